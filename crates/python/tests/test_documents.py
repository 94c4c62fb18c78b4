"""The blocks of the book's page are run, one after the other."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from conftest import ROOT

PAGE = ROOT / "docs" / "book" / "src" / "guide" / "python.md"


def test_blocks_of_the_page(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    text = PAGE.read_text(encoding="utf-8")
    blocks = list(re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    assert len(blocks) >= 8
    names: dict[str, object] = {}
    for block in blocks:
        line = text.count("\n", 0, block.start(1))
        # Lines of the page in tracebacks.
        code = compile("\n" * line + block.group(1), str(PAGE), "exec")
        exec(code, names)  # noqa: S102
