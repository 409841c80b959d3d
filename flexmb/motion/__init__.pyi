"""Names that this room offers beside those of flexmb itself."""

from .controlled_form import Feedback as Feedback
from .controllers import Sampled as Sampled
from .drive import Table as Table
from .drives_by_name import Drives as Drives
from .energy_keeping import EnergyKeeping as EnergyKeeping
from .generalized_alpha import GeneralizedAlpha as GeneralizedAlpha
from .integrator import Integrator as Integrator
from .linearized import linearize_motion as linearize_motion
from .linearized import steady_motion as steady_motion
from .loop import Loop as Loop
from .motion import Motion as Motion
from .motion import Observed as Observed
from .rosenbrock import Rodas5P as Rodas5P
