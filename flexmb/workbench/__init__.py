"""The workbench: the server behind the page on which one draws, edits and studies a mechanism."""
