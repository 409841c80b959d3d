"""What to release: the part with the largest share of a self-stress that statics gives by hand."""

import numpy as np
import pytest
from cases.mechanisms import braced_rectangle
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.checks.mobility import locked_inputs, removals
from flexmb.mechanics import deformation


@pytest.fixture(params=["whole", "in parts"], autouse=True)
def _whole_or_in_parts(request, monkeypatch):
    """Every mechanism here also as one of many coordinates, whose matrices are sparse."""
    if request.param == "in parts":
        monkeypatch.setattr(deformation, "MANY", 0)


def test_self_stress_of_a_braced_rectangle():
    model = braced_rectangle().build(check=False)
    assert model.counts() == {"nx": 8, "ne": 6, "nxo": 3, "neo": 6, "ndof": -1}
    found = fm.mobility(model)
    assert (found.overconstraints, found.underconstraints, found.status) == (1, 0, "overconstrained")
    shares = {share.of: share.share for share in found.stresses()}
    sign = np.sign(shares["ab"])
    expected = {"ab": 3, "cd": 3, "bc": 4, "da": 4, "ac": -5, "bd": -5}
    assert shares == approx({bar: sign * force / 5 for bar, force in expected.items()}, rel=1e-12)


@pytest.mark.parametrize(
    ("bars", "released"),
    [
        (("ab", "bc", "cd", "da", "ac", "bd"), "ac"),
        (("ab", "cd", "bd"), "bd"),
        (("ab", "bc", "cd"), "bc"),
        (("ab",), "ab"),
    ],
)
def test_the_bar_with_the_largest_force_is_released(bars, released):
    assert removals(braced_rectangle().build(check=False), [(bar, 1) for bar in bars]) == ((released, 1),)


def test_nothing_is_released_that_takes_no_part():
    """A beam that is clamped at both ends, and one that sticks out, which no self-stress reaches."""
    b = fm.Builder()
    for name, x in (("left", 0.0), ("middle", 1.0), ("right", 2.0), ("end", 3.0)):
        b.node(name, (x, 0))
    for p, q in (("left", "middle"), ("middle", "right"), ("right", "end")):
        b.add(planar.beam, p, q, name=f"{p} {q}", section=fm.Rigidity(EA=1.0, EIy=1.0), released=(2, 3))
    b.fix("left")
    b.fix("right")
    model = b.build(check=False)
    # Of the deformations that are held, a normal force in the first two beams.
    found = fm.mobility(model)
    assert found.overconstraints == 1
    assert found.release == (("left middle", 1),)
    assert {(s.of, s.component) for s in found.stresses()} == {("left middle", 1), ("middle right", 1)}
    assert "to remove it, release deformation 1 of element 'left middle'" in found.report()
    assert removals(model, [("right end", 1)]) == (None,)
    b.release("left middle", 1)
    assert fm.mobility(b.build(check=False)).overconstraints == 0


def test_forces_and_moments_of_a_self_stress_have_their_own_units():
    """An arm of half a metre that a hinge holds, and a bar at its end too: half a newton metre for every newton."""
    b = fm.Builder()
    for name, place in {"pivot": (0, 0), "end": (0.5, 0), "below": (0.5, -2)}.items():
        b.node(name, place)
    b.rotation("ground")
    b.rotation("arm")
    b.add(planar.rigid_beam, "pivot", "arm", "end", name="bar")
    b.add(planar.hinge, "ground", "arm", name="lock", released=())
    b.add(planar.truss, "end", "below", name="strut", released=())
    b.fix("pivot", "position")
    b.fix("below")
    b.fix("ground")
    found = fm.mobility(b.build(check=False))
    shares = {(share.of, share.component): abs(share.share) for share in found.stresses()}
    assert found.overconstraints == 1
    assert shares["lock", 1] / shares["strut", 1] == approx(0.5, rel=1e-12)
    assert shares["bar", 2] / shares["strut", 1] == approx(1.0, rel=1e-12)


def test_inputs_on_leaf_springs_are_looked_at_elsewhere_too():
    """The mechanism is looked at a little further along as well, where the inner coordinates of a leaf are zero too."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0, 0.1))
    leaf = fm.Rectangle(width=0.018, thickness=0.5e-3, material=fm.Material(E=210e9, G=80e9, rho=7850))
    b.add(planar.leaf_spring, "foot", "tip", name="leaf", section=leaf, order=2)
    b.fix("foot")
    b.mass("tip", 0.1, inertia=1e-4)
    b.dof("tip", "x")
    b.input("tip", "x")
    assert locked_inputs(b.build()) == []


def test_a_self_stress_of_many_parts_is_told_in_full():
    """Twelve rods end to end between two walls bear one force, each its share of one."""
    b = fm.Builder()
    for i in range(13):
        b.node(f"n{i}", (float(i), 0))
        if i:
            b.add(planar.truss, f"n{i - 1}", f"n{i}", name=f"rod {i}", released=())
        b.fix(f"n{i}", *(("x", "y") if i in (0, 12) else ("y",)))
    told = fm.mobility(b.build(check=False)).report()
    assert all(f"rod {i}.e1" in told for i in range(1, 13))
