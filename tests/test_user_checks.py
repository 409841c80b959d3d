"""What a user's program asks of JAX about ranks and copies to a device, which is about that program alone."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

STEEL = fm.Material(E=210e9, G=80e9, rho=7850)


def guide(thickness):
    b = fm.Builder()
    for node, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(node, place)
    for p, q, thick in (("A", "B", thickness), ("D", "C", thickness), ("B", "C", 10e-3)):
        b.add(planar.beam, p, q, section=fm.Rectangle(0.018, thick, STEEL))
    b.fix("A")
    b.fix("D")
    b.force("C", (0.2, 0.0))
    b.input("B", "x")
    b.output("C", "x")
    return b.build()


def first(model):
    return fm.frequencies(model)[0]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
@pytest.mark.parametrize(
    "checked",
    [lambda: jax.numpy_rank_promotion("raise"), lambda: jax.transfer_guard("disallow")],
    ids=["ranks", "transfers"],
)
def test_answers_are_the_same_under_checks_of_a_user(checked):
    def answers():
        model = guide(0.5e-3)
        loads = {"B.x": lambda t: 0.1 * t}
        return [
            fm.frequencies(model),
            fm.equilibrium(model).x,
            fm.stress(model).von_mises,
            fm.compliance(model, "B"),
            fm.frequency_response(model, [1.0, 20.0]).response,
            fm.to_statespace(model).A,
            fm.simulate(model, [0.0, 0.01], loads=loads).x,
            fm.sweep(guide, {"f": first}, {"thickness": [0.4e-3, 0.5e-3]})["f"],
        ]

    expected = answers()
    with checked():
        found = answers()
    for own, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(own, other)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
def test_derivatives_under_a_check_of_ranks():
    """Copies to a device are not checked here: ``jax.grad`` itself makes one."""
    gradient = jax.grad(lambda t: jnp.sum(fm.frequencies(guide(t), count=2)))
    expected = gradient(0.5e-3)
    with jax.numpy_rank_promotion("raise"):
        assert gradient(0.5e-3) == expected
