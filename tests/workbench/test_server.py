"""The server of the workbench: who is let in, what a message may be, several pages, and its end."""

import atexit
import hashlib
import http.client
import json
import re
import socket
import threading
import time
from pathlib import Path

import pytest
from cases.workbench import Client, served

import flexmb as fm
from flexmb.workbench.server import LONGEST_MESSAGE, Server
from flexmb.workbench.session import Session

PACKAGE = Path(fm.__file__).parent
pytestmark = pytest.mark.timeout(60)


def node(name):
    return {"op": "add", "thing": {"call": "node", "name": name, "args": {"position": ["0", "0"]}}}


NODE = node("A")


@pytest.fixture
def server():
    own = Server(Session())
    own.start()
    yield own
    own.close()


@pytest.fixture
def client(server):
    own = Client(server.address)
    yield own
    own.close()


def got(server, path, **headers):
    """Status, headers and text of a plain request."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    connection.putrequest("GET", path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    found = answer.status, answer.headers, answer.read().decode()
    connection.close()
    return found


def refused(server, **options):
    """Status with which the socket is refused."""
    from websockets.exceptions import InvalidStatus

    address = options.pop("address", server.address)
    with pytest.raises(InvalidStatus) as fault:
        Client(address, greet=False, **options)
    return fault.value.response.status_code


def test_its_end_is_left_to_the_process(monkeypatch):
    seen = []
    monkeypatch.setattr(atexit, "register", seen.append)
    own = Server(Session())
    own.start()
    seen[seen.index(own.close)]()
    with pytest.raises(ConnectionRefusedError):
        got(own, "/")


def test_bundle_is_built_from_the_source():
    text = (PACKAGE / "workbench" / "workbench.js").read_text()
    source = PACKAGE / "viewer" / "src"
    parts = [*sorted(source.glob("*.js")), *sorted((source / "workbench").glob("*.js"))]
    total = hashlib.sha256(b"".join(path.read_bytes() for path in parts)).hexdigest()
    assert text.startswith(f"/* source {total}\n"), "run npm ci && npm run build in flexmb/viewer/src"


def test_the_page_and_its_script_are_served_to_who_has_the_token(server):
    status, headers, text = got(server, f"/{server.token}/")
    assert status == 200
    assert text == (PACKAGE / "workbench" / "page.html").read_text()
    # What the page may do: its own script, its own server, nothing else; no frame of another's page holds it.
    policy = dict(part.strip().split(" ", 1) for part in headers["Content-Security-Policy"].split(";"))
    assert policy["default-src"] == "'none'"
    assert policy["script-src"] == policy["connect-src"] == "'self'"
    assert policy["frame-ancestors"] == "'none'"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert not re.findall(r"<script(?![^>]*\bsrc=)", text)
    assert not re.findall(r"(?:src|href)=\"(?:https?:)?//", text)
    assert got(server, f"/{server.token}/workbench.js")[2] == (PACKAGE / "workbench" / "workbench.js").read_text()
    assert got(server, f"/{server.token}/server.py")[0] == 404
    assert got(server, f"/{server.token}/../cli.py")[0] == 404


@pytest.mark.parametrize("path", ["/", "/workbench.js", "/socket", "/{almost}/", "//{token}/", "/?{token}"])
def test_nothing_is_served_without_the_token(server, path):
    text = path.format(token=server.token, almost=server.token[:-1])
    assert got(server, text)[0] == 403


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", "192.168.1.1", ""])
def test_a_foreign_name_of_this_machine_is_refused(server, host):
    # As after a name was made to point here, which any page can do with its own.
    assert got(server, f"/{server.token}/", Host=host)[0] == 403
    assert got(server, f"/{server.token}/", Host=f"localhost:{server.port}")[0] == 200


def test_a_socket_opens_for_the_own_page_alone(server):
    assert refused(server, origin="http://evil.example") == 403
    assert refused(server, origin=f"http://127.0.0.1:{server.port + 1}") == 403
    assert refused(server, origin="null") == 403
    assert refused(server, origin=None) == 403
    assert refused(server, address=server.address.replace(server.token, "x" * len(server.token))) == 403
    Client(server.address).close()


def test_it_listens_on_the_loopback_address_alone(server):
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", server.port), timeout=5)


MALFORMED = {
    "": "no JSON",
    "{": "no JSON",
    "[]": "object",
    '"x"': "object",
    "{}": "'id'",
    '{"id": 1.5, "do": "undo"}': "'id'",
    '{"id": true, "do": "undo"}': "'id'",
    '{"id": 7}': "'do'",
    '{"id": 7, "do": ["edit"]}': "'do'",
    '{"id": 7, "do": "no such"}': "no verb 'no such'",
    '{"id": 7, "do": "__init__"}': "no verb",
    '{"id": 7, "do": "edit"}': "ops",
    '{"id": 7, "do": "edit", "ops": [], "nonsense": 1}': "nonsense",
    '{"id": 7, "do": "edit", "ops": 5}': "",
    '{"id": 7, "do": "edit", "ops": [5]}': "",
    '{"id": 7, "do": "edit", "ops": [{"op": "nope"}]}': "",
    '{"id": 7, "do": "undo", "x": NaN}': "NaN",
    '{"id": 7, "do": "undo", "x": "\\ud800"}': "surrogates",
    '{"id": 7, "do": "undo", "x": ' + "[" * 100_000 + "]" * 100_000 + "}": "no JSON",
    '{"id": 7, "do": "undo", "x": ' + "9" * 5000 + "}": "no JSON",
}


@pytest.mark.parametrize("text", MALFORMED, ids=lambda text: text[:40])
def test_a_malformed_message_is_refused_and_ends_nothing(client, text):
    client.socket.send(text)
    number = int(found[1]) if (found := re.match(r'{"id": (\d+)[,}]', text)) else None
    reply = client.reply(number)
    assert not reply["ok"]
    assert MALFORMED[text] in reply["problem"]["message"]
    assert client.ask("edit", ops=[NODE])["ok"]


def test_what_is_binary_or_too_long_is_refused_by_name(client, server):
    client.socket.send(b"\x00")
    assert "binary" in client.reply(None)["problem"]["message"]
    reply = client.ask("edit", ops=[], label="x" * LONGEST_MESSAGE)
    assert f"It may have {LONGEST_MESSAGE} at most" in reply["problem"]["message"]
    assert client.ask("edit", ops=[NODE])["ok"]
    # Beyond any sense the connection ends, and the session does not.
    from websockets.exceptions import ConnectionClosed

    client.socket.send("x" * 17_000_000)
    with pytest.raises(ConnectionClosed, match="1009"):
        client.reply(None)
    other = Client(server.address)
    other.until(lambda: "document" in other.told)
    assert len(other.told["document"]["document"]["things"]) == 1
    other.close()


def test_pages_see_the_same_model(client, server):
    other = Client(server.address)
    revision = client.ask("edit", ops=[NODE], label="node A")["revision"]
    other.until(lambda: other.told.get("document", {}).get("revision") == revision)
    assert other.told["document"]["document"] == client.told["document"]["document"]
    assert other.told["document"]["undo"] == ["node A"]
    # Undone by the other.
    assert other.ask("undo")["label"] == "node A"
    client.until(lambda: not client.told["document"]["document"]["things"])
    other.close()


def test_a_document_comes_before_the_reply_to_its_edit(client):
    for number in range(20):
        reply = client.ask("edit", ops=[node(f"N{number}")])
        assert client.told["document"]["revision"] == reply["revision"]


def test_a_request_that_is_sent_again_is_done_once(server):
    # The page leaves before its reply.
    first = Client(server.address, page="one")
    number = first.send("edit", ops=[NODE])
    first.close()
    again = Client(server.address, page="one")
    again.number = number - 1
    reply = again.ask("edit", ops=[NODE])
    assert reply["ok"]
    assert reply["ids"] == ["1"]
    assert again.ask("undo")["label"]
    assert again.ask("undo")["label"] is None
    # Of another page it is a request of its own.
    other = Client(server.address, page="two")
    other.number = number - 1
    assert other.ask("edit", ops=[NODE])["revision"] > reply["revision"]
    for page in (again, other):
        page.close()


def test_a_job_that_is_asked_for_again_is_started_once(server):
    first = Client(server.address, page="one")
    number = first.send("run", analysis="mobility")
    job = first.reply(number)["job"]
    first.close()
    again = Client(server.address, page="one")
    again.number = number - 1
    assert again.ask("run", analysis="mobility")["job"] == job
    assert again.ask("run", analysis="mobility")["job"] != job
    again.close()


def test_a_slow_page_gets_the_newest_and_holds_up_no_other(client, server):
    slow = Client(server.address, max_queue=1, close_timeout=0.5)
    # What the operating system takes in is not much beside what is pushed: 100 MB.
    filler = "x" * 1_000_000
    for number in range(100):
        server.tell({"tell": "scene", "of_revision": number, "filler": filler})
    start = time.monotonic()
    assert client.ask("edit", ops=[NODE])["ok"]
    assert time.monotonic() - start < 10
    slow.until(lambda: slow.told.get("scene", {}).get("of_revision") == 99)
    assert len([one for one in slow.heard if one["tell"] == "scene"]) < 50
    slow.close()


def test_what_is_not_finite_is_sent_as_null(client, server):
    import numpy as np

    server.tell({"tell": "answers", "values": {"a": float("nan"), "b": np.float64(2.0), "c": np.array([1.0, np.inf])}})
    found = client.until(lambda: [one["values"] for one in client.heard if one["tell"] == "answers" and one["values"]])[
        0
    ]
    assert found == {"a": None, "b": 2.0, "c": [1.0, None]}


def test_a_page_is_told_the_document_before_any_edit(client):
    found = client.until(lambda: client.told.get("document"))
    assert found["document"]["things"] == []
    assert found["undo"] == found["redo"] == found["problems"] == []
    assert found["saved"] is True


def test_a_new_page_is_told_the_newest_of_everything(server):
    for number in range(3):
        server.tell({"tell": "pinned", "revision": number})
        server.tell({"tell": "job", "job": str(number), "status": "done"})
    client = Client(server.address)
    client.until(lambda: "pinned" in client.told and sum(one["tell"] == "job" for one in client.heard) == 3)
    assert client.told["pinned"]["revision"] == 2
    assert sum(one["tell"] == "pinned" for one in client.heard) == 1
    client.close()


def test_it_ends_with_its_threads_and_gives_the_port_back():
    before = set(threading.enumerate())
    server = Server(Session())
    server.start()
    client = Client(server.address)
    port = server.port
    server.close()
    server.close()
    from websockets.exceptions import ConnectionClosed

    with pytest.raises(ConnectionClosed, match="The workbench has ended"):
        client.until(lambda: False)
    # The client's own thread ends with its connection.
    client.close()
    deadline = time.monotonic() + 5
    while set(threading.enumerate()) - before and time.monotonic() < deadline:
        time.sleep(0.02)
    assert set(threading.enumerate()) == before
    again = Server(Session(), port=port)
    again.start()
    again.close()


def test_a_port_that_is_taken_is_refused(server):
    with pytest.raises(OSError, match="in use"):
        Server(Session(), port=server.port)


@pytest.mark.slow
def test_the_command_ends_cleanly():
    with served() as own:
        client = Client(own.address)
        assert client.ask("edit", ops=[NODE])["ok"]
        assert own.end() == (0, "", "")


@pytest.mark.slow
def test_messages_are_json_for_any_text(client):
    name = "</script><script>alert(1)</script>" + "n" * 100 + "\u2028\x00é"
    client.ask("edit", ops=[], label=name)
    assert client.told["document"]["undo"][-1] == name
    assert json.dumps(name)
