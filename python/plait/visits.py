"""Own computations on every vertex of a store."""

import ctypes

import numpy as np

from . import _structures as types
from ._functions import LIBRARY, text
from ._progress import Watch
from .errors import InvalidArgument, NoSuchAttribute


class Vertices:
    """What a visit gives to its function: vertices with equally many neighbours.

    vertices["position"] has the records of an attribute, shape (count,) or (count, components).
    Those of attributes that the visit reads are read-only. The function fills those that it writes;
    they are zeros at first, or the old records if the visit also reads the attribute.

    levels: shape (count,): the level that creates each vertex.
    places: shape (count,): its number among the vertices of its level, as in store[name][level].
    valence: neighbours of each vertex, 0 if the visit reads no rings.
    border: whether the vertices are on a border of the surface.
    base: whether they are base vertices.
    """

    def __init__(self, batch, visited):
        count = batch.count
        self.valence = batch.valence
        self.border = bool(batch.border)
        self.base = bool(batch.base)
        self.levels = _copied(batch.levels, (count,), np.dtype("<i4"))
        self.places = _copied(batch.places, (count,), np.dtype("<u8"))
        self._records = {}
        self._neighbours = {}
        for number, each in enumerate(visited):
            given = batch.attributes[number]
            tail = () if each.components == 1 else (each.components,)
            records = _copied(given.records, (count,) + tail, each.dtype)
            records.flags.writeable = each.access != types.ACCESS_READ
            self._records[each.name] = records
            if given.neighbours:
                around = _copied(given.neighbours, (count, batch.valence) + tail, each.dtype)
                around.flags.writeable = False
                self._neighbours[each.name] = around

    def __len__(self):
        return len(self.levels)

    def __getitem__(self, name):
        try:
            return self._records[name]
        except KeyError:
            raise NoSuchAttribute(f"the visit neither reads nor writes '{name}'") from None

    def __setitem__(self, name, records):
        self[name][...] = records

    def neighbours(self, name):
        """The records of the neighbours at the finest level, counterclockwise: shape (count,
        valence) or (count, valence, components). On a border the first and the last one are on the
        border, too. Inside, the base mesh alone decides which one is the first."""
        try:
            return self._neighbours[name]
        except KeyError:
            raise NoSuchAttribute(f"the visit reads no rings of '{name}': it needs rings=True, and "
                                  "the attribute in reads") from None


class _Visited:
    def __init__(self, reader, access, rings):
        self.name = reader.name
        self.dtype, self.components = reader.dtype, reader.components
        self.access, self.rings = access, rings


def _address(pointer):
    return pointer if isinstance(pointer, int) else ctypes.cast(pointer, ctypes.c_void_p).value


def _copied(pointer, shape, dtype):
    """A copy that outlives the call."""
    array = np.empty(shape, dtype)
    ctypes.memmove(array.ctypes.data, _address(pointer), array.nbytes)
    return array


def _names(names):
    return [names] if isinstance(names, str) else list(names)


def visited_attributes(reader_of, reads, writes, rings):
    """What the visit does with each attribute."""
    reads, writes = _names(reads), _names(writes)
    with_rings = [] if rings is False else reads if rings is True else _names(rings)
    for name in with_rings:
        if name in writes:
            raise InvalidArgument(
                f"visit: '{name}' is read with its rings and written: write to another attribute, "
                "and then call replace_attribute()")
        if name not in reads:
            raise InvalidArgument(f"visit: rings of '{name}', which is not in reads")
    visited = [_Visited(reader_of(name),
                        types.ACCESS_UPDATE if name in writes else types.ACCESS_READ,
                        name in with_rings) for name in reads]
    visited += [_Visited(reader_of(name), types.ACCESS_OVERWRITE, False)
                for name in writes if name not in reads]
    if not visited:
        raise InvalidArgument("visit: expected an attribute in reads or writes")
    return visited


def visit(store, visited, function, level, progress):
    """Runs the pass over a store handle."""
    attributes = (types.plait_visit_attribute * len(visited))(
        *((text(each.name), each.access, int(each.rings)) for each in visited))
    written = [(number, each.name) for number, each in enumerate(visited)
               if each.access != types.ACCESS_READ]

    def call(pointer, _):
        batch = pointer.contents
        vertices = Vertices(batch, visited)
        result = function(vertices)
        if result is False:
            return False
        if result is not None:
            if len(written) != 1:
                raise InvalidArgument("visit: the function returned records, but the visit does "
                                      f"not write one attribute but {len(written)}")
            vertices[written[0][1]] = result
        for number, name in written:
            records = vertices[name]
            ctypes.memmove(batch.attributes[number].records, records.ctypes.data, records.nbytes)
        return True

    with Watch("visit", progress) as watch:
        callback = types.plait_visit_batch(watch.guard(call))
        LIBRARY.plait_store_visit(store.address, attributes, len(visited), 0, level, callback,
                                  watch.callback, None)
