"""What plain beams leave out is told where it would change a stiffness by more than 1 %."""

import warnings

import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial

STEEL = fm.Material(E=210e9, G=210e9 / 2.6, rho=7850)
STRIP = fm.Rectangle(0.018, 0.5e-3, STEEL)
# By hand: 2.6 (12 + 11 nu)/(10 (1 + nu)) (18/100)^2 = 9.9 %; an end's layer is 18/sqrt(24 0.7) = 4.39 mm long, so
# that of 100 mm each clamped end takes as many, 100/95.6 or 100/91.2.
SHEAR, ONE, TWO = "along local y by 10%", "in torsion by 5%", "in torsion by 10%"


def told(element, section, ends=((0, 0, 0), (0, 0, 0.1)), count=1, clamped=False, **options):
    """What is warned of beams in a row between ends, of which the first is clamped, and the last by a rigid beam."""
    b = fm.Builder()
    for i in range(count + 1):
        b.node(f"n{i}", [p + (q - p) * i / count for p, q in zip(*ends, strict=True)])
    for i in range(count):
        b.add(element, f"n{i}", f"n{i + 1}", section=section, name=f"l{i}", **options)
    b.fix("n0")
    if clamped:
        b.node("far", (0.05, 0.0, 0.1))
        b.add(spatial.rigid_beam, f"n{count}", "far")
    return heard(b)


def heard(b: fm.Builder) -> str:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", fm.BeamTheoryWarning)
        b.build()
    return " ".join(str(one.message) for one in caught if issubclass(one.category, fm.BeamTheoryWarning))


@pytest.mark.parametrize("count", [1, 4])
def test_a_strip_of_cubic_beams(count):
    """Beams in line are one leaf spring."""
    assert all(part in told(spatial.beam, STRIP, count=count) for part in (SHEAR, ONE))
    assert all(part in told(spatial.beam, STRIP, count=count, clamped=True) for part in (SHEAR, TWO))


def test_beams_along_an_arc_are_one_leaf_spring():
    """Sixteen beams of 6 mm along a quarter of a circle of 64 mm; by themselves each would lack 4 % of its bending."""
    b = fm.Builder()
    for i, angle in enumerate(np.linspace(0, np.pi / 2, 17)):
        b.node(f"n{i}", 0.064 * np.array([np.sin(angle), 1 - np.cos(angle)]))
    for i in range(16):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rectangle(0.018, 0.7e-3, STEEL))
    b.fix("n0")
    assert heard(b) == ""


@pytest.mark.slow
def test_what_is_stated_is_not_told():
    whole = fm.Rectangle(0.018, 0.5e-3, STEEL, shear=True, warping_length=0.1)
    assert told(spatial.beam, whole, count=2) == ""
    assert told(spatial.leaf_spring, STRIP) == ""
    sheared = fm.Rectangle(0.018, 0.5e-3, STEEL, shear=True)
    assert "along local" not in told(spatial.spectral_beam, sheared, shear=True)
    assert told(spatial.beam, sheared.rigidity()) == ""


def test_what_is_held_or_small_is_not_told():
    """Held are torsion and sideways bending of a lean model; wires and planar leaf springs are slender."""
    assert told(spatial.beam, STRIP, released=(1, 3, 4)) == ""
    assert told(spatial.beam, fm.Circle(0.5e-3, STEEL)) == ""
    assert told(planar.spectral_beam, STRIP, ends=((0, 0), (0.1, 0))) == ""
    # 2.6 (12 + 11 nu)/(10 (1 + nu)) (10/100)^2 = 3.06 %, and of a circle 2.6 (7 + 6 nu)/(8 (1 + nu)) (10/100)^2.
    thick = fm.Rectangle(0.018, 0.01, STEEL)
    assert "along local z by 3%" in told(planar.spectral_beam, thick, ends=((0, 0), (0.1, 0)))
    assert "along local z by 3%" in told(planar.leaf_spring, thick, ends=((0, 0), (0.1, 0)))
    assert told(planar.leaf_spring, thick, ends=((0, 0), (0.1, 0)), shear=True) == ""
    assert "along local z by 2%" in told(spatial.beam, fm.Circle(0.01, STEEL))


