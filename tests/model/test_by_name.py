"""Results asked by name: statics by hand, closed forms of a cantilever and of a shaft; of motion see test_drive."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial

LENGTH, EI, GIT = 0.3, 2.0, 1.5


def cantilever(*, load=None, stroke=None):
    """A beam along x under its own weight and that of a mass on its tip."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (LENGTH, 0))
    b.add(planar.spectral_beam(order=3), "foot", "tip", name="leaf", section=fm.Rigidity(EA=1e6, EIy=EI, mass=0.1))
    b.fix("foot")
    b.mass("tip", 0.5)
    if load is not None:
        b.gravity((0, -9.81))
        b.force("tip", load)
    if stroke is not None:
        b.prescribe("tip", "y", stroke)
        b.dof("leaf", 4, 5, 6, 8, 9)
    return b.build()


def shaft(torque):
    """A bar along x twisted by a moment about it."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (LENGTH, 0, 0))
    section = fm.Rigidity(EA=1e6, EIy=EI, EIz=EI, GIt=GIT, mass=0.1)
    b.add(spatial.beam, "foot", "tip", name="shaft", section=section, released=(2,))
    b.fix("foot")
    if torque is not None:
        b.moment("tip", jnp.array([1.0, 0.0, 0.0]) * torque)
    b.mass("tip", 1.0, inertia=1e-3 * np.eye(3))
    b.dof("shaft", 2)
    return b.build()


def rod():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("end", (1, 0))
    b.add(planar.truss, "wall", "end", section=fm.Rigidity(EA=1.0))
    b.fix("wall")
    b.fix("end", "y")
    return b.build()


@pytest.fixture(scope="module")
def loaded():
    return fm.linearize(cantilever(load=(1.0, 3.0)))


def test_reactions_of_a_cantilever_are_load_and_weight_and_their_moments(loaded):
    x, y = loaded.position("tip")
    assert abs(float(y)) > 1e-3
    # Balance of the whole, its own weight in its middle to the order of its deflection; round-off of EA.
    weight, own = 0.5 * 9.81, 0.1 * LENGTH * 9.81
    np.testing.assert_allclose(loaded.reaction("foot", "x"), -1.0, atol=1e-9)
    np.testing.assert_allclose(loaded.reaction("foot", "y"), weight + own - 3.0, atol=1e-9)
    about_foot = x * (3.0 - weight) - y * 1.0
    assert float(loaded.reaction("foot", "phi") + about_foot) == approx(own * LENGTH / 2, rel=2e-3)
    np.testing.assert_array_equal(loaded.reaction("foot"), [loaded.reaction("foot", c) for c in ("x", "y", "phi")])
    np.testing.assert_array_equal(loaded.reaction("foot.rotation")[0], loaded.reaction("foot", "phi"))
    # What is needed from outside is the load itself: neither weight nor, at the foot, more than the support.
    np.testing.assert_allclose(loaded.force_needed("tip"), [1.0, 3.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(loaded.force_needed("foot"), loaded.reaction("foot"), rtol=1e-12)


@pytest.mark.slow
def test_states_and_modes_answer_alike(loaded):
    at = fm.equilibrium(loaded.model)
    modes = fm.modes(loaded)
    for found in (at, modes):
        for ask in (
            lambda r: r.position("tip", "y"),
            lambda r: r.rotation("tip"),
            lambda r: r.reaction("foot"),
            lambda r: r.deformation("leaf", 2),
            lambda r: r.stress_resultant("leaf"),
            lambda r: r.force_needed("tip", "x"),
        ):
            np.testing.assert_allclose(ask(found), ask(loaded), rtol=1e-9, atol=1e-12)
    sparse = fm.equilibrium(loaded.model, sparse=True)
    np.testing.assert_allclose(sparse.force_needed("tip"), [1.0, 3.0, 0.0], atol=1e-9)
    path = fm.path(loaded.model, step=0.5)
    assert path.rotation("tip").shape == path.force_needed("tip", "y").shape == path.load_factor.shape
    np.testing.assert_allclose(path.force_needed("tip", "y"), 3.0 * path.load_factor, atol=1e-9)
    np.testing.assert_allclose(path.rotation("tip")[-1], loaded.rotation("tip"), rtol=1e-9)
    assert modes.shape("tip").shape == (len(modes.frequencies), 3)
    assert "reactions" in dir(loaded)
    assert "supports" in (type(loaded).reactions.__doc__ or "")


@pytest.mark.slow
def test_force_at_a_prescribed_tip_is_that_of_its_stiffness():
    stroke = 1e-3 * LENGTH
    # 3 EI / L^3 of small strokes; the next term is of the order of (stroke / L)^2, 1e-6.
    assert float(fm.equilibrium(cantilever(stroke=stroke)).force_needed("tip", "y")) == approx(
        3 * EI / LENGTH**3 * stroke, rel=2e-6
    )

    drive = fm.jit(lambda stroke: fm.equilibrium(cantilever(stroke=stroke)).force_needed("tip", "y"))
    assert float(jax.grad(drive)(0.0)) == approx(3 * EI / LENGTH**3, rel=1e-8)


def test_a_shaft_is_turned_by_its_torque():
    model = shaft(1e-3)
    at = fm.equilibrium(model)
    # T L / GIt about the axis alone; a cubic beam is linear but for the square of its twist, 4e-8.
    np.testing.assert_allclose(at.rotation("tip"), [1e-3 * LENGTH / GIT, 0, 0], rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(at.reaction("foot"), [0, 0, 0, -1e-3, 0, 0], atol=1e-10)
    np.testing.assert_allclose(at.force_needed("tip.rotation"), [1e-3, 0, 0], atol=1e-10)
    assert float(at.force_needed("tip", "rx")) == approx(1e-3, rel=1e-9)


@pytest.mark.slow
def test_the_derivative_of_a_turn_is_finite_at_rest_and_a_mode_turns():
    turned = fm.jit(lambda torque: fm.equilibrium(shaft(torque)).rotation("tip", "rx"))
    assert float(jax.grad(turned)(0.0)) == approx(LENGTH / GIT, rel=1e-9)
    assert float(jax.jacfwd(turned)(0.0)) == approx(LENGTH / GIT, rel=1e-9)
    # A torsional mode turns its end by 1/sqrt(J), J of the body and a third of that of the bar, which has none here.
    shape = fm.modes(shaft(None)).shape("tip", "rx")
    assert np.max(np.abs(shape)) == approx(1 / np.sqrt(1e-3), rel=1e-6)


@pytest.mark.slow
def test_a_body_on_a_hinge_turns_at_its_rate():
    b = fm.Builder()
    b.node("here", (0, 0, 0))
    b.fix("here")
    b.rotation("base")
    b.rotation("arm")
    b.add(spatial.hinge, "base", "arm", name="hinge", axis=(0, 0, 1), released=(1,))
    b.fix("base")
    b.inertia("arm", np.eye(3))
    b.dof("hinge", 1)
    at = fm.configuration(b.build(), np.array([0.7]), np.array([2.0]))
    np.testing.assert_allclose(at.rotation("arm"), [0, 0, 0.7], atol=1e-12)
    np.testing.assert_allclose(at.angular_velocity("arm"), [0, 0, 2.0], atol=1e-12)


@pytest.mark.slow(
    "<lambda>-AttributeError-has no velocities: a configuration and a motion",
    "<lambda>-AttributeError-Configuration has no reactions",
    "<lambda>-KeyError-no rotation",
)
@pytest.mark.parametrize(
    ("ask", "kind", "words"),
    [
        (lambda r: r.position("tpi"), KeyError, "no node 'tpi' in this model; did you mean 'tip'"),
        (lambda r: r.position("stage"), KeyError, "it has foot, tip"),
        (lambda r: r.position("tip.rotation"), KeyError, "ask rotation"),
        (lambda r: r.reaction("tip", "z"), KeyError, "it has x, y, phi"),
        (lambda r: r.deformation("leef", 1), KeyError, "did you mean 'leaf'"),
        (lambda r: r.stress_resultant("leaf", 12), KeyError, "deformations 1 to 9, not 12"),
        (lambda r: r.velocity("tip"), AttributeError, "has no velocities: a configuration and a motion"),
        (lambda r: fm.configuration(r.model).reaction("tip"), AttributeError, "Configuration has no reactions"),
        (lambda r: fm.configuration(rod()).rotation("end"), KeyError, "no rotation"),
    ],
)
def test_wrong_names(loaded, ask, kind, words):
    with pytest.raises(kind, match=words):
        ask(loaded)


@pytest.mark.slow
def test_a_component_of_a_rotation_is_asked_by_its_own_name():
    with pytest.raises(KeyError, match=r"'phi' is a component of a rotation: ask rotation\('tip', 'phi'\)"):
        fm.equilibrium(cantilever()).position("tip", "phi")
    found = fm.simulate(shaft(None), [0.0, 1e-4])
    for wrong, right in (("position", "rotation"), ("velocity", "angular_velocity")):
        with pytest.raises(KeyError, match=rf"ask {right}\('tip', 'rx'\)"):
            getattr(found, wrong)("tip", "rx")
        getattr(found, right)("tip", "rx")
