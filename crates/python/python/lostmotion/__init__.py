"""How far a real machine leaves the programmed contour, and what each way of compensating backlash
does about it.

>>> import lostmotion
>>> program = lostmotion.Program("G21 G90\\nG0 X25\\nG3 I-25 F2000\\nM2\\n")
>>> machine = lostmotion.Machine.preset("vmc3").edit({"axis.x.load.slide.gap_um": 25.0})
>>> run = lostmotion.simulate(program, machine, methods=["none", "fixed"])
>>> run.recommended
'fixed'

Lengths are in mm, errors in um, angles in deg (inside an axis rad), times in s, forces in N; every
name says its unit.
"""

from __future__ import annotations

import os
from typing import Any, Literal

from . import _native, compensators, errors, results, sweep
from ._native import (
    Imported,
    Machine,
    Plan,
    Progress,
    Table,
    Tick,
    __version__,
)
from .axis import Axis, Fit, fit, identify
from .errors import (
    Cancelled,
    DataError,
    Error,
    Finding,
    MachineError,
    MethodError,
    MissingPackage,
    OptionError,
    ProgramError,
)
from .program import Explanation, Operation, Program
from .run import Run, plan, simulate

__all__ = [
    "Axis",
    "Cancelled",
    "DataError",
    "Error",
    "Explanation",
    "Finding",
    "Fit",
    "Imported",
    "Machine",
    "MachineError",
    "MethodError",
    "MissingPackage",
    "Operation",
    "OptionError",
    "Plan",
    "Program",
    "ProgramError",
    "Progress",
    "Run",
    "Table",
    "Tick",
    "__version__",
    "compensators",
    "errors",
    "fit",
    "identify",
    "import_machine",
    "machine_keys",
    "methods",
    "plan",
    "presets",
    "results",
    "schema",
    "simulate",
    "sweep",
]


def presets() -> dict[str, str]:
    """The machines that come with the library, each with a line about it."""
    return dict(_native.presets())


def methods() -> dict[str, str]:
    """The registered compensation methods, each with a line about it."""
    return dict(_native.methods())


def machine_keys() -> dict[str, str]:
    """Every key of machine files, with what its value is; ``axis.x`` stands for any axis."""
    return dict(_native.machine_keys())


def schema(
    document: Literal["simulation", "comparison", "time", "check-log", "ballbar", "findings"],
) -> dict[str, Any]:
    """JSON Schema of a document that the command writes."""
    return _native.schema(document)


def import_machine(
    path: str | os.PathLike[str],
    *,
    format: str | None = None,
    preset: str | None = None,
    tip: str | None = None,
    max_bytes: int | None = None,
) -> Imported:
    """A machine from another program's description: LinuxCNC's INI, grbl's settings, Klipper,
    FluidNC, RepRapFirmware, Marlin, Sinumerik, Fanuc, TwinCAT, MTConnect, FreeCAD's machine (JSON),
    URDF.

    What the description does not say (drives, loads, gaps, jerk) is taken from ``preset``; if it is
    left out from vmc3, and axes that steppers move get a stepper's drive, open loop. ``tip``
    is the link of the tool, of a URDF tree that ends in several. Files that the description names
    are looked for beside it.
    """
    name = os.fspath(path)
    with open(name, "rb") as file:
        content = file.read()
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise MachineError(
            f"{name}: it is not UTF-8 text (byte {error.start})", code="utf-8", hint="save it as UTF-8"
        ) from None
    return _native.import_machine(text, name, format, preset, tip, max_bytes, os.path.dirname(name) or ".")
