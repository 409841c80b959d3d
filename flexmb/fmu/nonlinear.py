"""The nonlinear mechanism as C: rates and outputs by time, state and inputs, as core.c calls them."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..control.nonlinear_system import plant_rates
from ..errors import AnalysisError
from ..linear.loose import without_mass
from ..mechanics.extent import sizes_of
from ..model.model import Model, as_model
from ..motion.coordinates_form import coordinates_form
from ..motion.drive import Driven
from ..motion.drives_by_name import Drives, driven_by
from ..motion.kinks import kinks_of
from ..motion.loop import check_signals
from ..motion.protocol import MotionState
from ..motion.reduced_form import reduced_form
from ..results import RESULTS
from ..statics.configuration import configuration
from ..statics.equilibrium import warn_of_increment
from .translate import Unit

# Newton's method has found the dependent coordinates where as many steps again change them by less than this share of
# the extent, or radians: the error is then the square of that, or less.
FOUND = 1e-6
CALL = """\
/* Rates and outputs; not 0 where the dependent coordinates are not found, or nothing finite comes out. */
static int plant(const double *p, double t, const double *x, const double *u, double *xdot, double *y, double *memory,
                 double *work)
{
    double *w = work, *from = w + %(w)d, *next = from + %(m)d, *at = next + %(m)d, gap;
    int64_t *n = (int64_t *)(at + %(x)d);
    (void)p;
    plant_rates(&t, x, u, memory, xdot, y, next, &gap, w, n);
    /* From too far away: go there in steps, from where the degrees of freedom were. */
    for (int steps = 4; !(gap < %(found)r) && steps <= 256; steps *= 4) {
        memcpy(next, memory, %(m)d * sizeof *next);
        for (int i = 0; i < %(q)d; i++) from[i] = memory[DOF_AT[i]] - DOF_FROM[i];
        for (int k = 1; k <= steps; k++) {
            for (int i = 0; i < %(q)d; i++) {
                at[i] = from[i] + (x[i] - from[i]) * k / steps;
                at[%(q)d + i] = 0;
            }
            plant_rates(&t, k < steps ? at : x, u, next, xdot, y, next, &gap, w, n);
            if (!(gap < %(found)r)) break;
        }
    }
    if (!(gap < %(found)r)) return 1;
    for (int i = 0; i < %(x)d; i++)
        if (!isfinite(xdot[i])) return 1;
    memcpy(memory, next, %(m)d * sizeof *next);
    return 0;
}
"""


class PlantSource(NamedTuple):
    """A mechanism in C.

    Attributes:
        source: Text of a file, C99, that defines ``static int plant(const double *p, double t, const double *x, const
            double *u, double *xdot, double *y, double *memory, double *work)``: it fills ``xdot`` and ``y`` and renews
            ``memory``, where Newton's method starts, and returns 0 where all was found. No parameters are read. It
            defines ``BENDS`` too, 1 where laws may have kinks.
        states: Names of the states: degrees of freedom, then their rates.
        inputs: Names of the inputs.
        outputs: Names of the outputs.
        memory: What the memory begins with: coordinates and deformations of the undeformed mechanism, (n_x + n_e,)
            [m, rad, -].
        work: So many numbers (double) of workspace it needs.
    """

    source: str
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    memory: Float[np.ndarray, "n"]
    work: int


def plant(
    model: Model, *, loads: Mapping[str, Callable] | None = None, motion: Mapping[str, Callable] | None = None
) -> PlantSource:
    """Translate the equations of motion of a mechanism, with all their nonlinearity, to C.

    What :func:`flexmb.control.to_nonlinear_system` computes, in C without libraries: states are the degrees of freedom
    from the undeformed mechanism and their rates. The dependent coordinates are searched for from where the last call
    left them, by twice three steps of Newton's method; where that is too far away, in up to 256 steps of the degrees of
    freedom.

    Args:
        model: Mechanism with named inputs and outputs.
        loads: Loads as functions of time, see :class:`flexmb.motion.Drives`.
        motion: Prescribed motion as functions of time, see :class:`flexmb.motion.Drives`.

    Raises:
        AnalysisError: singular_mass, where a motion carries no mass.
        ModelError: The model names no inputs or no outputs, or one that has no place in a simulation; or an element or
            a function of time calls back to Python or does what has no translation.

    Source:
        THEORY.md 5, eq. (5.2), 9 (a), and 14, eq. (14.55).
    """
    model = as_model(model, "plant")
    warn_of_increment(model, "save_fmu")
    check_signals(model, "A plant")
    if massless := without_mass(model):
        raise AnalysisError("singular_mass", f"{RESULTS.singular_mass.message} {massless}")
    driven = driven_by(model, Drives(loads=loads, motion=motion))
    nameless, topology, labels = model.without_names(), model.topology, model.labels
    sizes = sizes_of(topology, model.parameters)

    def rates(t: Float[Array, ""], x: Float[Array, "n"], u: Float[Array, "n_u"], memory: Float[Array, "m"]):
        xdot, y, found = plant_rates(nameless, driven, t, x, memory, u)
        # The rates are those after this second search, which C does once.
        again = _searched(nameless, driven, t, x, found)
        gap = jnp.max(jnp.abs(again - found)[: topology.n_x] / sizes, initial=0.0)
        return xdot, y, found, gap

    start = configuration(model)
    memory = np.concatenate([start.x, np.zeros(topology.n_e)])
    n_q, n_u = topology.n_q, len(labels.inputs)
    like = jnp.zeros(()), jnp.zeros(2 * n_q), jnp.zeros(n_u), jnp.asarray(memory)
    unit = Unit()
    done = unit.add("plant_rates", rates, like, ("t", "x", "u", "memory"), ("xdot", "y", "next", "gap"), static=True)
    places = [*np.asarray(topology.x.dof).tolist(), *(topology.n_x + np.asarray(topology.e.dof)).tolist()]
    origin = [*np.asarray(model.parameters.reference)[np.asarray(topology.x.dof)].tolist()] + [0.0] * n_q
    bends = kinks_of(coordinates_form(topology, model.parameters, driven)) is not None
    table = (
        f"/* Whether laws may have kinks, which are then looked for within steps. */\n#define BENDS {int(bends)}\n"
        f"static const int DOF_AT[] = {{{', '.join(map(str, places))}}};\n"
        f"static const double DOF_FROM[] = {{{', '.join(map(repr, origin[:n_q]))}}};\n"
    )
    (w, n), m = done.work, memory.size
    call = CALL % {"w": w, "m": m, "x": 2 * n_q, "q": n_q, "found": FOUND}
    names = tuple(model.q_labels)
    return PlantSource(
        "\n".join([unit.source(), table, call]),
        names + tuple(f"d {name}" for name in names),
        tuple(signal.name for signal in labels.inputs),
        tuple(signal.name for signal in labels.outputs),
        memory,
        w + 2 * m + 2 * n_q + n,
    )


def _searched(
    model: Model, driven: tuple[Driven, ...], t: Float[Array, ""], x: Float[Array, "n"], memory: Float[Array, "m"]
):
    """Coordinates and deformations at a state, from where they were."""
    form = reduced_form(coordinates_form(model.topology, model.parameters, driven))
    q, qd = x[: form.size] / form.sizes, x[form.size :] / form.sizes
    return form.settle(t, MotionState(q, qd, memory)).memory
