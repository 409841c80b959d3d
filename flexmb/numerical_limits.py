"""Tolerances, each with its reason: what counts as zero, equal, small or reached.

Values are relative unless a unit is given. Tolerances of integrators and of user options are in their own modules.
"""

# --- in several rooms -------------------------------------------------------------------------------------------------

NEGLIGIBLE = 1e-9
"""Numbers below this share of the largest of their kind, or of their parts, are round-off: stiffnesses of a leaf spring
differ by six digits, and answers keep nine or ten."""

ROUND_OFF = 1e-12
"""The same for numbers whose round-off no stiffness amplifies, such as sums and phases, and for displayed coordinates
[m, rad]: they keep twelve digits."""

TEN_DIGITS = 1e-9
"""Given numbers are equal within this: they are typed or printed with ten digits, or are sums or quotients."""

SAME_TIME = 1e-9
"""Two times are equal within this share of the largest time or of one step: times are often sums of steps."""

NO_STIFFNESS = 1e-12
"""A motion meets no stiffness below this share of the stiffnesses at its coordinates, or of the largest stiffness:
round-off of the stiffness matrix."""

NO_MASS = 1e-12
"""A motion has no mass below this share of the largest."""

FREE_STIFFNESS = 1e-13
"""A motion is free if its stiffness or its eigenvalue is below this share of the largest, or of the stiffnesses at its
coordinates, which is round-off."""

REPEATED_EIGENVALUE = 1e-8
"""Eigenvalues or poles within this share of each other are one that is repeated."""

LARGEST_ALIKE = 1e-6
"""Numbers are alike within this share of the largest. The first of them decides a sign, a place or an order, since
round-off must not decide."""

FREE_POLE = 1e-7
"""A pole or a frequency below this share of the largest belongs to a free motion, by round-off."""

SAME_ANSWER = 1e-6
"""Answers belong to the same model if they agree up to this share of the largest. Beyond round-off times the condition
of a leaf spring, more than numbers has changed."""

CONSTRAINTS_MET = 1e-9
"""Largest error of constraints and held deformations, in radians or as a share of their value for a length of the
whole extent."""

SUPPORTED = 1e-13
"""Stiffness that makes a singular matrix regular, over its largest entry: just above round-off."""

NEGATIVE_BY_ROUND_OFF = 1e-10
"""A mass or a flexibility is negative below minus this share of the largest, or of the own entry of its coordinate.
Nearer to zero stands round-off."""

REPORTED_ERROR = 0.01
"""Error of a state space or a response, by what it leaves out, that is reported."""

BOUNDED_ROUND_OFF = 1e-14
"""Round-off of a sum over the bound of its terms, and of a matrix over its largest entry."""

# --- root -----------------------------------------------------------------------------------------------------------

OUTER_MOTION = 1e-6
"""A mode moves nodes, and not only inner coordinates of elements, above this share of its largest motion. Below is
round-off."""

POWER_OF_TEN = 1e-9
"""Added to a logarithm, so that round-off does not put a power of ten below its prefix."""

# --- elements -------------------------------------------------------------------------------------------------------

DISTINCT_DECAY = 1e-3
"""Least size of the part of a decaying function that polynomials of twist leave out. With less, stiffnesses of the
coefficients of a leaf spring differ by 13 digits; more changes answers."""

SHORTEST_ELEMENT = 1e-12
"""Shortest length of an element over the largest coordinate of its ends. Positions have 16 digits: below this, ends
such as 3 * 0.05 and 0.15 differ by round-off alone."""

SOFTEST_STIFF_SOLID = 1e6
"""Young's modulus in Pa below which solids are gels, soft rubbers or foams. Moduli of metals in MPa (210e3)
or GPa (210) are below."""

DENSEST_GEL = 1500.0
"""Density of gels and soft rubbers in kg/m^3, with fillers."""

DENSEST_SOLID = 3e4
"""Density in kg/m^3; osmium has 22 600."""

LIGHTEST_STIFF_SOLID = 25.0
"""Density in kg/m^3 below which no solid is stiffer than SOFTEST_STIFF_SOLID. Densities in g/cm^3 are below."""

WEAKEST_SOLID = 1e-6
"""Strength over Young's modulus; annealed pure metals have 1e-4. A strength in MPa beside E in Pa has at most 1e-7."""

LARGEST_EXPANSION = 1e-2
"""Coefficient of thermal expansion in 1/K; polymers have up to 3e-4. Numbers in 1e-6/K are above."""

CONTRADICTING_MODULI = 0.1
"""Relative difference of G from E/(2 (1 + nu)). Published constants of metals scatter by up to 3 %."""

LARGEST_MECHANISM = 1e3
"""Distance of nodes in m; the largest cranes have 250 m. Lengths above 1 m in mm, and above 1 mm in um, exceed it."""

