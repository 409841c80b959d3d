"""Derivatives of elements in two stages, against those that JAX takes of the whole."""

import jax
import numpy as np
import pytest

import flexmb as fm
from flexmb import spatial
from flexmb.mechanics.blocks import each_block
from flexmb.mechanics.prepared import _prepared
from flexmb.mechanics.staged import Staged, curvature, derivative

SECTION = fm.Rectangle(0.018, 0.5e-3, fm.Material(E=210e9, G=80e9, rho=7850.0))


TAPER = fm.sections.taper(SECTION, fm.Rectangle(0.01, 0.4e-3, fm.Material(E=210e9, G=80e9, rho=7850.0)))


def one(element, section=SECTION, **properties):
    b = fm.Builder()
    b.node("foot", (0.0, 0.0, 0.0))
    b.node("tip", (0.1, 0.0, 0.0))
    b.add(element, "foot", "tip", section=section, y=(0.0, 1.0, 0.0), **properties)
    b.fix("foot")
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize(
    "model",
    [
        one(spatial.spectral_beam(3), curvature=(0.0, 2.0, 5.0)),
        one(spatial.spectral_beam(2), TAPER),
        # Warpings are inner coordinates too, between those of the nodes.
        one(spatial.leaf_spring(3), clamped=True),
    ],
    ids=["curved", "taper", "leaf"],
)
@pytest.mark.parametrize("companion", ["deformation", "inertia"])
def test_derivatives_in_two_stages_are_those_of_the_whole(model, companion):
    topology, parameters = model.topology, model.parameters
    generator = np.random.default_rng(0)
    staged = [
        of for of in each_block(topology, _prepared(topology, parameters), companion) if isinstance(of[1], Staged)
    ]
    ((block, function, ref, numbers),) = staged
    (whole,) = [of for of in each_block(topology, parameters, companion) if of[0] is block]
    x = np.asarray(ref)[0] + 0.05 * generator.standard_normal(block.x.shape[1])
    own, numbers = jax.tree.map(lambda leaf: leaf[0], (whole[2:], numbers))

    def first(found):
        return found if companion == "deformation" else found[0]

    expected = first(whole[1](x, *own))
    slopes, value = map(first, jax.jit(derivative(function))(x, ref[0], numbers))
    np.testing.assert_allclose(value, expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(first(function(x, ref[0], numbers)), expected, rtol=0, atol=1e-15)
    by_jax = jax.jit(jax.jacrev(lambda x: first(whole[1](x, *own))))(x)
    # Round-off.
    np.testing.assert_allclose(slopes, by_jax, rtol=0, atol=1e-14 * np.max(np.abs(by_jax)))
    if companion == "deformation":
        sigma = generator.standard_normal(expected.shape[0])
        by_jax = jax.jit(jax.hessian(lambda x: sigma @ whole[1](x, *own)))(x)
        found = jax.jit(curvature(function))(x, sigma, ref[0], numbers)
        np.testing.assert_allclose(found, by_jax, rtol=0, atol=1e-13 * np.max(np.abs(by_jax)))
