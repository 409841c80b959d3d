"""Names that this room offers beside those of flexmb itself."""

from .buckling import Buckling as Buckling
from .compliance import directional_compliance as directional_compliance
from .linearize import Linearization as Linearization
from .measures import follow_modes as follow_modes
from .measures import frequency_like as frequency_like
from .measures import mode_assurance as mode_assurance
from .measures import smooth_maximum as smooth_maximum
from .measures import smooth_minimum as smooth_minimum
from .modes import Modes as Modes
from .second_order_transfer import second_transfer as second_transfer
from .state_series import Series as Series
from .stress import Location as Location
from .stress import SectionResultants as SectionResultants
from .stress import Stress as Stress
from .stress import section_resultants as section_resultants