LARGEST_SECTION = 10.0
"""Width, thickness or diameter of a beam in m; towers have up to 10 m. A width of 18 mm in mm exceeds it."""

THICKEST_LEAF_SPRING = 0.05
"""Thickness of a leaf spring in m; leaf springs of railway wagons have 0.02 m. A sheet of 0.1 mm in mm exceeds it."""

DIRECTED_STRESS = 1e-9
"""A bending moment or a shear force on a ring has a direction where it exceeds this share of all that stresses the
section. Below, its direction is round-off and has no derivative."""

STRIP_RATIOS = 30.0
"""u^4 of a bent strip up to which power series replace the closed form. The series are exact to round-off there, and
derivatives of the closed form lose digits."""

STRIP_SERIES = 0.06
"""u^4 of a flattened strip up to which a quotient of power series replaces the closed form. The series is exact to
1e-10 there, and the closed form loses digits."""

SMOOTH_CURVE = 1e-6
"""An initial curvature is smooth if its series of twenty terms misses it by less than this share of the largest."""

SAME_LINE = 1e-6
"""A curve goes through its points, and its ends lie at the nodes, within this share of its length."""

PARALLEL = 1e-5
"""Sine of the angle up to which a vector that fixes local y is parallel to the axis."""

SAME_END = 1e-9
"""A curve of a given chord is found where its chord is right to this share."""

SAME_SIZE = 1e-9
"""Leaf springs in line have no step in width or thickness if these differ by less than this share."""

SAME_STIFFNESS = 1e-6
"""A stiffness matrix is symmetric up to this share of the roots of its diagonal. Printed numbers have seven digits."""

LEAST_OF_STIFFNESS = 1e-12
"""Smallest eigenvalue of a positive definite stiffness matrix of a section with ones on its diagonal. Below stands
round-off."""

SMOOTH_COMPLIANCE = 1e-3
"""Largest error of mean compliances by the Gauss nodes of a beam. Beyond, a section is not smooth between breaks."""

SMOOTH_MASS = 1e-2
"""The same of the mass, by few Lobatto nodes of a beam in space of low order. Mass has less effect than stiffness."""

# --- motion -----------------------------------------------------------------------------------------------------------

ENERGY_PER_STEP = 3.0
"""A step may gain or lose this times the relative tolerance of the greatest energy. At 10, twenty impacts between
walls add up to more than the warning's limit; at 3 they do not (tests/motion/test_balance.py)."""

INTEGRATOR_POLE = 1e-8
"""A controller's pole is an integrator within this of zero, or of one if it is sampled: round-off of eigenvalues."""

REDUNDANT_COMPLIANCE = 1e-8
"""Share of a constraint's own compliance that is added to it. It keeps the equations solvable for constraints that
are redundant or lose rank for a moment; a smaller compliance counts as redundant."""

CHAIN_RESIDUAL = 1e-6
"""Corrected accelerations of a chain leave less than this share of the first residual, unless masses are singular."""

DRIVEN_START = 1e-6
"""A motion cannot start if driven coordinates or deformations miss their values by more than this share of the
extent."""

KINK_OVER_USUAL = 8.0
"""A function has a kink where its second difference exceeds this times the median of a step."""

KINK_OVER_SLOPE = 1e-3
"""A kink changes the slope by at least this share. A smaller one has no effect on a step within its tolerance."""

STEP_AT_KINK = 1e-6
"""A step across a kink is shortened to this share of the step that was refused."""

JUMP_AT_KINK = 0.3
"""A function jumps if the shortest step across a kink has more than this share of the first step's change."""

TIME_ROUND_OFF = 1e-14
"""Steps are not shortened below this share of the time, where its round-off shows."""

SHORTEST_STEP = 20.0
"""Steps are not shortened below this times the smallest step, at which an integration fails."""

STEADY_CONVERGED = 1e-9
"""Last change of a degree of freedom of a steady motion, over its size."""

STEADY_EQUATIONS = 1e-6
"""A motion is steady if its equations change by less than this share while it goes on."""

SMALL_DIAGONAL = 1e-8
"""Diagonal entries below this share of the largest do not scale a comparison of matrices: it would show round-off."""

REUSED_FACTORS = 0.2
"""A time step keeps its factorised matrix while each iteration reduces the change at least to this share."""

STEP_CONVERGED = 1e-14
"""Displacements over their sizes change by less than this when a time step is solved."""

STEP_STALLED = 1e-10
"""An iteration that stalls below this change, at round-off, counts as solved too."""

ROOT_FINDER = 1e-3
"""Tolerance of the root finder of an implicit solver, as share of the relative tolerance of a step."""

ENERGY_OF_MOTION = 100.0
"""A motion that gains or loses more than this times its relative tolerance of energy without a cause is reported."""

ENERGY_ROUND_OFF = 1e-8
"""Smaller shares of the greatest energy are round-off. Four bars that pass their singular position at rtol 1e-11 end at
1.2e-9 (tests/motion/test_simulate.py), since their constraint forces are large there."""

