"""Configuration of the mechanism at given degrees of freedom: x = F(q), and its velocity."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import as_floats, check_numbers
from ..compilation.compile import jit, unguarded
from ..compilation.record import Record, static
from ..display import Result, Summary, largest, unit_of_rate
from ..math.derivative import DIFFERENTIATED
from ..math.indices import put
from ..mechanics.deformation import Transfer, correction, deformation_jacobian, transfer, zero_strain
from ..mechanics.loads import LoadFactors, warn_of_increment
from ..model.by_name import ByName
from ..model.model import Labels, Model, as_determined
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import CONFIGURATION_STEP, CONSTRAINTS_MET, FOLDED_MECHANISM, SETTLED_CONFIGURATION
from ..results import RESULTS, check, or_nan, outcome_text
from .newton_search import prescribed_values

# 20 000 radians or extents; anything farther is out of reach, and no step is made.
MOST_STEPS = 1e5
CORRECTIONS = 8
# Additional turns at the end: near a dead point each halves the error, until it is smaller than the way there.
MORE_TURNS = 8


class Configuration(ByName, Result, Record):
    """Coordinates, deformations and velocities at given degrees of freedom.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        xd: Their velocities, (n_x,) [1/s].
        e: Deformations, (n_e,) [m, rad].
        result: Code of RESULTS.
        labels: Names.
    """

    x: Float[Array, "n_x"]
    xd: Float[Array, "n_x"]
    e: Float[Array, "n_e"]
    result: Int[Array, ""]
    labels: Labels = static()
    one_axis = "x"

    def summary(self) -> Summary:
        """Return the outcome, and the largest velocity and deformation with their names."""
        rows = {
            "result": outcome_text(self.result),
            "largest velocity": largest(self.xd, self.labels.x, unit_of_rate),
            "largest deformation": largest(self.e, self.labels.e, "[m, rad]"),
        }
        return Summary(f"Configuration: {len(self.x)} coordinates, {len(self.e)} deformations", rows)


class _Continuation(NamedTuple):
    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    step: Int[Array, ""]
    change: Float[Array, ""]


def _prescribed_share(
    topology: Topology, parameters: Parameters, q: Float[Array, "n_q"], share: Float[Array, ""] | float = 1.0
):
    """Given coordinates and deformations, a share of the way there; others as undeformed."""
    x, e = prescribed_values(topology, parameters, LoadFactors(1.0, 0.0))
    prescribed = parameters.reference + share * (x - parameters.reference), share * e
    return _with_freedoms(topology, prescribed, share * q)


def _with_freedoms(topology: Topology, prescribed: tuple[Array, Array], q: Float[Array, "n_q"]):
    x, e = prescribed
    n = topology.x.dof.shape[0]
    return put(x, topology.x.dof, x[topology.x.dof] + q[:n]), put(e, topology.e.dof, q[n:])


def _corrected(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    last_strain: Float[Array, "n_e"],
    wanted_x: Float[Array, "n_x"],
    wanted_e: Float[Array, "n_e"],
):
    """One Newton step, the deformations before it, and the transfer functions there."""
    independent = topology.x.given
    shift = put(jnp.zeros(topology.n_x), independent, (wanted_x - x)[independent])
    e, jacobian = deformation_jacobian(topology, parameters, x, last_strain)
    tangent = transfer(topology, jacobian)
    excess = e - wanted_e + jacobian @ shift
    return x + correction(topology, tangent, excess, shift), e, tangent


def configured(
    topology: Topology,
    parameters: Parameters,
    given: tuple[Float[Array, "n_x"], Float[Array, "n_e"]],
    q: Float[Array, "n_q"],
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
) -> tuple[Float[Array, "n_x"], Float[Array, "n_e"]]:
    """One Newton step towards the configuration at given degrees of freedom, and the deformations at the guess.

    ``given`` are coordinates and deformations with the PRESCRIBED ones at their values.
    """
    x, e, _ = _corrected(topology, parameters, x, near, *_with_freedoms(topology, given, q))
    return x, e


def configure(topology: Topology, parameters: Parameters, q: Float[Array, "n_q"], qd: Float[Array, "n_q"]):
    """Configuration x, velocity xd, deformations e and a code of RESULTS at given degrees of freedom."""
    sizes = coordinate_scales(topology, parameters)
    wanted_x, wanted_e = _prescribed_share(topology, parameters, q)
    independent = topology.x.given
    relative = jnp.concatenate([((wanted_x - parameters.reference) / sizes)[independent], wanted_e[topology.e.given]])
    needed = jnp.ceil(jnp.max(jnp.abs(relative), initial=0.0) / CONFIGURATION_STEP) + 1
    within = needed <= MOST_STEPS
    steps = jnp.where(within, needed, 0).astype(jnp.int32)
    settled = jax.lax.stop_gradient((parameters, q))

    def turn(continuation: _Continuation) -> _Continuation:
        parameters, q = settled
        share = jnp.minimum(continuation.step + 1, steps).astype(float) / steps.astype(float)
        wanted_x, wanted_e = _prescribed_share(topology, parameters, q, share)

        def corrected(_: Array, carried: tuple[Array, ...]):
            x, last_strain, _ = carried
            after, e, _ = _corrected(topology, parameters, x, last_strain, wanted_x, wanted_e)
            return after, e, jnp.max(jnp.abs(after - x) / jax.lax.stop_gradient(sizes), initial=0.0)

        x, last_strain, change = jax.lax.fori_loop(
            0, CORRECTIONS, corrected, (continuation.x, continuation.near, continuation.change)
        )
        return _Continuation(x, last_strain, continuation.step + 1, change)

    def goes_on(continuation: _Continuation):
        return (continuation.step < steps) | (
            within & (continuation.step < steps + MORE_TURNS) & (continuation.change > SETTLED_CONFIGURATION)
        )

    start = _Continuation(settled[0].reference, zero_strain(topology), jnp.zeros((), jnp.int32), jnp.array(0.0))
    end = jax.lax.stop_gradient(jax.lax.while_loop(goes_on, turn, start))
    wanted_x, wanted_e = _prescribed_share(topology, parameters, q)

    def differentiated(_: Array, x: Float[Array, "n_x"]):
        return _corrected(topology, parameters, x, end.near, wanted_x, wanted_e)[0]

    x = jax.lax.fori_loop(0, DIFFERENTIATED, differentiated, end.x)
    e, jacobian = deformation_jacobian(topology, parameters, x, end.near)
    tangent = transfer(topology, jacobian)
    parts = (jnp.abs(jacobian) @ sizes)[topology.e.given]
    off = jnp.abs((e - wanted_e)[topology.e.given]) / jnp.where(parts > 0, parts, 1.0)
    off = jnp.max(off, initial=0.0)
    converged = within & (off < CONSTRAINTS_MET) & (end.change <= SETTLED_CONFIGURATION)
    result = jnp.where(converged, RESULTS.successful, RESULTS.out_of_reach)
    _, undeformed = deformation_jacobian(topology, settled[0], settled[0].reference, zero_strain(topology))
    before = _moved(topology, undeformed, transfer(topology, undeformed), sizes)
    folded = converged & (_moved(topology, jacobian, tangent, sizes) > FOLDED_MECHANISM * before)
    astray = within & ~(tangent.regular & jnp.isfinite(off) & ~folded)
    result = jnp.where(astray, RESULTS.singular_configuration, result)
    return x, tangent.DFx @ qd, e, result.astype(jnp.int32)


def _moved(topology: Topology, jacobian: Float[Array, "n_e n_x"], tangent: Transfer, sizes: Float[Array, "n_x"]):
    """Largest motion of the mechanism by changes of the constraints, each a share of its parts [-]."""
    parts = (jnp.abs(jacobian) @ sizes)[topology.e.given]
    moved = jnp.sum(jnp.abs(tangent.factors.solve(jnp.diag(parts))), axis=1)
    return jnp.max(moved / sizes[topology.x.dependent], initial=0.0)


_configure = jit(configure)


@unguarded
def configuration(
    model: Model, q: Float[Array, "n_q"] | None = None, qd: Float[Array, "n_q"] | None = None, *, throw: bool = True
) -> Configuration:
    """Return position and velocity of the mechanism at given degrees of freedom.

    Args:
        model: Mechanism; differentiable in its parameters.
        q: Degrees of freedom in the order of ``model.q_labels``; coordinates as displacements from their start,
            (n_q,) [m, rad]. None: the start values of the builder, or zero.
        qd: Their rates, (n_q,) [1/s]. None: the start values of the builder, or zero.
        throw: Raise if there is no such configuration; otherwise the code is in ``result``.

    Returns:
        Configuration with x and xd (n_x,), e (n_e,).

    Raises:
        ValueError: q or qd does not have one number for each degree of freedom.
        AnalysisError: singular_configuration, also if position or velocity depends on round-off near a dead point; or
            out_of_reach.

    Warns:
        FlexmbWarning: Motions are prescribed, or temperatures given, with ``increment=True``: they are left out.

    Source:
        THEORY.md 4, eq. (4.2): Newton's method on D(x) = e, in steps.
    """
    more = as_determined(model, "configuration").parameters.increment
    if more is not None and any(moves is not None for moves in (more.x, more.e, more.temperature)):
        warn_of_increment(model, "configuration")
    return start_of(model, q, qd, throw=throw)


def start_of(
    model: Model, q: Float[Array, "n_q"] | None = None, qd: Float[Array, "n_q"] | None = None, *, throw: bool = True
) -> Configuration:
    """:func:`configuration`, without incremental loads and without a warning of them."""
    start = as_determined(model, "configuration").parameters.start
    zero = np.zeros(model.topology.n_q)
    defaults = (zero, zero) if start is None else start
    for name, value in (("q", q), ("qd", qd)):
        if value is not None:
            check_numbers(f"Argument `{name}`", value)
    values = [g if v is None else as_floats(v) for v, g in zip((q, qd), defaults, strict=True)]
    for name, value in zip(("q", "qd"), values, strict=True):
        if value.shape != zero.shape:
            raise ValueError(
                f"Argument `{name}` must have one number for each of the {zero.shape[0]} degrees of freedom"
                f" ({', '.join(model.q_labels)}), but has shape {value.shape}."
            )
    x, xd, e, result = _configure(model.topology, model.parameters, *values)
    check(result, throw)
    return or_nan(Configuration(x, xd, e, result, model.labels), result, throw)
