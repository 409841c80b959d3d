"""Each kind of arguments has a program of its own, and a setting of JAX another."""

import contextlib

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from flexmb.compilation import kept
from flexmb.compilation.compile import compile_thoroughly, jit
from flexmb.math import linear

A, B = np.arange(4.0).reshape(2, 2), np.array([[1.0, 2.0], [3.0, 5.0]])


@contextlib.contextmanager
def setting(name, value):
    """Within, JAX has another setting."""
    before = jax.config.values[name]
    jax.config.update(name, value)
    yield
    jax.config.update(name, before)
    compile_thoroughly(False, keep=True)


@pytest.mark.slow
def test_arguments_of_several_kinds_in_turn(compilations):
    own = jit(lambda x: jnp.sum(x) * 2)
    given = [np.arange(3.0), np.arange(4.0), np.arange(3), np.arange(3.0), jnp.arange(4.0)]
    for x in given:
        assert own(x) == 2 * np.sum(x)
        assert own(x).dtype == x.dtype
    assert len([name for name in compilations if "lambda" in name]) == 3


@pytest.mark.slow
def test_programs_from_disk_are_those_of_their_arguments(tmp_path):
    product = jit(linear.multiplied)
    with setting("jax_compilation_cache_dir", str(tmp_path)):
        for _ in range(2):
            jax.clear_caches()
            for one, other in ((A, B), (A[:1], B), (A, B[:, :1]), (A.astype(np.float32), B.astype(np.float32))):
                found = product(one, other)
                assert found.dtype == one.dtype
                np.testing.assert_array_equal(found, one @ other)
            assert len(list(tmp_path.glob("programs/*"))) == 4


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
    with pytest.raises(error, match="too long"):
        own(jax.device_put(np.arange(5.0), jax.devices()[0]))
    assert traced == [(3,), (4,), (5,)]


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


def test_a_number_that_is_none_is_told_as_jax_tells_it():
    own, x = jit(lambda x: jnp.log(x)), np.array([-1.0])
    assert np.isnan(own(x)[0])
    with jax.debug_nans(True), pytest.raises(FloatingPointError, match="log"):
        own(x)
    with jax.debug_infs(True), pytest.raises(FloatingPointError, match="log"):
        own(0 * x)


def test_a_device_that_was_chosen_is_not_that_of_other_numbers():
    own = jit(lambda x: 2 * x)
    assert own(jax.device_put(A, jax.devices()[0])).committed
    assert not own(A).committed
    assert own(jax.device_put(A, jax.devices()[0])).committed


@pytest.mark.parametrize(
    ("name", "value"), [("jax_compilation_cache_dir", None), ("jax_enable_compilation_cache", False)]
)
def test_nothing_is_kept_where_jax_is_to_keep_nothing(caplog, name, value):
    with setting(name, value), caplog.at_level("DEBUG", "flexmb"):
        assert kept._path((linear.multiplied,), (A, B)) is None
    assert "not kept on disk" in caplog.text


def test_programs_for_a_chosen_device_are_kept_by_jax_alone(caplog):
    with jax.default_device(jax.devices()[0]), caplog.at_level("DEBUG", "flexmb"):
        assert kept._path((linear.multiplied,), (A, B)) is None
    assert "a device was chosen" in caplog.text


def test_programs_are_not_those_of_arrays_on_another_device(monkeypatch, tmp_path):
    """As of arrays that lie on the processor where a graphics card is what JAX computes with."""
    product, on_processor = jit(linear.multiplied), jax.device_put(A, jax.devices()[0])
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    with setting("jax_compilation_cache_dir", str(tmp_path)):
        np.testing.assert_array_equal(product(on_processor, B), A @ B)
        assert not list(tmp_path.glob("programs/*"))
