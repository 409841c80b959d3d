"""Every step ends on the constraints: looked at in one coarse step, since what is given out is put onto them anyway."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import motions
from cases.tolerances import approx

import flexmb as fm
from flexmb.motion.coordinates_form import coordinates_form
from flexmb.motion.solver import MotionTerm, Projected


@pytest.mark.slow
@pytest.mark.parametrize("solver", [Projected(diffrax.Heun()), fm.motion.Rodas5P(), fm.motion.GeneralizedAlpha()])
def test_a_coarse_step_ends_on_the_constraints(solver):
    """A pendulum falls from the horizontal; its rod keeps its length, and its mass moves across the rod."""
    model = motions.pendulum().build()
    step = 0.2

    @jax.jit
    def stepped(x):
        form = coordinates_form(model.topology, model.parameters)
        start, term = form.state_of(x, jnp.zeros_like(x), None), MotionTerm(form)
        state, *_ = solver.step(term, 0.0, step, start, None, solver.init(term, 0.0, step, start, None), False)
        return form.whole_motion(step, state)[:2]

    places, velocities = stepped(model.parameters.reference)
    mass, rate = (np.asarray(of[model.labels.known("mass")]) for of in (places, velocities))
    # What two corrections leave of a gap of some hundredths; the velocity is corrected with the places before the last.
    assert np.linalg.norm(mass) == approx(1.0, abs=1e-7)
    assert mass @ rate == approx(0.0, abs=1e-4)
    # As far as it falls in that time, to the error of a coarse step.
    assert mass[1] == approx(-9.81 * step**2 / 2, rel=0.1)
