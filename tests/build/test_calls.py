"""The calls of a Builder, made again, build the same model."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.build.calls import replay
from flexmb.mechanisms import mechanism_path

from ..blocks.test_blocks import FRAMES, LEAF, STEEL
from ..cases import mechanisms, motions
from ..workbench.test_from_builder import check_same_contents, everything

SHIPPED = sorted(path.stem for path in Path(mechanism_path("pf2d")).parent.glob("*.dat"))
CASES = (
    *(lambda name=name: getattr(mechanisms, name)() for name in ("truss_guide", "planar_guide", "spatial_guide")),
    mechanisms.braced_rectangle,
    lambda: mechanisms.cross_pivot(0.5, 0.7),
    *(motions.pendulum, motions.double_pendulum, motions.slider_crank, motions.flexible_slider_crank, motions.rotor),
    *(motions.spinning_up, motions.shaft, motions.released_guide, motions.sprung_mass, motions.meshing_wheels),
    lambda: motions.four_bars(2),
    lambda: motions.thrown_at_a_stop(0.1),
    lambda: motions.spaghetti(4),
    lambda: everything(fm.Builder()),
)


def check_replays(builder: fm.Builder) -> None:
    """Same contents, and numbers and indices of the model equal to the last bit."""
    twin = fm.Builder()
    # A file may name rotations before positions.
    twin.dimension = builder.dimension
    replay(builder.calls, twin)
    check_same_contents(twin, builder)
    models = [one.build(check=False) for one in (twin, builder)]
    assert jax.tree.structure(models[0]) == jax.tree.structure(models[1])
    jax.tree.map(np.testing.assert_array_equal, *models)
    assert [one.method for one in twin.calls] == [one.method for one in builder.calls]


@pytest.mark.parametrize("name", SHIPPED)
def test_calls_of_a_shipped_mechanism(name):
    check_replays(fm.read_spacar(mechanism_path(name)).builder)


@pytest.mark.parametrize("k", range(len(CASES)))
def test_calls_of_a_builder(k):
    check_replays(CASES[k]())


@pytest.mark.parametrize("name", FRAMES)
def test_calls_of_a_block_are_those_of_its_parts(name):
    block, sizes, _ = FRAMES[name]
    b = fm.Builder()
    b.node("base", (0, 0, 0))
    block(b, "base", "stage", section=LEAF, **sizes)
    check_replays(b)


def test_named_degrees_of_freedom_are_calls():
    b = mechanisms.spatial_guide()
    model = b.build(release="auto")
    check_replays(b.with_dofs(model.q_labels))


def test_a_call_that_is_refused_or_changed_afterwards_leaves_no_trace():
    b, place = fm.Builder(), np.array([0.0, 0.0])
    b.node("A", place)
    place[0] = 1.0
    b.node("B", list(place))
    with pytest.raises(fm.ModelError):
        b.node("A", (1, 1))
    b.add(planar.truss, "A", "B", section=fm.Rigidity(EA=1.0))
    b.prestress("truss 1", *iter([1.0]))
    b.force("B", iter((1.0, 0.0)))
    assert [call.method for call in b.calls] == ["node", "node", "add", "prestress", "force"]
    assert b.calls[2].keywords["name"] == "truss 1"
    check_replays(b)
    twin = b.copy()
    twin.fix("A")
    assert len(b.calls) == 5


def test_calls_hold_traced_numbers():
    def energy(t):
        b = fm.Builder()
        b.node("A", (0, 0))
        b.node("B", (0.1, 0))
        b.add(planar.beam, "A", "B", section=fm.Rectangle(0.01, t, STEEL))
        twin = replay(b.calls, fm.Builder())
        return jnp.sum(twin.build(check=False).parameters.properties[0]["section"].thickness)

    assert jax.grad(energy)(1e-3) == 1.0
