"""Compiled code calls the host by name, and is kept on disk."""

import functools
import signal

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from flexmb.compilation import host
from flexmb.compilation.compile import jit
from flexmb.compilation.host import call_host


def mirrored(numbers: dict[str, np.ndarray], *, by: float):
    return {name: by * number for name, number in numbers.items()}


def written_into(number: np.ndarray):
    number += 1.0
    return number


def of_shape(_: np.ndarray, *, shape: tuple[int, ...], kind: type):
    return np.zeros(shape, kind)


def refused(_: np.ndarray, *, why: str = "the beam 'a-b' has no length"):
    raise ValueError(why)


ALL = {
    "real": np.array([[1.0, -2.0], [3.0, 0.5]]),
    "complex": np.array([1.0 - 2.0j]),
    "whole": np.array([3, -4], np.int32),
    "long": np.array(2**40),
    "none": np.zeros((0, 3)),
}


@pytest.fixture(params=[jit, jax.jit], ids=["this package's", "a user's"])
def compiled(request):
    """A program that this package runs, which calls the host by its name, and one of a user's, which calls back."""
    host.forget()
    yield request.param
    assert bool(host._calls) == (request.param is jit)


def test_numbers_of_every_kind_and_shape_go_there_and_back(compiled):
    like = {name: jax.ShapeDtypeStruct(number.shape, number.dtype) for name, number in ALL.items()}
    twice = functools.partial(mirrored, by=2)
    found = compiled(lambda numbers: call_host(twice, like, numbers))(ALL)
    for name, number in ALL.items():
        assert found[name].dtype == number.dtype
        np.testing.assert_array_equal(found[name], 2 * number)


def test_known_numbers_are_answered_at_once():
    found = call_host(functools.partial(mirrored, by=3.0), {"x": jax.ShapeDtypeStruct((2,), float)}, {"x": np.ones(2)})
    np.testing.assert_array_equal(found["x"], [3.0, 3.0])


def test_a_batch_is_asked_one_by_one(compiled):
    like = {"x": jax.ShapeDtypeStruct((2,), float), "all": jax.ShapeDtypeStruct((), float)}
    half = functools.partial(mirrored, by=0.5)

    def of_one(x):
        return call_host(half, like, {"x": x, "all": jnp.array(8.0)})

    # Of the batch, the second axis.
    found = compiled(jax.vmap(of_one, in_axes=1))(jnp.arange(6.0).reshape(2, 3))
    np.testing.assert_array_equal(found["x"], np.arange(6.0).reshape(2, 3).T / 2)
    np.testing.assert_array_equal(found["all"], [4.0] * 3)


def test_arguments_are_copies(compiled):
    @compiled
    def both(x):
        x = x * 2
        return x, call_host(written_into, jax.ShapeDtypeStruct(x.shape, x.dtype), x)

    before, after = both(jnp.ones(3))
    np.testing.assert_array_equal((before, after), ([2.0] * 3, [3.0] * 3))


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (refused, "ValueError: the beam 'a-b' has no length"),
        (functools.partial(refused, why="of 'caf\udc80'"), r"ValueError: of 'caf.udc80'"),
        (functools.partial(of_shape, shape=(3,), kind=float), r"shape \(3,\) in place of \(2,\)"),
        (functools.partial(of_shape, shape=(2,), kind=complex), "Cannot cast"),
    ],
)
def test_what_fails_is_an_error(function, message):
    with pytest.raises(jax.errors.JaxRuntimeError, match=message):
        jit(lambda x: call_host(function, jax.ShapeDtypeStruct((2,), float), x))(1.0)


@pytest.mark.parametrize("device", ["processor", "other"])
def test_what_no_program_can_name_and_other_devices_are_served_too(monkeypatch, device):
    host.forget()
    if device == "other":
        monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    function = (lambda x: x + 1) if device == "processor" else written_into
    assert float(jit(lambda x: call_host(function, jax.ShapeDtypeStruct((), float), x))(1.0)) == 2.0
    assert not host._calls


def test_calls_beyond_the_number_that_is_remembered_are_read_again(monkeypatch):
    monkeypatch.setattr(host, "MOST_CALLS", 1)
    host.forget()
    like = {"x": jax.ShapeDtypeStruct((), float)}
    times = [functools.partial(mirrored, by=by) for by in (2.0, 3.0)]
    calls = [jit(lambda x, of=of: call_host(of, like, {"x": x})["x"]) for of in times]
    assert [float(call(1.0)) for call in (*calls, *calls)] == [2.0, 3.0, 2.0, 3.0]
    assert len(host._calls) == 1


COUNTED = []


def counted(number: np.ndarray, *, interrupts: bool):
    COUNTED.append(float(number))
    if interrupts and number == 3.0:
        signal.raise_signal(signal.SIGINT)
    return number + 1.0


@pytest.fixture
def interruptions():
    """A function that says what becomes of them: a shell may have started the tests with interruptions ignored."""
    before = signal.getsignal(signal.SIGINT)
    yield functools.partial(signal.signal, signal.SIGINT)
    signal.signal(signal.SIGINT, before)


def many(start, interrupts):
    call, like = functools.partial(counted, interrupts=interrupts), jax.ShapeDtypeStruct((), float)
    return jax.lax.fori_loop(0, 20_000, lambda _, x: call_host(call, like, x), start)


def test_an_interruption_that_the_process_ignores_ends_no_program(interruptions):
    """As of a job in the background of a shell, or under nohup."""
    interruptions(signal.SIG_IGN)
    assert float(jit(functools.partial(many, interrupts=True))(jnp.array(0.0))) == 20_000
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


@pytest.mark.parametrize("again", [False, True])
def test_an_interruption_ends_a_program_and_is_told(again, interruptions):
    """Pressed while the host answers; heard by this thread, whichever thread the program runs in."""
    interruptions(signal.default_int_handler)
    programs = {interrupts: jit(functools.partial(many, interrupts=interrupts)) for interrupts in (False, True)}
    for _ in range(1 + again):
        COUNTED.clear()
        with pytest.raises(KeyboardInterrupt):
            programs[True](jnp.array(0.0))
        assert 4 <= len(COUNTED) < 20_000
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert float(programs[False](jnp.array(0.0))) == 20_000


def handled(number: np.ndarray):
    COUNTED.append(signal.getsignal(signal.SIGINT))
    return number


def test_a_program_whose_part_was_traced_for_another_holds_interruptions_back_too(interruptions):
    interruptions(signal.default_int_handler)
    part = jit(lambda x: call_host(handled, jax.ShapeDtypeStruct((), float), x))
    COUNTED.clear()
    for by in (2.0, 3.0):
        assert float(jit(lambda x, by=by: by * part(x))(jnp.array(1.0))) == by
    assert len(COUNTED) == 2
    assert signal.default_int_handler not in COUNTED
