"""Names that this room offers beside those of flexmb itself."""

from .view import View as View
