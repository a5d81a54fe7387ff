"""The message standard of this kit: a JSON header, then one frame of raw bytes for each array.

    request = Message("frame", 7, {"bottom_up": True}, [Array("uint8", picture.shape, picture)])
    socket.send_multipart(request.frames())
    reply = Message.read_reply(socket.recv_multipart(copy=False))       reply.values, reply.arrays[0].numpy()

    frame 1     {"kind":"frame","version":1,"id":7,"values":{"bottom_up":true},
                 "arrays":[{"dtype":"uint8","shape":[240,320,3]}]}           JSON, UTF-8, at most 64 KB
    frame 2...  the arrays' items, row after row, little-endian; all arrays together at most 64 MB

`values` are texts, numbers, true and false by name. A reply has the request's id, and its kind is `ok`, or `error` with
the values `code`, for programs, and `text`, for people. Fields that this version does not know are ignored. What does
not keep to this is a MessageError. The C# side is Message.cs. It needs only Python; `Array.numpy` needs numpy.
"""

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from netmq_example.errors import Coded, Refused
from netmq_example.errors import MessageError as MessageError
from netmq_example.json_text import parsed, quoted, written
from netmq_example.trouble import ends_program, shown

VERSION = 1
# In bytes: the header, and all arrays together.
HEADER_LIMIT = 64 * 1024
LIMIT = 64 * 1024 * 1024
# Of characters that say what is wrong; in the header one may become 12 bytes.
LONGEST_TEXT = 4000
# Whole numbers nearer to zero than this are exact in every JSON reader, also in one that knows only floats.
EXACT = 2**53
# The names are numpy's, and their items' sizes in bytes.
DTYPES = {"uint8": 1, "uint16": 2, "int32": 4, "int64": 8, "float32": 4, "float64": 8}
# How a memoryview names the items of each. Bytes, which may be any of them, are B or c there.
FORMATS = {"uint8": "?", "uint16": "H", "int32": "il", "int64": "lq", "float32": "f", "float64": "d"}

log = logging.getLogger("netmq_example.server")


@dataclass(slots=True)
class Array:
    """Numbers, and how they are to be read. `data` is any bytes: a memoryview, a zmq.Frame, a numpy array."""

    dtype: str
    shape: tuple[int, ...]
    data: Any = field(repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.dtype, str) or self.dtype not in DTYPES:
            raise MessageError("bad-dtype", f"dtype {self.dtype!a:.40} is none of {', '.join(DTYPES)}")
        if not is_shape(self.shape):
            what = f"at most 8 whole numbers from 0, of at most {LIMIT} items"
            raise MessageError("bad-shape", f"a shape is {what}, not {self.shape!a:.40}")
        try:
            view = memoryview(self.data)
        except (TypeError, ValueError):
            raise MessageError("wrong-type", f"an array's data is bytes, not {self.data!a:.40}") from None
        size = math.prod(self.shape) * DTYPES[self.dtype]
        if size != view.nbytes:
            raise MessageError("bad-shape", f"{self.dtype} {self.shape} is {size} contiguous bytes, not {view.nbytes}")
        items = view.format.lstrip("@=<")
        if items not in "Bc" and (items not in FORMATS[self.dtype] or view.itemsize != DTYPES[self.dtype]):
            cure = f"numpy's astype('{self.dtype}') makes it so"
            raise MessageError("bad-dtype", f"the data is no {self.dtype}, but of format '{view.format:.20}'; {cure}")
        if not view.c_contiguous:
            cure = "the data has gaps: numpy.ascontiguousarray makes it whole"
            raise MessageError("bad-shape", f"{self.dtype} {self.shape} is {size} contiguous bytes; {cure}")

    @classmethod
    def of(cls, numbers: Any) -> "Array":
        """A numpy array as it is: MessageError, with the cure, for a dtype or a byte order that no message has.

        One with gaps, such as a picture turned over, is copied; of any other the memory itself is sent.
        """
        dtype: Any = getattr(numbers, "dtype", None)
        # Those of torch and jax have a dtype, too.
        if not hasattr(dtype, "isnative") or not hasattr(numbers, "flags"):
            raise MessageError("wrong-type", f"of takes a numpy array, not {numbers!a:.40}: numpy.asarray makes one")
        if dtype.name not in DTYPES or not dtype.isnative:
            cure = f"write array.astype('{dtype.name if dtype.name in DTYPES else 'float32'}')"
            raise MessageError(
                "bad-dtype", f"an array of {dtype!s:.40} cannot be sent, only {', '.join(DTYPES)}; {cure}"
            )
        data = numbers if numbers.flags.c_contiguous else numbers.tobytes()
        return cls(dtype.name, tuple(map(int, numbers.shape)), data)

    def numpy(self) -> Any:
        """The numbers for numpy, read-only: in the very memory that ZeroMQ received them in, which may be needed."""
        try:
            import numpy as np
        except ImportError:
            raise MessageError("no-numpy", "arrays need numpy where they are read: pip install numpy") from None
        little_endian = f"<{self.dtype[0]}{DTYPES[self.dtype]}"
        return np.ndarray(self.shape, little_endian, memoryview(self.data).toreadonly())


