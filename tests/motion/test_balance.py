"""Energy balance of motions: impacts on stiff springs, friction, and random mechanisms with stiff one-sided laws."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb import planar
from flexmb.errors import FlexmbWarning

G = 9.81


def stop(e, ed, *, k, gap):
    return -k * jnp.maximum(-e - gap, 0.0)


def walls(e, ed, *, k):
    return k * jnp.maximum(e - 0.05, 0.0) - k * jnp.maximum(-e - 0.05, 0.0)


def falling_ball(k, drop):
    b = fm.Builder()
    b.node("floor", (0, 0))
    b.node("ball", (0, drop + 1.0))
    b.fix("floor")
    b.fix("ball", "x")
    b.mass("ball", 1.0)
    b.add(planar.spring_damper, "floor", "ball", name="stop", law=stop, k=k, gap=drop)
    b.gravity((0, -G))
    return b.build()


def mass_beside(name, law, **properties):
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("mass", (1, 0))
    b.fix("wall")
    b.fix("mass", "y")
    b.mass("mass", 1.0)
    b.add(planar.spring_damper, "wall", "mass", name=name, law=law, **properties)
    return b


@pytest.mark.slow
@pytest.mark.parametrize("drop", [0.1, 1.0, 5.0])
def test_a_ball_keeps_its_energy_on_a_stiff_stop(drop):
    # Wanted: 1 %. The step control allows 3 rtol = 3e-5 a step, and some 40 steps make up an impact.
    times = np.linspace(0, 1.5 * np.sqrt(2 * drop / G), 101)
    for k in np.geomspace(1e6, 1e11, 21):
        found = fm.simulate(falling_ball(k, drop), times)
        height, speed = found.position("ball", "y")[-1] - (drop + 1.0), found.velocity("ball", "y")[-1]
        assert speed > 0
        assert G * height + speed**2 / 2 == approx(0.0, abs=0.01 * G * drop), k
        assert found.energy_error < 1e-3


def bouncing(t, k):
    """Place of a mass of 1 kg at 1 m/s between elastic walls 0.05 m to both sides: straight lines and half waves."""
    omega = np.sqrt(k)
    contact = np.pi / omega
    s = np.mod(t, 2 * (0.1 + contact))
    way = np.where(s < 0.05, s, 0.0)
    for begin, sign in ((0.05, 1), (0.15 + contact, -1)):
        way = np.where((s >= begin) & (s < begin + contact), sign * (0.05 + np.sin(omega * (s - begin)) / omega), way)
        after = begin + contact
        way = np.where((s >= after) & (s < after + 0.1), sign * (0.05 - (s - after)), way)
    return way


@pytest.mark.slow
def test_a_cart_between_stiff_walls():
    times = np.linspace(0, 2, 201)
    for k in np.geomspace(1e6, 1e11, 6):
        b = mass_beside("walls", walls, k=k)
        b.dof("mass", "x")
        b.start("mass", "x", 0.0, 1.0)
        place = fm.simulate(b.build(), times).position("mass", "x") - 1.0
        # Wanted: 5 % of the gap, after some twenty impacts.
        np.testing.assert_allclose(place, bouncing(times, k), atol=0.05 * 0.05)


def rubbed(e, ed, *, v_s):
    v = ed - 0.1
    return 100.0 * e + 2 * jnp.tanh(v / v_s) * (1 + 0.5 * jnp.exp(-((v / 0.05) ** 2)))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:The motion gains or loses")
@pytest.mark.parametrize("v_s", [1e-5, 1e-6])
def test_stick_slip_against_scipy(v_s):
    times = np.linspace(0, 10, 501)
    found = fm.simulate(mass_beside("belt", rubbed, v_s=v_s).build(), times)

    def rates(t, y):
        v = y[1] - 0.1
        return [y[1], -100 * y[0] - 2 * np.tanh(v / v_s) * (1 + 0.5 * np.exp(-((v / 0.05) ** 2)))]

    exact = solve_ivp(rates, (0, 10), [0.0, 0.0], t_eval=times, method="Radau", rtol=1e-10, atol=1e-12)
    # Wanted: 1e-3 m of an amplitude of 0.038 m.
    np.testing.assert_allclose(found.position("mass", "x") - 1.0, exact.y[0], atol=1e-3)


@pytest.mark.slow
def test_diffrax_solvers_keep_the_energy_too():
    model, times = falling_ball(1e8, 1.0), np.linspace(0, 0.7, 51)
    found = fm.simulate(model, times, jumps=[0.1])
    height, speed = found.position("ball", "y")[-1] - 2.0, found.velocity("ball", "y")[-1]
    assert G * height + speed**2 / 2 == approx(0.0, abs=0.01 * G)
    assert found.energy_error < 1e-3
    # Fixed steps are not looked at.
    fixed = fm.simulate(model, times, solver=fm.motion.GeneralizedAlpha(), dt0=1e-3)
    assert np.isnan(fixed.energy_error)


@pytest.mark.slow
def test_work_of_loads_dampers_and_prescribed_motion_counts():
    def damped(e, ed):
        return 50.0 * e + 2.0 * ed + 500.0 * e**3

    b = mass_beside("spring", damped)
    b.node("shaker", (2, 0))
    b.fix("shaker", "y")
    b.prescribe("shaker", "x", 0.0)
    b.add(planar.spring_damper, "mass", "shaker", name="coupling", law=lambda e, ed: 80.0 * e + 1.0 * ed)
    b.dof("mass", "x")
    drives = {"loads": {"mass.x": lambda t: jnp.sin(9 * t)}, "motion": {"shaker.x": lambda t: 0.1 * jnp.sin(5 * t)}}
    found = fm.simulate(b.build(), np.linspace(0, 5, 51), **drives)
    # One step is off by some 1e-6 of the energy at the default tolerance: far below what is warned of.
    assert found.energy_error < 1e-4
    finer = fm.simulate(b.build(), np.linspace(0, 5, 51), rtol=1e-8, **drives)
    assert finer.energy_error < found.energy_error / 30


@pytest.mark.slow
def test_lost_energy_is_warned_of():
    # Axial vibrations that a sudden load excites are damped by long steps: their displacement is below the tolerance.
    leaf = fm.Rectangle(width=0.018, thickness=0.5e-3, material=fm.Material(E=210e9, G=80e9, rho=7850))
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.beam, "A", "B", name="left", section=leaf)
    b.add(planar.beam, "D", "C", name="right", section=leaf)
    b.add(planar.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    b.mass("B", 0.1)
    b.mass("C", 0.1)
    loads = {"B.x": lambda t: 2 * jnp.sin(60 * t)}
    with pytest.warns(FlexmbWarning, match="gains or loses .* % of its greatest energy"):
        found = fm.simulate(b.build(), np.linspace(0, 1, 201), loads=loads, rtol=1e-3)
    assert found.energy_error > 0.1


@pytest.mark.slow
@given(st.integers(0, 5), st.floats(5.0, 9.0), st.floats(0.2, 1.5))
def test_random_mechanisms_with_one_sided_stops_keep_their_energy(links, stiffness, gap):
    """A chain of rigid links swings against a stiff one-sided stop."""
    k, places = 10.0**stiffness, [(0.3 * i, 0.1 * np.sin(i + links)) for i in range(4)]
    b = fm.Builder()
    for i, place in enumerate(places):
        b.node(f"n{i}", place)
    for i in range(3):
        b.add(planar.truss, f"n{i}", f"n{i + 1}", name=f"link {i}")
        b.mass(f"n{i + 1}", 0.2 + 0.1 * i)
    b.node("stop", (0.9, -1.5))
    b.fix("stop")
    b.fix("n0")
    b.add(planar.spring_damper, "stop", "n3", name="stop law", law=stop, k=k, gap=0.5 * gap)
    b.gravity((0, -G))
    times = np.linspace(0, 0.8, 41)
    found = fm.simulate(b.build(), times)
    x, v = (np.stack([of(f"n{i}") for i in (1, 2, 3)], 1) for of in (found.position, found.velocity))
    masses = np.array([0.2, 0.3, 0.4])
    energy = (masses * ((v**2).sum(-1) / 2 + G * (x[..., 1] - x[0, :, 1]))).sum(1)
    length = np.linalg.norm(found.position("n3") - np.array([0.9, -1.5]), axis=-1)
    e = length - np.linalg.norm(np.array(places[3]) - np.array([0.9, -1.5]))
    energy = energy + k * np.maximum(-e - 0.5 * gap, 0.0) ** 2 / 2
    # Some impacts, each within 3 rtol a step and 40 steps.
    largest = np.max((masses * (v**2).sum(-1)).sum(1)) / 2
    np.testing.assert_allclose(energy, 0.0, atol=5e-3 * largest)


@pytest.mark.slow
def test_the_balance_leaves_derivatives_alone():
    def end(k):
        return fm.simulate(falling_ball(k, 0.1), [0.0, 0.1, 0.2], rtol=1e-9).position("ball", "y")[-1]

    k, h = 1e4, 10.0
    expected = float(end(k + h) - end(k - h)) / (2 * h)
    # Steps change with k, so that differences are off by some rtol over h.
    assert float(jax.grad(end)(k)) == approx(expected, rel=1e-3)
