"""Noise budgets against closed forms and Lyapunov's equation by python-control, and as answers of designs."""

import itertools
from typing import Any

import control
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
from cases.mechanisms import planar_guide
from cases.motions import sprung_mass
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.control.feedback import feedback_controller

K, D, M = 90.0, 1.2, 0.4
# One-sided densities: 1e-4 N^2/Hz of force, 1e-3 (m/s^2)^2/Hz of the floor.
FORCE, FLOOR = 1e-4, 1e-3


def shaken(stiffness=K, damping=D):
    """A mass on a spring on a floor that shakes."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (1, 0))
    b.add(planar.truss, "foot", "mass", name="s", section=fm.Rigidity(EA=stiffness), damping=fm.Damping(EA=damping))
    b.fix("foot")
    b.fix("mass", "y")
    b.mass("mass", M)
    b.dof("mass", "x")
    b.input("mass", "x", name="push")
    b.input("foot", "x", "acceleration", name="floor")
    b.output("mass", "x", name="tip")
    b.output("mass", "x", "velocity", name="speed")
    b.output("s", 1, name="stretch")
    b.output("s", 1, "stress", name="tension")
    return b.build()


@pytest.mark.slow
def test_white_noise_on_one_mass():
    """Of a force of two-sided density S the position has S/(2 d k), the velocity S/(2 d m); a floor acts by m a."""
    model, s = shaken(), FORCE / 2
    with pytest.warns(fm.FlexmbWarning, match="'tip' by 'floor', of 'speed' by 'floor' is infinite.*makes it drift"):
        found = fm.control.noise_budget(model, sources={"floor": FLOOR, "push": FORCE})
    assert found.rms("tip", "push") ** 2 == approx(s / (2 * D * K), rel=1e-12)
    assert found.rms("speed", "push") ** 2 == approx(s / (2 * D * M), rel=1e-12)
    assert found.rms("stretch", "floor") ** 2 == approx(FLOOR / 2 * M**2 / (2 * D * K), rel=1e-12)
    # k^2 of the stretch and d^2 of its rate, which are not correlated.
    tension = (K**2 / (2 * D * K) + D**2 / (2 * D * M)) * s
    assert found.rms("tension", "push") ** 2 == approx(tension, rel=1e-12)
    assert found.rms("stretch") ** 2 == approx(float(np.sum(found.variances[2])), rel=1e-14)
    assert "rms of tip: inf" in repr(found)
    assert "% push" in repr(found)
    # Within a band that has nearly all of it: what lies below the first frequency is missing.
    own = {"outputs": ["stretch", "speed"], "sources": {"floor": lambda f: FLOOR + 0 * f, "push": FORCE}}
    with pytest.warns(fm.FlexmbWarning, match="'speed' by 'floor' grows towards 0 Hz.* at 0.0002"):
        banded = fm.control.noise_budget(model, band=(0, 1e3), **own)
    assert banded.rms("stretch") == approx(float(found.rms("stretch")), rel=1e-4)
    assert banded.cumulative("stretch")[-1] == approx(float(banded.rms("stretch")), rel=1e-12)
    # Up to the resonance: |H|^2 = m^2/|k - m w^2 + i d w|^2 of the floor, and without m^2 of the force.
    top = np.sqrt(K / M) / (2 * np.pi)
    passed = scipy.integrate.quad(
        lambda f: (M**2 * FLOOR + FORCE) / abs(K - M * (2 * np.pi * f) ** 2 + 2j * np.pi * f * D) ** 2, 0, top
    )
    below = np.interp(top, banded.hertz, banded.cumulative("stretch"))
    assert below**2 == approx(passed[0], rel=1e-3)
    # By the trapezoidal rule at the same frequencies, some eighty a resonance.
    again = fm.control.noise_budget(model, banded.hertz, **own)
    np.testing.assert_allclose(again.variances, banded.variances, rtol=5e-3)
    upper, lower = fm.plot.noise(banded, "stretch").axes
    assert lower.lines[-1].get_ydata()[-1] == approx(float(banded.rms("stretch")), rel=1e-12)
    assert [text.get_text() for text in upper.get_legend().get_texts()] == ["floor", "push", "all"]


def floor_guide(element, dofs=()):
    """Two leaf springs and a bar with 0.1 kg at each of its ends, whose feet shake as one floor."""
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, place)
    leaf = fm.Rectangle(width=18e-3, thickness=0.5e-3, material=fm.Material(E=210e9, G=80e9, rho=7850.0))
    b.add(element, "A", "B", name="left", section=leaf)
    b.add(element, "D", "C", name="right", section=leaf)
    b.add(planar.beam, "B", "C", name="bar")
    for foot, top in ("AB", "DC"):
        b.fix(foot)
        b.mass(top, 0.1)
    for component in dofs:
        b.dof("B", component)
    b.actuator("floor", {"acceleration A.x": 1.0, "acceleration D.x": 1.0})
    b.sensor("gap", {"B.x": 1.0, "position A.x": -1.0})
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("element", "dofs"),
    [(planar.spectral_beam(4), ()), (planar.beam, ("x", "y", "phi"))],
    ids=["deformations", "nodes"],
)
def test_a_floor_that_moves_as_a_whole_makes_nothing_drift(element, dofs):
    """Its two feet and the relative sensor cancel but for round-off; Miles: x² = S/(4 zeta w^3), S two-sided."""
    density, ratio = 1e-8, 0.01
    model = floor_guide(element, dofs)
    found = fm.control.noise_budget(fm.damped(model, ratio=ratio), sources={"floor": density})
    w = 2 * np.pi * float(fm.frequencies(model)[0])
    miles = np.sqrt(density / 2 / (4 * ratio * w**3))
    # The leaf springs have 7 % of the mass: their share in the mode is more than that in the mass that is moved.
    assert found.rms("gap") == approx(miles, rel=0.02)
    assert found.rms("gap") == approx(6.381e-7, rel=1e-3)


def by_hand(stiffness, density, edges, factor=1.0):
    """Root mean square of the mass by a density, by the trapezoidal rule between edges at many frequencies."""
    f = np.concatenate([np.linspace(low, high, 100_001) for low, high in itertools.pairwise(edges)])
    size = factor / np.abs(stiffness - M * (2 * np.pi * f) ** 2 + 2j * np.pi * f * D) ** 2
    return np.sqrt(np.trapezoid(size * density(f), f))


@pytest.mark.slow
def test_lines_and_jumps_of_densities_that_are_functions():
    """Of what poles know nothing: a line beside a measured spectrum that is high in one of its bins, and a box."""
    # 0.1 % of its frequency wide, as narrow as is promised; and a box to beyond the resonance at 2.39 Hz.
    centre, width, edge, band = 16.7, 0.0167, 2.5, (1.0, 400.0)
    bins = np.arange(0, 500.1, 0.2)
    measured = np.where(np.arange(len(bins)) == 250, FORCE, 1e-9)

    def push(f, centre: Any = centre, xp: Any = np):
        return xp.interp(f, bins, measured) + FORCE * xp.exp(-(((f - centre) / width) ** 2))

    def budget(stiffness, centre=centre):
        sources = {"push": lambda f: push(f, centre, jnp), "floor": lambda f: jnp.where(f < edge, FLOOR, 0.0)}
        return fm.control.noise_budget(shaken(stiffness), sources=sources, band=band, outputs="stretch")

    def stretch(*at):
        found = budget(*at)
        return jnp.stack([found.rms(source=source) for source in ("push", "floor")])

    def wanted(stiffness, centre=centre):
        near = [band[0], centre - 10 * width, centre + 10 * width, *bins[249:252], band[1]]
        by_push = by_hand(stiffness, lambda f: push(f, centre), near)
        return np.array([by_push, by_hand(stiffness, lambda f: FLOOR, [band[0], edge], M**2)])

    # What is drawn by straight pieces is off by 2e-3 of its height at most.
    np.testing.assert_allclose(stretch(K), wanted(K), rtol=1e-3)
    found = budget(K)
    hertz = np.asarray(found.hertz)
    assert np.all(np.diff(hertz) > 0)
    # What is not negative adds up, also across a jump.
    assert np.all(np.diff(found.below, axis=0) >= 0)
    # An edge stands still, though frequencies beside it move with the poles.
    by_stiffness, by_centre = jax.jacfwd(stretch, argnums=(0, 1))(K, centre)
    difference = (wanted(K * 1.0001) - wanted(K * 0.9999)) / (2e-4 * K)
    np.testing.assert_allclose(by_stiffness, difference, rtol=2e-3)
    difference = (wanted(K, centre * 1.00001) - wanted(K, centre * 0.99999)) / (2e-5 * centre)
    # A line that moves loses at one side what it gains at the other, but for a share of its width: digits go with it.
    np.testing.assert_allclose(by_centre, difference, rtol=2e-2)
    # Within jax.jit the same frequencies; of a line whose place is not known there none.
    assert jax.eval_shape(lambda stiffness: budget(stiffness).hertz, K).shape == hertz.shape
    assert jax.eval_shape(lambda centre: budget(K, centre).hertz, centre).shape < hertz.shape


@pytest.mark.slow("<lambda>1", "<lambda>0")
@pytest.mark.parametrize(
    "rough",
    [
        lambda f: FORCE * (1 + np.sin(1e9 * f)),
        # It has no end.
        lambda f: FORCE / (f - 50.01) ** 2,
    ],
)
def test_a_density_too_rough_to_be_drawn_is_told(rough):
    with pytest.warns(fm.FlexmbWarning, match="density of source 'push' is too rough"):
        fm.control.noise_budget(shaken(), sources={"push": rough}, band=(1.0, 400.0), outputs="tip")


@pytest.mark.slow
@pytest.mark.parametrize("gain", [1e3, 1e5])
def test_frequencies_beside_a_controller_that_is_a_function_of_them(gain):
    """S/(4 d (k + g)) of a mass on a spring and a gain, whose resonance no pole of the mechanism tells."""
    model = shaken()
    own = {"sources": {"push": FORCE}, "measured": "tip", "driven": "push", "outputs": "tip"}
    found = fm.control.noise_budget(model, band=(0.1, 1e3), controller=lambda f: gain + 0j * f, **own)
    # Responses change by 2 % from each frequency to the next, and the trapezoidal rule is off by the square.
    assert found.rms() ** 2 == approx(FORCE / (4 * D * (K + gain)), rel=1e-3)


@pytest.mark.slow
def test_a_gain_that_is_traced_in_a_function_of_frequencies():
    """By closed form d(rms)/dg = -rms/(2 (k + g)), by k as well; under jax.jit no frequencies are chosen."""

    def rms(gain, stiffness=K):
        model = shaken(stiffness)
        own = {"sources": {"push": FORCE}, "measured": "tip", "driven": "push", "outputs": "tip"}
        return fm.control.noise_budget(model, band=(0.1, 100), controller=lambda f: gain + 0j * f, **own).rms()

    value, slopes = jax.value_and_grad(rms, argnums=(0, 1))(1e3, K)
    # As far as the rule that sums is exact.
    np.testing.assert_allclose(slopes, -value / (2 * (K + 1e3)), rtol=2e-3)
    with pytest.raises(ValueError, match=r"Give `hertz` under jax\.jit"):
        jax.jit(rms)(1e3)


def test_a_loop_without_damping_that_a_function_of_frequencies_closes_is_told():
    b = sprung_mass(stiffness=K, damping=0.0, mass=M)
    b.input("mass", "x", name="push")
    b.output("mass", "x", name="tip")
    with pytest.warns(fm.FlexmbWarning, match="an undamped resonance, or a long delay"):
        fm.control.noise_budget(
            b.build(), sources={"push": FORCE}, band=(0.5, 10.0), controller=lambda f: 50.0 + 0j * f
        )


def test_a_resonance_without_damping_in_a_band_is_refused():
    b = sprung_mass(stiffness=K, damping=0.0, mass=M)
    b.input("mass", "x", name="push")
    b.output("mass", "x", name="tip")
    model, w = b.build(), np.sqrt(K / M)
    with pytest.raises(fm.AnalysisError, match=rf"at {w / (2 * np.pi):.4g} Hz, has no damping"):
        fm.control.noise_budget(model, sources={"push": FORCE}, band=(0.0, w))
    above = fm.control.noise_budget(model, sources={"push": FORCE}, band=(w, 2 * w))
    wanted = scipy.integrate.quad(lambda f: FORCE / (K - M * (2 * np.pi * f) ** 2) ** 2, w, 2 * w)[0]
    assert above.rms("tip") ** 2 == approx(wanted, rel=1e-6)
    assert np.isfinite(fm.control.noise_budget(model, sources={"push": FORCE}, band=(0.01 * w, 0.1 * w)).rms("tip"))


@pytest.mark.slow
def test_frequencies_that_do_not_resolve_a_resonance_are_told():
    """The mean square of a mass under white force is S/(4 d k), of one-sided density S, whatever the grid finds."""
    damping = 2 * 5e-4 * np.sqrt(K * M)
    model, f0 = shaken(damping=damping), np.sqrt(K / M) / (2 * np.pi)
    true = np.sqrt(FORCE / (4 * damping * K))
    own = {"sources": {"push": FORCE, "floor": lambda f: 0 * f}, "outputs": "tip"}
    for count in (300, 3000):
        named = rf"resolve the resonance at {f0:.4f}.*half-power width is 0\.0024.*'tip' by 'push'.*band=\(0\.5, 20\)"
        with pytest.warns(fm.FlexmbWarning, match=named) as told:
            found = fm.control.noise_budget(model, np.linspace(0.5, 20, count), **own)
        stated = float(str(told[0].message).split("some ")[1].split(" %")[0]) / 100
        # The static part of the response is no part of the peak; two digits of the message.
        assert abs(found.rms() / true - 1) == approx(stated, rel=0.05)
    # Three frequencies within the width: the trapezoidal rule is wrong by 2 exp(-3 pi).
    fine = fm.control.noise_budget(model, np.arange(0.5, 20, 2 * 5e-4 * f0 / 3), **own)
    assert fine.rms() == approx(true, rel=2e-3)
    # A resonance outside the frequencies does not matter.
    fm.control.noise_budget(model, np.linspace(4, 20, 300), sources={"push": FORCE})
    # The poles of the loop count, not the poles of the mechanism.
    damped = {"controller": ([[-1e3]], [[1.0]], [[-4e5]], [[400.0]]), "measured": "tip", "driven": "push"}
    loop = fm.control.noise_budget(model, np.linspace(0.5, 20, 300), **own, **damped)
    banded = fm.control.noise_budget(model, band=(0.5, 20), **own, **damped)
    assert loop.rms() == approx(float(banded.rms()), rel=1e-2)


@pytest.mark.slow("49.0-mass", "49.0-end")
@pytest.mark.parametrize("pushed", ["mass", "end"])
@pytest.mark.parametrize("stiffness", [49.0, 50.0, 64.0])
def test_motions_without_mass_pass_on_nothing_by_round_off(stiffness, pushed):
    """S/(4 d k) of a mass on a spring, whatever hangs on it without mass."""
    b = sprung_mass(stiffness=K, damping=D, mass=M)
    b.node("end", (0.5, 0.0))
    b.add(planar.truss, "mass", "end", section=fm.Rigidity(EA=0.1 * stiffness))
    b.fix("end", "y")
    b.dof("end", "x")
    b.input(pushed, "x", name="push")
    b.output("mass" if pushed == "end" else "end", "x", name="tip")
    found = fm.control.noise_budget(b.build(), sources={"push": FORCE})
    assert found.rms("tip") ** 2 == approx(FORCE / (4 * D * K), rel=1e-9)


def guide(thickness=5e-4):
    """The tutorial's guide with all deformations free."""
    b = planar_guide(thickness, elongation=True, ratio=0.01, dofs=False)
    b.dof("left 1", 1, 2, 3)
    return b.build(dofs="named")