SOON_AFTER_START = 1e-3
"""An event condition that is zero at the start is evaluated again after this share of the time."""

MOVED_START = 1e-6
"""Drives that move the start by less than this share of the extent, or of the largest rate, are not reported."""

LARGE_DISPLACEMENT = 0.5
"""Displacement beyond which the tolerance of a step stays constant (extents, radians)."""

RAN_AWAY = 1e8
"""A motion that comes this far (extents, radians) runs away: it would end in infinity after very many steps."""

JUST_BEHIND = 1e-15
"""A step ends just behind a jump within this share of its time: at the next number, or the one after it."""

SHORTEST_TIME_STEP = 1e-12
"""Smallest step, as share of the time: shorter steps do not advance the time."""

SUDDEN_OVER_USUAL = 5.0
"""A function of time changes suddenly where its second difference exceeds this times the usual one."""

SUDDEN_BEND = 1e-6
"""Smallest second difference of a sudden change, over the range of the function. Changes that take a seventh of the
time stay below; no step misses them."""

JUMP_OF_RANGE = 0.02
"""A function of time jumps if it changes by more than this share of its range between two of the compared times."""

# --- linear -----------------------------------------------------------------------------------------------------------

FAR_BEFORE_BUCKLING = 0.3
"""Loads that move a mechanism by more than this before it buckles are reported (extents, radians)."""

BENT_BY_LOADS = 0.1
"""If all loads are scaled, loads that move a mechanism by more than this are reported: multipliers are about the moved
state. A strip on edge that is turned by 0.1 rad has a multiplier that is wrong by 5 %."""

KNOWN_EIGENVALUE = 1e-3
"""An eigenvalue of an unsymmetric matrix is known if round-off moves it by less than this share."""

UNBOUNDED_MULTIPLIER = 1e9
"""Load multipliers above this times the smallest are unbounded: the load does not act in that motion."""

STRESS_ROUND_OFF = 1e-15
"""Round-off of stress resultants: that of a deformation, over what the mechanism's extent would make of it; that of a
constraint force, over the largest force that it balances; that of an element's curvature, over its largest entry."""

HELD_COMPLIANCE = 1e-7
"""A direction of a node is held if the root of its compliance is below this share of the largest root among
displacements, or among rotations: a share of 1e-14 of a compliance is round-off; leaf springs have 1e-8 at least."""

NEGATIVE_WORK = 1e-6
"""Forces on a node in a stable state do no negative work beyond this, for compliances scaled to one."""

VIBRATES_ABOVE_SHIFT = 1e-6
"""If K had to be shifted by s, a motion vibrates whose omega^2 exceeds this share of s; others meet no stiffness."""

LANCZOS_CONVERGED = 1e-4
"""Change of a motion by one more Lanczos iteration. The error of an eigenvalue is its square."""

COUNTED_BEFORE_LAST = 1e-6
"""Eigenvalues are counted up to this share before the last that was found."""

ONE_CLUSTER = 1e-6
"""Eigenvalues within this share of each other have one common space of modes: the vector of one is round-off."""

TRUE_POLE = 1e-9
"""Residual of a pole's motion over its size. Above, another shift is tried."""

FREE_ENERGY = 1e-8
"""A free motion has less elastic energy than this share of the round-off of the largest stiffness."""

KNOWN_BY_FACTORS = 0.1
"""Factors that know an eigenvalue to this share make iterations with a better product converge."""

ROUGH_EIGENVALUE = 1e-4
"""Accuracy of eigenvalues that only determine a shift."""

GOOD_MOTION = 1e-6
"""Change of a motion by one more iteration, whose square is the error of an eigenvalue. Above, another shift is
tried."""

EIGENVALUES_APART = 1e4
"""Iterations alone separate eigenvalues at least this factor apart. Together, the round-off of the larger would be the
error of the smaller."""

DEFINITE_STIFFNESS = 1e-14
"""A stiffness needs no shift if its lowest eigenvalue is above this share of |K|/|M|."""

FIRST_SHIFT = 1e-8
"""Otherwise shifts start at this share of |K|/|M| and grow until K + sM is positive definite, so that the shift is not
much larger than the most negative eigenvalue needs. A smaller shift leaves no digits for others beside a free
motion."""

GENERAL_SHIFT = 1e-6
"""First shift for an unsymmetric K, whose factors do not show definiteness. Beside a free motion, eigenvalues from
1e-12 to 1 of |K|/|M| then keep nine digits."""

TOLD_BESIDE_SHIFT = 1e-10
"""Beside a shift, an eigenvalue above this share of it is known not to be zero."""

NEXT_SHIFT = 1e-4
"""The next shift is this share of the lowest eigenvalue that is known not to be zero. Below both shares, one is
zero."""

SURE_EIGENVALUE = 10.0
"""An eigenvalue is known if it is above this times its round-off."""

