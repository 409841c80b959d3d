"""Compiled programs of XLA for the disk, without the operations that their machine code was compiled from.

Beside its code a program holds its operations: what its kernels do, and what loops do. To load it, XLA makes objects of
them three times, follows through them where each value comes from, and asks where parameters, constants and results
lie: that is three fifths of the time. Here a loop fusion is one operation of its operands that is already compiled, and
so is what a loop does and whether it goes on, of its parameters. Constants within them move to the outermost
operations. Code, the order of kernels, and buffers stay, but for the list of values that no operation is left of.
Fusions of other kinds keep their bodies, of which a library makes its code when the program is loaded or run.

A program is a message of protocol buffers (https://protobuf.dev/programming-guides/encoding); its parts have the
numbers of XLA's ``hlo.proto`` and of what is around that.
"""

import io
from collections.abc import Callable, Iterator
from typing import Any

import jax
import jaxlib.version
from jax.experimental import serialize_executable

# Versions whose programs were run so. What they write is promised to nobody: of others it stays whole.
KNOWN = ("0.10.2",)
# Of the program: its code; of that: operations with settings, and buffers; of the first: operations.
CODE, SET, BUFFERS, MODULE = 1, 1, 2, 1
# Of a module; of a computation; of an instruction.
COMPUTATIONS, ENTRY, SCHEDULE = 3, 6, 7
INSTRUCTIONS, COMPUTATION, ROOT = 2, 5, 6
NAME, OPERATION, SHAPE, KIND, TARGET, INSTRUCTION, CALLED = 1, 2, 3, 11, 28, 35, 38
# Of buffers: values, their aliases, allocations, and what is largest in each; of these the value; of a value: its
# number, and where it is defined, by which instruction.
VALUES, ALIASES, ALLOCATIONS, LARGEST = 1, 2, 3, 5
ASSIGNED, CONSTANT, LARGEST_VALUES = 9, 12, 2
VALUE, DEFINED, DEFINING = 1, 3, 4
# Fusions whose code is part of a program.
COMPILED = ([b"kLoop"], [b"kOutput"])
# Kinds of parts: a number, bytes behind their count, and how many bytes others have.
NUMBER, BYTES, SIZES = 0, 2, {1: 8, 5: 4}
# Bytes of a number.
LONGEST = 10


def slim(program: bytes) -> bytes:
    """A program that is loaded quickly.

    Args:
        program: As ``jax.experimental.serialize_executable.serialize`` writes it.

    Returns:
        The same but for the bodies of fusions and of loops.

    Raises:
        ValueError: It is made otherwise, for another device, or by a version of jaxlib that is not known.
    """
    # Programs of other devices are made from their operations once more when they are loaded.
    if jaxlib.version.__version__ not in KNOWN or jax.default_backend() != "cpu":
        raise ValueError(f"what jaxlib {jaxlib.version.__version__} writes for {jax.default_backend()} is not known")
    found = io.BytesIO()
    _ProgramWriter(found).dump(_ProgramReader(io.BytesIO(program), jax.devices()[0].client).load())
    return found.getvalue()


class _Code(bytes):
    """Of XLA."""


class _ProgramReader(serialize_executable._JaxPjrtUnpickler):
    def persistent_load(self, pid: tuple[str, Any]) -> Any:
        return _Code(_slim(pid[1])) if pid[0] == "exec" else super().persistent_load(pid)


class _ProgramWriter(serialize_executable._JaxPjrtPickler):
    def persistent_id(self, obj: Any) -> Any:
        return ("exec", bytes(obj)) if isinstance(obj, _Code) else super().persistent_id(obj)


def _slim(code: bytes) -> bytes:
    # Ahead of it stand versions and devices.
    length, start = _number(code, 0)
    ahead = start + length
    return code[:ahead] + _changed(code[ahead:], CODE, _code)