PUSH, TIP = "force right1.x", "position left1.x"


def regulator(kp=400.0, kd=1.5, lag=1e-3):
    """Force by position, with a lag, as A, B, C and D."""
    return jnp.array([[-1 / lag]]), jnp.array([[1.0]]), jnp.array([[(kp - kd / lag) / lag]]), jnp.array([[kd / lag]])


@pytest.mark.slow
def test_a_guide_and_its_loop_as_lyapunovs_equation_has_them():
    model = guide()
    plant = fm.to_statespace(model)[[0], [0]]
    open_loop = fm.control.noise_budget(model, sources={PUSH: FORCE}, outputs=TIP)
    loop = control.ss(*(np.asarray(part) for part in regulator()))
    sources = {f"sensor {TIP}": 1e-14, PUSH: FORCE}
    around = {"sources": sources, "measured": TIP, "outputs": TIP}
    closed = fm.control.noise_budget(model, controller=loop, **around)
    by_push, by_sensor = control.feedback(plant, loop), -control.feedback(plant * loop, 1)
    checked: Any = (
        (open_loop.rms(), plant, FORCE),
        (closed.rms(TIP, PUSH), by_push, FORCE),
        (closed.rms(TIP, f"sensor {TIP}"), by_sensor, 1e-14),
    )
    for found, system, density in checked:
        # Scaled, or round-off of the highest frequency squared leaves seven digits.
        a, scale = scipy.linalg.matrix_balance(system.A)
        b, c = np.linalg.solve(np.asarray(scale), system.B), system.C @ scale
        covariance = control.lyap(a, density / 2 * b @ b.T)
        assert found**2 == approx((c @ covariance @ c.T).item(), rel=1e-8)
    # By frequency, where the controller may be a function, too.
    banded = fm.control.noise_budget(model, controller=regulator(), band=(0, 2e3), **around)
    np.testing.assert_allclose(banded.variances, closed.variances, rtol=1e-3)
    s = 2j * np.pi * np.asarray(banded.hertz)
    by_hand = fm.control.noise_budget(
        model, banded.hertz, controller=lambda f: -(400 + 1.5 * s) / (1 + 1e-3 * s), sign=1, driven=PUSH, **around
    )
    np.testing.assert_allclose(by_hand.spectra, banded.spectra, rtol=1e-9, atol=1e-12 * np.max(banded.spectra))
    with pytest.raises(fm.AnalysisError, match=r"loop of mechanism and controller is unstable: its pole .* Hz, grows"):
        fm.control.noise_budget(model, controller=loop, sign=1, **around)


