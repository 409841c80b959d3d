"""Test a user's element type against the laws that every element obeys, in random states near several references."""

import dataclasses
import functools
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from ..arguments import check_number
from ..compilation.compile import jit
from ..display import Result, Summary, counted
from ..elements.element import Element
from ..elements.nodes import NodeKind
from ..errors import ModelError
from ..math import rotations
from ..numerical_limits import ELEMENT_DIFFERENCE, ELEMENT_LAW, POTENTIAL_DIFFERENCE
from .assemble import is_option
from .properties import complete_properties, element_type, number_of_deformations, with_options

# Companions that need not have derivatives everywhere.
KINKED = ("law", "energy", "dissipation")
STEP = float(np.cbrt(np.finfo(float).eps))
REFERENCES = 3
# Distances of the states from their reference, over the distance of nodes, and in radians: in it, near it, away from
# it.
AWAY = (0.0, 1e-3, 0.3)
TINY = float(np.finfo(float).tiny)
ZERO, RIGID = "zero in the undeformed mechanism", "unchanged by rigid motion"
SMOOTH, TWICE = "first derivatives, against differences", "second derivatives, against differences"
SLOPES = {"energy": "stress is the slope of the energy", "dissipation": "and of the dissipation, by rates"}
SYMMETRIC = "stiffness and damping are symmetric"
MASS, KINETIC = "mass is symmetric and positive semidefinite", "kinetic energy is unchanged by rigid motion"


@dataclasses.dataclass(frozen=True, repr=False)
class ElementCheck(Result):
    """Laws that a passing element type obeys, and their deviations.

    Attributes:
        element: Name of the element type.
        deformations: Number of deformations.
        deviations: Largest deviation from each law, relative to the largest number of the same kind [-].
    """

    element: str
    deformations: int
    deviations: dict[str, float]

    def summary(self) -> Summary:
        """The laws, and their deviations."""
        rows = {law: f"within {value:.1e}" for law, value in self.deviations.items()}
        return Summary(f"ElementCheck: {self.element} with {counted(self.deformations, 'deformation')} passes", rows)


def check_element(element: Any, *, apart: float = 1.0, **properties: Any) -> ElementCheck:
    """Test whether the functions of an element type obey the laws that analyses rely on.

    - Deformations are zero in the undeformed mechanism. They do not change in rigid motion, unless ``grounded``.
    - First and second derivatives are right in the undeformed mechanism, near it and away from it: by the coordinates,
      by the undeformed coordinates and by the properties.
    - Stress is the slope of the energy; stiffness and damping are symmetric.
    - Mass is symmetric and positive semidefinite, and rigid motion does not change the kinetic energy.

    Args:
        element: Element type, or a bare deformation function.
        apart: Approximate distance of the nodes in the tested states, () [m].
        properties: Properties and options, as ``Builder.add`` takes them.

    Returns:
        The tested laws, with their deviations. Printed, they are a short report.

    Raises:
        ModelError: Every law that fails, by name; a property that is missing, unknown or of the wrong kind; functions
            that do not fit together.

    Source:
        Definition of an element; central differences with a step of eps^(1/3).
    """
    check_number("apart", apart, above=0)
    element = element_type(element)
    name = element.name
    element, remaining = with_options(element, name, properties)
    completed = complete_properties(element, name, remaining)
    count = number_of_deformations(element, name, completed)
    states = _Tried(element, completed, count, apart)
    laws = dict(states.laws())
    if faults := [fault for _, fault in laws.values() if fault]:
        raise ModelError("\n".join(f"Element type '{name}': {fault}." for fault in faults))
    return ElementCheck(name, count, {law: value for law, (value, _) in laws.items()})


# -- states of an element, and answers of its functions ----------------------------------------------------------------


class ElementState(NamedTuple):
    """Coordinates of an element in a state and in the undeformed mechanism, node by node."""

    x: list[np.ndarray]
    ref: list[np.ndarray]


def abs_or_one(numbers: np.ndarray) -> np.ndarray:
    """Absolute values. The largest of them replaces a zero, or 1 if all are zero."""
    sizes = np.abs(numbers)
    return np.where(sizes > 0, sizes, np.max(sizes, initial=0.0) or 1.0)


def sizes(kinds: list[NodeKind], apart: float) -> list[np.ndarray]:
    """Usual sizes of coordinates, node by node."""
    return [np.full(kind.size, apart if kind.part == "position" else 1.0) for kind in kinds]


