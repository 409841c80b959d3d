"""The faults of `faults.py` are those of the code as it stands: each finds its place, in every room."""

import pytest
from faults import ENOUGH, FAULTS, ROOT, split, stale


def test_every_fault_finds_its_place():
    assert stale(FAULTS) == []
    assert len(FAULTS) == len({(fault.file, fault.old) for fault in FAULTS}) >= 100


def test_every_fault_changes_something_and_has_tests():
    for fault in FAULTS:
        assert fault.old != fault.new
        files = [word.partition("::")[0] for word in split(fault.tests) if ".py" in word]
        assert files, fault
        assert all((ROOT / "tests" / name).is_file() for name in files), fault


def test_the_suite_sees_all_but_a_few():
    assert sum(fault.slow for fault in FAULTS) <= (1 - ENOUGH) * len(FAULTS)


def test_every_room_has_faults():
    rooms = {path.parent.name for path in (ROOT / "flexmb").glob("*/*.py") if path.name != "__init__.py"}
    assert rooms <= {fault.room for fault in FAULTS}


@pytest.mark.slow
def test_a_text_that_is_gone_or_stands_twice_is_stale(tmp_path):
    fault = FAULTS[0]
    path = tmp_path / fault.file
    path.parent.mkdir(exist_ok=True)
    assert stale([fault], tmp_path)[0].startswith("there is no such file: ")
    for count, wrong in ((0, True), (1, False), (2, True)):
        path.write_text(count * f"{fault.old}\n")
        assert bool(stale([fault], tmp_path)) is wrong