@pytest.mark.slow
def test_a_free_mass_held_by_its_controller_and_a_joint_without_mass():
    """Gains k and d make of a free mass that on a spring and a damper; a joint follows it at once."""
    k1, k2 = 30.0, 60.0
    b = fm.Builder()
    for name, x in (("free", 0.0), ("wall", 1.0), ("joint", 2.0), ("mass", 3.0)):
        b.node(name, (x, 0))
    b.add(planar.truss, "wall", "joint", section=fm.Rigidity(EA=k1))
    b.add(planar.truss, "joint", "mass", section=fm.Rigidity(EA=k2))
    b.add(planar.truss, "free", "wall", section=fm.Rigidity(EA=0.0), damping=fm.Damping(EA=0.0))
    b.fix("wall")
    for name in ("free", "joint", "mass"):
        b.fix(name, "y")
        b.dof(name, "x")
        b.input(name, "x", name=f"push {name}")
        b.output(name, "x", name=name)
    b.output("free", "x", "velocity", name="speed")
    for name in ("free", "mass"):
        b.mass(name, M)
    lin = fm.damped(b.build(), rayleigh=(D / M, 0.0))
    hertz = np.array([0.5, 2.0, 7.0])
    response = fm.frequency_response(lin, hertz, outputs=["joint", "mass"], inputs=["push joint", "push mass"]).response
    w, share, k = 2 * np.pi * hertz, k2 / (k1 + k2), k1 * k2 / (k1 + k2)
    mass = 1 / (k + 1j * w * D - M * w**2)
    expected = np.array([[share**2 * mass + 1 / (k1 + k2), share * mass], [share * mass, mass]])
    np.testing.assert_allclose(response, np.moveaxis(expected, -1, 0), rtol=1e-12)
    hold = {"controller": np.array([[K, 0.5 * D]]), "measured": ["free", "speed"], "driven": "push free"}
    found = fm.control.noise_budget(
        lin, sources={"push free": FORCE, "push mass": FORCE}, outputs=["free", "joint"], **hold
    )
    assert found.rms("free", "push free") ** 2 == approx(FORCE / 2 / (2 * 1.5 * D * K), rel=1e-10)
    assert found.rms("joint", "push mass") ** 2 == approx(share**2 * FORCE / 2 / (2 * D * k), rel=1e-12)
    with pytest.warns(fm.FlexmbWarning, match="'joint' by 'push joint' is infinite"):
        fm.control.noise_budget(lin, sources={"push joint": FORCE}, outputs="joint", **hold)


