"""Numbers of sections and dampers that an element does not use, in place of those that it does, are told by name."""

import warnings

import jax
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial


def build(element, section, damping=None, **options):
    """A mass on one element between two nodes."""
    dimension = 2 if element.deformation.__module__.endswith("planar") else 3
    b = fm.Builder()
    b.node("A", (0.0, 0.0, 0.0)[:dimension])
    b.node("B", (1.0, 0.0, 0.0)[:dimension])
    b.add(element, "A", "B", name="part", section=section, damping=damping, **options)
    b.fix("A")
    b.mass("B", 1.0)
    return b.build()


@pytest.mark.parametrize(
    ("element", "given", "told"),
    [
        (
            planar.truss,
            {"EIy": 1.0},
            r"Section of element 'part' \(truss\): without EA, nothing resists .* It does not use EIy\.",
        ),
        (planar.beam, {"EA": 1.0, "EIz": 1.0}, r"without EIy, nothing .* uses EA, EIy\. It does not use EIz\."),
        (
            planar.spectral_beam,
            {"EA": 1.0, "EIz": 1.0, "GIt": 1.0},
            r"without EIy, nothing .* It does not use EIz, GIt\.",
        ),
        (spatial.truss, {"EIy": 1.0, "EIz": 1.0}, r"without EA, nothing .* It does not use EIy, EIz\."),
    ],
)
def test_rigidities_that_an_element_does_not_use_are_told(element, given, told):
    with pytest.warns(fm.FlexmbWarning, match=told):
        build(element, fm.Rigidity(**given))


def test_dampers_that_an_element_does_not_use_are_told():
    with pytest.warns(
        fm.FlexmbWarning,
        match=r"Damping of element 'part' \(beam\): without EIy, nothing damps .* It does not use GIt\.",
    ):
        build(planar.beam, fm.Rigidity(EA=1.0, EIy=1.0), fm.Damping(EA=1.0, GIt=1.0))
    with pytest.warns(fm.FlexmbWarning, match=r"without EIy, nothing damps .* It does not use GAz\."):
        build(planar.beam, fm.Rigidity(EA=1.0, EIy=1.0), fm.Damping(EA=1.0, GAz=1.0))
    with pytest.warns(fm.FlexmbWarning, match=r"Section of .* without EIy, nothing resists .* It does not use GIt\."):
        build(planar.beam, fm.Rigidity(EA=1.0, GIt=1.0), fm.Damping(EA=1.0, EIy=1.0))


@pytest.mark.parametrize(
    ("section", "damping", "released", "told"),
    [
        ({"EA": 1.0, "EIy": 1.0}, {"EA": 1.0}, (2, 3), r"Damping .* \(beam\): EA damps only deformation 1, which is"),
        ({"EIy": 1.0}, None, (1,), r"Section .* \(beam\): EIy resists only deformations 2, 3, which are"),
    ],
)
def test_numbers_that_act_on_held_deformations_alone_are_told(section, damping, released, told):
    damping = None if damping is None else fm.Damping(**damping)
    with pytest.warns(fm.FlexmbWarning, match=told):
        build(planar.beam, fm.Rigidity(**section), damping, released=released)


def test_what_is_told_beside_traced_numbers_is_nothing():
    """A damper that is known, of a beam whose section is not."""
    steel = fm.Material(E=210e9, G=80e9, rho=7850.0)

    def mass(thickness):
        root, tip = (fm.Rectangle(width, thickness, steel) for width in (0.02, 0.01))
        section = fm.sections.taper(root, tip)
        damping, released = fm.Damping(EA=0.1), (*range(7, 10),)
        return fm.mass(build(planar.spectral_beam(3), section, damping, released=released))

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Of half the material: 0.015 m on average.
        np.testing.assert_allclose(jax.jit(mass)(1e-3), 1.0 + 0.015e-3 * 7850.0, rtol=1e-12)


def test_what_is_told_of_a_traced_place_is_nothing_that_is_not_known():
    def length(place):
        b = fm.Builder()
        b.node("A", (0.0, 0.0))
        b.node("B", (place, 0.0))
        b.add(planar.truss, "A", "B", name="part", section=fm.Rigidity(EIy=1.0))
        b.fix("A")
        b.fix("B", "y")
        b.dof("B", "x")
        model = b.build()
        return model.parameters.reference[model.labels.known("B")[0]]

    assert float(jax.jit(length)(0.25)) == 0.25


def test_more_numbers_than_an_element_uses_are_no_fault():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        build(planar.truss, fm.Rigidity(EA=1.0, EIy=1.0))
        build(planar.truss, fm.Rigidity(mass=1.0))
        # The elongation is held.
        build(planar.beam, fm.Rigidity(EIy=1.0, EIz=1.0, GIt=1.0), released=(2, 3))
        # Bending is held.
        build(planar.beam, fm.Rigidity(EA=1.0, GIt=1.0), released=(1,))
        build(planar.beam, fm.Rigidity(EIz=1.0, mass=1.0), released=())
        build(planar.beam, fm.Rigidity(EA=1.0, EIy=1.0), fm.Damping(EIy=1.0))


def test_what_is_resisted_is_found_by_one_program(compilations):
    """As a build of other numbers of such an element has it already: each of a hundred operations would be another."""
    for rigidity in (1.0, 2.0):
        with pytest.warns(fm.FlexmbWarning, match="constrained here"):
            build(planar.beam, fm.Rigidity(EIy=rigidity), released=(1,))
    assert set(compilations) <= {"flexmb.build.idle._diagonals"}
    assert len(compilations) <= 1


@pytest.mark.parametrize("element", [planar.spring_damper, planar.rotary_spring_damper])
def test_a_law_of_deformations_that_are_all_held_is_told(element):
    def build(**options):
        b = fm.Builder()
        b.node("A", (0.0, 0.0))
        b.node("B", (1.0, 0.0))
        b.add(planar.beam, "A", "B", name="leaf", section=fm.Rigidity(EA=1.0, EIy=1.0))
        b.add(element(lambda e, ed: 3.0 * e), "A", "B", name="spring", **options)
        b.fix("A")
        return b.build()

    with pytest.warns(
        fm.FlexmbWarning, match="Law of element 'spring': all of its deformations are FIXED or PRESCRIBED"
    ):
        build(released=())
    build()
