"""Equations solved by factors on the host, against NumPy's dense solution."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.mechanics.sparse_order import order_of

SECTION = fm.Rigidity(EA=1e4, EIy=1.0, mass=1.0)


def wheel(spokes: int, held=False):
    """A ring of beams about a hub; or the hub alone with one spoke, whose length may be held."""
    b = fm.Builder()
    b.node("hub", (0.0, 0.0))
    names = [f"n{i}" for i in range(spokes)]
    for name, angle in zip(names, np.linspace(0, 2 * np.pi, spokes, endpoint=False), strict=True):
        b.node(name, (np.cos(angle), np.sin(angle)))
        b.add(planar.beam, "hub", name, section=SECTION, released=[2, 3] if held else None)
    for p, q in zip(names, names[1:] + names[:1], strict=True) if spokes > 2 else ():
        b.add(planar.beam, p, q, section=SECTION)
    b.fix(names[0])
    return b.build(check=False)


def test_what_is_compiled_for_one_serves_the_next():
    order: Any = order_of(wheel(20).topology)
    again: Any = order_of(wheel(20).topology)
    assert again.places is order.places


@pytest.mark.slow("float")
@pytest.mark.parametrize("kind", [float, complex])
def test_it_is_solved(kind):
    order: Any = order_of(wheel(20).topology)
    draw = np.random.default_rng(0)
    count = order.places.count

    def drawn(*shape):
        return draw.standard_normal(shape) + (1j * draw.standard_normal(shape) if kind is complex else 0)

    pieces = tuple(jnp.asarray(drawn(*own.shape, own.shape[1])) for own in order.unknowns)
    right, diagonal = drawn(count), 10 + drawn(count)
    whole = np.zeros((count + 1, count + 1), kind)
    for own, matrices in zip(order.unknowns, pieces, strict=True):
        for places, matrix in zip(np.asarray(own), np.asarray(matrices), strict=True):
            np.add.at(whole, np.ix_(places, places), matrix)
    whole = whole[:-1, :-1]
    # Inside compiled code, where it is used; 1e-12 is round-off of a hundred operations.
    found = jax.jit(order.solved)(pieces, jnp.asarray(diagonal), right)
    np.testing.assert_allclose(found, np.linalg.solve(whole + np.diag(diagonal), right), atol=1e-12)
    if kind is float:
        np.testing.assert_allclose(order.product(pieces, jnp.asarray(right)), whole @ right, atol=1e-12)
    # Singular equations have no answer, least of all that of the matrix before.
    nothing = tuple(jnp.zeros_like(own) for own in pieces)
    assert not np.any(np.isfinite(order.solved(nothing, jnp.zeros(count, kind), right)))


def test_a_solution_that_does_not_fit_lets_rows_change_places(monkeypatch):
    order: Any = order_of(wheel(20).topology)
    places, count = order.places, order.places.count
    entries = np.concatenate(
        [*(np.zeros(own.size * own.shape[1]) for own in order.unknowns), np.arange(1.0, count + 1)]
    )
    # Round-off.
    np.testing.assert_allclose(places.solution(entries, np.ones(count)), 1 / np.arange(1.0, count + 1), rtol=1e-15)
    assert not places._known(entries).by_rows
    monkeypatch.setattr("flexmb.math.sparse.BACKWARD_ERROR", -1.0)
    np.testing.assert_allclose(places.solution(entries, np.ones(count)), 1 / np.arange(1.0, count + 1), rtol=1e-15)
    assert places._known(entries).by_rows
