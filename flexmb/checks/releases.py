"""Releases that remove over-constraints: of elastic deformations, otherwise of joints and single supports."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from ..elements.element import ELASTIC
from ..math.linear import uneven
from ..math.subspace import dense, null_spaces
from ..mechanics.deformation import host_deformations
from ..model.by_name import FRAME_OF, TURN_OF, TURNS, tilted_by, turned_by
from ..model.model import Entry, Model
from ..numerical_limits import CLOSED_LOOP, LARGEST_ALIKE, SELF_STRESS, TAKES_NO_PART

# Steps of the motion to either side, and their largest size [extents, rad]: together half a turn.
STEPS, STEP = 20, 0.2
# Larger mechanisms are only checked undeformed: each step needs singular value decompositions.
MOST_FOLLOWED = 150
# Number of Newton iterations that satisfy the FIXED deformations.
ITERATIONS = 8


class Release(NamedTuple):
    """A constraint whose release removes an over-constraint. The remaining self-stress is proportional to 1/part².

    Attributes:
        of: Element or node.
        component: Number of its deformation, from 1; of a support "x", "phi" or "rx".
        part: Smallest part in the self-stress of norm 1 along the motion.
        fails: Where along the motion the release loses rank, such as "hinge.e1 = 1.57"; "" where it does not.
        shared: Whether it is a node whose name an element bears too.
    """

    of: str
    component: int | str
    part: float
    fails: str = ""
    shared: bool = False

    @property
    def kind(self) -> str:
        """Whether it is of a "node" or of an "element"."""
        return "node" if isinstance(self.component, str) else "element"

    @property
    def number(self) -> int:
        """Number of the deformation or of the coordinate, from 1."""
        return self.component if isinstance(self.component, int) else "xyz".find(self.component) + 1 or 1

    def __str__(self) -> str:
        """The call that releases it, or the line of a file, where elements and nodes are named by numbers."""
        if not self.of.isdecimal():
            kind = ", kind='node'" if self.shared else ""
            call = f"release({self.of!r}, {self.component!r}{kind})"
        elif self.kind == "node":
            call = f"FIX {self.of} without coordinate {self.number}"
        else:
            call = f"RLSE {self.of} {self.number}"
        return call + (f" (loses rank near {self.fails})" if self.fails else "")

    @property
    def words(self) -> str:
        """What to release, in words."""
        return f"{'coordinate' if self.kind == 'node' else 'deformation'} {self.component} of {self.kind} '{self.of}'"


class _Motion(NamedTuple):
    """States along the motion: parts of the constraints in the self-stresses, values of x and e, the undeformed one."""

    parts: Float[np.ndarray, "k m n"]
    values: Float[np.ndarray, "k n_x+n_e"]
    start: int


def _releasable(model: Model, only_elastic: bool) -> list[int]:
    """FIXED deformations of elements that have other ones; no closure, whose release cuts a spectral beam."""
    indices = []
    fixed = set(np.asarray(model.topology.e.fixed).tolist())
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        element = block.element
        is_elastic = not set(ELASTIC).isdisjoint(block.companions)
        if only_elastic and not (is_elastic and element.is_elastic({**dict(block.options), **properties})):
            continue
        measured = {n - 1 for n in element.measured}
        excluded = measured | {n - 1 for n in element.closure}
        # Of a rigid beam only deformations of its closure, such as warping, are not FIXED.
        aside = measured if not only_elastic else excluded if element.fields else ()
        for row in np.asarray(block.e).tolist():
            if any(i not in fixed for n, i in enumerate(row) if n not in aside):
                indices += [i for n, i in enumerate(row) if i in fixed and n not in excluded]
    return sorted(indices)


def _supports(model: Model) -> tuple[list[tuple[str, str]], np.ndarray]:
    """Names of FIXED coordinates that can be released one by one, and how each moves scaled coordinates, (n_x, s)."""
    labels, fixed = model.labels, set(np.asarray(model.topology.x.fixed).tolist())
    # Coordinates that a signal moves, or whose reaction it measures, must stay held.
    fixed -= {part.index for s in (*labels.inputs, *labels.outputs) for part in s.terms if not part.of_element}
    names, moves = [], []
    reference = np.asarray(model.parameters.reference)

    def add(entry: Entry, symbol: str, first: int, values: Any) -> None:
        names.append((entry.of.removesuffix(".rotation"), symbol))
        moves.append(np.zeros(len(reference)))
        moves[-1][first : first + len(values)] = values

    for i in sorted(fixed):
        entry = labels.x[i]
        if entry.kind == "position" or entry.symbol == "phi":
            add(entry, entry.symbol, i, [1.0])
        elif entry.symbol == "l0" and fixed.issuperset(range(i, i + 4)) and not entry.of.startswith(FRAME_OF):
            # Files hold a rotation in space as a whole.
            for turn, axis in zip(() if entry.of.isdecimal() else TURNS, np.eye(3), strict=False):
                # Half the product of the turn and the Euler parameters.
                scalar, vector = reference[i], reference[i + 1 : i + 4]
                add(entry, turn, i, 0.5 * np.array([-axis @ vector, *(scalar * axis + np.cross(axis, vector))]))
    return names, np.array(moves).reshape(-1, len(reference)).T


def proposals(model: Model, constraints: Any, stress: np.ndarray) -> tuple[tuple[Release, ...], ...]:
    """Candidates for each over-constraint; the release of the first leaves the smallest self-stress.

    Joints and supports are candidates where no elastic deformation takes part. ``stress`` are orthonormal self-stresses
    in scaled rows, (n_e, over).
    """
    if not stress.shape[1]:
        return ()
    labels, elastic = model.labels, _releasable(model, True)
    candidates = [tuple(releases) for releases in one_by_one(model, elastic, stress)]
    if len(candidates) == stress.shape[1]:
        return tuple(candidates)
    released = [model.labels.deformations(*releases[0][:2]) for releases in candidates]
    supports, moves = _supports(model)
    rows: list[int] = []
    names: list[tuple[str, int | str]] = []
    for i in sorted(set(_releasable(model, False)).difference(elastic)):
        entry, (node, axis) = labels.e[i], turned_by(labels.e[i].of)
        is_turn = entry.of.startswith(TURN_OF)
        # A hinge that holds a node about global axes is named as its support. About other axes it has no name.
        if not is_turn or axis:
            rows.append(i)
            axes = (axis, *tilted_by(entry.of))
            names.append((node, axes[entry.component - 1]) if is_turn else (entry.of, entry.component))
    names += supports
    elements = {name for name, *_ in labels.elements}
    motion = _along_motion(model, constraints, released, rows, moves)
    for order in _in_turn(motion.parts, motion.start):
        releases = [Release(*names[k], part, _place(model, motion, gap)) for k, part, gap in order]
        candidates.append(
            tuple(release._replace(shared=release.kind == "node" and release.of in elements) for release in releases)
        )
    return (*candidates, *[()] * (stress.shape[1] - len(candidates)))


def one_by_one(model: Model, rows: Sequence[int], stress: np.ndarray) -> Iterator[list[Release]]:
    """Deformations among some rows that each remove an over-constraint, by their parts in the undeformed mechanism."""
    for order in _in_turn(stress[None, list(rows)], 0):
        entries = [(model.labels.e[rows[k]], part) for k, part, _ in order]
        yield [Release(entry.of, entry.component, part) for entry, part in entries]


def _in_turn(parts: np.ndarray, start: int) -> Iterator[list[tuple[int, float, float | None]]]:
    """Constraints that remove one over-constraint after the other: index, smallest part, nearest place of lost rank.

    ``parts``: shares of each constraint in each self-stress, in states along the motion, (k, m, n). Each constraint
    takes part at ``start``. The best constraint is released before the next over-constraint.
    """
    count, chosen, remaining = parts.shape[2], [], parts
    while len(chosen) < count:
        sizes = np.linalg.norm(remaining, axis=2)
        least, gaps = sizes.min(axis=0), [None] * parts.shape[1]
        if len(chosen) == count - 1 and len(parts) > 1:
            # Where the last part vanishes, the volume that all parts span changes its sign.
            sets = np.array([[*chosen, k] for k in range(parts.shape[1])], int).reshape(-1, count)
            volumes = np.linalg.det(parts[:, sets])
            for k in np.flatnonzero(np.any(volumes[1:] * volumes[:-1] < 0, axis=0)):
                crossed = np.flatnonzero(volumes[1:, k] * volumes[:-1, k] < 0)
                at = int(crossed[np.argmin(np.abs(crossed + 0.5 - start))])
                least[k], gaps[k] = 0.0, at + volumes[at, k] / (volumes[at, k] - volumes[at + 1, k])
        best = [k for k in range(parts.shape[1]) if sizes[start, k] > TAKES_NO_PART and k not in chosen]
        best.sort(key=lambda k: (round(-least[k], 9), round(-sizes[start, k], 9), k))
        if not best:
            return
        yield [(k, float(least[k]), gaps[k]) for k in best]
        chosen.append(best[0])
        # Self-stresses that are left once this constraint is released.
        row = remaining[:, best[0]] / np.maximum(sizes[:, best[0], None], np.finfo(float).tiny)
        remaining = remaining - (remaining @ row[:, :, None]) * row[:, None]


def _along_motion(model: Model, constraints: Any, taken: list[int], rows: list[int], moves: np.ndarray) -> _Motion:
    """Parts of deformations and of supports in the self-stresses, as far as the mechanism moves to either side.

    ``taken`` deformations are released already; ``moves`` are the coordinates that each support moves, (n_x, s).
    """
    top = model.topology
    constrained, free = np.setdiff1d(top.e.held, taken), np.asarray(top.x.free)
    row_of = {i: k for k, i in enumerate(constrained.tolist())}
    rows = [row_of[i] for i in rows]

    def parts_of(jacobian: Any, left: Any) -> np.ndarray:
        # A support bears the force of the self-stress on its coordinate.
        return np.concatenate([left[rows], -dense(jacobian[constrained] @ moves).T @ left])

    reference = np.asarray(model.parameters.reference)
    rank, left, right = null_spaces(constraints.jacobian[np.ix_(constrained, free)])
    left, right = dense(left), dense(right)
    begin = reference, np.zeros(top.n_e), left
    states, followed = [(parts_of(constraints.jacobian, left), np.append(*begin[:2]))], []
    sides = (1, -1) if right.shape[1] and left.shape[1] and top.n_x <= MOST_FOLLOWED else ()

    def closed(x: np.ndarray, last_strain: np.ndarray):
        """The state near to coordinates by Newton's method; None if its FIXED deformations do not vanish."""
        for _ in range(ITERATIONS):
            e, jacobian = host_deformations(top, model.parameters, x, last_strain)
            jacobian = dense(jacobian) * constraints.columns * constraints.rows[:, None]
            if not np.all(np.isfinite(jacobian)):
                return None
            u, values, vh = np.linalg.svd(jacobian[np.ix_(constrained, free)])
            excess = (constraints.rows * e)[constrained]
            if np.max(np.abs(excess), initial=0.0) < CLOSED_LOOP:
                return x, e, jacobian, u, values, vh
            change = vh[:rank].T @ ((u[:, :rank].T @ excess) / values[:rank])
            x = x.copy()
            x[free] -= constraints.columns[free] * change
        return None

    for side in sides:
        x, last_strain, before = begin
        way, followed = side * right @ uneven(right.shape[1], 1), []
        for _ in range(STEPS):
            x = x.copy()
            x[free] += STEP * constraints.columns[free] * way / np.max(np.abs(way))
            state = closed(x, last_strain)
            if state is None or np.max(state[4][rank:], initial=0.0) > SELF_STRESS:
                break
            x, last_strain, jacobian, u, values, vh = state
            way = vh[rank:].T @ (vh[rank:] @ way)
            if values[rank - 1] < SELF_STRESS:
                continue
            turned, _, back = np.linalg.svd(u[:, rank:].T @ before)
            before = u[:, rank:] @ (turned @ back)
            followed.append((parts_of(jacobian, before), np.append(x, last_strain)))
        states = states + followed if side > 0 else followed[::-1] + states
    return _Motion(np.array([entry for entry, _ in states]), np.array([entry for _, entry in states]), len(followed))


def _place(model: Model, motion: _Motion, gap: float | None) -> str:
    """Place where a release loses rank: a coordinate or deformation that moves, and its value there."""
    if gap is None:
        return ""
    top, entries = model.topology, (*model.labels.x, *model.labels.e)
    angles = [i for i in np.asarray(top.e.free).tolist() if not entries[top.n_x + i].of.startswith(TURN_OF)]
    ranges = np.ptp(motion.values, axis=0)
    indices = [top.n_x + i for i in angles if ranges[top.n_x + i] > STEP]
    if not indices:
        indices = [i for i, entry in enumerate(model.labels.x) if entry.kind == "position" or entry.symbol == "phi"]
    # Among equals the first: a rounding difference must not decide.
    most = next(i for i in indices if ranges[i] > (1 - LARGEST_ALIKE) * max(ranges[indices]))
    value = np.interp(gap, np.arange(len(motion.values)), motion.values[:, most])
    # Between two states it is known to a thousandth of the way.
    return f"{entries[most]} = {np.round(value / ranges[most], 3) * ranges[most]:.3g}"
