"""Rods in motion, written apart from flexmb and never importing it: Reissner's and Simo's rod, strains as series.

The strains (curvature, extension, shear) of a rod are polynomials of the arc length, and their coefficients q are the
unknowns. Position and rotation follow by integration along the rod, r' = R gamma, so that they and their velocities are
exact functions of q and the motion of the base; integrals use Gauss points, where integration along the rod is a
matrix. Virtual work then gives M(z) z'' = f(t, z, z') in z = (base, q), in which no term is dropped.
"""

import dataclasses
from math import inf

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike

AFTER, BEFORE = [1, 2, 0], [2, 0, 1]


@dataclasses.dataclass(frozen=True)
class Grid:
    """Gauss points of a rod and the matrix that integrates along it.

    Attributes:
        shapes: Legendre polynomials at the Gauss points, (n_terms, n_points).
        weights: Of the Gauss points and zeros for the stations, (n_points + n_stations,).
        integral: From values at the Gauss points to integrals from the base to these and the stations.
        squares: Integrals of the squared polynomials, (n_terms,).
    """

    shapes: np.ndarray
    weights: np.ndarray
    integral: np.ndarray
    squares: np.ndarray

    @classmethod
    def of(cls, length: float, terms: int, points: int, stations: ArrayLike) -> "Grid":
        """Grid of a rod.

        Args:
            length: Of the rod.
            terms: Of each strain.
            points: Of Gauss.
            stations: Further places of interest, fractions of the length; the end comes last.
        """
        x, w = legendre.leggauss(points)
        places = np.concatenate([x, 2 * np.asarray(stations, float) - 1])
        transform = (legendre.legvander(x, points - 1) * w[:, None]).T * (np.arange(points) + 0.5)[:, None]
        antiderivatives = legendre.legint(np.eye(points), lbnd=-1)
        integral = length / 2 * legendre.legvander(places, points) @ antiderivatives @ transform
        degrees = np.arange(terms)
        return cls(
            shapes=legendre.legvander(x, terms - 1).T,
            weights=np.concatenate([length / 2 * w, np.zeros(len(places) - points)]),
            integral=integral,
            squares=length / (2 * degrees + 1),
        )


@dataclasses.dataclass(frozen=True)
class Field:
    """Motion of all points of a rod, planar or spatial, linear in the rates of z; last axis of the Jacobians is z.

    Attributes:
        r: Positions, (n, d).
        v: Velocities, (n, d).
        a: Accelerations at z'' = 0, (n, d).
        J: Jacobian of the velocities, (n, d, n_z).
    """

    r: np.ndarray
    v: np.ndarray
    a: np.ndarray
    J: np.ndarray

    def end(self) -> "Field":
        """Its last point alone."""
        return Field(self.r[-1:], self.v[-1:], self.a[-1:], self.J[-1:])


