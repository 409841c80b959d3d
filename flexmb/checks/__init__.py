"""Mobility: which constraints are too many or too few, and what moves; asked by the builder and by users."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
