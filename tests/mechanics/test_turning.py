"""What turns as a whole keeps its forces: those of elastic chains, turned by the places of their unknowns."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.math.rigid import compose_turns
from flexmb.math.rotation import rotation_matrix, rotation_plane
from flexmb.mechanics.levels import levels_of
from flexmb.motion.chain_form import chain_form
from flexmb.motion.protocol import MotionState

SECTION = fm.Rigidity(EA=1e4, EIy=1.0, EIz=1.3, GIt=0.8, mass=1.0, Jx=1e-3, Jy=5e-4, Jz=5e-4)


def rod(space: bool):
    """Two free beams; in space the first is rigid to stretching, so that there is a multiplier more."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.5 * i, 0.1 * i, 0.0) if space else (0.5 * i, 0.1 * i))
    for i in range(2):
        own = {"y": (0, 1, 0), "released": [2, 3, 4, 5, 6] if i else None} if space else {}
        element = spatial.beam if space else planar.beam
        b.add(element, f"n{i}", f"n{i + 1}", name=f"rod {i}", section=SECTION, **own)
    return b.build()


@pytest.mark.slow("False")
@pytest.mark.parametrize("space", [False, True])
def test_forces_turn_with_the_mechanism(space):
    model, random = rod(space), np.random.default_rng(5)
    levels = levels_of(model.topology)
    turning, entries = levels.turning, model.labels.x
    before = np.asarray(model.parameters.reference) + 0.05 * random.standard_normal(model.topology.n_x)
    places = {}
    for number, entry in enumerate(entries):
        places.setdefault((entry.kind, entry.of), []).append(number)
    after = before.copy()
    turn = random.standard_normal(4)
    turn /= np.linalg.norm(turn)
    for (kind, _), own in places.items():
        if kind == "position":
            matrix = rotation_matrix(turn) if space else rotation_plane(jnp.array(0.7))
            after[own] = np.asarray(matrix) @ before[own]
        elif space:
            before[own] /= np.linalg.norm(before[own])
            after[own] = np.asarray(compose_turns(turn, before[own]))
        else:
            after[own] = before[own] + 0.7
    assert turning.vectors.shape == ((3, 3) if space else (3, 2))
    assert turning.parameters.shape == ((3, 4) if space else (0, 4))
    turns = jax.jit(turning.since)(jnp.asarray(after), jnp.asarray(before))
    z = jnp.asarray(random.standard_normal(len(levels.back)))

    @jax.jit
    def force(x, z):
        form = chain_form(model, (), levels)
        state = form.state_of(jnp.asarray(x), jnp.zeros(len(before)), None)
        return form.residual(0.0, MotionState(state.u, jnp.zeros(form.size), state.memory), z)

    turned_by = jax.jit(turning.turned)
    turned = turned_by(turns, z)
    # Round-off of forces of some 1e4 N.
    np.testing.assert_allclose(force(after, turned), turned_by(turns, force(before, z)), rtol=0, atol=1e-10)
    np.testing.assert_allclose(jax.jit(turning.turned_back)(turns, turned), z, rtol=0, atol=1e-14)
