"""`simulate` and `plan`: a program on a machine."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from . import _native
from ._native import Machine, Plan, Table
from ._settings import OnProgress, Path, Reading, check_keywords, machine_of, read_settings
from .compensators import CompensatorMaker
from .errors import OptionError
from .program import Program, program_of
from .results import ErrorStats, MethodResult, PlanInfo, ProgramInfo, RunResult, Trust

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Run", "Running", "plan", "simulate"]


class Running(Reading, total=False):
    """How a program is run; what is left out is as the machine has it."""

    tolerance_um: float
    """Tolerance of the contour error, um."""
    cutting_force_n: float
    """Cutting force against the direction of travel on feed moves, N."""
    bow_limit_um: float
    """How far the tool may leave its path between two setpoints, um."""
    sensitivity: float
    """By how much the drives are told gap, friction and stiffness wrong, per cent, 0 to 95; 30 in a
    comparison."""
    control: str
    """Recommend among what this control can do."""
    quality: Literal["fast", "optimal"]
    """How much effort goes into the cycle time."""
    interventions: Sequence[tuple[float, str] | tuple[float, str, float]]
    """What an operator does: ``(3.2, "hold")``, ``(4.5, "resume")``, ``(7.0, "override", 0.5)``."""
    learned: str
    """What methods that learn start from: ``Run.learned`` of an earlier run."""
    max_duration_s: float
    """Longest motion, s; a week if left out."""
    keep_blocks: int
    """How many of the worst blocks `MethodResult.worst_blocks` lists; 10 if left out."""
    keep_reversals: int
    """How many of the worst reversals `MethodResult.reversals` lists; 20 if left out."""
    spline_tolerance_mm: float
    """How far the planned curves may lie from the splines of the program, mm."""
    threads: int
    """Threads; 0, as if left out, is one a core. The result does not depend on it."""


def _settings(given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Those of reading, and those of running."""
    check_keywords(given, Running.__annotations__)
    own = set(Running.__annotations__) - set(Reading.__annotations__)
    running = {name: given[name] for name in given if name in own and given[name] is not None}
    reading = {name: given[name] for name in given if name not in own}
    if "interventions" in running:
        running["interventions"] = [
            (float(at[0]), str(at[1]), float(at[2]) if len(at) > 2 else None)
            for at in running["interventions"]
        ]
    return read_settings(reading), running


class Run:
    """What came of a run. It can be pickled; in a notebook it shows its page.

    Contour errors are in um: ``blocks`` has a row for each block, ``reversals`` for each reversal,
    and, where they were asked for, ``samples`` and ``motors`` for each servo tick.
    """

    def __init__(self, native: _native.Run) -> None:
        self._native = native

    @cached_property
    def data(self) -> RunResult:
        """Every figure, in full precision."""
        return RunResult.of(self._native.to_dict())

    @property
    def program(self) -> ProgramInfo:
        """The program."""
        return self.data.program

    @property
    def plan(self) -> PlanInfo:
        """The motion, which all methods share."""
        return self.data.plan

    @property
    def results(self) -> tuple[MethodResult, ...]:
        """One for each method, in the order asked for."""
        return self.data.results

    @property
    def without_gap(self) -> ErrorStats:
        """The same machine without a gap: the best that compensation can reach, um."""
        return self.data.without_gap

    @property
    def recommended(self) -> str | None:
        """The method to use; ``None`` where there is one method, or none can be recommended."""
        return self.data.recommended

    @property
    def trust(self) -> Trust | None:
        """What it would take to recommend another one."""
        return self.data.trust

    def __getitem__(self, method: str) -> MethodResult:
        """The result of a method."""
        for result in self.results:
            if result.method == method:
                return result
        known = ", ".join(result.method for result in self.results)
        raise KeyError(f'no result of "{method}"; there are {known}')

    @property
    def within_tolerance(self) -> bool:
        """Whether the method that decides keeps the tolerance: the recommended one of several."""
        return self._native.within_tolerance

    @property
    def blocks(self) -> Table:
        """A row for each block and method, in the order in which they were finished: ``method``,
        ``segment``, ``file``, ``line``, ``rapid`` (0, 1), ``time_s``, ``max_um`` (signed, of the
        worst sample), ``rms_um``, its parts ``command_um``, ``servo_um`` and ``backlash_um``,
        ``cause``, ``x_mm``, ``y_mm``, ``z_mm``."""
        return self._native.blocks

    @property
    def reversals(self) -> Table:
        """A row for each reversal and method: ``method``, ``axis``, ``direction``, ``file``,
        ``line``, ``rapid``, ``time_s``, ``peak_um``, ``backlash_um``."""
        return self._native.reversals

    @property
    def samples(self) -> Table:
        """A row for each servo tick and method: time ``t_s``, foot point and normal of the contour,
        ``error_um``, ``backlash_um``, places of command and tool in mm. Raises `OptionError` where
        the run was not asked for them."""
        return _asked(self._native.samples, "samples")

    @property
    def motors(self) -> Table:
        """A row for each servo tick and method: reference, motor, load, current, torque and
        engagement of each motor. Raises `OptionError` where the run was not asked for them."""
        return _asked(self._native.motors, "motors")

    @property
    def learned(self) -> str | None:
        """What a method that learns knows at the end, as the text of a file."""
        return self._native.learned

    @property
    def page(self) -> str:
        """The page of the run for a browser, one HTML text that needs no network. Raises
        `OptionError` where the run was not asked for it."""
        page = self._native.page
        if page is None:
            raise OptionError("the run has no page", code="not-kept", hint="simulate(..., page=True)")
        return page

    def to_dict(self) -> dict[str, Any]:
        """Every figure, in full precision."""
        return self._native.to_dict()

    def to_json(self) -> str:
        """The document that ``lostmotion simulate --format json`` prints, rounded as there."""
        return self._native.to_json()

    def to_text(self, width: int | None = None) -> str:
        """The answer as the command prints it."""
        return self._native.to_text(width)

    def __str__(self) -> str:
        return self.to_text()

    def __repr__(self) -> str:
        errors = ", ".join(f"{result.method}: {result.cutting.max:.1f} um" for result in self.results)
        return f"Run({self.program.name!r} on {self.data.machine!r}; {errors})"

    def _repr_html_(self) -> str:
        """The page where there is one, and the text of the answer where not."""
        if self._native.page is None:
            return f"<pre>{html.escape(self.to_text())}</pre>"
        # A frame of its own: scripts and styles of the page and the notebook do not meet.
        page = html.escape(self._native.page, quote=True)
        return (
            f'<iframe srcdoc="{page}" sandbox="allow-scripts" '
            'style="width: 100%; height: 48em; border: 0"></iframe>'
        )


