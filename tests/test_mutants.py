"""Random changes: one at a time, the same for a seed, seen by a test that asks for it."""

import ast

import mutants

MODULE = '''"""Docstring with 1 number."""


def area(width: "int | 2", height, places=(0, 1)):
    """Two sides: 2."""
    if width < 0 or height < 0:
        raise ValueError("at least " + str(0))
    whole = max(width, height, key=abs)
    return width * height if whole else -places[0]
'''
TEST = """from flexmb.shapes.area import area


def test_area():
    assert area(3, 4) == 12
"""


# Where the tiny package lies.
PACKAGE, TESTS = "flexmb", "tests"


def tree(folder):
    """A package of one module, with its test."""
    files = {f"{PACKAGE}/shapes/area.py": MODULE, f"{TESTS}/shapes/test_area.py": TEST}
    files |= {f"{PACKAGE}/__init__.py": "", f"{PACKAGE}/shapes/__init__.py": "", f"{TESTS}/conftest.py": ""}
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def test_changes_of_a_tiny_function(tmp_path):
    found = mutants.drawn(tree(tmp_path) / "flexmb", 1000, seed=3)
    assert {one.kind for one in found} == {"operator", "constant", "sign", "index", "condition", "argument"}
    for one in found:
        rows = [line for line in one.diff(MODULE).splitlines()[2:] if line[0] in "+-"]
        assert [line[0] for line in rows] == ["-", "+"], one
        ast.parse(one.text)
        # Texts, annotations and errors stay.
        assert not any(word in rows[0] for word in ("Docstring", "Two sides", "raise")), rows
        assert '"int | 2"' in one.text
    assert mutants.drawn(tmp_path / "flexmb", 5, seed=3) == found[:5] != mutants.drawn(tmp_path / "flexmb", 5, seed=4)
    assert mutants.drawn(tmp_path / "flexmb", 5, seed=3, room="root") == []


def test_a_change_that_a_test_sees_is_killed(tmp_path):
    found = mutants.drawn(tree(tmp_path) / "flexmb", 1000, seed=0)
    killed = next(one for one in found if "(width / height)" in one.text)
    left = next(one for one in found if "places[0 + 1]" in one.text)
    assert mutants.outcome(tmp_path, killed, 100.0, []) == mutants.KILLED
    assert mutants.outcome(tmp_path, left, 100.0, []) == mutants.SURVIVED
    assert mutants.outcome(tmp_path, killed, 0.01, []) == mutants.TIMEOUT
    assert (tmp_path / PACKAGE / "shapes" / "area.py").read_text() == MODULE
