"""Names that this room offers beside those of flexmb itself."""

from .fitted import Fit as Fit
from .fitted import ProfileLikelihood as ProfileLikelihood
from .measurement import Measured as Measured
from .measurement import measured as measured
from .mode_pairing import measured_modes as measured_modes
from .response_data import measured_response as measured_response
from .undetermined import Undetermined as Undetermined
