"""Scatter of parameters and what follows from it, against closed forms of probability."""

import warnings

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import design_cases
from scipy.stats import norm, triang, uniform

import flexmb as fm
from flexmb import planar
from flexmb.design.evaluate import build_once, layout_of
from flexmb.design.robust import robust_front
from flexmb.design.scatter import correlation_root, moments
from flexmb.design.statistics import Statistic, sampled_of, smooth_yield, statistic_value

SCORE = norm.ppf(0.95)


def made(**parameters):
    """Answers of parameters need no mechanism."""
    return parameters


def cube(model):
    return model["x"] ** 3


KINDS = {
    "normal": (("normal", 0.1), norm(0, 0.1)),
    "number": (0.1, norm(0, 0.1)),
    "uniform": (("uniform", 0.2), uniform(-0.2, 0.4)),
    "one side": (("uniform", 0.0, 0.3), uniform(0.0, 0.3)),
    "triangular": (("triangular", 0.2), triang(0.5, -0.2, 0.4)),
    "skew": (("triangular", -0.1, 0.3), triang(0.25, -0.1, 0.4)),
    "own": (uniform(-0.1, 0.4), uniform(-0.1, 0.4)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_each_distribution_is_that_of_scipy(kind):
    given, expected = KINDS[kind]
    scatter = fm.scatter({"x": given})
    drawn = fm.design.monte_carlo(4000, scatter, x=2.0, seed=1)["x"] - 2.0
    # Kolmogorov's statistic of 4000 samples stays below 2/sqrt(4000) in 99.9 % of cases.
    ordered = expected.cdf(np.sort(drawn))
    assert np.max(np.abs(ordered - np.arange(1, 4001) / 4000)) < 2 / np.sqrt(4000)
    mean, covariance = moments(scatter, {"x": 2.0})
    # The grid of scores resolves a step of the density to its square.
    assert mean[0] == pytest.approx(expected.mean(), abs=1e-7)
    assert covariance[0, 0] == pytest.approx(expected.var(), rel=1e-5)


def test_a_lognormal_parameter_scatters_about_its_median():
    scatter = fm.scatter({"E": ("lognormal", 0.1)}, nominal={"E": 200.0})
    drawn = fm.design.monte_carlo(20_000, scatter)["E"]
    assert np.median(drawn) == pytest.approx(200.0, rel=4 * 1.2533 * 0.1 / np.sqrt(20_000))
    assert np.std(np.log(drawn)) == pytest.approx(0.1, rel=4 / np.sqrt(40_000))
    mean, covariance = moments(scatter, {"E": 200.0})
    assert mean[0] == pytest.approx(200 * np.expm1(0.005), rel=1e-9)
    assert covariance[0, 0] == pytest.approx(200**2 * np.exp(0.01) * np.expm1(0.01), rel=1e-9)


def test_correlation_by_the_copula():
    scatter = fm.scatter(
        {"a": ("uniform", 1.0), "b": ("uniform", 2.0), "c": 0.5}, correlation={("a", "b"): 0.8, ("c", "a"): -0.5}
    )
    _, covariance = moments(scatter, {"a": 0.0, "b": 0.0, "c": 0.0})
    correlation = covariance / np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    # Of uniform variables 6/pi asin(r/2) (Pearson 1907), of a uniform and a normal one sqrt(3/pi) r.
    assert correlation[0, 1] == pytest.approx(6 / np.pi * np.arcsin(0.4), rel=1e-6)
    assert correlation[0, 2] == pytest.approx(-0.5 * np.sqrt(3 / np.pi), rel=1e-6)
    assert abs(correlation[1, 2]) < 1e-12
    drawn = fm.design.monte_carlo(20_000, scatter, seed=2, a=0.0, b=0.0, c=0.0)
    sampled = np.corrcoef(np.stack([drawn["a"], drawn["b"], drawn["c"]]))
    np.testing.assert_allclose(sampled, correlation, atol=4 / np.sqrt(20_000))


def test_entries_of_arrays_scatter_by_themselves():
    scatter = fm.scatter({"h": 0.1}, correlation={("h[0]", "h[2]"): 0.9})
    drawn = fm.design.monte_carlo(5000, scatter, h=[1.0, 2.0, 3.0], w=5.0)
    assert drawn["h"].shape == (5000, 3)
    assert np.all(drawn["w"] == 5.0)
    np.testing.assert_allclose(drawn["h"].mean(axis=0), [1, 2, 3], atol=4 * 0.1 / np.sqrt(5000))
    found = np.corrcoef(drawn["h"].T)
    np.testing.assert_allclose(found[0], [1.0, 0.0, 0.9], atol=4 / np.sqrt(5000))


WRONG = [
    ({}, {}, "at least one"),
    ({"x": ("gauss", 0.1)}, {}, "Scatter of 'x' must be a standard deviation"),
    ({"x": -0.1}, {}, "Scatter of 'x' is -0.1. It must be positive"),
    ({"x": ("normal", 0.1, 0.2)}, {}, "normal takes one number"),
    ({"x": ("uniform", 0.1, 0.2)}, {}, "must enclose zero"),
    ({"x": 0.1}, {"correlation": {("x", "y"): 0.5}}, "'y' has no scatter"),
    ({"x": 0.1, "y": 0.1}, {"correlation": {("x", "y"): 1.0}}, "between -1 and 1"),
    ({"x": 0.1}, {"correlation": {("x", "x"): 0.5}}, "two different parameters"),
    ({"x": 0.1, "y": 0.1}, {"correlation": {("x", "y"): 0.5, ("y", "x"): 0.1}}, "given twice"),
    ({"x": 0.1}, {"nominal": {"y": 1.0}}, "Nominal value of 'y'"),
]


@pytest.mark.parametrize(("distributions", "more", "words"), WRONG)
def test_wrong_scatter_is_named(distributions, more, words):
    with pytest.raises(ValueError, match=words):
        fm.scatter(distributions, **more)


def test_contradictions_and_missing_values_are_named():
    pairs = {("a", "b"): 0.9, ("b", "c"): 0.9, ("a", "c"): -0.9}
    scatter = fm.scatter({"a": 1.0, "b": 1.0, "c": 1.0}, correlation=pairs)
    with pytest.raises(ValueError, match="contradict each other"):
        correlation_root(scatter, layout_of({"a": 0.0, "b": 0.0, "c": 0.0}))
    with pytest.raises(ValueError, match="'b' has no nominal value"):
        fm.design.monte_carlo(10, scatter, a=1.0)
    whole = fm.scatter({"h": 1.0, "k": 1.0}, correlation={("h", "k"): 0.5})
    with pytest.raises(ValueError, match=r"'h': there is no such parameter\. Name an entry"):
        correlation_root(whole, layout_of({"h": np.ones(2), "k": 1.0}))


def test_tolerances_of_correlated_parameters():
    scatter = fm.scatter({"x": 0.3, "y": 0.4}, correlation={("x", "y"): 0.5})
    found = fm.design.tolerances(
        made, {"sum": lambda m: 2 * m["x"] + m["y"]}, {"x": 1.0, "y": 1.0}, scatter, samples=4000
    )
    variance = 0.6**2 + 0.4**2 + 2 * 0.5 * 0.6 * 0.4
    assert found.deviations[0] == pytest.approx(np.sqrt(variance), rel=1e-9)
    np.testing.assert_allclose(found.shares[0], np.array([0.36 + 0.12, 0.16 + 0.12]) / variance, rtol=1e-9)
    assert found.sampled_deviations[0] == pytest.approx(np.sqrt(variance), rel=3 / np.sqrt(8000))


@pytest.mark.slow
def test_frequencies_that_cross_are_warned_of_and_counted():
    """The smaller of two alike normal numbers has its 5th percentile where (1 - Phi)^2 = 0.95."""
    near, scatter = {"first": 1000.0, "second": 1000.1}, fm.scatter({"first": 10.0, "second": ("uniform", 17.32)})
    with pytest.warns(fm.FlexmbWarning, match="two frequencies nearly coincide"):
        fm.design.tolerances(design_cases.two_carts, "frequency 1", near, scatter)
    alike = fm.scatter({"first": 10.0, "second": 10.0})
    found = fm.design.robustness(design_cases.two_carts, "frequency 1", near, alike, samples=4000)
    stiffness = (2 * np.pi * found.percentile("frequency 1", 5).value) ** 2
    assert stiffness == pytest.approx(1000 - 10 * norm.ppf(np.sqrt(0.95)), abs=1.0)


def test_the_second_order_of_a_square_is_exact_and_of_a_cube_has_its_error():
    answers = {"square": lambda m: m["x"] ** 2, "cube": cube}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fm.FlexmbWarning)
        found = fm.design.tolerances(made, answers, {"x": 1.0}, fm.scatter({"x": 0.2}), second_order=True)
    # Mean m^2 + s^2 and m^3 + 3 m s^2; variance 4 m^2 s^2 + 2 s^4 and 9 m^4 s^2 + 36 m^2 s^4 + 15 s^6.
    np.testing.assert_allclose(found.mean, [1.04, 1.12], rtol=1e-9)
    square = np.sqrt(4 * 0.04 + 2 * 0.04**2)
    exact = np.sqrt(9 * 0.04 + 36 * 0.04**2 + 15 * 0.04**3)
    # A deviation of 100 000 samples.
    assert found.second_order_deviations[0] == pytest.approx(square, rel=4 / np.sqrt(200_000))
    assert found.error[0] < 1e-12
    assert "second order 1.04 ± 0.4" in found.summary().rows["square"]
    # The cube of the deviation is left out: sqrt(15) s^3 in the mean square, here of 64 samples.
    assert found.error[1] == pytest.approx(np.sqrt(15) * 0.008, rel=0.6)
    assert abs(found.second_order_deviations[1] - exact) < found.error[1]
    assert found.second_order_interval[0, 0] == pytest.approx((1 - 0.2 * 1.959964) ** 2, abs=5e-3)
    lognormal = fm.design.tolerances(
        made, lambda m: m["E"], {}, fm.scatter({"E": ("lognormal", 0.1)}, nominal={"E": 2.0}), second_order=True
    )
    assert lognormal.mean[0] == pytest.approx(2 * np.exp(0.005), rel=1e-9)


def test_percentiles_of_a_cube_of_a_normal_variable():
    scatter = fm.scatter({"x": 0.1})
    found = fm.design.robustness(made, {"y": cube}, {"x": 1.0}, scatter, limits={"y": (0.7, 1.2)}, samples=20_000)
    for percent in (1, 5, 50, 95, 99):
        exact = (1 + 0.1 * norm.ppf(percent / 100)) ** 3
        value, lower, upper = found.percentile("y", percent)
        assert lower < value < upper
        # A 95 % interval is 3.92 deviations wide: the exact one is within four of them.
        assert abs(value - exact) < 4 * (upper - lower) / 3.92
        assert upper - lower < 0.05
    share = norm.cdf((1.2 ** (1 / 3) - 1) / 0.1) - norm.cdf((0.7 ** (1 / 3) - 1) / 0.1)
    assert found.fraction.value == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / 20_000))
    # Wald's interval nearly equals the exact one of many samples.
    width = 2 * 1.96 * np.sqrt(share * (1 - share) / 20_000)
    assert found.fraction.upper - found.fraction.lower == pytest.approx(width, rel=0.02)
    assert found.mean("y").value == pytest.approx(1.03, abs=4 * 0.303 / np.sqrt(20_000))
    (low, at), (high, _) = found.worst("y")
    assert low == pytest.approx(at["x"] ** 3)
    assert low < found.percentile("y", 0.1).value < found.percentile("y", 99.9).value < high
    assert found.percentile("y", 100).upper == np.inf
    assert "yield: " in str(found)


