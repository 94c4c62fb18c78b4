"""Results as typed values. Made from the JSON Schema of the command's documents by
`make_results.py`: the fields, their units and their meaning are those of the JSON form, in full
precision. A figure that cannot be told is NaN, a part that there is not is ``None``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = [
    "AxisResult",
    "BlockRef",
    "BlockResult",
    "ErrorParts",
    "ErrorStats",
    "GantryResult",
    "LateInterventions",
    "LimitsUsed",
    "MethodResult",
    "MisledResult",
    "PlanInfo",
    "PlanShortfalls",
    "ProgramInfo",
    "ReversalResult",
    "RunResult",
    "Span",
    "StopResult",
    "Straightness",
    "Trust",
]


def _name(value: Any) -> str:
    """A name, or the name of a kind with what it is of: ``reversal of X``."""
    if isinstance(value, Mapping):
        return " of ".join(map(str, value.values()))
    return str(value)


@dataclass(frozen=True)
class Span:
    """A stretch of source bytes with its line and column for people."""
    column: int
    """Column in bytes, from 1."""
    file: int
    """Index of the file in the session's list of files; 0 is the program itself."""
    len: int
    """Number of bytes."""
    line: int
    """Line, from 1."""
    start: int
    """Offset of the first byte."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> Span:
        """From the form that `Run.to_dict` has."""
        return cls(
            column=data["column"],
            file=data["file"],
            len=data["len"],
            line=data["line"],
            start=data["start"],
        )


@dataclass(frozen=True)
class BlockRef:
    """The block that an action came from."""
    call_stack: int
    """Index into the interpreter's list of call stacks; 0 is the main program."""
    span: Span
    """Where the block stands."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> BlockRef:
        """From the form that `Run.to_dict` has."""
        return cls(
            call_stack=data["call_stack"],
            span=Span.of(data["span"]),
        )


@dataclass(frozen=True)
class Straightness:
    """The largest distance of a way that is no straight line from a straight one, and where."""
    block: BlockRef
    """The block."""
    max_um: float
    """Distance, um."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> Straightness:
        """From the form that `Run.to_dict` has."""
        return cls(
            block=BlockRef.of(data["block"]),
            max_um=data["max_um"],
        )


@dataclass(frozen=True)
class ErrorStats:
    """Distribution of an error's magnitude over the samples of one kind of motion."""
    max: float
    """Largest magnitude."""
    p50: float
    """Median magnitude."""
    p95: float
    """95th percentile."""
    p99: float
    """99th percentile."""
    p999: float
    """99.9th percentile."""
    rms: float
    """Root mean square."""
    samples: int
    """Number of samples."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> ErrorStats:
        """From the form that `Run.to_dict` has."""
        return cls(
            max=data["max"],
            p50=data["p50"],
            p95=data["p95"],
            p99=data["p99"],
            p999=data["p999"],
            rms=data["rms"],
            samples=data["samples"],
        )


@dataclass(frozen=True)
class LateInterventions:
    """Interventions that came too late to do anything."""
    count: int
    """How many."""
    end_s: float
    """When the motion was over, s."""
    first_s: float
    """Time of the first of them since the start of the program, s."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> LateInterventions:
        """From the form that `Run.to_dict` has."""
        return cls(
            count=data["count"],
            end_s=data["end_s"],
            first_s=data["first_s"],
        )


