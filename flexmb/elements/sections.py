"""Cross-sections: rigidities, mass and stress from dimensions; axes as in :mod:`.section`."""

import dataclasses
from typing import Literal

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, check_number, holds, is_concrete, library_of, nan_if_refused, short_repr
from ..compilation.record import static
from ..errors import ModelError
from ..lazy import only
from . import necks, surface
from .curves import curvature_along as curvature_along
from .curves import curvature_through as curvature_through
from .general import General as General
from .holes import with_hole as with_hole
from .profile import Profile as Profile
from .profile import stepped as stepped
from .profile import taper as taper
from .roots import root_stiffness as root_stiffness
from .section import Damping as Damping
from .section import Material as Material
from .section import MaterialDamping as MaterialDamping
from .section import Rigidity as Rigidity
from .section import Scalar
from .section import Section as Section


def damping_from_ratio(section: Section, length: Scalar, ratio: Scalar, *, frequency: Scalar | None = None) -> Damping:
    """Return the damping rigidities of a leaf spring for a damping ratio at one frequency.

    With ``frequency``, vibrations of this frequency have the ratio: damping is stiffness times ratio/(pi frequency).
    Without ``frequency``, each stiffness k = rigidity/L or rigidity/L^3 has the damping d = 2 ratio sqrt(k m) with the
    whole mass m of the spring, as in the tutorial. The damping rigidity is d L or d L^3. In bending, the ratio then
    belongs to the frequency sqrt(EI/(m L^3))/(2 pi).

    A mode of the mechanism has the damping ratio ``ratio`` times its frequency over this frequency. Example: for a
    ratio of 0.01, a guide of 10.8 Hz on leaf springs of 11.9 Hz has the damping ratio 0.0091. :func:`flexmb.damped`
    damps all modes by chosen ratios.

    For a leaf spring of several beams, give the length of the whole leaf spring. A ``leaf_spring`` is stiffer near its
    clamps than its section, and these additional stiffnesses have no damping. The ratio of its modes is therefore
    smaller. ``Material(damping=ratio/(pi * frequency))`` damps the additional stiffnesses too.

    Args:
        section: Cross-section with mass.
        length: Length of the spring, () [m].
        ratio: Damping ratio, () [-].
        frequency: Frequency at which vibrations have this ratio, () [Hz]; by default the frequencies of k and m.

    Returns:
        Damping rigidities.

    Raises:
        TypeError: The section or a number has the wrong type.
        ModelError: The length or the frequency is not positive, or the ratio is negative.

    Source:
        Tutorial WA 1239 (2012), eq. (2.14) and the numbers after (3.9) and (4.14); with a frequency THEORY.md 2,
        eq. (2.41).
    """
    if not isinstance(section, Section):
        raise TypeError(f"Argument `section` must be a Section, such as Rectangle(..), not {short_repr(section)}.")
    with nan_if_refused() as marked:
        check_number("length", length, above=0, fault=ModelError)
        check_number("ratio", ratio, least=0, fault=ModelError)
        if frequency is not None:
            check_number("frequency", frequency, above=0, fault=ModelError)
        length, ratio, frequency = marked((length, ratio, frequency))
    s = section.rigidity()
    if frequency is not None:
        return MaterialDamping(ratio / (np.pi * frequency)).rigidities(section)
    mass = s.mass * length
    xp = library_of((s.EA, s.EIy, s.EIz, s.GIt, mass, ratio))

    def equivalent(rigidity: Scalar, power: int):
        stiffness = rigidity / length**power
        # A zero rigidity has no damping. The root has no derivative at zero.
        positive = xp.asarray(stiffness * mass) > 0
        product = xp.where(positive, stiffness * mass, 1.0)
        return xp.where(positive, 2 * ratio * xp.sqrt(product), 0.0) * length**power

    powers = {"EA": 1, "EIy": 3, "EIz": 3, "GIt": 3}
    shears = (equivalent(shear, 1) for shear in s.shear_rigidities())
    return Damping(*(equivalent(getattr(s, name), power) for name, power in powers.items()), *shears)


