"""Contour errors of a CAM job in FreeCAD.

From a macro or the Python console, with or without a window::

    from lostmotion_freecad import check_job
    result = check_job(job, machine="vmc3", method="fixed", tolerance_um=20.0)

The add-on needs the Python package ``lostmotion`` in FreeCAD's Python.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .check import Block, Result, check
from .errors import JobError
from .machine import machine_of
from .program import JobProgram, program_of

__all__ = ["Block", "JobError", "JobProgram", "Result", "check", "check_job", "machine_of", "program_of"]


def check_job(
    job: Any,
    machine: str = "",
    *,
    method: str = "",
    tolerance_um: float | None = None,
    preamble: str = "",
    on_progress: Callable[[float], object] | None = None,
) -> Result:
    """Simulates a CAM job and puts the result into its document: the path with its edges coloured by
    contour error, and a spreadsheet of the blocks out of tolerance.

    ``machine`` is the name of a preset or the path of a machine file (``.toml``), a FreeCAD machine
    (``.fcm``) or a LinuxCNC configuration (``.ini``); empty for the machine of the job. ``method`` is a
    compensation method; ``method`` and ``tolerance_um`` (um) are those of the machine if left out.
    ``preamble`` is a line of G-code before the first operation, such as ``G64 P0.01``. ``on_progress``
    is called with the share of the program that is done, 0 to 1; ``False`` ends the run.

    Raises `JobError`, which says what to do.
    """
    from . import document

    program = program_of(job, preamble)
    taken = machine_of(machine or document.machine_of_job(job))
    result = check(program, taken, method, tolerance_um, on_progress)
    document.show(job, program, result)
    return result
