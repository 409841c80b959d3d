"""Names that this room offers beside those of flexmb itself."""

from .controlled_form import Feedback as Feedback
from .drive import Table as Table
from .energy_keeping import EnergyKeeping as EnergyKeeping
from .generalized_alpha import GeneralizedAlpha as GeneralizedAlpha
from .linearized import linearize_motion as linearize_motion
from .linearized import steady_motion as steady_motion
from .loop import Sampled as Sampled
from .rosenbrock import Rodas5P as Rodas5P
from .simulate import Motion as Motion
from .simulate import Observed as Observed
