"""Stress of a leaf spring with restrained warping, clamps, and flattening at large curvature.

z = 1 is the side at positive local z. y = 1 is the edge at positive local y. Distances from clamps are in widths.
"""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerical_limits import STRIP_SERIES
from . import surface
from .bent_strip import curving, relaxing_and_distorting
from .leaf import REACHES, TINY, Leaf, share_of_change
from .section import Scalar
from .surface import AT_Y, AT_Z, CORNER, RECTANGLE

# Distance over which a clamp keeps the middle of the width flat, over the average distance, by solid elements.
MIDDLE = 1.4
# Bending at a clamp relative to the average of the width, over Poisson's ratio: MORE in the middle, LESS at the edges,
# over the distance NEAR in widths. Both are halved if u^4 is HALVED.
MORE, NEAR, LESS, HALVED = 0.65, 0.15, 0.55, 500.0
# The stress of lifted fibres fades towards a clamp by the factor 1 - LACKS exp(-x - BENDS x^2). Here x is
# (SLOWEST + FASTER u^4)^(1/4) times the distance in widths. THEORY.md 2, eq. (2.59).
LACKS, BENDS, SLOWEST, FASTER = 0.77, 0.5, 0.1, 0.03


def leaf_stress(
    leaf: Leaf,
    place: Float[Array, ""],
    length: Any,
    resultants: Float[Array, "6"],
    twist: tuple[Float[Array, ""], Float[Array, ""]] | None = None,
) -> surface.WithAcross:
    """Return the stress at the points of :data:`flexmb.elements.surface.RECTANGLE` of a leaf spring.

    Returns the stress along x, shear stress, and stress across along the surface, each (8,) [Pa]. Source: THEORY.md 2,
    eq. (2.27) to (2.29), (2.56), (2.59) and (2.69).

    Args:
        twist: Rate of twist and its slope along the leaf spring, () [1/m] and () [1/m^2]; None in the plane.
    """
    rectangle = leaf.rectangle(place, length)
    wide, thick, numbers = rectangle.width, rectangle.thickness, rectangle.rigidity()
    youngs, nu = rectangle.material.E, rectangle.material.poisson()
    force, _, _, torque, moment, _ = resultants
    twisted, curved = (jnp.reshape(value, (-1,))[0] for value in leaf.initial_at(jnp.asarray(place, float)[None]))
    rate, slope = (0.0, None) if twist is None else twist
    longer = rate * (2 * twisted + rate)
    bent, stiffer, fourth = _flattened(moment / numbers.EIy, curved, longer, wide, thick, nu)
    keeps, lifted, lowered = _across(fourth)
    # Distances from the clamps of both ends, in widths.
    away = (jnp.stack([jnp.asarray(place), 1 - jnp.asarray(place)]) * length + leaf.beyond) / wide
    flat_stretched, flat_bent = (_flat_share(away, leaf.clamped, reach) for reach in REACHES[:2, 0])
    free = 1 - flat_bent
    warped = shear = jnp.zeros(())
    if slope is not None:
        relaxed, distorting = relaxing_and_distorting(fourth)
        of_edges = wide**2 * (force / 12 + numbers.EA * wide**2 * longer * relaxed / 360)
        of_edges = of_edges + nu * numbers.EIy / (1 - nu**2) * fourth * relaxed / 90 * share_of_change(bent, curved)
        # Shear by restrained warping carries the rest of the torque.
        shear = 9 * (torque - numbers.GIt * rate - (twisted + rate) * of_edges) / (wide**2 * thick)
        warped = -youngs * slope * wide * thick / 4
        # Twist carries a part of the moment.
        moment = moment + free * (numbers.EIy * bent * stiffer - moment)
        # In sideways bending the section distorts, and the edges carry more stress.
        softer = leaf.distorted(jnp.asarray(place, float)[None], length)[0] * (distorting - 1)
        resultants = jnp.stack([*resultants[:3], numbers.GIt * rate, moment, resultants[5] / (1 + softer)])
    sigma, tau = rectangle.stress(resultants)
    stretched, at_surface = force / (wide * thick), 6 * moment / (wide * thick**2)
    clamp_effect = nu * jnp.exp(-((away / NEAR) ** 2)) @ leaf.clamped / (1 + fourth / HALVED)
    fibres = youngs * nu * bent * (curved + bent) * wide**2 / 12 * _faded(away, leaf.clamped, fourth)
    # Where a clamp keeps the section flat, lift does not relieve the stress of twist.
    twisting = youngs * longer * wide**2 / 12
    lift, drop = (fibres * height + twisting * (1 + free * (height - 1)) for height in (lifted, lowered))
    over_curvature = (curved + bent) / ((curved + bent) ** 2 + TINY)
    rolled = youngs * thick / 2 / (1 - nu**2) * longer * over_curvature * free * (1 - keeps)
    at_edges = 1 + free * (1 / stiffer - 1) - LESS * clamp_effect
    in_middle = 1 + free * ((1 - nu**2 * keeps) / ((1 - nu**2) * stiffer) - 1) + MORE * clamp_effect
    y, z = RECTANGLE.T
    sigma = sigma + at_surface * z * (CORNER * (at_edges - 1) + AT_Z * (in_middle - 1))
    sigma = sigma + lift * y**2 - drop / 2 * AT_Z + nu * rolled * z * AT_Z
    curved = free * keeps
    across = at_surface * z * in_middle * (1 - curved) / (1 - nu**2 * curved)
    across = nu * AT_Z * (across + (stretched - drop / 2) * flat_stretched) + rolled * z * AT_Z
    return sigma + warped * y * z, tau + AT_Y * shear, across


