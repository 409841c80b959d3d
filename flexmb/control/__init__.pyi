"""Names that this room offers beside those of flexmb itself."""

from .frequency_response import FrequencyResponse as FrequencyResponse
from .noise import NoiseBudget as NoiseBudget
from .noise import noise_budget as noise_budget
from .nonlinear_system import to_nonlinear_system as to_nonlinear_system
from .second_order_form import SecondOrder as SecondOrder
from .second_order_form import second_order as second_order
from .state_space import state_matrices as state_matrices
