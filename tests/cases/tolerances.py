import pytest


def approx(expected, rel=None, abs=None, nan_ok=False):
    """As pytest's, without its absolute 1e-12 where a relative tolerance is given: any smaller number would pass."""
    return pytest.approx(expected, rel, 0.0 if abs is None and rel is not None else abs, nan_ok)