def test_intervals_of_percentiles_contain_them():
    """Of 400 repetitions with 60 samples, 95 % do; four deviations of a binomial number."""
    rng = np.random.default_rng(0)
    exact, inside = norm.ppf(0.9), 0
    scatter = fm.scatter({"x": 1.0})
    base = fm.design.robustness(made, {"y": lambda m: m["x"]}, {"x": 0.0}, scatter, samples=60)
    for _ in range(400):
        answers = {"y": rng.standard_normal(60)}
        sweep = fm.design.Sweep(base.samples.designs, answers, base.samples.codes, {})
        one = type(base)(base.nominal, {}, base.fraction, {}, sweep, 0.95).percentile("y", 90)
        inside += one.lower < exact < one.upper
    assert inside / 400 > 0.95 - 4 * np.sqrt(0.95 * 0.05 / 400)


def cantilever(thickness, length):
    b = fm.Builder()
    b.node("root", (0, 0))
    b.node("tip", (length, 0))
    b.add(
        planar.beam,
        "root",
        "tip",
        section=fm.Rigidity(EA=1e9, EIy=210e9 * 0.02 * thickness**3 / 12, mass=7850 * 0.02 * thickness),
    )
    b.fix("root")
    return b.build(release="auto")


@pytest.mark.slow
def test_the_yield_of_a_cantilever_frequency():
    """f goes with t/l^2: of a normal thickness the yield is that of a normal distribution."""
    nominal, spread = 1e-3, 2e-5
    scatter = fm.scatter({"thickness": spread})
    first = float(fm.frequencies(cantilever(nominal, 0.1))[0])
    assert first == pytest.approx(1.8751**2 / (2 * np.pi) * np.sqrt(210e9 / 12 / 7850) * nominal / 0.01, rel=0.01)
    limits = {"frequency 1": (0.985 * first, None)}
    found = fm.design.robustness(
        cantilever, "frequency 1", {"thickness": nominal, "length": 0.1}, scatter, limits=limits, samples=5000
    )
    share = norm.cdf(0.015 * nominal / spread)
    assert found.fraction.value == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / 5000))
    assert found.percentile("frequency 1", 5).value == pytest.approx(first * (1 - SCORE * 0.02), rel=0.004)


