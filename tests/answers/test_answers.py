"""Answers of the modes as plain numbers, against what statics says of them."""

import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.answers.answers import answer
from flexmb.answers.mode_1_simulate import _uniformly_accelerated
from flexmb.spacar.actions import RATES_IDLE


@pytest.mark.slow
def test_reactions_and_compliances_of_a_clamped_arm():
    """Force and moment of the clamp, of the equilibrium of the whole: the arm is that to where the tip came."""
    b = fm.Builder()
    b.node("1", (0, 0, 0))
    b.node("3", (1.0, 0, 0))
    section = fm.Rigidity(EA=1e5, GIt=20.0, EIy=30.0, EIz=10.0, mass=1.0, Jx=0.1, Jy=0.1, Jz=0.1)
    b.add(spatial.beam, "1", "3", name="1", section=section, y=(0, 1, 0))
    b.fix("1")
    b.force("3", (0.6, 0.4, -0.8))
    data = answer(b, "arm", 7, dofs="auto").data
    force, tip = np.array([0.6, 0.4, -0.8]), np.array(data["x"]["3"])
    assert np.linalg.norm(tip - [1, 0, 0]) > 0.01
    assert set(data["reactions"]) == {"1", "1.rotation"}
    np.testing.assert_allclose(data["reactions"]["1"], -force, atol=1e-9)
    np.testing.assert_allclose(data["reactions"]["1.rotation"], -np.cross(tip, force), atol=1e-9)


def test_what_falls_has_no_frequency():
    """A mass on an upright rod on a hinge with a spring: omega^2 = (k - F l)/(m l^2)."""
    k, m, length = 3.0, 0.4, 0.5
    for force, stable in ((4.0, True), (9.0, False)):
        b = fm.Builder()
        b.node("pivot", (0, 0))
        b.node("mass", (0, length))
        b.rotation("ground")
        b.rotation("rod")
        b.add(planar.rigid_beam, "pivot", "rod", "mass", name="bar")
        b.add(planar.hinge, "ground", "rod", name="spring", stiffness=k)
        b.fix("pivot", "position")
        b.fix("ground")
        b.mass("mass", m)
        b.dof("rod", "phi")
        b.force("mass", (0, -force))
        found = answer(b, "falling", 7)
        assert (found.exit_status, found.data["stable"], found.data["massless"]) == (0, stable, 0)
        square = (k - force * length) / (m * length**2)
        np.testing.assert_allclose(found.data["eigenvalues"], [square], rtol=1e-9)
        hertz = approx(np.sqrt(abs(square)) / (2 * np.pi), rel=1e-9)
        assert found.data["frequencies_hz"] == [hertz if stable else None]


def test_what_is_prescribed_with_an_acceleration():
    assert _uniformly_accelerated(2.0, 0.5, -1.0, 3.0) == 0.5 - 1.0 * 2.0 + 3.0 * 2.0**2 / 2


def shaft(torque: float, damping: float = 0.0):
    """A cantilever in space under an axial moment about a fixed axis, which has no potential."""
    b = fm.Builder()
    b.node("1", (0, 0, 0))
    b.node("3", (0.1, 0, 0))
    section = fm.Rigidity(EA=1e7, GIt=2.0, EIy=1.0, EIz=1.0, mass=1.0, Jx=1e-4, Jy=1e-4, Jz=1e-4)
    given = fm.Damping(GIt=2 * damping, EIy=damping, EIz=damping) if damping else None
    b.add(spatial.beam, "1", "3", name="1", section=section, y=(0, 1, 0), damping=given)
    b.fix("1")
    b.mass("3", 0.1)
    b.moment("3", (torque, 0.0, 0.0))
    return b


@pytest.mark.slow
def test_a_moment_about_a_fixed_axis_lets_motions_grow():
    """Ziegler: whatever its size, without damping; the symmetric part of the stiffness is positive definite."""
    unstable = answer(shaft(5.0), "shaft", 7, dofs="auto").data
    assert (unstable["status"], unstable["stable"]) == ("ok", False)
    assert max(re for re, _ in unstable["poles"]) > 1.0
    assert all(unstable[key] is None for key in ("eigenvalues", "frequencies_hz", "massless", "modes"))
    # Stiffness in proportion damps what is fast, so that a small moment makes nothing grow.
    damped = answer(shaft(0.05, 1e-3), "shaft", 7, dofs="auto").data
    assert max(re for re, _ in damped["poles"]) < 1e-6
    assert damped["stable"]
    buckled = answer(shaft(5.0), "shaft", 8, dofs="auto").data
    assert not buckled["stable"]
    assert any("complex: before it buckles the mechanism may flutter" in text for text in buckled["warnings"])


ROTOR = """PLRBEAM 2 3 4 5
X 3 0 0
X 5 0 {length}
FIX 3
DYNX 4 1
END
HALT
XM 5 {mass}
XF 4 1.0
ERROR 1e-4 1e-6
TIMESTEP 10 4
END
END
"""


@pytest.mark.slow
def test_tolerances_of_angles_do_not_depend_on_the_size_of_a_mechanism():
    """t^2/2 of a rotor of 1 kg m^2 under 1 N m: to 1e-4 rad in each of some steps, whatever its arm."""
    for length in (1.0, 1e-3):
        read = fm.read_spacar(ROTOR.format(length=length, mass=1 / length**2))
        # What is said of lines that static modes do not use is not said of this one.
        idle = [f"rotor:4: INPUTX: {RATES_IDLE}"]
        data = answer(read.builder, "rotor", 1, idle, settings=read.settings, progress=False).data
        assert data["warnings"] == []
        assert data["x"]["4"][0] == approx(50.0, abs=0.05)


@pytest.mark.slow
def test_warnings_of_a_motion_are_in_the_answer():
    """A beam that its load stretches by a tenth: cubic beams are inaccurate there, and mode 1 says so."""
    b = fm.Builder()
    b.node("1", (0.0, 0.0))
    b.node("2", (1.0, 0.0))
    b.add(planar.beam, "1", "2", name="1", section=fm.Rigidity(EA=10.0, EIy=1.0))
    b.fix("1")
    b.mass("2", 1.0, inertia=0.1)
    b.dof("2", "x", "y", "phi")
    b.force("2", (0.5, 0.0))
    b.force("2", (1.0, 0.0), increment=True)
    warnings = answer(b, "bar", 1, settings={"TIMESTEP": {"end": 1.0, "steps": 4}}, progress=False).data["warnings"]
    # Half a period of 2 s: twice the static strain of 0.05.
    assert any("strain along the beam reaches 0.1" in text for text in warnings)
    # Once, by the keywords of a file.
    assert [text for text in warnings if "ncremental loads" in text] == [
        "Incremental loads (DELXF, DELESIG, DELINPX, DELINPE) act in modes 8 and 10: mode 1 answers without them."
    ]
