"""Names that this room offers beside those of flexmb itself."""

from .designs import Designs as Designs
from .designs import grid as grid
from .designs import latin_hypercube as latin_hypercube
from .designs import monte_carlo as monte_carlo
from .lean import Lean as Lean
from .leanness import too_lean as too_lean
from .problem import Curve as Curve
from .robust import Robustness as Robustness
from .robust import robust_front as robust_front
from .robust import robustness as robustness
from .scatter import Scatter as Scatter
from .sensitivities import Sensitivities as Sensitivities
from .settling import settling_time as settling_time
from .swept import Front as Front
from .swept import Sweep as Sweep
from .tolerance import Tolerances as Tolerances
from .tolerance import tolerances as tolerances
from .tuned import Combination as Combination
from .tuned import Tuned as Tuned
from .verdict import Verdict as Verdict