def torsion_series(width: Scalar, thickness: Scalar) -> Scalar:
    """Return the Saint-Venant torsion constant of a rectangle, by its series.

    It = w t^3 (1/3 - (64/pi^5) (t/w) sum over odd n of tanh(n pi w / 2t) / n^5) with t the shorter side.

    Args:
        width: First side, () [m].
        thickness: Second side, () [m].

    Returns:
        Torsion constant, () [m^4], with a relative error below 1e-9.

    Raises:
        ModelError: A side is not positive.

    Source:
        Saint-Venant's solution, e.g. Timoshenko and Goodier, Theory of Elasticity, section on rectangular bars.
    """
    return _by_series(*_sides(width, thickness))


def _sides(width: Scalar, thickness: Scalar) -> tuple[Scalar, Scalar]:
    """Two positive sides; traced sides that are not positive become NaN."""
    with nan_if_refused() as marked:
        check_number("width", width, above=0, fault=ModelError)
        check_number("thickness", thickness, above=0, fault=ModelError)
        return marked((width, thickness))


def _by_series(width: float | Float[Array, "*n"], thickness: float | Float[Array, "*n"]) -> float | Float[Array, "*n"]:
    """Torsion constant of positive sides, for one section or many sections."""
    xp = library_of((width, thickness))
    w, t = xp.maximum(width, thickness), xp.minimum(width, thickness)
    # From n = 5 on, tanh(n pi w/2t) is 1 to 3e-7 for w >= t, so the tail follows from the zeta function:
    # sum over odd n of 1/n^5 = (31/32) zeta(5).
    odd = (1.0, 3.0)
    total = (31 / 32) * 1.0369277551433699 + sum((xp.tanh(n * np.pi * w / (2 * t)) - 1) / n**5 for n in odd)
    return w * t**3 * (1 / 3 - 64 / np.pi**5 * (t / w) * total)


def torsion_approximate(width: Scalar, thickness: Scalar) -> Scalar:
    """Return the torsion constant of a thin rectangle by the formula of the tutorial, for comparison.

    Args:
        width: First side, () [m].
        thickness: Second side, () [m].

    Returns:
        w t^3 (1/3 - 0.21 (t/w) (1 - (t/w)^4/12)) with t the shorter side, () [m^4].

    Raises:
        ModelError: A side is not positive.

    Source:
        Tutorial WA 1239 (2012), eq. (4.9).
    """
    return _by_formula(*_sides(width, thickness))


def _by_formula(width: Scalar, thickness: Scalar) -> Scalar:
    """Result of :func:`torsion_approximate` for positive sides, of one section or many sections."""
    xp = library_of((width, thickness))
    w, t = xp.maximum(width, thickness), xp.minimum(width, thickness)
    return w * t**3 * (1 / 3 - 0.21 * (t / w) * (1 - (t / w) ** 4 / 12))


def warping_factor(
    length: Scalar, width: Scalar, nu: Scalar, clamped_ends: int = 2, modulus: Literal["plate", "beam"] = "plate"
) -> Scalar:
    """Return the factor by which restrained warping at clamped ends stiffens a thin strip in torsion.

    1/(1 - tanh(al)/(al)) for one clamped end, 1/(1 - 2 tanh(al/2)/(al)) for two. The strip resists warping with the
    modulus of a plate, alpha^2 = 24 (1 - nu)/w^2, or with the modulus of a beam, alpha^2 = 24/((1 + nu) w^2).

    Args:
        length: Length of the whole leaf spring, () [m].
        width: Width of the leaf spring, () [m].
        nu: Poisson's ratio, () [-].
        clamped_ends: 0, 1 or 2.
        modulus: "plate", E/(1 - nu^2), or "beam", E.

    Returns:
        Factor on G It, () [-]; 1 for no clamped end.

    Raises:
        ModelError: The length is not positive; Poisson's ratio, the modulus or the number of ends is invalid.

    Source:
        Tutorial WA 1239 (2012), eq. (4.11); Vlasov's narrow strip, alpha^2 = G It/(E Cw) with It = w t^3/3 and
        Cw = w^3 t^3/144. Eq. (4.14) of the tutorial is the limit for a long strip.
    """
    if clamped_ends not in (0, 1, 2):
        raise ModelError(f"clamped_ends must be 0, 1 or 2, but is {clamped_ends!r}.")
    if modulus not in ("plate", "beam"):
        raise ModelError(f"modulus must be 'plate' or 'beam', but is {modulus!r}.")
    with nan_if_refused() as marked:
        check_number("length", length, above=0, fault=ModelError)
        check_number("width", width, above=0, fault=ModelError)
        check_number("nu", nu, above=-1, most=1, fault=ModelError)
        length, width, nu = marked((length, width, nu))
    return _by_warping(length, width, nu, clamped_ends, modulus)


