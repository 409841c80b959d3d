"""Spectral beam in the plane, with or without shear; common code is in ``spectral``."""

import copy
from functools import partial
from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.scipy.linalg import block_diag
from jaxtyping import Array, Float

from ..math.quadrature import gauss, legendre_coefficients
from ..math.rotation import cosine_and_sine, rotation_plane
from . import beams
from .curves import CurvedLine, curved_length, tilt_of, turned_to
from .element import Element
from .leaf_ends import IN_PLANE, jumps
from .nodes import Angle, Point2, Reference, Series2, Static
from .section import Scalar
from .sections import Damping, Section
from .spectral import (
    check_curvature,
    check_section,
    check_shear,
    fields_after,
    pieces_of,
    rigidities,
    section_rigidities,
    series_matrix,
    strains,
    thermal_series,
)

# Fields in the order of the coefficients.
ELONGATION, CURVATURE, SHEAR = 0, 1, 2
FIELDS = ("EA", "EIy", "GAz")
# Deformations that join the end of the beam to node q.
CLOSURE = 3


def _names(shear: bool) -> tuple[str, ...]:
    """Rigidities of the strain fields."""
    return FIELDS if shear else FIELDS[:SHEAR]


def gauss_nodes(order: int) -> int:
    """Return the number of Gauss nodes in each smooth piece of a beam."""
    return 2 * order + 8


def _rule(
    order: int, shear: bool, section: Section | None, length: Float[Array, ""], end: Float[Array, ""] | None = None
) -> SimpleNamespace:
    """Quadrature along the beam, to a place or to its last end, with the strains at its nodes and their integrals."""
    pieces, (nodes, weights) = pieces_of(section, length, end), gauss(gauss_nodes(order))
    places = pieces.spread(nodes).ravel()
    shapes = strains(order, section, places, length, _names(shear))
    along = pieces.integrals(nodes, weights)
    weights = (pieces.sizes[:, None] * weights).ravel()
    curvatures = shapes[:, CURVATURE]
    compliant_ends: Any = getattr(section, "ends", None) and jumps(section, order, length, _names(shear))
    return SimpleNamespace(
        pieces=pieces,
        inner=nodes,
        nodes=places,
        weights=weights,
        along=along,
        elongations=shapes[:, ELONGATION],
        angles=along @ curvatures,
        # If the strains are known polynomials, only the first coefficient contributes to the angle between the ends.
        turn=np.eye(order)[0] if isinstance(shapes, np.ndarray) else weights @ curvatures,
        shears=shapes[:, SHEAR] if shear else None,
        jumps=None if compliant_ends is None else IN_PLANE @ compliant_ends,
    )


def _length(ref: Reference, curvature: Scalar | CurvedLine | None) -> Float[Array, ""]:
    return curved_length(beams.beam_length(ref), curvature)


class PlanarLine:
    """The line of a beam by the coefficients c of its strains, from end p to a place or to its last end.

    Attributes:
        length: Length of the beam, () [m].
        rule: Quadrature.
        fields: Coefficients of each strain, (fields, order).
        jumps: Displacement and angle that each end adds, (2, 3); None without compliant ends.
    """

    def __init__(self, c: Array, ref: Reference, order: int, shear: bool, section: Any, curvature: Any):
        chord = beams.beam_length(ref)
        self.length, self._along, self._start = curved_length(chord, curvature), (ref.q - ref.p) / chord, ref.rot_p
        self._curvature, self.fields = curvature, c.reshape(-1, order)
        self._rule_to = partial(_rule, order, shear, section, self.length)
        self.rule = self._rule_to(None)
        self.jumps: Any = None if self.rule.jumps is None else self.rule.jumps @ c

    def up_to(self, place: Float[Array, ""]) -> "PlanarLine":
        """The same line, to a place."""
        part = copy.copy(self)
        part.rule = self._rule_to(place)
        return part

    def axes(self, rot_p: Angle) -> Float[Array, "2 2"]:
        """Axes of end p, as columns."""
        tilt = 0.0 if self._curvature is None else tilt_of(self._curvature, self.length)
        x = rotation_plane(rot_p[0] - self._start[0] - tilt) @ self._along
        return jnp.stack([x, jnp.stack([-x[1], x[0]])], axis=1)

    def _directions(self, places: Any, integrals: Any) -> Float[Array, "n 2"]:
        """Directions at places, in axes of end p."""
        angle = integrals @ self.fields[CURVATURE]
        if self._curvature is not None:
            angle = angle + turned_to(self._curvature, self.length, places)
        return jnp.stack(cosine_and_sine(angle), axis=-1)

    def _along_and_across(self, directions: Float[Array, "n 2"]) -> Float[Array, "n 2"]:
        """Derivative of the position by the place: along the normals of the sections, and across by shear."""
        slopes = (self.length + self.rule.elongations @ self.fields[ELONGATION])[:, None] * directions
        if self.rule.shears is None:
            return slopes
        across = jnp.stack([-directions[:, 1], directions[:, 0]], axis=-1)
        return slopes + (self.rule.shears @ self.fields[SHEAR])[:, None] * across

    def _slopes_after_jump(self) -> Float[Array, "n 2"]:
        return self._along_and_across(self._directions(self.rule.nodes, self.rule.angles))

    def slopes(self) -> Float[Array, "n 2"]:
        """Derivative of the position by the place at the nodes, in axes of end p."""
        slopes = self._slopes_after_jump()
        return slopes if self.jumps is None else slopes @ rotation_plane(self.jumps[0, 2]).T

    def turned_slopes(self, turn: Float[Array, ""]) -> Float[Array, "n 2"]:
        """As :meth:`slopes`, in global axes, of a beam whose end p is turned from its reference."""
        angle = turn + self.rule.angles @ self.fields[CURVATURE]
        if self._curvature is not None:
            bent = turned_to(self._curvature, self.length, self.rule.nodes)
            angle = angle + bent - tilt_of(self._curvature, self.length)
        x, (cosine, sine) = self._along, cosine_and_sine(angle)
        return self._along_and_across(cosine[:, None] * x + sine[:, None] * jnp.stack([-x[1], x[0]]))

    def last_direction(self, place: Any) -> Float[Array, "2"]:
        """Direction at the end of the line, (1,) place, in axes of end p."""
        last = self._directions(place, self.rule.turn[None])[0]
        return last if self.jumps is None else rotation_plane(self.jumps[0, 2]) @ last

    def to_end(self) -> Float[Array, "2"]:
        """Vector from p to the end of the line, in axes of end p."""
        way = self.rule.weights @ self._slopes_after_jump()
        return way if self.jumps is None else self.jumps[0, :2] + rotation_plane(self.jumps[0, 2]) @ way


