"""Lines of code are those without comments, blank lines and bare strings."""

from count_lines import ROOT, counts, table

MODULE = '''"""Docstring
of two lines."""

import os  # a comment behind code

# a comment
LIMIT = 3
"""A bare string, no docstring."""
TEXT = """a value

of three lines"""


def named(
    place,
):
    "Docstring."
    return f"{place}"
'''


def test_a_tiny_tree(tmp_path):
    (tmp_path / "room").mkdir()
    (tmp_path / "room/module.py").write_text(MODULE)
    (tmp_path / "room/stub.pyi").write_text("a: int\n")
    (tmp_path / "top.py").write_text("a = 1\n\nb = 2")
    (tmp_path / "__init__.py").write_text("")
    rooms = counts([tmp_path])
    # import, LIMIT, TEXT (three), def (three), return.
    assert dict(rooms["room"]) == {"files": 1, "code": 9, "lines": 18}
    assert dict(rooms["root"]) == {"files": 2, "code": 2, "lines": 3}
    assert table(rooms).splitlines()[-1].split() == ["total", "3", "11", "21"]


def test_a_room_of_the_package():
    (count,) = counts([ROOT / "flexmb/checks"]).values()
    assert count["files"] == len(list((ROOT / "flexmb/checks").glob("*.py")))
    assert 0 < count["code"] < count["lines"]
