"""The extension module; its public names are those of `lostmotion`."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, final

import numpy.typing as npt

from .compensators import CompensatorMaker
from .errors import Finding

__all__ = [
    "Axis",
    "Column",
    "Imported",
    "Machine",
    "Operations",
    "Plan",
    "Program",
    "Progress",
    "Run",
    "SweepDriver",
    "Table",
    "Tick",
    "__version__",
    "fit",
    "identify",
    "import_machine",
    "machine_keys",
    "methods",
    "plan",
    "presets",
    "schema",
    "simulate",
    "sweep_collect",
    "sweep_plan",
    "sweep_work",
]

__version__: str

@final
class Progress:
    """How far a run is."""

    @property
    def done_bytes(self) -> int:
        """Bytes of the program read so far."""
    @property
    def total_bytes(self) -> int:
        """Bytes of the program."""
    @property
    def simulated_s(self) -> float:
        """Machine time simulated so far, s."""
    @property
    def share(self) -> float:
        """Part of the program that has been read, 0 to 1."""

@final
class Tick:
    """What a drive knows at a servo tick; angles are rad at the motor's shaft."""

    @property
    def position(self) -> float:
        """Reference, rad."""
    @property
    def velocity(self) -> float:
        """Velocity of the reference, rad/s."""
    @property
    def acceleration(self) -> float:
        """Acceleration of the reference, rad/s2."""
    @property
    def next_position(self) -> float:
        """Reference one servo tick ahead, rad."""
    @property
    def next_velocity(self) -> float:
        """Its velocity, rad/s."""
    @property
    def next_acceleration(self) -> float:
        """Its acceleration, rad/s2."""
    @property
    def motor_position(self) -> float:
        """Motor from its encoder, rad, quantised."""
    @property
    def motor_velocity(self) -> float:
        """Motor as the drive computes it, rad/s."""
    @property
    def current(self) -> float:
        """Torque-forming current, A."""
    @property
    def mean_current(self) -> float:
        """Its mean over the last servo period, A."""
    @property
    def saturated(self) -> bool:
        """Whether the drive was at a limit in the last period."""
    @property
    def load_position(self) -> float | None:
        """Load from its scale, rad; ``None`` unless the maker declares ``load_scale``."""

@final
class Column:
    """A column whose memory ``numpy.asarray`` reads in place."""

    def __len__(self) -> int: ...
    @property
    def __array_interface__(self) -> dict[str, Any]: ...

@final
class Table:
    """Columns of equal length, which numpy, Arrow, pandas and polars read without a copy.

    ``table["error_um"]`` is a read-only array of shape ``(len(table),)``: ``float64`` for numbers,
    ``int64`` for whole numbers, objects for texts. The unit is in the name of the column. A number
    that is not known is NaN.
    """

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
    def keys(self) -> list[str]: ...
    def __len__(self) -> int:
        """Number of rows."""
    def __iter__(self) -> Iterator[str]: ...
    def __contains__(self, name: object, /) -> bool: ...
    def __getitem__(self, name: str, /) -> npt.NDArray[Any]: ...
    def row(self, index: int) -> dict[str, Any]:
        """A row as a dictionary; from the end where the index is below 0."""
    def __arrow_c_stream__(self, requested_schema: object = None) -> object: ...
    def to_pandas(self) -> Any:
        """``pandas.DataFrame``; texts become categories."""
    def to_polars(self) -> Any:
        """``polars.DataFrame``."""
    def to_arrow(self) -> Any:
        """``pyarrow.Table``."""

@final
class Machine:
    """A checked machine. Equal machines compare equal; it can be pickled."""

    @staticmethod
    def preset(name: str) -> Machine:
        """A machine that comes with the library: ``vmc3``; see `presets`."""
    @staticmethod
    def from_toml(text: str, name: str = "machine.toml") -> Machine:
        """A machine from the text of its file.

        Raises `MachineError` with everything that is wrong, each with line, column and hint.
        """
    @staticmethod
    def from_file(path: str | PathLike[str]) -> Machine:
        """A machine from its file."""
    @staticmethod
    def from_dict(description: dict[str, Any]) -> Machine:
        """A machine from what `to_dict` gives, changed or made by hand: keys of a machine file."""
    @staticmethod
    def problems(text: str, name: str = "machine.toml") -> list[Finding]:
        """All that is wrong with the text of a machine file, badly tuned loops included."""
    def edit(self, changes: Mapping[str, Any]) -> Machine:
        """The machine with other values of its keys: ``{"axis.x.load.slide.gap_um": 25.0}``.

        `machine_keys` lists the keys; each has its unit in its name.
        """
    @property
    def name(self) -> str: ...
    @property
    def description(self) -> str:
        """One line about it."""
    @property
    def dialect(self) -> str:
        """Dialect that its programs are in."""
    @property
    def drives(self) -> list[str]:
        """Names of its drives: letters of the axes, ``y2`` for a gantry's second motor."""
    def to_toml(self) -> str:
        """The text of a machine file that gives an equal machine."""
    def to_dict(self) -> dict[str, Any]:
        """The same as a dictionary."""
    def remarks(self) -> list[str]:
        """What a commissioning engineer would object to."""
    def tuning(self) -> list[dict[str, Any]]:
        """A row for each loop of each axis: margins in dB and deg, crossover and bandwidth in Hz."""

@final
class Imported:
    """What came of `import_machine`."""

    @property
    def machine(self) -> Machine: ...
    @property
    def toml(self) -> str:
        """Its file, where every value says where it is from."""
    @property
    def rows(self) -> list[tuple[str, str, str, str]]:
        """Key, value, fate (used, ignored, filled in) and note of every key."""

