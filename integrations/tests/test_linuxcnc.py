"""The check for LinuxCNC: as a command, as a filter, and what it says of bad input."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import lostmotion
import lostmotion_check

SCRIPT = Path(lostmotion_check.__file__)

INI = """[EMC]
MACHINE = mill
[TRAJ]
COORDINATES = X Y Z
LINEAR_UNITS = mm
MAX_LINEAR_VELOCITY = 50
[RS274NGC]
SUBROUTINE_PATH = subs:missing
[KINS]
KINEMATICS = trivkins
JOINTS = 3
[AXIS_X]
MAX_VELOCITY = 50
MAX_ACCELERATION = 500
MIN_LIMIT = -200
MAX_LIMIT = 200
[AXIS_Y]
MAX_VELOCITY = 50
MAX_ACCELERATION = 500
MIN_LIMIT = -200
MAX_LIMIT = 200
[AXIS_Z]
MAX_VELOCITY = 30
MAX_ACCELERATION = 500
MIN_LIMIT = -100
MAX_LIMIT = 100
"""

PART = "G21 G90 G17 G94 G64 P0.01\nG0 X15 Y0\nG3 I-15 F1200\nM2\n"


@pytest.fixture
def room(tmp_path: Path) -> Path:
    (tmp_path / "mill.ini").write_text(INI)
    # Bytes that are no UTF-8 and no newline at the end come out as they went in.
    (tmp_path / "part.ngc").write_bytes(PART.replace("M2\n", "(\xe4) M2").encode("latin-1"))
    (tmp_path / "subs").mkdir()
    return tmp_path


def run(room: Path, *arguments: str, **environment: str) -> tuple[int, bytes, str]:
    clean = {name: value for name, value in os.environ.items() if name != "INI_FILE_NAME"}
    done = subprocess.run(
        [sys.executable, str(SCRIPT), *arguments],
        cwd=room, capture_output=True, env={**clean, **environment}, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr.decode()


def test_as_a_command(room: Path) -> None:
    code, out, _ = run(room, "part.ngc", "--ini", "mill.ini", "--method", "none", "--tolerance", "500")
    assert (
        code == 0
        and out.startswith(b"lostmotion: within tolerance")
        and b"machine of mill.ini (--ini)" in out
    )
    code, out, _ = run(room, "part.ngc", "--ini", "mill.ini", "--method", "none", "--tolerance", "0.5")
    assert code == 1 and b"OUT OF tolerance" in out
    # The figures are the library's.
    machine = lostmotion.import_machine(room / "mill.ini", format="linuxcnc").machine
    own = lostmotion.simulate(room / "part.ngc", machine, method="none", tolerance_um=0.5)
    assert f"{own.results[0].cutting.max:.1f} um at most, 0.5 um allowed (method none" in out.decode()
    worst = own.results[0].worst_blocks[0]
    assert f"line {worst.block.span.line}: {worst.max_um:+.1f} um" in out.decode()


def test_as_a_filter(room: Path) -> None:
    ini = str(room / "mill.ini")
    code, out, told = run(room, "--filter", "part.ngc", INI_FILE_NAME=ini)
    assert (code, out) == (0, (room / "part.ngc").read_bytes())
    percents = [int(line.split("=")[1]) for line in told.splitlines() if line.startswith("FILTER_PROGRESS=")]
    assert percents == sorted(percents) and percents[-1] == 100
    assert "INI_FILE_NAME, the running LinuxCNC's" in told
    # Out of tolerance it is loaded all the same, or not.
    loud = ["--filter", "part.ngc", "--tolerance", "0.5"]
    code, out, told = run(room, *loud, INI_FILE_NAME=ini)
    assert (code, out) == (0, (room / "part.ngc").read_bytes()) and "OUT OF tolerance" in told
    (room / "mill.ini").write_text(INI + "[lostmotion]\non_violation = stop\nTOLERANCE_UM = 0.5\n# end\n")
    code, out, told = run(room, "--filter", "part.ngc", INI_FILE_NAME=ini)
    assert (code, out) == (1, b"") and "is not loaded" in told and "0.5 um allowed" in told
    code, out, _ = run(room, "--filter", "part.ngc", "--on-violation", "warn", INI_FILE_NAME=ini)
    assert code == 0 and out


def test_a_machine_of_its_own(room: Path) -> None:
    machine = lostmotion.Machine.preset("bench3")
    (room / "own.toml").write_text(machine.to_toml())
    (room / "mill.ini").write_text(INI + "[LOSTMOTION]\nMACHINE = own.toml\nMETHOD = none\n")
    code, out, _ = run(room.parent, str(room / "part.ngc"), "--ini", str(room / "mill.ini"))
    own = lostmotion.simulate(room / "part.ngc", machine, method="none")
    assert (
        code == int(not own.within_tolerance)
        and f"{own.results[0].cutting.max:.1f} um at most" in out.decode()
    )
    code, out, _ = run(room, "part.ngc", "--machine", "vmc3")
    assert b"preset vmc3" in out
    settings = lostmotion_check.settings_of(["part.ngc", "--ini", str(room / "mill.ini")], {})
    assert lostmotion_check.subroutines_of(settings.ini) == [str(room / "subs")]


@pytest.mark.parametrize(
    ("arguments", "section", "message"),
    [
        (["part.ngc"], "", "There is no INI file"),
        (["part.ngc", "--ini", "other.ini"], "", "other.ini (--ini) cannot be read"),
        (["other.ngc", "--ini", "mill.ini"], "", "other.ngc"),
        (["part.ngc", "--ini", "mill.ini"], "TOLERANCE = 3", "has no key TOLERANCE"),
        (["part.ngc", "--ini", "mill.ini"], "TOLERANCE_UM = some", "has to be a number"),
        (["part.ngc", "--ini", "mill.ini"], "TOLERANCE_UM = -3", "has to be above 0"),
        (["part.ngc", "--ini", "mill.ini"], "ON_VIOLATION = shout", "one of warn, stop"),
        (["part.ngc", "--ini", "mill.ini"], "METHOD = nome", "nome"),
        (["part.ngc", "--ini", "mill.ini"], "MACHINE = missing.toml", "missing.toml"),
        (["part.ngc", "--ini", "mill.ini"], "MACHINE = vmc99", "vmc99"),
        (["wrong.ngc", "--ini", "mill.ini"], "", "wrong.ngc:2"),
    ],
)
def test_bad_input_says_what_to_do(room: Path, arguments: list[str], section: str, message: str) -> None:
    (room / "mill.ini").write_text(f"{INI}[LOSTMOTION]\n{section}\n" if section else INI)
    (room / "wrong.ngc").write_text("G21\nG1 Z-\n")
    for more in ([], ["--filter"]):
        code, out, told = run(room, *more, *arguments)
        assert (code, out) == (2, b"") and message in told, told
        assert len(told.splitlines()) > 1 or "did you mean" in told, told


def test_the_package_may_be_missing_or_old(room: Path) -> None:
    (room / "lostmotion.py").write_text("raise ImportError('no module of this kind')\n")
    code, _, told = run(room, "part.ngc", "--ini", "mill.ini", PYTHONPATH=str(room))
    assert code == 2 and "cannot be loaded" in told and "pip install" in told
    (room / "lostmotion.py").write_text("__version__ = '0.0.3'\n")
    code, _, told = run(room, "part.ngc", "--ini", "mill.ini", PYTHONPATH=str(room))
    assert code == 2 and "is 0.0.3; 0.1 or newer" in told
