"""The answer of each analysis mode as plain numbers: what the command line prints, writes and saves."""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np

from .. import __version__
from ..build.dofs import complete_series
from ..checks.mobility import Mobility, mobility
from ..control.state_space import state_matrices
from ..errors import AnalysisError, MechanismError, ModelError, heard
from ..linear.buckling import buckling
from ..linear.compliance import directional_compliance
from ..linear.linearize import Linearization, linearize
from ..linear.loose import refuse_negative_mass
from ..linear.modes import modes, poles
from ..linear.stress import stress, without_shape
from ..math.linear import is_positive_definite
from ..math.rotation import lbar
from ..model.model import Labels, Model
from ..model.topology import RoleIndices
from ..paths.path import Path, path
from ..results import RESULTS
from .motion_answers import simulated

# A degree of freedom whose stiffness is below this share of the largest, both per unit mass, is reported as loose.
LOOSE = 1e-12


@dataclasses.dataclass(frozen=True)
class Answer:
    """What an analysis found.

    Attributes:
        data: Keys and values, all numbers plain or numpy arrays.
        exit_status: 0 answered, 1 not valid or not converged.
        model: The mechanism, if it could be built.
        lin: Its linearisation, if there is one.
        found: What the analysis returned: Mobility, Motion, Modes, Buckling or Path; None for a state space.
    """

    data: dict[str, Any]
    exit_status: int
    model: Model | None = None
    lin: Linearization | None = None
    found: Any = None

    @property
    def shown(self) -> Any:
        """What pictures show: what was found; where that has none of its own, the linearisation or the mechanism."""
        if self.found is not None and self.found.summary().picture != "mechanism":
            return self.found
        return self.model if self.lin is None else self.lin


def _number(name: str) -> int | str:
    """Node or element number; a rotation that a name stands for keeps its name."""
    return int(name) if name.isdigit() else name


def _by_owner(values, entries) -> dict[str, list[float]]:
    """Entries of a vector by the node or element they belong to.

    Coordinates that an element owns are among its deformations and not repeated.
    """
    grouped: dict[str, list[float]] = {}
    for value, entry in zip(np.asarray(values).tolist(), entries, strict=True):
        if entry.kind not in ("norm", "internal"):
            grouped.setdefault(entry.of, []).append(value)
    return grouped


def _dofs(model: Model) -> list[dict[str, Any]]:
    def named(kind: str, indices: RoleIndices, entries):
        for i in np.asarray(indices.dof).tolist():
            yield {"kind": kind, "of": _number(entries[i].of), "component": entries[i].component}

    return [*named("x", model.topology.x, model.labels.x), *named("e", model.topology.e, model.labels.e)]


def _reactions(lin: Linearization) -> dict[str, list[float]]:
    """Support forces, moments of spatial rotations about global axes, at nodes where something is held."""
    labels, found = lin.labels, {}
    held = set(np.asarray(lin.model.topology.x.held).tolist())
    reactions, x = np.asarray(lin.matrices.reactions), np.asarray(lin.matrices.x)
    for node in dict.fromkeys(entry.of for entry in labels.x):
        indices = labels.coordinates(node)
        if held.isdisjoint(indices):
            continue
        values = reactions[indices]
        # The dual of Euler parameters is 2 Lbar^T M and Lbar Lbar^T = I, so M = Lbar f / 2.
        found[node] = (np.asarray(lbar(jnp.asarray(x[indices]))) @ values / 2 if len(indices) == 4 else values).tolist()
    return found


def _mobility_modes(found: Mobility) -> list[dict[str, Any]]:
    def listed(shares, key):
        return [{key: _number(s.of), "component": s.component, "share": s.share} for s in shares]

    over = [
        {
            "kind": "overconstraint",
            "deformations": listed(found.stresses(i), "element"),
            "release": None if r is None else {"element": _number(r[0]), "component": r[1]},
        }
        for i, r in enumerate(found.release)
    ]
    under = [
        {"kind": "underconstraint", "coordinates": listed(found.motions(i), "node")}
        for i in range(found.underconstraints)
    ]
    return over + under


def _state(lin: Linearization) -> dict[str, Any]:
    """What modes 7 to 9 have in common."""
    m = lin.matrices
    return {**_configuration(lin), **_matrices(lin), "stable": bool(is_positive_definite((m.K + m.K.T) / 2))}


def _configuration(lin: Linearization) -> dict[str, Any]:
    labels, m = lin.labels, lin.matrices
    return {
        "x": _by_owner(m.x, labels.x),
        "e": _by_owner(m.e, labels.e),
        "sig": _by_owner(m.sigma, labels.e),
        "reactions": _reactions(lin),
        **_stress(lin),
    }


def _stress(lin: Linearization) -> dict[str, Any]:
    """Largest von Mises stress and where it is, where the sections of all flexible elements have a shape."""
    if not any(map(any, lin.labels.stressed)) or without_shape(lin.model):
        return {}
    found = stress(lin.model, at=lin)
    element, place, _ = found.where
    return {"stress": {"maximum": float(found.maximum), "element": _number(element), "place": place}}