@dataclass(frozen=True)
class PlanShortfalls:
    """How often a plan is not what it could be: it keeps every limit, but takes longer."""
    curve_stops: int
    """Stops where a smooth curve in place of many lines could not be found any further."""
    kept_windows: int
    """Windows of a retimed motion (quality `optimal`, overrides above 100 %) in which nothing faster
    was found than the pace that they end with.
    """
    window_stops: int
    """Stops because the look-ahead window was too short for the path's detail."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> PlanShortfalls:
        """From the form that `Run.to_dict` has."""
        return cls(
            curve_stops=data["curve_stops"],
            kept_windows=data["kept_windows"],
            window_stops=data["window_stops"],
        )


@dataclass(frozen=True)
class PlanInfo:
    """The plan, common to all methods."""
    bow: Straightness | None
    """On machines whose joints do not go straight with the tool, and where there is a limit to keep:
    how far it leaves its planned way between two commands if the drives join them by straight
    lines of the joints, in the part's frame.
    """
    bow_limit_um: float | None
    """How far it may be at most, um, where the motion is planned to keep a limit."""
    command: ErrorStats
    """Deviation of the command itself from the programmed path on cutting moves, um."""
    cutting_force_n: float | None
    """Size of the cutting force on feed moves, N."""
    cutting_mm: float
    """Length of cutting moves, mm."""
    duration_s: float
    """Duration of the program, s."""
    late: LateInterventions | None
    """Interventions whose time came after the end of the motion; they did nothing."""
    rapid_mm: float
    """Length of rapids, mm."""
    shortfalls: PlanShortfalls | None
    """How often the plan is not what it could be, if it ever is not."""
    unstraight: Straightness | None
    """How far a straight feed move with linear and rotary words, without tool-centre-point control,
    is from the straight line between its ends in the part's frame; `None` where there is no such
    move.
    """

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> PlanInfo:
        """From the form that `Run.to_dict` has."""
        return cls(
            bow=None if (value := data.get("bow")) is None else Straightness.of(value),
            bow_limit_um=data.get("bow_limit_um"),
            command=ErrorStats.of(data["command"]),
            cutting_force_n=data.get("cutting_force_n"),
            cutting_mm=data["cutting_mm"],
            duration_s=data["duration_s"],
            late=None if (value := data.get("late")) is None else LateInterventions.of(value),
            rapid_mm=data["rapid_mm"],
            shortfalls=None if (value := data.get("shortfalls")) is None else PlanShortfalls.of(value),
            unstraight=None if (value := data.get("unstraight")) is None else Straightness.of(value),
        )


@dataclass(frozen=True)
class ProgramInfo:
    """The program that was run."""
    bytes: int
    """Size."""
    files: tuple[str, ...]
    """Files of subroutines that were read: blocks name them by their place in this list, from 1."""
    lines: int
    """Lines."""
    moves: int
    """Moves."""
    name: str
    """File name as given."""
    warnings: tuple[str, ...]
    """Warnings of the front end, rendered."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> ProgramInfo:
        """From the form that `Run.to_dict` has."""
        return cls(
            bytes=data["bytes"],
            files=() if (value := data.get("files")) is None else tuple(item for item in value),
            lines=data["lines"],
            moves=data["moves"],
            name=data["name"],
            warnings=tuple(item for item in data["warnings"]),
        )


