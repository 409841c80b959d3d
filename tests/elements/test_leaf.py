"""Leaf springs beside solid finite elements and closed forms; which of their ends are clamped."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.strip_section import energy_of_section
from cases.tolerances import approx
from numpy.polynomial import polynomial

import flexmb as fm
from flexmb import planar, spatial
from flexmb.build.clamps import End, as_before
from flexmb.elements.bent_strip import curving
from flexmb.elements.leaf import Leaf, flags_and_distances

STEEL = fm.Material(E=210e9, G=210e9 / 2.6, rho=7850.0, alpha=11.5e-6)
LEAF = fm.Rectangle(0.018, 0.5e-3, STEEL)


def strip(width=0.018, thickness=0.5e-3):
    """A leaf spring of 100 mm with a clamped foot and a rigid tip."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.1, 0, 0))
    section = fm.Rectangle(width, thickness, STEEL)
    b.add(spatial.leaf_spring, "foot", "tip", name="leaf", section=section, y=(0, 1, 0), clamped=True)
    b.fix("foot")
    return b


def guide(stroke: float) -> fm.Model:
    b = fm.Builder()
    b.node("stage", (0.1, 0, 0.05))
    for i, z in enumerate((0.0, 0.1)):
        b.node(f"foot {i}", (0, 0, z))
        b.node(f"top {i}", (0.1, 0, z))
        nodes = f"foot {i}", f"foot {i}.rotation", f"top {i}", "stage.rotation"
        b.add(spatial.leaf_spring, *nodes, name=f"leaf {i}", section=LEAF, y=(0, 1, 0))
        b.add(spatial.rigid_beam, "stage", "stage.rotation", f"top {i}")
        b.fix(f"foot {i}")
    b.prescribe("stage", "z", stroke)
    return b.build()


# Of the tip along and about x, y and z, all else free; then along y and z with the rotations held.
SOLID = {
    0.018: (1.89889e7, 149883, 120.295, 0.652317, 0.398978, 511.44, 560628, 488.542),
    0.05: (5.31648e7, 2.77923e6, 342.896, 2.20741, 1.13484, 11000.2, 7.54473e6, 1401.76),
}


@pytest.mark.slow
@pytest.mark.parametrize(("width", "tolerance"), [(0.018, 0.002), (0.05, 0.01)])
def test_tip_of_a_strip_beside_solid_elements(width, tolerance):
    """REFERENCES.md A14-leaf; largest deviations 0.11 and 0.73 %."""
    flexible = np.asarray(fm.compliance(strip(width).build(), "tip"))
    stiff = np.linalg.inv(flexible)
    found = [*1 / np.diag(flexible), stiff[1, 1], stiff[2, 2]]
    np.testing.assert_allclose(found, SOLID[width], rtol=tolerance)


@pytest.mark.slow
def test_guide_at_a_stroke_beside_solid_elements():
    """REFERENCES.md A14-leaf: force of the drive, stiffness along x, y and about x, y, z at 10 mm."""
    at = fm.linearize(guide(0.01))
    force = next(
        float(np.asarray(at.matrices.reactions)[i])
        for i, entry in enumerate(at.labels.x)
        if (entry.of, entry.component) == ("stage", 3)
    )
    flexible = np.diag(np.asarray(fm.compliance(at, "stage")))
    found = [force, *1 / flexible[[0, 1, 3, 4, 5]]]
    np.testing.assert_allclose(found, [9.937, 4.79616e6, 127955, 963.778, 11989.7, 470.742], rtol=0.016)


@pytest.mark.slow
def test_fold_beside_solid_elements():
    """REFERENCES.md A14-leaf: two legs at a right angle; twist is shared across the fold."""
    b = fm.Builder()
    for name, place in {"foot": (0, 0, 0), "corner": (0.1, 0, 0), "tip": (0.1, 0, 0.1)}.items():
        b.node(name, place)
    b.add(spatial.leaf_spring, "foot", "corner", name="first", section=LEAF, y=(0, 1, 0))
    b.add(spatial.leaf_spring, "corner", "tip", name="last", section=LEAF, y=(0, 1, 0))
    b.fix("foot")
    b.inertia("tip", (1e-9, 0, 0, 1e-9, 0, 1e-9))
    flexible = 1 / np.diag(np.asarray(fm.compliance(b.build(), "tip")))
    np.testing.assert_allclose(flexible, [29.9939, 63.6993, 120.292, 0.636736, 0.199637, 0.636737], rtol=0.002)


