"""A CAM job as G-code: a line for each command, and for each line the operation that it is of.

Nothing here needs FreeCAD: a job is whatever has its properties.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from .errors import JobError

__all__ = ["JobProgram", "Move", "Origin", "program_of"]

Point = tuple[float, float, float]

HEADER = "G17 G21 G40 G49 G80 G90 G94"
"""What postprocessors put at the start: XY plane, mm, no offsets, no cycle, absolute, feed per minute."""

WORDS = "XYZABCUVWIJKRQPLFSTHDE"
"""Words in the order in which they are written."""

FEED_MOVES = {"G1", "G2", "G3"}
CYCLES = {"G73", "G74", "G81", "G82", "G83", "G84", "G85", "G86", "G87", "G88", "G89"}
CENTRES = {"G17": "IJ", "G18": "IK", "G19": "JK"}
"""Words of an arc's centre in each plane. FreeCAD writes all three."""

NORMALS: dict[str, Point] = {"G17": (0.0, 0.0, 1.0), "G18": (0.0, 1.0, 0.0), "G19": (1.0, 0.0, 0.0)}
ACTIVE_PLANES = {"G17": (0, 1), "G18": (2, 0), "G19": (1, 2)}


@dataclass(frozen=True)
class Origin:
    """Where a line of the program is from."""

    operation: str
    """Label of the operation, or of the tool controller."""
    command: int
    """Place of the command in its path, from 0."""


@dataclass(frozen=True)
class Move:
    """Motion of a line, for drawing; places in mm."""

    line: int
    start: Point
    end: Point
    centre: Point | None = None
    """Of an arc; a straight line has none."""
    normal: Point = (0.0, 0.0, 1.0)
    """Axis of an arc, about which it goes anticlockwise."""


@dataclass
class JobProgram:
    """A job as G-code."""

    name: str
    lines: list[str] = field(default_factory=list)
    origins: list[Origin | None] = field(default_factory=list)
    """For each line; ``None`` for what the add-on has put in."""
    moves: list[Move] = field(default_factory=list)
    """Feed moves in the order of the program."""
    tools: dict[int, tuple[float, str]] = field(default_factory=dict)
    """Diameter in mm and name of each tool by its number."""
    remarks: list[str] = field(default_factory=list)
    """What the user should know of it."""

    @property
    def text(self) -> str:
        """The G-code."""
        return "".join(f"{line}\n" for line in self.lines)

    @property
    def tool_table(self) -> str:
        """The tools in LinuxCNC's format."""
        return "".join(
            f"T{number} P{number} D{number_text(diameter)} ; {name}\n"
            for number, (diameter, name) in sorted(self.tools.items())
        )

    def origin(self, line: int) -> Origin | None:
        """Where a line is from; lines count from 1."""
        return self.origins[line - 1] if 0 < line <= len(self.origins) else None

    def place(self, line: int) -> str:
        """A line for people: its operation, command and text."""
        origin = self.origin(line)
        text = self.lines[line - 1] if 0 < line <= len(self.lines) else ""
        if origin is None:
            return f"line {line}, {text}"
        return f"{origin.operation}, command {origin.command}, {text}"

    def _put(self, line: str, origin: Origin | None = None) -> int:
        self.lines.append(line)
        self.origins.append(origin)
        return len(self.lines)


def number_text(value: float) -> str:
    """A number with at most six decimals, which are nanometres."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def code_of(name: str) -> str:
    """A command's name without leading zeros: ``G01`` is ``G1``."""
    found = re.fullmatch(r"([GM])0*(\d+(?:\.\d+)?)", name.strip().upper())
    return f"{found[1]}{found[2]}" if found else name.strip()


@dataclass
class _State:
    """What the commands so far have set."""

    position: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    plane: str = "G17"
    feed: float = 0.0
    relative: bool = False
    retract_to_r: bool = False
    hole: dict[str, float] = field(default_factory=dict)
    """Z and R of the cycle in force."""


def program_of(job: Any, preamble: str = "") -> JobProgram:
    """The G-code of a job: its active operations in their order, each with its tool.

    ``preamble`` is put before the first operation.

    Raises `JobError` for what is no job, a job without moves, and moves without a feed.
    """
    if job is None or not hasattr(job, "Operations") or not hasattr(job, "Tools"):
        raise JobError(
            "There is no CAM job here.",
            "Select a job in the tree, or make one: workbench CAM (Path before FreeCAD 1.0), New Job.",
        )
    label = str(job.Label)
    group = list(getattr(job.Operations, "Group", None) or [])
    active = [operation for operation in group if property_of(operation, "Active") is not False]
    if not active:
        raise JobError(
            f"The job {label} has no {'active ' if group else ''}operation.",
            "Activate an operation." if group else "Add one, such as a profile or a pocket.",
        )
    program = JobProgram(name=label)
    program._put(HEADER)
    fixtures = list(getattr(job, "Fixtures", None) or ["G54"])
    program._put(str(fixtures[0]))
    if len(fixtures) > 1:
        program.remarks.append(
            f"The job is cut at {', '.join(map(str, fixtures))}; it is simulated once, at {fixtures[0]}."
        )
    if preamble.strip():
        program._put(" ".join(preamble.split()))
    state = _State()
    tool = None
    for operation in active:
        controller = property_of(operation, "ToolController")
        if controller is not None and controller is not tool:
            tool = controller
            program.tools[int(controller.ToolNumber)] = tool_of(controller)
            write(program, state, str(controller.Label), controller, controller)
        write(program, state, str(operation.Label), operation, tool)
    program._put("M2")
    if not program.moves:
        raise JobError(
            f"The job {label} has no feed move.",
            "Recompute the document, and look at the operations: each needs a path.",
        )
    skipped = len(group) - len(active)
    if skipped:
        program.remarks.append(f"{skipped} operation(s) are not active and were left out.")
    return program


