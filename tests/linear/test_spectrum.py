"""The solutions of (K, M) agree with each other, also where motions carry no mass or meet no stiffness."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

from flexmb.linear.spectrum import (
    general_spectrum,
    is_real,
    massless_freedoms,
    poles_of,
    response_without_mass,
    spectrum,
    symmetric_eigenvalues,
    to_frequency,
)

# omega^2 of a motion without mass, of one without stiffness, and of some between.
CASES = {
    "ordinary": [4.0, 9.0, 2e4],
    "massless": [4.0, 9.0, np.inf],
    "free": [0.0, 9.0, 2e4],
    "both": [0.0, 9.0, np.inf],
}


def pair(values, seed=3):
    """Stiffness and mass with given eigenvalues, in coordinates that mix the motions."""
    turned = np.linalg.qr(np.random.default_rng(seed).standard_normal((len(values), len(values))))[0]
    mass = np.isfinite(values).astype(float)
    stiffness = np.where(np.isfinite(values), values, 50.0)
    return turned @ np.diag(stiffness) @ turned.T, turned @ np.diag(mass) @ turned.T


@pytest.mark.slow("ordinary", "massless", "free")
@pytest.mark.parametrize("name", CASES)
def test_every_solution_finds_the_same(name):
    values = np.array(CASES[name])
    k, m = pair(values)
    massive = values[np.isfinite(values)]
    # Beside a free motion, round-off over the shift: eight digits (2.9e-9 with JAX 0.12), or nine where K may be
    # unsymmetric.
    tolerance = dict(rtol=1e-9, atol=1e-9 * np.max(massive))
    np.testing.assert_allclose(jax.jit(spectrum)(k, m)[0], values, rtol=1e-8, atol=1e-8 * np.max(massive))
    np.testing.assert_allclose(symmetric_eigenvalues(k, m), massive, **tolerance)
    found, vectors = general_spectrum(k, m)
    np.testing.assert_allclose(found.real, values, **tolerance)
    assert np.all(is_real(found[np.abs(found) > 1]))
    for w, v in zip(found[: len(massive)], vectors.T[: len(massive)], strict=True):
        np.testing.assert_allclose(k @ v, w * (m @ v), atol=1e-9 * np.max(np.abs(k)))
    poles = poles_of(k, 0 * k, m)
    assert poles.shape == (2 * len(massive),)
    np.testing.assert_allclose(np.sort(np.abs(poles) ** 2), np.sort(np.repeat(massive, 2)), rtol=1e-8, atol=1e-7)


def test_complex_eigenvalues_are_no_real_ones():
    k = np.array([[4.0, 1.0, 0.0], [-1.0, 4.0, 0.0], [0.0, 0.0, 9.0]])
    found, _ = general_spectrum(k, np.eye(3))
    np.testing.assert_allclose(np.sort_complex(found), [4 - 1j, 4 + 1j, 9], atol=1e-14)
    assert is_real(found).tolist() == [False, False, True]


@pytest.mark.slow
def test_frequencies_on_the_host_are_those_of_traced_numbers():
    values = np.array([-4.0, 0.0, 9.0, np.inf])
    np.testing.assert_array_equal(to_frequency(values), np.asarray(to_frequency(jnp.asarray(values))))
    assert to_frequency(values)[2] == approx(1.5 / np.pi, rel=1e-15)


@pytest.mark.slow
def test_motions_without_mass_are_condensed():
    """What is condensed answers a force as a static problem in which the others stand still by their inertia."""
    k, m = pair(np.array(CASES["massless"]))
    condensed = tuple(massless_freedoms(m))
    assert len(condensed) == 1
    null = np.linalg.eigh(m)[1][:, :1]
    force = np.array([1.0, -2.0, 0.5])
    expected = null[:, 0] * (null[:, 0] @ force) / (null[:, 0] @ k @ null[:, 0])
    np.testing.assert_allclose(response_without_mass(m, k, condensed, force, np.linalg.solve), expected, atol=1e-15)
    traced = response_without_mass(jnp.asarray(m), jnp.asarray(k), condensed, jnp.asarray(force))
    np.testing.assert_allclose(traced, expected, atol=1e-15)
