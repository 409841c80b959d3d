"""Pictures to turn and to play: a page that opens in any browser without a network, and tables in notebooks.

What the page does is JavaScript, in the folder ``src``; ``viewer.js`` here is built from it.
"""

from ..lazy import names

__getattr__, __dir__ = names(__name__)
