"""What went wrong, by kind. Each kind is also the exception of Python that fits it."""

import ctypes
import errno
import os
import re
from typing import Optional

from ._library import LIBRARY

LIBRARY.plait_error_message.restype = ctypes.c_char_p
LIBRARY.plait_error_path.restype = ctypes.c_char_p
LIBRARY.plait_error_offset.restype = ctypes.c_uint64
_NO_OFFSET = 2**64 - 1


class Error(Exception):
    """The library refused a call, or a call failed.

    path: the file or directory that the error is about, or None.
    offset: the byte of this file that the error is about, or None.
    Those that are an OSError also have errno, strerror and filename, as far as they are known.
    """

    _errno: Optional[int] = None

    def __init__(self, message, path=None, offset=None):
        super().__init__(message)
        self.offset = offset
        number = self._errno or _number_in(message)
        self._tell(errno=number, strerror=os.strerror(number) if number else None)
        self.about(path)

    def _tell(self, **fields):
        """Sets the fields of an OSError."""
        if issubclass(type(self), OSError):
            for name, value in fields.items():
                setattr(self, name, value)

    def about(self, path):
        """The same error, with the file or directory that it is about."""
        self.path = path
        self._tell(filename=path)
        return self

    def __str__(self):
        return str(self.args[0])

    def __reduce__(self):
        return type(self), (self.args[0], self.path, self.offset)


class NotFound(Error, FileNotFoundError):
    """A file, store, attribute or level does not exist."""

    _errno = errno.ENOENT


class NoSuchAttribute(NotFound, KeyError):
    """A store does not have the attribute."""


class NoSuchLevel(NotFound, IndexError):
    """An attribute does not have the level."""


class InvalidArgument(Error, ValueError):
    """An argument out of its range, or an input file that is refused."""


class AlreadyExists(InvalidArgument, FileExistsError):
    """A file or store that a call was to make is there already."""

    _errno = errno.EEXIST


class Damaged(Error):
    """Stored bytes are damaged: see `path` and `offset`."""


class NotSupported(Error, NotImplementedError):
    """This build or machine lacks a backend, codec or feature."""


class InputOutputError(Error, OSError):
    """The operating system refused a file operation."""


class NoSpace(InputOutputError):
    """The disk or the quota is full."""

    _errno = errno.ENOSPC


class OutOfMemory(Error, MemoryError):
    """An allocation failed."""


class TooLarge(Error, MemoryError):
    """The memory budget, or the limit that the caller set, is too small."""


class Busy(Error, BlockingIOError):
    """Somebody else has the store open, or arrays still point into it."""

    _errno = errno.EAGAIN


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


# What messages of the library call by the names of C++ or of the program, and what it is in Python.
_WORDS = [(re.compile(pattern), words) for pattern, words in (
    (r"take Store::roll_back\(\)", "call roll_back()"),
    (r"Store::add_attribute\(schema, (\d+)\)", r"add_attribute(level=\1)"),
    (r"raise the budget to (\d+) bytes", r"allow memory=\1"),
    (r"raise the budget", "allow more by memory="),
    (r"end pins or views", "read in fewer threads at once, delete arrays without a copy"),
    (r" \(--plugin FILE, PLAIT_PLUGINS\)", " (plait.load_plugin)"),
    (r"open it with writable = 1|open it for writing", "open it for writing, by writable=True"),
)]
_EXISTS = re.compile("create (.+): it exists")
_SYSTEM = {os.strerror(number): number for number in errno.errorcode}


def _number_in(message):
    """The number of the system's error whose text ends the message."""
    return _SYSTEM.get(message.rpartition(": ")[2].rstrip("."))


def in_words(message):
    """A message of the library in the words of Python."""
    if message.startswith("plait_"):  # the function of C, which tells a program in Python nothing
        message = message.partition(": ")[2]
    for pattern, words in _WORDS:
        message = pattern.sub(words, message)
    return message


def of_status(status):
    """The exception for the last call of this thread, which returned `status`."""
    message = in_words(LIBRARY.plait_error_message().decode(errors="replace"))
    path = LIBRARY.plait_error_path().decode(errors="surrogateescape")
    offset = LIBRARY.plait_error_offset()
    kind = KINDS.get(status, Error)
    there = _EXISTS.match(message)
    if kind is InvalidArgument and there:
        kind, path = AlreadyExists, path or there.group(1)
    return kind(message, path or None, None if offset == _NO_OFFSET else offset)
