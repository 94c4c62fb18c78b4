#!/usr/bin/env python3
"""Simulates a part program on the machine of a LinuxCNC configuration, and says which blocks are out of
tolerance. As a filter it checks each program that is opened.

    lostmotion_check.py part.ngc --ini my-mill.ini

checks a program and prints what was found; the exit code is 0 within tolerance, 1 out of it, 2 where there
is no result. With ``--filter`` it is a filter program of LinuxCNC's user interfaces:

    [FILTER]
    PROGRAM_EXTENSION = .ngc,.nc,.tap Checked G-code
    ngc = /path/to/lostmotion_check.py --filter
    nc = /path/to/lostmotion_check.py --filter
    tap = /path/to/lostmotion_check.py --filter

    [LOSTMOTION]
    TOLERANCE_UM = 20
    METHOD = fixed
    MACHINE = my-mill.toml
    ON_VIOLATION = warn

Every key of ``[LOSTMOTION]`` may be left out; options go before keys. A program out of tolerance is loaded
with a notice (``warn``), or is not loaded (``stop``). It is handed on as it is, byte by byte.

It needs the Python package ``lostmotion``, and nothing of a running LinuxCNC but the path of its INI file.
"""

from __future__ import annotations

import argparse
import importlib
import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

NEEDED = (0, 1)
"""The first release of the Python package that has all that is used here."""

SECTION = "LOSTMOTION"
KEYS = ("MACHINE", "METHOD", "TOLERANCE_UM", "ON_VIOLATION")
ON_VIOLATION = ("warn", "stop")

LISTED = 10
"""Blocks that are listed, the worst first."""

WITHIN, OUTSIDE, NO_RESULT = 0, 1, 2
"""Exit codes."""


class CheckError(Exception):
    """Why there is no result; the second line says what to do."""


@dataclass(frozen=True)
class Settings:
    """What is checked, and against what."""

    program: str
    ini: str
    """Path of the INI file; empty where there is none."""
    ini_from: str
    """Who has named it."""
    machine: str
    """Path of a machine file or name of a preset; empty for the machine of the INI file."""
    method: str
    tolerance_um: float | None
    on_violation: str
    is_filter: bool


def parser() -> argparse.ArgumentParser:
    """The options."""
    options = argparse.ArgumentParser(
        prog="lostmotion_check.py",
        description="Simulates a part program on the machine of a LinuxCNC configuration.",
        epilog="Keys MACHINE, METHOD, TOLERANCE_UM and ON_VIOLATION of [LOSTMOTION] in the INI file "
        "are used where an option is left out.",
    )
    options.add_argument("program", help="part program")
    options.add_argument(
        "--ini", help="LinuxCNC's INI file; that of the running LinuxCNC (INI_FILE_NAME) if left out"
    )
    options.add_argument(
        "--machine", help="machine file (.toml) or preset in place of the INI file's machine"
    )
    options.add_argument("--method", help="compensation method; that of the machine if left out")
    options.add_argument("--tolerance", type=float, metavar="UM", help="tolerance of the contour error, um")
    options.add_argument(
        "--on-violation",
        choices=ON_VIOLATION,
        help="load a program out of tolerance, or do not; warn if left out",
    )
    options.add_argument("--filter", action="store_true", help="print the program, and progress for LinuxCNC")
    return options


def section_of(text: str, path: str) -> dict[str, str]:
    """The keys of ``[LOSTMOTION]`` in the text of an INI file. The last one of a name counts.

    Raises `CheckError` for a key that there is not.
    """
    found: dict[str, str] = {}
    inside = False
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line[0] in "#;":
            continue
        if line[0] == "[":
            inside = line[1:].split("]")[0].strip().upper() == SECTION
        elif inside:
            key, equals, value = line.partition("=")
            key = key.strip().upper()
            if key not in KEYS or not equals:
                raise CheckError(
                    f"{path}, line {number}: [{SECTION}] has no key {key}.\nIts keys are {', '.join(KEYS)}."
                )
            found[key] = value.strip()
    return found


