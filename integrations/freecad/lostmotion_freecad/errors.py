"""What can go wrong, and the package that the add-on needs."""

from __future__ import annotations

import importlib
import os
import sys
from types import ModuleType

__all__ = ["JobError", "lostmotion"]

FOLDER = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
"""The add-on's own folder, which FreeCAD looks into for packages, whatever else it does."""

NEEDED = (0, 1)
"""The first release of the Python package that has all that the add-on uses."""


class JobError(Exception):
    """Why there is no result, and what to do about it."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(f"{message}\n{hint}" if hint else message)
        self.message = message
        self.hint = hint


def lostmotion() -> ModuleType:
    """The Python package ``lostmotion``.

    Raises `JobError` where it is missing, cannot be loaded, or is too old.
    """
    hint = (
        "Build its wheel in a clone of lostmotion, `pip wheel --no-deps .`, and install it for FreeCAD's "
        f"Python, {sys.version_info.major}.{sys.version_info.minor}: "
        f'`pip install --no-deps --target "{FOLDER}" lostmotion*.whl`; then start FreeCAD again.'
    )
    try:
        module = importlib.import_module("lostmotion")
    except ImportError as error:
        raise JobError(f"The Python package lostmotion cannot be loaded: {error}.", hint) from error
    version = str(getattr(module, "__version__", "0"))
    if not hasattr(module, "simulate") or release(version) < NEEDED:
        needed = ".".join(map(str, NEEDED))
        where = getattr(module, "__file__", None) or "an empty folder"
        raise JobError(
            f"The Python package lostmotion is {version} ({where}); this add-on needs {needed} or newer.",
            hint,
        )
    return module


def release(version: str) -> tuple[int, ...]:
    """The numbers of a version: ``0.1.0-rc1`` gives 0, 1, 0."""
    numbers = []
    for part in version.split("."):
        digits = "".join(character for character in part.split("-")[0] if character.isdigit())
        numbers.append(int(digits or 0))
    return tuple(numbers)
