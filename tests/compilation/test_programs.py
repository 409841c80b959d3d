"""Each kind of arguments has a program of its own, and a setting of JAX another."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from flexmb.compilation import kept, programs
from flexmb.compilation.compile import compile_thoroughly, jit
from flexmb.math import linear

A, B = np.arange(4.0).reshape(2, 2), np.array([[1.0, 2.0], [3.0, 5.0]])


def test_arguments_of_several_kinds_in_turn(compilations):
    own = jit(lambda x: jnp.sum(x) * 2)
    given = [np.arange(3.0), np.arange(4.0), np.arange(3), np.arange(3.0), jnp.arange(4.0)]
    for x in given:
        assert own(x) == 2 * np.sum(x)
        assert own(x).dtype == x.dtype
    assert len([name for name in compilations if "lambda" in name]) == 3


def test_where_operations_were_written_is_not_in_a_program():
    program = programs._compiled(programs.named(lambda x: jnp.sin(x) + 1, "sine", None), (A,))
    assert "metadata=" not in str(program.as_text())


@pytest.mark.parametrize("error", [TypeError, ValueError])
def test_a_function_that_fails_is_traced_once(error):
    traced = []

    def failing(x):
        traced.append(x.shape)
        if x.shape[0] > 3:
            raise error("too long")
        return 2 * x

    own = jit(failing)
    own(np.arange(3.0))
    with pytest.raises(error, match="too long"):
        own(np.arange(4.0))
    assert traced == [(3,), (4,)]


def test_settings_make_another_program(compilations):
    traced = []

    def function(x):
        traced.append(x)
        return 2 * x

    own, x = jit(function), np.arange(3.0)
    own(x)
    own(x)
    assert len(traced) == 1
    with jax.default_matmul_precision("float32"):
        own(x)
        own(x)
    assert len(traced) == 2
    with jax.disable_jit():
        np.testing.assert_array_equal(own(x), 2 * x)
    own(x)
    assert len(traced) == 3


def test_what_jax_has_in_its_cache_is_compiled_for_this_one(tmp_path):
    """XLA writes what it has read without the code of its loops, which then is not found."""
    product = jit(linear.multiplied)
    before = jax.config.values["jax_compilation_cache_dir"]
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        for keep in (False, True, True):
            kept_now = list(tmp_path.glob("programs/*"))
            compile_thoroughly(False, keep=keep)
            jax.clear_caches()
            programs.let_go()
            np.testing.assert_array_equal(product(A, B), A @ B)
        assert kept_now
        assert kept_now == list(tmp_path.glob("programs/*"))
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
        compile_thoroughly(False, keep=True)


def test_programs_for_a_chosen_device_are_kept_by_jax_alone(caplog):
    things = (linear.multiplied, None, (), None)
    with jax.default_device(jax.devices()[0]), caplog.at_level("DEBUG", "flexmb"):
        assert kept.read_program(things, (A, B)) == (None, None)
    assert "a device was chosen" in caplog.text


def test_another_version_of_jax_compiles_by_itself(monkeypatch):
    own = jit(lambda x: 3 * x)
    monkeypatch.setattr(programs, "_config", None)
    np.testing.assert_array_equal(own(A), 3 * A)
    np.testing.assert_array_equal(own(A[0]), 3 * A[0])
