"""Levels of a store that a program fills patch by patch."""

import ctypes
from ctypes import byref, c_uint32, c_void_p

import numpy as np

from . import _handles
from . import _structures as types
from ._functions import LIBRARY, text
from ._reading import address_of, patch_vertices
from .errors import BadState, InvalidArgument


class PatchWriter:
    """Fills levels of a store patch by patch, in any order of faces, from any number of threads.
    Made by Store.patch_writer().

    Every patch of the levels must be written. `with` finishes the writer at the end of the block,
    unless an exception leaves it; then the levels are unfinished, until they are written again or
    Store.roll_back() is called.
    """

    def __init__(self, store, attributes, base_level, names, first_level, last_level, compare):
        self._attributes = attributes
        self._base_level = base_level
        array = (ctypes.c_char_p * max(1, len(names)))(*map(text, names))
        options = types.plait_patch_writer_options(
            attributes=array, attribute_count=len(names),
            first_level=types.OUTERMOST_LEVEL if first_level is None else first_level,
            last_level=types.OUTERMOST_LEVEL if last_level is None else last_level,
            compare=int(compare))
        address = c_void_p()
        LIBRARY.plait_patch_writer_open(store.address, byref(options), byref(address))
        self._writer = _handles.patch_writer(address.value)

    def write_patch(self, name, face, level, records):
        """Writes a patch at `level` with all coarser levels of the writer.

        records: all records of the patch in row order, as Store.patch() gives them: shape
        (vertices of a patch,) or (vertices of a patch, components). They become the dtype of the
        attribute if that loses no kind of number: float64 may become float32, but 1.5 no integer.
        A vertex on an edge is in two patches: the record of the face that owns the edge is kept.
        """
        self._write(LIBRARY.plait_patch_writer_write_patch, name, face, level, records)

    def write_level(self, name, face, level, records):
        """Writes only the vertices that `level` creates. records: of the whole patch, as for
        write_patch(); those of coarser vertices are not read."""
        self._write(LIBRARY.plait_patch_writer_write_level, name, face, level, records)

    def _write(self, function, name, face, level, records):
        if self._writer is None:
            raise BadState("the patch writer is closed")
        if not 0 <= face < 1 << 32:  # ctypes would take the last 32 bits
            raise InvalidArgument(f"face {face}: expected 0 and more, as in store.base.triangles")
        given = np.asarray(records)
        attribute = self._attributes.get(name)
        if attribute is not None:
            dtype, components = attribute
            if not np.can_cast(given.dtype, dtype, "same_kind"):
                raise InvalidArgument(f"'{name}': expected {dtype}, found {given.dtype}")
            count = patch_vertices(max(level - self._base_level, 0))
            shape = (count,) if components == 1 else (count, components)
            if given.shape != shape:
                raise InvalidArgument(f"'{name}' at level {level}: expected records of shape "
                                      f"{shape}, found {given.shape}")
            given = np.ascontiguousarray(given, dtype)
        function(self._writer.address, text(name), c_uint32(face), level, address_of(given),
                 given.nbytes)

    def finish(self):
        """Ends the work: the levels can be read and committed. Raises BadState if a patch is
        missing, and names it; write it, and call finish() again."""
        if self._writer is None:
            raise BadState("the patch writer is closed")
        LIBRARY.plait_patch_writer_finish(self._writer.address)
        self._writer = None

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None and self._writer is not None:
            self.finish()
        self._writer = None
