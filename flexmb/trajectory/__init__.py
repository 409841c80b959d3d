"""Wanted motions, the inputs that drive a mechanism along them, and the equations of deviations from them."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