@final
class Operations:
    """Canonical operations: ``(line, column, file, text)`` of each, made as they are asked for."""

    def __iter__(self) -> Operations: ...
    def __next__(self) -> tuple[int, int, int, str]: ...

@final
class Program:
    @staticmethod
    def from_text(text: str, name: str = "program") -> Program: ...
    @staticmethod
    def from_file(path: str | PathLike[str]) -> Program: ...
    @property
    def name(self) -> str: ...
    @property
    def text(self) -> str: ...
    def format(self, *, case: str = "upper", indent: int = 2, line_numbers: str = "keep") -> str: ...
    def _findings(
        self,
        machine: Machine | None,
        lints: Sequence[tuple[str, str]] | None,
        reading: dict[str, Any],
    ) -> list[dict[str, Any]]: ...
    def _operations(self, machine: Machine | None, reading: dict[str, Any]) -> Operations: ...
    def _explain(
        self, line: int, machine: Machine | None, reading: dict[str, Any]
    ) -> tuple[str, dict[str, Any]]: ...
    def _resolved(self, machine: Machine | None, system: int, reading: dict[str, Any]) -> str: ...

@final
class Run:
    @property
    def blocks(self) -> Table: ...
    @property
    def reversals(self) -> Table: ...
    @property
    def samples(self) -> Table | None: ...
    @property
    def motors(self) -> Table | None: ...
    @property
    def page(self) -> str | None: ...
    @property
    def learned(self) -> str | None: ...
    @property
    def within_tolerance(self) -> bool: ...
    def to_dict(self) -> dict[str, Any]: ...
    def to_json(self) -> str: ...
    def to_text(self, width: int | None = None) -> str: ...

@final
class Plan:
    """A planned motion."""

    @property
    def samples(self) -> Table:
        """A row a command cycle: ``t_s``, a position for each axis (``x_mm`` ... ``c_deg``, machine
        coordinates), its velocity (``x_velocity_mm_s``) and acceleration
        (``x_acceleration_mm_s2``), ``line`` of the program."""
    @property
    def duration_s(self) -> float:
        """Length of the motion, s."""
    @property
    def cutting_mm(self) -> float:
        """Length of cutting moves, mm."""
    @property
    def rapid_mm(self) -> float:
        """Length of rapids, mm."""
    def to_dict(self) -> dict[str, Any]:
        """All that is known of the plan."""

@final
class Axis:
    def __new__(
        cls,
        axis: str | Machine,
        drive: str | None = None,
        *,
        method: str | None = None,
        compensator: CompensatorMaker | None = None,
        start: float = 0.0,
        differences: bool = True,
    ) -> Axis: ...
    def _push(
        self,
        position: bytes,
        velocity: bytes | None,
        acceleration: bytes | None,
        load_force: bytes | None,
    ) -> Table: ...
    @property
    def unit(self) -> str: ...
    @property
    def method(self) -> str: ...
    @property
    def servo_ticks(self) -> int: ...
    @property
    def delay_ticks(self) -> int: ...
    @property
    def servo_period_s(self) -> float: ...
    @property
    def command_period_s(self) -> float: ...
    def to_dict(self) -> dict[str, Any]: ...
    def copy(self) -> Axis: ...

def presets() -> list[tuple[str, str]]: ...
def machine_keys() -> list[tuple[str, str]]: ...
def methods() -> list[tuple[str, str]]: ...
def schema(document: str) -> dict[str, Any]: ...
def import_machine(
    text: str,
    name: str,
    format: str | None,
    preset: str | None,
    tip: str | None,
    max_bytes: int | None,
    folder: str | PathLike[str] | None,
) -> Imported: ...
def simulate(
    program: Program,
    machine: Machine,
    method: str | None,
    methods: Sequence[str] | None,
    compensators: Sequence[tuple[str, CompensatorMaker]],
    keep: tuple[bool, bool, bool],
    reading: dict[str, Any],
    running: dict[str, Any],
    on_progress: Callable[[Progress], object] | None,
) -> Run: ...
def plan(
    program: Program,
    machine: Machine,
    reading: dict[str, Any],
    running: dict[str, Any],
    on_progress: Callable[[Progress], object] | None,
) -> Plan: ...
def fit(
    log: tuple[dict[str, bytes], str] | tuple[str | PathLike[str], Sequence[str]],
    axis: str | Machine | None,
    drive: str | None,
    motor_only: bool,
    lateness_s: float,
) -> tuple[dict[str, Any], str]: ...
def identify(
    log: tuple[dict[str, bytes], str] | tuple[str | PathLike[str], Sequence[str]],
    lateness_s: float,
) -> dict[str, Any]: ...

@final
class SweepDriver:
    def __new__(
        cls, manifest: str | PathLike[str], shard: str, results: str | PathLike[str]
    ) -> SweepDriver: ...
    def __len__(self) -> int: ...
    def shared(self) -> bytes: ...
    def take(self, count: int) -> tuple[list[str], list[int]]: ...
    def program(self, index: int) -> bytes: ...
    def append(self, lines: Sequence[str]) -> tuple[int, float]: ...
    def work(
        self,
        shared: bytes,
        programs: Sequence[tuple[int, bytes]],
        cells: Sequence[str],
        threads: int,
    ) -> tuple[int, float]: ...
    def close(self) -> None: ...

def sweep_plan(
    text: str, path: str | PathLike[str], out: str | PathLike[str], most_cells: int | None
) -> int: ...
def sweep_collect(
    manifest: str | PathLike[str], results: Sequence[str | PathLike[str]]
) -> tuple[Table, int, list[str]]: ...
def sweep_work(
    shared: bytes, programs: Sequence[tuple[int, bytes]], cells: Sequence[str], threads: int
) -> list[str]: ...
