"""Initial curvature and twist of beams: numbers, functions of the place along a beam, or a curve through points."""

import contextlib
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_reals, check_numbers, holds, is_concrete, short_repr
from ..compilation.record import Record
from ..errors import ModelError
from ..math.quadrature import gauss, legendre_coefficients, legendre_integrals, legendre_values, lobatto
from ..math.rigid import chain, compose_turns, screws
from ..math.rotation import CONJUGATE, initial_frame, rotation_matrix, rotation_plane
from ..numerical_limits import PARALLEL, SAME_END, SAME_LINE, SMOOTH_CURVE

# Legendre coefficients of a curve, and Gauss nodes for its ends in the plane.
COUNT, NODES = 20, 40
# Places at which a curve is compared with its function, and number of samples of a curve through points.
LOOKED_AT, FINE = np.linspace(0.0, 1.0, 101), 2000
# Newton's steps from the chord to the length of a curve.
STEPS = 40


class CurvedLine(Record):
    """Initial curvature along a beam, from the first node to the last.

    Create it by :func:`curvature_along` or :func:`curvature_through`.

    Attributes:
        coefficients: Legendre coefficients over the place from 0 to 1. In the plane: curvature, counter-clockwise,
            (20,) [1/m]. In space: twist and curvatures about local y and z, (20, 3) [1/m].
        to_middle: Vector from the first point to the middle of a curve through points, (d,) [m]; otherwise None.
        to_end: Vector from the first point to the last of a curve through points, (d,) [m]; otherwise None.

    Source:
        THEORY.md 2, eq. (2.43).
    """

    coefficients: Any
    to_middle: Any = None
    to_end: Any = None

    def at(self, places: Any) -> Float[Array, "n *k"]:
        """Return the curvature at places, (n,), in space twist and curvatures, (n, 3) [1/m]."""
        return legendre_values(COUNT, places) @ self.coefficients


def curvature_along(function: Callable[[float], Any]) -> CurvedLine:
    """Return an initial curvature from a function of the place along a beam.

    The nodes at both ends and the curvature determine the length and the directions of the beam. The chord of the curve
    goes from the first node to the last. In space, flexmb first finds local y as for a straight beam between these
    nodes. It then turns local y by the smallest rotation from the chord to the first tangent.

    Args:
        function: ``f(place)``, with the place from 0 at the first end to 1 at the last. In the plane it returns the
            curvature, counter-clockwise, () [1/m]. In space it returns twist and curvatures about local y and z, (3,)
            [1/m]. It must be smooth; its numbers may be traced.

    Returns:
        The property ``curvature`` of a beam.

    Raises:
        ModelError: The function does not return one or three numbers, or is not smooth.
    """
    if not callable(function):
        raise ModelError(
            f"The curvature of a beam must be a function of the place from 0 to 1, not {short_repr(function)}."
        )
    nodes = gauss(COUNT)[0]
    values = [as_reals("The curvature of a beam", function(float(place)), ModelError) for place in nodes]
    if any(np.shape(value) not in ((), (3,)) for value in values):
        raise ModelError(
            "The curvature of a beam must be one number in the plane, three numbers in space, but has the shape"
            f" {np.shape(values[0])}."
        )
    library: Any = np if is_concrete(values) else jnp
    curve = CurvedLine(
        legendre_coefficients(nodes) @ library.stack([library.asarray(value, float) for value in values])
    )
    if library is np:
        samples = np.array([function(float(place)) for place in LOOKED_AT], float)
        if np.max(np.abs(samples - curve.at(LOOKED_AT))) > SMOOTH_CURVE * np.max(np.abs(samples)):
            raise ModelError(
                "The curvature of a beam is not smooth enough along it: make a beam of each smooth piece, and join the"
                " beams at nodes."
            )
    return curve


