"""Names that this room offers beside those of flexmb itself."""

from .document import Document as Document
from .edit import Workbench as Workbench
