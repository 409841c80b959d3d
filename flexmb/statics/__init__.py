"""Equilibrium under loads, and where coordinates lie at given degrees of freedom."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
