"""Owners of what the library opens. A call counts while it runs, so a handle that is ended meanwhile
goes when its last call has returned: no call meets a freed object. A frame or a traceback that still
refers to an owner keeps nothing open."""

from ._functions import LIBRARY
from .errors import BadState


class Handle:
    """Owns a handle of the library.

    address: where it is; None once it was ended.
    """

    __slots__ = ("address", "_owned", "_calls", "_end", "__weakref__")

    def __init__(self, address, end):
        self.address = address
        self._owned = [address]  # for the one who frees it
        self._calls = []
        self._end = end

    def call(self, function, *arguments):
        """Calls a function of the library that takes the handle first."""
        self._calls.append(None)  # append and pop are atomic
        try:
            address = self.address
            if address is None:
                raise BadState("the store was closed or changed while another thread used it")
            return function(address, *arguments)
        finally:
            self._calls.pop()
            if self.address is None:
                self._free_if_unused()

    def end(self):
        """Ends the handle: now, or when the calls that run have returned."""
        self.address = None
        self._free_if_unused()

    def _free_if_unused(self):
        if not self._calls:
            try:
                address = self._owned.pop()
            except IndexError:
                return
            self._end(address)

    def __del__(self):
        self.end()


def store(address):
    return Handle(address, LIBRARY.plait_store_release)


def reader(address):
    return Handle(address, LIBRARY.plait_reader_close)


def patch_writer(address):
    return Handle(address, LIBRARY.plait_patch_writer_close)


class Pinned:
    """Records that stay at their addresses in memory while an array points to them. numpy takes
    this object as the base of the array, and so keeps it. `pins` has one entry for each of them."""

    __slots__ = ("_pin", "_pins", "__array_interface__")

    def __init__(self, pin, address, dtype, shape, pins):
        self._pin = Handle(pin, LIBRARY.plait_pin_release)
        self._pins = pins
        pins.append(None)
        self.__array_interface__ = {
            "version": 3, "data": (address, True), "typestr": dtype.str, "shape": shape}

    def __del__(self):
        self._pin.end()
        self._pins.pop()
