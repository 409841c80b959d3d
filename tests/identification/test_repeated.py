"""Fits of many sets of values: against closed forms and SciPy, within bounds, with correlated and unknown scatter."""

import numpy as np
import pytest
import scipy.optimize
from cases.mechanisms import cart_on_rod

import flexmb as fm

STIFFNESS, LOADS, SCATTER = 100.0, np.arange(1.0, 6.0), 0.02
SETS = LOADS / STIFFNESS + SCATTER / STIFFNESS * np.random.default_rng(5).standard_normal((80, 5))


def cart(stiffness):
    return cart_on_rod(stiffness, 4.0, 1.0).build()


def line(model):
    return (fm.equilibrium(model).position("cart")[0] - 1) * LOADS


def fitted(bounds=(10.0, 1000.0), loss="linear", **scatter):
    data = fm.measured(line, LOADS / STIFFNESS, name="line", **scatter)
    return fm.fit(cart, data, {"stiffness": 90.0}, {"stiffness": bounds}, loss=loss)


def test_many_sets_with_correlated_scatter_have_their_closed_form():
    covariance = (SCATTER / STIFFNESS) ** 2 * (0.5 * np.eye(5) + 0.5)
    found = fitted(covariance=covariance).again(SETS)
    weights = np.linalg.solve(covariance, LOADS)
    compliance = SETS @ weights / (LOADS @ weights)
    assert np.all(found.converged)
    assert 1 / found.parameters["stiffness"] == pytest.approx(compliance, rel=1e-6)
    assert found.deviation["stiffness"] * compliance**2 == pytest.approx((LOADS @ weights) ** -0.5, rel=1e-6)
    differences = SETS - compliance[:, None] * LOADS
    squares = np.sum(differences * np.linalg.solve(covariance, differences.T).T, axis=1)
    assert found.chi_squared == pytest.approx(squares, rel=1e-8)


def test_many_sets_without_scatter_estimate_it():
    found = fitted().again(SETS)
    compliance = SETS @ LOADS / (LOADS @ LOADS)
    estimate = np.sqrt(np.sum((SETS - compliance[:, None] * LOADS) ** 2, axis=1) / 4 / (LOADS @ LOADS))
    assert found.deviation["stiffness"] * compliance**2 == pytest.approx(estimate, rel=1e-6)


@pytest.mark.parametrize("loss", ["huber", "soft_l1", "cauchy"])
def test_many_sets_with_outliers_are_fitted_as_by_scipy(loss):
    sets = SETS.copy()
    sets[:, 2] += 10 * SCATTER / STIFFNESS
    found = fitted(loss=loss, deviation=SCATTER / STIFFNESS).again(sets)

    def alone(values):
        def differences(compliance):
            return (compliance / STIFFNESS * LOADS - values) / (SCATTER / STIFFNESS)

        best = scipy.optimize.least_squares(differences, 1.0, loss=loss, ftol=1e-14, xtol=1e-14, gtol=1e-12)
        return best.x[0] / STIFFNESS

    assert np.all(found.converged)
    assert 1 / found.parameters["stiffness"] == pytest.approx([alone(values) for values in sets], rel=2e-5)


def test_many_sets_stay_within_bounds():
    compliance = SETS @ LOADS / (LOADS @ LOADS)
    upper = float(np.median(1 / compliance))
    start = min(90.0, 0.9 * upper)
    data = fm.measured(line, LOADS / start, SCATTER / STIFFNESS, name="line")
    found = fm.fit(cart, data, {"stiffness": start}, {"stiffness": (10.0, upper)}).again(SETS)
    assert np.all(found.converged)
    assert found.parameters["stiffness"] == pytest.approx(np.minimum(1 / compliance, upper), rel=1e-6)


def test_undetermined_parameters_of_many_sets_have_infinite_deviations():
    def both(first, second):
        return cart_on_rod(first * second, 4.0, 1.0).build()

    data = fm.measured(line, LOADS / STIFFNESS, SCATTER / STIFFNESS, name="line")
    with pytest.warns(fm.FlexmbWarning, match="do not determine first and second"):
        fit = fm.fit(both, data, {"first": 9.0, "second": 11.0}, {"first": (1.0, 100.0), "second": (1.0, 100.0)})
    found = fit.again(SETS)
    product = found.parameters["first"] * found.parameters["second"]
    assert 1 / product == pytest.approx(SETS @ LOADS / (LOADS @ LOADS), rel=1e-6)
    assert np.all(np.isinf(found.deviation["first"]) & np.isinf(found.deviation["second"]))


@pytest.mark.parametrize("count", [5, len(SETS)])
def test_chi_squared_of_many_sets_is_that_of_a_fit(count):
    robust = fitted(loss="huber", deviation=SCATTER / STIFFNESS).again(SETS[:count])
    differences = LOADS / robust.parameters["stiffness"][:, None] - SETS[:count]
    # Chi-squared of a fit leaves out the robust loss.
    assert robust.chi_squared == pytest.approx(np.sum((differences * STIFFNESS / SCATTER) ** 2, axis=1), rel=1e-8)
    assert np.all(np.isnan(fitted().again(SETS[:count]).chi_squared))


def test_wrong_sets_are_named():
    found = fitted(loss="cauchy", deviation=SCATTER / STIFFNESS)
    gap = SETS.copy()
    gap[3, 1] = np.nan
    for sets, words in (
        (gap, r"Value 2 of set \[3\] is nan\. Leave this set out"),
        (np.full((1, 5), np.inf), r"Value 1 of set \[0\] is inf"),
        (np.zeros((0, 5)), r"Give sets of 5 values each, not an array of \(0, 5\)"),
        (np.zeros((2, 4)), r"Give sets of 5 values each, not an array of \(2, 4\)"),
        (SETS.astype(complex), "Sets of values must be numbers"),
    ):
        with pytest.raises(ValueError, match=words):
            found.again(sets)


@pytest.mark.parametrize("count", [5, len(SETS)])
def test_parameters_of_an_impossible_mechanism_are_no_fit(count):
    def inertia(model):
        return fm.linearize(model).M0[0, 0] * LOADS

    data = fm.measured(inertia, 4 * LOADS, SCATTER, name="inertia")
    fit = fm.fit(lambda mass: cart_on_rod(STIFFNESS, mass, 1.0).build(), data, {"mass": 3.0}, {"mass": (-5.0, 10.0)})
    sets = np.tile(4 * LOADS, (count, 1))
    sets[3] = -LOADS
    found = fit.again(sets)
    assert found.parameters["mass"][:5] == pytest.approx([4, 4, 4, -1, 4])
    assert np.flatnonzero(~found.converged).tolist() == [3]
