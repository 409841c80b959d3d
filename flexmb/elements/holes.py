"""Section of the piece of a leaf spring beside a hole: the rigidities of a beam of equal compliance."""

import dataclasses
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, check_number, holds, short_repr
from ..compilation.record import static
from ..errors import ModelError
from ..numerical_limits import SAME_SIZE
from .profile import Profile
from .section import Material, Rigidity, Scalar, Section

# Additional lengths of the hole over the width of the strip, for the resultants of RESULTANTS (rows). Columns: powers
# 0, 1, 2 of hole/width a, then the same over length/width of the hole, then over its square. Last column: times
# a (nu - 0.3). THEORY.md 2, eq. (2.74).
RESULTANTS = ("N", "T", "My", "Mz", "Vy", "Vz")
ROUND = np.array(
    [
        [0, 1.809, -1.659, 0, -0.63, 0.515, 0, 0, 0, 0],
        [0, 0.186, -1.009, 0, -0.546, -0.226, 0, 0.29, 0.481, -0.215],
        [0, 0.363, -0.878, 0, -0.028, 0.04, 0, 0, 0, 0.096],
        [0, 0.699, -0.653, 0, -0.368, 0.225, 0, 0, 0, 0],
        [0.233, 0.102, -1.22, -0.055, 0.223, 0.006, 0, 0, 0, 0],
        [0, 0.384, -0.908, 0, -0.018, 0.236, 0, 0, 0, 0.065],
    ]
)
SHARP = np.array(
    [
        [0, 2.171, -1.921, 0, -0.319, 0.42, 0, 0, 0, 0],
        [0, 0.636, -0.763, 0, -0.975, -0.275, 0, 0.539, 0.257, -0.315],
        [0, 0.792, -0.751, 0, -0.032, 0.048, 0, 0, 0, 0.124],
        [0, 1.113, -0.825, 0, -0.138, 0.172, 0, 0, 0, 0],
        [0.24, 0.424, -0.739, -0.003, 0.039, -0.037, 0, 0, 0, 0],
        [0, 0.78, -0.73, 0, -0.056, 0.109, 0, 0, 0, 0.083],
    ]
)
# The curvature of the piece by a constant moment is larger in its middle, by this share of a polynomial of order 2.
# Otherwise the compliance to shear would be negative beside round holes.
IN_MIDDLE = 0.375


