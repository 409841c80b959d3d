"""Configurations at given degrees of freedom, against closed forms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar


def rod(length):
    """A rigid rod about the origin, whose end is at x = 0.6 and therefore at y = sqrt(length^2 - 0.6^2)."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("end", (0.6, jnp.sqrt(length**2 - 0.36)))
    b.add(planar.truss, "pivot", "end", name="rod")
    b.fix("pivot")
    b.dof("end", "x")
    b.mass("end", 1.0)
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("outer", [jax.jacfwd, jax.jacrev])
def test_second_derivatives_of_a_configuration(outer):
    def height(length, moved):
        return fm.configuration(rod(length), moved[None]).at("end")[1]

    # Of y = sqrt(L^2 - (0.6 + q)^2) with L = 1 and q = 0.2: -(x/y)^2/y by L twice, L x/y^3 by both, -(L/y)^2/y by q.
    (by_length, both), (_, by_moved) = fm.jit(outer(jax.grad(height, (0, 1)), (0, 1)))(1.0, jnp.asarray(0.2))
    found = [float(one) for one in (by_length, both, by_moved)]
    assert found == approx([-0.64 / 0.216, 0.8 / 0.216, -1 / 0.216], rel=1e-12)


def crank(x, velocity):
    """A rod of length 1 about the origin, whose end is led along x from (0.6, 0.8)."""
    b = fm.Builder()
    b.node("p", (0, 0))
    b.node("m", (0.6, 0.8))
    b.rotation("r")
    b.add(planar.rigid_beam, "p", "r", "m", name="arm")
    b.fix("p")
    b.mass("m", 1.0)
    b.start("m", "x", x - 0.6, velocity=velocity)
    return b.build()


@pytest.mark.slow
def test_short_flexures_of_a_long_chain_are_no_dead_point():
    """What a notch of 1 mm turns moves the end of the chain by 10 m, and is as regular as that of a short one."""
    b = fm.Builder()
    b.node("n0", (0, 0))
    for i in range(10):
        b.node(f"m{i}", (i + 1e-3, 0))
        b.node(f"n{i + 1}", (i + 1, 0))
        b.add(planar.beam, f"n{i}", f"m{i}", name=f"notch{i}", section=fm.Rigidity(EA=1e6, EIy=1.0))
        b.add(planar.rigid_body, f"m{i}", f"n{i + 1}")
    b.fix("n0")
    model = b.build()
    bent = np.array([name.endswith(("2", "3")) for name in model.q_labels]) * 1e-6
    found = fm.configuration(model, bent)
    # An arc turns its chord by what an end does, e/l, and its last end by twice that.
    turned = -2e-3 * np.arange(11)
    chords = 1e-3 * (turned[:-1] - 1e-3), (1 - 1e-3) * turned[1:]
    assert found.at("n10")[1] == approx(np.sum(chords), rel=1e-3)


def test_prescribed_increments_are_left_out_with_a_warning():
    """A crank that an incremental load turns by 0.3 rad stays where it was placed; a force moves nothing here."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("end", (0.1, 0))
    b.add(planar.rigid_beam, "pivot", "end", name="crank")
    b.fix("pivot", "x", "y")
    b.force("end", (0.0, 1.0), increment=True)
    b.prescribe("pivot", "phi", 0.3)
    here = np.asarray(fm.configuration(b.build()).position("end"))
    np.testing.assert_allclose(here, [0.1 * np.cos(0.3), 0.1 * np.sin(0.3)], rtol=1e-12)
    b.prescribe("pivot", "phi", 0.3, increment=True)
    b.prescribe("pivot", "phi", 0.0)
    with pytest.warns(fm.FlexmbWarning, match=r"fm\.configuration leaves out .* build them without increment=True"):
        fm.configuration(b.build())


@pytest.mark.parametrize("away", [0.4, 1e-3, 1e-6, 1e-8])
def test_near_a_dead_point(away):
    """y = sqrt(1 - x^2): of the root of what is left round-off remains, and of the velocity its share of y."""
    x = 1 - away
    found = fm.configuration(crank(x, 0.01))
    y = np.sqrt((1 - x) * (1 + x))
    error = 4 * np.finfo(float).eps / y
    np.testing.assert_allclose(found.at("m"), [x, y], atol=error)
    np.testing.assert_allclose(found.velocity("m"), [0.01, -0.01 * x / y], rtol=10 * error / y)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("x", "velocity", "code"),
    [
        (1.0, 0.0, "singular_configuration"),
        (1.0, 1.0, "singular_configuration"),
        (1 - 1e-11, 0.01, "singular_configuration"),
        (1 + 1e-7, 0.0, "out_of_reach"),
        (1 + 1e-3, 1.0, "out_of_reach"),
    ],
)
def test_at_a_dead_point_and_beyond(x, velocity, code):
    for ask in (fm.configuration, lambda model: fm.simulate(model, np.linspace(0, 0.1, 3))):
        with pytest.raises(fm.AnalysisError) as fault:
            ask(crank(x, velocity))
        assert fault.value.code == code
