"""Pictures by matplotlib: each function takes a result and returns Axes or a Figure. A plot is one file of this room.

matplotlib is loaded when the first picture is drawn.
"""

from ..lazy import only
from .bode import bode as bode
from .fit import fit as fit
from .frequencies import frequencies as frequencies
from .history import history as history
from .mechanism import mechanism as mechanism
from .modes import modes as modes
from .noise import noise as noise
from .path import path as path
from .prediction import prediction as prediction
from .profile import profile as profile
from .self_stress import self_stress as self_stress
from .sensitivities import sensitivities as sensitivities
from .stress import stress as stress
from .sweep import sweep as sweep
from .tuning import tuning as tuning
from .verdict import verdict as verdict

__all__, __dir__ = only(globals(), lambda value: callable(value) and value is not only)
