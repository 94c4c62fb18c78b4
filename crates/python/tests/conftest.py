"""What the tests share: the repository, and the command that the figures are held against."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

Command = Callable[..., str]


@pytest.fixture(scope="session")
def parts() -> Path:
    """Part programs of the repository."""
    return ROOT / "gcode_samples" / "parts"


@pytest.fixture(scope="session")
def command() -> Command:
    """The command; answers what it prints. Its path is in LOSTMOTION."""
    program = os.environ.get("LOSTMOTION")
    if program is None:
        pytest.skip("LOSTMOTION names no command to compare with")

    def run(*arguments: object) -> str:
        done = subprocess.run(
            [program, "-q", *map(str, arguments)], capture_output=True, text=True, check=False
        )
        assert done.returncode in (0, 1), done.stderr
        return done.stdout

    return run
