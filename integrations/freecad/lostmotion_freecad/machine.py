"""Machines: presets, machine files, and what FreeCAD and LinuxCNC know of one.

Nothing here needs FreeCAD.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from .errors import JobError, lostmotion

__all__ = ["Taken", "find_machine", "machine_of"]

PRESET = "vmc3"
"""The machine where none is named."""


@dataclass(frozen=True)
class Taken:
    """A machine, and where it is from."""

    machine: Any
    """A `lostmotion.Machine`."""
    source: str
    """Name of the preset, or path of the file."""
    remarks: list[str] = field(default_factory=list)
    """What the user should know of it."""
    toml: str = ""
    """Text of a machine file, where the machine was imported."""


def machine_of(source: str) -> Taken:
    """The machine of a name or path: a preset, a machine file (``.toml``), or a file that is imported
    (FreeCAD's ``.fcm``, LinuxCNC's ``.ini`` and others). The usual preset for an empty text.

    Raises `JobError` for what is none of these, or does not hold.
    """
    package = lostmotion()
    source = source.strip() or PRESET
    _, extension = os.path.splitext(source)
    try:
        if not extension and not os.path.exists(source):
            return Taken(package.Machine.preset(source), source)
        if extension.lower() == ".toml":
            return Taken(package.Machine.from_file(source), source)
        imported = package.import_machine(source)
    except (OSError, UnicodeDecodeError) as error:
        raise JobError(f"The machine {source} cannot be read: {error}.", "Choose another file.") from error
    except package.Error as error:
        raise JobError(f"The machine {source} does not hold: {told(error)}", error.hint) from error
    return Taken(imported.machine, source, remarks_of(imported.rows, source), imported.toml)


def told(error: Any) -> str:
    """An error of the package with the places of all that was found."""
    places = [f"line {found.line}: {found.message} ({found.hint})" for found in error.findings if found.line]
    return "; ".join(places) or str(error.message)


def remarks_of(rows: Iterable[tuple[str, str, str, str]], source: str) -> list[str]:
    """What an import has filled in and left aside, in two sentences."""
    fates: dict[str, list[str]] = {}
    for key, _, fate, _ in rows:
        fates.setdefault(fate, []).append(key)
    name = os.path.basename(source)
    remarks = []
    filled = fates.get("filled in", [])
    if filled:
        remarks.append(
            f"{name} does not say {len(filled)} values, such as {', '.join(filled[:3])}: they were filled "
            "in. Save the machine as a file, and put in what was measured on yours, the gaps above all."
        )
    ignored = fates.get("ignored", [])
    if ignored:
        remarks.append(f"Not used of {name}: {', '.join(ignored[:6])}{', ...' if len(ignored) > 6 else ''}.")
    return remarks


def find_machine(name: str, folders: Iterable[str]) -> str | None:
    """The file of the FreeCAD machine of this name in the folders, or below them: by the name in the
    file, or that of the file, in upper or lower case."""
    wanted = name.strip().lower()
    for folder in folders:
        for place, _, files in sorted(os.walk(folder)):
            for file in sorted(files):
                stem, extension = os.path.splitext(file)
                if extension.lower() != ".fcm":
                    continue
                path = os.path.join(place, file)
                if wanted in {stem.lower(), stem.replace("_", " ").lower(), name_in(path)}:
                    return path
    return None


def name_in(path: str) -> str:
    """The name that a machine has in its file; empty where it cannot be read."""
    try:
        with open(path, encoding="utf-8") as file:
            return str(json.load(file)["machine"]["name"]).strip().lower()
    except (OSError, ValueError, KeyError, TypeError):
        return ""
