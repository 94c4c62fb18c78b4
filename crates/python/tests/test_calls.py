"""Progress, cancelling, Ctrl-C, threads, pickling."""

from __future__ import annotations

import copy
import itertools
import os
import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

import lostmotion

SLOT = lostmotion.Program("G21 G90\nG1 X40 F900\nX0\nX40\nX0\nM2\n", "slot")
ARC = lostmotion.Program("G21 G90\nG0 X25\nG3 I-25 F2000\nM2\n", "arc")
# Half an hour of motion: nothing that is left behind is done within a test.
LONG = lostmotion.Program("G21 G90\nG91 F900\no1 repeat [900]\nG1 X30\nX-30\no1 endrepeat\nM2\n", "long")


def test_progress_is_told_and_reaches_the_end() -> None:
    seen: list[lostmotion.Progress] = []
    run = lostmotion.simulate(SLOT, on_progress=seen.append)
    assert seen and seen[-1].simulated_s >= run.plan.duration_s
    # What stands behind the end of a program is not read, and nothing is left to do.
    assert seen[-1].share == 1.0
    assert all(a.simulated_s <= b.simulated_s for a, b in itertools.pairwise(seen))


def test_a_progress_bar_fits() -> None:
    tqdm = pytest.importorskip("tqdm")
    with tqdm.tqdm(total=1.0, disable=False, file=open(os.devnull, "w")) as bar:
        lostmotion.simulate(SLOT, on_progress=lambda done: bar.update(done.share - bar.n))
        assert bar.n == pytest.approx(1.0)


def test_machines_take_what_numpy_has() -> None:
    machine = lostmotion.Machine.preset("vmc3")
    key = "axis.x.load.slide.gap_um"
    made = [
        machine.edit({key: gap}) for gap in (20, *np.arange(20, 40, 20), np.float32(20.0), np.array(20.0))
    ]
    assert len(set(made)) == 1 and made[0] != machine
    assert machine.edit(MappingProxyType({key: 20})) == made[0]
    assert hash(pickle.loads(pickle.dumps(made[0]))) == hash(made[0])


def test_false_ends_a_run() -> None:
    with pytest.raises(lostmotion.Cancelled) as caught:
        lostmotion.simulate(LONG, on_progress=lambda _done: False)
    assert caught.value.code == "cancelled"


def test_an_exception_of_the_callback_ends_a_run() -> None:
    def tell(_done: lostmotion.Progress) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        lostmotion.simulate(LONG, on_progress=tell)


