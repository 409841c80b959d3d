"""Names that this room offers beside those of flexmb itself."""

from .configuration import Configuration as Configuration
from .equilibrium import Equilibrium as Equilibrium
from .stroke import Equilibria as Equilibria