def is_shape(shape: Any) -> bool:
    if not isinstance(shape, (tuple, list)) or len(shape) > 8:
        return False
    items = 1
    for length in shape:
        # By its type: to Python, True is a whole number.
        if type(length) is not int or length < 0:
            return False
        # Counted also where a 0 makes nothing of them: numpy takes no larger shape.
        items *= length or 1
    return items <= LIMIT


@dataclass(slots=True)
class Message:
    """A request or a reply. `frames` refuses what the standard lacks, such as a list among the values."""

    kind: str
    id: int = 0
    values: dict[str, Any] = field(default_factory=dict)
    arrays: list[Array] = field(default_factory=list)

    def frames(self) -> list[Any]:
        """What is sent: the header, and the bytes of each array, which are not copied."""
        self.check()
        frames: list[Any] = [b""]
        listed: list[str] = []
        for array in self.arrays:
            if not isinstance(array, Array):
                raise TypeError(f"arrays takes Array(dtype, shape, data), not {type(array).__name__}")
            shape = ",".join(map(str, array.shape))
            listed.append(f'{{"dtype":"{array.dtype}","shape":[{shape}]}}')
            frames.append(array.data)
        # By hand: the encoder takes twice as long for it.
        values = ",".join([f"{quoted(name)}:{written(value)}" for name, value in self.values.items()])
        start = f'{{"kind":{quoted(self.kind)},"version":{VERSION},"id":{self.id}'
        text = f'{start},"values":{{{values}}},"arrays":[{",".join(listed)}]}}'
        frames[0] = text.encode()
        if "\\" in text:
            # It may have half a character, which no reader takes.
            header_in(frames[0])
        refuse_too_large(frames)
        return frames

    @staticmethod
    def refusal(error: Coded, id: int = 0) -> "Message":
        """The reply that says what is wrong, to the request of this id."""
        # The reply can be written, whatever is in it.
        code, text = (str(each).encode(errors="replace").decode() for each in (error.code, error.text))
        own = type(error.id) is int and 0 < error.id < EXACT
        return Message("error", error.id if own else id, {"code": code[:40], "text": text[:LONGEST_TEXT]})

    def check(self) -> None:
        """MessageError if a reader would refuse it."""
        if not isinstance(self.kind, str) or type(self.id) is not int or not isinstance(self.values, dict):
            what = "a text as its kind, a whole number as its id, and a dict of values"
            raise MessageError("wrong-type", f"a message has {what}, not {self.kind!a:.20}, {self.id!a:.20}")
        if not 0 <= self.id < EXACT:
            raise MessageError("bad-value", "'id' must be 0 to 2**53 - 1")
        for name, value in self.values.items():
            if isinstance(value, float):
                exact = -math.inf < value < math.inf
            else:
                exact = isinstance(value, str) or (isinstance(value, int) and -EXACT < value < EXACT)
            if not exact or type(name) is not str:
                if type(name) is not str or not isinstance(value, str | int | float):
                    raise MessageError("wrong-type", f"value {name!a:.40} must be text, a number, true or false")
                raise MessageError("bad-value", f"value {name!a:.40} is not finite, or too large to be exact")

    @staticmethod
    def read(frames: list[Any]) -> "Message":
        """The message in these frames, whose payloads are not copied; MessageError says what is wrong with them."""
        if not frames:
            raise MessageError("bad-frames", "a message has at least one frame, its header")
        refuse_too_large(frames)
        header = header_in(frames[0])
        try:
            return read_fields(header, frames[1:])
        except MessageError as error:
            id = header.get("id") if type(header) is dict else None
            if type(id) is int and 0 <= id < EXACT:
                error.id = id
            raise

    @staticmethod
    def read_reply(frames: list[Any]) -> "Message":
        """The same for a reply: one of kind `error` is raised as Refused, with its code, its text and its id."""
        reply = Message.read(frames)
        if reply.kind == "error":
            code, text = (str(reply.values.get(name, "not said")) for name in ("code", "text"))
            raise Refused(code, text, reply.id)
        return reply


