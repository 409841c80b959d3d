"""Calls from compiled code to the host. Compiled code with such calls can be stored on disk.

``jax.pure_callback`` does the same, but a program with one is compiled anew in every process, and a call takes 130 us
instead of 11 us. Here the host is a handler of XLA's foreign function interface with a fixed name. The program contains
the call itself: the name of a function of this package and its arguments other than arrays. Only programs that this
package runs use it: they are waited for, and Ctrl-C ends them at their next call. Within a user's own ``jax.jit`` the
call is a callback of JAX.
"""

import base64
import contextlib
import ctypes
import functools
import hashlib
import logging
import pickle
import signal
import threading
import zlib
from collections.abc import Callable
from ctypes import POINTER, Structure, c_char_p, c_int, c_int64, c_size_t, c_uint32, c_void_p
from typing import Any

import jax
import jax.core
import jax.numpy as jnp
import numpy as np

# Name by which programs call the host.
TARGET = "flexmb_host"
# Different calls that are remembered as programs contain them.
MOST_CALLS = 32
_lock = threading.Lock()
_here = threading.local()


class Run:
    """Context for one run of a compiled function of this package whose program may call the host.

    During such a run Ctrl-C is held back: raised within the handler it would be lost, together with the answer of the
    call. The handler refuses further calls instead, so that the program ends. If the process ignores interruptions, as
    background jobs of a shell or under nohup do, the program continues.

    Attributes:
        calls_host: List of one flag: whether the program is known to call the host.
        interrupted: Whether programs are to end.
    """

    interrupted = False

    def __init__(self, calls_host: list[bool]):
        self.calls_host = calls_host
        self._before: Any = None
        self._noted = False

    def __enter__(self) -> "Run":
        self._outer = getattr(_here, "run", None)
        _here.run = self
        if self.calls_host[0]:
            self.hold()
        return self

    def hold(self) -> None:
        """Note that the program calls the host."""
        self.calls_host[0] = True
        if self._before is None and threading.current_thread() is threading.main_thread():
            before = signal.getsignal(signal.SIGINT)
            if callable(before):
                self._before = before
                signal.signal(signal.SIGINT, self._note)

    def _note(self, *_: Any) -> None:
        self._noted = Run.interrupted = True

    def finished(self, results: Any) -> Any:
        """Results once they are complete; the program has ended even if this thread is interrupted while waiting."""
        try:
            return jax.block_until_ready(results)
        except jax.errors.JaxRuntimeError:
            # The program has ended by itself.
            raise
        except BaseException:
            if self.calls_host[0]:
                before, Run.interrupted = Run.interrupted, True
                with contextlib.suppress(Exception):
                    jax.block_until_ready(results)
                Run.interrupted = before
            raise

    def __exit__(self, *fault: object) -> None:
        _here.run = self._outer
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
            if self._noted:
                Run.interrupted = False
                self._before(signal.SIGINT, None)


def call_host(function: Callable[..., Any], like: Any, *arguments: Any) -> Any:
    """Result of a function of NumPy's arrays, inside compiled code, in the form of ``like``; without derivatives.

    Exceptions of the function become errors of JAX with the same text.

    Args:
        function: Function of a module of this package, a ``functools.partial`` of one, or a method of a picklable
            object; programs with other functions are compiled anew in every process. It calls nothing of JAX and has
            no effects.
        like: Shapes and types of the result, a pytree of ``jax.ShapeDtypeStruct``.
    """
    leaves, structure = jax.tree.flatten(arguments)
    shapes, results = jax.tree.flatten(like)
    shapes = [jax.ShapeDtypeStruct(leaf.shape, jax.dtypes.canonicalize_dtype(leaf.dtype)) for leaf in shapes]

    def flat(*leaves: Any):
        return _flat(function, structure, results, leaves)

    if not any(isinstance(leaf, jax.core.Tracer) for leaf in leaves):
        values = [jax.device_put(np.asarray(a, s.dtype)) for a, s in zip(flat(*leaves), shapes, strict=True)]
        return jax.tree.unflatten(results, values)
    trees = [jax.tree.unflatten(tree, range(tree.num_leaves)) for tree in (structure, results)]
    text = _as_text(function, trees) if is_within_run() else None

    @jax.custom_jvp
    def called(*leaves: Any):
        if text is None:
            return jax.pure_callback(flat, shapes, *leaves, vmap_method="sequential")
        digest = hashlib.blake2b(text, digest_size=16).hexdigest()
        written = base64.b85encode(zlib.compress(text)).decode()
        call = jax.ffi.ffi_call(TARGET, shapes, vmap_method="sequential")
        return list(call(*leaves, digest=digest, text=written))

    called.defjvp(_refused)
    return jax.tree.unflatten(results, called(*map(jnp.asarray, leaves)))


def _refused(*_: Any):
    raise TypeError(
        "Results of sparse factors on the host have no further derivative here: a motion can be differentiated once in"
        ' reverse. Give form="coordinates", or sparse=False to other analyses.'
    )


