"""Part programs: what can be said of one without moving anything."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from ._native import Machine
from ._native import Program as _Program
from ._settings import Path, Reading, machine_of, read_settings
from .errors import Finding

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Explanation", "Operation", "Program"]


class Operation(NamedTuple):
    """A canonical operation, and the block that it comes from."""

    line: int
    """Line, from 1; 0 for what holds before the first block."""
    column: int
    """Column in bytes, from 1; 0 for what holds before the first block."""
    file: int
    """0 for the program, n for the nth file of subroutines."""
    text: str
    """The operation: ``STRAIGHT_FEED(10.0000, ...)``."""


@dataclass(frozen=True)
class Explanation:
    """What a line does."""

    text: str
    """For people: its words, the modes and the position before and after, what it makes move."""
    data: Mapping[str, Any]
    """The same as data: the JSON form of ``lostmotion gcode explain``."""

    def __str__(self) -> str:
        return self.text


class Program:
    """A part program: a file, which is read where it stands, or a text. It can be pickled; a file
    is pickled as its path.

    >>> program = Program("G21 G90\\nG1 X40 F600\\nG1 Z-\\nM2\\n")
    >>> [found.line for found in program.diagnostics()]
    [3]
    """

    __slots__ = ("_native",)

    def __init__(self, text: str, name: str = "program") -> None:
        """A program from its text, with a name for messages."""
        self._native = _Program.from_text(text, name)

    @classmethod
    def from_file(cls, path: Path) -> Program:
        """A program in a file."""
        program = cls.__new__(cls)
        program._native = _Program.from_file(path)
        return program

    @property
    def name(self) -> str:
        """Its name in messages; the path of a file."""
        return self._native.name

    @property
    def text(self) -> str:
        """The whole text; bytes that are not UTF-8 become replacement characters."""
        return self._native.text

    def diagnostics(self, machine: Machine | Path | None = None, **reading: Unpack[Reading]) -> list[Finding]:
        """Everything that is wrong or doubtful when the program is read to its end."""
        return self._found(machine, None, reading)

    def lint(
        self,
        machine: Machine | Path | None = None,
        *,
        levels: Mapping[str, Literal["allow", "warn", "deny"]] | None = None,
        **reading: Unpack[Reading],
    ) -> list[Finding]:
        """The same with what is allowed and may still break a tool, a part or a machine.

        ``levels`` changes what is reported, by the code of the lint; ``all`` stands for every one.
        """
        return self._found(machine, list((levels or {}).items()), reading)

    def _found(
        self,
        machine: Machine | Path | None,
        lints: list[tuple[str, Any]] | None,
        reading: Mapping[str, Any],
    ) -> list[Finding]:
        on = None if machine is None else machine_of(machine)
        found = self._native._findings(on, lints, read_settings(reading))
        return [Finding(**one) for one in found]

    def operations(
        self, machine: Machine | Path | None = None, **reading: Unpack[Reading]
    ) -> Iterator[Operation]:
        """Its canonical operations, made as they are asked for.

        Raises `ProgramError` at the end if there was something wrong on the way.
        """
        on = None if machine is None else machine_of(machine)
        return map(Operation._make, self._native._operations(on, read_settings(reading)))

    def explain(
        self, line: int, machine: Machine | Path | None = None, **reading: Unpack[Reading]
    ) -> Explanation:
        """What a line does, with the modes and the position before and after."""
        on = None if machine is None else machine_of(machine)
        text, data = self._native._explain(line, on, read_settings(reading))
        return Explanation(text, data)

    def format(
        self,
        *,
        case: Literal["upper", "lower", "keep"] = "upper",
        indent: int = 2,
        line_numbers: Literal["keep", "remove"] | int = "keep",
    ) -> str:
        """The program in one style, without a change of what it does.

        ``indent`` is the number of blanks for each level of O-words; ``line_numbers`` may be the
        step of new numbers.
        """
        return self._native.format(case=case, indent=indent, line_numbers=str(line_numbers))

    def resolved(
        self,
        machine: Machine | Path | None = None,
        *,
        system: int = 1,
        **reading: Unpack[Reading],
    ) -> str:
        """The program with everything computed: no parameters, loops, calls, cycles, offsets.

        ``system`` is the work coordinate system of the coordinates, 1 for G54 to 9 for G59.3.
        """
        on = None if machine is None else machine_of(machine)
        return self._native._resolved(on, system, read_settings(reading))

    def __repr__(self) -> str:
        return repr(self._native)


def program_of(part: Program | Path) -> Program:
    """A program from itself or from the path of its file."""
    return part if isinstance(part, Program) else Program.from_file(part)
