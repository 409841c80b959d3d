"""State spaces of the modes that matter, against masses on springs by hand and against all modes."""

import itertools
from typing import Any

import control
import jax
import numpy as np
import pytest
from cases.mechanisms import guide_with_ports, planar_guide
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar

K, BETWEEN, MASS = 30.0, 20.0, 0.5
FREQUENCIES = np.array([0.1, 0.7, 1.3]) * np.sqrt(K / MASS)


def chain(foot=K, joint=False) -> fm.Model:
    """foot k mass between mass k foot, along x; or the masses alone with a joint without mass in their middle."""
    names = ["a", *(["joint"] if joint else []), "b"]
    b = fm.Builder()
    for i, name in enumerate(names):
        b.node(name, (float(i + 1), 0))
        b.fix(name, "y")
        b.dof(name, "x")
        b.input(name, "x", name=f"force {name}")
        b.output(name, "x", name=f"x.{name}")
    for p, q in itertools.pairwise(names):
        b.add(planar.truss, p, q, name=f"{p}{q}", section=fm.Rigidity(EA=BETWEEN * (len(names) - 1)))
    if foot:
        for name, end, x in (("left", "a", 0.0), ("right", "b", 3.0)):
            b.node(name, (x, 0))
            b.fix(name)
            b.add(planar.truss, name, end, name=f"at {name}", section=fm.Rigidity(EA=foot))
    for name in "ab":
        b.mass(name, MASS)
    b.output("a", "x", "velocity", name="v")
    b.output("a", "x", "acceleration", name="acceleration")
    b.output("ab" if not joint else "ajoint", 1, "stress", name="stress")
    return b.build()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:The state space of 1 of")
def test_one_mode_of_two_masses():
    """Both swing together with 1/(2 m (w^2 + 2 z w s + s^2)); against each other they follow by 1/(2 m W^2)."""
    w, v, z = np.sqrt(K / MASS), np.sqrt((K + 2 * BETWEEN) / MASS), 0.05
    lin = fm.damped(chain(), ratio=z)
    system: Any = fm.to_statespace(lin, modes=1)
    assert system.state_labels == ["mode 1", "d mode 1"]
    assert system.input_labels == ["force a", "force b"]
    assert system.output_labels == ["x a", "x b", "v", "acceleration", "stress"]
    for s in 1j * FREQUENCIES:
        together, against = 1 / (2 * MASS * (w**2 + 2 * z * w * s + s**2)), 1 / (2 * MASS * v**2)
        expected = [
            [together + against, together - against],
            [together - against, together + against],
            [s * together, s * together],
            [s**2 * together, s**2 * together],
            # Elongation b - a times its stiffness.
            [-2 * against * BETWEEN, 2 * against * BETWEEN],
        ]
        np.testing.assert_allclose(system(s), expected, rtol=1e-10, atol=1e-14)
    # Which mode: of the second alone the first follows at once.
    second = fm.to_statespace(lin, modes=[1])
    assert second.state_labels == ["mode 2", "d mode 2"]
    s = 1j * FREQUENCIES[1]
    expected = 1 / (2 * MASS * w**2) + 1 / (2 * MASS * (v**2 + 2 * z * v * s + s**2))
    np.testing.assert_allclose(second(s)[0, 0], expected, rtol=1e-10)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:The state space of 1 of")
def test_the_error_that_is_told_is_that_against_all_modes():
    lin = fm.damped(chain(), ratio=0.05)
    full, hertz = fm.to_statespace(lin), 0.6 * np.sqrt(K / MASS) / (2 * np.pi)
    one: Any = fm.to_statespace(lin, bandwidth=1.7 * hertz)
    omega = 2 * np.pi * 1.7 * hertz * np.logspace(-2, 0, 400)
    whole, small = (np.array([of(1j * w) for w in omega]) for of in (full, one))
    # Responses rise from rest to the resonance: there the largest of them is at the same place as their median, so
    # that relative to themselves they are off by as much or more.
    pointwise = np.max(np.abs(whole - small) / np.abs(whole), axis=0)
    assert np.all(one.truncation_error <= 1.001 * pointwise)
    assert np.all(one.truncation_error >= 0.3 * pointwise)


def test_a_large_error_is_told():
    lin = fm.damped(chain(), ratio=0.05)
    # The velocity of b that the second mode has against the first is (1/K - 1/(K + 2 BETWEEN)) of the force on a.
    off = 100 * (1 / (K / (K + 2 * BETWEEN)) - 1) ** -1
    _, second = fm.frequencies(lin)
    removed = rf"The nearest mode that is left out is at {second:.5g} Hz\. Keep more"
    with pytest.warns(fm.FlexmbWarning, match=rf"1 of 2 modes is off by {off:.2g} % for 'v' of 'force b' .*{removed}"):
        fm.control.state_matrices(lin, bandwidth=1.6)


@pytest.mark.filterwarnings("ignore:The state space of 1 of")
def test_rigid_motion_and_motion_without_mass():
    """Free masses m on a spring: 1/(2 m s^2) and, left out, 1/(2 m W^2) with W^2 = 2 k/m."""
    free = chain(foot=0.0)
    system = fm.to_statespace(free, modes=1)
    for s in 1j * FREQUENCIES:
        np.testing.assert_allclose(system(s)[0], [0.5 / (MASS * s**2) + d / (4 * BETWEEN) for d in (1, -1)], rtol=1e-9)
    with pytest.raises(ValueError, match=r"Mode 1 does not vibrate .* Keep it, as number 0"):
        fm.to_statespace(free, modes=[1])
    # With a joint in the middle of the spring, a force on it moves it by 1/(4 k) more than both masses' mean.
    jointed = fm.to_statespace(chain(foot=0.0, joint=True), modes=1)
    s = 1j * FREQUENCIES[0]
    np.testing.assert_allclose(jointed(s)[1, 1], 0.5 / (MASS * s**2) + 1 / (4 * BETWEEN), rtol=1e-9)
    np.testing.assert_allclose(jointed(s)[0, 2], system(s)[0, 1], rtol=1e-9)


