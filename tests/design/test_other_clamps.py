"""Sweeps and searches over designs whose leaf springs are clamped in some and not in others: as each is built alone."""

import jax.core
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import spatial

MATERIAL = fm.Material(E=210e9, G=80e9, rho=7850)
LEAF = spatial.leaf_spring(order=2)


def stepped(thick, turn=0.0):
    return described(thick, turn).build()


def described(thick, turn=0.0, beside=LEAF):
    """A leaf spring of 0.5 mm and one beside it, which clamps it from 1.5 mm on, or folds it from five degrees on."""
    b = fm.Builder()
    b.node("foot", (0.0, 0.0, 0.0))
    b.node("step", (0.0, 0.0, 0.03))
    b.node("top", (0.0, 0.03 * jnp.sin(turn), 0.03 + 0.03 * jnp.cos(turn)))
    for i, (p, q, t) in enumerate((("foot", "step", 0.5e-3), ("step", "top", thick))):
        section = fm.Rectangle(30e-3, t, MATERIAL)
        element = beside if i else LEAF
        b.add(element, p, q, name=f"leaf {i}", section=section, y=(1, 0, 0))
    b.fix("foot")
    return b


def twist(model):
    return fm.stiffness(model, "top", "rz")


DESIGNS = {"thick": np.array([0.6e-3, 2e-3, 0.6e-3]), "turn": np.array([0.0, 0.0, 0.2])}


@pytest.fixture(scope="module")
def alone():
    return np.array([twist(stepped(*design)) for design in zip(*DESIGNS.values(), strict=True)])


@pytest.mark.slow
def test_a_sweep_has_each_design_as_it_is_built_alone(alone):
    assert alone[1] > 2 * alone[0]
    found = fm.sweep(stepped, {"twist": twist}, DESIGNS)
    np.testing.assert_array_equal(found.codes, 0)
    # Round-off of the stiffness.
    np.testing.assert_allclose(found["twist"], alone, rtol=1e-9)


@pytest.mark.slow
def test_widths_at_an_angle_and_warping_that_is_held_are_no_other_clamps():
    def build(length):
        b = fm.Builder()
        for name, z in (("foot", 0.0), ("step", 0.03), ("top", 0.03 + length)):
            b.node(name, (0.0, 0.0, z))
        for p, q, y in (("foot", "step", (1, 0, 0)), ("step", "top", (0.9, 0.45, 0))):
            b.add(spatial.leaf_spring(order=2), p, q, section=fm.Rectangle(30e-3, 0.5e-3, MATERIAL), y=y)
        b.fix("foot")
        return b.build()

    with pytest.warns(fm.FlexmbWarning, match="meet with their widths at an angle"):
        found = fm.sensitivities(build, {"mass": fm.mass}, {"length": 0.03})
    assert found.values[0] == approx(0.06 * 30e-3 * 0.5e-3 * 7850)

    def held(thick):
        b = described(thick)
        b.fix("step.warping")
        return b.build()

    found = fm.sensitivities(held, {"mass": fm.mass}, {"thick": 0.5e-3})
    assert found.values[0] == approx(0.06 * 30e-3 * 0.5e-3 * 7850)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
def test_what_another_structure_cannot_answer_stops_no_other_design():
    """A thick beam holds the warping of a leaf spring, which then is no degree of freedom."""

    def beside_a_beam(thick):
        return described(thick, beside=spatial.beam).build()

    def frequencies(model):
        return jnp.ones(model.topology.n_q)

    def like(model):
        if model.topology.n_q != first:
            raise ValueError("another number of degrees of freedom")
        return 1.0

    def picky(thick):
        if float(thick) > 1e-3 if not isinstance(thick, jax.core.Tracer) else False:
            raise fm.ModelError("too thick")
        return beside_a_beam(thick)

    thick = {"thick": np.array([0.6e-3, 2e-3])}
    first = beside_a_beam(0.6e-3).topology.n_q
    for answer in (frequencies, like):
        found = fm.sweep(beside_a_beam, {"f": answer}, thick)
        np.testing.assert_array_equal(found.codes, [0, fm.RESULTS.other_clamps])
    found = fm.sweep(picky, {"mass": fm.mass}, thick)
    np.testing.assert_array_equal(found.codes, [0, fm.RESULTS.impossible_design])


@pytest.mark.slow
def test_a_search_leaves_out_what_is_clamped_otherwise(alone):
    between = alone[:2].mean()
    with pytest.warns(fm.FlexmbWarning, match="left out designs whose leaf springs are clamped differently"):
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
