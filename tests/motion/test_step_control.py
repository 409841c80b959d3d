"""Step size control by displacements: against closed forms, and its rule case by case."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.motion.balance import at_start
from flexmb.motion.protocol import MotionState
from flexmb.motion.step_control import DisplacementController
from flexmb.numerical_limits import LARGE_DISPLACEMENT

RTOL = 1e-5
# Of a mass of 2 kg on a bar of 1 m [N].
STRETCHING = 800.0
RATE = np.sqrt(STRETCHING / 2.0)


def oscillator(damping=0.0):
    """A mass on a bar, with a damper [N s] in it."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (1.0, 0))
    b.add(planar.truss, "foot", "mass", name="bar", section=fm.Rigidity(EA=STRETCHING), damping=fm.Damping(EA=damping))
    b.fix("foot")
    b.fix("mass", "y")
    b.mass("mass", 2.0)
    b.dof("mass", "x")
    return b.build()


def released(model, amplitude, times):
    """Motion from rest, away from equilibrium by so much."""
    start = fm.configuration(model, q=jnp.array([amplitude]))
    return fm.simulate(model, times, initial=start, rtol=RTOL)


@pytest.mark.slow
def test_small_motions_are_as_accurate_as_large_ones():
    """Ten nanometres as a centimetre: ten periods, closed form; steps are those of the motion, not of its size."""
    times = np.linspace(0, 20 * np.pi / RATE, 31)
    model = oscillator()
    found = {size: released(model, size, times) for size in (1e-8, 1e-5, 1e-2)}
    for size, motion in found.items():
        moved = np.asarray(motion.at("mass"))[:, 0] - 1.0
        # 60 rad in phase, in some 110 steps.
        np.testing.assert_allclose(moved / size, np.cos(RATE * times), atol=30 * RTOL)
    steps = [int(motion.steps) for motion in found.values()]
    assert max(steps) <= 1.3 * min(steps)


@functools.partial(jax.jit, static_argnames="states")
def adapted(moved, zero, end, error, *, states):
    """What the controller makes of a step from 0 to 0.1 s: whether it is kept, the next one, the greatest size."""
    before = at_start()._replace(moved=jnp.asarray(moved))
    controller = DisplacementController(rtol=RTOL, atol=1e-12, before=before, states=states)
    first, state = controller.init(None, jnp.asarray(0.0), jnp.asarray(1.0), zero, jnp.asarray(0.1), None, None, 5)
    found = controller.adapt_step_size(jnp.asarray(0.0), first, zero, end, None, error, 5, state)
    keep, after, then, _, state, _ = found
    return keep, after, then, state[1].moved


def judged(error_u, error_w, *, moved=0.0, states=0, size=1e-3, speed=1.0):
    """Whether a step of 0.1 s with these errors is kept, the next step, and the greatest displacement after it.

    Displacements reach ``size``, velocities ``speed``.
    """
    none = np.zeros(0)
    error, zero = MotionState(error_u, error_w, none), MotionState(np.zeros(2), np.zeros(2), none)
    end = MotionState(np.array([size, 0.0]), np.full(2, speed), none)
    keep, after, then, greatest = adapted(moved, zero, end, error, states=states)
    return bool(keep), float(then - after), float(greatest)


@pytest.mark.slow("errors0-settings0-True", "errors1-settings1-False", "errors13-settings13-False")
@pytest.mark.parametrize(
    ("errors", "settings", "kept"),
    [
        (([0.9e-8, 0], [0, 0]), {}, True),  # a share of the greatest displacement,
        (([1.1e-8, 0], [0, 0]), {}, False),
        (([0, 0.9e-8], [0, 0]), {}, True),  # for another that has not moved as well,
        (([0, 1.1e-8], [0, 0]), {}, False),
        (([0, 1.1e-8], [0, 0]), {"moved": 2e-3}, True),  # or of what it was before,
        (([0, 0.9 * LARGE_DISPLACEMENT * 1e-5], [0, 0]), {"moved": 50.0}, True),  # but no more than of what is large,
        (([0, 1.1 * LARGE_DISPLACEMENT * 1e-5], [0, 0]), {"moved": 50.0}, False),
        (([0, 0], [0.9e-7, 0]), {}, True),  # velocities by what they do in a step of 0.1 s,
        (([0, 0], [1.1e-7, 0]), {}, False),
        (([0, 0], [0, 0.9e-5]), {"states": 1}, True),  # states of a controller each by its own size.
        (([0, 0], [0, 1.1e-5]), {"states": 1}, False),
        (([0, 0], [0, 1.1e-5]), {"states": 1, "speed": 1.2}, True),
        (([np.nan, 0], [0, 0]), {}, False),
        (([0, 0], [0, np.nan]), {}, False),
    ],
)
def test_what_is_kept(errors, settings, kept):
    keep, step, after = judged(*(np.asarray(error, float) for error in errors), **settings)
    assert keep == kept
    # A refused step is shortened, and does not count as a motion.
    assert (step >= 0.1) if kept else (0 < step < 0.1)
    before = min(settings.get("moved", 0.0), LARGE_DISPLACEMENT)
    assert after == (max(before, 1e-3) if kept else before)


@pytest.mark.slow
def test_parts_go_on_with_the_size_of_the_motion():
    """What has died out is not followed as closely as what there was: in parts as in the whole."""
    model = oscillator(damping=8.0)
    times = np.linspace(0, 40 * np.pi / RATE, 51)
    start = fm.configuration(model, q=jnp.array([1e-3]))
    whole, parts = (
        fm.simulate(model, times, initial=start, rtol=RTOL, progress=progress)
        for progress in (False, lambda done, of: None)
    )
    np.testing.assert_allclose(parts.x, whole.x, atol=10 * RTOL * 1e-3)
    # Each of the 50 parts begins with a step of its own.
    assert int(parts.steps) < int(whole.steps) + 100
