"""A few hundred cases of the fuzzer of input files; ``benchmarks`` runs more."""

import dataclasses
import itertools

import pytest
from fuzz import files

import flexmb as fm

# What is compiled for an analysis here: one small model in three modes.
QUICK = ("moved", (0, 7, 9))


def quick(case):
    return case if case.name == QUICK[0] and case.mode in QUICK[1] else dataclasses.replace(case, mode=None)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_only_answers_and_named_refusals_leave(seed):
    found = {files.run(quick(case)) for case in itertools.islice(files.cases(seed), 100)}
    assert found >= {"refused", "read", "called"}


def test_the_same_cases_for_the_same_seed():
    one, again, other = (list(itertools.islice(files.cases(seed), 20)) for seed in (7, 7, 8))
    assert one == again
    assert one != other


@pytest.mark.slow
def test_an_analysis_is_run_where_the_shapes_are_known():
    text = files.originals()["moved"]
    assert files.run(files.Case("moved", text.encode(), mode=7)) == "answered"
    assert (
        files.run(files.Case("moved", text.replace("DYNX 2 1", "").replace("STARTDX", "%").encode(), mode=7)) == "read"
    )


@pytest.mark.parametrize("fault", [KeyError("x"), RecursionError(), ValueError("not of the package"), MemoryError()])
def test_what_must_not_leave_is_seen(fault, monkeypatch):
    def surprised(*_, **__):
        raise fault

    monkeypatch.setattr(fm, "read_spacar", surprised)
    with pytest.raises(type(fault)):
        files.run(files.Case("moved", b""))


@pytest.mark.parametrize("message", ["model.dat:1: X: \x1b[31m", "no file", "model.dat:1: " + "x" * 2000])
def test_a_message_of_more_than_a_line_or_of_no_place_is_seen(message, monkeypatch):
    def refused(*_, **__):
        raise fm.SpacarError(message)

    monkeypatch.setattr(fm, "read_spacar", refused)
    with pytest.raises(AssertionError):
        files.run(files.Case("moved", b""))


@pytest.mark.slow
def test_what_hangs_is_seen(monkeypatch):
    def endless(*_, **__):
        while True:
            pass

    monkeypatch.setattr(files, "LIMIT_S", 0.2)
    monkeypatch.setattr(fm, "read_spacar", endless)
    with pytest.raises(TimeoutError):
        files.run(files.Case("moved", b""))