@pytest.mark.parametrize(
    "call",
    [
        "lostmotion.simulate(program, methods=['none', 'fixed', 'adaptive', 'kalman'])",
        "lostmotion.plan(program, quality='optimal')",
        "lostmotion.simulate(program, compensators={'own': Own})",
        "lostmotion.Axis('paper', compensator=Own).push([0.0] * 4_000_000)",
        "list(program.operations(limits={'looped_blocks': 1e9}))",
    ],
)
def test_ctrl_c_is_heard(call: str) -> None:
    """A process of its own is interrupted in the middle; it says how long it took to hear of it."""
    code = textwrap.dedent(
        f"""
        import signal, threading, time, os
        import lostmotion

        class Own:
            def __init__(self, facts): pass
            def step(self, tick): return None

        program = lostmotion.Program(
            "G21 G90\\nG91 F900\\no1 repeat [400000]\\nG1 X30\\nX-30\\no1 endrepeat\\nM2\\n"
        )
        sent = []
        def press():
            time.sleep(0.7)
            sent.append(time.perf_counter())
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=press, daemon=True).start()
        try:
            {call}
        except KeyboardInterrupt:
            print("heard", time.perf_counter() - sent[0], flush=True)
            os._exit(0)
        print("not heard")
        """
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout.startswith("heard"), done.stdout + done.stderr
    # It takes 0 to 20 ms, and up to 100 where the machine has no core left; what waits for the end of
    # the work takes tens of seconds.
    assert float(done.stdout.split()[1]) < 2.0


def test_other_threads_go_on() -> None:
    """While a run goes on, this thread keeps Python's lock and counts."""
    done = threading.Event()

    def work() -> None:
        lostmotion.simulate(SLOT, methods=["none", "fixed"])
        done.set()

    thread = threading.Thread(target=work)
    count = 0
    thread.start()
    while not done.is_set():
        count += 1
        time.sleep(0)
    thread.join()
    assert count > 100


def test_runs_side_by_side_are_the_same() -> None:
    runs: list[str] = []
    threads = [
        threading.Thread(target=lambda: runs.append(lostmotion.simulate(SLOT, threads=1).to_json()))
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(runs) == 4 and len(set(runs)) == 1
    assert runs[0] == lostmotion.simulate(SLOT, threads=2).to_json()


def test_everything_can_be_pickled(tmp_path: Path) -> None:
    run = lostmotion.simulate(SLOT, methods=["none", "adaptive"], samples=True, motors=True, page=True)
    again = pickle.loads(pickle.dumps(run))
    assert again.to_dict() == run.to_dict()
    assert again.to_json() == run.to_json()
    assert (again.page, again.learned) == (run.page, run.learned)
    for name in ("blocks", "reversals", "samples", "motors"):
        before, after = getattr(run, name), getattr(again, name)
        assert before.columns == after.columns
        for column in before.columns:
            ours, theirs = before[column], after[column]
            assert ours.dtype == theirs.dtype
            assert ours.tobytes() == theirs.tobytes() if ours.dtype != object else (ours == theirs).all()
    machine = lostmotion.Machine.preset("vmc3").edit({"axis.x.load.slide.gap_um": 0.1 + 0.2})
    assert pickle.loads(pickle.dumps(machine)) == machine
    assert copy.deepcopy(machine) == machine
    program = pickle.loads(pickle.dumps(SLOT))
    assert (program.name, program.text) == (SLOT.name, SLOT.text)
    path = tmp_path / "part.ngc"
    path.write_text("G21\nM2\n")
    assert pickle.loads(pickle.dumps(lostmotion.Program.from_file(path))).name == str(path)
    with pytest.raises(lostmotion.ProgramError) as caught:
        lostmotion.simulate(lostmotion.Program("G1 X"))
    error = pickle.loads(pickle.dumps(caught.value))
    assert (str(error), error.code, error.line, error.findings) == (
        str(caught.value),
        caught.value.code,
        caught.value.line,
        caught.value.findings,
    )


def test_what_is_learned_goes_into_the_next_run() -> None:
    cold = lostmotion.simulate(SLOT, "vmc3-worn", method="adaptive")
    assert cold.learned is not None
    warm = lostmotion.simulate(SLOT, "vmc3-worn", method="adaptive", learned=cold.learned)
    assert warm.results[0].backlash.rms <= cold.results[0].backlash.rms


def test_interventions_change_the_time() -> None:
    usual = lostmotion.plan(SLOT)
    slow = lostmotion.plan(SLOT, interventions=[(0.5, "override", 0.5)])
    held = lostmotion.plan(SLOT, interventions=[(0.5, "hold"), (1.5, "resume")])
    assert slow.duration_s > usual.duration_s
    assert held.duration_s > usual.duration_s + 0.9


class Half:
    """Half the gap towards the commanded direction, at once."""

    def __init__(self, facts: lostmotion.compensators.AxisFacts) -> None:
        self.half = 0.5 * facts.gap_rad

    def step(self, tick: lostmotion.Tick) -> float:
        return self.half * float(np.sign(tick.velocity))


def test_a_compensator_in_python_is_the_same_on_an_axis_and_in_a_run() -> None:
    run = lostmotion.simulate(ARC, "vmc3-worn", methods=["none"], compensators={"half": Half}, samples=True)
    assert [result.method for result in run.results] == ["none", "half"]
    assert run["half"].backlash.rms < run["none"].backlash.rms
    again = lostmotion.simulate(ARC, "vmc3-worn", compensators={"half": Half}, threads=2)
    assert again.results[0].cutting == run["half"].cutting


def test_a_compensator_that_fails_ends_the_run() -> None:
    class Broken:
        def __init__(self, facts: lostmotion.compensators.AxisFacts) -> None:
            self.ticks = 0

        def step(self, tick: lostmotion.Tick) -> float:
            self.ticks += 1
            return 1.0 / (50 - self.ticks)

    with pytest.raises(ZeroDivisionError):
        lostmotion.simulate(LONG, compensators={"broken": Broken})
    axis = lostmotion.Axis("paper", compensator=Broken)
    with pytest.raises(ZeroDivisionError):
        axis.push(np.zeros(100))
    with pytest.raises(lostmotion.MethodError, match="has failed"):
        axis.push([0.0])


@pytest.mark.parametrize("answer", [float("nan"), float("inf"), "much"])
def test_corrections_that_are_none_are_refused(answer: object) -> None:
    class Odd:
        def __init__(self, facts: lostmotion.compensators.AxisFacts) -> None: ...

        def step(self, tick: lostmotion.Tick) -> object:
            return answer

    with pytest.raises((lostmotion.MethodError, AttributeError)):
        lostmotion.simulate(SLOT, compensators={"odd": Odd})  # type: ignore[dict-item]


def test_an_axis_steps_by_ticks_and_copies_go_on_alone() -> None:
    axis = lostmotion.Axis("vmc3:x")
    assert (axis.unit, axis.servo_ticks, axis.servo_period_s, axis.command_period_s) == (
        "mm",
        4,
        250e-6,
        1e-3,
    )
    positions = 2.0 * (1.0 - np.cos(np.arange(400) * 0.01))
    whole = axis.push(positions)
    single = lostmotion.Axis("vmc3:x")
    parts = [single.step(float(place)) for place in positions]
    for name in whole.columns:
        joined = np.concatenate([part[name] for part in parts])
        assert np.array_equal(joined, whole[name], equal_nan=True)
    other = axis.copy()
    assert np.array_equal(other.step(4.0)["load_mm"], axis.step(4.0)["load_mm"])


def test_signals_are_left_as_they_were() -> None:
    before = signal.getsignal(signal.SIGINT)
    lostmotion.simulate(SLOT)
    assert signal.getsignal(signal.SIGINT) is before
