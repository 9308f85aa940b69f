"""Patches as one mesh: each vertex once."""

from ctypes import c_void_p
from typing import NamedTuple

import numpy as np

from . import _memory
from ._functions import LIBRARY
from ._reading import frozen, patch_vertices, whole
from .errors import InvalidArgument

_PATCHES_AT_ONCE_BYTES = 8 << 20


class Mesh(NamedTuple):
    """Triangles of several patches, welded.

    vertices: positions, shape (vertices, 3), in the units of the mesh.
    triangles: shape (triangles, 3), uint32 numbers of vertices, counterclockwise.
    faces: the base faces whose patches these are, in order: patch k has the triangles
        k * 4**refinements to (k + 1) * 4**refinements - 1, unless some faces have fewer levels
        (store.depths).
    attributes: by name, the records of the same vertices.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    faces: np.ndarray
    attributes: dict


def needed_bytes(readers, face_count, level):
    """The most memory that welded() takes, without vertices that patches share."""
    refinements = level - readers[0].base_level
    points = face_count * patch_vertices(refinements)
    records = sum(reader.record_bytes for reader in readers)
    return points * (4 + records) + face_count * (12 << 2 * refinements) + _PATCHES_AT_ONCE_BYTES


def welded(readers, faces, level, memory):
    """The patches of these faces as one mesh. The first reader is that of the positions."""
    _memory.check(f"mesh of {len(faces)} patches at level {level}",
                  needed_bytes(readers, len(faces), level), memory,
                  "take a coarser level or a smaller box")
    numbers, count = readers[0].weld(faces, level)
    records = {reader.name: _scattered(reader, faces, level, numbers, count) for reader in readers}
    corners = readers[0].triangles(level)
    triangles = np.empty((len(faces),) + corners.shape, np.uint32)
    np.take(numbers, corners, axis=1, out=triangles, mode="clip")
    vertices = records[readers[0].name]
    return Mesh(vertices, frozen(triangles.reshape(-1, 3)), faces,
                {reader.name: records[reader.name] for reader in readers[1:]})


def drawn(store, names, level, memory):
    """The whole surface at `level`, or less where faces have fewer levels. The first name is that of
    the positions. Vertices are in the order of store[name].upto(level)."""
    counts = store.counts(level)
    record_bytes = sum(store[name].dtype.itemsize * store[name].components for name in names)
    _memory.check(f"mesh of {counts.faces} triangles",
                  counts.faces * 12 + counts.vertices * record_bytes, memory,
                  "take a coarser level")
    triangles = np.empty((counts.faces, 3), np.uint32)
    store._store().call(LIBRARY.plait_store_get_triangles, level, c_void_p(triangles.ctypes.data),
                        len(triangles), None)
    records = {name: store[name].upto(level, memory=memory) for name in names}
    faces = frozen(np.arange(len(store.base.triangles), dtype=np.uint32))
    return Mesh(records.pop(names[0]), frozen(triangles), faces, records)


def _scattered(reader, faces, level, numbers, count):
    """The record of each vertex, from a few patches at a time."""
    records = np.empty(reader.shape(count), reader.dtype)
    at_once = max(1, _PATCHES_AT_ONCE_BYTES // (numbers.shape[1] * reader.record_bytes))
    for first in range(0, len(faces), at_once):
        part = slice(first, first + at_once)
        records[numbers[part]] = reader.patches(faces[part], level)
    return frozen(records)

def triangles(level, base_level=0):
    """The triangles of every patch at `level`: places in row order, counterclockwise, shape
    (4**(level - base_level), 3), uint32. They are the same for all patches. store.triangles(level) knows
    the base level of a store."""
    level, base_level = whole("level", level), whole("base_level", base_level)
    if not 0 <= level - base_level <= 15:
        raise InvalidArgument(f"triangles: expected a level from {base_level} to {base_level + 15}, "
                              f"found {level}")
    size = 1 << (level - base_level)
    rows = np.arange(size + 1)
    starts = rows * (size + 1) - rows * (rows - 1) // 2
    j = np.repeat(np.arange(size), size - np.arange(size))
    i = np.arange(len(j)) - np.repeat(np.cumsum(size - np.arange(size)) - (size - np.arange(size)),
                                      size - np.arange(size))
    low, high = starts[j] + i, starts[j + 1] + i
    up = np.stack([low, low + 1, high], 1)
    inner = i + j + 1 < size
    down = np.stack([low + 1, high + 1, high], 1)[inner]
    # Each upright triangle is followed by the one beside it, as in plait_reader_patch_indices().
    order = np.argsort(np.concatenate([2 * np.arange(len(up)), 2 * np.flatnonzero(inner) + 1]),
                       kind="stable")
    return frozen(np.concatenate([up, down])[order].astype(np.uint32))
