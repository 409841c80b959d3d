"""Properties of elements: forgotten, of the wrong kind, or of the wrong shape, each answered by name."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.build.assemble import assemble, stack
from flexmb.elements import beams

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)
LEAF = fm.Rectangle(0.018, 5e-4, STEEL)


def ends(dimension=2):
    b = fm.Builder()
    b.node("A", (0.0,) * dimension)
    b.node("B", (0.1, *(0.0,) * (dimension - 1)))
    return b


def bar(p: fm.Point2, q: fm.Point2, *, ref):
    return beams.truss(p, q, ref=ref)


def hard(e, *, ref, k: float, cubic: float):
    return k * e[0] ** 2 / 2 + cubic * e[0] ** 4


def soft(*, ref, k: float, share: float = 1.0):
    return jnp.reshape(k * share, (1, 1))


def heavy(p: fm.Point2, q: fm.Point2, *, ref, rho: float, area: float):
    return beams.line_inertia(p, q, ref=ref, section=fm.Rigidity(mass=rho * area))


COMPANIONS = {
    "stiffness": (soft, {"share": 0.5}, "k"),
    "energy": (hard, {"k": 100.0}, "cubic"),
    "dissipation": (lambda e, ed, *, ref, c, d: (c + d) * ed[0] ** 2, {"d": 1.0}, "c"),
    "damping": (lambda *, ref, c, d: jnp.reshape(c + d, (1, 1)), {"c": 1.0}, "d"),
    "inertia": (heavy, {"area": 1.0}, "rho"),
    "force": (lambda p, q, *, ref, size, at: size * jnp.ones(4) * at, {"size": 1.0}, "at"),
    "resultants": (lambda p, q, *, ref, place, sigma, a, b: jnp.zeros(6), {"a": 1.0}, "b"),
    "surface": (lambda e, *, ref, place, resultants, a, b: (jnp.zeros(8),) * 3, {"a": 1.0}, "b"),
    "shape": (lambda p, q, *, ref, place, bow, out: p, {"bow": 1.0}, "out"),
}


@pytest.mark.parametrize("companion", COMPANIONS)
def test_some_but_not_all_properties_of_a_companion(companion):
    function, given, missing = COMPANIONS[companion]
    element = fm.Element(bar, **{companion: function})
    with pytest.raises(fm.ModelError, match=f"'own' .*{companion} needs '{missing}' too.*'{next(iter(given))}'"):
        ends().add(element, "A", "B", name="own", **given)
    # None of them: the element is without it.
    ends().add(element, "A", "B", name="own")


def test_a_law_needs_all_of_its_properties():
    stop = planar.spring_damper(lambda e, ed, *, k, gap: k * e - gap)
    for given in ({}, {"k": 1.0}, {"gap": 1.0}, {"k": 1.0, "gap": None}):
        with pytest.raises(fm.ModelError, match=r"'own' .* needs the property '(k|gap)'"):
            ends().add(stop, "A", "B", name="own", **given)


def test_what_the_deformation_asks_for_is_no_part_of_a_companion():
    """A belt without a section does not stretch, though its radii are properties of its energy too."""
    b = ends()
    b.add(planar.belt_to_point, "A", "B", name="rope", radius_p=0.01)
    assert list(b.members) == ["rope"]
    b = ends(3)
    b.add(spatial.beam, "A", "B", name="rigid", y=(0, 0, 1))
    assert list(b.members) == ["rigid"]


WRONG = {
    "section a number": ({"section": 5e-4}, r"Property 'section' of element 'leaf' must be a Section.*not 0.0005"),
    "section a word": ({"section": "steel"}, r"Property 'section' of element 'leaf' must be a Section.*not 'steel'"),
    "section a material": ({"section": STEEL}, r"Property 'section' of element 'leaf' must be a Section.*Material"),
    "damping a number": ({"section": LEAF, "damping": 0.01}, r"Property 'damping' of element 'leaf' must be a Damping"),
    "thickness a word": (
        {"section": fm.Rectangle(0.018, "0.5e-3", STEEL)},
        r"section of element 'leaf' has thickness = '0.5e-3', but it must be a number",
    ),
    "thickness two numbers": (
        {"section": fm.Rectangle(0.018, [5e-4, 5e-4], STEEL)},
        r"section of element 'leaf' has thickness = \[0.0005, 0.0005\], but it must be a number",
    ),
    "thickness forgotten": (
        {"section": fm.Rectangle(0.018, None, STEEL)},
        r"section of element 'leaf' has thickness = None, but it must be a number",
    ),
    "material a number": (
        {"section": fm.Rectangle(0.018, 5e-4, 210e9)},
        r"section of element 'leaf' has material = 2100000+\.0, but it must be a Material",
    ),
    "an unknown rule of torsion": (
        {"section": fm.Rectangle(0.018, 5e-4, STEEL, torsion="exact")},
        r"section of element 'leaf' has torsion = 'exact', but it must be one of 'series', 'approximate'",
    ),
    "three clamped ends": (
        {"section": fm.Rectangle(0.018, 5e-4, STEEL, warping_length=0.1, clamped_ends=3)},
        r"section of element 'leaf' has clamped_ends = 3",
    ),
    "a clamped end without a length of warping": (
        {"section": fm.Rectangle(0.018, 5e-4, STEEL, clamped_ends=1)},
        r"section of element 'leaf' has clamped_ends = 1 without warping_length.*without effect: give it",
    ),
    "shear a word": (
        {"section": fm.Rectangle(0.018, 5e-4, STEEL, shear="no")},
        r"section of element 'leaf' has shear = 'no', but it must be True or False",
    ),
    "second_order a word": ({"section": LEAF, "second_order": "no"}, r"'leaf' .*`second_order` of beam must be True"),
    "too large": ({"section": fm.Rigidity(EA=1e200)}, r"'section' of element 'leaf' has a value .* too large"),
    "a damping below zero": (
        {"section": LEAF, "damping": fm.Damping(EA=-1.0)},
        r"The damping of element 'leaf' has EA = -1.0, but it cannot be negative",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_properties_of_a_beam(case):
    properties, message = WRONG[case]
    with pytest.raises(fm.ModelError, match=message):
        ends().add(planar.beam, "A", "B", name="leaf", **properties)


OTHERS = {
    "axis of two numbers": (
        lambda b: b.add(spatial.hinge, "A", "B", name="h", axis=(0, 1)),
        r"Property 'axis' of element 'h' .*must have shape \(3,\), but has shape \(2,\)",
    ),
    "axis a word": (lambda b: b.add(spatial.hinge, "A", "B", name="h", axis="z"), r"'axis' of element 'h' must be num"),
    "ratio a word": (
        lambda b: b.add(spatial.screw, "A", "B", name="g", axis=(0, 0, 1), pitch="3"),
        r"Property 'pitch' of element 'g' must be a number, not '3'",
    ),
    "stiffness of two": (
        lambda b: b.add(spatial.hinge, "A", "B", name="h", axis=(0, 0, 1), stiffness=(1.0, 2.0)),
        r"Element 'h' \(hinge\): its stiffness cannot be computed",
    ),
    "stiffness a truth": (
        lambda b: b.add(spatial.hinge, "A", "B", name="h", axis=(0, 0, 1), stiffness=True),
        r"Property 'stiffness' of element 'h' must be a number, not True",
    ),
    "a hinge of a body with itself": (
        lambda b: b.add(spatial.hinge, "A", "A", name="h", axis=(0, 0, 1)),
        r"Element 'h' \(hinge\) joins node 'A.rotation' to itself",
    ),
    "a mass below zero": (
        lambda b: b.add(spatial.mass, "A", name="m", mass=-1.0),
        r"Element 'm' has a mass of -1.0, but it cannot be negative",
    ),
    "a mass without mass": (lambda b: b.add(spatial.mass, "A", name="m"), r"'m' .*has no effect without .*'mass'"),
    "Poisson's ratio in percent": (
        lambda b: b.add(spatial.beam, "A", "B", name="s", section=fm.Circle(1e-3, fm.Material(1e9, 1e9, nu=30.0))),
        r"section of element 's' has nu = 30.0, but it must be above -1 and below 0.5",
    ),
    "measured deformations that are not there": (
        lambda b: b.add(fm.Element(spatial.truss.deformation, measured=(2,)), "A", "B", name="t"),
        r"'t' \(truss\): its `measured` names deformations \[2\], but it has 1",
    ),
    "a ratio of zero": (
        lambda b: (c := ends(), c.add(planar.gear, "A", "B", name="g", ratio=0.0)),
        r"Element 'g' has a ratio of zero",
    ),
    "no function": (lambda b: b.add("beam", "A", "B"), r"Element type must be .* such as planar.beam, not 'beam'"),
    "the module": (lambda b: b.add(spatial, "A", "B"), r"Element type must be .* such as planar.beam"),
}


@pytest.mark.parametrize("case", OTHERS)
def test_wrong_properties_of_others(case):
    act, message = OTHERS[case]
    with pytest.raises(fm.ModelError, match=message):
        act(ends(3))


# -- options ------------------------------------------------------------------------------------------------------


def powers(p: fm.Point2, q: fm.Point2, *, ref, exponents: fm.Static[tuple] = (1,), scale: fm.Static = 1.0):
    """A deformation for each exponent."""
    return scale * jnp.concatenate([beams.truss(p, q, ref=ref) ** n for n in exponents])


def each(*, ref, exponents, stiffness: float):
    return stiffness * jnp.eye(len(exponents))


POWERS = fm.Element(powers, stiffness=each)
WRONG_OPTIONS = {
    "half an order": (planar.spectral_beam, {"order": 2.5}, "`order` of spectral_beam must be a whole number, not 2.5"),
    "an order beyond sense": (planar.spectral_beam, {"order": 41}, "order must be at least 1 and at most 40, but"),
    "shear of a cubic beam": (planar.beam, {"shear": True}, "has no property 'shear'. It takes: .*section"),
    "shear a word": (spatial.spectral_beam, {"shear": "no"}, "`shear` of .* must be True or False, not 'no'"),
    "no law": (planar.spring_damper, {"k": 1.0}, "needs the option 'law'"),
    "a law that is none": (planar.spring_damper, {"law": 3.0}, "`law` of spring_damper must be a function, not 3.0"),
    "a law of the deformation alone": (planar.spring_damper, {"law": lambda e: e}, "its law cannot be computed"),
    "a list": (POWERS, {"exponents": [1, 2]}, r"`exponents` of powers must be a tuple, not \[1, 2\]"),
    "a list in a tuple": (POWERS, {"exponents": (1, [2])}, r"`exponents` .* must be hashable, not \(1, \[2\]\)"),
}


@pytest.mark.parametrize("case", WRONG_OPTIONS)
def test_wrong_options(case):
    element, given, message = WRONG_OPTIONS[case]
    with pytest.raises(fm.ModelError, match=rf"Element 'own' \({element.name}\).*{message}"):
        ends(next(iter(element.nodes.values())).dimension).add(element, "A", "B", name="own", **given)


def test_an_option_cannot_be_traced():
    def built(t):
        return ends().add(POWERS, "A", "B", name="own", scale=t)

    with pytest.raises(fm.ModelError, match=r"'own'.*`scale` of powers must be known before tracing"):
        jax.jit(built)(1.0)


def test_options_by_name_and_by_call_are_one_thing():
    b = ends()
    b.add(planar.spectral_beam, "A", "B", name="named", section=LEAF, order=3)
    b.add(planar.spectral_beam(3), "A", "B", name="called", section=LEAF)
    b.add(planar.spectral_beam(4), "A", "B", name="named after", section=LEAF, order=3)
    b.add(planar.spectral_beam, "A", "B", name="usual", section=LEAF)
    (blocks,) = {tuple(len(block.x) for block in assemble(b).topology.blocks)}
    assert blocks == (3, 1)
    assert b.members["called"].element is b.members["named"].element
    assert b.members["usual"].element is planar.spectral_beam is planar.spectral_beam(order=5)
    assert [len(m.roles) for m in b.members.values()] == [9, 9, 9, 13]
    assert b.nodes["called.internal"].kind.size == 6


def test_an_option_is_any_hashable_and_chooses_code():
    b = ends()
    b.add(POWERS, "A", "B", name="one", stiffness=1.0)
    b.add(POWERS, "A", "B", name="three", stiffness=1.0, exponents=(1, 2, 3))
    # Equal, and yet of another type.
    b.add(POWERS, "A", "B", name="whole", stiffness=1.0, scale=1)
    b.add(POWERS((1,), scale=1.0), "A", "B", name="again", stiffness=2.0)
    blocks = assemble(b).topology.blocks
    assert [block.e.tolist() for block in blocks] == [[[0], [5]], [[1, 2, 3]], [[4]]]
    assert [block.element.options["scale"] for block in blocks] == [1.0, 1.0, 1]
    with pytest.raises(TypeError, match="Options of powers are: exponents, scale; `power` is unknown or given twice"):
        POWERS(power=2)
    with pytest.raises(TypeError, match="Options of truss are: none; there are not 1 of them"):
        planar.truss(1)


def test_properties_of_a_law_that_is_an_option():
    def stop(e, ed, *, k, gap=0.0):
        return k * (e - gap)

    b = ends()
    b.add(planar.spring_damper, "A", "B", name="own", law=stop, k=2.0)
    b.add(planar.spring_damper(stop), "A", "B", name="other", k=3.0, gap=0.1)
    (properties,) = assemble(b).parameters.properties
    np.testing.assert_array_equal(properties["k"], [2.0, 3.0])
    np.testing.assert_array_equal(properties["gap"], [0.0, 0.1])
    with pytest.raises(fm.ModelError, match=r"'third' \(spring_damper\) has no property 'gab'. It takes: k, gap, law"):
        b.add(planar.spring_damper, "A", "B", name="third", law=stop, k=2.0, gab=1.0)


# -- elements of one's own ----------------------------------------------------------------------------------------


def scalar(p: fm.Point2, q: fm.Point2, *, ref):
    return beams.truss(p, q, ref=ref)[0]


def column(p: fm.Point2, q: fm.Point2, *, ref):
    return beams.truss(p, q, ref=ref)[:, None]


def broken(p: fm.Point2, q: fm.Point2, *, ref):
    return p + jnp.zeros(3)


SHAPES = {
    "a deformation that is one number": ({"deformation": scalar}, r"'own' \(scalar\): its deformation must .* \(n,\)"),
    "a deformation that is a matrix": ({"deformation": column}, r"'own' \(column\): its deformation must .* \(1, 1\)"),
    "a deformation that cannot be computed": (
        {"deformation": broken},
        r"'own' \(broken\): its deformation cannot be computed",
    ),
    "an energy without ref": (
        {"deformation": bar, "energy": lambda e: e[0] ** 2},
        r"'own' \(bar\): its energy cannot be computed: .*; every function of an element takes `ref` by name",
    ),
    "a stiffness that is a number": (
        {"deformation": bar, "stiffness": lambda *, ref: 3.0},
        r"'own' \(bar\): its stiffness must have shape \(1, 1\), but has \(\)",
    ),
    "an energy that is a vector": (
        {"deformation": bar, "energy": lambda e, *, ref: e**2},
        r"'own' \(bar\): its energy must have shape \(\), but has \(1,\)",
    ),
    "a law that is a number": (
        {"deformation": bar, "law": lambda e, ed, *, ref: e[0]},
        r"'own' \(bar\): its law must have shape \(1,\), but has \(\)",
    ),
    "a force that is short": (
        {"deformation": bar, "force": lambda p, q, *, ref: jnp.zeros(2)},
        r"'own' \(bar\): its force must have shape \(4,\), but has \(2,\)",
    ),
    "an inertia without its matrix": (
        {"deformation": bar, "inertia": lambda p, q, *, ref: jnp.stack([p, q])},
        r"'own' \(bar\): its inertia must be vectors \(k, d\) and a matrix \(k, k\)",
    ),
    "an inertia whose matrix is small": (
        {"deformation": bar, "inertia": lambda p, q, *, ref: (jnp.stack([p, q]), jnp.eye(1))},
        r"'own' \(bar\): its inertia must be vectors \(k, d\) and a matrix \(k, k\)",
    ),
    "a surface without stress across": (
        {"deformation": bar, "surface": lambda e, *, ref, place, resultants: (jnp.zeros(8), jnp.zeros(8))},
        r"'own' \(bar\): its surface must be three vectors \(8,\)",
    ),
    "nodes that are not annotated": (
        {"deformation": lambda p, q, *, ref: q - p},
        r"must be annotated with a node kind",
    ),
}


@pytest.mark.parametrize("case", SHAPES)
def test_wrong_shapes_of_own_elements(case):
    parts, message = SHAPES[case]
    with pytest.raises(fm.ModelError, match=message):
        ends().add(fm.Element(**parts), "A", "B", name="own")


def length_itself(p: fm.Point2, q: fm.Point2, *, ref):
    return beams.length(q - p)[None]


def test_deformations_that_do_not_vanish_undeformed():
    b = ends()
    b.add(length_itself, "A", "B", name="bar", released="all")
    b.fix("A")
    b.fix("B", "y")
    with pytest.raises(
        fm.ModelError, match=r"Deformation 1 of element 'bar' \(length_itself\) is 0.1 but must be zero"
    ):
        b.build()


def test_deformations_that_are_no_number_undeformed():
    def squared(p: fm.Point2, q: fm.Point2, *, ref):
        return jnp.sqrt((q - p - ref.q + ref.p)[:1])

    b = ends()
    b.add(squared, "A", "B", name="bar", released="all")
    b.fix("A")
    b.fix("B", "y")
    with pytest.raises(fm.ModelError, match=r"element 'bar' \(squared\).* derivative .*not finite"):
        b.build()


def test_euler_parameters_that_are_no_rotation():
    b = ends(3)
    with pytest.raises(fm.ModelError, match=r"Euler parameters of node 'R' must have norm 1, but \(1, 1, 0, 0\) have"):
        b.rotation("R", (1, 1, 0, 0))
    with pytest.raises(fm.ModelError, match=r"Node 'R' must have 4 coordinates, but has 3"):
        b.rotation("R", (1, 0, 0))
    with pytest.raises(fm.ModelError, match=r"Node 'r' must have 1 coordinate, but has 2"):
        ends().rotation("r", np.zeros(2))


def test_damping_of_what_cannot_deform_is_warned_of():
    b = ends()
    b.add(planar.beam, "A", "B", name="leaf", damping=fm.Damping(EA=1.0))
    b.fix("A")
    with pytest.warns(fm.FlexmbWarning, match="Damping of element 'leaf'"):
        b.build()


def test_whatever_is_a_number_may_be_traced():
    """Checks of values pass what is traced: alone, in lists and in arrays."""

    def built(t):
        b = fm.Builder()
        b.node("A", (0, 0, 0))
        b.node("B", (0.1 * t, 0, 0))
        b.node("C", jnp.array([0.2, 0.0, 0.1]) * t)
        b.rotation("R", [t, 0.0, 0.0, 0.0])
        section = fm.Rectangle(0.018, 5e-4 * t, fm.Material(210e9 * t, 80e9, 7850.0))
        b.add(spatial.beam, "A", "B", name="leaf", section=section, y=[0.0, t, 0.0], damping=fm.Damping(EA=t))
        b.add(spatial.hinge, "B", "R", name="hinge", axis=(0.0, 0.0, t), stiffness=[t, 1.0, 1.0])
        b.add(spatial.truss, "B", "C", name="bar", section=fm.Rigidity(EA=t))
        b.fix("A")
        b.mass("B", t, inertia=[t, 0.0, 0.0, t, 0.0, t])
        b.inertia("R", t * jnp.eye(3))
        b.inertia("R", [[t, 0.0, 0.0], [0.0, t, 0.0], [0.0, 0.0, t]])
        b.force("B", (t, 0.0, 0.0))
        b.force("B", t * jnp.ones(3), increment=True, follower=True)
        b.moment("B", [0.0, t, 0.0])
        b.moment("B", t * jnp.ones(3), follower=True)
        b.gravity([0.0, 0.0, -9.81 * t])
        b.prestress("bar", t)
        b.strain("leaf", t)
        b.prescribe("C", "x", t)
        b.prescribe("R", "rotation", t, axis=(0, 0, 1), tilt="free")
        b.start("C", "y", t, velocity=t)
        b.dof("C", "y")
        return assemble(b).parameters

    from_traced = jax.jit(built)(1.0)
    alone = built(1.0)
    for one, other in zip(jax.tree.leaves(from_traced), jax.tree.leaves(alone), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-15, atol=1e-15)


def test_what_elements_share_is_traced_once():
    """Numbers that several elements share, and such that are known, stand where they do without a trace."""

    def stacked(a, b):
        return stack([a, 2.0, b, a, 3.0, b, 2.0])

    np.testing.assert_array_equal(jax.jit(stacked)(5.0, 7.0), stacked(5.0, 7.0))
    slopes = jax.jacobian(stacked, argnums=(0, 1))(5.0, 7.0)
    np.testing.assert_array_equal(slopes, [[1, 0, 0, 1, 0, 0, 0], [0, 0, 1, 0, 0, 1, 0]])

    def operations(elements):
        return len(jax.make_jaxpr(lambda a: stack([a] * elements))(5.0).eqns)

    assert operations(1000) == operations(10)
