"""Owners of what the library opens. The last reference ends it, so no call meets a freed object:
a call holds a reference to the owner of the handle that it passes on."""

from ._functions import LIBRARY


class Handle:
    """Owns a handle of the library."""

    __slots__ = ("address", "_end", "__weakref__")

    def __init__(self, address, end):
        self.address = address
        self._end = end

    def __del__(self):
        self._end(self.address)


def store(address):
    return Handle(address, LIBRARY.plait_store_release)


def reader(address):
    return Handle(address, LIBRARY.plait_reader_close)


def patch_writer(address):
    return Handle(address, LIBRARY.plait_patch_writer_close)


class Pinned:
    """Records that stay at their addresses in memory while an array points to them. numpy takes
    this object as the base of the array, and so keeps it."""

    __slots__ = ("_pin", "__array_interface__")

    def __init__(self, pin, address, dtype, shape):
        self._pin = Handle(pin, LIBRARY.plait_pin_release)
        self.__array_interface__ = {
            "version": 3, "data": (address, True), "typestr": dtype.str, "shape": shape}
