"""Every figure equals the command's, to the bit."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest

import lostmotion
import make_results
from conftest import Command

RUNS = [
    ("circle_r50.ngc", "vmc3", ["none", "fixed", "adaptive"], {}),
    ("square_rounded.ngc", "vmc3-worn", ["none", "lookup"], {"tolerance_um": 12.0}),
    ("trunnion_cone.ngc", "trunnion5", ["none", "fixed"], {"cutting_force_n": 100.0}),
]


def flags(options: dict[str, Any]) -> list[str]:
    return [text for name, value in options.items() for text in (f"--{name.replace('_', '-')}", str(value))]


@pytest.mark.parametrize(("part", "machine", "methods", "options"), RUNS)
def test_comparisons(
    command: Command,
    parts: Path,
    tmp_path: Path,
    part: str,
    machine: str,
    methods: list[str],
    options: dict[str, Any],
) -> None:
    out = tmp_path / "out"
    path = parts / part
    told = command(
        "simulate", path, "-m", machine, "--methods", ",".join(methods), "--format", "json",
        "--out", out, "--trace", "--trace-motors", "--trace-format", "parquet", *flags(options),
    )  # fmt: skip
    run = lostmotion.simulate(
        str(path), machine, methods=methods, samples=True, motors=True, page=True, **options
    )
    assert run.to_json() == told
    # Typed values are the same figures, in full.
    rounded = json.loads(told)
    for result, figures in zip(run.results, rounded["results"], strict=True):
        assert round(result.cutting.max, 4) == figures["cutting"]["max"]
        assert len(result.worst_blocks) == len(figures["worst_blocks"])
    # Samples are those of the trace, bit by bit.
    for name, table in (("contour", run.samples), ("motors", run.motors)):
        trace = pyarrow.parquet.read_table(out / f"{name}.parquet")
        assert trace.column_names == table.columns
        assert trace.num_rows == len(table)
        for column in table.columns:
            theirs = trace[column].to_numpy()
            if theirs.dtype == np.float64:
                assert np.array_equal(theirs, table[column], equal_nan=True), column
            else:
                assert (theirs == table[column]).all(), column
    assert_same_csv(out / "blocks.csv", run.blocks)
    assert_same_csv(out / "reversals.csv", run.reversals)
    assert (out / "comparison.txt").read_text() == run.to_text()


def test_one_method(command: Command, parts: Path) -> None:
    path = parts / "engraving.ngc"
    told = command("simulate", path, "-m", "vmc3", "--method", "fixed", "--format", "json")
    assert lostmotion.simulate(str(path), "vmc3", method="fixed").to_json() == told
    told = command("simulate", path, "-m", "vmc3", "--format", "json")
    assert lostmotion.simulate(str(path), "vmc3").to_json() == told


def test_pages(command: Command, parts: Path, tmp_path: Path) -> None:
    path, page = parts / "circle_r10.ngc", tmp_path / "page.html"
    command("simulate", path, "--methods", "none,fixed", "--html", page)
    run = lostmotion.simulate(str(path), methods=["none", "fixed"], page=True)
    assert run.page == page.read_text(encoding="utf-8")


def test_changes_of_the_machine(command: Command, parts: Path) -> None:
    path = parts / "circle_r10.ngc"
    changes = {"axis.x.load.slide.gap_um": 25.0, "simulate.tolerance_um": 15}
    told = command(
        "simulate", path, "--method", "none", "--format", "json",
        *(text for key, value in changes.items() for text in ("--set", f"{key}={value}")),
    )  # fmt: skip
    machine = lostmotion.Machine.preset("vmc3").edit(changes)
    assert lostmotion.simulate(str(path), machine, method="none").to_json() == told


@pytest.mark.parametrize(
    ("part", "machine"), [("square_sharp.ngc", "vmc3"), ("trunnion_cone.ngc", "trunnion5")]
)
def test_plans(command: Command, parts: Path, tmp_path: Path, part: str, machine: str) -> None:
    out = tmp_path / "plan.csv"
    command("plan", parts / part, "-m", machine, "--out", out)
    plan = lostmotion.plan(parts / part, machine)
    assert_same_csv(out, plan.samples)
    # Rates are those of the positions: central differences leave what a step of jerk makes.
    samples = plan.samples
    speed = np.diff(samples["x_mm"]) / 1e-3
    mean = 0.5 * (samples["x_velocity_mm_s"][1:] + samples["x_velocity_mm_s"][:-1])
    assert np.abs(speed - mean).max() < 0.05
    assert plan.duration_s == pytest.approx(plan.samples["t_s"][-1], abs=2e-3)


def test_axes(command: Command, tmp_path: Path) -> None:
    time = np.arange(1500) * 1e-3
    position = 5.0 * (1.0 - np.cos(2.0 * np.pi * time / 0.5))
    setpoints, out = tmp_path / "setpoints.csv", tmp_path / "axis.csv"
    with open(setpoints, "w") as file:
        file.write("t_s,position\n")
        file.writelines(f"{t:.3f},{p!r}\n" for t, p in zip(time, position.tolist(), strict=True))
    for method in ("none", "fixed"):
        command("axis", "run", "--setpoints", setpoints, "--axis", "vmc3:x", "--method", method, "--out", out)
        axis = lostmotion.Axis("vmc3:x", method=method, start=float(position[0]))
        assert_same_csv(out, axis.push(position))


def log_of(tmp_path: Path) -> Path:
    """A log of an axis that is moved to and fro with several accelerations."""
    time = np.arange(12_000) * 1e-3
    position = 8.0 * np.sin(2.0 * np.pi * 0.4 * time) + 1.5 * np.sin(2.0 * np.pi * 1.7 * time)
    axis = lostmotion.Axis("vmc3-worn:x")
    trace = axis.push(position)
    path = tmp_path / "log.csv"
    every = slice(0, None, axis.servo_ticks)
    columns = [trace[name][every].tolist() for name in ("t_s", "motor_mm", "load_mm", "current_a")]
    with open(path, "w") as file:
        file.write("t_s,motor_mm,load_mm,current_a\n")
        file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*columns, strict=True))
    return path


def test_fits(command: Command, tmp_path: Path) -> None:
    log, out = log_of(tmp_path), tmp_path / "fit.json"
    command("axis", "fit", log, "--axis", "vmc3-worn:x", "--out", out)
    fit = lostmotion.fit(log, "vmc3-worn:x")
    assert fit.json == out.read_text()
    # The gap of the machine lies in the interval.
    gap_mm = 0.04
    assert fit.gap_interval[0] <= gap_mm <= fit.gap_interval[1]
    # Columns give the same as the file.
    rows = np.loadtxt(log, delimiter=",", skiprows=1)
    names = ("time_s", "motor", "load", "current_a")
    columns = dict(zip(names, rows.T, strict=True))
    assert lostmotion.fit(columns, "vmc3-worn:x").gap == fit.gap
    found = lostmotion.identify(log)
    assert found["body"]["inertia"]["value"] > 0.0
    # No crossing of this motion shows a load that rests: the motor alone does not tell the gap.
    with pytest.raises(lostmotion.DataError, match="does not excite the gap"):
        lostmotion.fit(log, "vmc3-worn:x", motor_only=True)


def test_texts(command: Command, parts: Path) -> None:
    path = parts / "parameters.ngc"
    program = lostmotion.Program.from_file(path)
    canon = "".join(f"{found.text}\n" for found in program.operations())
    assert canon == command("gcode", "canon", path)
    assert program.format(case="lower", indent=4) == command(
        "gcode", "format", path, "--case", "lower", "--indent", 4
    )
    explained = program.explain(5)
    assert explained.text.rstrip() == command("gcode", "explain", f"{path}:5").rstrip()
    assert program.resolved() == command("gcode", "write", path)


def test_findings(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "wrong.ngc"
    path.write_text("G21 G90\nG1 X10\nG2 X20 R3 F100\nG1 Z-\n")
    done = json.loads(_findings(command, path))
    program = lostmotion.Program.from_file(path)
    found = program.lint()
    assert [(one.code, one.line, one.column, one.message) for one in found] == [
        (one["code"], one["span"]["line"], one["span"]["column"], one["message"]) for one in done["findings"]
    ]


def _findings(command: Command, path: Path) -> str:
    import os
    import subprocess

    program = os.environ["LOSTMOTION"]
    done = subprocess.run(
        [program, "gcode", "lint", str(path), "--format", "json"], capture_output=True, text=True, check=False
    )
    return done.stdout


def assert_same_csv(path: Path, table: lostmotion.Table) -> None:
    """Cells of a CSV are the values of a table, rounded to the decimals of the cell."""
    with open(path, newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        cells = list(rows)
    assert len(cells) == len(table)
    for place, name in enumerate(names):
        values = table[name]
        for row, value in zip(cells, values.tolist(), strict=True):
            cell = row[place]
            if isinstance(value, float):
                if cell == "" or not math.isfinite(value):
                    assert cell == "" and not math.isfinite(value)
                    continue
                decimals = len(cell.partition(".")[2])
                # Half a unit in the last decimal of the cell, and what a float of it is off by.
                assert abs(float(cell) - value) <= 0.5000001 * 10.0**-decimals + 1e-15 * abs(value), (
                    name,
                    cell,
                    value,
                )
            else:
                assert cell == str(value), (name, cell, value)


def test_typed_results_are_those_of_the_schema() -> None:
    assert make_results.results() == make_results.TARGET.read_text(), "run crates/python/make_results.py"
