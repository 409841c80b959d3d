"""Difference of two models, and the check whether a model is too lean for a question."""

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any

import jax
import numpy as np

from ..arguments import check_number, short_repr
from ..build.restrict import can_be_tied, with_released
from ..compilation.threads import one_thread
from ..control.second_order_form import second_order
from ..display import among
from ..elements import planar, spatial
from ..errors import AnalysisError, ModelError, printable
from ..linear.linearize import Linearization, linearize
from ..linear.spectrum import symmetric_eigenvalues, to_frequency
from ..mechanics.blocks import companion_of
from ..model.model import Model
from ..model.topology import extent_of
from ..numerical_limits import NEAR_BAND, NEAR_RESONANCE, ZERO_FREQUENCY_OF_BAND

# Number of frequencies of the band at which transfer functions are compared.
POINTS = 40


@dataclasses.dataclass(frozen=True)
class Deviation:
    """Largest relative differences between two models, at rest and at all increments.

    Attributes:
        frequencies: Difference of the natural frequencies in the band, or of the first one.
        stiffness: Difference of the static response of outputs to inputs, and of the compliance of nodes.
        transfer: Difference of the frequency responses of outputs to inputs in the band, away from resonances, over the
            largest response to that input among the outputs of a kind. Rotations are multiplied by the mechanism's
            extent.
    """

    frequencies: float
    stiffness: float
    transfer: float

    @property
    def worst(self) -> float:
        """The largest difference."""
        return max(self.frequencies, self.stiffness, self.transfer)

    def plus(self, other: "Deviation") -> "Deviation":
        """Bound of the sum of two deviations."""
        return Deviation(*(a + b for a, b in zip(dataclasses.astuple(self), dataclasses.astuple(other), strict=True)))


@dataclasses.dataclass(frozen=True)
class Response:
    """Numbers of a linearised model on the host.

    Attributes:
        K, M, D: Stiffness, mass and damping, (n, n).
        B: Inputs and their two rates on the degrees of freedom, (3, n, n_u), B0, B1 and B2 of
            :func:`flexmb.control.second_order`.
        C: Outputs from the degrees of freedom and their two rates, (3, n_y, n), rotations times the extent.
        through: Outputs from inputs and their two rates, (3, n_y, n_u).
        orders: Order of each input as a derivative of a displacement, (n_u,).
        kinds: Kind of each output.
        nodes: Coordinates of the given nodes from the degrees of freedom, (k, n).
    """

    K: np.ndarray
    M: np.ndarray
    D: np.ndarray
    B: np.ndarray
    C: np.ndarray
    through: np.ndarray
    orders: np.ndarray
    kinds: tuple[str, ...]
    nodes: np.ndarray

    @property
    def directions(self) -> np.ndarray:
        """Directions of inputs, outputs and nodes in the degrees of freedom, one a row."""
        return np.concatenate([*self.B.mT, *self.C, self.nodes])

    def restricted(self, z: np.ndarray) -> "Response":
        """The same with degrees of freedom z times new ones."""
        k, m, d = (z.T @ matrix @ z for matrix in (self.K, self.M, self.D))
        parts = {"B": z.T @ self.B, "C": self.C @ z, "nodes": self.nodes @ z}
        return dataclasses.replace(self, K=k, M=m, D=d, **parts)

    def frequencies(self) -> np.ndarray:
        """Natural frequencies, ascending [Hz]."""
        return to_frequency(symmetric_eigenvalues(self.K, self.M))

    def static(self) -> tuple[np.ndarray, np.ndarray]:
        """Static response of outputs to inputs, and compliance of the nodes."""
        moved = self.C[0] @ np.linalg.solve(self.K, self.B[0]) + self.through[0]
        # The integral of an input has no static response.
        return moved * (self.orders == 0), self.nodes @ np.linalg.solve(self.K, self.nodes.T)

    def transfer(self, hertz: np.ndarray) -> np.ndarray:
        """Response of outputs to inputs at each frequency."""
        responses = []
        for w in 2 * np.pi * hertz:
            rates = (1j * w) ** np.arange(3)
            b, c, d = (np.tensordot(rates, matrices, 1) for matrices in (self.B, self.C, self.through))
            h = c @ np.linalg.solve(self.K - w**2 * self.M + 1j * w * self.D, b) + d
            responses.append(h / (1j * w) ** self.orders)
        return np.array(responses)


