"""Public names, as type checkers and editors see them; ``__init__.py`` loads each on first use."""

from .analysis.buckling import Buckling as Buckling
from .analysis.buckling import buckling as buckling
from .analysis.buckling import buckling_loads as buckling_loads
from .analysis.compliance import compliance as compliance
from .analysis.compliance import directional_compliance as directional_compliance
from .analysis.critical import CriticalPoint as CriticalPoint
from .analysis.critical import limit_load as limit_load
from .analysis.equilibrium import Equilibrium as Equilibrium
from .analysis.equilibrium import equilibrium as equilibrium
from .analysis.linearize import Linearization as Linearization
from .analysis.linearize import linearize as linearize
from .analysis.linearize import second_transfer as second_transfer
from .analysis.mobility import Mobility as Mobility
from .analysis.mobility import mobility as mobility
from .analysis.modal import Modes as Modes
from .analysis.modal import frequencies as frequencies
from .analysis.modal import modes as modes
from .analysis.modal import poles as poles
from .analysis.path import Path as Path
from .analysis.path import path as path
from .build.builder import Builder as Builder
from .elements import planar as planar
from .elements import sections as sections
from .elements import spatial as spatial
from .elements.element import Element as Element
from .elements.nodes import Angle as Angle
from .elements.nodes import Point2 as Point2
from .elements.nodes import Point3 as Point3
from .elements.nodes import Rotation3 as Rotation3
from .elements.sections import Circle as Circle
from .elements.sections import Damping as Damping
from .elements.sections import HollowRectangle as HollowRectangle
from .elements.sections import Material as Material
from .elements.sections import Rectangle as Rectangle
from .elements.sections import Rigidity as Rigidity
from .elements.sections import Tube as Tube
from .elements.sections import damping_from_ratio as damping_from_ratio
from .elements.sections import torsion_approximate as torsion_approximate
from .elements.sections import torsion_series as torsion_series
from .elements.sections import warping_factor as warping_factor
from .errors import AnalysisError as AnalysisError
from .errors import MechanismError as MechanismError
from .errors import ModelError as ModelError
from .errors import SpacarError as SpacarError
from .io.spacar import read_spacar as read_spacar
from .io.spacar import write_spacar as write_spacar
from .math.compile import jit as jit
from .model.model import Model as Model
from .results import RESULTS as RESULTS
from .setup import enable_cache as enable_cache
from .setup import enable_x64 as enable_x64
from .statespace import state_matrices as state_matrices
from .statespace import to_statespace as to_statespace

__version__: str
_WHERE: dict[str, str]
