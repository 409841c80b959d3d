"""Large mechanisms by the deformations of their elements: many short beams against closed forms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from linear.test_sparse_poles import rotor
from scipy.optimize import brentq

import flexmb as fm
from flexmb import planar
from flexmb.control.second_order_form import lossy_elements
from flexmb.errors import AnalysisError
from flexmb.math.by_deformations import forces, refined_solution, saddle_product
from flexmb.math.element_matrices import AssembledEquations, transposed

# Of a cantilever, times the square root of EI/(m l^4).
ROOTS = np.array([1.8751040687119611, 4.694091132974174, 7.854757438237613])


def row(beams, tip=None, stiffness=1.0, load=None, press=1e-3):
    """A cantilever of short beams in a row."""
    section = fm.Rigidity(EA=1e6, EIy=stiffness, mass=1.0)
    b = fm.Builder()
    b.node("n0", (0, 0))
    for i in range(beams):
        b.node(f"n{i + 1}", ((i + 1) / beams, 0.0))
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=section)
    b.fix("n0")
    b.input(f"n{beams}", "y")
    b.output(f"n{beams}", "y")
    b.force(f"n{beams}", (-press, 0.0), increment=True)
    if tip is not None:
        b.mass(f"n{beams}", tip)
    if load is not None:
        b.force(f"n{beams}", (0.0, load))
    return b.build(check=False)


@pytest.fixture(scope="module")
def strip():
    """A thousand beams: their stiffness cannot be told from its entries beyond three digits."""
    return row(1000)


@pytest.fixture(scope="module")
def still(strip):
    return fm.linearize(strip, sparse=True, increment=0.0)


def test_many_short_beams_vibrate_as_a_cantilever(still):
    # Discretisation, 1e-11 of the third; assembled matrices alone gave 3e-4, 8e-6 and 1e-6.
    np.testing.assert_allclose(fm.frequencies(still, count=3), ROOTS**2 / (2 * np.pi), rtol=1e-10)


def test_more_poles_whose_last_digits_do_not_settle(still):
    # Iterations end with all that is asked for, but for digits beyond the tolerance of 1e-9.
    found = np.asarray(fm.poles(still, count=12))[1::2]
    roots = np.array([brentq(lambda x: np.cos(x) + 1 / np.cosh(x), np.pi * k, np.pi * (k + 1)) for k in range(6)])
    np.testing.assert_allclose(found, 1j * roots**2, rtol=1e-8)


@pytest.mark.slow
def test_shapes_of_many_short_beams_change_as_those_of_fewer():
    def end(tip, beams):
        return fm.modes(row(beams, tip), count=2, sparse=True).shape(f"n{beams}", "y")

    many, few = (jax.jit(jax.jacfwd(lambda tip, n=n: end(tip, n)))(0.2) for n in (1000, 100))
    # Discretisation of the second mode by a hundred beams is 1e-8; assembled matrices alone gave 3e-6.
    np.testing.assert_allclose(many, few, rtol=1e-7)


def test_many_short_beams_have_the_poles_of_a_cantilever(still):
    found = np.asarray(fm.poles(still, count=6))
    # As the frequencies; assembled matrices alone gave 1e-6.
    np.testing.assert_allclose(found[1:6:2], 1j * ROOTS**2, rtol=1e-10)


def test_many_short_beams_respond_as_a_cantilever(still):
    found = fm.frequency_response(still, [1.0]).response[0, 0, 0]
    k = np.sqrt(2 * np.pi)
    expected = np.cosh(k) * np.sin(k) - np.sinh(k) * np.cos(k)
    expected /= k**3 * (1 + np.cos(k) * np.cosh(k))
    # As the frequencies, 4 % above the first of which this is; assembled matrices alone gave 2e-5.
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_many_short_beams_bend_as_a_cantilever(still):
    found = fm.compliance(still, "n1000")
    # Exact for cubic beams but for round-off: deformations lose the square of their number, 1e-10.
    np.testing.assert_allclose(found[1, 1:], [1 / 3, 1 / 2], rtol=1e-10)


def height(stiffness, beams):
    """Of the tip under a load that bends it far."""
    model = row(beams, stiffness=stiffness, load=0.5)
    return fm.equilibrium(model, sparse=True).position(f"n{beams}")[1]


@pytest.mark.slow
def test_derivatives_of_many_short_beams_under_load_are_alike_forward_and_reverse():
    forward = fm.jit(jax.jacfwd(lambda s: height(s, 1000)))(1.0)
    reverse = fm.jit(jax.grad(lambda s: height(s, 1000)))(1.0)
    # By assembled matrices alone 4e-6.
    np.testing.assert_allclose(reverse, forward, rtol=1e-10)


@pytest.mark.slow
def test_derivatives_of_many_short_beams_under_load():
    """What a bending stiffness makes of a large deflection, of which 100 and 200 beams tell the error of more."""
    few, more, many = (fm.jit(jax.jacfwd(lambda s, n=n: height(s, n)))(1.0) for n in (100, 200, 1000))
    exact = more + (more - few) / 3
    # The next term of the error is 1e-10; by assembled matrices alone 4e-6.
    np.testing.assert_allclose(many, exact + (more - exact) / 25, rtol=1e-9)


def test_forces_that_constraints_bear_alone_move_nothing():
    """A push along a leaf spring that cannot be shortened, and one across it: the first leaves round-off alone."""
    stiffness, axis = np.diag([0.0, 3.0]), np.array([np.cos(0.3), np.sin(0.3)])
    turned = np.array([[axis[0], -axis[1]], [axis[1], axis[0]]])
    a = np.block([[turned @ stiffness @ turned.T, axis[:, None]], [axis[None, :], np.zeros((1, 1))]])
    right = np.concatenate([np.stack([axis, turned[:, 1]], axis=1), np.zeros((1, 2))])
    noise = np.random.default_rng(0)

    def product(z: np.ndarray):
        # Round-off as where the forces of many elements are added up.
        found = a @ z
        return found + 1e-16 * noise.standard_normal(found.shape) * np.max(np.abs(z))

    found = refined_solution(product, lambda left: np.linalg.solve(a, left), right, np.ones(2))
    np.testing.assert_allclose(found, [[0, -axis[1] / 3], [0, axis[0] / 3], [1, 0]], atol=1e-14)


@pytest.mark.slow
def test_many_short_beams_bifurcate_along_a_path_as_fewer():
    """Pressed columns bend aside at the same load, however finely they are divided."""
    few, many = (
        fm.path(row(beams, press=40.0), sparse=True, step=0.02, stop={"load_factor": 0.07}).critical_points[0]
        for beams in (100, 1000)
    )
    assert few.kind == many.kind == "bifurcation"
    # Discretisation of 100 beams is 5e-9; entries of the stiffness alone gave 3e-6.
    assert many.load_factor == approx(few.load_factor, rel=5e-8)


def test_many_short_beams_buckle_as_a_column(strip):
    found = fm.buckling_loads(strip, count=3, sparse=True)
    # Euler's loads of a column clamped at one end, of n/2 + 1/4 waves; assembled matrices alone gave 8e-6.
    np.testing.assert_allclose(found, 1e3 * (np.pi * (np.arange(3) + 0.5)) ** 2, rtol=1e-9)


@pytest.mark.slow
def test_forces_are_those_of_the_assembled_matrices():
    """Under forces that follow, with laws and held deformations; transposed too, and at a frequency."""
    lin = fm.linearize(rotor(), sparse=True)
    lossy = lossy_elements(lin, jnp.linspace(0.1, 0.3, lin.e.shape[0]))
    with_loss = lin.elements._replace(loss=lossy.stiffness, lossy=lossy.elastic)
    for s, given in ((None, lin.elements), (3j, with_loss)):
        elements, turned = (jax.tree.map(np.asarray, own) for own in (given, transposed(given)))
        whole = (
            AssembledEquations(elements).at() if s is None else AssembledEquations(elements).at_frequency(s)
        ).toarray()
        z = np.random.default_rng(3).standard_normal((len(whole), 2)).astype(whole.dtype)
        # Round-off beside the largest entry.
        close = {"rtol": 0, "atol": 1e-14 * np.max(np.abs(whole))}
        np.testing.assert_allclose(forces(elements, z, s=s), whole @ z, **close)
        np.testing.assert_allclose(saddle_product(given, z, None, s), whole @ z, **close)
        np.testing.assert_allclose(forces(elements, z, transposed=True, s=s), whole.T @ z, **close)
        np.testing.assert_allclose(forces(turned, z, s=s), whole.T @ z, **close)


@pytest.mark.slow
def test_factors_of_another_matrix_are_of_no_help():
    a = np.array([[2.0, 1.0], [1.0, 3.0]])
    near, far = np.linalg.inv(a + 0.1), -np.linalg.inv(a)
    right = np.array([[1.0], [2.0]])
    found = refined_solution(lambda z: a @ z, lambda left: near @ left, right, np.ones(2))
    np.testing.assert_allclose(a @ found, right, rtol=1e-12)
    with pytest.raises(AnalysisError, match="round-off"):
        refined_solution(lambda z: a @ z, lambda left: far @ left, right, np.ones(2))
