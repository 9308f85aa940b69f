"""Texts of a store, attributes of its base faces, and records of its base vertices."""

import ctypes
from ctypes import byref, c_char_p, c_uint32, c_uint64, c_void_p

import numpy as np

from . import _records
from . import _structures as types
from ._functions import LIBRARY, text
from ._reading import frozen
from .errors import InvalidArgument, NotFound

_NUMBERS = {name: number for number, name in types.TYPES.items()}
_INTEGERS = ("|u1", "<u2", "<u4", "<u8", "|i1", "<i2", "<i4", "<i8")


def texts(store):
    """All texts by name."""
    found, value = {}, c_char_p()
    try:
        while True:
            store.call(LIBRARY.plait_store_get_text_name, c_uint32(len(found)), byref(value))
            name = value.value
            store.call(LIBRARY.plait_store_get_text, name, byref(value))
            found[name.decode()] = value.value.decode(errors="replace")
    except NotFound:
        return found


class Snapshot(dict):
    """What a property of a store made anew: a change of it would be lost, so it takes none. dict() makes
    one that does."""

    def __init__(self, entries, way):
        super().__init__(entries)
        self._way = way

    def _refuse(self):
        raise TypeError(f"this dict is a copy, and the store would not hear of a change: {self._way}")

    def __setitem__(self, key, value):
        self._refuse()

    def __delitem__(self, key):
        self._refuse()

    def update(self, *args, **kwargs):
        self._refuse()

    def setdefault(self, key, default=None, /):
        self._refuse()

    def pop(self, key, *default):
        self._refuse()

    def clear(self):
        self._refuse()

    def __reduce__(self):
        return dict, (dict(self),)


def _face_types(store):
    """The dtype of each attribute of faces."""
    found, info = {}, types.plait_attribute_info()
    try:
        while True:
            store.call(LIBRARY.plait_store_get_face_attribute, c_uint32(len(found)), byref(info))
            found[info.name.decode()] = np.dtype(types.TYPES[info.type])
    except NotFound:
        return found


def face_attributes(store, face_count):
    """Copies of all attributes of faces."""
    from .visits import copied
    arrays = {}
    for name, dtype in _face_types(store).items():
        address = c_void_p()
        store.call(LIBRARY.plait_store_get_face_records, text(name), byref(address), None)
        arrays[name] = frozen(copied(address.value, (face_count,), dtype))
    return arrays


def _smallest(given):
    """The smallest dtype of a store that has these numbers."""
    if given.dtype.kind == "f":
        return np.dtype("<f4" if given.dtype.itemsize <= 4 else "<f8")
    low, high = (int(given.min()), int(given.max())) if given.dtype.kind in "iu" else (0, 1)
    return np.dtype(next(each for each in _INTEGERS
                         if np.iinfo(each).min <= low and high <= np.iinfo(each).max))


def set_face_attribute(store, name, numbers, dtype):
    """Fills an attribute of faces; adds it if the store does not have it."""
    given = _records.unmasked(f"'{name}'", numbers)
    count = len(store.base.triangles)
    if given.shape != (count,):
        raise InvalidArgument(f"'{name}': expected a number for each of {count} faces, found shape "
                              f"{given.shape}")
    there = _face_types(store._store()).get(name)
    if dtype is not None:
        wanted = np.dtype(_records.type_name(dtype, _NUMBERS))
    elif there is not None:
        wanted = there
    else:
        wanted = _smallest(given)
    records = np.ascontiguousarray(_records.fitted(f"'{name}'", given, wanted))
    if there is not None and there != wanted:
        raise InvalidArgument(f"'{name}': expected {there}, the dtype that it has, found {wanted}: "
                              "remove_face_attribute() first")
    if there is None:
        store._change(LIBRARY.plait_store_add_face_attribute, text(name), _NUMBERS[wanted.str])
    address = c_void_p()
    store._change(LIBRARY.plait_store_edit_face_records, text(name), byref(address), None)
    ctypes.memmove(address.value, records.ctypes.data, records.nbytes)


def set_base_records(change, info, records):
    """Writes the records of the base vertices."""
    name, dtype = info.name.decode(), np.dtype(types.TYPES[info.type])
    components = info.components
    given = np.ascontiguousarray(_records.fitted(f"'{name}'", records, dtype))
    address, count = c_void_p(), c_uint64()
    change(LIBRARY.plait_store_edit_base_records, text(name), byref(address), byref(count))
    shape = (count.value,) if components == 1 else (count.value, components)
    if given.shape != shape:
        raise InvalidArgument(f"'{name}': expected base records of shape {shape}, found {given.shape}")
    ctypes.memmove(address.value, given.ctypes.data, given.nbytes)
