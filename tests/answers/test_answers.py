"""Answers of the modes as plain numbers, against what statics says of them."""

import numpy as np

import flexmb as fm
from flexmb import spatial
from flexmb.answers.answers import answer


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
