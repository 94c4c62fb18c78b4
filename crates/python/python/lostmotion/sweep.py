"""Sweeps: many programs, machines and settings; planned, run here or on a cluster of Ray, collected.

The files are those of ``lostmotion study sweep``: a manifest that one has planned is run by the
other, and results are put together whichever made them. A cell has the same figures, to the bit,
wherever it runs.
"""

from __future__ import annotations

import os
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Literal

from . import _native
from ._native import Table
from .errors import Cancelled, DataError, Error, MissingPackage, OptionError

__all__ = ["SweepProgress", "collect", "plan", "run"]

_Path = str | os.PathLike[str]

# Most cells of a batch: its results stay far below what one message may be.
_MOST_CELLS = 2000


@dataclass(frozen=True)
class SweepProgress:
    """How far a run is."""

    done: int
    """Cells finished by this run."""
    all: int
    """Cells that were to be run."""
    failed: int
    """Cells without figures among them; the table says why."""
    simulated_s: float
    """Machine time simulated, s."""


def plan(file: _Path, out: _Path, *, most_cells: int | None = None) -> int:
    """Plans the sweep of a file and writes its manifest; answers the number of cells.

    ``most_cells`` stands in place of the file's own limit. A key, value, program or machine that
    does not fit is an exception before anything runs.
    """
    if most_cells is not None and most_cells < 1:
        raise OptionError(f"most_cells is {most_cells}; it has to be 1 or more", code="option")
    with open(file, encoding="utf-8") as text:
        return _native.sweep_plan(text.read(), file, out, most_cells)


def _there(manifest: _Path) -> Path:
    """The path of a file that can be opened; Python's own exceptions where it cannot."""
    with open(manifest, "rb"):
        return Path(manifest)


def _results_path(manifest: Path, shard: str) -> Path:
    """The file that ``study sweep run`` takes when none is named."""
    stem = manifest.name.removesuffix(".jsonl")
    index, _, count = shard.partition("/")
    part = "" if (index.strip(), count.strip()) == ("1", "1") else f"-{index.strip()}-of-{count.strip()}"
    return manifest.with_name(f"{stem}.results{part}.jsonl")


def collect(manifest: _Path, results: _Path | list[_Path] | None = None) -> Table:
    """The table of a sweep: a row for each cell and method, in the order of the manifest.

    ``results`` are files of results; if left out those that ``run`` names after the manifest. Cells
    that have no result yet are missing from the table and told by a warning of Python's.
    """
    path = _there(manifest)
    if results is None:
        stem = path.name.removesuffix(".jsonl")
        found = [*path.parent.glob(f"{stem}.results.jsonl"), *path.parent.glob(f"{stem}.results-*.jsonl")]
        if not found:
            raise DataError(f"there are no results of {path} beside it", code="data", hint="run it first")
        paths: list[_Path] = [*sorted(found)]
    else:
        paths = [results] if isinstance(results, (str, os.PathLike)) else list(results)
    table, missing, named = _native.sweep_collect(path, paths)
    if missing:
        import warnings

        shown = ", ".join(named) + (", ..." if missing > len(named) else "")
        warnings.warn(f"{missing} cells of {path} have no result: {shown}", stacklevel=2)
    return table


def run(
    manifest: _Path,
    *,
    engine: Literal["local", "ray"] = "local",
    out: _Path | None = None,
    shard: str = "1/1",
    threads: int = 0,
    on_progress: Callable[[SweepProgress], object] | None = None,
    batch_s: float = 1.0,
    in_flight: int | None = None,
    retries: int = 20,
) -> SweepProgress:
    """Runs the cells of a manifest that have no result yet; results are appended as they come.

    ``engine="local"`` takes ``threads`` threads of this process (0: one a core). ``engine="ray"``
    takes the cluster that Ray is connected to, or starts one here: a task for each batch of about
    ``batch_s`` seconds on one core, at most ``in_flight`` of them at a time (twice the cores of the
    cluster, if left out), each run again up to ``retries`` times when its worker or node is lost.
    Machines and settings go once into Ray's object store, programs once each.

    ``out`` is the file of results; if left out it is named after the manifest. ``shard`` ``"i/n"``
    is the i-th of every n cells. ``on_progress`` is called after each batch and ends the run by
    answering ``False``; results so far are kept then, as they are after Ctrl-C.
    """
    for name, value, least in [("threads", threads, 0), ("retries", retries, 0)]:
        if value < least:
            raise OptionError(f"{name} is {value}; it has to be {least} or more", code="option")
    if not 0.01 <= batch_s <= 3600.0:
        raise OptionError(f"batch_s is {batch_s}; it has to be 0.01 to 3600", code="option")
    if in_flight is not None and in_flight < 1:
        raise OptionError(f"in_flight is {in_flight}; it has to be 1 or more", code="option")
    if engine not in ("local", "ray"):
        raise OptionError(f'there is no engine "{engine}"', code="option", hint="known: local, ray")
    ray = _ray() if engine == "ray" else None
    path = _there(manifest)
    driver = _native.SweepDriver(path, shard, _results_path(path, shard) if out is None else out)
    count = _Count(len(driver), on_progress)
    batches = _Batches(driver, batch_s)
    try:
        answers = _local(batches, threads) if ray is None else _on_ray(ray, batches, in_flight, retries)
        for answer in answers:
            count.add(*answer)
    finally:
        driver.close()
    return count.progress


def _ray() -> Any:
    try:
        import ray
    except ImportError:
        raise MissingPackage("ray is not installed", code="missing-package", hint="pip install ray") from None
    return ray


