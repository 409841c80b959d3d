"""Answers at each stroke: force, stress, stiffness, parasitic motion, buckling, frequencies."""

import contextlib
import dataclasses
from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import is_concrete
from ..build.restrict import with_turn
from ..compilation.compile import jit
from ..display import listed, quantity_text
from ..elements import spatial
from ..elements.nodes import ROTATION3
from ..errors import AnalysisError, BeamTheoryWarning, ModelError, heard, warn
from ..linear.compliance import compliance
from ..linear.modes import frequencies
from ..linear.stress import WITHOUT_WARPING, Location, Stress, stress
from ..math.linear import factorise, is_positive_definite
from ..math.rotation import rotation_since
from ..mechanics.loads import has_loads
from ..model.by_name import TURN_OF, turned_by
from ..model.model import Model
from ..numerical_limits import ALONG_AXIS, RIGID_NODE
from ..questions.question import asked, components_of, unit_of_question
from ..results import RESULTS
from ..statics.solver_choice import up_to
from .stroke import AtStroke, StrokeDrive, unit_of_driven


class StrokeQuestions:
    """The questions about one mechanism, and its states so far.

    A question is a function of a state and of the coordinates at zero stroke. It returns numbers by name.
    """

    def __init__(self, model: Model, drive: StrokeDrive, node: str | None, count: int):
        self.model, self.driven, self.count = model, drive, count
        driven_node = drive.entry.of.removesuffix(".rotation") if drive.kind == "x" else None
        about = None
        if driven_node is None and drive.entry.of.startswith(TURN_OF):
            # The hinge of a rotation that Builder.prescribe prescribes.
            driven_node, about = turned_by(drive.entry.of)[0], _axis(model, drive.index)
        self.node, self.unit = driven_node if node is None else str(node), unit_of_driven(model, drive)
        self.parts = [p for p in (self.node, f"{self.node}.rotation") if p and model.labels.coordinates(p)]
        if node is not None and not self.parts:
            raise ModelError(f"Argument `node`: the model has no node '{node}'.")
        self.axes = tuple(components_of(model.labels, str(self.node))) if self.parts else ()
        self.own = drive.entry.symbol if self.node == driven_node else None
        # Axis of rotation of the drive, (3,), which may be a coordinate axis.
        self.about = about if self.node == driven_node else None
        if self.about is not None and np.max(np.abs(self.about)) > ALONG_AXIS:
            self.own = self.axes[-3:][int(np.argmax(np.abs(self.about)))]
        self.at: dict[float, AtStroke] = {}
        self.values: dict[float, dict[str, float]] = {}
        self.unanswered: dict[str, str] = {}
        self.missing: dict[float, str] = {}
        self.questions: dict[str, Callable[[AtStroke, Any], dict[str, Any]]] = {
            "drive": lambda at, x_at_rest: {"force": at.force, "drive stiffness": at.stiffness},
            "stress": lambda at, x_at_rest: _stresses(_stress(at)),
            "buckling": _buckling,
            "support stiffness": self._stiffnesses,
            "parasitic motion": self._parasitic,
            "frequencies": self._frequencies,
        }

    def ask_too(self, name: str) -> None:
        """Ask another question by its text about the held state, at once at zero stroke; KeyError, ValueError."""
        question = asked(name)
        # A wrong name leaves nothing behind. `look` notes other failures.
        with heard(), contextlib.suppress(ModelError, AnalysisError, NotImplementedError):
            float(question(self.at[0.0].held))
        self.questions[name] = lambda at, x_at_rest: {name: question(at.held)}
        self.values.clear()
        self.look(0.0)

    def look(self, stroke: float, throw: bool = False) -> bool:
        """Find the state at a stroke and answer all questions; False, with a note, if there is none."""
        if stroke in self.values:
            return True
        at, answers = self._state(stroke, throw), {}
        if at is None:
            return False
        self.at[stroke] = at
        for subject, ask in list(self.questions.items()):
            try:
                with heard():
                    answers |= {name: float(value) for name, value in ask(at, self.at[0.0].held.x).items()}
            except (ModelError, AnalysisError, NotImplementedError) as fault:
                reason = " ".join(str(fault).split()).rstrip(".")
                if stroke != 0:
                    self.unanswered.setdefault(subject, f"at {quantity_text(stroke, self.unit)}: {reason}")
                    continue
                # A question without an answer at zero stroke is not asked again.
                self.unanswered[subject] = reason
                del self.questions[subject]
        self.values[stroke] = answers
        return True

    def approach(self, last: float, missing: float, close: float) -> None:
        """Find the last stroke with an equilibrium, by bisection between one with and one without.

        The search for each equilibrium begins at the undeformed mechanism: it has load steps of its own, and reaches no
        further from a neighbouring equilibrium.
        """
        while abs(missing - last) > close:
            middle = (last + missing) / 2
            last, missing = (last, middle) if self._state(middle) is None else (middle, missing)
        self.look(last)

    def _state(self, stroke: float, throw: bool = False) -> AtStroke | None:
        """The state at a stroke; None, with a note, if there is none."""
        at = self.driven.at(self.model, stroke, throw=throw)
        code = RESULTS(int(at.held.result))
        if code is RESULTS.successful:
            return at
        self.missing[stroke] = code.name
        sides = ([s for s in self.missing if s < 0], [s for s in self.missing if s > 0])
        nearest = [min(side, key=abs) for side in sides if side]
        strokes = " and ".join(f"{quantity_text(s, self.unit)} ({self.missing[s]})" for s in nearest)
        self.unanswered["stroke"] = f"no equilibrium was found at {strokes}"
        return None

    def _stiffnesses(self, at: AtStroke, x_at_rest: Any) -> dict[str, Any]:
        """Stiffness of the node along every axis but the driven one, infinite if the model is rigid there."""
        node, m = self._checked_node(), at.held.matrices
        positions = np.isin(np.arange(len(m.x)), np.asarray(at.held.model.topology.axes))
        alike = np.stack([positions == (axis in "xyz") for axis in self.axes])
        stiffness = _along_axes(m.K, m.DFx, compliance(at.held, node), alike)
        return {f"stiffness {axis}": k for axis, k in zip(self.axes, stiffness, strict=True) if axis != self.own}

    def _parasitic(self, at: AtStroke, x_at_rest: Any) -> dict[str, Any]:
        """Motion of the node from its place at zero stroke, along every axis but the driven one."""
        self._checked_node()
        parts = [self.model.labels.known(part) for part in self.parts]
        moved = _displacements(x_at_rest, at.held.x, parts, np.zeros(3) if self.about is None else self.about)
        return {f"parasitic {axis}": value for axis, value in zip(self.axes, moved, strict=True) if axis != self.own}

    def _checked_node(self) -> str:
        if self.node is None:
            raise ModelError("a deformation belongs to several nodes: give `node`")
        return self.node

    def _frequencies(self, at: AtStroke, x_at_rest: Any) -> dict[str, Any]:
        hertz = frequencies(at.free, count=up_to(self.count, at.free.model))
        if is_concrete(hertz) and 0.0 not in self.values:
            self.count = int(np.sum(np.isfinite(hertz)))
        if not self.count:
            raise ModelError("no motion of the model moves a mass")
        return {f"frequency {i + 1}": hertz[i] for i in range(self.count)}

    def say_what_is_missing(self) -> None:
        """Note limits that materials lack, and incremental loads, which the stroke replaces."""
        if "stress" in self.questions:
            at_rest = _stress(self.at[0.0])
            if at_rest.left_out:
                names = listed([repr(name) for name in at_rest.left_out])
                self.unanswered[f"stress of {names}"] = "the section is given by its rigidities, without a shape"
            for question, quantity, limit in (
                ("yield", "strength", "strength"),
                ("fatigue", "fatigue", "fatigue limit"),
            ):
                borne = getattr(at_rest, quantity)
                silent = np.ones(len(at_rest.names), bool) if borne is None else np.all(np.isinf(borne), axis=1)
                if np.any(silent):
                    names = listed([repr(name) for name, lacks in zip(at_rest.names, silent, strict=True) if lacks])
                    self.unanswered[question] = f"the material of {names} states no {limit}"
        increment = self.model.parameters.increment
        others = () if increment is None else ("force", "gravity", "prestress", "temperature", "x", "e")
        if any(getattr(increment, n) is not None for n in others if not (self.driven.given and n == self.driven.kind)):
            self.unanswered["incremental loads"] = "they are left out: the stroke replaces them"

    def curves(self) -> dict[str, np.ndarray]:
        """Numbers at all strokes so far, ascending, by name; NaN if missing."""
        strokes = sorted(self.values)
        return {name: np.array([self.values[s].get(name, np.nan) for s in strokes]) for name in self.values[0.0]}

    def places(self) -> tuple[Location, ...]:
        """Place of the largest stress at each stroke."""
        if "stress" not in self.questions:
            return ()
        with heard() as texts:
            found = tuple(stress(at.held.model, at=at.held).where for _, at in sorted(self.at.items()))
        for text in dict.fromkeys(text for text in texts if WITHOUT_WARPING in text):
            warn(text, BeamTheoryWarning)
        return found

    def stable(self, how: str) -> np.ndarray:
        """Whether it is stable at each stroke, "held" or "free", (states,)."""
        return np.array([bool(_is_positive(getattr(self.at[s], how).matrices.K)) for s in sorted(self.at)])

    def numbers_at(self, model: Model, stroke: float, names: list[str]) -> Any:
        """Numbers at a stroke of a model that may be traced, (names,)."""
        model = with_turn(model, self.driven.entry.of.removeprefix(TURN_OF))
        at, x_at_rest = self.driven.at(model, stroke), model.parameters.reference
        if has_loads(self.driven.free, dataclasses.replace(model.parameters, increment=None)):
            x_at_rest = self.driven.at(model, 0.0).held.x
        values: dict[str, Any] = {}
        for ask in self.questions.values():
            values |= ask(at, x_at_rest)
        return jnp.stack([jnp.asarray(values[name], float) for name in names])