@pytest.mark.slow
def test_twist_of_a_strip_that_cannot_warp():
    """Closed form (2.10) with the plate's modulus and the warping constant of (2.57): exact for a constant torque."""
    it = LEAF.rigidity().GIt / STEEL.shear_modulus()
    warping = STEEL.E / (1 - 0.3**2) * (0.018 * 0.5e-3) ** 3 / 144 / (1 + 12 * (0.5 / 18) ** 2)
    al = 0.1 / np.sqrt(warping / (STEEL.shear_modulus() * float(it)))
    expected = 0.1 / (STEEL.shear_modulus() * float(it)) * (1 - 2 * np.tanh(al / 2) / al)
    assert np.asarray(fm.compliance(strip().build(), "tip"))[3, 3] == approx(expected, rel=1e-9)


def bent_wide_strip(u: float, nu: float) -> tuple[float, float]:
    """Energy of a bent plate with free edges over that of a flat one, by Ritz's method with even polynomials.

    Over y from -1 to 1, with bending stiffness and curvature 1: curvature across z'' + nu, fibres strained by -z. Also
    the second moment of the stress of these strains.
    """
    foundation = 4 * (u / 2) ** 4
    shapes = [np.eye(2 * k + 1)[-1] for k in range(14)]
    slopes = [polynomial.polyder(shape, 2) for shape in shapes]

    def integral(p):
        whole = polynomial.polyint(p)
        return polynomial.polyval(1.0, whole) - polynomial.polyval(-1.0, whole)

    matrix = np.array(
        [
            [
                integral(polynomial.polymul(slopes[i], slopes[j]))
                + foundation * integral(polynomial.polymul(shapes[i], shapes[j]))
                for j in range(14)
            ]
            for i in range(14)
        ]
    )
    right = -nu * np.array([integral(slope) for slope in slopes])
    found = np.linalg.lstsq(matrix, right, rcond=1e-14)[0]
    stress = [-foundation * integral(polynomial.polymul(shape, [0, 0, 1])) for shape in shapes]
    return float(1 + nu * np.array([integral(s) for s in slopes]) @ found / 2), float(np.array(stress) @ found)


@pytest.mark.parametrize("u", [0.3, 1.5, 4.0, 8.0])
def test_flattening_of_a_wide_strip(u):
    """A plate by Ritz's method, 1e-7: its energy, and the second moment of its stress, (2.23) and (2.30)."""
    keeps, (energy, moment) = float(curving(jnp.array(u**4))), bent_wide_strip(u, 0.3)
    assert 1 - 0.09 * keeps == approx(energy, rel=1e-7)
    assert 2 * 0.3 * 2 * (1 - keeps) == approx(moment, rel=1e-6)


def test_energy_of_the_section_of_a_strip():
    """Constant curvatures, stretch and twist beside Ritz's method over the width; of third order."""
    leaf, names = Leaf(LEAF, jnp.zeros(2)), ("EA", "GIt", "EIy", "EIz")
    kappa, twist, stretch, sideways, length = 20.0, 15.0, 1e-4, 0.3, 0.1
    c = jnp.array([stretch, 0, 0, 0, kappa, 0, sideways, 0, twist, twist]) * length
    c = c.at[2].set(twist * length)

    @jax.jit
    def energy_and_hessian(c):
        def energy(c):
            return leaf.energy(2, c, length, names)

        return energy(c), jax.hessian(energy)(c)

    found, _ = energy_and_hessian(c)
    expected = energy_of_section(LEAF, 0.0, kappa, twist**2, stretch, sideways)
    assert float(found) == approx(length * expected, rel=1e-8)
    _, rest = energy_and_hessian(jnp.zeros(10))
    # Zero but for the rounding of a quantity of size 1.
    assert np.max(np.abs(np.asarray(rest))) < 1e-13 * float(LEAF.rigidity().EIy) / length


