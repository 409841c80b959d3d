"""Responses and state spaces of large mechanisms by sparse matrices, against dense ones and differences."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0, damping=1e-5)
HERTZ = np.array([3.0, 20.0, 100.0, 400.0])


def arm(check=False):
    """Arm in space under its weight, with a rigid part, something prescribed and an elongation held."""
    section = fm.Rectangle(0.01, 1e-3, STEEL)
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    b.node("b", (0.1, 0, 0))
    b.node("c", (0.1, 0.03, 0))
    b.node("d", (0.1, 0.1, 0.02))
    b.add(spatial.beam, "a", "b", name="ab", section=section, y=(0, 1, 0), released=(2, 3, 4, 5, 6))
    b.add(spatial.beam, "b", "c", y=(0, 0, 1))
    b.add(spatial.beam, "c", "d", name="cd", section=section, y=(0, 0, 1))
    b.fix("a")
    b.mass("d", 0.02)
    b.gravity((0, 0.5, -9.81))
    b.prescribe("d", "z", 0.002)
    b.force("d", (0.3, 0.0, 0.0))
    for of, component, *quantity in (
        ("d", "x"),
        ("d.rotation", "rx"),
        ("cd", 3),
        ("d", "z", "displacement"),
        ("ab", 1, "displacement"),
        ("a", "x", "acceleration"),
        ("a.rotation", "ry", "velocity"),
    ):
        b.input(of, component, *quantity)
    for of, component, *quantity in (
        ("d", "y"),
        ("c", "x", "velocity"),
        ("d", "x", "acceleration"),
        ("b.rotation", "rz"),
        ("ab", 5),
        ("cd", 3, "stress"),
        ("d", "z", "reaction"),
        ("ab", 1, "stress"),
        ("a.rotation", "rz", "reaction"),
    ):
        b.output(of, component, *quantity)
    return b.build(check=check)


def rod(thickness=1e-3, check=False):
    """Clamped strip of six beams that its load bends, with a mass, driven by a force and by its clamp."""
    b = fm.Builder()
    for i in range(7):
        b.node(f"n{i}", (0.05 * i, 0.01 * i * (i % 2)))
    for i in range(6):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=fm.Rectangle(0.01, thickness, STEEL))
    b.fix("n0")
    b.mass("n3", 0.01)
    b.force("n6", (1.0, -0.2))
    b.input("n6", "y")
    b.input("n0", "y", "acceleration")
    b.output("n4", "y")
    b.output("b2", 3)
    b.output("n0", "y", "reaction")
    return b.build(check=check)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::flexmb.errors.FlexmbWarning")
@pytest.mark.parametrize("losses", [None, {"ab": 0.02}])
def test_responses_are_those_of_dense_matrices(losses):
    """Of all kinds of inputs and outputs; the equilibria agree to 1e-9 of the extent."""
    wanted = fm.frequency_response(arm(check=True), HERTZ, loss_factor=losses, method="direct")
    found = fm.frequency_response(arm(), HERTZ, loss_factor=losses, sparse=True)
    assert (found.inputs, found.outputs) == (wanted.inputs, wanted.outputs)
    off = np.abs(found.response - wanted.response) / np.max(np.abs(wanted.response), axis=0)
    assert np.max(off) < 1e-8
    one = fm.frequency_response(
        arm(), HERTZ[:2], inputs="force d.x", outputs="position d.y", loss_factor=losses, sparse=True
    )
    assert one.response.shape == (2, 1, 1)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*state space of.*:flexmb.FlexmbWarning")
@pytest.mark.parametrize("kept", [{"modes": 3}, {"modes": [0, 2]}, {"bandwidth": 200.0}])
def test_state_spaces_are_those_of_dense_matrices(kept):
    wanted: Any = fm.to_statespace(rod(check=True), **kept)
    found: Any = fm.to_statespace(rod(), sparse=True, **kept)
    assert found.state_labels == wanted.state_labels
    one, other = (np.array([system(2j * np.pi * f) for f in HERTZ]) for system in (wanted, found))
    assert np.max(np.abs(one - other) / np.max(np.abs(one), axis=0)) < 1e-8
    # Measured at other frequencies.
    assert np.max(found.truncation_error) == approx(np.max(wanted.truncation_error), rel=0.2)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*state space of.*:flexmb.FlexmbWarning")
def test_derivatives_are_those_of_central_differences():
    def answers(thickness):
        large = fm.linearize(rod(thickness), sparse=True)
        response = fm.frequency_response(large, HERTZ[:2], loss_factor=0.01).response[:, :2]
        system, _ = fm.control.state_matrices(large, modes=2)
        size = len(system.A)
        at = system.C.astype(complex) @ jnp.linalg.solve(
            100j * np.eye(size) - system.A.astype(complex), system.B.astype(complex)
        )
        at = at + system.D.astype(complex)
        return jnp.log(jnp.abs(jnp.concatenate([response.ravel(), at[:2].ravel()])))

    start, h = 1e-3, 1e-6
    near = {i: answers(start + i * h) for i in (-2, -1, 1, 2)}
    difference = (8 * (near[1] - near[-1]) - (near[2] - near[-2])) / (12 * h)
    # Truncation (h/t)^4, and the equilibrium's 1e-10 over h.
    found = jax.jacrev(answers)(start)
    np.testing.assert_allclose(found, difference, rtol=1e-5, atol=1e-6 * np.max(np.abs(difference)))


@pytest.mark.slow
def test_what_is_refused():
    large = fm.linearize(rod(), sparse=True)
    with pytest.raises(NotImplementedError, match="no sum over all modes"):
        fm.frequency_response(large, HERTZ, method="modes")
    with pytest.raises(ValueError, match="a choice of few modes"):
        fm.to_statespace(large)
    with pytest.raises(ValueError, match="below the first mode"):
        fm.to_statespace(large, bandwidth=1e-3)
    with pytest.raises(ValueError, match="a constant velocity or acceleration"):
        fm.frequency_response(large, 0.0)
    with pytest.raises(ValueError, match="no element is of"):
        fm.frequency_response(large, HERTZ, loss_factor={"nobody": 0.1})


@pytest.mark.slow
def test_an_input_on_what_constraints_hold_is_refused():
    b = fm.Builder()
    for name, at in (("wall", (0.0, 0.0)), ("block", (0.0, 0.1)), ("tip", (0.2, 0.1))):
        b.node(name, at)
    b.add(planar.rigid_body, "wall", "block")
    b.add(planar.beam, "block", "tip", section=fm.Rectangle(0.01, 1e-3, fm.Material(E=210e9, G=80e9, rho=7850.0)))
    b.fix("wall")
    b.output("tip", "y")
    b.input("block", "y", name="push")
    model = b.build(check=False)
    with pytest.raises(fm.ModelError, match=r"'push'.* moves nothing"):
        fm.frequency_response(model, [1.0], sparse=True)
    with pytest.raises(fm.ModelError, match=r"'push'.* moves nothing"):
        fm.to_statespace(model, modes=2, sparse=True)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:The state space of 2")
def test_known_equations_within_a_trace_of_other_numbers():
    """What is known is computed with on the host, also where frequencies or a loss factor alone are traced."""
    lin, hertz = fm.linearize(arm(), sparse=True), jnp.asarray(HERTZ[:2])

    def size(hertz, loss):
        return jnp.sum(jnp.abs(fm.frequency_response(lin, hertz, loss_factor=loss).response))

    known = float(size(hertz, 0.02))
    value, slopes = jax.jit(jax.value_and_grad(size, (0, 1)))(hertz, 0.02)
    assert float(value) == approx(known, rel=1e-12)
    step = 1e-5
    by_loss = float(size(hertz, 0.02 + step) - size(hertz, 0.02 - step)) / (2 * step)
    shift = jnp.array([step, 0.0])
    by_first = float(size(hertz + shift, 0.02) - size(hertz - shift, 0.02)) / (2 * step)
    # Truncation and round-off of the differences.
    assert float(slopes[1]) == approx(by_loss, rel=1e-6)
    assert float(slopes[0][0]) == approx(by_first, rel=1e-6)
    strip = fm.linearize(rod(), sparse=True)
    few = fm.control.state_matrices(strip, modes=2)[0]
    within = jax.jit(lambda share: share * fm.control.state_matrices(strip, modes=2)[0].B)(2.0)
    np.testing.assert_allclose(within, 2 * np.asarray(few.B), rtol=1e-12)
