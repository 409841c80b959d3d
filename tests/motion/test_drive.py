"""What depends on time: incremental loads, stresses, prescribed motion; against SciPy's integration of the equation."""

import jax.numpy as jnp
import numpy as np
import pytest
from cases.motions import sprung_mass, turned
from cases.tolerances import approx
from jax.tree_util import Partial
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb import planar


@pytest.mark.slow
def test_increment_stress_and_prescribed_motion_at_once():
    """m x'' = -k (x - a) - S + i F, with the foot at a(t), a stress S(t) and the factor i(t) of the force F.

    A constant force and a constant prestress are there all the time.
    """
    k, m, force = 90.0, 0.4, 8.0
    b = sprung_mass(stiffness=k, mass=m, foot="prescribed")
    b.force("mass", (3.0, 0))
    b.force("mass", (force, 0), increment=True)
    b.prestress("s", 0.7)
    b.mass("foot", 0.5)
    times = np.linspace(0, 0.6, 5)
    found = fm.simulate(
        b.build(),
        times,
        motion={"foot.x": lambda t: 0.02 * jnp.sin(7 * t)},
        loads={"s.e1": lambda t: 5 * t},
        increment=lambda t: jnp.cos(9 * t),
        rtol=1e-9,
    )

    def rate(t, z):
        pulled = k * (z[0] - 0.02 * np.sin(7 * t)) + 5 * t + 0.7
        return [z[1], (3.0 + force * np.cos(9 * t) - pulled) / m]

    exact = solve_ivp(rate, (0, 0.6), [0.0, 0.0], t_eval=times, rtol=1e-12, atol=1e-13)
    # Ten times the tolerance of a step, over some tens of steps.
    np.testing.assert_allclose(found.at("mass")[:, 0] - 0.4, exact.y[0], atol=1e-7)
    np.testing.assert_allclose(found.at("foot")[:, 0], 0.02 * np.sin(7 * times), atol=1e-14)
    np.testing.assert_allclose(found.velocity("foot", "x"), 0.14 * np.cos(7 * times), atol=1e-13)
    # What drives the foot gives its own m a and pulls the spring; on the mass the loads act. Errors of x times k.
    driven, pulled = 0.02 * np.sin(7 * times), found.stress_resultant("s", 1)
    np.testing.assert_allclose(pulled, k * (exact.y[0] - driven) + 5 * times + 0.7, atol=1e-5)
    np.testing.assert_allclose(found.acceleration("foot", "x"), -49 * driven, atol=1e-12)
    np.testing.assert_allclose(found.force_needed("foot", "x"), 0.5 * -49 * driven - pulled, atol=1e-12)
    np.testing.assert_allclose(found.reaction("foot", "x"), found.force_needed("foot", "x"), atol=1e-12)
    np.testing.assert_allclose(found.force_needed("mass", "x"), 3.0 + force * np.cos(9 * times), atol=1e-12)


@pytest.mark.slow
def test_incremental_loads_that_a_motion_replaces_are_not_left_out():
    """The foot is prescribed once as an increment; its motion replaces that, but no force."""
    model = sprung_mass(foot="prescribed")
    model.prescribe("foot", "x", 0.02, increment=True)
    motion = {"foot.x": lambda t: 0.02 * jnp.sin(7 * t)}
    fm.simulate(model.build(), [0.0, 0.01], motion=motion)
    model.force("mass", (8.0, 0), increment=True)
    with pytest.warns(fm.FlexmbWarning, match=r"fm\.simulate leaves out the incremental loads"):
        fm.simulate(model.build(), [0.0, 0.01], motion=motion)


def hanging_rod() -> fm.Builder:
    """A rod with a mass at its end, across a crank whose angle is prescribed."""
    b = fm.Builder()
    for name, place in {"ground": (0, 0), "pin": (1, 0), "mass": (1, 1)}.items():
        b.node(name, place)
    b.rotation("crank")
    b.rotation("rod")
    b.add(planar.rigid_beam, "ground", "crank", "pin", name="arm")
    b.add(planar.rigid_beam, "pin", "rod", "mass", name="bar")
    b.fix("ground", "position")
    b.mass("mass", 2.0)
    b.prescribe("crank", "phi", 0.0)
    b.dof("mass", "x")
    return b


