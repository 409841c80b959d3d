"""Velocities and accelerations of a node in a motion: "velocity top.x", "acceleration top.phi"."""

from typing import Any

from .question import ANGLES, Question, by_component, split


def _velocity(state: Any, rest: str) -> Any:
    node, component = split(rest)
    return (state.angular_velocity if component in ANGLES else state.velocity)(node, component)


def _acceleration(state: Any, rest: str) -> Any:
    node, component = split(rest)
    return (state.angular_acceleration if component in ANGLES else state.acceleration)(node, component)


QUESTIONS = (
    Question("velocity", "node", _velocity, by_component("m/s", "rad/s"), of_many=True, differentiable=False),
    Question("acceleration", "node", _acceleration, by_component("m/s²", "rad/s²"), of_many=True, differentiable=False),
)