def _asked(table: Table | None, name: str) -> Table:
    if table is None:
        raise OptionError(f"the run has no {name}", code="not-kept", hint=f"simulate(..., {name}=True)")
    return table


def simulate(
    part: Program | Path,
    machine: Machine | Path = "vmc3",
    *,
    method: str | None = None,
    methods: Sequence[str] | None = None,
    compensators: Mapping[str, CompensatorMaker] | None = None,
    samples: bool = False,
    motors: bool = False,
    page: bool = False,
    on_progress: OnProgress | None = None,
    **settings: Unpack[Running],
) -> Run:
    """Runs a part program on a machine and judges the contour error.

    ``part`` is a `Program` or the path of one; ``machine`` a `Machine`, the name of a preset or the
    path of a machine file. ``method`` is a registered method (`methods` lists them), or that of the
    machine; ``methods`` are compared on one plan, and one is recommended. ``compensators`` are of
    your own, by the name for the results; they are slow.

    ``samples``, ``motors`` and ``page`` say what is kept besides: at 4,000 rows a second of motion
    and method of some 150 bytes each, samples of hours need gigabytes.

    ``on_progress`` is called about once a second of motion with a `Progress`; answering ``False``
    ends the run with `Cancelled`. The run goes on without Python's lock; Ctrl-C ends it at once.

    Raises `ProgramError`, `MachineError`, `MethodError` or `OptionError`, each with a code, a place
    and a hint.

    >>> import lostmotion
    >>> program = lostmotion.Program("G21 G90\\nG0 X25\\nG3 I-25 F2000\\nM2\\n")
    >>> run = lostmotion.simulate(program, "vmc3", method="fixed")
    >>> run.within_tolerance
    True
    """
    if method is not None and methods is not None:
        raise OptionError("both method and methods are given", hint="give one of them")
    if isinstance(methods, str):
        raise OptionError(
            f'methods is the text "{methods}"; it has to be a list', hint=f'methods=["{methods}"]'
        )
    names = [*(methods or ()), *(compensators or {})]
    for name in names:
        if names.count(name) > 1:
            raise OptionError(f'"{name}" is asked for twice', hint="results go by their names")
    reading, running = _settings(settings)
    native = _native.simulate(
        program_of(part)._native,
        machine_of(machine),
        method,
        None if methods is None else list(methods),
        list((compensators or {}).items()),
        (samples, motors, page),
        reading,
        running,
        on_progress,
    )
    return Run(native)


def plan(
    part: Program | Path,
    machine: Machine | Path = "vmc3",
    *,
    on_progress: OnProgress | None = None,
    **settings: Unpack[Running],
) -> Plan:
    """Plans a part program and gives the motion: a row of `Plan.samples` for each command cycle.

    >>> import lostmotion
    >>> program = lostmotion.Program("G21 G90\\nG1 X50 F3000\\nM2\\n")
    >>> motion = lostmotion.plan(program, "bench3")
    >>> motion.cutting_mm
    50.0
    >>> round(float(motion.samples["x_mm"][-1]), 9)
    50.0
    """
    reading, running = _settings(settings)
    return _native.plan(program_of(part)._native, machine_of(machine), reading, running, on_progress)