@pytest.mark.slow
@pytest.mark.parametrize("band", [None, (0.5, 50.0)], ids=["exact", "band"])
def test_derivatives_of_a_loop(band):
    """Stiffness and gain against central differences, forward and in reverse."""

    @fm.jit
    def answers(at):
        around = {
            "sources": {"push": FORCE, "sensor tip": 1e-12},
            "measured": "tip",
            "driven": "push",
            "outputs": ("tip", "tension"),
        }
        found = fm.control.noise_budget(shaken(at[0]), controller=regulator(at[1]), band=band, **around)
        return jnp.stack([found.rms(name) for name in found.outputs])

    at, step = np.array([K, 400.0]), 1e-4
    forward, back = fm.jit(lambda at: (jax.jacfwd(answers)(at), jax.jacrev(answers)(at)))(at)
    np.testing.assert_allclose(forward, back, rtol=1e-9)
    for i in range(2):
        moved = at * (1 + step * np.eye(2)[i]), at * (1 - step * np.eye(2)[i])
        difference = (answers(moved[0]) - answers(moved[1])) / (2 * step * at[i])
        # Error of a central difference: the square of its step.
        np.testing.assert_allclose(forward[:, i], difference, rtol=1e-6)
    # Without an error, which a trace cannot have: what does not come to rest has no end.
    assert np.all(np.isinf(answers(np.array([K, -1e6]))))


