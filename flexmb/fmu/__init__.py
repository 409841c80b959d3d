"""The mechanism as a functional mock-up unit (FMU), for other simulation programs."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
