"""Each kind of arguments has a program of its own, and a setting of JAX another."""

import contextlib
import time

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.experimental.serialize_executable import serialize

from flexmb.compilation import executables, kept
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


def test_arguments_of_several_kinds_in_turn(compilations):
    own = jit(lambda x: jnp.sum(x) * 2)
    given = [np.arange(3.0), np.arange(4.0), np.arange(3), np.arange(3.0), jnp.arange(4.0)]
    for x in given:
        assert own(x) == 2 * np.sum(x)
        assert own(x).dtype == x.dtype
    assert len([name for name in compilations if "lambda" in name]) == 3


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


def test_where_operations_were_written_is_not_in_a_program():
    def sine(x):
        with jax.named_scope("in a place of its own"):
            # In JAX's cache there is none with this number, without names, of an earlier run.
            return jnp.sin(x) + time.time()

    program = executables._compiled(executables.named(sine, "sine", None), (A,))
    assert b"in a place of its own" not in serialize(program)[0]


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
            jax.clear_caches()
            np.testing.assert_array_equal(product(A, B), A @ B)
        assert kept_now
        assert kept_now == list(tmp_path.glob("programs/*"))
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
        compile_thoroughly(False, keep=True)


def test_options_of_the_compiler_make_another_program(tmp_path):
    with setting("jax_compilation_cache_dir", str(tmp_path)):
        for options in (None, {"xla_backend_optimization_level": 1}):
            executables.Executables(linear.multiplied, "product", options, (linear.multiplied,))(A, B)
    assert len(list(tmp_path.glob("programs/*"))) == 2


@pytest.mark.parametrize(
    ("name", "value"), [("jax_compilation_cache_dir", None), ("jax_enable_compilation_cache", False)]
)
def test_nothing_is_kept_where_jax_is_to_keep_nothing(caplog, name, value):
    with setting(name, value), caplog.at_level("DEBUG", "flexmb"):
        assert kept.read_program((linear.multiplied, None, (), None), (A, B)) == (None, None)
    assert "not kept on disk" in caplog.text


def test_programs_for_a_chosen_device_are_kept_by_jax_alone(caplog):
    things = (linear.multiplied, None, (), None)
    with jax.default_device(jax.devices()[0]), caplog.at_level("DEBUG", "flexmb"):
        assert kept.read_program(things, (A, B)) == (None, None)
    assert "a device was chosen" in caplog.text


def test_another_version_of_jax_compiles_by_itself(monkeypatch):
    for name in ("_config", "_caches", "_passes"):
        monkeypatch.setattr(executables, name, None)
    monkeypatch.setattr(executables, "_is_known", False)
    own = jit(lambda x: 3 * x)
    np.testing.assert_array_equal(own(A), 3 * A)
    np.testing.assert_array_equal(own(A[0]), 3 * A[0])
