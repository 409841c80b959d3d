"""Companions that several element types share: uncoupled springs and dampers, and laws of the user's own."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from .nodes import Reference, Static


def uncoupled(n: int) -> dict[str, Any]:
    """Companions ``stiffness`` and ``damping`` of n uncoupled deformations.

    Returns:
        ``f(*, ref, stiffness) -> (n, n)`` and ``f(*, ref, damping) -> (n, n)``, by name. The property is one number for
        all deformations or one number each.
    """

    def stiff(*, ref: Reference, stiffness: float) -> Float[Array, "n n"]:
        return jnp.diag(jnp.broadcast_to(stiffness, (n,)))

    def damped(*, ref: Reference, damping: float) -> Float[Array, "n n"]:
        return stiff(ref=ref, stiffness=damping)

    return {"stiffness": stiff, "damping": damped}


def mesh_stiffness(*, ref: Reference, stiffness: float) -> Float[Array, "2 2"]:
    """Companion ``stiffness`` of a gear, for its first deformation; the second is measured."""
    return jnp.diag(jnp.stack([jnp.asarray(stiffness, float), jnp.zeros(())]))


def mesh_damping(*, ref: Reference, damping: float) -> Float[Array, "2 2"]:
    """Companion ``damping`` of a gear, for its first deformation."""
    return mesh_stiffness(ref=ref, stiffness=damping)


def characteristic(
    e: Float[Array, "1"],
    ed: Float[Array, "1"],
    *,
    ref: Reference,
    law: Static[Callable[[Any, Any], Any]],
    **properties: Any,
) -> Float[Array, "1"]:
    """Companion ``law`` of an element with one deformation and a stress function of the user.

    Returns (1,) [N, N m].

    Args:
        law: ``f(e, ed, **properties) -> ()``, force [N] or moment [N m]. Its keyword-only parameters are properties of
            the element. Define it once: each function makes an element type of its own.
    """
    return jnp.reshape(law(e[0], ed[0], **properties), (1,))
