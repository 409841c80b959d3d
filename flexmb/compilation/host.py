"""Calls of the host by compiled code, in a way that lets such code be kept on disk.

``jax.pure_callback`` does the same, but what holds one is compiled anew in every process, and a call takes twelve times
as long (130 us beside 11 us). Here the host is a handler of XLA's foreign function interface, of the same name in every
process, and what it is to call stands in the program itself: a function of this package by its name, and what it takes
beside arrays.
"""

import base64
import ctypes
import functools
import hashlib
import logging
import pickle
import zlib
from collections.abc import Callable
from ctypes import POINTER, Structure, c_char_p, c_int, c_int64, c_size_t, c_uint32, c_void_p
from typing import Any

import jax
import numpy as np

# The name by which programs call the host.
TARGET = "flexmb_host"
# So many different calls are remembered as they are written in programs.
MOST = 256


def call_host(function: Callable[..., Any], like: Any, *arguments: Any) -> Any:
    """Result of a function of arrays of NumPy, inside compiled code; it has no derivatives.

    Args:
        function: Function of a module of this package, or such a one of which some arguments are given already
            (``functools.partial``), or a method of what can be pickled; what holds another is compiled anew in every
            process. It calls nothing of JAX and has no effects.
        like: Shapes and types of what it returns, a pytree of ``jax.ShapeDtypeStruct``.
        arguments: Pytrees of arrays; the function is given copies.

    Returns:
        As ``like``. What the function raises becomes an error of JAX with its text.
    """
    if jax.default_backend() != "cpu" or not is_known_to_xla():
        return _by_callback(function, like, *arguments)
    leaves, structure = jax.tree.flatten(arguments)
    shapes, results = jax.tree.flatten(like)
    trees = [jax.tree.unflatten(tree, range(tree.num_leaves)) for tree in (structure, results)]
    try:
        text = pickle.dumps((function, *trees), protocol=5)
    except (pickle.PicklingError, AttributeError, TypeError) as reason:
        logging.getLogger("flexmb").debug("%s is called by jax.pure_callback: %s", function, reason)
        return _by_callback(function, like, *arguments)
    found = jax.ffi.ffi_call(TARGET, shapes, vmap_method="sequential")(
        *leaves,
        digest=hashlib.blake2b(text, digest_size=16).hexdigest(),
        text=base64.b85encode(zlib.compress(text)).decode(),
    )
    return jax.tree.unflatten(results, found)


def _by_callback(function: Callable[..., Any], like: Any, *arguments: Any) -> Any:
    """As :func:`call_host` where a program cannot name the function, or on another device than a processor."""

    def called(*arguments: Any):
        return function(*jax.tree.map(np.array, arguments))

    return jax.pure_callback(called, like, *arguments, vmap_method="sequential")


@functools.cache
def is_known_to_xla() -> bool:
    """Whether programs can call the host by its name, from now on."""
    try:
        jax.ffi.register_ffi_target(TARGET, jax.ffi.pycapsule(_handler), platform="cpu")
    except Exception as reason:
        logging.getLogger("flexmb").debug("the host is called by jax.pure_callback: %s", reason)
        return False
    return True


# By digest: a function, and how its arguments and results are made of arrays.
_calls: dict[bytes, tuple[Callable[..., Any], Any, Any]] = {}


def _answer(digest: bytes, text: Callable[[], bytes], given: list[np.ndarray], wanted: list[np.ndarray]) -> None:
    """Call what is written in a program, and put what it returns where the program wants it."""
    if digest not in _calls:
        function, *trees = pickle.loads(zlib.decompress(base64.b85decode(text())))
        while len(_calls) >= MOST:
            _calls.pop(next(iter(_calls)), None)
        _calls[digest] = function, *map(jax.tree.structure, trees)
    function, structure, results = _calls[digest]
    found = results.flatten_up_to(function(*jax.tree.unflatten(structure, given)))
    for place, number in zip(wanted, map(np.asarray, found), strict=True):
        if number.shape != place.shape:
            raise ValueError(f"{function} returned the shape {number.shape} in place of {place.shape}.")
        np.copyto(place, number, casting="same_kind")


