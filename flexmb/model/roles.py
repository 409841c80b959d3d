"""The one role that each coordinate and each deformation has."""

import enum


class Role(enum.Enum):
    """Role of a coordinate or deformation (THEORY.md 1).

    FIXED: a coordinate at its start value, a deformation at zero or what temperature makes of it. DEPENDENT: found from
    the others ("released" for a deformation). DOF: a degree of freedom. PRESCRIBED: a given value.
    """

    FIXED = "fixed"
    DEPENDENT = "dependent"
    DOF = "dof"
    PRESCRIBED = "prescribed"


# What is known beforehand.
HELD = (Role.FIXED, Role.PRESCRIBED)