LOST_EIGENVALUE = 1e-3
"""An eigenvalue is lost if its round-off is above this share of it, and above FAINT of others."""

FAINT = 1e-9
"""Round-off below this share of other eigenvalues does not count: a zero beside them, as at a critical state, is no
loss."""

MASSLESS_SHARE = 100 * 2.0**-52
"""A motion has no mass if its mu is below this share of the largest, per degree of freedom."""

WITHOUT_MASS = 1e-13
"""A combination of degrees of freedom has no mass below this share of the masses at them, per degree of freedom."""

REGULAR_STIFFNESS = 1e12
"""Largest condition of a stiffness from whose side slow poles are solved."""

SIZES_APART = 1e-6
"""Poles are split between both sides where sizes differ by at least this share."""

REAL_VALUE = 1e-8
"""A value is real if its imaginary part is below this share of it."""

GROWING_POLE = 1e-9
"""A pole grows if its real part is above this share of its size."""

BESIDE_BREAK = 1e-9
"""Distance from a break at which both its sides are evaluated, over an element's length."""

SOLVED_BY_VECTOR = 1e-6
"""Residual of the vector of a pole, for equations scaled to one."""

MEETING_POLES = 1e-5
"""Least change of the scaled equations with the pole along its vectors. Below, two poles almost meet with one vector,
and their derivatives have no digits."""

BESIDE_POLE = 1e-7
"""Sparse factors are taken this share beside a pole. Errors of vectors are its square."""

# --- control ----------------------------------------------------------------------------------------------------------

COUPLED_MODES = 1e-8
"""Damping couples two modes if the matrix between them exceeds this share of the mean of their own entries. It is far
above round-off and far below what a response would show."""

RESONANCE_HIT = 16 * 2.0**-52
"""A resonance is hit if stiffness minus inertia is below this share of both: 16 times round-off."""

SAME_MODE = 1e-9
"""Squared frequencies of modes within this share of each other belong to the same mode."""

TURN_OF_MODES = 1e-5
"""A Newton step that turns modes by more than this into each other does so by round-off."""

RESONANT_SOLUTION = 1e-3
"""Largest error of a solution near an undamped resonance."""

ENTRY_ROUND_OFF = 1e-13
"""An entry of a semidefinite matrix is round-off below this share of what its diagonal allows."""

WHOLE_SAMPLES = 1e-6
"""A delay is a whole number of samples within this share of one."""

GROWING_NOISE = 1e-10
"""A motion grows if its pole has a real part above this share of the largest pole. Round-off moves the double pole of a
free motion by its root."""

UNRESOLVED_SHARE = 0.02
"""Frequencies do not resolve a resonance if they change a mean square by this share (the root mean square by half)."""

DRIFTING_NOISE = 0.01
"""An output drifts if its spectrum at the begin of a band from 0 Hz, times that frequency, exceeds this share of the
sum."""

DECAYING_POLE = 1e-13
"""A motion decays if its pole has a real part below minus this share of the largest pole; round-off is smaller."""

FIRST_OF_BAND = 1e-4
"""A band from 0 Hz begins at this share of its slowest pole or of its end: an acceleration has moved without bounds at
rest."""

POLE_AT_REST = 1e-9
"""A pole below this share of a band's end does not vibrate."""

CHANGE_OF_RESPONSE = 0.02
"""Largest change of a response from one frequency to the next, without known poles."""

FAINT_RESPONSE = 1e-6
"""Changes below this share of the largest response do not count."""

NEAREST_FREQUENCIES = 1e-9
"""Frequencies are at least this share apart."""

CURVED_DENSITY = 0.002
"""A density is refined if it leaves the straight line between two frequencies by this share of its value."""

DEPENDENT_FOUND = 1e-6
"""Newton's method has found the dependent coordinates if as many steps again change them by less than this share of the
extent, or radians: the error is then at most its square."""

POSITION_OUTPUT = 0.1
"""An output is a position if its part by rate is below this share of it, at the frequency of the plant."""

NARROWEST_RESONANCE = 1e-6
"""Smallest half width of a resonance about which frequencies are placed, over its frequency."""

POLE_AT_ORIGIN = 1e-7
"""Two poles at the origin are off it by less than this share of the fastest pole, the root of round-off."""

FARTHEST_ZERO = 1e4
"""A zero above this times the fastest pole is at infinity, but for round-off."""

TWIN_FREQUENCIES = 1e-12
"""Of two frequencies within this share, as two conjugate poles give them, one is enough."""

NEARLY_CROSSING = 0.3
"""Dips of a function that changes its sign are searched if they are as near to zero as this."""

BLUR_OF_POLE = 1e-14
"""Round-off blurs a pole by this share of the highest frequency."""

JUMP_OF_PHASE = 0.1
"""A function that has not come down to this share so near to a zero jumps over it."""

