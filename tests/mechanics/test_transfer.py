import jax
import jax.numpy as jnp
import numpy as np

import flexmb as fm
from flexmb import planar
from flexmb.mechanics.deformation import deformation_jacobian, transfer


def test_a_stiffness_along_the_degrees_of_freedom():
    """Of two rows of beams to one body: all but a few deformations are degrees of freedom."""
    b = fm.Builder()
    for side, y in (("left", 0.0), ("right", 0.5)):
        for i in range(9):
            b.node(f"{side}{i}", (i / 8, y))
        for i in range(8):
            b.add(planar.beam, f"{side}{i}", f"{side}{i + 1}", section=fm.Rigidity(EA=1e6, EIy=1.0))
        b.fix(f"{side}0")
    b.add(planar.beam, "left8", "right8")
    model = b.build()
    topology = model.topology
    _, jacobian = deformation_jacobian(topology, model.parameters, model.parameters.reference, jnp.zeros(topology.n_e))
    found = transfer(topology, jacobian)
    assert found.rows is not None
    # Deformations of the motions themselves, and a stiffness that is not symmetric; round-off.
    own = np.asarray(jacobian) @ np.asarray(found.DFx)
    np.testing.assert_allclose(found.DFe, own, rtol=0, atol=1e-12 * np.max(np.abs(own)))
    stiffness = np.random.default_rng(1).standard_normal((topology.n_e, topology.n_e))
    expected = own.T @ stiffness @ own
    close = {"rtol": 0, "atol": 1e-12 * np.max(np.abs(expected))}
    np.testing.assert_allclose(jax.jit(found.between)(stiffness), expected, **close)
