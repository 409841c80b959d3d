"""Confidence intervals contain the truth as often as they say."""

import sys
from pathlib import Path

import pytest

BENCHMARKS = str(Path(__file__).parents[2] / "benchmarks")


@pytest.mark.slow
def test_intervals_contain_the_truth():
    sys.path.insert(0, BENCHMARKS)
    try:
        import fits  # type: ignore
    finally:
        sys.path.remove(BENCHMARKS)
    found = fits.response_fits(100)
    assert found["converged"] == 1.0
    # Of 100 intervals of 95 %, fewer than 90 contain the truth with a probability of 1 %.
    assert {name: found[name] for name in fits.TRUTH if found[name] < 0.9} == {}
