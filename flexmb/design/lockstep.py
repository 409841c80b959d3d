"""Several searches at once, with their designs in one call."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

Kernel = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, int]]


class _Meeting:
    """Searches wait here until each running one has a design to compute."""

    def __init__(self, kernel: Callable[[np.ndarray], tuple], size: int, count: int):
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
            answer = self.answered.pop(search)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def leave(self) -> None:
        """End a search."""
        with self.changed:
            self.under_way -= 1
            self._meet()

    def _meet(self) -> None:
        if not self.asked or len(self.asked) < self.under_way:
            return
        searches = list(self.asked)
        rows = [self.asked[search] for search in searches]
        # A constant number of rows needs one compiled program.
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
    """Results of a search from every start, some at a time, each as if it were alone."""
    results: list[Any] = []
    for first in range(0, len(starts), size):
        group = starts[first : first + size]
        meeting = _Meeting(kernel, size, len(group))

        def run(number: int, start: Any, meeting: _Meeting = meeting) -> Any:
            try:
                return search(lambda unit: meeting.compute(number, unit), start)
            finally:
                meeting.leave()

        with ThreadPoolExecutor(len(group)) as pool:
            results += list(pool.map(run, range(len(group)), group))
    return results