@pytest.mark.slow
def test_a_cantilever_tuned_for_a_percentile():
    """The mean thickness lies 1.645 deviations above what the frequency needs."""
    scatter = fm.scatter({"thickness": 2e-5})
    wanted = float(fm.frequencies(cantilever(1e-3, 0.1))[0])
    found = fm.tune(
        lambda thickness: cantilever(thickness, 0.1),
        {"f": "frequency 1", "m": "mass"},
        {"thickness": 1.2e-3},
        {"thickness": (0.5e-3, 3e-3)},
        minimize="mean m",
        limits={"percentile 5 f": (wanted, None)},
        scatter=scatter,
        samples=200,
    )
    assert found.result is fm.RESULTS.successful
    assert found.dimensions["thickness"] == pytest.approx(1e-3 + SCORE * 2e-5, abs=0.05 * 2e-5)
    assert found.answers["percentile 5 f"] == pytest.approx(wanted, rel=1e-5)
    assert found.answers["m"] == pytest.approx(found.answers["mean m"], rel=1e-4)


def test_the_best_yield_between_two_limits():
    """A lognormal variable has its best yield between a and b at their geometric mean."""
    scatter = fm.scatter({"x": ("lognormal", 0.3)})
    found = fm.tune(
        made,
        {"y": lambda m: m["x"]},
        {"x": 1.0},
        {"x": (0.5, 8.0)},
        maximize="yield",
        acceptable={"y": (1.0, 4.0)},
        scatter=scatter,
        samples=500,
    )
    assert found.dimensions["x"] == pytest.approx(2.0, rel=0.04)
    share = 2 * norm.cdf(np.log(2) / 0.3) - 1
    assert found.answers["yield"] == pytest.approx(share, abs=0.01)


