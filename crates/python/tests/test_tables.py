"""Columns in place: numpy, Arrow, pandas, polars."""

from __future__ import annotations

import builtins
import pickle
from typing import Any

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import lostmotion

PROGRAM = lostmotion.Program("G21 G90\nG0 X25\nG3 I-25 F2000\nM2\n")


@pytest.fixture(scope="module")
def run() -> lostmotion.Run:
    return lostmotion.simulate(PROGRAM, methods=["none", "fixed"], samples=True)


def test_numpy_reads_in_place(run: lostmotion.Run) -> None:
    table = run.samples
    first, second = table["error_um"], table["error_um"]
    assert first.dtype == np.float64 and first.shape == (len(table),)
    assert first.__array_interface__["data"][0] == second.__array_interface__["data"][0]
    assert not first.flags.writeable
    with pytest.raises(ValueError):
        first[0] = 1.0
    # The memory stays as long as an array of it does.
    kept = lostmotion.plan(PROGRAM).samples["x_mm"]
    before = kept.copy()
    for _ in range(20):
        lostmotion.plan(PROGRAM)
    assert (kept == before).all()


def test_arrow_reads_in_place(run: lostmotion.Run) -> None:
    table = run.samples
    arrow = table.to_arrow()
    assert arrow.column_names == table.columns and arrow.num_rows == len(table)
    column = arrow["error_um"].chunk(0)
    assert column.buffers()[1].address == table["error_um"].__array_interface__["data"][0]
    assert arrow["method"].to_pylist()[0] == "none"
    assert pyarrow.table(run.blocks).num_rows == len(run.blocks)
    arrow.validate(full=True)


def test_pandas_and_polars_say_the_same(run: lostmotion.Run) -> None:
    table = run.blocks
    frame, other = table.to_pandas(), table.to_polars()
    assert isinstance(frame, pandas.DataFrame) and isinstance(other, polars.DataFrame)
    assert list(frame.columns) == other.columns == table.columns
    for name in table.columns:
        assert frame[name].tolist() == other[name].to_list() == table[name].tolist()
    samples = run.samples
    shared = samples.to_pandas()["error_um"].to_numpy()
    assert np.shares_memory(shared, samples["error_um"])
    worst = frame.loc[frame["method"] == "none", "max_um"].abs().max()
    assert worst == abs(run["none"].worst_blocks[0].max_um)


def test_rows_and_names(run: lostmotion.Run) -> None:
    table = run.blocks
    assert "max_um" in table and "nonsense" not in table
    assert list(table) == table.columns == list(table.keys())
    assert table.row(-1) == table.row(len(table) - 1)
    assert set(dict(**table.row(0))) == set(table.columns)
    with pytest.raises(KeyError, match="the columns are"):
        table["nonsense"]
    with pytest.raises(IndexError, match="the table has"):
        table.row(len(table))


def test_every_method_has_all_its_samples(run: lostmotion.Run) -> None:
    samples = run.samples
    methods, counts = np.unique(samples["method"].astype(str), return_counts=True)
    assert set(methods) == {"none", "fixed"} and counts[0] == counts[1]
    moving = samples["moving"] == 1
    cutting = moving & (samples["rapid"] == 0) & (samples["method"] == "none")
    worst = np.abs(samples["error_um"][cutting]).max()
    assert worst == run["none"].cutting.max


@pytest.mark.parametrize(
    ("name", "method"), [("pandas", "to_pandas"), ("polars", "to_polars"), ("pyarrow", "to_arrow")]
)
def test_packages_that_are_missing_are_named(
    run: lostmotion.Run, monkeypatch: pytest.MonkeyPatch, name: str, method: str
) -> None:
    usual = builtins.__import__

    def without(wanted: str, *rest: Any, **more: Any) -> Any:
        if wanted == name:
            raise ImportError(wanted)
        return usual(wanted, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setitem(__import__("sys").modules, name, None)
    with pytest.raises(lostmotion.MissingPackage) as caught:
        getattr(run.blocks, method)()
    assert caught.value.hint == f"pip install {name}"
    assert isinstance(caught.value, ImportError)


def test_pictures_for_notebooks() -> None:
    run = lostmotion.simulate(PROGRAM, method="none", page=True)
    shown = run._repr_html_()
    assert shown.startswith("<iframe srcdoc=") and "&lt;!DOCTYPE html&gt;" in shown.replace(
        "doctype", "DOCTYPE"
    )
    plain = lostmotion.simulate(PROGRAM, method="none")
    assert plain._repr_html_().startswith("<pre>")
    with pytest.raises(lostmotion.OptionError) as caught:
        _ = plain.page
    assert caught.value.hint == "simulate(..., page=True)"


def test_tables_without_rows() -> None:
    line = lostmotion.Program("G21 G90\nG1 X5 F600\nM2\n")
    table = lostmotion.simulate(line, "bench3", method="none").reversals
    assert len(table) == 0 and table["time_s"].shape == (0,) and table["axis"].shape == (0,)
    assert len(table.to_pandas()) == len(table.to_polars()) == table.to_arrow().num_rows == 0
    assert pickle.loads(pickle.dumps(table)).columns == table.columns
