"""Reads of one attribute of a store, each one call of the library."""

import ctypes
import operator
from ctypes import byref, c_uint32, c_uint64, c_void_p

import numpy as np

from . import _handles, _records
from . import _structures as types
from ._functions import LIBRARY, text
from .errors import InvalidArgument, NotSupported


def patch_vertices(refinements):
    """Vertices of a patch whose sides have 2**refinements steps."""
    size = 1 << refinements
    return (size + 1) * (size + 2) // 2


def frozen(array):
    """The array, read-only."""
    array.setflags(write=False)
    return array


def address_of(array):
    """Where the array is in memory."""
    return array.ctypes.data


def whole(what, value):
    """A whole number."""
    try:
        return operator.index(value)
    except TypeError:
        raise InvalidArgument(f"{what}: expected a whole number, found {value!r}") from None


def face_list(faces):
    """Faces as the library takes them: a read-only array of its own."""
    given = _records.unmasked("faces", faces)
    if given.size == 0:
        return frozen(np.empty(0, np.uint32))
    if given.dtype.kind not in "iu" or given.ndim != 1:
        raise InvalidArgument(
            f"faces: expected a list of whole numbers, found {given.dtype} of shape {given.shape}")
    if given.min() < 0 or given.max() >= 1 << 32:
        raise InvalidArgument(f"faces: expected 0 and more, found {given.min()} to {given.max()}")
    return frozen(np.array(given, np.uint32))


def three_numbers(what, values):
    """A point or a direction for the library."""
    values = np.asarray(_records.unmasked(what, values), np.float64)
    if values.shape != (3,):
        raise InvalidArgument(f"{what}: expected 3 numbers, found shape {values.shape}")
    return (ctypes.c_double * 3)(*values)


def corners(box):
    """The two points of a box."""
    try:
        low, high = box
    except (TypeError, ValueError):
        raise InvalidArgument(f"box: expected (low, high), two points, found {box!r}") from None
    return low, high


# The functions that programs call often.
_read_vertices = LIBRARY.plait_reader_read_vertices
_copy_patches = LIBRARY.plait_reader_copy_patches
_PAGE_BYTES = 4096
_LARGE_BYTES = 4 << 20


