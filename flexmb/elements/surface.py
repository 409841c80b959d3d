"""Stress at points on the surface of a cross-section, from the force and moment in it.

All functions take the resultants (N, Vy, Vz, T, My, Mz) as :class:`flexmb.Element` defines them. They return the
stress along x and the shear stress along the surface, positive counter-clockwise about x. The surface is free, so that
no other shear stress exists there. Elements add the stress of restrained warping and of clamped Poisson contraction
(:mod:`.leaf_stress`). Stress concentrations at notches are not included.
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..math.derivative import root_or_zero
from ..numerical_limits import DIRECTED_STRESS

# Points of a rectangle over half its sides, counter-clockwise from the corner at +y, +z: corners and middles in turn.
RECTANGLE = np.array([[1.0, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]])
POINTS = len(RECTANGLE)
# Middles of the sides at +-y, middles of the sides at +-z, and corners.
AT_Y, AT_Z = (RECTANGLE[:, 1] == 0).astype(float), (RECTANGLE[:, 0] == 0).astype(float)
CORNER = 1 - AT_Y - AT_Z
CATALAN = 0.9159655941772190

Scalar = float | Float[Array, ""]
Stress = tuple[Float[Array, "8"], Float[Array, "8"]]
WithAcross = tuple[Float[Array, "8"], Float[Array, "8"], Float[Array, "8"]]


def squared(sigma_x: Float[Array, "*n"], tau: Float[Array, "*n"], across: Any = 0.0) -> Float[Array, "*n"]:
    """Square of the equivalent stress, with the arguments of :func:`von_mises`, the same shape [Pa^2]."""
    return sigma_x**2 + 3 * tau**2 + across * (across - sigma_x)


def von_mises(sigma_x: Float[Array, "*n"], tau: Float[Array, "*n"], across: Any = 0.0) -> Float[Array, "*n"]:
    """Equivalent stress sqrt(sigma^2 - sigma across + across^2 + 3 tau^2), with derivative zero at zero stress.

    Returns the same shape [Pa]. Source: Von Mises's criterion for plane stress.
    """
    return root_or_zero(squared(sigma_x, tau, across))


def torsion_stress(
    width: Scalar, thickness: Scalar, torsion_constant: Scalar
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Shear stress of a unit torque in the middle of the sides of a rectangle, by Saint-Venant's series.

    With t the shorter side and w the longer: (t/It) (1 - (8/pi^2) sum over odd n of 1/(n^2 cosh(n pi w/2t))) on the
    longer side, which is the largest, and (t/It) (8/pi^2) sum of (-1)^((n-1)/2) tanh(n pi w/2t)/n^2 on the shorter.
    Returns the stress on the sides at the ends of y, and on those at the ends of z, () [1/m^3]; terms left out are
    below 1e-10.

    Source:
        Derivatives of Saint-Venant's stress function of a rectangle, Timoshenko and Goodier, Theory of Elasticity,
        section on rectangular bars; the alternating sum of 1/n^2 is Catalan's constant.
    """
    flat = width >= thickness
    w, t = jnp.where(flat, width, thickness), jnp.where(flat, thickness, width)
    half = jnp.pi * w / (2 * t)
    # 1/cosh decays at least as exp(-n pi/2), 1 - tanh as its square. Both are zero to round-off beyond n half = 300.
    n = np.arange(1.0, 13, 2)
    longer = 1 - 8 / jnp.pi**2 * jnp.sum(1 / (n**2 * jnp.cosh(jnp.minimum(n * half, 300.0))))
    correction = (jnp.tanh(n * half) - 1) @ ((-1) ** (n // 2) / n**2)
    shorter = 8 / jnp.pi**2 * (CATALAN + correction)
    on_longer, on_shorter = longer * t / torsion_constant, shorter * t / torsion_constant
    return jnp.where(flat, on_shorter, on_longer), jnp.where(flat, on_longer, on_shorter)


def rectangle_stress(
    width: Scalar, thickness: Scalar, torsion_constant: Scalar, resultants: Float[Array, "6"]
) -> Stress:
    """Stress at the points of :data:`RECTANGLE` of a solid rectangle.

    Source: N/A + My z/Iy - Mz y/Iz; V Q/(I b); :func:`torsion_stress`.

    Returns:
        Stress along x and shear stress, (8,) [Pa]. Shear forces spread as parabolas, 3/2 V/A in the middle of a side;
        corners carry no shear.
    """
    n, vy, vz, t, my, mz = resultants
    y, z = RECTANGLE.T
    area = width * thickness
    sigma = n / area + 6 * (my / thickness * z - mz / width * y) / area
    on_y, on_z = torsion_stress(width, thickness, torsion_constant)
    parabola = 1.5 / area * (vz * y - vy * z)
    return sigma, (AT_Y * on_y + AT_Z * on_z) * t + (AT_Y + AT_Z) * parabola


def hollow_rectangle(
    width: Scalar,
    thickness: Scalar,
    wall_y: Scalar,
    wall_z: Scalar,
    area: Scalar,
    iy: Scalar,
    iz: Scalar,
    resultants: Float[Array, "6"],
) -> Stress:
    """Stress at the points of :data:`RECTANGLE` of a thin-walled rectangular tube, on its outer surface.

    Returns:
        Stress along x and shear stress, (8,) [Pa]: shear flow (constant in torsion by Bredt, V Q/I for shear forces)
        over the thickness of the wall, at a corner over the thickness of the thinner wall.

    Source:
        N/A + My z/Iy - Mz y/Iz; T/(2 Am) with Am within the middle of the walls; V Q/(2 I), Q beyond the middle of a
        wall, or of half the adjoining wall at a corner.
    """
    n, vy, vz, t, my, mz = resultants
    y, z = RECTANGLE.T
    sigma = n / area + my * z * thickness / (2 * iy) - mz * y * width / (2 * iz)
    between_y, between_z = width - wall_y, thickness - wall_z
    torsion = t / (2 * between_y * between_z)
    inner_y, inner_z = width - 2 * wall_y, thickness - 2 * wall_z
    # First moments of half the section, and of one wall without the overlap at its corners.
    middle_z, middle_y = (
        (width * thickness**2 - inner_y * inner_z**2) / 8,
        (thickness * width**2 - inner_z * inner_y**2) / 8,
    )
    corner_z, corner_y = wall_z * between_y * between_z / 2, wall_y * between_z * between_y / 2
    along_z = vz / (2 * iy) * (CORNER * corner_z + AT_Y * middle_z)
    along_y = vy / (2 * iz) * (CORNER * corner_y + AT_Z * middle_y)
    wall = CORNER * jnp.minimum(wall_y, wall_z) + AT_Y * wall_y + AT_Z * wall_z
    return sigma, (torsion + y * along_z - z * along_y) / wall


def _direction(
    y: Float[Array, ""], z: Float[Array, ""], least: Float[Array, ""]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Unit vector along (y, z), or along y if (y, z) is shorter than ``least``."""
    square = y**2 + z**2
    known = square > least**2
    size = jnp.sqrt(jnp.where(known, square, 1.0))
    return jnp.where(known, y / size, 1.0), jnp.where(known, z / size, 0.0)


def ring(diameter: Scalar, inner: Scalar, resultants: Float[Array, "6"]) -> Stress:
    """Stress on the circumference of a circle or a circular tube.

    Eight points: the two where combined bending is largest and the two a quarter turn from them, then the two along the
    combined shear force and the two a quarter turn from them, where its stress is largest. Returns the stress along x
    and shear stress, (8,) [Pa].

    Source:
        N/A + (My z - Mz y)/I; T R/(2 I); V Q/(I b) at the height of the point, along the circumference:
        4 V (R^2 + R r + r^2)/(3 A (R^2 + r^2)) times the sine of the angle from V.
    """
    n, vy, vz, t, my, mz = resultants
    outer, hole = diameter / 2, inner / 2
    area, i = jnp.pi * (outer**2 - hole**2), jnp.pi / 4 * (outer**4 - hole**4)
    shear = 4 / (3 * area) * (outer**2 + outer * hole + hole**2) / (outer**2 + hole**2)
    # A moment or force at round-off of the others has no direction, and the direction no derivative.
    all_of_it = jnp.sum(jnp.abs(jax.lax.stop_gradient(resultants)) * jnp.where(np.arange(6) < 3, outer, 1.0))
    bent = _direction(-mz, my, DIRECTED_STRESS * all_of_it)
    sheared = _direction(vy, vz, DIRECTED_STRESS * all_of_it / outer)
    first = jnp.stack([jnp.stack(bent), jnp.stack(sheared)])
    quarter = jnp.stack([-first[:, 1], first[:, 0]], axis=1)
    y, z = jnp.stack([first, quarter, -first, -quarter], axis=1).reshape(POINTS, 2).T
    return n / area + outer / i * (my * z - mz * y), t * outer / (2 * i) + shear * (vz * y - vy * z)