@dataclass(frozen=True)
class AxisResult:
    """One axis over the whole run."""
    axis: str
    """The axis."""
    following: ErrorStats
    """Following error: reference minus load position (delay of the spline taken out)."""
    following_without_gap: ErrorStats
    """The same without the gap."""
    gap: float
    """Total gap of the machine's axis."""
    peak_current_ratio: float
    """Largest current, in parts of the drive's limit."""
    peak_velocity: float
    """Peak commanded velocity per s (mm or deg)."""
    range: tuple[float, ...]
    """Travelled range, mm or deg."""
    reversals: int
    """Number of reversals."""
    saturated_samples: int
    """Samples at which the drive was at a limit."""
    unit: str
    """Unit of the position figures below: `um` or `mdeg`."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> AxisResult:
        """From the form that `Run.to_dict` has."""
        return cls(
            axis=_name(data["axis"]),
            following=ErrorStats.of(data["following"]),
            following_without_gap=ErrorStats.of(data["following_without_gap"]),
            gap=data["gap"],
            peak_current_ratio=data["peak_current_ratio"],
            peak_velocity=data["peak_velocity"],
            range=tuple(item for item in data["range"]),
            reversals=data["reversals"],
            saturated_samples=data["saturated_samples"],
            unit=data["unit"],
        )


@dataclass(frozen=True)
class GantryResult:
    """Skew of an axis that two motors drive: how far its first end is ahead of the second while
    anything moves.
    """
    axis: str
    """The axis."""
    block: BlockRef
    """In which block."""
    peak_um: float
    """The largest, um, signed: positive where the first end is ahead."""
    skew_um: ErrorStats
    """Distribution of the skew's magnitude, um."""
    time_s: float
    """When, s."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> GantryResult:
        """From the form that `Run.to_dict` has."""
        return cls(
            axis=_name(data["axis"]),
            block=BlockRef.of(data["block"]),
            peak_um=data["peak_um"],
            skew_um=ErrorStats.of(data["skew_um"]),
            time_s=data["time_s"],
        )


@dataclass(frozen=True)
class LimitsUsed:
    """How near the motors of an axis came to the limits that stop the machine, as parts of them: 1
    is the limit. 0 where nothing is watched; on a gantry the larger of both motors.
    """
    at_limit: float
    """Of the time that the drive may be at its limit without a break."""
    axis: str
    """The axis."""
    following_error: float
    """Of the following error that is allowed at the speed of the moment."""
    overload: float
    """Of the overload (I2t)."""
    travel: float
    """Of the way from the middle of the travel to where the motor is stopped."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> LimitsUsed:
        """From the form that `Run.to_dict` has."""
        return cls(
            at_limit=data["at_limit"],
            axis=_name(data["axis"]),
            following_error=data["following_error"],
            overload=data["overload"],
            travel=data["travel"],
        )


@dataclass(frozen=True)
class MisledResult:
    """How a method does where the drive is told one quantity of its axes wrong."""
    backlash: ErrorStats
    """What backlash adds to it, um."""
    cutting: ErrorStats
    """Contour error of cutting moves, um."""
    factor: float
    """Told over true; above zero."""
    stops: bool
    """Whether the control stops the machine; the errors are then of what was before."""
    what: str
    """Which."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> MisledResult:
        """From the form that `Run.to_dict` has."""
        return cls(
            backlash=ErrorStats.of(data["backlash"]),
            cutting=ErrorStats.of(data["cutting"]),
            factor=data["factor"],
            stops=data.get("stops", False),
            what=_name(data["what"]),
        )


@dataclass(frozen=True)
class ReversalResult:
    """One reversal of one axis."""
    axis: str
    """The axis."""
    backlash_um: float
    """Share of backlash in it, um, signed."""
    block: BlockRef
    """The block in force then."""
    direction: int
    """New direction: 1 or -1."""
    peak_um: float
    """Largest contour error between this reversal and the end of its window, um, signed."""
    rapid: bool
    """Whether the reversal is on a rapid."""
    time_s: float
    """When its commanded velocity changes sign, s."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> ReversalResult:
        """From the form that `Run.to_dict` has."""
        return cls(
            axis=_name(data["axis"]),
            backlash_um=data["backlash_um"],
            block=BlockRef.of(data["block"]),
            direction=data["direction"],
            peak_um=data["peak_um"],
            rapid=data["rapid"],
            time_s=data["time_s"],
        )