def _by_warping(length: Scalar, width: Scalar, nu: Scalar, clamped_ends: int, modulus: str) -> Scalar:
    """Result of :func:`warping_factor` for valid sizes, of one leaf spring or many leaf springs."""
    if clamped_ends == 0:
        return 1.0
    al = length * jnp.sqrt(24 * (1 - nu) if modulus == "plate" else 24 / (1 + nu)) / width
    return 1 / (1 - clamped_ends * jnp.tanh(al / clamped_ends) / al)


class Rectangle(Section):
    """Rectangular section, as of a leaf spring.

    Attributes:
        width: Side along local y [m].
        thickness: Side along local z [m]; bending about the soft axis displaces along z and has rigidity EIy.
        material: Material.
        shear: Whether shear deformation is counted, with k = 10 (1 + nu)/(12 + 11 nu) (Cowper 1966).
        rotary: Whether the rotary inertia of the section is counted.
        torsion: Torsion constant: "series", or "approximate" by tutorial WA 1239 (2012), eq. (4.9), see
            :func:`torsion_approximate`.
        warping_length: Length of the whole leaf spring [m] for restrained warping at clamped ends, otherwise None.
        clamped_ends: Number of ends at which warping is restrained.
        warping_modulus: "plate" or "beam", see :func:`warping_factor`; it also applies to the warping rigidity EIw.
    """

    width: Scalar
    thickness: Scalar
    material: Material
    shear: bool = static(default=False)
    rotary: bool = static(default=True)
    torsion: Literal["series", "approximate"] = static(default="series")
    warping_length: Scalar | None = None
    clamped_ends: int = static(default=2)
    warping_modulus: Literal["plate", "beam"] = static(default="plate")

    def faults(self) -> list[str]:
        """Return the faults of the numbers, such as more than two clamped ends, or one of no warping length."""
        faults = super().faults()
        if self.clamped_ends not in (0, 1, 2):
            faults.append(f"clamped_ends = {self.clamped_ends}, but it must be 0, 1 or 2")
        elif self.clamped_ends == 1 and self.warping_length is None:
            faults.append(
                "clamped_ends = 1 without warping_length, the length of the whole leaf spring, and so without effect:"
                " give it, or use a leaf_spring, which finds its clamps"
            )
        return faults

    def rigidity(self) -> Rigidity:
        """Return the rigidities of the rectangle, with the warping constant (w t)^3/144 of a narrow strip."""
        w, t, material = self.width, self.thickness, self.material
        it = (_by_series if self.torsion == "series" else _by_formula)(w, t)
        nu = material.poisson()
        if self.warping_length is not None:
            it = it * _by_warping(self.warping_length, w, nu, self.clamped_ends, self.warping_modulus)
        k = 10 * (1 + nu) / (12 + 11 * nu)
        rigidity = _from_geometry(self, w * t, w * t**3 / 12, t * w**3 / 12, it, k)
        modulus = material.E / (1 - nu**2) if self.warping_modulus == "plate" else material.E
        constant = (w * t) ** 3 / 144
        rho = material.rho if self.rotary else 0.0
        return dataclasses.replace(rigidity, EIw=modulus * constant, Jw=rho * constant)

    def stress(self, resultants: Float[Array, "6"]) -> surface.Stress:
        """Return the stress at corners and middles of the sides, from the corner at +y, +z counter-clockwise about x.

        The torsion stress is Saint-Venant's, also with restrained warping. The stress due to restrained warping, and
        its share of the torque, are neglected. A ``leaf_spring`` includes both, see :mod:`flexmb.elements.leaf_stress`.

        Args:
            resultants: (6,) [N, N m].
        """
        it = _by_series(self.width, self.thickness)
        return surface.rectangle_stress(self.width, self.thickness, it, resultants)