def test_a_warping_beam_without_shear():
    """It counts restrained warping, but not shear."""
    assert told(spatial.warping_beam, STRIP).startswith("Plain beams neglect effects on a stiffness: shear in bending")
    assert SHEAR in told(spatial.warping_beam, STRIP, count=2)
    assert "torsion" not in told(spatial.warping_beam, STRIP)
    assert told(spatial.warping_beam, fm.Rectangle(0.018, 0.5e-3, STEEL, shear=True)) == ""


def test_one_coefficient_of_a_curvature_that_varies():
    """n arcs of a guided leaf spring have 1 - 1/n^2 of its compliance, and one has none; of four, 1/15 lacks."""
    wire = fm.Rigidity(EA=1.0, EIy=1.0, EIz=1.0, GIt=1.0)
    alone = told(spatial.spectral_beam, wire, order=1)
    assert "varying curvature in bending by more than 9999% ('l0')" in alone
    assert "Count varying curvature by an order of 2 or more." in alone
    assert "bending by 7% ('l0' to 'l3')" in told(planar.spectral_beam, wire, ((0, 0), (0.1, 0)), count=4, order=1)
    assert told(planar.spectral_beam, wire, ((0, 0), (0.1, 0)), count=12, order=1) == ""
    assert told(planar.spectral_beam, wire, ((0, 0), (0.1, 0)), order=2) == ""
    assert told(planar.spectral_beam, wire, ((0, 0), (0.1, 0)), order=1, released=(4,)) == ""
    # The shear of a leaf spring does not count it.
    strip = fm.Rectangle(0.02, 0.3e-3, STEEL)
    leaf = told(planar.leaf_spring, strip, ((0, 0), (0.1, 0)), order=1, shear=True)
    assert "varying curvature in bending by more than 9999% ('l0'). Count varying curvature by an order of 2" in leaf
    assert told(planar.leaf_spring, strip, ((0, 0), (0.1, 0)), order=2, shear=True) == ""


def test_a_thick_section_does_not_warp_as_a_strip():
    """A square hardly warps, and a strip whose sides are swapped has the wrong decay length."""

    def of(wide, thick, **more):
        return fm.Rectangle(wide, thick, STEEL, shear=True, **more)

    square = told(spatial.beam, of(0.01, 0.01, warping_length=0.1))
    assert "Element 'l0' restrains its warping as a thin strip does, but it is 1 times as wide" in square
    assert "give the longer side as width" in told(spatial.beam, of(0.5e-3, 0.018, warping_length=0.1))
    assert "use spatial.beam" in told(spatial.warping_beam, of(0.01, 0.01))
    assert told(spatial.beam, of(0.018, 0.5e-3, warping_length=0.1)) == ""
    assert told(spatial.warping_beam, of(0.5e-3, 0.018)) == ""
    # Free ends restrain nothing.
    b = fm.Builder()
    b.node("first", (0, 0, 0))
    b.node("last", (0.1, 0, 0))
    b.add(spatial.warping_beam, "first", "last", section=of(0.01, 0.01), y=(0, 1, 0), clamped=(False, False))
    b.fix("first")
    assert "strip" not in heard(b)
    assert told(spatial.beam, of(0.01, 0.01, warping_length=0.1, clamped_ends=0)) == ""


