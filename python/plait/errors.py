"""What went wrong, by kind. Each kind is also the exception of Python that fits it."""

from ._library import LIBRARY
import ctypes

LIBRARY.plait_error_message.restype = ctypes.c_char_p
LIBRARY.plait_error_path.restype = ctypes.c_char_p
LIBRARY.plait_error_offset.restype = ctypes.c_uint64
_NO_OFFSET = 2**64 - 1


class Error(Exception):
    """The library refused a call, or a call failed.

    path: the file or directory that the error is about, or None.
    offset: the byte of this file that the error is about, or None.
    """

    def __init__(self, message, path=None, offset=None):
        super().__init__(message)
        self.path = path
        self.offset = offset

    def __str__(self):
        return str(self.args[0])

    def __reduce__(self):
        return type(self), (self.args[0], self.path, self.offset)


class NotFound(Error, FileNotFoundError):
    """A file, store, attribute or level does not exist."""


class NoSuchAttribute(NotFound, KeyError):
    """A store does not have the attribute."""


class InvalidArgument(Error, ValueError):
    """An argument out of its range, or an input file that is refused."""


class Damaged(Error):
    """Stored bytes are damaged: see `path` and `offset`."""


class NotSupported(Error, NotImplementedError):
    """This build or machine lacks a backend, codec or feature."""


class InputOutputError(Error, OSError):
    """The operating system refused a file operation."""


class NoSpace(InputOutputError):
    """The disk or the quota is full."""


class OutOfMemory(Error, MemoryError):
    """An allocation failed."""


class TooLarge(Error, MemoryError):
    """The memory budget, or the limit that the caller set, is too small."""


class Busy(Error, BlockingIOError):
    """Somebody else has the store open, or arrays still point into it."""


class BadState(Error, RuntimeError):
    """A call that the state of the store forbids, such as one in a forked process."""


class Cancelled(Error):
    """A callback cancelled the work."""


class InternalError(Error):
    """A mistake in the library."""


KINDS = {
    1: NotFound,
    2: InvalidArgument,
    3: Damaged,
    4: NotSupported,
    5: InputOutputError,
    6: NoSpace,
    7: OutOfMemory,
    8: TooLarge,
    9: Busy,
    10: BadState,
    11: Cancelled,
    12: InternalError,
}


def of_status(status):
    """The exception for the last call of this thread, which returned `status`."""
    message = LIBRARY.plait_error_message().decode(errors="replace")
    if message.startswith("plait_"):  # the function of C, which tells a program in Python nothing
        message = message.partition(": ")[2]
    path = LIBRARY.plait_error_path().decode(errors="surrogateescape")
    offset = LIBRARY.plait_error_offset()
    kind = KINDS.get(status, Error)
    return kind(message, path or None, None if offset == _NO_OFFSET else offset)