LEVEL_AT_REST = 0.01
"""A response near rest is constant if its size differs by less than this share from that at twice the rate."""

# --- paths ------------------------------------------------------------------------------------------------------------

SOFT_SIGN = 1e-8
"""A flexibility shows the sign of a motion above this share of the largest. The stiffness shows that of others."""

SMALL_MOTION = 1e-4
"""Displacements of points are measured by a motion of this share of the extent, forth and back."""

ALLOWED_STATE = 1e-13
"""Last change of coordinates of an allowed state, over their sizes."""

STATIONARY_LOAD = 1e-13
"""The load is stationary if its rate along the path, at most one, is below this. The load has all its digits long
before; the error of its derivative is that of the place."""

TURNED_LOAD = 1e-6
"""A path whose rate of the load is nowhere below this between the nearest states jumps there."""

SETTLED_LIMIT = 1e-12
"""The place of a limit point is known if it changes by less than this share of the step."""

SMALL_IMPERFECTION = 1e-4
"""A small imperfection that a message proposes, over the extent."""

CRITICAL_RESIDUAL = 1e-7
"""Residual of a motion of a critical value; the error of the value is its square."""

SETTLED_MOTION = 1e-5
"""Flexibility times residual of a motion over the motion. The error of the value is its square."""

LOST_MOTION = 1e-3
"""Above this, after the first correction, which finds missed copies of a value, round-off hides the path at a critical
point."""

DOUBTED_SIGN = 100
"""Pivots may miss the sign of a value up to this times the difference of factors and better products."""

SMALLEST_COSINE = 0.9
"""Cosine of the largest turn of the tangent in a step: 25 degrees."""

LARGEST_MOTION = 0.2
"""Largest motion in a step (extents of the mechanism, radians)."""

SHORTEST_PATH_STEP = 1e-6
"""Steps shorter than this share of the first are not tried."""

STRAIGHT_PATH = 0.98
"""Cosine of the turn of the tangent in a step (11 degrees) up to which the next step is twice as long."""

SMALLEST_SCALE = 0.05
"""Smallest motion that weighs as much as the whole load in the length of a path (extents, radians)."""

REUSED_CORRECTION = 0.1
"""Factors of a correction are reused if the next correction then leaves less than this share of the tolerance."""

NEAR_STATES = 1e-6
"""A zero is found between states this near to each other: the path is straight there to 1e-12."""

WIDEST_GAP = 1e-3
"""States on both sides of a zero are at most this share of the step apart, and joined by a smooth curve: a path that
bends away beside another seems to continue on that. Otherwise the step is shortened."""

WIDEST_GAP_AT_LEAST = 1e-5
"""Distance of such states that always suffices."""

VANISHED_VALUE = 1e-4
"""A critical value that changes its sign on a step is zero where the load turns back if it is below this share of those
at the ends of the step: a second search would find the same point."""

NEUTRAL_VALUE = 1e-13
"""A critical value below this share of the next one has no sign: a column that may buckle to any side moves between
sides without force."""

SAME_STATE = 1e-7
"""States of a closed path agree to this (extents, radians, load factor): Newton's tolerance."""

NEUTRAL_ON_BRANCH = 1e-5
"""If two motions lose their stiffness at once, one meets none on the branch if its critical value there is below this
share of the next one; otherwise both grow alike."""

NULL_VECTOR_SHIFT = 1e-9
"""Shift that makes a singular stiffness regular for its null vector, over the critical value at the begin of the
step."""

HOLD_ON_BRANCH = 1e-3
"""Stiffness that holds a motion without any on a branch, over the critical values at the ends of the step. It is far
below other stiffnesses, so that the corrector converges, and far above round-off."""

FIRST_ON_BRANCH = 0.02
"""Motion of the first step on another branch (extents, radians)."""

# --- statics ----------------------------------------------------------------------------------------------------------

COARSE_ANGLE = 0.2
"""Angle between the chord of a beam and its end, or of its twist [rad], up to which one beam has an error of 6 % of the
deflection of an arc, and 3 % of a twist. Both errors grow with its square."""

LONGEST_STROKE = 0.01
"""Stroke over the length of a leaf spring, below which skew cuts and initial twist need no warning."""

LONGEST_CUT = 0.12
"""Distance along a leaf spring between both edges of its skew cuts, the sum of both ends, over its length: 30 degrees
at one end at a width of 0.2 of the length. Up to it, stiffnesses at strokes of a fifth are within 2.5 % of solid
elements."""

MOST_TWIST = 0.035
"""Initial twist in rad, 2 degrees. Above it, the stiffness across the stroke differs by up to 57 % from solid elements
near its least value."""

FINE_TWIST_ORDER = 9
"""Order of a leaf spring with initial twist, from which it was compared with solid elements at strokes."""

WIDEST_BENT = 12.0
"""u of (2.56), which grows with the curvature of a leaf spring, up to which its law is compared with solid elements."""

