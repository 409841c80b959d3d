"""Truncated polynomials (jets): a function's rates along a motion and their derivatives, in one pass.

Nested differentiation computes each rate and each derivative by separate operations, some fifteen times as many. A jet
stores all of them in one array. A linear operation then stays one operation, and a product becomes a few operations.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..compilation.program import is_literal, needed

if TYPE_CHECKING:
    from jax.extend.core import Jaxpr

# Operations that are linear in all operands together; operations that are linear in one operand with the others
# constant; programs within programs.
TOGETHER = {"add", "add_any", "concatenate", "pad", "select_n", "stack", "sub"}
ALONE = {"broadcast_in_dim", "convert_element_type", "copy", "cumsum", "div", "dot_general", "dynamic_slice", "gather"}
ALONE |= {"mul", "neg", "reduce_sum", "reshape", "rev", "slice", "split", "squeeze", "transpose"}
INLINE = {"jit", "pjit", "closed_call"}
# Operations that take an argument apart, by NumPy, for index arrays.
APART: dict[str, Callable[..., list[np.ndarray]]] = {
    "split": lambda x, sizes, axis: np.split(x, np.cumsum(sizes)[:-1], axis),
    "squeeze": lambda x, dimensions: [np.squeeze(x, dimensions)],
}


class Jet(NamedTuple):
    """A number as a polynomial.

    Attributes:
        parts: Value, rate, half the second rate, and rate along another motion, as many as are asked for; of each part
            first itself, then its derivatives in some directions, (parts, 1 + directions, ...).
        directions: The directions of ``parts``; derivatives in all others are zero.
        chosen: Entries of the argument of which the number consists, or None.
    """

    parts: Any
    directions: tuple[int, ...]
    chosen: np.ndarray | None = None

    @property
    def value(self) -> Array:
        """The number itself."""
        return self.parts[0, 0]


def jets(function: Callable[..., Any], motion: tuple[Array, ...], aside: Array | None, directed: bool) -> Any:
    """Rates of a function of one array along a motion and along another one ``aside``.

    Each array of the result becomes (rates, 1 + n, ...) if ``directed``: value and rates, each followed by its
    derivatives by the n entries of x at constant rates of x; else (rates, 1, ...).
    """
    x = motion[0]
    jaxpr, constants, like = _traced(function, x)
    parts = [*motion[:2], *(0.5 * rate for rate in motion[2:]), *([] if aside is None else [aside])]
    n = x.shape[0]
    algebra = Algebra(len(motion), jnp.stack(parts), range(n) if directed else range(0))
    found = algebra.evaluated(jaxpr, constants, [algebra.chosen(np.arange(n))])
    factors = np.array([2.0 if 2 <= k < len(motion) else 1.0 for k in range(len(parts))])
    leaves = []
    for jet in found:
        parts = algebra.expanded(algebra.lifted(jet), tuple(algebra.directions)).parts
        leaves.append(parts * factors.reshape(-1, *[1] * (parts.ndim - 1)) if len(motion) > 2 else parts)
    return jax.tree.unflatten(jax.tree.structure(like), leaves)


def length(function: Callable[..., Any], x: Array) -> int:
    """Number of operations of a function of one array, inner programs included."""
    return _length(_traced(function, x)[0])


def _traced(function: Callable[..., Any], x: Array) -> tuple[Jaxpr, Any, Any]:
    """Program of a function without unused operations, its constants, and the structure of its results."""
    program, like = jax.make_jaxpr(function, return_shape=True)(jax.typeof(x))
    jaxpr = program.jaxpr
    return jaxpr.replace(eqns=needed(jaxpr.eqns, jaxpr.outvars)[0]), program.consts, like


def _length(jaxpr: Jaxpr) -> int:
    within = [getattr(each, "jaxpr", each) for equation in jaxpr.eqns for each in equation.params.values()]
    return len(jaxpr.eqns) + sum(_length(each) for each in within if hasattr(each, "eqns"))


class Algebra:
    """Arithmetic of jets.

    Attributes:
        orders: Number of parts along the motion: value, rate, and half the second rate if asked for.
        argument: Parts of the argument, (parts, n).
        directions: Directions of derivatives.
    """

    def __init__(self, orders: int, argument: Array, directions: range):
        self.orders, self.argument, self.directions = orders, argument, directions
        self.count = argument.shape[0]
        # table[k, i, j]: part k of a product has the product of parts i of one and j of the other.
        table = np.zeros((self.count, self.count, self.count))
        for i in range(orders):
            for j in range(orders - i):
                table[i + j, i, j] = 1.0
        for k in range(orders, self.count):
            table[k, 0, k] = table[k, k, 0] = 1.0
        # A matrix that multiplies the parts of one factor; the result multiplies the parts of the other.
        self.table = table.reshape(-1, self.count)

    def chosen(self, entries: np.ndarray) -> Jet:
        """Entries of the argument."""
        known = tuple(np.unique(entries).tolist()) if self.directions else ()
        own = np.zeros((self.count, len(known), *entries.shape))
        own[0] = np.equal.outer(known, entries)
        return Jet(jnp.concatenate([self.argument[:, entries][:, None], own], axis=1), known, entries)

    def evaluated(self, jaxpr: Jaxpr, constants: Any, arguments: list) -> list:
        """Results of a program; those independent of the argument are plain numbers."""
        known: dict = dict(zip([*jaxpr.constvars, *jaxpr.invars], [*constants, *arguments], strict=True))
        used = [v for equation in jaxpr.eqns for v in equation.invars] + list(jaxpr.outvars)
        sums = {e.invars[0] for e in jaxpr.eqns if e.primitive.name == "reduce_sum"}
        sums = {v for v in sums if not is_literal(v) and sum(v is one for one in used) == 1}
        factors: dict[Any, tuple[Jet, Jet]] = {}
        for equation in jaxpr.eqns:
            taken: Any = [atom.val if is_literal(atom) else known.get(atom) for atom in equation.invars]
            name, read = equation.primitive.name, [v for v in equation.invars if not is_literal(v)]
            if name == "mul" and equation.outvars[0] in sums and all(isinstance(one, Jet) for one in taken):
                # Product and sum together are a product of matrices.
                factors[equation.outvars[0]] = tuple(taken)
            elif read and read[0] in factors:
                a, b = factors.pop(read[0])
                known[equation.outvars[0]] = self.product(a, b, equation.params["axes"])
            else:
                known.update(zip(equation.outvars, self.applied(jaxpr, equation, taken), strict=True))
        return [atom.val if is_literal(atom) else known[atom] for atom in jaxpr.outvars]

    def applied(self, jaxpr: Jaxpr, equation: Any, taken: list) -> list:
        """Results of one operation."""
        name, parameters = equation.primitive.name, equation.params
        varying = [isinstance(one, Jet) for one in taken]

        def function(*taken: Any):
            return jax.core.eval_jaxpr(_alone(jaxpr, equation), (), *taken)

        real = [np.issubdtype(v.aval.dtype, np.inexact) for v in equation.outvars]
        if not any(varying) or not any(real):
            return function(*[one.value if isinstance(one, Jet) else one for one in taken])
        if name in INLINE:
            return self.evaluated(parameters["jaxpr"].jaxpr, parameters["jaxpr"].consts, taken)
        if name in APART and taken[0].chosen is not None:
            return [self.chosen(entries) for entries in APART[name](taken[0].chosen, **parameters)]
        if name == "square" or (name == "integer_pow" and parameters["y"] == 2):
            return [self.product(taken[0], taken[0])]
        if name == "mul" and all(varying):
            return [self.product(*taken)]
        if name == "select_n" and varying[0]:
            taken[0], varying[0] = taken[0].value, False
        if name in TOGETHER and any(varying):
            return self.linear(function, self.together(taken, 1 if name == "select_n" else 0))
        if name in ALONE and sum(varying) == 1 and (varying[0] or name in ("mul", "dot_general")):
            return self.linear(function, taken)
        if not any(varying):
            return function(*taken)
        found = iter(
            self.general(lambda *taken: [y for y, of in zip(function(*taken), real, strict=True) if of], taken)
        )
        if all(real):
            return list(found)
        whole = function(*[one.value if isinstance(one, Jet) else one for one in taken])
        return [next(found) if of else one for of, one in zip(real, whole, strict=True)]

    def linear(self, function: Callable[..., Any], taken: list) -> list:
        """Results of an operation that is linear in all its jets together, which have the same directions."""
        axes = [0 if isinstance(one, Jet) else None for one in taken]
        (shape, directions), *_ = [(one.parts.shape[:2], one.directions) for one in taken if isinstance(one, Jet)]
        count = shape[0] * shape[1]
        flat = [one.parts.reshape(count, *one.parts.shape[2:]) if isinstance(one, Jet) else one for one in taken]
        return [Jet(one.reshape(*shape, *one.shape[1:]), directions) for one in jax.vmap(function, axes)(*flat)]

    def together(self, taken: list, first: int) -> list:
        """Operands from number ``first`` on as jets with the same directions."""
        own = [self.lifted(one) for one in taken[first:]]
        every = tuple(sorted(set().union(*[one.directions for one in own])))
        return [*taken[:first], *[self.expanded(one, every) for one in own]]

    def lifted(self, one: Any) -> Jet:
        """A constant as a jet."""
        if isinstance(one, Jet):
            return one
        one = jnp.asarray(one)
        return Jet(_padded(one[None, None], 0, 0, self.count - 1), ())

    def expanded(self, one: Jet, directions: tuple[int, ...]) -> Jet:
        """A jet with more directions, in order."""
        if one.directions == directions:
            return one
        places = np.array([directions.index(d) for d in one.directions], int)
        if not len(places):
            return Jet(_padded(one.parts, 1, 0, len(directions)), directions)
        first, count, more = int(places[0]), len(places), len(directions) - len(places)
        if not np.array_equal(places, np.arange(first, first + count)):
            of = np.full(len(directions) + 1, count + 1)
            of[0], of[1 + places] = 0, 1 + np.arange(count)
            return Jet(_padded(one.parts, 1, 0, 1)[:, of], directions)
        if not first:
            return Jet(_padded(one.parts, 1, 0, more), directions)
        itself, rest = one.parts[:, :1], _padded(one.parts[:, 1:], 1, first, more - first)
        return Jet(jnp.concatenate([itself, rest], axis=1), directions)

    def product(self, a: Jet, b: Jet, axes: tuple[int, ...] = ()) -> Jet:
        """Product entry by entry, summed over axes."""
        rank = max(a.parts.ndim, b.parts.ndim)
        one, other = _of_rank(a.parts, rank), _of_rank(b.parts, rank)
        found = Jet(self._contracted(one, other, axes), b.directions)
        if not a.directions:
            return found
        if a is b:
            twice = np.array([1.0] + [2.0] * len(a.directions)).reshape(1, -1, *[1] * (found.parts.ndim - 2))
            return Jet(found.parts * twice, a.directions)
        # Only its derivatives: the value is counted already.
        more = self._contracted(other, one[:, 1:], axes)
        if set(a.directions).isdisjoint(b.directions):
            return Jet(jnp.concatenate([found.parts, more], axis=1), (*b.directions, *a.directions))
        every = tuple(sorted({*a.directions, *b.directions}))
        changed = self.expanded(Jet(_padded(more, 1, 1, 0), a.directions), every)
        return Jet(self.expanded(found, every).parts + changed.parts, every)

    def _contracted(self, factor: Array, parts: Array, axes: tuple[int, ...]) -> Array:
        """Products of parts with value and rates of another factor, summed over axes."""
        value = factor[:, 0]
        matrix = (self.table @ value.reshape(self.count, -1)).reshape(self.count, self.count, *value.shape[1:])
        if not axes:
            return jnp.sum(matrix[:, :, None] * parts[None], axis=1)
        # As a product of matrices, without the axes along which a factor has size one.
        shapes = value.shape[1:], parts.shape[2:]
        sizes = [max(pair) for pair in zip(*shapes, strict=True)]
        own, theirs = ([i for i, size in enumerate(shape) if size == sizes[i]] for shape in shapes)
        matrix = matrix.reshape(self.count, self.count, *[sizes[i] for i in own])
        parts = parts.reshape(*parts.shape[:2], *[sizes[i] for i in theirs])
        left, right, result = (
            "".join(chr(ord("a") + i) for i in kept)
            for kept in (own, theirs, [i for i in range(len(sizes)) if i not in axes])
        )
        return jnp.einsum(f"yx{left},xz{right}->yz{result}", matrix, parts)

    def general(self, function: Callable[..., Any], taken: list) -> list:
        """Results of any operation, by its derivatives."""
        every = tuple(sorted(set().union(*[one.directions for one in taken if isinstance(one, Jet)])))
        own = [self.expanded(one, every).parts for one in taken if isinstance(one, Jet)]

        def of_varying(*values: Array):
            given = iter(values)
            return function(*[next(given) if isinstance(one, Jet) else one for one in taken])

        def along(parts: list[Array]):
            at, *rates = [[one[k] for one in parts] for k in range(self.count)]

            def first(at: list[Array], rate: list[Array]):
                return jax.jvp(of_varying, at, rate)

            if self.orders == 2:
                found = [*first(at, rates[0])]
            else:
                twice = [2.0 * one for one in rates[1]]
                (value, rate), (_, second) = jax.jvp(first, (at, rates[0]), (rates[0], twice))
                found = [value, rate, [0.5 * one for one in second]]
            found += [first(at, rate)[1] for rate in rates[self.orders - 1 :]]
            return [jnp.stack(each) for each in zip(*found, strict=True)]

        at, changes = [one[:, 0] for one in own], [one[:, 1:] for one in own]
        if not every:
            return [Jet(one[:, None], ()) for one in along(at)]
        value, changed = jax.vmap(lambda change: jax.jvp(along, (at,), (change,)), 1, (None, 1))(changes)
        return [Jet(jnp.concatenate([v[:, None], c], axis=1), every) for v, c in zip(value, changed, strict=True)]


def _padded(array: Array, axis: int, before: int, after: int) -> Array:
    """An array with zeros before and after it along an axis."""
    if not before and not after:
        return array
    amounts = [(before, after, 0) if i == axis else (0, 0, 0) for i in range(array.ndim)]
    return jax.lax.pad(array, np.zeros((), array.dtype), amounts)


def _of_rank(parts: Array, rank: int) -> Array:
    """Parts of a number with axes of size one, for products with numbers of higher rank."""
    return parts.reshape(*parts.shape[:2], *[1] * (rank - parts.ndim), *parts.shape[2:])


def _alone(jaxpr: Jaxpr, equation: Any) -> Jaxpr:
    """One equation of a program, as a program of all its operands."""
    from jax.extend.core import Var

    inputs, outputs = [Var(atom.aval) for atom in equation.invars], [Var(v.aval) for v in equation.outvars]
    own = [equation.replace(invars=inputs, outvars=outputs)]
    return jaxpr.replace(constvars=[], invars=inputs, eqns=own, outvars=outputs)
