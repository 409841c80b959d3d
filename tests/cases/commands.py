"""The command line in the process of the tests."""

import contextlib
from unittest import mock

from typer.testing import CliRunner, Result

from flexmb.cli import app


def keeping() -> contextlib.AbstractContextManager:
    """In it a command compiles as the tests do, quickly and kept beside theirs.

    By itself it would compile code for many runs, in twice the time, and switch to the user's folder.
    """
    return mock.patch("flexmb.enable_cache")


def command(*arguments, **options) -> Result:
    """Call the program with words, numbers or paths; ``options`` are those of typer's runner."""
    with keeping():
        return CliRunner().invoke(app, [str(argument) for argument in arguments], **options)
