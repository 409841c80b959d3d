"""Messages between the pages and the server: checked JSON, and the queue of a page."""

import asyncio
import json
import logging
import re
from collections.abc import Callable, Hashable
from typing import Any

from ..errors import AnalysisError, clean
from .session import Refused

# Longest message from a page in characters; a longer one is refused, and one beyond the second ends the connection.
LONGEST_MESSAGE, LONGEST_FRAME = 4_000_000, 16_000_000


class Page:
    """One connected page and its queue. A slow page receives only the newest message of each kind."""

    def __init__(self, own: Any):
        self.socket = own
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
        raise Refused(f"'{clean(fault.filename)}': {fault.strerror}." if fault.filename else str(fault)) from fault
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
        found = json.loads(text, parse_constant=_no_constant)
        if "\\ud" in text.lower():
            json.dumps(found, ensure_ascii=False).encode()
    except (ValueError, RecursionError) as fault:
        raise Refused(f"The message is no JSON: {type(fault).__name__}: {fault}") from None
    if not isinstance(found, dict):
        raise Refused("The message is no object. It needs 'id' and 'do'.")
    number, verb = found.pop("id", None), found.pop("do", None)
    if type(number) is not int or not 0 <= number < 2**53:
        raise Refused("The message has no 'id'. It needs a whole number.")
    if not isinstance(verb, str):
        raise Refused("The message has no 'do'. It needs a verb.")
    return number, verb, found


def number_of(text: Any) -> int | None:
    """Number of a refused message, if it begins with one."""
    found = re.match(r'\s*\{\s*"id"\s*:\s*(\d{1,15})\s*[,}]', text[:100]) if isinstance(text, str) else None
    return int(found[1]) if found else None


def _no_constant(word: str) -> Any:
    raise ValueError(f"{word} is no number of JSON.")


def refused(number: int | None, fault: Refused) -> str:
    """Reply with what is wrong."""
    return written({"re": number, "ok": False, "problem": fault.problem})


def written(message: dict[str, Any]) -> str:
    """A message as JSON, with null for numbers that are not finite."""
    try:
        return json.dumps(message, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError):
        from ..answers.answers import plain

        return json.dumps(plain(message), allow_nan=False, separators=(",", ":"))
