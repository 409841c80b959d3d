"""The workbench: a mechanism that is drawn and changed in a browser, with its answers beside it all the time.

The document here is the truth; pages send edits and are told what follows. What a page does is JavaScript, in
``viewer/src/workbench``; ``workbench.js`` here is built from it.
"""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
