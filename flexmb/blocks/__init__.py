"""Building blocks: guides, pivots, hinges and stages on leaf springs, attached by named nodes."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
