"""Lean models: fewer beams and fewer degrees of freedom within a tolerance."""

import dataclasses
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arguments import check_number, check_whole, short_repr
from ..build.restrict import Restriction, can_be_tied, restrict
from ..checks.mobility import allowed_motions, constraints
from ..compilation.compile import unguarded
from ..compilation.threads import one_thread
from ..display import Result, Summary, listed
from ..errors import AnalysisError, ModelError, printable, warn
from ..linear.linearize import Linearization, linearize
from ..linear.modes import modes
from ..model.model import Model
from ..numerical_limits import HIDDEN, NEGLIGIBLE, NEGLIGIBLE_SHARE, NO_MOTION, ROUND_OFF, SAME_DIRECTIONS
from ..questions.question import asked
from .designs import float_array
from .leanness import Deviation, Response, check_question, deviation, in_band, largest_deviation, response

# Beams of a leaf spring in the full model.
FINEST = 4


@dataclasses.dataclass(frozen=True, repr=False)
class Lean(Result):
    """A lean model, and its difference from the full model.

    Attributes:
        model: Lean model, an ordinary model.
        full: Full model.
        error: Estimate of the error.
        beams: Number of beams of each leaf spring, by the arguments of the function that builds the model.
        fixed: Deformations that are FIXED.
        ties: Number of combinations of the other deformations that are FIXED.
        bandwidth: Bandwidth of the question [Hz].
        tolerance: Tolerance of the question.
        full_frequencies: Natural frequencies of the full model in the band, and the next higher one [Hz].
        frequencies: Natural frequencies of the lean model, the same number [Hz].
        restriction: Restriction that :meth:`of` applies.
        in_deviations: Answer of the lean model minus answer of the full model, in standard deviations of the
            measurement, by question [-]; empty without ``deviations``.
    """

    model: Model
    full: Model
    error: Deviation
    beams: dict[str, int]
    fixed: tuple[str, ...]
    ties: int
    bandwidth: float
    tolerance: float
    full_frequencies: np.ndarray
    frequencies: np.ndarray
    restriction: Restriction
    in_deviations: dict[str, float] = dataclasses.field(default_factory=dict)

    def summary(self) -> Summary:
        """Return the degrees of freedom of the lean model, and the error."""
        full, count, e = self.full.topology.n_q, self.model.topology.n_q, self.error
        rows = {
            "frequencies": f"{listed(self.frequencies, 'Hz')} within {100 * e.frequencies:.2g} %",
            "stiffness": f"within {100 * e.stiffness:.2g} %",
            "frequency response": f"within {100 * e.transfer:.2g} %",
            "left out": f"{len(self.fixed)} deformations FIXED, {self.ties} combinations tied",
        }
        title = (
            f"Lean up to {self.bandwidth:g} Hz: {count} of {full} degrees of freedom ({listed(self.model.q_labels)})"
        )
        if self.in_deviations:
            rows["against scatter"] = self._against_scatter()
        return Summary(title, rows)

    def _against_scatter(self) -> str:
        return ", ".join(f"{name} {size:+.2g} deviations" for name, size in self.in_deviations.items())

    def __str__(self) -> str:
        return self.report()

    def of(self, model: Model) -> Model:
        """Apply the same restriction to a model with other numbers, which may be traced.

        Args:
            model: Model with the structure of ``full``.

        Raises:
            ModelError: The structure is another one.
        """
        if model.topology.n_e != self.full.topology.n_e or model.topology.n_x != self.full.topology.n_x:
            raise ModelError("The model has another structure. lean.of() needs the nodes and elements of lean.full.")
        return self.restriction.of(model)

    def report(self) -> str:
        """Return the omitted deformations and the error."""
        full, lean_ = self.full.topology, self.model.topology
        hertz = ", ".join(f"{f:.6g}" for f in self.full_frequencies)
        lines = [
            f"Question: frequencies up to {self.bandwidth:g} Hz, within {100 * self.tolerance:g} %.",
            f"Full model: {full.n_q} degrees of freedom; lean model: {lean_.n_q} ({', '.join(self.model.q_labels)}).",
            f"Natural frequencies of the full model up to the first above the band: {hertz} Hz.",
            f"Of the lean model: {', '.join(f'{f:.6g}' for f in self.frequencies)} Hz.",
        ]
        if self.beams:
            lines.append("Beams: " + ", ".join(f"{name} {count}" for name, count in self.beams.items()) + ".")
        if self.fixed:
            lines.append(f"FIXED, since they hardly deform: {', '.join(self.fixed)}.")
        if self.ties:
            lines.append(
                f"{self.ties} further combinations of deformations follow the kept motions statically (condensed)."
            )
        e = self.error
        costs = f"stiffness {100 * e.stiffness:.2g} %, frequency response {100 * e.transfer:.2g} %."
        lines.append(f"Cost: frequencies {100 * e.frequencies:.2g} %, {costs}")
        if self.in_deviations:
            lines.append(f"Against the scatter of measurements: {self._against_scatter()}.")
        return "\n".join(lines)


