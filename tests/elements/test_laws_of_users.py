"""Elements with an energy, a dissipation or a law of their own: statics, linearisation and motion of one mass."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb import planar
from flexmb.mechanics.loads import lacks_potential
from flexmb.mechanics.stress_resultants import is_nonlinear

K, K3, C, MASS, FORCE = 100.0, 3e4, 0.5, 2.0, 5.0


def elongation(p: fm.Point2, q: fm.Point2, *, ref):
    return planar.truss.deformation(p, q, ref=ref)


def hardening_energy(e, *, ref, k, k3):
    return k * e[0] ** 2 / 2 + k3 * e[0] ** 4 / 4


def hardening_law(e, ed, *, ref, k, k3):
    return k * e + k3 * e**3


def quadratic_dissipation(e, ed, *, ref, c):
    """Grows with the elongation too, so that its derivatives by e matter."""
    return c * (1 + e[0]) * ed[0] ** 2 / 2


SPRINGS = {
    "energy": fm.Element(elongation, energy=hardening_energy, dissipation=quadratic_dissipation),
    "law": fm.Element(elongation, law=hardening_law, dissipation=quadratic_dissipation),
}


def mass_on(element, **properties):
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("mass", (1, 0))
    b.add(element, "wall", "mass", name="spring", **properties)
    b.fix("wall")
    b.fix("mass", "y")
    b.mass("mass", MASS)
    b.dof("mass", "x")
    return b


def hardening(element):
    b = mass_on(element, k=K, k3=K3, c=C)
    b.force("mass", (FORCE, 0))
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("element", SPRINGS.values(), ids=SPRINGS)
def test_equilibrium_stiffness_and_damping_of_a_hardening_spring(element):
    model = hardening(element)
    # The one real root of k3 e^3 + k e = F.
    e = next(root.real for root in np.roots([K3, 0, K, -FORCE]) if abs(root.imag) < 1e-9)
    lin = fm.linearize(model)
    np.testing.assert_allclose(lin.e[0], e, rtol=1e-12)
    np.testing.assert_allclose(lin.sigma[0], FORCE, rtol=1e-12)
    np.testing.assert_allclose(lin.K, [[K + 3 * K3 * e**2]], rtol=1e-12)
    np.testing.assert_allclose(lin.D0, [[C * (1 + e)]], rtol=1e-12)
    np.testing.assert_allclose(lin.reactions[0], -FORCE, rtol=1e-12)
    assert lin.symmetric
    frequency = np.sqrt((K + 3 * K3 * e**2) / MASS) / (2 * np.pi)
    np.testing.assert_allclose(fm.frequencies(model), [frequency], rtol=1e-12)


@pytest.mark.slow
def test_derivatives_of_the_equilibrium_by_properties():
    model = hardening(SPRINGS["energy"])

    def place(parameters):
        return fm.equilibrium(fm.Model(model.topology, parameters, model.labels)).at("mass")[0]

    found = fm.jit(jax.grad(place))(model.parameters).properties[0]
    e = float(fm.equilibrium(model).e[0])
    # k e + k3 e^3 = F by implicit differentiation.
    tangent = K + 3 * K3 * e**2
    np.testing.assert_allclose(found["k"], [-e / tangent], rtol=1e-10)
    np.testing.assert_allclose(found["k3"], [-(e**3) / tangent], rtol=1e-10)


@pytest.mark.slow
def test_strain_and_prestress_add_to_an_energy():
    b = mass_on(SPRINGS["energy"], k=K, k3=K3, c=C)
    b.strain("spring", 0.02)
    b.prestress("spring", 3.0)
    found = fm.equilibrium(b.build())
    stretched = found.e[0] - 0.02
    assert found.sigma[0] == approx(0, abs=1e-10)
    np.testing.assert_allclose(K * stretched + K3 * stretched**3, -3.0, rtol=1e-10)


def follower_like(e, ed, *, ref, stiffness, coupling):
    """Two springs, the second pulled by the first without return: no potential."""
    return stiffness * e + coupling * jnp.stack([jnp.zeros(()), e[0]])


def displacement(p: fm.Point2, q: fm.Point2, *, ref):
    return (q - p) - (ref.q - ref.p)


@pytest.mark.slow
def test_a_law_without_potential_makes_the_stiffness_unsymmetric():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("mass", (1, 0))
    b.add(fm.Element(displacement, law=follower_like), "wall", "mass", stiffness=K, coupling=30.0)
    b.fix("wall")
    b.mass("mass", MASS)
    b.dof("mass", "x", "y")
    model = b.build()
    lin = fm.linearize(model)
    np.testing.assert_allclose(lin.K0, [[K, 0], [30.0, K]], rtol=1e-14)
    assert not lin.symmetric
    with pytest.raises(NotImplementedError, match="without a potential"):
        fm.frequencies(model)
    # A double eigenvalue of a matrix that has one eigenvector only, known to the root of the round-off.
    np.testing.assert_allclose(np.abs(fm.poles(lin)), np.sqrt(K / MASS), rtol=1e-6)


@pytest.mark.slow
def test_a_law_that_pulls_at_rest_moves_the_mechanism():
    def pretension(e, ed, *, ref, force, stiffness):
        return stiffness * e - force

    model = mass_on(fm.Element(elongation, law=pretension), stiffness=K, force=FORCE).build()
    np.testing.assert_allclose(fm.equilibrium(model).e[0], FORCE / K, rtol=1e-12)
    # So does the path, which begins there.
    np.testing.assert_allclose(fm.path(model).e[:, 0], FORCE / K, rtol=1e-12)


def test_what_is_linear_is_told_apart_before_anything_is_traced():
    model = mass_on(planar.truss, section=fm.Rigidity(EA=K)).build()
    assert not is_nonlinear(model.topology)
    assert not lacks_potential(model.topology)


def test_a_law_must_get_its_properties():
    with pytest.raises(fm.ModelError, match="needs the property 'k3'"):
        mass_on(SPRINGS["law"], k=K)
    # Damping may be left out.
    mass_on(SPRINGS["law"], k=K, k3=K3)


# -- motion -------------------------------------------------------------------------------------------------------

MU, DRAG = 3.0, 20.0


def cubic_dissipation(e, ed, *, ref, drag):
    return drag * jnp.abs(ed[0]) ** 3 / 3


def friction(e, ed, *, mu):
    """Friction that grows with the distance."""
    return mu * (1 + e) * jnp.tanh(ed / 0.05)


@pytest.mark.slow
def test_motion_of_a_mass_against_its_own_equation():
    """A hardening spring, a quadratic damper and friction, each stated in its own way."""
    b = mass_on(fm.Element(elongation, energy=hardening_energy, dissipation=cubic_dissipation), k=K, k3=K3, drag=DRAG)
    b.add(planar.spring_damper(friction), "wall", "mass", name="friction", mu=MU)
    b.start("mass", "x", 0.1)
    times = np.linspace(0, 1.5, 16)
    found = fm.simulate(b.build(), times, rtol=1e-6)

    def elastic(e):
        return K * e + K3 * e**3

    def lost(e, v):
        return DRAG * np.abs(v) * v + MU * (1 + e) * np.tanh(v / 0.05)

    def rates(t, z):
        return [z[1], -(elastic(z[0]) + lost(*z)) / MASS]

    alone = solve_ivp(rates, (0, 1.5), [0.1, 0], t_eval=times, method="DOP853", rtol=1e-10, atol=1e-12).y
    # Ten times rtol, of the motion and of the largest velocity.
    np.testing.assert_allclose(found.at("mass")[:, 0] - 1, alone[0], rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.velocity("mass")[:, 0], alone[1], rtol=0, atol=1e-5)
    seen = found.observe()
    e, ed = np.asarray(seen.e[:, 0]), np.asarray(seen.ed[:, 0])
    # What has an energy is stored, the rest is power: its rate.
    np.testing.assert_allclose(seen.elastic, K * e**2 / 2 + K3 * e**4 / 4, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(seen.power, -lost(e, ed) * ed, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(seen.sigma.sum(axis=1), elastic(e) + lost(e, ed), rtol=1e-11, atol=1e-12)
    lin = fm.motion.linearize_motion(found)
    stiffness = K + 3 * K3 * e**2 + MU * np.tanh(ed / 0.05)
    np.testing.assert_allclose(lin.K0[:, 0, 0], stiffness, rtol=1e-10)
    damping = 2 * DRAG * np.abs(ed) + MU * (1 + e) / 0.05 / np.cosh(ed / 0.05) ** 2
    np.testing.assert_allclose(lin.D0[:, 0, 0], damping, rtol=1e-8, atol=1e-12)
