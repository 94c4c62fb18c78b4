"""One axis alone, and what a log tells of one."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _native
from ._native import Machine, Table
from ._settings import Path, numbers
from .compensators import CompensatorMaker
from .errors import DataError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Axis", "Fit", "fit", "identify"]


class Axis:
    """An axis with a compensator, stepped by its setpoints: drive, motor, gap and load.

    ``axis`` is a preset (``"paper"``, ``"vmc3:x"``), the text of an axis file, or a `Machine` with
    the name of its drive. Positions are in the axis' unit. ``method`` is a registered one;
    ``compensator`` makes one of your own. ``start`` is where it stands, at rest.

    With ``differences`` positions alone are enough; without it the axis' own interpolator may need
    velocity and acceleration, too.

    >>> axis = Axis("paper")
    >>> trace = axis.push([0.0, 0.001, 0.002])
    >>> len(trace) == 3 * axis.servo_ticks
    True
    """

    __slots__ = ("_native",)

    def __init__(
        self,
        axis: str | Machine,
        drive: str | None = None,
        *,
        method: str | None = None,
        compensator: CompensatorMaker | None = None,
        start: float = 0.0,
        differences: bool = True,
    ) -> None:
        self._native = _native.Axis(
            axis,
            drive,
            method=method,
            compensator=compensator,
            start=start,
            differences=differences,
        )

    def push(
        self,
        position: ArrayLike,
        *,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        load_force: ArrayLike | None = None,
    ) -> Table:
        """Takes setpoints, one a command cycle (1 ms), and gives what the axis did: a row for each
        servo tick (250 us).

        All are of one dimension and one length: position in the axis' unit ``u``, its velocity
        (``u``/s) and acceleration (``u``/s2), and a force on the load against the positive
        direction (N, or N m of an axis that turns).

        Columns: ``t_s``, ``reference_u`` with its velocity and acceleration, ``motor_u``,
        ``load_u`` and their velocities, ``current_a``, ``torque_nm``, ``engagement`` (-1, 0, 1),
        estimates of the compensator (NaN where there is none), force of the shaft on the load.
        """
        places = numbers("position", position)
        count = len(places) // 8

        def column(name: str, values: ArrayLike | None) -> bytes | None:
            return None if values is None else numbers(name, values, count)

        return self._native._push(
            places,
            column("velocity", velocity),
            column("acceleration", acceleration),
            column("load_force", load_force),
        )

    def step(self, position: float, **setpoint: float) -> Table:
        """Takes one setpoint; keywords as those of `push`."""
        return self.push([position], **{name: [value] for name, value in setpoint.items()})

    @property
    def unit(self) -> str:
        """Unit of positions: ``mm``, ``deg`` or ``rad``."""
        return self._native.unit

    @property
    def method(self) -> str:
        """The compensator."""
        return self._native.method

    @property
    def servo_ticks(self) -> int:
        """Servo ticks in a command cycle."""
        return self._native.servo_ticks

    @property
    def delay_ticks(self) -> int:
        """Command cycles by which the reference lags behind the setpoints."""
        return self._native.delay_ticks

    @property
    def servo_period_s(self) -> float:
        """Time between two servo ticks, s."""
        return self._native.servo_period_s

    @property
    def command_period_s(self) -> float:
        """Time between two setpoints, s."""
        return self._native.command_period_s

    def to_dict(self) -> dict[str, Any]:
        """Everything that is known of the axis, as in its table of a machine file."""
        return self._native.to_dict()

    def copy(self) -> Axis:
        """An axis that goes on from here on its own."""
        axis = Axis.__new__(Axis)
        axis._native = self._native.copy()
        return axis

    def __repr__(self) -> str:
        return repr(self._native)


@dataclass(frozen=True)
class Fit:
    """The gap of an axis as a log tells it."""

    gap: float
    """Total gap at the load, in the unit of the log."""
    gap_interval: tuple[float, float]
    """95 % interval of it."""
    unit: str
    """Unit of the log's positions."""
    excited: bool
    """Whether the log tells the gap from zero; if not, it is a bound and no value."""
    data: Mapping[str, Any]
    """All figures, in full."""
    json: str
    """The document that ``lostmotion axis fit`` writes."""


