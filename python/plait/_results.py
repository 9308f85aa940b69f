"""What calls of a store return."""

from typing import NamedTuple

import numpy as np


class Base(NamedTuple):
    """The base mesh of a store.

    vertices: positions from which the store was made, shape (vertices, 3), float64.
    triangles: shape (faces, 3), uint32, counterclockwise. Face f is patch f.
    """

    vertices: np.ndarray
    triangles: np.ndarray


class Counts(NamedTuple):
    """Of the whole mesh at a level."""

    vertices: int
    edges: int
    faces: int


class Info(NamedTuple):
    """What a store is, and where. Sizes are in bytes; the last ones are after compression."""

    path: str
    backend: str
    pipeline: str
    layout: str
    scheme: str
    program: str
    uuid: str
    sequence: int
    block_bytes: int
    budget_bytes: int
    stored_bytes: int
    base_level: int
    finest_level: int
    writable: bool


class Patches(NamedTuple):
    """Many patches.

    faces: shape (patches,), uint32.
    records: shape (patches, vertices of a patch) or (patches, vertices of a patch, components), each
        patch in row order.
    """

    faces: np.ndarray
    records: np.ndarray


class Hits(NamedTuple):
    """Faces whose bounds a ray meets, the nearest first.

    faces: shape (hits,), uint32.
    distances: shape (hits,), float64: where the ray enters the bounds, in lengths of its direction.
    """

    faces: np.ndarray
    distances: np.ndarray


class Statistics(NamedTuple):
    """What the pager of a store did. Bytes are before compression, times in nanoseconds."""

    blocks_read: int
    bytes_read: int
    blocks_written: int
    bytes_written: int
    blocks_prefetched: int
    blocks_evicted: int
    read_waits: int
    read_wait_ns: int
    write_waits: int
    write_wait_ns: int
    peak_frame_bytes: int


class DamagedBlock(NamedTuple):
    """A block whose bytes are not those that were written."""

    attribute: str
    level: int
    block: int
    reason: str
    file_offset: int
    first_edge: int
    edge_after: int


class VerifyReport(NamedTuple):
    """blocks, bytes: read and checked. never_written: blocks that read as zeros. damaged_count: of
    these, `damaged` has the first 1,000."""

    blocks: int
    bytes: int
    never_written: int
    damaged_count: int
    damaged: list


class Input(NamedTuple):
    """Where the vertices and faces of the base mesh are in the mesh from which the store was made (the
    input), and the other way round. 4294967295 stands for nothing.

    input_vertices: of each base vertex, its number in the input; nothing: made by a base level.
    input_faces: of each face of the store, the face of the input that it is, or is a part of.
    turned: of each face of the store, whether its second and third corner were exchanged.
    vertices: of each vertex of the input, its number in the store; nothing: it was dropped.
    faces: of each face of the input, its number in the store, or that of the first of its parts.
    """

    input_vertices: np.ndarray
    input_faces: np.ndarray
    turned: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray


class Points(NamedTuple):
    """Where vertices are on the base mesh: vertex k is the point (i[k], j[k]) of the grid of base face
    face[k], whose corners are (0, 0), (size[k], 0) and (0, size[k]), in the order of
    store.base.triangles. A vertex on an edge is in two faces: this is a point of one of them."""

    face: np.ndarray
    i: np.ndarray
    j: np.ndarray
    size: np.ndarray
