"""Tolerances, each with its reason: what counts as zero, equal, small or reached.

Values are relative unless a unit stands beside them. Tolerances of integrators and of user options stay with them.
"""

# --- elements -------------------------------------------------------------------------------------------------------

SHORTEST_ELEMENT = 1e-12
"""Shortest length of an element over the largest coordinate of its ends. Positions have 16 digits: below this, ends
such as 3 * 0.05 and 0.15 differ by round-off alone."""

ABOVE_LARGEST_POISSON = 1e-9
"""E/(2 G) - 1 may exceed 0.5 by this. Moduli are often typed from a Poisson's ratio of one half."""

PRINCIPAL_MOMENTS = 1e-9
"""Principal moments of inertia may miss the triangle inequality by this share of the largest: a plate meets it exactly,
and eigenvalues carry round-off."""

DIRECTED_STRESS = 1e-9
"""A bending moment or a shear force on a ring has a direction where it exceeds this share of all that stresses the
section. Below, its direction is round-off and has no derivative."""

STRIP_SERIES = 0.06
"""u^4 of a flattened strip up to which a quotient of power series replaces the closed form. The series is exact to
1e-10 there, and the closed form loses digits."""

PLACE_OF_BREAK = 1e-9
"""Breaks of a section may lie outside of [0, 1], or out of order, by this: they are often quotients of lengths."""

SAME_DAMPING = 1e-12
"""Damping of a material along a section varies where it differs by more than this, which is round-off."""

SMOOTH_COMPLIANCE = 1e-3
"""Largest error of mean compliances by the Gauss nodes of a beam. Beyond, a section is not smooth between breaks."""

SMOOTH_MASS = 1e-2
"""The same of the mass, by few Lobatto nodes of a beam in space of low order. Mass has less effect than stiffness."""

# --- math -----------------------------------------------------------------------------------------------------------

ANGLE_BY_SERIES = 1e-4
"""Square of an angle below which sine and cosine are taken from their series, exact to round-off there [rad^2]."""

SMALLEST_TURN = 1e-20
"""Square of the sine of half an angle below which the sine is the angle, to round-off."""

EIGENVALUES_ALIKE = 1e-5
"""Relative distance of two eigenvalues below which the mean slope replaces their divided difference. Both have lost as
many digits there."""

# --- trajectory -----------------------------------------------------------------------------------------------------

OUTSIDE_TIMES = 1e-9
"""Times may lie outside of the times of a system by this share of the largest: they are often sums of steps."""

NO_VIBRATION = 1e-6
"""Frequencies below this share of the highest count as no vibration where frequencies are compared."""

ZERO_OF_TERMS = 1e-11
"""A sum is zero below this share of the sizes of its terms: what round-off leaves of systems of some ten states."""

ZERO_ON_AXIS = 1e-9
"""A zero of a transfer function is on the imaginary axis where its real part is below this share of its size."""

JUMP_OF_LAW = 1e-7
"""A law of motion jumps where derivatives of both sides differ by more than this share of the sum of its terms."""

MISSED_AT_REST = 1e-3
"""A start from rest that misses the flexible trajectory by this share of the largest output is reported."""

MISSED_CONFIGURATION = 1e-8
"""How far wanted values may be missed along a trajectory, over the extent of the mechanism, or in radians."""

# --- plot -----------------------------------------------------------------------------------------------------------

SMALLEST_RESPONSE = 1e-9
"""An output responds to an input above this share of the largest response to it. Below stands round-off."""

SMALLEST_SHAPE = 1e-6
"""A mode moves its lines, or turns its sections, above this, per unit of its largest coordinate. Below stands the
round-off of the difference that finds the motion."""