def _kept_motions(
    full: list[Response], bandwidth: float, tolerance: float, bands: list[np.ndarray]
) -> list[np.ndarray]:
    """Return the motions to keep at each state: modes of the band, and static responses until the tolerance is met.

    Each motion has an energy of 1.
    """
    bases = []
    for state, shapes in zip(full, bands, strict=True):
        z = shapes / np.sqrt(np.einsum("ij,ij->j", shapes, state.K @ shapes))
        candidates = np.linalg.solve(state.K, state.directions.T)
        while z.shape[1] < len(state.K):
            if deviation(state, state.restricted(z), bandwidth).worst <= tolerance:
                break
            # Missing part of each static response, and its share in energy.
            missing = candidates - z @ np.linalg.solve(z.T @ state.K @ z, z.T @ state.K @ candidates)
            size = np.einsum("ij,ij->j", missing, state.K @ missing)
            total = np.einsum("ij,ij->j", candidates, state.K @ candidates)
            share = size / np.where(total > 0, total, 1.0) if size.size else np.zeros(0)
            if not share.size or np.max(share) < ROUND_OFF:
                break
            most = int(np.argmax(share))
            z = np.column_stack([z, missing[:, most] / np.sqrt(size[most])])
        bases.append(z)
    return bases


@one_thread()
@unguarded
def lean(
    model: Model | Callable[..., Model],
    *,
    bandwidth: float,
    tolerance: float = 0.01,
    nodes: Sequence[str] = (),
    increments: Sequence[float] = (0.0,),
    finest: int = FINEST,
    deviations: Mapping[str, float] | None = None,
) -> Lean:
    """Find the smallest model that answers a question within a tolerance, and its error.

    Each leaf spring has as few beams as possible. flexmb fixes deformations that are negligible in the band.
    Constraints between the other deformations ("ties") leave only the natural modes of the band. Where necessary they
    also leave the static responses to the inputs and to forces at the given nodes. flexmb compares every candidate with
    the full model.

    Args:
        model: Full model; or a function of the number of beams of each leaf spring that builds it.
        bandwidth: Highest frequency of the question [Hz].
        tolerance: Relative error of natural frequencies, stiffness and frequency responses.
        nodes: Nodes whose compliance in all directions is part of the question, beside inputs and outputs.
        increments: Factors of the incremental loads at which flexmb compares the models, such as strokes.
        finest: Number of beams of a leaf spring in the full model, if ``model`` is a function.
        deviations: Standard deviations of measured answers, by question, such as ``{"frequency 1": 0.1}``. flexmb
            compares the answers of the lean model and of the full model in these units. If ``model`` is a function,
            this full model has ``finest`` beams per leaf spring.

    Returns:
        Lean. Its ``model`` is an ordinary model with new deformations named "tie".

    Raises:
        ModelError: bandwidth or tolerance is not positive. A node does not exist. increments are not finite. finest is
            below two, or is given with a Model. The function has no arguments. A deviation is not positive.
        KeyError: There is no such question.
        AnalysisError: An equilibrium fails or is unstable, or no smaller model meets the tolerance.

    Warns:
        FlexmbWarning: An answer of the lean model differs by more than half a standard deviation. Lower the tolerance.

    Source:
        Modes and static responses: Craig, Bampton (1968), AIAA Journal 6, 1313. flexmb applies them as constraints
        between the deformations of the elements. The lean model therefore allows large displacements.
    """
    if not isinstance(model, Model) and not callable(model):
        raise ModelError(f"Argument `model` must be a Model or a function that builds it, not {type(model).__name__}.")
    check_question(model if isinstance(model, Model) else None, bandwidth, tolerance, nodes)
    if not isinstance(increments, Iterable):
        raise ModelError(
            f"Argument `increments` must be a list of factors such as [0.0, 5.0], not {short_repr(increments)}."
        )
    try:
        increments = float_array("Argument `increments`", list(increments)).ravel().tolist()
        finest = check_whole("finest", finest, 2)
    except (TypeError, ValueError) as fault:
        raise ModelError(f"{fault} `finest` sets the beams of the full model.") from None
    if isinstance(model, Model) and finest != FINEST:
        raise ModelError("Argument `finest` is for a function of the numbers of beams. A Model has its beams.")
    if not increments or not np.all(np.isfinite(increments)):
        raise ModelError(f"Argument `increments` must be finite numbers, at least one, not {increments}.")
    questions = {name: _deviation(name, size) for name, size in (deviations or {}).items()}
    beams: dict[str, int] = {}
    spent = Deviation(0.0, 0.0, 0.0)
    if isinstance(model, Model):
        full_model = model
    else:
        full_model, beams, spent = _fewest_beams(model, bandwidth, tolerance, nodes, increments, finest)
    states = [linearize(full_model, increment=increment) for increment in increments]
    full = [response(lin, nodes) for lin in states]
    shapes = []
    for lin in states:
        eigenmodes = modes(lin)
        count = in_band(np.asarray(eigenmodes.frequencies), bandwidth)
        shapes.append(np.asarray(eigenmodes.q_shapes)[:, :count])
    theirs = full[0].frequencies()
    for same in SAME_DIRECTIONS:
        missed = NEGLIGIBLE_SHARE * tolerance if same < SAME_DIRECTIONS[0] else tolerance / 2
        kept_motions = _kept_motions(full, bandwidth, missed, shapes)
        decided = _decide(full_model, states, kept_motions, tolerance, same)
        if decided is None:
            continue
        restriction, fixed, ties = decided
        small = restriction.of(full_model)
        try:
            small_responses = [response(linearize(small, increment=increment), nodes) for increment in increments]
        except AnalysisError:
            continue
        pairs = zip(full, small_responses, strict=True)
        error = largest_deviation([deviation(a, b, bandwidth) for a, b in pairs]).plus(spent)
        if error.worst <= tolerance:
            names = tuple(str(full_model.labels.e[i]) for i in fixed)
            count = in_band(theirs, bandwidth) + 1
            question = bandwidth, tolerance, theirs[:count], small_responses[0].frequencies()[:count]
            finer = full_model
            if questions and not isinstance(model, Model):
                finer = model(**dict.fromkeys(beams, finest))
            against = {name: float(asked(name)(small) - asked(name)(finer)) / s for name, s in questions.items()}
            _tell_beyond_scatter(against)
            return Lean(small, full_model, error, beams, names, ties, *question, restriction, against)
    raise AnalysisError(
        "not_lean",
        f"No smaller model answers up to {bandwidth:g} Hz within {tolerance:g}. Allow a larger tolerance or ask for a"
        " smaller band.",
    )


