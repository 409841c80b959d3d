"""Names that this room offers beside those of flexmb itself."""

from .inverse import Nominal as Nominal
from .inverse import inverse_dynamics as inverse_dynamics
from .laws import Law as Law
from .laws import quintic as quintic
from .laws import rates as rates
from .laws import sampled as sampled
from .laws import scurve as scurve
from .laws import septic as septic
from .laws import spline as spline
from .laws import stretched as stretched
from .laws import zv as zv
from .laws import zvd as zvd
from .linear_along import TimeVarying as TimeVarying
from .linear_along import time_varying as time_varying
from .vibrations import Perturbation as Perturbation
from .vibrations import perturbation as perturbation
