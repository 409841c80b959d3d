"""Scatter that grows with the answer, where a fit assumes a common deviation."""

import warnings

import numpy as np
import pytest
from cases.mechanisms import cart_on_rod

import flexmb as fm
from flexmb import planar
from flexmb.identification.fit import ratio_of_scatter

MASS, STIFFNESS, DAMPING = 2.0, 200.0, 1.0
BOUNDS = {"stiffness": (20, 2000), "damping": (0.01, 10)}
TRUTH = {"stiffness": STIFFNESS, "damping": DAMPING}
HERTZ = np.linspace(0.2, 4.0, 60)
S = 2j * np.pi * HERTZ
CLEAN = 1 / (MASS * S**2 + DAMPING * S + STIFFNESS)


def oscillator(stiffness, damping):
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.truss, "wall", "cart", section=fm.Rigidity(EA=stiffness), damping=fm.Damping(EA=damping))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", MASS)
    b.dof("cart", "x")
    b.input("cart", "x")
    b.output("cart", "x")
    return b.build()


def noise(count=60, seed=3):
    return np.random.default_rng(seed).standard_normal((count, 2)) @ [1, 1j]


def fitted(values, deviation=None, logarithmic=False):
    """Return the result and the warnings of scatter that depends on the answer."""
    data = fm.measured_response(HERTZ, values, deviation, logarithmic=logarithmic)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = fm.fit(oscillator, data, TRUTH, BOUNDS)
    return found, [str(w.message) for w in caught if "times as much where" in str(w.message)]


def test_noise_in_proportion_to_a_response_needs_a_deviation():
    values = CLEAN + 0.03 * np.abs(CLEAN) * noise()
    found, texts = fitted(values)
    assert found.result is fm.RESULTS.successful
    assert len(texts) == 1
    assert "where the answer is large" in texts[0]
    assert "The intervals are too narrow" in texts[0]
    assert "a relative deviation), or logarithmic=True" in texts[0]
    for better in (fitted(values, 0.03 * np.abs(CLEAN)), fitted(values, logarithmic=True)):
        assert better[1] == []
        # The intervals without deviation are too narrow.
        assert better[0].deviation["damping"] > 2 * found.deviation["damping"]
        for name, value in TRUTH.items():
            # Four deviations of a normal distribution: missed once in 16 000.
            assert abs(better[0].parameters[name] - value) < 4 * better[0].deviation[name]


def test_equal_noise_has_no_warning_and_is_uneven_in_logarithms():
    values = CLEAN + 0.003 * np.max(np.abs(CLEAN)) * noise()
    assert fitted(values)[1] == []
    (text,) = fitted(values, logarithmic=True)[1]
    assert "where the answer is small" in text
    assert "or omit logarithmic=True" in text


def test_a_common_deviation_that_is_right_in_the_mean_only():
    """Chi-squared alone finds a wrong size of the deviation, and not a wrong distribution."""
    values = CLEAN + 0.03 * np.abs(CLEAN) * noise()
    found, texts = fitted(values, fitted(values)[0].noise)
    assert found.result is fm.RESULTS.successful
    assert found.probability > 0.3
    assert len(texts) == 1
    assert "weighs them by deviations" in texts[0]
    found, texts = fitted(values, fitted(values)[0].noise / 2)
    assert found.result is fm.RESULTS.poor_fit
    assert texts == []


def test_a_force_curve_of_an_instrument_with_a_relative_error():
    strokes = np.linspace(0.02, 1.0, 40)

    def forces(model):
        return strokes / (fm.equilibrium(model).position("cart")[0] - 1)

    values = STIFFNESS * strokes * (1 + 0.03 * noise(40).real)
    data = fm.measured(forces, values, name="force")
    given = (lambda stiffness: cart_on_rod(stiffness, 1.0, 1.0).build(), data, {"stiffness": 150.0})
    with pytest.warns(
        fm.FlexmbWarning, match="of measurement 'force' scatter .* times as much where the answer is large"
    ):
        fm.fit(*given, {"stiffness": (10, 1000)})


@pytest.mark.parametrize("count", [8, 12, 20, 40, 200])
@pytest.mark.parametrize("kind", ["normal", "student", "proportional"])
def test_false_and_right_alarms(count, kind):
    """Linear fits of stiffness, damping and mass: differences are the noise without its part along the slopes."""
    rng = np.random.default_rng(count)
    s = 2j * np.pi * np.linspace(0.2, 4.0, count)
    clean = 1 / (MASS * s**2 + DAMPING * s + STIFFNESS)
    slopes = np.array([-(clean**2), -s * clean**2, -(s**2) * clean**2]).T
    basis, _ = np.linalg.qr(np.concatenate([slopes.real, slopes.imag]))
    sizes, remaining = np.tile(np.abs(clean), 2), 1 - np.sum(basis**2, axis=1)
    draws = 1000
    sample = rng.standard_t(3, (draws, 2 * count)) if kind == "student" else rng.standard_normal((draws, 2 * count))
    sample = sample * sizes if kind == "proportional" else sample
    differences = sample - sample @ basis @ basis.T
    alarms = sum(ratio_of_scatter(row, remaining, sizes) is not None for row in differences)
    if kind != "proportional":
        # At a rate of 0.6 %, more than 15 of 1000 are seen once in 1000 runs.
        assert alarms <= 15
    elif count >= 40:
        assert alarms >= 0.99 * draws
