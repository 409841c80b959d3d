"""Compiled programs of XLA for the disk, without the operations that their machine code was compiled from.

Beside its code a program holds its operations. Most are bodies of loop fusions: what each of its kernels does. To load
it, XLA makes objects of them three times and asks nothing of them, which is half of the time or more for a motion. Here
such a body is its parameters and something of the shape of its result; code, buffers and the order of kernels stay.
Fusions of other kinds keep theirs, of which a library makes its code when the program is loaded or run.

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
# Of the program: its code; of that: operations and settings; of these: operations.
TO_MODULE = (1, 1, 1)
# Of a module; of a computation; of an instruction.
COMPUTATIONS = 3
INSTRUCTIONS, COMPUTATION, ROOT = 2, 5, 6
NAME, OPERATION, SHAPE, KIND, TARGET, INSTRUCTION, CALLED = 1, 2, 3, 11, 28, 35, 38
# Kinds of parts: a number, bytes behind their count, and how many bytes others have.
NUMBER, BYTES, SIZES = 0, 2, {1: 8, 5: 4}
# Bytes of a number.
LONGEST = 10


def slim(program: bytes) -> bytes:
    """A program that is loaded quickly.

    Args:
        program: As ``jax.experimental.serialize_executable.serialize`` writes it.

    Returns:
        The same but for the bodies of fusions.

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
    return code[:ahead] + _within(code[ahead:], *TO_MODULE)


def _within(message: bytes, *path: int) -> bytes:
    return _changed(message, path[0], lambda part: _within(part, *path[1:])) if path else _module(message)


def _module(module: bytes) -> bytes:
    instructions = [one for whole in _all(module, COMPUTATIONS) for one in _all(whole, INSTRUCTIONS)]
    fusions = [one for one in instructions if _operation(one) == b"fusion" and _all(one, KIND) == [b"kLoop"]]
    called = [number for one in fusions for number in _all(one, CALLED)]
    bodies = {number if isinstance(number, int) else _number(number, 0)[0] for number in called}

    def computation(whole: bytes) -> bytes:
        (number,), (root,) = _all(whole, COMPUTATION), _all(whole, ROOT)
        return _changed(whole, INSTRUCTIONS, lambda one: _of_body(one, root)) if number in bodies else whole

    return _changed(module, COMPUTATIONS, computation)


def _operation(instruction: bytes) -> Any:
    return next((value for number, value, _ in _parts(instruction) if number == OPERATION), None)


def _of_body(instruction: bytes, root: int) -> bytes | None:
    """A parameter as it is, the result as an operation without operands, which may have any shape; no other."""
    if _operation(instruction) == b"parameter":
        return instruction
    if _all(instruction, INSTRUCTION) != [root]:
        return None
    kept = [written for number, _, written in _parts(instruction) if number in (NAME, SHAPE, INSTRUCTION)]
    return b"".join([*kept, _part(OPERATION, b"custom-call"), _part(TARGET, b"compiled")])


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


def _all(message: bytes, chosen: int) -> list[Any]:
    return [value for number, value, _ in _parts(message) if number == chosen]


def _parts(message: bytes) -> Iterator[tuple[int, Any, bytes]]:
    """Of each part of a message its number, its value, and all of it as written."""
    end = 0
    while end < len(message):
        start = end
        key, end = _number(message, start)
        number, kind = divmod(key, 8)
        if kind == NUMBER:
            value, end = _number(message, end)
        else:
            size, begin = _number(message, end) if kind == BYTES else (SIZES.get(kind, len(message)), end)
            end = begin + size
            value = message[begin:end]
        if end > len(message):
            raise ValueError(f"a part {number} of kind {kind} goes beyond what there is")
        yield number, value, message[start:end]


def _part(number: int, value: bytes) -> bytes:
    return b"".join([_written(8 * number + BYTES), _written(len(value)), value])


def _number(message: bytes, at: int) -> tuple[int, int]:
    """A number, seven bits a byte and the last ones last, and where it ends."""
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
