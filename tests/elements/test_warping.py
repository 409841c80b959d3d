"""Beams whose warping is a coordinate of their nodes: closed forms of restrained torsion, and which ends share it."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize
from cases.tolerances import approx
from numpy.polynomial import legendre

import flexmb as fm
from flexmb import spatial
from flexmb.elements.beams import restrained_torsion

STEEL = fm.Material(E=210e9, G=210e9 / 2.6, rho=7850.0)
LEAF = fm.Rectangle(0.018, 0.5e-3, STEEL, shear=True)
LENGTH = 0.1
# Torsion and warping of strips as above, and of one that is thicker.
TWIST, WARPING = float(LEAF.rigidity().GIt), float(LEAF.rigidity().EIw)


def rod(sections, lengths, clamped=(False, False)):
    """Beams in a row along x from a fixed foot; ``clamped`` holds the warping of both its ends, or () has it found."""
    b, last = fm.Builder(), len(sections)
    for i, x in enumerate([0.0, *np.cumsum(lengths)]):
        b.node(f"n{i}", (x, 0, 0))
    for i, section in enumerate(sections):
        held = (clamped[0] and i == 0, clamped[1] and i == last - 1) if clamped else None
        b.add(spatial.warping_beam, f"n{i}", f"n{i + 1}", name=f"beam {i}", section=section, y=(0, 1, 0), clamped=held)
    b.fix("n0")
    return b


def twist_stiffness(b: fm.Builder, end: str) -> float:
    return 1 / float(fm.compliance(b.build(), end)[3, 3])


@pytest.mark.slow("both-1", "one-1", "one-3", "none-1", "none-3")
@pytest.mark.parametrize("beams", [1, 3])
@pytest.mark.parametrize("ends", [(True, True), (True, False), (False, False)], ids=["both", "one", "none"])
def test_twist_of_a_strip_by_the_closed_form(beams, ends):
    """REFERENCES.md T7-torsion, (2.10): exact with any number of beams, but for round-off times 1e2."""
    al = LENGTH * np.sqrt(TWIST / WARPING)
    factor = {2: 1 / (1 - 2 * np.tanh(al / 2) / al), 1: 1 / (1 - np.tanh(al) / al), 0: 1.0}[sum(ends)]
    found = twist_stiffness(rod([LEAF] * beams, [LENGTH / beams] * beams, ends), f"n{beams}")
    assert found == approx(TWIST / LENGTH * factor, rel=1e-12)
    assert factor == approx(float(fm.sections.warping_factor(LENGTH, 0.018, 0.3, sum(ends))), rel=2e-3)


@pytest.mark.slow
def test_two_strips_share_what_warps_between_them():
    """Where the section jumps angle, twist rate and bimoment go on: eight equations for two exact solutions."""
    lengths, twist, warping = (0.03, 0.05), (0.04, 0.09), (1.6e-6, 1e-5)
    sections = [fm.Rigidity(1e6, 1.0, 50.0, g, EIw=w) for g, w in zip(twist, warping, strict=True)]
    rows, right = np.zeros((8, 8)), np.zeros(8)
    alpha = np.sqrt(np.divide(twist, warping))

    def terms(k, x, slope):
        """Of the angle 1, x, sinh and cosh, or of its slopes."""
        hyperbolic = (np.sinh, np.cosh)
        powers = ([1.0, x], [0.0, 1.0], [0.0, 0.0], [0.0, 0.0])[slope]
        return np.array([*powers, *(alpha[k] ** slope * hyperbolic[(i + slope) % 2](alpha[k] * x) for i in (0, 1))])

    for row, slope in ((0, 0), (1, 1)):
        rows[row, :4] = terms(0, 0.0, slope)
        rows[row + 2, :4], rows[row + 2, 4:] = terms(0, lengths[0], slope), -terms(1, 0.0, slope)
    for row, slope, sizes in ((4, 2, warping), (5, 3, warping)):
        rows[row, :4] = sizes[0] * terms(0, lengths[0], slope)
        rows[row, 4:] = -sizes[1] * terms(1, 0.0, slope)
    # Torque GIt angle' - EIw angle''' goes on too, and is one at the end, where nothing warps.
    rows[5] = -rows[5]
    rows[5, :4] += twist[0] * terms(0, lengths[0], 1)
    rows[5, 4:] -= twist[1] * terms(1, 0.0, 1)
    rows[6, 4:] = twist[1] * terms(1, lengths[1], 1) - warping[1] * terms(1, lengths[1], 3)
    rows[7, 4:], right[6] = terms(1, lengths[1], 1), 1.0
    angle = terms(1, lengths[1], 0) @ np.linalg.solve(rows, right)[4:]
    found = twist_stiffness(rod(sections, lengths, (True, True)), "n2")
    assert found == approx(1 / angle, rel=1e-9)


def least_energy(u: float) -> np.ndarray:
    """Energy of an angle and two end slopes, of all polynomials that have them: Ritz's method, GIt and length one."""
    x, weights = legendre.leggauss(40)
    shapes = [legendre.Legendre.basis(k, domain=[0, 1]) for k in range(24)]
    s, w = (x + 1) / 2, weights / 2
    slope, second = (np.array([shape.deriv(m)(s) for shape in shapes]) for m in (1, 2))
    energy = (slope * w) @ slope.T + (second * w) @ second.T / (4 * u**2)
    at = [(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0)]
    ends = np.array([[(shape.deriv(m) if m else shape)(place) for shape in shapes] for m, place in at])
    whole = np.block([[energy, ends.T], [ends, np.zeros((4, 4))]])
    return -np.linalg.inv(whole)[-4:, -4:][1:, 1:]