class HollowRectangle(Section):
    """Thin-walled rectangular tube.

    Attributes:
        width: Outer side along local y [m].
        thickness: Outer side along local z [m].
        wall_y: Thickness of the two walls at the ends of the width [m].
        wall_z: Thickness of the two walls at the ends of the thickness [m].
        material: Material.
        rotary: Whether the rotary inertia of the section is counted.
    """

    width: Scalar
    thickness: Scalar
    wall_y: Scalar
    wall_z: Scalar
    material: Material
    rotary: bool = static(default=True)

    shear = False

    def faults(self) -> list[str]:
        """Return the faults of the numbers, such as walls that leave no hole."""
        sides = {"wall_y": self.width, "wall_z": self.thickness}
        thick = [n for n, side in sides.items() if not holds(2 * as_known(getattr(self, n)) < as_known(side))]
        return super().faults() + [f"{n} = {getattr(self, n)}, which leaves no hole between two walls" for n in thick]

    def rigidity(self) -> Rigidity:
        """Return the rigidities; torsion by Bredt: It = 4 A_m^2 / closed integral of ds/wall."""
        wm, tm = self.width - self.wall_y, self.thickness - self.wall_z
        it = 4 * (wm * tm) ** 2 / (2 * wm / self.wall_z + 2 * tm / self.wall_y)
        area, iy, iz = self._areas()
        return _from_geometry(self, area, iy, iz, it, 1.0)

    def _areas(self):
        """Area, and second moments of area about y and z."""
        w, t = self.width, self.thickness
        wi, ti = w - 2 * self.wall_y, t - 2 * self.wall_z
        return w * t - wi * ti, (w * t**3 - wi * ti**3) / 12, (t * w**3 - ti * wi**3) / 12

    def stress(self, resultants: Float[Array, "6"]) -> surface.Stress:
        """Return the stress at corners and middles of the outer sides, from +y, +z on counter-clockwise about x.

        Args:
            resultants: (6,) [N, N m].
        """
        sizes = (self.width, self.thickness, self.wall_y, self.wall_z)
        return surface.hollow_rectangle(*sizes, *self._areas(), resultants)


class Circle(Section):
    """Solid circular section, as of a wire flexure.

    Attributes:
        diameter: Diameter [m].
        material: Material.
        shear: Whether shear deformation is counted, with k = 6 (1 + nu)/(7 + 6 nu) (Cowper 1966).
        rotary: Whether the rotary inertia of the section is counted.
    """

    diameter: Scalar
    material: Material
    shear: bool = static(default=False)
    rotary: bool = static(default=True)

    def rigidity(self) -> Rigidity:
        """Return the rigidities of the circle."""
        d, nu = self.diameter, self.material.poisson()
        i = jnp.pi * d**4 / 64
        return _from_geometry(self, jnp.pi * d**2 / 4, i, i, 2 * i, 6 * (1 + nu) / (7 + 6 * nu))

    def stress(self, resultants: Float[Array, "6"]) -> surface.Stress:
        """Return the stress on the circumference, at the extremes of combined bending and of the combined shear force.

        Args:
            resultants: (6,) [N, N m].
        """
        return surface.ring(self.diameter, 0.0, resultants)


class Tube(Section):
    """Circular tube.

    Attributes:
        diameter: Outer diameter [m].
        wall: Wall thickness [m].
        material: Material.
        rotary: Whether the rotary inertia of the section is counted.
    """

    diameter: Scalar
    wall: Scalar
    material: Material
    rotary: bool = static(default=True)

    shear = False

    def faults(self) -> list[str]:
        """Return the faults of the numbers, such as a wall that leaves no hole."""
        thin = holds(2 * as_known(self.wall) < as_known(self.diameter))
        return super().faults() + ([] if thin else [f"wall = {self.wall}, which leaves no hole in the tube"])

    def rigidity(self) -> Rigidity:
        """Return the rigidities of the tube."""
        d, inner = self.diameter, self.diameter - 2 * self.wall
        i = jnp.pi * (d**4 - inner**4) / 64
        return _from_geometry(self, jnp.pi * (d**2 - inner**2) / 4, i, i, 2 * i, 1.0)

    def stress(self, resultants: Float[Array, "6"]) -> surface.Stress:
        """Return the stress on the outer circumference, at the extremes of bending and of the combined shear force.

        Args:
            resultants: (6,) [N, N m].
        """
        return surface.ring(self.diameter, self.diameter - 2 * self.wall, resultants)


