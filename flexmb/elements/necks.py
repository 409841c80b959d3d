"""Section of a circular notch hinge, fitted to solid elements: effects in a neck that beam theory neglects."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..compilation.compile import jit
from ..errors import BeamTheoryWarning, warn
from ..math.quadrature import gauss
from .profile import NODES, Profile
from .section import Material, Rigidity, Scalar, Section
from .surface import Stress

# Slanted faces increase the compliance in tension by TENSION q and in shear by SHEAR q. Here q = s/(1 + STEEP s), and s
# is the squared slope of the thickness. THEORY.md 2, eq. (2.60).
TENSION, SHEAR, STEEP = 0.18, 0.21, 0.60
# Width of the zones along the free edges without plate behaviour in stretching and bending, over sqrt(radius neck).
STRETCHED, BENT = 2.8, 1.55
# The warping rigidity of a thick place is divided by 1 + OF_THICK (thickness/width)^2.
OF_THICK = 1.0
# Largest neck over radius, and least width over sqrt(radius neck), of the range compared with solid elements.
DEEPEST, NARROWEST = 0.25, 2.0


class Neck(Section):
    """A rectangle at a place of a notch hinge.

    Attributes:
        rectangle: Rectangle with shear.
        slope: Slope of the thickness along the hinge, () [-].
        twist: Torsional rigidity over Saint-Venant's torsional rigidity, constant along the hinge, () [-].
        stretched: Factor on the compliance in stretching, at most 1, since the neck is a plate, () [-].
        bent: Factor on the compliance in bending, at most 1, since the neck is a plate, () [-].
        even: Shear coefficient k for displacement along y, () [-].

    Source:
        THEORY.md 2, eq. (2.60) and (2.61).
    """

    rectangle: Any
    slope: Scalar
    twist: Scalar
    stretched: Scalar
    bent: Scalar
    even: Scalar

    @property
    def material(self) -> Material:
        """Material of the rectangle."""
        return self.rectangle.material

    def faults(self) -> list[str]:
        """Return the faults of the rectangle."""
        return self.rectangle.faults()

    def stress(self, resultants: Float[Array, "6"]) -> Stress:
        """Return the stress of the rectangle.

        Args:
            resultants: Forces and moments in the section, (6,) [N, N m].
        """
        return self.rectangle.stress(resultants)

    def rigidity(self) -> Rigidity:
        """Return the rigidities of (2.60), with the torsional rigidity of (2.61)."""
        rigidity, square = self.rectangle.rigidity(), self.slope**2
        spread = square / (1 + STEEP * square)
        stretched = (1 + TENSION * spread) * self.stretched
        area = self.rectangle.width * self.rectangle.thickness
        sideways = self.even * self.material.shear_modulus() * area / (1 + SHEAR * spread)
        return dataclasses.replace(
            rigidity,
            EA=rigidity.EA / stretched,
            EIz=rigidity.EIz / stretched,
            EIy=rigidity.EIy / self.bent,
            GIt=rigidity.GIt * self.twist,
            shear_y=rigidity.EIz / stretched / sideways,
            shear_z=rigidity.shear_z / self.bent,
        )


def notch_length(height: Scalar, neck: Scalar, radius: Scalar) -> Scalar:
    """Return the length of a circular notch from rim to rim."""
    depth = (height - neck) / 2
    return 2 * (depth * (2 * radius - depth)) ** 0.5


def neck(plain: Profile, width: Scalar, thin: Scalar, radius: Scalar, extent: Scalar, material: Material) -> Profile:
    """Return the section of a circular notch hinge from rim to rim.

    Args:
        plain: Rectangles with shear along the hinge.
        width: Side along local y, () [m].
        thin: Height of the remaining neck, () [m].
        radius: Radius of the notch, () [m].
        extent: Distance between the rims, () [m].
        material: Material.
    """
    _warn_of_stocky(thin / radius, width / (radius * thin) ** 0.5)
    numbers = _everywhere(plain, width, (radius * thin) ** 0.5, material, extent)

    def section(place: Float[Array, ""], length: Float[Array, ""]):
        def thickness(place: Float[Array, ""]):
            rectangle: Any = plain.at(place, length)
            return jnp.asarray(rectangle.thickness, float), rectangle

        _, slope, rectangle = jax.jvp(thickness, (place,), (jnp.ones_like(place),), has_aux=True)
        return Neck(rectangle, slope / length, *numbers)

    return Profile(section, plain.breaks)


@jit
def _everywhere(plain: Profile, width: Scalar, long: Scalar, material: Material, extent: Scalar):
    """Factors of :class:`Neck` that are constant along a hinge: twist, stretched, bent, even."""
    nu = material.poisson()
    plates = [1 - nu**2 * jnp.maximum(1 - 2 * edge * long / width, 0.0) for edge in (STRETCHED, BENT)]
    cowper = 10 * (1 + nu) / (12 + 11 * nu)
    even = 1 - (1 - cowper) * jnp.exp(-0.2 * width / (jnp.pi * long))
    nodes, weights = gauss(NODES)
    places = jnp.concatenate([nodes / 2, (1 + nodes) / 2])

    def numbers(place: Float[Array, ""]):
        rectangle: Any = plain.at(place, jnp.asarray(extent, float))
        rigidity = rectangle.rigidity()
        return rigidity.GIt, rigidity.EIy / rigidity.shear_z, rectangle.thickness

    turned, sheared, thickness = jax.vmap(numbers)(places)
    weights = jnp.concatenate([weights, weights]) / 2 * extent
    warped = material.E * (width * thickness) ** 3 / 144 / (1 + OF_THICK * (thickness / width) ** 2)
    away = (places - 0.5) * extent
    free, restrained = weights @ (1 / turned), weights @ (away**2 / warped + 12 / (width**2 * sheared))
    return 1 + free / restrained, *plates, even


def _warn_of_stocky(deep: Any, wide: Any) -> None:
    if is_concrete((deep, wide)) and (deep > DEEPEST or wide < NARROWEST):
        warn(
            f"A notch hinge whose neck is {deep:.2g} of its radius, and {wide:.2g} times as wide as sqrt(radius neck),"
            f" was not compared with solid elements: comparisons go up to {DEEPEST} and from {NARROWEST:g} on.",
            BeamTheoryWarning,
        )