def weights(count: int) -> np.ndarray:
    """Numbers of order one without symmetry."""
    return np.cos(2.0 + 1.7 * np.arange(count))


def random_element(kinds: list[NodeKind], apart: float, random: np.random.Generator) -> list[np.ndarray]:
    """Coordinates of an undeformed element: nodes in a row along a line, with random rotations."""
    coordinates, places = [], 0
    along = np.array([1.0, 0.3, -0.2])
    for kind in kinds:
        if kind.part == "position":
            offset = 0.3 * random.uniform(-1, 1, kind.size) + places * along[: kind.size]
            coordinates.append(apart * offset)
            places += 1
        elif kind.part != "rotation":
            coordinates.append(np.zeros(kind.size))
        elif kind.dimension == 2:
            coordinates.append(random.uniform(-1, 1, 1))
        else:
            coordinates.append(np.asarray(rotations.from_vector(random.uniform(-1, 1, 3))))
    return coordinates


def moved_nodes(
    kinds: list[NodeKind], ref: list[np.ndarray], away: float, apart: float, random: np.random.Generator
) -> list[np.ndarray]:
    """Coordinates of the deformed element, with each node moved by itself."""
    coordinates = []
    for kind, part in zip(kinds, ref, strict=True):
        change = away * random.uniform(-1, 1, 3 if kind.part == "rotation" else kind.size)
        if kind.part == "rotation" and kind.dimension == 3:
            coordinates.append(np.asarray(rotations.quaternion_product(rotations.from_vector(change), part)))
        else:
            coordinates.append(part + (apart if kind.part == "position" else 1.0) * change[: kind.size])
    return coordinates


def rigid_motion(
    kinds: list[NodeKind], x: list[np.ndarray], turn: np.ndarray, shift: np.ndarray, rates: bool = False
) -> list[np.ndarray]:
    """Coordinates after a rigid motion of the whole, or rates carried along by it."""
    c, s = np.cos(turn[2]), np.sin(turn[2])
    lam, plane = rotations.from_vector(turn), np.array([[c, -s], [s, c]])
    coordinates = []
    for kind, part in zip(kinds, x, strict=True):
        if kind.part == "position":
            matrix = plane if kind.dimension == 2 else np.asarray(rotations.to_matrix(lam))
            coordinates.append(matrix @ part + shift[: kind.dimension])
        elif kind.part != "rotation":
            coordinates.append(part)
        elif kind.dimension == 2:
            coordinates.append(part + (0.0 if rates else turn[2]))
        else:
            coordinates.append(np.asarray(rotations.quaternion_product(lam, part)))
    return coordinates


