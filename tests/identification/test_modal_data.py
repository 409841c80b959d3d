"""Modal data from responses: closed-form sums of modes with noise, and a guide that is fitted to them."""

from typing import Any

import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.identification import modes_of_response

HERTZ = np.linspace(2.0, 150.0, 300)
FREQUENCIES, DAMPING = np.array([11.0, 40.0, 41.0, 120.0]), np.array([0.01, 0.005, 0.008, 0.02])
SHAPES = np.array([[1.0, 0.4, -0.3, 0.5], [0.6, 1.0, 1.0, -0.7], [-0.2, 0.5, 0.9, 1.0]])


def responses(hertz=HERTZ, modes=4, beyond=0.0) -> Any:
    s = 2j * np.pi * hertz[:, None]
    omega = 2 * np.pi * FREQUENCIES[:modes]
    each = 1 / (s**2 + 2 * DAMPING[:modes] * omega * s + omega**2)
    return each @ (SHAPES[:, :modes] * SHAPES[0, :modes]).T + beyond


def noisy(clean, share, seed):
    rng = np.random.default_rng(seed)
    return clean + share * np.abs(clean) * (rng.standard_normal(clean.shape) + 1j * rng.standard_normal(clean.shape))


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["position", "acceleration"])
def test_modes_of_a_sum_of_modes_without_noise(quantity):
    s = 2j * np.pi * HERTZ[:, None]
    rates = s**2 if quantity == "acceleration" else 1.0
    # A mode above the band adds a constant to the response of positions.
    found = modes_of_response(HERTZ, responses(beyond=1e-5) * rates, modes=4, quantity=quantity)
    np.testing.assert_allclose(found.hertz, FREQUENCIES, rtol=1e-8)
    np.testing.assert_allclose(found.damping, DAMPING, rtol=1e-6)
    np.testing.assert_allclose(found.shapes, SHAPES, atol=1e-6)
    np.testing.assert_allclose(found.fitted, responses(beyond=1e-5) * rates, rtol=1e-6)
    # R = phi_y phi_u/(2 i w_d) of a unit modal mass.
    omega = 2 * np.pi * FREQUENCIES * np.sqrt(1 - DAMPING**2)
    expected = SHAPES * SHAPES[0] / (2j * omega)
    power = found.poles**2 if quantity == "acceleration" else 1.0
    np.testing.assert_allclose(found.residues, expected * power, rtol=1e-5)


@pytest.mark.slow
def test_deviations_are_those_of_repetitions():
    clean = responses(modes=2)
    deviation = 0.03 * np.abs(clean)
    found = [modes_of_response(HERTZ, noisy(clean, 0.03, seed), deviation, modes=2) for seed in range(30)]
    assert found[0].noise == pytest.approx(1.0, abs=0.1)
    for name, truth in (("hertz", FREQUENCIES[:2]), ("damping", DAMPING[:2])):
        values = np.stack([getattr(one, name) for one in found])
        stated = np.stack([getattr(one, f"{name}_deviation") for one in found])
        # A deviation of 30 values scatters by 1/sqrt(58); three of those. A mean by 1/sqrt(30) deviations; four.
        np.testing.assert_allclose(np.std(values, axis=0, ddof=1), stated.mean(axis=0), rtol=3 / np.sqrt(58))
        assert np.all(np.abs(values.mean(axis=0) - truth) < 4 * stated.mean(axis=0) / np.sqrt(30))


@pytest.mark.slow
def test_the_number_of_modes_follows_from_noisy_responses():
    found = modes_of_response(HERTZ, noisy(responses(), 0.05, 7))
    assert len(found.hertz) == 4
    assert np.all(np.abs(found.hertz - FREQUENCIES) < 4 * found.hertz_deviation)
    assert np.all(np.abs(found.damping - DAMPING) < 4 * found.damping_deviation)
    assert found.noise == pytest.approx(0.05, rel=0.1)
    assert "mode 2: 40.0" in str(found)


