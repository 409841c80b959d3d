"""Names that this room offers beside those of flexmb itself."""

from .critical import CriticalPoint as CriticalPoint
from .path import Path as Path
