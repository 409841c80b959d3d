"""The answers beside the drawing as functions of the free names, with derivatives, compiled once for each structure."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..compilation.compile import jit
from ..design.evaluate import build_once, flat_function, layout_of
from ..design.objectives import AXES, mass
from ..design.possible import refusal
from ..design.sensitivities import REVERSE_COST
from ..errors import clean
from ..linear.buckling import buckling_loads
from ..linear.compliance import compliance
from ..linear.linearize import Linearization, linearize
from ..linear.modes import frequencies
from ..linear.stress import stress
from ..math.derivative import root_or_zero
from ..model.model import Model
from ..results import RESULTS
from ..spacar.arithmetic import is_number
from .building import build, free_names, numbers_of, structure
from .document import Document
from .edits import texts

# Structures whose compiled functions are kept.
MOST = 24

Answer = Callable[[Linearization], Any]


def answer_of(key: str, node: str | None = None) -> Answer:
    """An answer beside the drawing as a function of the linearised mechanism, which may be traced.

    Args:
        key: As the answers are called: "frequency 1", "multiplier 1", "stress", "utilisation", "mass", "stiffness x",
            "displacement", "displacement x".
        node: That of the support stiffness and of displacements along axes.

    Raises:
        ValueError: There is no such answer, or it needs a node.
    """
    kind, _, which = key.partition(" ")
    number = int(which) - 1 if which.isascii() and which.isdecimal() else -1
    if kind in ("frequency", "multiplier") and number >= 0:
        return (_Frequency if kind == "frequency" else _Multiplier)(number)
    if key in _WHOLE:
        return _WHOLE[key]
    if kind in ("stiffness", "displacement") and which:
        if node is None:
            raise ValueError(f"'{clean(key)}' is that of a node: choose one.")
        return (_Stiffness if kind == "stiffness" else _Displacement)(node, which)
    raise ValueError(f"'{clean(key)}' is no answer that has derivatives by the dimensions.")


class _Frequency:
    """A frequency by its number from 0 [Hz]."""

    def __init__(self, number: int):
        self.number = number

    def __call__(self, lin: Linearization) -> Any:
        return _entry(frequencies(lin, count=self.number + 1), self.number, "frequencies")


class _Multiplier:
    """A load multiplier by its number from 0 [-]."""

    def __init__(self, number: int):
        self.number = number

    def __call__(self, lin: Linearization) -> Any:
        return _entry(buckling_loads(lin.model, increment=_increment(lin.model)), self.number, "load multipliers")


def _entry(values: Any, number: int, what: str) -> Any:
    if number >= values.shape[0]:
        raise ValueError(f"There are {values.shape[0]} {what}.")
    return values[number]


class _Stiffness:
    """Force on a node over its displacement along an axis [N/m, N m/rad]."""

    def __init__(self, node: str, axis: str):
        self.node, self.axis = node, axis

    def __call__(self, lin: Linearization) -> Any:
        found = compliance(lin, self.node)
        axes = AXES[lin.labels.dimension][: found.shape[0]]
        if self.axis not in axes:
            raise ValueError(
                f"Node '{clean(self.node)}' has stiffness along {', '.join(axes)}, not {clean(self.axis)}."
            )
        i = axes.index(self.axis)
        return 1 / found[i, i]


class _Displacement:
    """Displacement of a node along an axis [m]."""

    def __init__(self, node: str, axis: str):
        self.node, self.axis = node, axis

    def __call__(self, lin: Linearization) -> Any:
        own = [(e.of, e.symbol) for e in lin.labels.x]
        if (self.node, self.axis) not in own:
            raise ValueError(f"Node '{clean(self.node)}' does not move along {clean(self.axis)}.")
        i = own.index((self.node, self.axis))
        return lin.x[i] - lin.model.parameters.reference[i]


def _largest_displacement(lin: Linearization) -> Any:
    nodes: dict[str, list[int]] = {}
    for i, entry in enumerate(lin.labels.x):
        if entry.kind == "position":
            nodes.setdefault(entry.of, []).append(i)
    moved = (lin.x - lin.model.parameters.reference)[np.array(list(nodes.values()))]
    return root_or_zero(jnp.max(jnp.sum(moved**2, axis=1)))


_WHOLE: dict[str, Answer] = {
    "mass": lambda lin: mass(lin.model),
    "stress": lambda lin: stress(lin.model, at=lin).maximum,
    "utilisation": lambda lin: jnp.max(stress(lin.model, at=lin).utilisation),
    "displacement": _largest_displacement,
}


def _increment(model: Model) -> float | None:
    """As live answers take it: without incremental loads."""
    return None if model.parameters.increment is None else 0.0


class Traced:
    """Answers as a function of the free names, and their derivatives.

    Attributes:
        names: Free names, in order.
        keys: Answers, in order.
    """

    def __init__(self, document: Document, model: Model, keys: Sequence[str], node: str | None):
        """Trace nothing yet.

        Args:
            document: Whose structure is meant.
            model: That it builds.
            keys: Answers.
            node: See :func:`answer_of`.
        """
        self.names, self.keys = tuple(free_names(document)), tuple(keys)
        self._document, self._plain = document, plain_of(document)
        functions = {key: answer_of(key, node) for key in keys}
        layout = layout_of({"free": np.zeros(len(self.names)), "plain": np.zeros(len(self._plain))})
        example = dict(zip(layout.names, self._inputs(document), strict=True))
        models = build_once(self._built, example)
        function, _ = flat_function(self._linearized, functions, layout, models)
        self._refused = refusal(self._built, models, example)

        def of_names(free: Array, plain: Array):
            values, code = function(jnp.concatenate([free, plain]))
            return values, (values, code)

        forward = len(self.names) <= REVERSE_COST * len(keys)
        self._function = jit((jax.jacfwd if forward else jax.jacrev)(of_names, has_aux=True))

    def _built(self, free: Any, plain: Any) -> Model:
        numbers = numbers_of(self._document, dict(zip(self.names, free, strict=True)))
        numbers |= dict(zip(self._plain, plain, strict=True))
        return build(self._document, numbers).builder.build()

    def _linearized(self, free: Any, plain: Any) -> Linearization:
        model = self._built(free, plain)
        return linearize(model, increment=_increment(model))

    def _inputs(self, document: Document) -> tuple[np.ndarray, np.ndarray]:
        values = numbers_of(document)
        free = [values[f"names/{name}/value"] for name in self.names]
        return np.array(free, float), np.array([values[address] for address in self._plain], float)

    def at(self, document: Document) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, int]]:
        """Answers by the free names of a document of this structure.

        Args:
            document: Whose other numbers are taken.

        Returns:
            Function of the values of the free names, (n,), with answers (m,), derivatives (m, n), and a code of
            RESULTS: impossible_design where the Builder would refuse the numbers.
        """
        plain = self._inputs(document)[1]

        def answers(free: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
            if self.names and self._refused({"free": free[None], "plain": plain[None]})[0]:
                nothing = np.full((len(self.keys), len(self.names)), np.nan)
                return nothing[:, :1].sum(axis=1), nothing, int(RESULTS.impossible_design)
            slopes, (values, code) = self._function(jnp.asarray(free), jnp.asarray(plain))
            # An unstable state has an answer.
            answered = int(code) == RESULTS.unstable_state
            return np.asarray(values), np.asarray(slopes), int(RESULTS.successful if answered else code)

        return answers


def plain_of(document: Document) -> list[str]:
    """Addresses of the numeric fields that are numbers alone: they do not depend on names, and vary in a structure."""
    return [address for address, text in texts(document) if is_number(text) and not address.startswith("names/")]


_KEPT: dict[Any, Traced] = {}
_LOCK = threading.Lock()


def clamps_of(model: Model) -> tuple[tuple[float, ...], ...]:
    """Which ends of leaf springs and warping beams are clamped, of each block that has some."""
    return tuple(
        tuple(np.asarray(own["clamped"]).ravel().tolist()) for own in model.parameters.properties if "clamped" in own
    )


def traced(document: Document, model: Model, keys: Sequence[str], node: str | None = None) -> Traced:
    """The function of the free names of a document, kept for its structure.

    Args:
        document: The document.
        model: That it builds, whose degrees of freedom are taken.
        keys: Answers.
        node: See :func:`answer_of`.

    Raises:
        ValueError: There is no such answer.
    """
    key = (structure(document), tuple(model.q_labels), clamps_of(model), tuple(keys), node)
    with _LOCK:
        found = _KEPT.pop(key, None) or Traced(document, model, keys, node)
        _KEPT[key] = found
        while len(_KEPT) > MOST:
            del _KEPT[next(iter(_KEPT))]
    return found