STRETCHED_BEAM = 0.01
"""Strain up to which cubic beams, of any number, bend with an EI that is correct within 2 %."""

CONFIGURATION_STEP = 0.2
"""Given coordinates move from their undeformed value in steps of this share of the mechanism's extent, or radians."""

SETTLED_CONFIGURATION = 1e-10
"""Last correction of a configuration, over the extent, or in radians."""

FOLDED_MECHANISM = 1e5
"""Largest motion by a change of the constraints, over that of the undeformed mechanism. A crank that is a share y of
its length from its dead point is moved some 1/y times as far, and round-off of its velocity is that over y^2."""

LOOSE_BY_ROUND_OFF = 1e-20
"""A motion has no stiffness below this share of the largest stiffness, even if other motions join it by round-off."""

STEP_TOLERANCE = 1e-9
"""A smaller correction is made and ends the iteration: the error left is of the order of its square."""

LOOSE_TOLERANCE = 0.005
"""Distance to an equilibrium that may be left at loads that are only passed."""

SMALLEST_LOAD_STEP = 1e-5
"""Load steps are not shortened below this share of the load."""

DEFORMATION_ROUND_OFF = 1e-13
"""Round-off of a deformation, over what the mechanism's extent would make of it."""

CRITICAL_SHARE = 1e-4
"""An equilibrium is critical if its stiffness K in some motion is below this share of the structural stiffness K0. At a
limit point the share falls with the root of the distance: a change of the load by some 1e-9 of itself doubles the
derivative there. At a bifurcation it is the distance itself. It has no unit, and is 1 without load for any leaf
spring."""

NEGATIVE_SHARE = 1e-6
"""A stiffness is negative below minus this share of the structural stiffness in the same motion; nearer to zero a state
is critical."""

STIFFNESS_ROUND_OFF = 1e-10
"""If nothing elastic resists a motion, its stiffness is negative below minus this share of the largest."""

SYMMETRIC_STIFFNESS = 1e-9
"""Larger differences of K from its transpose, with entries scaled to one, are those of loads without potential."""

DEPENDENT_VECTOR = 1e-20
"""Square of a vector, over that of the previous one, below which it depends on earlier ones."""

NEEDLESS_ENERGY = 30.0
"""Elastic energy over the least possible one that is reported. Shapes that elements take gradually stay below."""

# --- math -----------------------------------------------------------------------------------------------------------

ANGLE_BY_SERIES = 1e-4
"""Square of an angle below which sine and cosine are taken from their series, exact to round-off there [rad^2]."""

SMALLEST_TURN = 1e-20
"""Square of the sine of half an angle below which the sine is the angle, to round-off."""

EIGENVALUES_ALIKE = 1e-5
"""Relative distance of two eigenvalues below which the mean slope replaces their divided difference. Both have lost as
many digits there."""

EIGENVALUES_REPEATED = 1e-10
"""Relative distance of two eigenvalues of a pencil below which their vectors have no derivative of their own: the
derivative divides by the distance."""

EIGENVECTORS_APART = 1e6
"""Largest row sum of the inverse of the matrix of eigenvectors. Beyond, vectors are nearly parallel, and derivatives of
their eigenvalues lose as many digits."""

EIGENVECTOR_DIGITS = 1e-11
"""Residual of an iterated eigenvector over its eigenvalue at which the iteration ends."""

SEMIDEFINITE = 1e-9
"""An eigenvalue is negative below minus this, in units that make the diagonal one: far above round-off."""

SMALLEST_PIVOT = 1e-13
"""Least pivot of a regular dense matrix over its largest pivot. Solutions keep three digits there."""

ZERO_SINGULAR_VALUE = 1e-12
"""Singular values below this share of the largest are zero for the dense solver: some digits above round-off."""

RANK_TOLERANCE = 2.0**-26
"""Singular values below this share of the largest are zero in decisions about a model: square root of round-off, the
predecessor's choice."""

REPROJECTED = 1e-6
"""Rows are projected anew when the squares of what is left fall below this share: differences have lost six digits."""

EQUAL_ROWS = 1 - 1e-6
"""Rows of at least this share of the largest norm count as equally large, so that round-off does not choose one."""

NEGLIGIBLE_PIVOT = 1e-14
"""Pivots of a sparse matrix, scaled to entries of one, are round-off below this share of the largest."""

DIAGONAL_PIVOT = 1e-8
"""A diagonal entry is a pivot of sparse factors above this share of the largest in its column. It may be small, since
stiffnesses are far apart and rows that change places would fill the factors."""

BACKWARD_ERROR = 1e-10
"""Largest residual of a solution over itself and the right-hand side, in scaled equations. Beyond, rows change."""

REFINED = 1e-13
"""A correction this small beside the solution ends iterative refinement: it is round-off."""

UNREFINED = 1e-6
"""The largest last correction of a refined solution; a larger one that no longer falls by half is refused."""

