"""What tests of SPACAR input files have in common."""

import jax
import numpy as np
import pytest

import flexmb as fm


def assert_same(actual, expected):
    """Two builders of equal models: structure, names and every number."""
    models = [b.build(check=False) for b in (actual, expected)]
    assert jax.tree.structure(models[0]) == jax.tree.structure(models[1])
    for a, b in zip(*map(jax.tree.leaves, models), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-15, atol=0)


def faults(text):
    """Lines of what is said about a wrong file."""
    with pytest.raises(fm.SpacarError) as info:
        fm.read_spacar(text)
    return str(info.value).splitlines()
