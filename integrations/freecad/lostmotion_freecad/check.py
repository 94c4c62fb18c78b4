"""A job on a machine: the contour error of each of its blocks.

Nothing here needs FreeCAD.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .errors import JobError, lostmotion
from .machine import Taken
from .program import JobProgram, Point

__all__ = ["Block", "Result", "check"]

COLUMNS = (
    "Operation",
    "Command",
    "G-code",
    "Line",
    "Error um",
    "Backlash um",
    "Servo um",
    "Path um",
    "Cause",
    "Time s",
    "X mm",
    "Y mm",
    "Z mm",
)
"""Headings of the table."""


@dataclass(frozen=True)
class Block:
    """A block that cuts, and its largest contour error."""

    line: int
    """Line of the program, from 1."""
    operation: str
    """Label of its operation."""
    command: int
    """Place of its command in the path of the operation, from 0."""
    text: str
    """Its G-code."""
    error_um: float
    """Contour error, um: positive to the left of the direction of travel."""
    backlash_um: float
    """What backlash adds to it."""
    servo_um: float
    """What the machine without a gap adds to it."""
    command_um: float
    """How far the commanded path itself is off the programmed one, by rounding corners above all."""
    cause: str
    """What is behind it."""
    time_s: float
    """When, s."""
    at_mm: Point
    """Where, mm."""

    @property
    def cells(self) -> tuple[str | int | float, ...]:
        """Its row of the table, under `COLUMNS`."""
        return (
            self.operation,
            self.command,
            self.text,
            self.line,
            *(round(value, 2) for value in (self.error_um, self.backlash_um, self.servo_um, self.command_um)),
            self.cause,
            round(self.time_s, 3),
            *(round(value, 3) for value in self.at_mm),
        )


@dataclass(frozen=True)
class Result:
    """What came of a job."""

    job: str
    machine: str
    source: str
    """Name of the preset, or path of the file that the machine is from."""
    method: str
    tolerance_um: float
    duration_s: float
    """Length of the motion, s."""
    max_um: float
    """Largest contour error of the cutting moves, um."""
    stopped: str
    """Why the control stops the machine; empty where it does not."""
    blocks: list[Block] = field(default_factory=list)
    """All blocks that cut, in the order of the program."""
    remarks: list[str] = field(default_factory=list)
    """What the user should know."""

    @property
    def outside(self) -> list[Block]:
        """Those out of tolerance, the worst first."""
        out = [block for block in self.blocks if abs(block.error_um) > self.tolerance_um]
        return sorted(out, key=lambda block: (-abs(block.error_um), block.line))

    @property
    def summary(self) -> str:
        """The answer in a sentence or two."""
        outside = len(self.outside)
        answer = (
            f"{outside} of {len(self.blocks)} blocks are out of tolerance"
            if outside
            else f"All {len(self.blocks)} blocks are within tolerance"
        )
        text = (
            f"{answer}: {self.max_um:.1f} um at most, {self.tolerance_um:g} um allowed, on {self.machine} "
            f"with method {self.method}, in {self.duration_s:.1f} s."
        )
        return f"{text} The control stops: {self.stopped}" if self.stopped else text


def check(
    program: JobProgram,
    taken: Taken,
    method: str = "",
    tolerance_um: float | None = None,
    on_progress: Callable[[float], object] | None = None,
) -> Result:
    """Simulates a job on a machine, with one compensation method.

    ``method`` and ``tolerance_um`` are those of the machine if left out; ``on_progress`` is called with
    the share of the program that is done, and ends the run by ``False``.

    Raises `JobError`: the operation and command that it is about, and what to do.
    """
    package = lostmotion()
    if tolerance_um is not None and not tolerance_um > 0.0:
        raise JobError(f"The tolerance is {tolerance_um} um; it has to be above 0.")
    told = None
    if on_progress is not None:
        listener = on_progress

        def told(progress: Any) -> bool:
            return listener(progress.share) is not False

    try:
        run = package.simulate(
            package.Program(program.text, program.name),
            taken.machine,
            method=method or None,
            tolerance_um=tolerance_um,
            tool_table=program.tool_table or None,
            on_progress=told,
        )
    except package.Cancelled as error:
        raise JobError("The run was ended.") from error
    except package.Error as error:
        raise JobError(placed(error, program), error.hint) from error
    return result_of(run, program, taken)


def placed(error: Any, program: JobProgram) -> str:
    """An error with the operations that it is about in place of lines."""
    found = [one for one in error.findings if one.line and one.severity == "error"]
    if not found:
        return str(error.message)
    shown = [f"{program.place(one.line)}: {one.message}" for one in found[:5]]
    more = len(found) - len(shown)
    return "\n".join(shown) + (f"\nand {more} more" if more else "")


def result_of(run: Any, program: JobProgram, taken: Taken) -> Result:
    """The figures of a run, block by block."""
    figures = run.data.results[0]
    table = {name: run.blocks[name].tolist() for name in BLOCK_COLUMNS}
    # A line may make several moves, such as a cycle of drilling: the worst of them counts.
    worst: dict[int, int] = {}
    for row, (line, rapid, error) in enumerate(
        zip(table["line"], table["rapid"], table["max_um"], strict=True)
    ):
        if rapid or program.origin(line) is None:
            continue
        if line not in worst or abs(error) > abs(table["max_um"][worst[line]]):
            worst[line] = row
    blocks = []
    for line, row in sorted(worst.items()):
        origin = program.origin(line)
        if origin is None:
            continue
        blocks.append(
            Block(
                line=line,
                operation=origin.operation,
                command=origin.command,
                text=program.lines[line - 1],
                error_um=table["max_um"][row],
                backlash_um=table["backlash_um"][row],
                servo_um=table["servo_um"][row],
                command_um=table["command_um"][row],
                cause=str(table["cause"][row]),
                time_s=table["time_s"][row],
                at_mm=(table["x_mm"][row], table["y_mm"][row], table["z_mm"][row]),
            )
        )
    stop = figures.stop
    return Result(
        job=program.name,
        machine=str(run.data.machine),
        source=taken.source,
        method=str(figures.method),
        tolerance_um=float(run.data.tolerance_um),
        duration_s=float(run.plan.duration_s),
        max_um=float(figures.cutting.max),
        stopped="" if stop is None else f"{stop.axis}, {stop.limit} after {stop.time_s:.3f} s. {stop.reason}",
        blocks=blocks,
        remarks=[*program.remarks, *taken.remarks, *run.program.warnings],
    )


BLOCK_COLUMNS = (
    "line",
    "rapid",
    "time_s",
    "max_um",
    "command_um",
    "servo_um",
    "backlash_um",
    "cause",
    "x_mm",
    "y_mm",
    "z_mm",
)
"""What is used of the table of blocks."""
