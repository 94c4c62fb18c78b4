"""Exceptions: each says what is wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

__all__ = [
    "Cancelled",
    "DataError",
    "Error",
    "Finding",
    "MachineError",
    "MethodError",
    "MissingPackage",
    "OptionError",
    "ProgramError",
]


@dataclass(frozen=True)
class Finding:
    """One thing that was found in a program or a machine file."""

    code: str
    """Stable name of the kind of finding: ``outside-travel``."""
    severity: str
    """``error``, ``warning`` or ``note``."""
    message: str
    """What was found, with the values."""
    file: str
    """Name of the program or file."""
    line: int
    """Line, from 1; 0 for the file as a whole."""
    column: int
    """Column in bytes, from 1."""
    length: int = 0
    """Length of the place, bytes."""
    hint: str = ""
    """What to do; may be empty."""
    excerpt: str = ""
    """The line."""
    values: Mapping[str, Any] = field(default_factory=dict)
    """The values in the message by name."""

    def __str__(self) -> str:
        text = f"{self.file}:{self.line}:{self.column}: {self.severity}[{self.code}]: {self.message}"
        if self.excerpt:
            text += f"\n  {self.excerpt}"
        return f"{text}\n  hint: {self.hint}" if self.hint else text


class Error(Exception):
    """Why there is no result.

    ``code`` is stable; ``file``, ``line`` and ``column`` are ``None`` where the error is about no
    place; ``findings`` has everything that was found.
    """

    def __init__(
        self,
        message: str,
        *,
        code: str = "error",
        hint: str = "",
        findings: Sequence[Finding | Mapping[str, Any]] = (),
    ) -> None:
        super().__init__(message)
        self.message = message
        self.code = code
        self.hint = hint
        self.findings: list[Finding] = [
            found if isinstance(found, Finding) else Finding(**found) for found in findings
        ]
        first = self.findings[0] if self.findings else None
        placed = first if first is not None and first.line > 0 else None
        self.file: str | None = first.file if first is not None else None
        self.line: int | None = placed.line if placed is not None else None
        self.column: int | None = placed.column if placed is not None else None

    def __str__(self) -> str:
        return f"{self.message}\nhint: {self.hint}" if self.hint else self.message

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), self.message, self.code, self.hint, self.findings)


def _restored(kind: type[Error], message: str, code: str, hint: str, findings: list[Finding]) -> Error:
    return kind(message, code=code, hint=hint, findings=findings)


class ProgramError(Error, ValueError):
    """The part program: it cannot be read, has errors, or does not fit the machine."""


class MachineError(Error, ValueError):
    """A machine description that does not hold."""


class MethodError(Error, ValueError):
    """A compensation method: not known, not fit for the axis, or failed."""


class OptionError(Error, ValueError):
    """A setting that makes no sense."""


class DataError(Error, ValueError):
    """Data: arrays of wrong shapes, numbers that are none, a log that tells nothing."""


class Cancelled(Error):
    """The caller has ended the run."""


class MissingPackage(Error, ImportError):
    """A package that is needed for this form alone; ``hint`` says how to get it."""
