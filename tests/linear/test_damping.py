"""Damping of a whole model against masses on springs, written down by hand, and against complex stiffness."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from cases import mechanisms
from cases.mechanisms import LENGTH, THICKNESS, WIDTH, leaf, planar_guide
from cases.motions import sprung_mass
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.linear.damping import loss_factors

K, M, D = 90.0, 0.4, 1.2


def ratios_of(lin) -> np.ndarray:
    """Damping ratios of poles that swing, by ascending frequency."""
    found: Any = fm.poles(lin)
    found = found[found.imag > 1e-9 * np.abs(found)]
    found = found[np.argsort(np.abs(found))]
    return -found.real / np.abs(found)


def chain(k=30.0, between=20.0, other=None, masses=(0.5, 0.5)) -> fm.Model:
    """wall k mass between mass k wall, along x."""
    b = fm.Builder()
    for i in range(4):
        b.node(str(i), (float(i), 0))
    for i, stiffness in enumerate((k, between, k if other is None else other)):
        b.add(planar.truss, str(i), str(i + 1), name=f"spring {i}", section=fm.Rigidity(EA=stiffness))
    for name in "03":
        b.fix(name)
    for name, mass in zip("12", masses, strict=True):
        b.fix(name, "y")
        b.mass(name, mass)
        b.dof(name, "x")
    return b.build()


def test_one_mass_in_every_way():
    """m x'' + d x' + k x = 0 has the ratio d/(2 sqrt(k m))."""
    model = sprung_mass(stiffness=K, damping=0.0, mass=M).build()
    w = np.sqrt(K / M)
    for given, d in (
        ({"ratio": 0.03}, 2 * 0.03 * np.sqrt(K * M)),
        ({"ratio": [0.03, 0.04][:1]}, 2 * 0.03 * np.sqrt(K * M)),
        ({"ratio": [(0.0, 0.01), (2 * w / (2 * np.pi), 0.03)]}, 2 * 0.02 * np.sqrt(K * M)),
        ({"ratio": lambda hertz: 1e-3 * hertz}, 2e-3 * w / (2 * np.pi) * np.sqrt(K * M)),
        ({"rayleigh": (0.2, 1e-3)}, 0.2 * M + 1e-3 * K),
        ({"loss_factor": 0.04}, 0.04 * np.sqrt(K * M)),
        ({"loss_factor": {"*": 1.0, "s": 0.04}}, 0.04 * np.sqrt(K * M)),
        ({"ratio": 0.03, "loss_factor": 0.04}, 2 * 0.05 * np.sqrt(K * M)),
    ):
        found = fm.damped(model, **given)
        np.testing.assert_allclose(found.D0, [[d]], rtol=1e-12)
        np.testing.assert_allclose(ratios_of(found), d / (2 * np.sqrt(K * M)), rtol=1e-12)
    # Beside the damper of the element, or in its place.
    own = sprung_mass(stiffness=K, damping=D, mass=M).build()
    np.testing.assert_allclose(fm.damped(own, ratio=0.03).D0, [[D + 0.06 * np.sqrt(K * M)]], rtol=1e-12)
    alone = fm.damped(own, ratio=0.03, elements=False)
    np.testing.assert_allclose(alone.D0, [[0.06 * np.sqrt(K * M)]], rtol=1e-12)
    assert not np.any(alone.S_d)


def test_modes_of_two_masses():
    """Both swing together at k/m or against each other at (k + 2 c)/m: D = m (z w + Z W, z w - Z W; ..)."""
    k, c, m = 30.0, 20.0, 0.5
    w, v = np.sqrt(k / m), np.sqrt((k + 2 * c) / m)
    model = chain(k, c)
    found = fm.damped(model, ratio=[0.01, 0.04])
    expected = m * np.array([[0.01 * w + 0.04 * v, 0.01 * w - 0.04 * v], [0.01 * w - 0.04 * v, 0.01 * w + 0.04 * v]])
    np.testing.assert_allclose(found.D0, expected, rtol=1e-12)
    # In proportion to the ratios, and so are their derivatives.
    by_ratio = jax.jacrev(lambda ratios: fm.damped(model, ratio=ratios).D0)(jnp.array([0.01, 0.04]))
    np.testing.assert_allclose(by_ratio @ np.array([0.01, 0.04]), expected, rtol=1e-12)
    # The spring between them stores nothing in the first mode, and 2 c/(k + 2 c) of the energy in the second.
    found = fm.damped(model, loss_factor={"spring 1": 0.1})
    np.testing.assert_allclose(ratios_of(found), [0.0, 0.05 * 2 * c / (k + 2 * c)], rtol=1e-12, atol=1e-14)
    # Rayleigh's, as the docstring says, for one ratio at two frequencies.
    f, g = w / (2 * np.pi), v / (2 * np.pi)
    numbers = (4 * np.pi * 0.02 * f * g / (f + g), 0.02 / (np.pi * (f + g)))
    np.testing.assert_allclose(ratios_of(fm.damped(model, rayleigh=numbers)), [0.02, 0.02], rtol=1e-12)


