"""The nonlinear mechanism as C: rates and outputs by time, state and inputs, as core.c calls them."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..control.nonlinear_system import FARTHEST, FINER, STEP, freedoms_in_memory, memory_at_start, plant_rates
from ..errors import AnalysisError
from ..linear.loose import without_mass
from ..model.model import Model, as_model
from ..motion.coordinates_form import coordinates_form
from ..motion.drives_by_name import Drives, driven_by
from ..motion.kinks import kinks_of
from ..motion.loop import check_signals
from ..numerical_limits import DEPENDENT_FOUND
from ..results import RESULTS
from ..statics.equilibrium import warn_of_increment
from .translate import Unit

CALL = Path(__file__).with_name("plant_steps.c")


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
        memory: What the memory begins with: coordinates and deformations where the builder lets a motion begin,
            (n_x + n_e,) [m, rad, -].
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
    left them, by twice three steps of Newton's method; where that is far away, in steps of the degrees of freedom.

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
    memory = memory_at_start(model)
    n_q, n_u = topology.n_q, len(labels.inputs)

    def rates(t: Array, x: Array, u: Array, memory: Array):
        return plant_rates(nameless, driven, t, x, memory, u)

    like = jnp.zeros(()), jnp.zeros(2 * n_q), jnp.zeros(n_u), jnp.asarray(memory)
    unit = Unit()
    done = unit.add("plant_rates", rates, like, ("t", "x", "u", "memory"), ("xdot", "y", "next", "gap"), static=True)
    freedoms = freedoms_in_memory(model)
    bends = kinks_of(coordinates_form(topology, model.parameters, driven)) is not None
    table = (
        f"/* Whether laws may have kinks, which are then looked for within steps. */\n#define BENDS {int(bends)}\n"
        f"static const int DOF_AT[] = {{{', '.join(map(str, freedoms.places.tolist()))}}};\n"
        + "".join(
            f"static const double DOF_{name}[] = {{{', '.join(map(repr, own.tolist()))}}};\n"
            for name, own in (("FROM", freedoms.origins), ("SIZE", freedoms.sizes))
        )
    )
    (w, n), m = done.work, memory.size
    numbers = {"WORK": w, "MEMORY": m, "X": 2 * n_q, "Q": n_q}
    numbers |= {"DEPENDENT_FOUND": DEPENDENT_FOUND, "STEP": STEP, "FARTHEST": FARTHEST, "FINER": FINER}
    defined = "\n".join(f"#define PLANT_{name} {value!r}" for name, value in numbers.items())
    call = f"{defined}\n{CALL.read_text(encoding='utf-8')}"
    names = tuple(model.q_labels)
    return PlantSource(
        "\n".join([unit.source(), table, call]),
        names + tuple(f"d {name}" for name in names),
        tuple(signal.name for signal in labels.inputs),
        tuple(signal.name for signal in labels.outputs),
        memory,
        w + 2 * m + 2 * n_q + n,
    )
