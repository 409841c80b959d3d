"""Names that this room offers beside those of flexmb itself."""

from .comparison import Comparison as Comparison
from .fitted import Fit as Fit
from .fitted import ProfileLikelihood as ProfileLikelihood
from .measurement import Measured as Measured
from .modal_data import ModalData as ModalData
from .modal_data import modes_of_response as modes_of_response
from .posterior import Posterior as Posterior
from .problem import Undetermined as Undetermined
