"""Base class of cross-sections, given rigidities, materials, and damping of elements.

A section's local y and z axes are the element's. ``EIy`` resists bending that displaces along z (deformations 3
and 4 of the spatial beam, the bending of a planar beam), ``EIz`` bending that displaces along y.
"""

import abc
import dataclasses
from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, holds, library_of
from ..compilation.record import Record
from ..errors import ModelError
from ..numerical_limits import TEN_DIGITS
from . import surface
from .surface import Scalar as Scalar

WITHOUT_SHEAR_MODULUS = "neither G nor nu: give Material(E=.., nu=..), Material(E=.., G=..), or all three"


class Material(Record):
    """Isotropic linear material; :mod:`flexmb.materials` contains common materials.

    Attributes:
        E: Young's modulus [Pa].
        G: Shear modulus [Pa]; E/(2 (1 + nu)) unless given. A material needs G, nu or both.
        rho: Density [kg/m^3].
        nu: Poisson's ratio [-]; E/(2 G) - 1 unless given.
        alpha: Coefficient of thermal expansion, of either sign [1/K]. Without it, elements of the material cannot have
            a temperature.
        strength: Yield stress, or fracture stress of a brittle material [Pa]; optional. :class:`flexmb.linear.Stress`
            compares the stress of elements with it.
        fatigue: Largest amplitude of a fully reversed stress without fatigue failure [Pa]; optional.
        damping: Time constant of Kelvin and Voigt [s]: the stress is E (strain + damping * strain rate), THEORY.md 2,
            eq. (2.41). It applies to elements without a ``damping`` property. A vibration of angular frequency w has
            the damping ratio damping * w/2. None: no damping.
    """

    E: Scalar
    G: Scalar | None = None
    rho: Scalar = 0.0
    nu: Scalar | None = None
    alpha: Scalar | None = None
    strength: Scalar | None = None
    fatigue: Scalar | None = None
    damping: Scalar | None = None

    def poisson(self) -> Scalar:
        """Poisson's ratio, () [-]."""
        return self.E / (2 * self.shear_modulus()) - 1 if self.nu is None else self.nu

    def shear_modulus(self) -> Scalar:
        """Shear modulus, () [Pa]."""
        if self.G is not None:
            return self.G
        if self.nu is None:
            raise ModelError(f"The material has {WITHOUT_SHEAR_MODULUS}.")
        return self.E / (2 * (1 + self.nu))

    def faults(self) -> list[str]:
        """Return the faults of known numbers: moduli that are not positive, and contradictions."""
        return faults_of(self, at_least_zero=("rho", "damping")) + _faults_of_material(self)


class Section(Record):
    """Cross-section of a beam or truss. :meth:`rigidity` returns its rigidities and mass per length.

    A section with a shape also returns its stress, by :meth:`stress`.
    """

    # Whether :meth:`at` returns different sections at different places.
    varies = False

    @abc.abstractmethod
    def rigidity(self) -> "Rigidity":
        """Return rigidities and mass per length of the section."""

    def at(self, place: Scalar, length: Scalar) -> "Section":
        """Return the section at a place of a beam; the section itself if it does not vary.

        Args:
            place: From 0 to 1, () [-].
            length: Of the beam, () [m].
        """
        return self

    def breaks_at(self, length: Scalar) -> tuple[Float[Array, ""], ...]:
        """Return the places where the section or its slope jumps along a beam; none if it does not vary.

        Args:
            length: Of the beam, () [m].
        """
        return ()

    def relative(self, places: Any, length: Scalar, names: Sequence[str]) -> Float[Array, "n names"]:
        """Return compliances at places of a spectral beam over the mean compliances: 1, except in leaf springs.

        Args:
            places: From 0 to 1, (n,).
            length: Of the beam, () [m].
            names: Names of rigidities.
        """
        return jnp.ones((len(places), len(names)))

    def stress(self, resultants: Float[Array, "6"]) -> surface.Stress:
        """Return the stress at eight points of the surface.

        Args:
            resultants: Normal force, shear forces along y and z [N], torque, bending moments about y and z [N m], (6,).

        Returns:
            Stress along x and shear stress along the surface, counter-clockwise about x, (8,) [Pa].

        Raises:
            ModelError: The section has no shape.

        Source:
            :mod:`flexmb.elements.surface`.
        """
        raise ModelError(f"A section of kind {type(self).__name__} has no shape, and therefore no stress.")

    @property
    def has_shape(self) -> bool:
        """Return whether the section has a shape, so that :meth:`stress` works."""
        return type(self).stress is not Section.stress

    def stated(self, quantity: str) -> Any:
        """Return a quantity of the material; None without this quantity or without a material.

        Args:
            quantity: Attribute of :class:`Material`, such as "strength".
        """
        return getattr(getattr(self, "material", None), quantity, None)

    def states(self, quantity: str) -> bool:
        """Return whether the material has a quantity.

        Args:
            quantity: Attribute of :class:`Material`.
        """
        return self.stated(quantity) is not None

    def material_damping(self) -> "MaterialDamping | None":
        """Return the damping of the material; None if it has none."""
        time = self.stated("damping")
        return None if time is None else MaterialDamping(time)

    @property
    def expands(self) -> bool:
        """Whether its coefficient of thermal expansion is stated."""
        return self.states("alpha")

    def faults(self) -> list[str]:
        """Return the faults of known numbers: sizes and moduli that are not positive, negative densities."""
        return faults_of(self, at_least_zero=("rho", "damping"))