def _from_geometry(
    section: Rectangle | HollowRectangle | Circle | Tube, area: Scalar, iy: Scalar, iz: Scalar, it: Scalar, k: Scalar
) -> Rigidity:
    material = section.material
    shear_modulus = material.shear_modulus()
    ei_y, ei_z, gak = material.E * iy, material.E * iz, shear_modulus * area * k
    rho = material.rho if section.rotary else 0.0
    return Rigidity(
        EA=material.E * area,
        EIy=ei_y,
        EIz=ei_z,
        GIt=shear_modulus * it,
        shear_z=ei_y / gak if section.shear else 0.0,
        shear_y=ei_z / gak if section.shear else 0.0,
        mass=material.rho * area,
        Jx=rho * (iy + iz),
        Jy=rho * iy,
        Jz=rho * iz,
        alpha=material.alpha,
    )


def notch_circular(
    width: Scalar, height: Scalar, neck: Scalar, radius: Scalar, material: Material, shear: bool = False
) -> Profile:
    """Return the section of a bar with a circular notch on both sides, the hinge of Paros and Weisbord.

    In beam theory the neck warps freely. A short neck between thick parts does not: a solid model (neck 0.3 mm, width
    10 mm, radius 5 mm) is eleven times as stiff in torsion. The other stiffnesses of a spectral beam with shear are
    within 6 %. :func:`hinge_circular` includes the restrained warping. Instead, 34 ``spatial.warping_beam`` in a row
    can model the notch, with shorter beams near the neck and the mean of 1/t^3 in each beam. This row is 17 % too stiff
    in torsion. Its other stiffnesses are within 6 %.

    Args:
        width: Side of the bar along local y, () [m].
        height: Side of the bar along local z, away from the notch, () [m].
        neck: Height left in the middle, () [m].
        radius: Radius of the notch, () [m]; at least half of height - neck.
        material: Material.
        shear: Whether shear deformation is counted, as of :class:`Rectangle`.

    Returns:
        The section of the whole beam. Its length is at least the length of the notch, 2 sqrt(d (2 radius - d)) with d =
        (height - neck)/2.

    Raises:
        ModelError: A size is not positive, or the neck is higher than the bar.

    Source:
        Paros and Weisbord (1965), Machine Design 37, 151: the shape.
    """
    _depth(width, height, neck, radius=radius)
    return notch_elliptic(width, height, neck, radius, radius, material, shear)


def hinge_circular(width: Scalar, height: Scalar, neck: Scalar, radius: Scalar, material: Material) -> Profile:
    """Return the section of a circular notch hinge from rim to rim, fitted to solid elements.

    Use it with a spectral beam of order 3 with shear, from rim to rim between rigid parts. Its stiffnesses are within
    5 % of solid elements if neck/radius is at most 0.2 and the width at least twice sqrt(radius neck).

    Args:
        width: Side of the bar along local y, () [m].
        height: Side of the bar along local z, away from the notch, () [m].
        neck: Height left in the middle, () [m].
        radius: Radius of the notch, () [m]; at least half of height - neck.
        material: Material.

    Returns:
        The section of the whole beam, whose length is the length of the notch, 2 sqrt(d (2 radius - d)) with d =
        (height - neck)/2.

    Raises:
        ModelError: A size is not positive, or the neck is higher than the bar.

    Warns:
        BeamTheoryWarning: Neck/radius is above 0.25, or the width is below twice sqrt(radius neck).

    Source:
        THEORY.md 2, eq. (2.60) and (2.61).
    """
    plain = notch_circular(width, height, neck, radius, material, shear=True)
    return necks.neck(plain, width, neck, radius, necks.notch_length(height, neck, radius), material)