def _axis(model: Model, index: int) -> np.ndarray | None:
    """Unit vector of the hinge whose angle is a deformation, (3,); None for another deformation."""
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        rows = np.flatnonzero(np.asarray(block.e)[:, :1] == index)
        if block.element is spatial.hinge and len(rows):
            axis = np.asarray(properties["axis"])[rows[0]]
            return axis / np.linalg.norm(axis)
    return None


def _stress(at: AtStroke) -> Stress:
    with heard():
        return stress(at.held.model, at=at.held)


def _stresses(stress: Stress) -> dict[str, Any]:
    """The largest stress, and its largest shares of strength and fatigue limit."""
    numbers_of = {"stress": stress.maximum}
    if stress.strength is not None:
        numbers_of["yield"] = jnp.max(stress.utilisation)
    if stress.fatigue is not None:
        numbers_of["fatigue"] = jnp.max(stress.fatigue_utilisation)
    return numbers_of


@jit
def _along_axes(
    k: Float[Array, "n n"],
    DFx: Float[Array, "n_x n"],
    compliance: Float[Array, "a a"],
    alike: Bool[Array, "a n_x"],
) -> list[Float[Array, ""]]:
    """Stiffness of a node along each axis, infinite if it yields less than a share of the most compliant node."""
    every = jnp.einsum("ij,ji->i", DFx, factorise(k).solve(DFx.T))
    diagonal, most = jnp.diagonal(compliance), jnp.max(jnp.where(alike, every, 0.0), axis=1, initial=0.0)
    yields = diagonal > RIGID_NODE * most
    return list(jnp.where(yields, 1 / jnp.where(yields, diagonal, 1.0), jnp.inf))