class Rigidity(Section):
    """A section given by its rigidities and inertia. The default of each number is zero.

    A shear compliance of zero means a section that is rigid in shear. An ``outline`` adds sizes for the stress; it does
    not change rigidities and inertia.

    Attributes:
        EA: Axial rigidity [N].
        EIy: Bending rigidity about local y [N m^2]; the bending rigidity of a planar beam.
        EIz: Bending rigidity about local z [N m^2].
        GIt: Torsional rigidity [N m^2].
        shear_z: EIy/(GAk) for displacement along z [m^2].
        shear_y: EIz/(GAk) for displacement along y [m^2].
        mass: Mass per length [kg/m].
        Jx, Jy, Jz, Jyz: Rotary inertia per length about local axes [kg m]. Jyz = -(integral of rho y z over the
            section), the entry of the tensor. A planar beam uses Jy.
        alpha: Coefficient of thermal expansion [1/K]; None: no thermal expansion.
        EIw: Warping rigidity of a beam with warping as a coordinate (``spatial.warping_beam``) [N m^4].
        Jw: Inertia of warping per length of this beam [kg m^3].
        outline: Section with the sizes for the stress and the material for the strength; None: no shape and no
            stress.
    """

    EA: Scalar = 0.0
    EIy: Scalar = 0.0
    EIz: Scalar = 0.0
    GIt: Scalar = 0.0
    shear_z: Scalar = 0.0
    shear_y: Scalar = 0.0
    mass: Scalar = 0.0
    Jx: Scalar = 0.0
    Jy: Scalar = 0.0
    Jz: Scalar = 0.0
    Jyz: Scalar = 0.0
    alpha: Scalar | None = None
    EIw: Scalar = 0.0
    Jw: Scalar = 0.0
    outline: Section | None = None

    def rigidity(self) -> "Rigidity":
        """Return these rigidities without their outline."""
        return self if self.outline is None else dataclasses.replace(self, outline=None)

    def stress(self, resultants: Float[Array, "6"]) -> surface.Stress:
        """Return the stress in a section with the sizes of the outline.

        Args:
            resultants: Forces and moments in the section, (6,) [N, N m].
        """
        return super().stress(resultants) if self.outline is None else self.outline.stress(resultants)

    @property
    def has_shape(self) -> bool:
        """Return whether the section has an outline."""
        return self.outline is not None

    def stated(self, quantity: str) -> Any:
        """Return alpha, or the strength or the fatigue limit of the outline's material; None for any other quantity.

        Args:
            quantity: Attribute of :class:`Material`.
        """
        if quantity == "alpha":
            return self.alpha
        if self.outline is None or quantity not in ("strength", "fatigue"):
            return None
        return self.outline.stated(quantity)

    def shear_rigidities(self) -> tuple[Any, Any]:
        """Return the shear rigidities along y and along z [N]; zero for a section that is rigid in shear."""
        library = library_of((self.EIy, self.EIz, self.shear_y, self.shear_z))

        def rigidity(bending: Scalar, compliance: Scalar):
            sheared = library.asarray(compliance) > 0
            return library.where(sheared, bending / library.where(sheared, compliance, 1.0), 0.0)

        return rigidity(self.EIz, self.shear_y), rigidity(self.EIy, self.shear_z)

    def faults(self) -> list[str]:
        """Return faults: a negative rigidity or mass. Product of inertia and thermal expansion have either sign."""
        numbers = tuple(f.name for f in dataclasses.fields(self) if f.name != "Jyz")
        faults = faults_of(self.rigidity(), at_least_zero=numbers)
        return faults + [f"outline: {fault}" for fault in (self.outline.faults() if self.outline is not None else [])]


