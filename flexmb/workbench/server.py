"""The server of the workbench: a page, its script and a socket with checked messages, on the loopback address.

Any web page may send requests to this address. Each request therefore needs the token of the address and a host that is
this machine, and the socket also an origin that is this server.
"""

import asyncio
import atexit
import contextlib
import hmac
import http
import json
import logging
import os
import re
import secrets
import socket
import threading
from collections import deque
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from typing import Any

from ..errors import AnalysisError, printable
from .jobs import PATIENCE
from .session import Refused, Session

# Longest message from a page in characters; a longer one is refused, and one beyond the second ends the connection.
LONGEST_MESSAGE, LONGEST_FRAME = 4_000_000, 16_000_000


class Page:
    """One connected page and its queue. A slow page receives only the newest message of each kind."""

    def __init__(self, web_socket: Any):
        self.socket = web_socket
        self.waiting: dict[Hashable, str] = {}
        self.filled = asyncio.Event()
        self.replies = 0

    def push(self, key: Hashable, text: str) -> None:
        """Send a text instead of an older waiting one of the same kind."""
        self.waiting[key] = text
        self.filled.set()

    def reply(self, text: str) -> None:
        """Send a reply after everything that waits."""
        self.replies += 1
        self.push(("reply", self.replies), text)

    async def send(self) -> None:
        """Send what waits, as long as the page exists."""
        while True:
            await self.filled.wait()
            while self.waiting:
                await self.socket.send(self.waiting.pop(next(iter(self.waiting))))
            self.filled.clear()


def guarded(work: Callable[..., Any], *arguments: Any) -> Any:
    """Do something, and turn every fault into a refusal: no message ends the session."""
    try:
        return work(*arguments)
    except Refused:
        raise
    except OSError as fault:
        raise Refused(f"'{printable(fault.filename)}': {fault.strerror}." if fault.filename else str(fault)) from fault
    except (AnalysisError, ImportError, ValueError) as fault:
        raise Refused(str(fault), getattr(fault, "address", None)) from fault
    except Exception as fault:
        logging.getLogger("flexmb").debug("a request failed", exc_info=True)
        raise Refused(f"{type(fault).__name__}: {' '.join(str(fault).split())}") from fault


def parsed(text: str | bytes) -> tuple[int, str, dict[str, Any]]:
    """Number, verb and arguments of a message."""
    if not isinstance(text, str):
        raise Refused("The message is binary. It must be a text of JSON.")
    if len(text) > LONGEST_MESSAGE:
        raise Refused(f"The message has {len(text)} letters. It may have {LONGEST_MESSAGE} at most.")
    try:
        message = json.loads(text, parse_constant=_no_constant)
        if "\\ud" in text.lower():
            json.dumps(message, ensure_ascii=False).encode()
    except (ValueError, RecursionError) as fault:
        raise Refused(f"The message is no JSON: {type(fault).__name__}: {fault}") from None
    if not isinstance(message, dict):
        raise Refused("The message is no object. It needs 'id' and 'do'.")
    number, verb = message.pop("id", None), message.pop("do", None)
    if type(number) is not int or not 0 <= number < 2**53:
        raise Refused("The message has no 'id'. It needs a whole number.")
    if not isinstance(verb, str):
        raise Refused("The message has no 'do'. It needs a verb.")
    return number, verb, message


def number_of(text: Any) -> int | None:
    """Number of a refused message, if it begins with one."""
    match = re.match(r'\s*\{\s*"id"\s*:\s*(\d{1,15})\s*[,}]', text[:100]) if isinstance(text, str) else None
    return int(match[1]) if match else None


def _no_constant(word: str) -> Any:
    raise ValueError(f"{word} is no number of JSON.")


def refusal_reply(number: int | None, fault: Refused) -> str:
    """Reply with what is wrong."""
    return written({"re": number, "ok": False, "problem": fault.problem})


def written(message: dict[str, Any]) -> str:
    """A message as JSON, with null for numbers that are not finite."""
    try:
        return json.dumps(message, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError):
        from ..answers.answers import plain

        return json.dumps(plain(message), allow_nan=False, separators=(",", ":"))


