"""Sweeps and searches over designs whose leaf springs are clamped in some and not in others: as each is built alone."""

import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import spatial

MATERIAL = fm.Material(E=210e9, G=80e9, rho=7850)


def stepped(thick, turn=0.0):
    """A leaf spring of 0.5 mm and one beside it, which clamps it from 1.5 mm on, or folds it from five degrees on."""
    b = fm.Builder()
    b.node("foot", (0.0, 0.0, 0.0))
    b.node("step", (0.0, 0.0, 0.03))
    b.node("top", (0.0, 0.03 * jnp.sin(turn), 0.03 + 0.03 * jnp.cos(turn)))
    for i, (p, q, t) in enumerate((("foot", "step", 0.5e-3), ("step", "top", thick))):
        section = fm.Rectangle(30e-3, t, MATERIAL)
        b.add(spatial.leaf_spring(order=2), p, q, name=f"leaf {i}", section=section, y=(1, 0, 0))
    b.fix("foot")
    return b.build()


def twist(model):
    return fm.stiffness(model, "top", "rz")


DESIGNS = {"thick": np.array([0.6e-3, 2e-3, 0.6e-3]), "turn": np.array([0.0, 0.0, 0.2])}


@pytest.fixture(scope="module")
def alone():
    return np.array([twist(stepped(*design)) for design in zip(*DESIGNS.values(), strict=True)])


def test_a_sweep_has_each_design_as_it_is_built_alone(alone):
    assert alone[1] > 2 * alone[0]
    for order in ([0, 1, 2], [1, 2, 0]):
        found = fm.sweep(stepped, {"twist": twist}, {name: values[order] for name, values in DESIGNS.items()})
        np.testing.assert_array_equal(found.codes, 0)
        # Round-off of the stiffness.
        np.testing.assert_allclose(found["twist"], alone[order], rtol=1e-9)


def test_a_search_leaves_out_what_is_clamped_otherwise(alone):
    between = alone[:2].mean()
    with pytest.warns(fm.FlexmbWarning, match="has left out designs whose leaf springs are clamped otherwise"):
        found = fm.tune(
            stepped,
            {"twist": twist},
            {"thick": 2e-3},
            {"thick": (0.6e-3, 2.5e-3)},
            targets={"twist": between},
            max_evaluations=15,
            throw=False,
        )
    assert found.dimensions["thick"] >= 1.5e-3 * (1 - 1e-9)