class Holed(Section):
    """The section at a place of a piece of a leaf spring beside a hole. It has no stress, since stress concentrates.

    Attributes:
        strip: Rectangle of the leaf spring.
        hole: Width of the hole along local y, () [m].
        length: Length of the hole, () [m].
        place: Place along the hole from 0 to 1, () [-].
        rounded: Whether the ends of the hole are half circles; otherwise its corners are sharp.

    Source:
        THEORY.md 2, eq. (2.72) to (2.75).
    """

    strip: Any
    hole: Scalar
    length: Scalar
    place: Scalar
    rounded: bool = static(default=True)

    @property
    def material(self) -> Material:
        """Material of the strip."""
        return self.strip.material

    @property
    def width(self) -> Scalar:
        """Width of the strip."""
        return self.strip.width

    @property
    def thickness(self) -> Scalar:
        """Thickness of the strip."""
        return self.strip.thickness

    def faults(self) -> list[str]:
        """Return the faults of the sizes: a hole wider than the strip, or wider than long."""
        faults = self.strip.faults()
        hole, length = as_known(self.hole), as_known(self.length)
        if not holds(hole < as_known(self.width)):
            faults.append(f"a hole of width {np.max(hole):.4g} in a strip of width {np.min(as_known(self.width)):.4g}")
        if not holds(hole <= length * (1 + SAME_SIZE)):
            faults.append(
                f"a hole of width {np.max(hole):.4g} and length {np.min(length):.4g}, but it must be at least as long"
                " as wide: the ends of the beam are the ends of the hole"
            )
        if not faults:
            rigidity = self.rigidity()
            if not all(holds(as_known(number) > 0) for number in (rigidity.shear_y, rigidity.shear_z)):
                share = np.max(hole / as_known(self.width))
                faults.append(
                    f"a hole {share:.3g} times as wide as the strip, whose fitted compliance to shear is not positive:"
                    " fits hold from 0.1 to 0.7"
                )
        return faults

    def rigidity(self) -> Rigidity:
        """Return the rigidities of (2.72) to (2.75), and the mass of the remaining material."""
        strip = dataclasses.replace(self.strip, shear=True, warping_length=None)
        rail = dataclasses.replace(strip, width=(self.width - self.hole) / 2).rigidity()
        plain, width = strip.rigidity(), self.width
        share, long = self.hole / width, self.length / width
        n, t, my, mz, vy, vz = long + _added(share, share / long, self.material.poisson(), self.rounded)
        # Compliances over the compliance of the plain strip per width.
        missing, missing_sideways = share / (1 - share), share**3 / (1 - share**3)
        stretched, bent, sideways = long + missing * n, long + missing * my, long + missing_sideways * mz
        twisted = long + (plain.GIt / (2 * rail.GIt) - 1) * t
        # Compliances to shear forces, less the displacement by their bending moments.
        along_y = vy**3 / (3 * (1 - share) ** 3) + long * plain.shear_y / width**2 / (1 - share)
        along_y = along_y - long**2 / 12 * sideways
        along_z = (long**3 + missing * vz**3) / 12 + long * plain.shear_z / width**2
        along_z = along_z - (1 - 0.4 * IN_MIDDLE) * long**2 / 12 * bent
        bent_here = bent * (1 - IN_MIDDLE * (1.5 * (2 * self.place - 1) ** 2 - 0.5))
        open_share, open_third = self._opened()
        return Rigidity(
            EA=plain.EA * long / stretched,
            EIy=plain.EIy * long / bent_here,
            EIz=plain.EIz * long / sideways,
            GIt=plain.GIt * long / twisted,
            shear_y=width**2 * along_y / sideways,
            shear_z=width**2 * along_z / bent_here,
            mass=plain.mass * (1 - open_share),
            Jx=plain.Jy * (1 - open_share) + plain.Jz * (1 - open_third),
            Jy=plain.Jy * (1 - open_share),
            Jz=plain.Jz * (1 - open_third),
            alpha=plain.alpha,
        )

    def _opened(self) -> tuple[Scalar, Scalar]:
        """Means along the hole of its width over the width of the strip, and of the cube of this ratio."""
        share, ends = self.hole / self.width, float(self.rounded) * self.hole / self.length
        return share * (1 - ends + np.pi / 4 * ends), share**3 * (1 - ends + 3 * np.pi / 16 * ends)


def _added(share: Any, ratio: Any, nu: Any, rounded: bool) -> Float[Array, "6 *n"]:
    """Additional lengths over the width of the strip, by its width and length over the hole's. Source: eq. (2.74)."""
    share, ratio = (jnp.asarray(number, float) for number in (share, ratio))
    powers = [ratio**k * share**j for k in range(3) for j in range(3)]
    return jnp.tensordot(ROUND if rounded else SHARP, jnp.stack([*powers, share * (nu - 0.3)]), 1)


def with_hole(section: Section, width: Scalar, *, rounded: bool = True) -> Profile:
    """Return the section of the piece of a leaf spring beside a hole in the middle of its width.

    Place a node at both ends of the hole. Use this section for a spectral beam with shear between these nodes, and the
    section of the strip for leaf springs on both sides. The stiffnesses agree with solid elements within 1.5 %.
    The piece has no stress: stress concentrates beside a hole.

    Args:
        section: Rectangle of the strip.
        width: Width of the hole, across the strip, () [m].
        rounded: Whether both ends of the hole are half circles: a round hole is as long as wide. Otherwise the corners
            of the hole are sharp.

    Returns:
        The section of the whole beam. Its length is the length of the hole.

    Raises:
        TypeError: The section is not a rectangle.
        ModelError: The width is not positive, or not smaller than the strip.

    Source:
        THEORY.md 2, eq. (2.72) to (2.75): fits to solid elements.
    """
    # Of all sections, a rectangle alone has this field.
    if not hasattr(section, "warping_length"):
        raise TypeError(f"Argument `section` must be a Rectangle, not {short_repr(section)}.")
    strip: Any = section
    check_number("width", width, above=0, fault=ModelError)
    if not holds(as_known(width) < as_known(strip.width)):
        raise ModelError(f"A hole of width {width:g} needs a wider strip, not one of width {strip.width:g}.")
    return Profile(lambda place, length: Holed(strip, width, length, place, rounded))


def is_holed(section: Any) -> bool:
    """Return whether a section is the section of a piece beside a hole.

    Args:
        section: Section of an element, or None.
    """
    return isinstance(section, Profile) and isinstance(section._kind(), Holed)