def curvature_through(points: Any, y: Any = None) -> CurvedLine:
    """Return the initial curvature of a beam through points, by a spline of degree five or less.

    Place the nodes of the beam at the first point and at the last. Fewer than six points have a lower degree.

    Args:
        points: At least three points from the first end to the last, (n, 2) in the plane, (n, 3) in space [m].
        y: In space the property ``y`` of the beam, a vector that fixes local y, (3,). The section does not twist along
            the curve.

    Returns:
        The property ``curvature`` of a beam.

    Raises:
        ModelError: There are fewer than three points; points coincide or are traced; the curve bends too sharply for
            one beam; ``y`` in the plane; ``y`` that is zero or parallel to the beginning of the curve.
    """
    if not is_concrete((points, y)):
        raise ModelError("The points of a curve must be known numbers: give a function to curvature_along instead.")
    knots: Any = np.zeros(0)
    with contextlib.suppress(TypeError, ValueError):
        knots = np.asarray(points, float)
    if knots.ndim != 2 or len(knots) < 3 or knots.shape[1] not in (2, 3) or not np.all(np.isfinite(knots)):
        raise ModelError(f"A curve needs at least three points, (n, 2) or (n, 3), not {short_repr(points)}.")
    across = None
    if y is not None:
        if knots.shape[1] == 2:
            raise ModelError("A curve in the plane takes no `y`.")
        check_numbers("`y` of a curve", y, (3,), ModelError)
        across = np.asarray(y, float)
    away = np.linalg.norm(np.diff(knots, axis=0), axis=1)
    if np.min(away) <= 0:
        raise ModelError("Two successive points of a curve coincide.")
    if across is not None:
        sine = np.linalg.norm(np.cross(knots[1] - knots[0], across))
        if not sine > PARALLEL * away[0] * np.linalg.norm(across):
            raise ModelError("`y` of a curve is zero or parallel to its first direction: give a vector across it.")
    reached, values = _sampled(knots, np.concatenate([[0], np.cumsum(away)]), across)
    curve = CurvedLine(legendre_coefficients(gauss(COUNT)[0]) @ values)
    length = float(np.asarray(curve_length(np.linalg.norm(knots[-1] - knots[0]), curve)))
    chord = knots[-1] - knots[0]
    middle = np.asarray(to_middle(curve, chord, length, across))
    at_middle = np.array([np.interp(0.5, reached[0], x) for x in reached[1:]]) - knots[0]
    if not np.linalg.norm(middle - at_middle) <= SAME_LINE * length:
        raise ModelError("A curve through points bends too sharply for one beam: use several beams.")
    return CurvedLine(curve.coefficients, at_middle, chord)


def _sampled(points: np.ndarray, at: np.ndarray, y: Any) -> tuple[np.ndarray, np.ndarray]:
    """Places and points along a spline, (1 + d, n), and its curvature at the Gauss nodes of its length."""
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(at, points, k=min(5, len(points) - 1))
    s = np.linspace(0, at[-1], FINE + 1)
    first, second = spline(s, 1), spline(s, 2)
    speed = np.linalg.norm(first, axis=1)
    inner, weights = gauss(6)
    steps = np.linalg.norm(spline((s[:-1, None] + np.diff(s)[:, None] * inner).ravel(), 1), axis=1)
    length = np.concatenate([[0], np.cumsum(np.diff(s) * (steps.reshape(-1, 6) @ weights))])
    places = length / length[-1]
    tangents = first / speed[:, None]
    if points.shape[1] == 2:
        bends = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
    else:
        # A frame that does not turn about the curve, by two reflections per step (Wang et al. 2008).
        frame = initial_frame(jnp.asarray(points[0]), jnp.asarray(points[-1]), None if y is None else jnp.asarray(y))
        across = np.asarray(frame)
        d = across.T @ tangents[0]
        across = across @ np.asarray(rotation_matrix(_least_turn(jnp.asarray(d))))[:, 1]
        directions, line = [across], spline(s)
        for i in range(FINE):
            v = line[i + 1] - line[i]
            back, turned = (vector - 2 / (v @ v) * (v @ vector) * v for vector in (directions[-1], tangents[i]))
            w = tangents[i + 1] - turned
            directions.append(back - (2 / (w @ w) * (w @ back) * w if w @ w > 0 else 0.0))
        ys = np.array(directions)
        change = (second - tangents * np.sum(second * tangents, axis=1)[:, None]) / speed[:, None] ** 2
        about_z, about_y = np.sum(change * ys, axis=1), -np.sum(change * np.cross(tangents, ys), axis=1)
        bends = np.stack([np.zeros_like(about_y), about_y, about_z], axis=1)
    smooth = make_interp_spline(places, bends, k=3)
    return np.concatenate([places[None], spline(s).T]), smooth(gauss(COUNT)[0])


# -- questions of beams ----------------------------------------------------------------------------------------------


