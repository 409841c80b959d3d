"""SPACAR input files opened and saved: the same model, names in braces, values and bounds in the study beside."""

import re
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.design.study_file import read_study
from flexmb.errors import ModelError
from flexmb.mechanisms import mechanism_path
from flexmb.workbench.building import build
from flexmb.workbench.dat_file import NoValueError, cannot_hold, open_dat, save_dat
from flexmb.workbench.document import Document, apply
from flexmb.workbench.from_builder import document_of

from ..cases import documents, mechanisms
from ..cases.commands import command
from .test_from_builder import SHIPPED, check_same, check_same_contents, rebuilt

MANUAL = (Path(fm.__file__).parent / "spacar/README.md").read_text()
GUIDE = re.search(r"```text guide.dat\n(.*?)```", MANUAL, re.DOTALL).group(1)
STUDY = re.search(r"```toml study.toml\n(.*?)```", MANUAL, re.DOTALL).group(1)


@pytest.fixture
def guide(tmp_path) -> Path:
    """The guide of the manual, with its names, and its study."""
    (tmp_path / "guide.dat").write_text(GUIDE)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "guide.dat"


def edited(document: Document, **names: str) -> Document:
    return apply(document, [{"op": "set", "address": f"names/{n}/value", "to": v} for n, v in names.items()])[0]


@pytest.mark.slow
def test_names_and_arithmetic_of_a_file_become_names_and_fields(guide):
    document, notes = open_dat(guide)
    assert cannot_hold(document) == []
    assert document.names["t"] == {"value": "0.0005", "low": "0.0001", "high": "0.002"}
    assert document.names["w"] == {"value": "0.018"}
    section = next(thing["args"] for thing in document.things if thing["call"] == "Rigidity")
    assert (section["EA"], section["EIy"], section["mass"]) == ("210e9*w*t", "210e9*w*t**3/12", "7850*w*t")
    # The study names a function beside it, which is neither there nor looked for.
    assert notes == ["study.toml names Python functions, which the workbench never runs: own:twice"]
    numbers = {"t": 0.7e-3, "w": 0.02}
    expected = fm.frequencies(fm.read_spacar(guide, numbers=numbers).builder.build())
    other = edited(document, **{name: repr(value) for name, value in numbers.items()})
    np.testing.assert_allclose(fm.frequencies(rebuilt(other).build()), expected, rtol=1e-12)


def test_names_without_a_value_are_asked_for(guide):
    (guide.parent / "study.toml").unlink()
    with pytest.raises(NoValueError, match=r"guide.dat has \{w, t\}, but no study") as fault:
        open_dat(guide)
    assert fault.value.names == ["w", "t"]
    document, _ = open_dat(guide, {"t": (0.5e-3, 0.1e-3, 1e-3), "w": 0.018})
    assert document.names["t"]["high"] == "0.001"


def test_what_was_saved_is_opened_and_run_as_it_was(guide, tmp_path):
    document, _ = open_dat(guide)
    saved = tmp_path / "again" / "guide.dat"
    saved.parent.mkdir()
    assert save_dat(document, saved) == []
    assert "ESTIFF 1 {210e9*w*t} {210e9*w*t**3/12}" in saved.read_text()
    # Rotations have their numbers again.
    assert saved.read_text().startswith("PLBEAM 1 1 2 3 4\nPLBEAM 2 3 4 5 6\nPLBEAM 3 5 6 7 8\n")
    numbers = {"t": 0.7e-3, "w": 0.02}
    both = [fm.read_spacar(one, numbers=numbers).builder.build() for one in (guide, saved)]
    np.testing.assert_allclose(*map(fm.frequencies, both[::-1]), rtol=1e-12)
    again, notes = open_dat(saved)
    assert notes == []
    assert again.names == document.names
    check_same_contents(rebuilt(again), rebuilt(document))
    study = read_study(saved.with_suffix(".toml"))
    assert study.values == {"t": 0.5e-3}


