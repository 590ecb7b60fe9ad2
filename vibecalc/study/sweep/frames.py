"""Messages between a sweep and the processes that work for it: pickles, each with its length."""

import pickle
import struct
from typing import IO, Any

_LENGTH = struct.Struct(">Q")


def send(stream: IO[bytes], message: Any) -> None:
    """Write one message; OSError if nobody reads any more."""
    content = message if isinstance(message, bytes) else packed(message)
    stream.write(_LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Read one message; EOFError at the end, also in the middle of a message."""
    (length,) = _LENGTH.unpack(_exactly(stream, _LENGTH.size))
    return pickle.loads(_exactly(stream, length))


def packed(message: Any) -> bytes:
    """A message as bytes, for one that is sent several times."""
    return pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)


def _exactly(stream: IO[bytes], length: int) -> bytes:
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return content