@dataclass(frozen=True)
class StopResult:
    """Where and why the control stops the machine, in a command cycle."""
    allowed: float
    """The limit: of a following error its magnitude, of the travel its end with the overtravel, of
    an overload 100, else the longest time.
    """
    at_limit_s: float
    """How long the drive had been at its current or voltage limit by then, s."""
    at_mm: tuple[float, ...]
    """Tool tip commanded then, mm, from the program's zero."""
    axis: str
    """The axis."""
    block: BlockRef
    """The block in force then."""
    limit: str
    """The limit that it has passed."""
    reason: str
    """Why, as far as it can be told: an unstable loop, a drive at its limit, a compensator that
    drives the axis off. May be empty.
    """
    second: bool
    """Whether it is the second motor of a gantry."""
    time_s: float
    """When, s."""
    unit: str
    """Unit of the two values below: `um` or `mdeg` of a following error, `mm` or `deg` of a
    position, `%` of an overload, `s` at the drive's limit.
    """
    value: float
    """What it was, signed."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> StopResult:
        """From the form that `Run.to_dict` has."""
        return cls(
            allowed=data["allowed"],
            at_limit_s=data["at_limit_s"],
            at_mm=tuple(item for item in data["at_mm"]),
            axis=_name(data["axis"]),
            block=BlockRef.of(data["block"]),
            limit=_name(data["limit"]),
            reason=data["reason"],
            second=data.get("second", False),
            time_s=data["time_s"],
            unit=data["unit"],
            value=data["value"],
        )


@dataclass(frozen=True)
class ErrorParts:
    """Decomposition of one signed contour error, um. The sum is the error itself."""
    backlash: float
    """What the gap adds."""
    command: float
    """The command's own distance from the programmed path."""
    servo: float
    """What the machine without a gap adds."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> ErrorParts:
        """From the form that `Run.to_dict` has."""
        return cls(
            backlash=data["backlash"],
            command=data["command"],
            servo=data["servo"],
        )


@dataclass(frozen=True)
class BlockResult:
    """One block of the program and how far the tool left its contour."""
    at_mm: tuple[float, ...]
    """Tool tip commanded at the worst sample, mm, from the program's zero."""
    block: BlockRef
    """Where the block stands."""
    cause: str
    """What makes most of it."""
    max_um: float
    """Largest error, signed, um; positive to the left of the direction of travel."""
    parts_um: ErrorParts
    """Parts of the error at the worst sample, um: command (blending), servo, backlash."""
    rapid: bool
    """Whether it is a G0 move."""
    rms_um: float
    """Root mean square, um."""
    segment: int
    """Running number of the move."""
    text: str
    """The block's text, trimmed, at most 80 characters."""
    time_s: float
    """Time of the worst sample, s."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> BlockResult:
        """From the form that `Run.to_dict` has."""
        return cls(
            at_mm=tuple(item for item in data["at_mm"]),
            block=BlockRef.of(data["block"]),
            cause=_name(data["cause"]),
            max_um=data["max_um"],
            parts_um=ErrorParts.of(data["parts_um"]),
            rapid=data["rapid"],
            rms_um=data["rms_um"],
            segment=data["segment"],
            text=data["text"],
            time_s=data["time_s"],
        )


@dataclass(frozen=True)
class MethodResult:
    """How one method did."""
    axes: tuple[AxisResult, ...]
    """Per axis."""
    backlash: ErrorStats
    """What backlash adds to the error on cutting moves, um: the length of the difference between the
    errors with and without a gap, as vectors across the path.
    """
    cutting: ErrorStats
    """Contour error of cutting moves (G1, G2, G3), um."""
    gantry: GantryResult | None
    """Skew of the gantry, on machines that have one."""
    limits_used: tuple[LimitsUsed, ...]
    """How near each axis came to being stopped."""
    method: str
    """Registered name of the compensator."""
    misled: tuple[MisledResult, ...]
    """How it does where the drive is told its axis wrong; of methods that are compared and told
    something.
    """
    not_recommended: str | None
    """Why it is not recommended, if there is a reason."""
    notes: tuple[str, ...]
    """Remarks for people: saturation, a limit cycle, a method that does harm."""
    orientation_mdeg: ErrorStats | None
    """Tool-axis orientation error on cutting moves, mdeg, on machines with rotary axes."""
    rapid: ErrorStats
    """Contour error of rapids, um."""
    reversal_count: int
    """Number of all reversals."""
    reversals: tuple[ReversalResult, ...]
    """Reversals with the largest error, worst first; the number kept is bounded."""
    stop: StopResult | None
    """Where the control stops the machine; all figures are of what was before. `None` if it runs to
    the end.
    """
    within_tolerance: bool
    """Largest error of cutting moves within the tolerance, and the machine not stopped?"""
    worst_blocks: tuple[BlockResult, ...]
    """Cutting blocks with the largest error, worst first; G0 blocks only if the program cuts
    nothing.
    """

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> MethodResult:
        """From the form that `Run.to_dict` has."""
        return cls(
            axes=tuple(AxisResult.of(item) for item in data["axes"]),
            backlash=ErrorStats.of(data["backlash"]),
            cutting=ErrorStats.of(data["cutting"]),
            gantry=None if (value := data.get("gantry")) is None else GantryResult.of(value),
            limits_used=tuple(LimitsUsed.of(item) for item in data["limits_used"]),
            method=data["method"],
            misled=() if (value := data.get("misled")) is None else tuple(MisledResult.of(item) for item in value),
            not_recommended=data.get("not_recommended"),
            notes=tuple(item for item in data["notes"]),
            orientation_mdeg=None if (value := data.get("orientation_mdeg")) is None else ErrorStats.of(value),
            rapid=ErrorStats.of(data["rapid"]),
            reversal_count=data["reversal_count"],
            reversals=tuple(ReversalResult.of(item) for item in data["reversals"]),
            stop=None if (value := data.get("stop")) is None else StopResult.of(value),
            within_tolerance=data["within_tolerance"],
            worst_blocks=tuple(BlockResult.of(item) for item in data["worst_blocks"]),
        )


@dataclass(frozen=True)
class Trust:
    """How well the axes have to be known for a method to be recommended."""
    least: float
    """The smallest part tried."""
    method: str
    """The method."""
    told: tuple[str, ...]
    """The quantities that have to be known better."""
    within: float
    """Largest part of the values tried by which they may be off; `None` if the method is not safe
    even with the smallest one.
    """

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> Trust:
        """From the form that `Run.to_dict` has."""
        return cls(
            least=data["least"],
            method=data["method"],
            told=tuple(_name(item) for item in data["told"]),
            within=data["within"],
        )


@dataclass(frozen=True)
class RunResult:
    """Answer of a run: one plan, one method or several side by side."""
    machine: str
    """Machine name."""
    plan: PlanInfo
    """The plan."""
    program: ProgramInfo
    """The program."""
    recommended: str | None
    """The method to use: never one that stops the machine, or leaves a larger contour error than no
    compensation, as it stands or with gap, friction or stiffness told wrong
    (`MethodResult::misled`); of the others one that keeps the tolerance, with the smallest RMS in
    the worst of these runs. `None` if there is one method, or none that can be recommended.
    """
    results: tuple[MethodResult, ...]
    """One row a method, in the order asked for."""
    schema: int
    """Version of this form, `SCHEMA_VERSION`."""
    tolerance_um: float
    """Tolerance of the verdict, um."""
    trust: Trust | None
    """What it would take to recommend another one: that which is best where everything is told
    right, if it is not the one that is safe where something is told wrong.
    """
    without_gap: ErrorStats
    """The same machine without any gap and without compensation: the best that compensation can
    reach, um on cutting moves.
    """

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> RunResult:
        """From the form that `Run.to_dict` has."""
        return cls(
            machine=data["machine"],
            plan=PlanInfo.of(data["plan"]),
            program=ProgramInfo.of(data["program"]),
            recommended=data.get("recommended"),
            results=tuple(MethodResult.of(item) for item in data["results"]),
            schema=data["schema"],
            tolerance_um=data["tolerance_um"],
            trust=None if (value := data.get("trust")) is None else Trust.of(value),
            without_gap=ErrorStats.of(data["without_gap"]),
        )
