"""Warnings of cubic beams that are bent or twisted further than one is right for, or stretched further than any are."""

from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..display import listed
from ..errors import CoarseWarning, warn
from ..model.model import Model

# Angle [rad] between the chord of a beam and its end, or of its twist, up to which one beam is right within 6 % of the
# deflection of an arc, and within 3 % of a twist; both errors grow with its square.
LARGE = 0.2
# Strain [-] up to which cubic beams, of any number, bend with an EI that is right within 2 %.
STRETCHED = 0.01
# So many are named, the furthest first.
NAMED = 3


def warn_of_coarse(model: Model, e: Any) -> None:
    """Warn of cubic beams that are bent or twisted so far that there should be more of them, or stretched too far.

    Args:
        model: Mechanism.
        e: Deformations, also at many times or states, (*times, n_e) [m, rad]. Nothing is looked at where they are
            traced; what is not finite is left out.

    Source:
        A cubic beam that is stretched bends with EI (1 + strain)^2: THEORY.md 2, below eq. (2.10).
    """
    blocks = [block for block in model.topology.blocks if block.element.angles and "deformation" in block.companions]
    if not blocks or not is_concrete((model.parameters.reference, e)):
        return
    e = np.abs(np.asarray(e)).reshape(-1, model.topology.n_e)
    e[~np.isfinite(e)] = 0.0
    # Most are asked about without loads.
    if not e.any():
        return
    reference, dims = np.asarray(model.parameters.reference), len(model.topology.axes)
    held = np.concatenate([np.asarray(model.topology.e.fixed), np.asarray(model.topology.e.prescribed)])
    found: dict[str, float] = {}
    stretched: dict[str, float] = {}
    for block in blocks:
        own = np.asarray(block.e)[:, np.array(block.element.angles) - 1]
        largest = e[:, own].max(axis=(0, 2), initial=0.0)
        # Both ends have nodes of the same kinds, points first.
        ends, second = np.asarray(block.x), block.splits[len(block.splits) // 2]
        chords = reference[ends[:, second : second + dims]] - reference[ends[:, :dims]]
        squares = (chords * chords).sum(axis=1)
        for i in np.flatnonzero(largest * largest > LARGE**2 * squares):
            found[str(model.labels.e[own[i, 0]].of)] = float(largest[i] / np.sqrt(squares[i]))
        if number := block.element.number_of("elongation"):
            strains = e[:, np.asarray(block.e)[:, number - 1]].max(axis=0, initial=0.0) / np.sqrt(squares)
            for i in np.flatnonzero((strains > STRETCHED) & ~np.isin(own, held).all(axis=1)):
                stretched[str(model.labels.e[own[i, 0]].of)] = float(strains[i])
    if found:
        advice = "use spectral beams" if found.keys() & stretched.keys() else "use more beams, or spectral ones"
        warn(
            f"{_named(found)}: an end turns by up to {max(found.values()):.2g} rad from the chord, or from the other"
            f" end about it. Beyond {LARGE} rad one beam is off by 3 % or more where twisted, and by 5 % where bent:"
            f" {advice}.",
            CoarseWarning,
        )
    if stretched:
        largest = max(stretched.values())
        warn(
            f"{_named(stretched)}: the strain along the beam reaches {largest:.2g}. Cubic beams bend there with"
            f" EI (1 + strain)^2 in place of EI, which is off by about {2 * largest:.0%}, however many they are: use"
            " spectral beams.",
            CoarseWarning,
        )


def _named(found: dict[str, float]) -> str:
    """Names of elements, those of the largest numbers first."""
    names = sorted(found, key=lambda name: -found[name])
    more = f", and {len(names) - NAMED} more" if len(names) > NAMED else ""
    which = listed([f"'{name}'" for name in names[:NAMED]])
    return f"Element{'s' * (len(names) > 1)} {which}{more}"
