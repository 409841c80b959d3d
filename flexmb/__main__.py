"""``python -m flexmb`` is the command line."""

from .cli import main

main()
