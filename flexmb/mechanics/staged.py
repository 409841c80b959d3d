"""Derivatives of element functions, some in two stages: first by the inner coordinates, then by all."""

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.program import split_in_stages


class Staged:
    """A function of the coordinates of one element, in two stages: first inner coordinates only, then all coordinates.

    Inner coordinates are coefficients of strains and warpings, about half of the coordinates. They determine the poses
    along a spatial beam relative to its first end. These poses need nearly all operations of deformations and inertia.
    Two stages avoid derivatives of these operations by the other coordinates.

    Call it as ``f(x_el, ref_el, numbers_el)``. The numbers include all values that depend on the reference.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        nodes: Sequence[jax.ShapeDtypeStruct],
        is_inner: Sequence[bool],
        numbers: tuple[Any, ...],
    ):
        """Split a function into two stages."""

        def every(numbers: tuple[Any, ...], *coordinates: tuple[Array, ...]):
            inner, outer = map(iter, coordinates)
            return (), (), function([next(inner if which else outer) for which in is_inner], *numbers)

        groups = [tuple(itertools.compress(nodes, which)) for which in (is_inner, np.logical_not(is_inner))]
        self._known, self._bent, self._closed = split_in_stages(every, [numbers, *groups])
        sizes = [node.shape[0] for node in nodes]
        self._is_inner = np.repeat(is_inner, sizes)
        self._splits = [np.cumsum([node.shape[0] for node in group])[:-1] for group in groups]
        order = np.concatenate([np.flatnonzero(self._is_inner), np.flatnonzero(~self._is_inner)])
        self._place = np.argsort(order)
        self._shape = jax.eval_shape(
            lambda inner, *every: self._bent(*inner, *self._known(*every)[1])[1], groups[0], *numbers
        )
        if not all(np.issubdtype(leaf.dtype, np.floating) for leaf in self._shape):
            raise TypeError("Results of the inner coordinates must be differentiable numbers.")

    def __call__(self, x: Any, ref: Float[Array, "c"], numbers: tuple[Array, ...]) -> Any:
        """Return the value of the function; coordinates may be a list by node."""
        x = jnp.concatenate(x) if isinstance(x, list) else x
        bent, closed = self._stages(numbers)
        return closed(x[~self._is_inner], bent(x[self._is_inner]))

    def derivative(self, x: Float[Array, "c"], ref: Float[Array, "c"], numbers: tuple[Array, ...]) -> tuple[Any, Any]:
        """Return the derivatives by the coordinates, on the last axis of each array, and the value."""
        value, by_all = derivative_in_stages(*self._stages(numbers), x[self._is_inner], x[~self._is_inner])
        return jax.tree.map(lambda derivatives: derivatives[..., self._place], by_all), value

    def curvature(
        self, x: Float[Array, "c"], sigma: Float[Array, "n"], ref: Float[Array, "c"], numbers: tuple[Array, ...]
    ) -> Float[Array, "c c"]:
        """Return second derivatives of sigma . e by the coordinates; the function returns the deformations e."""
        bent, closed = self._stages(numbers)
        inner, outer = x[self._is_inner], x[~self._is_inner]
        hessian = hessian_in_stages(bent, lambda outer, shape: sigma @ closed(outer, shape), inner, outer)
        return hessian[self._place][:, self._place]

    def _stages(self, numbers: tuple[Array, ...]) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """Both stages as functions of flat arrays."""
        _, known = self._known(*numbers)
        of_inner, of_outer = self._splits

        def bent(inner: Float[Array, "k"]):
            results = self._bent(*jnp.split(inner, of_inner), *known)[1]
            return jnp.concatenate([jnp.ravel(result) for result in results])

        def closed(outer: Float[Array, "m"], shape: Float[Array, "s"]):
            parts = jnp.split(shape, np.cumsum([leaf.size for leaf in self._shape])[:-1])
            parts = [jnp.reshape(part, leaf.shape) for part, leaf in zip(parts, self._shape, strict=True)]
            return self._closed(*jnp.split(outer, of_outer), *known, *parts)[0]

        return bent, closed


Bend = Callable[[Float[Array, "k"]], Float[Array, "s"]]


def derivative_in_stages(
    bent: Bend, closed: Callable[..., Any], inner: Float[Array, "k"], outer: Float[Array, "m"]
) -> tuple[Any, Any]:
    """Return ``closed(outer, bent(inner))`` and its derivatives by inner, then outer coordinates, on the last axis."""
    slopes, shape = jax.jacfwd(lambda inner: (bent(inner),) * 2, has_aux=True)(inner)
    return _along(closed, (outer, shape), slopes)


def hessian_in_stages(
    bent: Bend, energy: Callable[..., Float[Array, ""]], inner: Float[Array, "k"], outer: Float[Array, "m"]
) -> Float[Array, "k+m k+m"]:
    """Return second derivatives of ``energy(outer, bent(inner))`` by inner, then outer coordinates."""
    gradient = jax.grad(energy, (0, 1))
    shape = bent(inner)
    weight = gradient(outer, shape)[1]

    def with_pull(inner: Float[Array, "k"]):
        shape, pull = jax.vjp(bent, inner)
        return shape, pull(weight)[0]

    slopes, of_inner = jax.jacfwd(with_pull)(inner)
    _, (of_outer, of_shape) = _along(gradient, (outer, shape), slopes)
    hessian = jnp.concatenate([slopes.T @ of_shape, of_outer])
    return hessian + jnp.pad(of_inner, (0, outer.size))


def _along(function: Callable[..., Any], at: tuple[Array, Array], slopes: Float[Array, "s k"]) -> tuple[Any, Any]:
    """Value of a function of outer coordinates and a shape, and derivatives by inner and outer coordinates."""
    outer, shape = at
    changes = jnp.concatenate([jnp.zeros((outer.size, slopes.shape[1])), jnp.eye(outer.size)], axis=1)
    along = jnp.concatenate([slopes, jnp.zeros((shape.size, outer.size))], axis=1)
    return jax.vmap(lambda *change: jax.jvp(function, at, change), (1, 1), (None, -1))(changes, along)


def derivative(function: Callable[..., Any], arguments: int | tuple[int, ...] = 0) -> Callable[..., tuple[Any, Any]]:
    """Return a function for the derivatives by some arguments, on the last axis of each array, and the value."""
    if isinstance(function, Staged):
        return function.derivative

    def with_value(*values: Any):
        value = function(*values)
        return value, value

    return jax.jacfwd(with_value, arguments, has_aux=True)


def curvature(function: Callable[..., Float[Array, "n"]]) -> Callable[..., Float[Array, "c c"]]:
    """Return ``f(x_el, sigma_el, *arguments_el) -> (c, c)`` for second derivatives of sigma . e of an element."""
    if isinstance(function, Staged):
        return function.curvature

    def energy(x: Float[Array, "c"], sigma: Float[Array, "n"], *arguments: Any):
        return sigma @ function(x, *arguments)

    return jax.jacfwd(jax.grad(energy))