def _flat(function: Callable[..., Any], structure: Any, results: Any, numbers: Any) -> list[Any]:
    """Arrays of a function's result, from copies of the arrays of its arguments."""
    return results.flatten_up_to(function(*jax.tree.unflatten(structure, list(map(np.array, numbers)))))


def _as_text(function: Callable[..., Any], trees: list[Any]) -> bytes | None:
    """The call as text for a program; None if it cannot be pickled or XLA cannot call it."""
    if jax.default_backend() != "cpu" or not is_known_to_xla():
        return None
    try:
        return pickle.dumps((function, *trees), protocol=5)
    except (pickle.PicklingError, AttributeError, TypeError) as reason:
        logging.getLogger("flexmb").debug("%s is called by jax.pure_callback: %s", function, reason)
        return None


def is_within_run() -> bool:
    """Whether operations traced now become part of a program that this package runs."""
    return getattr(_here, "run", None) is not None


def hold_for(program: Any) -> None:
    """Note if the program of this run calls the host."""
    if _registered.cache_info().currsize and is_within_run() and _calls_host(program):
        _here.run.hold()


def _calls_host(program: Any) -> bool:
    from jax.extend.core import jaxprs_in_params

    return any(
        equation.params.get("target_name") == TARGET or any(map(_calls_host, jaxprs_in_params(equation.params)))
        for equation in program.eqns
    )


def is_known_to_xla() -> bool:
    """Register the handler, and return whether programs can call the host by its name."""
    with _lock:
        return _registered()


@functools.cache
def _registered() -> bool:
    try:
        jax.ffi.register_ffi_target(TARGET, jax.ffi.pycapsule(_handler), platform="cpu")
    except Exception as reason:
        logging.getLogger("flexmb").debug("the host is called by jax.pure_callback: %s", reason)
        return False
    return True


def program_on_disk(program: bytes) -> None:
    """Prepare to run a program compiled in another process, which may call the host.

    Raises RuntimeError: XLA's interface differs.
    """
    if TARGET.encode() in program:
        if not is_known_to_xla():
            raise RuntimeError("XLA cannot call the host by its name")
        if is_within_run():
            _here.run.hold()


# By digest: a function, and the structures of its arguments and results.
_calls: dict[bytes, tuple[Callable[..., Any], Any, Any]] = {}


def forget() -> None:
    """Forget calls of programs that are no longer compiled."""
    _calls.clear()


def _answer(digest: bytes, text: Callable[[], bytes], arguments: list[np.ndarray], outputs: list[np.ndarray]) -> None:
    """Call the function that a program contains, and copy its results to the places that XLA gives."""
    if Run.interrupted:
        raise KeyboardInterrupt("the program was interrupted")
    call = _calls.get(digest)
    if call is None:
        function, *trees = pickle.loads(zlib.decompress(base64.b85decode(text())))
        call = function, *map(jax.tree.structure, trees)
        with _lock:
            while len(_calls) >= MOST_CALLS:
                del _calls[next(iter(_calls))]
            _calls[digest] = call
    function, structure, results = call
    answers = _flat(function, structure, results, arguments)
    for place, number in zip(outputs, map(np.asarray, answers), strict=True):
        if number.shape != place.shape:
            raise ValueError(f"{function} returned the shape {number.shape} in place of {place.shape}.")
        np.copyto(place, number, casting="same_kind")


# XLA's interface, xla/ffi/api/c_api.h of version 0.3. Other minor versions only add fields at the end, and XLA refuses
# handlers of versions that it does not support.
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
    """Arrays in the memory of XLA."""
    arrays = []
    for place in range(buffers.count):
        buffer = buffers.all[place].contents
        shape, kind = tuple(buffer.sizes[: buffer.rank]), np.dtype(TYPES[buffer.type])
        size = int(np.prod(shape, dtype=np.int64)) * kind.itemsize
        memory: Any = (ctypes.c_char * size).from_address(buffer.data) if size else bytearray()
        arrays.append(np.frombuffer(memory, kind).reshape(shape))
    return arrays


def _text(attributes: Any, place: int) -> bytes:
    """An attribute of the call; XLA orders attributes by name."""
    attribute = attributes.all[place].contents
    return ctypes.string_at(attribute.begin, attribute.length)


@ctypes.CFUNCTYPE(c_void_p, POINTER(_Frame))
def _handler(frame: Any) -> Any:
    """Handler for XLA, which first asks for its version and then passes arrays; returns an error or None."""
    try:
        call = frame.contents
        if call.extensions:
            extension = _Extension.from_address(call.extensions)
            if extension.kind == METADATA:
                version = extension.metadata.contents.version
                version.major, version.minor = MAJOR, MINOR
                return None
        arguments = _arrays(call.arguments)
        texts = call.attributes
        _answer(_text(texts, 0), lambda: _text(texts, 1), arguments, _arrays(call.results))
    except BaseException as fault:
        # An exception would be lost here, and the program would continue without its results.
        try:
            message = f"{type(fault).__name__}: {fault}"
        except BaseException:
            message = type(fault).__name__
        encoded = message.encode(errors="backslashreplace")
        return frame.contents.interface.contents.make_error(_Failure(ctypes.sizeof(_Failure), None, encoded, INTERNAL))
    return None
