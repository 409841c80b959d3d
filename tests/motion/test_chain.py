"""Motion in the form of chains, against the dense form, whose answers other tests compare with references."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial

TIMES = np.linspace(0.0, 0.1, 6)
SECTION = fm.Rigidity(EA=1e4, EIy=1.0, EIz=1.3, GIt=0.8, mass=1.0, Jx=1e-3, Jy=5e-4, Jz=5e-4)


def foot(t):
    """Motion of the foot [m]."""
    return 0.05 * (1 - jnp.cos(20 * t))


def pendulum(beams: int):
    """Planar beams on a foot that is driven up and down; every second one keeps its length."""
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (i / beams, 0.0))
    for i in range(beams):
        released = [2, 3] if i % 2 else None
        own = {"section": SECTION, "damping": fm.Damping(EA=1.0, EIy=1e-2)}
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"rod {i + 1}", released=released, **own)
    b.fix("n0", "x")
    b.prescribe("n0", "y")
    b.mass(f"n{beams}", 0.2)
    b.force(f"n{beams}", (0.5, -1.0))
    b.gravity((0.0, -9.81))
    return b.build()


def arm(beams: int):
    """Spatial beams from a clamp."""
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (i / beams, 0.0, 0.0))
    for i in range(beams):
        b.add(spatial.beam, f"n{i}", f"n{i + 1}", name=f"rod {i + 1}", section=SECTION, y=(0, 1, 0))
    b.fix("n0")
    b.force(f"n{beams}", (0.0, 1.0, 0.7))
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("plane", [True, False])
def test_motion_and_what_follows_from_it_are_those_of_the_dense_form(plane):
    drives = {"motion": {"n0.y": foot}} if plane else {}
    model = pendulum(4) if plane else arm(3)
    dense = fm.simulate(model, TIMES, rtol=1e-8, **drives)
    chain = fm.simulate(model, TIMES, rtol=3e-8, form="chain", **drives)
    assert (chain.form, chain.solver) == ("chain", "Rodas5P")
    np.testing.assert_allclose(chain.x, dense.x, atol=1e-7)
    np.testing.assert_allclose(chain.xd, dense.xd, atol=1e-5)
    seen, wanted = chain.observe(), dense.observe()
    for name, tolerance in (("reactions", 1e-2), ("sigma", 1e-2), ("kinetic", 1e-6), ("elastic", 1e-5)):
        np.testing.assert_allclose(getattr(seen, name), getattr(wanted, name), atol=tolerance, err_msg=name)
    np.testing.assert_allclose(seen.potential, wanted.potential, atol=1e-6)
    np.testing.assert_allclose(seen.power, wanted.power, atol=1e-2)


def test_what_the_form_does_not_cover_is_refused_by_name():
    model = arm(1)
    with pytest.raises(ValueError, match="Leave `solver` out"):
        fm.simulate(model, TIMES, form="chain", solver=fm.motion.Rodas5P())
    with pytest.raises(fm.ModelError, match="traced"):
        jax.jit(lambda t: fm.simulate(model, t, form="chain", jumps=[0.05]).x)(TIMES)
    b = fm.Builder()
    b.node("p", (0.0, 0.0, 0.0))
    b.node("q", (1.0, 0.0, 0.0))
    b.add(spatial.beam, "p", "q", section=SECTION, y=(0, 1, 0))
    b.fix("p")
    b.force("q", (0.0, 1.0, 0.0), follower=True)
    with pytest.raises(fm.ModelError, match="a load that follows"):
        fm.simulate(b.build(), TIMES, form="chain")


@pytest.mark.slow
def test_many_beams_take_it_by_themselves_and_few_do_not(monkeypatch):
    model = arm(3)
    assert fm.simulate(model, TIMES, rtol=1e-8).form == "coordinates"
    monkeypatch.setattr("flexmb.motion.integrator.NET", 10)
    assert fm.simulate(model, TIMES, rtol=1e-7).form == "chain"
    # Fewer coordinates take dense matrices.
    assert fm.simulate(pendulum(2), TIMES, motion={"n0.y": foot}, rtol=1e-8).form == "coordinates"


@pytest.mark.slow
def test_a_motion_without_mass_is_named():
    b = fm.Builder()
    b.node("p", (0.0, 0.0))
    b.node("q", (1.0, 0.0))
    b.add(planar.beam, "p", "q", section=fm.Rigidity(EA=1e4, EIy=1.0, mass=0.0))
    b.fix("p")
    b.force("q", (0.0, 1.0))
    with pytest.raises(fm.AnalysisError, match="mass matrix is singular"):
        fm.simulate(b.build(), TIMES, form="chain")


@pytest.mark.slow
def test_why_a_chain_does_not_start_is_said():
    """A load that is no number is not called a missing mass."""
    load = {"loads": {"n2.x": lambda t: jnp.where(t < 0.05, 1.0, jnp.nan)}, "motion": {"n0.y": foot}}
    for form in ("chain", None):
        with pytest.raises(fm.AnalysisError, match=r"Load 'n2.x' is not finite at t = 0.05") as fault:
            fm.simulate(pendulum(2), TIMES, form=form, **load)
        assert fault.value.code == "not_finite"


def soft_pendulum(beams: int, held=True):
    """A pendulum that bends far while it turns, or a rod that falls."""
    section = fm.Rigidity(EA=1e5, EIy=1.0, mass=1.0)
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (i / beams, 0.0))
    for i in range(beams):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"rod {i + 1}", section=section)
    if held:
        b.fix("n0", "position")
    b.gravity((0.0, -9.81))
    return b.build()


@pytest.mark.slow
def test_its_motion_is_that_of_the_dense_form():
    model, times = soft_pendulum(8), np.array([0.0, 0.1, 0.3, 0.31, 0.6])
    # A first step that is too long and refused.
    own = fm.simulate(model, times, rtol=1e-5, form="chain", dt0=0.04)
    other = fm.simulate(model, times, rtol=1e-5, form="coordinates")
    # Ten times the tolerance of a step; stiff beams make velocities some hundred times as large.
    np.testing.assert_allclose(own.x, other.x, rtol=0, atol=1e-4)
    np.testing.assert_allclose(own.xd, other.xd, rtol=0, atol=1e-2)


@pytest.mark.slow
def test_too_few_steps_are_named():
    short = fm.simulate(soft_pendulum(2), TIMES, form="chain", max_steps=5, throw=False)
    assert fm.RESULTS(int(short.result)) == fm.RESULTS.motion_unfinished
    assert np.all(np.isfinite(short.x[0]))
    assert not np.any(np.isfinite(short.x[-1, 2:]))


@pytest.mark.slow
def test_its_failures_are_named():
    far = fm.simulate(soft_pendulum(2, held=False), [0.0, 1e5], form="chain", throw=False)
    assert fm.RESULTS(int(far.result)) == fm.RESULTS.ran_away
