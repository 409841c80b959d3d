"""The plant of a functional mock-up unit in numbers and names: linear, time-varying or nonlinear."""

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..arguments import numbers, short_repr
from ..control.nonlinear_system import FARTHEST, FINER, STEP, freedoms_in_memory, memory_at_start, plant_rates
from ..control.state_space import state_matrices
from ..display import unit_of
from ..errors import AnalysisError, ModelError, printable
from ..linear.about import asked_about
from ..linear.linearize import Linearization
from ..linear.loose import without_mass
from ..mechanics.loads import warn_of_increment
from ..model.model import Model
from ..motion.coordinates_form import coordinates_form
from ..motion.drives_by_name import Drives, driven_by
from ..motion.kinks import kinks_of
from ..motion.loop import check_signals
from ..numerical_limits import DEPENDENT_FOUND
from ..results import RESULTS
from ..trajectory.linear_along import TimeVarying
from .translate import Unit
from .writer import c_array, c_numbers

# Typical size of a state, for the importer's error control: a millimetre for a mechanism, 1 for an unknown system.
NOMINAL_OF_MECHANISM = 1e-3
# Characters that XML or FMI forbid in names.
FORBIDDEN = "[\x00-\x1f\x7f\ud800-\udfff\ufffe\uffff]"
# Quantity of a unit.
MOTION_OF = {"m": "Displacement", "rad": "Rotation"}
UNDEFORMED = "the undeformed mechanism"
STEPS = Path(__file__).with_name("plant_steps.c")


class Variable(NamedTuple):
    """One number or array of a unit.

    Attributes:
        name: Name for importers.
        unit: SI unit in Modelica's notation, such as "N.m"; empty if unknown.
        start: Value at the start.
        nominal: Typical size of a state.
        description: Description for importers.
        origin: Coordinate from which an output counts that is a displacement [m]; None for other outputs.
    """

    name: str
    unit: str = ""
    start: Any = 0.0
    nominal: float = 1.0
    description: str = ""
    origin: float | None = None


class Plant(NamedTuple):
    """The plant of a unit, the interface between Python and the C of this folder.

    Attributes:
        inputs: Inputs in order.
        outputs: Outputs in order; :func:`with_unique_names` adds nominal inputs and outputs, then absolute positions.
        states: States in order, with their values at the start.
        matrices: A, B, C, D, u0, y0 of a linear or time-varying plant, in this order, (n_t, ..) each, without a zero D,
            and without u0 and y0 of a linear one.
        times: Knots of a time-varying plant, (n_t,) [s].
        substep: Longest step of its integration [s].
        parameters: Parameters of a nonlinear plant, in order.
        source: Text of plant.c of a nonlinear plant; core.c describes its definitions.
        memory: Start values that a nonlinear plant passes from call to call.
        work: Number of entries of its workspace.
    """

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    states: tuple[Variable, ...]
    matrices: Mapping[str, np.ndarray] = {}
    times: np.ndarray | None = None
    substep: float = 0.0
    parameters: tuple[Variable, ...] = ()
    source: str = ""
    memory: Sequence[float] = ()
    work: int = 0

    @property
    def n_nominal(self) -> int:
        """Number of nominal inputs and outputs, which are also outputs."""
        return sum(self.matrices[name].shape[-1] for name in ("u0", "y0") if name in self.matrices)

    @property
    def displacements(self) -> list[int]:
        """Numbers of the outputs with absolute positions, which are the last outputs."""
        return [i for i, v in enumerate(self.outputs) if v.origin is not None]

    @property
    def n_own(self) -> int:
        """Number of outputs without nominal inputs and outputs and absolute positions."""
        return len(self.outputs) - self.n_nominal - len(self.displacements)


