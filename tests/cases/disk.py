"""A disk that is full, and files that never end or never begin."""

import contextlib
import os
import resource


@contextlib.contextmanager
def full(most=1000):
    """Within, no file of this process grows beyond so many bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def not_regular(folder, ending):
    """A pipe that nobody writes to, and a link to a device without an end."""
    pipe, endless = folder / f"pipe{ending}", folder / f"endless{ending}"
    os.mkfifo(pipe)
    endless.symlink_to("/dev/zero")
    return pipe, endless
