"""Numbers of sections and dampers that an element does not use, in place of those that it does, are told by name."""

import warnings

import jax
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
            r"Section of element 'part' \(truss\): nothing resists .* for want of EA, and what is given as EIy is",
        ),
        (planar.beam, {"EA": 1.0, "EIz": 1.0}, r"for want of EIy, and what is given as EIz is not .* uses EA, EIy\."),
        (
            planar.spectral_beam,
            {"EA": 1.0, "EIz": 1.0, "GIt": 1.0},
            "for want of EIy, and what is given as EIz, GIt is not",
        ),
        (spatial.truss, {"EIy": 1.0, "EIz": 1.0}, "for want of EA, and what is given as EIy, EIz is not"),
    ],
)
def test_rigidities_that_an_element_does_not_use_are_told(element, given, told):
    with pytest.warns(fm.FlexmbWarning, match=told):
        build(element, fm.Rigidity(**given))


def test_dampers_that_an_element_does_not_use_are_told():
    with pytest.warns(
        fm.FlexmbWarning,
        match=r"Damping of element 'part' \(beam\): nothing damps .* of EIy, and .* GIt is not used",
    ):
        build(planar.beam, fm.Rigidity(EA=1.0, EIy=1.0), fm.Damping(EA=1.0, GIt=1.0))


def test_numbers_that_act_on_held_deformations_alone_are_told():
    with pytest.warns(
        fm.FlexmbWarning, match=r"Damping of element 'part' .* EA damps deformation 1 alone, which is held"
    ):
        build(planar.beam, fm.Rigidity(EA=1.0, EIy=1.0), fm.Damping(EA=1.0), released=(2, 3))
    with pytest.warns(fm.FlexmbWarning, match=r"Section of element 'part' .* EIy resists deformation 2, 3 alone"):
        build(planar.beam, fm.Rigidity(EIy=1.0), released=(1,))


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
