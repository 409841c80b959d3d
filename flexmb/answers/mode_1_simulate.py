"""Mode 1: motion in time."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial
from jaxtyping import Array, ArrayLike, Float

from ..control.state_space import state_matrices
from ..errors import SpacarError
from ..linear.linearize import Linearization, Matrices
from ..linear.loose import without_mass
from ..linear.spectrum import general_spectrum, is_real, massless_freedoms, to_frequency
from ..model.model import Entry, Model
from ..model.topology import Role, extent_of
from ..motion.linearized import linearize_motion
from ..motion.motion import Motion
from ..motion.simulate import simulate
from ..results import RESULTS
from ..spacar.reading import Setting
from ..spacar.trajectories import laws_of, role_of, ways_of
from ..trajectory.about_motion import inputs_that_move, outputs_of
from .answer_parts import SHOWN_VALUES, is_shown, row
from .mode import Mode, ModeRequest, ModeResult

RTOL = 1e-5
# Most bytes of the output times of a motion. A number is kept in arrays, in lists and as text: 300 bytes, measured with
# 200 000 times of a truss. The arrays of the linearised equations take 24 000 bytes a time beside their numbers.
LARGEST_ANSWER = 4 * 2**30
BYTES_A_NUMBER = 300
BESIDE_MATRICES = 80


def _uniformly_accelerated(
    t: Float[Array, ""], value: Float[Array, ""], velocity: Float[Array, ""], acceleration: Float[Array, ""]
):
    """Prescribed value with constant acceleration."""
    return value + velocity * t + 0.5 * acceleration * t**2


def motions_of(model: Model, settings: dict[str, Any]) -> dict[str, Partial]:
    """Functions of time of INPUTX and INPUTE with a velocity or an acceleration."""
    motions = {}
    for keyword, entries, start in (
        ("INPUTX", model.labels.x, np.asarray(model.parameters.reference)),
        ("INPUTE", model.labels.e, np.zeros(len(model.labels.e))),
    ):
        for owner, component, value, *rates in settings.get(keyword, []):
            if any(rates):
                index = next(i for i, n in enumerate(entries) if n.of == str(owner) and n.component == component)
                numbers = (jnp.asarray(number) for number in (value - start[index], *rates))
                motions[str(entries[index])] = Partial(_uniformly_accelerated, **dict(zip(NAMES, numbers, strict=True)))
    return motions


NAMES = ("value", "velocity", "acceleration")
# A motion that ended with one of these has states. Any other has not begun.
PARTLY = (
    RESULTS.successful,
    RESULTS.step_too_small,
    RESULTS.step_too_large,
    RESULTS.motion_unfinished,
    RESULTS.ran_away,
    RESULTS.stopped,
)


def times_of(name: str, settings: dict[str, Any], numbers: int = 1, needed: str = "") -> np.ndarray:
    """Output times that TIMESTEP asks for, (n_t,) [s]; SpacarError without one, or if the answer would be too large."""
    if "TIMESTEP" not in settings:
        problem = (
            f"{needed}: needs TIMESTEP in the dynamics block" if needed else f"{name}: TIMESTEP: modes 1 and 4 need it"
        )
        raise SpacarError(f"{problem}: TIMESTEP end steps, such as TIMESTEP 1.0 100")
    setting = settings["TIMESTEP"]
    steps, most = int(setting["steps"]), LARGEST_ANSWER // (BYTES_A_NUMBER * numbers)
    if steps > most:
        at = f"{name}:{setting.line}" if isinstance(setting, Setting) else name
        raise SpacarError(
            f"{at}: TIMESTEP: {steps} steps of {numbers} numbers take {steps * numbers * BYTES_A_NUMBER:.3g} bytes,"
            f" but {LARGEST_ANSWER:.3g} is the most; give at most {most} steps"
        )
    return np.linspace(0.0, setting["end"], steps + 1)


def over_time(values: ArrayLike, entries: Sequence[Entry]) -> dict[str, list]:
    """Columns of a history by their node or element, one row per time."""
    grouped: dict[str, list[int]] = {}
    for i, entry in enumerate(entries):
        if is_shown(entry):
            grouped.setdefault(entry.of, []).append(i)
    values = np.asarray(values)
    return {owner: values[:, columns].tolist() for owner, columns in grouped.items()}


def origins(model: Model) -> np.ndarray:
    """Origins of the outputs, (n_y,): a file means coordinates, not displacements."""
    start = np.asarray(model.parameters.reference)
    return np.array(
        [start[s.index] if s.quantity == "position" and s.axis is None else 0.0 for s in model.labels.outputs]
    )


def steps_of(found: Motion) -> tuple[dict[str, Any], list[str]]:
    """Linearised equations at every time, null where there are none, with a warning."""
    along, labels = linearize_motion(found), found.labels
    named = {"inputs": [s.name for s in labels.inputs], "outputs": [s.name for s in labels.outputs]}
    # One conversion to numpy, whose slices cost nothing.
    matrices, steps, lost = jax.tree.map(np.asarray, along.matrices), [], []
    state_spaces = _state_spaces(matrices, found.model) if all(named.values()) else {}
    for i, t in enumerate(np.asarray(found.t).tolist()):
        m = jax.tree.map(lambda a, i=i: a[i], matrices)
        by_name: dict[str, Any] = {name: np.asarray(getattr(m, name)) for name in ("M0", "C0", "D0", "K0", "N0", "G0")}
        if int(m.result) != RESULTS.successful:
            lost.append(t)
            steps.append({"time": t, "frequencies_hz": [], **{name.lower(): None for name in by_name}})
            continue
        values, _ = general_spectrum(by_name["K0"] + by_name["N0"] + by_name["G0"], by_name["M0"])
        # Massless motions have infinite frequencies.
        values = values[np.isfinite(values)]
        real = is_real(values) & (values.real >= 0)
        hertz = [f if known else None for f, known in zip(to_frequency(values.real).tolist(), real, strict=True)]
        by_name |= state_spaces.get(i, {})
        lower = {name.lower() if len(name) > 1 else name: value for name, value in by_name.items()}
        steps.append({"time": t, "frequencies_hz": hertz, **lower})
    warnings = [
        f"At {len(lost)} of {len(steps)} times, first at {t:.6g} s, the degrees of freedom do not determine the"
        " configuration, or a motion has no mass: there are no matrices there."
        for t in lost[:1]
    ]
    return {"steps": steps, **named}, warnings


def _state_spaces(matrices: Matrices, model: Model) -> dict[int, dict[str, np.ndarray]]:
    """A, B, C, D by the indices of their times; times with the same massless motions are taken together."""
    alike: dict[tuple[int, ...], list[int]] = {}
    for i in np.flatnonzero(matrices.result == RESULTS.successful).tolist():
        alike.setdefault(tuple(massless_freedoms(np.asarray(matrices.M0[i]))), []).append(i)
    state_spaces = {}
    for rows in alike.values():
        some = Linearization(jax.tree.map(lambda a, rows=rows: a[rows], matrices), model)
        of_state, _ = state_matrices(some)
        named = {name: np.asarray(value) for name, value in of_state._asdict().items()}
        state_spaces |= {i: {name: values[place] for name, values in named.items()} for place, i in enumerate(rows)}
    return state_spaces


def _idle_ways(asked: ModeRequest) -> list[str]:
    """Warnings of prescribed ways of degrees of freedom, which move by themselves."""
    return [
        f"{way.keyword} on line {way.legs[0].line} belongs to a degree of freedom, which moves freely here; it acts in"
        " modes 2, 3, 5 and 6."
        for key, way in ways_of(asked.settings).items()
        if role_of(asked.builder, key) is Role.DOF
    ]


def run(asked: ModeRequest, linearised: bool = False) -> ModeResult:
    """Motion in time from TIMESTEP, ERROR, INPUTX and INPUTE; with ``linearised`` at every output time the matrices."""
    model, settings = asked.checked(), asked.settings
    n_x, n_e, n_q = len(model.labels.x), len(model.labels.e), model.topology.n_q
    n_u, n_y = len(model.labels.inputs), len(model.labels.outputs)
    matrices = BESIDE_MATRICES + 6 * n_q**2 + (2 * n_q + n_u) * (2 * n_q + n_y) if linearised else 0
    times = times_of(asked.name, settings, 4 + 2 * (n_x + n_e) + matrices)
    error = settings.get("ERROR", {})
    extent = extent_of(model.topology, model.parameters)
    rtol = error.get("relative", RTOL)
    # ERROR holds in metres and radians. An integrator takes shares of the extent, and radians.
    atol = error["absolute"] / max(extent, 1.0) if "absolute" in error else None
    driven = motions_of(model, settings) | laws_of(asked.builder, model.labels, settings, Role.PRESCRIBED)
    asked.warnings += _idle_ways(asked)
    motion = simulate(model, times, motion=driven, rtol=rtol, atol=atol, progress=asked.reported, throw=False)
    code = RESULTS(int(motion.result))
    extra = {"status": "ok" if code == RESULTS.successful else code.name, "message": code.message}
    if code not in PARTLY:
        return ModeResult(extra)
    reached = np.all(np.isfinite(np.asarray(motion.x)), axis=1)
    if not reached[-1]:
        motion = motion.until(int(np.argmin(reached)))
    if code == RESULTS.singular_mass:
        extra["message"] = f"{code.message} {without_mass(model)}"
    if not len(motion.t):
        return ModeResult(extra)
    seen = motion.observe()
    labels = motion.labels
    along, warnings = steps_of(motion) if linearised else ({}, [])
    if linearised:
        # Inputs are zero unless they prescribe motion.
        along["u0"] = np.asarray(inputs_that_move(motion))
        along["y0"] = np.asarray(outputs_of(motion)) + origins(model)
    data = {
        **extra,
        "x": {node: rows[-1] for node, rows in over_time(motion.x, labels.x).items()},
        "time": np.asarray(motion.t),
        "trajectory": over_time(motion.x, labels.x),
        "velocities": over_time(motion.xd, labels.x),
        "deformations": over_time(seen.e, labels.e),
        "stresses": over_time(seen.sigma, labels.e),
        "energy": {kind: np.asarray(getattr(seen, kind)) for kind in ("kinetic", "elastic", "potential")},
        **along,
    }
    asked.warnings += warnings
    return ModeResult(data, motion)


def table(data: dict[str, Any]) -> list[str]:
    """Lines of the terminal of a motion."""
    if "time" not in data:
        return []
    times, energy = np.asarray(data["time"]), {name: np.asarray(e) for name, e in data["energy"].items()}
    lines = [f"motion from 0 to {times[-1]:.6g} s, {len(times)} output times; at the end:"]
    lines += [f"  node {node:<7} {row(rows[-1])}" for node, rows in data["trajectory"].items()][:SHOWN_VALUES]
    total = sum(energy.values())
    lines.append("energy [J] at start and end: {:.6g}, {:.6g}".format(*(np.asarray(total)[[0, -1]])))
    return lines + frequencies_at_ends(data)


def frequencies_at_ends(data: dict[str, Any]) -> list[str]:
    """Lines of the terminal of the first and the last state, where the equations are linearised."""
    lines = []
    for step in [data["steps"][0], data["steps"][-1]] if "steps" in data else []:
        hertz = ["-" if f is None else f"{f:.6g}" for f in step["frequencies_hz"][:SHOWN_VALUES]]
        lines.append(f"frequencies [Hz] at {step['time']:.6g} s: {'  '.join(hertz)}")
    return lines


MODE = Mode(run, table, needs=("cause", "times"))