class AttributeReader:
    """Reads one attribute. Any number of threads may use it at the same time."""

    def __init__(self, store, info, base_level, pins):
        self.name = info.name.decode()
        self._name = info.name
        self.base_level = base_level
        self.finest_level = info.finest_level
        self.dtype = np.dtype(types.TYPES[info.type])
        self.components = info.components
        self.record_bytes = info.record_bytes
        names = (ctypes.c_char_p * 1)(info.name)
        options = types.plait_reader_options(attributes=names, attribute_count=1)
        address = c_void_p()
        store.call(LIBRARY.plait_reader_open, byref(options), byref(address))
        self._reader = _handles.reader(address.value)
        self._pins = pins
        self._has_addresses = None
        self._of_record = () if info.components == 1 else (info.components,)
        self._counts = {}
        self._starts = {}

    def end(self):
        """Ends the reader. Arrays that it returned stay valid."""
        self._reader.end()

    def shape(self, count):
        """The shape of `count` records."""
        return (count,) + self._of_record

    def vertex_count(self, level):
        """Vertices that the level creates."""
        count = self._counts.get(level)
        if count is None:
            found = c_uint64()
            self._reader.call(LIBRARY.plait_reader_vertex_count, level, byref(found))
            count = self._counts[level] = found.value
        return count

    def block_starts(self, level):
        """The first vertex of each block."""
        count = c_uint64()
        self._reader.call(LIBRARY.plait_reader_get_blocks, self._name, level, None, 0,
                                        byref(count))
        firsts = np.empty(count.value, np.uint64)
        self._reader.call(LIBRARY.plait_reader_get_blocks, self._name, level,
                                        firsts.ctypes.data, count.value, byref(count))
        return firsts.astype(np.int64)

    def vertices(self, level, first, count):
        """Records of vertices that a level creates. No copy if they lie in memory in one piece."""
        if self._has_addresses is not False and count > 0:
            pinned = self._pinned(level, first, count)
            if pinned is not None:
                return pinned
        size = count * self.record_bytes
        if size < _LARGE_BYTES:
            records = np.empty((count,) + self._of_record, self.dtype)
        else:
            records = self._beside_block(level, first, count)
        self._reader.call(_read_vertices, self._name, level, first, count, address_of(records),
                       size)
        return frozen(records)

    def _beside_block(self, level, first, count):
        """An array for these records, at the place in a page that they have in their block. A copy to
        a place a few bytes further takes twice the time: the processor takes loads for dependent on
        stores whose addresses have the same last twelve bits."""
        starts = self._starts.get(level)
        if starts is None:
            starts = self._starts[level] = self.block_starts(level)
        start = int(starts[np.searchsorted(starts, first, "right") - 1])
        room = np.empty(count * self.record_bytes + _PAGE_BYTES, np.uint8)
        ahead = ((first - start) * self.record_bytes - room.ctypes.data) % _PAGE_BYTES
        return room[ahead:ahead + count * self.record_bytes].view(self.dtype).reshape(
            self.shape(count))

    def _pinned(self, level, first, count):
        pin, address, found = c_void_p(), c_void_p(), c_uint64()
        try:
            self._reader.call(LIBRARY.plait_reader_pin_vertices, self._name, level, first, count,
                                              byref(pin), byref(address), byref(found))
        except NotSupported:
            self._has_addresses = False
            return None
        self._has_addresses = True
        owner = _handles.Pinned(pin.value, address.value, self.dtype, self.shape(found.value),
                                self._pins)
        return np.asarray(owner) if found.value == count else None

    def patch(self, face, level):
        """The records of one patch in row order."""
        if not 0 <= face < 1 << 32:  # ctypes would take the last 32 bits
            raise InvalidArgument(f"face {face}: expected 0 and more, as in store.base.triangles")
        count = patch_vertices(level - self.base_level)
        records = np.empty((count,) + self._of_record, self.dtype)
        self._reader.call(_copy_patches, self._name, byref(c_uint32(face)), 1, level,
                      address_of(records), count * self.record_bytes)
        return frozen(records)

    def patches(self, faces, level):
        """The records of many patches, in an array that can be written to."""
        count = patch_vertices(level - self.base_level)
        records = np.empty((len(faces),) + self.shape(count), self.dtype)
        self._reader.call(_copy_patches, self._name, address_of(faces), len(faces), level,
                      address_of(records), records.nbytes)
        return records

    def weld(self, faces, level):
        """The number of each point of each patch, and how many vertices there are."""
        numbers = np.empty((len(faces), patch_vertices(level - self.base_level)), np.uint32)
        count = c_uint64()
        self._reader.call(LIBRARY.plait_reader_weld_patches, faces.ctypes.data, len(faces), level,
                                          numbers.ctypes.data, numbers.size, byref(count))
        return numbers, count.value

    def triangles(self, level):
        """The triangles of a patch: places in row order."""
        count = 1 << 2 * (level - self.base_level)
        indices = np.empty((count, 3), np.uint32)
        found = c_uint64()
        self._reader.call(LIBRARY.plait_reader_patch_indices, level, indices.ctypes.data, count,
                                           byref(found))
        return frozen(indices)

    def faces_in_box(self, low, high, face_count):
        """The faces whose bounds meet the box, ascending."""
        faces = np.empty(face_count, np.uint32)
        found = c_uint64()
        self._reader.call(LIBRARY.plait_reader_faces_in_box, self._name, low, high,
                                          faces.ctypes.data, face_count, byref(found))
        return frozen(faces[:found.value].copy())

    def faces_along_ray(self, origin, direction, face_count):
        """The faces whose bounds the ray meets, the nearest first, and the distances."""
        faces, distances = np.empty(face_count, np.uint32), np.empty(face_count, np.float64)
        found = c_uint64()
        self._reader.call(LIBRARY.plait_reader_faces_along_ray, self._name, origin, direction,
                                             faces.ctypes.data, distances.ctypes.data, face_count,
                                             byref(found))
        return frozen(faces[:found.value].copy()), frozen(distances[:found.value].copy())

    def prefetch(self, faces, level):
        """Begins to read patches, and returns how many are in memory or on their way."""
        begun = c_uint64()
        self._reader.call(LIBRARY.plait_reader_prefetch, faces.ctypes.data, len(faces), level,
                          byref(begun))
        return begun.value

    def end_prefetch(self):
        """Nobody will read the patches that were not read since."""
        self._reader.call(LIBRARY.plait_reader_end_prefetch)