def test_loss_factors_of_parts_are_those_of_complex_stiffness():
    """(K + i sum of eta K_part) v = lambda M v: a loss factor Im/Re of lambda to the second order in eta, 1e-6 here."""
    k, between, other, masses = 30.0, 20.0, 70.0, (0.5, 0.2)
    found = ratios_of(fm.damped(chain(k, between, other, masses), loss_factor={"spring 0": 1e-3, "spring 2": 3e-3}))
    stiffness = np.array([[k + between, -between], [-between, other + between]]) + 1j * np.diag(
        [1e-3 * k, 3e-3 * other]
    )
    values: Any = np.sort(scipy.linalg.eigvals(stiffness, np.diag(masses)))
    np.testing.assert_allclose(found, values.imag / values.real / 2, rtol=1e-5)


@pytest.mark.slow
def test_modes_of_one_frequency_keep_their_own_loss():
    """Two oscillators that know nothing of each other, k m each, d = eta sqrt(k m); d' by its k is eta/2 sqrt(m/k)."""

    def damping(stiffness):
        model = chain(between=0.0, k=stiffness[0], other=stiffness[1])
        return jnp.diag(fm.damped(model, loss_factor={"spring 0": 0.1, "spring 2": 0.3}).D0)

    at = jnp.array([30.0, 30.0])
    np.testing.assert_allclose(damping(at), np.array([0.1, 0.3]) * np.sqrt(30.0 * 0.5), rtol=1e-12)
    expected = np.diag([0.1, 0.3]) / 2 * np.sqrt(0.5 / 30.0)
    np.testing.assert_allclose(jax.jacfwd(damping)(at), expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(jax.jacrev(damping)(at), expected, rtol=1e-9, atol=1e-12)
    # Modal damping of both modes is no other where their shapes are not determined.
    by_ratio = jax.jacfwd(lambda at: fm.damped(chain(between=0.0, k=at[0], other=at[1]), ratio=0.05).D0)(at)
    np.testing.assert_allclose(by_ratio[:, :, 0], [[0.05 * np.sqrt(0.5 / 30.0), 0], [0, 0]], rtol=1e-9, atol=1e-12)


@pytest.mark.slow("-9.81", "9.81")
@pytest.mark.parametrize("gravity", [-9.81, 0.0, 9.81])
def test_what_does_not_vibrate_is_not_damped(gravity):
    """A pendulum of 0.5 m and 0.2 kg beside a sprung mass: it hangs and swings, turns freely, or stands and falls."""
    b = sprung_mass(stiffness=K, mass=M)
    b.node("pivot", (0, 1.0))
    b.rotation("rod")
    b.node("bob", (0, 0.5))
    b.add(planar.rigid_beam, "pivot", "rod", "bob", name="arm")
    b.fix("pivot", "x", "y")
    b.mass("bob", 0.2)
    b.dof("rod", "phi")
    if gravity:
        b.gravity((0, gravity))
    model = b.build()
    along = 2 * 0.03 * np.sqrt(K * M)
    # Ratio times twice the root of stiffness m g l and inertia m l^2.
    swing = 2 * 0.03 * np.sqrt(0.2 * max(-gravity, 0.0) * 0.5 * 0.2 * 0.5**2)
    np.testing.assert_allclose(fm.damped(model, ratio=0.03).D0, np.diag([along, swing]), rtol=1e-9, atol=1e-12)
    # Gravity dissipates nothing.
    np.testing.assert_allclose(fm.damped(model, loss_factor=0.06).D0, np.diag([along, 0]), rtol=1e-9, atol=1e-12)


def test_motions_without_mass_are_left_alone():
    """A joint without mass between two springs: the mass behind them is damped, and what the joint does beside."""
    found = fm.damped(chain(30.0, 60.0, 0.0, masses=(0.0, 0.5)), ratio=0.02)
    np.testing.assert_allclose(found.D0, [[0, 0], [0, 2 * 0.02 * np.sqrt(30 * 60 / 90 * 0.5)]], rtol=1e-10, atol=1e-14)


def fine_guide(*materials) -> fm.Model:
    """Frequencies over four orders of magnitude, in pairs where both leaf springs are alike."""
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, LENGTH), "C": (0.1, LENGTH), "D": (0.1, 0)}.items():
        b.node(name, place)
    for name, ends, material in zip(("left", "right"), ("AB", "DC"), materials, strict=True):
        b.add(planar.spectral_beam(3), *ends, name=name, section=fm.Rectangle(WIDTH, THICKNESS, material))
    b.add(planar.beam, "B", "C", name="stage")
    for end in "AD":
        b.fix(end)
    for end in "BC":
        b.mass(end, 0.1)
    return b.build()


