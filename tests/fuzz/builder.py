"""Random calls of a Builder, right ones and broken ones: a call is done or refused by name, and then leaves nothing.

``cases(seed)`` yields cases without end, the same for the same seed; ``run(case)`` makes the calls on a Builder and
builds. It returns what happened in a word, and raises what must not. What is built whole is a mechanism whose degrees
of freedom determine it; of most cases only the counts and numbers of an unchecked model are looked at, since each shape
of mechanism that is checked is compiled.
"""

import dataclasses
import random
import warnings
from collections.abc import Iterator
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import flexmb as fm
from flexmb import planar, spatial
from flexmb.checks.mobility import allowed_motions

# Share of arguments that are broken, and of mechanisms that are checked whole.
SHARE_BROKEN, SHARE_WHOLE = 0.12, 0.1
MOST_CALLS = 12

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)
LEAF = fm.Rectangle(0.018, 5e-4, STEEL)
NAMES = ("A", "B", "C", "leaf", "bar", "A.rotation", "R")
BROKEN_NAMES = (
    "",
    " ",
    None,
    3,
    1.5,
    True,
    "Z",
    "a\nb",
    "ü",
    ("A",),
    "A.x",
    "leaf.e1",
    "mass A 1",
    "B.rotation.rotation",
)
BROKEN_NUMBERS = (
    float("nan"),
    float("inf"),
    1e308,
    -1e308,
    1e-320,
    "1",
    "",
    None,
    True,
    [1.0],
    (),
    {},
    1j,
    b"1",
    object,
)
BROKEN_VALUES = (*BROKEN_NUMBERS, *BROKEN_NAMES, np.zeros(3), np.zeros((2, 2)), fm, planar.beam, lambda: 1)
COMPONENTS = ("x", "y", "z", "phi", "l1", "l0", "rx", "rz", "position", "rotation", 1, 2, 3, "1", "4")
BROKEN_COMPONENTS = (0, -1, 1.5, 99, None, True, "²", "", "q", "X", ["x"], (1, 2), np.array([1, 2]))


def own(p: fm.Point2, q: fm.Point2, *, ref, gain: float = 1.0):
    """Change of the distance of two points, times a number."""
    return gain * (jnp.sqrt((q - p) @ (q - p)) - jnp.sqrt((ref.q - ref.p) @ (ref.q - ref.p)))[None]


def hard(e, *, ref, k: float, cubic: float):
    """Energy of a spring that hardens."""
    return k * e[0] ** 2 / 2 + cubic * e[0] ** 4


def buffer(e, ed, *, gap: float, drag: float = 0.0):
    """Force of a buffer."""
    return -jnp.maximum(-e - gap, 0.0) * (1 - drag * ed)


def squared(p: fm.Point2, q: fm.Point2, *, ref):
    """Not zero in the undeformed mechanism."""
    return ((q - p) @ (q - p))[None]


HARD = fm.Element(own, energy=hard)
# Element types by dimension, with properties that may be given.
TYPES: dict[int, list[tuple[Any, dict[str, Any]]]] = {
    2: [
        (planar.truss, {"section": LEAF}),
        (planar.beam, {"section": LEAF, "damping": fm.Damping(EIy=1e-3), "second_order": False}),
        (planar.spectral_beam(2), {"section": LEAF, "curvature": 2.0, "order": 2}),
        (planar.rigid_beam, {"section": fm.Rigidity(mass=1.0)}),
        (planar.rigid_body, {"section": fm.Rigidity(mass=1.0)}),
        (planar.hinge, {"stiffness": 2.0, "damping": 0.1}),
        (planar.slider, {"axis": (1.0, 0.0), "stiffness": 3.0}),
        (planar.gear, {"ratio": 2.0, "stiffness": 1.0}),
        (planar.belt_to_point, {"radius_p": 0.01, "section": LEAF}),
        (HARD, {"k": 1.0, "cubic": 2.0, "gain": 2.0}),
        (planar.spring_damper, {"law": buffer, "gap": 0.01, "drag": 1.0}),
        (own, {"gain": 3.0}),
        (squared, {}),
    ],
    3: [
        (spatial.truss, {"section": LEAF}),
        (spatial.beam, {"section": LEAF, "y": (0.0, 1.0, 0.0), "damping": fm.Damping(GIt=1.0)}),
        (spatial.rigid_beam, {"section": fm.Rigidity(mass=1.0)}),
        (spatial.rigid_body, {"section": fm.Rigidity(mass=1.0)}),
        (spatial.hinge, {"axis": (0.0, 0.0, 1.0), "stiffness": (1.0, 2.0, 3.0)}),
        (spatial.slider, {"axis": (1.0, 0.0, 0.0)}),
        (spatial.screw, {"axis": (1.0, 0.0, 0.0), "pitch": 0.01}),
    ],
}


