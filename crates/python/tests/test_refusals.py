"""Bad input is refused with a code, a place and a hint; nothing is lost."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import lostmotion
from lostmotion.errors import Finding

SLOT = lostmotion.Program("G21 G90\nG1 X40 F900\nM2\n", "slot")


def refused(kind: type[lostmotion.Error], call: Any) -> lostmotion.Error:
    with pytest.raises(kind) as caught:
        call()
    return caught.value


def test_errors_of_a_program_have_their_places() -> None:
    program = lostmotion.Program("G21 G90\nG1 X40 F600\nG1 Z-\nG1 Q\nM2\n", "part.ngc")
    error = refused(lostmotion.ProgramError, lambda: lostmotion.simulate(program))
    assert (error.file, error.line) == ("part.ngc", 3)
    assert error.column is not None and error.column > 1
    assert len(error.findings) >= 2 and all(isinstance(found, Finding) for found in error.findings)
    assert error.findings[0].excerpt == "G1 Z-"
    assert isinstance(error, ValueError)
    with pytest.raises(lostmotion.ProgramError):
        list(program.operations())


def test_a_part_that_does_not_fit() -> None:
    far = lostmotion.Program("G21 G90\nG0 X400\nM2\n")
    error = refused(lostmotion.ProgramError, lambda: lostmotion.simulate(far))
    assert (error.code, error.line) == ("outside-travel", 2)
    assert "move the origin of G54" in error.hint
    rotary = lostmotion.Program("G21 G90\nG0 A90\nM2\n")
    assert refused(lostmotion.ProgramError, lambda: lostmotion.simulate(rotary)).code == "no-axis"
    empty = lostmotion.Program("M2\n")
    assert refused(lostmotion.ProgramError, lambda: lostmotion.simulate(empty)).code == "empty"


def test_machines() -> None:
    error = refused(lostmotion.MachineError, lambda: lostmotion.Machine.preset("vcm3"))
    assert "did you mean `vmc3`?" in error.hint
    machine = lostmotion.Machine.preset("vmc3")
    error = refused(lostmotion.MachineError, lambda: machine.edit({"axis.x.drive.position_gain_per_s": -1.0}))
    assert error.findings[0].values["key"] == "axis.x.drive.position_gain_per_s"
    error = refused(lostmotion.MachineError, lambda: machine.edit({"axis.x.drive.position_gian": 30}))
    assert "unknown key" in str(error)
    error = refused(lostmotion.MachineError, lambda: machine.edit({"simulate.tolerance_um": float("nan")}))
    assert "finite" in str(error)
    refused(lostmotion.MachineError, lambda: machine.edit({"axis.x.load.slide.gap_um": "wide"}))
    error = refused(
        lostmotion.MachineError, lambda: lostmotion.Machine.from_toml("name = 3\n[axis", "my.toml")
    )
    assert error.file == "my.toml" and error.line is not None
    found = lostmotion.Machine.problems("name = 3\n", "my.toml")
    assert found and found[0].file == "my.toml"
    assert lostmotion.Machine.problems(machine.to_toml()) == []


def test_files_that_are_not_there(tmp_path: Path) -> None:
    for call in (
        lambda: lostmotion.simulate(tmp_path / "no.ngc"),
        lambda: lostmotion.Program.from_file(tmp_path / "no.ngc"),
        lambda: lostmotion.Machine.from_file(tmp_path / "no.toml"),
        lambda: lostmotion.simulate(SLOT, tmp_path / "no.toml"),
        lambda: lostmotion.import_machine(tmp_path / "no.ini"),
    ):
        with pytest.raises(FileNotFoundError):
            call()
    with pytest.raises(OSError):
        lostmotion.Program.from_file(tmp_path)
    for reads in (
        lambda: lostmotion.fit(tmp_path / "no.csv"),
        lambda: lostmotion.identify(tmp_path / "no.csv"),
        lambda: lostmotion.sweep.run(tmp_path / "no.jsonl"),
        lambda: lostmotion.sweep.collect(tmp_path / "no.jsonl"),
    ):
        with pytest.raises(FileNotFoundError):
            reads()


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"tolerance_um": -1.0}, "tolerance_um"),
        ({"tolerance_um": float("nan")}, "tolerance_um"),
        ({"tolerance_um": "ten"}, "not understood"),
        ({"cutting_force_n": float("inf")}, "cutting_force_n"),
        ({"sensitivity": 100.0}, ""),
        ({"threads": 100_000}, ""),
        ({"threads": -1}, "not understood"),
        ({"quality": "best"}, "not understood"),
        ({"control": "fanuk"}, ""),
        ({"dialect": "fanuk"}, "did you mean"),
        ({"accept": ["nonsense"]}, "nonsense"),
        ({"accept": "nonsense"}, "has to be a list"),
        ({"limits": {"nonsense": 1.0}}, "nonsense"),
        ({"m_codes": {"X1": "ignore"}}, "M code"),
        ({"m_codes": {"M100": "dance"}}, "M100"),
        ({"interventions": [(1.0, "dance")]}, "no action"),
        ({"interventions": [(1.0, "override", 9.0)]}, ""),
        ({"interventions": [(-1.0, "hold")]}, ""),
        ({"subroutines": ["/no/such/folder"]}, "/no/such/folder"),
        ({"max_duration_s": 0.5}, "longer than"),
        ({"tolerance": 1.0}, 'there is no keyword "tolerance"\nhint: did you mean `tolerance_um`?'),
        ({"treads": 1}, "did you mean `threads`?"),
        ({"methods": "none"}, "has to be a list"),
        ({"methods": ["none", "none"]}, "twice"),
        ({"method": "none", "methods": ["none"]}, "both"),
    ],
)
def test_settings(settings: dict[str, Any], told: str) -> None:
    error = refused(lostmotion.OptionError, lambda: lostmotion.simulate(SLOT, **settings))
    assert told in str(error)


@pytest.mark.parametrize("answer", [True, np.True_, "half", (0.1, 0.0), np.zeros(2), object()])
def test_what_is_no_correction(answer: Any) -> None:
    class Own:
        def __init__(self, facts: Any) -> None: ...
        def step(self, tick: Any) -> Any:
            return answer

    error = refused(lostmotion.MethodError, lambda: lostmotion.simulate(SLOT, compensators={"own": Own}))
    assert error.code == "correction" and "an angle in rad" in error.hint


def test_methods() -> None:
    error = refused(lostmotion.MethodError, lambda: lostmotion.simulate(SLOT, method="fixd"))
    assert "did you mean" in str(error)
    refused(lostmotion.MethodError, lambda: lostmotion.Axis("paper", method="fixd"))
    refused(lostmotion.MachineError, lambda: lostmotion.simulate(SLOT, learned="version = 9"))


@pytest.mark.parametrize(
    ("values", "code"),
    [
        (np.zeros((3, 2)), "shape"),
        (5.0, "shape"),
        ([0.0, float("nan")], "not-finite"),
        ([0.0, float("inf")], "not-finite"),
        (["a", "b"], "dtype"),
        ([[0.0], [1.0, 2.0]], "dtype"),
        (["0.0", "1.0"], "dtype"),
        ([0.0, 1.0j], "dtype"),
        (np.array(["2026-01-01", "2026-01-02"], dtype="datetime64[s]"), "dtype"),
        (np.ma.masked_greater([0.0, 1.0], 0.5), "not-finite"),
        (None, "shape"),
    ],
)
def test_arrays(values: Any, code: str) -> None:
    axis = lostmotion.Axis("paper")
    error = refused(lostmotion.DataError, lambda: axis.push(values))
    assert error.code in (code, "not-finite")
    # The axis has not moved.
    assert axis.push([0.0])["t_s"][0] == 0.0


def test_arrays_of_any_layout() -> None:
    places = np.zeros((50, 3), order="C")
    places[:, 1] = np.linspace(0.0, 0.5, 50)
    strided, reverse = places[:, 1], places[::-1, 1][::-1]
    assert not strided.flags.c_contiguous
    expected = lostmotion.Axis("paper").push(strided.copy())["load_rad"]
    for layout in (strided, reverse, strided.tolist(), strided.astype(">f8"), strided.astype(np.longdouble)):
        assert np.array_equal(lostmotion.Axis("paper").push(layout)["load_rad"], expected)


def test_columns_of_other_lengths() -> None:
    axis = lostmotion.Axis("paper")
    error = refused(lostmotion.DataError, lambda: axis.push([0.0, 0.0], velocity=[0.0]))
    assert error.code == "shape" and "velocity has 1 values" in str(error)
    log = {"time_s": [0.0, 1e-3], "motor": [0.0, 0.0], "load": [0.0], "current_a": [0.0, 0.0]}
    refused(lostmotion.DataError, lambda: lostmotion.fit(log))
    refused(lostmotion.DataError, lambda: lostmotion.fit({"motor": [0.0]}))
    refused(lostmotion.DataError, lambda: lostmotion.fit({**log, "load": [0.0, 0.0], "speed": [0.0, 0.0]}))
    error = refused(
        lostmotion.DataError, lambda: lostmotion.identify({"time_s": [0.0, 1e-3], "motor": [0.0, 0.0]})
    )
    assert str(error)


def test_logs_of_other_kinds() -> None:
    others: list[Any] = [None, 3, np.zeros((3, 4)), pd.DataFrame({"time_s": [0.0]})]
    for other in others:
        error = refused(lostmotion.DataError, partial(lostmotion.fit, other))
        assert type(other).__name__ in str(error) and "time_s" in error.hint
    log = {"time_s": [0.0, 1e-3], "motor": [0.0, 0.0], "current_a": [0.0, 0.0]}
    error = refused(lostmotion.DataError, lambda: lostmotion.identify({**log, "drive": [0.0, 0.0]}))
    assert "both current_a and drive" in str(error)
    # What `fit` takes, `identify` takes.
    assert "no column" not in str(refused(lostmotion.DataError, lambda: lostmotion.identify(log)))


def test_units() -> None:
    places = 8.0 * np.sin(3.0 * np.arange(8000) * 1e-3)
    trace = lostmotion.Axis(lostmotion.Machine.preset("vmc3-worn"), "x").push(places)
    slow = {"time_s": trace["t_s"], "motor": trace["motor_mm"], "load": trace["load_mm"]}
    milli = {**slow, "current_a": 1e3 * trace["current_a"]}
    error = refused(lostmotion.DataError, lambda: lostmotion.fit(milli, "vmc3-worn:x"))
    assert "milliamperes" in str(error)
    time = np.arange(100) * 1e-3
    log = {"time_s": time, "motor": time, "load": time, "current_a": time}
    error = refused(lostmotion.DataError, lambda: lostmotion.fit(log, unit="inch"))
    assert "inch" in str(error) and "mm" in error.hint
    error = refused(lostmotion.DataError, lambda: lostmotion.fit(log, "paper", unit="mm"))
    assert "the positions are in mm, but the axis is in rad" in str(error)
    refused(lostmotion.OptionError, lambda: lostmotion.Axis("no such axis"))
    refused(lostmotion.OptionError, lambda: lostmotion.Axis(lostmotion.Machine.preset("vmc3")))
    refused(lostmotion.OptionError, lambda: lostmotion.Axis(lostmotion.Machine.preset("vmc3"), "q"))


def test_lints_have_levels() -> None:
    program = lostmotion.Program("G21 G90\nG1 X40\nM2\n")
    found = program.lint()
    assert found and all(str(one) for one in found)
    assert program.lint(levels={"all": "allow"}) == program.diagnostics()
    refused(lostmotion.OptionError, lambda: program.lint(levels={"nonsense": "warn"}))
    refused(lostmotion.OptionError, lambda: program.lint(levels={"all": "loud"}))  # type: ignore[dict-item]
    refused(lostmotion.OptionError, lambda: program.explain(99))
    refused(lostmotion.OptionError, lambda: program.format(case="title"))  # type: ignore[arg-type]


def test_imports(tmp_path: Path) -> None:
    path = tmp_path / "mill.ini"
    path.write_text("[KINS]\nKINEMATICS = trivkins\n#INCLUDE x.inc\n")
    (tmp_path / "x.inc").write_text("[JOINT_0]\nMAX_VELOCITY = 50\n[AXIS_X]\nMAX_VELOCITY = 40\n")
    imported = lostmotion.import_machine(path)
    assert "velocity_mm_s = 40.0 # [AXIS_X] MAX_VELOCITY" in imported.toml
    assert imported.machine == lostmotion.Machine.from_toml(imported.toml)
    assert any(fate == "filled in" for _key, _value, fate, _note in imported.rows)
    printer = tmp_path / "printer.cfg"
    printer.write_text(
        "[stepper_x]\nmicrosteps: 16\nrotation_distance: 40\nposition_max: 200\n[printer]\nmax_velocity: 300\n"
    )
    stepper = lostmotion.import_machine(printer)
    assert any(fate == "guess" for _key, _value, fate, _note in stepper.rows)
    assert "lead_mm = 40.0 # [stepper_x] rotation_distance" in stepper.toml
    assert "lead_mm = 16.0" in lostmotion.import_machine(printer, preset="vmc3").toml
    refused(lostmotion.MachineError, lambda: lostmotion.import_machine(printer, max_bytes=10))
    printer.write_bytes("[printer] # Größe\n".encode("latin-1"))
    error = refused(lostmotion.MachineError, lambda: lostmotion.import_machine(printer))
    assert "not UTF-8 text (byte 14)" in str(error)
    odd = tmp_path / "odd.xyz"
    odd.write_text("nothing")
    assert refused(lostmotion.MachineError, lambda: lostmotion.import_machine(odd)).code == "format"


def test_subroutines_are_those_beside_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slot.ngc").write_text("o<slot> sub\nG1 X10 F600\no<slot> endsub\nM2\n")
    text = "G21 G90\no<slot> call\nM2\n"
    (tmp_path / "part.ngc").write_text(text)
    assert lostmotion.plan("part.ngc", "bench3").cutting_mm == 10.0
    # A text has no folder, whatever it is called.
    program = lostmotion.Program(text, "part.ngc")
    refused(lostmotion.ProgramError, lambda: lostmotion.plan(program, "bench3"))
    assert lostmotion.plan(program, "bench3", subroutines=[tmp_path]).cutting_mm == 10.0