def refuse_too_large(frames: list[Any]) -> None:
    try:
        header, *arrays = [memoryview(frame).nbytes for frame in frames]
    except TypeError as error:
        raise MessageError("bad-frames", f"the frames of a message are bytes: {error!s:.80}") from None
    if header > HEADER_LIMIT or sum(arrays) > LIMIT:
        raise MessageError("too-big", f"a header has at most {HEADER_LIMIT} bytes, all arrays together {LIMIT}")


def header_in(frame: Any) -> Any:
    try:
        return parsed(frame)
    except ValueError as error:
        raise MessageError("bad-json", f"the header is not JSON in UTF-8: {error!s:.80}") from None


def read_fields(header: Any, payloads: list[Any]) -> Message:
    # The version comes first: another one may have other fields.
    version = take(header, "version", int)
    if version != VERSION:
        raise MessageError("bad-version", f"version {version!s:.9}, here {VERSION}: are both sides of one release?")
    message = Message(take(header, "kind", str), take(header, "id", int), take(header, "values", dict), [])
    message.check()
    arrays = take(header, "arrays", list)
    if len(arrays) != len(payloads):
        raise MessageError("bad-frames", f"the header lists {len(arrays)} arrays, but {len(payloads)} frames follow it")
    message.arrays.extend(map(read_array, arrays, payloads))
    return message


def read_array(listed: Any, payload: Any) -> Array:
    return Array(take(listed, "dtype", str), tuple(take(listed, "shape", list)), payload)


def take(where: Any, name: str, kind: type) -> Any:
    """The field of this name and type; MessageError says what is wrong with it."""
    if type(where) is not dict:
        raise MessageError("wrong-type", f"expected an object with '{name}'")
    value = where.get(name)
    # Not isinstance: to Python, True is a whole number.
    if type(value) is kind:
        return value
    if name in where:
        raise MessageError("wrong-type", f"'{name}' must be {kind.__name__}")
    raise MessageError("missing-field", f"there is no '{name}'")


def message_reply(
    answer: Callable[[Message], Message], frames: list[Any], mistake: str = "error-in-answer"
) -> tuple[Message, Message, list[Any]]:
    """A request, what `answer` makes of it, and the frames of that. MessageError becomes a reply of kind `error`.

    So does any other mistake in `answer`, with the code `mistake`, and its traceback is logged: it ends no server.
    """
    request = Message("")
    try:
        request = Message.read(frames)
        reply = answer(request)
        if not isinstance(reply, Message):
            raise MessageError(mistake, f"answer returned {reply!r:.40}: return a Message")
        # A message that cannot be written is found out here, before a part of it is on its way.
        return request, reply, reply.frames()
    except Coded as error:
        reply = Message.refusal(error, request.id)
    except BaseException as error:
        if ends_program(error):
            raise
        log.error("a mistake in answer", exc_info=error)
        reply = Message.refusal(MessageError(mistake, shown(error)), request.id)
    return request, reply, reply.frames()


# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        former = {"read": Message.read, "read_reply": Message.read_reply, "reply_to": message_reply}
        if name not in former:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from netmq_example.former import renamed

        return renamed(f"{__name__}.{name}", f"netmq_example.{former[name].__qualname__}", former[name])
