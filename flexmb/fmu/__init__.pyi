"""Names that this room offers beside those of flexmb itself."""