@pytest.mark.slow
def test_derivatives_of_some_frequencies_need_no_compiled_function():
    def tip(stiffness):
        return fm.control.noise_budget(shaken(stiffness), [1.0, 1.2], sources={"push": FORCE}, outputs="tip").rms("tip")

    # Error of a central difference: the square of its step.
    difference = (tip(K * 1.0001) - tip(K * 0.9999)) / (2e-4 * K)
    assert float(jax.jvp(tip, (K,), (1.0,))[1]) == approx(float(difference), rel=1e-6)


@pytest.mark.slow
def test_an_answer_of_designs():
    """The variance S/(2 d k) is inverse to stiffness and to damping."""
    answers = {"rms": lambda m: fm.control.noise_budget(m, sources={"push": FORCE}, outputs="tip").rms("tip")}
    start = {"stiffness": K, "damping": D}
    found = fm.sensitivities(shaken, answers, start)
    np.testing.assert_allclose(found.table, [[-0.5, -0.5]], rtol=1e-10)
    swept = fm.sweep(shaken, answers, {"stiffness": np.array([45.0, 90.0]), "damping": np.array([D, 2 * D])})
    expected = np.sqrt(FORCE / 2 / (2 * np.array([45.0 * D, 90.0 * 2 * D])))
    np.testing.assert_allclose(swept.answers["rms"], expected, rtol=1e-10)
    wanted = np.sqrt(FORCE / 2 / (2 * D * 300.0))
    tuned = fm.tune(
        lambda stiffness: shaken(stiffness),
        answers,
        {"stiffness": K},
        {"stiffness": (10.0, 1e3)},
        targets={"rms": wanted},
    )
    assert tuned.dimensions["stiffness"] == approx(300.0, rel=1e-8)


