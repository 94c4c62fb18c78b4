"""The parts of the add-on that need no FreeCAD: a job as G-code, machines, blocks out of tolerance."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import lostmotion
from lostmotion_freecad import JobError, JobProgram, check, errors, machine_of, program_of
from lostmotion_freecad.machine import find_machine


def command(name: str, **parameters: float) -> Any:
    return SimpleNamespace(Name=name, Parameters=parameters)


def path(*commands: Any) -> Any:
    return SimpleNamespace(Commands=list(commands))


def controller(number: int = 1, label: str = "TC") -> Any:
    tool = SimpleNamespace(Label="Mill (5 mm); long", Diameter=SimpleNamespace(Value=5.0))
    return SimpleNamespace(
        Label=label,
        ToolNumber=number,
        Tool=tool,
        Path=path(command("(TC)"), command("M6", T=float(number)), command("M3", S=8000.0)),
    )


def operation(label: str, *commands: Any, tool: Any = None, **more: Any) -> Any:
    tool = controller() if tool is None else tool
    return SimpleNamespace(Label=label, Path=path(*commands), ToolController=tool, **more)


def job_of(*operations: Any, **more: Any) -> Any:
    group = SimpleNamespace(Group=list(operations))
    return SimpleNamespace(Label="Job", Operations=group, Tools=SimpleNamespace(Group=[]), **more)


CIRCLE = (
    command("(Profile)"),
    command("G0", Z=5.0, F=0.0),
    command("G0", X=15.0, Y=0.0, F=99.0),
    command("G1", Z=-1.0, F=5.0),
    command("G3", X=15.0, Y=0.0, Z=-1.0, I=-15.0, J=5e-8, K=0.0, F=20.0),
    command("G1", X=15.0, Y=20.0, F=20.0),
)


def test_commands_become_lines() -> None:
    program = program_of(job_of(operation("Profile", *CIRCLE), Fixtures=["G55"]), " G64  P0.01 ")
    assert program.lines == [
        "G17 G21 G40 G49 G80 G90 G94",
        "G55",
        "G64 P0.01",
        "M6 T1",
        "M3 S8000",
        "G0 Z5",
        "G0 X15 Y0",
        "G1 Z-1 F300",
        "G3 X15 Y0 Z-1 I-15 J0 F1200",
        "G1 X15 Y20 F1200",
        "M2",
    ]
    places = [(place.operation, place.command) if place else None for place in program.origins]
    assert places == [None] * 3 + [("TC", 1), ("TC", 2)] + [("Profile", n) for n in range(1, 6)] + [None]
    assert program.origin(9) is not None and program.origin(0) is None and program.origin(99) is None
    assert program.tool_table == "T1 P1 D5 ; Mill (5 mm)  long\n"
    arc = program.moves[1]
    assert (arc.line, arc.start, arc.end) == (9, (15.0, 0.0, -1.0), (15.0, 0.0, -1.0))
    assert arc.centre == (0.0, 5e-8, -1.0) and arc.normal == (0.0, 0.0, 1.0)


def test_operations_have_their_tools() -> None:
    first, second = controller(1, "one"), controller(2, "two")
    dressed = SimpleNamespace(Label="Tags", Path=path(command("G1", X=3.0, F=10.0)))
    dressed.Base = operation("Profile", tool=second, Active=True)
    job = job_of(
        operation("A", command("G1", X=1.0, F=10.0), tool=first),
        operation("B", command("G1", X=2.0), tool=first),
        operation("off", command("G1", X=9.0, F=10.0), tool=second, Active=False),
        dressed,
    )
    program = program_of(job)
    moved = [line for line in program.lines if line[0] == "M" or "X" in line]
    assert moved == ["M6 T1", "M3 S8000", "G1 X1 F600", "G1 X2", "M6 T2", "M3 S8000", "G1 X3 F600", "M2"]
    assert program.remarks == ["1 operation(s) are not active and were left out."]
    twice = program_of(job_of(operation("A", command("G1", X=1.0, F=10.0)), Fixtures=["G54", "G55"]))
    assert "simulated once, at G54" in twice.remarks[0]


def test_planes_and_cycles_and_relative_moves() -> None:
    program = program_of(
        job_of(
            operation(
                "Op",
                command("G18"),
                command("G02", X=10.0, Z=0.0, I=5.0, J=0.0, K=0.0, F=10.0),
                command("G17"),
                command("G99"),
                command("G83", X=1.0, Y=2.0, Z=-5.0, R=2.0, Q=1.0, F=2.0),
                command("G83", X=4.0),
                command("G80"),
                command("G91"),
                command("G1", X=1.0, Z=1.0),
            )
        )
    )
    assert "G2 X10 Z0 I5 K0 F600" in program.lines
    assert "G83 X1 Y2 Z-5 R2 Q1 F120" in program.lines
    arc, first, second, last = program.moves
    assert arc.normal == (0.0, -1.0, 0.0) and arc.centre == (5.0, 0.0, 0.0)
    assert (first.start, first.end) == ((1.0, 2.0, 2.0), (1.0, 2.0, -5.0))
    assert (second.start, second.end) == ((4.0, 2.0, 2.0), (4.0, 2.0, -5.0))
    assert (last.start, last.end) == ((4.0, 2.0, 2.0), (5.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("job", "message"),
    [
        (None, "no CAM job"),
        (SimpleNamespace(Label="Box"), "no CAM job"),
        (job_of(), "has no operation"),
        (job_of(operation("A", *CIRCLE, Active=False)), "has no active operation"),
        (job_of(operation("A", command("G0", X=1.0))), "has no feed move"),
        (job_of(operation("Slot", command("G0", X=1.0), command("G1", X=2.0, F=0.0))), "Slot, command 1 (G1) has no feed"),
    ],
)  # fmt: skip
def test_jobs_that_cannot_be_cut(job: Any, message: str) -> None:
    with pytest.raises(JobError) as refused:
        program_of(job)
    assert message in refused.value.message and refused.value.hint


def test_blocks_are_those_of_the_library() -> None:
    program = program_of(job_of(operation("Profile", *CIRCLE)))
    told: list[float] = []
    result = check(program, machine_of("vmc3-worn"), "none", 20.0, told.append)
    run = lostmotion.simulate(lostmotion.Program(program.text), "vmc3-worn", method="none", tolerance_um=20.0)
    lines = run.blocks["line"].tolist()
    # Each line that cuts makes one block here.
    assert [block.line for block in result.blocks] == [
        line for line, rapid in zip(lines, run.blocks["rapid"], strict=True) if not rapid
    ]
    for block in result.blocks:
        row = run.blocks.row(lines.index(block.line))
        assert (block.error_um, block.backlash_um, block.cause) == (
            row["max_um"],
            row["backlash_um"],
            row["cause"],
        )
        assert block.operation == "Profile" and program.lines[block.line - 1] == block.text
        assert block.command == CIRCLE.index(CIRCLE[block.command])
    assert result.max_um == run.results[0].cutting.max == max(abs(block.error_um) for block in result.blocks)
    assert result.outside and abs(result.outside[0].error_um) == result.max_um
    assert all(abs(block.error_um) > 20.0 for block in result.outside)
    assert f"{len(result.outside)} of {len(result.blocks)} blocks are out of tolerance" in result.summary
    assert told and told[-1] <= 1.0
    assert result.tolerance_um == 20.0 and result.source == "vmc3-worn"


def test_wrong_lines_name_their_operation() -> None:
    program = program_of(job_of(operation("Profile", *CIRCLE, command("G1", X=9000.0))))
    with pytest.raises(JobError, match=r"Profile, command 6, G1 X9000: ") as refused:
        check(program, machine_of("vmc3"))
    assert refused.value.hint
    good = program_of(job_of(operation("Profile", *CIRCLE)))
    with pytest.raises(JobError, match="was ended"):
        check(good, machine_of("vmc3"), on_progress=lambda share: False)
    with pytest.raises(JobError, match="above 0"):
        check(good, machine_of("vmc3"), tolerance_um=0.0)
    with pytest.raises(JobError, match="nome"):
        check(good, machine_of("vmc3"), "nome")
    with pytest.raises(JobError):
        check(JobProgram("empty"), machine_of("vmc3"))


def fcm(name: str, joint: object) -> str:
    """A machine as FreeCAD writes it, its joints in one of both forms."""
    axis = {
        "type": "linear",
        "role": "table_linear",
        "parent": None,
        "sequence": 0,
        "joint": joint,
        "limits": {"min": -120.0, "max": 120.0},
        "max_velocity": 9000,
    }
    axes = {letter: axis for letter in "XYZ"}
    return json.dumps(
        {"freecad_version": "1.2.0", "machine": {"name": name, "axes": axes, "units": "metric"}}
    )


@pytest.mark.parametrize("joint", [[[0, 0, 0], [1, 0, 0]], {"origin": [0, 0, 0], "axis": [1, 0, 0]}])
def test_machines_of_freecad(tmp_path: Path, joint: object) -> None:
    file = tmp_path / "My_Mill.fcm"
    file.write_text(fcm("Mill 3", joint))
    taken = machine_of(str(file))
    limits = taken.machine.to_dict()["axis"]["y"]["limits"]
    assert (limits["min_mm"], limits["max_mm"], limits["velocity_mm_s"]) == (-120.0, 120.0, 150.0)
    assert "does not say" in taken.remarks[0] and "gaps above all" in taken.remarks[0]
    assert lostmotion.Machine.from_toml(taken.toml) == taken.machine
    # By name in a folder: that in the file, that of the file.
    for name in ("mill 3", "My_Mill", "My Mill"):
        assert find_machine(name, [str(tmp_path / "missing"), str(tmp_path)]) == str(file)
    assert find_machine("other", [str(tmp_path)]) is None


def test_machines_that_do_not_hold(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.fcm"
    wrong.write_text('{"machine": {"axes": {"X": {"limits": {"min": "zero", "max": 5}}}}}')
    with pytest.raises(JobError, match=r"line 1: .*number"):
        machine_of(str(wrong))
    wrong.write_text("not a machine")
    with pytest.raises(JobError, match="wrong.fcm"):
        machine_of(str(wrong))
    with pytest.raises(JobError, match="cannot be read"):
        machine_of(str(tmp_path / "missing.fcm"))
    with pytest.raises(JobError, match="vmc99"):
        machine_of("vmc99")
    own = tmp_path / "own.toml"
    own.write_text("name = 3\n")
    with pytest.raises(JobError, match=r"line 1"):
        machine_of(str(own))
    own.write_text(lostmotion.Machine.preset("bench3").to_toml())
    assert machine_of(str(own)).machine == lostmotion.Machine.preset("bench3")
    assert machine_of(" ").source == "vmc3"


def test_the_package_may_be_missing_or_old(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lostmotion, "__version__", "0.0.9")
    with pytest.raises(JobError, match=r"is 0\.0\.9 .* needs 0\.1 or newer"):
        machine_of("vmc3")

    def missing(name: str) -> Any:
        raise ImportError(f"No module named '{name}'")

    monkeypatch.setattr("importlib.import_module", missing)
    with pytest.raises(JobError, match="cannot be loaded") as refused:
        machine_of("vmc3")
    assert "pip install" in refused.value.hint
    assert errors.release("1.10.2-rc1") == (1, 10, 2) and math.isfinite(errors.release("x")[0])
