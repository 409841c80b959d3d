"""Euler parameters against rotations made otherwise, and the rule of the initial frame."""

import hypothesis
import hypothesis.extra.numpy as npst
import jax
import numpy as np
import pytest
from cases.tolerances import approx
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb.math import rotation as r

EPS = np.finfo(float).eps
vectors = npst.arrays(float, 3, elements=st.floats(-1, 1).map(lambda x: round(x, 3)))
turns = vectors.map(lambda v: Rotation.from_rotvec(3 * v))


def parameters(turn: Rotation) -> np.ndarray:
    return turn.as_quat(scalar_first=True)


@given(turns)
def test_rotation_matrix_is_that_of_the_turn(turn):
    found = np.asarray(r.rotation_matrix(parameters(turn)))
    np.testing.assert_allclose(found, turn.as_matrix(), atol=20 * EPS)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=20 * EPS)
    assert np.linalg.det(found) == approx(1, abs=20 * EPS)
    # Both signs of the parameters are the same rotation.
    np.testing.assert_array_equal(r.rotation_matrix(-parameters(turn)), found)


@given(turns, npst.arrays(float, 4, elements=st.floats(-2, 2)))
def test_rotation_matrix_is_of_degree_two(turn, lam):
    # So says the docstring; the derivative by a parameter off the unit sphere rests on it.
    np.testing.assert_allclose(r.rotation_matrix(2 * lam), 4 * r.rotation_matrix(lam), atol=100 * EPS)


@given(st.floats(-10, 10))
def test_plane(angle):
    expected = Rotation.from_rotvec([0, 0, angle]).as_matrix()[:2, :2]
    np.testing.assert_allclose(r.rotation_plane(angle), expected, atol=20 * EPS)


@pytest.mark.slow
@given(npst.arrays(float, 3, elements=st.floats(-10, 10)))
def test_cosine_and_sine(angles):
    """They and their derivatives, forward, reverse and both, are those of NumPy's."""
    c, s = np.cos(angles), np.sin(angles)

    def sine(angles):
        return r.cosine_and_sine(angles)[1].sum()

    def slope(angles):
        return jax.grad(sine)(angles).sum()

    np.testing.assert_allclose(r.cosine_and_sine(angles), (c, s), atol=EPS)
    np.testing.assert_allclose(jax.grad(sine)(angles), c, atol=EPS)
    np.testing.assert_allclose(jax.jvp(slope, (angles,), (np.ones(3),))[1], -s.sum(), atol=4 * EPS)
    np.testing.assert_allclose(jax.grad(slope)(angles), -s, atol=EPS)


@given(turns, vectors)
def test_angular_velocity_from_the_rates(turn, omega):
    """Central difference of a finite turn about omega: 2 lbar lam_dot = omega, 2 lbody lam_dot = R^T omega."""
    step = EPS ** (1 / 3)
    lam = parameters(turn)

    def after(t):
        there = parameters(Rotation.from_rotvec(t * omega) * turn)
        return there if there @ lam > 0 else -there  # of the two signs, the one that is continuous

    rate = (after(step) - after(-step)) / (2 * step)
    # Truncation step^2/6 |omega/2|^3, round-off eps/step = 4e-11.
    np.testing.assert_allclose(2 * r.lbar(lam) @ rate, omega, atol=5e-10)
    np.testing.assert_allclose(2 * r.lbody(lam) @ rate, turn.inv().apply(omega), atol=5e-10)


@given(turns)
def test_rate_matrices_have_orthonormal_rows_across_the_parameters(turn):
    lam = parameters(turn)
    for matrix in (np.asarray(r.lbar(lam)), np.asarray(r.lbody(lam))):
        np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=20 * EPS)
        np.testing.assert_allclose(matrix @ lam, 0, atol=20 * EPS)


@given(turns, vectors, vectors)
def test_dual_of_a_moment_has_its_power(turn, moment, omega):
    # f = 2 lbar^T M: f . lam_dot = M . omega for the rates lam_dot = lbar^T omega / 2.
    lbar = np.asarray(r.lbar(parameters(turn)))
    assert (2 * lbar.T @ moment) @ (lbar.T @ omega / 2) == approx(moment @ omega, abs=20 * EPS)


@given(turns, turns, turns, turns)
def test_relative_turn_is_that_since_the_undeformed_state(p, q, ref_p, ref_q):
    axes = np.array([[0.6, 0.0, -0.8], [0.8, 0.0, 0.6], [0.0, -1.0, 0.0]])
    found = np.asarray(r.relative_turn(*map(parameters, (p, q, ref_p, ref_q)), axes))
    turned = parameters((p * ref_p.inv()).inv() * q * ref_q.inv())
    expected = np.append(turned[0], turned[1:] @ axes)
    sign = 1 if found @ expected > 0 else -1
    np.testing.assert_allclose(sign * found, expected, atol=40 * EPS)