@pytest.mark.slow
def test_what_is_refused():
    model, white = shaken(), {"push": FORCE}
    still = fm.damped(model, ratio=0.0, elements=False)
    for fault, message, words in (
        (ValueError, "at least one", {"sources": {}}),
        (KeyError, "no source 'tap': it is an input, push, floor", {"sources": {"tap": 1.0}}),
        (fm.ModelError, "there is no controller", {"sources": {"sensor tip": 1.0}}),
        (ValueError, "cannot be negative", {"sources": {"push": -1.0}, "band": (1, 2)}),
        (ValueError, "'push' is not white", {"sources": {"push": lambda f: 1 / f}}),
        (ValueError, "ascend", {"hertz": [2.0, 1.0]}),
        (ValueError, "ascend", {"hertz": [1.0, 1.0]}),
        (ValueError, "`band` must be two ascending", {"band": (2, 1)}),
        (ValueError, "either `hertz` or `band`", {"band": (1, 2), "hertz": [1.0, 2.0]}),
        (ValueError, "1 inputs, but the mechanism has 4 outputs", {"controller": 3.0}),
        (ValueError, "sampled", {"controller": control.ss(0.5, 1, 1, 0, 0.01)}),
        (TypeError, "A controller is", {"controller": "pid"}),
        (ValueError, "need a controller", {"driven": "push"}),
        (fm.AnalysisError, "does not come to rest.* no damping", {"model": still}),
    ):
        own = {"sources": white, "model": model, **words}
        with pytest.raises(fault, match=message):
            fm.control.noise_budget(own.pop("model"), own.pop("hertz", None), **own)


