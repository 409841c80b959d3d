"""A document as a Python script that builds the same mechanism, with its names as parameters of a function."""

import builtins
import json
import keyword
import re
from typing import Any

import flexmb

from ..errors import printable
from ..spacar.arithmetic import names_in
from .building import Arguments, build, call_arguments, free_names, numeric_values
from .document import Document
from .edits import texts
from .references import call_and_name, call_of

# Words that no variable of the script may have.
RESERVED = {*keyword.kwlist, *keyword.softkwlist, *dir(builtins), "fm", "planar", "spatial", "pi"}
WIDEST = 110
NAME = re.compile(r"(?<![\w.])[^\W\d]\w*")
LEADING_ZEROS = re.compile(r"(?<![\w.])0+(?=\d)(?![\d]*[.eE])")


def python_of(document: Document) -> str:
    """A script whose function returns the model of a document; a comment names what cannot be built, and why."""
    return _Script(document).text()


class _Script:
    """One script."""

    def __init__(self, document: Document):
        self.document = document
        self.built = build(document)
        self.values, self.texts = numeric_values(document), dict(texts(document))
        self.taken = set(RESERVED)
        self.function = self._variable(document.data["title"] or "mechanism", "mechanism")
        self.names = {name: self._variable(name, "number") for name in document.names}
        self.b = self._variable("b", "builder")
        numbers = {address: Source(self._number(address)) for address in self.values}
        self.arguments = Arguments(document, numbers, {}, Source)

    def text(self) -> str:
        """The whole script."""
        # In the order of building: each thing after the things that it refers to.
        items = [self.document.by_id[id] for id in self.built.made]
        lines = [line for item in items for line in self._lines(item)]
        body = [*self._derived(), f"{self.b} = fm.Builder()", *lines, f"return {self.b}.build()"]
        text = "\n".join("    " + part for line in body for part in line.split("\n"))
        rooms = [room for room in ("planar", "spatial") if re.search(rf"\b{room}\.", text)]
        head = ["import flexmb as fm"]
        head += [f"from flexmb import {', '.join(rooms)}"] * bool(rooms)
        pi = ["from math import pi", ""] if re.search(r"\bpi\b", text) else []
        parameters = [f"{self.names[n]}={self._number(f'names/{n}/value')}" for n in self._free()]
        head_of_function = _wrapped(f"def {self.function}", parameters, ":")
        title = printable(self.document.data["title"] or "mechanism")
        start = [_docstring(f"{title}, from the workbench of flexmb."), "", *self._left_out(), *pi, *head]
        doc = "    " + _docstring(self._doc(title)).replace("\n", "\n    ").replace("\n    \n", "\n\n")
        end = ['if __name__ == "__main__":', f"    print(fm.frequencies({self.function}()))", ""]
        return "\n".join([*start, "", "fm.enable_x64()", "", "", head_of_function, doc, text, "", "", *end])

    def _variable(self, name: str, otherwise: str) -> str:
        """A new name for a variable."""
        word = re.sub(r"\W+", "_", name.strip()).strip("_") or otherwise
        word = word if word.isidentifier() else f"{otherwise}_{word}"
        word = word if word.isidentifier() else otherwise
        variable, number = word, 1
        while variable in self.taken:
            number += 1
            variable = f"{word}_{number}" if number > 2 else f"{word}_"
        self.taken.add(variable)
        return variable

    def _free(self) -> list[str]:
        return [name for name in free_names(self.document) if f"names/{name}/value" in self.values]

    def _doc(self, title: str) -> str:
        """Docstring of the function, with the bounds of its arguments."""
        bounds = []
        for name in self._free():
            low, high = (self.document.names[name].get(bound) for bound in ("low", "high"))
            if low and high:
                bounds.append(f"{self.names[name]}: from {printable(low)} to {printable(high)}.")
        return "\n\n".join([f"Model of {title}.", "\n".join(bounds)]) + "\n" if bounds else f"Model of {title}."

    def _left_out(self) -> list[str]:
        items = self.document.by_id
        problems = {f"{call_and_name(items, p['address'])}: {p['message']}" for p in self.built.problems}
        reported = {p["address"].partition("/")[0] for p in self.built.problems}
        others = [id for id in self.built.skipped if id not in reported]
        problems |= {f"{call_and_name(items, id)}: the thing that it refers to is left out" for id in others}
        return [f"# Left out: {printable(' '.join(text.split()))}" for text in sorted(problems)] + [""] * bool(problems)

    def _derived(self) -> list[str]:
        """Names that follow from others, each after those names."""
        free, lines = self._free(), []
        waiting = [n for n in self.document.names if n not in free and f"names/{n}/value" in self.values]
        while waiting:
            ready = [n for n in waiting if set(waiting).isdisjoint(names_in(self.document.names[n]["value"]))]
            lines += [f"{self.names[n]} = {self._number(f'names/{n}/value')}" for n in ready]
            waiting = [n for n in waiting if n not in ready]
        return lines

    def _number(self, address: str) -> str:
        """The text of a number, with the names of the script."""
        text = LEADING_ZEROS.sub("", " ".join(self.texts[address].split()))
        return NAME.sub(lambda match: self.names.get(match.group(), match.group()), text)

    def _lines(self, item: dict[str, Any]) -> list[str]:
        call: Any = call_of(item)
        by_place, by_name = call_arguments(call, item.get("name"), self.arguments.of(call, item, lambda *_: None))
        place = "fm" if hasattr(flexmb, call.name.partition(".")[0]) else "fm.sections"
        parts = [f"{place}.{call.name}", self.b]
        if call.kind in ("constant", "record"):
            self.arguments.records[item["id"]] = variable = Source(self._variable(item["name"], str(call.makes)))
            parts = [f"{variable} = {parts[0]}"]
            if call.kind == "constant":
                return parts
        elif call.kind == "element":
            parts = [f"{self.b}.add", call.name]
        elif call.kind == "method":
            parts = [f"{self.b}.{call.name}"]
        args = [*parts[1:], *map(_written, by_place), *(f"{key}={_written(value)}" for key, value in by_name.items())]
        return [_wrapped(parts[0], args)]


class Source(str):
    """Text that stands in the script unchanged."""


def _written(value: Any) -> str:
    """A value in Python, with texts in double quotes."""
    if isinstance(value, Source):
        return value
    if isinstance(value, tuple):
        return f"({', '.join(map(_written, value))}{',' * (len(value) == 1)})"
    if isinstance(value, list):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{_written(key)}: {_written(entry)}' for key, entry in value.items())}}}"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _wrapped(called: str, args: list[str], end: str = "") -> str:
    """A call in one line, or with one argument a line if it is too long."""
    line = f"{called}({', '.join(args)}){end}"
    return line if len(line) <= WIDEST or not args else f"{called}(\n    " + ",\n    ".join(args) + f",\n){end}"


def _docstring(text: str) -> str:
    """A docstring without quotes inside."""
    text = text.replace("\\", "/").replace('"', "'")
    return f'"""{text}"""'
