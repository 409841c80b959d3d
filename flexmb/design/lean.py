"""No more model than the question needs: fewer beams, fewer degrees of freedom, and what that costs."""

import dataclasses
import inspect
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..arguments import check_number, check_whole, shown
from ..build.restrict import Restriction, can_be_tied, restrict
from ..compilation.compile import unguarded
from ..compilation.threads import one_thread
from ..display import Result, Summary, listed
from ..errors import AnalysisError, ModelError, clean
from ..linear.linearize import Linearization, linearize
from ..linear.modes import modes
from ..model.model import Model
from .designs import numbers
from .deviation import Deviation, Response, deviation, in_band, largest_of, response

# Beams of a leaf spring in the model that others are measured by, unless given.
FINEST = 4
# Share of the tolerance that deformations of no account may cost together; the rest is for what is condensed.
NEGLIGIBLE = 0.1
# Directions this much smaller than the largest, by energy, are taken for the same as the others.
SAME = (1e-4, 1e-6, 1e-8, 1e-10)


@dataclasses.dataclass(frozen=True, repr=False)
class Lean(Result):
    """A lean model, and what was left out.

    Attributes:
        model: The model; an ordinary one.
        full: The model that it stands for.
        error: Estimate of its error.
        beams: Beams of each leaf spring, by the names of the arguments of the function that built it.
        fixed: Deformations that are FIXED.
        ties: Number of combinations of the other deformations that are FIXED.
        bandwidth: Of the question [Hz].
        tolerance: Of the question.
        full_frequencies: Natural frequencies of the full model, the first above the band included [Hz].
        frequencies: Those of the lean model [Hz].
        restriction: What :meth:`of` applies.
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

    def summary(self) -> Summary:
        """What is left of the degrees of freedom, and what that costs."""
        full, own, e = self.full.topology.n_q, self.model.topology.n_q, self.error
        rows = {
            "frequencies": f"{listed(self.frequencies, 'Hz')} within {100 * e.frequencies:.2g} %",
            "stiffness": f"within {100 * e.stiffness:.2g} %",
            "frequency response": f"within {100 * e.transfer:.2g} %",
            "left out": f"{len(self.fixed)} deformations FIXED, {self.ties} combinations tied",
        }
        title = f"Lean up to {self.bandwidth:g} Hz: {own} of {full} degrees of freedom ({listed(self.model.q_labels)})"
        return Summary(title, rows)

    def __str__(self) -> str:
        return self.report()

    def of(self, model: Model) -> Model:
        """The same decision for other numbers; may be traced.

        Args:
            model: A model with the structure of ``full``.

        Raises:
            ModelError: Another structure.
        """
        if model.topology.n_e != self.full.topology.n_e or model.topology.n_x != self.full.topology.n_x:
            raise ModelError("lean.of() takes a model of the same nodes and elements as lean.full.")
        return self.restriction.of(model)

    def report(self) -> str:
        """What was left out, and what it costs."""
        full, own = self.full.topology, self.model.topology
        hertz = ", ".join(f"{f:.6g}" for f in self.full_frequencies)
        lines = [
            f"Question: up to {self.bandwidth:g} Hz within {100 * self.tolerance:g} %.",
            f"Full model: {full.n_q} degrees of freedom; lean model: {own.n_q} ({', '.join(self.model.q_labels)}).",
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
        lines.append(
            f"Cost: frequencies {100 * e.frequencies:.2g} %, stiffness {100 * e.stiffness:.2g} %, frequency response"
            f" {100 * e.transfer:.2g} %."
        )
        return "\n".join(lines)


def _kept(full: list[Response], bandwidth: float, tolerance: float, bands: list[np.ndarray]) -> list[np.ndarray]:
    """Motions to keep at each state: modes of the band, and static responses as long as they are missed."""
    found = []
    for own, shapes in zip(full, bands, strict=True):
        z = shapes
        candidates = np.linalg.solve(own.K, own.directions.T)
        while z.shape[1] < len(own.K):
            if deviation(own, own.restricted(z), bandwidth).worst <= tolerance:
                break
            # What of each static response is missing, by energy.
            missing = candidates - z @ np.linalg.solve(z.T @ own.K @ z, z.T @ own.K @ candidates)
            size = np.einsum("ij,ij->j", missing, own.K @ missing)
            whole = np.einsum("ij,ij->j", candidates, own.K @ candidates)
            share = size / np.where(whole > 0, whole, 1.0) if size.size else np.zeros(0)
            if not share.size or np.max(share) < 1e-12:
                break
            z = np.column_stack([z, missing[:, int(np.argmax(share))]])
        found.append(z)
    return found


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
) -> Lean:
    """The smallest model that answers a question within a tolerance, and what it costs.

    Each leaf spring gets as few beams as will do; what hardly deforms in the band is FIXED; the other deformations are
    tied to follow the kept motions as they do in the full model: natural modes of the band, and static responses to
    the inputs and at the nodes asked for, as far as they are missed. Every candidate is measured against the full
    model.

    Args:
        model: The full model; or a function that builds it, whose arguments are numbers of beams of leaf springs.
        bandwidth: Frequencies up to here matter [Hz].
        tolerance: Relative error to allow in natural frequencies, stiffness and frequency responses.
        nodes: Nodes whose compliance in all directions matters, beside the model's inputs and outputs.
        increments: Factors of the incremental loads at which it is to hold: the stroke.
        finest: Beams of a leaf spring in the full model, where ``model`` is a function.

    Returns:
        Lean. Its ``model`` is an ordinary model, whose new deformations are named "tie".

    Raises:
        ModelError: bandwidth or tolerance is not positive, a node is not there, increments are no numbers,
            finest is below two, or the function has no arguments.
        AnalysisError: An equilibrium fails or is not stable, or no smaller model was found to be good enough.

    Source:
        Modes and static responses: Craig, Bampton (1968), AIAA Journal 6, 1313; here as constraints between the
        deformations of the elements, so that the lean model moves through large displacements.
    """
    if not isinstance(model, Model) and not callable(model):
        raise ModelError(f"Argument `model` must be a Model or a function that builds it, not {type(model).__name__}.")
    check_question(model if isinstance(model, Model) else None, bandwidth, tolerance, nodes)
    if not isinstance(increments, Iterable):
        raise ModelError(
            f"Argument `increments` must be a list of factors, such as [0.0, 5.0], not {shown(increments)}."
        )
    try:
        increments = numbers("Argument `increments`", list(increments)).ravel().tolist()
        finest = check_whole("finest", finest, 2)
    except (TypeError, ValueError) as fault:
        raise ModelError(f"{fault} Fewer beams are measured by `finest`.") from None
    if not increments or not np.all(np.isfinite(increments)):
        raise ModelError(f"Argument `increments` must be finite numbers, at least one, not {increments}.")
    beams: dict[str, int] = {}
    spent = Deviation(0.0, 0.0, 0.0)
    if isinstance(model, Model):
        whole = model
    else:
        whole, beams, spent = _fewest_beams(model, bandwidth, tolerance, nodes, increments, finest)
    states = [linearize(whole, increment=increment) for increment in increments]
    full = [response(lin, nodes) for lin in states]
    shapes = []
    for lin in states:
        found = modes(lin)
        count = in_band(np.asarray(found.frequencies), bandwidth)
        shapes.append(np.asarray(found.q_shapes)[:, :count])
    theirs = full[0].frequencies()
    for same in SAME:
        kept = _kept(full, bandwidth, NEGLIGIBLE * tolerance if same < SAME[0] else tolerance / 2, shapes)
        decided = _decide(whole, states, kept, tolerance, same)
        if decided is None:
            continue
        restriction, fixed, ties = decided
        small = restriction.of(whole)
        try:
            own = [response(linearize(small, increment=increment), nodes) for increment in increments]
        except AnalysisError:
            continue
        worst = largest_of([deviation(a, b, bandwidth) for a, b in zip(full, own, strict=True)])
        error = worst.plus(spent)
        if error.worst <= tolerance:
            names = tuple(str(whole.labels.e[i]) for i in fixed)
            these = in_band(theirs, bandwidth) + 1
            ours = own[0].frequencies()[:these]
            return Lean(
                small, whole, error, beams, names, ties, bandwidth, tolerance, theirs[:these], ours, restriction
            )
    raise AnalysisError(
        "not_lean",
        f"No smaller model answers up to {bandwidth:g} Hz within {tolerance:g}: the full one is as lean as can be."
        " Allow a larger tolerance or ask for a smaller band.",
    )


def check_question(model: Model | None, bandwidth: float, tolerance: float, nodes: Sequence[str]) -> None:
    """Refuse a question that has no answer.

    Raises:
        ModelError: One of them is not positive and finite, or not there.
    """
    for name, value in (("bandwidth", bandwidth), ("tolerance", tolerance)):
        try:
            check_number(name, value, above=0)
        except (TypeError, ValueError) as fault:
            raise ModelError(str(fault)) from None
    if isinstance(nodes, str) or not isinstance(nodes, Iterable):
        raise ModelError(f"Argument `nodes` must be a list of names, such as ['top'], not {shown(nodes)}.")
    for node in nodes:
        if model is not None and not model.labels.coordinates(node):
            raise ModelError(f"Argument `nodes`: there is no node '{clean(node)}' in the model.")


def _decide(model: Model, states: list[Linearization], kept: list[np.ndarray], tolerance: float, same: float):
    """Which deformations to FIX and which to tie; None where nothing would be left out."""
    top = model.topology
    free = np.sort(np.asarray(top.e.free))
    stiffness = np.diag(np.asarray(states[0].matrices.S))
    free = free[can_be_tied(model)[free] & (stiffness[free] > 0)]
    weight = np.sqrt(stiffness[free])
    rows = [np.asarray(lin.matrices.DFe)[free] * weight[:, None] for lin in states]
    # Energy of each deformation in each kept motion, as share of the motion's.
    shares = np.zeros(len(free))
    for a, z, lin in zip(rows, kept, states, strict=True):
        energy = np.maximum(np.sum((a @ z) ** 2, axis=0), 1e-12 * np.max(np.diag(z.T @ (a.T @ a) @ z), initial=0.0))
        shares = np.maximum(shares, np.max((a @ z) ** 2 / np.where(energy > 0, energy, 1.0), axis=1))
        # From the undeformed mechanism: what its own loads and strains do counts too.
        moved = np.asarray(lin.matrices.e)[free] * weight
        size = moved @ moved
        shares = np.maximum(shares, moved**2 / size if size > 0 else 0.0)
    n_q = rows[0].shape[1]
    fixed: list[int] = []
    null = np.eye(n_q)
    spent = 0.0
    for i in np.argsort(shares, kind="stable"):
        spent += shares[i]
        if spent > NEGLIGIBLE * tolerance:
            break
        row = rows[0][i] @ null
        if np.linalg.norm(row) > 1e-7 * np.linalg.norm(rows[0][i]):
            fixed.append(int(i))
            null = null @ np.linalg.svd(row[None])[2][1:].T
    rest = np.setdiff1d(np.arange(len(free)), fixed)
    basis, sizes, _ = np.linalg.svd(rows[0][rest] @ null, full_matrices=False)
    basis = basis[:, sizes > 1e-9 * np.max(sizes, initial=0.0)]
    patterns = []
    for a, z, lin in zip(rows, kept, states, strict=True):
        pattern = basis.T @ (a[rest] @ z)
        patterns.append(pattern / np.maximum(np.linalg.norm(pattern, axis=0), 1e-300))
        moved = basis.T @ (np.asarray(lin.matrices.e)[free] * weight)[rest]
        if np.linalg.norm(moved) > 0:
            patterns.append(moved[:, None] / np.linalg.norm(moved))
    left, sizes, _ = np.linalg.svd(np.column_stack(patterns), full_matrices=True)
    count = int(np.sum(sizes**2 > same * np.max(sizes, initial=0.0) ** 2))
    ties = (basis @ left[:, count:]).T * weight[rest]
    ties = ties / np.max(np.abs(ties), axis=1, keepdims=True) if len(ties) else ties
    if not fixed and not len(ties):
        return None
    chosen = [int(free[i]) for i in fixed]
    return restrict(model, chosen, [int(free[i]) for i in rest], ties), chosen, len(ties)


def _fewest_beams(
    build: Callable[..., Model],
    bandwidth: float,
    tolerance: float,
    nodes: Sequence[str],
    increments: Sequence[float],
    finest: int,
) -> tuple[Model, dict[str, int], Deviation]:
    """Fewest beams of each leaf spring, and what they cost against so many of them and against more."""
    names = list(inspect.signature(build).parameters)
    if not names:
        raise ModelError("The function given to lean() must have arguments: numbers of beams of leaf springs.")

    def responses(counts: dict[str, int]) -> tuple[Any, list[Response]]:
        model = build(**counts)
        return model, [response(linearize(model, increment=s), nodes) for s in increments]

    def apart(one: list[Response], other: list[Response]) -> Deviation:
        return largest_of([deviation(a, b, bandwidth) for a, b in zip(one, other, strict=True)])

    counts: dict[str, int] = {name: finest for name in names}
    model, reference = responses(counts)
    # Convergence is of order two at least: what is left is at most a third of what the last halving changed.
    half = apart(reference, responses(dict.fromkeys(names, max(finest // 2, 1)))[1])
    left = Deviation(*(value / 3 for value in dataclasses.astuple(half)))
    spent = left
    for name in names:
        while counts[name] > 1:
            fewer = counts | {name: counts[name] // 2}
            candidate, own = responses(fewer)
            cost = apart(reference, own).plus(left)
            if cost.worst > tolerance / 2:
                break
            counts, model, spent = fewer, candidate, cost
    return model, counts, spent
