"""Names that this room offers beside those of flexmb itself."""

from .frequency_response import FrequencyResponse as FrequencyResponse
from .loops import delayed as delayed
from .loops import fed_forward as fed_forward
from .loops import saturated as saturated
from .loops import scheduled as scheduled
from .noise import NoiseBudget as NoiseBudget
from .noise import noise_budget as noise_budget
from .nonlinear_system import to_nonlinear_system as to_nonlinear_system
from .pole_placement import notch as notch
from .pole_placement import pid as pid
from .second_order_form import SecondOrder as SecondOrder
from .second_order_form import second_order as second_order
from .stability import ClosedLoop as ClosedLoop
from .stability import Margins as Margins
from .stability import closed_loop as closed_loop
from .state_space import StateMatrices as StateMatrices
from .state_space import state_matrices as state_matrices
