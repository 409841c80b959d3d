"""Parameters from measurements, against closed forms of least squares."""

import dataclasses
import warnings
from typing import Any

import jax
import matplotlib.pyplot as plt
import numpy as np
import pytest
from cases.mechanisms import cart_on_rod
from scipy.stats import chi2

import flexmb as fm
from flexmb import planar

STIFFNESS, MASS, LOAD = 100.0, 4.0, 1.0
LOADS = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
BOUNDS = {"stiffness": (10.0, 1000.0), "mass": (0.4, 40.0)}
GUESS = {"stiffness": 70.0, "mass": 5.0}


def cart(stiffness=STIFFNESS, mass=MASS):
    b = cart_on_rod(stiffness, mass, LOAD)
    b.input("cart", "x")
    b.output("cart", "x")
    return b.build()


def moved(model):
    return fm.equilibrium(model).position("cart")[0] - 1


def readings(model, offset):
    """Of a linear spring under several loads, by a sensor with an offset."""
    return moved(model) * LOADS + offset


@pytest.mark.slow
def test_mass_and_stiffness_from_a_frequency_and_a_displacement():
    frequency, shift = np.sqrt(STIFFNESS / MASS) / (2 * np.pi), LOAD / STIFFNESS
    data = {"frequency 1": (frequency, 1e-3 * frequency), "displacement cart.x": (shift, 1e-2 * shift)}
    found = fm.fit(cart, data, GUESS, BOUNDS)
    assert found.result is fm.RESULTS.successful
    assert found.parameters["stiffness"] == pytest.approx(STIFFNESS, rel=1e-7)
    assert found.parameters["mass"] == pytest.approx(MASS, rel=1e-7)
    # k = F/u and m = k/(2 pi f)^2, whose relative deviations add in squares.
    assert found.deviation["stiffness"] == pytest.approx(1e-2 * STIFFNESS, rel=1e-6)
    assert found.deviation["mass"] == pytest.approx(np.hypot(1e-2, 2e-3) * MASS, rel=1e-6)
    correlation = 1e-2 / np.hypot(1e-2, 2e-3)
    assert found.correlation[0, 1] == pytest.approx(correlation, rel=1e-6)
    assert found.freedom == 0
    lower, upper = found.interval("mass")
    assert lower * upper == pytest.approx(MASS**2, rel=1e-6)
    assert np.log(upper / lower) == pytest.approx(2 * 1.959964 * np.hypot(1e-2, 2e-3), rel=1e-6)


def test_a_straight_line_as_its_textbook_formulas_say():
    rng = np.random.default_rng(1)
    values = LOADS / STIFFNESS + 2e-3 + 1e-4 * rng.standard_normal(len(LOADS))
    data = fm.measured(readings, values, over=LOADS, label="load [N]")
    parameters = {"stiffness": 70.0, "offset": 0.0}
    bounds = {"stiffness": (10, 1000), "offset": (-1, 1)}
    empty: Any = []
    found = fm.fit(lambda stiffness: cart(stiffness), data, parameters, bounds, priors=empty)
    slope, offset = np.polyfit(LOADS, values, 1)
    assert 1 / found.parameters["stiffness"] == pytest.approx(slope, rel=1e-7)
    assert found.parameters["offset"] == pytest.approx(offset, rel=1e-6)
    # Without a known scatter it follows from the misfit, of n - 2 degrees of freedom.
    noise = np.sqrt(np.sum((slope * LOADS + offset - values) ** 2) / (len(LOADS) - 2))
    assert found.noise == pytest.approx(noise, rel=1e-6)
    of_slope = noise / np.sqrt(np.sum((LOADS - LOADS.mean()) ** 2))
    assert found.deviation["stiffness"] / found.parameters["stiffness"] == pytest.approx(of_slope / slope, rel=1e-5)
    # Student's t of 3 degrees of freedom.
    lower, upper = found.interval("offset")
    assert (upper - lower) / 2 == pytest.approx(3.182446 * found.deviation["offset"], rel=1e-6)
    assert np.isnan(found.chi_squared)


