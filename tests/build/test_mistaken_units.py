"""Warnings of numbers that are off by a factor of a unit."""

import warnings

import jax
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.elements import materials

STEEL = {"E": 210e9, "G": 80e9, "rho": 7850.0}


def leaf_spring(length=0.1, width=0.018, thickness=0.5e-3, element=planar.leaf_spring, **material):
    b = fm.Builder()
    b.node("A", (0.0, 0.0))
    b.node("B", (length, 0.0))
    section = fm.Rectangle(width, thickness, fm.Material(**(STEEL | material)))
    b.add(element, "A", "B", name="leaf", section=section)
    b.fix("A")
    return b


WRONG = [
    ({"length": 100.0, "width": 18.0, "thickness": 0.5}, "width = 18 m.*millimetres"),
    ({"length": 100.0, "width": 8.0, "thickness": 0.5}, "Leaf spring 'leaf' has thickness = 0.5 m.*millimetres"),
    ({"length": 2e4}, "Nodes are 20000 m apart.*millimetres"),
    ({"E": 210.0, "G": 80.0}, "E = 210 Pa, as soft as a gel: is it in GPa"),
    ({"E": 210e3, "G": 80e3}, "E = 210000 Pa, as soft as a gel: is it in MPa"),
    ({"E": 210e3, "G": 80e3, "rho": 7.85e-9}, "E = 210000 Pa, as soft as a gel"),
    ({"E": 70e3, "G": 26e3, "rho": 0.0}, "E = 70000 Pa, as soft as a gel"),
    ({"rho": 7850e3}, "denser than any solid"),
    ({"rho": 7.85}, "lighter than any stiff solid: is it in g/cm"),
    ({"strength": 900.0}, "strength = 900 Pa.*is it in MPa"),
    ({"alpha": 11.5}, "alpha = 11.5 1/K: is it in 1e-6/K"),
    ({"nu": 0.49}, "G = 8e.10 Pa, but E and nu .* need G = 7.047e.10 Pa"),
]


@pytest.mark.parametrize(("numbers", "text"), WRONG)
def test_a_number_of_another_unit_is_named(numbers, text):
    with pytest.warns(fm.FlexmbWarning, match=f"(?s){text}"):
        leaf_spring(**numbers).build()


RIGHT = [
    # A comb drive of silicon: 200 x 2 x 2 micrometres.
    {"length": 200e-6, "width": 2e-6, "thickness": 2e-6, "E": 169e9, "G": 69e9, "rho": 2330.0},
    # The boom of a crane, 60 m, and a tower of steel.
    {"length": 60.0, "width": 2.5, "thickness": 3.0, "element": planar.beam},
    {"length": 150.0, "width": 8.0, "thickness": 8.0, "element": planar.beam},
    # Silicone rubber, a hydrogel, a foam of polyurethane, a beam without mass.
    {"E": 70e3, "G": 70e3 / 2.98, "rho": 1070.0},
    {"E": 1e3, "G": 1e3 / 2.98, "rho": 1000.0},
    {"E": 100e3, "G": 40e3, "rho": 30.0},
    {"rho": 0.0},
    # Numbers without units.
    {"E": 1.0, "G": 0.5, "rho": 1.0},
    {"E": 3.0, "G": 1.2, "rho": 2.0, "alpha": 0.1},
    {"rho": 1.0},
]


@pytest.mark.parametrize("numbers", RIGHT)
def test_unusual_mechanisms_cause_no_warning(numbers):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", fm.BeamTheoryWarning)
        leaf_spring(**numbers).build()


@pytest.mark.parametrize("name", materials.__all__)
def test_shipped_materials_cause_no_warning(name):
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (0.1, 0, 0))
    section = fm.Rectangle(0.02, 1e-3, getattr(materials, name))
    b.add(spatial.leaf_spring, "A", "B", section=section, y=(0, 1, 0))
    b.fix("A")
    b.build()


def test_a_material_needs_only_nu_or_g():
    by_nu, by_g = fm.Material(E=210e9, nu=0.3), fm.Material(E=210e9, G=210e9 / 2.6)
    sections = [fm.Rectangle(0.02, 1e-3, material).rigidity() for material in (by_nu, by_g)]
    # G = E/(2 (1 + nu)): Timoshenko and Goodier 1970, eq. (6).
    assert float(sections[0].GIt) == pytest.approx(float(sections[1].GIt), rel=1e-14)
    assert by_g.poisson() == pytest.approx(0.3, rel=1e-14)
    slope = jax.grad(lambda e: fm.Material(E=e, nu=0.25).shear_modulus())(200e9)
    assert slope == pytest.approx(0.4, rel=1e-14)
    b = leaf_spring(G=None, nu=0.3)
    stiff = leaf_spring(G=210e9 / 2.6)
    frequencies = [float(fm.frequencies(one.build(), count=1)[0]) for one in (b, stiff)]
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-12)


def test_a_material_without_g_and_nu_is_refused():
    with pytest.raises(fm.ModelError, match="section of element 'leaf' has neither G nor nu: give Material"):
        leaf_spring(G=None)
    with pytest.raises(fm.ModelError, match="neither G nor nu"):
        fm.Rectangle(0.02, 1e-3, fm.Material(E=210e9)).rigidity()
