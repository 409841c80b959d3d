"""Elements: pure functions of nodal coordinates. ``planar`` and ``spatial`` hold the types, ``sections`` their data."""
