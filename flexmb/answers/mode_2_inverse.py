"""Mode 2: inverse dynamics along a trajectory."""

from collections.abc import Callable, Iterator
from typing import Any, NoReturn

import numpy as np

from ..build.builder import Builder
from ..build.description import Key, NamedSignal
from ..errors import SpacarError
from ..model.by_name import TURNS
from ..model.topology import Role
from ..spacar.reading import Channel
from ..spacar.trajectories import NOMINAL, REFERENCES, WAYS, Way, laws_of, role_of, ways_of
from ..trajectory.inverse import Nominal, inverse_dynamics
from .answer_parts import SHOWN_VALUES, row
from .mode import Mode, ModeRequest, ModeResult
from .mode_1_simulate import frequencies_at_ends, motions_of, origins, over_time, steps_of, times_of

KINDS = {"NOMF": "node", "NOMS": "element"}
FORM = "TRAJX node coordinate start end value [quintic|septic|scurve], or TRAJE element deformation .."


def _channels(settings: dict[str, Any], keywords: Any) -> Iterator[tuple[str, Channel]]:
    """Lines of nominal inputs or reference outputs, in the order of their numbers."""
    channels = [(keyword, channel) for keyword in keywords for channel in settings.get(keyword, [])]
    return iter(sorted(channels, key=lambda pair: pair[1].number))


def _driven(asked: ModeRequest, ways: dict[Key, Way], refuse: Callable[..., NoReturn]) -> list[Key]:
    """PRESCRIBED motions of the file that nominal inputs drive: inputs that act on them, then the remaining inputs."""
    roles = {key: role_of(asked.builder, key) for key in ways}
    nominal = list(_channels(asked.settings, NOMINAL))
    by_key = {(KINDS[keyword], str(channel.of), channel.component) for keyword, channel in nominal}
    direct = [key for key, role in roles.items() if role is Role.PRESCRIBED and key in by_key]
    free = [key for key, role in roles.items() if role is Role.DOF]
    others = [key for key, role in roles.items() if role is Role.PRESCRIBED and key not in by_key]
    remaining = len(nominal) - len(direct) - len(free)
    if remaining in (0, len(others)):
        return direct + (others if remaining else [])
    if remaining < 0:
        first = next(key for key in free if key not in by_key)
        way = ways[first]
        keyword = "NOMF" if way.keyword == "TRAJX" else "NOMS"
        refuse(
            way.keyword,
            f"{first[0]} {first[1]}: nothing drives it along its trajectory: there are {len(nominal)} nominal inputs"
            f" for {len(direct) + len(free)} driven quantities. Name one more with {keyword}, or prescribe it",
            way.legs[0].line,
        )
    keyword, last = nominal[-1]
    refuse(
        keyword,
        f"input {last.number}: {len(nominal)} nominal inputs drive as many coordinates and deformations along"
        f" trajectories, but {len(ways)} have one; those that are degrees of freedom (DYNX, DYNE) or have an input of"
        " their own are driven first",
        last.line,
    )


def _with_signals(builder: Builder, settings: dict[str, Any]) -> None:
    """Builder with nominal inputs and reference outputs instead of the inputs and outputs of the state space."""
    for side, keywords in (("input", NOMINAL), ("output", tuple(REFERENCES))):
        signals: list[NamedSignal] = []
        for keyword, channel in _channels(settings, keywords):
            kind = "node" if keyword in ("NOMF", "REFX", "REFXP", "REFXDP") else "element"
            quantity = REFERENCES.get(keyword) or ("force" if kind == "node" else "stress")
            axis = TURNS.index(channel.component) if channel.component in TURNS else None
            quantity = "moment" if axis is not None and quantity == "force" else quantity
            label = f"{quantity} {channel.of}.{channel.component}"
            name = f"{label} ({channel.number})" if label in {signal.name for signal in signals} else label
            key: Key = (kind, str(channel.of), 1 if isinstance(channel.component, str) else channel.component)
            signals.append(NamedSignal(name, quantity, key, axis))
        builder.signals[side] = signals


def _idle_velocities(asked: ModeRequest, released: bool) -> list[str]:
    """Warnings of start velocities that have no effect."""
    keys = [key for key, (_, velocity) in asked.builder.starts.items() if velocity != 0]
    idle = [key for key in keys if not released or key in ways_of(asked.settings)]
    return [
        f"The start velocity of {kind} {of}, {number}, has no effect: along a trajectory all driven quantities start at"
        f" rest{'' if released else ', and all else is held'}."
        for kind, of, number in idle
    ]


