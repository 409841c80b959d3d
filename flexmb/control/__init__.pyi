"""Names that this room offers beside those of flexmb itself."""

from .nonlinear_system import to_nonlinear_system as to_nonlinear_system
from .state_space import state_matrices as state_matrices
