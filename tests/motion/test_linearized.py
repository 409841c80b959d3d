"""Linearised equations about a steady rotation, against a spectral solution of the rotating beam."""

import jax.numpy as jnp
import numpy as np
from cases import motions
from jax.tree_util import Partial

import flexmb as fm


def test_rotating_cantilever_stiffens():
    """REFERENCES C3: first lead-lag frequency; a linear beam on the hub would soften and diverge beyond 3.516."""
    model = motions.rotor().build()
    for speed, expected in ((0.0, 3.5160153), (2.0, 3.6217970), (6.0, 4.2632254)):
        angle = Partial(motions.turned, speed=jnp.array(speed))
        lin = fm.motion.steady_motion(model, {"hub.rotation.phi": angle})
        found = np.sort(np.abs(np.imag(fm.poles(lin))))
        # Printed digits; the strain by the rotation is 2e-8 at EA = 1e9.
        np.testing.assert_allclose(found[0], expected, rtol=1e-6)
