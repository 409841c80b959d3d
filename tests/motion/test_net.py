"""Motion of nets, whose equations the host solves, against the dense form, whose answers other tests compare."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.mechanics.sparse_order import order_of
from flexmb.motion.chain_form import chain_form

TIMES = np.linspace(0.0, 0.05, 3)


@functools.cache
def net(n: int = 2, m: int = 3):
    """A lattice hung at its upper corners, one of its beams keeping its length; a spectral beam hangs below."""
    section = fm.Rigidity(EA=1e4, EIy=0.1, mass=0.1)
    b = fm.Builder()
    for i in range(n + 1):
        for j in range(m + 1):
            b.node(f"{i},{j}", (i / n, -j / n))
            if i:
                own = {"released": [2, 3]} if (i, j) == (2, 2) else {}
                b.add(planar.beam, f"{i - 1},{j}", f"{i},{j}", name=f"along {i},{j}", section=section, **own)
            if j:
                b.add(planar.beam, f"{i},{j - 1}", f"{i},{j}", name=f"down {i},{j}", section=section)
    b.node("tip", (1.0, -2.0))
    b.add(planar.spectral_beam(2), f"{n},{m}", "tip", name="tail", section=section)
    b.fix("0,0", "position")
    b.fix(f"{n},0", "position")
    b.gravity((0.0, -9.81))
    return b.build(check=False)


def large(monkeypatch):
    """Thirty beams count as many."""
    monkeypatch.setattr("flexmb.motion.integrator.NET", 10)


@pytest.mark.slow
def test_a_net_moves_as_the_dense_form_has_it(monkeypatch):
    dense = fm.simulate(net(), TIMES, rtol=1e-8)
    assert dense.form != "chain"
    large(monkeypatch)
    found = fm.simulate(net(), TIMES, rtol=1e-7)
    assert (found.form, found.solver) == ("chain", "Rodas5P")
    # Ten times the tolerance of a step; stiff beams make velocities some hundred times as large.
    np.testing.assert_allclose(found.x, dense.x, atol=1e-6)
    np.testing.assert_allclose(found.xd, dense.xd, atol=1e-4)
    assert np.max(np.ptp(found.x, axis=0)) > 0.005
    seen = found.observe()
    # Round-off of the constraints; a thousand tolerances of a step, as strains are small beside displacements.
    np.testing.assert_allclose(seen.e[:, np.asarray(net().topology.e.held)], 0.0, atol=1e-12)
    np.testing.assert_allclose(seen.energy, seen.energy[0], atol=1e-4 * np.max(seen.kinetic))


def bob(angle=1.0, mass=1e-6, g=9.81):
    """A mass on a rod, turned by an angle from below."""
    b = fm.Builder()
    b.node("a", (0.0, 0.0))
    b.node("bob", (np.sin(angle), -np.cos(angle)))
    b.add(planar.truss, "a", "bob")
    b.fix("a")
    b.mass("bob", mass)
    b.gravity((0.0, -g))
    return b.build(check=False)


@pytest.mark.slow
def test_too_little_memory_is_named(monkeypatch):
    def full(*_, **__):
        raise MemoryError

    monkeypatch.setattr("scipy.sparse.linalg.splu", full)
    with pytest.raises(fm.AnalysisError, match="memory does not suffice"):
        fm.simulate(bob(), TIMES, rtol=1e-7, form="chain")


def test_a_bob_of_a_milligram_falls_along_its_circle():
    """Closed form: g sin(a) along the tangent, m g cos(a) in the rod, at rest at an angle a from below."""
    angle, mass, g = 1.0, 1e-6, 9.81
    model = bob(angle, mass, g)

    @jax.jit
    def of(x):
        form = chain_form(model, (), order_of(model.topology))
        found, massive = form.acceleration(jnp.zeros(()), form.state_of(x, jnp.zeros_like(x), None))
        return found, massive, form.sizes

    found, massive, sizes = of(model.parameters.reference)
    assert massive
    # Coordinates are in extents.
    found = np.asarray(found) * np.append(sizes, 1.0)
    tangential = -g * np.sin(angle)
    wanted = [tangential * np.cos(angle), tangential * np.sin(angle), mass * g * np.cos(angle)]
    # What keeps redundant constraints solvable, 1e-8, is gone to its third power; round-off is left.
    np.testing.assert_allclose(found, wanted, rtol=1e-12)
