"""Mode 4: motion in time, and the linearised equations along it."""

import functools

from .mode import Mode
from .mode_1_simulate import run, table

MODE = Mode(functools.partial(run, linearised=True), table, needs=("cause", "times"))
