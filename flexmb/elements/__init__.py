"""Elements: pure functions of nodal coordinates. ``planar`` and ``spatial`` hold the types, ``sections`` their data."""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