def nominal_motion(asked: ModeRequest, number: int) -> tuple[Nominal, list[str]]:
    """The motion along the trajectory of a file, with its nominal inputs and reference outputs."""
    settings, ways = asked.settings, ways_of(asked.settings)

    def refuse(keyword: str, text: str, line: int | None = None) -> NoReturn:
        raise SpacarError(f"{asked.name}{'' if line is None else f':{line}'}: {keyword}: {text}")

    if not ways:
        first = next(_channels(settings, (*NOMINAL, *REFERENCES)), None)
        keyword, line = ("TRAJX", None) if first is None else (first[0], first[1].line)
        refuse(keyword, f"mode {number} needs a trajectory: {FORM}", line)
    asked.warnings += _idle_velocities(asked, released=number == 6)
    driven = _driven(asked, ways, refuse)
    original, builder = asked.builder, asked.builder.copy()
    for key in driven:
        (builder.nodes if key[0] == "node" else builder.members)[key[1]].roles[key[2] - 1] = Role.DOF
        for loads in builder.loads.values():
            loads.get("prescribed", {}).pop(key, None)
    builder.dofs = driven + builder.dofs
    _with_signals(builder, settings)
    asked.builder = builder
    model = asked.checked()
    labels = model.labels
    n_q, n_u, n_y = model.topology.n_q, len(labels.inputs), len(labels.outputs)
    matrices = (6 * n_q**2 + (2 * n_q + n_u) * (2 * n_q + n_y)) * (number != 2)
    first = min((way.legs[0] for way in ways.values()), key=lambda leg: leg.line)
    keyword = next(word for word in WAYS if first in settings.get(word, []))
    where = f"{asked.name}:{first.line}: {keyword}"
    times = times_of(asked.name, settings, 2 * (len(labels.x) + len(labels.e)) + n_u + n_y + n_q + matrices, where)
    for way in ways.values():
        if way.legs[-1].end > times[-1]:
            asked.warnings.append(
                f"{way.keyword} on line {way.legs[-1].line} goes on until {way.legs[-1].end:.6g} s, but TIMESTEP ends"
                f" at {times[-1]:.6g} s."
            )
    laws = laws_of(original, labels, settings)
    return inverse_dynamics(model, laws | motions_of(model, settings), times), list(laws)


def nominal_data(found: Nominal, motion: Any = None) -> dict[str, Any]:
    """Times, coordinates, nominal inputs and reference outputs."""
    motion = found.motion if motion is None else motion
    labels = motion.labels
    trajectory = over_time(motion.x, labels.x)
    return {
        "x": {node: rows[-1] for node, rows in trajectory.items()},
        "time": np.asarray(motion.t),
        "trajectory": trajectory,
        "velocities": over_time(motion.xd, labels.x),
        "inputs": [signal.name for signal in labels.inputs],
        "outputs": [signal.name for signal in labels.outputs],
        "u0": np.asarray(found.u0),
        "y0": np.asarray(found.y0) + origins(motion.model),
    }


def linearised(asked: ModeRequest, found: Nominal) -> dict[str, Any]:
    """The linearised equations at every time."""
    along, warnings = steps_of(found.motion)
    asked.warnings += warnings
    return along


def run(asked: ModeRequest, matrices: bool = False) -> ModeResult:
    """Inverse dynamics along the trajectory; with ``matrices`` also the linearised equations at every time."""
    nominal, _ = nominal_motion(asked, 3 if matrices else 2)
    return ModeResult({**nominal_data(nominal), **(linearised(asked, nominal) if matrices else {})}, nominal.motion)


def table(data: dict[str, Any]) -> list[str]:
    """Lines of the terminal of a motion along a trajectory."""
    if "time" not in data:
        return []
    times = np.asarray(data["time"])
    lines = [f"trajectory from 0 to {times[-1]:.6g} s, {len(times)} output times; at the end:"]
    lines += [f"  node {node:<7} {row(rows[-1])}" for node, rows in data["trajectory"].items()][:SHOWN_VALUES]
    for side, key in (("input", "u0"), ("output", "y0")):
        for name, values in zip(data[f"{side}s"][:SHOWN_VALUES], np.asarray(data[key]).T, strict=False):
            lines.append(f"  {side} {name}: {values.min():.6g} to {values.max():.6g}")
    return lines + frequencies_at_ends(data)


MODE = Mode(run, table, needs=("trajectory", "times"))
