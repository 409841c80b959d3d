"""Over- and under-constraints of a mechanism, by singular values and by name."""

import dataclasses
from collections.abc import Collection, Sequence
from typing import Any

import jax
import jax.core
import numpy as np

from ..compilation.compile import unguarded
from ..display import AT_MOST, Result, States, Summary, among, counted
from ..errors import ModelError
from ..math.linear import uneven
from ..math.subspace import dense, null_spaces, row_sizes, scattered_rows
from ..mechanics.deformation import undeformed
from ..mechanics.signals import along_coordinates, combined, terms_of
from ..model.model import Entry, Model, Signal, as_known_model
from ..model.topology import coordinate_scales
from ..numerical_limits import LARGEST_ALIKE, NEGLIGIBLE, SMALLEST_SHARE
from .releases import Release, one_by_one, proposals

# Distance along motions at which a mechanism is checked for locked inputs [extents, rad].
SHIFT = 1e-2


@dataclasses.dataclass(frozen=True)
class Share:
    """Part that one coordinate or deformation has in an over- or under-constraint.

    Attributes:
        of: Node or element.
        component: Number from 1.
        symbol: How it is written.
        share: Amplitude: displacement or rotation of a motion, stress resultant of a self-stress; the largest is 1.
    """

    of: str
    component: int
    symbol: str
    share: float


@dataclasses.dataclass(frozen=True, repr=False)
class Mobility(Result):
    """Redundant constraints and free motions of a mechanism, with every named DOF constrained.

    Attributes:
        overconstraints: Number of independent states of self-stress.
        underconstraints: Number of independent motions that no constraint and no DOF prevents.
        self_stress: One state of self-stress per column, in the order of e, (n_e, overconstraints) [N, N m].
        motion: One motion per column, in the order of x, (n_x, underconstraints) [m, rad, -].
        candidates: Possible releases for each over-constraint, once the earlier ones are released: elastic
            deformations, otherwise deformations of joints and single supports. The first candidate leaves the smallest
            self-stress.
        model: The mechanism.
    """

    overconstraints: int
    underconstraints: int
    self_stress: np.ndarray
    motion: np.ndarray
    candidates: tuple[tuple[Release, ...], ...]
    model: Model

    @property
    def release(self) -> tuple[tuple[str, int | str] | None, ...]:
        """Return the first release of each over-constraint as (element, number) or (node, coordinate), or None."""
        return tuple(releases[0][:2] if releases else None for releases in self.candidates)

    @property
    def status(self) -> str:
        """One of "ok", "overconstrained", "underconstrained", "both"."""
        over, under = self.overconstraints > 0, self.underconstraints > 0
        return "both" if over and under else "overconstrained" if over else "underconstrained" if under else "ok"

    def stresses(self, mode: int = 0) -> list[Share]:
        """Return the elements that take part in a state of self-stress, largest first.

        Args:
            mode: Number of the state, from 0.
        """
        return shares(self.self_stress[:, mode], self.model.labels.e)

    def motions(self, mode: int = 0) -> list[Share]:
        """Return the nodes that take part in a motion, largest first.

        Args:
            mode: Number of the motion, from 0.
        """
        return shares(self.motion[:, mode], self.model.labels.x)

    def states(self) -> States:
        """Return the undeformed mechanism, with the share of each element in every state of self-stress."""
        if not self.overconstraints:
            return self.model.states()._replace(shares=())
        parts: list[dict[str, float]] = [{} for _ in range(self.overconstraints)]
        titles = []
        for i, (largest, release) in enumerate(zip(parts, self.release, strict=True)):
            for share in self.stresses(i):
                largest[share.of] = max(largest.get(share.of, 0.0), abs(share.share))
            advice = "between rigid elements"
            if release:
                symbol = release[1] if isinstance(release[1], str) else f"e{release[1]}"
                advice = f"release {symbol} of '{release[0]}' to remove it"
            titles.append(f"self-stress {i + 1} of {self.overconstraints}: {advice}")
        return States(self.model, self.model.parameters.reference, "self-stress", shares=parts, titles=titles)

    def summary(self) -> Summary:
        """Return the number of over- and under-constraints, and the nodes and elements that take part."""
        rows = dict(title.split(": ", 1) for title in self.states().titles)
        for i in range(self.underconstraints):
            rows[f"free motion {i + 1}"] = ", ".join(f"{s.of}.{s.symbol}" for s in self.motions(i)[:AT_MOST])
        title = f"Mobility: {self.status}, {counted(self.overconstraints, 'over-constraint')}"
        title += f", {counted(self.underconstraints, 'under-constraint')}"
        return Summary(title, rows, "self_stress" if self.overconstraints else "mechanism")

    def report(self) -> str:
        """Return the over- and under-constrained parts by name, and the releases to try."""
        lines = [f"over-constraints: {self.overconstraints}, under-constraints: {self.underconstraints}"]
        for i in range(self.overconstraints):
            parts = among(f"{s.of}.{s.symbol} ({s.share:.2g})" for s in self.stresses(i))
            if not self.stresses(i):
                # Unit norms are no deformations, and stress against nothing but held Euler parameters.
                stressed = np.abs(self.self_stress[:, i]) > SMALLEST_SHARE
                nodes = [e.of for e, s in zip(self.model.labels.e, stressed, strict=True) if s]
                parts = ", ".join(f"Euler parameters of {node}" for node in dict.fromkeys(nodes))
            lines.append(f"self-stress {i + 1}: {parts}")
            if releases := self.candidates[i]:
                lines.append(f"  to remove it, release {releases[0].words}: {releases[0]}")
            else:
                lines.append("  rigid elements form a closed loop here: replace one by a flexible or a pinned one")
            if releases[1:]:
                lines.append(f"  or one of these, the smallest self-stress first: {among(map(str, releases[1:]))}")
        for i in range(self.underconstraints):
            parts = among(f"{s.of}.{s.symbol} ({s.share:.2g})" for s in self.motions(i))
            lines.append(f"free motion {i + 1}: {parts}")
        return "\n".join(lines)


