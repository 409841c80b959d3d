"""``flexmb edit`` and ``fm.edit``: how they begin, what they refuse, how they end."""

import os
import re
import signal
import socket
import subprocess
import sys

import pytest
from cases.tolerances import approx
from cases.workbench import Client, Process, cantilever, served

import flexmb as fm
from flexmb import planar
from flexmb.workbench import edit

pytestmark = pytest.mark.timeout(180)
NODE = {"op": "add", "thing": {"call": "node", "name": "A", "args": {"position": ["0", "0"]}}}


@pytest.fixture(autouse=True)
def _state(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXMB_STATE", str(tmp_path / "state"))
    for name in edit.REMOTE:
        monkeypatch.delenv(name, raising=False)


def called(*arguments, code=2, **options):
    """What a call that ends by itself writes on standard error."""
    run = subprocess.run(
        [sys.executable, "-m", "flexmb", "edit", *map(str, arguments)], capture_output=True, text=True, **options
    )
    assert run.returncode == code, run
    assert run.stdout == ""
    return run.stderr


@pytest.mark.slow
def test_the_first_line_is_the_address(tmp_path):
    with served(state=tmp_path) as own:
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", own.address)
        assert own.end() == (0, "", "")


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_cleanly_while_something_is_computed(how, tmp_path):
    own = Process(state=tmp_path)
    client = Client(own.address)
    client.ask("edit", ops=cantilever())
    for k in range(5):
        client.send("edit", ops=[{"op": "name", "name": "t", "to": {"value": f"{k + 1}e-4"}}])
    assert own.end(how) == (0, "", "")
    # The port is free at once.
    port = int(own.address.split(":")[2].split("/")[0])
    with socket.create_server(("127.0.0.1", port)):
        pass


@pytest.mark.slow
def test_a_port_that_is_taken_is_said_so(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        told = called("--no-browser", "--port", port)
    assert re.fullmatch(rf"flexmb edit: port {port} is taken: .*. --port 0 takes any free port.\n", told)


@pytest.mark.slow
def test_a_file_that_is_open_is_said_to_be(tmp_path):
    path = tmp_path / "guide.json"
    path.write_text('{"format": "flexmb workbench 1", "dimension": 2}')
    with served(path, state=tmp_path / "state") as own:
        port = own.address.split(":")[2].split("/")[0]
        for more in ([], ["--port", port]):
            told = called(path, "--no-browser", *more)
            assert told == f"flexmb edit: 'guide.json' is already open in another workbench: {own.address}\n"


@pytest.mark.slow
def test_wrong_files_are_refused(tmp_path):
    wrong = tmp_path / "wrong.dat"
    wrong.write_text("PLBEAN 1 1 2 3 4\n")
    told = called(wrong, "--no-browser")
    assert "wrong.dat" in told
    assert "PLBEAN" in told
    assert "cannot read" in called(tmp_path / "none.dat", "--no-browser")
    script = tmp_path / "run.py"
    script.write_text("raise SystemExit(3)")
    assert "opens .dat and .json" in called(script, "--no-browser")
    assert "Traceback" not in told


def test_without_websockets_the_extra_is_named(tmp_path):
    (tmp_path / "websockets.py").write_text(
        "raise ModuleNotFoundError(\"No module named 'websockets'\", name='websockets')"
    )
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    told = called("--no-browser", env={**os.environ, "PYTHONPATH": path})
    assert told == "flexmb edit: the workbench needs the package websockets: pip install 'flexmb[workbench]'.\n"


@pytest.mark.slow
def test_another_start_after_a_clean_end_has_the_same_address(tmp_path):
    path = tmp_path / "guide.json"
    path.write_text('{"format": "flexmb workbench 1", "dimension": 2}')
    addresses = []
    for _ in range(2):
        with served(path, state=tmp_path / "state") as own:
            addresses.append(own.address)
    assert addresses[0] == addresses[1]


@pytest.mark.slow
def test_journals_are_for_their_user_alone(tmp_path):
    with served(state=tmp_path / "state") as own:
        client = Client(own.address)
        client.ask("edit", ops=[NODE])
        files = sorted((tmp_path / "state").iterdir())
        assert [file.suffix for file in files] == [".json", ".jsonl"]
        assert [(file.stat().st_mode & 0o077) for file in (tmp_path / "state", *files)] == [0, 0, 0]


# In Python.


def guide():
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.1, 0))
    b.add(planar.beam, "A", "B", name="spring", section=fm.Rigidity(EA=2.1e6, EIy=0.04))
    b.fix("A")
    b.mass("B", 0.1)
    return b


@pytest.mark.slow
def test_a_builder_is_opened_and_taken_back():
    b = guide()
    with fm.edit(b, browser=False) as own:
        client = Client(own.address)
        document = client.until(lambda: client.told.get("document"))["document"]
        assert [one.get("name", one["call"]) for one in document["things"]][:2] == ["A", "B"]
        before = float(fm.frequencies(b.build())[0])
        assert float(fm.frequencies(own.model())[0]) == approx(before, rel=1e-12)
        mass = next(one["id"] for one in document["things"] if one["call"] == "mass")
        client.ask("edit", ops=[{"op": "set", "address": f"{mass}/mass", "to": "0.4"}])
        assert float(fm.frequencies(own.model())[0]) == approx(before / 2, rel=1e-9)
        # A builder of one's own, to go on with.
        taken = own.builder()
        taken.node("C", (0, 1))
        assert "C" not in own.builder().nodes
        assert "fm.Builder()" in own.python()
    # After its end what was made is still there.
    assert own.document.data["things"]
    with pytest.raises(OSError, match="refused"):
        Client(own.address)


def test_a_document_that_cannot_be_built_says_why():
    with fm.edit(browser=False) as own:
        client = Client(own.address)
        client.ask("edit", ops=[NODE, {"op": "set", "address": "1/position/0", "to": "2*q"}])
        with pytest.raises(fm.ModelError, match="q"):
            own.builder()


@pytest.mark.slow
def test_it_is_saved_from_python(tmp_path):
    with fm.edit(guide(), browser=False) as own:
        own.save(tmp_path / "guide.json")
        own.save(tmp_path / "guide.py")
        before = own.document.data
    with fm.edit(tmp_path / "guide.json", browser=False) as again:
        assert again.document.data == before


def test_what_is_none_of_these_is_refused():
    with pytest.raises(TypeError):
        fm.edit(5, browser=False)
    with pytest.raises(ValueError, match="opens"):
        fm.edit(__file__, browser=False)


def test_a_notebook_shows_the_page_in_a_frame(monkeypatch):
    with fm.edit(browser=False) as own:
        text = own._repr_html_()
        assert re.findall(r'<iframe src="([^"]*)"', text) == [own.address]
        assert "ssh -L" in text
        # Other pages may hold it in a frame there, and nowhere else.
        import http.client

        connection = http.client.HTTPConnection("127.0.0.1", int(own.address.split(":")[2].split("/")[0]))
        connection.request("GET", "/" + own.address.split("/", 3)[3])
        assert "frame-ancestors" not in connection.getresponse().headers["Content-Security-Policy"]
        connection.close()
        # Where the kernel is likely elsewhere, that comes first, by name.
        monkeypatch.setenv("JUPYTERHUB_USER", "me")
        assert own._repr_html_().startswith("<p")
        assert "JupyterHub" in own._repr_html_()


@pytest.mark.slow
def test_two_at_once():
    with fm.edit(guide(), browser=False) as one, fm.edit(browser=False) as other:
        assert one.address != other.address
        assert len(one.document.data["things"]) > 3
        assert other.document.data["things"] == []
