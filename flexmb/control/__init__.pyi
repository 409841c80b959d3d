"""Names that this room offers beside those of flexmb itself."""

from .loops import delayed as delayed
from .loops import fed_forward as fed_forward
from .loops import saturated as saturated
from .loops import scheduled as scheduled
from .nonlinear_system import to_nonlinear_system as to_nonlinear_system
from .pole_placement import notch as notch
from .pole_placement import pid as pid
from .stability import ClosedLoop as ClosedLoop
from .stability import Margins as Margins
from .stability import closed_loop as closed_loop
from .state_space import StateMatrices as StateMatrices
from .state_space import state_matrices as state_matrices