@pytest.mark.parametrize("stiffness", [1e2, 1e5, 1e8])
def test_the_unit_of_values_without_deviation_does_not_end_the_search(stiffness):
    values = LOADS / stiffness * (1 + 1e-3 * np.array([1.0, -1.0, 2.0, 0.0, -1.0]))
    data = fm.measured(lambda model: moved(model) * LOADS, values, name="line")
    bounds = {"stiffness": (stiffness / 10, 10 * stiffness)}
    found = fm.fit(lambda stiffness: cart(stiffness), data, {"stiffness": 0.7 * stiffness}, bounds)
    # Least squares of a line through zero. A search ends 1e-8 of the bounds from the minimum.
    assert found.parameters["stiffness"] == pytest.approx(np.sum(LOADS**2) / (values @ LOADS), rel=1e-6)
    assert found.minima[0][1] == pytest.approx(found.freedom * found.noise**2, rel=1e-9)


def test_a_combination_that_is_not_determined_is_named():
    frequency = np.sqrt(STIFFNESS / MASS) / (2 * np.pi)
    data = {"frequency 1": (frequency, 1e-3 * frequency), "again": fm.measured("frequency 1", frequency, 1e-3)}
    with pytest.warns(fm.FlexmbWarning, match="do not determine"):
        found = fm.fit(cart, data, GUESS, BOUNDS)
    assert len(found.undetermined) == 1
    combination = found.undetermined[0]
    assert set(combination.names) == {"stiffness", "mass"}
    assert combination.change == pytest.approx([1.0, 1.0], rel=1e-6)
    assert any("^-1 is determined" in text for text in combination.determined)
    assert np.isinf(combination.deviation)
    assert np.isinf(found.deviation["mass"])
    assert np.isinf(found.deviation["stiffness"])
    assert found.interval("mass") == (0.0, np.inf)
    # The frequency itself is known all the same, a displacement is not.
    answers = found.predict(["frequency 1", "displacement cart.x"])
    assert answers["frequency 1"].deviation == pytest.approx(1 / np.hypot(1 / (1e-3 * frequency), 1e3), rel=1e-6)
    assert np.isinf(answers["displacement cart.x"].deviation)
    with pytest.raises(ValueError, match="do not determine"):
        found.next_measurement([fm.measured("mass", 1.0, 0.1)])
    # A prior determines it.
    known = fm.fit(cart, data, GUESS, BOUNDS, priors={"mass": (MASS, 0.04)})
    assert known.undetermined == ()
    assert known.parameters["mass"] == pytest.approx(MASS, rel=1e-6)
    assert known.deviation["mass"] == pytest.approx(0.04, rel=1e-6)


@pytest.mark.slow
def test_what_to_measure_next():
    frequency, shift = np.sqrt(STIFFNESS / MASS) / (2 * np.pi), LOAD / STIFFNESS
    data = {"frequency 1": (frequency, 1e-3 * frequency), "displacement cart.x": (shift, 1e-2 * shift)}
    found = fm.fit(cart, data, GUESS, BOUNDS)
    scale = fm.measured("mass", 1.0, 0.02 * MASS, name="scale")
    gauge = fm.measured("stiffness cart.x", 1.0, 1e-3 * STIFFNESS, name="gauge")
    ranked = found.next_measurement([scale, gauge], narrow="mass")
    assert [name for name, _ in ranked] == ["gauge", "scale"]
    # Independent measurements: information adds. The scale knows the mass to 2 %.
    of_mass = np.hypot(1e-2, 2e-3)
    assert dict(ranked)["scale"] == pytest.approx(1 / np.sqrt(1 + (of_mass / 0.02) ** 2), rel=1e-6)
    # An answer: the logarithms of frequency and stiffness are independent, and ln m = ln k - 2 ln f + const.
    known = np.diag([1e-6, 1e-4])
    by_mass = known @ [-2, 1]
    share = np.sqrt(1 - by_mass[0] ** 2 / (by_mass @ [-2, 1] + 0.02**2) / 1e-6)
    of_answer = dict(found.next_measurement([scale, gauge], narrow="frequency 1"))
    assert of_answer == pytest.approx({"scale": share, "gauge": 1.0}, rel=1e-6)
    with pytest.raises(KeyError, match="no parameter or question 'width'"):
        found.next_measurement([scale], narrow="width")
    better = fm.fit(cart, data | {"gauge": fm.measured("stiffness cart.x", STIFFNESS, 0.1)}, GUESS, BOUNDS)
    assert dict(ranked)["gauge"] == pytest.approx(better.deviation["mass"] / found.deviation["mass"], rel=1e-6)


