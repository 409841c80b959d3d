"""Questions asked of the mechanism linearised about a state: frequencies, buckling, compliance, stress."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
