"""Motions that are wanted, what drives a mechanism along them, and its equations about them."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
