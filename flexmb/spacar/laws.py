"""Laws of time of an input file: the motions of coordinates and deformations by TRAJX and TRAJE."""

from typing import Any, NamedTuple

import jax
import numpy as np

from ..build.builder import Builder
from ..build.description import Key
from ..model.model import Labels
from ..model.roles import Role
from ..trajectory.laws import Law, quintic, scurve, septic
from .actions import start_of
from .reading import Leg
from .trajectories import WAYS

# Limits of an S-curve over a distance of 1 in a time of 1. It accelerates in the first third and decelerates in the
# last; the acceleration grows, stays and falls in a third of each.
THIRDS = {"velocity": 1.5, "acceleration": 6.75, "jerk": 60.75}


class Way(NamedTuple):
    """Lines of one coordinate or deformation, in the order of time, and their keyword."""

    keyword: str
    legs: list[Leg]


def role_of(builder: Builder, key: Key) -> Role:
    """Role of a coordinate or deformation."""
    kind, owner, number = key
    return (builder.nodes if kind == "node" else builder.members)[owner].roles[number - 1]


def ways_of(settings: dict[str, Any]) -> dict[Key, Way]:
    """Lines of TRAJX and TRAJE in the settings of a file, by coordinate or deformation."""
    ways: dict[Key, Way] = {}
    for keyword, kind in zip(WAYS, ("node", "element"), strict=True):
        for leg in sorted(settings.get(keyword, []), key=lambda leg: leg.start):
            key = (kind, str(leg.of), leg.component)
            ways.setdefault(key, Way(keyword, [])).legs.append(leg)
    return ways


def _name(labels: Labels, key: Key) -> str:
    """Name of a coordinate or deformation."""
    kind, owner, number = key
    entries = labels.x if kind == "node" else labels.e
    return next(str(entry) for entry in entries if entry.of == owner and entry.component == number)


def _move(leg: Leg, start: float, end: float) -> Law:
    """One motion from rest to rest."""
    duration = leg.end - leg.start
    if leg.law == "scurve" and end != start:
        far = abs(end - start)
        limits = {name: THIRDS[name] * far / duration ** (i + 1) for i, name in enumerate(THIRDS)}
        return scurve(start, end, **limits, begin=leg.start)
    return (septic if leg.law == "septic" else quintic)(start, end, duration, begin=leg.start)


def law_of(legs: list[Leg], start: float, reference: float = 0.0) -> Law:
    """One law of several motions in the order of time, with rest between them.

    The first motion begins at ``start``, from the undeformed mechanism; values of lines count from ``reference`` [m,
    rad].
    """
    breaks, polynomials, at = [legs[0].start], [], start
    for leg in legs:
        if leg.start > breaks[-1]:
            polynomials.append(np.array([[at]]))
            breaks.append(leg.start)
        motion, at = _move(leg, at, leg.value - reference), leg.value - reference
        polynomials.append(np.asarray(motion.coefficients))
        # The phases of an S-curve miss the end by round-off.
        breaks += [*np.asarray(motion.breaks)[1:-1].tolist(), leg.end]
    widest = max(piece.shape[1] for piece in polynomials)
    padded = [np.pad(piece, ((0, 0), (0, widest - piece.shape[1]))) for piece in polynomials]
    # jnp.asarray compiles a program for each shape.
    return Law(jax.device_put(np.array(breaks)), jax.device_put(np.concatenate(padded)))


def laws_of(builder: Builder, labels: Labels, settings: dict[str, Any], only: Role | None = None) -> dict[str, Law]:
    """Laws of all motions in a file, or of one role, by names: displacements from the undeformed mechanism."""
    prescribed, laws = builder.loads["initial"].get("prescribed", {}), {}
    for key, way in ways_of(settings).items():
        kind, owner, number = key
        if only in (None, role_of(builder, key)):
            start = prescribed.get(key, builder.starts.get(key, (0.0, 0.0))[0])
            reference = start_of(builder, kind, owner, number)
            laws[_name(labels, key)] = law_of(way.legs, float(start), float(reference))
    return laws