def notch_elliptic(
    width: Scalar, height: Scalar, neck: Scalar, along: Scalar, across: Scalar, material: Material, shear: bool = False
) -> Profile:
    """Return the section of a bar with an elliptic notch on both sides in its middle.

    Args:
        width: Side of the bar along local y, () [m].
        height: Side of the bar along local z, away from the notch, () [m].
        neck: Height left in the middle, () [m].
        along: Half axis of the ellipse along the bar, () [m].
        across: Half axis of the ellipse across the bar, () [m]; at least half of height - neck.
        material: Material.
        shear: Whether shear deformation is counted, as of :class:`Rectangle`.

    Returns:
        The section of the whole beam.

    Raises:
        ModelError: A size is not positive, or the neck is higher than the bar.

    Source:
        Smith, Badami, Dale, Xu (1997), Review of Scientific Instruments 68, 1474: the shape.
    """
    width, height, neck, along, across = map(as_known, (width, height, neck, along, across))
    depth = _depth(width, height, neck, along=along, across=across)
    if is_concrete((depth, across)) and across < depth:
        raise ModelError(
            f"A notch with a depth of {depth:g} = (height - neck)/2 needs `across` of at least this depth, not"
            f" {across:g}."
        )
    # Impossible sizes become NaN. A beam with this section raises an error that names it.
    cut = along * jnp.sqrt(jnp.where((depth > 0) & (depth <= across), depth * (2 * across - depth), jnp.nan)) / across

    def section(place: Float[Array, ""], length: Float[Array, ""]):
        x = jnp.abs(place - 0.5) * length
        inside = x < cut
        x = jnp.where(inside, x, 0.0)
        return Rectangle(width, jnp.where(inside, neck + 2 * across * _rise(x / along), height), material, shear=shear)

    return Profile(section, lambda length: (0.5 - cut / length, 0.5, 0.5 + cut / length))


def notch_filleted(
    width: Scalar, height: Scalar, neck: Scalar, flat: Scalar, radius: Scalar, material: Material, shear: bool = False
) -> Profile:
    """Return the section of a bar with a long notch on both sides in its middle and rounded corners.

    Args:
        width: Side of the bar along local y, () [m].
        height: Side of the bar along local z, away from the notch, () [m].
        neck: Height left in the notch, () [m].
        flat: Length of the neck between its roundings, () [m].
        radius: Radius of the roundings, () [m]; at most half of height - neck.
        material: Material.
        shear: Whether shear deformation is counted, as of :class:`Rectangle`.

    Returns:
        The section of the whole beam, whose length is at least flat + 2 radius.

    Raises:
        ModelError: A size is not positive, the neck is higher than the bar, or the radius is larger than the depth.

    Source:
        Lobontiu (2003), Compliant Mechanisms, section 2.3: the shape.
    """
    width, height, neck, flat, radius = map(as_known, (width, height, neck, flat, radius))
    depth = _depth(width, height, neck, flat=flat, radius=radius)
    if is_concrete((depth, radius)) and radius > depth:
        raise ModelError(f"Argument `radius` must be at most (height - neck)/2 = {depth:g}, but is {radius:g}.")
    radius = jnp.where(radius <= depth, radius, jnp.nan)

    def section(place: Float[Array, ""], length: Float[Array, ""]):
        x = jnp.abs(place - 0.5) * length - flat / 2
        inside = (x > 0) & (x < radius)
        curved = neck + 2 * radius * _rise(jnp.where(inside, x, 0.0) / radius)
        return Rectangle(width, jnp.where(x < radius, curved, height), material, shear=shear)

    def breaks(length: Float[Array, ""]):
        inner, outer = flat / 2 / length, (flat / 2 + radius) / length
        return 0.5 - outer, 0.5 - inner, 0.5 + inner, 0.5 + outer

    return Profile(section, breaks)


def _depth(width: Scalar, height: Scalar, neck: Scalar, **others: Scalar) -> Scalar:
    """Check sizes, and return the depth of a notch from each side."""
    height, neck = as_known(height), as_known(neck)
    with nan_if_refused() as marked:
        for name, value in {"width": width, "height": height, "neck": neck, **others}.items():
            check_number(name, value, above=0, fault=ModelError)
        if not holds(neck < height):
            raise ModelError(f"Argument `neck` must be smaller than the height {height:g} of the bar, but is {neck:g}.")
        return marked((height - neck) / 2)


def _rise(x: Scalar) -> Scalar:
    """Height of a unit circle above its lowest point."""
    return 1 - jnp.sqrt(1 - x**2)


__all__, __dir__ = only(globals(), lambda value: getattr(value, "__module__", "").startswith(f"{__package__}."))
