"""Several searches at once, whose designs are computed in one call."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

Kernel = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, int]]


class _Meeting:
    """Where searches wait until each that is still under way has a design to compute."""

    def __init__(self, kernel: Callable[[np.ndarray], tuple], size: int, count: int):
        """Begin with so many searches."""
        self.kernel, self.size, self.under_way = kernel, size, count
        self.asked: dict[int, np.ndarray] = {}
        self.answered: dict[int, Any] = {}
        self.changed = threading.Condition()

    def compute(self, search: int, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
        """Answers of one design of a search."""
        with self.changed:
            self.asked[search] = np.array(unit, float)
            self._meet()
            self.changed.wait_for(lambda: search in self.answered)
            found = self.answered.pop(search)
        if isinstance(found, BaseException):
            raise found
        return found

    def leave(self) -> None:
        """A search has ended."""
        with self.changed:
            self.under_way -= 1
            self._meet()

    def _meet(self) -> None:
        if not self.asked or len(self.asked) < self.under_way:
            return
        searches = list(self.asked)
        rows = [self.asked[search] for search in searches]
        # Always as many rows, so that one compiled program serves.
        rows += [rows[-1]] * (self.size - len(rows))
        try:
            values, slopes, codes = self.kernel(np.array(rows))
            for row, search in enumerate(searches):
                self.answered[search] = values[row], slopes[row], int(codes[row])
        except BaseException as fault:
            self.answered |= dict.fromkeys(searches, fault)
        self.asked.clear()
        self.changed.notify_all()


def in_lockstep(
    search: Callable[[Kernel, Any], Any], starts: Sequence[Any], kernel: Callable[[np.ndarray], tuple], size: int
) -> list[Any]:
    """Results of a search from every start, some at a time, each as it would be alone.

    Raises:
        BaseException: As a search or the kernel raises.
    """
    found: list[Any] = []
    for first in range(0, len(starts), size):
        group = starts[first : first + size]
        meeting = _Meeting(kernel, size, len(group))

        def one(number: int, start: Any, meeting: _Meeting = meeting) -> Any:
            try:
                return search(lambda unit: meeting.compute(number, unit), start)
            finally:
                meeting.leave()

        with ThreadPoolExecutor(len(group)) as pool:
            found += list(pool.map(one, range(len(group)), group))
    return found
