"""Derivatives of functions by rules that compile faster than the rules of JAX."""

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
        all_leaves = list(leaves)
        for i, value in zip(varied, values, strict=True):
            all_leaves[i] = value
        return function(*jax.tree.unflatten(structure, all_leaves))

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
        all_leaves = list(leaves)
        for i, number in zip(places, numbers, strict=True):
            all_leaves[i] = number
        return which(*jax.tree.unflatten(structure, all_leaves))

    @jax.custom_vjp
    def value(*numbers: Any):
        return called(function, numbers)

    def ahead(*numbers: Any):
        values = [number.value for number in numbers]
        results, carried = called(forward, values)
        # An empty tuple marks numbers that vary: residuals may hold arrays alone.
        return results, (values, carried, [() if number.perturbed else None for number in numbers])

    def back(carried: tuple[Any, ...], changes: Any):
        values, saved, marks = carried
        numbers = jax.tree.map(_number_of, changes, is_leaf=lambda change: isinstance(change, SymbolicZero))
        arguments = called(lambda *parts: parts, values)
        varies = [False] * len(leaves)
        for i, mark in zip(places, marks, strict=True):
            varies[i] = mark is not None
        remaining = iter(varies)
        parts = [
            _varied(argument, list(itertools.islice(remaining, len(jax.tree.leaves(argument)))))
            for argument in arguments
        ]
        derivatives = itertools.chain.from_iterable(backward(parts, saved, numbers))
        return tuple(None if mark is None else next(derivatives) for mark in marks)

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

    def with_numbers(numbers: list[Any]):
        remaining = iter(numbers)
        merged = [next(remaining) if varied else leaf for leaf, varied in zip(leaves, varies, strict=True)]
        return jax.tree.unflatten(structure, merged)

    return Varied([leaf for leaf, varied in zip(leaves, varies, strict=True) if varied], with_numbers, varies)


def jit_beside_reverse(function: Callable[..., Any], ahead: Callable[..., Any], once: str) -> Callable[..., Any]:
    """As :func:`jit_beside_options`, for a function that is differentiated in reverse mode alone.

    JAX compiles the backward pass of ``jax.grad`` without our compiler options, which takes twice as long. Here the
    backward pass is a separate program with these options.

    Args:
        function: Also takes ``known``: None, or what ``ahead`` found.
        ahead: Returns the value and what the backward pass needs: arrays, or None to evaluate the function again.
        once: Message of the error that a second derivative raises.
    """
    run, run_ahead = jit_beside_options(function), jit_beside_options(ahead)

    def pulled(varies: tuple[bool, ...], arguments: tuple[Any, ...], known: Any, changes: Any):
        varied = _varied(arguments, list(varies))
        outputs, pull = jax.vjp(lambda numbers: function(*varied.whole(numbers), known=known), varied.numbers)
        whole_numbers = [np.zeros(leaf.shape, jax.dtypes.float0) for leaf in jax.tree.leaves(outputs)]
        cotangents = [a if b is None else b for a, b in zip(whole_numbers, changes, strict=True)]
        return pull(jax.tree.unflatten(jax.tree.structure(outputs), cotangents))[0]

    pulled.__module__, pulled.__name__ = function.__module__, f"{function.__name__}_back"
    back = jit_beside_options(pulled)

    @functools.wraps(function)
    def call(*arguments: Any):
        leaves = jax.tree.leaves(arguments)
        if not any(isinstance(leaf, jax.core.Tracer) for leaf in leaves) or is_staged():
            return run(*arguments)

        def way_back(parts: list[Varied], known: Any, changes: Any):
            varies = tuple(varied for part in parts for varied in part.varies)
            cotangents = [None if leaf.dtype == jax.dtypes.float0 else leaf for leaf in jax.tree.leaves(changes)]
            # Inputs are refused too: the backward pass may call the host, whose derivatives JAX refuses unclearly.
            numbers, cotangents = refusing_derivatives(([part.numbers for part in parts], cotangents), once)
            full_parts = tuple(part.whole(part_numbers) for part, part_numbers in zip(parts, numbers, strict=True))
            derivatives = iter(back(varies, full_parts, known, cotangents))
            return [[next(derivatives) for _ in part.numbers] for part in parts]

        values: list[Any] = []

        def forward(*inputs: Any):
            value, known = run_ahead(*inputs)
            values.append(value)
            return value, known

        result = with_derivative(run, forward, way_back, *arguments)
        # Integers and flags have no derivative: return their known values.
        return jax.tree.map(_as_known, result, values[-1]) if values else result

    return call


def _as_known(number: Any, known: Any) -> Any:
    """The known value of an integer or flag, else the differentiated value."""
    use_known = not jnp.issubdtype(number.dtype, jnp.inexact) and not isinstance(known, jax.core.Tracer)
    return known if use_known else number