def response(lin: Linearization, nodes: Sequence[str]) -> Response:
    """Numbers of a linearised model; AnalysisError if the state is unstable."""
    m, labels = lin.matrices, lin.labels
    K = np.asarray(m.K)
    scale = np.sqrt(np.abs(np.diag(K)))
    scale = np.where(scale > 0, scale, 1.0)
    if np.min(np.linalg.eigvalsh(K / np.outer(scale, scale)), initial=1.0) <= len(K) * np.finfo(float).eps:
        raise AnalysisError(
            "unstable",
            "The state is unstable: the stiffness K0 + N0 is not positive definite. Support or stiffen the free motion,"
            " or lower the load.",
        )
    system: Any = second_order(lin)
    system, dfx = system._replace(M=np.asarray(system.M)), np.asarray(m.DFx)
    extent = extent_of(lin.model.topology, lin.model.parameters)
    turns = [not s.of_element and not s.parts and labels.x[s.index].kind == "rotation" for s in labels.outputs]
    motions = [s.quantity in ("position", "velocity", "acceleration") for s in labels.outputs]
    # Outputs with the same unit are of a kind; each sensor is a kind of its own.
    kinds = [s.name if s.parts else s.quantity for s in labels.outputs]
    kinds = [f"{kind} {turn and not motion}" for kind, turn, motion in zip(kinds, turns, motions, strict=True)]
    size = np.where(np.logical_and(turns, motions), extent, 1.0)[:, None]
    rows = [dfx[[*labels.known(node), *labels.coordinates(f"{node}.rotation")]] for node in nodes]
    return Response(
        K=K,
        M=system.M,
        D=np.asarray(m.D0),
        B=np.array([system.B0, system.B1, system.B2]),
        C=size * np.array([system.C0, system.C1, system.C2]),
        through=size * np.array([system.D0, system.D1, system.D2]),
        orders=system.orders,
        kinds=tuple(kinds),
        nodes=np.concatenate(rows) if rows else np.zeros((0, dfx.shape[1])),
    )


def in_band(frequencies: np.ndarray, bandwidth: float) -> int:
    """Number of frequencies in the band, but at least one."""
    return max(int(np.sum(frequencies <= bandwidth)), 1)


def deviation(full: Response, lean: Response, bandwidth: float) -> Deviation:
    """Largest relative differences of a lean model from a full one."""
    ours, theirs, zero = lean.frequencies(), full.frequencies(), ZERO_FREQUENCY_OF_BAND * bandwidth
    count = in_band(theirs, bandwidth)
    if len(ours) < count:
        return Deviation(np.inf, np.inf, np.inf)
    frequencies = np.max(np.abs(ours[:count] - theirs[:count]) / np.maximum(np.abs(theirs[:count]), zero))
    (h, c), (h0, c0) = lean.static(), full.static()
    stiffness = _largest(h - h0, _sizes(h0[None], full.kinds)[0])
    size = np.sqrt(np.abs(np.outer(np.diag(c0), np.diag(c0)))) if len(c0) else c0
    stiffness = max(stiffness, _largest(c - c0, size))
    hertz = bandwidth * np.linspace(1 / POINTS, 1, POINTS)
    distances = np.abs(hertz[:, None] / np.maximum(np.abs(theirs), zero) - 1)
    hertz = hertz[np.min(distances, axis=1) > NEAR_RESONANCE]
    t, t0 = lean.transfer(hertz), full.transfer(hertz)
    largest = np.max(_sizes(t0, full.kinds), axis=0, keepdims=True, initial=0.0)
    return Deviation(float(frequencies), stiffness, _largest(t - t0, np.broadcast_to(largest, t.shape)))


def _sizes(responses: np.ndarray, kinds: tuple[str, ...]) -> np.ndarray:
    """Largest response to each input among the outputs of a kind."""
    sizes = np.abs(responses)
    for kind in set(kinds):
        rows = [i for i, k in enumerate(kinds) if k == kind]
        sizes[:, rows] = np.max(sizes[:, rows], axis=1, keepdims=True)
    return sizes


def _largest(difference: np.ndarray, size: np.ndarray) -> float:
    fine = size > 0
    return float(np.max(np.abs(difference)[fine] / size[fine], initial=0.0))


def largest_deviation(deviations: list[Deviation]) -> Deviation:
    """The largest of several deviations, for each number by itself."""
    return Deviation(*(max(column) for column in zip(*map(dataclasses.astuple, deviations), strict=True)))


