"""Frequency responses against closed forms, python-control and SciPy, and their derivatives."""

import contextlib

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.signal
from cases.mechanisms import planar_guide
from cases.motions import pendulum, sprung_mass
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar

K, D, M, ETA = 90.0, 1.2, 0.4, 0.05


def shaken(stiffness=K, damping=D):
    """A mass on a spring on a floor that shakes."""
    b = sprung_mass(stiffness=stiffness, damping=damping, mass=M)
    b.input("mass", "x", name="push")
    b.input("foot", "x", "acceleration", name="floor")
    b.output("mass", "x", name="tip")
    b.output("mass", "x", "acceleration", name="felt")
    b.output("s", 1, "stress", name="tension")
    return b.build()


@pytest.mark.slow("modes")
@pytest.mark.parametrize("method", ["modes", "direct"])
def test_a_mass_on_a_lossy_spring_on_a_floor_that_shakes(method):
    """x = (F + c p)/(c - m w^2) with c = k (1 + i eta) + i w d and a floor p = -a/w^2; the spring has c (x - p)."""
    hertz = np.array([0.3, 2.0, 40.0])
    found = fm.frequency_response(shaken(), hertz, loss_factor=ETA, method=method)
    w = 2 * np.pi * hertz
    spring, moved = K * (1 + 1j * ETA) + 1j * w * D, -1 / w**2
    by_force = 1 / (spring - M * w**2)
    by_floor = spring * moved * by_force
    for name, own, floor in (
        ("tip", by_force, by_floor),
        ("felt", -(w**2) * by_force, -(w**2) * by_floor),
        ("tension", spring * by_force, spring * (by_floor - moved)),
    ):
        # Round-off; the floor carries the mass along at 0.3 Hz, and what the spring feels is what is left.
        np.testing.assert_allclose(found.of(name, "push"), own, rtol=1e-12)
        np.testing.assert_allclose(found.of(name, "floor"), floor, rtol=1e-11)
    np.testing.assert_allclose(found.magnitude("tip", "push"), np.abs(by_force), rtol=1e-12)
    np.testing.assert_allclose(found.phase("tip", "push"), np.angle(by_force), rtol=1e-10)
    alone = fm.frequency_response(
        shaken(), 2.0, outputs="felt", inputs=["floor"], loss_factor={"s": ETA}, method=method
    )
    np.testing.assert_allclose(alone.of(), found.of("felt", "floor")[1:2], rtol=1e-13)


def guide(thickness=5e-4, ratio=0.01, lossy_left=False):
    """The tutorial's guide with all deformations free; damping of one leaf spring alone couples modes."""
    b = planar_guide(thickness, beams=2, elongation=True, ratio=ratio, dofs=False)
    for of in ("left 1", "left 2", "right 1"):
        b.dof(of, 1, 2, 3)
    if lossy_left:
        b.add(planar.truss, "left2", "right0", name="damper", section=fm.Rigidity(EA=0.0), damping=fm.Damping(EA=0.3))
    b.input("left2", "phi", name="twist")
    b.output("right2", "y", "acceleration", name="bounce")
    return b.build(dofs="named")


@pytest.mark.slow
@pytest.mark.parametrize("coupled", [False, True])
def test_a_guide_as_python_control_and_scipy_have_it(coupled):
    model = guide(lossy_left=coupled)
    hertz = np.logspace(0, 3, 200)
    plant = fm.to_statespace(model)
    expected = np.moveaxis(plant(2j * np.pi * hertz, squeeze=False), -1, 0)
    largest = np.max(np.abs(expected), axis=0)
    moved = largest > 1e-6 * np.max(largest, axis=0)
    by_stiffness = np.asarray(fm.frequency_response(model, hertz, method="direct").response)
    # Round-off of python-control, whose matrix has the highest frequency squared beside the lowest, 5e8 times less, at
    # a resonance that is fifty times as high as the response at rest: 5e-6 for one rounding, and LAPACK makes a few.
    assert np.max((np.abs(by_stiffness - expected) / largest)[:, moved]) < 1e-4
    found = np.asarray(fm.frequency_response(model, hertz).response)
    # Both solve the same equations from the side of the stiffness: round-off, and coupling of modes taken as none.
    assert np.max((np.abs(found - by_stiffness) / largest)[:, moved]) < 1e-9
    # At the highest response of the sway, with nineteen digits by refinement: round-off of modes is that of K by its
    # condition, 5e8, of which a tenth is seen.
    peak = int(np.argmax(np.abs(found[:, 0, 0])))
    lin, w = fm.linearize(model), 2 * np.pi * np.longdouble(hertz[peak])
    k, d, m = (np.asarray(of).astype(np.clongdouble) for of in (lin.K, lin.D0, lin.M0))
    z = k + 1j * w * d - w**2 * m
    sensed, force = (np.asarray(lin.DFx)[model.labels.coordinates(name)[0]] for name in ("left2", "right2"))
    x = np.zeros(len(z), np.clongdouble)
    for _ in range(5):
        x = x + np.linalg.solve(z.astype(complex), (force - z @ x).astype(complex))
    assert found[peak, 0, 0] == approx(complex(sensed @ x), rel=1e-8)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::flexmb.errors.BeamTheoryWarning")