def settings_of(arguments: Sequence[str], environment: Mapping[str, str]) -> Settings:
    """What is asked for, by options, by the INI file, by the environment.

    Raises `CheckError`.
    """
    given = parser().parse_args(arguments)
    running = environment.get("INI_FILE_NAME", "")
    ini = given.ini or running
    ini_from = "--ini" if given.ini else "INI_FILE_NAME, the running LinuxCNC's" if running else ""
    keys: dict[str, str] = {}
    if ini:
        try:
            with open(ini, encoding="utf-8", errors="replace") as file:
                keys = section_of(file.read(), ini)
        except OSError as error:
            raise CheckError(
                f"The INI file {ini} ({ini_from}) cannot be read: {error.strerror or error}.\n"
                "Name the one that LinuxCNC is started with: --ini my-mill.ini."
            ) from error
    elif not given.machine:
        raise CheckError(
            "There is no INI file: LinuxCNC is not running (INI_FILE_NAME is not set).\n"
            "Name it, --ini my-mill.ini, or a machine, --machine my-mill.toml."
        )
    tolerance_um = given.tolerance
    if tolerance_um is None and keys.get("TOLERANCE_UM"):
        tolerance_um = number_of(keys["TOLERANCE_UM"], f"[{SECTION}]TOLERANCE_UM")
    if tolerance_um is not None and not 0.0 < tolerance_um < float("inf"):
        raise CheckError(f"The tolerance is {tolerance_um} um.\nIt has to be above 0.")
    on_violation = given.on_violation or keys.get("ON_VIOLATION", "").lower() or "warn"
    if on_violation not in ON_VIOLATION:
        raise CheckError(
            f"[{SECTION}]ON_VIOLATION is {on_violation}.\nIt is one of {', '.join(ON_VIOLATION)}."
        )
    machine = given.machine or keys.get("MACHINE", "")
    if machine and not given.machine and machine.endswith(".toml"):
        # Files that an INI names are beside it.
        machine = os.path.join(os.path.dirname(ini), os.path.expanduser(machine))
    return Settings(
        program=given.program,
        ini=ini,
        ini_from=ini_from,
        machine=machine,
        method=given.method or keys.get("METHOD", ""),
        tolerance_um=tolerance_um,
        on_violation=on_violation,
        is_filter=given.filter,
    )


def number_of(text: str, key: str) -> float:
    """A number. Raises `CheckError`."""
    try:
        return float(text)
    except ValueError as error:
        raise CheckError(f"{key} is {text}.\nIt has to be a number.") from error


def package() -> Any:
    """The Python package. Raises `CheckError` where it is missing or too old."""
    python = sys.executable or "python3"
    hint = f"Build its wheel in a clone of lostmotion, `pip wheel --no-deps .`, and install it: `{python} -m pip install lostmotion*.whl`."
    try:
        import lostmotion
    except ImportError as error:
        raise CheckError(f"The Python package lostmotion cannot be loaded: {error}.\n{hint}") from error
    version = str(getattr(lostmotion, "__version__", "0"))
    numbers = tuple(int("".join(filter(str.isdigit, part)) or 0) for part in version.split(".")[:2])
    if numbers < NEEDED or not hasattr(lostmotion, "simulate"):
        needed = ".".join(map(str, NEEDED))
        raise CheckError(f"The Python package lostmotion is {version}; {needed} or newer is needed.\n{hint}")
    return lostmotion


def machine_of(lostmotion: Any, settings: Settings) -> tuple[Any, str]:
    """The machine, and a sentence about where it is from."""
    if settings.machine.endswith(".toml"):
        return lostmotion.Machine.from_file(settings.machine), f"machine of {settings.machine}"
    if settings.machine:
        return lostmotion.Machine.preset(settings.machine), f"preset {settings.machine}"
    imported = lostmotion.import_machine(settings.ini, format="linuxcnc")
    filled = sum(fate == "filled in" for _, _, fate, _ in imported.rows)
    told = f"machine of {settings.ini} ({settings.ini_from})"
    if filled:
        told += (
            f"; {filled} values that it does not say, gaps and drives among them, are filled in: "
            f"`lostmotion machine import` writes a machine file to correct, and [{SECTION}]MACHINE names it"
        )
    return imported.machine, told


class Progress:
    """Tells LinuxCNC how far the run is, whenever it is another per cent."""

    def __init__(self) -> None:
        self.told = -1

    def __call__(self, progress: Any) -> None:
        percent = min(99, int(100.0 * progress.share))
        if percent > self.told:
            self.told = percent
            print(f"FILTER_PROGRESS={percent}", file=sys.stderr, flush=True)


