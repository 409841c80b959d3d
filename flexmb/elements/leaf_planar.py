"""Leaf spring in the plane: a spectral beam that bends as a plate near clamps; common code is in ``leaf``."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from . import beams, spectral_planar
from .curves import CurvedLine
from .element import Element
from .leaf import Leaf, faults_of_leaf, leaf_of
from .leaf_ends import PlanarRoots, faults_of_ends
from .leaf_stress import leaf_stress
from .nodes import Angle, Point2, Reference, Series2, Static
from .profile import Profile
from .section import Damping
from .sections import Rectangle
from .spectral import check_curvature, check_shear, section_rigidities
from .spectral_planar import CLOSURE, ELONGATION, SHEAR, _length, _names, gauss_nodes


def _of_beam(section: Any, clamped: Any, order: int, shear: bool, curvature: Any, clamp: Any) -> dict[str, Any]:
    """Properties of the spectral beam with the section of a leaf spring."""
    leaf = leaf_of(section, clamped, curvature, None, clamp)
    return {"section": leaf, "order": order, "shear": shear, "curvature": curvature}


def _leaf_spring(
    p: Point2,
    rot_p: Angle,
    q: Point2,
    rot_q: Angle,
    c: Series2,
    *,
    ref: Reference,
    section: Rectangle | Profile,
    order: Static[int] = 6,
    shear: Static[bool] = False,
    clamped: tuple[bool, bool] | bool | None = None,
    curvature: float | CurvedLine | None = None,
    clamp: PlanarRoots | None = None,
) -> Float[Array, "n_e"]:
    """Closure at q, then the coefficients."""
    options = _of_beam(section, clamped, order, shear, curvature, clamp)
    return spectral_planar._spectral_beam(p, rot_p, q, rot_q, c, ref=ref, **options)


def _matrix(of: Damping | None, leaf: Leaf, order: int, shear: bool, ref: Reference):
    return jnp.pad(leaf.matrix(of, order, _length(ref, leaf.initial), _names(shear)), (CLOSURE, 0))


def _stiffness(*, ref, section, order, shear, clamped=None, curvature=None, clamp=None):
    return _matrix(None, leaf_of(section, clamped, curvature, None, clamp), order, shear, ref)


def _damping(*, ref, damping: Damping, order, shear, section, clamped=None, curvature=None, clamp=None):
    return _matrix(damping, leaf_of(section, clamped, curvature, None, clamp), order, shear, ref)


def _energy(e: Array, *, ref, section, order, shear, clamped=None, curvature=None):
    """Energy of flattening at large curvature."""
    return leaf_of(section, clamped, curvature).energy(order, e[CLOSURE:], _length(ref, curvature), _names(shear))


def _inertia(*nodes: Array, ref, section, order, shear, clamped=None, curvature=None, clamp=None):
    return spectral_planar._inertia(*nodes, ref=ref, **_of_beam(section, clamped, order, shear, curvature, clamp))


def _resultants(
    *nodes: Array, ref, place, sigma, section, order, shear, fall=None, clamped=None, curvature=None, clamp=None
):
    options = _of_beam(section, clamped, order, shear, curvature, clamp)
    return spectral_planar._resultants(*nodes, ref=ref, place=place, sigma=sigma, fall=fall, **options)


def _surface(e: Array, *, ref, place, resultants, section, clamped=None, curvature=None):
    # A positive moment about the section's y axis turns clockwise, a positive curvature counter-clockwise.
    opposite = None if curvature is None else jax.tree.map(jnp.negative, curvature)
    return leaf_stress(leaf_of(section, clamped, opposite), place, _length(ref, curvature), resultants)


def _thermal(change: Array, gradient: Array, *, ref, section, order, shear, clamped=None, curvature=None, clamp=None):
    """Thermal elongation and curvature; the warmer side becomes longer."""
    leaf, bends = leaf_of(section, clamped, curvature, None, clamp), {"EIy": -gradient[0]}
    coefficients = leaf.thermal(change, bends, order, _length(ref, curvature), _names(shear))
    return jnp.pad(coefficients, (CLOSURE, 0))


def _shape(*nodes: Array, ref, place, order, shear, section, clamped=None, curvature=None, clamp=None):
    options = _of_beam(section, clamped, order, shear, curvature, clamp)
    return spectral_planar._shape(*nodes, ref=ref, place=place, **options)


def _check(*, ref, order, shear, section, curvature=None, clamp=None) -> list[str]:
    faults = beams.check_length(ref=ref) or check_curvature(ref, curvature)
    faults = faults or faults_of_leaf(section, ref, curvature, gauss_nodes(order)) or faults_of_ends(None, clamp)
    if faults or shear:
        # A leaf spring with shear uses the shear compliance of its rectangle, also if the section has ``shear=False``.
        return faults
    # An invalid material, which the section reports, may cause division by zero here.
    with np.errstate(all="ignore"):
        return check_shear(False, section_rigidities(section, ref, curvature).shear_z)


leaf_spring = Element(
    _leaf_spring,
    stiffness=_stiffness,
    energy=_energy,
    damping=_damping,
    inertia=_inertia,
    resultants=_resultants,
    surface=_surface,
    thermal=_thermal,
    shape=_shape,
    check=_check,
    third_order=True,
    series=spectral_planar._fields,
    lengths=(ELONGATION, SHEAR),
    names=spectral_planar.spectral_beam.names,
)
"""A leaf spring that agrees with a solid model, one element for its whole length.

Near clamped ends it bends and stretches as a plate. Its middle flattens as its curvature grows. flexmb finds the
clamped ends when it builds the model. An end is clamped if its rotation is held, at a fold, and where it joins a rigid
element, a hinge, a body or a part at least three times as thick.

Deformations: as of ``planar.spectral_beam``.
Properties: section, a :class:`flexmb.Rectangle`, constant or varying smoothly; damping; clamped, whether the first end
and the last are clamped, such as (True, False), instead of the ends that flexmb finds; curvature, as of
``planar.spectral_beam``; clamp (stiffnesses of elastic roots: along the leaf spring, across it to the left, and of the
angle [N/m, N m/rad]; three numbers for both ends, or a pair of three numbers, None for a rigid end).
Options: order, the number of coefficients of each strain, default 6; shear, whether shear deformation is counted,
default False. The third bending frequency of a cantilever is 2 % too high with order 5, and within 0.5 % with order 6.
If shear would change a stiffness by more than 1 %, flexmb warns.

The stress includes the stress across the width near clamps and the flattening of the middle; see :mod:`.leaf_stress`.

Source: THEORY.md 2, eq. (2.22), (2.23), (2.28), (2.42), (2.47), (2.49) to (2.52), (2.58) and (2.59).
"""
