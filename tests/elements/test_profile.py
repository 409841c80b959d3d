"""Sections that vary along a spectral beam, against shooting and closed forms."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
from cases.tolerances import approx
from references import notches
from references.varying_rods import CASES, CUT, TIPS, WIDTH

import flexmb as fm
from flexmb import planar, sections, spatial
from flexmb.plot.geometry import lines

STEEL = fm.Material(210e9, 80e9, 7850.0)


def leaf(thickness):
    return fm.Rectangle(WIDTH, thickness, STEEL)


SECTIONS = {
    "taper": sections.taper(leaf(5e-4), leaf(3e-4)),
    "reinforced": sections.stepped([leaf(5e-4), leaf(5e-3), leaf(5e-4)], (0.2, 0.8)),
    "notch": sections.notch_circular(WIDTH, 5e-3, 3e-4, 5e-3, STEEL),
}


def cantilever(element, section, end, force=None, **properties):
    b = fm.Builder()
    b.node("foot", (0.0,) * len(end))
    b.node("tip", end)
    b.fix("foot")
    across = {"y": (0, 1, 0)} if len(end) == 3 else {}
    b.add(element, "foot", "tip", name="leaf", section=section, **across, **properties)
    if force is not None:
        b.force("tip", force)
    return b


@pytest.mark.slow("reinforced-False-4-5e-05")
@pytest.mark.parametrize(
    ("case", "plane", "order", "error"),
    [
        # Bounds on the distance over the length: twice what was seen; other orders below.
        ("notch", True, 2, 1.2e-7),
        ("reinforced", False, 4, 5e-5),
    ],
)
def test_large_deflection_against_shooting(case, plane, order, error):
    _, length, _, force = CASES[case]
    end, force = (np.array([length, 0, 0]), np.array(force))
    element, axes = (planar.spectral_beam, [0, 2]) if plane else (spatial.spectral_beam, [0, 1, 2])
    found = fm.equilibrium(cantilever(element(order), SECTIONS[case], tuple(end[axes]), tuple(force[axes])).build())
    np.testing.assert_allclose(found.at("tip"), np.array(TIPS[case, plane])[axes], rtol=0, atol=error * length)


# Distances of the tip over the length, of the plane and of space, of orders 2, 4, 6, 8.
DISTANCES = {
    "taper": ([2.6e-4, 2.8e-6, 8.7e-11, 2.9e-12], [1.6e-3, 4.1e-6, 4.3e-8, 8.1e-10]),
    "reinforced": ([7.7e-6, 5.0e-8, 2.9e-8, 5.0e-9], [2.1e-3, 2.2e-5, 5.5e-6, 2.5e-6]),
    "notch": ([4.8e-8, 2.6e-9, 1.7e-9, 1.1e-9], [4.7e-6, 1.8e-6, 1.2e-6, 9.3e-7]),
}


@pytest.mark.slow("True-4", "True-6", "True-8", "False-2", "False-4", "False-6", "False-8")
@pytest.mark.parametrize("order", [2, 4, 6, 8])
@pytest.mark.parametrize("plane", [True, False])
def test_convergence_with_the_order_against_shooting(plane, order):
    """All three sections at once: what the elements' own functions make of the least potential of the coefficients.

    Against TIPS. The error of the taper falls exponentially. Where rigidities jump by a thousand, or a notch is deep,
    what bends is short, the resultants are nearly linear in it, and few coefficients do.
    """
    element = (planar.spectral_beam if plane else spatial.spectral_beam)(order)
    axes, closure, fields = ([0, 2], 3, 2) if plane else ([0, 1, 2], 6, 4)
    n, still = fields * order, jnp.zeros(len(axes))
    turned = jnp.zeros(1) if plane else jnp.array([1.0, 0, 0, 0])
    lengths, forces = (np.array([case[i] for case in CASES.values()]) for i in (1, 3))
    # Of three pieces at most; where there are fewer a break does nothing.
    breaks = np.array([(*case[2], *(0.97, 0.98, 0.99))[:3] for case in CASES.values()])
    breaks = np.sort(breaks, axis=1)

    def thickness(place):
        x = jnp.where(abs(place - 0.5) < CUT, (place - 0.5) * CASES["notch"][1], 0.0)
        bar = jnp.where(abs(place - 0.5) < CUT, 3e-4 + 2 * (5e-3 - jnp.sqrt(25e-6 - x**2)), 5e-3)
        return jnp.stack([5e-4 - 2e-4 * place, jnp.where((place > 0.2) & (place < 0.8), 5e-3, 5e-4), bar])

    @fm.jit
    @jax.vmap
    def unbalanced(case, breaks, length, force, c):
        section = sections.Profile(lambda place: leaf(thickness(place)[case]), tuple(breaks))
        ref = element.reference((still, turned, still.at[0].set(length), turned, jnp.zeros(n)))
        own: dict[str, Any] = {"ref": ref, "section": section, "order": order} | {"shear": False}
        across = {} if plane else {"y": jnp.array([0.0, 1, 0])}

        def tip(c):
            # The closure is what the nodes are apart, here nothing, less where the series puts the last end.
            return -element.deformation(still, turned, still, turned, c, **own, **across)[: len(axes)]

        at, pulled = jax.vjp(tip, c)
        return element.stiffness(**own)[closure:, closure:] @ c - pulled(force)[0], at

    c, tips, cases = np.zeros((3, n)), np.zeros((3, 1, len(axes))), np.repeat(np.arange(3), 2 * n + 1)
    near = 1e-6 * np.concatenate([np.zeros((1, n)), np.eye(n), -np.eye(n)])
    for share in (0.5, 0.5, 0.5, *[1.0] * 5):
        points = (c[:, None] + near).reshape(-1, n)
        found = unbalanced(cases, breaks[cases], lengths[cases], share * forces[cases][:, axes], points)
        slopes, tips = (np.asarray(one).reshape(3, 2 * n + 1, -1) for one in found)
        tangents = (slopes[:, 1 : n + 1] - slopes[:, n + 1 :]) / 2e-6
        c = c - np.linalg.solve(tangents, slopes[:, 0, :, None])[:, :, 0]
    for i, (case, distances) in enumerate(DISTANCES.items()):
        away = np.linalg.norm(tips[i, 0] - np.array(TIPS[case, plane])[axes]) / lengths[i]
        assert away == approx(distances[not plane][order // 2 - 1], rel=0.5)


@pytest.mark.slow
def test_natural_frequencies_of_a_wedge():
    # Thickness halved towards the tip: omega sqrt(rho A L^4/(E I)) of the foot are 3.82378, 18.3173, 47.2648
    # (Euler-Bernoulli; Downs 1977, and solve_ivp of the equation).
    def thin(place):
        return fm.Rectangle(0.01, 1e-3 * (1 - 0.5 * place), STEEL, rotary=False)

    found = fm.frequencies(cantilever(planar.spectral_beam(8), sections.Profile(thin), (0.5, 0)).build())[:3]
    foot = thin(0.0).rigidity()
    unit = np.sqrt(foot.EIy / foot.mass) / 0.5**2 / (2 * np.pi)
    np.testing.assert_allclose(found / unit, [3.823784847, 18.317260904, 47.264827010], rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("space", [False, True])
def test_compliance_of_a_circular_notch(space):
    # A full half circle of radius R, a neck t, in a beam just as long: closed form of Wu and Zhou (2002), Review of
    # Scientific Instruments 73, 3101, of the integral of Paros and Weisbord (1965). The vertical slope at its ends
    # costs 5e-7.
    width, t, r = 0.01, 5e-4, 3e-3
    s = r / t
    first = 2 * s**3 * (6 * s**2 + 4 * s + 1) / ((2 * s + 1) * (4 * s + 1) ** 2)
    second = 12 * s**4 * (2 * s + 1) / (4 * s + 1) ** 2.5 * np.arctan(np.sqrt(4 * s + 1))
    expected = 12 / (210e9 * width * r**2) * (first + second)

    notch = section = sections.notch_circular(width, t + 2 * r, t, r, STEEL)
    element, end, moment = planar.spectral_beam(3), (2 * r, 0), 1e-3
    if space:
        # With shear, which a moment does not feel.
        element, end, moment = spatial.spectral_beam(3, shear=True), (2 * r, 0, 0), (0, 1e-3, 0)

        def shearing(place, length):
            at: Any = notch.at(place, length)
            return fm.Rectangle(width, at.thickness, STEEL, shear=True)

        section = sections.Profile(shearing, notch.breaks_at)
    b = cantilever(element, section, end)
    b.moment("tip", moment)
    found = fm.equilibrium(b.build()).at("tip.rotation")
    angle = 2 * found[2] if space else found[0]
    assert angle / 1e-3 == approx(expected, rel=1e-6)


HINGES = {
    # Function of sections, its sizes, length and closed form; the bar beyond the notch is as high as its shoulders.
    "circular": (sections.notch_circular, (5e-3, 3e-4, 5e-3), notches.circular, (3e-4, 5e-3, 5e-3)),
    "elliptic": (sections.notch_elliptic, (4e-3, 3e-4, 6e-3, 2e-3), notches.elliptic, (3e-4, 4e-3, 6e-3, 2e-3)),
    "filleted": (sections.notch_filleted, (2.3e-3, 3e-4, 8e-3, 1e-3), notches.filleted, (3e-4, 8e-3, 1e-3)),
}


@pytest.mark.slow("circular")
@pytest.mark.parametrize("hinge", HINGES)
def test_compliance_of_notch_hinges(hinge):
    """REFERENCES.md A13: Paros and Weisbord (1965); Smith and others (1997); steep shoulders cost 1e-6."""
    function, sizes, closed, numbers = HINGES[hinge]
    width, bar, element = 0.01, 0.02, planar.spectral_beam(2)
    section = function(width, *sizes, STEEL)
    still = jnp.zeros(2)
    ref = element.reference((still, jnp.zeros(1), still.at[0].set(bar), jnp.zeros(1), jnp.zeros(4)))
    stiffness = jax.jit(lambda section: element.stiffness(ref=ref, section=section, order=2, shear=False))(section)
    notch = [float(b) for b in section.breaks_at(bar)]
    beyond = bar * (1 - (notch[-1] - notch[0])) * 12 / (210e9 * width * sizes[0] ** 3)
    # The first coefficient of the curvature is the angle between the ends; the others follow without a moment.
    found = np.linalg.inv(stiffness[3:, 3:])[2, 2]
    assert found - beyond == approx(closed(210e9, width, *numbers), rel=1e-5)
    if hinge == "circular":
        # REFERENCES.md G4: solid elements, whose neck is wide and so partly a plate, nu = 0.3.
        assert 1 / found < 3.49265 < 1 / found / (1 - 0.3**2)
        assert 1 / found == approx(3.49265, rel=0.06)


@pytest.mark.slow
def test_derivatives_by_every_dimension():
    def height(d):
        b = cantilever(
            planar.spectral_beam(3), sections.notch_filleted(0.01, d[0], d[1], d[2], d[3], STEEL), (0.03, 0), (0.0, 3.0)
        )
        return fm.equilibrium(b.build()).at("tip")[1]

    # Height of the bar, neck, flat length, radius of the roundings.
    d = jnp.array([5e-3, 4e-4, 8e-3, 1e-3])
    step = 1e-5 * d
    differences = [
        (height(d + step * e) - height(d - step * e)) / (2 * s) for e, s in zip(np.eye(4), step, strict=True)
    ]
    # Central differences of relative step 1e-5: their truncation is 1e-9, their round-off 1e-7 of the terms.
    np.testing.assert_allclose(jax.grad(height)(d), differences, rtol=1e-6)
    np.testing.assert_allclose(jax.jacfwd(height)(d), differences, rtol=1e-6)


@pytest.mark.slow
def test_stress_and_resultants_follow_the_section():
    # A taper that hangs: at each place the weight beyond it, and the force at its end bends it.
    section = sections.taper(fm.Rectangle(0.01, 2e-3, STEEL), fm.Rectangle(0.01, 1e-3, STEEL))
    b = cantilever(planar.spectral_beam(3), section, (0.1, 0), (0.0, 0.02))
    b.gravity((9.81, 0))
    model = b.build()
    found = fm.stress(model, points=5)
    place = np.linspace(0, 1, 5)
    thickness = 2e-3 - 1e-3 * place
    mass = 7850 * 0.01 * 0.1 * (2e-3 * (1 - place) - 1e-3 * (1 - place**2) / 2)
    moment = 0.02 * 0.1 * (1 - place)
    # The deflection of 12 um turns the weight by 2e-4.
    np.testing.assert_allclose(found.resultants.values[0, :, 0], 9.81 * mass, rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(abs(found.resultants.values[0, :, 4]), moment, rtol=2e-3, atol=1e-9)
    bending = 6 * moment / (0.01 * thickness**2) + 9.81 * mass / (0.01 * thickness)
    np.testing.assert_allclose(np.max(abs(found.sigma_x[0]), axis=1), bending, rtol=2e-3, atol=1)
    # All of it stands on the foot.
    assert float(fm.mass(model)) == approx(7850 * 0.01 * 0.1 * 1.5e-3, rel=1e-12)


@pytest.mark.slow
def test_different_sections_stand_side_by_side():
    # Between one foot and one tip stiffnesses add up, whatever is stacked with what.
    def stiffness(*leaves):
        b = fm.Builder()
        b.node("foot", (0, 0))
        b.node("tip", (0.1, 0))
        b.fix("foot")
        for i, section in enumerate(leaves):
            b.add(planar.spectral_beam(2), "foot", "tip", name=f"leaf {i}", section=section)
        return np.linalg.inv(fm.compliance(b.build(), "tip"))

    leaves = [sections.taper(leaf(6e-4), leaf(5e-4)), leaf(5e-4), sections.taper(leaf(4e-4), leaf(3e-4))]
    np.testing.assert_allclose(stiffness(*leaves), sum(stiffness(one) for one in leaves), rtol=1e-9)


@pytest.mark.slow("True")
@pytest.mark.parametrize("space", [False, True])
def test_shape_of_a_stepped_cantilever_under_a_moment(space):
    # Closed form: slopes and deflections of three pieces, each an arc of small curvature M/EI.
    thickness, ends, moment = (5e-4, 5e-3, 3e-4), (0.0, 0.2, 0.7, 1.0), 1e-6
    section = sections.stepped([leaf(t) for t in thickness], ends[1:-1])
    element, end = (spatial.spectral_beam(2), (0.1, 0, 0)) if space else (planar.spectral_beam(2), (0.1, 0))
    b = cantilever(element, section, end)
    b.moment("tip", (0, -moment, 0) if space else moment)
    model = b.build()
    (line,) = lines(model, np.asarray(fm.equilibrium(model).x))
    expected = np.zeros(len(line.points))
    for t, first, last in zip(thickness, ends[:-1], ends[1:], strict=True):
        inside = np.clip(line.points[:, 0] / 0.1, first, last) - first
        beyond = line.points[:, 0] / 0.1 - first - inside
        expected += moment * 0.1**2 / leaf(t).rigidity().EIy * (inside**2 / 2 + inside * np.maximum(beyond, 0))
    np.testing.assert_allclose(line.points[:, -1], expected, rtol=1e-5, atol=1e-13)


@pytest.mark.slow
def test_a_profile_that_does_not_vary_is_the_plain_beam():
    # By the closed form of its matrices, THEORY.md 2, eq. (2.15), which the plain beam has.
    damping = fm.Damping(EA=2.0, EIy=3e-4, EIz=0.4, GIt=5e-4)
    plain = leaf(5e-4)
    for element, end in ((planar.spectral_beam(3), (0.1, 0)), (spatial.spectral_beam(3), (0.1, 0, 0))):
        one, other = (
            fm.linearize(cantilever(element, section, end, damping=damping).build())
            for section in (plain, sections.stepped([plain, plain], (0.3,)))
        )
        for name in ("M0", "D0", "K0"):
            own = getattr(one, name)
            np.testing.assert_allclose(getattr(other, name), own, rtol=0, atol=1e-9 * np.max(np.abs(own)), err_msg=name)


FAULTS = {
    "zero": (lambda s: leaf(5e-4 * (1 - 2 * s)), (), "thickness = 0.0, .*at place 0.5"),
    "no number": (lambda s: leaf(jnp.sqrt(s - 0.5)), (), "thickness = nan, .*at place 0"),
    "break": (lambda s: leaf(5e-4), (0.5, 1.5), "breaks at 0.5, 1.5.*between 0 and 1"),
    "jump": (lambda s: leaf(jnp.where(s > 0.4, 5e-4, 3e-4)), (), "not smooth between its breaks"),
    # As wide as before in the mean, and as heavy: nine nodes miss a wave of its density.
    "heavy": (
        lambda s: fm.Rectangle(0.02, 5e-4, fm.Material(E=2e11, G=8e10, rho=8000 * (1 + 0.9 * jnp.sin(40 * s)))),
        (),
        "a mass along its section that is not smooth between its breaks",
    ),
    # It bends about its other axis alone.
    "wide": (
        lambda s: fm.Rigidity(EA=1e6, EIy=1.0, EIz=jnp.where(s > 0.4, 10.0, 1.0), GIt=1.0, mass=1.0),
        (),
        "a section that is not smooth between its breaks",
    ),
    # Between the nodes of the quadrature.
    "groove": (
        lambda s: leaf(5e-4 * (1 - 0.8 * jnp.exp(-(((s - 0.3) / 0.005) ** 2)))),
        (),
        "a section that is not smooth between its breaks: name the places where it jumps or bends sharply in `breaks`",
    ),
    "order": (lambda s: leaf(5e-4), (0.6, 0.4), "breaks at 0.6, 0.4.*in order"),
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("space", [False, True])
def test_a_faulty_profile_is_refused_by_name(fault, space):
    function, breaks, message = FAULTS[fault]
    element, end = (spatial.spectral_beam, (0.1, 0, 0)) if space else (planar.spectral_beam, (0.1, 0))
    with pytest.raises(fm.ModelError, match=f"'leaf'.*{message}"):
        cantilever(element, sections.Profile(function, breaks), end).build()


@pytest.mark.slow("5-breaks1")
@pytest.mark.parametrize(("order", "breaks"), [(10, ()), (5, (0.3, 0.37, 0.45))])
def test_a_smooth_groove_bends_as_its_compliances_say(order, breaks):
    """Tip of a cantilever by SciPy's quadrature; refused until the order, or breaks, see the groove."""

    def thickness(s, xp):
        return 5e-4 * (1 - 0.3 * xp.exp(-(((s - 0.37) / 0.1) ** 2)))

    def tip(order, breaks=()):
        groove = sections.Profile(lambda s: leaf(thickness(s, jnp)), breaks)
        b = cantilever(planar.spectral_beam, groove, (0.1, 0), (0, 1e-4), order=order)
        return float(fm.equilibrium(b.build()).at("tip")[1])

    share = scipy.integrate.quad(lambda s: (1 - s) ** 2 * (5e-4 / thickness(s, np)) ** 3, 0, 1, points=(0.37,))[0]
    # What a section may be off by before it is refused.
    exact = approx(1e-4 * 0.1**3 * share / (210e9 * WIDTH * 5e-4**3 / 12), rel=1e-3)
    with pytest.raises(fm.ModelError, match="take a higher order, or divide"):
        tip(5)
    assert tip(order, breaks) == exact


