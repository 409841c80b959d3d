"""Leaf spring in the plane: a spectral beam that bends as a plate near clamps; what it shares stands in ``leaf``."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from . import beams, spectral_planar
from .element import Element
from .leaf import Clamped, Leaf, faults_of_leaf, leaf_of
from .leaf_stress import leaf_stress
from .nodes import Angle, Point2, Reference, Series2, Static
from .profile import Profile
from .section import Damping
from .sections import Rectangle
from .spectral import check_shear, fields_after, numbers_of
from .spectral_planar import ELONGATION, FIELDS, SHEAR, nodes_of


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
) -> Float[Array, "n_e"]:
    """Closure at q, then the coefficients themselves."""
    own = {"section": leaf_of(section, clamped), "order": order, "shear": shear}
    return spectral_planar._spectral_beam(p, rot_p, q, rot_q, c, ref=ref, **own)


def _fields(*, order: int, shear: bool):
    return fields_after(3, len(_names(shear)), order)


def _names(shear: bool) -> tuple[str, ...]:
    return FIELDS if shear else FIELDS[:SHEAR]


def _matrix(of: Damping | None, leaf: Leaf, order: int, shear: bool, ref: Reference):
    return jnp.pad(leaf.matrix(of, order, beams.beam_length(ref), _names(shear)), (3, 0))


def _stiffness(
    *, ref: Reference, section: Rectangle | Profile, order: int, shear: bool, clamped: Clamped | None = None
):
    return _matrix(None, leaf_of(section, clamped), order, shear, ref)


def _energy(
    e: Float[Array, "n_e"],
    *,
    ref: Reference,
    section: Rectangle | Profile,
    order: int,
    shear: bool,
    clamped: Clamped | None = None,
):
    """Of the flattening at large curvature."""
    return leaf_of(section, clamped).energy(order, e[3:], beams.beam_length(ref), _names(shear))


def _damping(
    *,
    ref: Reference,
    damping: Damping,
    order: int,
    shear: bool,
    section: Rectangle | Profile,
    clamped: Clamped | None = None,
):
    return _matrix(damping, leaf_of(section, clamped), order, shear, ref)


def _inertia(
    p: Point2,
    rot_p: Angle,
    q: Point2,
    rot_q: Angle,
    c: Series2,
    *,
    ref: Reference,
    section: Rectangle | Profile,
    order: int,
    shear: bool,
    clamped: Clamped | None = None,
):
    """That of a spectral beam of such a section."""
    own = {"section": leaf_of(section, clamped), "order": order, "shear": shear}
    return spectral_planar._inertia(p, rot_p, q, rot_q, c, ref=ref, **own)


def _resultants(
    p: Point2,
    rot_p: Angle,
    q: Point2,
    rot_q: Angle,
    c: Series2,
    *,
    ref: Reference,
    place: Float[Array, ""],
    sigma: Float[Array, "n_e"],
    section: Rectangle | Profile,
    order: int,
    shear: bool,
    fall: Float[Array, "k 2"] | None = None,
    clamped: Clamped | None = None,
):
    """Statics of the part beyond the place."""
    own = {"section": leaf_of(section, clamped), "order": order, "shear": shear, "sigma": sigma, "fall": fall}
    return spectral_planar._resultants(p, rot_p, q, rot_q, c, ref=ref, place=place, **own)


def _surface(
    e: Float[Array, "n_e"],
    *,
    ref: Reference,
    place: Float[Array, ""],
    resultants: Float[Array, "6"],
    section: Rectangle | Profile,
    clamped: Clamped | None = None,
):
    """Stress with what is across where clamps keep the section flat."""
    return leaf_stress(leaf_of(section, clamped), place, beams.beam_length(ref), resultants)


def _thermal(
    change: Float[Array, "2"],
    gradient: Float[Array, "1"],
    *,
    ref: Reference,
    section: Rectangle | Profile,
    order: int,
    shear: bool,
    clamped: Clamped | None = None,
):
    """Elongation, and the curvature by which the warmer side gets longer."""
    bends = {"EIy": -gradient[0]}
    found = leaf_of(section, clamped).thermal(change, bends, order, beams.beam_length(ref), _names(shear))
    return jnp.pad(found, (3, 0))


def _shape(
    p: Point2,
    rot_p: Angle,
    q: Point2,
    rot_q: Angle,
    c: Series2,
    *,
    ref: Reference,
    place: Float[Array, ""],
    order: int,
    shear: bool,
    section: Rectangle | Profile,
    clamped: Clamped | None = None,
):
    own = {"section": leaf_of(section, clamped), "order": order, "shear": shear}
    return spectral_planar._shape(p, rot_p, q, rot_q, c, ref=ref, place=place, **own)


def _check(*, ref: Reference, order: int, shear: bool, section: Rectangle | Profile) -> list[str]:
    faults = beams.check_length(ref=ref) or faults_of_leaf(section, ref, nodes_of(order))
    if faults or shear:
        # What counts shear does so whatever the section states.
        return faults
    # Of a material that the section itself finds fault with there is none to be found here.
    with np.errstate(all="ignore"):
        return check_shear(False, numbers_of(section, ref, None).shear_z)


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
    series=_fields,
    lengths=(ELONGATION, SHEAR),
    names=spectral_planar.spectral_beam.names,
)
"""A leaf spring as a solid model has it, one element for the whole of it.

Near clamped ends it bends and stretches as a plate, and its middle flattens as its curvature grows. Which ends are
clamped is found when the model is built: those whose rotation is held, those joined to a rigid element, a hinge, a body
or a part at least three times as thick, and folds.

Deformations: those of ``planar.spectral_beam``.
Properties: section, a :class:`flexmb.Rectangle`, the same everywhere or varying smoothly; damping; clamped, whether its
first end and its last are clamped, such as (True, False), where that shall not be found.
Options: order, the number of coefficients of each strain, 6 unless given: the third bending frequency of a
cantilever is 2 % high with 5 and within 0.5 % with 6; shear, whether shear deformation is counted, False unless given.
Where that would change a stiffness by more than 1 %, a model warns.

Stress counts what is across the width where clamps keep it flat, and the flattening of the middle; see
:mod:`.leaf_stress`.

Source: THEORY.md 2, eq. (2.22), (2.23) and (2.28).
"""