def test_tubes_and_boxes():
    """Half of the area of a thin tube, and both webs of a box, carry a shear force."""
    # I = A r^2/2, k = 2 (1 + nu)/(4 + 3 nu): 12 EI/(GAk L^2) = 6 (4 + 3 nu) (r/L)^2 = 29.4 (9.5/100)^2 = 26.5 %.
    tube = told(spatial.beam, fm.Tube(0.02, 1e-3, STEEL))
    assert "along local z by 26%" in tube
    assert "along local y by 26%" in tube
    assert "Count shear by a Rigidity with shear_y and shear_z (and shear=True of a spectral_beam)." in tube
    assert "leaf_spring" not in tube
    assert told(planar.beam, fm.Tube(2e-3, 1e-4, STEEL), ends=((0, 0), (0.1, 0))) == ""
    # I = 2/3 t a^3, webs 2 t a: 12 EI/(G 2 t a L^2) = 4 E/G (a/L)^2 = 10.4 (20/100)^2 = 41.6 % for a thin box.
    box = fm.HollowRectangle(0.02, 0.02, 1e-5, 1e-5, STEEL)
    assert "along local y by 42%" in told(spatial.beam, box)
    assert "along local z by 42%" in told(spatial.beam, box)
    webs = fm.HollowRectangle(0.02, 0.02, 2e-5, 1e-5, STEEL)
    # Two walls are a quarter of I as webs and three quarters as flanges: EIy 5/4 over 2, and EIz 7/4 over 1.
    assert "along local z by 26%" in told(spatial.beam, webs)
    assert "along local y by 73%" in told(spatial.beam, webs)
    assert told(spatial.beam, fm.Rigidity(EA=1.0, EIy=1.0, EIz=1.0, GIt=1.0, shear_y=1e-4, outline=box)) == ""


@pytest.mark.slow
def test_sections_that_vary():
    """A taper is nearly its mean; at the centre of a notch hinge nothing bends, and its short neck cannot warp."""
    taper = fm.sections.taper(STRIP, fm.Rectangle(0.018, 0.4e-3, STEEL))
    assert "along local y by 10%" in told(spatial.spectral_beam, taper)
    notch = fm.sections.notch_circular(0.01, 5e-3, 0.3e-3, 5e-3, STEEL)
    found = told(spatial.spectral_beam, notch, ends=((0, 0, 0), (0, 0, 0.02)))
    # Trapezoidal rule over half of it, from the neck on.
    x = np.linspace(0, 0.01, 200001)
    t = np.where(x < np.sqrt(2.35e-3 * 7.65e-3), 0.3e-3 + 2 * (5e-3 - np.sqrt(np.maximum(25e-6 - x**2, 0))), 5e-3)
    shear = np.trapezoid(2.6 * 15.3 / 13 / t, x) / np.trapezoid(12 * x**2 / t**3, x)
    assert f"along local z by {shear:.0%}" in found
    assert int(found.split("in torsion by ")[1].split("%")[0]) > 1000


@pytest.mark.slow
def test_what_is_advised_is_what_can_be_done():
    """A leaf spring takes no breaks and no circle; what is advised leaves nothing to warn of."""
    notch, ends = (0.01, 5e-3, 0.3e-3, 5e-3, STEEL), ((0, 0, 0), (0, 0, 0.02))
    found = told(spatial.spectral_beam, fm.sections.notch_circular(*notch), ends=ends)
    assert "leaf_spring" not in found
    assert "Count shear by shear=True of the section (and of a spectral_beam) and warping by a row of" in found
    sheared = fm.sections.notch_circular(*notch, shear=True)
    assert "shear" not in told(spatial.spectral_beam(shear=True), sheared, ends=ends).replace("shear=True", "")
    pieces = [sheared.at((i + 0.5) / 10, 0.02) for i in range(10)]
    b = fm.Builder()
    for i in range(11):
        b.node(f"n{i}", (0, 0, 0.002 * i))
    for i, piece in enumerate(pieces):
        b.add(spatial.warping_beam, f"n{i}", f"n{i + 1}", section=piece)
    b.fix("n0")
    assert heard(b) == ""
    assert "leaf_spring" not in told(spatial.beam, fm.Circle(0.01, STEEL))
    strip = told(spatial.beam, STRIP)
    assert "A spatial.leaf_spring counts it. Or count shear by" in strip
    assert "and warping by warping_length= of the section." in strip
    thick = fm.Rectangle(0.018, 0.01, STEEL)
    assert "planar.leaf_spring(shear=True) counts it" in told(planar.spectral_beam, thick, ends=((0, 0), (0.1, 0)))