@dataclasses.dataclass(frozen=True)
class Case:
    """Calls of a Builder.

    Attributes:
        calls: Name of the method, positional arguments and arguments by name.
        options: Of ``build``.
        whole: Whether the mechanism is checked.
    """

    calls: tuple[tuple[str, tuple, dict[str, Any]], ...]
    options: dict[str, Any]
    whole: bool


class _Draw:
    """Arguments of calls, some of them broken."""

    def __init__(self, draw: random.Random):
        self.draw = draw
        self.dimension = draw.choice((2, 2, 3))
        # Some cases have no broken argument at all.
        self.share = draw.choice((0.0, SHARE_BROKEN, 2 * SHARE_BROKEN))

    def broken(self, right: Any, wrong: tuple) -> Any:
        return self.draw.choice(wrong) if self.draw.random() < self.share else right

    def name(self) -> Any:
        return self.broken(self.draw.choice(NAMES), BROKEN_NAMES)

    def number(self) -> Any:
        return self.broken(self.draw.choice((0.0, 1.0, -0.5, 0.1, 2, np.float64(0.3), jnp.array(0.2))), BROKEN_VALUES)

    def vector(self, size: int | None = None) -> Any:
        count = self.broken(self.dimension if size is None else size, (0, 1, 2, 3, 4))
        given = [self.number() for _ in range(count)]
        if self.draw.random() < 0.2 and all(isinstance(v, float) for v in given):
            return np.array(given)
        return self.broken(tuple(given), BROKEN_VALUES)

    def component(self) -> Any:
        return self.broken(self.draw.choice(COMPONENTS), BROKEN_COMPONENTS)

    def some(self, what, most: int = 3) -> tuple:
        return tuple(what() for _ in range(self.draw.randrange(most + 1)))

    def sometimes(self, **options: Any) -> dict[str, Any]:
        return {name: what() for name, what in options.items() if self.draw.random() < 0.3}

    def flag(self) -> Any:
        return self.broken(self.draw.random() < 0.5, (None, "no", 2, "True"))

    def call(self) -> tuple[str, tuple, dict[str, Any]]:
        method = self.draw.choice(sorted(METHODS))
        return (method, *METHODS[method](self))

    def add(self) -> tuple[tuple, dict[str, Any]]:
        dimension = self.broken(self.dimension, (2, 3))
        element, known = self.draw.choice(TYPES[dimension])
        element = self.broken(element, (None, "beam", planar, fm.Rectangle, planar.spectral_beam, 3, lambda p, q: p))
        given = {key: self.broken(value, BROKEN_VALUES) for key, value in known.items() if self.draw.random() < 0.8}
        if self.draw.random() < self.share:
            given[self.draw.choice(("sections", "k", "ref", "near", "incremental"))] = 1.0
        nodes = tuple(self.name() for _ in range(self.broken(2, (0, 1, 3, 4, 5))))
        options = self.sometimes(name=self.name)
        if self.draw.random() < 0.3:
            options["released"] = self.broken(
                self.draw.choice(("all", (), (1,), (2, 3))), (None, "none", 1, (0,), (9,), (1.5,))
            )
        return (element, *nodes), {**given, **options}

    def tilt(self) -> str:
        return self.draw.choice(("free", "fixed", "no"))

    def quantity(self) -> str:
        return self.draw.choice(("velocity", "stress", "speed"))

    def kind(self) -> Any:
        return self.broken(self.draw.choice(("node", "element", None)), ("nodes", 1))


METHODS: dict[str, Any] = {
    "node": lambda d: ((d.name(), d.vector()), {}),
    "rotation": lambda d: ((d.name(),), d.sometimes(start=lambda: d.vector(1 if d.dimension == 2 else 4))),
    "add": _Draw.add,
    "release": lambda d: ((d.name(), *d.some(d.component)), {}),
    "fix": lambda d: ((d.name(), *d.some(d.component)), {}),
    "dof": lambda d: ((d.name(), *d.some(d.component)), d.sometimes(kind=d.kind)),
    "prescribe": lambda d: (
        (d.name(), d.component(), d.number()),
        d.sometimes(increment=d.flag, axis=lambda: d.vector(3), tilt=d.tilt, kind=d.kind),
    ),
    "start": lambda d: ((d.name(), d.component(), d.number()), d.sometimes(velocity=d.number, kind=d.kind)),
    "mass": lambda d: ((d.name(), d.number()), d.sometimes(inertia=d.number)),
    "inertia": lambda d: ((d.name(), d.draw.choice((d.number(), d.vector(6), np.eye(3)))), {}),
    "force": lambda d: ((d.name(), d.vector()), d.sometimes(increment=d.flag, follower=d.flag)),
    "moment": lambda d: (
        (d.name(), d.draw.choice((d.number(), d.vector(3)))), d.sometimes(increment=d.flag, follower=d.flag)
    ),
    "gravity": lambda d: ((d.vector(),), d.sometimes(increment=d.flag)),
    "prestress": lambda d: ((d.name(), *d.some(d.number)), d.sometimes(increment=d.flag)),
    "strain": lambda d: ((d.name(), *d.some(d.number)), {}),
    "input": lambda d: ((d.name(), d.component()), d.sometimes(name=d.name, kind=d.kind, local=d.flag)),
    "output": lambda d: (
        (d.name(), d.component()),
        d.sometimes(quantity=d.quantity, name=d.name, kind=d.kind, local=d.flag),
    ),
}  # fmt: skip