def divided(places, width=0.03, thickness=0.3e-3, guided=False) -> fm.Model:
    """A planar leaf spring of several pieces, clamped at its foot, and at its tip if that is guided."""
    b = fm.Builder()
    for i, place in enumerate(places):
        b.node(f"n{i}", place)
    section = fm.Rectangle(width, thickness, STEEL)
    for i in range(len(places) - 1):
        b.add(planar.leaf_spring, f"n{i}", f"n{i + 1}", name=f"piece {i}", section=section)
    b.fix("n0")
    if guided:
        b.fix(f"n{len(places) - 1}", "rotation")
    return b.build()


def tip_compliance(model: fm.Model) -> np.ndarray:
    """Of the displacements and the rotation of the last node."""
    return np.diag(np.asarray(fm.compliance(model, model.labels.elements[-1][2][2])))


@pytest.mark.slow("0.03-False")
@pytest.mark.parametrize("guided", [False, True])
@pytest.mark.parametrize("length", [0.03, 0.01])
def test_a_divided_leaf_spring_is_as_one_piece(guided, length):
    """Pieces shorter than a clamp reaches, also where clamps reach over the whole leaf spring."""
    whole = tip_compliance(divided([(0, 0), (length, 0)], guided=guided))
    places = [(length * s, 0) for s in (0, 0.05, 0.15, 0.3, 0.62, 0.8, 1.0)]
    np.testing.assert_allclose(tip_compliance(divided(places, guided=guided)), whole, rtol=1e-9, atol=1e-15)


def test_a_clamp_reaches_over_the_whole_of_a_short_leaf_spring():
    """Clamped at one end, a leaf spring of 0.3 widths bends as a plate all over; at both, each clamp has half of it."""
    for guided in (False, True):
        model = divided([(0, 0), (0.009, 0)], guided=guided)
        plate = (
            0.009**3 / (12 if guided else 3) * (1 - 0.3**2) / float(fm.Rectangle(0.03, 0.3e-3, STEEL).rigidity().EIy)
        )
        assert tip_compliance(model)[1] == approx(plate, rel=1e-9)