def _matrices(lin: Linearization) -> dict[str, Any]:
    return {name.lower(): np.asarray(getattr(lin.matrices, name)) for name in ("M0", "C0", "D0", "K0", "N0", "G0")}


def _poles(lin: Linearization, always: bool) -> dict[str, Any]:
    damped = np.any(np.asarray(lin.matrices.C0 + lin.matrices.D0))
    if not (always or damped or not lin.matrices.symmetric):
        return {}
    return {"poles": [[p.real, p.imag] for p in poles(lin).tolist()]}


def _compliance(lin: Linearization) -> dict[str, list[float]]:
    """Directional compliance of each node, infinite (so that JSON has null) where it takes part in a free motion."""
    own = {entry.of for entry in lin.labels.x if entry.kind == "internal"}
    return {node: values.tolist() for node, values in directional_compliance(lin).items() if node not in own}


def _shapes(columns, labels: Labels) -> list[dict[str, list[float]]]:
    return [_by_owner(column, labels.x) for column in np.asarray(columns).T]


def _hertz(values, hertz) -> list[float | None]:
    """Frequencies, None where the eigenvalue is negative."""
    return [None if v < 0 else f for v, f in zip(np.asarray(values).tolist(), np.asarray(hertz).tolist(), strict=True)]


def _frequencies(model: Model, lin: Linearization) -> dict[str, Any]:
    if not lin.matrices.symmetric:
        silent = "The stiffness is unsymmetric (moments about fixed axes, follower loads): `poles` answers alone."
        return {**_state(lin), **_poles(lin, always=True), "warnings": [silent]}
    found = modes(lin)
    values, hertz = np.asarray(found.eigenvalues), np.asarray(found.frequencies)
    return {
        **_state(lin),
        "found": found,
        "stable": found.stable,
        "eigenvalues": values,
        "frequencies_hz": _hertz(values, hertz),
        "massless": found.massless,
        "modes": _shapes(found.shapes, lin.labels),
        **_poles(lin, always=False),
    }


def _buckling(model: Model, lin: Linearization) -> dict[str, Any]:
    refuse_negative_mass(lin)
    found = buckling(model)
    silent = "No load acts in any motion: there is no load multiplier." if not len(found.multipliers) else None
    return {
        **_state(lin),
        "found": found,
        "load_multipliers": np.asarray(found.multipliers),
        "modes": _shapes(found.shapes, lin.labels),
        "compliance": _compliance(lin),
        "warnings": [silent] if silent else [],
    }


def _statespace(model: Model, lin: Linearization) -> dict[str, Any]:
    found, states = state_matrices(lin)
    return {
        **_state(lin),
        **{name: np.asarray(value) for name, value in found._asdict().items()},
        "inputs": [s.name for s in lin.labels.inputs],
        "outputs": [s.name for s in lin.labels.outputs],
        "states": states,
        **_poles(lin, always=True),
    }


def _step(found: Path, i: int) -> dict[str, Any]:
    lin, values, multipliers = (
        found.linearization(i),
        np.asarray(found.eigenvalues[i]),
        np.asarray(found.multipliers[i]),
    )
    finite = np.isfinite(values)
    return {
        "load_factor": float(found.load_factor[i]),
        **_configuration(lin),
        "stable": bool(found.stable[i]),
        "eigenvalues": values[finite],
        "frequencies_hz": _hertz(values[finite], np.asarray(found.frequencies[i])[finite]),
        "load_multipliers": multipliers[np.isfinite(multipliers)],
        **_matrices(lin),
        "compliance": _compliance(lin),
    }


def _path(found: Path) -> dict[str, Any]:
    code = RESULTS(int(found.result))
    critical = [
        {"load_factor": c.load_factor, "kind": c.kind, "mode": _by_owner(c.phi, found.labels.x)}
        for c in found.critical_points
    ]
    return {
        "status": "ok" if code == RESULTS.successful else code.name,
        "message": code.message,
        **_configuration(found.linearization()),
        "stable": bool(found.stable[-1]),
        "critical_points": critical,
        "path": [_step(found, i) for i in range(len(found.load_factor))],
    }


# Number and name of each mode; the analysis where there is one.
MODES: dict[int, tuple[str, Callable[[Model, Linearization], dict[str, Any]] | None]] = {
    0: ("mobility", None),
    1: ("simulate", None),
    4: ("simulate-linearise", None),
    7: ("frequencies", _frequencies),
    8: ("buckling", _buckling),
    9: ("statespace", _statespace),
    10: ("path", None),
}
RESERVED = {
    2: "inverse",
    3: "trajectory-linearisation",
    5: "perturbation",
    6: "superposition",
}
# Modes in which incremental loads act.
INCREMENTAL = (8, 10)