@pytest.mark.parametrize("u", [0.05, 0.17, 0.18, 1.0, 6.0])
def test_stiffness_is_that_of_least_energy(u):
    """Also where the series and the quotient meet, u^2 = 0.03."""
    angle, coupling, warping, both = (float(c) for c in restrained_torsion(1.0, 1 / (4 * u**2), 1.0))
    found = [[angle, coupling, coupling], [coupling, warping, both], [coupling, both, warping]]
    np.testing.assert_allclose(found, least_energy(u), rtol=1e-9)


@pytest.mark.slow
def test_without_warping_rigidity_torsion_is_as_of_a_beam():
    """Also of a rigid beam, of which nothing is given, and with derivatives."""
    assert [float(c) for c in restrained_torsion(2.0, 0.0, 4.0)] == [0.5, 0.0, 0.0, 0.0]
    assert [float(c) for c in restrained_torsion(0.0, 0.0, 4.0)] == [0.0, 0.0, 0.0, 0.0]
    cubic = [float(c) for c in restrained_torsion(0.0, 2.0, 1.0)]
    np.testing.assert_allclose(cubic, [24.0, -12.0, 8.0, 4.0], rtol=1e-14)
    slopes = [jax.grad(lambda g, i=i: restrained_torsion(g, 2.0, 1.0)[i])(0.0) for i in range(4)]
    # Those of the cubic: 36, -3, 4 and -1 thirtieths.
    np.testing.assert_allclose(slopes, np.array([36.0, -3.0, 4.0, -1.0]) / 30, rtol=1e-12)


@pytest.mark.slow
def test_torsional_frequency_of_a_strip_that_is_clamped_at_its_foot():
    """GIt a'' - EIw a'''' = -J w^2 a, a = a' = 0 at the foot, no bimoment nor torque at the tip; error of order two."""
    length, git, eiw, inertia = 0.03, 0.05, 2e-5, 2e-6

    def determinant(frequency):
        root = np.sqrt((git / 2 / eiw) ** 2 + inertia * frequency**2 / eiw)
        a, b = np.sqrt(root + git / 2 / eiw), np.sqrt(root - git / 2 / eiw)
        # cosh(a x) - cos(b x) and sinh(a x)/a - sin(b x)/b are zero with their slopes at the foot.
        ch, sh, c, s = np.cosh(a * length), np.sinh(a * length), np.cos(b * length), np.sin(b * length)
        bimoment = [a**2 * ch + b**2 * c, a * sh + b * s]
        torque = [git * (a * sh + b * s) - eiw * (a**3 * sh - b**3 * s)]
        torque += [git * (ch - c) - eiw * (a**2 * ch + b**2 * c)]
        return bimoment[0] * torque[1] - bimoment[1] * torque[0]

    scale = np.sqrt(git / inertia) / length
    exact: Any = scipy.optimize.brentq(determinant, 0.5 * scale, 5.0 * scale)
    section = fm.Rigidity(1e9, 1e3, 1e3, git, mass=1.0, Jx=inertia, EIw=eiw)
    errors = []
    for beams in (8, 16):
        b = rod([section] * beams, [length / beams] * beams, (True, False))
        for i in range(1, beams + 1):
            b.fix(f"n{i}", "position")
            b.fix(f"n{i}", "l2", "l3")
        for i in range(beams):
            for deformation in (1, 3, 4, 5, 6):
                b.release(f"beam {i}", deformation)
        errors.append(2 * np.pi * float(fm.frequencies(b.build())[0]) / exact - 1)
    assert np.log2(errors[0] / errors[1]) == approx(2, abs=0.1)
    assert (4 * errors[1] - errors[0]) / 3 == approx(0, abs=2e-5)


