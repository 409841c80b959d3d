"""Motion: its equations, in several forms, drives and controllers, solvers, and the simulation that joins them."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
