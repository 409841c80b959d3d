"""Names that this room offers beside those of flexmb itself."""

from .linear_along import TimeVarying as TimeVarying
from .linear_along import time_varying as time_varying
from .vibrations import Perturbation as Perturbation
from .vibrations import perturbation as perturbation