def curvature_at(curvature: Any, places: Any) -> Any:
    """Return the initial curvature at places, (n,) or (n, 3) [1/m]."""
    if isinstance(curvature, CurvedLine):
        return curvature.at(places)
    curvature = jnp.asarray(curvature, float)
    return jnp.broadcast_to(curvature, (len(places), *curvature.shape))


def turned_to(curvature: Any, length: Any, places: Any) -> Any:
    """Return the angle in the plane from the first end to places, (n,) [rad]."""
    if not isinstance(curvature, CurvedLine):
        return curvature * length * places
    return length * (legendre_integrals(COUNT, places) @ curvature.coefficients)


def curve_length(chord: Any, curvature: Any, steps: int = 8) -> Any:
    """Return the length of a beam with initial curvature from its chord, () [m].

    Source: THEORY.md 2, eq. (2.43); Newton's method on the length.

    Args:
        steps: Number of steps of a beam in space, see :func:`pose_steps`.
    """
    if curvature is None:
        return chord
    if not isinstance(curvature, CurvedLine):
        # In the plane with its sign, so that it is differentiable everywhere.
        size = curvature if jnp.ndim(curvature) == 0 else jnp.sqrt(curvature @ curvature)
        return arc_length(chord, size * chord / 2)

    def newton(length: Float[Array, ""], coefficients: Any, chord: Any) -> Float[Array, ""]:
        def gap(length: Float[Array, ""]):
            end = _end(coefficients, length, steps)
            return jnp.sqrt(end @ end) - chord

        value, slope = jax.jvp(gap, (length,), (jnp.ones_like(length),))
        return length - value / slope

    chord = jnp.asarray(chord, float)
    known = jax.lax.stop_gradient((jnp.asarray(curvature.coefficients, float), chord))
    length = jax.lax.fori_loop(0, STEPS, lambda _, length: newton(length, *known), known[1])
    # Each of these steps doubles the number of correct derivatives.
    for _ in range(2):
        length = newton(length, curvature.coefficients, chord)
    return length


def curved_length(chord: Any, curvature: Any, steps: int | None = None) -> Any:
    """Return the length of a beam from its chord, in space with its number of steps, () [m]."""
    if isinstance(curvature, CurvedLine) and (curvature.coefficients.ndim == 1) is not (steps is None):
        raise ModelError("the curvature has one number per place in the plane, three in space")
    return curve_length(chord, curvature, steps or 8)


def arc_length(chord: Any, half: Any) -> Float[Array, ""]:
    """Return the length of an arc over a chord [m]; ``half`` is half the curvature times the chord [-]."""
    return chord * jnp.arcsin(half) / half


def tilt_of(curvature: Any, length: Any) -> Float[Array, ""]:
    """Return the angle in the plane from the first direction of a beam to its chord, () [rad]."""
    if not isinstance(curvature, CurvedLine):
        return curvature * length / 2
    x, y = _end(curvature.coefficients, length)
    return jnp.arctan2(y, x)


def turns_of_ends(curvature: Any, length: Any, steps: int = 8) -> tuple[Float[Array, "4"], Float[Array, "4"]]:
    """Return Euler parameters of the frame of the chord relative to the first end, and of the last end to the chord."""
    if not isinstance(curvature, CurvedLine):
        half = chain(jnp.concatenate([curvature * length / 2, jnp.zeros(3)])[None]).turns[1]
        return half, half
    line = chain(_motions(curvature.coefficients, length, steps))
    end = line.places[-1]
    first = _least_turn(end / jnp.sqrt(end @ end))
    return first, compose_turns(first * CONJUGATE, line.turns[-1])


def axes_of_end(curvature: Any, chord: Any, y: Any, end: int) -> tuple[Any, Any]:
    """Return direction and local y of a curved beam at its first end (0) or last (1); y is (1,) in the plane."""
    if len(chord) == 2:
        length = curve_length(jnp.sqrt(chord @ chord), curvature)
        angle = turned_to(curvature, length, np.array([float(end)]))[0] - tilt_of(curvature, length)
        return rotation_plane(angle) @ chord / jnp.sqrt(chord @ chord), np.ones(1)
    axes = frames_of_ends(curvature, chord, y)[end]
    return axes[:, 0], axes[:, 1]


def frames_of_ends(curvature: Any, chord: Any, y: Any) -> Float[Array, "2 3 3"]:
    """Return the section axes of a beam in space at its first end and at its last, as columns."""
    first, last = turns_of_ends(curvature, curve_length(jnp.sqrt(chord @ chord), curvature))
    frame = initial_frame(jnp.zeros(3), chord, y)
    return jnp.stack([frame @ rotation_matrix(first).T, frame @ rotation_matrix(last)])


