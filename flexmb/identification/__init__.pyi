"""Names that this room offers beside those of flexmb itself."""

from .comparison import Comparison as Comparison
from .fitted import Fit as Fit
from .fitted import ProfileLikelihood as ProfileLikelihood
from .measurement import Measured as Measured
from .posterior import Posterior as Posterior
from .undetermined import Undetermined as Undetermined