def test_a_controller_of_names_is_connected_by_all_of_them_or_by_none():
    """As in a simulation: one name of two that fits is a mistake, and would connect the signals in a wrong order."""
    names: Any = {"inputs": ["speed", "other"], "outputs": ["push"]}
    law = control.ss([], [], [], [[1.0, 2.0]], **names)
    with pytest.raises(fm.ModelError, match="'other' is no output of the mechanism"):
        feedback_controller(law, None, None, ["tip", "speed"], ["push"], -1)
    law.set_inputs(["speed", "tip"])
    assert feedback_controller(law, None, None, ["tip", "speed"], ["push"], -1).measured == (1, 0)
    law.set_inputs(2)
    assert feedback_controller(law, None, None, ["tip", "speed"], ["push"], -1).measured == (0, 1)


def test_a_user_s_kind_of_system_is_no_function_of_frequencies():
    """A system of python-control is callable too, with s in place of a frequency in Hz."""

    class Lead(control.StateSpace):
        pass

    own = feedback_controller(Lead([[-50.0]], [[1.0]], [[500.0]], [[0.0]]), None, None, ["tip"], ["push"], -1)
    s = 2j * np.pi * 10.0
    assert own.by_frequency(np.array([10.0]))[0, 0, 0] == approx(-500 / (s + 50), rel=1e-12)


@pytest.mark.parametrize(
    "law", [control.tf([5.0], [1.0, 0.0]), lambda f: np.where(f > 0, 5.0, np.inf), np.array([[np.nan]])]
)
def test_a_controller_that_is_not_finite_is_refused_by_its_frequency(law):
    given = feedback_controller(law, None, None, ["tip"], ["push"], -1)
    with pytest.raises(ValueError, match="controller is not finite at 0 Hz"):
        given.by_frequency(np.array([0.0, 1.0]))