@pytest.mark.slow
@pytest.mark.parametrize("drawn", [documents.planar_guide, documents.spatial_guide])
def test_drawings_keep_their_frequencies_and_names(drawn, tmp_path):
    document = drawn()
    path = tmp_path / "drawn.dat"
    save_dat(document, path)
    model = rebuilt(document).build(release="auto")
    parameters = tomllib.loads(path.with_suffix(".toml").read_text())["parameters"]
    values = {n: v["value"] if isinstance(v, dict) else v for n, v in parameters.items()}
    read = fm.read_spacar(path, numbers=values)
    np.testing.assert_allclose(fm.frequencies(read.builder.build(release="auto")), fm.frequencies(model), rtol=1e-12)
    again, _ = open_dat(path)
    assert {t["name"] for t in again.things if t["call"] == "node"} == {
        t["name"] for t in document.things if t["call"] == "node"
    }
    check_same(rebuilt(document), rebuilt(again), release="auto")
    # Another thickness is that of the drawing, since the file has the arithmetic.
    if drawn is documents.planar_guide:
        thicker = {**values, "t": 2 * values["t"]}
        found = fm.frequencies(fm.read_spacar(path, numbers=thicker).builder.build())
        expected = fm.frequencies(rebuilt(edited(document, t=repr(thicker["t"]))).build())
        np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_mechanism(name, tmp_path):
    shutil.copy(mechanism_path(name), tmp_path)
    path = tmp_path / f"{name}.dat"
    before = fm.read_spacar(path)
    document, _ = open_dat(path)
    save_dat(document, path)
    after = fm.read_spacar(path)
    check_same(before.builder, after.builder, release="auto")
    for keyword in ("TIMESTEP", "ERROR"):
        assert after.settings.get(keyword) == before.settings.get(keyword)
    check_same(before.builder, rebuilt(open_dat(path)[0]), release="auto")


@pytest.mark.slow
@pytest.mark.parametrize("built", ["planar_guide", "spatial_guide", "truss_guide"])
def test_tutorial_systems(built, tmp_path):
    builder = getattr(mechanisms, built)()
    document, _ = document_of(builder)
    save_dat(document, tmp_path / "one.dat")
    again, _ = open_dat(tmp_path / "one.dat")
    check_same(builder, rebuilt(again), release="auto")
    assert set(rebuilt(again).nodes) == set(builder.nodes)
    signals = [s.name for s in builder.signals["input"] + builder.signals["output"]]
    own = rebuilt(again).signals
    assert [s.name for s in own["input"] + own["output"]] == signals


@pytest.mark.slow
def test_what_a_file_cannot_hold_is_listed_all_at_once(tmp_path):
    document, _ = document_of(mechanisms.planar_guide())
    a, b, *_ = [thing["name"] for thing in document.things if thing["call"] == "node"]
    add = [
        ("planar.rigid_body", "body 1", {"nodes": [a, b]}),
        ("body", None, {"node": b, "mass": "1"}),
        ("sensor", "both", {"weights": [[f"{a}.x", "1"], [f"{b}.x", "1"]]}),
        ("gravity", None, {"acceleration": ["0", "-9.81"], "increment": "true"}),
        ("mass", None, {"node": b, "mass": "no"}),
    ]
    ops = [{"op": "add", "thing": {"call": c, "name": n, "args": args}} for c, n, args in add]
    document = apply(document, ops)[0]
    told = "\n".join(cannot_hold(document))
    for wanted in ("rigid_body", "The body on node", "'both'", "Gravity as an increment", "no such name"):
        assert wanted in told
    with pytest.raises(ModelError, match="Save Python or the document instead"):
        save_dat(document, tmp_path / "no.dat")
    assert list(tmp_path.iterdir()) == []
    # What is not complete is in no answer, and in no file.
    half = apply(documents.planar_guide(), [ops[-1]])[0]
    assert "no such name" in cannot_hold(half)[0]
    save_dat(half, tmp_path / "half.dat")
    read = fm.read_spacar(tmp_path / "half.dat", numbers={"t": 0.5e-3, "L": 0.1, "d": 0.1})
    np.testing.assert_allclose(
        fm.frequencies(read.builder.build()), fm.frequencies(build(half).builder.build()), rtol=1e-12
    )


