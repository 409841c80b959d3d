"""Base class of dense and sparse paths: states, factors and summary."""

from typing import Any

import numpy as np

from ..arguments import check_whole
from ..display import AT_MOST, States, Summary, course, short
from ..linear.linearize import Stressed
from ..mechanics.loads import LoadFactors
from ..results import outcome_text
from .stepper import factors_at


class OverLoad:
    """Base class of results with equilibria over a load factor."""

    @property
    def labels(self: Any):
        """Names."""
        return self.model.labels

    def step_of(self: Any, step: int | None, time: float | None) -> int:
        """Number of a step, from 0 or from the end; by default the last."""
        if time is not None:
            raise ValueError("A path has no times. Choose a state by step=, such as step=-1 for the last.")
        count, chosen = len(self.load_factor), -1 if step is None else check_whole("step", step)
        if not -count <= chosen < count:
            raise IndexError(f"The path has {count} steps, numbered from 0. Number {chosen} is none of them.")
        return chosen

    def factors(self: Any, step: int) -> LoadFactors:
        """Load factors of the constant and of the incremental loads at one step."""
        return factors_at(self.model.parameters, self.load_factor[step])

    def stressed(self: Any) -> Stressed:
        """What stress of all steps is computed from."""
        return Stressed(self.x, self.sigma, self.felt, self.e)

    def states(self: Any) -> States:
        """The equilibria, over the load factor."""
        return States(self.model, self.x, "path", self.load_factor, "load factor [-]")

    def check_critical(self: Any) -> None:
        """Raise ValueError for a path without critical points."""
        if not self.critical_points:
            raise ValueError(
                "This path has no critical points. Follow it further, with more load or a later `stop`, until"
                " path.critical_points has some."
            )

    def summary(self: Any) -> Summary:
        """Outcome, steps, load factor and critical points."""
        points = [f"{point.kind} at {point.load_factor:.5g}" for point in self.critical_points]
        stable = np.asarray(self.stable)
        rows = {
            "result": outcome_text(self.result),
            "steps": f"{len(stable)}, {int(np.sum(stable))} of them stable",
            "load factor": f"up to {short(np.max(np.asarray(self.load_factor)))}",
            "critical points": ", ".join(points[:AT_MOST]) or "none",
        }
        if self.stopped_by is not None:
            rows["stopped by"] = f"{self.stopped_by}, at load factor {short(np.asarray(self.load_factor)[-1])}"
        return Summary(f"{type(self).__name__}: {course(self.states())}", rows, self.picture)