def faults_of(record: Any, at_least_zero: tuple[str, ...]) -> list[str]:
    """Return the faults of the numbers of a record: all must be positive, some may be zero.

    Args:
        record: Section, material or damping. Conditions on traced numbers go to :func:`flexmb.arguments.holds`.
    """
    faults = []
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        if field.metadata.get("static") or value is None or field.name in ("Jyz", "nu", "alpha"):
            continue
        if isinstance(value, Record):
            faults += faults_of(value, at_least_zero)
            faults += _faults_of_material(value) if isinstance(value, Material) else []
        elif field.name in at_least_zero:
            faults += [] if holds(as_known(value) >= 0) else [f"{field.name} = {value}, but it cannot be negative"]
        elif not holds(as_known(value) > 0):
            faults.append(f"{field.name} = {value}, but it must be positive")
    return faults


def _faults_of_material(material: Material) -> list[str]:
    """Contradictions between the numbers of a material."""
    faults, nu = [], as_known(material.nu)
    if nu is not None and not (holds(nu > -1) and holds(nu < 0.5)):
        faults.append(f"nu = {nu}, but it must be above -1 and below 0.5")
    if nu is None and material.G is None:
        return [*faults, WITHOUT_SHEAR_MODULUS]
    ratio = as_known(material.E) / (2 * as_known(material.shear_modulus())) - 1
    if nu is None and not holds(ratio <= 0.5 + TEN_DIGITS):
        faults.append(f"nu = {np.max(ratio):.4g} by E and G, but it must be below 0.5: G is at least E/3, or give nu")
    fatigue, strength = as_known(material.fatigue), as_known(material.strength)
    if fatigue is not None and strength is not None and not holds(fatigue <= strength):
        faults.append(f"fatigue = {fatigue}, but it cannot be above the strength {strength}")
    return faults


class Damping(Record):
    """Damping rigidities of a beam or truss, one for each rigidity of its section.

    Attributes:
        EA: Axial [N s].
        EIy: Bending about local y [N m^2 s]; the bending of a planar beam.
        EIz: Bending about local z [N m^2 s].
        GIt: Torsion [N m^2 s].
        GAy: Shear along y, of beams with shear [N s].
        GAz: Shear along z; the shear of a planar beam [N s].
    """

    EA: Scalar = 0.0
    EIy: Scalar = 0.0
    EIz: Scalar = 0.0
    GIt: Scalar = 0.0
    GAy: Scalar = 0.0
    GAz: Scalar = 0.0

    def faults(self) -> list[str]:
        """Return the faults of known numbers: negative damping."""
        return faults_of(self, at_least_zero=tuple(f.name for f in dataclasses.fields(self)))


class MaterialDamping(Record):
    """Damping S_d = time * S of an element by its material, used without a ``damping`` property.

    Attributes:
        time: Time constant of Kelvin and Voigt [s].

    Source:
        THEORY.md 2, eq. (2.41).
    """

    time: Scalar

    def rigidities(self, section: Any) -> Damping:
        """Return the damping rigidities of a section that does not vary.

        Args:
            section: A :class:`Section` of this material.
        """
        s = section.rigidity()
        return Damping(*(self.time * rigidity for rigidity in (s.EA, s.EIy, s.EIz, s.GIt, *s.shear_rigidities())))