def arm_on_a_support(dofs: list[str], damped: bool) -> fm.Model:
    """Four beams with masses on a clamped end that is moved across."""
    section = fm.Rigidity(EA=1e5, EIy=2.0, mass=0.3)
    b = fm.Builder()
    for i in range(5):
        b.node(f"n{i}", (0.1 * i, 0.0))
    for i in range(4):
        # Of two of them, so that what is left out feels what is kept.
        damping = fm.Damping(EIy=2e-3) if damped and i < 2 else None
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=section, released=(2, 3), damping=damping)
    b.fix("n0", "x")
    b.fix("n0", "rotation")
    b.prescribe("n0", "y")
    b.mass("n2", 0.05)
    b.mass("n4", 0.1)
    b.input("n0", "y", "acceleration")
    b.input("n3", "y")
    b.output("n0", "y", "reaction")
    b.output("n4", "y")
    b.output("b1", 2, "stress")
    b.output("n4", "y", "velocity")
    return b.build(dofs=dofs)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:The state space of 2")
@pytest.mark.parametrize("damped", [False, True])
def test_what_is_left_out_is_carried_along_whatever_the_degrees_of_freedom(damped):
    """Relative, absolute and no degrees of freedom, by sparse matrices: one transfer function, to round-off."""
    absolute = [f"n{i}.{of}" for i in range(1, 5) for of in ("y", "rotation.phi")]
    relative = [f"b{i}.e{k}" for i in range(4) for k in (2, 3)]
    models = [arm_on_a_support(dofs, damped) for dofs in (absolute, relative)]
    systems: Any = [fm.to_statespace(model, modes=2) for model in models]
    systems.append(fm.to_statespace(models[1], modes=2, sparse=True))
    full: Any = fm.to_statespace(models[0])
    for s in (20j, 60j, 200j):
        first, *others = (system(s) for system in systems)
        for other in others:
            np.testing.assert_allclose(other, first, rtol=1e-9, atol=1e-11 * np.max(np.abs(first)))
    # At rest the whole mass is moved; the third mode is at 980 rad/s, and what is left out off by its square, twice.
    np.testing.assert_allclose(systems[1](1e-3j)[0, 0], 0.3 * 0.4 + 0.05 + 0.1, rtol=1e-8)
    # By damping what is left out does not act back.
    np.testing.assert_allclose(systems[0](20j)[:3], full(20j)[:3], rtol=1e-3 if damped else 1e-4)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_margins_of_a_stiff_guide():
    """Of all modes, up to 1e5 Hz, python-control cannot tell the margins; of those of the band it can."""
    lin, lead = fm.damped(guide_with_ports(planar.spectral_beam(4)), ratio=0.01), control.tf([3.0, 300.0], [1e-3, 1.0])
    full = fm.to_statespace(lin)
    # The coefficients of its polynomials overflow.
    with pytest.raises(np.linalg.LinAlgError):
        control.margin(full * lead)
    small: Any = fm.to_statespace(lin, bandwidth=300.0)
    assert 2 <= small.nstates <= 6 < full.nstates
    assert np.max(small.truncation_error) < 1e-3
    _, phase, _, crossover = control.margin(small * lead)
    # What it says holds of all modes, to the error that is told.
    loop: Any = full(1j * crossover) * lead(1j * crossover)
    assert abs(loop) == approx(1.0, rel=1e-3)
    assert np.degrees(np.angle(loop)) + 180 == approx(phase, abs=0.1)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:The state space of 1 of")
def test_derivatives():
    def answer(thickness):
        model = planar_guide(thickness, elongation=True, ratio=0.01).build()
        found, _ = fm.control.state_matrices(model, modes=1)
        # Whatever the sign of the shape is.
        return (found.C @ found.A @ found.B + found.D)[0, 0] + 1e-3 * found.A[1, 0] + found.A[1, 1]

    at, step = 5e-4, 5e-8
    expected = float(answer(at + step) - answer(at - step)) / (2 * step)
    assert jax.jvp(answer, (at,), (1.0,))[1] == approx(expected, rel=1e-6)
    assert jax.grad(answer)(at) == approx(expected, rel=1e-6)


def test_a_bandwidth_that_is_traced_chooses_no_modes():
    model = chain()
    with pytest.raises(ValueError, match=r"depend on traced numbers\. Give `modes`"):
        jax.eval_shape(lambda hertz: fm.control.state_matrices(model, bandwidth=hertz)[0], 3.0)


@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({"modes": 1, "bandwidth": 3.0}, ValueError, "not both"),
        ({"modes": 0}, ValueError, "from 1 to 2, the number of modes, but is 0"),
        ({"modes": 3}, ValueError, "from 1 to 2"),
        ({"modes": [0, 0]}, ValueError, "from 0 to 1, each once"),
        ({"modes": [2]}, ValueError, "from 0 to 1"),
        ({"modes": "first"}, TypeError, "a whole number, or numbers of modes"),
        ({"bandwidth": -3.0}, ValueError, "`bandwidth` must be positive"),
        ({"bandwidth": 0.5}, ValueError, r"0.5 Hz is below the first mode, 1.2328 Hz"),
    ],
)
def test_bad_input(given, kind, words):
    with pytest.raises(kind, match=words):
        fm.to_statespace(chain(), **given)