def with_unique_names(plant: Plant) -> Plant:
    """Return the plant with unique names: an input and an output with one name both name their kind.

    States are named "state q", nominal inputs and outputs "nominal u", absolute positions "absolute y".
    """
    shared = {v.name for v in plant.inputs} & {v.name for v in plant.outputs}

    def with_kind(kind: str, variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
        return tuple(v._replace(name=f"{kind} {v.name}") if v.name in shared else v for v in variables)

    for kind in ("input", "output", "state"):
        for v in getattr(plant, kind + "s"):
            if not v.name.strip() or re.search(FORBIDDEN, v.name):
                raise ValueError(
                    f"The {kind} '{printable(v.name)}' has a name that FMI forbids. Give it one that is not empty,"
                    " without line feeds, tabs or other control characters."
                )
    inputs, outputs = with_kind("input", plant.inputs), with_kind("output", plant.outputs)
    states = tuple(v._replace(name=f"state {v.name}") for v in plant.states)
    if "u0" in plant.matrices:
        outputs += tuple(v._replace(name=f"nominal {v.name}", origin=None) for v in (*inputs, *outputs))
    outputs += tuple(
        Variable(f"absolute {v.name}", v.unit, description=f"'{v.name}' plus {v.origin:.9g} {v.unit}")
        for v in outputs
        if v.origin is not None
    )
    return plant._replace(inputs=inputs, outputs=outputs, states=states)


def modelica(unit: str) -> str:
    """An SI unit as FMUs write it."""
    return unit.replace(" ", ".").replace("²", "2")


def mechanism_plant(model: Model | Linearization, modes: Any, bandwidth: Any) -> Plant:
    """Linear plant of a mechanism about its equilibrium, or of its linearisation."""
    about: Any = model
    if isinstance(model, Model):
        few = modes is not None or bandwidth is not None
        about = asked_about(model, "save_fmu", few=few)
    system, names = state_matrices(about, modes=modes, bandwidth=bandwidth)
    labels = model.labels
    if not labels.inputs or not labels.outputs:
        raise ModelError("The model has no inputs or no outputs. Name them with input() and output().")
    if np.ndim(system.A) > 2:
        raise ModelError(
            f"This linearisation is along a motion, at {len(system.A)} times. Give lin.at_time(0), or the time-varying"
            " system of the motion."
        )
    whence = "the static equilibrium" if isinstance(model, Model) else "the state of the linearisation"
    inputs, outputs, states = _variables(about.model, names, np.asarray(about.x), whence)
    return linear_plant(*system, inputs, outputs, states)


def units_of(model: Model, names: Sequence[str]) -> dict[str, str]:
    """SI units of a mechanism by the names of inputs, outputs and states, if known."""
    return {v.name: v.unit for variables in _variables(model, names) for v in variables if v.unit and v.name}


def nonlinear(
    model: Model, loads: Mapping[str, Callable] | None = None, motion: Mapping[str, Callable] | None = None
) -> Plant:
    """Nonlinear plant of a mechanism in C, from the builder's start values, or undeformed and at rest.

    States are the degrees of freedom from the undeformed mechanism and their rates. The search for the dependent
    coordinates starts from the last call, with up to twice three steps of Newton's method; over a long way it takes
    steps of the degrees of freedom. Its memory starts from all coordinates and deformations at the builder's start
    (THEORY.md 5, eq. (5.2), 9 (a), and 14, eq. (14.55)).
    """
    warn_of_increment(model, "save_fmu")
    check_signals(model, "A plant")
    if massless := without_mass(model):
        raise AnalysisError("singular_mass", f"{RESULTS.singular_mass.message} {massless}")
    driven = driven_by(model, Drives(loads=loads, motion=motion))
    nameless, topology = model.without_names(), model.topology
    n_q, memory, freedoms = topology.n_q, memory_at_start(model), freedoms_in_memory(model)

    def rates(t: Array, x: Array, u: Array, memory: Array):
        return plant_rates(nameless, driven, t, x, memory, u)

    like = jnp.zeros(()), jnp.zeros(2 * n_q), jnp.zeros(len(model.labels.inputs)), jnp.asarray(memory)
    unit = Unit()
    arguments, results = ("t", "x", "u", "memory"), ("xdot", "y", "next", "gap")
    w, n = unit.add("plant_rates", rates, like, arguments, results, static=True).work
    bends = kinks_of(coordinates_form(topology, model.parameters, driven)) is not None
    limits = {"WORK": w, "MEMORY": memory.size, "X": 2 * n_q, "Q": n_q}
    limits |= {"FOUND": DEPENDENT_FOUND, "STEP": STEP, "FARTHEST": FARTHEST, "FINER": FINER}
    source = [
        unit.source(),
        f"/* Whether laws may have kinks, which are then looked for within steps. */\n#define BENDS {int(bends)}",
        c_array("int", "DOF_AT", [str(place) for place in freedoms.places]),
        c_numbers("DOF_FROM", freedoms.origins),
        c_numbers("DOF_SIZE", freedoms.sizes),
        *(f"#define PLANT_{name} {value!r}" for name, value in limits.items()),
        STEPS.read_text(encoding="utf-8"),
    ]
    states = [*model.q_labels, *(f"d {name}" for name in model.q_labels)]
    signals = _variables(model, states, np.asarray(model.parameters.reference), UNDEFORMED)
    work = w + 2 * memory.size + 2 * n_q + n
    plant = Plant(*signals, source="\n".join(source), memory=memory.tolist(), work=work)
    at = model.parameters.start
    return plant if at is None else started(plant, np.concatenate(at).tolist())


def _variables(
    model: Model, states: Sequence[str], origin: np.ndarray | None = None, whence: str = ""
) -> tuple[tuple[Variable, ...], tuple[Variable, ...], tuple[Variable, ...]]:
    """Inputs, outputs and states with units; displacements count from ``origin``, described by ``whence``."""
    units = {str(entry): unit_of(entry).replace("-", "") for entry in model.labels.x}
    units |= {f"d {name}": f"{unit}/s" if unit else "" for name, unit in units.items()}

    def variable(name: str, unit: str, nominal: float = 1.0, at: int | None = None):
        motion = MOTION_OF.get(unit) if whence else None
        start = float(origin[at]) if origin is not None and at is not None and unit == "m" else None
        return Variable(name, unit, 0.0, nominal, f"{motion} from {whence}" if motion else "", start)

    inputs = tuple(variable(s.name, modelica(s.port(model.labels).unit)) for s in model.labels.inputs)
    outputs = tuple(variable(s.name, modelica(s.port(model.labels).unit), at=s.index) for s in model.labels.outputs)
    return inputs, outputs, tuple(variable(name, units.get(name, ""), NOMINAL_OF_MECHANISM) for name in states)


def state_space_plant(system: Any) -> Plant:
    """Linear plant of a ``control.StateSpace``, which has names and no units."""
    if system.dt:
        rate = "" if system.dt is True else f" (dt = {system.dt:g} s)"
        raise ValueError(f"This state space is sampled{rate}. Give the continuous system.")
    labels = (system.input_labels, system.output_labels, system.state_labels)
    return linear_plant(
        system.A, system.B, system.C, system.D, *([Variable(name) for name in names] for names in labels)
    )


def linear_plant(a: Any, b: Any, c: Any, d: Any, inputs: Any, outputs: Any, states: Any) -> Plant:
    """Linear plant of matrices and names."""
    matrices = {name: np.asarray(m, float)[None] for name, m in zip("ABCD", (a, b, c, d), strict=True)}
    return _checked(Plant(tuple(inputs), tuple(outputs), tuple(states), matrices))


def time_varying_plant(system: TimeVarying, substep: float | None) -> Plant:
    """Time-varying plant of a system along a motion, with total inputs and outputs (nominal plus deviation).

    The default substep is a quarter of the shortest time between two knots [s].
    """
    t = np.asarray(system.t, float)
    if len(t) < 2 or not np.all(np.diff(t) > 0):
        raise ValueError("The times do not ascend. A time-varying system needs at least two ascending times.")
    substep = float(np.min(np.diff(t))) / 4 if substep is None else substep
    matrices = {name: np.asarray(getattr(system, name), float) for name in ("A", "B", "C", "D", "u0", "y0")}
    starts = np.asarray(matrices["u0"])[0]
    inputs = tuple(Variable(name, start=float(at)) for name, at in zip(system.input_labels, starts, strict=True))
    states = tuple(Variable(name) for name in system.state_labels)
    origins = [np.nan] * len(system.output_labels) if system.origins is None else np.asarray(system.origins).tolist()
    explanation = f"{MOTION_OF['m']} from {UNDEFORMED}"
    outputs = tuple(
        Variable(name) if np.isnan(at) else Variable(name, "m", description=explanation, origin=at)
        for name, at in zip(system.output_labels, origins, strict=True)
    )
    return _checked(Plant(inputs, outputs, states, matrices, t, substep))


def _checked(plant: Plant) -> Plant:
    if not plant.inputs or not plant.outputs or not plant.states:
        raise ValueError("The system has no inputs, no outputs or no states. An FMU needs at least one of each.")
    for name, m in plant.matrices.items():
        if not np.all(np.isfinite(m)):
            place = ", ".join(str(i + 1) for i in np.argwhere(~np.isfinite(m))[0][m.shape[0] == 1 :])
            raise ValueError(f"{name}[{place}] is no finite number. The FMU would return no finite results.")
    matrices = {name: m for name, m in plant.matrices.items() if name != "D" or np.any(m)}
    return plant._replace(matrices=matrices)


def started(plant: Plant, start: Mapping[str, float] | Sequence[float] | None) -> Plant:
    """The plant with other start values of states, by name or all in order."""
    if start is None:
        return plant
    names = [v.name for v in plant.states]
    start_by_name = dict(start) if isinstance(start, Mapping) else None
    if start_by_name is not None and (unknown := [name for name in start_by_name if name not in names]):
        names_of = ", ".join(names)
        raise ValueError(f"Argument `start` names '{printable(unknown[0])}', which is no state: there are {names_of}.")
    values = numbers([start_by_name.get(v.name, v.start) for v in plant.states] if start_by_name is not None else start)
    if values is None or values.shape != (len(names),) or not np.all(np.isfinite(values)):
        raise ValueError(
            f"Argument `start` must be {len(names)} finite numbers, one for each state, or a dictionary of them, but is"
            f" {short_repr(start)}."
        )
    return plant._replace(states=tuple(v._replace(start=float(at)) for v, at in zip(plant.states, values, strict=True)))


def plant_with_units(plant: Plant, units: Mapping[str, str] | None) -> Plant:
    """The plant with units of inputs, outputs and states, by name; raise ValueError for a wrong name or unit."""
    kinds = {kind: getattr(plant, kind) for kind in ("inputs", "outputs", "states")}
    names = [v.name for variables in kinds.values() for v in variables]
    for name, unit in (units or {}).items():
        if name not in names:
            raise ValueError(f"Argument `units` names '{printable(name)}', which is none of {', '.join(names)}.")
        if not isinstance(unit, str) or re.search(FORBIDDEN, unit):
            raise ValueError(
                f"Argument `units` must give texts such as 'N.m', not {short_repr(unit)} for '{printable(name)}'."
            )
    new_units = dict(units or {})
    changed = {
        kind: tuple(v._replace(unit=new_units.get(v.name, v.unit)) for v in variables)
        for kind, variables in kinds.items()
    }
    return plant._replace(**changed)
