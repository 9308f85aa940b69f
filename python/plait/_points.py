"""Where the base mesh is in the mesh of the program, and where vertices are on the base mesh."""

from ctypes import byref

import numpy as np

from . import _keys
from . import _structures as types
from ._functions import LIBRARY
from ._reading import frozen
from ._results import Input, Points

_POINT = np.dtype([("face", "<u4"), ("i", "<i4"), ("j", "<i4"), ("size", "<i4")])
_NEAR = 64  # points that are made to leave fewer calls


def input_maps(store):
    """The maps of a store handle."""
    from .visits import copied
    maps = types.plait_input_maps()
    store.call(LIBRARY.plait_store_get_input_maps, byref(maps))
    return Input(*(frozen(copied(pointer, (count,), np.dtype(kind))) for pointer, count, kind in (
        (maps.input_vertices, maps.vertex_count, "<u4"), (maps.input_faces, maps.face_count, "<u4"),
        (maps.turned, maps.face_count, "?"), (maps.vertices, maps.input_vertex_count, "<u4"),
        (maps.faces, maps.input_face_count, "<u4"))))


def numbers(places, count):
    """Numbers of vertices, of a slice, a list or an array."""
    if isinstance(places, slice):
        return np.arange(*places.indices(count))
    return _keys.checked(np.atleast_1d(np.asarray(places, None if np.size(places) else np.int64)),
                         count)


def points(store, level, places):
    """The points of these vertices of a level."""
    found = np.empty(len(places), _POINT)
    order = np.argsort(places, kind="stable")
    ascending = places[order]
    cuts = np.flatnonzero(np.diff(ascending) > _NEAR) + 1
    if len(places):
        for stretch, there in zip(np.split(ascending, cuts), np.split(order, cuts)):
            first, count = int(stretch[0]), int(stretch[-1] - stretch[0]) + 1
            some = np.empty(count, _POINT)
            store.call(LIBRARY.plait_store_get_points, level, first, count, some.ctypes.data)
            found[there] = some[stretch - first]
    return Points(*(frozen(np.ascontiguousarray(found[name])) for name in Points._fields))


def points_of_levels(store, levels, places):
    """The points of vertices of several levels."""
    found = Points(*(np.empty(len(places), _POINT[name]) for name in Points._fields))
    for level in np.unique(levels):
        these = np.flatnonzero(levels == level)
        for whole, part in zip(found, points(store, int(level), places[these].astype(np.int64))):
            whole[these] = part
    return Points(*map(frozen, found))
