"""Functions of JAX as C99: one file without libraries, with a loop for each operation on arrays."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import ModelError
from .flatten import Atom, Body, Equation, flattened, origin_of, read_by
from .primitives import RULES
from .writer import ArrayView, Compound, Place, Tables, Value, Writer, c_type, variable

RUNTIME = Path(__file__).with_name("runtime.c")
# Longest expression; longer ones are stored, which keeps lines readable and compilers fast.
OPERATIONS = 16


class Translated(NamedTuple):
    """A function in C.

    Attributes:
        name: Name of the function.
        inputs: Names, shapes and types of its inputs; integers and truth values are int64_t.
        outputs: The same for its outputs.
        work: Length of the workspace: numbers (double) and integers (int64_t).
    """

    name: str
    inputs: tuple[tuple[str, tuple[int, ...], np.dtype], ...]
    outputs: tuple[tuple[str, tuple[int, ...], np.dtype], ...]
    work: tuple[int, int]


class Unit:
    """A C file of any number of functions, with shared tables and helpers."""

    def __init__(self):
        self._tables = Tables()
        self._helpers: dict[str, None] = {}
        self._functions: list[str] = []

    def add(
        self,
        name: str,
        function: Callable[..., Any],
        like: Sequence[Any],
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        static: bool = False,
    ) -> Translated:
        """Translate a function of arrays.

        The function in C is ``void name(const double *a, .., double *r, .., double *w, int64_t *n)``: arguments,
        results, and a workspace in any state. Loops, sums, products, bounds of indices, wrapping integers and NaN
        follow JAX up to round-off. ``like`` has arguments or their shapes; captured numbers become constants; only
        this file calls a ``static`` function.
        """
        program = flattened(function, *like)
        inputs = inputs or [f"a{i}" for i in range(len(program.block.inputs))]
        outputs = outputs or [f"r{i}" for i in range(len(program.block.outputs))]
        w = Writer(self._tables, program.constants)
        emitter = _Emitter(w, program.block)
        arguments = []
        for argument, atom in zip(inputs, program.block.inputs, strict=True):
            view = w.new(atom.shape, atom.dtype)
            emitter.at[atom] = view
            arguments.append(f"const {c_type(atom.dtype)} *{argument}")
            w.add(f"(void){argument};")
            if 0 not in atom.shape:
                w.store(view._replace(pool=argument, start=Place()), view)
        with w.writing([]) as middle:
            emitter.run(program.block.equations)
        # Only the middle is divided into functions, which do not know the arguments.
        w.add(Compound([("{", middle)], "}"))
        results = []
        for argument, atom in zip(outputs, program.block.outputs, strict=True):
            value = emitter.at[atom]
            results.append(f"{c_type(atom.dtype)} *{argument}")
            w.add(f"(void){argument};")
            if 0 not in atom.shape:
                w.store(value, w.new(atom.shape, atom.dtype)._replace(pool=argument, start=Place()))
        functions, calls = w.text(name)
        self._helpers.update(w.helpers)
        head = f"{'static ' if static else ''}void {name}({', '.join([*arguments, *results])}, double *w, int64_t *n)"
        body = "\n".join(calls)
        self._functions += [*functions, f"{head}\n{{\n(void)w;\n(void)n;\n{body}\n}}\n"]
        of_inputs, of_outputs = (
            tuple((argument, atom.shape, atom.dtype) for argument, atom in zip(names, atoms, strict=True))
            for names, atoms in ((inputs, program.block.inputs), (outputs, program.block.outputs))
        )
        return Translated(name, of_inputs, of_outputs, w.sizes())

    def source(self) -> str:
        """The text of the file."""
        head, *helpers = _runtime(self._helpers)
        code = "\n".join([*helpers, *self._functions])
        return f"{head}\n{self._tables.completed(code)}"


def _runtime(helper_names: dict[str, None]) -> list[str]:
    """The beginning of ``runtime.c``, and its functions by name."""
    _, head, *texts = RUNTIME.read_text(encoding="utf-8").split("\n\n")
    functions = [head + "\n"]
    for text in texts:
        named = re.search(r"\b(fx_\w+)\(", text)
        if named and named[1] in helper_names:
            functions.append(text.strip() + "\n")
    return functions


class _Emitter:
    """Writes equations one after another; ``at`` is each value."""

    def __init__(self, w: Writer, program: Body):
        self.w = w
        self.at: dict[Atom, Value] = {atom: w.tables.value(array) for atom, array in w.constants.items()}
        self.uses: dict[Atom, int] = {}
        self._count(program)

    def _count(self, block: Body) -> None:
        for equation in block.equations:
            for atom in equation.inputs:
                self.uses[atom] = self.uses.get(atom, 0) + 1
            for inner in equation.blocks:
                self._count(inner)
                # Values from outside a loop are stored before it begins.
                inside = {atom for other in inner.equations for atom in other.outputs}
                for atom in read_by(inner.equations, inner.outputs):
                    self.uses[atom] = self.uses.get(atom, 0) + (atom not in inside)
        for atom in block.outputs:
            self.uses[atom] = self.uses.get(atom, 0) + 1

    def run(self, equations: list[Equation]) -> None:
        """Write equations in order."""
        for equation in equations:
            for atom in equation.outputs:
                _check_type(equation, atom)
            values = [self.at[atom] for atom in equation.inputs]
            for atom, value in zip(equation.outputs, self._translated(equation, values), strict=True):
                if value.cost and (self.uses.get(atom, 0) > 1 or value.cost > OPERATIONS):
                    value = self.w.copied(value)
                self.at[atom] = value

    def _translated(self, equation: Equation, values: list[Value]) -> list[Value]:
        if equation.blocks:
            return {"scan": self._scan, "while": self._while, "cond": self._cond}[equation.name](equation, values)
        try:
            if equation.name not in RULES:
                raise NotImplementedError
            return RULES[equation.name](self.w, equation, values)
        except NotImplementedError as fault:
            about = f" of {fault}" if fault.args else ""
            raise ModelError(
                f"The operation `{equation.name}`{about}{origin_of(equation.origin)} has no translation to C. Use other"
                " functions of jax.numpy."
            ) from None

    def _body(self, block: Body) -> list:
        """Statements of a body."""
        with self.w.writing([]) as inside:
            self.run(block.equations)
        return inside

    def _renewed(self, block: Body, atoms: list[Atom], carried: list[ArrayView]) -> None:
        """Pass the results of a round to the next, all at once."""
        news = [self.at[atom] for atom in atoms]
        moving = [(new, old) for new, old in zip(news, carried, strict=True) if new is not old]
        # A result in a buffer of its own can be stored entry by entry. Others may be computed from carried values.
        fresh = [new if self._has_own_buffer(new, block) else self.w.copied(new) for new, _ in moving]
        for new, (_, old) in zip(fresh, moving, strict=True):
            self.w.store(new, old)

    def _has_own_buffer(self, value: Value, block: Body) -> bool:
        """Whether a value is in a buffer other than those of carried values."""
        carried = {view.start.buffer for view in map(self.at.get, block.inputs) if isinstance(view, ArrayView)}
        return isinstance(value, ArrayView) and value.start.buffer not in carried

    def _scan(self, equation: Equation, values: list[Value]) -> list[Value]:
        (block,), params = equation.blocks, equation.params
        length, carry = params["length"], params["num_carry"]
        carried = [self.w.copied(value) for value in values[:carry]]
        stacks = [self.w.new(atom.shape, atom.dtype) for atom in equation.outputs[carry:]]
        if not length:
            return [*carried, *stacks]
        counter = self.w.new((), np.dtype(np.int64))
        place = variable(counter.at([]))
        row = place * -1 + (length - 1) if params["reverse"] else place
        self.at.update(zip(block.inputs[:carry], carried, strict=True))
        for atom, value in zip(block.inputs[carry:], values[carry:], strict=True):
            self.at[atom] = _row(self.w.stored(value), row)
        inside = self._body(block)
        with self.w.writing(inside):
            for atom, stack in zip(block.outputs[carry:], stacks, strict=True):
                self.w.store(self.at[atom], _row(stack, row))
            self._renewed(block, block.outputs[:carry], carried)
        i = counter.at([])
        # Naming the counter at the end keeps its place.
        self.w.add(Compound([(f"for ({i} = 0; {i} < {length}; {i}++) {{", inside)], f"}} /* {i} */"))
        return [*carried, *stacks]

    def _while(self, equation: Equation, values: list[Value]) -> list[Value]:
        unfinished, block = equation.blocks
        carried = [self.w.copied(value) for value in values]
        for part in (unfinished, block):
            self.at.update(zip(part.inputs, carried, strict=True))
        asked = self._body(unfinished)
        answer = self.at[unfinished.outputs[0]].at([])
        inside = self._body(block)
        with self.w.writing(inside):
            self._renewed(block, block.outputs, carried)
        self.w.add(Compound([("for (;;) {", asked), (f"if (!{answer}) break;", inside)], "}"))
        return list(carried)

    def _cond(self, equation: Equation, values: list[Value]) -> list[Value]:
        results = [self.w.new(atom.shape, atom.dtype) for atom in equation.outputs]
        which = self.w.cheap(values[0]).at([])
        sections = []
        for i, block in enumerate(equation.blocks):
            inside = self._body(block)
            with self.w.writing(inside):
                for atom, to in zip(block.outputs, results, strict=True):
                    self.w.store(self.at[atom], to)
            # An index outside the branches takes the nearest.
            ask = "" if i == len(equation.blocks) - 1 else f"if ({which} <= {i}) "
            sections.append((f"{'} else ' if i else ''}{ask}{{", inside))
        self.w.add(Compound(sections, "}"))
        return list(results)


def _row(view: ArrayView, place: Place) -> ArrayView:
    """One row of an array, with a number known at run time."""
    return ArrayView(view.pool, view.start + place * view.strides[0], view.strides[1:], view.shape[1:], view.dtype)


def _check_type(equation: Equation, atom: Atom) -> None:
    """Refuse types of numbers that C represents differently from JAX."""
    kind = atom.dtype
    if kind.kind in "fiub" and (kind.kind != "f" or kind.itemsize == 8) and kind != np.uint64:
        return
    raise ModelError(
        f"The operation `{equation.name}`{origin_of(equation.origin)} returns numbers of type {kind}: C code has only"
        " float64, integers and truth values."
    )
