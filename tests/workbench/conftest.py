"""The workbench in a browser: a server and a page, one each for the tests of a file."""

import pytest
from cases.drawing import blank
from cases.workbench import browsing, faults, opened, served


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with browsing(tmp_path_factory.mktemp("browser")) as driver:
        yield driver


@pytest.fixture(scope="module")
def workbench(tmp_path_factory):
    with served(folder=tmp_path_factory.mktemp("work")) as own:
        yield own


@pytest.fixture
def page(browser, workbench):
    """An empty page in the plane."""
    opened(browser, workbench.address)
    yield blank(browser, 2)
    assert not faults(browser)
