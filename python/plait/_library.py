"""Finds and loads libplait, and checks that it fits this package."""

import ctypes
import os
import pathlib

NAME = "libplait.so.0"
INTERFACE = 1  # the PLAIT_ABI_VERSION that this package was written for


def _candidates():
    """Where the library may be: what the user names, then beside this package, then the system's."""
    named = os.environ.get("PLAIT_LIBRARY")
    if named:
        yield named
        return
    for folder in (pathlib.Path(__file__).parent, pathlib.Path(__file__).parent.parent / "plait.libs"):
        yield from (str(path) for path in sorted(folder.glob("libplait*.so*")))
    yield NAME


def load():
    """Loads the library. It hides its symbols, so that it may stand beside another TBB or zstd."""
    failures = []
    for candidate in _candidates():
        try:
            library = ctypes.CDLL(candidate)
        except OSError as error:
            failures.append(f"{candidate}: {error}")
            continue
        library.plait_abi_version.restype = ctypes.c_uint32
        found = library.plait_abi_version()
        if found < INTERFACE:
            raise ImportError(
                f"{candidate}: expected interface version {INTERFACE} or newer, found {found}")
        return library
    raise ImportError(
        "libplait was not found; set PLAIT_LIBRARY to the file, or install the package libplait0: "
        + "; ".join(failures))


LIBRARY = load()