def test_what_is_no_profile_is_refused():
    with pytest.raises(fm.ModelError, match="must take a place"):
        sections.Profile(lambda: leaf(1e-3))
    for diameter in (0.0, -1e-3):
        nothing = sections.Profile(lambda s, d=diameter: fm.Circle(d + 0.0 * s, STEEL))
        with pytest.raises(fm.ModelError, match=r"'leaf' has a section with diameter = .* positive, at place 0"):
            cantilever(spatial.spectral_beam, nothing, (0.1, 0.0, 0.0))
    with pytest.raises(fm.ModelError, match="has a section with EA = 0 at place"):
        cantilever(spatial.spectral_beam, sections.Profile(lambda s: fm.Rigidity(EIy=1.0 + s)), (0.1, 0.0, 0.0))
    with pytest.raises(fm.ModelError, match="must return a section"):
        sections.Profile(lambda s: 5e-4 * s)
    with pytest.raises(fm.ModelError, match=r"entry of shape \(2,\)"):
        sections.Profile(lambda s: leaf(jnp.stack([s, s])))
    with pytest.raises(fm.ModelError, match="one kind"):
        sections.taper(leaf(5e-4), fm.Circle(5e-4, STEEL))
    with pytest.raises(fm.ModelError, match="3 pieces has one break fewer, not 1"):
        sections.stepped([leaf(5e-4)] * 3, (0.5,))
    with pytest.raises(ValueError, match=r"neck.*smaller than the height"):
        sections.notch_circular(0.01, 1e-3, 2e-3, 5e-3, STEEL)
    with pytest.raises(ValueError, match=r"radius.*at most"):
        sections.notch_filleted(0.01, 2e-3, 1e-3, 5e-3, 5e-3, STEEL)
    with pytest.raises(ValueError, match="at least this depth"):
        sections.notch_elliptic(0.01, 2e-3, 1e-3, 5e-3, 1e-4, STEEL)


@pytest.mark.parametrize("element", [planar.beam, planar.truss])
def test_other_elements_refuse_a_profile(element):
    with pytest.raises(fm.ModelError, match=r"'leaf'.*for spectral beams"):
        cantilever(element, SECTIONS["taper"], (0.1, 0)).build()


@pytest.mark.slow
def test_a_notch_longer_than_its_beam_is_refused():
    with pytest.raises(fm.ModelError, match="breaks at -"):
        cantilever(planar.spectral_beam, SECTIONS["notch"], (0.5 * CUT * 0.03, 0)).build()