def test_correlated_values_weigh_as_their_covariance_says():
    covariance = 1e-8 * (np.eye(len(LOADS)) + 3.0)
    values = LOADS / STIFFNESS + 1e-4 * np.array([1.0, -1.0, 2.0, 0.0, 1.0])
    data = fm.measured(lambda model: moved(model) * LOADS, values, covariance=covariance, name="line")
    found = fm.fit(lambda stiffness: cart(stiffness), data, {"stiffness": 70.0}, {"stiffness": (10, 1000)})
    # Generalised least squares of a line through zero.
    weight = np.linalg.inv(covariance)
    information = LOADS @ weight @ LOADS
    slope = LOADS @ weight @ values / information
    assert 1 / found.parameters["stiffness"] == pytest.approx(slope, rel=1e-7)
    assert found.deviation["stiffness"] * slope**2 == pytest.approx(information**-0.5, rel=1e-6)
    residual = values - slope * LOADS
    assert found.chi_squared == pytest.approx(residual @ weight @ residual, rel=1e-5)
    assert found.probability == pytest.approx(chi2.sf(found.chi_squared, 4), rel=1e-9)


@pytest.mark.slow
def test_slopes_agree_with_differences():
    data = {"frequency 1": (0.8, 0.01), "displacement cart.x": (0.01, 1e-4)}
    problem = fm.fit(cart, data, GUESS, BOUNDS, throw=False).problem
    unit = np.array([0.4, 0.55])
    _, slopes, _ = problem.residuals(unit)
    for i in range(2):
        step = 1e-5 * np.eye(2)[i]
        difference = (problem.residuals(unit + step)[0] - problem.residuals(unit - step)[0]) / 2e-5
        # Central differences of step h are off by h^2.
        assert slopes[:, i] == pytest.approx(difference, rel=1e-7)

    def computed(at):
        model = cart(*problem.scaling.to_dimensions(at))
        return jax.numpy.stack([fm.frequencies(model)[0] / 0.01, moved(model) / 1e-4])

    assert slopes == pytest.approx(np.asarray(jax.jacrev(computed)(jax.numpy.asarray(unit))), rel=1e-9)


def test_a_model_that_does_not_fit_says_so():
    values = LOADS / STIFFNESS + 2e-3 * LOADS**2
    data = fm.measured(lambda model: moved(model) * LOADS, values, 1e-4, name="line")
    with pytest.warns(fm.FlexmbWarning, match="does not fit the data"):
        found = fm.fit(lambda stiffness: cart(stiffness), data, {"stiffness": 70.0}, {"stiffness": (10, 1000)})
    assert found.result is fm.RESULTS.poor_fit
    assert found.largest_residuals()[0][0] == "line"


def test_differences_far_below_their_deviations_are_told():
    values = LOADS / STIFFNESS
    for scatter, agrees in ((1e-6, True), (1e-9, False), (0.0, False)):
        noisy = values + scatter * np.array([1.0, -1.0, 2.0, 0.0, -1.0])
        data = fm.measured(lambda model: moved(model) * LOADS, noisy, 1e-6, name="line")
        found = fm.fit(lambda stiffness: cart(stiffness), data, {"stiffness": 70.0}, {"stiffness": (10, 1000)})
        assert found.result is fm.RESULTS.successful
        assert ("agrees with the values within their scatter" in found.reason) is agrees
        assert ("scatter less than their deviations" in str(found)) is not agrees
        assert ("the intervals are too wide" in str(found)) is not agrees


