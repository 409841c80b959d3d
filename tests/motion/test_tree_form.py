"""Motion where the last ends of spectral beams are computed: the same as in all coordinates, without their closures."""

import jax
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.mechanics.tree import tree_of

TIMES = [0.0, 0.01, 0.02]


def planar_frame(force=2.0):
    """Beams that branch, two of them walked from their last end, and a rigid bar that closes a loop."""
    section = fm.Rigidity(EA=1e3, EIy=1.0, mass=1.0, Jy=0.01)
    b = fm.Builder()
    for name, place in {"a": (0, 0), "b": (1, 0.2), "c": (2, 0), "d": (1, 1), "e": (2, 1)}.items():
        b.node(name, place)
    for p, q in ("ba", "bc", "db", "de"):
        b.add(planar.spectral_beam(2), p, q, section=section, name=p + q)
    b.add(planar.beam, "c", "e", section=section, released=(), name="ce")
    b.fix("a")
    b.mass("c", 1.0)
    b.force("e", (1.0, force))
    b.gravity((0, -9.81))
    return b.build()


def spatial_branch():
    """Three beams from one node, one of them bent and walked from its last end."""
    section = fm.Rigidity(EA=1e3, EIy=1.0, EIz=2.0, GIt=1.0, mass=1.0, Jx=0.1, Jy=0.1, Jz=0.1)
    b = fm.Builder()
    for name, place in {"a": (0, 0, 0), "b": (1, 0.2, 0), "c": (2, 0, 0.3)}.items():
        b.node(name, place)
    b.add(spatial.spectral_beam(2), "b", "a", section=section, name="ba", curvature=(0, 0.3, 0.2), y=(0, 1, 0))
    b.add(spatial.spectral_beam(2), "b", "c", section=section, name="bc", y=(0, 1, 0))
    b.fix("a")
    b.mass("c", 1.0)
    b.force("c", (1.0, 2.0, 30.0))
    b.gravity((0, 0, -9.81))
    return b.build()


@pytest.mark.parametrize(("scene", "multipliers", "dropped"), [(planar_frame, 3, 12), (spatial_branch, 0, 14)])
def test_a_tree_moves_as_all_coordinates_do(scene, multipliers, dropped):
    model = scene()
    tree = tree_of(model.topology)
    assert tree is not None
    assert tree.held_places.shape == (multipliers,)
    assert model.topology.x.free.shape[0] - tree.kept.shape[0] == dropped
    other, found = (fm.simulate(model, TIMES, form=form, rtol=1e-9, atol=1e-12) for form in ("coordinates", "auto"))
    assert (other.form, found.form) == ("coordinates", "tree")
    np.testing.assert_allclose(found.x, other.x, atol=1e-9)
    np.testing.assert_allclose(found.xd, other.xd, atol=1e-6)
    np.testing.assert_allclose(found.near, other.near, atol=1e-9)


def test_derivative_by_a_load():
    def place(force):
        return fm.simulate(planar_frame(force), TIMES[:2], rtol=1e-8).x[-1]

    step = 0.1
    difference = (place(2.0 + step) - place(2.0 - step)) / (2 * step)
    np.testing.assert_allclose(jax.jacfwd(place)(2.0), difference, atol=1e-9)


def test_what_needs_all_coordinates_gets_them():
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.add(planar.beam, "a", "b", section=fm.Rigidity(EA=1e3, EIy=1.0, mass=1.0))
    b.fix("a")
    model = b.build()
    assert tree_of(model.topology) is None
    with pytest.raises(fm.ModelError, match="spectral beam with FIXED closure"):
        fm.simulate(model, TIMES, form="tree")
    with pytest.raises(ValueError, match='controller needs form="coordinates"'):
        fm.simulate(model, TIMES, form="tree", control=abs)
