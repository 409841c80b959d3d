"""What a concrete build refuses is NaN under a trace, where nothing can be raised."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import blocks, planar, sections, spatial

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)


def guide(thickness=0.5e-3, length=0.1, mass=0.5, element=None):
    """A stage on two leaf springs, whose motion along x they leave free."""
    b = fm.Builder()
    b.node("base", (0, 0))
    b.fix("base")
    blocks.parallel_guide(
        b, "base", "stage", length=length, spacing=0.05, section=fm.Rectangle(0.02, thickness, STEEL), element=element
    )
    b.body("stage", mass, inertia=1e-3)
    return b


def beam(element, section, last=(0.1, 0.0, 0.0), inertia=(1, 0, 0, 1, 0, 1), **own):
    """One beam in the plane, or in space where it has a direction, with a body at its end."""
    b = fm.Builder()
    size = 3 if "y" in own else 2
    b.node("foot", (0.0,) * size)
    b.node("tip", last[:size])
    b.add(element, "foot", "tip", section=section, **own)
    b.fix("foot")
    if size == 3:
        b.body("tip", 1.0, inertia=inertia)
    return b.build(check=False)


FLAT = fm.Rectangle(0.02, 1e-3, STEEL)
Y = {"y": (0.0, 1.0, 0.0)}
# A function that builds, a value that a concrete build takes, and those that it refuses.
CASES = {
    "thickness": (lambda v: guide(thickness=v).build(check=False), 5e-4, (-6e-4, 0.0)),
    "length of a block": (lambda v: guide(length=v).build(check=False), 0.1, (-0.1, 0.0)),
    "mass": (lambda v: guide(mass=v).build(check=False), 0.5, (-0.5, 0.0)),
    "modulus": (lambda v: beam(planar.beam, fm.Rectangle(0.02, 1e-3, fm.Material(v, 80e9))), 210e9, (-1.0, 300e9)),
    "Poisson's ratio": (
        lambda v: beam(planar.beam, fm.Rectangle(0.02, 1e-3, fm.Material(210e9, 80e9, nu=v))), 0.3, (0.5, -1.0)
    ),
    "rigidity": (lambda v: beam(planar.beam, fm.Rigidity(EA=1.0, EIy=v)), 1.0, (-1.0,)),
    "damping": (lambda v: beam(planar.beam, FLAT, damping=fm.Damping(EIy=v)), 1.0, (-1.0,)),
    "wall": (lambda v: beam(planar.beam, fm.Tube(0.01, v, STEEL)), 1e-3, (-1e-3, 6e-3)),
    "hole": (lambda v: beam(planar.beam, fm.HollowRectangle(0.02, 0.01, 1e-3, v, STEEL)), 1e-3, (6e-3,)),
    "no length": (lambda v: beam(planar.beam, FLAT, last=(v, 0.0)), 0.1, (0.0,)),
    "taper": (
        lambda v: beam(planar.spectral_beam(2), sections.taper(FLAT, fm.Rectangle(0.02, v, STEEL))), 2e-3, (-1e-3,)
    ),
    "break": (lambda v: beam(planar.spectral_beam(2), sections.stepped([FLAT, FLAT], [v])), 0.5, (-0.5, 1.5)),
    "notch": (
        lambda v: beam(planar.spectral_beam(3), sections.notch_circular(0.01, 5e-3, 5e-4, v, STEEL)),
        3e-3,
        (1e-3, -3e-3),
    ),
    "curvature": (lambda v: beam(planar.spectral_beam(2), FLAT, curvature=v), 1.0, (0.0, 30.0)),
    "axis across": (lambda v: beam(spatial.beam, FLAT, y=jnp.stack([1.0, v, 0.0])), 1.0, (0.0,)),
    "inertia": (lambda v: beam(spatial.beam, FLAT, inertia=(1, 0, 0, 1, 0, v), **Y), 1.0, (-1.0, 2.1)),
    "inertia as a matrix": (
        lambda v: beam(spatial.beam, FLAT, inertia=jnp.eye(3).at[0, 1].set(v), **Y), 0.0, (0.1,)
    ),
    "leaf spring": (lambda v: beam(spatial.leaf_spring(2), fm.Rectangle(0.02, v, STEEL), **Y), 1e-3, (-1e-3,)),
    "spring damper": (lambda v: beam(planar.truss, FLAT, last=(v, 0.0)), 0.1, (0.0,)),
}  # fmt: skip


def probe(model):
    """A number that depends on all numbers of a model."""
    return sum(jnp.sum(leaf) for leaf in jax.tree.leaves(model.parameters))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
@pytest.mark.parametrize("name", CASES)
def test_a_traced_build_is_nan_where_a_concrete_one_refuses(name):
    build, good, bad = CASES[name]
    build(good)
    for value in bad:
        with pytest.raises(fm.ModelError):
            build(value)
    found = jax.vmap(lambda value: probe(build(value)))(jnp.array([good, *bad]))
    np.testing.assert_array_equal(np.isnan(found), [False, *(True for _ in bad)])


def frequency(thickness):
    return fm.frequencies(
        guide(thickness, element=planar.beam).build(dofs=["stage.x", "stage.y", "stage.rotation.phi"])
    )[0]


@pytest.mark.slow
def test_a_frequency_below_zero_is_none():
    found = jax.vmap(frequency)(jnp.array([-0.6e-3, 0.6e-3]))
    np.testing.assert_array_equal(np.isnan(found), [True, False])
    assert np.isnan(fm.jit(frequency)(-0.6e-3))


@pytest.mark.slow
def test_derivatives_of_what_can_be_built_stay():
    """The factor that marks what cannot be is one: to the last digit of central differences."""
    found = jax.grad(frequency)(0.6e-3)
    step = 1e-7
    expected = (frequency(0.6e-3 + step) - frequency(0.6e-3 - step)) / (2 * step)
    # Differences: third derivative times step^2/6, relative to the slope (step/thickness)^2, some 3e-8.
    assert float(found) == approx(float(expected), rel=1e-6)
    assert np.isnan(jax.vmap(jax.grad(frequency))(jnp.array([-0.6e-3]))[0])


def test_what_is_computed_beside_a_model():
    """Numbers for a section that are made by functions of their own."""

    def torsion(width):
        return jnp.stack([sections.torsion_series(width, 1e-3), sections.torsion_approximate(width, 1e-3)])

    def others(length):
        return jnp.stack([
            sections.warping_factor(length, 0.02, 0.3), sections.damping_from_ratio(FLAT, length, 0.01).EIy
        ])  # fmt: skip

    for function in (torsion, others):
        found = jax.vmap(function)(jnp.array([0.02, -0.02]))
        assert np.all(np.isfinite(found[0]))
        assert np.all(np.isnan(found[1]))


def test_another_number_of_a_model():
    model = beam(planar.beam, FLAT)
    found = jax.vmap(lambda value: fm.mass(model.with_property("section.thickness", value)))(jnp.array([1e-3, -1e-3]))
    np.testing.assert_array_equal(np.isnan(found), [False, True])
