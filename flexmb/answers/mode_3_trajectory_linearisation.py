"""Mode 3: what drives a mechanism along a trajectory, and its linearised equations there."""

import functools

from .mode import Mode
from .mode_2_inverse import run, table

MODE = Mode(functools.partial(run, matrices=True), table, needs=("trajectory", "times"))