def test_an_outlier_weighs_less_with_a_robust_loss():
    values = LOADS / STIFFNESS
    values = values + 1e-2 * (LOADS == 5)
    data = fm.measured(lambda model: moved(model) * LOADS, values, 1e-4, name="line")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fits = [
            fm.fit(lambda stiffness: cart(stiffness), data, {"stiffness": 70.0}, {"stiffness": (10, 1000)}, loss=loss)
            for loss in ("linear", "huber", "soft_l1", "cauchy")
        ]
    errors = [abs(found.parameters["stiffness"] - STIFFNESS) for found in fits]
    assert errors[0] > 10 * errors[1] > errors[3]
    assert errors[2] < errors[0] / 5


def test_profile_of_a_line_is_a_parabola_and_of_its_inverse_is_not():
    values = LOADS / STIFFNESS
    data = fm.measured(lambda model: moved(model) * LOADS, values, 2e-2, name="line")
    found = fm.fit(lambda stiffness: cart(stiffness), data, {"stiffness": 70.0}, {"stiffness": (10, 1000)})
    profile = found.profile("stiffness")
    # Chi-squared is a parabola in the compliance 1/k, so that its interval is known.
    width = 1.959964 * 2e-2 / np.sqrt(np.sum(LOADS**2))
    assert profile.interval == pytest.approx((1 / (1 / STIFFNESS + width), 1 / (1 / STIFFNESS - width)), rel=1e-3)
    expected = ((1 / profile.values - 1 / STIFFNESS) / 2e-2) ** 2 * np.sum(LOADS**2)
    assert profile.growth == pytest.approx(expected, rel=1e-4, abs=1e-4)
    # The linearised model is linear in log k, its scale.
    slope = np.sqrt(np.sum(LOADS**2)) / STIFFNESS / 2e-2
    assert profile.linear == pytest.approx((slope * np.log(profile.values / STIFFNESS)) ** 2, rel=1e-6, abs=1e-9)
    ax = fm.plot.profile(profile)
    drawn = {line.get_label(): line for line in ax.lines}
    np.testing.assert_allclose(drawn["profile"].get_ydata(), profile.growth[np.argsort(profile.values)])
    np.testing.assert_allclose(drawn["linearised"].get_ydata(), profile.linear[np.argsort(profile.values)])
    span = ax.patches[0].get_extents().transformed(ax.transData.inverted())
    assert (span.x0, span.x1) == pytest.approx(profile.interval, rel=1e-6)
    # The square of the quantile of the normal distribution for 95 %.
    assert profile.threshold == pytest.approx(1.959964**2, rel=1e-6)
    assert "Profile likelihood of stiffness" in repr(profile)
    plt.close(ax.figure)
    with pytest.raises(TypeError, match=r"needs the result of fitted\.profile"):
        fm.plot.profile(found)  # type: ignore


def test_other_values_are_fitted_by_the_same_programs():
    rng = np.random.default_rng(0)
    data = fm.measured(lambda model: moved(model) * LOADS, LOADS / STIFFNESS, 1e-4, name="line")
    found = fm.fit(lambda stiffness: cart(stiffness), data, {"stiffness": 70.0}, {"stiffness": (10, 1000)})
    sets = LOADS / STIFFNESS + 1e-4 * rng.standard_normal((20, 5))
    several = found.again(sets)
    slopes = sets @ LOADS / np.sum(LOADS**2)
    assert np.all(several.converged)
    assert 1 / several.parameters["stiffness"] == pytest.approx(slopes, rel=1e-7)
    assert several.deviation["stiffness"] * slopes**2 == pytest.approx(1e-4 / np.sqrt(np.sum(LOADS**2)), rel=1e-6)


