"""The first random studies and pieces of arithmetic; ``benchmarks/fuzz.py`` runs as many as are asked for."""

import itertools

import pytest
from cases.commands import keeping
from fuzz import arithmetic, studies


@pytest.mark.parametrize("seed", range(4))
def test_arithmetic(seed):
    happened = {arithmetic.run(case) for case in itertools.islice(arithmetic.cases(seed), 1000)}
    assert happened == {"value", "refused"}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_studies(seed):
    # Of those that are compiled for themselves, only the quickest.
    drawn = (case for case in studies.cases(seed) if case.how == "one by one" or b"own:plain" in case.content)
    with keeping():
        happened = [studies.run(case) for case in itertools.islice(drawn, 50)]
    # Enough of them are computed.
    assert sum(what in ("answered", "failed", "called") for what in happened) >= 15