def _code(code: bytes) -> bytes:
    """Operations and buffers, shorter."""
    (settings,), (buffers,) = _all(code, SET), _all(code, BUFFERS)
    (module,) = _all(settings, MODULE)
    found = _Operations(module)
    values = {_first(one, VALUE): _first(_all(one, DEFINED)[0], DEFINING) for one in _all(buffers, VALUES)}
    constant = [one for one in _all(buffers, ALLOCATIONS) if _numbers(one, CONSTANT)]
    for number in sorted(_first(one, VALUE) for whole in constant for one in _all(whole, ASSIGNED)):
        found.keep_constant(values[number])
    kept = {number for number, defining in values.items() if defining in found.numbers}

    def value(whole: bytes) -> bytes | None:
        def at(defined: bytes) -> bytes:
            return _replaced(defined, DEFINING, found.numbers[_first(defined, DEFINING)])

        return _changed(whole, DEFINED, at) if _first(whole, VALUE) in kept else None

    def allocation(whole: bytes) -> bytes:
        return _without(whole, ASSIGNED, lambda one: _first(one, VALUE) not in kept)

    def largest(whole: bytes) -> bytes:
        own = b"".join(_written(number) for number in _numbers(whole, LARGEST_VALUES) if number in kept)
        return _without(whole, LARGEST_VALUES, lambda _: True) + _part(LARGEST_VALUES, own)

    buffers = _changed(_changed(buffers, VALUES, value), ALLOCATIONS, allocation)
    buffers = _without(_changed(buffers, LARGEST, largest), ALIASES, lambda _: True)
    settings = _changed(settings, MODULE, lambda _: found.module())
    return _changed(_changed(code, SET, lambda _: settings), BUFFERS, lambda _: buffers)


class _Operations:
    """Operations of a module by which it can be told where parameters, constants and results lie.

    Attributes:
        numbers: Of each instruction that is kept, by what it was.
    """

    def __init__(self, module: bytes):
        self._whole = module
        self._computations = {_first(one, COMPUTATION): one for one in _all(module, COMPUTATIONS)}
        self._kept: dict[int, list[bytes]] = {}
        self._outlined: set[int] = set()
        (self._entry,) = _numbers(module, ENTRY)
        self._keep(self._entry)
        self.numbers = {number: number for own in self._kept.values() for number in map(_of, own)}
        left = [number for number in self._computations if number not in self._kept]
        lost = [one for number in (*left, *self._outlined) for one in self._all_of(number)]
        if any(_operation(one) == b"fusion" and _all(one, KIND) not in COMPILED for one in lost):
            raise ValueError("a library makes code of what a loop does when the program is loaded")
        self._constants = {_of(one): one for one in lost if _operation(one) == b"constant"}
        self._next = max(map(_of, self._kept[self._entry])) + 1

    def keep_constant(self, number: int) -> None:
        """Keep a constant, among the outermost operations where what it is part of is not kept."""
        if number not in self.numbers:
            self.numbers[number] = self._next
            self._kept[self._entry].append(_replaced(self._constants[number], INSTRUCTION, self._next))
            self._next += 1

    def module(self) -> bytes:
        """What is kept, without the order of operations."""

        def computation(whole: bytes) -> bytes | None:
            own = self._kept.get(_first(whole, COMPUTATION))
            if own is None:
                return None
            return _without(whole, INSTRUCTIONS, lambda _: True) + b"".join(_part(INSTRUCTIONS, one) for one in own)

        return _without(_changed(self._whole, COMPUTATIONS, computation), SCHEDULE, lambda _: True)

    def _all_of(self, number: int) -> list[bytes]:
        return _all(self._computations[number], INSTRUCTIONS)

    def _keep(self, number: int) -> None:
        """Keep a computation and those that it calls; of loops what they need, and give."""
        if number in self._outlined:
            raise ValueError("a loop and something else do the same")
        if number in self._kept:
            return
        self._kept[number] = []
        for one in map(_as_compiled, self._all_of(number)):
            self._kept[number].append(one)
            for called in _numbers(one, CALLED):
                (self._outline if _operation(one) == b"while" else self._keep)(called)

    def _outline(self, number: int) -> None:
        """Keep parameters of a computation, and its result as something that is compiled."""
        if number in self._kept:
            raise ValueError("a loop and something else do the same")
        root = _first(self._computations[number], ROOT)
        outlined = (_outlined(one, root) for one in self._all_of(number))
        self._kept[number] = [one for one in outlined if one is not None]
        self._outlined.add(number)