FORCE_ROUND_OFF = 10 * 2.0**-52
"""Round-off of forces over the largest: some units in the last place."""

# --- build ----------------------------------------------------------------------------------------------------------

INDEPENDENT = 1e-5
"""Part of a unit candidate for a degree of freedom that must remain after those already chosen. Below, the rest of the
mechanism would be determined to ten digits or fewer."""

CLEARLY_INDEPENDENT = 1e-2
"""The same if better candidates follow."""

TURNS_BACK = 2.0
"""A position becomes a degree of freedom if its change in extents exceeds the change of a rotation in radians by this
factor. Otherwise flexmb chooses the rotation. It determines the mechanism over the whole turn, with 0.3 digits less."""

CANNOT_MOVE = 1e-7
"""Change of a degree of freedom per unit motion below which it cannot move: null spaces carry the square root of
round-off."""

ELEMENT_LAW = 1e-9
"""Largest deviation of a user's element from a law, relative to numbers of the same kind. Round-off leaves 1e-14."""

ELEMENT_DIFFERENCE = 1e-5
"""The same for derivatives against differences, which carry 1e-10."""

POTENTIAL_DIFFERENCE = 1e-2
"""The same for the slope of a potential, which may have a corner within a step, as in contact."""

# --- blocks ---------------------------------------------------------------------------------------------------------

SHORTEST_DIRECTION = 1e-9
"""Least length of a vector that states a direction, of unit length or in metres: below stands round-off."""

# --- trajectory -----------------------------------------------------------------------------------------------------

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

SMALLEST_SHAPE = 1e-6
"""A mode moves its lines, or turns its sections, above this, per unit of its largest coordinate. Below stands the
round-off of the difference that finds the motion."""

SAME_PLACE_ON_LINE = 1e-9
"""A node is the end of a line if it is nearer than this share of the line's extent."""

BETWEEN_ENDS = 1e-9
"""A state lies between two others within this share of their squared distance: an end is between them too."""

OPPOSITE_TANGENTS = 1e-9
"""1 plus the cosine of a turn is at least this. A line that turns back on itself has no smallest rotation."""

PHASE_OF_MINUS_180 = 1e-3
"""A phase that begins within this below 180 degrees is drawn from -180, as of a mass without support [degrees]."""

# --- workbench ------------------------------------------------------------------------------------------------------

REPEATED_ANSWER = 1e-6
"""Two frequencies, load multipliers or stresses are repeated within this share: one alone has no derivative there."""

TARGET_MET = 1e-9
"""A target is met if its answer misses it by this share at most."""

TARGET_TO_ROUND_OFF = 1e-12
"""A target is met to round-off within this share. Below it the nearest design is best."""

TARGET_NEARLY = 1e-6
"""The search for targets may miss them by this share. Searches for the targets alone follow it."""

TARGET_AGAINST = 1e-4
"""A target that is met with less than this share to spare limits the others."""

# --- design ---------------------------------------------------------------------------------------------------------

NOT_LINEAR = 0.2
"""A scatter is not linear if its second order exceeds this share of the first. Our choice."""

RIGID_NODE = 1e-20
"""A node is rigid along an axis if its compliance is below this share of the most compliant node. Below stands
round-off of the solution."""

ALONG_AXIS = 1 - 1e-12
"""A unit vector lies along an axis if its component exceeds this."""

VIOLATION_FALLS = 0.25
"""The weight of the penalty grows if a round leaves more than this share of the violation."""

MISSED_TOLERANCES = 100
"""Targets are missed beyond this many tolerances. Our choice."""

MISSED_BY_FIT = 0.1
"""Targets that outnumber the dimensions are missed beyond this: a fit meets them in the mean only. Our choice."""

AT_BOUND = 1e-6
"""A dimension is at a bound within this share of its range."""

STATIONARY = 1e-7
"""Projected derivative of the scaled Lagrangian at an optimum."""

FIRST_STATIONARY = 1e-2
"""The same after the first round, whose multipliers are rough."""

NEARLY_STATIONARY = 1e-4
"""The same if no lower design is found: round-off of the answers hides the descent."""

TARGET_OF_TUNE_MET = 1e-8
"""A target is met if its answer misses it by less than this share. Below stands round-off of the answers."""

SOFT_TARGET_MET = 1e-5
"""The same beside an objective or limits: a search ends with such differences, and a user does not see them."""

NEGLIGIBLE_SHARE = 0.1
"""Share of the tolerance of a lean model for negligible deformations. The rest is for condensed ones. Our choice."""

SAME_DIRECTIONS = (1e-4, 1e-6, 1e-8, 1e-10)
"""Directions whose energy is below this share of the largest are dropped. Smaller ones are tried if the error is too
large."""

NO_MOTION = 1e-7
"""A deformation depends on those that are FIXED if this share of its motion is left."""