class PlanarRod:
    """A straight planar rod; z = (x, y, angle of the base; curvature, extension, shear strain coefficients).

    r' = (1 + extension) d(theta) + shear n(theta), theta' = curvature. A stiffness of inf leaves its strain out.

    Args:
        length: Of the rod.
        EI: Bending stiffness.
        mass: Per length.
        EA: Extensional stiffness.
        GA: Shear stiffness.
        rotary: Rotary inertia per length.
        terms: Of each strain's series.
        stations: Where Field is wanted beside the Gauss points, fractions of the length; the end is the last.
    """

    def __init__(self, length, EI, mass, EA=inf, GA=inf, rotary=0.0, terms=6, stations=(0.5, 1.0)):
        self.length, self.mass, self.rotary, self.terms = length, mass, rotary, terms
        self.grid = Grid.of(length, terms, 2 * terms + 8, stations)
        self.kinds = [kind for kind, stiffness in (("EI", EI), ("EA", EA), ("GA", GA)) if stiffness < inf]
        finite = [stiffness for stiffness in (EI, EA, GA) if stiffness < inf]
        self.stiffness = np.concatenate([stiffness * self.grid.squares for stiffness in finite])
        self.n_q = len(self.stiffness)

    def place(self, q: np.ndarray) -> np.ndarray:
        """End of the rod seen from its base, (2,)."""
        curvature, extension, shear = (self.strain(k, q) for k in ("EI", "EA", "GA"))
        theta = self.grid.integral[: len(curvature)] @ curvature
        c, s = np.cos(theta), np.sin(theta)
        return self.grid.integral[-1] @ np.stack([(1 + extension) * c - shear * s, (1 + extension) * s + shear * c], 1)

    def strain(self, kind: str, q: np.ndarray) -> np.ndarray:
        """A strain, or its rate, at the Gauss points."""
        if kind not in self.kinds:
            return np.zeros(self.grid.shapes.shape[1])
        at = self.kinds.index(kind) * self.terms
        return q[at : at + self.terms] @ self.grid.shapes

    def field(self, z: np.ndarray, zd: np.ndarray) -> tuple[Field, Field]:
        """Positions and angles; angles as a Field of one dimension."""
        S, shapes, points = self.grid.integral, self.grid.shapes, self.grid.shapes.shape[1]
        (curvature, extension, shear), rates = ([self.strain(k, y[3:]) for k in ("EI", "EA", "GA")] for y in (z, zd))
        theta, turning = z[2] + S @ curvature, zd[2] + S @ rates[0]
        d = np.stack([np.cos(theta), np.sin(theta)], axis=-1)[:points]
        n = np.stack([-d[:, 1], d[:, 0]], axis=-1)
        w = turning[:points, None]
        # r' and its derivative by theta, both along the rod.
        along, across = [(1 + extension)[:, None] * p + shear[:, None] * m for p, m in ((d, n), (n, -d))]
        stretching, shearing = (
            rates[1][:, None] * d + rates[2][:, None] * n,
            rates[1][:, None] * n - rates[2][:, None] * d,
        )
        J = np.zeros((len(S), 2, len(z)))
        K = np.zeros((len(S), 1, len(z)))
        J[:, 0, 0] = J[:, 1, 1] = K[:, 0, 2] = 1.0
        J[:, :, 2] = S @ across
        K[:, 0, 3 : 3 + self.terms] = S @ shapes.T
        columns = {"EI": (across, K[:points, 0, 3 : 3 + self.terms]), "EA": (d, shapes.T), "GA": (n, shapes.T)}
        for i, kind in enumerate(self.kinds):
            vectors, scalars = columns[kind]
            at = 3 + i * self.terms
            J[:, :, at : at + self.terms] = np.tensordot(S, vectors[:, :, None] * scalars[:, None, :], 1)
        positions = Field(
            r=z[:2] + S @ along,
            v=zd[:2] + S @ (w * across + stretching),
            a=S @ (2 * w * shearing - w**2 * along),
            J=J,
        )
        return positions, Field(theta[:, None], turning[:, None], np.zeros((len(S), 1)), K)

    def equations(self, z: np.ndarray, zd: np.ndarray) -> tuple[np.ndarray, np.ndarray, Field, Field]:
        """Mass matrix and force: M z'' = force, without supports and loads; and both fields."""
        positions, angles = self.field(z, zd)
        M, force = np.zeros((len(z), len(z))), np.zeros(len(z))
        for field, density in ((positions, self.mass), (angles, self.rotary)):
            J = field.J.reshape(-1, len(z))
            w = np.repeat(density * self.grid.weights, field.J.shape[1])
            M += (J.T * w) @ J
            force -= J.T @ (w * field.a.ravel())
        force[3:] -= self.stiffness * z[3:]
        return M, force, positions, angles


def right_product(u: np.ndarray) -> np.ndarray:
    """Matrices (n, 4, 4) of p -> p (0, u), quaternions with the scalar first; u (n, 3)."""
    x, y, z = u.T
    o = np.zeros_like(x)
    return np.array([[o, -x, -y, -z], [x, o, z, -y], [y, -z, o, x], [z, y, -x, o]]).transpose(2, 0, 1)


def left_product(u: np.ndarray) -> np.ndarray:
    """Matrix (4, 4) of p -> (0, u) p."""
    x, y, z = u
    return np.array([[0, -x, -y, -z], [x, 0, -z, y], [y, z, 0, -x], [z, -y, x, 0]])


def matrices(p: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3) of quaternions (n, 4), whose length drops out."""
    w, x, y, z = (p / np.sqrt((p**2).sum(-1, keepdims=True))).T
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vector products along axis 1, the shapes broadcast."""
    return a[:, AFTER] * b[:, BEFORE] - a[:, BEFORE] * b[:, AFTER]


@dataclasses.dataclass(frozen=True)
class Frames:
    """Motion of the section frames of points of a rod.

    Attributes:
        R: Rotation matrices, axis of the rod first, (n, 3, 3).
        w: Angular velocities in space, (n, 3).
        a: Angular accelerations at z'' = 0, (n, 3).
        J: Jacobian of the angular velocities, (n, 3, n_z).
    """

    R: np.ndarray
    w: np.ndarray
    a: np.ndarray
    J: np.ndarray

    def end(self) -> "Frames":
        """Its last point alone."""
        return Frames(self.R[-1:], self.w[-1:], self.a[-1:], self.J[-1:])

    def turned(self, rotation: np.ndarray) -> "Frames":
        """Frames fixed to these, turned by a constant rotation within them."""
        return dataclasses.replace(self, R=self.R @ rotation)