def _loose_warnings(lin: Linearization) -> list[str]:
    """Degrees of freedom that move nothing stiff."""
    m = lin.matrices
    stiffness = np.abs(np.diag(np.asarray(m.K)))
    coupled = np.max(np.abs(np.asarray(m.K)), axis=1, initial=0.0)
    largest = max(stiffness.max(initial=0.0), np.abs(np.asarray(m.S)).max(initial=0.0))
    return [
        f"Degree of freedom {name} has neither stiffness nor load: nothing holds it."
        for name, c in zip(lin.model.q_labels, coupled, strict=True)
        if c <= LOOSE * largest
    ]


def answer(
    builder,
    name: str,
    mode: int,
    warnings: list[str] | None = None,
    release: str = "none",
    dofs: str = "named",
    max_steps: int = 200,
    settings: dict[str, Any] | None = None,
) -> Answer:
    """Run one analysis mode.

    Args:
        builder: Description of the mechanism.
        name: Name of its file.
        mode: A key of MODES.
        warnings: What reading the file had to say.
        release: "auto" releases over-constraints before modes other than 0.
        dofs: "named" or "auto", see Builder.build.
        max_steps: Steps of a path at most.
        settings: What the file says beside the mechanism.

    Returns:
        Answer, also where the mechanism is not valid or the analysis failed.
    """
    data: dict[str, Any] = {"model": name, "mode": mode, "flexmb": __version__, "status": "ok", "message": ""}
    data["warnings"] = list(warnings or [])
    # Of overflow on the way nothing is said: what is not finite in the end has a status.
    with heard() as said, np.errstate(all="ignore"):
        found = _answer(data, builder, name, mode, release, dofs, max_steps, settings or {})
    # What does nothing has been told with the line that says it.
    data["warnings"] += [text for text in dict.fromkeys(said) if not text.startswith(("Prestress", "Strain"))]
    return found


def _answer(
    data: dict[str, Any],
    builder,
    name: str,
    mode: int,
    release: Any,
    dofs: Any,
    max_steps: int,
    settings: dict[str, Any],
) -> Answer:
    """Fill in the keys and values of an answer."""
    model = complete_series(builder, builder.build(check=False))
    data["warnings"] += _increment_warnings(builder, mode)
    lin = None
    failed = 0
    try:
        if mode == 0:
            found = mobility(model)
            extra = {
                "status": found.status,
                "message": found.report(),
                "overconstraints": found.overconstraints,
                "underconstraints": found.underconstraints,
                "mobility": _mobility_modes(found),
                "found": found,
            }
        elif mode in (1, 4):
            model = builder.build(dofs=dofs, release=release)
            extra = simulated(model, name, settings, mode == 4)
            failed = int(extra["status"] != "ok")
        elif mode == 10:
            model = builder.build(dofs=dofs, release=release)
            followed = path(model, max_steps=max_steps, throw=False)
            lin, extra = followed.linearization(), {**_path(followed), "found": followed}
            data["warnings"] += _loose_warnings(lin)
            failed = int(extra["status"] != "ok")
        else:
            model = builder.build(dofs=dofs, release=release)
            run = MODES[mode][1]
            assert run is not None
            lin = linearize(model, increment=0.0)
            data["warnings"] += _loose_warnings(lin)
            extra = run(model, lin)
    except (MechanismError, AnalysisError) as fault:
        extra = {"status": fault.code, "message": str(fault)}
        failed = 1
    except ModelError as fault:
        # Such as an output that cannot be given.
        extra = {"status": "not_valid", "message": str(fault)}
        failed = 1
    data.update(model.counts())
    data["dofs"] = _dofs(model)
    data["warnings"] += extra.pop("warnings", [])
    returned = extra.pop("found", None)
    bad = [key for key, value in extra.items() if not _finite({key: value})]
    if failed:
        extra = {key: value for key, value in extra.items() if key not in bad}
    elif bad:
        extra = {"status": RESULTS.not_finite.name, "message": f"{RESULTS.not_finite.message} ({', '.join(bad)})"}
        failed = 1
    data.update(extra)
    return Answer(data, failed, model, lin, returned)


def _finite(value: Any) -> bool:
    """Whether all numbers in a value are finite."""
    if isinstance(value, dict):
        # A motion that nothing holds is infinitely compliant, and null.
        return all(_finite(v) for key, v in value.items() if key != "compliance")
    if isinstance(value, list | tuple):
        return all(map(_finite, value))
    numeric = isinstance(value, float | complex | np.generic) or (
        isinstance(value, np.ndarray) and value.dtype.kind in "fc"
    )
    return not numeric or bool(np.all(np.isfinite(value)))


def _increment_warnings(builder, mode: int) -> list[str]:
    """What to say where loads of the file do not act."""
    hidden = (m for m in builder.members.values() if m.hidden)
    there = any(builder.loads["increment"].values()) or any(m.properties.get("incremental") for m in hidden)
    if not there or mode in (0, *INCREMENTAL):
        return []
    return [
        f"Incremental loads (DELXF, DELESIG, DELINPX, DELINPE) act in modes {' and '.join(map(str, INCREMENTAL))}:"
        f" mode {mode} answers without them."
    ]


def plain(value: Any) -> Any:
    """Value with numpy arrays as lists and numbers that are not finite as None, for JSON.

    Args:
        value: Any value of an answer.
    """
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