LIMIT_PLACE = 1e-6
"""A limit is located to this share of the distance between two strokes."""

LIMIT_EXTREME = 1e-4
"""An extreme of a curve is located to this share of the distance between the strokes beside it."""

LIMIT_ENDS = 0.01
"""The last stroke with an equilibrium is located to this share of the given stroke."""

NEAR_RESONANCE = 0.1
"""Transfer functions are compared beyond this relative distance from resonances, where small shifts change them much.
Our choice."""

ZERO_FREQUENCY_OF_BAND = 1e-9
"""Frequencies below this share of the bandwidth are compared as if they had this size."""

NEAR_BAND = 2.0
"""Vibrations of a beam between its ends matter up to this multiple of the bandwidth. Our choice."""

# --- spacar ---------------------------------------------------------------------------------------------------------

SIZES_ALIKE = 0.02
"""Second moments over the area by sizes and by ESTIFF agree within this share. Sizes in files are often rounded."""

LARGEST_MULTIPLIER = 1e12
"""Load multipliers beyond this are round-off of the geometric stiffness: no load acts."""

LIGHT_SHORTEST = 1e-5
"""Shortest beam of a SPACAR Light script, and longest hinge [m]. The predecessor has the same limit."""

LIGHT_LENGTH_RATIO = 1000
"""Largest ratio of two beam lengths in a SPACAR Light script. The predecessor has the same limit."""

LIGHT_PARALLEL = 1e-5
"""A beam is parallel to its orien up to this sine of the angle. The predecessor has the same limit."""

LIGHT_THIN = 1e-4
"""A size of a section below this is likely given in the wrong unit [m]."""

# --- checks ---------------------------------------------------------------------------------------------------------

SMALLEST_SHARE = 1e-3
"""Parts below this in a motion or a self-stress, whose largest is 1, are not listed."""

TAKES_NO_PART = 1e-6
"""A constraint with less than this part in all self-stresses of norm 1 takes no part in them."""

CLOSED_LOOP = 1e-10
"""Scaled deformations that are fixed are closed below this, which Newton's method reaches in double precision."""

SELF_STRESS = 1e-6
"""Scaled singular values below this are those of a self-stress. Near a branching point the others come close."""

# --- answers --------------------------------------------------------------------------------------------------------

# --- identification -------------------------------------------------------------------------------------------------

MISTAKEN_UNIT = 300.0
"""Measured values over computed ones at the start, in the mean. Beyond, the unit is mistaken: units differ by 1000."""

WORST_MAC = 0.5
"""A measured shape has no partner if its modal assurance criterion is below this with every mode."""

UNDETERMINED_SHARE = 12**-0.5
"""Standard deviation of a combination of parameters over the distance of their bounds. Beyond, data tell no more than
the bounds: a uniform distribution between them has this deviation."""

PART_IN_COMBINATION = 0.02
"""A parameter with less than this part in a direction does not belong to the combination."""

OUTLIER = 3.0
"""Differences beyond so many standard deviations are named. Scatter alone exceeds it once in 370."""

IMPLAUSIBLE = 1e-3
"""A chi-squared that scatter alone exceeds with a smaller probability is no scatter."""

UNEVEN_SCATTER = 2.0
"""Scatter of differences at large answers over the scatter at small ones. Up to this, a common deviation is wrong by a
factor of two at most."""

FEWEST_OF_SCATTER = 8
"""Fewest values whose scatter is compared with their size: with five, equal scatter is called uneven in 3 % of fits."""

UNTESTED = 1e-3
"""A value with a smaller share of its variance in its difference from the model is met by the fit, whatever it is."""

EXACT_FIT = 1e-7
"""Differences below this share of the values are round-off of data that a model computed: no instrument measures so."""

SAME_MINIMUM = 1e-3
"""Two minima are one if no scaled parameter differs by more than this."""

AS_GOOD = 4.0
"""Another minimum fits as well if its chi-squared is larger by less than this: two standard deviations."""

SETTLED_COST = 1e-10
"""A search ends if the cost changes by less than this share."""

SETTLED_PARAMETERS = 1e-8
"""A search ends if the scaled parameters change by less than this, far below any scatter."""

HIDDEN = 0.5
"""A difference of models below this share of a standard deviation is hidden by scatter: the root of the mean square of
both is larger by an eighth at most."""

NOT_MIXED = 1.05
"""Largest R-hat of samples that represent a posterior. Vehtari and others 2021 ask for 1.01 with many chains."""

FEW_DRAWS = 100
"""Fewest independent samples: quantiles 0.025 and 0.975 rest on two or three of a hundred."""

LARGEST_RATIO_OF_MODE = 0.5
"""Poles with a larger damping ratio make no peak, and are not taken for modes of a measured response."""

SAME_POLE = 3e-4
"""Poles closer than this share of their modulus are one: a tenth of the width of a peak with 0.15 % damping."""