def test_small_angles_are_in_line_and_folds_are_not():
    """Of two pieces that are half as long as a clamp reaches, clamped at the first."""
    for angle, flat in ((4.9, [[1.0, 0.0], [0.006, 0.0]]), (5.1, [1.0, 0.0])):
        turn = np.radians(angle)
        end = (0.006 + 0.006 * np.cos(turn), 0.006 * np.sin(turn))
        (properties,) = divided([(0, 0), (0.006, 0), end]).parameters.properties
        np.testing.assert_allclose(properties["clamped"][1], flat, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("pieces", [1, 4, 10])
def test_divided_leaf_spring_beside_solid_elements(pieces):
    """30 x 30 x 0.3 mm with a rigid tip, C3D20R: largest deviation 1.1 %, and 6 % where clamps end with their piece."""
    b = fm.Builder()
    for i in range(pieces + 1):
        b.node(f"n{i}", (0.03 * i / pieces, 0, 0))
    section = fm.Rectangle(0.03, 0.3e-3, STEEL)
    for i in range(pieces):
        b.add(spatial.leaf_spring, f"n{i}", f"n{i + 1}", section=section, y=(0, 1, 0))
    b.fix("n0")
    b.inertia(f"n{pieces}", (1e-9, 0, 0, 1e-9, 0, 1e-9))
    found = 1 / np.diag(np.asarray(fm.compliance(b.build(), f"n{pieces}")))
    np.testing.assert_allclose(found, [6.4659e7, 9.1118e6, 1687.37, 1.36672, 0.503617, 4779.91], rtol=0.0125)


@pytest.mark.slow
def test_a_leaf_spring_cut_near_its_clamp_twists_far_as_one_piece():
    """In the first piece, as long as its twist takes to build up, the decaying functions are nearly polynomials."""

    def turn(places):
        b = fm.Builder()
        for i, place in enumerate(places):
            b.node(f"n{i}", (place, 0, 0))
        section = fm.Rectangle(0.02, 0.5e-3, STEEL)
        for i in range(len(places) - 1):
            b.add(spatial.leaf_spring, f"n{i}", f"n{i + 1}", section=section, y=(0, 1, 0), order=7)
        b.fix("n0")
        b.moment(f"n{len(places) - 1}", (0.5, 0, 0))
        found = fm.equilibrium(b.build())
        assert found.iterations < 15
        return np.asarray(found.rotation(f"n{len(places) - 1}"))

    # A tenth of the 0.5 % that a division may change.
    np.testing.assert_allclose(turn([0, 0.005, 0.1]), turn([0, 0.1]), rtol=5e-4, atol=1e-12)


@pytest.mark.parametrize("order", [3, 6, 8])
def test_strains_of_twist_of_a_short_piece_are_independent(order):
    """Beside polynomials of the same degree, functions that decay over a longer distance are polynomials themselves."""
    leaf = Leaf(fm.Rectangle(0.02, 0.5e-3, STEEL), *flags_and_distances(jnp.array([1.0, 0.0])))
    places = np.polynomial.legendre.leggauss(20)[0] / 2 + 0.5
    sizes = np.linalg.svd(np.asarray(leaf.twist(order, places, 0.005)))[1]
    # A part of 1e-3 remains of a decaying function, and eight polynomials share it: a hundredth of 1e-3.
    assert sizes[-1] > 1e-5 * sizes[0]
    # Long leaf springs keep the exact functions.
    np.testing.assert_array_equal(leaf._fading_over(order, 0.1), leaf.layers(0.1))


@pytest.mark.slow
def test_one_coefficient_bends_under_a_moment():
    """Constant curvature is exact: M/EIy, and (1 - nu^2) M/EIy within 0.40 widths of the clamp (THEORY (2.22))."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.1, 0, 0))
    b.add(spatial.leaf_spring(order=1), "foot", "tip", section=fm.Rectangle(0.02, 0.5e-3, STEEL), y=(0, 1, 0))
    b.fix("foot")
    b.moment("tip", (0, 1e-5, 0))
    bending = 210e9 * 0.02 * 0.5e-3**3 / 12
    found = fm.equilibrium(b.build()).rotation("tip")[1]
    # The strip flattens with the square of its curvature.
    assert float(found) == approx(1e-5 * (0.1 - 0.3**2 * 0.4 * 0.02) / bending, rel=1e-6)


@pytest.mark.slow
def test_derivatives_of_a_divided_leaf_spring():
    """By its width, thickness and the place where it is divided: that changes nothing."""

    def answer(sizes):
        b = fm.Builder()
        for i, x in enumerate((0.0, sizes[2], 0.03)):
            b.node(f"n{i}", (x, 0))
        section = fm.Rectangle(sizes[0], sizes[1], STEEL)
        for i, clamped in enumerate(((True, False), (False, False))):
            b.add(planar.leaf_spring, f"n{i}", f"n{i + 1}", name=f"piece {i}", section=section, clamped=clamped)
        b.fix("n0")
        return 1e3 * fm.compliance(b.build(dofs=labels), "n2")[1, 1]

    sizes = jnp.array([0.03, 0.3e-3, 0.005])
    labels = divided([(0, 0), (0.005, 0), (0.03, 0)]).q_labels
    forward, reverse = jax.jacfwd(answer)(sizes), jax.jacrev(answer)(sizes)
    steps = np.diag([1e-6, 1e-8, 1e-6])
    slopes = [float(answer(sizes + step) - answer(sizes - step)) / (2 * step.sum()) for step in steps]
    np.testing.assert_allclose(forward, slopes, rtol=1e-5, atol=1e-6 * abs(slopes[0]))
    np.testing.assert_allclose(forward, reverse, rtol=1e-8, atol=1e-9 * abs(slopes[0]))


@pytest.mark.slow
def test_temperature_beside_solid_elements():
    """REFERENCES.md A14-leaf: 1 K across bends a strip by 119.4 to 120.0 um (beam theory 115)."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0.1, 0))
    b.add(planar.leaf_spring, "foot", "tip", name="leaf", section=LEAF)
    b.fix("foot")
    b.temperature("leaf", 0.0, gradient=2000.0)
    assert float(fm.equilibrium(b.build()).at("tip")[1]) == approx(-119.7e-6, rel=3e-3)


@pytest.mark.slow
def test_derivatives_by_the_dimensions():
    """In the plane; those of the element in space test_laws.py asks."""

    def answer(sizes):
        b = fm.Builder()
        b.node("foot", (0, 0))
        b.node("tip", (0.1, 0))
        section = fm.Rectangle(sizes[0], sizes[1], STEEL)
        b.add(planar.leaf_spring, "foot", "tip", name="leaf", section=section, clamped=True)
        b.fix("foot")
        flexible = fm.compliance(b.build(), "tip")
        return jnp.stack([flexible[1, 1] * 1e2, flexible[2, 2]])

    sizes = jnp.array([0.018, 0.5e-3])
    forward, reverse = jax.jacfwd(answer)(sizes), jax.jacrev(answer)(sizes)
    for i, step in enumerate((1e-5, 1e-7)):
        change = step * np.eye(2)[i]
        slope = (answer(sizes + change) - answer(sizes - change)) / (2 * step)
        np.testing.assert_allclose(forward[:, i], slope, rtol=1e-4)
    np.testing.assert_allclose(forward, reverse, rtol=1e-8)


# -- which ends are clamped -----------------------------------------------------------------------------------------


def ends(model: fm.Model, leaf: str) -> tuple[list[float], list[str]]:
    """Which ends of a leaf spring are kept flat, and the roles of its warping."""
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        of = [model.labels.e[i].of for i in np.asarray(block.e)[:, 0].tolist()] if block.e.shape[1] else []
        if "clamped" in properties and leaf in of:
            flat = np.atleast_2d(np.asarray(properties["clamped"])[of.index(leaf)])[0].tolist()
            nodes = next(nodes for name, _, nodes in model.labels.elements if name == leaf)
            roles = dict(zip([entry.of for entry in model.labels.x], model.roles()[0], strict=True))
            return flat, [roles[node].name for node in nodes if node.endswith(".warping")]
    raise LookupError(leaf)


def chain(join) -> fm.Model:
    """A clamped leaf spring whose last end, at x = 0.1, is joined to something."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("mid", (0.1, 0, 0))
    b.add(spatial.leaf_spring, "foot", "mid", name="leaf", section=LEAF, y=(0, 1, 0))
    b.fix("foot")
    join(b)
    return b.build()


def beside(place, y=(0, 1, 0), element=spatial.leaf_spring, thickness=0.5e-3):
    def join(b):
        b.node("end", place)
        b.add(element, "mid", "end", name="next", section=fm.Rectangle(0.018, thickness, STEEL), y=y)

    return join


def held_by_a_hinge(b):
    b.node("end", (0.2, 0, 0))
    b.rotation("lever")
    b.add(spatial.hinge, "mid.rotation", "lever", axis=(0, 0, 1))
    b.add(spatial.rigid_beam, "mid", "lever", "end")


@pytest.mark.parametrize(
    ("join", "flat", "warping"),
    [
        (lambda b: None, 0.0, "DOF"),
        (lambda b: b.mass("mid", 0.1), 0.0, "DOF"),
        (lambda b: b.inertia("mid", (1e-6, 0, 0, 1e-6, 0, 1e-6)), 1.0, "FIXED"),
        (lambda b: b.body("mid", 0.1, center=(0.01, 0, 0), inertia=(1e-6, 0, 0, 1e-6, 0, 1e-6)), 1.0, "FIXED"),
        (held_by_a_hinge, 1.0, "FIXED"),
        (beside((0.2, 0, 0)), 0.0, "DOF"),
        (beside((0.2, 0, 0), thickness=1.4e-3), 1 - (0.5 / 1.4) ** 3, "DOF"),
        (beside((0.2, 0, 0), thickness=1.6e-3), 1.0, "DOF"),
        (beside((0.2, 0, 0), element=spatial.beam, thickness=1.6e-3), 1.0, "FIXED"),
        (beside((0.1, 0, 0.1)), 1.0, "DOF"),
        (beside((0.2, 0, 0), element=spatial.beam), 0.0, "DOF"),
    ],
    ids=["free", "mass", "inertia", "body", "hinge", "chain", "thicker", "thick", "thick beam", "fold", "beam"],
)
def test_what_clamps_an_end(join, flat, warping):
    found = ends(chain(join), "leaf")
    assert found[0] == approx([1.0, flat], rel=1e-12)
    assert found[1][0] == "FIXED"
    # Free warping is a degree of freedom, or follows from the next one.
    assert found[1][1] == warping or (warping == "DOF" and found[1][1] == "DEPENDENT")


def test_widths_at_an_angle_are_taken_to_clamp():
    with pytest.warns(fm.FlexmbWarning, match="meet with their widths at an angle"):
        model = chain(beside((0.2, 0, 0), y=(0, 0, 1)))
    assert ends(model, "leaf") == ([1.0, 1.0], ["FIXED", "FIXED"])


def test_a_traced_thickness_repeats_what_was_found():
    def tip(thickness):
        model = chain(beside((0.2, 0, 0), thickness=thickness))
        return model.parameters.properties[0]["clamped"]

    with pytest.raises(fm.ModelError, match="whether 'next' clamps its last end cannot be found"):
        jax.jit(tip)(1.6e-3)


def test_warping_by_another_name_is_found_again():
    """Where sizes are traced, the model of before says what was found, whatever its warping is called."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.1, 0, 0))
    b.warping("own")
    nodes = "foot", "foot.rotation", "foot.warping", "tip", "tip.rotation", "own"
    b.add(spatial.leaf_spring, *nodes, name="leaf", section=LEAF, y=(0, 1, 0))
    b.fix("foot")
    before = b.build()
    assert as_before(before, End("leaf", "foot.rotation", 0)) == (True, True)
    assert as_before(before, End("leaf", "tip.rotation", 1)) == (False, False)


def test_ends_that_contradict_each_other_are_named():
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.1 * i, 0, 0))
    for i in range(2):
        b.add(spatial.leaf_spring, f"n{i}", f"n{i + 1}", name=f"leaf {i}", section=LEAF, clamped=i == 0)
    b.fix("n0")
    with pytest.raises(fm.ModelError, match=r"'leaf 0' and 'leaf 1' share their warping at 'n1.warping'"):
        b.build()


