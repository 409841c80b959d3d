"""The nonlinear mechanism as C: rates and outputs from time, state and inputs, as called by core.c."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..control.nonlinear_system import FARTHEST, FINER, STEP, freedoms_in_memory, memory_at_start, plant_rates
from ..errors import AnalysisError
from ..linear.loose import without_mass
from ..mechanics.loads import warn_of_increment
from ..model.model import Model, as_model
from ..motion.coordinates_form import coordinates_form
from ..motion.drives_by_name import Drives, driven_by
from ..motion.kinks import kinks_of
from ..motion.loop import check_signals
from ..numerical_limits import DEPENDENT_FOUND
from ..results import RESULTS
from .translate import Unit

CALL = Path(__file__).with_name("plant_steps.c")


class PlantSource(NamedTuple):
    """A mechanism in C.

    Attributes:
        source: Text of a file, C99, that defines ``static int plant(const double *p, double t, const double *x, const
            double *u, double *xdot, double *y, double *memory, double *work)``. The function computes ``xdot`` and
            ``y`` and updates ``memory``, the start of Newton's method. It returns 0 on success. ``BENDS`` is 1 if laws
            may have kinks.
        states: Names of the states: degrees of freedom, then their rates.
        inputs: Names of the inputs.
        outputs: Names of the outputs.
        memory: Start of the memory: coordinates and deformations at the builder's start, (n_x + n_e,) [m, rad, -].
        work: Number of entries (double) of the workspace.
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
    """Translate the nonlinear equations of motion of a mechanism to C without libraries.

    States are the degrees of freedom from the undeformed mechanism and their rates. The search for the dependent
    coordinates starts from the last call, with up to twice three steps of Newton's method; over a long way it takes
    steps of the degrees of freedom.

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
    translation = unit.add(
        "plant_rates", rates, like, ("t", "x", "u", "memory"), ("xdot", "y", "next", "gap"), static=True
    )
    freedoms = freedoms_in_memory(model)
    bends = kinks_of(coordinates_form(topology, model.parameters, driven)) is not None
    lists = {"FROM": freedoms.origins.tolist(), "SIZE": freedoms.sizes.tolist()}
    table = (
        f"/* Whether laws may have kinks, which are then looked for within steps. */\n#define BENDS {int(bends)}\n"
        f"static const int DOF_AT[] = {{{', '.join(map(str, freedoms.places.tolist()))}}};\n"
        + "".join(f"static const double DOF_{n}[] = {{{', '.join(map(repr, v))}}};\n" for n, v in lists.items())
    )
    (w, n), m = translation.work, memory.size
    numbers = {"WORK": w, "MEMORY": m, "X": 2 * n_q, "Q": n_q}
    numbers |= {"FOUND": DEPENDENT_FOUND, "STEP": STEP, "FARTHEST": FARTHEST, "FINER": FINER}
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