def _deviation(name: str, size: Any) -> float:
    asked(name).parsed()
    try:
        return float(check_number(f"deviations['{printable(name)}']", size, above=0))
    except (TypeError, ValueError) as fault:
        raise ModelError(str(fault)) from None


def _tell_beyond_scatter(against: Mapping[str, float]) -> None:
    """Warn of answers in which the lean model differs by more than HIDDEN deviations."""
    if beyond := [name for name, size in against.items() if not abs(size) <= HIDDEN]:
        listed_names = ", ".join(f"'{name}' ({against[name]:+.2g} deviations)" for name in beyond)
        warn(
            f"The lean model differs from the full model by more than half of the scatter in {listed_names}. Lower"
            " `tolerance`."
        )


def _decide(model: Model, states: list[Linearization], kept_motions: list[np.ndarray], tolerance: float, same: float):
    """Return the restriction, the deformations to FIX and the number of ties; None if nothing is left out."""
    top = model.topology
    free = np.sort(np.asarray(top.e.free))
    stiffness = np.diag(np.asarray(states[0].matrices.S))
    free = free[can_be_tied(model)[free] & (stiffness[free] > 0)]
    weight = np.sqrt(stiffness[free])
    rows = [np.asarray(lin.matrices.DFe)[free] * weight[:, None] for lin in states]
    stiffnesses = [np.asarray(lin.matrices.K) for lin in states]
    # Deformations from loads and strains count too.
    loaded = np.zeros(len(free))
    for lin in states:
        moved = np.asarray(lin.matrices.e)[free] * weight
        size = moved @ moved
        loaded = np.maximum(loaded, moved**2 / size if size > 0 else 0.0)

    def lost(chosen: Any, nulls: list[np.ndarray]) -> np.ndarray:
        parts = zip(rows, nulls, stiffnesses, kept_motions, strict=True)
        return np.max([loaded[chosen], *(_lost(a[chosen] @ null, null, k, z) for a, null, k, z in parts)], axis=0)

    # Effects in the undeformed mechanism, by which the restricted model chooses its degrees of freedom.
    undeformed = constraints(model)
    motions, _ = allowed_motions(model, undeformed)
    effects = undeformed.jacobian[free] @ motions
    effects = effects if isinstance(effects, np.ndarray) else effects.toarray()
    fixed: list[int] = []
    every = [*rows, effects]
    nulls = [np.eye(matrix.shape[1]) for matrix in every]
    spent = 0.0
    for i in np.argsort(lost(np.arange(len(free)), nulls[:-1]), kind="stable"):
        left = [matrix[i] @ null for matrix, null in zip(every, nulls, strict=True)]
        if not all(
            np.linalg.norm(row) > NO_MOTION * np.linalg.norm(matrix[i]) for row, matrix in zip(left, every, strict=True)
        ):
            continue
        cost = float(lost(np.array([i]), nulls[:-1])[0])
        if spent + cost <= NEGLIGIBLE_SHARE * tolerance:
            spent += cost
            fixed.append(int(i))
            nulls = [null @ np.linalg.svd(row[None])[2][1:].T for row, null in zip(left, nulls, strict=True)]
    remaining = np.setdiff1d(np.arange(len(free)), fixed)
    basis, sizes, _ = np.linalg.svd(rows[0][remaining] @ nulls[0], full_matrices=False)
    basis = basis[:, sizes > NEGLIGIBLE * np.max(sizes, initial=0.0)]
    patterns = []
    for a, z, lin in zip(rows, kept_motions, states, strict=True):
        pattern = basis.T @ (a[remaining] @ z)
        patterns.append(pattern / np.maximum(np.linalg.norm(pattern, axis=0), 1e-300))
        moved = basis.T @ (np.asarray(lin.matrices.e)[free] * weight)[remaining]
        if np.linalg.norm(moved) > 0:
            patterns.append(moved[:, None] / np.linalg.norm(moved))
    left, sizes, _ = np.linalg.svd(np.column_stack(patterns), full_matrices=True)
    count = int(np.sum(sizes**2 > same * np.max(sizes, initial=0.0) ** 2))
    ties = (basis @ left[:, count:]).T * weight[remaining]
    ties = ties / np.max(np.abs(ties), axis=1, keepdims=True) if len(ties) else ties
    if not fixed and not len(ties):
        return None
    chosen = [int(free[i]) for i in fixed]
    return restrict(model, chosen, [int(free[i]) for i in remaining], ties), chosen, len(ties)