def test_motions_almost_without_mass_are_summed_as_they_are():
    """Shear of two equal leaf springs vibrates at frequencies that round-off does not tell apart."""
    thin = fm.Rectangle(0.02, 0.4e-3, fm.Material(E=210e9, G=80e9, rho=7850.0), shear=True)
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.08, 0.1), "D": (0.08, 0)}.items():
        b.node(name, place)
    for foot, top in ("AB", "DC"):
        b.add(planar.spectral_beam(8, shear=True), foot, top, section=thin)
    b.add(planar.rigid_body, "B", "C")
    b.mass("B", 0.2)
    b.fix("D")
    b.fix("A", "rotation")
    b.fix("A", "y")
    b.prescribe("A", "x", 0.0)
    b.input("A", "x", "displacement")
    b.output("A", "x", "reaction")
    model = b.build()
    found, direct = (
        np.asarray(fm.frequency_response(model, [0.0, 20.0], method=method).response) for method in ("modes", "direct")
    )
    np.testing.assert_allclose(found, direct, rtol=1e-7)
    # Two guided leaf springs, one after the other, of stiffness 12 EI/(L^3 (1 + 12 EI/(k G A L^2))), k after Cowper.
    nu, t, length = 210 / 160 - 1, 0.4e-3, 0.1
    shear = 210e9 * t**2 / (10 * (1 + nu) / (12 + 11 * nu) * 80e9 * length**2)
    assert found[0, 0, 0].real == approx(0.5 * 210e9 * 0.02 * t**3 / length**3 / (1 + shear), rel=1e-8)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::scipy.signal.BadCoefficients")
def test_the_guide_of_the_tutorial_as_scipy_has_it():
    model = planar_guide(ratio=0.01).build()
    hertz = np.logspace(0, 2, 50)
    plant = fm.to_statespace(model)
    # SciPy goes by a transfer function, which it can of few states alone.
    one = scipy.signal.StateSpace(plant.A, plant.B, plant.C[:1], plant.D[:1])
    _, expected = scipy.signal.freqresp(one, 2 * np.pi * hertz)
    found = fm.frequency_response(model, hertz, outputs="position left1 x")
    np.testing.assert_allclose(found.of(), expected, rtol=1e-11)


@pytest.mark.slow
def test_derivatives_by_dimensions_and_frequencies():
    """Against central differences, through modes that damping couples, forward and in reverse."""
    hertz = np.array([5.0, 30.0, 300.0])

    def answers(at):
        model = guide(at[0], lossy_left=True)
        found = fm.frequency_response(model, at[1] * hertz, loss_factor=at[2], outputs=("position right2.x", "bounce"))
        return jnp.stack([jnp.real(found.response), jnp.imag(found.response)])

    at, step = np.array([5e-4, 1.0, 0.02]), 1e-5
    one = jax.jit(answers)
    forward, back = jax.jit(jax.jacfwd(answers))(at), jax.jit(jax.jacrev(answers))(at)
    np.testing.assert_allclose(forward, back, atol=1e-12 * np.max(np.abs(back)))
    for i in range(3):
        moved = at * (1 + step * np.eye(3)[i]), at * (1 - step * np.eye(3)[i])
        difference = (one(moved[0]) - one(moved[1])) / (2 * step * at[i])
        # Error of a central difference: the square of its step, times the sharpness of a resonance squared.
        assert np.max(np.abs(forward[..., i] - difference)) < 1e-6 * np.max(np.abs(difference))


def ball(stiffness):
    """A mass on springs along x and y: where they are equal, so are its frequencies."""
    b = fm.Builder()
    for name, place in {"m": (0, 0), "x": (1, 0), "y": (0, 1)}.items():
        b.node(name, place)
    for i, name in enumerate("xy"):
        b.add(planar.truss, "m", name, section=fm.Rigidity(EA=stiffness[i]))
        b.fix(name)
        b.input("m", name, name=f"F{name}")
        b.output("m", name, name=name)
    b.mass("m", M)
    b.dof("m", "x", "y")
    return b.build()


@pytest.mark.slow
def test_where_frequencies_are_repeated_and_where_a_resonance_is_hit():
    w = 1.3 * np.sqrt(K / M)
    slopes = jax.jacrev(lambda k: jnp.real(fm.frequency_response(ball(k), w / (2 * np.pi)).response)[0])(
        np.array([K, K])
    )
    expected = np.zeros((2, 2, 2))
    expected[0, 0, 0] = expected[1, 1, 1] = -1 / (K - M * w**2) ** 2
    np.testing.assert_allclose(slopes, expected, atol=1e-12 * np.max(np.abs(expected)))
    # 100 rad/s, but for round-off; the other motion does not know of it.
    still = ball(np.array([1e4 * M, K]))
    with pytest.warns(fm.FlexmbWarning, match=r"'x' to 'Fx' is infinite at 15\.9155 Hz.*fm\.damped"):
        found = fm.frequency_response(still, [1.0, 100 / (2 * np.pi)])
    finite = np.isfinite(np.asarray(found.response))
    np.testing.assert_array_equal(finite, [np.ones((2, 2), bool), [[False, True], [True, True]]])
    assert found.of("y", "Fy")[1] == approx(1 / (K - M * 1e4), rel=1e-12)
    with pytest.warns(fm.FlexmbWarning, match="infinite at 0 Hz.*Support it"):
        assert np.all(~np.isnan(np.asarray(fm.frequency_response(ball(np.zeros(2)), 0.0, method="direct").response)))