def test_a_parameter_that_only_scatters_is_no_dimension():
    scatter = fm.scatter({"E": ("lognormal", 0.2)}, nominal={"E": 3.0})
    found = fm.tune(
        made,
        {"k": lambda m: m["E"] * m["x"]},
        {"x": 1.0},
        {"x": (0.1, 10.0)},
        targets={"percentile 50 k": 6.0},
        scatter=scatter,
        samples=101,
    )
    # The median of E is 3.
    assert found.dimensions == {"x": pytest.approx(2.0, rel=5e-3)}
    assert found.answers["k"] == pytest.approx(6.0, rel=5e-3)


def test_choices_are_compared_by_their_statistics():
    """With twice the number the scatter of the product is twice as large."""
    found = fm.tune(
        lambda x, number: {"y": number * x},
        {"y": lambda m: m["y"]},
        {"x": 1.0},
        {"x": (0.1, 4.0)},
        choices={"number": [2, 1]},
        minimize="percentile 95 y",
        limits={"y": (1.0, None)},
        scatter=fm.scatter({"x": 0.1}),
        samples=100,
    )
    assert found.choices == {"number": 1}
    assert found.answers["percentile 95 y"] == pytest.approx(1 + 0.1 * SCORE, abs=5e-3)
    other = found.combinations[0].tuned
    assert other.answers["percentile 95 y"] == pytest.approx(1 + 0.2 * SCORE, abs=1e-2)


