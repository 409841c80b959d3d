"""Test states of an element type, and the values and derivatives of its functions in these states."""

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from ..compilation.compile import jit
from ..elements.element import Element
from ..elements.nodes import NodeKind
from ..math import rotations

# Companions that need not have derivatives everywhere.
KINKED = ("law", "energy", "dissipation")
STEP = float(np.cbrt(np.finfo(float).eps))


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