_Log = Path | Mapping[str, "ArrayLike"]


def _log(
    log: _Log, columns: Sequence[str], unit: str, roles: Sequence[str]
) -> tuple[dict[str, bytes], str] | tuple[str, Sequence[str]]:
    if isinstance(log, (str, os.PathLike)):
        # Python's own exceptions for files that cannot be opened.
        with open(log, "rb"):
            return os.fspath(log), list(columns)
    if not isinstance(log, Mapping):
        raise DataError(
            f"a log is a file or a mapping of columns, not {type(log).__name__}",
            code="log",
            hint='of a frame: {"time_s": frame["t_s"], "motor": frame["motor_mm"], ...}',
        )
    known = ["time_s", "motor", *roles]
    for name in log:
        if name not in known:
            raise DataError(f'a log has no column "{name}"', hint=f"known: {', '.join(known)}")
    for name in ("time_s", "motor"):
        if name not in log:
            raise DataError(f"the log has no {name}", hint=f"columns: {', '.join(known)}")
    time = numbers("time_s", log["time_s"])
    count = len(time) // 8
    rest = {name: numbers(name, values, count) for name, values in log.items()}
    if "current_a" in rest and "drive" in rest:
        raise DataError("the log has both current_a and drive", hint="give one of them")
    drive = rest.pop("current_a", None)
    if drive is not None:
        rest["drive"] = drive
    return rest, unit


def fit(
    log: _Log,
    axis: str | Machine | None = None,
    drive: str | None = None,
    *,
    motor_only: bool = False,
    unit: str = "mm",
    columns: Sequence[str] = (),
    lateness_ms: float = 0.4,
) -> Fit:
    """Fits the gap of an axis to a log.

    ``log`` is a file in any format that ``lostmotion axis log`` knows (``columns`` says what a
    column is: ``"motor=NAME,unit=um"``), or columns of one length: ``time_s``, ``motor``, ``load``
    (positions at the load in ``unit``) and ``current_a``. With ``axis`` motor data are known and
    the interval is narrower. ``motor_only`` does without the load's position and needs the axis.
    ``lateness_ms`` is how much later or earlier than the motor's the load's position may be read
    where the log does not tell it: 0 where one drive reads both at the same time.

    Raises `DataError` for a log that does not tell the gap, or that is none.
    """
    if motor_only and axis is None:
        raise DataError("motor_only needs the axis", hint='for example axis="vmc3:x"')
    roles = ["current_a"] if motor_only else ["load", "current_a"]
    given = _log(log, columns, unit, ["load", "current_a"])
    if isinstance(log, Mapping):
        for name in roles:
            if name not in log:
                raise DataError(f"the log has no {name}", hint="give it as a column")
    data, document = _native.fit(given, axis, drive, motor_only, 1e-3 * lateness_ms)
    low, high = data["gap_interval"]
    return Fit(data["gap"], (low, high), data["unit"], data["excited"], data, document)


def identify(
    log: _Log,
    *,
    unit: str = "mm",
    columns: Sequence[str] = (),
    lateness_ms: float = 0.4,
) -> dict[str, Any]:
    """What a log tells of an axis as one body: lost motion, inertia, friction, servo gains.

    ``log`` is a file, or columns of one length: ``time_s``, ``motor`` and, as far as they were
    logged, ``load`` and ``command`` (positions at the load in ``unit``) and ``drive`` (current,
    torque or force; a current may also be called ``current_a``, as in `fit`). ``lateness_ms`` is
    how much later or earlier than the motor's the load's position may be read where the log does
    not tell it. Answers in m or rad, s, and the unit of ``drive``: ``lost_motion``, ``body`` and
    ``servo``, each ``None`` where ``untold`` says why. A figure is ``value``, its standard
    ``error`` and its 95 % ``interval``.
    """
    given = _log(log, columns, unit, ["load", "command", "drive", "current_a"])
    return _native.identify(given, 1e-3 * lateness_ms)