@given(turns, turns, vectors)
def test_what_turns_with_a_triad(now, ref, vector):
    found = r.turned(parameters(now), parameters(ref), np.stack([vector, [1.0, 0, 0]], axis=1))
    expected = (now * ref.inv()).apply([vector, [1.0, 0, 0]])
    np.testing.assert_allclose(found, expected.T, atol=40 * EPS)


@pytest.mark.parametrize("angle", [0.3, -2.9, 3.0])
def test_polar_angle_and_its_derivatives(angle):
    """Of v = 2 (cos a, sin a): by the vector (-v2, v1)/v^2, and again (2 v1 v2, v2^2 - v1^2; .., -2 v1 v2)/v^4."""
    vector = 2 * np.array([np.cos(angle), np.sin(angle)])
    assert float(r.polar_angle(vector)) == approx(angle, rel=1e-15)
    c, s = np.cos(2 * angle), np.sin(2 * angle)
    for first in (jax.jacfwd, jax.jacrev):
        slope, bend = fm.jit(lambda x, first=first: (first(r.polar_angle)(x), jax.jacfwd(first(r.polar_angle))(x)))(
            vector
        )
        np.testing.assert_allclose(slope, [-np.sin(angle) / 2, np.cos(angle) / 2], atol=1e-15)
        np.testing.assert_allclose(bend, np.array([[s, -c], [-c, -s]]) / 4, atol=1e-15)


def test_derivatives_are_finite_at_zero_rotation():
    lam = np.array([1.0, 0, 0, 0])
    for function in (r.rotation_matrix, r.lbar, r.lbody, lambda x: r.relative_turn(x, lam, lam, lam, np.eye(3))):
        both = fm.jit(lambda x, f=function: (jax.jacrev(f)(x), jax.jacfwd(jax.jacfwd(f))(x)))
        assert all(np.all(np.isfinite(found)) for found in both(lam))


# -- initial frame --------------------------------------------------------------------------------------------------


def is_right_handed_frame(frame: np.ndarray, atol: float) -> bool:
    return np.allclose(frame.T @ frame, np.eye(3), atol=atol) and np.linalg.det(frame) > 0


@given(vectors, vectors)
def test_initial_frame_by_default(p, axis):
    hypothesis.assume(np.linalg.norm(axis) > 0.1)
    frame = np.asarray(r.initial_frame(p, p + axis, None))
    assert is_right_handed_frame(frame, 50 * EPS)
    # p + axis - p is axis but for eps of p, 1e-15 of an axis of 0.1.
    unit = axis / np.linalg.norm(axis)
    np.testing.assert_allclose(frame[:, 0], unit, atol=100 * EPS)
    # Local y in the plane of x and the global axis least along x, on that axis's side.
    sizes = np.sort(np.abs(axis))
    hypothesis.assume(sizes[1] - sizes[0] > 1e-3)
    least = np.eye(3)[np.argmin(np.abs(axis))]
    assert frame[:, 1] @ least > 0.8  # the least component is at most 1/sqrt 3, its complement 0.816
    np.testing.assert_allclose(frame[:, 2] @ least, 0, atol=50 * EPS)


@pytest.mark.parametrize(
    ("axis", "y"),
    [((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (1, 0, 0)), ((0, 0, 2), (1, 0, 0)), ((1, 1, 0), (0, 0, 1))],
)
def test_initial_frame_of_ties(axis, y):
    # SPACAR's rule takes the first of two axes that are equally far from x.
    frame = np.asarray(r.initial_frame(np.zeros(3), np.array(axis, float), None))
    np.testing.assert_allclose(frame[:, 1], y, atol=EPS)


@pytest.mark.slow
@given(vectors, vectors, vectors, st.floats(0.01, 100))
def test_initial_frame_by_a_vector(p, axis, y, scale):
    hypothesis.assume(np.linalg.norm(axis) > 0.1)
    hypothesis.assume(np.linalg.norm(np.cross(axis, y)) > 0.1 * np.linalg.norm(axis))
    frame = np.asarray(r.initial_frame(p, p + axis, y))
    # Gram-Schmidt loses what y has along x: a factor 10 here.
    assert is_right_handed_frame(frame, 500 * EPS)
    ez = np.cross(axis, y)
    np.testing.assert_allclose(frame[:, 2], ez / np.linalg.norm(ez), atol=500 * EPS)
    assert frame[:, 1] @ y > 0
    # Only the direction of y counts.
    np.testing.assert_allclose(r.initial_frame(p, p + axis, scale * y), frame, atol=500 * EPS)