def _operation(instruction: bytes) -> Any:
    return next((value for number, value, _ in _parts(instruction) if number == OPERATION), None)


def _as_compiled(instruction: bytes) -> bytes:
    """A loop fusion as one operation of its operands; others as they are."""
    if _operation(instruction) != b"fusion" or _all(instruction, KIND) != [b"kLoop"]:
        return instruction
    kept = [written for number, _, written in _parts(instruction) if number not in (OPERATION, KIND, CALLED)]
    return b"".join([*kept, *_COMPILED])


def _outlined(instruction: bytes, root: int) -> bytes | None:
    """A parameter as it is, the result as an operation without operands, which may have any shape; no other."""
    if _operation(instruction) == b"parameter":
        return instruction
    if _of(instruction) != root:
        return None
    kept = [written for number, _, written in _parts(instruction) if number in (NAME, SHAPE, INSTRUCTION)]
    return b"".join([*kept, *_COMPILED])


def _of(instruction: bytes) -> int:
    """Number of an instruction."""
    return _first(instruction, INSTRUCTION)


def _changed(message: bytes, chosen: int, change: Callable[[bytes], bytes | None]) -> bytes:
    """A message some parts of which are changed, or left out; an error where it has none of them."""
    found, count = [], 0
    for number, value, written in _parts(message):
        if number == chosen:
            count += 1
            value = change(value)
            written = b"" if value is None else _part(number, value)
        found.append(written)
    if not count:
        raise ValueError(f"a part {chosen} is missing")
    return b"".join(found)


def _without(message: bytes, chosen: int, unwanted: Callable[[Any], bool]) -> bytes:
    """A message without such parts of a kind as are not wanted."""
    return b"".join(written for number, value, written in _parts(message) if number != chosen or not unwanted(value))


def _replaced(message: bytes, chosen: int, value: int) -> bytes:
    """A message with another number in a part of it."""
    return _without(message, chosen, lambda _: True) + _written(8 * chosen + NUMBER) + _written(value)


def _all(message: bytes, chosen: int) -> list[Any]:
    return [value for number, value, _ in _parts(message) if number == chosen]


def _numbers(message: bytes, chosen: int) -> list[int]:
    """Numbers in a part, one by one or in a row."""
    found = []
    for value in _all(message, chosen):
        end = 0
        while not isinstance(value, int) and end < len(value):
            number, end = _number(value, end)
            found.append(number)
        found += [value] if isinstance(value, int) else []
    return found


def _first(message: bytes, chosen: int) -> int:
    """A number, which is left out where it is zero."""
    return next(iter(_numbers(message, chosen)), 0)


def _parts(message: bytes) -> Iterator[tuple[int, Any, bytes]]:
    """Of each part of a message its number, its value, and all of it as written."""
    end, length = 0, len(message)
    while end < length:
        start = end
        key, end = _number(message, start)
        number, kind = key >> 3, key & 7
        if kind == NUMBER:
            value, end = _number(message, end)
        else:
            size, begin = _number(message, end) if kind == BYTES else (SIZES.get(kind, length), end)
            end = begin + size
            value = message[begin:end]
        if end > length:
            raise ValueError(f"a part {number} of kind {kind} goes beyond what there is")
        yield number, value, message[start:end]


def _part(number: int, value: bytes) -> bytes:
    return b"".join([_written(8 * number + BYTES), _written(len(value)), value])


def _number(message: bytes, at: int) -> tuple[int, int]:
    """A number, seven bits a byte and the last ones last, and where it ends."""
    # Most have one byte.
    if at < len(message) and message[at] < 128:
        return message[at], at + 1
    found = shift = 0
    for place, byte in enumerate(message[at : at + LONGEST], at + 1):
        found |= (byte & 127) << shift
        if byte < 128:
            return found, place
        shift += 7
    raise ValueError("it ends within a number")


def _written(number: int) -> bytes:
    found = bytearray()
    while number > 127:
        found.append(number & 127 | 128)
        number >>= 7
    return bytes([*found, number])


# How an operation is written that is already compiled.
_COMPILED = (_part(OPERATION, b"custom-call"), _part(TARGET, b"compiled"))
