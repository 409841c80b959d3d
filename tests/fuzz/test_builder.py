"""The first random calls of a Builder; ``benchmarks/fuzz.py`` runs as many as are asked for."""

import itertools

import pytest
from fuzz import builder


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_builder(seed):
    happened = [builder.run(case) for case in itertools.islice(builder.cases(seed), 150)]
    assert {"built", "unchecked", "refused"} <= set(happened)
    # Enough of them are mechanisms.
    assert sum(what != "refused" for what in happened) >= 50
