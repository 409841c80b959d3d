"""The table that watches itself: what got worse is named, and nothing else."""

import copy
import importlib.util
import json
from pathlib import Path

import pytest

PLACE = Path(__file__).parents[1] / "benchmarks" / "quick.py"
found = importlib.util.spec_from_file_location("quick", PLACE)
assert found is not None
assert found.loader is not None
quick = importlib.util.module_from_spec(found)
found.loader.exec_module(quick)


@pytest.fixture
def rows():
    return json.loads(quick.TABLE.read_text())["rows"]


def test_every_row_stands_in_the_committed_table(rows):
    assert list(rows) == [case.__name__ for case in quick.CASES]


def test_nothing_is_named_where_nothing_changed(rows):
    assert quick.losses(rows, rows) == []


@pytest.mark.parametrize(
    ("key", "factor", "told"),
    [("time", 2.0, True), ("time", 1.2, False), ("first", 1.5, True), ("instructions", 1.03, True), ("error", 3, True)],
)
def test_a_loss_above_noise_is_named(rows, key, factor, told):
    worse = copy.deepcopy(rows)
    worse["elastica"][key] *= factor
    said = quick.losses(worse, rows)
    assert bool(said) is told
    assert all(text.startswith(f"elastica: {key} ") for text in said)


def test_a_slower_machine_is_no_loss(rows):
    slower = copy.deepcopy(rows)
    for row in slower.values():
        row["time"] *= 3
        row["yardstick"]["time"] *= 3
    assert quick.losses(slower, rows) == []


def test_an_answer_that_is_no_number_is_named(rows):
    worse = copy.deepcopy(rows)
    worse["path"]["error"] = float("nan")
    assert len(quick.losses(worse, rows)) == 1


def test_rows_that_are_missing_or_new_are_named(rows):
    fewer = {name: row for name, row in rows.items() if name != "path"}
    assert "no longer measured" in quick.losses(fewer, rows)[0]
    assert "not in the committed table" in quick.losses(rows, fewer)[0]
