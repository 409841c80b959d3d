"""Linearised equations of a shallow truss: by hand below its limit load, and none beyond it."""

import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar

SPAN, HEIGHT, EA, MASS = 1.0, 0.2, 1e3, 2.0
LENGTH = np.hypot(SPAN, HEIGHT)
# Load of two bars whose apex stands at a height, and its greatest value on the way down.
HEIGHTS = np.linspace(HEIGHT, 0, 200001)


def carried(height):
    now = np.hypot(SPAN, height)
    return 2 * EA * (LENGTH - now) / LENGTH * height / now


LIMIT = np.max(carried(HEIGHTS))


def shallow(load) -> fm.Model:
    b = fm.Builder()
    for name, place in {"left": (-SPAN, 0), "apex": (0, HEIGHT), "right": (SPAN, 0)}.items():
        b.node(name, place)
    for name in ("left", "right"):
        b.add(planar.truss, name, "apex", name=f"{name} bar", section=fm.Rigidity(EA=EA))
        b.fix(name)
    b.fix("apex", "x")
    b.dof("apex", "y")
    b.mass("apex", MASS)
    b.force("apex", (0, -load))
    return b.build()


@pytest.mark.slow
def test_stiffness_and_mass_below_the_limit():
    height = 0.8 * HEIGHT
    lin = fm.linearize(shallow(carried(height)))
    assert lin.x[lin.labels.known("apex")][1] == approx(height, abs=1e-10)
    now = np.hypot(SPAN, height)
    force = EA * (now - LENGTH) / LENGTH
    # Of both bars: EA/l0 sin^2, and N/l cos^2.
    np.testing.assert_allclose(lin.K0, [[2 * EA / LENGTH * (height / now) ** 2]], rtol=1e-8)
    np.testing.assert_allclose(lin.G0, [[2 * force / now * (SPAN / now) ** 2]], rtol=1e-8)
    np.testing.assert_allclose(lin.M0, [[MASS]], rtol=1e-12)
    step = 1e-6
    slope = (carried(height - step) - carried(height + step)) / (2 * step)
    np.testing.assert_allclose(lin.K, [[slope]], rtol=1e-6)
    np.testing.assert_allclose(fm.frequencies(lin), np.sqrt(slope / MASS) / (2 * np.pi), rtol=1e-6)


@pytest.mark.slow("linearize", "frequencies")
@pytest.mark.parametrize("ask", [fm.linearize, fm.modes, fm.frequencies, fm.poles], ids=lambda f: f.__name__)
def test_beyond_the_limit_there_is_no_state_to_linearise_about(ask):
    with pytest.raises(fm.AnalysisError) as fault:
        ask(shallow(1.05 * LIMIT))
    assert fault.value.code in ("not_converged", "singular_stiffness")


def test_without_raising_the_code_says_so():
    lin = fm.linearize(shallow(1.05 * LIMIT), throw=False)
    assert fm.RESULTS(int(lin.result)) != fm.RESULTS.successful
    assert fm.RESULTS(int(fm.linearize(shallow(0.9 * LIMIT), throw=False).result)) == fm.RESULTS.successful


def test_mass_of_what_has_turned():
    """A rigid bar on a spring, turned by a moment: m l^3/3 and its rotary inertia, wherever it points."""
    mass, rotary, length, stiffness = 1.5, 0.02, 0.7, 2.0
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("end", (length, 0))
    b.rotation("ground")
    b.fix("pivot", "position")
    b.fix("ground")
    b.add(planar.beam, "pivot", "end", name="bar", section=fm.Rigidity(mass=mass, Jy=rotary), released=())
    b.add(planar.hinge, "ground", "pivot.rotation", name="spring", stiffness=stiffness)
    b.dof("pivot", "phi")
    b.force("end.rotation", (1.2,))
    lin = fm.linearize(b.build())
    assert lin.x[lin.labels.known("pivot.rotation")][0] == approx(0.6, rel=1e-9)
    np.testing.assert_allclose(lin.M0, [[mass * length**3 / 3 + rotary * length]], rtol=1e-9)
    np.testing.assert_allclose(lin.K, [[stiffness]], rtol=1e-9)