def _spectral_beam(
    p: Point2,
    rot_p: Angle,
    q: Point2,
    rot_q: Angle,
    c: Series2,
    *,
    ref: Reference,
    order: Static[int] = 5,
    shear: Static[bool] = False,
    section: Section | None = None,
    curvature: float | CurvedLine | None = None,
) -> Float[Array, "n_e"]:
    """Closure at q, then the coefficients."""
    line = PlanarLine(c, ref, order, shear, section, curvature)
    displacement = line.axes(rot_p).T @ (q - p) - line.rule.weights @ line.slopes()
    turn = (rot_q - ref.rot_q) - (rot_p - ref.rot_p) - line.rule.turn @ line.fields[CURVATURE]
    if line.jumps is not None:
        x, y = line.last_direction(np.ones(1))
        displacement = displacement - line.jumps[0, :2] - jnp.array([[x, -y], [y, x]]) @ line.jumps[1, :2]
        turn = turn - jnp.sum(line.jumps[:, 2])
    return jnp.concatenate([jnp.concatenate([displacement, turn]), c])


def _fields(*, order: int, shear: bool):
    return fields_after(CLOSURE, len(_names(shear)), order)


def _stiffness(*, ref, section, order, shear, curvature=None):
    return series_matrix(section, section, order, _length(ref, curvature), CLOSURE, _names(shear))


def _damping(*, ref, damping: Damping, order, shear, section=None, curvature=None):
    return series_matrix(damping, section, order, _length(ref, curvature), CLOSURE, _names(shear))


def _inertia(*nodes: Array, ref, section, order, shear=False, curvature=None):
    """Vectors whose weighted sums are the positions and angles at the nodes, and their mass matrix H.

    The vectors are the position of end p and the stretched directions at the nodes, then the turn of end p and the
    coefficients of curvature, padded by zeros.
    """
    p, rot_p, *_, c = nodes
    line, turn = PlanarLine(c, ref, order, shear, section, curvature), rot_p - ref.rot_p
    if line.jumps is not None:
        p = p + line.axes(rot_p) @ line.jumps[0, :2]
        turn = turn + line.jumps[0, 2]
    rule, turns = line.rule, jnp.concatenate([turn, line.fields[CURVATURE]])
    masses = rigidities(section, rule.nodes, line.length, ("mass", "Jy")) * (line.length * rule.weights)[:, None]
    to_places, to_angles = _with_ones(rule.along), _with_ones(rule.angles)
    vectors = [p[None], line.turned_slopes(turn[0]), jnp.stack([turns, jnp.zeros_like(turns)], axis=1)]
    sums = [(matrix.T * masses[:, k]) @ matrix for k, matrix in enumerate((to_places, to_angles))]
    return jnp.concatenate(vectors), block_diag(*sums)


def _with_ones(integrals: Float[Array, "n k"] | np.ndarray) -> Float[Array, "n 1+k"]:
    """Weights of positions or angles at the nodes: 1 for end p, then integrals from end p."""
    return jnp.concatenate([jnp.ones((integrals.shape[0], 1)), jnp.asarray(integrals)], axis=1)


def _turn(lever: Float[Array, "*n 2"], force: Float[Array, "*n 2"]):
    """Moment of forces in the plane, counter-clockwise."""
    return lever[..., 0] * force[..., 1] - lever[..., 1] * force[..., 0]


