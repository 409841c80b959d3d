"""The loop of the default solver against that of diffrax, a peer: the same steps, states and failures."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from jax.tree_util import Partial

import flexmb as fm
from flexmb import planar
from flexmb.motion import Feedback, Rodas5P

DIFFRAX = Rodas5P()


def swinging(mass=2.0):
    """A mass on a soft bar that swings, and a force and a place by which it may be controlled."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (1.0, 0))
    b.add(planar.truss, "foot", "mass", name="bar", section=fm.Rigidity(EA=800.0), damping=fm.Damping(EA=1.0))
    b.fix("foot")
    b.mass("mass", mass)
    b.force("mass", (0, -9.0))
    b.input("mass", "y")
    b.output("mass", "y")
    return b.build()


MODEL = swinging()
# The first time is the start; others lie within one step and on the end.
TIMES = np.array([0.0, 1e-4, 1.1e-4, 0.3, 1.0])


def both(model=MODEL, times=TIMES, **options):
    return [fm.simulate(model, times, throw=False, solver=solver, **options) for solver in (None, DIFFRAX)]


def output(t, z, y, gain):
    return gain * z


def lag(t, z, y):
    return 5.0 * (y - z)


def loop(gain):
    """Feedback with a state of its own, whose error counts by itself; its first step is much too long and refused."""
    control = Feedback(Partial(output, gain=gain), lag, jnp.zeros(1))
    return dict(control=control, rtol=1e-7, dt0=0.5)


def test_states_and_steps_are_those_of_the_general_loop():
    for own, other in (both(), both(**loop(-3.0))):
        assert int(own.steps) == int(other.steps) > 10
        # Round-off of some hundred steps, of accelerations some 1e4 times as large.
        np.testing.assert_allclose(own.x, other.x, rtol=0, atol=1e-12)
        np.testing.assert_allclose(own.xd, other.xd, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(own.x[0], MODEL.parameters.reference)


@pytest.mark.slow("-motion_unfinished")
@pytest.mark.parametrize(
    ("options", "code"),
    [
        (dict(max_steps=5), "motion_unfinished"),
        (dict(model=swinging(mass=0.0)), "singular_mass"),
        (loop(1e6), "ran_away"),
    ],
    ids=lambda of: of if isinstance(of, str) else "",
)
def test_failures_are_those_of_the_general_loop(options, code):
    own, other = both(**options)
    assert {fm.RESULTS(int(found.result)).name for found in (own, other)} == {code}
    np.testing.assert_array_equal(np.isfinite(own.x), np.isfinite(other.x))
    # A motion that runs away gains energy, which the own loop alone looks at here: some steps more.
    assert int(own.steps) == approx(int(other.steps), abs=60 if code == "ran_away" else 0)


@pytest.mark.slow
def test_motions_of_a_batch_end_each_at_its_own_time():
    ends = jnp.array([0.2, 1.0])
    rows = jax.vmap(lambda end: fm.simulate(MODEL, jnp.stack([jnp.zeros(()), end])).x[-1])(ends)
    for row, end in zip(rows, ends, strict=True):
        alone = fm.simulate(MODEL, np.array([0.0, end]))
        np.testing.assert_allclose(row, alone.x[-1], rtol=0, atol=1e-10)
