"""Energies of a motion: "kinetic", "elastic", "potential", and "energy", their sum."""

import functools
from typing import Any

from .question import Question

ENERGIES = ("kinetic", "elastic", "potential", "energy")


def _energy(name: str, motion: Any, argument: str) -> Any:
    return getattr(motion.observe(), name)


QUESTIONS = tuple(
    Question(
        name,
        (),
        functools.partial(_energy, name),
        "J",
        kind="energy",
        only="motion",
        of_many=True,
        differentiable=False,
    )
    for name in ENERGIES
)
