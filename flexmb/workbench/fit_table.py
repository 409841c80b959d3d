"""Names of a document fitted to a table of measurements."""

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp

from ..display import short
from ..errors import heard
from ..identification.fit import fit
from ..identification.fitted import Fit
from ..identification.study_data import measured_table
from ..linear.linearize import linearize
from ..model.model import Model
from ..plot.answer import image_of
from .building import build, built_whole, numeric_values
from .document import Document
from .targets import bounds_of
from .traced import answer_of, increment_of
from .wants import checked_free, name_ops

LEVEL = 0.95


def fitted_names(
    document: Document, file: str, text: str, free: Sequence[str], node: str | None = None
) -> dict[str, Any]:
    """Fit names to the text of a CSV file, as :func:`flexmb.fit` does.

    Returns:
        "status", "title", "text", "rows" (a line for each name), "picture" (SVG), and "ops" that would write the fitted
        values into the document.
    """
    built_whole(document)
    numbers = numeric_values(document)
    names = checked_free(document, free)
    bounds = {name: bounds_of(document, name, numbers)[0] for name in names}
    start = {name: float(numbers[f"names/{name}/value"]) for name in names}

    def model_of(**values: Any) -> Model:
        return build(document, numeric_values(document, values)).builder.build()

    def answers(questions: list[str]) -> Any:
        functions = [answer_of(question, node) for question in questions]

        def computed(model: Model) -> Any:
            lin = linearize(model, increment=increment_of(model))
            return jnp.stack([jnp.asarray(function(lin), float) for function in functions])

        return computed

    with heard() as warnings:
        fit_result = fit(model_of, measured_table(file, text, answers), start, bounds, throw=False)
    summary = fit_result.summary()
    facts = [f"{name}: {text}" for name, text in summary.rows.items() if name not in fit_result.labels]
    good = fit_result.result.name in ("successful", "poor_fit")
    ops = name_ops(document, {name: float(value) for name, value in fit_result.parameters.items()}, 7)
    return {
        "status": "done" if good else "failed",
        "title": f"Fit to {file}",
        "text": "\n".join([summary.title, *facts, *dict.fromkeys(warnings)]),
        "rows": [_row(fit_result, name, start[name]) for name in fit_result.labels],
        "picture": image_of(fit_result, "svg").decode(),
        "ops": ops if good else [],
    }


def _row(fit_result: Fit, name: str, before: float) -> dict[str, str]:
    ends = fit_result.interval(name, LEVEL)
    return {
        "name": name,
        "before": short(before),
        "fitted": short(float(fit_result.parameters[name])),
        "deviation": short(float(fit_result.deviation[name])),
        f"{100 * LEVEL:g} % from": short(ends[0]),
        "to": short(ends[1]),
    }
