"""Files that another program changes."""

import os
import time

import pytest

from flexmb.workbench import open_file as module
from flexmb.workbench.open_file import Watch

pytestmark = pytest.mark.timeout(30)


@pytest.fixture
def told():
    return []


@pytest.fixture
def watch(told):
    own = Watch(told.append)
    yield own
    own.close()


def until(there, seconds=5.0):
    end = time.monotonic() + seconds
    while not there() and time.monotonic() < end:
        time.sleep(0.02)
    return there()


@pytest.fixture
def looks(monkeypatch):
    """Time for some looks at all files, in a fifth of the time that users wait [s]."""
    monkeypatch.setattr(module, "PERIOD", module.PERIOD / 5)
    return 3 * module.PERIOD


def test_a_change_is_told_once_within_four_looks(looks, watch, told, tmp_path):
    path = tmp_path / "guide.dat"
    path.write_text("one")
    watch.know(path)
    time.sleep(looks)
    assert not told
    path.write_text("two")
    start = time.monotonic()
    assert until(lambda: told == [path])
    # A busy machine may hold up the thread.
    assert time.monotonic() - start < 4 * module.PERIOD + 0.2
    assert watch.differs() == [path]
    time.sleep(looks)
    assert told == [path]
    # Another change of the same file, of the same length, as an editor writes it: a new file in its place.
    (tmp_path / "other").write_text("six")
    os.replace(tmp_path / "other", path)
    assert until(lambda: told == [path, path])
    # Back to what was read here: nothing is left to be told.
    path.write_text("one")
    time.sleep(looks)
    assert told == [path, path]
    assert watch.differs() == []


def test_what_is_written_here_is_known(looks, watch, told, tmp_path):
    path = tmp_path / "guide.dat"
    path.write_text("one")
    watch.know(path)
    path.write_text("two")
    watch.know(path)
    time.sleep(looks)
    assert not told
    # As is a touch, which changes nothing.
    path.touch()
    time.sleep(looks)
    assert not told


def test_a_file_that_is_being_written_is_waited_for(monkeypatch, watch, told, tmp_path):
    monkeypatch.setattr(module, "PERIOD", module.PERIOD / 2)
    path = tmp_path / "guide.dat"
    path.write_text("")
    watch.know(path)
    with path.open("w") as file:
        for _ in range(12):
            file.write("part")
            file.flush()
            time.sleep(0.1)
        assert not told
    assert until(lambda: told == [path])


@pytest.mark.slow
def test_a_file_that_goes_or_comes_is_told(looks, watch, told, tmp_path):
    here, there = tmp_path / "guide.dat", tmp_path / "guide.toml"
    here.write_text("one")
    watch.know(here, there)
    here.unlink()
    assert until(lambda: told == [here])
    there.write_text("new")
    assert until(lambda: told == [here, there])
