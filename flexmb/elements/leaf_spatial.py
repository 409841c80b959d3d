"""Leaf spring in space: a spectral beam with warping as a coordinate; common code is in ``leaf``."""

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from . import beams, spectral_spatial
from .curves import CurvedLine
from .element import Element
from .leaf import Leaf, faults_of_leaf, leaf_of
from .leaf_ends import Roots, faults_of_ends
from .leaf_stress import leaf_stress, twist_at
from .nodes import Point3, Reference, Rotation3, Series3, Static, Warping
from .profile import Profile
from .section import Damping
from .sections import Rectangle
from .spectral import check_curvature, fields_after
from .spectral_spatial import FIELDS, _length

# Deformations: the closure, the warping of both ends, and the coefficients of the strains.
CLOSURE, WARPINGS = 6, 2
OF_BEAM = spectral_spatial.spectral_beam.names


def _spectral(nodes: Sequence[Array], ref: Reference, curvature: Any, order: int):
    """Coordinates of a spectral beam whose last two coefficients are warping times length."""
    p, rot_p, warp_p, q, rot_q, warp_q, c = nodes
    return p, rot_p, q, rot_q, jnp.concatenate([c, _length(ref, curvature, order) * jnp.concatenate([warp_p, warp_q])])


def _of_beam(section: Any, clamped: Any, order: int, y: Any, curvature: Any, *ends: Any) -> dict[str, Any]:
    """Properties of the spectral beam with the section of a leaf spring."""
    leaf = leaf_of(section, clamped, curvature, *ends)
    return {"section": leaf, "order": order, "shear": True, "y": y, "curvature": curvature}


def _leaf_spring(
    p: Point3,
    rot_p: Rotation3,
    warp_p: Warping,
    q: Point3,
    rot_q: Rotation3,
    warp_q: Warping,
    c: Series3,
    *,
    ref: Reference,
    section: Rectangle | Profile,
    order: Static[int] = 6,
    clamped: tuple[bool, bool] | bool | None = None,
    y: Float[Array, "3"] | None = None,
    curvature: Float[Array, "3"] | CurvedLine | None = None,
    skew: Float[Array, "2"] | None = None,
    clamp: Roots | None = None,
) -> Float[Array, "n_e"]:
    """Closure at q, warping of both ends, then the coefficients."""
    options = _of_beam(section, clamped, order, y, curvature, skew, clamp)
    warping = _length(ref, curvature, order) * jnp.concatenate([warp_p, warp_q])
    # The search for allowed motions passes no section: it does not depend on the distribution of strains.
    coefficients = c if section is None else jnp.concatenate([c, warping])
    e = spectral_spatial._spectral_beam(p, rot_p, q, rot_q, coefficients, ref=ref, **options)
    return jnp.concatenate([e[:CLOSURE], warping, c])


def _fields(*, order):
    return fields_after(CLOSURE + WARPINGS, len(FIELDS), order)


def _matrix(of: Damping | None, leaf: Leaf, order: int, ref: Reference):
    matrix = leaf.matrix(of, order, _length(ref, leaf.initial, order), FIELDS)
    return jnp.pad(jnp.roll(matrix, (WARPINGS, WARPINGS), (0, 1)), (CLOSURE, 0))


def _stiffness(*, ref, section, order, clamped=None, curvature=None, skew=None, clamp=None):
    return _matrix(None, leaf_of(section, clamped, curvature, skew, clamp), order, ref)


def _damping(*, ref, damping: Damping, order, section, clamped=None, curvature=None, skew=None, clamp=None):
    return _matrix(damping, leaf_of(section, clamped, curvature, skew, clamp), order, ref)


def _energy(e: Array, *, ref, section, order, clamped=None, curvature=None):
    """Energy of flattening at large curvature, and of the tension of the edges by twist."""
    return leaf_of(section, clamped, curvature).energy(
        order, jnp.roll(e[CLOSURE:], -WARPINGS), _length(ref, curvature, order), FIELDS
    )


def _inertia(*nodes: Array, ref, section, order, clamped=None, y=None, curvature=None, skew=None, clamp=None):
    options = _of_beam(section, clamped, order, y, curvature, skew, clamp)
    return spectral_spatial._inertia(*_spectral(nodes, ref, curvature, order), ref=ref, **options)


