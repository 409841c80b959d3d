"""Functions of a user's own element that refer to numbers outside: no answer mixes numbers of before and after."""

import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

STIFFNESS, MASS, FORCE = 100.0, 2.0, 5.0


def elongation(p: fm.Point2, q: fm.Point2, *, ref):
    return planar.truss.deformation(p, q, ref=ref)


def law(e, e_dot, *, ref):
    return jnp.asarray(STIFFNESS) * e


SPRING = fm.Element(elongation, law=law)


def built():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("mass", (1, 0))
    b.add(SPRING, "wall", "mass", name="spring")
    b.fix("wall")
    b.fix("mass", "y")
    b.mass("mass", MASS)
    b.force("mass", (FORCE, 0))
    return b.build()


def displacement(model):
    return float(fm.equilibrium(model).at("mass")[0]) - 1


def frequency(model):
    """In rad/s."""
    return float(fm.frequencies(model)[0]) * 2 * np.pi


def stretched(model):
    """After a tenth of a second from rest."""
    return float(fm.simulate(model, [0.0, 0.1]).at("mass")[-1, 0]) - 1


def test_a_model_answers_for_what_its_elements_meant_when_it_was_built(monkeypatch):
    before = built()
    assert displacement(before) == pytest.approx(FORCE / STIFFNESS)
    monkeypatch.setitem(globals(), "STIFFNESS", 400.0)
    after = built()
    assert displacement(after) == pytest.approx(FORCE / 400.0)
    assert frequency(after) == pytest.approx((400.0 / MASS) ** 0.5)
    # What is compiled keeps its number; what has to be derived anew would have the other one.
    assert displacement(before) == pytest.approx(FORCE / 100.0)
    with pytest.raises(fm.ModelError, match=r"'elongation'.* its law refers to has changed since the model was built"):
        stretched(before)
    monkeypatch.setitem(globals(), "STIFFNESS", 100.0)
    assert stretched(before) == pytest.approx(FORCE / 100.0 * (1 - np.cos((100.0 / MASS) ** 0.5 * 0.1)), rel=1e-4)
