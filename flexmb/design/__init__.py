"""Designs: sensitivities, sweeps and tuning of named dimensions."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