def shares(vector: np.ndarray, entries: Sequence[Entry]) -> list[Share]:
    """Parts of a motion or a self-stress, whose largest is 1, the largest first, without small ones."""
    order = np.argsort(-np.round(np.abs(vector) / LARGEST_ALIKE), kind="stable")
    indices = [i for i in order if abs(vector[i]) > SMALLEST_SHARE and entries[i].kind != "norm"]
    return [Share(entries[i].of, entries[i].component, entries[i].symbol, float(vector[i])) for i in indices]


@dataclasses.dataclass(frozen=True)
class Constraints:
    """Jacobian of the deformations in the undeformed mechanism, scaled to pure numbers.

    Attributes:
        jacobian: Rows of unit size, columns per extent of the mechanism or radian, (n_e, n_x); sparse where there are
            many.
        rows: Factor of each row, (n_e,).
        columns: Factor of each column, (n_x,).
    """

    jacobian: Any
    rows: np.ndarray
    columns: np.ndarray

    def self_stress(self, left: Any, held: np.ndarray) -> np.ndarray:
        """Stress resultants of left null vectors of the held rows, the largest of each 1."""
        return _unit(dense(scattered_rows(left, held, len(self.rows))) * self.rows[:, None])

    def motion(self, right: Any, free: np.ndarray) -> np.ndarray:
        """Coordinates of right null vectors of the free columns, the largest of each 1."""
        return _unit(dense(scattered_rows(right, free, len(self.columns))) * self.columns[:, None])


def _unit(columns: np.ndarray) -> np.ndarray:
    """Columns scaled to a largest entry of 1: the first of the entries that are equal but for round-off."""
    if not columns.size:
        return columns
    sizes = np.abs(columns)
    first = np.argmax(sizes > (1 - LARGEST_ALIKE) * sizes.max(axis=0), axis=0)
    return columns / columns[first, np.arange(columns.shape[1])]


def constraints(model: Model) -> Constraints:
    """Scaled Jacobian of the deformations in the undeformed mechanism.

    Raises:
        ModelError: A deformation does not vanish where it should, or has no finite derivative there.
    """
    topology, parameters = model.topology, model.parameters
    e, jacobian = undeformed(topology, parameters)
    columns = coordinate_scales(topology, parameters)
    sizes = row_sizes(jacobian * columns)
    _check_undeformed(model, e, sizes)
    rows = 1 / np.where(sizes > 0, sizes, 1.0)
    scaled = jacobian * columns * rows[:, None]
    return Constraints(scaled if isinstance(scaled, np.ndarray) else scaled.tocsr(), rows, columns)


def _check_undeformed(model: Model, e: np.ndarray, sizes: np.ndarray) -> None:
    """Refuse deformations that are not zero, or not differentiable, in the undeformed mechanism."""
    types = {name: kind for name, kind, _ in model.labels.elements}
    for entry, value, size in zip(model.labels.e, e.tolist(), sizes.tolist(), strict=True):
        subject = f"Deformation {entry.component} of element '{entry.of}' ({types.get(entry.of, entry.kind)})"
        if not np.isfinite(value) or not np.isfinite(size):
            part = "its derivative is" if np.isfinite(value) else "it is"
            raise ModelError(
                f"{subject}: in the undeformed mechanism {part} not finite. Rewrite it so that it is finite."
            )
        if abs(value) > NEGLIGIBLE * size:
            raise ModelError(
                f"{subject} is {value:.6g} but must be zero in the undeformed mechanism, which is its argument `ref`."
            )


def allowed_motions(model: Model, found: Constraints | None = None) -> tuple[Any, int]:
    """Scaled motions that the constraints allow, (n_x, f), sparse if the constraints are; and the over-constraints."""
    found, topology = found or constraints(model), model.topology
    constrained, free = np.asarray(topology.e.held), np.asarray(topology.x.free)
    rank, _, right = null_spaces(found.jacobian[np.ix_(constrained, free)])
    return scattered_rows(right, free, topology.n_x), len(constrained) - rank


