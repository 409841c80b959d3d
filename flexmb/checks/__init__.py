"""Mobility: over- and under-constraints and free motions, for the builder and for users."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
