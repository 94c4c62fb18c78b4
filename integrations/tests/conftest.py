"""The add-on and the check are not installed: they are taken from where they stand."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent

sys.path[:0] = [str(HERE.parent / "freecad"), str(HERE.parent / "linuxcnc")]