def test_every_mode_of_a_stiff_guide_has_its_ratio():
    steel = mechanisms.steel()
    model = fine_guide(steel, steel)
    for given in ({"ratio": 0.01}, {"loss_factor": 0.02}, {"loss_factor": {steel: 0.02}}):
        np.testing.assert_allclose(ratios_of(fm.damped(model, **given)), 0.01, rtol=1e-6)
    # Elements of a material are those that are made of it.
    mixed = fine_guide(steel, dataclasses.replace(steel, E=200e9))
    found = [fm.damped(mixed, loss_factor=own).D0 for own in ({steel: 0.02}, {"left": 0.02})]
    np.testing.assert_array_equal(*found)


def test_damping_of_a_leaf_spring_by_a_ratio():
    """A leaf spring's own ratio is that of a vibration at its own frequency: at another one it is in proportion."""
    section = leaf()
    s = section.rigidity()
    own = np.sqrt(s.EIy / (s.mass * LENGTH**4))
    model = planar_guide(ratio=0.01).build()
    w = 2 * np.pi * float(fm.frequencies(model)[0])
    np.testing.assert_allclose(ratios_of(fm.linearize(model)), 0.01 * w / own, rtol=1e-9)
    # Given the frequency of the mode, it is that of the mode; and of a model it is so anyway.
    right = fm.sections.damping_from_ratio(section, LENGTH, 0.01, frequency=w / (2 * np.pi))
    b = planar_guide()
    for name in ("left 1", "right 1"):
        b.members[name].properties["damping"] = right
    np.testing.assert_allclose(ratios_of(fm.linearize(b.build())), 0.01, rtol=1e-9)
    np.testing.assert_allclose(ratios_of(fm.damped(model, ratio=0.01, elements=False)), 0.01, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "given",
    [
        {"ratio": lambda hertz: 1e-3 * hertz**0.5, "rayleigh": (0.1, 1e-6)},
        {"loss_factor": {"left 1": 0.02, "right 1": 0.05}, "ratio": [(1.0, 0.01), (20.0, 0.02), (5000.0, 0.1)]},
    ],
    ids=["function", "loss"],
)
def test_derivatives(given):
    weight = np.cos(np.arange(9.0)).reshape(3, 3) * np.outer([1, 1e-2, 1e-2], [1, 1e-2, 1e-2])

    def answer(thickness):
        lin = fm.damped(planar_guide(thickness, elongation=True, rotary=True).build(), **given)
        return jnp.sum(weight * lin.D0)

    at, step = 5e-4, 5e-8
    expected = float(answer(at + step) - answer(at - step)) / (2 * step)
    # Central differences: their own error is of the order (step/at)^2 and of round-off over step/at.
    assert jax.jvp(answer, (at,), (1.0,))[1] == approx(expected, rel=1e-6)
    assert jax.grad(answer)(at) == approx(expected, rel=1e-6)


@pytest.mark.slow("given9-TypeError-by names of elements or by Materials", "given10-ValueError-names no element")
@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({}, ValueError, "Give `ratio`, `rayleigh` or `loss_factor`"),
        ({"ratio": -0.1}, ValueError, "`ratio` cannot be negative"),
        ({"ratio": [0.1, 0.1, 0.1]}, ValueError, "has 3 numbers, but there are 2 modes"),
        ({"ratio": [(10, 0.1), (5, 0.1)]}, ValueError, "must ascend"),
        ({"ratio": [[1, 2, 3]]}, ValueError, r"pairs \(frequency"),
        ({"ratio": lambda hertz: -hertz}, ValueError, "a function, cannot be negative"),
        ({"ratio": lambda hertz: 0.1}, ValueError, r"a function, must have shape \(2,\)"),
        ({"rayleigh": 3.0}, ValueError, r"`rayleigh` must have shape \(2,\)"),
        ({"loss_factor": {"spring 7": 0.1}}, ValueError, "no element is of 'spring 7'. There are: spring 0"),
        ({"loss_factor": {3: 0.1}}, TypeError, "by names of elements or by Materials"),
        ({"loss_factor": {}}, ValueError, "names no element"),
    ],
)
def test_bad_input(given, kind, words):
    with pytest.raises(kind, match=words):
        fm.damped(chain(), **given)


@pytest.mark.slow
def test_known_loss_factors_serve_within_compiled_code():
    lin = fm.linearize(chain())
    for given in (0.02, {"spring 0": 0.02}):
        assert float(jax.jit(lambda row, given=given: loss_factors(lin, given)[row])(0)) == 0.02


@pytest.mark.slow
def test_incremental_loads_left_out_are_named_with_what_to_give():
    b = planar_guide()
    b.force("left1", (0.1, 0), increment=True)
    with pytest.warns(fm.FlexmbWarning, match=r"fm\.damped leaves out .* Give fm\.linearize\(model, increment=1\.0\)"):
        fm.damped(b.build(), ratio=0.01)
