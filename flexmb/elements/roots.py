"""Spreading of loads from a narrow part into a wide part, and stiffness of a root in an elastic block."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, holds, short_repr
from ..errors import ModelError
from .section import Material, Scalar, Section

# Factors of the spreading lengths in (2.49): of H in tension, and in bending in the plane of the step.
STRETCHED, BENT = 0.964, 0.412
# Rotation of the root of a strip in a half plane, times pi E' t^2 over the moment per width: O'Donnell (1960).
HALF_PLANE = 50 / 3
# Rotation of the root by torque, in antiplane shear of a half plane, times pi G t^2 over the torque per width.
TWISTED = 2.25


def spreading_length(share: Any) -> Any:
    """Return the spreading length of a load at a symmetric step, over half of the narrow width.

    Args:
        share: Narrow width over wide width, () [-].

    Returns:
        () [-]; zero if the other part is not wider.

    Source:
        THEORY.md 2, eq. (2.49): potential flow.
    """
    a = jnp.where(share < 1, share, 0.5)
    spreading = (a**2 + 1) / a * jnp.log((1 + a) / (1 - a)) - 2 * jnp.log(4 * a / (1 - a**2))
    return jnp.where(share < 1, spreading / np.pi, 0.0)


def bent_spread(share: Any) -> Any:
    """Return the spreading length of a moment in the plane of the step, over the narrow width. Source: eq. (2.49)."""
    a = jnp.where(share < 1, share, 0.5)
    return jnp.where(share < 1, BENT * (1 - a**2.05) ** 1.7, 0.0)


def root_stiffness(section: Section, material: Material, thickness: Scalar) -> Float[Array, "6"]:
    """Return the stiffnesses of the root of a leaf spring in an elastic block, for its property ``clamp``.

    The block is as wide as the leaf spring and symmetric about its middle plane. In tension and shear, the compliance
    grows with the logarithm of the thickness of the block over the thickness of the leaf spring. Moments spread over a
    few thicknesses of the leaf spring. The compliances of screws and joints are not included.

    Args:
        section: Rectangle of the leaf spring.
        material: Material of the block.
        thickness: Thickness of the block, across the leaf spring, () [m].

    Returns:
        Stiffnesses along local x, y, z [N/m] and about x, y, z [N m/rad], (6,). For a leaf spring in the plane use
        entries 0, 2 and 4: along x, along z and about y.

    Raises:
        TypeError: The section is not a rectangle, or the material is not a :class:`flexmb.Material`.
        ModelError: The block is not thicker than the leaf spring.

    Source:
        THEORY.md 2, eq. (2.53). Rotation about y: O'Donnell (1960), Journal of Applied Mechanics 27, 461.
    """
    if not hasattr(section, "width") or not hasattr(section, "thickness"):
        raise TypeError(f"Argument `section` must be a Rectangle, not {short_repr(section)}.")
    if not isinstance(material, Material):
        raise TypeError(f"Argument `material` must be a Material, not {short_repr(material)}.")
    rectangle: Any = section
    check_number("thickness", thickness, above=0, fault=ModelError)
    nu = material.poisson()
    share, per_width = rectangle.thickness / thickness, (1 - nu**2) / (material.E * rectangle.width)
    if not holds(share < 1):
        raise ModelError("The block at the root must be thicker than the leaf spring.")
    along = STRETCHED * spreading_length(share) * per_width
    across = spreading_length(share) / (2 * material.shear_modulus() * rectangle.width)
    bent = HALF_PLANE / np.pi * per_width / rectangle.thickness**2
    twisted = TWISTED / (np.pi * material.shear_modulus() * rectangle.width * rectangle.thickness**2)
    flexible = [along, across, along, twisted, bent, 12 * along / rectangle.width**2]
    return 1 / jnp.stack([jnp.asarray(value, float) for value in flexible])
