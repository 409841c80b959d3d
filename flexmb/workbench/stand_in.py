"""Stands in for the history of documents until there is one: adds, sets and deletes things."""

import copy
from typing import Any


class History:
    """Documents as plain data, with undo."""

    def __init__(self, document: Any = None):
        empty = {"format": "flexmb workbench 1", "title": "", "dimension": 2, "names": {}, "next": 1, "things": []}
        self.document = document or empty
        self.steps: list[tuple[str, Any]] = []
        self.later: list[tuple[str, Any]] = []

    undone = property(lambda self: [label for label, _ in self.steps])
    redone = property(lambda self: [label for label, _ in self.later])

    def edit(self, ops: list, label: str, merge: str | None) -> dict[str, Any]:
        """Apply some of the operations."""
        new, ids = copy.deepcopy(self.document), []
        for op in ops:
            if op["op"] == "add":
                ids.append(str(new["next"]))
                new["things"].append({"id": ids[-1], **op["thing"]})
                new["next"] += 1
            elif op["op"] == "set":
                place, name, *index = op["address"].split("/")
                args = next(one for one in new["things"] if one["id"] == place)["args"]
                if index:
                    args[name][int(index[0])] = op["to"]
                else:
                    args[name] = op["to"]
            elif op["op"] == "delete":
                new["things"] = [one for one in new["things"] if one["id"] not in op["ids"]]
            elif op["op"] == "name":
                new["names"][op["name"]] = op["to"]
        self.steps.append((label, self.document))
        self.document, self.later = new, []
        return {"ids": ids, "also": []}

    def undo(self) -> str:
        """Go back."""
        label, old = self.steps.pop()
        self.later.append((label, self.document))
        self.document = old
        return label

    def redo(self) -> str:
        """Go forward."""
        label, new = self.later.pop()
        self.steps.append((label, self.document))
        self.document = new
        return label
