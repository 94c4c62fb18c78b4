"""Keywords that several functions share, and values as the extension module takes them."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from ._native import Machine, Progress
from .errors import DataError, OptionError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Path = str | os.PathLike[str]
OnProgress = Callable[[Progress], object]
Dialect = Literal["linuxcnc", "fanuc", "haas", "marlin", "klipper", "siemens"]


class Reading(TypedDict, total=False):
    """How a program is read; what is left out is as the machine or the dialect has it."""

    dialect: Dialect
    """Dialect of the program."""
    accept: Sequence[str]
    """Codes of warnings: what the dialect refuses and is to be accepted with that warning."""
    refuse: Sequence[str]
    """Codes of warnings: what the dialect accepts with that warning and is to be refused."""
    m_codes: Mapping[str, str]
    """What M codes of the machine's builder do: ``{"M100": "ignore", "M10": "dwell:1.5"}``."""
    block_skips: Sequence[int]
    """Which of ``/1`` to ``/9`` are skipped, ``/`` being 1."""
    told: Mapping[str, float]
    """Values that only the machine knows, by number or name of the parameter: ``{"3011": 1.0}``."""
    subroutines: Sequence[Path]
    """Folders with files of subroutines, besides the program's own."""
    limits: Mapping[str, float]
    """Limits of the interpreter: ``{"looped_blocks": 1e6}``."""
    tool_table: str
    """Text of a tool table in LinuxCNC's format, in place of the machine's tools."""


def check_keywords(given: Iterable[str], known: Iterable[str]) -> None:
    """Raises `OptionError` for a keyword that is not known."""
    known = sorted(known)
    for name in given:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            # What was cut short is no typing error: `tolerance` for `tolerance_um`.
            near = near or [word for word in known if word.startswith(name)]
            ask = f"did you mean `{near[0]}`? " if near else ""
            raise OptionError(
                f'there is no keyword "{name}"', code="keyword", hint=f"{ask}known: {', '.join(known)}"
            )


def read_settings(reading: Mapping[str, Any]) -> dict[str, Any]:
    """The keywords of `Reading` as plain values."""
    check_keywords(reading, Reading.__annotations__)
    plain = {name: value for name, value in reading.items() if value is not None}
    for name in ("accept", "refuse", "block_skips"):
        if name in plain:
            if isinstance(plain[name], str):
                raise OptionError(f"{name} is a text; it has to be a list", code="keyword")
            plain[name] = list(plain[name])
    if "subroutines" in plain:
        plain["subroutines"] = [os.fspath(folder) for folder in plain["subroutines"]]
    for name in ("told", "limits"):
        if name in plain:
            plain[name] = {key: float(value) for key, value in plain[name].items()}
    return plain


def machine_of(machine: Machine | Path) -> Machine:
    """A machine from itself, the name of a preset, or the path of a machine file."""
    if isinstance(machine, Machine):
        return machine
    if isinstance(machine, str) and not machine.endswith(".toml"):
        return Machine.preset(machine)
    return Machine.from_file(machine)


def numbers(name: str, values: ArrayLike, length: int | None = None) -> bytes:
    """One-dimensional finite numbers, whatever their layout in memory.

    Raises `DataError` for another shape or length, and for numbers that are not finite.
    """
    # Here, since numpy takes longer to import than all of this package.
    import numpy as np

    try:
        given = np.asanyarray(values)
        # Of complex numbers, points in time and texts a part would be taken for the whole.
        if given.dtype.kind in "cmMSUV":
            raise TypeError(f"it is of type {given.dtype}")
        array = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise DataError(f"{name} is not an array of numbers: {error}", code="dtype") from error
    if np.ma.is_masked(given):
        raise DataError(
            f"{name} has masked values", code="not-finite", hint="drop them, or fill them in before"
        )
    if array.ndim != 1:
        raise DataError(
            f"{name} has the shape {array.shape}; it has to have one dimension",
            code="shape",
            hint="take one column: array[:, 0]",
        )
    if length is not None and len(array) != length:
        raise DataError(f"{name} has {len(array)} values, the others have {length}", code="shape")
    finite = np.isfinite(array)
    if not finite.all():
        place = int(np.argmin(finite))
        raise DataError(
            f"{name}[{place}] is {array[place]}; every value has to be finite",
            code="not-finite",
            hint="drop such rows, or fill them in before",
        )
    return np.ascontiguousarray(array).tobytes()
