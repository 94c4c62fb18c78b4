"""Sweeps in this process: the command's files and figures, progress, what is refused."""

from __future__ import annotations

import builtins
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path
from typing import Any

import pytest

import lostmotion
from conftest import Command
from lostmotion import sweep

FILE = """
programs = ["part.ngc"]
machines = ["bench3"]
methods = ["none", "fixed"]

[[vary]]
name = "gap_um"
keys = ["axis.x.load.slide.gap_um"]
from = 0
to = 40
steps = 12
"""


@pytest.fixture
def manifest(tmp_path: Path) -> Path:
    (tmp_path / "part.ngc").write_text("G21 G90 G64 P0.005\nG0 X10 Y0\nG1 X0 Y10 F2000\nX10 Y0\nM2\n")
    (tmp_path / "sweep.toml").write_text(FILE)
    assert sweep.plan(tmp_path / "sweep.toml", tmp_path / "sweep.jsonl") == 12
    return tmp_path / "sweep.jsonl"


def test_results_are_those_of_the_command(manifest: Path, command: Command) -> None:
    seen: list[sweep.SweepProgress] = []
    done = sweep.run(manifest, on_progress=seen.append, batch_s=0.01)
    assert (done.done, done.all, done.failed) == (12, 12, 0) and seen[-1] == done and len(seen) > 1
    # The command finds nothing left, and makes the same.
    command("study", "sweep", "run", manifest, "--out", manifest.with_name("theirs.jsonl"))
    ours = manifest.with_name("sweep.results.jsonl").read_text().splitlines()
    assert sorted(ours) == sorted(manifest.with_name("theirs.jsonl").read_text().splitlines())
    table = sweep.collect(manifest)
    assert len(table) == 24 and list(table["method"][:2]) == ["none", "fixed"]
    assert sweep.run(manifest).all == 0


def test_hyperqueue_runs_the_script(manifest: Path, command: Command) -> None:
    pytest.importorskip("hyperqueue")
    script = manifest.with_name("job.sh")
    script.write_text(command("study", "sweep", "emit", "hq", manifest, "--shards", "4"))
    programs = manifest.with_name("bin")
    programs.mkdir()
    (programs / "lostmotion").symlink_to(Path(os.environ["LOSTMOTION"]).resolve())
    runner = Path(__file__).parents[3] / ".ci/hq"
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"
    subprocess.run(
        [sys.executable, runner, script, "2"],
        cwd=manifest.parent,
        env={**os.environ, "PATH": path},
        check=True,
        timeout=600,
    )
    shards = sorted(manifest.parent.glob("sweep.results-*-of-4.jsonl"))
    assert [len(shard.read_text().splitlines()) for shard in shards] == [3, 3, 3, 3]
    theirs = sweep.collect(manifest, list(shards))
    sweep.run(manifest)
    assert theirs.to_pandas().equals(sweep.collect(manifest).to_pandas())


def test_dask_runs_the_script(manifest: Path, command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed")
    script = manifest.with_name("job.py")
    with monkeypatch.context() as there:
        there.chdir(manifest.parent)
        script.write_text(command("study", "sweep", "emit", "dask", manifest.name, "--shards", "3"))
    programs = manifest.with_name("bin")
    programs.mkdir()
    (programs / "lostmotion").symlink_to(Path(os.environ["LOSTMOTION"]).resolve())
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")

    def run() -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, script, cluster.scheduler_address],
            cwd=manifest.parent,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )

    # A worker is somewhere else: the folder is the one in which the script is started.
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=None) as cluster:
        done = run()
        assert "3 of 3 shards" in done.stdout, done.stderr
        shards = sorted(manifest.parent.glob("sweep.results-*-of-3.jsonl"))
        assert [len(shard.read_text().splitlines()) for shard in shards] == [4, 4, 4]
        manifest.with_name("part.ngc").write_text("M2\n")
        for shard in shards:
            shard.unlink()
        assert "has changed since the plan" in run().stderr


def test_a_run_that_is_ended_goes_on(manifest: Path) -> None:
    with pytest.raises(lostmotion.Cancelled):
        sweep.run(manifest, shard="1/2", threads=1, batch_s=0.01, on_progress=lambda _done: False)
    results = manifest.with_name("sweep.results-1-of-2.jsonl")
    first = results.read_text()
    assert 0 < first.count("\n") < 6
    assert sweep.run(manifest, shard="1/2").done == 6 - first.count("\n")
    assert results.read_text().startswith(first)
    with pytest.warns(UserWarning, match="6 cells"):
        assert len(sweep.collect(manifest)) == 12


def test_ctrl_c_is_heard_and_nothing_is_lost(manifest: Path) -> None:
    text = FILE.replace("steps = 12", "steps = 4000")
    manifest.with_name("sweep.toml").write_text(text)
    sweep.plan(manifest.with_name("sweep.toml"), manifest)
    script = f"""
        from lostmotion import sweep
        tell = lambda done: print("going", flush=True)
        sweep.run({str(manifest)!r}, batch_s=0.1, on_progress=tell)
    """
    child = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert child.stdout is not None and child.stdout.readline() == b"going\n"
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=60)
    assert b"KeyboardInterrupt" in said
    lines = manifest.with_name("sweep.results.jsonl").read_text()
    assert lines.endswith("\n") and 0 < lines.count("\n") < 4000


def test_a_kill_repeats_the_cells_in_flight_alone(manifest: Path) -> None:
    """A batch of an hour: each cell is kept as soon as it is finished."""
    text = FILE.replace("steps = 12", "steps = 3000")
    manifest.with_name("sweep.toml").write_text(text)
    sweep.plan(manifest.with_name("sweep.toml"), manifest)
    script = f"from lostmotion import sweep; sweep.run({str(manifest)!r}, threads=2, batch_s=3600)"
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    results = manifest.with_name("sweep.results.jsonl")
    # The first batch is of a cell for each thread, the second has the most that one may have.
    while child.poll() is None and (not results.exists() or results.read_text().count("\n") < 20):
        time.sleep(0.01)
    child.kill()
    child.communicate()
    assert 20 <= results.read_text().count("\n") < 3000


def test_what_is_wrong_is_an_exception(manifest: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong: list[dict[str, Any]] = [
        {"engine": "slurm"},
        {"threads": -1},
        {"retries": -1},
        {"batch_s": float("nan")},
        {"batch_s": 0.0},
        {"in_flight": 0},
        {"shard": "3/2"},
    ]
    for named in wrong:
        with pytest.raises(lostmotion.OptionError):
            sweep.run(manifest, **named)
    with pytest.raises(lostmotion.OptionError):
        sweep.plan(manifest.with_name("sweep.toml"), manifest, most_cells=0)
    with pytest.raises(lostmotion.DataError, match="more than 5 cells"):
        sweep.plan(manifest.with_name("sweep.toml"), manifest, most_cells=5)
    with pytest.raises(lostmotion.DataError, match="no results"):
        sweep.collect(manifest)
    manifest.with_name("part.ngc").write_text("M2\n")
    with pytest.raises(lostmotion.DataError, match="has changed since the plan"):
        sweep.run(manifest)

    real = builtins.__import__

    def without_ray(name: str, *rest: Any, **named: Any) -> Any:
        if name == "ray":
            raise ImportError(name)
        return real(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", without_ray)
    with pytest.raises(lostmotion.MissingPackage, match="ray is not installed"):
        sweep.run(manifest, engine="ray")
