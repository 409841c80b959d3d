"""Derivatives of every answer by the dimensions of the guide, against closed forms and central differences."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.model.topology import Parameters

T = mechanisms.THICKNESS


def closed_form(t):
    """E1: f(t) = sqrt(2 E w t^3/l^3/(m + (26/35) rho w t l))/2 pi [Hz]."""
    stiffness = 2 * 210e9 * 0.018 * t**3 / 0.1**3
    return jnp.sqrt(stiffness / (0.206 + 26 / 35 * 7850 * 0.018 * t * 0.1)) / (2 * jnp.pi)


def frequency(t):
    return fm.frequencies(mechanisms.planar_guide(t).build())[0]


@pytest.mark.slow
def test_frequency_and_its_derivative_are_the_closed_form():
    # E1: tolerance 1e-9 for the value, 1e-8 for the derivative; 31670.0798802 Hz/m is printed there.
    assert frequency(T) == approx(10.64484738, abs=5e-9)
    # Forward and reverse: the second takes the first through the other.
    slope, twice = fm.jit(lambda t: jax.jvp(jax.grad(frequency), (t,), (1.0,)))(T)
    assert slope == approx(31670.0798802, rel=1e-8)
    assert twice == approx(float(jax.grad(jax.grad(closed_form))(T)), rel=1e-7)


@pytest.mark.slow
def test_frequency_about_a_linearisation_is_the_closed_form():
    """Under 20 N of the 78.75 N (t/T)^3 at which the guide buckles, that share of its stiffness is lost."""

    def loaded(t):
        model = mechanisms.planar_guide(t, force=(0, -1.0)).build()
        return fm.frequencies(fm.linearize(model, load_factor=20.0))[0]

    def expected(t):
        return closed_form(t) * jnp.sqrt(1 - 20 / 78.75 * (T / t) ** 3)

    value, slope = fm.jit(jax.value_and_grad(loaded))(T)
    assert value == approx(float(expected(T)), rel=1e-9)
    assert slope == approx(float(jax.grad(expected)(T)), rel=1e-8)


ANSWERS = ("frequency", "buckling load", "entry of A", "drive compliance", "deflection")


def answers(t, force):
    """Of the guide under a force."""
    model = mechanisms.planar_guide(t, force=force, ratio=0.005).build()
    lin = fm.linearize(model)
    return jnp.stack(
        [
            fm.frequencies(lin)[0],
            fm.buckling_loads(model)[0],
            fm.control.state_matrices(lin)[0].A[1, 0],
            fm.compliance(lin, "left1")[0, 0],
            lin.x[model.labels.known("left1")[1]],
        ]
    )


@pytest.mark.slow
def test_derivatives_by_thickness_and_the_cube_of_it_in_a_buckling_load():
    step, force = 1e-5 * T, np.array([0.5, -20.0])
    value, forward, reverse = fm.jit(answers), fm.jit(jax.jacfwd(answers)), fm.jit(jax.jacrev(answers))
    difference = (value(T + step, force) - value(T - step, force)) / (2 * step)
    found = forward(T, force)
    for i, name in enumerate(ANSWERS):
        # Truncation of the difference is (1e-5)^2, its round-off about 1e-16/1e-5 times the conditioning of the answer.
        assert found[i] == approx(float(difference[i]), rel=1e-6), name
        assert reverse(T, force)[i] == approx(float(found[i]), rel=1e-10), name
    # d ln P/d ln t = 3 for EI ~ t^3 with fixed elongations, exactly, in the limit of small load.
    light = np.array([0.0, -1e-3])
    assert T * reverse(T, light)[1] / value(T, light)[1] == approx(3, rel=1e-8)


@pytest.mark.slow
def test_vmap_over_thicknesses_is_a_loop():
    thicknesses = np.linspace(0.3e-3, 0.8e-3, 5)
    together = fm.jit(jax.vmap(frequency))(thicknesses)
    np.testing.assert_allclose(together, [frequency(t) for t in thicknesses], rtol=1e-11)
    np.testing.assert_allclose(together, closed_form(thicknesses), rtol=1e-9)


@pytest.fixture(scope="module")
def spatial():
    return mechanisms.spatial_guide(beams=2, released="all", dofs=False, rotary=True).build()


@pytest.mark.slow
def test_derivatives_of_the_spatial_guide(spatial):
    def lowest(parameters):
        return fm.frequencies(fm.Model(spatial.topology, parameters, spatial.labels))[:4]

    def along(direction, h):
        moved = jax.tree.map(lambda a, d: a + h * d, spatial.parameters, direction)
        return lowest(moved)

    rng = np.random.default_rng(1)
    # Every number moves by its own random share of itself.
    direction = jax.tree.map(lambda a: a * rng.uniform(-1, 1, a.shape), spatial.parameters)
    # A moved Euler parameter of the reference would no longer be of unit norm.
    turned = np.array([entry.kind == "rotation" for entry in spatial.labels.x])
    reference = jnp.where(turned, 0.0, direction.reference)
    direction = Parameters(reference, direction.properties, direction.loads, direction.increment, direction.strain)
    _, forward = fm.jit(lambda p, d: jax.jvp(lowest, (p,), (d,)))(spatial.parameters, direction)
    h = 6e-6  # cube root of round-off
    difference = (along(direction, h) - along(direction, -h)) / (2 * h)
    np.testing.assert_allclose(forward, difference, rtol=1e-6, atol=1e-6 * float(jnp.max(jnp.abs(forward))))
    reverse = fm.jit(jax.jacrev(lowest))(spatial.parameters)
    products = jax.tree.map(lambda j, d: jnp.tensordot(j, d, d.ndim), reverse, direction)
    np.testing.assert_allclose(sum(jax.tree.leaves(products)), forward, rtol=1e-9)


@pytest.mark.slow
def test_equal_modes_have_finite_derivatives():
    """Two equal guides side by side: every frequency comes twice."""

    def both(t):
        b = fm.Builder()
        for name in ("one", "two"):
            b.node(f"{name} foot", (0, 0))
            b.node(f"{name} top", (0, 0.1))
            b.add(
                fm.planar.beam,
                f"{name} foot",
                f"{name} top",
                name=name,
                section=mechanisms.leaf(t[0 if name == "one" else 1]),
                released=(2, 3),
            )
            b.fix(f"{name} foot")
            b.mass(f"{name} top", 0.1)
            b.dof(name, 2, 3)
        return fm.frequencies(b.build())[:2]

    at = jnp.array([T, T])
    jacobian = fm.jit(jax.jacrev(both))(at)
    assert np.all(np.isfinite(jacobian))
    np.testing.assert_allclose(jacobian, fm.jit(jax.jacfwd(both))(at), rtol=1e-9)
    # The sum over the pair is smooth, and each guide contributes its own derivative.
    one = fm.jit(jax.grad(lambda t: both(jnp.array([t, 2 * T]))[0]))(T)
    np.testing.assert_allclose(jnp.sum(jacobian, axis=0), [one, one], rtol=1e-8)


@pytest.mark.slow
def test_condition_of_the_derivatives_of_an_equilibrium():
    """Springs of 1 and 10^6 N/m each on its own are no trouble; the stiff one behind the soft one is."""

    def chain(first, second, joined):
        b = fm.Builder()
        for i in range(3):
            b.node(f"n{i}", (float(i), 0.0))
            b.fix(f"n{i}", *("xy" if i == 0 else "y"))
        b.add(planar.truss, "n0", "n1", section=fm.Rigidity(EA=first))
        b.add(planar.truss, "n1" if joined else "n0", "n2", section=fm.Rigidity(EA=second * (1 if joined else 2)))
        b.dof("n1", "x")
        b.dof("n2", "x")
        return fm.linearize(b.build()).condition

    assert chain(1.0, 1e6, joined=False) == approx(1.0)
    # K = (k1 + k2, -k2; -k2, k2), off the diagonal -1/sqrt(1 + k1/k2) once scaled: eigenvalues 1 +- that.
    s = 1 / np.sqrt(1 + 1e-6)
    assert chain(1.0, 1e6, joined=True) == approx((1 + s) / (1 - s), rel=1e-6)