# -- what shares it, and what holds it --------------------------------------------------------------------------------


@functools.cache
def fold(shared: bool) -> float:
    """Stiffness across the fold at the tip of two strips at a right angle."""
    b = fm.Builder()
    for name, place in {"foot": (0, 0, 0), "corner": (0.1, 0, 0), "tip": (0.1, 0, 0.1)}.items():
        b.node(name, place)
    for leg, (p, q) in enumerate((("foot", "corner"), ("corner", "tip"))):
        ends = [p, q]
        if not shared:
            ends = [p, f"{p}.rotation", b.warping(f"{p} {leg}"), q, f"{q}.rotation", b.warping(f"{q} {leg}")]
        b.add(spatial.warping_beam, *ends, section=LEAF, y=(0, 1, 0))
    b.fix("foot")
    b.inertia("tip", (1e-9, 0, 0, 1e-9, 0, 1e-9))
    return 1 / float(fm.compliance(b.build(), "tip")[1, 1])


def test_fold_shares_its_warping():
    """REFERENCES.md A14-leaf: 63.6993 N/m in solid elements, converged to 0.1 %; without sharing 2.3 % less."""
    assert fold(True) == approx(63.6993, rel=1e-3)
    assert fold(False) == approx(0.977 * 63.6993, rel=1e-3)


def warping_of(model: fm.Model) -> dict[str, str]:
    """Role of each warping; of a free one "free", whether it is a degree of freedom or follows from one."""
    found = zip(model.labels.x, model.roles()[0], strict=True)
    return {
        entry.of.removesuffix(".warping"): "FIXED" if role.name == "FIXED" else "free"
        for entry, role in found
        if entry.kind == "warping"
    }


def beside(element, section=LEAF, place=(0.2, 0, 0), **own):
    def join(b):
        b.node("n2", place)
        b.add(element, "n1", "n2", section=section, y=(0, 1, 0), **own)

    return join


THICK = fm.Rectangle(0.018, 1.5e-3, STEEL)


@pytest.mark.parametrize(
    ("join", "expected"),
    [
        (lambda b: None, {"n1": "free"}),
        (lambda b: b.fix("n1", "rotation"), {"n1": "FIXED"}),
        (lambda b: b.fix("n1.warping"), {"n1": "FIXED"}),
        (lambda b: b.inertia("n1", (1e-6, 0, 0, 1e-6, 0, 1e-6)), {"n1": "FIXED"}),
        (beside(spatial.warping_beam), {"n1": "free", "n2": "free"}),
        (beside(spatial.warping_beam, place=(0.1, 0, 0.1)), {"n1": "free", "n2": "free"}),
        (beside(spatial.warping_beam, THICK), {"n1": "FIXED", "n2": "free"}),
        (beside(spatial.warping_beam, released=()), {"n1": "FIXED", "n2": "FIXED"}),
        (beside(spatial.warping_beam, released=(1, 3, 4, 5, 6)), {"n1": "FIXED", "n2": "FIXED"}),
        (beside(spatial.leaf_spring), {"n1": "free", "n2": "free"}),
        (beside(spatial.beam), {"n1": "free"}),
        (beside(spatial.rigid_beam), {"n1": "FIXED"}),
    ],
    ids=["free", "held", "by name", "inertia", "chain", "fold", "thick", "rigid", "untwisted", "leaf", "beam", "bar"],
)
def test_what_restrains_warping(join, expected):
    b = rod([LEAF], [LENGTH], ())
    join(b)
    assert warping_of(b.build()) == {"n0": "FIXED", **expected}


