"""How loads spread from a narrow part into a wide one, and what the root of a leaf spring in an elastic block gives."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, holds, shown
from ..errors import ModelError
from .section import Material, Scalar, Section

# Spreading in tension over that of potential flow, and in bending in the plane in which the load spreads.
STRETCHED, BENT = 0.964, 0.412
# Rotation of the root of a strip in a half plane, times pi E' t^2 over the moment per width.
HALF_PLANE = 50 / 3
# The same of the root of twist, times pi G t^2 over the torque per width.
TWISTED = 2.25


def spread(share: Any) -> Any:
    """Length over which a load spreads from a narrow part into a wide one, over the narrow width; symmetric step.

    Args:
        share: Narrow width over wide width, () [-].

    Returns:
        () [-]; zero where the other part is not wider.

    Source:
        THEORY.md 2, eq. (2.49): potential flow.
    """
    a = jnp.where(share < 1, share, 0.5)
    found = (a**2 + 1) / a * jnp.log((1 + a) / (1 - a)) - 2 * jnp.log(4 * a / (1 - a**2))
    return jnp.where(share < 1, found / np.pi, 0.0)


def bent_spread(share: Any) -> Any:
    """The same for a moment in the plane in which the load spreads. Source: THEORY.md 2, eq. (2.49)."""
    a = jnp.where(share < 1, share, 0.5)
    return jnp.where(share < 1, BENT * (1 - a**2.05) ** 1.7, 0.0)


def root_stiffness(section: Section, material: Material, thickness: Scalar) -> Float[Array, "6"]:
    """Stiffnesses of the root of a leaf spring in an elastic block, for the property ``clamp`` of a leaf spring.

    The block is as wide as the leaf spring and symmetric about its middle plane. Its thickness counts in tension and
    shear, by the logarithm of it over that of the leaf spring; moments spread over a few thicknesses of the leaf
    spring. What belongs to screws and joints comes on top.

    Args:
        section: Rectangle of the leaf spring.
        material: Of the block.
        thickness: Of the block, across the leaf spring, () [m].

    Returns:
        Stiffnesses along local x, y, z [N/m] and about x, y, z [N m/rad], (6,). In the plane a leaf spring takes those
        along x, along z and about y: numbers 0, 2 and 4.

    Raises:
        TypeError: The section is no rectangle, or the material none.
        ModelError: The block is not thicker than the leaf spring.

    Source:
        THEORY.md 2, eq. (2.53).
    """
    if not hasattr(section, "width") or not hasattr(section, "thickness"):
        raise TypeError(f"Argument `section` must be a Rectangle, not {shown(section)}.")
    if not isinstance(material, Material):
        raise TypeError(f"Argument `material` must be a Material, not {shown(material)}.")
    own: Any = section
    check_number("thickness", thickness, above=0, fault=ModelError)
    nu = material.poisson()
    share, per_width = own.thickness / thickness, (1 - nu**2) / (material.E * own.width)
    if not holds(share < 1):
        raise ModelError("A leaf spring has its root in a block that is thicker than itself.")
    along = STRETCHED * spread(share) * per_width
    across = spread(share) / (2 * material.G * own.width)
    bent = HALF_PLANE / np.pi * per_width / own.thickness**2
    twisted = TWISTED / (np.pi * material.G * own.width * own.thickness**2)
    flexible = [along, across, along, twisted, bent, 12 * along / own.width**2]
    return 1 / jnp.stack([jnp.asarray(one, float) for one in flexible])