@functools.cache
def compiled_functions(element: Element, count: int, options: tuple, structure: Any, shapes: tuple) -> Any:
    """Compiled values and derivatives of an element's functions at many points, and the slice of each function."""
    _, unravel = ravel_pytree(jax.tree.unflatten(structure, [np.zeros(shape) for shape in shapes]))

    def chosen(companion: Any, numbers: dict[str, Any]) -> dict[str, Any] | None:
        return element.arguments(companion, {**numbers, **dict(options)})

    def answers(point: Any) -> dict[str, Any]:
        x, ref, numbers = unravel(point)
        where = element.reference(ref)
        keywords = {"near": jnp.zeros(count)} if element.tracks_angle else {}
        e = element.deformation(*x, ref=where, **(chosen(element.deformation, numbers) or {}), **keywords)
        answered = {"deformations": e}
        rates = weights(count)
        calls = {"energy": (e,), "dissipation": (e, rates), "law": (e, rates), "stiffness": (), "damping": ()}
        for name, arguments in (*calls.items(), ("force", x), ("inertia", x)):
            companion = getattr(element, name)
            properties = chosen(companion, numbers)
            if properties is None:
                continue
            answer = companion(*arguments, ref=where, **properties)
            answered |= {"vectors": answer[0], "H": answer[1]} if name == "inertia" else {name: answer}
        return answered

    def weighed(point: Any) -> Any:
        """Weights of all answers; zero for laws and potentials, which may have kinks, as in contact."""
        parts = {name: jnp.full(part.size, float(name not in KINKED)) for name, part in answers(point).items()}
        joined = jnp.concatenate([part for _, part in sorted(parts.items())])
        return joined * weights(joined.size)

    def flat(point: Any) -> Any:
        return jnp.concatenate([jnp.ravel(part) for _, part in sorted(answers(point).items())])

    def both(point: Any) -> Any:
        value, pull = jax.vjp(flat, point)
        return value, pull(weighed(point))[0]

    def slopes(name: str, point: Any) -> dict[str, Any]:
        """Derivative of a potential in a direction, and its difference quotient."""
        _, ref, numbers = unravel(point)
        properties = chosen(getattr(element, name), numbers) or {}
        e = answers(point)["deformations"]
        potential = getattr(element, name)

        def of(v: Any) -> Any:
            arguments = (v,) if name == "energy" else (e, v)
            return potential(*arguments, ref=element.reference(ref), **properties)

        at = e if name == "energy" else jnp.asarray(weights(count))
        way, step = jnp.cos(jnp.arange(count)), STEP * jnp.max(jnp.abs(at), initial=1e-3)
        along = (of(at + step * way) - of(at - step * way)) / (2 * step)
        return {f"{name} slope": jax.grad(of)(at) @ way, f"{name} differences": along}

    def one(point: Any, along: Any) -> dict[str, Any]:
        (value, reverse), (forward, second) = jax.jvp(both, (point,), (along,))
        results = {"value": value, "reverse": reverse, "forward": forward, "second": second}
        x, ref, numbers = unravel(point)
        if chosen(element.inertia, numbers) is not None:
            at, again = ravel_pytree(x)

            def vectors(x: Any) -> Any:
                return answers(ravel_pytree((again(x), ref, numbers))[0])["vectors"]

            j = jax.jacfwd(vectors)(at)
            results["mass"] = jnp.einsum("akc,ab,bkd->cd", j, answers(point)["H"], j)
        for name in ("energy", "dissipation"):
            if chosen(getattr(element, name), numbers) is not None:
                results |= slopes(name, point)
        return results

    example = jax.eval_shape(answers, jax.ShapeDtypeStruct((sum(int(np.prod(s)) for s in shapes),), float))
    ends = np.cumsum([0, *(int(np.prod(part.shape)) for _, part in sorted(example.items()))]).tolist()
    slices = {name: slice(a, b) for name, a, b in zip(sorted(example), ends[:-1], ends[1:], strict=True)}
    return jit(jax.vmap(one)), slices


# -- the laws -------------------------------------------------------------------------------------------------------


