"""Names that this room offers beside those of flexmb itself."""

from .nonlinear_system import to_nonlinear_system as to_nonlinear_system
from .second_order_form import SecondOrder as SecondOrder
from .second_order_form import second_order as second_order
from .state_space import state_matrices as state_matrices
