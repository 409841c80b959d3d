"""Roles: each coordinate and each deformation has exactly one."""

import enum


class Role(enum.Enum):
    """Role of a coordinate or deformation (THEORY.md 1).

    FIXED: a coordinate at its start value, a deformation at zero or its thermal value. DEPENDENT: follows from the
        others
    ("released" for a deformation). DOF: a degree of freedom. PRESCRIBED: a given value.
    """

    FIXED = "fixed"
    DEPENDENT = "dependent"
    DOF = "dof"
    PRESCRIBED = "prescribed"


# Roles of known values.
HELD = (Role.FIXED, Role.PRESCRIBED)
