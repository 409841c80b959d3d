"""Answers of the modes that simulate: motion in time, and the linearised equations along it."""

import sys
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial

from ..analysis.loose import without_mass
from ..analysis.moving import linearize_motion
from ..analysis.simulate import Motion, simulate
from ..errors import SpacarError, heard
from ..mechanics.extent import sizes_of
from ..model.model import Model
from ..results import RESULTS

RTOL = 1e-5


def _uniformly_accelerated(t, value, velocity, acceleration):
    """Prescribed value with constant acceleration."""
    return value + velocity * t + 0.5 * acceleration * t**2


def _motions(model: Model, settings: dict[str, Any]) -> dict[str, Partial]:
    """Functions of time of what INPUTX and INPUTE prescribe with a velocity or an acceleration."""
    found = {}
    for keyword, entries, start in (
        ("INPUTX", model.labels.x, np.asarray(model.parameters.reference)),
        ("INPUTE", model.labels.e, np.zeros(len(model.labels.e))),
    ):
        for of, component, value, *rates in settings.get(keyword, []):
            if any(rates):
                index = next(i for i, n in enumerate(entries) if n.of == str(of) and n.component == component)
                numbers = (jnp.asarray(number) for number in (value - start[index], *rates))
                found[str(entries[index])] = Partial(_uniformly_accelerated, **dict(zip(NAMES, numbers, strict=True)))
    return found


NAMES = ("value", "velocity", "acceleration")


def times_of(name: str, settings: dict[str, Any]) -> np.ndarray:
    """Output times that TIMESTEP asks for, (n_t,) [s].

    Args:
        name: Name of the file.
        settings: What is not part of the mechanism.

    Raises:
        SpacarError: There is no TIMESTEP.
    """
    if "TIMESTEP" not in settings:
        raise SpacarError(f"{name}: TIMESTEP: modes 1 and 4 need it: TIMESTEP end steps, such as TIMESTEP 1.0 100")
    given = settings["TIMESTEP"]
    return np.linspace(0.0, given["end"], int(given["steps"]) + 1)


def _over_time(values, entries) -> dict[str, list]:
    """Columns of a history by the node or element they belong to, one row a time."""
    grouped: dict[str, list[int]] = {}
    for i, entry in enumerate(entries):
        if entry.kind not in ("norm", "internal"):
            grouped.setdefault(entry.of, []).append(i)
    values = np.asarray(values)
    return {owner: values[:, columns].tolist() for owner, columns in grouped.items()}


def _steps(found: Motion) -> list[dict[str, Any]]:
    """Linearised equations at every time."""
    m = linearize_motion(found).matrices
    steps = []
    for i, t in enumerate(np.asarray(found.t).tolist()):
        own = {name: np.asarray(getattr(m, name)[i]) for name in ("M0", "C0", "D0", "K0", "N0", "G0")}
        fine = int(m.result[i]) == RESULTS.successful
        values = np.linalg.eigvals(np.linalg.solve(own["M0"], own["K0"] + own["N0"] + own["G0"])) if fine else []
        values = sorted(values, key=lambda v: v.real)
        hertz = [None if v.real < 0 or v.imag else float(np.sqrt(v.real)) / (2 * np.pi) for v in values]
        steps.append({"time": t, "frequencies_hz": hertz, **{name.lower(): value for name, value in own.items()}})
    return steps


def simulated(model: Model, name: str, settings: dict[str, Any], linearised: bool) -> dict[str, Any]:
    """Motion in time, as keys and values of an answer.

    Args:
        model: Mechanism.
        name: Name of its file.
        settings: What is not part of the mechanism: TIMESTEP, ERROR, INPUTX, INPUTE.
        linearised: Whether to linearise at every output time.

    Returns:
        The keys, and the Motion itself as "found", if any of it was reached.

    Raises:
        SpacarError: There is no TIMESTEP.
    """
    times = times_of(name, settings)
    error = settings.get("ERROR", {})
    extent = float(jnp.max(sizes_of(model.topology, model.parameters)[model.topology.axes], initial=0.0)) or 1.0
    rtol = error.get("relative", RTOL)
    atol = error["absolute"] / extent if "absolute" in error else None
    driven = _motions(model, settings)
    # That incremental loads are left out is said by the keywords of the file.
    with heard():
        found = simulate(model, times, motion=driven, rtol=rtol, atol=atol, progress=sys.stderr.isatty(), throw=False)
    code = RESULTS(int(found.result))
    reached = np.all(np.isfinite(np.asarray(found.x)), axis=1)
    if not reached[-1]:
        count = int(np.argmin(reached))
        found = found.until(count)
    extra = {"status": "ok" if code == RESULTS.successful else code.name, "message": code.message}
    if code == RESULTS.singular_mass:
        extra["message"] = f"{code.message} {without_mass(model)}"
    if not len(found.t):
        return extra
    seen = found.observe()
    labels = found.labels
    return {
        **extra,
        "found": found,
        "x": {node: rows[-1] for node, rows in _over_time(found.x, labels.x).items()},
        "time": np.asarray(found.t),
        "trajectory": _over_time(found.x, labels.x),
        "velocities": _over_time(found.xd, labels.x),
        "deformations": _over_time(seen.e, labels.e),
        "stresses": _over_time(seen.sigma, labels.e),
        "energy": {kind: np.asarray(getattr(seen, kind)) for kind in ("kinetic", "elastic", "potential")},
        **({"steps": _steps(found)} if linearised else {}),
    }