@pytest.mark.slow("properties6-must be True or False, or two of them")
@pytest.mark.parametrize(
    ("properties", "message"),
    [
        ({}, "needs the property 'section'"),
        ({"section": fm.Rigidity(EA=1.0)}, "must be a Rectangle"),
        ({"section": dataclasses.replace(LEAF, warping_length=0.1)}, "counts restrained warping itself"),
        ({"section": fm.sections.stepped((LEAF, LEAF), (0.5,))}, "use one leaf spring per piece"),
        ({"section": fm.sections.Profile(lambda s: fm.Rectangle(0.018, 1e-3 * (0.5 - s), STEEL))}, "must be positive"),
        ({"section": LEAF, "clamped": (1, 0)}, "must be True or False, or two of them"),
        ({"section": LEAF, "clamped": (True,)}, "must be True or False, or two of them"),
    ],
)
def test_bad_input_is_named(properties, message):
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.1, 0, 0))
    with pytest.raises(fm.ModelError, match=message):
        b.add(spatial.leaf_spring, "foot", "tip", name="leaf", **properties)


def narrow(place):
    """Waisted from 30 to 12 mm and back."""
    return fm.Rectangle(0.030 - 0.018 * jnp.sin(np.pi * place) ** 2, 0.5e-3, STEEL)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("section", "solid"),
    [
        (
            fm.sections.taper(fm.Rectangle(0.03, 0.5e-3, STEEL), fm.Rectangle(0.012, 0.5e-3, STEEL)),
            [2.57459e7, 685782, 326.132, 0.917195, 0.545642, 667.074],
        ),
        (
            fm.sections.taper(fm.Rectangle(0.04, 0.5e-3, STEEL), fm.Rectangle(0.004, 0.5e-3, STEEL)),
            [1.99987e7, 724871, 371.722, 0.689006, 0.428777, 120.773],
        ),
        (fm.sections.Profile(narrow), [2.42593e7, 289727, 261.187, 0.871632, 0.519399, 530.795]),
    ],
    ids=["trapezoid", "triangle", "waist"],
)
def test_width_that_varies_beside_solid_elements(section, solid):
    """C3D20R, 80 mm long, 0.5 mm thick, with a rigid tip; largest deviation 1.9 %, without (2.46) 6 %."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.08, 0, 0))
    b.add(spatial.leaf_spring, "foot", "tip", section=section, y=(0, 1, 0))
    b.fix("foot")
    b.inertia("tip", (1e-9, 0, 0, 1e-9, 0, 1e-9))
    found = 1 / np.diag(np.asarray(fm.compliance(b.build(), "tip")))
    assert np.all(np.abs(found / solid - 1) < [0.008, 0.008, 0.02, 0.008, 0.008, 0.008])


@pytest.mark.slow
def test_derivatives_by_the_widths_of_a_trapezoid():
    def answer(widths) -> Any:
        b = fm.Builder()
        b.node("foot", (0, 0, 0))
        b.node("tip", (0.08, 0, 0))
        section = fm.sections.taper(*(fm.Rectangle(width, 0.5e-3, STEEL) for width in widths))
        b.add(spatial.leaf_spring(order=3), "foot", "tip", section=section, y=(0, 1, 0), clamped=(True, False))
        b.fix("foot")
        model = b.build() if labels is None else b.build(dofs=labels)
        return model if labels is None else 1e5 * fm.compliance(model, "tip")[1, 1]

    widths, labels = jnp.array([0.03, 0.012]), None
    labels = answer(widths).q_labels
    forward, reverse = jax.jacfwd(answer)(widths), jax.jacrev(answer)(widths)
    slopes = [float(answer(widths + step) - answer(widths - step)) / 2e-6 for step in 1e-6 * np.eye(2)]
    np.testing.assert_allclose(forward, slopes, rtol=1e-5)
    np.testing.assert_allclose(forward, reverse, rtol=1e-8)


@pytest.mark.slow
def test_a_width_that_varies_fast_warns():
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0.03, 0))
    steep = fm.sections.taper(LEAF, dataclasses.replace(LEAF, width=0.05))
    b.add(planar.leaf_spring, "foot", "tip", name="leaf", section=steep)
    b.fix("foot")
    with pytest.warns(fm.BeamTheoryWarning, match="width of element 'leaf' has a slope of up to 1.07"):
        b.build()


@pytest.mark.slow
def test_taper_beside_solid_elements():
    """REFERENCES.md A14-leaf: 0.5 to 0.3 mm thick; one that stays the same is as a section that does not vary."""

    def stiffness(section):
        b = fm.Builder()
        b.node("foot", (0, 0, 0))
        b.node("tip", (0.1, 0, 0))
        b.add(spatial.leaf_spring, "foot", "tip", section=section, y=(0, 1, 0), clamped=True)
        b.fix("foot")
        return 1 / np.diag(np.asarray(fm.compliance(b.build(), "tip")))

    taper = fm.sections.taper(LEAF, dataclasses.replace(LEAF, thickness=0.3e-3))
    solid = [1.48708e7, 133293, 82.8942, 0.300841, 0.179986, 400.491]
    np.testing.assert_allclose(stiffness(taper), solid, rtol=4e-3)
    np.testing.assert_allclose(stiffness(fm.sections.taper(LEAF, LEAF)), stiffness(LEAF), rtol=1e-9)
