"""Names that this room offers beside those of flexmb itself."""

from .server import Server as Server
from .session import Session as Session
