"""The mechanism as a plant: linear state space and nonlinear system, with named inputs and outputs."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