# First root of cosh(z) cos(z) = 1, for a beam with both ends held.
CLAMPED = 4.730040744862704


@one_thread()
def too_lean(model: Model, *, bandwidth: float, tolerance: float = 0.01, nodes: Sequence[str] = ()) -> tuple[str, ...]:
    """Return the reasons why a model is too lean for a question; empty if there are none.

    flexmb checks two reasons: FIXED deformations with a known stiffness, which it releases all at once, and SPACAR
    beams that vibrate between their ends.

    Args:
        model: Mechanism.
        bandwidth: Highest frequency of the question [Hz].
        tolerance: Relative error to allow.
        nodes: Nodes whose compliance matters, beside inputs and outputs.

    Returns:
        Reasons, each with a remedy.

    Raises:
        ModelError: ``model`` is no Model, bandwidth or tolerance is not positive and finite, or a node does not exist.
        AnalysisError: The equilibrium of the model, or of the model with released deformations, fails or is unstable.

    Source:
        Vibrations with both ends clamped, beside static shapes: Craig, Bampton (1968), AIAA Journal 6, 1313. The
        distance to the band is our choice.
    """
    if not isinstance(model, Model):
        raise ModelError(f"Argument `model` must be a Model, not {type(model).__name__}.")
    check_question(model, bandwidth, tolerance, nodes)
    lin = linearize(model)
    reasons = []
    stiffness = np.diag(np.asarray(lin.matrices.S))
    fixed = [i for i in np.asarray(model.topology.e.fixed).tolist() if stiffness[i] > 0 and can_be_tied(model)[i]]
    if fixed:
        fuller = linearize(with_released(model, fixed))
        worst = deviation(response(fuller, nodes), response(lin, nodes), bandwidth)
        names = among(str(model.labels.e[i]) for i in fixed)
        if worst.worst > tolerance:
            says = "adds a vibration to the band" if np.isinf(worst.worst) else f"changes it by {worst.worst:.2g}"
            reasons.append(f"{names} are FIXED; a release {says}: release them (RLSE, `released=`).")
    reasons += [
        f"Beam '{name}' vibrates between its ends at {hertz:.4g} Hz, near the band: divide it into two or more, or use"
        " a spectral beam."
        for name, hertz in _own_vibrations(model)
        if hertz < NEAR_BAND * bandwidth
    ]
    return tuple(reasons)


def _own_vibrations(model: Model) -> list[tuple[str, float]]:
    """First natural frequency of each SPACAR beam with both ends held, by name [Hz]."""
    frequencies = []
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        if block.element.usual not in (planar.beam, spatial.beam) or "stiffness" not in block.companions:
            continue
        section = jax.vmap(lambda s: s.rigidity())(companion_of(block, properties, "stiffness")[1]["section"])
        nodes = np.asarray(model.parameters.reference)[np.asarray(block.x)]
        size = model.labels.dimension
        # Nodes of a beam: position and rotation of one end, then of the other.
        second = block.splits[1]
        length = np.linalg.norm(nodes[:, second : second + size] - nodes[:, :size], axis=1)
        bending = np.array([section.EIy] if size == 2 else [section.EIy, section.EIz])
        softest = np.min(np.where(bending > 0, bending, np.inf), axis=0)
        mass = np.broadcast_to(np.asarray(section.mass), length.shape)
        with np.errstate(divide="ignore"):
            hertz = (CLAMPED / length) ** 2 * np.sqrt(softest / mass) / (2 * np.pi)
        names = [model.labels.e[row[0]].of for row in np.asarray(block.e)]
        frequencies += [(n, float(f)) for n, f in zip(names, hertz, strict=True) if np.isfinite(f)]
    return frequencies


def check_question(model: Model | None, bandwidth: float, tolerance: float, nodes: Sequence[str]) -> None:
    """Raise ModelError if bandwidth or tolerance is not positive, or a node does not exist."""
    for name, value in (("bandwidth", bandwidth), ("tolerance", tolerance)):
        try:
            check_number(name, value, above=0)
        except (TypeError, ValueError) as fault:
            raise ModelError(str(fault)) from None
    if isinstance(nodes, str) or not isinstance(nodes, Iterable):
        raise ModelError(f"Argument `nodes` must be a list of names, such as ['top'], not {short_repr(nodes)}.")
    for node in nodes:
        if model is not None and not model.labels.coordinates(node):
            raise ModelError(f"Argument `nodes`: the model has no node '{printable(node)}'.")