@pytest.mark.slow
def test_numbers_that_are_no_arithmetic_are_told(tmp_path):
    names = {"t": "1e-3", "twice": "2*t"}
    things = [
        ("Material", "steel", {"E": "210e9", "G": "80e9", "rho": "7850"}),
        ("Rectangle", "leaf", {"width": "0.01", "thickness": "twice", "material": "steel"}),
        ("node", "A", {"position": ["0", "0", "0"]}),
        ("node", "B", {"position": ["0.1", "0", "0"]}),
        ("spatial.beam", "beam", {"nodes": ["A", "B"], "section": "leaf"}),
        ("fix", None, {"node": "A"}),
    ]
    document = documents.drawn(3, names, things)
    told = cannot_hold(document)
    assert told[1] == "section leaf: as rigidities (ESTIFF, EM) and sizes (CROSSDIM), of leaf springs as SECTION"
    assert told[0] == "names that follow from others, twice: their arithmetic is written where they are used"
    assert told[-1] == "number 2 of ESTIFF 1 follows from names by more than + - * / ** and stays unchanged"
    path = tmp_path / "beam.dat"
    save_dat(document, path)
    read = fm.read_spacar(path, numbers={"t": 1e-3})
    np.testing.assert_allclose(
        fm.frequencies(read.builder.build()), fm.frequencies(rebuilt(document).build()), rtol=1e-12
    )


@pytest.mark.slow
def test_a_study_that_is_there_keeps_what_is_not_about_names(guide):
    document, _ = open_dat(guide)
    (guide.parent / "study.toml").rename(guide.with_suffix(".toml"))
    save_dat(edited(document, t="0.6e-3"), guide)
    data = tomllib.loads(guide.with_suffix(".toml").read_text())
    before = tomllib.loads(STUDY)
    assert data.pop("parameters") == {"t": {"value": 0.6e-3, "lower": 0.1e-3, "upper": 2e-3}, "w": 0.018}
    before.pop("parameters")
    assert data == before
    assert "# also [equal]" in guide.with_suffix(".toml").read_text()
    # That of another model is left alone.
    guide.with_suffix(".toml").write_text('model = "other.dat"\n[answers]\nf = { frequency = 1 }\n')
    with pytest.raises(ModelError, match=r"study of another model, 'other.dat'"):
        save_dat(document, guide)


@pytest.mark.slow
def test_leaf_springs_keep_their_sizes_as_names(tmp_path):
    names = {"t": "0.5e-3"}
    things = [
        ("Material", "steel", {"E": "210e9", "G": "80e9", "rho": "7850"}),
        ("Rectangle", "leaf", {"width": "40*t", "thickness": "t", "material": "steel"}),
        ("node", "A", {"position": ["0", "0", "0"]}),
        ("node", "B", {"position": ["0.1", "0", "0"]}),
        ("spatial.leaf_spring", "spring", {"nodes": ["A", "B"], "section": "leaf", "y": ["0", "0", "1"]}),
        ("fix", None, {"node": "A"}),
        ("mass", None, {"node": "B", "mass": "0.1"}),
    ]
    document = documents.drawn(3, names, things)
    path = tmp_path / "leaf.dat"
    save_dat(document, path)
    assert "SECTION 1 {40*t} {t} 210000000000.0 80000000000.0 7850.0" in path.read_text()
    again, _ = open_dat(path)
    section = next(thing["args"] for thing in again.things if thing["call"] == "Rectangle")
    assert (section["width"], section["thickness"]) == ("40*t", "t")
    check_same(rebuilt(document), rebuilt(again))


@pytest.mark.slow
def test_a_wrong_file_is_told_by_line(tmp_path):
    (tmp_path / "wrong.dat").write_text("PLBEAM 1 1 2 3\nEND\nHALT\nEND\nEND\n")
    with pytest.raises(fm.SpacarError, match=r"wrong.dat:1: PLBEAM"):
        open_dat(tmp_path / "wrong.dat")
    with pytest.raises(FileNotFoundError):
        open_dat(tmp_path / "nowhere.dat")


@pytest.mark.slow
def test_commands_take_what_was_saved(guide):
    document, _ = open_dat(guide)
    save_dat(document, guide)
    numbers = ["--set", "t=0.5e-3", "--set", "w=0.018"]
    assert "10.79932" in command("run", guide, "--mode", "7", *numbers).output
    study = guide.with_suffix(".toml")
    assert "successful" in command("sweep", study).output


def test_what_is_refused_leaves_no_node_to_be_refused_after_it(tmp_path):
    b = mechanisms.planar_guide()
    b.node("tip", (0.2, 0.3))
    b.add(fm.planar.spectral_beam, "right1", "tip", name="curved", section=fm.Rigidity(EA=1e5, EIy=1.0), curvature=0.5)
    b.body("tip", 0.1)
    document, _ = document_of(b)
    with pytest.raises(ModelError) as fault:
        save_dat(document, tmp_path / "guide.dat")
    assert "'curved'" in str(fault.value)
    assert "in no element" not in str(fault.value)
