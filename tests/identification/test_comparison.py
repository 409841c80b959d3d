"""Two models against the scatter of measurements, in closed form."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from cases.mechanisms import cart_on_rod
from scipy.stats import chi2, norm

import flexmb as fm
from flexmb import planar
from flexmb.mechanisms import mechanism_path


def cart(stiffness, mass=4.0, parts=1):
    return cart_on_rod(stiffness, mass, parts=parts).build()


def test_the_distance_of_two_models_in_deviations():
    # Stiffness 100 and 104, mass 4 and 4.02.
    expected = {"scale": fm.measured("mass", 4.0, 0.01), "gauge": fm.measured("stiffness cart.x", 101.0, 2.0)}
    found = fm.compare(cart(100.0), cart(104.0, 4.02), expected)
    assert found.in_deviations["scale"] == pytest.approx([-2.0], rel=1e-9)
    assert found.in_deviations["gauge"] == pytest.approx([-2.0], rel=1e-9)
    assert found.difference["gauge"] == pytest.approx([-4.0], rel=1e-9)
    assert found.distance == pytest.approx(np.sqrt(8), rel=1e-9)
    assert found.correct == pytest.approx(norm.cdf(np.sqrt(2)), rel=1e-9)
    assert not found.told_apart
    assert found.chi_squared == pytest.approx((0.25, 4 + 2.25), rel=1e-9)
    assert found.probability == pytest.approx(tuple(chi2.sf([0.25, 6.25], 2)), rel=1e-9)
    assert fm.compare(cart(100.0), cart(104.0, 4.02), expected, level=0.9).told_apart
    assert "fits better" in fm.compare(cart(100.0), cart(104.0, 4.02), expected, level=0.9).reason


def test_before_anything_is_measured():
    found = fm.compare(cart(100.0), cart(100.5), {"stiffness cart.x": 2.0, "mass": 0.1})
    assert found.worst == ("stiffness cart.x", pytest.approx(0.25))
    assert np.isnan(found.chi_squared[0])
    assert "less than half of their scatter" in str(found)
    assert "told apart: with a probability of 0.55" in str(found)


def test_the_right_model_is_chosen_as_often_as_stated():
    """Of 2000 drawn data sets; four deviations of a binomial number."""
    a, b = cart(100.0), cart(103.0)
    found = fm.compare(a, b, {"stiffness cart.x": 2.0})
    drawn = 100 + 2 * np.random.default_rng(0).standard_normal(2000)
    right = np.mean(np.abs(drawn - 100) < np.abs(drawn - 103))
    assert right == pytest.approx(found.correct, abs=4 * np.sqrt(0.2 / 2000))


def test_correlated_data_hide_what_they_share():
    def twice(model):
        return fm.stiffness(model, "cart", "x") * np.ones(2)

    covariance = 4 * np.array([[1.0, 0.9], [0.9, 1.0]])
    found = fm.compare(cart(100.0), cart(104.0), fm.measured(twice, [100, 100], covariance=covariance))
    difference = np.array([-4.0, -4.0])
    assert found.distance**2 == pytest.approx(difference @ np.linalg.solve(covariance, difference), rel=1e-9)


def test_parameters_of_measurements_have_values():
    data = fm.measured(lambda model, gain: gain * fm.stiffness(model, "cart", "x"), 200.0, 1.0, name="gauge")
    found = fm.compare(cart(100.0), cart(101.0), data, parameters={"gain": 2.0})
    assert found.difference["gauge"] == pytest.approx([-2.0])
    with pytest.raises(ValueError, match="takes the parameter 'gain': give its value"):
        fm.compare(cart(100.0), cart(101.0), data)


def test_wrong_questions_are_named():
    with pytest.raises(fm.ModelError, match="`model_b` must be a Model"):
        fm.compare(cart(100.0), cart, {"mass": 0.1})  # type: ignore
    with pytest.raises(ValueError, match="has no deviation"):
        fm.compare(cart(100.0), cart(101.0), fm.measured("mass", 4.0))
    with pytest.raises(ValueError, match=r"deviation of -0\.1"):
        fm.compare(cart(100.0), cart(101.0), {"mass": -0.1})
    with pytest.raises(ValueError, match="SI units"):
        fm.compare(cart(100.0), cart(101.0), fm.measured("mass", 4000.0, 1.0))
    with pytest.raises(ValueError, match="level"):
        fm.compare(cart(100.0), cart(101.0), {"mass": 0.1}, level=1.5)
    turned = fm.measured(lambda model: jnp.array([1.0 + 2.0j]), 1.0, 0.1, name="response")
    with pytest.raises(ValueError, match="'response' must be real"):
        fm.compare(cart(100.0), cart(101.0), turned)


def test_phases_differ_by_less_than_half_a_turn():
    """Far above the resonance both responses have the opposite phase of the measured one, by a little more or less."""

    def phase(model, angle):
        stiffness = fm.stiffness(model, "cart", "x")
        return jnp.array([0.0, jnp.where(stiffness > 100.5, angle, -angle)])

    data = dataclasses.replace(
        fm.measured(phase, [0.0, 0.0], 0.1, name="response"), relative=True, parameters=("angle",)
    )
    found = fm.compare(cart(100.0), cart(101.0), data, parameters={"angle": 3.1})
    assert found.difference["response"] == pytest.approx([0.0, 2 * np.pi - 6.2])
    assert found.distance == pytest.approx((2 * np.pi - 6.2) / 0.1)


@pytest.mark.slow
def test_a_measured_mode_without_partner_is_named():
    def two(first):
        b = fm.Builder()
        for name, place in {"wall": 0, "left": 1, "right": 2}.items():
            b.node(name, (place, 0))
        for p, q, stiffness in (("wall", "left", first), ("left", "right", 150.0)):
            b.add(planar.truss, p, q, name=f"{p} to {q}", section=fm.Rigidity(EA=stiffness))
        b.fix("wall")
        for name in ("left", "right"):
            b.fix(name, "y")
            b.mass(name, 2.0)
            b.dof(name, "x")
        return b.build()

    shapes = np.array([[1.0], [-0.35]])
    data = fm.measured_modes([1.0], 0.1, shapes=shapes, at=["left.x", "right.x"], among=1)
    with pytest.raises(ValueError, match="has no partner in the model"):
        fm.compare(two(200.0), two(210.0), data)


@pytest.mark.slow
def test_a_lean_model_against_the_scatter_of_data():
    full = fm.read_spacar(mechanism_path("pf3d19dof")).builder.build()
    small = fm.lean(full, bandwidth=100.0, tolerance=0.01, deviations={"frequency 1": 0.05})
    shift = float(fm.frequencies(small.model)[0] - fm.frequencies(full)[0]) / 0.05
    assert small.in_deviations == {"frequency 1": pytest.approx(shift, rel=1e-6)}
    assert f"Against the scatter of measurements: frequency 1 {shift:+.2g} deviations." in str(small)
    assert fm.compare(small.model, full, {"frequency 1": 0.05}).distance == pytest.approx(abs(shift), rel=1e-6)
    with pytest.warns(fm.FlexmbWarning, match="more than half of the scatter in 'frequency 1'"):
        fm.lean(full, bandwidth=100.0, tolerance=0.01, deviations={"frequency 1": 0.001})
    with pytest.raises(fm.ModelError, match="positive"):
        fm.lean(full, bandwidth=100.0, deviations={"frequency 1": 0.0})