def test_wrong_responses_are_named():
    clean = responses()
    with pytest.raises(ValueError, match="There are 300 frequencies, but responses of"):
        modes_of_response(HERTZ, clean[:-1])
    with pytest.raises(ValueError, match="Row 4 of 300 has a value that is not finite or zero"):
        modes_of_response(HERTZ, np.where(np.arange(300)[:, None] == 3, np.nan, clean))
    with pytest.raises(ValueError, match="positive and ascending"):
        modes_of_response(HERTZ[::-1], clean)
    with pytest.raises(ValueError, match="A deviation is -1"):
        modes_of_response(HERTZ, clean, -1.0)
    with pytest.raises(ValueError, match=r"Response 1 of .* is real and positive at all frequencies"):
        modes_of_response(HERTZ, np.abs(clean))
    with pytest.raises(ValueError, match="do not determine 3 modes"):
        modes_of_response(HERTZ[:8], clean[:8, :1], modes=3)
    with pytest.raises(ValueError, match="quantity"):
        modes_of_response(HERTZ, clean, quantity="force")  # type: ignore


@pytest.mark.parametrize(
    ("ratio", "text"),
    [
        (0.6, "The search for mode 1 ended at a bound, .* damping ratio of 0.5"),
        (0.0, "do not determine the damping of mode 1, at 25.46 Hz"),
    ],
)
def test_a_mode_at_a_bound_of_its_search_is_told(ratio, text):
    """One oscillator that is damped more than a mode may be, or not at all, beside an ordinary one."""
    s = 2j * np.pi * HERTZ
    clean = sum(1 / (s**2 + 2 * z * w * s + w**2) for z, w in ((ratio, 160.0), (0.02, 400.0)))
    with pytest.warns(fm.FlexmbWarning, match=text):
        modes_of_response(HERTZ, noisy(clean, 1e-3, 3), modes=2)


@pytest.mark.filterwarnings("ignore:The responses do not determine the damping")
def test_real_responses_without_damping_have_modes():
    """Unlike a magnitude, the receptance of an undamped mechanism changes its sign at each resonance."""
    clean = sum(1 / (w**2 - (2 * np.pi * HERTZ) ** 2) for w in (160.0, 400.0))
    found = modes_of_response(HERTZ, clean, modes=2)
    np.testing.assert_allclose(2 * np.pi * found.hertz, (160.0, 400.0), rtol=1e-6)


def test_what_modes_do_not_explain_is_told():
    with pytest.warns(fm.FlexmbWarning, match="times the given deviations"):
        modes_of_response(HERTZ, responses(), 1e-3 * np.abs(responses()), modes=2)


def two_carts(left, right):
    b = fm.Builder()
    for name, place in {"wall": 0, "left": 1, "right": 2}.items():
        b.node(name, (place, 0))
    for p, q, stiffness in (("wall", "left", left), ("left", "right", right)):
        b.add(planar.truss, p, q, name=f"{p} to {q}", section=fm.Rigidity(EA=stiffness))
    b.fix("wall")
    for name in ("left", "right"):
        b.fix(name, "y")
        b.mass(name, 2.0)
        b.dof(name, "x")
        b.output(name, "x")
    b.input("left", "x")
    return b.build()


@pytest.mark.slow
def test_modes_of_responses_are_data_of_a_fit():
    hertz = np.linspace(0.3, 5.0, 200)
    clean = np.asarray(fm.frequency_response(two_carts(200.0, 150.0), hertz, loss_factor=0.02).response)[:, :, 0]
    found = modes_of_response(hertz, noisy(clean, 0.01, 3))
    assert len(found.hertz) == 2
    # Ratios are half of a small loss factor.
    np.testing.assert_allclose(found.damping, 0.01, rtol=0.05)
    data = found.measured(at=["left.x", "right.x"])
    fitted = fm.fit(two_carts, data, {"left": 160.0, "right": 180.0}, {"left": (20, 2000), "right": (15, 1500)})
    for name, truth in {"left": 200.0, "right": 150.0}.items():
        # Structural damping shifts a frequency by less than the square of the ratio.
        assert abs(fitted.parameters[name] - truth) < 4 * fitted.deviation[name] + 1e-3 * truth