LOOPBACK = "127.0.0.1"
# A Host header that names this machine; a tunnel may have another port.
LOCAL_HOST = re.compile(r"(127\.0\.0\.1|localhost)(:\d{1,5})?", re.ASCII | re.IGNORECASE)
# Number of kept replies to one page, for requests that are sent again after a lost connection, and of such pages.
MOST_REPLIES = 200
MOST_PAGES = 50
# Requests of one page at once; more wait.
MOST_UNDER_WAY = 50
# Number of jobs whose last state a new page receives.
MOST_JOBS = 30
FILES = {
    "": ("page.html", "text/html"),
    "page.css": ("page.css", "text/css"),
    "workbench.js": ("workbench.js", "text/javascript"),
}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:;"
    " connect-src 'self'; base-uri 'none'; form-action 'none'"
)
HEADERS = {
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
GOODBYE = "The workbench has ended. Start flexmb edit again to continue on this page."


class Server:
    """Serves a session to the pages of this machine's user, at an address with a port and a token."""

    def __init__(self, session: Session, *, port: int = 0, token: str | None = None, framed: bool = False):
        """Take the port; :meth:`start` begins to answer."""
        try:
            import websockets.asyncio.server  # noqa: F401
        except ModuleNotFoundError:
            message = "The workbench needs the package websockets: pip install 'flexmb[workbench]'."
            raise ModuleNotFoundError(message, name="websockets") from None
        self.session = session
        self.token = token or secrets.token_urlsafe(24)
        self._socket = _listening(port)
        self.port = self._socket.getsockname()[1]
        self.address = f"http://{LOOPBACK}:{self.port}/{self.token}/"
        self._policy = POLICY if framed else f"{POLICY}; frame-ancestors 'none'"
        self._pages: set[Page] = set()
        self._last: dict[Hashable, str] = {}
        self._replies: dict[str, dict[int, asyncio.Task]] = {}
        # Requests change the session here, one after the other. The event loop only passes them on.
        self._desk = ThreadPoolExecutor(1, "flexmb desk")
        self._beside = ThreadPoolExecutor(2, "flexmb beside")
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), name="flexmb workbench", daemon=True)
        self._ready = threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ended: asyncio.Event | None = None

    def start(self) -> None:
        """Begin to answer, in a thread of its own."""
        self._thread.start()
        self._ready.wait()
        self.session.listen(self.tell)
        # Ending a process while its threads compute would abort it within JAX.
        atexit.register(self.close)

    def close(self) -> None:
        """Tell the pages, end the session, and give the port back; a second call does nothing."""
        atexit.unregister(self.close)
        if self._thread.is_alive() and self._loop is not None and self._ended is not None:
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._ended.set)
            self._thread.join(PATIENCE)
        self._socket.close()
        self.session.close()
        self._desk.shutdown(cancel_futures=True)
        self._beside.shutdown(wait=False, cancel_futures=True)

    def tell(self, message: dict[str, Any]) -> None:
        """Send a message to all pages, from any thread."""
        key = (message["tell"], message.get("job"))
        text = written(message)
        if self._loop is not None:
            # A closed loop raises.
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._push, key, text)

    async def _serve(self) -> None:
        from websockets.asyncio.server import serve

        self._loop, self._ended = asyncio.get_running_loop(), asyncio.Event()
        quiet = logging.getLogger("flexmb.workbench.websockets")
        quiet.addHandler(logging.NullHandler())
        quiet.propagate = False
        server = await serve(
            self._connected,
            sock=self._socket,
            process_request=self._request,
            max_size=LONGEST_FRAME,
            compression=None,
            server_header=None,
            close_timeout=1,
            logger=quiet,
        )
        self._ready.set()
        await self._ended.wait()
        server.close(reason=GOODBYE)
        await server.wait_closed()

    def _push(self, key: Hashable, text: str) -> None:
        # The newest job stands last. The oldest job is removed.
        self._last.pop(key, None)
        self._last[key] = text
        jobs = [other for other in self._last if isinstance(other, tuple) and other[1] is not None]
        for old in jobs[:-MOST_JOBS]:
            del self._last[old]
        for page in self._pages:
            page.push(key, text)

    def _request(self, connection: Any, request: Any) -> Any:
        """Answer a request for a file, refuse a wrong one, or let the socket open (None)."""
        hosts, path = request.headers.get_all("Host"), request.path.partition("?")[0]
        if len(hosts) != 1 or not LOCAL_HOST.fullmatch(hosts[0]):
            return self._refusal(connection, 403, "The host is wrong. Use 127.0.0.1 or localhost.")
        token, _, name = path.removeprefix("/").partition("/")
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return self._refusal(connection, 403, "The token in the address is missing or wrong. Copy the whole line.")
        if name == "socket":
            if request.headers.get_all("Origin") != [f"http://{hosts[0]}"]:
                return self._refusal(connection, 403, "The origin is wrong. Use the page of this server.")
            return None
        content = files("flexmb.workbench").joinpath(FILES[name][0]) if name in FILES else None
        if content is None or not content.is_file():
            return self._refusal(connection, 404, "There is no such file.")
        return self._response(connection, 200, content.read_bytes(), FILES[name][1])

    def _refusal(self, connection: Any, status: int, text: str) -> Any:
        return self._response(connection, status, f"{text}\n".encode(), "text/plain")

    def _response(self, connection: Any, status: int, body: bytes, kind: str) -> Any:
        from websockets.datastructures import Headers
        from websockets.http11 import Response

        headers = {"Content-Security-Policy": self._policy, "Content-Type": f"{kind}; charset=utf-8"}
        headers |= {"Content-Length": str(len(body)), "Connection": "close"}
        return Response(status, http.HTTPStatus(status).phrase, Headers(HEADERS | headers), body)

    async def _connected(self, connection: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        page = Page(connection)
        sender = asyncio.create_task(page.send())
        name, under_way = "", deque[asyncio.Task]()
        try:
            async for text in connection:
                try:
                    number, verb, arguments = parsed(text)
                except Refused as fault:
                    page.reply(refusal_reply(number_of(text), fault))
                    continue
                if verb == "hello":
                    name = str(arguments.pop("page", ""))[:100]
                under_way.append(self._asked(page, name, number, verb, arguments))
                if len(under_way) > MOST_UNDER_WAY:
                    await asyncio.wait([under_way.popleft()])
        except ConnectionClosed:
            pass
        finally:
            self._pages.discard(page)
            sender.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionClosed):
                await sender

    def _asked(self, page: Page, name: str, number: int, verb: str, arguments: dict[str, Any]) -> asyncio.Task:
        """Do a request once, however often it is sent, and reply."""
        tasks = self._replies.setdefault(name, {}) if name else {}
        task = tasks.get(number) if verb != "hello" else None
        if task is None:
            key = f"{name}/{number}" if name else None
            task = tasks[number] = asyncio.create_task(self._reply(number, verb, arguments, key))
            while len(tasks) > MOST_REPLIES:
                del tasks[next(iter(tasks))]
        while len(self._replies) > MOST_PAGES:
            del self._replies[next(iter(self._replies))]

        def send_reply(task: asyncio.Task) -> None:
            if task.cancelled():
                return
            page.reply(task.result())
            if verb == "hello":
                self._pages.add(page)
                for key, text in self._last.items():
                    page.push(key, text)

        task.add_done_callback(send_reply)
        return task

    async def _reply(self, number: int, verb: str, arguments: dict[str, Any], key: str | None) -> str:
        assert self._loop is not None
        try:
            content = await self._loop.run_in_executor(self._desk, guarded, self.session.ask, verb, arguments, key)
            if callable(content):
                content = await self._loop.run_in_executor(self._beside, guarded, content)
            return written({"re": number, "ok": True, **content})
        except Refused as fault:
            return refusal_reply(number, fault)


def _listening(port: int) -> socket.socket:
    # Only on a socket with the protocol TCP does asyncio send small messages without waiting (40 ms).
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        if os.name == "posix":
            # The port of an ended process is free; on other systems the option would share a taken port.
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((LOOPBACK, port))
        listener.listen()
    except OSError:
        listener.close()
        raise
    return listener