def _resultants(
    *nodes: Array,
    ref,
    place,
    sigma,
    section,
    order,
    fall=None,
    clamped=None,
    y=None,
    curvature=None,
    skew=None,
    clamp=None,
):
    options = _of_beam(section, clamped, order, y, curvature, skew, clamp)
    return spectral_spatial._resultants(
        *_spectral(nodes, ref, curvature, order), ref=ref, place=place, sigma=sigma, fall=fall, **options
    )


def _surface(e: Array, *, ref, place, resultants, section, order, clamped=None, curvature=None):
    """Stress with restrained warping, and with stress across the width near clamps."""
    leaf, length, at = leaf_of(section, clamped, curvature), _length(ref, curvature, order), CLOSURE + WARPINGS + order
    twisting = jnp.concatenate([e[at : at + order], e[CLOSURE : CLOSURE + WARPINGS]])
    return leaf_stress(leaf, place, length, resultants, twist_at(leaf, place, length, order, twisting))


def _thermal(
    change: Array, gradient: Array, *, ref, section, order, clamped=None, curvature=None, skew=None, clamp=None
):
    """Thermal elongation and curvatures; the warmer side becomes longer."""
    leaf, bends = leaf_of(section, clamped, curvature, skew, clamp), {"EIy": gradient[1], "EIz": -gradient[0]}
    coefficients = leaf.thermal(change, bends, order, _length(ref, curvature, order), FIELDS)
    return jnp.pad(coefficients, (CLOSURE + WARPINGS, 0))


def _shape(*nodes: Array, ref, place, section, order, clamped=None, y=None, curvature=None, skew=None, clamp=None):
    options = _of_beam(section, clamped, order, y, curvature, skew, clamp)
    return spectral_spatial._shape(*_spectral(nodes, ref, curvature, order), ref=ref, place=place, **options)


def _check(*, ref, section, y=None, curvature=None, skew=None, clamp=None) -> list[str]:
    faults = beams.check_length(ref=ref) or beams.check_across(ref=ref, y=y) or check_curvature(ref, curvature, y)
    return faults or faults_of_leaf(section, ref, curvature) or faults_of_ends(skew, clamp)


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
    measured=(7, 8),
    third_order=True,
    series=_fields,
    lengths=(0, 4, 5),
    names=(*OF_BEAM[:CLOSURE], "warping_p", "warping_q", *OF_BEAM[CLOSURE:]),
)
"""A leaf spring that agrees with a solid model, one element for its whole length.

In addition to a spectral beam it models shear and warping. Clamps restrain the warping. Leaf springs that meet in a
node share their warping. Near clamps the leaf spring bends and stretches as a plate. Its middle flattens as its
curvature grows, and twist causes tension in its edges. flexmb finds the clamped ends when it builds the model. An end
is clamped if its rotation is held, or if it joins a rigid element, a hinge, a body or a part at least three times as
thick. At a fold the section stays flat.

Deformations:
    1 to 6: the closure at q, FIXED.
    7, 8: twist rates of the first and the last end, times length [rad]. The warping coordinates of the nodes determine
        them.
    From 9 on: ``order`` coefficients of each strain, times length, as of ``spatial.spectral_beam`` with shear.

Properties: section, a :class:`flexmb.Rectangle`, constant or varying smoothly; damping; y (vector that fixes local y,
along the width); clamped, such as (True, False) if only the first end is clamped, in place of the clamped ends that
flexmb finds; curvature, as of ``spatial.spectral_beam``; skew (angles between the cuts of both ends and straight cuts
[rad], positive if the edge at +y lies further along x); clamp (stiffnesses of elastic roots along and about local x, y,
z [N/m, N m/rad]: six for both ends, or a pair of six, None for a rigid end).
Options: order, the number of coefficients of each strain, default 6. The third bending frequency of a cantilever is 2 %
too high with order 5, and within 0.5 % with order 6.

The stress includes the bimoment of restrained warping, the stress across the width near clamps, and the effects of
flattening and of edge tension; see :mod:`.leaf_stress`. Beyond a tenth of the width from a clamp it is within about 5 %
of solid elements. Nearer to a clamp, solid elements have a singularity at the edges, which the stress does not include.
If a leaf spring warms up and its clamp stays cold, the stress does not include the thermal stress across the width at
this clamp.

Source: THEORY.md 2, eq. (2.22) to (2.30), (2.42), (2.47) to (2.52) and (2.55) to (2.59), (2.65) to (2.67).
"""