@jax.core.eval_context()
def locked_inputs(model: Model) -> list[Signal]:
    """Inputs that no motion moves, in the undeformed mechanism and in one built a little further along its motions.

    The second mechanism distinguishes a locked input from an input at a dead point. The model is concrete; other
    numbers may be traced.
    """
    locked = list(model.labels.inputs)
    motions, _ = allowed_motions(model)
    columns = constraints(model).columns
    motion = motions @ uneven(motions.shape[1], 1)
    away = SHIFT * motion / max(np.max(np.abs(motion), initial=0.0), np.finfo(float).tiny)
    moved = np.array(model.parameters.reference) + columns * away
    for place, entry in enumerate(model.labels.x):
        if entry.kind in ("internal", "warping"):
            # Undeformed elements have none of these.
            moved[place] = model.parameters.reference[place]
        if entry.symbol == "l0":
            indices = model.labels.coordinates(entry.of)
            moved[indices] /= np.linalg.norm(moved[indices])
    parameters = dataclasses.replace(model.parameters, reference=moved)
    for variant in (model, dataclasses.replace(model, parameters=parameters)):
        motions, _ = allowed_motions(variant)
        constraint_set, x = constraints(variant), np.asarray(variant.parameters.reference)
        locked = [s for s in locked if np.linalg.norm(motions.T @ _acting(variant, s, constraint_set, x)) <= NEGLIGIBLE]
    return locked


def _acting(model: Model, signal: Signal, constraint_set: Constraints, x: np.ndarray) -> np.ndarray:
    """Row of :func:`_input_row`; of an actuator its weighted parts, the largest of unit size."""
    if not signal.parts:
        return _input_row(signal, constraint_set, x)
    inputs, weights = model.labels.inputs, model.parameters.weights
    factors = np.asarray(combined(inputs, None if weights is None else weights[0]))[inputs.index(signal)]
    rows = [
        _input_row(term, constraint_set, x) if term in signal.parts else np.zeros(len(x)) for term in terms_of(inputs)
    ]
    return factors @ np.array(rows) / max(np.max(np.abs(factors)), np.finfo(float).tiny)


def _input_row(signal: Signal, constraint_set: Constraints, x: np.ndarray) -> np.ndarray:
    """Effect of an input on scaled coordinates, of unit size."""
    if signal.quantity == "stress":
        return dense(constraint_set.jacobian[[signal.index]])[0]
    row = np.zeros(len(x))
    indices, along = along_coordinates(signal, jax.device_put(x))
    row[np.asarray(indices)] = np.asarray(along)
    return row / np.linalg.norm(row)


@unguarded
def mobility(model: Model) -> Mobility:
    """Find over- and under-constraints of the undeformed mechanism, with every named DOF constrained.

    Args:
        model: Mechanism, checked or not (``Builder.build(check=False)``).

    Returns:
        Mobility: the numbers of over- and under-constraints, self-stresses (n_e, over), and motions (n_x, under) [SI].
            The largest entry of each self-stress and motion is 1.

    Raises:
        TypeError: Numbers of the model are traced, as under ``jax.jit``.

    Source:
        THEORY.md 8, eq. (8.1): singular values of the Jacobian of FIXED, PRESCRIBED and DOF deformations by the
        DEPENDENT coordinates; left null vectors are over-constraints, right ones under-constraints.
    """
    return mobility_of(model, constraints(as_known_model(model, "mobility")))


def mobility_of(model: Model, found: Constraints) -> Mobility:
    """As :func:`mobility`, of constraints that are known."""
    matrix, constrained, free = _constrained_rows(model, found)
    rank, left, right = null_spaces(matrix)
    stress = found.self_stress(left, constrained)
    candidates = proposals(model, found, _stress(model, left, constrained))
    return Mobility(len(constrained) - rank, len(free) - rank, stress, found.motion(right, free), candidates, model)


def removals(model: Model, candidates: Collection[tuple[str, int]]) -> tuple[tuple[str, int] | None, ...]:
    """For each over-constraint the element and number to release among some, FIXED or DOF; None if none takes part."""
    matrix, constrained, _ = _constrained_rows(model, constraints(model))
    left = null_spaces(matrix)[1]
    rows = [i for i in constrained.tolist() if (model.labels.e[i].of, model.labels.e[i].component) in candidates]
    releases = [
        (alternatives[0].of, alternatives[0].number)
        for alternatives in one_by_one(model, rows, _stress(model, left, constrained))
    ]
    return (*releases, *[None] * (left.shape[1] - len(releases)))


def _stress(model: Model, left: Any, constrained: np.ndarray) -> np.ndarray:
    """Orthonormal self-stresses, with the rows that are not held, (n_e, over)."""
    return dense(scattered_rows(left, constrained, model.topology.n_e))


def _constrained_rows(model: Model, constraint_set: Constraints) -> tuple[Any, np.ndarray, np.ndarray]:
    """Jacobian of the deformations that are held by the DEPENDENT coordinates, and the indices of both."""
    topology = model.topology
    constrained, free = np.asarray(topology.e.given), np.asarray(topology.x.dependent)
    return constraint_set.jacobian[np.ix_(constrained, free)], constrained, free