def _lost(rows: np.ndarray, null: np.ndarray, stiffness: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Return the largest share of the energy of a kept motion that each constraint takes, (rows,).

    In a loop, other deformations depend on a deformation: a constraint on it then takes more than its own energy.

    Args:
        rows: Constraints on the remaining motions, (rows, m).
        null: Remaining motions as columns, (n, m).
        stiffness: Stiffness, (n, n).
        kept: Motions with an energy of 1, (n, motions).
    """
    answers = np.linalg.solve(null.T @ stiffness @ null, rows.T)
    effects = null.T @ stiffness @ kept
    given = np.einsum("ij,ji->i", rows, answers)
    return np.max((answers.T @ effects) ** 2, axis=1) / np.where(given > 0, given, 1.0)


def _fewest_beams(
    build: Callable[..., Model],
    bandwidth: float,
    tolerance: float,
    nodes: Sequence[str],
    increments: Sequence[float],
    finest: int,
) -> tuple[Model, dict[str, int], Deviation]:
    """Return the model with the fewest beams of each leaf spring, the numbers of beams, and the error."""
    names = list(inspect.signature(build).parameters)
    if not names:
        raise ModelError(
            "The function of lean() has no arguments. Its arguments must be the numbers of beams of leaf springs."
        )

    def responses(counts: dict[str, int]) -> tuple[Any, list[Response]]:
        model = build(**counts)
        return model, [response(linearize(model, increment=s), nodes) for s in increments]

    def difference(base: list[Response], other: list[Response]) -> Deviation:
        return largest_deviation([deviation(a, b, bandwidth) for a, b in zip(base, other, strict=True)])

    counts: dict[str, int] = {name: finest for name in names}
    model, reference = responses(counts)
    # Convergence has order two or higher. The error is then at most a third of the change by the last doubling.
    half = difference(reference, responses(dict.fromkeys(names, max(finest // 2, 1)))[1])
    finest_error = Deviation(*(value / 3 for value in dataclasses.astuple(half)))
    spent = finest_error
    for name in names:
        while counts[name] > 1:
            fewer = counts | {name: counts[name] // 2}
            candidate, coarser = responses(fewer)
            cost = difference(reference, coarser).plus(finest_error)
            if cost.worst > tolerance / 2:
                break
            counts, model, spent = fewer, candidate, cost
    return model, counts, spent
