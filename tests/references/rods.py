"""Reference solver for elastic rods: shooting on the rod equations, written apart from flexmb and never importing it.

Rod of Reissner and Simo: section frame R = [t, y, z] along the arc length s of the undeformed axis, with
    r' = R (e1 + N/C_n),  N = R^T n,  C_n = (EA, GAy, GAz)        n' = -q (dead load per undeformed length)
    R' = R hat(kappa0 + M/C_m),  M = R^T m,  C_m = (GJ, EIy, EIz)  m' = -r' x n
n and m act on the part before the cut. A stiffness of inf leaves its strain out. Integrated by DOP853 at rtol 1e-12.

A problem (Cantilever, Hinged, Assembly) is solved by `shooting.solve` and its neighbours, which describe what it must
have. All functions take columns: states of shape (size, k), complex and analytic, so that k load cases or complex steps
run at once. Units: any consistent set.
"""

import dataclasses
from math import inf

import numpy as np
from references.shooting import NotConverged, jacobian
from scipy.integrate import DOP853

RTOL = 1e-12
INTERVALS = 12


def column(vector) -> np.ndarray:
    """A vector (n,) as one column (n, 1); columns stay."""
    vector = np.asarray(vector)
    return vector[:, None] if vector.ndim == 1 else vector


def cross(a, b) -> np.ndarray:
    """Vector product of columns (3, k)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def product(p, q) -> np.ndarray:
    """Quaternion product p q, scalar first, columns (4, k)."""
    scalar = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3]
    return np.concatenate([scalar[None], p[0] * q[1:] + q[0] * p[1:] + cross(p[1:], q[1:])])


def conjugate(q) -> np.ndarray:
    """Inverse of a unit quaternion."""
    return q * np.array([[1.0], [-1.0], [-1.0], [-1.0]])


def turned(q, v) -> np.ndarray:
    """R(q) v; the length of q drops out."""
    w, u = q[0], q[1:]
    uu = (u * u).sum(0)
    return ((w * w - uu) * v + 2 * (u * v).sum(0) * u + 2 * w * cross(u, v)) / (w * w + uu)


def quaternion(vector) -> np.ndarray:
    """Unit quaternion (4,) of a rotation vector (3,) [rad]."""
    angle = np.linalg.norm(vector)
    return np.r_[np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * np.asarray(vector, float)]


def matrix(q) -> np.ndarray:
    """Rotation matrix (3, 3) of a quaternion (4,)."""
    return turned(column(q), np.eye(3))


class Plane:
    """Geometry in the plane: a pose is (x, y, phi), a force has two entries and a moment one."""

    poses, forces, moments = 3, 2, 1

    @staticmethod
    def rotate(pose, v):
        c, s = np.cos(pose[2]), np.sin(pose[2])
        return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]])

    @classmethod
    def compose(cls, pose, offset):
        """Pose that lies at `offset` (a pose) in the frame `pose`."""
        return np.concatenate([pose[:2] + cls.rotate(pose, offset), pose[2:] + offset[2:]])

    @staticmethod
    def moment(r, f):
        return (r[0] * f[1] - r[1] * f[0])[None]

    @staticmethod
    def gap(pose, target):
        """Displacements and angle from `target` to `pose`."""
        return pose - target

    @staticmethod
    def moved(pose, shift, factor):
        """Pose (3, 1) displaced and turned by `factor` times `shift` (3,)."""
        return pose + column(shift) * factor

    @staticmethod
    def norm(pose):
        return pose[:0]

    @staticmethod
    def variations(pose):
        """Change of the pose (3,) by displacements and rotation, (3, 3)."""
        return np.eye(3)


class Space:
    """Geometry in space: a pose is a position and a unit quaternion, (7,)."""

    poses, forces, moments = 7, 3, 3

    @staticmethod
    def rotate(pose, v):
        return turned(pose[3:], v)

    @classmethod
    def compose(cls, pose, offset):
        return np.concatenate([pose[:3] + turned(pose[3:], offset[:3]), product(pose[3:], offset[3:])])

    @staticmethod
    def moment(r, f):
        return cross(r, f)

    @staticmethod
    def gap(pose, target):
        """Displacements and, to first order, rotations from `target` to `pose`."""
        turn = product(pose[3:], conjugate(target[3:]))
        return np.concatenate([pose[:3] - target[:3], 2 * turn[1:]])

    @staticmethod
    def moved(pose, shift, factor):
        """Pose (7, 1) displaced and turned by `factor` times `shift` (6,), its last three a rotation vector."""
        angle = np.linalg.norm(shift[3:]) or 1.0
        half = angle * factor / 2
        spin = np.concatenate([np.cos(half)[None], column(shift[3:] / angle) * np.sin(half)])
        return np.concatenate([pose[:3] + column(shift[:3]) * factor, product(spin, pose[3:])])

    @staticmethod
    def norm(pose):
        return (pose[3:] ** 2).sum(0)[None] - 1

    @staticmethod
    def variations(pose):
        """Change of the pose (7,) by displacements and spatial rotations, (7, 6): dq = (0, dtheta) q / 2."""
        result = np.zeros((7, 6))
        result[:3, :3] = np.eye(3)
        result[3:, 3:] = product(np.eye(4)[:, 1:] / 2, np.repeat(column(pose[3:]), 3, 1))
        return result


def march(rates, length, state, size):
    """Integrate columns `state` (n, k) over `length`; `size` (n, 1) is what one unit of each row is."""
    shape = state.shape

    def flat(s, y):
        return rates(s, y.reshape(shape)).ravel()

    atol = np.broadcast_to(0.1 * RTOL * size, shape).ravel()
    # The error control sees no imaginary parts: a straight state would be crossed in one step, its derivatives wrong.
    longest = length / INTERVALS
    solver = DOP853(flat, 0.0, state.ravel(), length, rtol=RTOL, atol=atol, max_step=longest)
    steps = 0
    while solver.status == "running" and steps < 30 * INTERVALS:  # more only where Newton went astray
        solver.step()
        steps += 1
    if solver.status != "finished" or not np.isfinite(solver.y).all():
        raise NotConverged("the integration broke down")
    return solver.y.reshape(shape)


@dataclasses.dataclass(frozen=True)
class PlanarRod:
    """Rod in the plane, state (x, y, phi, m): an elastica with extension and shear; `load` is q, (2,)."""

    length: float
    EI: float = 1.0
    EA: float = inf
    GA: float = inf
    curvature: float = 0.0
    load: tuple[float, ...] = (0.0, 0.0)
    space = Plane

    def march(self, pose, n, m, factor=1.0):
        """Pose, force and moment at the end from those at the start, columns; q is multiplied by `factor`."""
        q = column(self.load) * factor

        def rates(s, state):
            c, sn = np.cos(state[2]), np.sin(state[2])
            nx, ny = n - q * s
            a, b = 1 + (c * nx + sn * ny) / self.EA, (c * ny - sn * nx) / self.GA
            dx, dy = c * a - sn * b, sn * a + c * b
            return np.array([dx, dy, state[3] / self.EI + self.curvature, dy * nx - dx * ny])

        size = np.array([[self.length], [self.length], [1.0], [self.EI / self.length]])
        end = march(rates, self.length, np.concatenate([pose, m]), size)
        return end[:3], n - q * self.length, end[3:]

    @property
    def scale(self):
        """Size of a force and of a moment: EI/L^2, EI/L."""
        return self.EI / self.length**2, self.EI / self.length


@dataclasses.dataclass(frozen=True)
class SpatialRod:
    """Rod in space, state (r, quaternion, m); `curvature` is kappa0 (3,), `load` is q (3,)."""

    length: float
    GJ: float = 1.0
    EIy: float = 1.0
    EIz: float = 1.0
    EA: float = inf
    GAy: float = inf
    GAz: float = inf
    curvature: tuple[float, ...] = (0.0, 0.0, 0.0)
    load: tuple[float, ...] = (0.0, 0.0, 0.0)
    space = Space

    def march(self, pose, n, m, factor=1.0):
        """Pose, force and moment at the end from those at the start, columns; q is multiplied by `factor`."""
        q = column(self.load) * factor
        stretch = 1 / column([self.EA, self.GAy, self.GAz])
        bend = 1 / column([self.GJ, self.EIy, self.EIz])
        along, kappa0 = column([1.0, 0.0, 0.0]), column(self.curvature)
        rigid = not stretch.any()

        def rates(s, state):
            turn, force = state[3:7], n - q * s
            back = conjugate(turn)
            strain = along if rigid else along + stretch * turned(back, force)
            dr = turned(turn, strain)
            kappa = bend * turned(back, state[7:]) + kappa0
            spin = product(turn, np.concatenate([np.zeros_like(kappa[:1]), kappa])) / 2
            return np.concatenate([dr, spin, cross(force, dr)])

        size = column([self.length] * 3 + [1.0] * 4 + [self.scale[1]] * 3)
        end = march(rates, self.length, np.concatenate([pose, m]), size)
        return end[:7], n - q * self.length, end[7:]

    @property
    def scale(self):
        """Size of a force and of a moment, by the weaker bending stiffness."""
        weak = min(self.EIy, self.EIz)
        return weak / self.length**2, weak / self.length


@dataclasses.dataclass(frozen=True)
class Chain:
    """Rods rigidly joined end to end: (rod, offset pose to the next start, dead force on the joint), in order."""

    parts: tuple

    def march(self, pose, n, m, factor=1.0):
        for rod, offset, force in self.parts:
            pose, n, m = rod.march(pose, n, m, factor)
            n = n - column(force) * factor
            pose = self.space.compose(pose, np.repeat(column(offset), pose.shape[1], 1))
        return pose, n, m

    @property
    def space(self):
        return self.parts[0][0].space

    @property
    def length(self):
        return sum(rod.length for rod, *_ in self.parts)

    @property
    def scale(self):
        force, moment = np.min([rod.scale for rod, *_ in self.parts], axis=0)
        return force, moment


@dataclasses.dataclass(frozen=True)
class Cantilever:
    """Rod or chain clamped at `root` (a pose); at its tip dead force and fixed-axis moment, and follower ones in the
    frame of the tip. All grow with the load factor, and so does q. Unknowns: force and moment at the root."""

    rod: PlanarRod | SpatialRod | Chain
    root: tuple[float, ...]
    force: tuple[float, ...] | None = None
    moment: tuple[float, ...] | None = None
    follower_force: tuple[float, ...] | None = None
    follower_moment: tuple[float, ...] | None = None

    def end(self, z):
        """Pose, force and moment at the tip, columns."""
        forces, k = self.rod.space.forces, z.shape[1]
        return self.rod.march(np.repeat(column(self.root), k, 1) + 0 * z[:1], z[:forces], z[forces:-1], z[-1])

    def residual(self, z):
        space = self.rod.space
        pose, n, m = self.end(z)
        for force, follows in ((self.force, False), (self.follower_force, True)):
            if force is not None:
                value = column(force) * z[-1]
                n = n - (space.rotate(pose, value) if follows else value)
        for moment, follows in ((self.moment, False), (self.follower_moment, space is Space)):
            if moment is not None:
                value = column(moment) * z[-1]
                m = m - (space.rotate(pose, value) if follows else value)
        return np.concatenate([n, m])

    def tip(self, z):
        """Pose of the tip (3,) or (7,)."""
        return self.end(column(z))[0][:, 0]

    @property
    def scale(self):
        force, moment = self.rod.scale
        return np.r_[np.full(self.rod.space.forces, force), np.full(self.rod.space.moments, moment), 1.0]

    @property
    def start(self):
        return np.zeros(self.scale.size)


@dataclasses.dataclass(frozen=True)
class Hinged:
    """Planar chain between two hinges, at `first` and `last` (positions). Unknowns: force and angle at the start,
    whose undeformed value is `angle`."""

    rod: Chain
    first: tuple[float, float]
    last: tuple[float, float]
    angle: float

    def begin(self, z):
        """Pose, force and moment at the start."""
        first = np.repeat(column(self.first), z.shape[1], 1) + 0 * z[:1]
        return np.concatenate([first, z[2:3]]), z[:2], 0 * z[:1]

    def residual(self, z):
        pose, _, m = self.rod.march(*self.begin(z), z[-1])
        return np.concatenate([pose[:2] - column(self.last), m])

    def joint(self, z, count):
        """Pose at the end of the first `count` parts, columns (3, k)."""
        return Chain(self.rod.parts[:count]).march(*self.begin(z), z[-1])[0]

    @property
    def scale(self):
        return np.array([self.rod.scale[0]] * 2 + [1.0, 1.0])

    @property
    def start(self):
        return np.array([0.0, 0.0, self.angle, 0.0])


@dataclasses.dataclass(frozen=True)
class Assembly:
    """Leaves from the ground to one rigid platform: (rod, root pose, pose of its end in the platform's frame).

    Dead force and fixed-axis moment act at the platform's origin, `home` its pose before loading. `given` prescribes
    the displacement of single coordinates {index: value}: 0, 1(, 2) along the axes, then the rotations (in space all
    three, as entries of the rotation vector). Loads, displacements and q grow with the load factor, but `dead` (force,
    moment) is there from the start. Unknowns: force and moment at every root, pose of the platform.
    """

    leaves: tuple
    home: tuple[float, ...]
    load: tuple[float, ...]
    given: dict[int, float] = dataclasses.field(default_factory=dict)
    dead: tuple[float, ...] | None = None

    @property
    def space(self):
        return self.leaves[0][0].space

    def balance(self, z):
        """Gaps between leaves and platform, norm of the quaternion, and the wrench the platform needs, by columns."""
        space, rows, wrench = self.space, [], np.zeros((1, 1))
        platform = z[-1 - space.poses : -1]
        each = space.forces + space.moments
        for i, (rod, root, offset) in enumerate(self.leaves):
            n, m = np.split(z[i * each : (i + 1) * each], [space.forces])
            pose, n, m = rod.march(np.repeat(column(root), z.shape[1], 1) + 0 * z[:1], n, m, z[-1])
            place = space.compose(platform, np.repeat(column(offset), z.shape[1], 1))
            rows.append(space.gap(pose, place))
            arm = place[: space.forces] - platform[: space.forces]
            wrench = wrench + np.concatenate([n, m + space.moment(arm, n)])
        wrench = wrench - (0 if self.dead is None else column(self.dead))
        return np.concatenate([*rows, space.norm(platform)]), wrench

    def residual(self, z):
        gaps, wrench = self.balance(z)
        wrench = wrench - column(self.load) * z[-1]
        if not self.given:
            return np.concatenate([gaps, wrench])
        space = self.space
        shift = np.zeros(space.forces + space.moments)
        shift[list(self.given)] = list(self.given.values())
        target = space.moved(column(self.home), shift, z[-1])
        away = space.gap(z[-1 - space.poses : -1], target)
        held = column(np.isin(np.arange(len(shift)), list(self.given)))
        return np.concatenate([gaps, np.where(held, away, wrench)])

    def platform(self, z):
        """Pose of the platform."""
        return z[-1 - self.space.poses : -1]

    def wrench(self, z):
        """Force and moment that the platform's origin needs besides `dead`, (3,) or (6,)."""
        return self.balance(column(z))[1][:, 0]

    def compliance(self, z):
        """Displacements and spatial rotations of the platform by a unit wrench, about z, (3, 3) or (6, 6)."""
        poses, size = self.space.poses, self.space.forces + self.space.moments
        _, slope = jacobian(lambda w: np.concatenate(self.balance(w)), z, self.scale)
        slope = slope[:, :-1] * self.scale[:-1]
        weight = 1 / np.abs(slope).max(1)
        unit = np.zeros((len(slope), size))
        unit[-size:] = np.diag(weight[-size:])
        moved = np.linalg.solve(slope * column(weight), unit) * column(self.scale[:-1])
        return np.linalg.pinv(self.space.variations(self.platform(z))) @ moved[-poses:]

    def stiffness(self, z):
        """Tangent: change of the wrench by displacements and spatial rotations of the platform, (3, 3) or (6, 6)."""
        return np.linalg.inv(self.compliance(z))

    @property
    def scale(self):
        force, moment = self.leaves[0][0].scale
        one = np.r_[np.full(self.space.forces, force), np.full(self.space.moments, moment)]
        length = self.leaves[0][0].length
        pose = np.r_[np.full(self.space.forces, length), np.ones(self.space.poses - self.space.forces)]
        return np.r_[np.tile(one, len(self.leaves)), pose, 1.0]

    @property
    def start(self):
        z = np.zeros(self.scale.size)
        z[-1 - self.space.poses : -1] = self.home
        return z
