"""Derivatives that compile faster than those JAX would find by itself."""

import functools
import itertools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jax.custom_derivatives import SymbolicZero

from ..compilation.compile import is_staged, jit_beside_options

# Steps of Newton's method that derivatives pass through, from a solution that JAX takes as constant: one step yields
# first derivatives, two steps yield derivatives up to the third.
DIFFERENTIATED = 2


def jvp_of_varied(function: Callable[..., Any], primals: tuple, tangents: tuple) -> tuple[Any, Any]:
    """As ``jax.jvp``, without tracing tangents that are symbolic zeros."""
    leaves, structure = jax.tree.flatten(primals)
    changes = jax.tree.leaves(tangents, is_leaf=lambda t: isinstance(t, SymbolicZero))
    varied = [i for i, change in enumerate(changes) if not isinstance(change, SymbolicZero)]

    def of_varied(values: list[Any]):
        whole = list(leaves)
        for i, value in zip(varied, values, strict=True):
            whole[i] = value
        return function(*jax.tree.unflatten(structure, whole))

    return jax.jvp(of_varied, ([leaves[i] for i in varied],), ([changes[i] for i in varied],))


def _number_of(change: Any) -> Any:
    """A change as an array; symbolic zeros become zeros."""
    shaped: Any = change
    return jnp.zeros(shaped.shape, shaped.dtype) if isinstance(change, SymbolicZero) else change


class Varied(NamedTuple):
    """An argument with its varying numbers, its reconstruction from these numbers, and which of its leaves vary."""

    numbers: list[Any]
    whole: Callable[[list[Any]], Any]
    varies: list[bool]


def with_derivative(
    function: Callable[..., Any],
    forward: Callable[..., tuple[Any, Any]],
    backward: Callable[..., Sequence[list[Any]]],
    *arguments: Any,
) -> Any:
    """Value of a function with a given derivative in reverse mode.

    Args:
        forward: Called instead of the function under differentiation: the same value, and what ``backward`` needs.
        backward: Of a :class:`Varied` for each argument, of what ``forward`` kept, and of a cotangent: the derivatives
            by the varying numbers of each argument.
    """
    leaves, structure = jax.tree.flatten(arguments)
    places = [i for i, leaf in enumerate(leaves) if isinstance(leaf, jax.Array | np.ndarray)]

    def called(which: Callable[..., Any], numbers: Sequence[Any]):
        whole = list(leaves)
        for i, number in zip(places, numbers, strict=True):
            whole[i] = number
        return which(*jax.tree.unflatten(structure, whole))

    @jax.custom_vjp
    def value(*numbers: Any):
        return called(function, numbers)

    def ahead(*numbers: Any):
        values = [number.value for number in numbers]
        found, carried = called(forward, values)
        # An empty tuple marks numbers that vary: residuals may hold arrays alone.
        return found, (values, carried, [() if number.perturbed else None for number in numbers])

    def back(carried: tuple[Any, ...], changes: Any):
        values, kept, marks = carried
        numbers = jax.tree.map(_number_of, changes, is_leaf=lambda change: isinstance(change, SymbolicZero))
        given = called(lambda *whole: whole, values)
        varies = [False] * len(leaves)
        for i, mark in zip(places, marks, strict=True):
            varies[i] = mark is not None
        left = iter(varies)
        parts = [_varied(one, list(itertools.islice(left, len(jax.tree.leaves(one))))) for one in given]
        found = itertools.chain.from_iterable(backward(parts, kept, numbers))
        return tuple(None if mark is None else next(found) for mark in marks)

    value.defvjp(ahead, back, symbolic_zeros=True)
    return value(*[leaves[i] for i in places])


def refusing_derivatives(value: Any, message: str) -> Any:
    """The same numbers, whose derivatives raise TypeError in both modes, even under ``stop_gradient``."""

    @jax.custom_jvp
    def same(number: jax.Array):
        return number

    @same.defjvp
    def _(*_: Any):
        raise TypeError(message)

    return jax.tree.map(same, value)