class _Count:
    """What is done, and who is told."""

    def __init__(self, cells: int, tell: Callable[[SweepProgress], object] | None) -> None:
        self.progress = SweepProgress(0, cells, 0, 0.0)
        self._tell = tell

    def add(self, cells: int, failed: int, simulated_s: float) -> None:
        now = self.progress
        self.progress = SweepProgress(
            now.done + cells, now.all, now.failed + failed, now.simulated_s + simulated_s
        )
        if self._tell is not None and self._tell(self.progress) is False:
            raise Cancelled("the run was cancelled", code="cancelled")


class _Batches:
    """Batches of cells of about a time, as the cells so far have taken it."""

    def __init__(self, driver: _native.SweepDriver, batch_s: float) -> None:
        self.driver = driver
        self.batch_s = batch_s
        self._cell_s: float | None = None

    def took(self, cells: int, seconds: float) -> None:
        """Learns from a batch that is done: newer cells are more like those that follow."""
        cell_s = seconds / max(cells, 1)
        self._cell_s = cell_s if self._cell_s is None else 0.7 * self._cell_s + 0.3 * cell_s

    def take(self, cores: int = 1) -> tuple[list[str], list[int]] | None:
        """The next batch for some cores: lines of cells and numbers of programs."""
        # Before anything is known: one cell a core.
        cells = cores
        if self._cell_s is not None:
            cells = int(cores * self.batch_s / max(self._cell_s, 1e-6))
        cells = min(max(cells, cores), _MOST_CELLS * cores)
        batch = self.driver.take(cells)
        return batch if batch[0] else None


# Of each batch that is done and kept: its cells, those without figures, the machine time, s.
_Answer = tuple[int, int, float]


def _local(batches: _Batches, threads: int) -> Iterator[_Answer]:
    cores = threads or os.cpu_count() or 1
    shared = batches.driver.shared()
    while (batch := batches.take(cores)) is not None:
        cells, programs = batch
        texts = [(index, batches.driver.program(index)) for index in programs]
        began = time.monotonic()
        failed, simulated_s = batches.driver.work(shared, texts, cells, threads)
        batches.took(len(cells), cores * (time.monotonic() - began))
        yield len(cells), failed, simulated_s


def _work(shared: bytes, numbers: list[int], cells: list[str], *programs: bytes) -> tuple[list[str], float]:
    """A task: lines of results, and the seconds that they took."""
    began = time.monotonic()
    texts = list(zip(numbers, programs, strict=True))
    lines = _native.sweep_work(shared, texts, cells, 1)
    return lines, time.monotonic() - began


def _on_ray(ray: Any, batches: _Batches, in_flight: int | None, retries: int) -> Iterator[_Answer]:
    if not ray.is_initialized():
        ray.init(log_to_driver=False)
    task = ray.remote(num_cpus=1, max_retries=retries)(_work)
    shared = ray.put(batches.driver.shared())
    texts: dict[int, Any] = {}
    flying = _Flying()
    cores = _Cores(ray)
    left = True
    try:
        while left or flying.batches:
            while left and len(flying.batches) < (in_flight or 2 * cores.now()):
                batch = batches.take()
                if batch is None:
                    left = False
                    break
                cells, programs = batch
                for index in programs:
                    if index not in texts:
                        texts[index] = ray.put(batches.driver.program(index))
                reference = task.remote(shared, programs, cells, *(texts[index] for index in programs))
                flying.add(reference, len(cells), programs[0])
                # Cells come program by program: what none in flight needs is let go.
                for index in [index for index in texts if index < flying.first_program()]:
                    del texts[index]
            if not flying.batches:
                break
            cells_done, answer = flying.wait()
            try:
                lines, seconds = answer.result()
            except ray.exceptions.RayTaskError as error:
                # What the task itself raised, as it would be raised here.
                cause = getattr(error, "cause", None)
                raise cause if isinstance(cause, Error) else error from None
            except ray.exceptions.RayError as error:
                raise Error(
                    f"a batch of {cells_done} cells was lost with its worker {retries + 1} times: {error}",
                    code="worker-lost",
                    hint="run again to go on; retries allows more",
                ) from error
            batches.took(cells_done, seconds)
            yield len(lines), *batches.driver.append(lines)
    finally:
        for reference, _, _ in flying.batches.values():
            ray.cancel(reference, force=True)


class _Flying:
    """Batches in flight. However many there are, adding one and waiting for one costs the same."""

    def __init__(self) -> None:
        # Each with its number of cells and of its first program, in the order in which they began.
        self.batches: OrderedDict[int, tuple[Any, int, int]] = OrderedDict()
        self._ended: SimpleQueue[tuple[int, Future[Any]]] = SimpleQueue()
        self._begun = 0

    def add(self, reference: Any, cells: int, program: int) -> None:
        number = self._begun
        self._begun += 1
        self.batches[number] = (reference, cells, program)
        # Told by a thread of Ray's.
        reference.future().add_done_callback(lambda future: self._ended.put((number, future)))

    def first_program(self) -> int:
        """Of the batch that began first: programs come in order."""
        return next(iter(self.batches.values()))[2]

    def wait(self) -> tuple[int, Future[Any]]:
        """The cells and the answer of the next that ends."""
        number, answer = self._ended.get()
        _, cells, _ = self.batches.pop(number)
        return cells, answer


class _Cores:
    """Cores of the cluster, which may grow and shrink; asked for once a second."""

    def __init__(self, ray: Any) -> None:
        self._ray = ray
        self._cores = 1
        self._asked: float | None = None

    def now(self) -> int:
        now = time.monotonic()
        if self._asked is None or now - self._asked >= 1.0:
            self._cores = max(int(self._ray.cluster_resources().get("CPU", 1)), 1)
            self._asked = now
        return self._cores