def twist_at(
    leaf: Leaf, place: Float[Array, ""], length: Any, order: int, c: Float[Array, "c"]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Return the rate of twist at a place, and its slope along the leaf spring.

    Returns () [1/m] and () [1/m^2]. Source: THEORY.md 2, eq. (2.24).
    """
    place = jnp.asarray(place, float)[None]
    rate, slope = jax.jvp(lambda at: leaf.twist(order, at, length) @ c, (place,), (jnp.ones_like(place),))
    return rate[0] / length, slope[0] / length**2


def _flat_share(away: Float[Array, "2"], clamped: Any, reach: float) -> Float[Array, ""]:
    """Share from 0 to 1 by which clamps keep the middle of the width flat, at distances from both ends."""
    # The integral of the share along the strip is MIDDLE times the distance of (2.22).
    fallen = 2 * away / (MIDDLE * reach)
    return 1 - jnp.prod(1 - clamped * (1 + fallen) * jnp.exp(-fallen))


def _faded(away: Float[Array, "2"], clamped: Any, fourth: Float[Array, ""]) -> Float[Array, ""]:
    """Share from 0 to 1 of the stress of lifted fibres, at distances from both ends."""
    x = jnp.sqrt(jnp.sqrt(SLOWEST + FASTER * fourth)) * away
    first, last = clamped * LACKS * jnp.exp(-x - BENDS * x**2)
    return (1 - first) * (1 - last)


def _flattened(
    change: Float[Array, ""], initial: Any, longer: Any, wide: Scalar, thick: Scalar, nu: Scalar
) -> tuple[Float[Array, ""], ...]:
    """Curvature, relative stiffness and u^4 of a strip bent by M = EIy times ``change``, far from clamps.

    Args:
        longer: Square of the twist rate, minus its initial square [1/m^2].
    """
    scale = 3 * (1 - nu**2) * (wide**2 / thick) ** 2

    def stiffer(curvature: Float[Array, ""]):
        whole = initial + curvature
        value, slope = jax.jvp(curving, (scale * whole**2,), (jnp.ones(()),))
        return (1 - nu**2 * (value + scale * curvature * whole * slope)) / (1 - nu**2)

    def of_twist(curvature: Float[Array, ""]):
        """Energy of twist per length over EIy, eq. (2.65)."""
        whole = initial + curvature
        relieved = longer * (nu * curvature * whole + longer / 2) * scale / 180
        return relieved * relaxing_and_distorting(scale * whole**2)[0] / (1 - nu**2)

    def moment(curvature: Float[Array, ""]):
        return curvature * stiffer(curvature) + jax.grad(of_twist)(curvature)

    # Without twist the stiffness varies by nu^2 at most, so that two steps of Newton's method suffice.
    curvature = change / stiffer(change)
    for _ in range(2):
        value, slope = jax.value_and_grad(moment)(curvature)
        curvature = curvature - (value - change) / slope
    return curvature, stiffer(curvature), scale * (initial + curvature) ** 2


def _across(fourth: Float[Array, ""]) -> tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""]]:
    """Curvature in the middle, lift of the edges and drop of the middle of a flattened strip, by u^4."""
    small = fourth < STRIP_SERIES
    v, u = jnp.where(small, fourth, 0.0), jnp.sqrt(jnp.sqrt(jnp.where(small, 1.0, fourth)))
    below = 1 + v / 120 + v**2 / 362880
    series = 1 - v / 480 + v**2 / 5806080, 1 + v / 840 + v**2 / 6652800, 1 - v / 3360 + v**2 / 106444800
    # Terms over exp(u)/2 do not overflow.
    half, cosine, sine = jnp.exp(-u / 2), jnp.cos(u / 2), jnp.sin(u / 2)
    down, up = half * (1 - half**2), half * (1 + half**2)
    scale, twice = 1 - half**4, 2 * half**2 * jnp.sin(u)
    large = (2 * (up * sine + down * cosine), 6 / u**2 * (scale - twice), 24 / u**2 * (up * sine - down * cosine))
    parts = [
        jnp.where(small, by_series / below, far / (scale + twice)) for by_series, far in zip(series, large, strict=True)
    ]
    return parts[0], parts[1], parts[2]
