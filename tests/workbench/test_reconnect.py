"""The page in a browser: it finds the server again, and nothing that was changed meanwhile is lost."""

import functools
import http.server
import signal
import threading
import time

import pytest
from cases.workbench import (
    Client,
    Process,
    ask,
    faults,
    needs_browser,
    opened,
    requests,
    served,
    until,
    wait_for,
)

import flexmb as fm

pytestmark = [needs_browser, pytest.mark.timeout(180)]
NODE = "{op: 'add', thing: {call: 'node', name: 'NAME', args: {position: ['0', '0']}}}"


def node(name):
    return NODE.replace("NAME", name)


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves a folder without a word."""

    def log_message(self, format, *args):
        """Say nothing."""


def names(page):
    return ask(page, "s.state.document.things.map((one) => one.name)")


@pytest.mark.slow
def test_a_killed_server_is_found_again_with_all_edits(browser, tmp_path):
    first = Process(state=tmp_path / "state")
    page = opened(browser, first.address)
    assert wait_for(page, f"s.edit([{node('A')}])")["ids"] == ["1"]
    page.execute_script(
        "window.own = []; window.workbench.store.on('connected', (own) => window.own.push(own.connected));"
    )
    first.end(signal.SIGKILL)
    until(page, "!s.state.connected")
    # What is changed while nobody answers is sent when somebody does.
    page.execute_script(
        f"const s = window.workbench.store; window.replies = [];"
        f"for (const one of [{node('B')}, {node('C')}])"
        " s.edit([one]).then((reply) => window.replies.push(reply.ids), (fault) => window.replies.push(fault.message));"
    )
    second = Process(state=tmp_path / "state")
    try:
        # The same port and token, so that the page that is open finds it.
        assert second.address == first.address
        until(page, "s.state.connected && window.replies.length === 2")
        until(page, "s.state.document.things.length === 3")
        assert names(page) == ["A", "B", "C"]
        assert ask(page, "window.replies") == [["2"], ["3"]]
        # What came back from the journal is told.
        until(page, "document.getElementById('recovered')")
        assert ask(page, "s.state.undo.length") == 3
        for _ in range(3):
            wait_for(page, "s.ask('undo')")
        until(page, "s.state.document.things.length === 0")
    finally:
        assert second.end()[0] == 0


@pytest.mark.slow
def test_an_edit_that_was_done_but_not_answered_is_not_done_twice(browser, tmp_path):
    first = Process(state=tmp_path / "state")
    page = opened(browser, first.address)
    # The page asks, and hears no reply; the server has done it.
    page.execute_script(
        "const s = window.workbench.store; const hear = s.hear.bind(s);"
        "s.hear = (message) => { if (!('re' in message)) hear(message); };"
        f"s.edit([{node('A')}]).then((reply) => (window.reply = reply), (fault) => (window.reply = fault.message));"
    )
    until(page, "s.state.document.things.length === 1")
    first.end(signal.SIGKILL)
    page.execute_script("delete window.workbench.store.hear;")
    with served(state=tmp_path / "state"):
        until(page, "window.reply")
        assert ask(page, "window.reply.ids") == ["1"]
        until(page, "s.state.connected && s.state.document")
        assert names(page) == ["A"]


@pytest.mark.slow
def test_a_hiccup_of_the_connection_loses_nothing(browser, tmp_path):
    with served(state=tmp_path / "state") as own:
        page = opened(browser, own.address)
        page.execute_script(
            "const s = window.workbench.store; window.done = 0;"
            "for (let k = 0; k < 40; k += 1) {"
            "  const thing = {call: 'node', name: `N${k}`, args: {position: [String(k), '0']}};"
            "  s.edit([{op: 'add', thing}]).then(() => (window.done += 1));"
            "  if (k % 10 === 5) s.connection.socket.close();"
            "}"
        )
        until(page, "window.done === 40")
        until(page, "s.state.document.things.length === 40")
        assert names(page) == [f"N{k}" for k in range(40)]


@pytest.mark.slow
def test_of_a_burst_the_last_counts(browser, tmp_path):
    with served(state=tmp_path / "state") as own:
        page = opened(browser, own.address)
        wait_for(page, f"s.edit([{node('A')}, {{op: 'name', name: 't', to: {{value: '1'}}}}])")
        before = ask(page, "s.state.revision")
        page.execute_script(
            "const s = window.workbench.store; const all = [];"
            "for (let k = 1; k <= 300; k += 1) {"
            "  all.push(s.edit([{op: 'name', name: 't', to: {value: String(k)}}], {label: 't', merge: 't'}));"
            "  const set = {op: 'set', address: '1/position/0', to: String(k)};"
            "  if (k % 2) all.push(s.edit([set], {label: 't', merge: 't'}));"
            "}"
            "const told = (what) => (window.replies = what);"
            "Promise.all(all).then((replies) => told(replies.length), (fault) => told(fault.message));"
        )
        until(page, "window.replies === 450")
        until(page, "s.state.values.t === 300")
        # Of both kinds the last; one edit under way, and all others in the one that waited.
        assert ask(page, "s.state.positions.A[0]") == 299
        assert ask(page, "s.state.revision") - before <= 4
        assert ask(page, "s.state.undo.length") == 2


@pytest.mark.slow
def test_an_undo_comes_after_what_waits(browser, tmp_path):
    with served(state=tmp_path / "state") as own:
        page = opened(browser, own.address)
        wait_for(page, "s.edit([{op: 'name', name: 't', to: {value: '1'}}], {label: 'first'})")
        page.execute_script(
            "const s = window.workbench.store;"
            "for (let k = 2; k < 10; k += 1) s.edit([{op: 'name', name: 't', to: {value: String(k)}}], {merge: 't'});"
            "s.ask('undo').then((reply) => (window.label = reply.label));"
        )
        until(page, "window.label !== undefined")
        until(page, "s.state.values.t === 1")
        assert ask(page, "s.state.undo") == ["first"]


@pytest.mark.slow
def test_two_pages_and_no_request_elsewhere(browser, tmp_path):
    with served(state=tmp_path / "state") as own:
        page = opened(browser, own.address)
        first = page.current_window_handle
        page.switch_to.new_window("tab")
        opened(page, own.address)
        wait_for(page, f"s.edit([{node('<script>alert(1)</script>' + 'x' * 100)}], {{label: '<b>bold</b>'}})")
        page.switch_to.window(first)
        until(page, "s.state.document.things.length === 1")
        assert names(page)[0].startswith("<script>alert(1)")
        # What is shown is shown by all, also by one that is loaded anew.
        wait_for(page, "s.want({state: 'equilibrium', mode: 2})")
        page.switch_to.window(next(other for other in page.window_handles if other != first))
        until(page, "s.state.want.mode === 2 && s.state.want.state === 'equilibrium'")
        page.switch_to.window(first)
        opened(page, own.address)
        assert ask(page, "s.state.want.mode") == 2
        assert ask(page, "document.querySelectorAll('script').length") == 1
        # Of a third that is no browser, too.
        client = Client(own.address)
        client.ask("undo")
        until(page, "s.state.document.things.length === 0")
        client.close()
        assert not faults(page)
        asked = [address for address in requests(page) if not address.startswith(("data:", "blob:", "chrome:"))]
        assert all(address.startswith(own.address) for address in asked)
        page.switch_to.window(next(other for other in page.window_handles if other != first))
        page.close()
        page.switch_to.window(first)


@pytest.mark.slow
def test_a_message_that_is_too_long_is_refused_by_name(browser, tmp_path):
    with served(state=tmp_path / "state") as own:
        page = opened(browser, own.address)
        reply = wait_for(page, "s.ask('open', {name: 'a.json', text: 'x'.repeat(5e6)})")
        assert "too much for one message" in reply["problem"]
        assert wait_for(page, f"s.edit([{node('A')}])")["ids"]


@pytest.mark.slow
def test_the_page_says_when_the_server_has_ended(browser, tmp_path):
    with served(state=tmp_path / "state") as own:
        page = opened(browser, own.address)
        time.sleep(1.6)
        own.end()
        until(page, "document.getElementById('disconnected')")
        assert "ended" in page.find_element("id", "disconnected").text


@pytest.mark.slow
def test_a_notebook_holds_the_page_in_a_frame(browser, tmp_path, monkeypatch):
    """As a cell of a notebook does: in a page of another server, whose origin is another."""
    monkeypatch.setenv("FLEXMB_STATE", str(tmp_path / "state"))
    with fm.edit(browser=False) as own:
        (tmp_path / "cell.html").write_text(f"<!doctype html><meta charset='utf-8'>{own._repr_html_()}")
        handler = functools.partial(QuietHandler, directory=str(tmp_path))
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as notebook:
            threading.Thread(target=notebook.serve_forever, daemon=True).start()
            browser.get_log("browser")
            browser.get(f"http://127.0.0.1:{notebook.server_port}/cell.html")
            browser.switch_to.frame(0)
            try:
                until(browser, "window.workbench && s.state.connected && s.state.document")
                wait_for(browser, f"s.edit([{node('A')}])")
                assert own.document.things[0]["name"] == "A"
                assert not [one for one in faults(browser) if "favicon" not in one]
            finally:
                browser.switch_to.default_content()
                notebook.shutdown()


@pytest.mark.slow
def test_the_command_shows_in_no_frame(browser, tmp_path):
    with served(state=tmp_path / "state") as own:
        (tmp_path / "evil.html").write_text(f"<!doctype html><iframe src='{own.address}'></iframe>")
        browser.get((tmp_path / "evil.html").as_uri())
        until(browser, "document.querySelector('iframe')")
        assert any("frame-ancestors" in one for one in faults(browser))
