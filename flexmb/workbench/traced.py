"""The answers beside the drawing as functions of the free names with derivatives, compiled once for each structure."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..compilation.compile import jit
from ..design.evaluate import REVERSE_COST, build_once, flat_function, layout_of, refusal_of_designs
from ..errors import printable
from ..linear.linearize import Linearization, linearize
from ..model.model import Model
from ..questions.question import asked, question_names
from ..results import RESULTS
from ..spacar.arithmetic import is_number_text
from .building import build, free_names, numeric_values, structure
from .document import Document
from .edits import texts

# Number of structures whose compiled functions are kept.
MOST = 24

Answer = Callable[[Linearization], Any]


def answer_of(key: str, node: str | None = None) -> Answer:
    """An answer as a function of the linearised mechanism, which may be traced."""
    text = question_of(key, node)
    try:
        question = asked(text)
    except (KeyError, ValueError):
        question = None
    if question is None or not question.question.differentiable:
        known = ", ".join(question_names())
        raise ValueError(f"'{printable(key)}' has no derivatives by the dimensions. Answers with derivatives: {known}.")

    def answer(lin: Linearization) -> Any:
        try:
            return question(lin)
        except KeyError as fault:
            raise ValueError(f"{printable(key)}: {printable(fault.args[0])}.") from None

    return answer


def question_of(key: str, node: str | None = None) -> str:
    """The question of an answer's key; an axis alone becomes an axis of the node."""
    kind, _, which = key.partition(" ")
    if kind not in ("stiffness", "displacement") or not which or "." in which:
        return key
    if node is None:
        raise ValueError(f"'{printable(key)}' belongs to a node. Select a node.")
    return f"{kind} {node}.{which}"


def increment_of(model: Model) -> float | None:
    """Increment at which answers are computed: without incremental loads."""
    return None if model.parameters.increment is None else 0.0


class Traced:
    """Answers as a function of the free names, with derivatives.

    Attributes:
        names: Free names, in order.
        keys: Answers, in order.
    """

    def __init__(self, document: Document, model: Model, keys: Sequence[str], node: str | None):
        self.names, self.keys = tuple(free_names(document)), tuple(keys)
        # Numeric fields without names vary within a structure.
        plain = [address for address, text in texts(document) if is_number_text(text)]
        self._document, self._plain = document, [address for address in plain if not address.startswith("names/")]
        functions = {key: answer_of(key, node) for key in keys}
        layout = layout_of({"free": np.zeros(len(self.names)), "plain": np.zeros(len(self._plain))})
        example = dict(zip(layout.names, self._inputs(document), strict=True))
        models = build_once(self._built, example)
        function, _ = flat_function(self._linearized, functions, layout, models)
        self._refused = refusal_of_designs(self._built, models, example)

        def of_names(free: Array, plain: Array):
            values, code = function(jnp.concatenate([free, plain]))
            return values, (values, code)

        forward = len(self.names) <= REVERSE_COST * len(keys)
        self._function = jit((jax.jacfwd if forward else jax.jacrev)(of_names, has_aux=True))

    def _built(self, free: Any, plain: Any) -> Model:
        numbers = numeric_values(self._document, dict(zip(self.names, free, strict=True)))
        numbers |= dict(zip(self._plain, plain, strict=True))
        return build(self._document, numbers).builder.build()

    def _linearized(self, free: Any, plain: Any) -> Linearization:
        model = self._built(free, plain)
        return linearize(model, increment=increment_of(model))

    def _inputs(self, document: Document) -> tuple[np.ndarray, np.ndarray]:
        values = numeric_values(document)
        free = [values[f"names/{name}/value"] for name in self.names]
        return np.array(free, float), np.array([values[address] for address in self._plain], float)

    def at(self, document: Document) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, int]]:
        """The function of the free names for a document of this structure: answers, derivatives, code."""
        plain = self._inputs(document)[1]

        def answers(free: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
            if self.names and self._refused({"free": free[None], "plain": plain[None]})[0]:
                nothing = np.full((len(self.keys), len(self.names)), np.nan)
                return nothing[:, :1].sum(axis=1), nothing, int(RESULTS.impossible_design)
            slopes, (values, code) = self._function(jnp.asarray(free), jnp.asarray(plain))
            # An unstable state has answers too.
            answered = int(code) == RESULTS.unstable_state
            return np.asarray(values), np.asarray(slopes), int(RESULTS.successful if answered else code)

        return answers


_TRACED: dict[Any, Traced] = {}
_LOCK = threading.Lock()


def clamps_of(model: Model) -> tuple[tuple[bool, ...], ...]:
    """Whether ends of leaf springs and warping beams are clamped, for each block with such ends."""
    flags = [entry["clamped"] for entry in model.parameters.properties if "clamped" in entry]
    return tuple(tuple((np.asarray(clamped) == 1).ravel().tolist()) for clamped in flags)


def traced(document: Document, model: Model, keys: Sequence[str], node: str | None = None) -> Traced:
    """The function of the free names of a document, kept for its structure."""
    key = (structure(document), tuple(model.q_labels), clamps_of(model), tuple(keys), node)
    with _LOCK:
        traced_function = _TRACED.pop(key, None) or Traced(document, model, keys, node)
        _TRACED[key] = traced_function
        while len(_TRACED) > MOST:
            del _TRACED[next(iter(_TRACED))]
    return traced_function