@jit
def _displacements(
    rest: Float[Array, "n_x"], x: Float[Array, "n_x"], parts: list[Int[Array, "_n"]], about: Float[Array, "3"]
) -> list[Float[Array, ""]]:
    """Displacements of parts of a node, in space without the rotation about an axis unless it is zero."""
    moved = []
    for part in parts:
        turned = len(part) == ROTATION3.size
        change = rotation_since(rest[part], x[part]) if turned else x[part] - rest[part]
        moved.append(change - about * (about @ change) if turned else change)
    return list(jnp.concatenate(moved))


@jit
def _is_positive(k: Float[Array, "n n"]) -> Bool[Array, ""]:
    return is_positive_definite((k + k.T) / 2)


def _buckling(at: AtStroke, x_at_rest: Any) -> dict[str, Any]:
    """Multiplier of the constant loads; zero if the mechanism is unstable though the drive holds it."""
    if any(block.element.force is not None for block in at.free.model.topology.blocks):
        raise ModelError("follower loads have no load multiplier: use fm.path")
    least = jnp.array(jnp.inf) if at.margins is None else at.margins[0]
    return {"buckling": jnp.where(_is_positive(at.held.matrices.K), least, 0.0)}


def unit_of_curve(name: str, of_stroke: str) -> str:
    """Unit of a curve."""
    force = "N" if of_stroke == "m" else "N m"
    if name in ("force", "drive stiffness"):
        return force if name == "force" else f"{force}/{of_stroke}"
    kind, _, axis = name.partition(" ")
    if kind == "parasitic":
        return "m" if axis in ("x", "y", "z") else "rad"
    return unit_of_question(name)