def cases(seed: int) -> Iterator[Case]:
    """Random calls, the same for the same seed.

    Args:
        seed: Of the random numbers.
    """
    draw = random.Random(seed)
    while True:
        made = _Draw(draw)
        space = made.dimension == 3
        # A mechanism to begin with, so that calls find something to be about.
        first: list[tuple[str, tuple, dict[str, Any]]] = [
            ("node", ("A", (0.0, 0.0, 0.0)[: made.dimension]), {}),
            ("node", ("B", (0.1, 0.0, 0.0)[: made.dimension]), {}),
            ("add", (spatial.beam if space else planar.beam, "A", "B"), {"name": "leaf", "section": LEAF}),
            ("fix", ("A",), {}),
        ]
        for i in reversed(range(len(first))):
            if draw.random() < 0.1:
                del first[i]
        more = [made.call() for _ in range(draw.randrange(MOST_CALLS))]
        options = made.sometimes(
            dofs=lambda d=made: d.broken(draw.choice(("auto", "named")), ("none", None, 1)),
            release=lambda d=made: d.broken(draw.choice(("auto", "none")), ("all", True)),
        )
        yield Case((*first, *more), options, draw.random() < SHARE_WHOLE)


def _snapshot(b: fm.Builder) -> Any:
    """All that a builder holds, to be compared."""
    nodes = [(n, node.kind, [id(v) for v in node.start], list(node.roles)) for n, node in b.nodes.items()]
    members = [(n, m.element, m.nodes, sorted(m.properties), list(m.roles)) for n, m in b.members.items()]
    loads = {
        k: {n: [(key, id(v)) for key, v in own.items()] for n, own in sets.items() if own}
        for k, sets in b.loads.items()
    }
    starts = [(key, id(v)) for key, pair in b.starts.items() for v in pair]
    return nodes, members, list(b.dofs), loads, {k: list(v) for k, v in b.signals.items()}, starts, b.dimension


def _call(b: fm.Builder, method: str, arguments: tuple, options: dict[str, Any]) -> bool:
    """Whether a call was done; one that was not must leave the builder as it was."""
    before, refusal = _snapshot(b), None
    try:
        getattr(b, method)(*arguments, **options)
    except fm.ModelError as fault:
        refusal = str(fault)
    if refusal is not None:
        assert 0 < len(refusal.strip()) < 2000, f"a refusal that says nothing, or does not end: {refusal[:80]}"
        assert _snapshot(b) == before, f"{method} was refused ({refusal}), but changed the builder"
    return refusal is None


def _check_model(model: fm.Model) -> None:
    """What holds for every model, checked or not."""
    t, labels = model.topology, model.labels
    assert (t.n_x, t.n_e) == (len(labels.x), len(labels.e))
    assert len({str(e) for e in labels.x}) == t.n_x
    for indices, size in ((t.x, t.n_x), (t.e, t.n_e)):
        own = np.concatenate(
            [np.asarray(a) for a in (indices.fixed, indices.dependent, indices.dof, indices.prescribed)]
        )
        assert sorted(own.tolist()) == list(range(size))
    for leaf in jax.tree.leaves(model.parameters):
        assert leaf.dtype == float
        assert np.all(np.isfinite(leaf))
    for block in t.blocks:
        assert np.all(np.asarray(block.x) < t.n_x)
        assert np.all(np.asarray(block.e) < t.n_e)
    for side in (labels.inputs, labels.outputs):
        assert len({s.name for s in side}) == len(side)
    counts = model.counts()
    assert counts["ndof"] == counts["nx"] - counts["nxo"] - counts["neo"]
    assert model.overview()


def run(case: Case) -> str:
    """Make the calls and build.

    Args:
        case: Calls.

    Returns:
        "built", "unchecked", "no mechanism" or "refused".
    """
    b = fm.Builder()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", fm.FlexmbWarning)
        for method, arguments, options in case.calls:
            _call(b, method, arguments, options)
        try:
            model = b.build(check=False, **case.options)
        except fm.ModelError:
            return "refused"
        _check_model(model)
        if not case.whole:
            return "unchecked"
        try:
            model = b.build(**case.options)
        except fm.MechanismError:
            return "no mechanism"
        except fm.ModelError:
            return "refused"
        _check_model(model)
        motions, over = allowed_motions(model)
        assert over == 0
        assert motions.shape[1] == model.topology.n_q
        assert fm.mobility(model).status == "ok"
        assert len(set(model.q_labels)) == model.topology.n_q
    return "built"
