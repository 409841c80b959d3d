"""Compiled code calls the host by name, and is kept on disk."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from flexmb.compilation import host
from flexmb.compilation.host import call_host


def mirrored(numbers: dict[str, np.ndarray], *, by: float):
    return {name: by * number for name, number in numbers.items()}


def written_into(number: np.ndarray):
    number += 1.0
    return number


def of_shape(_: np.ndarray, *, shape: tuple[int, ...], kind: type):
    return np.zeros(shape, kind)


def refused(_: np.ndarray):
    raise ValueError("the beam 'a-b' has no length")


ALL = {
    "real": np.array([[1.0, -2.0], [3.0, 0.5]]),
    "complex": np.array([1.0 - 2.0j]),
    "whole": np.array([3, -4], np.int32),
    "long": np.array(2**40),
    "none": np.zeros((0, 3)),
}


def test_numbers_of_every_kind_and_shape_go_there_and_back():
    like = {name: jax.ShapeDtypeStruct(number.shape, number.dtype) for name, number in ALL.items()}
    twice = functools.partial(mirrored, by=2)
    program = jax.jit(lambda numbers: call_host(twice, like, numbers))
    # The compiler's cache takes no callback of JAX.
    assert "callback" not in str(jax.make_jaxpr(program)(ALL))
    found = program(ALL)
    for name, number in ALL.items():
        assert found[name].dtype == number.dtype
        np.testing.assert_array_equal(found[name], 2 * number)


def test_a_batch_is_asked_one_by_one():
    like = {"x": jax.ShapeDtypeStruct((2,), float)}
    half = functools.partial(mirrored, by=0.5)
    found = jax.jit(jax.vmap(lambda x: call_host(half, like, {"x": x})["x"]))(jnp.arange(6.0).reshape(3, 2))
    np.testing.assert_array_equal(found, np.arange(6.0).reshape(3, 2) / 2)


def test_arguments_are_copies():
    @jax.jit
    def both(x):
        x = x * 2
        return x, call_host(written_into, jax.ShapeDtypeStruct(x.shape, x.dtype), x)

    before, after = both(jnp.ones(3))
    np.testing.assert_array_equal((before, after), ([2.0] * 3, [3.0] * 3))


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (refused, "ValueError: the beam 'a-b' has no length"),
        (functools.partial(of_shape, shape=(3,), kind=float), r"shape \(3,\) in place of \(2,\)"),
        (functools.partial(of_shape, shape=(2,), kind=complex), "Cannot cast"),
    ],
)
def test_what_fails_is_an_error(function, message):
    with pytest.raises(jax.errors.JaxRuntimeError, match=message):
        jax.block_until_ready(jax.jit(lambda x: call_host(function, jax.ShapeDtypeStruct((2,), float), x))(1.0))


@pytest.mark.parametrize("device", ["processor", "other"])
def test_what_no_program_can_name_and_other_devices_are_served_too(monkeypatch, device):
    if device == "other":
        monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    function = (lambda x: x + 1) if device == "processor" else written_into
    program = jax.make_jaxpr(lambda x: call_host(function, jax.ShapeDtypeStruct((), float), x))(1.0)
    assert "pure_callback" in str(program)
    assert float(jax.core.eval_jaxpr(program.jaxpr, program.consts, 1.0)[0]) == 2.0


def test_calls_beyond_the_number_that_is_remembered_are_read_again(monkeypatch):
    monkeypatch.setattr(host, "MOST", 1)
    like = {"x": jax.ShapeDtypeStruct((), float)}
    calls = [
        jax.jit(lambda x, by=by: call_host(functools.partial(mirrored, by=by), like, {"x": x})["x"])
        for by in (2.0, 3.0)
    ]
    assert [float(call(1.0)) for call in (*calls, *calls)] == [2.0, 3.0, 2.0, 3.0]
    assert len(host._calls) == 1
