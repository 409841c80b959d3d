"""Companions that several element types share: uncoupled springs and dampers, and laws of the user's own."""

import functools
import inspect
from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..arguments import shown
from .element import Element


def diagonal_stiffness(n: int) -> Callable[..., Any]:
    """Companion ``stiffness`` of n deformations that are not coupled.

    Args:
        n: Number of deformations.

    Returns:
        ``f(*, ref, stiffness) -> (n, n)``; the property is one number for all of them or one for each.
    """

    def diagonal(*, ref, stiffness: float):
        return jnp.diag(jnp.broadcast_to(stiffness, (n,)))

    return diagonal


def diagonal_damping(n: int) -> Callable[..., Any]:
    """Companion ``damping`` of n deformations that are not coupled.

    Args:
        n: Number of deformations.

    Returns:
        ``f(*, ref, damping) -> (n, n)``; the property is one number for all of them or one for each.
    """

    def diagonal(*, ref, damping: float):
        return jnp.diag(jnp.broadcast_to(damping, (n,)))

    return diagonal


def mesh_stiffness(*, ref, stiffness: float) -> Float[Array, "2 2"]:
    """Companion ``stiffness`` of a gear: of its first deformation, while the second is measured."""
    return jnp.diag(jnp.stack([jnp.asarray(stiffness, float), jnp.zeros(())]))


def mesh_damping(*, ref, damping: float) -> Float[Array, "2 2"]:
    """Companion ``damping`` of a gear, likewise."""
    return mesh_stiffness(ref=ref, stiffness=damping)


def as_law(characteristic: Callable[..., Any]) -> Callable[..., Any]:
    """Companion ``law`` of an element with one deformation.

    Args:
        characteristic: ``f(e, ed, **properties) -> ()``, force or moment of a deformation and its rate. Its
            keyword-only parameters are properties of the element.

    Returns:
        ``f(e, ed, *, ref, **properties) -> (1,)``.

    Raises:
        TypeError: The function does not take a deformation and a rate.
    """
    if not callable(characteristic):
        raise TypeError(f"A law must be a function of a deformation and its rate, not {shown(characteristic)}.")
    given = list(inspect.signature(characteristic).parameters.values())
    own = [p for p in given if p.kind is p.KEYWORD_ONLY]
    if len(given) - len(own) != 2 or any(p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in given):
        name = getattr(characteristic, "__name__", str(characteristic))
        raise TypeError(
            f"Law '{name}' must take a deformation and its rate, and properties by keyword: def {name}(e, ed, *, ...)."
        )

    def law(e, ed, *, ref, **properties):
        return jnp.reshape(characteristic(e[0], ed[0], **properties), (1,))

    # What the signature names are the properties that the builder asks for.
    ends = [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in ("e", "ed")]
    ref = inspect.Parameter("ref", inspect.Parameter.KEYWORD_ONLY)
    setattr(law, "__signature__", inspect.Signature([*ends, ref, *own]))  # noqa: B010
    return law


def spring_damper_of(
    deformation: Callable[..., Any], check: Callable[..., list[str]] | None = None
) -> Callable[..., Element]:
    """Element types of one deformation whose stress is a law of the user's own.

    Args:
        deformation: Deformation function with one value, e1.
        check: Companion ``check``, if any.

    Returns:
        Function from a law to an element type; the same law gives the same type.
    """

    @functools.cache
    def spring_damper(law: Callable[..., Any]) -> Element:
        """Spring, damper or actuator with a force or moment of one's own.

        e1 change of the distance of two points [m], or rotation of body q relative to body p [rad], in space about the
        property axis (global, undeformed state). Its stress resultant is the force that pulls the points together, or
        the moment on body p. It holds nothing: the hinge beside it does.

        Args:
            law: ``f(e, ed, **properties) -> ()``, force [N] or moment [N m] of e1 and its rate. Its keyword-only
                parameters are properties of the element. Define it once: each function is an element type of its own.

        Returns:
            Element type.

        Raises:
            TypeError: The law does not take a deformation and a rate.

        Source:
            The power is law times ed.
        """
        return Element(deformation, law=as_law(law), check=check)

    return spring_damper
