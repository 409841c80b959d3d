"""The linearised mechanism as a state-space model of python-control."""

from typing import TYPE_CHECKING, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .analysis.linearize import Linearization, Matrices, linearize
from .errors import AnalysisError, ModelError
from .math.compile import jit
from .math.indices import put
from .math.linear import factorise
from .math.subspace import independent_rows
from .model.model import Model, Signal
from .model.roles import Role
from .results import RESULTS

if TYPE_CHECKING:
    import control

# A motion whose mass is below this share of the largest, every degree of freedom scaled to unit mass, has none.
MASSLESS = 1e-13


class StateMatrices(NamedTuple):
    """z_dot = A z + B u, y = C z + D u with z = (q, q_dot) of the degrees of freedom that carry mass.

    Attributes:
        A: (2 n, 2 n).
        B: (2 n, n_u).
        C: (n_y, 2 n).
        D: (n_y, n_u).
    """

    A: Float[Array, "z z"]
    B: Float[Array, "z n_u"]
    C: Float[Array, "n_y z"]
    D: Float[Array, "n_y n_u"]


def _massless(lin: Linearization) -> list[int]:
    """Degrees of freedom to condense, so that the mass matrix of the rest is regular."""
    mass = np.asarray(lin.matrices.M0)
    diagonal = np.diag(mass)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(mass * scale[:, None] * scale)
    null = vectors[:, values <= MASSLESS * len(values)] * scale[:, None]
    chosen, _ = independent_rows(null, null.shape[1], 0.0)
    return sorted(chosen)


@jit
def _state_matrices(
    m: Matrices, inputs: tuple[Signal, ...], outputs: tuple[Signal, ...], condensed: tuple[int, ...]
) -> StateMatrices:
    """Second-order system with massless motions condensed statically, then in first-order form."""
    n_q = m.M0.shape[0]
    kept = np.array([i for i in range(n_q) if i not in condensed], int)
    out = np.array(condensed, int)
    forces = [-m.DFe[s.index] if s.quantity == "stress" else m.DFx[s.index] for s in inputs]
    b = jnp.stack(forces, axis=1) if forces else jnp.zeros((n_q, 0))
    damping = m.C0 + m.D0
    keep, direct = jnp.eye(n_q)[:, kept], jnp.zeros((n_q, b.shape[1]))
    if condensed:
        # Columns of null span the motions without mass: M null = 0. Their equilibrium has no inertia in it.
        null = put(jnp.zeros((n_q, len(out))), out, jnp.eye(len(out)))
        null = put(null, kept, -factorise(m.M0[np.ix_(kept, kept)]).solve(m.M0[np.ix_(kept, out)]))
        stiff = factorise(null.T @ m.K @ null)
        direct = null @ stiff.solve(null.T @ b)
        keep = keep - null @ stiff.solve(null.T @ m.K @ keep)
    mass, stiffness = keep.T @ m.M0 @ keep, keep.T @ m.K @ keep
    inverse = factorise(mass)
    n = len(kept)
    lower = jnp.concatenate([-inverse.solve(stiffness), -inverse.solve(keep.T @ damping @ keep)], axis=1)
    upper = jnp.concatenate([jnp.zeros((n, n)), jnp.eye(n)], axis=1)
    drive = inverse.solve(keep.T @ (b - m.K @ direct))
    position = jnp.concatenate([keep, jnp.zeros((n_q, n))], axis=1)
    velocity = jnp.concatenate([jnp.zeros((n_q, n)), keep], axis=1)
    rows, feedthrough = [], []
    for s in outputs:
        of_q = m.DFx[s.index] if s.quantity in ("position", "velocity", "acceleration") else m.DFe[s.index]
        through = jnp.zeros(b.shape[1])
        if s.quantity in ("position", "deformation"):
            row, through = of_q @ position, of_q @ direct
        elif s.quantity in ("velocity", "deformation rate"):
            row = of_q @ velocity
        elif s.quantity in ("acceleration", "deformation acceleration"):
            row, through = of_q @ keep @ lower, of_q @ keep @ drive
        else:
            stress, rate = m.S[s.index] @ m.DFe, m.S_d[s.index] @ m.DFe
            row, through = stress @ position + rate @ velocity, stress @ direct
            through = through + jnp.array([float(u.quantity == "stress" and u.index == s.index) for u in inputs])
        rows.append(row)
        feedthrough.append(through)
    c = jnp.stack(rows) if rows else jnp.zeros((0, 2 * n))
    d = jnp.stack(feedthrough) if feedthrough else jnp.zeros((0, b.shape[1]))
    drive = jnp.concatenate([jnp.zeros((n, b.shape[1])), drive])
    return StateMatrices(jnp.concatenate([upper, lower]), drive, c, d)


