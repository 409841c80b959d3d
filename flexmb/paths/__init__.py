"""Equilibrium paths under growing loads, their critical points and limit loads."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