def _resultants(*nodes: Array, ref, place, sigma, section, order, shear=False, fall=None, curvature=None):
    """Section resultants at a place by statics of the part beyond it."""
    p, rot_p, q, _, c = nodes
    line = PlanarLine(c, ref, order, shear, section, curvature)
    part = line.up_to(place)
    rule, axes, (cosine, sine) = line.rule, line.axes(rot_p), part.last_direction(place[None])
    # Force and moment about p of the part beyond the place, counter-clockwise, in axes of end p.
    force, moment = jnp.split(sigma[:3], (2,))
    wrench = jnp.append(force, moment + _turn(axes.T @ (q - p), force))
    if fall is not None:
        masses = rigidities(section, rule.nodes, line.length, ("mass", "Jy")) * line.length
        n = masses.shape[0] + 1
        pulls = masses[:, :1] * ((fall[0] + rule.along @ fall[1:n]) @ axes)
        turning = masses[:, 1] * (_with_ones(rule.angles) @ fall[n:, 0])
        levers = rule.along @ line.slopes()
        if line.jumps is not None:
            levers = levers + line.jumps[0, :2]
        moments = _turn(levers, pulls) + turning
        loads = jnp.concatenate([pulls, moments[:, None]], axis=1).reshape(-1, len(rule.inner), 3)
        wrench = wrench + rule.pieces.beyond(legendre_coefficients(rule.inner), loads, place)
    (x, y), bending = wrench[:2], wrench[2] - _turn(part.to_end(), wrench[:2])
    # The y axis of the section points into the plane: a moment about it turns clockwise.
    zero = jnp.zeros_like(x)
    return jnp.stack([cosine * x + sine * y, zero, cosine * y - sine * x, zero, -bending, zero])


def _thermal(change: Array, gradient: Array, *, ref, section, order, shear, curvature=None):
    """Thermal elongation and curvature; the warmer side becomes longer."""
    bends = {"EIy": -gradient[0]}
    return thermal_series(change, bends, section, order, _length(ref, curvature), CLOSURE, _names(shear))


def _shape(*nodes: Array, ref, place, order, shear=False, section=None, curvature=None):
    p, rot_p, *_, c = nodes
    line = PlanarLine(c, ref, order, shear, section, curvature)
    return p + line.axes(rot_p) @ line.up_to(place).to_end()


def _end_pose(*nodes: Array, ref, order, shear, section=None, curvature=None):
    """Pose of end q relative to end p."""
    line = PlanarLine(nodes[-1], ref, order, shear, section, curvature)
    turn = ref.rot_q - ref.rot_p + line.rule.turn @ line.fields[CURVATURE]
    return line.rule.weights @ line.turned_slopes(-ref.rot_p[0]), turn


def _check(*, ref, order, shear, section=None, curvature=None) -> list[str]:
    faults = beams.check_length(ref=ref) or check_curvature(ref, curvature)
    faults = faults or check_section(section, ref, curvature, gauss_nodes(order))
    if section is None or faults:
        return faults
    return check_shear(shear, section_rigidities(section, ref, curvature).shear_z)


spectral_beam = Element(
    _spectral_beam,
    stiffness=_stiffness,
    damping=_damping,
    inertia=_inertia,
    resultants=_resultants,
    thermal=_thermal,
    shape=_shape,
    passage=_end_pose,
    check=_check,
    series=_fields,
    lengths=(ELONGATION, SHEAR),
    names=("closure_x", "closure_y", "closure_tilt", "elongation", "curvature", "shear"),
)
"""Geometrically exact beam; one element models a whole leaf spring in beam theory.

Deformations:
    1 to 3: the closure at q, FIXED: two displacements in axes of end p [m], and the angle [rad]. Their stress
        resultants are the force and moment at q.
    From 4 on: ``order`` coefficients of each strain, times length: elongation [m], then curvature [rad], then, with
        ``shear``, shear [m]. The first coefficient of the curvature is the angle between the ends.

Properties:
    section: EA, EIy, mass and Jy. It may vary, see :class:`flexmb.sections.Profile`.
    damping: Viscous damping of the section.
    curvature: Curvature of the undeformed beam [1/m], positive counter-clockwise. A number is an arc from p to q.
        Otherwise it is a function of the place, or :func:`flexmb.sections.curvature_through`.

Options: order, the number of coefficients of each strain, default 5; shear, whether shear deformation is counted,
default False. Order 2 bends like a cubic beam. Order 5 computes a leaf spring at a large stroke to six digits. With
shear the section must have a shear compliance.

The beam neglects the plate behaviour near clamps and the flattening of wide strips; use ``planar.leaf_spring`` for
them. If shear would change a stiffness by more than 1 %, flexmb warns.

Source: strains of the extensible elastica; theta(s) = integral of the curvature, r' = (1 + eps) t + gamma n with
t = (cos theta, sin theta), n normal to it (Reissner).
"""
