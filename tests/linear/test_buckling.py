"""Load multipliers: under a preload, and by sparse factors."""

import numpy as np
import pytest
import scipy.linalg

import flexmb as fm
from flexmb import planar
from flexmb.mechanics.deformation import deformations, zero_near
from flexmb.mechanics.loads import LoadFactors
from flexmb.statics.sparse import assemble, balanced, elastic_stress


@pytest.mark.parametrize("preload", [(0.0, 0.5), (0.3, 1.0)])
def test_multipliers_under_a_preload_are_those_of_the_balance(preload):
    # What the increment adds to all stresses is the derivative of the balance by its factor, here by differences
    # of equilibria in all coordinates (1e-5: truncation 1e-9), and no choice of degrees of freedom changes it.
    def bent(dofs):
        b = fm.Builder()
        for i in range(5):
            b.node(f"n{i}", (i / 4, 0.0))
        for i in range(4):
            section = fm.Rigidity(EA=1e4, EIy=1.0)
            b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=section, released=(2, 3))
        b.fix("n0")
        b.force("n4", preload)
        b.force("n4", (-1.0, 0.1), increment=True)
        return b.build(dofs=dofs)

    model = bent([f"b{i}.e{j}" for i in range(4) for j in (2, 3)])
    other = bent([f"n{i}.{name}" for i in range(1, 5) for name in ("y", "rotation.phi")])
    topology, parameters = model.topology, model.parameters
    held = np.asarray(topology.e.held)

    def balance(factor):
        factors = LoadFactors(1.0, factor)
        at = balanced(topology, parameters, factors)
        near = deformations(topology, parameters, at.x, zero_near(topology))
        sigma = np.array(elastic_stress(topology, parameters, factors, near))
        sigma[held] = at.multipliers
        return at.x, near, sigma

    x, near, sigma = balance(0.0)
    added = (balance(1e-5)[2] - balance(-1e-5)[2]) / 2e-5
    stays, scaled = (
        assemble(topology, parameters, LoadFactors(1.0, 0.0), x, near, s).tangent.toarray()
        for s in (sigma, sigma + added)
    )
    n = len(topology.x.free)
    motions = scipy.linalg.null_space(stays[n:, :n])
    inverse = scipy.linalg.eigvals(
        -motions.T @ (scaled - stays)[:n, :n] @ motions, motions.T @ stays[:n, :n] @ motions
    ).real
    wanted = 1 / inverse[np.argsort(-np.abs(inverse))][:3]
    np.testing.assert_allclose(fm.buckling_loads(model)[:3], wanted, rtol=1e-7)
    np.testing.assert_allclose(fm.buckling_loads(other)[:3], wanted, rtol=1e-7)