class SpatialRod:
    """A straight rod in space; q = coefficients of curvatures (twist, about y, about z) and stretches (axis, y, z).

    r' = R (e1 + stretches), R' = R hat(curvatures).

    Args:
        length: Of the rod.
        bending: GJ, EIy, EIz.
        stretching: EA, GAy, GAz.
        mass: Per length.
        rotary: Rotary inertia per length about the axes of the section, the rod's own first.
        terms: Of each strain's series.
        stations: Where Field is wanted beside the Gauss points, fractions of the length; the end is the last.
    """

    def __init__(self, length, bending, stretching, mass, rotary, terms=6, stations=(1.0,)):
        self.length, self.mass, self.rotary, self.terms = length, mass, np.array(rotary, float), terms
        self.grid = Grid.of(length, terms, 2 * terms + 8, stations)
        self.stiffness = np.outer([*bending, *stretching], self.grid.squares).ravel()
        self.n_q = 6 * terms

    def field(self, r0: Field, R0: Frames, q: np.ndarray, qd: np.ndarray, at: int) -> tuple[Field, Frames]:
        """Positions and frames of the rod's points, from those of its base; q has the columns from `at` on."""
        S, shapes, points = self.grid.integral, self.grid.shapes, self.grid.shapes.shape[1]
        kappa, gamma = np.split((q.reshape(6, -1) @ shapes).T, 2, axis=1)
        kappa_d, gamma_d = np.split((qd.reshape(6, -1) @ shapes).T, 2, axis=1)
        gamma = gamma + np.array([1.0, 0.0, 0.0])
        # p' = p (0, kappa)/2 by collocation: one linear system for all points.
        half = right_product(kappa) / 2
        steps = S[:points, None, :, None] * half.transpose(1, 0, 2)
        system = np.eye(4 * points) - steps.reshape(4 * points, -1)
        one = np.array([1.0, 0.0, 0.0, 0.0])
        p = np.linalg.solve(system, np.tile(one, points)).reshape(-1, 4)
        R = R0.R[0] @ matrices(one + S @ (half @ p[:, :, None])[:, :, 0])
        inside = R[:points]
        stretch, stretch_d, bend_d = ((inside @ u[:, :, None])[:, :, 0] for u in (gamma, gamma_d, kappa_d))
        w = R0.w + S @ bend_d
        aw = R0.a + S @ cross(w[:points], bend_d)
        wi = w[:points]
        v = r0.v + S @ (stretch_d + cross(wi, stretch))
        a = r0.a + S @ (cross(wi, 2 * stretch_d + cross(wi, stretch)) + cross(aw[:points], stretch))
        # Columns of the angular velocity: those of the base, and integrals of R e_j times each polynomial.
        axes = (inside[:, :, :, None] * shapes.T[:, None, None, :]).reshape(points, 3, -1)
        Jw = np.repeat(R0.J, len(S), axis=0)
        bends, stretches = slice(at, at + 3 * self.terms), slice(at + 3 * self.terms, at + 6 * self.terms)
        Jw[:, :, bends] += np.tensordot(S, axes, 1)
        slope = cross(Jw[:points], stretch[:, :, None])
        slope[:, :, stretches] += axes
        Jr = r0.J + np.tensordot(S, slope, 1)
        return Field(r0.r + S @ stretch, v, a, Jr), Frames(R, w, aw, Jw)

    def inertia(self, positions: Field, frames: Frames) -> tuple[np.ndarray, np.ndarray]:
        """Mass matrix and inertia force at z'' = 0 of the rod."""
        n_z = positions.J.shape[-1]
        weights = np.repeat(self.grid.weights, 3)
        back = frames.R.transpose(0, 2, 1)
        w, aw = ((back @ u[:, :, None])[:, :, 0] for u in (frames.w, frames.a))
        moment = self.rotary * aw + cross(w, self.rotary * w)
        Jr, Jw = positions.J.reshape(-1, n_z), (back @ frames.J).reshape(-1, n_z)
        densities = self.mass * weights, np.tile(self.rotary, len(w)) * weights
        M = (Jr.T * densities[0]) @ Jr + (Jw.T * densities[1]) @ Jw
        return M, -Jr.T @ (densities[0] * positions.a.ravel()) - Jw.T @ (weights * moment.ravel())


def at_rest(r: ArrayLike, R: ArrayLike, n_z: int) -> tuple[Field, Frames]:
    """A base that stands still.

    Args:
        r: Its position, (3,).
        R: Its frame, axis of the rod first, (3, 3).
        n_z: Number of unknowns.
    """
    none, columns = np.zeros((1, 3)), np.zeros((1, 3, n_z))
    return Field(np.array(r, float)[None], none, none, columns), Frames(np.array(R, float)[None], none, none, columns)
