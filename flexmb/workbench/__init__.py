"""The workbench: a mechanism that you draw and change in a browser, with its answers beside it.

The document is in Python. Pages send edits and receive what follows from them. The JavaScript of a page is in
``viewer/src/workbench``; ``workbench.js`` here is built from it.
"""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