def property_of(operation: Any, name: str) -> Any:
    """A property of an operation, or of the one that a dressup is put on."""
    seen = 0
    while operation is not None and not isinstance(operation, (list, tuple)) and seen < 100:
        if hasattr(operation, name):
            return getattr(operation, name)
        operation = getattr(operation, "Base", None)
        seen += 1
    return None


def tool_of(controller: Any) -> tuple[float, str]:
    """Diameter in mm and name of a controller's tool; 0 where there is no diameter."""
    tool = getattr(controller, "Tool", None)
    diameter = getattr(tool, "Diameter", 0.0)
    name = str(getattr(tool, "Label", getattr(tool, "Name", "")))
    return float(getattr(diameter, "Value", diameter)), re.sub(r"[^ -~]|;", " ", name).strip()


def write(program: JobProgram, state: _State, label: str, operation: Any, tool: Any) -> None:
    """Writes the commands of an operation or a tool controller."""
    path = getattr(operation, "Path", None)
    for place, command in enumerate(path.Commands if path is not None else ()):
        name = code_of(command.Name)
        # Comments change nothing; some controls act on theirs, so none is handed on.
        if not name or name[0] in "(;%":
            continue
        parameters = {str(key).upper(): float(value) for key, value in dict(command.Parameters).items()}
        moving = name in FEED_MOVES or name in CYCLES
        if moving:
            state.feed = parameters.get("F", 0.0) or state.feed
            if not state.feed > 0.0:
                raise JobError(
                    f"{label}, command {place} ({name}) has no feed.",
                    "Set the horizontal and the vertical feed of the tool controller "
                    f"{getattr(tool, 'Label', '')}.",
                )
        words = " ".join([name, *words_of(name, parameters, state)])
        line = program._put(words, Origin(label, place))
        program.moves.extend(follow(state, name, parameters, line))


def words_of(name: str, parameters: Mapping[str, float], state: _State) -> Iterator[str]:
    """The words of a command as a control reads them."""
    left = set("IJK") - set(CENTRES[state.plane]) if name in {"G2", "G3"} else set()
    for letter in WORDS:
        if letter not in parameters or letter in left:
            continue
        value = parameters[letter]
        if letter == "F":
            # FreeCAD has mm/s, G94 mm/min. Rapids have a speed of their own, and 0 says that none is set.
            if name == "G0" or value <= 0.0:
                continue
            value *= 60.0
        yield f"{letter}{number_text(value)}"


def follow(state: _State, name: str, parameters: Mapping[str, float], line: int) -> Iterator[Move]:
    """Moves the state on, and gives the feed moves of a command."""
    if name in CENTRES:
        state.plane = name
    elif name in {"G90", "G91"}:
        state.relative = name == "G91"
    elif name in {"G98", "G99"}:
        state.retract_to_r = name == "G99"
    elif name == "G80":
        state.hole = {}
    start: Point = (state.position[0], state.position[1], state.position[2])
    if name in CYCLES:
        yield from drill(state, parameters, line)
    elif name == "G0" or name in FEED_MOVES:
        for place, letter in enumerate("XYZ"):
            if letter in parameters:
                base = state.position[place] if state.relative else 0.0
                state.position[place] = base + parameters[letter]
        end: Point = (state.position[0], state.position[1], state.position[2])
        if name in {"G2", "G3"}:
            sign = 1.0 if name == "G3" else -1.0
            x, y, z = NORMALS[state.plane]
            offset = [
                parameters.get(letter, 0.0) if letter in CENTRES[state.plane] else 0.0 for letter in "IJK"
            ]
            centre: Point = (start[0] + offset[0], start[1] + offset[1], start[2] + offset[2])
            yield Move(line, start, end, centre, (sign * x, sign * y, sign * z))
        elif name == "G1" and start != end:
            yield Move(line, start, end)


def drill(state: _State, parameters: Mapping[str, float], line: int) -> Iterator[Move]:
    """A hole, from the plane of the retract to its bottom."""
    for letter in "ZR":
        if letter in parameters:
            state.hole[letter] = parameters[letter]
    for place, letter in enumerate("XY"):
        if letter in parameters:
            base = state.position[place] if state.relative else 0.0
            state.position[place] = base + parameters[letter]
    x, y, z = state.position
    top = state.hole.get("R", z)
    bottom = state.hole.get("Z", top)
    if state.relative:
        top += z
        bottom += top
    if not math.isclose(top, bottom):
        yield Move(line, (x, y, top), (x, y, bottom))
    state.position[2] = top if state.retract_to_r else max(z, top)
