"""Levels of a store that a program fills patch by patch."""

import ctypes
from ctypes import byref, c_uint32, c_void_p

import numpy as np

from . import _handles, _records
from . import _structures as types
from ._functions import LIBRARY, text
from ._reading import address_of, patch_vertices, whole
from .errors import BadState, InvalidArgument


class PatchWriter:
    """Fills levels of a store patch by patch, in any order of faces, from any number of threads.
    Made by Store.patch_writer().

    Every patch of the levels must be written. `with` finishes the writer at the end of the block,
    unless an exception leaves it; then the levels are unfinished, until they are written again or
    Store.roll_back() is called.
    """

    def __init__(self, change, attributes, base_level, names, first_level, last_level, compare):
        self._attributes = attributes
        self._base_level = base_level
        array = (ctypes.c_char_p * max(1, len(names)))(*map(text, names))
        options = types.plait_patch_writer_options(
            attributes=array, attribute_count=len(names),
            first_level=types.OUTERMOST_LEVEL if first_level is None else first_level,
            last_level=types.OUTERMOST_LEVEL if last_level is None else last_level,
            compare=int(compare))
        address = c_void_p()
        change(LIBRARY.plait_patch_writer_open, byref(options), byref(address))
        self._writer = _handles.patch_writer(address.value)

    def write_patch(self, name, face, level, records):
        """Writes a patch at `level` with all coarser levels of the writer.

        records: all records of the patch in row order, as Store.patch() gives them: shape
        (vertices of a patch,) or (vertices of a patch, components). They become the dtype of the
        attribute if that loses no kind of number: float64 may become float32, but 1.5 no integer;
        a whole number that the dtype does not have is refused.
        A vertex on an edge is in two patches: the record of the face that owns the edge is kept.
        """
        self._write(LIBRARY.plait_patch_writer_write_patch, name, face, level, records)

    def write_level(self, name, face, level, records):
        """Writes only the vertices that `level` creates. records: of the whole patch, as for
        write_patch(); those of coarser vertices are not read."""
        self._write(LIBRARY.plait_patch_writer_write_level, name, face, level, records)

    def _write(self, function, name, face, level, records):
        writer = self._open()
        face, level = whole("face", face), whole("level", level)
        if not 0 <= face < 1 << 32:  # ctypes would take the last 32 bits
            raise InvalidArgument(f"face {face}: expected 0 and more, as in store.base.triangles")
        given = _records.unmasked(f"'{name}'", records)
        attribute = self._attributes.get(name)
        if attribute is not None:
            dtype, components = attribute
            given = _records.fitted(f"'{name}'", given, dtype)
            count = patch_vertices(max(level - self._base_level, 0))
            shape = (count,) if components == 1 else (count, components)
            if given.shape != shape:
                raise InvalidArgument(f"'{name}' at level {level}: expected records of shape "
                                      f"{shape}, found {given.shape}")
            given = np.ascontiguousarray(given, dtype)
        writer.call(function, text(name), c_uint32(face), level, address_of(given),
                    given.nbytes)

    def finish(self):
        """Ends the work: the levels can be read and committed. Raises BadState if a patch is
        missing, and names it; write it, and call finish() again."""
        self._open().call(LIBRARY.plait_patch_writer_finish)
        self._end()

    def _open(self):
        if self._writer is None:
            raise BadState("the patch writer is closed")
        return self._writer

    def _end(self):
        writer, self._writer = self._writer, None
        if writer is not None:
            writer.end()

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None and self._writer is not None:
            self.finish()
        self._end()