def root_or_zero(square: Any) -> Any:
    """Square root of a non-negative number, with derivative zero at zero; NaN stays NaN."""
    none = square <= 0
    return jnp.where(none, 0.0, jnp.sqrt(jnp.where(none, 1.0, square)))


def _varied(argument: Any, varies: list[bool]) -> Varied:
    leaves, structure = jax.tree.flatten(argument)

    def whole(numbers: list[Any]):
        left = iter(numbers)
        own = [next(left) if varied else leaf for leaf, varied in zip(leaves, varies, strict=True)]
        return jax.tree.unflatten(structure, own)

    return Varied([leaf for leaf, varied in zip(leaves, varies, strict=True) if varied], whole, varies)


def jit_beside_reverse(function: Callable[..., Any], ahead: Callable[..., Any], once: str) -> Callable[..., Any]:
    """As :func:`jit_beside_options`, for a function that is differentiated in reverse mode alone.

    JAX compiles the backward pass of ``jax.grad`` without our compiler options, which takes twice as long. Here the
    backward pass is a separate program with these options.

    Args:
        function: Also takes ``known``: None, or what ``ahead`` found.
        ahead: Returns the value and what the backward pass needs: arrays, or None to evaluate the function again.
        once: Message of the error that a second derivative raises.
    """
    run, there = jit_beside_options(function), jit_beside_options(ahead)

    def pulled(varies: tuple[bool, ...], arguments: tuple[Any, ...], known: Any, changes: Any):
        own = _varied(arguments, list(varies))
        found, pull = jax.vjp(lambda numbers: function(*own.whole(numbers), known=known), own.numbers)
        whole_numbers = [np.zeros(one.shape, jax.dtypes.float0) for one in jax.tree.leaves(found)]
        given = [a if b is None else b for a, b in zip(whole_numbers, changes, strict=True)]
        return pull(jax.tree.unflatten(jax.tree.structure(found), given))[0]

    pulled.__module__, pulled.__name__ = function.__module__, f"{function.__name__}_back"
    back = jit_beside_options(pulled)

    @functools.wraps(function)
    def call(*arguments: Any):
        leaves = jax.tree.leaves(arguments)
        if not any(isinstance(leaf, jax.core.Tracer) for leaf in leaves) or is_staged():
            return run(*arguments)

        def way_back(parts: list[Varied], known: Any, changes: Any):
            varies = tuple(varied for part in parts for varied in part.varies)
            given = [None if one.dtype == jax.dtypes.float0 else one for one in jax.tree.leaves(changes)]
            # Inputs are refused too: the backward pass may call the host, whose derivatives JAX refuses unclearly.
            numbers, given = refusing_derivatives(([part.numbers for part in parts], given), once)
            whole = tuple(part.whole(own) for part, own in zip(parts, numbers, strict=True))
            found = iter(back(varies, whole, known, given))
            return [[next(found) for _ in part.numbers] for part in parts]

        values: list[Any] = []

        def forward(*given: Any):
            value, known = there(*given)
            values.append(value)
            return value, known

        found = with_derivative(run, forward, way_back, *arguments)
        # Integers and flags have no derivative: return their known values.
        return jax.tree.map(_as_known, found, values[-1]) if values else found

    return call


def _as_known(found: Any, known: Any) -> Any:
    """The known value of an integer or flag, else the differentiated value."""
    whole = not jnp.issubdtype(found.dtype, jnp.inexact) and not isinstance(known, jax.core.Tracer)
    return known if whole else found


def pointwise(function: Callable[[jax.Array], jax.Array]) -> Callable[[jax.Array], jax.Array]:
    """A function of one number, applied to each entry of an array; its derivative is computed once per entry.

    JAX would carry every direction of a derivative through each operation. Here each direction is multiplied by the
    slope. The result may be differentiated any number of times.
    """

    @jax.custom_jvp
    def applied(x: jax.Array):
        return function(x)

    @applied.defjvp
    def _(primals: tuple[jax.Array, ...], tangents: tuple[jax.Array, ...]):
        (x,), (change,) = primals, tangents
        slope = pointwise(lambda x: jax.jvp(function, (x,), (jnp.ones_like(x),))[1])
        return applied(x), slope(x) * change

    return applied