def test_a_floor_that_moves_with_a_velocity():
    """x = p (k + i w d)/(k + i w d - m w^2) with a floor p = v/(i w)."""
    b = sprung_mass(stiffness=K, damping=D, mass=M)
    b.input("foot", "x", "velocity", name="floor")
    b.output("mass", "x", name="tip")
    hertz = np.array([0.3, 2.0])
    w = 2 * np.pi * hertz
    spring = K + 1j * w * D
    found = fm.frequency_response(b.build(), hertz).of("tip", "floor")
    np.testing.assert_allclose(found, spring / (spring - M * w**2) / (1j * w), rtol=1e-11)


@pytest.mark.slow
def test_what_is_refused_and_what_is_said():
    model = shaken()
    found = fm.frequency_response(model, np.linspace(1, 10, 50))
    assert "tip by push: at most" in repr(found)
    assert "50, 1 to 10 Hz" in repr(found)
    for fault, message, words in (
        (KeyError, "no output 'top': the outputs are tip, felt, tension", {"outputs": "top"}),
        (KeyError, "no input 'pull': the inputs are push, floor", {"inputs": ["pull"]}),
        (ValueError, "cannot be negative", {"hertz": [-1.0]}),
        (ValueError, "no response to 'floor'", {"hertz": [0.0, 1.0]}),
        (ValueError, "`method` must be None or 'modes' or 'direct'", {"method": "fast"}),
        (ValueError, "no element is of 't'", {"loss_factor": {"t": 0.1}}),
    ):
        with pytest.raises(fault, match=message):
            fm.frequency_response(model, **{"hertz": [1.0], **words})
    with pytest.raises(KeyError, match="Choose one: the outputs are"):
        found.of()
    fm.plot.bode(found, "tip")


UNSTABLE = "The equilibrium is not stable: it has a negative frequency"


def test_a_pendulum_on_its_head():
    """A point mass on a rod: phi = T/(-m l^2 w^2 - m g l) on its head, which no one measures, and + m g l hanging."""
    hertz = np.array([0.5, 2.0])
    for height in (0.5, -0.5):
        b = pendulum((0, height), M)
        b.input("rod", "phi")
        b.output("rod", "phi")
        with pytest.warns(fm.FlexmbWarning, match=UNSTABLE) if height > 0 else contextlib.nullcontext():
            found = fm.frequency_response(b.build(), hertz)
        exact = 1 / (-M * 0.25 * (2 * np.pi * hertz) ** 2 - M * 9.81 * height)
        np.testing.assert_allclose(found.of(), exact, rtol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_column_about_its_buckling_load(share):
    """By sparse factors; Euler's load of EI = L = 1, which four cubic elements put 1e-4 higher."""
    b = fm.Builder()
    for i in range(5):
        b.node(f"n{i}", (i / 4, 0))
    for i in range(4):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0))
    b.fix("n0")
    b.force("n4", (-share * np.pi**2 / 4, 0))
    b.input("n4", "y")
    b.output("n4", "y")
    with pytest.warns(fm.FlexmbWarning, match=UNSTABLE) if share > 1 else contextlib.nullcontext():
        fm.frequency_response(b.build(), 1.0, sparse=True)


@pytest.mark.slow
def test_a_response_about_a_state_that_was_not_found_is_no_number():
    """Under a trace; it is not that of a resonance, which is infinite."""

    def place(force):
        b = fm.Builder()
        b.node("a", (0.0, 0.0))
        b.node("c", (0.1, 0.0))
        b.add(planar.truss, "a", "c", section=fm.Rigidity(EA=10.0))
        b.fix("a")
        b.fix("c", "y")
        b.mass("c", 0.1)
        b.dof("c", "x")
        b.force("c", (force, 0.0))
        b.input("c", "x")
        b.output("c", "x")
        found = fm.frequency_response(b.build(check=False), jnp.array([1.0]), method="direct")
        return jnp.abs(found.response[0, 0, 0])

    both = jax.jit(jax.value_and_grad(place))
    # 1/|k - m w^2|, which a force along the bar changes by little; of no number there is none.
    assert float(both(0.0)[0]) == approx(1 / (100.0 - 0.1 * (2 * np.pi) ** 2), rel=1e-9)
    assert np.all(np.isnan(both(np.nan)))
