"""Posterior distributions by NUTS, against quadrature of closed forms."""

import warnings

import numpy as np
import pytest
from cases.mechanisms import cart_on_rod

import flexmb as fm

STIFFNESS, MASS = 100.0, 4.0
BOUNDS = {"stiffness": (50.0, 200.0), "mass": (1.0, 16.0)}


def cart(stiffness=STIFFNESS, mass=MASS):
    return cart_on_rod(stiffness, mass).build()


def moments(density, stiffness, mass):
    """Mean and deviation of both by a sum over the logarithms of both."""
    weight = density / np.sum(density)
    means = [np.sum(weight * x) for x in (stiffness, mass)]
    return means, [np.sqrt(np.sum(weight * (x - m) ** 2)) for x, m in zip((stiffness, mass), means, strict=True)]


def check(found, expected):
    for name, mean, deviation in zip(("stiffness", "mass"), *expected, strict=True):
        samples, independent = found.parameters[name], found.draws[name]
        # Four deviations of a mean, and of a deviation of a distribution with tails as of an exponential one.
        assert np.mean(samples) == pytest.approx(mean, abs=4 * deviation / np.sqrt(independent))
        assert np.std(samples) == pytest.approx(deviation, rel=4 * np.sqrt(2 / independent))


@pytest.mark.slow
@pytest.mark.parametrize("case", ["both", "frequency alone", "prior"])
def test_samples_have_the_moments_of_the_posterior(case):
    pytest.importorskip("numpyro")
    frequency, shift = np.sqrt(STIFFNESS / MASS) / (2 * np.pi), 1 / STIFFNESS
    data = {"frequency 1": (frequency, 0.05 * frequency), "displacement cart.x": (shift, 0.2 * shift)}
    priors = {"mass": (5.0, 1.0)} if case == "prior" else {}
    if case == "frequency alone":
        data["displacement cart.x"] = (shift, 1e3 * shift)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fm.FlexmbWarning)
        fitted = fm.fit(cart, data, {"stiffness": 90.0, "mass": 5.0}, BOUNDS, priors=priors)
    found = fitted.sample(1500, seed=1)
    axes = [np.geomspace(*BOUNDS[name], 800) for name in BOUNDS]
    k, m = np.meshgrid(*axes, indexing="ij")
    square = ((np.sqrt(k / m) / (2 * np.pi) / frequency - 1) / 0.05) ** 2
    square += (((1 / k) / shift - 1) / (data["displacement cart.x"][1] / shift)) ** 2
    density = np.exp(-square / 2)
    if priors:
        density = density * np.exp(-((m - 5.0) ** 2) / 2) * m
    check(found, moments(density, k, m))
    assert found.divergences == 0
    assert max(found.mixing.values()) < 1.05
    # Predictions have the scatter of the data, or less.
    predicted = found.predict("frequency 1", samples=100)["frequency 1"]
    assert np.std(predicted) < 1.4 * 0.05 * frequency
    lower, upper = found.interval("mass", 0.9)
    assert np.mean((found.parameters["mass"] > lower) & (found.parameters["mass"] < upper)) == pytest.approx(
        0.9, abs=0.01
    )
    with pytest.raises(KeyError, match="no parameter 'width'"):
        found.interval("width")


@pytest.mark.slow
def test_an_unknown_deviation_is_integrated_out():
    """The mean of n normal values has Student's distribution of n - 1 degrees of freedom."""
    pytest.importorskip("numpyro")
    values = MASS + 0.3 * np.random.default_rng(5).standard_normal(6)
    data = fm.measured(lambda model: fm.mass(model) * np.ones(6), values, name="scale")
    fitted = fm.fit(lambda mass: cart(mass=mass), data, {"mass": 5.0}, {"mass": (-20.0, 30.0)})
    found = fitted.sample(3000, seed=2)
    scale = np.std(values, ddof=1) / np.sqrt(6)
    # Student's 97.5 % quantile of 5 degrees of freedom; its scatter in as many samples is 8 %.
    lower, upper = found.interval("mass")
    assert (upper - lower) / 2 == pytest.approx(2.5706 * scale, rel=0.25)
    assert np.mean(found.parameters["mass"]) == pytest.approx(np.mean(values), abs=4 * 1.3 * scale / np.sqrt(500))


def test_what_cannot_be_sampled_is_refused():
    data = {"frequency 1": (0.796, 0.01), "mass": (4.0, 0.1)}
    robust = fm.fit(cart, data, {"stiffness": 90.0, "mass": 5.0}, BOUNDS, loss="huber")
    with pytest.raises(ValueError, match="'huber' corresponds to no distribution"):
        robust.sample()
    with pytest.raises(ValueError, match="count"):
        fm.fit(cart, data, {"stiffness": 90.0, "mass": 5.0}, BOUNDS).sample(0)


def test_without_the_sampler_its_extra_is_named():
    try:
        import numpyro  # noqa: F401  # pyright: ignore[reportMissingImports]
    except ImportError:
        data = {"frequency 1": (0.796, 0.01), "mass": (4.0, 0.1)}
        with pytest.raises(ImportError, match=r"flexmb\[bayes\]"):
            fm.fit(cart, data, {"stiffness": 90.0, "mass": 5.0}, BOUNDS).sample()