def test_statistics_are_those_of_samples():
    values = np.random.default_rng(3).standard_normal((2, 4001))
    assert np.asarray(statistic_value(Statistic("mean", 0, "y"), jnp.asarray(values))) == pytest.approx(
        np.mean(values, axis=1), rel=1e-12
    )
    assert np.asarray(statistic_value(Statistic("deviation", 0, "y"), jnp.asarray(values))) == pytest.approx(
        np.std(values, axis=1, ddof=1)
    )
    found = np.asarray(statistic_value(Statistic("percentile", 90.0, "y"), jnp.asarray(values)))
    # Harrell and Davis differ from the sample quantile by less than its scatter.
    assert found == pytest.approx(np.quantile(values, 0.9, axis=1), abs=0.5 * 1.71 / np.sqrt(4001))
    # All alike: no deviation, and no slope that is not finite.
    same = jnp.ones(10)
    assert statistic_value(Statistic("deviation", 0, "y"), same) == 0
    for differentiate in (jax.jacfwd, jax.jacrev):
        assert np.all(np.isfinite(differentiate(lambda v: smooth_yield({"y": v}, {"y": (0.0, 2.0)}))(same)))
    assert smooth_yield({"y": same}, {"y": (1.0, None)}) == 1
    assert smooth_yield({"y": same}, {"y": (1.1, None)}) == 0


@pytest.mark.slow
@pytest.mark.parametrize("what", ["yield", "percentile 5 y", "percentile 80 y", "deviation y", "mean y"])
def test_slopes_of_statistics_agree_with_differences(what):
    functions = {"y": lambda m: m["x"] ** 2 * m["E"]}
    scatter = fm.scatter({"x": 0.1, "E": ("lognormal", 0.2)}, nominal={"E": 1.0}, correlation={("x", "E"): 0.5})
    sampled = sampled_of(scatter, 64, 0, [what], functions, ["x"], {"y": (0.5, 1.4)})
    layout = layout_of({"x": 1.0})
    function, answers = sampled.function(made, functions, layout, build_once(made, {"x": 1.0, "E": 1.0}))
    assert answers.names == ("y", *sampled.statistics, "yield")
    place = answers.names.index(what)

    def value(x):
        return function(jnp.array([x]))[0][place]

    step = 6e-6
    central = float((value(1.0 + step) - value(1.0 - step)) / (2 * step))
    assert jax.jacfwd(value)(1.0) == pytest.approx(central, rel=1e-6)
    assert jax.jacrev(value)(1.0) == pytest.approx(central, rel=1e-6)


def test_wrong_questions_about_made_mechanisms_are_named():
    start, bounds, answers = {"x": 1.0}, {"x": (0.5, 2.0)}, {"y": cube}
    scatter = fm.scatter({"x": 0.1})
    with pytest.raises(ValueError, match=r"'percentile 5 y' is a statistic of made mechanisms\. Give `scatter`"):
        fm.tune(made, answers, start, bounds, minimize="percentile 5 y")
    with pytest.raises(ValueError, match="needs `acceptable`"):
        fm.tune(made, answers, start, bounds, maximize="yield", scatter=scatter)
    with pytest.raises(ValueError, match="There is no answer 'percentile 5 z'"):
        fm.tune(made, answers, start, bounds, minimize="percentile 5 z", scatter=scatter)
    with pytest.raises(ValueError, match="a percentile is between 0 and 100"):
        fm.tune(made, answers, start, bounds, minimize="percentile 100 y", scatter=scatter)
    with pytest.raises(ValueError, match="'E' has no nominal value"):
        fm.tune(made, answers, start, bounds, minimize="mean y", scatter=fm.scatter({"E": 0.1}))
    with pytest.raises(ValueError, match="Limits of 'z'"):
        fm.design.robustness(made, answers, start, scatter, limits={"z": (0, 1)}, samples=10)
    with pytest.raises(TypeError, match="`acceptable` must be a dictionary by name"):
        fm.tune(made, answers, start, bounds, maximize="yield", scatter=scatter, acceptable="y")


@pytest.mark.parametrize(("lower", "value"), [(100.0, 0), (-100.0, 1)])
def test_a_yield_without_slope_is_named(lower, value):
    """Far from all limits, every mechanism is bad or every one is good."""
    given = {"scatter": fm.scatter({"x": 0.1}), "acceptable": {"y": (lower, None)}}
    with pytest.raises(ValueError, match=rf"The yield is {value} near the start\. Start where only some"):
        fm.tune(made, {"y": cube}, {"x": 1.0}, {"x": (0.5, 2.0)}, maximize="yield", **given)
    answers = {"y": lambda m: m["x"] + 0 * m["z"]}
    with pytest.raises(ValueError, match=r"depends on dimension 'z'\. Fix it in `build`"):
        fm.tune(made, answers, {"x": 1.0, "z": 1.0}, {"x": (0.5, 2.0), "z": (0, 2)}, minimize="mean y", **given)


