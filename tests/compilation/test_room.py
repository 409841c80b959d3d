"""Compiled code is given back before a process has no memory map left."""

from functools import partial
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from flexmb.compilation import compile


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="memory maps are counted on Linux alone")
def test_compiled_code_is_given_back_where_it_fills_the_memory_maps(compilations, monkeypatch):
    one, other = (compile.jit(lambda x, factor=factor: jnp.sin(x) * factor) for factor in (2.0, 3.0))
    x = jnp.linspace(0.0, 1.0, 5)
    before = one(x)
    compilations.clear()
    one(x)
    assert compilations == []
    monkeypatch.setattr(compile, "make_room", partial(compile.make_room, 0.0))
    other(x)
    monkeypatch.undo()
    compilations.clear()
    np.testing.assert_array_equal(one(x), before)
    assert len(compilations) == 1
