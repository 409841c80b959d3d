"""What of functions and models is seen: the same is the same anew, and what can be seen to differ differs."""

import dataclasses
import functools
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb.design.identity import identity

NUMBER = 1.0
NOTES: list[float] = []


def power(exponent):
    return lambda a: a**exponent


def scaled(a, by=2.0):
    return by * a


def of_global(a):
    return NUMBER * a


def noting(a):
    NOTES.append(a)
    return a


def outer(a):
    return of_global(a) + 1


def itself(a):
    return itself(a - 1) if a else 0


@dataclasses.dataclass(frozen=True)
class Asked:
    kind: str
    value: int

    def __call__(self, a):
        return a


class Unwilling:
    def __repr__(self):
        raise RuntimeError


def with_thickness(t):
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.add(fm.planar.truss, "a", "b", section=fm.Rectangle(1.0, t, fm.Material(E=1.0, G=1.0)))
    b.fix("a")
    b.fix("b", "y")
    return b.build()


@pytest.mark.parametrize(
    "make",
    [
        lambda: power(2),
        lambda: power(np.array([1.0, 2.0])),
        lambda: power(jnp.arange(3.0)),
        lambda: functools.partial(scaled, by=3.0),
        lambda: lambda a: a + 1,
        lambda: lambda a: {"x", "y", "z"},
        lambda: Asked("frequency", 1),
        lambda: jax.jit(power(3)),
        lambda: itself,
        lambda: with_thickness(0.1),
        lambda: (1, 2.5, "x", None, b"y", 10**6000, {3, 4}, Path("a") / "b"),
        lambda: Unwilling(),
        lambda: jax.random.key(1),
    ],
    ids=range(13),
)
def test_the_same_made_anew(make):
    assert identity(make()) == identity(make())


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (power(2), power(3)),
        (power(2), power(2.0)),
        (power(np.array([1.0, 2.0])), power(np.array([1.0, 2.5]))),
        (functools.partial(scaled, by=3.0), functools.partial(scaled, by=4.0)),
        (lambda a: a + 1, lambda a: a + 2),
        (lambda a: a + 1, lambda a: a - 1),
        (lambda a: jnp.sin(a), lambda a: jnp.cos(a)),
        (lambda a, by=1: by * a, lambda a, by=2: by * a),
        (Asked("frequency", 1), Asked("load_multiplier", 1)),
        (jax.jit(power(2)), jax.jit(power(3))),
        (with_thickness(0.1), with_thickness(0.2)),
        (1, True),
        (10**6000, 10**6000 + 1),
        ((1, (2,)), ((1, 2),)),
        (("ab", "c"), ("a", "bc")),
        (Path("a/x.dat"), Path("a/y.dat")),
    ],
    ids=range(16),
)
def test_what_differs(one, other):
    assert identity(one) != identity(other)


def test_a_global_that_is_named(monkeypatch):
    before = identity(outer)
    monkeypatch.setattr(f"{__name__}.NUMBER", 2.0)
    assert identity(outer) != before


def test_notes_that_a_function_takes_are_no_part_of_it():
    before = identity(noting)
    noting(1.0)
    assert identity(noting) == before
