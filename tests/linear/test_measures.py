"""Eigenvalues that meet: derivatives of functions of a cluster, and modes followed through a crossing."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.math.linear import pencil

M, K = 0.5, 800.0


def cross(stiff, mass=M):
    """A point held by two springs along x and y: modes along x and y, and a skew third spring couples them."""
    b = fm.Builder()
    b.node("p", (0, 0))
    for name, place, k in (("right", (1, 0), stiff[0]), ("up", (0, 1), stiff[1]), ("skew", (1, 1), stiff[2])):
        b.node(name, place)
        length = float(np.linalg.norm(place))
        b.add(planar.truss, "p", name, name=f"spring {name}", section=fm.Rigidity(EA=k * length))
        b.fix(name)
    b.mass("p", mass)
    b.dof("p", "x", "y")
    return b.build()


def exact(stiff):
    """Squares of the frequencies, from the stiffness matrix."""
    kx, ky, ks = stiff
    return np.linalg.eigvalsh(np.array([[kx + ks / 2, ks / 2], [ks / 2, ky + ks / 2]]) / M)


def hertz(stiff):
    return np.sqrt(exact(stiff)) / (2 * np.pi)


@pytest.mark.slow
@pytest.mark.parametrize("gap", [0.0, 1e-13, 1e-11, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("function", [jnp.sum, fm.linear.smooth_minimum], ids=["sum", "smooth minimum"])
def test_functions_of_a_cluster_have_right_derivatives(gap, function):
    at = jnp.array([K, K * (1 + gap), 0.0])

    def value(stiff):
        return function(fm.frequencies(cross(stiff)))

    reverse, forward = fm.jit(jax.grad(value))(at), fm.jit(jax.jacfwd(value))(at)
    h = 1e-5 * K
    for i in range(3):
        step = h * np.eye(3)[i]
        difference = (function(hertz(at + step)) - function(hertz(at - step))) / (2 * h)
        # Truncation of the difference: the curvature of the smooth minimum is its sharpness, 50, over the frequency.
        assert reverse[i] == approx(float(difference), rel=1e-6)
    np.testing.assert_allclose(forward, reverse, rtol=1e-9)


@pytest.mark.slow
def test_near_a_repeated_pair_each_eigenvalue_has_its_own_derivative():
    # Two coupled oscillators: omega^2 = (k +- s/2)/m moves by +-1/(2 m) per skew stiffness, however near they are.
    for gap in (1e-3, 1e-6, 1e-8):
        at = jnp.array([K, K, gap * K])
        slopes = fm.jit(jax.jacfwd(lambda s: (2 * jnp.pi * fm.frequencies(cross(s))) ** 2))(at)
        # The vectors of the pair are known to eps/gap.
        np.testing.assert_allclose(slopes[:, 2], [0.0, 1 / M], atol=1e-15 / gap / M * 10 + 1e-9)


@pytest.mark.slow
def test_vectors_and_second_derivatives_at_a_repeated_pair():
    a, b = np.diag([1.0, 1.0, 3.0]), np.diag([1.0, 2.0, 1.0])
    turn = np.array([[0.0, 1.0, 2.0], [1.0, 0.0, 1.0], [2.0, 1.0, 0.0]])
    shift = np.array([[0.3, 0.1, 0.0], [0.1, 0.2, 0.1], [0.0, 0.1, 0.1]])

    def by_modes(t, at):
        mu, w = pencil(at + t * turn, b + t * shift)
        return jnp.stack([jnp.sum(mu), jnp.sum((w @ w.T) * turn)])

    def exact(t, at):
        # The sum of the eigenvalues is the trace of B^-1 A, and W W^T is B^-1, whatever the vectors of the pair.
        inverse = jnp.linalg.inv(b + t * shift)
        return jnp.stack([jnp.trace(inverse @ (at + t * turn)), jnp.sum(inverse * turn)])

    @fm.jit
    def derivatives(at):
        """Forward, reverse, and twice, of both."""
        ways = (jax.jacfwd, jax.jacrev, lambda f: jax.jacfwd(jax.jacrev(f)))
        return [[way(function)(0.0, at) for function in (by_modes, exact)] for way in ways]

    other = np.array(a)
    other[1, 1] = 2.0  # the second is repeated: 2/2 = 1/1
    for at in (a, other):
        *first, (twice, expected) = derivatives(at)
        for found, same in first:
            np.testing.assert_allclose(found, same, rtol=1e-12, atol=1e-12)
        # Of second order only finite: that of the sum misses what the pair's own rotation adds where B changes.
        assert np.all(np.isfinite(twice))
        assert twice[1] == approx(float(expected[1]), rel=1e-11)


@pytest.mark.slow
def test_smooth_minimum_is_near_the_minimum():
    values = jnp.array([2.0, 2.0, 3.0, jnp.inf])
    # Closed form: (2 + (2/3)^50)^(-1/50) * 2.
    assert fm.linear.smooth_minimum(values) == approx(2 * (2 + (2 / 3) ** 50) ** (-1 / 50), rel=1e-12)
    assert fm.linear.smooth_maximum(values[:3], 2.0) == approx(np.sqrt(17), rel=1e-12)
    assert np.all(np.isfinite(jax.grad(fm.linear.smooth_minimum)(values)))
    with pytest.raises(ValueError, match="must be positive"):
        fm.linear.smooth_minimum(jnp.array([-1.0, 2.0]))


def test_modes_are_followed_by_shape():
    one, other = (fm.modes(cross((K, k, 0.02 * K))) for k in (1.4 * K, 0.6 * K))
    np.testing.assert_array_equal(fm.linear.follow_modes(one, other), [1, 0])
    np.testing.assert_allclose(fm.linear.mode_assurance(one, one), np.eye(2), atol=1e-12)  # round-off
    # Rows are shares of a whole.
    np.testing.assert_allclose(fm.linear.mode_assurance(one, other).sum(axis=0), 1.0, rtol=1e-9)


def test_three_modes_that_change_places_in_turn_are_followed():
    # Which mode each has become, and not where each has come from: that is another answer from three on.
    def masses(*stiffness):
        b = fm.Builder()
        for i, k in enumerate(stiffness):
            b.node(f"foot{i}", (0.0, i))
            b.node(f"mass{i}", (1.0, i))
            b.fix(f"foot{i}")
            b.fix(f"mass{i}", "y")
            b.add(planar.truss, f"foot{i}", f"mass{i}", section=fm.Rigidity(EA=k, mass=1.0))
        return fm.modes(b.build())

    np.testing.assert_array_equal(fm.linear.follow_modes(masses(1.0, 2.0, 3.0), masses(2.0, 3.0, 1.0)), [1, 2, 0])


@pytest.mark.slow
def test_a_frequency_is_followed_through_a_crossing():
    shape = fm.modes(cross((K, 1.4 * K, 0.0))).q_shapes[:, 1]  # along y

    def followed(k):
        return fm.linear.frequency_like(cross((K, k, 0.0)), shape)

    for k in (1.4 * K, 1.0001 * K, K * (1 + 1e-12), K, 0.9999 * K, 0.6 * K):
        # Closed form of the oscillator along y: sqrt(k/m)/2 pi, whatever the other does.
        value, slope = fm.jit(jax.value_and_grad(followed))(k)
        assert value == approx(np.sqrt(k / M) / (2 * np.pi), rel=1e-10)
        assert slope == approx(np.sqrt(1 / (k * M)) / (4 * np.pi), rel=1e-9)
    # At the crossing itself the solver's vectors lie along x and y; the mode along the diagonal is made of both.
    slanted = np.array([1.0, 1.0])
    across = np.array([1.0, -1.0])
    like = fm.jit(jax.value_and_grad(lambda s, along: fm.linear.frequency_like(cross((K, K, s)), along)))
    for skew in (0.1 * K, 1e-9 * K, 0.0):
        value, slope = like(skew, slanted)
        assert value == approx(np.sqrt((K + skew) / M) / (2 * np.pi), rel=1e-8)  # the share of the cluster
        assert slope == approx(np.sqrt(1 / ((K + skew) * M)) / (4 * np.pi), rel=1e-6)
        # The skew spring does not act across itself: this mode is the lower one.
        value, slope = like(skew, across)
        assert value == approx(np.sqrt(K / M) / (2 * np.pi), rel=1e-8)
        assert slope == approx(0.0, abs=1e-6 / (4 * np.pi * np.sqrt(K * M)))
    with pytest.raises(ValueError, match="must have 2 entries"):
        fm.linear.frequency_like(cross((K, K, 0.0)), shape[:1])


def guide(length):
    """A guide whose second leaf spring has another length; no degrees of freedom are named."""
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0.1 - length)}.items():
        b.node(name, place)
    for p, q, thick in (("A", "B", 0.5e-3), ("D", "C", 0.5e-3), ("B", "C", 5e-3)):
        section = fm.Rectangle(18e-3, thick, fm.Material(E=210e9, G=80e9, rho=7850))
        b.add(planar.beam, p, q, section=section)
    b.fix("A")
    b.fix("D")
    for node in "BC":
        b.mass(node, 0.1)
    return b.build()


def test_modes_are_compared_whatever_their_degrees_of_freedom():
    one, other = fm.modes(guide(0.1)), fm.modes(guide(0.1001))
    # Found degrees of freedom are others in designs that differ by a thousandth.
    assert one.lin.model.q_labels != other.lin.model.q_labels
    np.testing.assert_array_equal(fm.linear.follow_modes(one, other), np.arange(6))
    # A criterion is one less the square of how far shapes differ.
    np.testing.assert_allclose(np.diag(fm.linear.mode_assurance(one, other)), 1.0, atol=2e-3)
    for model, modes in ((guide(0.1), other), (guide(0.1001), one)):
        found = fm.linear.frequency_like(model, modes, 1)
        assert found == approx(float(fm.frequencies(model)[1]), rel=1e-12)
    with pytest.raises(ValueError, match=r"`number` .* one of the 6 modes, from 0, but is 6"):
        fm.linear.frequency_like(guide(0.1), one, 6)
    with pytest.raises(ValueError, match=r"`number` .* needs Modes"):
        fm.linear.frequency_like(guide(0.1), np.ones(6), 1)
    with pytest.raises(ValueError, match=r"the models differ\. Their nodes or elements have other names"):
        fm.linear.mode_assurance(one, fm.modes(cross((K, K, 0.0))))
