"""Sizes in bytes as the program writes them, and limits in words."""

from .errors import InvalidArgument, TooLarge

DEFAULT_LIMIT = 1 << 30
_UNITS = {"": 1, "B": 1, "K": 1 << 10, "KIB": 1 << 10, "M": 1 << 20, "MIB": 1 << 20,
          "G": 1 << 30, "GIB": 1 << 30}


def bytes_of(size):
    """The bytes of a size: a number, or a text such as "64MiB"."""
    try:
        if isinstance(size, str):
            digits = size.rstrip("BbGgIiKkMm ")
            size_bytes = int(float(digits) * _UNITS[size[len(digits):].strip().upper()])
        else:
            size_bytes = int(size)
        if 0 <= size_bytes < 1 << 64:
            return size_bytes
    except (KeyError, OverflowError, ValueError):
        pass
    raise InvalidArgument(
        f"size: expected bytes, or a number with KiB, MiB or GiB, found {size!r}")


def words(size):
    """A number of bytes for people."""
    for unit in ("bytes", "KiB", "MiB"):
        if size < 1024:
            return f"{size:.4g} {unit}"
        size /= 1024
    return f"{size:.4g} GiB"


def check(what, needed, limit, way_out):
    """Refuses what needs more memory than the caller allows."""
    limit = bytes_of(limit)
    if needed > limit:
        raise TooLarge(f"{what}: needs {words(needed)} of memory, the limit is {words(limit)}: "
                       f"{way_out}, or allow more by memory=")