def state_matrices(model: Model | Linearization) -> tuple[StateMatrices, list[str]]:
    """State-space matrices about the static equilibrium, for the model's named inputs and outputs.

    Motions without mass are condensed statically (their damping is left out), so that the states are those of the
    degrees of freedom that carry mass.

    Args:
        model: Mechanism, or its linearisation; differentiable in its parameters for named inputs and outputs. Which
            motions carry no mass is decided on concrete numbers; under a trace all are taken to carry mass.

    Returns:
        A, B, C, D (shapes in StateMatrices) [SI], and the names of the states.

    Raises:
        ModelError: An output is the stress of a FIXED deformation.
        AnalysisError: singular_mass where nothing carries mass.

    Source:
        FORMULATION.md 7; tutorial WA 1239 (2012), eq. (2.3) and (A.4): A = [[0, I], [-M0^-1 K, -M0^-1 (C0 + D0)]],
        a stress input adds to sigma: B = -M0^-1 DFe^T.
    """
    import jax.core

    lin = model if isinstance(model, Linearization) else linearize(model)
    labels = lin.labels
    traced = isinstance(lin.matrices.M0, jax.core.Tracer)
    if not traced:
        roles = lin.model.roles()[1]
        for s in labels.outputs:
            if s.quantity == "stress" and roles[s.index] in (Role.FIXED, Role.PRESCRIBED):
                raise ModelError(
                    f"Output '{s.name}' is the stress of a {roles[s.index].value} deformation, a constraint force,"
                    " which the state-space model does not give. Release the deformation and give it a stiffness."
                )
    condensed = () if traced else tuple(_massless(lin))
    names = [name for i, name in enumerate(lin.model.q_labels) if i not in condensed] if not traced else []
    if not traced and not names:
        raise AnalysisError("singular_mass", RESULTS.singular_mass.message + " Here no motion carries mass.")
    found = _state_matrices(lin.matrices, inputs=labels.inputs, outputs=labels.outputs, condensed=condensed)
    return found, names + [f"d {name}" for name in names]


def to_statespace(model: Model | Linearization) -> "control.StateSpace":
    """The linearised mechanism as a ``control.StateSpace`` with names for states, inputs and outputs.

    Args:
        model: Mechanism, or its linearisation.

    Returns:
        control.StateSpace; matrices as :func:`state_matrices`.

    Raises:
        ModelError: The model names no inputs or no outputs, or an output that cannot be given.
        AnalysisError: singular_mass.

    Source:
        See :func:`state_matrices`.
    """
    import control

    lin = model if isinstance(model, Linearization) else linearize(model)
    inputs, outputs = ([s.name for s in found] for found in (lin.labels.inputs, lin.labels.outputs))
    if not inputs or not outputs:
        raise ModelError("A state-space model needs an input and an output: name them with input() and output().")
    found, states = state_matrices(lin)
    # control refuses a dot in a name.
    clean = [[name.replace(".", " ") for name in names] for names in (states, inputs, outputs)]
    return control.StateSpace(*(np.asarray(m) for m in found), states=clean[0], inputs=clean[1], outputs=clean[2])