REFUSED = [
    ({"frequency 1": (0.8, 0.01)}, ValueError, "2 parameters cannot be fitted to 1 values"),
    ({"frequency 1": (800.0, 0.01), "mass": (4.0, 0.1)}, ValueError, "'frequency 1' are about 1.3e.*SI units"),
    ({"frequency 1": (np.nan, 0.01), "mass": (4.0, 0.1)}, ValueError, "'frequency 1' has a value that is not finite"),
    ({"frequency 1": (0.8, -0.01), "mass": (4.0, 0.1)}, ValueError, "'frequency 1' has a deviation of -0.01"),
    ({"frequency 1": 0.8, "mass": (4.0, 0.1)}, TypeError, "pair of value and standard deviation"),
    ({"frequency 1": (0.8, None), "mass": (4.0, 0.1)}, ValueError, "'frequency 1' has no deviation"),
    ({"frequenzy 1": (0.8, 0.1)}, KeyError, "no coordinate 'frequenzy 1'"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("data", "fault", "text"), REFUSED)
def test_bad_data_is_refused_by_name(data, fault, text):
    with pytest.raises(fault, match=text):
        fm.fit(cart, data, GUESS, BOUNDS)


def test_bad_arguments_are_refused_by_name():
    data = {"frequency 1": (0.8, 0.01), "mass": (4.0, 0.1)}
    with pytest.raises(ValueError, match=r"No measured value depends on parameter 'stiffness'"):
        fm.fit(cart, {"mass": (4.0, 0.1), "same": fm.measured("mass", 4.0, 0.1)}, GUESS, BOUNDS)
    with pytest.raises(ValueError, match="takes the parameter 'offset', which has no start"):
        fm.fit(cart, [fm.measured(readings, LOADS / 100, 0.1)], GUESS, BOUNDS)
    with pytest.raises(ValueError, match="Prior of 'width'"):
        fm.fit(cart, data, GUESS, BOUNDS, priors={"width": (1, 2)})
    with pytest.raises(ValueError, match="outside its bounds"):
        fm.fit(cart, data, GUESS | {"mass": 100.0}, BOUNDS)
    with pytest.raises(ValueError, match="5 values, but the model computes 1"):
        fm.fit(cart, fm.measured("mass", LOADS, 0.1), GUESS, BOUNDS)
    with pytest.raises(ValueError, match="covariance that is not positive definite"):
        fm.measured("mass", [4.0, 5.0], covariance=[[1.0, 2.0], [2.0, 1.0]])
    with pytest.raises(ValueError, match="covariance that is not symmetric"):
        fm.measured("mass", [1e-6, 2e-6], covariance=[[1e-12, 0.9e-12], [-0.5e-12, 1e-12]])
    with pytest.raises(KeyError, match="no parameter 'width'"):
        fm.fit(cart, data, GUESS, BOUNDS).interval("width")


@pytest.mark.slow
def test_the_picture_has_a_panel_for_each_measurement():
    data = {"frequency 1": (0.8, 0.01), "displacement cart.x": (0.01, 1e-3)}
    found = fm.fit(cart, data, GUESS, BOUNDS)
    figure = fm.plot.fit(found)
    assert [ax.get_ylabel() for ax in figure.axes[:3]] == [*data, "computed less measured [deviations]"]
    # There are as many values as parameters: computed values scatter as measured ones.
    assert [found.computed_deviation[name][0] for name in data] == pytest.approx([0.01, 1e-3], rel=1e-6)
    band = figure.axes[0].collections[-1].get_paths()[0].vertices[:, 1]
    assert (band.min(), band.max()) == pytest.approx((0.78, 0.82), rel=1e-4)
    plt.close(figure)
    predicted = found.predict({"frequencies": lambda model: fm.frequencies(model)})["frequencies"]
    ax = fm.plot.prediction(predicted, [3.0], measured=[0.8], label="load [N]", name="frequency [Hz]")
    band = ax.collections[0].get_paths()[0].vertices[:, 1]
    assert (band.min(), band.max()) == pytest.approx((0.78, 0.82), rel=1e-4)
    plt.close(ax.figure)
    with pytest.raises(ValueError, match="`over` has 2 numbers, but the prediction has 1"):
        fm.plot.prediction(predicted, [3.0, 4.0])
    with pytest.raises(TypeError, match=r"entry of fitted\.predict"):
        fm.plot.prediction(None)  # type: ignore
    with pytest.raises(TypeError, match=r"fm\.fit"):
        fm.plot.fit(None)  # type: ignore


@pytest.mark.slow
def test_parameters_that_fit_as_well_are_named():
    """A square does not tell the sign: 1 and 3 are as far from 2."""
    reading = fm.measured(lambda model, place: (place - 2) ** 2 + 0 * moved(model), 1.0, 0.01, name="reading")
    data = {"mass": (MASS, 0.1), "reading": reading}
    start, bounds = {"mass": 5.0, "place": 2.5}, {"mass": (0.4, 40.0), "place": (0.0, 4.0)}
    with pytest.warns(fm.FlexmbWarning, match="Other parameters fit equally well: .*place = "):
        found = fm.fit(lambda mass: cart(mass=mass), data, start, bounds, starts=6)
    assert sorted(float(values["place"]) for values, _ in found.minima) == pytest.approx([1.0, 3.0], rel=1e-6)


@pytest.mark.slow
def test_parameters_that_no_mechanism_has_are_no_fit():
    """E/(2 G) - 1 of the measured moduli is 1.5, beyond any Poisson's ratio."""

    def bar(modulus, shear):
        b = fm.Builder()
        b.node("wall", (0, 0))
        b.node("cart", (1, 0))
        material = fm.Material(E=modulus, G=shear, rho=1.0)
        b.add(planar.truss, "wall", "cart", name="rod", section=fm.Rectangle(0.01, 0.01, material))
        b.fix("wall")
        b.fix("cart", "y")
        b.mass("cart", MASS)
        b.dof("cart", "x")
        return b.build()

    data = [
        fm.measured("stiffness cart.x", 1e6, 1e3),
        fm.measured(lambda model, shear: shear, 2e9, 1e6, name="shear modulus"),
    ]
    start, bounds = {"modulus": 9e9, "shear": 4e9}, {"modulus": (1e9, 1e11), "shear": (1e9, 1e11)}
    with pytest.raises(fm.AnalysisError, match=r"(?s)No mechanism has these .* G is at least E/3"):
        fm.fit(bar, data, start, bounds)
    assert fm.fit(bar, data, start, bounds, throw=False).result is fm.RESULTS.impossible_design


def test_a_mode_that_has_lost_its_partner_is_told():
    def check(model):
        if fm.mass(model) < 4.5:
            raise ValueError("Mode 1 has no partner.")

    data = {"frequency 1": (0.8, 0.01), "mass": dataclasses.replace(fm.measured("mass", MASS, 0.1), check=check)}
    with pytest.warns(fm.FlexmbWarning, match="At the fitted parameters: Mode 1 has no partner"):
        fm.fit(cart, data, GUESS, BOUNDS)


def test_weights_need_deviations():
    data = fm.measured(lambda model: moved(model) * LOADS, LOADS / STIFFNESS, name="line")
    given = (lambda stiffness: cart(stiffness), data, {"stiffness": 70.0}, {"stiffness": (10, 1000)})
    with pytest.raises(ValueError, match=r"Priors weigh values by their deviations\. Give measurement 'line'"):
        fm.fit(*given, priors={"stiffness": (90.0, 10.0)})
    with pytest.raises(ValueError, match="loss 'huber' weighs values by their deviations"):
        fm.fit(*given, loss="huber")


@pytest.mark.slow
def test_a_prediction_without_a_value_is_refused():
    data = {"frequency 1": (0.8, 0.01), "displacement cart.x": (0.01, 1e-4)}
    found = fm.fit(cart, data, GUESS, BOUNDS)
    with pytest.raises(fm.AnalysisError, match="'root' has no finite derivative"):
        found.predict({"root": lambda model: jax.numpy.sqrt(moved(model) - moved(model))})
