"""Compiled code is given back before a process has no memory map left."""

from functools import partial
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from flexmb.compilation import compile


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="memory maps are counted on Linux alone")
@pytest.mark.parametrize("left", [0, 1])
def test_compiled_code_is_given_back_where_it_may_fill_the_memory_maps(compilations, monkeypatch, left):
    one, other = (compile.jit(lambda x, factor=factor: jnp.sin(x) * factor) for factor in (2.0, 3.0))
    x = jnp.linspace(0.0, 1.0, 5)
    before = one(x)
    compilations.clear()
    one(x)
    assert compilations == []
    # With one program left no maps are counted; with none left they are, and any number is too many here.
    monkeypatch.setattr(compile, "_programs_left", left)
    monkeypatch.setattr(compile, "make_room", partial(compile.make_room, 0.0))
    other(x)
    monkeypatch.undo()
    compilations.clear()
    np.testing.assert_array_equal(one(x), before)
    assert len(compilations) == (1 if left == 0 else 0)


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="memory maps are counted on Linux alone")
def test_maps_are_counted_again_before_programs_may_have_filled_them(monkeypatch):
    monkeypatch.setattr(compile, "_programs_left", -1)
    compile.make_room()
    most = int(Path("/proc/sys/vm/max_map_count").read_text(encoding="utf-8"))
    used = len(Path("/proc/self/maps").read_text(encoding="utf-8").splitlines())
    # Another thread may take some in between.
    assert -100.0 < 0.6 * most - used - 2000 * compile._programs_left < 2 * 2000