def to_middle(curve: CurvedLine, chord: Any, length: Any, y: Any) -> Any:
    """Return the vector from the first end of a beam to its middle, (d,) [m]."""
    if len(chord) == 2:
        nodes, weights = gauss(NODES)
        angles = turned_to(curve, length, nodes / 2) - tilt_of(curve, length)
        along = chord / jnp.sqrt(chord @ chord)
        x, y = weights @ jnp.cos(angles) * length / 2, weights @ jnp.sin(angles) * length / 2
        return x * along + y * jnp.stack([-along[1], along[0]])
    first, _ = turns_of_ends(curve, length)
    frame = initial_frame(jnp.zeros(3), jnp.asarray(chord, float), y)
    return frame @ rotation_matrix(first).T @ chain(_motions(curve.coefficients, length, end=0.5)).places[-1]


def _end(coefficients: Any, length: Any, steps: int = 8) -> Float[Array, "d"]:
    """Position of the last end of a beam in axes of the first, [m]."""
    if coefficients.ndim == 2:
        return chain(_motions(coefficients, length, steps)).places[-1]
    nodes, weights = gauss(NODES)
    angles = length * (legendre_integrals(COUNT, nodes) @ coefficients)
    return length * jnp.stack([weights @ jnp.cos(angles), weights @ jnp.sin(angles)])


def pose_steps(order: int) -> int:
    """Return the number of steps along a beam in space; each step is one exponential of the pose."""
    # The ends of the steps are the nodes for the mass: fewer steps would integrate it less accurately. Constant strains
    # have exact poses for any number of steps; six steps integrate the mass of an arc of 3 rad to 1e-10.
    return 6 if order == 1 else 8 * 2 ** max(0, int(np.ceil(np.log2(order / 6))))


def _motions(coefficients: Any, length: Any, steps: int = 8, end: float = 1.0) -> Float[Array, "steps 6"]:
    """Screw motions in space over the steps of a beam, up to a place."""
    ends = lobatto(steps + 1)[0] * end
    sizes = np.diff(ends)
    places = (ends[:-1, None] + sizes[:, None] * gauss(3)[0]).ravel()
    bends = (legendre_values(COUNT, places) @ coefficients).reshape(-1, 3, 3)
    straight = jnp.broadcast_to(jnp.eye(3)[0], bends.shape)
    return screws(jnp.concatenate([bends, straight], axis=2) * length, sizes)


def _least_turn(direction: Float[Array, "3"]) -> Float[Array, "4"]:
    """Euler parameters of the smallest rotation from the x axis to a direction."""
    x, y, z = direction
    return jnp.stack([1 + x, jnp.zeros_like(x), -z, y]) / jnp.sqrt(2 * (1 + x))


def faults_of_curve(ref: Any, curve: CurvedLine, y: Any = None) -> list[str]:
    """Return the faults of the initial curvature of one beam or of stacked beams between nodes."""
    chord = jnp.asarray(ref.q, float) - jnp.asarray(ref.p, float)

    def gaps(chord: Any, curve: CurvedLine, y: Any):
        size = jnp.sqrt(chord @ chord)
        length = curve_length(size, curve)
        end = _end(curve.coefficients, length)
        missed = jnp.abs(jnp.sqrt(end @ end) / size - 1) + jnp.where(length > 0, 0.0, jnp.inf)
        if curve.to_end is None:
            return missed, 0.0, 0.0
        off = curve.to_end - chord
        around = to_middle(curve, chord, length, y) - curve.to_middle
        return missed, jnp.sqrt(off @ off) / size, jnp.sqrt(around @ around) / size

    for _ in range(jnp.ndim(chord) - 1):
        gaps = jax.vmap(gaps)
    missed, off, around = gaps(chord, curve, None if y is None else jnp.asarray(y, float))
    if not holds(missed < SAME_END):
        return ["has an initial curvature that no curve between its ends has"]
    if not holds(off < SAME_LINE):
        return [
            "has an initial curvature through points whose ends do not match its nodes: put its nodes at the first and"
            " the last point"
        ]
    if not holds(around < 10 * SAME_LINE):
        return ["has an initial curvature through points with another y: give curvature_through the y of the element"]
    return []