class _Tried:
    """States of an element, and the answers of its functions there."""

    def __init__(self, element: Element, properties: dict[str, Any], count: int, apart: float):
        self.element, self.count = element, count
        options = tuple(sorted((k, v) for k, v in properties.items() if is_option(v)))
        numbers = {k: v for k, v in properties.items() if not is_option(v)}
        self.numbers = jax.tree.map(lambda leaf: np.asarray(leaf, float), numbers)
        self.kinds = list(element.nodes.values())
        random = np.random.default_rng(0)
        pairs = [(random_element(self.kinds, apart, random), away) for _ in range(REFERENCES) for away in AWAY]
        self.states = [ElementState(moved_nodes(self.kinds, ref, away, apart, random), ref) for ref, away in pairs]
        self.references = [i for i, (_, away) in enumerate(pairs) if not away]
        for i in self.references if element.check is not None else ():
            check: Any = element.check
            arguments = element.arguments(check, properties) or {}
            for fault in check(ref=element.reference(self.states[i].ref), **arguments):
                raise ModelError(f"Element type '{element.name}' {fault}.")
        turns = [random.uniform(-0.5, 0.5, (2, 3)) * [[1.0], [apart]] for _ in self.states]
        rigid = [
            ElementState(rigid_motion(self.kinds, s.x, *t), s.ref) for s, t in zip(self.states, turns, strict=True)
        ]
        self.turns = [turn for turn, _ in turns]
        points = [self._flat(state) for state in self.states]
        # Each number is scaled by its own size; coordinates, and numbers that are zero, by usual sizes.
        self.sizes = self._flat(ElementState(*(sizes(self.kinds, apart) for _ in range(2))), abs_or_one)
        ways = random.standard_normal((len(points), len(points[0]))) * self.sizes
        batch = [*points, *map(self._flat, rigid)]
        steps = [p + sign * STEP * way for sign in (1, -1) for p, way in zip(points, ways, strict=True)]
        along = np.concatenate([ways, np.zeros((len(rigid), ways.shape[1])), ways, ways])
        shapes = tuple(np.shape(leaf) for leaf in jax.tree.leaves(self._tree(self.states[0])))
        structure = jax.tree.structure(self._tree(self.states[0]))
        run, self.shapes = compiled_functions(element, count, options, structure, shapes)
        answers = jax.tree.map(np.asarray, run(np.stack([*batch, *steps]), along))
        self.along = ways
        n = len(points)
        self.here, self.rigid, self.plus, self.minus = (
            jax.tree.map(lambda leaf, i=i: leaf[i * n : (i + 1) * n], answers) for i in range(4)
        )

    def _tree(self, state: ElementState, change: Callable[[np.ndarray], np.ndarray] = np.asarray) -> Any:
        return [np.asarray(v, float) for v in state.x], list(state.ref), jax.tree.map(change, self.numbers)

    def _flat(self, state: ElementState, change: Callable[[np.ndarray], np.ndarray] = np.asarray) -> np.ndarray:
        return np.asarray(ravel_pytree(self._tree(state, change))[0])

    def laws(self) -> Iterator[tuple[str, tuple[float, str]]]:
        """Each law that applies, its largest deviation, and a fault if that is too large."""
        if fault := self._not_finite():
            # Other laws cannot be tested then.
            yield "finite", (np.inf, fault)
            return
        if self.count:
            yield ZERO, self._zero()
            if not self.element.grounded:
                yield RIGID, self._rigid()
        yield SMOOTH, self._first()
        yield TWICE, self._second()
        for kind in SLOPES:
            if kind in self.shapes:
                yield SLOPES[kind], self._slope(kind)
        if named := [n for n in ("stiffness", "damping") if n in self.shapes]:
            yield SYMMETRIC, self._symmetric(named)
        if "mass" in self.here:
            yield MASS, self._semidefinite()
            yield KINETIC, self._kinetic()

    def _answer(self, answers: dict[str, Any], name: str, kind: str = "value") -> np.ndarray:
        """Numbers of an answer in all states, (states, n)."""
        return answers[kind][:, self.shapes[name]]

    def _where(self, state: int) -> str:
        return ("in the undeformed mechanism", "near the undeformed mechanism", "away from it")[state % len(AWAY)]

    def _not_finite(self) -> str:
        for kind, noun in (("value", "number"), ("forward", "first derivative"), ("second", "second derivative")):
            slices = self.shapes if kind != "second" else {"functions": slice(None)}
            for i in range(len(self.states)):
                for name, columns in slices.items():
                    if not np.all(np.isfinite(self.here[kind][i, columns])):
                        return f"a {noun} of its {name} is not finite {self._where(i)}. Rewrite it so that it is finite"
        if not np.all(np.isfinite(self.here["reverse"])):
            return (
                "a derivative is not finite in reverse mode, although it is in forward mode: a square root of zero, or"
                " a division"
            )
        return ""

    def _zero(self) -> tuple[float, str]:
        e = self._answer(self.here, "deformations")
        largest = np.max(np.abs(e), axis=0)
        if still := [str(i + 1) for i in np.flatnonzero(largest == 0)]:
            return np.inf, f"deformation {', '.join(still)} is zero for all coordinates"
        ratios = np.abs(e[self.references]) / largest
        value, worst = float(ratios.max()), int(np.argmax(ratios.max(axis=0)))
        number = float(np.max(np.abs(e[self.references][:, worst])))
        fault = (
            f"deformation {worst + 1} is {number:.3g} in the undeformed mechanism, given as `ref`, but must be zero"
            " there"
        )
        return value, fault if value > ELEMENT_LAW else ""

    def _rigid(self) -> tuple[float, str]:
        e, e_moved = (self._answer(values, "deformations") for values in (self.here, self.rigid))
        errors = np.abs(e_moved - e) / (np.max(np.abs(e), axis=0) + TINY)
        value, worst = float(errors.max()), int(np.argmax(errors.max(axis=0)))
        number = float(np.max(np.abs(e_moved - e)[:, worst]))
        fault = (
            f"deformation {worst + 1} changes by {number:.3g} in a rigid motion of the whole element, but must not"
            " change: measure vectors in axes that turn with the element, and rotations relative to each other"
        )
        return value, fault if value > ELEMENT_LAW else ""

    def _first(self) -> tuple[float, str]:
        forward = self.here["forward"]
        # Largest size of the same answer and of its derivatives, for each number.
        scales = np.zeros(forward.shape[1])
        for columns in self.shapes.values():
            scales[columns] = max(np.max(np.abs(self.here[k][:, columns]), initial=0.0) for k in ("value", "forward"))
        scales = np.where(scales > 0, scales, 1.0)
        central = (self.plus["value"] - self.minus["value"]) / (2 * STEP)
        errors = np.abs(central - forward) / scales
        own_weights = weights(forward.shape[1])
        for name in self.shapes.keys() & {*KINKED}:
            errors[:, self.shapes[name]] = own_weights[self.shapes[name]] = 0.0
        reverse = np.sum(self.here["reverse"] * self.along, axis=1)
        reverse_errors = np.abs(forward @ own_weights - reverse) / np.sum(np.abs(forward), axis=1).clip(TINY)
        fault = self._named(errors, ELEMENT_DIFFERENCE, "the derivative of {} is not that of its differences {}")
        if not fault and np.max(reverse_errors) > ELEMENT_LAW:
            fault = "its derivatives in reverse mode are not those in forward mode"
        return float(max(errors.max(initial=0.0), reverse_errors.max(initial=0.0))), fault

    def _second(self) -> tuple[float, str]:
        second = self.here["second"]
        central = (self.plus["reverse"] - self.minus["reverse"]) / (2 * STEP)
        scale = max(np.max(np.abs(values * self.sizes)) for values in (second, self.here["reverse"])) or 1.0
        errors = np.abs(central - second) * self.sizes / scale
        value = float(errors.max())
        where = self._where(int(np.argmax(errors.max(axis=1))))
        fault = (
            f"its second derivatives are not those of differences {where}: it may have a kink, or be tried where it is"
        )
        return value, f"{fault} not defined (nodes are `apart` from each other)" * (value > ELEMENT_DIFFERENCE)

    def _named(self, errors: np.ndarray, most: float, text: str) -> str:
        """Fault of the answer that deviates most; empty if none deviates too much."""
        if not errors.size or errors.max() <= most:
            return ""
        state, column = np.unravel_index(int(np.argmax(errors)), errors.shape)
        name, columns = next((n, s) for n, s in self.shapes.items() if s.start <= column < s.stop)
        about = f"deformation {column - columns.start + 1}" if name == "deformations" else f"its {name}"
        return text.format(about, self._where(int(state)))

    def _slope(self, kind: str) -> tuple[float, str]:
        slope, differences = self.here[f"{kind} slope"], self.here[f"{kind} differences"]
        scale = max(np.max(np.abs(slope)), np.max(np.abs(differences))) or 1.0
        value = float(np.max(np.abs(slope - differences)) / scale)
        fault = f"the derivative of its {kind} is not that of its differences"
        return value, fault if value > POTENTIAL_DIFFERENCE else ""

    def _symmetric(self, named: list[str]) -> tuple[float, str]:
        value, fault = 0.0, ""
        for name in named:
            matrices = self._answer(self.here, name).reshape(-1, self.count, self.count)
            scale = np.max(np.abs(matrices)) or 1.0
            asymmetry = float(np.max(np.abs(matrices - matrices.transpose(0, 2, 1))) / scale)
            value = max(value, asymmetry)
            if asymmetry > ELEMENT_LAW:
                fault = fault or f"its {name} is not symmetric"
        return value, fault

    def _semidefinite(self) -> tuple[float, str]:
        mass, h = self.here["mass"], self._answer(self.here, "H")
        scale = np.max(np.abs(mass)) or 1.0
        size = int(np.sqrt(h.shape[1]))
        h = h.reshape(-1, size, size)
        skew = float(np.max(np.abs(h - h.transpose(0, 2, 1))) / (np.max(np.abs(h)) or 1.0))
        lowest = float(np.min(np.linalg.eigvalsh(mass)) / scale)
        fault = "the matrix H of its inertia is not symmetric" if skew > ELEMENT_LAW else ""
        if lowest < -ELEMENT_LAW:
            fault = fault or "its mass matrix is not positive semidefinite: a motion has a negative kinetic energy"
        return max(skew, -min(lowest, 0.0)), fault

    def _kinetic(self) -> tuple[float, str]:
        mass, value = self.here["mass"], 0.0
        ends = np.cumsum([kind.size for kind in self.kinds])[:-1]
        for i, turn in enumerate(self.turns):
            unmoved = (np.split(column, ends) for column in np.eye(mass.shape[1]))
            moved = [rigid_motion(self.kinds, column, turn, np.zeros(3), rates=True) for column in unmoved]
            turned = np.stack([np.concatenate(column) for column in moved], axis=1)
            deviation = turned.T @ self.rigid["mass"][i] @ turned - mass[i]
            value = max(value, float(np.max(np.abs(deviation)) / (np.max(np.abs(mass)) or 1.0)))
        fault = "its kinetic energy changes when the whole is turned or moved" if value > ELEMENT_LAW else ""
        return value, fault