@pytest.mark.slow
def test_a_mechanism_that_is_driven_from_its_start_moves_along_at_once():
    """A rod that hangs from a crank of constant speed; the pin takes the mass along the rod from the first moment."""
    speed = 2.0
    b = hanging_rod()
    times = np.array([0.0, 0.25, 0.5, 1.0])
    found = fm.simulate(b.build(), times, motion={"crank.phi": Partial(turned, speed=speed)}, rtol=1e-9)

    def rate(t, z):
        # theta'' = -(a x n).. of the rod (cos, sin) at the pin, whose acceleration is -speed^2 (cos, sin)(speed t).
        angle, spin = z
        pin = -(speed**2) * np.array([np.cos(speed * t), np.sin(speed * t)])
        return [spin, -(pin @ [-np.sin(angle), np.cos(angle)])]

    exact = solve_ivp(rate, (0, 1), [np.pi / 2, 0.0], t_eval=times, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(found.at("rod")[:, 0] + np.pi / 2, exact.y[0], atol=1e-6)
    np.testing.assert_allclose(found.velocity("mass")[0], [0, speed], atol=1e-12)


@pytest.mark.slow
def test_a_controller_sees_from_the_start_what_is_driven():
    """The first sample is that of the mass as the crank takes it along."""
    b = hanging_rod()
    b.input("mass", "y")
    b.output("mass", "y", "velocity")
    held = fm.motion.Sampled(lambda t, z, y: (0.5 * y, z), 0.01)
    drive = {"crank.phi": Partial(turned, speed=2.0)}
    found = fm.simulate(b.build(), [0.0, 0.01], motion=drive, control=held, rtol=1e-6)
    assert found.u[0, 0] == approx(0.5 * 2.0, rel=1e-9)


def arm():
    """A cantilever with a body on its tip, of which nothing stretches."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (1.0, 0))
    b.add(planar.beam, "foot", "tip", name="leaf", section=fm.Rigidity(EA=1.0, EIy=2.0), released=(2, 3))
    b.fix("foot")
    b.body("tip", 1.0, inertia=0.5)
    return b.build()


@pytest.mark.parametrize("name", ["foot.x", "foot", "foot.phi", "foot.rotation", "leaf.e1"])
def test_a_load_on_what_is_fixed_is_refused(name):
    size = 2 if name == "foot" else 1
    with pytest.raises(
        fm.ModelError, match=f"Load '{name}' acts on a FIXED coordinate or deformation and has no effect"
    ):
        fm.simulate(arm(), [0, 0.1], loads={name: lambda t: jnp.ones(size)})


@pytest.mark.slow
def test_a_load_on_a_node_that_is_held_in_part_acts_on_the_rest():
    b = sprung_mass(stiffness=90.0, mass=0.4)
    times = np.linspace(0, 0.3, 4)
    # Along y the mass is FIXED.
    found = fm.simulate(b.build(), times, loads={"mass": lambda t: jnp.array([3.0, 5.0])}, rtol=1e-8)
    expected = 3.0 / 90.0 * (1 - np.cos(np.sqrt(90.0 / 0.4) * times))
    # Ten times the tolerance.
    np.testing.assert_allclose(found.at("mass")[:, 0] - found.at("mass")[0, 0], expected, atol=1e-7)


@pytest.mark.slow
def test_a_rotation_in_the_plane_is_loaded_and_driven_by_the_name_that_inputs_take():
    model, times = arm(), np.linspace(0, 0.2, 3)
    names = "tip.phi", "tip.rotation", "tip.rotation.phi"
    found = [fm.simulate(model, times, loads={name: lambda t: 0.01 * t}).x for name in names]
    assert np.any(found[0] != found[0][0])
    np.testing.assert_array_equal(found[1], found[0])
    np.testing.assert_array_equal(found[2], found[0])
    with pytest.raises(fm.ModelError, match=r"'tip.psi' names no coordinate.* There are: foot.x, .*, tip.phi, leaf.e1"):
        fm.simulate(model, times, loads={"tip.psi": lambda t: t})
    b = sprung_mass(stiffness=90.0, mass=0.4)
    b.node("hub", (0, 1))
    b.fix("hub", "position")
    b.inertia("hub", 0.5)
    b.rotation("ground")
    b.fix("ground")
    b.add(planar.hinge, "ground", "hub", name="spring", stiffness=3.0)
    b.prescribe("hub", "phi")
    found = fm.simulate(b.build(), times, motion={"hub.phi": lambda t: 2.0 * t**2})
    np.testing.assert_allclose(found.rotation("hub"), 2.0 * times**2, atol=1e-14)
    # Round-off of the moment, by hand: inertia and spring.
    np.testing.assert_allclose(found.reaction("hub", "phi"), 0.5 * 4.0 + 3.0 * 2.0 * times**2, rtol=1e-12)


def test_a_name_that_is_wrong_is_answered_by_the_nearest_of_many():
    b = fm.Builder()
    for i in range(40):
        b.node(f"n{i}", (float(i), 0))
        if i:
            b.add(planar.beam, f"n{i - 1}", f"n{i}", name=f"leaf {i}", section=fm.Rigidity(EA=1.0, EIy=2.0, mass=1.0))
    b.fix("n0")
    with pytest.raises(fm.ModelError, match=r"There are: n37\.x, .* and \d+ more"):
        fm.simulate(b.build(), [0, 0.1], loads={"n37.ax": lambda t: t})
