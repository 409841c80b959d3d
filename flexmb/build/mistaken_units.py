"""Warnings of numbers that are off by a factor of a unit, such as lengths in millimetres."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from .. import numerical_limits as limits
from ..arguments import as_known, is_concrete
from ..elements.section import Material, Section
from ..errors import warn
from .description import Description

SIZES = ("width", "height", "thickness", "diameter")
TOO_LARGE = "This is too large for a {}. Are lengths in millimetres? flexmb reads metres."


def warn_of_material(of: str, material: Material) -> None:
    """Warn of a modulus, density, strength or expansion that no material has, and of moduli that contradict each other.

    Args:
        of: Words for the material or its section, such as "section of element 'leaf'".
        material: Material without faults.
    """
    if not is_concrete(material):
        return
    known: Any = as_known(material)
    if told := [*_of_material(known)]:
        warn(f"The {of} has {'; '.join(told)}. flexmb reads SI units: Pa, kg/m^3, 1/K.")
    if None not in (known.G, known.nu):
        given, shear = float(known.G), float(known.E) / (2 * (1 + float(known.nu)))
        if abs(given / shear - 1) > limits.CONTRADICTING_MODULI:
            warn(
                f"The {of} has G = {given:.4g} Pa, but E and nu of an isotropic material need"
                f" G = {shear:.4g} Pa. Leave out nu or G, unless the material is not isotropic."
            )


def _of_material(material: Any) -> Iterator[str]:
    modulus, density = float(material.E), float(material.rho)
    # Gels and soft rubbers are nearly incompressible. Foams are light.
    soft = density < limits.DENSEST_GEL and (material.poisson() > 0.45 or 23 <= density <= 300)
    if 10.0 <= modulus < limits.SOFTEST_STIFF_SOLID and not soft:
        unit = "GPa" if modulus < 2e3 else "MPa"
        yield f"E = {modulus:g} Pa, as soft as a gel: is it in {unit}?"
    if density > limits.DENSEST_SOLID:
        yield f"rho = {density:g} kg/m^3, denser than any solid"
    # A density of one stands for any mass.
    elif modulus >= limits.SOFTEST_STIFF_SOLID and 0.5 < density < limits.LIGHTEST_STIFF_SOLID and density != 1.0:
        yield f"rho = {density:g} kg/m^3, lighter than any stiff solid: is it in g/cm^3?"
    for name in ("strength", "fatigue"):
        stress = getattr(material, name)
        if stress is not None and float(stress) < limits.WEAKEST_SOLID * modulus:
            yield f"{name} = {float(stress):g} Pa, less than a millionth of E: is it in MPa?"
    alpha: Any = material.alpha
    if alpha is not None and modulus >= limits.SOFTEST_STIFF_SOLID and abs(float(alpha)) > limits.LARGEST_EXPANSION:
        yield f"alpha = {float(alpha):g} 1/K: is it in 1e-6/K?"


def warn_of_section(of: str, section: Section) -> None:
    """Warn of a cross-section larger than any mechanism has, and of its material.

    Args:
        of: Words for the section, such as "section of element 'leaf'".
        section: Section without faults.
    """
    if not is_concrete(section):
        return
    if large := _too_large(section):
        warn(f"The {of} has {', '.join(large)}. {TOO_LARGE.format('cross-section')}")
    if isinstance(material := getattr(section, "material", None), Material):
        warn_of_material(of, material)


def _too_large(section: Section) -> list[str]:
    sizes = {name: _number(section, name) for name in SIZES}
    return [f"{name} = {size:g} m" for name, size in sizes.items() if size > limits.LARGEST_SECTION]


def _number(section: Any, name: str) -> float:
    """Return the size of a section, or zero without a size of this name that is one number."""
    size = getattr(section, name, 0.0)
    try:
        return float(size) if np.ndim(size) == 0 else 0.0
    except TypeError:
        return 0.0


def warn_of_lengths(builder: Description) -> None:
    """Warn of nodes farther apart, and of leaf springs thicker, than in any mechanism."""
    places = [n.start for n in builder.nodes.values() if n.kind.part == "position"]
    if places and is_concrete(places):
        reach = np.ptp(np.array([np.asarray(place, float) for place in places]), axis=0)
        if np.max(reach) > limits.LARGEST_MECHANISM:
            warn(f"Nodes are {np.max(reach):g} m apart. {TOO_LARGE.format('mechanism')}")
            return
    for name, member in builder.members.items():
        section = member.properties.get("section")
        if member.element.name == "leaf_spring" and isinstance(section, Section) and is_concrete(section):
            thickness = _number(section, "thickness")
            if thickness > limits.THICKEST_LEAF_SPRING and not _too_large(section):
                warn(f"Leaf spring '{name}' has thickness = {thickness:g} m. {TOO_LARGE.format('leaf spring')}")
                return
