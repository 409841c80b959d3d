"""Numbers of sections and dampers that an element does not use, in place of those that it does, are told by name."""

import warnings

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
            r"Section of element 'part' \(truss\): EA is zero, and what is given as EIy is not used",
        ),
        (planar.beam, {"EA": 1.0, "EIz": 1.0}, r"EIy is zero, and what is given as EIz is not .* uses EA, EIy\."),
        (
            planar.spectral_beam,
            {"EA": 1.0, "EIz": 1.0, "GIt": 1.0},
            "EIy is zero, and what is given as EIz, GIt is not",
        ),
        (spatial.truss, {"EIy": 1.0, "EIz": 1.0}, "EA is zero, and what is given as EIy, EIz is not"),
    ],
)
def test_rigidities_that_an_element_does_not_use_are_told(element, given, told):
    with pytest.warns(fm.errors.IdleWarning, match=told):
        build(element, fm.Rigidity(**given))


def test_dampers_that_an_element_does_not_use_are_told():
    with pytest.warns(
        fm.errors.IdleWarning, match=r"Damping of element 'part' \(beam\): EIy is zero, and .* GIt is not used"
    ):
        build(planar.beam, fm.Rigidity(EA=1.0, EIy=1.0), fm.Damping(EA=1.0, GIt=1.0))


def test_more_numbers_than_an_element_uses_are_no_fault():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        build(planar.truss, fm.Rigidity(EA=1.0, EIy=1.0))
        build(planar.truss, fm.Rigidity(mass=1.0))
        # The elongation is held.
        build(planar.beam, fm.Rigidity(EIy=1.0, EIz=1.0, GIt=1.0), released=(2, 3))
        build(planar.beam, fm.Rigidity(EA=1.0, EIy=1.0), fm.Damping(EIy=1.0))
