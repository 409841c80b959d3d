"""A document as a Python script that builds the same mechanism, with its names as parameters of a function."""

import builtins
import inspect
import json
import keyword
import re
from typing import Any

import flexmb

from ..errors import clean
from ..spacar.arithmetic import names_in
from .building import build, free_names, numbers_of
from .document import Document
from .fields import ENDS_IN_WORDS, Call
from .references import call_of

# Words that a variable of the script must not be called.
RESERVED = {*keyword.kwlist, *keyword.softkwlist, *dir(builtins), "fm", "planar", "spatial", "pi"}
WIDEST = 110
NAME = re.compile(r"(?<![\w.])[^\W\d]\w*")
LEADING_ZEROS = re.compile(r"(?<![\w.])0+(?=\d)(?![\d]*[.eE])")


def python_of(document: Document) -> str:
    """A script whose function returns the model of a document; run by itself it prints the natural frequencies.

    What cannot be built is left out, and stands in a comment with its reason.

    Args:
        document: The document.
    """
    return _Script(document).text()


class _Script:
    """One script on its way."""

    def __init__(self, document: Document):
        self.document = document
        self.built = build(document)
        self.values = numbers_of(document)
        self.taken = set(RESERVED)
        self.function = self._variable(document.data["title"] or "mechanism", "mechanism")
        self.names = {name: self._variable(name, "number") for name in document.names}
        self.b = self._variable("b", "builder")
        self.variables: dict[str, str] = {}

    def text(self) -> str:
        """The whole script."""
        # In the order in which they were made, each after those that it refers to.
        things = [self.document.by_id[id] for id in self.built.made]
        lines = [line for thing in things for line in self._lines(thing)]
        body = [*self._derived(), f"{self.b} = fm.Builder()", *lines, f"return {self.b}.build()"]
        text = "\n".join("    " + part for line in body for part in line.split("\n"))
        rooms = [room for room in ("planar", "spatial") if re.search(rf"\b{room}\.", text)]
        head = ["import flexmb as fm"]
        head += [f"from flexmb import {', '.join(rooms)}"] * bool(rooms)
        pi = ["from math import pi", ""] if re.search(r"\bpi\b", text) else []
        parameters = ", ".join(f"{self.names[n]}={self._number(f'names/{n}/value')}" for n in self._free())
        called = f"def {self.function}({parameters}):"
        if len(called) > WIDEST:
            called = f"def {self.function}(\n    " + parameters.replace(", ", ",\n    ") + ",\n):"
        title = clean(self.document.data["title"] or "mechanism")
        return "\n".join(
            [
                _docstring(f"{title}, from the workbench of flexmb."),
                "",
                *self._left_out(),
                *pi,
                *head,
                "",
                "fm.enable_x64()",
                "",
                "",
                called,
                "    " + _docstring(self._told(title)).replace("\n", "\n    ").replace("\n    \n", "\n\n"),
                text,
                "",
                "",
                'if __name__ == "__main__":',
                f"    print(fm.frequencies({self.function}()))",
                "",
            ]
        )

    def _variable(self, name: str, otherwise: str) -> str:
        """A name for a variable that is not taken yet."""
        word = re.sub(r"\W+", "_", name.strip()).strip("_") or otherwise
        word = word if word.isidentifier() else f"{otherwise}_{word}"
        word = word if word.isidentifier() else otherwise
        found, number = word, 1
        while found in self.taken:
            number += 1
            found = f"{word}_{number}" if number > 2 else f"{word}_"
        self.taken.add(found)
        return found

    def _free(self) -> list[str]:
        return [name for name in free_names(self.document) if f"names/{name}/value" in self.values]

    def _told(self, title: str) -> str:
        """What the function returns, and the bounds of its arguments."""
        told = [f"Model of {title}."]
        for name in self._free():
            bounds = [self.document.names[name].get(bound) for bound in ("low", "high")]
            if all(bounds):
                told.append(f"{self.names[name]}: from {clean(bounds[0])} to {clean(bounds[1])}.")
        return told[0] if len(told) == 1 else "\n\n".join([told[0], "\n".join(told[1:])]) + "\n"

    def _left_out(self) -> list[str]:
        problems = {f"{self._called(one['address'])}: {one['message']}" for one in self.built.problems}
        told = {one["address"].partition("/")[0] for one in self.built.problems}
        problems |= {
            f"{self._called(id)}: what it refers to is left out" for id in self.built.skipped if id not in told
        }
        return [f"# Left out: {clean(' '.join(one.split()))}" for one in sorted(problems)] + [""] * bool(problems)

    def _called(self, address: str) -> str:
        thing = self.document.by_id.get(address.partition("/")[0])
        return address if thing is None else f"{thing['call']} {thing.get('name') or ''}".strip()

    def _derived(self) -> list[str]:
        """Names that follow from others, each after those."""
        free, lines, done = set(self._free()), [], set(self._free())
        waiting = [n for n in self.document.names if n not in free and f"names/{n}/value" in self.values]
        while waiting:
            ready = [n for n in waiting if set(names_in(self.document.names[n]["value"])) & set(waiting) == set()]
            lines += [f"{self.names[n]} = {self._number(f'names/{n}/value')}" for n in ready]
            done |= set(ready)
            waiting = [n for n in waiting if n not in done]
        return lines

    # -- numbers ------------------------------------------------------------------------------------------------------

    def _number(self, address: str) -> str:
        """The text of a number, with the names that the script has."""
        tree: Any = self.document.by_id[address.partition("/")[0]]["args"] if not address.startswith("names/") else None
        if tree is None:
            tree = self.document.names[address.split("/")[1]]["value"]
        else:
            for step in address.split("/")[1:]:
                tree = tree[int(step)] if isinstance(tree, list) else tree[step]
        text = LEADING_ZEROS.sub("", " ".join(str(tree).split()))
        return NAME.sub(lambda found: self.names.get(found.group(), found.group()), text)

    def _vector(self, address: str, values: Any) -> str:
        numbers = [self._number(f"{address}/{k}") for k in range(len(values))]
        return f"({', '.join(numbers)}{',' * (len(numbers) == 1)})"

    # -- calls -------------------------------------------------------------------------------------------------------

    def _lines(self, thing: dict[str, Any]) -> list[str]:
        call: Any = call_of(thing)
        given = {key: value for key, value in thing["args"].items() if value not in ("", [])}
        args = {key: self._argument(call.fields[key], f"{thing['id']}/{key}", given[key]) for key in given}
        if call.kind in ("constant", "record"):
            self.variables[thing["id"]] = variable = self._variable(thing["name"], str(call.makes))
            if call.kind == "constant":
                return [f"{variable} = fm.{call.name}"]
            made = f"fm.{call.name}" if hasattr(flexmb, call.name) else f"fm.sections.{call.name}"
            return [_wrapped(f"{variable} = {made}", [f"{key}={value}" for key, value in args.items()])]
        name = [f"name={_quoted(thing['name'])}"] if thing.get("name") else []
        if call.kind == "element":
            nodes = args.pop("nodes").split(NODES)
            rest = [f"{key}={value}" for key, value in args.items()]
            return [_wrapped(f"{self.b}.add", [call.name, *nodes, *name, *rest])]
        if call.kind == "block":
            rest = [f"{key}={value}" for key, value in args.items()]
            return [_wrapped(f"fm.{call.name}", [self.b, *rest, *name])]
        return [_wrapped(f"{self.b}.{call.name}", self._of_method(call, args, thing.get("name")))]

    def _of_method(self, call: Call, args: dict[str, str], name: str | None) -> list[str]:
        """Arguments of a method: what it needs by place, the rest by name."""
        found, by_place = [], True
        if name and call.makes:
            args = {"name": _quoted(name)} | args
        for key, parameter in inspect.signature(call.function).parameters.items():
            if key not in args:
                by_place = by_place and key == "self"
                continue
            if parameter.kind is parameter.VAR_POSITIONAL:
                found += args[key].split(NODES)
            elif by_place and parameter.kind is not parameter.KEYWORD_ONLY:
                found.append(args[key])
            else:
                found.append(f"{key}={args[key]}")
        return found

    def _argument(self, field: dict[str, Any], address: str, value: Any) -> str:
        """One argument; several that stand by themselves are joined by :data:`NODES`."""
        kind, one = field["kind"], value if isinstance(value, list) else [value]
        text: Any = value
        if kind == "number":
            if field["whole"]:
                return str(int(self.values[address]))
            return self._vector(address, value) if isinstance(value, list) else self._number(address)
        if kind == "vector":
            return self._of_vector(field, address, value)
        if kind == "weights":
            pairs = [f"{_quoted(part)}: {self._number(f'{address}/{k}/1')}" for k, (part, _) in enumerate(value)]
            return f"{{{', '.join(pairs)}}}"
        if kind in ("components", "deformations"):
            words = [word for text in one for word in re.split(r"[\s,]+", text) if word]
            shown = [word if word.isascii() and word.isdecimal() else _quoted(word) for word in words]
            if field["name"] == "released":
                return _released(words, shown)
            return NODES.join(shown)
        if kind == "nodes":
            return NODES.join(map(_quoted, one))
        if kind in ("section", "sections", "material", "damping"):
            space = ("section",) if kind == "sections" else (kind,)
            made = [self.variables[str(self.document.known.thing(space, name))] for name in one]
            return f"[{', '.join(made)}]" if kind == "sections" else made[0]
        if kind == "flag":
            return str(value == "true")
        if kind == "choice" and field["name"] == "clamped":
            return repr(ENDS_IN_WORDS[text])
        if kind == "choice" and field["name"] == "element":
            return text
        return _quoted(text)

    def _of_vector(self, field: dict[str, Any], address: str, value: Any) -> str:
        """As the fields of a document are taken: one number for several that are equal, or alone in the plane."""
        alone = isinstance(value, str)
        several = [self._number(address)] if alone else [self._number(f"{address}/{k}") for k in range(len(value))]
        if field["name"] == "values":
            return NODES.join(several)
        if field["name"] in ("start", "breaks"):
            return f"({', '.join(several)}{',' * (len(several) == 1)})"
        count = field["count"][str(self.document.dimension)]
        one = alone or count == 1 or (count is None and len(several) == 1)
        return several[0] if one else self._vector(address, value)


# Between arguments that are handed over one by one.
NODES = "\0"


def _quoted(text: str) -> str:
    """A text as Python writes it, in double quotes."""
    return json.dumps(text, ensure_ascii=False)


def _released(words: list[str], shown: list[str]) -> str:
    if words in (["all"], ["none"]):
        return '"all"' if words == ["all"] else "()"
    return f"({', '.join(shown)}{',' * (len(shown) == 1)})"


def _wrapped(called: str, args: list[str]) -> str:
    """A call in one line, or with an argument a line where that is too long."""
    line = f"{called}({', '.join(args)})"
    return line if len(line) <= WIDEST else f"{called}(\n    " + ",\n    ".join(args) + ",\n)"


def _docstring(text: str) -> str:
    """A docstring in which nothing ends early."""
    text = text.replace("\\", "/").replace('"', "'")
    return f'"""{text}"""'
