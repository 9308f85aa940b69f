"""Own computations on every vertex of a store."""

import ctypes

import numpy as np

from . import _points, _records
from . import _structures as types
from ._functions import LIBRARY, text
from ._progress import Watch, truth
from .errors import InvalidArgument, NoSuchAttribute


class Vertices:
    """What a visit gives to its function: vertices with equally many neighbours.

    vertices["position"] has the records of an attribute, shape (count,) or (count, components).
    Those of attributes that the visit reads are read-only. The function fills those that it writes;
    they are zeros at first, or the old records if the visit also reads the attribute. Numbers must
    fit the dtype: float64 may become float32, but 1.5 no integer.

    levels: shape (count,): the level that creates each vertex.
    places: shape (count,): its number among the vertices of its level, as in store[name][level].
    valence: neighbours of each vertex, 0 if the visit reads no rings.
    border: whether the vertices are on a border of the surface, or on an edge that only one of its
        faces has at their level (Store.depths).
    base: whether they are base vertices.
    """

    # What else is set on it would be lost, so it is refused.
    __slots__ = ("_store", "valence", "border", "base", "levels", "places", "_records",
                 "_asked_for", "_neighbours", "__weakref__")

    def __init__(self, batch, visited, store):
        self._store = store
        count = batch.count
        self.valence = batch.valence
        self.border = bool(batch.border)
        self.base = bool(batch.base)
        self.levels = copied(batch.levels, (count,), np.dtype("<i4"))
        self.places = copied(batch.places, (count,), np.dtype("<i8"))
        self._records = {}
        self._asked_for = set()
        self._neighbours = {}
        for number, each in enumerate(visited):
            given = batch.attributes[number]
            tail = () if each.components == 1 else (each.components,)
            records = copied(given.records, (count,) + tail, each.dtype)
            records.flags.writeable = each.access != types.ACCESS_READ
            self._records[each.name] = records
            if given.neighbours:
                around = copied(given.neighbours, (count, batch.valence) + tail, each.dtype)
                around.flags.writeable = False
                self._neighbours[each.name] = around

    def __len__(self):
        return len(self.levels)

    def __getitem__(self, name):
        try:
            records = self._records[name]
        except KeyError:
            raise NoSuchAttribute(f"the visit neither reads nor writes '{name}'") from None
        self._asked_for.add(name)
        return records

    def __setitem__(self, name, records):
        into = self[name]
        into[...] = _records.fitted(f"'{name}'", records, into.dtype)

    def points(self):
        """Where the vertices are on the base mesh, to sample height maps and textures: a named tuple
        Points."""
        return _points.points_of_levels(self._store, self.levels, self.places)

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
    def __init__(self, info, access, rings):
        self.name = info.name.decode()
        self.dtype, self.components = np.dtype(types.TYPES[info.type]), info.components
        self.access, self.rings = access, rings


def _address(pointer):
    return pointer if isinstance(pointer, int) else ctypes.cast(pointer, ctypes.c_void_p).value


def copied(pointer, shape, dtype):
    """A copy that outlives the call."""
    array = np.empty(shape, dtype)
    ctypes.memmove(array.ctypes.data, _address(pointer), array.nbytes)
    return array


def names_of(names):
    return [names] if isinstance(names, str) else list(names)


def visited_attributes(info_of, reads, writes, rings):
    """What the visit does with each attribute."""
    reads, writes = names_of(reads), names_of(writes)
    with_rings = [] if rings is False else reads if rings is True else names_of(rings)
    for name in with_rings:
        if name in writes:
            raise InvalidArgument(
                f"visit: '{name}' is read with its rings and written: write to another attribute, "
                "and then call replace_attribute()")
        if name not in reads:
            raise InvalidArgument(f"visit: rings of '{name}', which is not in reads")
    visited = [_Visited(info_of(name),
                        types.ACCESS_UPDATE if name in writes else types.ACCESS_READ,
                        name in with_rings) for name in reads]
    visited += [_Visited(info_of(name), types.ACCESS_OVERWRITE, False)
                for name in writes if name not in reads]
    if not visited:
        raise InvalidArgument("visit: expected an attribute in reads or writes")
    return visited


def visit(store, change, visited, function, level, progress):
    """Runs the pass over a store handle. change: calls a function that changes the store."""
    attributes = (types.plait_visit_attribute * len(visited))(
        *((text(each.name), each.access, int(each.rings)) for each in visited))
    written = [(number, each.name) for number, each in enumerate(visited)
               if each.access != types.ACCESS_READ]

    def call(pointer, _):
        batch = pointer.contents
        vertices = Vertices(batch, visited, store)
        result = function(vertices)
        verdict = truth(result)
        if verdict is False:
            return False
        if verdict is True:
            raise InvalidArgument("visit: the function returned True: expected records, None to go on, "
                                  "or False to cancel")
        if result is not None:
            if len(written) != 1:
                raise InvalidArgument("visit: the function returned records, but the visit does "
                                      f"not write one attribute but {len(written)}")
            vertices[written[0][1]] = result
        for number, name in written:
            if visited[number].access == types.ACCESS_OVERWRITE and name not in vertices._asked_for:
                raise InvalidArgument(f"visit: expected that the function fills '{name}' or returns its "
                                      f"records, found neither; v['{name}'] = 0 leaves zeros")
            records = vertices[name]
            ctypes.memmove(batch.attributes[number].records, records.ctypes.data, records.nbytes)
        return True

    with Watch("visit", progress) as watch:
        callback = types.plait_visit_batch(watch.guard(call))
        change(LIBRARY.plait_store_visit, attributes, len(visited), 0, level, callback,
               watch.callback, None, keeps=not written)
