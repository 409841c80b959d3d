"""Names that this room offers beside those of flexmb itself."""

from .mobility import Mobility as Mobility