def test_a_rigid_warping_beam_keeps_flat_what_it_joins():
    """As any rigid part does, though its warping is not among what is FIXED of it."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.1 * i, 0, 0))
    b.add(spatial.leaf_spring, "n0", "n1", name="leaf", section=LEAF, y=(0, 1, 0))
    b.add(spatial.warping_beam, "n1", "n2", section=LEAF, y=(0, 1, 0), released=())
    b.fix("n0")
    model = b.build()
    blocks = zip(model.topology.blocks, model.parameters.properties, strict=True)
    flat = [own["clamped"] for block, own in blocks if block.element.name == "leaf_spring"]
    np.testing.assert_array_equal(flat, [[[1.0, 1.0]]])


def test_sections_by_their_numbers():
    """They have no thickness: alike they are a chain, others must be told apart."""
    section = fm.Rigidity(1e6, 1.0, 50.0, 0.05, EIw=1e-6)
    assert warping_of(rod([section] * 2, [0.05] * 2, ()).build()) == {"n0": "FIXED", "n1": "free", "n2": "free"}
    other = fm.Rigidity(1e6, 1.0, 50.0, 0.06, EIw=1e-6)
    with pytest.raises(fm.ModelError, match=r"'beam 0': whether 'beam 1' clamps its last end.*State it by clamped="):
        rod([section, other], [0.05] * 2, ()).build()


@pytest.mark.slow
def test_a_chain_of_one_traced_section():
    """Which is as thick as itself; slope by the thickness, reverse, beside a central difference of the closed form."""

    def stiffness(thickness):
        section = fm.Rectangle(0.018, thickness, STEEL)
        b = rod([section] * 2, [0.05] * 2, ())
        b.dof("n1.warping", "w")
        b.dof("n2.warping", "w")
        for beam in ("beam 0", "beam 1"):
            b.dof(beam, *range(1, 7))
        return 1 / fm.compliance(b.build(dofs="named"), "n2")[3, 3]

    def closed(thickness):
        own = fm.Rectangle(0.018, thickness, STEEL).rigidity()
        al = LENGTH * float(jnp.sqrt(own.GIt / own.EIw))
        return float(own.GIt) / LENGTH / (1 - np.tanh(al) / al)

    value, slope = jax.value_and_grad(stiffness)(0.5e-3)
    assert float(value) == approx(closed(0.5e-3), rel=1e-10)
    assert float(slope) == approx((closed(0.5e-3 + 1e-8) - closed(0.5e-3 - 1e-8)) / 2e-8, rel=1e-7)


@pytest.mark.slow
def test_a_rod_that_is_free_at_its_foot():
    """What is held there is said by `clamped`, against what would be found."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (LENGTH, 0, 0))
    b.add(spatial.warping_beam, "foot", "tip", section=LEAF, y=(0, 1, 0), clamped=False)
    b.fix("foot")
    assert warping_of(b.build()) == {"foot": "free", "tip": "free"}
    assert twist_stiffness(b, "tip") == approx(TWIST / LENGTH, rel=1e-12)


@pytest.mark.parametrize(
    ("section", "message"),
    [
        (fm.Rectangle(0.018, 0.5e-3, STEEL, warping_length=0.1), "counts restrained warping itself"),
        (fm.Circle(1e-3, STEEL), "without warping rigidity EIw"),
        (fm.Rigidity(EA=1.0, GIt=1.0), "without warping rigidity EIw"),
        (fm.Rigidity(EA=1.0, GIt=1.0, EIw=-1.0), "EIw = -1.0, but it cannot be negative"),
    ],
)
def test_bad_input_is_named(section, message):
    with pytest.raises(fm.ModelError, match=message):
        rod([section], [LENGTH])


def test_warping_in_the_plane_is_refused():
    b = fm.Builder()
    b.node("foot", (0, 0))
    with pytest.raises(fm.ModelError, match="'own' has 1 coordinates, but the mechanism is planar"):
        b.warping("own")


def test_inertia_of_warping():
    """A warping that grows from zero: a third of Jw l0, THEORY.md 3."""
    section = fm.Rigidity(1e6, 1.0, 50.0, 0.05, EIw=1e-6, Jw=3e-9)
    b = rod([section], [LENGTH], (True, False))
    b.fix("n1")
    b.dof("n1.warping", "w")
    lin = fm.linearize(b.build())
    np.testing.assert_allclose(lin.matrices.M0, [[3e-9 * LENGTH / 3]], rtol=1e-12)
    t = jnp.tanh(u := LENGTH / 2 * np.sqrt(0.05 / 1e-6)) / u
    expected = 0.05 * LENGTH * (t / 2 + (1 - t) / (2 * u**2 * t)) / (2 * (1 - t))
    np.testing.assert_allclose(lin.matrices.K0, [[float(expected)]], rtol=1e-12)