# XLA's interface, xla/ffi/api/c_api.h of version 0.3. Another minor version adds fields at ends alone, and XLA refuses
# a handler of another major one.
MAJOR, MINOR = 0, 3
METADATA, INTERNAL = 1, 13
TYPES = {1: "?", 4: "i4", 5: "i8", 8: "u4", 9: "u8", 11: "f4", 12: "f8", 15: "c8", 18: "c16"}
HEAD = [("size_of", c_size_t), ("extensions", c_void_p)]


class _Version(Structure):
    _fields_ = [*HEAD, ("major", c_int), ("minor", c_int)]


class _Metadata(Structure):
    _fields_ = [("size_of", c_size_t), ("version", _Version), ("traits", c_uint32), ("state", c_int64)]


class _Extension(Structure):
    _fields_ = [("size_of", c_size_t), ("kind", c_int), ("next", c_void_p), ("metadata", POINTER(_Metadata))]


class _Buffer(Structure):
    _fields_ = [*HEAD, ("type", c_int), ("data", c_void_p), ("rank", c_int64), ("sizes", POINTER(c_int64))]


class _Buffers(Structure):
    _fields_ = [*HEAD, ("count", c_int64), ("kinds", c_void_p), ("all", POINTER(POINTER(_Buffer)))]


class _Characters(Structure):
    _fields_ = [("begin", c_void_p), ("length", c_size_t)]


class _Attributes(Structure):
    _fields_ = [
        *HEAD,
        ("count", c_int64),
        ("kinds", c_void_p),
        ("names", c_void_p),
        ("all", POINTER(POINTER(_Characters))),
    ]


class _Failure(Structure):
    _fields_ = [*HEAD, ("message", c_char_p), ("code", c_int)]


class _Interface(Structure):
    _fields_ = [
        *HEAD,
        ("version", _Version),
        ("internal", c_void_p),
        ("make_error", ctypes.CFUNCTYPE(c_void_p, POINTER(_Failure))),
    ]


class _Frame(Structure):
    _fields_ = [
        *HEAD,
        ("interface", POINTER(_Interface)),
        ("context", c_void_p),
        ("stage", c_int),
        ("arguments", _Buffers),
        ("results", _Buffers),
        ("attributes", _Attributes),
    ]


def _arrays(buffers: Any) -> list[np.ndarray]:
    """Arrays that lie where XLA has them."""
    found = []
    for place in range(buffers.count):
        one = buffers.all[place].contents
        shape, kind = tuple(one.sizes[: one.rank]), np.dtype(TYPES[one.type])
        size = int(np.prod(shape, dtype=np.int64)) * kind.itemsize
        memory = (ctypes.c_char * size).from_address(one.data) if size else bytearray()
        found.append(np.frombuffer(memory, kind).reshape(shape))
    return found


def _text(attributes: Any, place: int) -> bytes:
    """One of a program's attributes, which XLA orders by name."""
    one = attributes.all[place].contents
    return ctypes.string_at(one.begin, one.length)


@ctypes.CFUNCTYPE(c_void_p, POINTER(_Frame))
def _handler(frame: Any) -> Any:
    """What XLA calls: first with a question for the version, then with arrays; it returns an error or nothing."""
    try:
        call = frame.contents
        if call.extensions:
            extension = _Extension.from_address(call.extensions)
            if extension.kind == METADATA:
                version = extension.metadata.contents.version
                version.major, version.minor = MAJOR, MINOR
                return None
        given = [array.copy() for array in _arrays(call.arguments)]
        texts = call.attributes
        _answer(_text(texts, 0), lambda: _text(texts, 1), given, _arrays(call.results))
    except BaseException as fault:
        # An exception would leave the result as it is, and the program would go on.
        message = f"{type(fault).__name__}: {fault}".encode()
        return frame.contents.interface.contents.make_error(_Failure(ctypes.sizeof(_Failure), None, message, INTERNAL))
    return None
