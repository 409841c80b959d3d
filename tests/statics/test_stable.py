"""An equilibrium that is not stable is told: beyond Euler's loads, on its head, and by a determinant."""

import warnings

import jax
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.statics.chain import chain_of
from flexmb.statics.stable import unstable_motions

# Euler's load of a clamped column whose other end is free, EI = L = 1; its next is nine times that.
EULER = np.pi**2 / 4
# Which columns are solved by dense matrices, in the order of a chain, and by sparse factors: bars join their tips, so
# that they sway together, each in its own shape. Where all are joined to one, a level has more unknowns than a chain's.
WAYS = {
    "dense": {"count": 6},
    "chain": {"count": 45},
    "chain without stretch": {"count": 45, "released": (2, 3)},
    "chain of columns": {"count": 3, "columns": 9},
    "sparse": {"count": 3, "columns": 9, "star": True},
}


def columns(count, load, columns=1, star=False, released=None):
    b = fm.Builder()
    section = fm.Rigidity(EA=1e6, EIy=1.0)
    for k in range(columns):
        for i in range(count + 1):
            b.node(f"{k}.{i}", (i / count, k))
        for i in range(count):
            b.add(planar.beam, f"{k}.{i}", f"{k}.{i + 1}", section=section, released=released)
        b.fix(f"{k}.0")
        b.force(f"{k}.{count}", (-load, 0.0))
        if k:
            b.add(planar.truss, f"{0 if star else k - 1}.{count}", f"{k}.{count}", section=section)
    return b.build(check=columns == 1)


def column(count, load, elements=planar, **rigidity):
    b = fm.Builder()
    across = (0.0,) * (1 if elements is planar else 2)
    for i in range(count + 1):
        b.node(f"n{i}", (i / count, *across))
    for i in range(count):
        b.add(elements.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e6, **rigidity))
    b.fix("n0")
    b.fix("n0.rotation")
    b.force(f"n{count}", (-load, *across))
    return b.build()


def told(model, **how):
    """Warnings of an equilibrium."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        found = fm.equilibrium(model, **how)
    assert found.result == fm.RESULTS.successful
    return [str(w.message) for w in heard]


@pytest.mark.parametrize("way", WAYS)
# Columns of three cubic beams buckle 3e-4 late; at twice the first load no motion is soft.
@pytest.mark.parametrize(("share", "unstable"), [(0.99, False), (-5.0, False), (1.01, True), (2.0, True), (8.0, True)])
def test_straight_columns(way, share, unstable):
    model = columns(load=share * EULER, **WAYS[way])
    assert (chain_of(model.topology) is None) == (way == "sparse")
    found = told(model, sparse=way != "dense")
    assert len(found) == unstable
    assert all("The equilibrium is not stable: its stiffness is negative" in text for text in found)


def test_motions_are_counted_and_named():
    load = 1.1 * EULER
    (planar_one,) = told(column(6, load, EIy=1.0))
    assert "in 1 motion (n6.rotation.phi, " in planar_one
    assert "in 2 motions (" in told(column(6, 9.1 * EULER, EIy=1.0))[0]
    # Both ways at once: an even number of negative ones, which no determinant shows.
    square = column(4, load, spatial, EIy=1.0, EIz=1.0, GIt=1.0)
    assert "in 2 motions (" in told(square)[0]
    assert len(told(square, sparse=True)) == 1


@pytest.mark.parametrize(("height", "unstable"), [(1.0, True), (-1.0, False)])
def test_a_body_on_its_head(height, unstable):
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("mass", (0, height))
    b.rotation("rod")
    b.add(planar.rigid_beam, "pivot", "rod", "mass")
    b.fix("pivot", "x", "y")
    b.mass("mass", 1.0)
    b.gravity((0, -9.81))
    b.dof("rod", "phi")
    assert len(told(b.build())) == unstable


def test_equilibria_that_follow_one_another():
    with pytest.warns(fm.FlexmbWarning, match="Of 4 equilibria 2 are not stable, the first of them number 2: "):
        fm.equilibria(column(6, EULER, EIy=1.0), load_factor=[0.5, 0.99, 1.01, 1.5])


def test_where_numbers_are_traced_nothing_is_told():
    tip = jax.jit(lambda load: fm.equilibrium(column(6, load, EIy=1.0)).at("n6"))(1.5 * EULER)
    # Straight, shorter by P/EA.
    np.testing.assert_allclose(tip, [1 - 1.5e-6 * EULER, 0], rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("stiffness", "structural", "symmetric", "count"),
    [
        ([[2.0, 0.0], [0.0, -1.0]], 1.0, True, 1),
        # Of a force that follows, as Beck's: negative in some motion is the symmetric part, not the determinant.
        ([[1.0, 4.0], [0.0, 1.0]], 1.0, False, 0),
        ([[1.0, 4.0], [1.0, 1.0]], 1.0, False, 1),
        # Beside the structural stiffness it is a critical state; and beside the largest, round-off.
        ([[1.0, 1.0 + 1e-8], [1.0 + 1e-8, 1.0]], 1.0, True, 0),
        ([[1.0, 1.0 + 1e-8], [1.0 + 1e-8, 1.0]], 0.0, True, 1),
        ([[1.0, 1.0 + 1e-12], [1.0 + 1e-12, 1.0]], 0.0, True, 0),
    ],
)
def test_signs_of_a_stiffness(stiffness, structural, symmetric, count):
    found = unstable_motions(np.array(stiffness), structural * np.eye(2), symmetric)
    assert found.shape == (2, count)
    if count:
        k = np.array(stiffness)
        assert found[:, 0] @ k @ found[:, 0] < 0
