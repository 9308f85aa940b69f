"""Stores that are made of arrays."""

import os
import warnings
from ctypes import byref, c_void_p

import numpy as np

from . import _functions, _handles, _memory, _records
from . import _structures as types
from ._functions import LIBRARY, text
from ._progress import Watch
from .errors import InvalidArgument
from .store import Store


def create(vertices, faces, path=None, backend=None, dtype=None, layout="given", pipeline=None,
           block_bytes=None, memory=types.DEFAULT_BUDGET_BYTES, base_level=0,
           warn=None):
    """Makes a store from arrays, and opens it for writing.

    vertices: shape (vertices, 3), positions. faces: shape (triangles, 3), whole numbers,
    counterclockwise. The mesh must be an oriented 2-manifold, with or without border. The store
    drops vertices that no triangle uses, and warns of that.
    path: a directory that does not exist; None: only in memory. With a path, the store is committed.
    dtype: float32 or float64, of the attribute "position"; None: float32, or float64 with a warning if
    float32 would move a vertex by more than a thousandth of the shortest edge there, or is too coarse
    for three levels below base_level.
    layout: "given": face f of yours is patch f; "auto", which None also means, or another layout puts faces that are near each
    other beside each other, so that boxes of a large store are fast to read: store.input then tells
    where each face is. base_level: so often the mesh is refined in memory, which makes four patches of
    each face; store.input tells which.
    backend: None: "memory" without a path, else the library chooses. pipeline: of compression.
    block_bytes: unit of I/O, a power of two; None: 64 KiB, or 256 KiB with compression. memory: the most memory for blocks; a number or a text such as "64MiB".
    warn: a function of a text, told what was changed in the mesh; None: Python warns.
    """
    vertices, rounded = _records.positions("vertices", vertices)
    given = _records.unmasked("faces", faces)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InvalidArgument(f"vertices: expected shape (n, 3), found {vertices.shape}")
    if given.ndim != 2 or given.shape[1] != 3 or given.dtype.kind not in "iu":
        raise InvalidArgument(
            f"faces: expected whole numbers of shape (n, 3), found {given.dtype} of {given.shape}")
    if given.size and (given.min() < 0 or given.max() >= len(vertices)):
        raise InvalidArgument(f"faces: expected vertices 0 to {len(vertices) - 1}, found "
                              f"{given.min()} to {given.max()}")
    faces = np.ascontiguousarray(given, np.uint32)
    position = types.AUTOMATIC_POSITIONS if dtype is None else {
        "<f4": types.FLOAT32, "<f8": types.FLOAT64}.get(np.dtype(dtype).newbyteorder("<").str)
    if position is None:
        raise InvalidArgument(f"dtype: expected float32 or float64, found {np.dtype(dtype)}")
    if rounded:
        words = (f"vertices: float64 rounds coordinates of {rounded} of {len(vertices)} vertices; "
                 "subtract an origin first")
        warnings.warn(words, stacklevel=2) if warn is None else warn(words)
    if path is None and backend is None:
        backend = "memory"
    store = None
    try:
        with Watch("create") as watch:
            options = types.plait_store_options(
                backend=text(backend), pipeline=text(pipeline), layout=text(layout),
                block_bytes=0 if block_bytes is None else _memory.bytes_of(block_bytes), budget_bytes=_memory.bytes_of(memory),
                warn=watch.warning(warn), base_level=base_level, io_threads=types.AUTOMATIC_THREADS,
                position_type=position, durability=0)
            address = c_void_p()
            LIBRARY.plait_store_create(b"" if path is None else _functions.path(path),
                                       vertices.ctypes.data, len(vertices), faces.ctypes.data,
                                       len(faces), byref(options), byref(address))
            store = Store(_handles.store(address.value), "" if path is None else os.fsdecode(path),
                          options.budget_bytes)
        if path is not None:
            store.commit()
        return store
    except BaseException:  # what warn() raises comes when there is a store already
        if store is not None:
            store._close(warns=False)  # removes the directory, which has no commit
        raise
