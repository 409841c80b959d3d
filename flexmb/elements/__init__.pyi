"""Names that this room offers beside those of flexmb itself."""

from . import materials as materials
from . import planar as planar
from . import sections as sections
from . import spatial as spatial
from .sections import damping_from_ratio as damping_from_ratio
from .sections import torsion_approximate as torsion_approximate
from .sections import torsion_series as torsion_series
from .sections import warping_factor as warping_factor
