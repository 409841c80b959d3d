"""Mode 3: inverse dynamics along a trajectory, with the linearised equations along it."""

import functools

from .mode import Mode
from .mode_2_inverse import run, table

MODE = Mode(functools.partial(run, matrices=True), table, needs=("trajectory", "times"))
