"""Identification: parameters of a mechanism from measurements, and how well the measurements determine them."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
