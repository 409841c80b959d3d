"""Traced functions are kept on disk, and taken from there by what they depend on alone."""

import dataclasses
import functools
import random
import time

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.math import kept
from flexmb.math.compile import compile_thoroughly, jit, jit_beside_options
from flexmb.math.fingerprint import UnknownError, fingerprint
from flexmb.solvers.rosenbrock import Rodas5P


@pytest.fixture
def folder(tmp_path):
    """Where traces are kept, as with ``fm.enable_cache()``."""
    compile_thoroughly(True)
    kept.keep_traces(tmp_path)
    yield tmp_path
    kept.keep_traces(None)
    compile_thoroughly(False)


@pytest.fixture
def written(monkeypatch):
    """Files that were written."""
    names, write = [], kept._write

    def noted(path, *others):
        names.append(path)
        return write(path, *others)

    monkeypatch.setattr(kept, "_write", noted)
    return names


def scaled(by):
    return jit(lambda x: (by * x, {"square": x**2}))


def test_a_second_process_takes_what_the_first_kept(folder, written):
    x = jnp.arange(3.0)
    first = scaled(2.0)(x)
    jax.clear_caches()  # what a new process starts with
    second = scaled(2.0)(x)
    assert len(written) == 1
    assert len(list(folder.iterdir())) == 1
    np.testing.assert_array_equal(second[0], first[0])
    np.testing.assert_array_equal(second[1]["square"], [0.0, 1.0, 4.0])


def test_other_constants_shapes_and_options_are_other_files(folder, written):
    x = jnp.arange(3.0)
    np.testing.assert_array_equal(scaled(2.0)(x)[0], 2 * x)
    np.testing.assert_array_equal(scaled(3.0)(x)[0], 3 * x)
    np.testing.assert_array_equal(scaled(3.0)(x[:2])[0], 3 * x[:2])
    raised = jit(lambda x, *, power: x**power)
    np.testing.assert_array_equal(raised(x, power=2), x**2)
    np.testing.assert_array_equal(raised(x, power=3), x**3)
    assert len(set(written)) == 5


def test_derivatives_and_batches_go_through(folder):
    double = scaled(2.0)
    assert jax.grad(lambda x: jnp.sum(double(x)[0]))(jnp.ones(2)).tolist() == [2.0, 2.0]
    assert jax.vmap(lambda x: double(x)[0])(jnp.ones((2, 3))).shape == (2, 3)


class Amplitude:
    """State that nobody can see from outside."""

    def __init__(self, value):
        self.value = value


def test_what_cannot_be_known_is_traced_each_time(folder, written):
    amplitude = Amplitude(2.0)
    assert float(jit(lambda x: amplitude.value * x)(jnp.array(1.0))) == 2.0
    assert not written
    assert not list(folder.iterdir())


def test_a_damaged_file_is_made_anew(folder, written, caplog):
    x = jnp.arange(3.0)
    scaled(2.0)(x)
    (file,) = folder.iterdir()
    file.write_bytes(b"no trace")
    jax.clear_caches()
    np.testing.assert_array_equal(scaled(2.0)(x)[0], 2 * x)
    assert len(written) == 2
    assert "made anew" in caplog.text


def test_leaves_beside_arrays_choose_the_file(folder, written):
    apply = jit_beside_options(lambda function, x: function(x))
    x = jnp.ones(2)
    for factor in (2.0, 3.0):
        np.testing.assert_array_equal(apply(lambda x, f=factor: f * x, x), factor * x)
    assert len(set(written)) == 2


SCALE = 2.0


def test_fingerprint_of_functions():
    def by_global(x):
        return SCALE * jnp.sin(x)

    def twice(function):
        return lambda x: function(function(x))

    before = fingerprint(by_global)
    assert before == fingerprint(by_global)
    by_global.__globals__["SCALE"] = 3.0
    assert fingerprint(by_global) != before
    by_global.__globals__["SCALE"] = 2.0
    assert fingerprint(twice(by_global)) != fingerprint(twice(lambda x: x + 1))
    assert fingerprint(lambda t: t + 1) != fingerprint(lambda t: t + 2)
    assert fingerprint(planar.beam) == fingerprint(planar.beam) != fingerprint(planar.truss)
    assert fingerprint(planar.spectral_beam(2)) != fingerprint(planar.spectral_beam(3))
    assert fingerprint(Rodas5P()) != fingerprint(Rodas5P(jumps=True))
    assert fingerprint(np.zeros(2)) != fingerprint(np.ones(2)) != fingerprint(np.ones(2, int))


def importing(x):
    import json

    return json.loads(x)


def counting(x):
    global SCALE
    SCALE = x
    return x


def before_it_is_there():
    def function(x):
        return later * x

    refused = [function]
    if not refused:
        later = 1.0
    return function


@jax.custom_jvp
def with_its_own_derivative(x):
    return x


@pytest.mark.parametrize(
    "thing",
    [
        Amplitude(1.0),
        Amplitude(1.0).__init__,
        np.array([Amplitude(1.0)], object),
        importing,
        counting,
        before_it_is_there(),
        with_its_own_derivative,
        lambda: random.random(),
        lambda x: np.load(x),
        lambda x: getattr(np, x),
        lambda x: [open(x) for x in x],
        time.time,
        time,
    ],
)
def test_what_may_change_unseen_has_no_fingerprint(thing):
    with pytest.raises(UnknownError):
        fingerprint(thing)


@functools.partial(jax.tree_util.register_dataclass, data_fields=["value"], meta_fields=["mark"])
@dataclasses.dataclass
class Marked:
    """Record with a static part that is equal to itself alone."""

    value: jax.Array
    mark: Amplitude


def test_a_result_that_is_only_equal_to_itself_is_not_kept(folder):
    mark = Amplitude(2.0)
    assert kept._write(folder / "one.trace", lambda x: Marked(2 * x, mark), [jnp.ones(2)]) is None
    assert not list(folder.iterdir())


def test_a_simulation_is_kept_and_right(folder, written, monkeypatch):
    """Pendulum by its own function of time: the kept program gives what the traced one gives.

    It is kept although equinox was imported before, in its own setting.
    """
    monkeypatch.delenv("EQX_ON_ERROR")
    monkeypatch.setattr("equinox._errors.EQX_ON_ERROR", "raise")
    fm.enable_cache(folder)
    kept.keep_traces(folder)
    b = fm.Builder()
    b.gravity((0.0, -9.81))
    b.node("pivot", (0.0, 0.0))
    b.node("bob", (1.0, 0.0))
    b.add(planar.truss, "pivot", "bob", section=fm.Rigidity(mass=0.0), released=())
    b.fix("pivot")
    b.mass("bob", 1.0)
    model, times = b.build(), np.linspace(0, 0.5, 3)

    def push(t):
        return 0.5 * jnp.sin(3 * t)

    first = fm.simulate(model, times, loads={"bob.x": push}).x
    count = len(written)
    assert count >= 1
    jax.clear_caches()
    second = fm.simulate(model, times, loads={"bob.x": push}).x
    assert len(written) == count
    np.testing.assert_array_equal(first, second)
    third = fm.simulate(model, times, loads={"bob.x": lambda t: 0.0 * t}).x
    assert len(written) > count
    assert np.abs(third - first).max() > 1e-3
