"""Input files of SPACAR, read and written, and the interface of SPACAR Light."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
