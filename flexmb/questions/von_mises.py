"""Largest von Mises stress: "stress"; in one element: "stress leaf". Largest ratio to the strength: "utilisation"."""

from typing import Any

import jax.numpy as jnp

from ..linear.stress import Stress, stress
from ..model.model import Model
from .question import Question, as_host_values


def stress_of(state: Any) -> Stress:
    """Stress of a state, or of all states of a path or a motion."""
    return stress(state) if isinstance(state, Model) else stress(state.model, at=state)


def _stress(state: Any, element: str) -> Any:
    known = stress_of(state)
    if not element:
        return known.maximum
    if element not in known.names:
        raise KeyError(f"no stress of an element '{element}'; there is {', '.join(known.names)}")
    return as_host_values(state, known.by_element)[..., known.names.index(element)]


def _utilisation(state: Any, argument: str) -> Any:
    return jnp.max(stress_of(state).utilisation, axis=-1)


QUESTIONS = (
    Question("stress", ("element?",), _stress, "Pa", "largest von Mises stress", of_many=True, of_loads=True),
    Question("utilisation", (), _utilisation, "-", "stress over strength", of_many=True, of_loads=True),
)