def test_mechanisms_without_answers_are_no_good():
    with pytest.warns(fm.FlexmbWarning, match="have no answers"):
        found = fm.design.robustness(
            made,
            {"y": lambda m: jnp.sqrt(m["x"])},
            {"x": 0.0},
            fm.scatter({"x": 1.0}),
            limits={"y": (0.0, None)},
            samples=2000,
        )
    assert found.fraction.value == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(2000))


def test_a_front_of_the_nominal_value_against_the_percentile():
    """With a deviation of (2 - x)^2 the percentile of x + deviation is least where its slope vanishes."""
    answers = {"y": lambda m: m["x"] + m["noise"] * (2 - m["x"]) ** 2}
    scatter = fm.scatter({"noise": 1.0}, nominal={"noise": 0.0})
    front = robust_front(
        made,
        answers,
        {"x": 1.0},
        {"x": (0.5, 1.99)},
        minimize="y",
        against="percentile 95 y",
        scatter=scatter,
        samples=200,
        points=5,
    )
    assert list(front.criteria) == ["y", "percentile 95 y"]
    assert len(front) == 5
    exact = front["x"] + SCORE * (2 - front["x"]) ** 2
    # Of 200 even samples.
    np.testing.assert_allclose(front["percentile 95 y"], exact, rtol=0.02)
    assert front["x"][0] == pytest.approx(0.5, abs=1e-3)
    assert front["x"][-1] == pytest.approx(2 - 1 / (2 * SCORE), abs=0.01)
    assert np.all(np.diff(front["y"]) > 0)
    assert np.all(np.diff(front["percentile 95 y"]) < 0)
    with pytest.raises(ValueError, match="two different criteria"):
        robust_front(made, answers, {"x": 1.0}, {"x": (0.5, 1.99)}, minimize="y", against="y")


@pytest.mark.slow
def test_made_mechanisms_that_cannot_be_built_have_no_statistics():
    """A rod of negative stiffness would have a deformation, and count as one below every limit."""

    def rod(stiffness, factor=1.0):
        b = fm.Builder()
        b.node("wall", (0, 0))
        b.node("end", (1, 0))
        b.add(planar.truss, "wall", "end", section=fm.Rigidity(EA=stiffness * factor))
        b.fix("wall")
        b.fix("end", "y")
        b.force("end", (1.0, 0))
        b.dof("end", "x")
        return b.build()

    search = {"targets": {"mean u": 100.0}, "samples": 32}
    answers, start, bounds = {"u": "stiffness end.x"}, {"stiffness": 100.0}, {"stiffness": (50.0, 500.0)}
    with pytest.raises(ValueError, match=r"impossible_design.*Every made mechanism needs one: narrow `scatter`"):
        fm.tune(rod, answers, start, bounds, scatter=fm.scatter({"stiffness": 80.0}), **search)
    factors = fm.scatter({"factor": 0.8}, nominal={"factor": 1.0})
    with pytest.raises(ValueError, match="impossible_design"):
        fm.tune(rod, answers, start, bounds, scatter=factors, **search)
    found = fm.tune(rod, answers, start, bounds, scatter=fm.scatter({"stiffness": 10.0}), **search)
    # The mean of 32 even samples is off by a part of the scatter over 32.
    assert found.dimensions["stiffness"] == pytest.approx(100.0, abs=10.0 / 32)


def test_a_percentile_beyond_all_samples_lies_in_its_interval():
    found = fm.design.robustness(made, {"y": lambda m: m["x"]}, {"x": 1.0}, fm.scatter({"x": 0.1}), samples=50)
    lowest, highest = np.min(found.samples.answers["y"]), np.max(found.samples.answers["y"])
    assert found.percentile("y", 0.001) == (pytest.approx(lowest, rel=1e-14), -np.inf, lowest)
    assert found.percentile("y", 99.999) == (pytest.approx(highest, rel=1e-14), highest, np.inf)