def simulate(settings: Settings) -> tuple[bool, str]:
    """Whether the program is within tolerance, and the report. Raises `CheckError`."""
    lostmotion = package()
    try:
        machine, told = machine_of(lostmotion, settings)
        run = lostmotion.simulate(
            settings.program,
            machine,
            method=settings.method or None,
            tolerance_um=settings.tolerance_um,
            keep_blocks=LISTED,
            subroutines=subroutines_of(settings.ini),
            on_progress=Progress() if settings.is_filter else None,
        )
    except OSError as error:
        raise CheckError(f"{error}.\nIs the path right?") from error
    except lostmotion.Error as error:
        found = [f"  {one.file}:{one.line}: {one.message}" for one in error.findings if one.line]
        lines = [error.message, *found[:LISTED]]
        raise CheckError("\n".join([*lines, error.hint] if error.hint else lines)) from error
    return bool(run.within_tolerance), report(run, told)


def subroutines_of(ini: str) -> list[str]:
    """Folders of subroutines that the INI file names: ``[RS274NGC]SUBROUTINE_PATH`` and
    ``[DISPLAY]PROGRAM_PREFIX``."""
    if not ini:
        return []
    folders: list[str] = []
    section = ""
    with open(ini, encoding="utf-8", errors="replace") as file:
        for line in map(str.strip, file):
            if line.startswith("["):
                section = line[1:].split("]")[0].strip().upper()
                continue
            key, equals, value = line.partition("=")
            name = (section, key.strip().upper())
            if equals and name in {("RS274NGC", "SUBROUTINE_PATH"), ("DISPLAY", "PROGRAM_PREFIX")}:
                folders.extend(filter(None, map(str.strip, value.split(":"))))
    base = os.path.dirname(ini)
    paths = [os.path.join(base, os.path.expanduser(folder)) for folder in folders]
    return [path for path in dict.fromkeys(paths) if os.path.isdir(path)]


def report(run: Any, told: str) -> str:
    """The answer for people."""
    result = run.results[0]
    tolerance_um = run.data.tolerance_um
    verdict = "within" if run.within_tolerance else "OUT OF"
    answer = (
        f"lostmotion: {verdict} tolerance: {result.cutting.max:.1f} um at most, {tolerance_um:g} um allowed "
        f"(method {result.method}, {run.plan.duration_s:.1f} s)"
    )
    lines = [answer, told]
    if result.stop is not None:
        lines.append(
            f"the control stops: axis {result.stop.axis}, {result.stop.limit}, after {result.stop.time_s:.3f} s"
        )
    for block in result.worst_blocks:
        if not block.rapid and abs(block.max_um) > tolerance_um:
            lines.append(
                f"  line {block.block.span.line}: {block.max_um:+.1f} um, {block.cause}: {block.text}"
            )
    return "\n".join(lines)


def notify(text: str) -> bool:
    """Shows a text in the running user interface, where there is one."""
    if not os.environ.get("INI_FILE_NAME"):
        return False  # its messages go nowhere, without an error
    try:
        linuxcnc = importlib.import_module("linuxcnc")
    except ImportError:
        return False
    try:
        linuxcnc.command().display_msg(text)
    except linuxcnc.error:  # it is not running
        return False
    return True


def hand_on(program: str) -> None:
    """Prints the program, byte by byte. Raises `CheckError`."""
    try:
        with open(program, "rb") as file:
            shutil.copyfileobj(file, sys.stdout.buffer)
        sys.stdout.buffer.flush()
    except OSError as error:
        raise CheckError(f"{error}.\nIs the path right?") from error
    print("FILTER_PROGRESS=100", file=sys.stderr, flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Answers the exit code."""
    try:
        settings = settings_of(sys.argv[1:] if arguments is None else arguments, os.environ)
        try:
            within, told = simulate(settings)
        except CheckError as error:
            # A program that cannot be judged is loaded with a notice, too, but never without one.
            notice = f"lostmotion: not checked. {error}"
            if not settings.is_filter or settings.on_violation == "stop" or not notify(notice):
                raise
            print(notice, file=sys.stderr)
            hand_on(settings.program)
            return WITHIN
        if not settings.is_filter:
            print(told)
            return WITHIN if within else OUTSIDE
        print(told, file=sys.stderr, flush=True)
        if not within and settings.on_violation == "stop":
            print(f"The program is not loaded: [{SECTION}]ON_VIOLATION is stop.", file=sys.stderr)
            return OUTSIDE
        if not within:
            notify(told.splitlines()[0])
        hand_on(settings.program)
        return WITHIN
    except CheckError as error:
        print(f"lostmotion: {error}", file=sys.stderr)
        return NO_RESULT
    except KeyboardInterrupt:
        print("lostmotion: ended", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