@pytest.mark.parametrize("pair", [(np.nan, None), (None, np.nan), (np.nan, 2.0)])
def test_limits_that_are_no_numbers_are_refused(pair):
    """No mechanism would be acceptable."""
    scatter, answers = fm.scatter({"x": 0.1}), {"y": lambda m: m["x"]}
    with pytest.raises(ValueError, match="limit of 'y' is NaN"):
        fm.design.robustness(made, answers, {"x": 1.0}, scatter, limits={"y": pair}, samples=10)
    with pytest.raises(ValueError, match="limit of 'y' is NaN"):
        fm.tune(made, answers, {"x": 1.0}, {"x": (0, 2)}, maximize="yield", scatter=scatter, acceptable={"y": pair})


@pytest.mark.parametrize("pair", [([0.5, 0.6], None), (None, [1.5, 1.6])])
def test_limits_of_another_shape_are_refused(pair):
    answers = {"y": lambda m: m["x"]}
    with pytest.raises(ValueError, match=r"limit of 'y' must be a number or of shape \(\)"):
        fm.design.robustness(made, answers, {"x": 1.0}, fm.scatter({"x": 0.1}), limits={"y": pair}, samples=10)


def test_percentiles_beyond_the_samples_are_refused():
    scatter = fm.scatter({"x": 0.1})
    for text in ("percentile 99.5 y", "percentile 0.5 y"):
        with pytest.raises(ValueError, match=rf"'{text}' lies beyond 128 samples\. Give `samples`, 200 or more"):
            fm.tune(made, {"y": lambda m: m["x"]}, {"x": 1.0}, {"x": (0.5, 2.0)}, minimize=text, scatter=scatter)
    answers, targets = {"y": lambda m: m["x"]}, {"percentile 99.5 y": 1.5}
    found = fm.tune(made, answers, {"x": 1.0}, {"x": (0.5, 2.0)}, targets=targets, scatter=scatter, samples=200)
    # Of 200 even samples the highest, within the scatter of it.
    assert found.dimensions["x"] == pytest.approx(1.5 - 0.1 * norm.ppf(0.995), abs=0.03)


def test_a_limit_at_infinity_is_none():
    found = [
        fm.tune(
            made,
            {"y": lambda m: m["x"]},
            {"x": 1.0},
            {"x": (0.5, 2.0)},
            targets={"yield": 0.9},
            acceptable={"y": (1.0, upper)},
            scatter=fm.scatter({"x": 0.1}),
        ).dimensions["x"]
        for upper in (None, np.inf)
    ]
    assert found[0] == pytest.approx(1.0 + 0.1 * norm.ppf(0.9), abs=0.005)
    assert found[1] == pytest.approx(found[0], rel=1e-9)


def test_what_has_choices_has_no_nominal_value():
    with pytest.raises(ValueError, match="'number' has choices and a nominal value"):
        fm.tune(
            made,
            {"y": lambda m: m["x"] * m["number"]},
            {"x": 1.0},
            {"x": (0.5, 2.0)},
            choices={"number": [1.0, 2.0]},
            targets={"mean y": 1.0},
            scatter=fm.scatter({"number": 0.1}, nominal={"number": 1.0}),
        )
    with pytest.raises(ValueError, match="A front has no `choices`"):
        robust_front(
            made, {"y": cube}, {"x": 1.0}, {"x": (0.5, 2.0)}, minimize="y", against="z", choices={"number": [1, 2]}
        )


@pytest.mark.filterwarnings("ignore:The scatter of 'y' .*is not linear", "ignore:Of 200 mechanisms")
def test_samples_without_answers_are_told():
    answers = {"y": lambda m: jnp.sqrt(m["x"])}
    with pytest.warns(fm.FlexmbWarning, match=r"Of 200 samples \d+ have no answers .*leave them out"):
        fm.design.tolerances(made, answers, {"x": 1.0}, {"x": 0.5}, samples=200)
    with pytest.warns(fm.FlexmbWarning, match=r"The nominal design has no answers \(not_finite\)"):
        found = fm.design.robustness(made, answers, {"x": -0.01}, fm.scatter({"x": 1.0}), samples=200)
    assert np.isnan(found.nominal["y"])


def test_an_object_is_about_deviations():
    with pytest.raises(ValueError, match=r"must enclose zero\. They are added to the nominal value"):
        fm.scatter({"t": norm(0.5e-3, 5e-6)})
    with pytest.raises(ValueError, match="must enclose zero"):
        fm.scatter({"t": uniform(-3.0, 1.0)})
    fm.scatter({"t": uniform(0.0, 1.0), "s": norm(0.1, 0.1)})
