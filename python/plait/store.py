"""A store that this process has open."""

import ctypes
import os
import threading
import warnings
from ctypes import byref, c_uint32, c_uint64, c_void_p
from typing import NamedTuple

import numpy as np

from . import _functions, _handles, _memory, _reading, mesh, visits, writing
from . import _structures as types
from ._functions import LIBRARY, text
from ._progress import Watch
from .attributes import Attribute
from .errors import BadState, Error, InvalidArgument, NoSuchAttribute, NotFound


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


class Store:
    """A store. Made by plait.open() and plait.create(); `with` closes it at the end of the block.

    Any number of threads may read one store at the same time, and the interpreter's lock is free
    while they do. A call that changes the store must be alone. In a process that was forked, every
    call fails with BadState: open the store again there.
    """

    def __init__(self, handle):
        self._handle = handle
        self._lock = threading.Lock()
        self._readers = {}
        self._base = None

    # ---- What it has

    def _store(self):
        handle = self._handle
        if handle is None:
            raise BadState("the store is closed")
        return handle

    def _raw_info(self):
        info = types.plait_store_info()
        LIBRARY.plait_store_get_info(self._store().address, byref(info))
        return info

    def _attribute_infos(self):
        store = self._store()
        for number in range(self._raw_info().attribute_count):
            info = types.plait_attribute_info()
            LIBRARY.plait_store_get_attribute(store.address, c_uint32(number), byref(info))
            yield info

    @property
    def info(self):
        """Path, backend, sizes: a named tuple Info."""
        raw = self._raw_info()
        return Info(os.fsdecode(raw.path), raw.backend.decode(), raw.pipeline.decode(),
                    raw.layout.decode(), raw.scheme.decode(), raw.program.decode(),
                    bytes(raw.uuid).hex(), raw.sequence, raw.block_bytes, raw.budget_bytes,
                    raw.stored_bytes, raw.base_level, raw.finest_level, bool(raw.writable))

    @property
    def path(self):
        """The directory of the store; empty for a store in memory."""
        return os.fsdecode(self._raw_info().path)

    @property
    def levels(self):
        """A range: the base level and all finer levels."""
        raw = self._raw_info()
        return range(raw.base_level, raw.finest_level + 1)

    @property
    def attributes(self):
        """The attributes by name, as a dict of Attribute objects."""
        return {info.name.decode(): self[info.name.decode()] for info in self._attribute_infos()}

    @property
    def base(self):
        """The base mesh: a named tuple Base. The arrays are copies, made once."""
        if self._base is None:
            store = self._store()
            address, count = c_void_p(), c_uint64()
            LIBRARY.plait_store_get_base_positions(store.address, byref(address), byref(count))
            vertices = visits._copied(address.value, (count.value, 3), np.dtype("<f8"))
            LIBRARY.plait_store_get_faces(store.address, byref(address), byref(count))
            triangles = visits._copied(address.value, (count.value, 3), np.dtype("<u4"))
            self._base = Base(_reading.frozen(vertices), _reading.frozen(triangles))
        return self._base

    def counts(self, level):
        """Vertices, edges and faces of the whole mesh at `level`: a named tuple Counts."""
        found = [c_uint64() for _ in range(3)]
        LIBRARY.plait_store_get_counts(self._store().address, level, *map(byref, found))
        return Counts(*(each.value for each in found))

    @property
    def statistics(self):
        """What the pager did so far: a named tuple Statistics."""
        raw = types.plait_paging_statistics()
        LIBRARY.plait_store_get_statistics(self._store().address, byref(raw))
        return Statistics(*(getattr(raw, name) for name in Statistics._fields))

    # ---- Reading

    def _reader(self, name):
        reader = self._readers.get(name)
        if reader is None:
            with self._lock:
                reader = self._readers.get(name)
                if reader is None:
                    reader = self._readers[name] = self._new_reader(name)
        return reader

    def _check_names(self, *names):
        known = [info.name.decode() for info in self._attribute_infos()]
        for name in names:
            if name not in known:
                there = ", ".join(f"'{each}'" for each in known)
                raise NoSuchAttribute(f"no attribute '{name}': the store has {there or 'none'}",
                                      self.path or None)

    def _new_reader(self, name):
        self._check_names(name)
        info, = (info for info in self._attribute_infos() if info.name.decode() == name)
        return _reading.AttributeReader(self._store(), info, self._raw_info().base_level)

    def _level_of(self, reader, level):
        if level is None:
            return reader.finest_level
        if not reader.base_level <= level <= reader.finest_level:
            raise NotFound(f"level {level} of '{reader.name}': expected {reader.base_level} to "
                           f"{reader.finest_level}", self.path or None)
        return level

    def __getitem__(self, name):
        """An attribute: store["position"][5] is its level 5 as an array."""
        return Attribute(self._reader(name), self.path)

    def __contains__(self, name):
        return any(info.name.decode() == name for info in self._attribute_infos())

    def patch(self, face, level=None, attribute="position"):
        """The records of a patch in row order: (0, 0), (1, 0), ..., (n, 0), (0, 1), ..., (0, n).

        face: 0 and more, as in store.base.triangles. level: default the finest of the attribute.
        Returns a read-only array of (n + 1)(n + 2) / 2 records, n = 2**(level - base level).
        """
        reader = self._reader(attribute)
        if level is None or not reader.base_level <= level <= reader.finest_level:
            level = self._level_of(reader, level)
        return reader.patch(face, level)

    def patches(self, faces=None, *, box=None, level=None, attribute="position",
                memory=_memory.DEFAULT_LIMIT):
        """The records of many patches in one call: a named tuple Patches.

        faces: a list of faces. box: (low, high), two points: the faces whose bounds meet the box.
        memory: refuses to return more bytes; a number or a text such as "4GiB".
        """
        reader = self._reader(attribute)
        level = self._level_of(reader, level)
        faces = self._faces(faces, box)
        needed = (len(faces) * _reading.patch_vertices(level - reader.base_level)
                  * reader.record_bytes)
        _memory.check(f"{len(faces)} patches at level {level}", needed, memory,
                      "take fewer faces, a smaller box or a coarser level")
        return Patches(faces, _reading.frozen(reader.patches(faces, level)))

    def _faces(self, faces, box):
        if (faces is None) == (box is None):
            raise InvalidArgument("expected either faces or box")
        return self.faces_in_box(*_reading.corners(box)) if faces is None else (
            _reading.face_list(faces))

    def faces_in_box(self, low, high, attribute="position"):
        """The faces whose bounds meet the box from `low` to `high`, ascending: uint32, read-only.

        The bounds of a face contain all vertices of its patch. The first call reads a file that
        write_bounds() has written, or else all levels of the attribute.
        """
        return self._reader(attribute).faces_in_box(
            _reading.three_numbers("low", low), _reading.three_numbers("high", high),
            self._raw_info().face_count)

    def along_ray(self, origin, direction, attribute="position"):
        """The faces whose bounds a ray meets, the nearest first: a named tuple Hits."""
        return Hits(*self._reader(attribute).faces_along_ray(
            _reading.three_numbers("origin", origin),
            _reading.three_numbers("direction", direction), self._raw_info().face_count))

    def mesh(self, level=None, box=None, faces=None, attributes=(), memory=_memory.DEFAULT_LIMIT):
        """Patches as one mesh, in which neighbouring patches share vertices: a named tuple Mesh.

        level: default the finest one. box: (low, high); faces: a list; neither: the whole surface.
        attributes: names of attributes whose records come along.
        memory: refuses to use more bytes; a number or a text such as "4GiB".
        """
        names = ["position"] + [attributes] if isinstance(attributes, str) else [
            "position", *attributes]
        readers = [self._reader(name) for name in dict.fromkeys(names)]
        for reader in readers:
            level = self._level_of(reader, level)
        if faces is None and box is None:
            count = self._raw_info().face_count
            _memory.check(f"mesh of {count} patches at level {level}",
                          mesh.needed_bytes(readers, count, level), memory,
                          "take a coarser level or a box")
            faces = np.arange(count, dtype=np.uint32)
        else:
            faces = self._faces(faces, box)
        return mesh.welded(readers, faces, level, memory)

    # ---- Computing and changing

    def _changing(self):
        """The handle, for a call that changes the store. Readers would be in its way."""
        with self._lock:
            self._readers.clear()
        return self._store()

    def visit(self, function, reads=(), writes=(), rings=False, level=None, progress=None):
        """Computes on every vertex of the levels up to `level`, base vertices too, in one pass over
        the files, with memory for one batch.

        function: called with Vertices, many at once. It fills the attributes that the visit writes,
            or returns the records if the visit writes one. If it returns False, the visit ends with
            Cancelled.
        reads, writes: names of attributes. One that is in both is changed in place.
        rings: True: function also gets the neighbours of each vertex for all attributes in reads; a
            list of names: for these.
        level: default the finest one, which all attributes must have.
        progress: True for a bar, or a function of (phase, done, total).

        An attribute whose rings are read cannot be written: write to another one, and then call
        replace_attribute(). After an error the levels that were written cannot be read until a pass
        has written them again, or roll_back() was called.
        """
        visited = visits.visited_attributes(self._reader, reads, writes, rings)
        visits.visit(self._changing(), visited, function,
                     types.FINEST_LEVEL if level is None else level, progress)

    def patch_writer(self, attributes=(), first_level=None, last_level=None, compare=False):
        """A PatchWriter, which fills levels of the store patch by patch.

        attributes: names; none: all attributes of the store.
        first_level, last_level: the levels to fill; None: from the base level on, up to the finest
        level of each attribute.
        compare: refuses a patch that gives a vertex another record than an earlier patch did.
        """
        names = [attributes] if isinstance(attributes, str) else list(attributes)
        known = {info.name.decode(): (np.dtype(types.TYPES[info.type]), info.components)
                 for info in self._attribute_infos()}
        self._check_names(*names)
        return writing.PatchWriter(self._changing(), known, self._raw_info().base_level, names,
                                   first_level, last_level, compare)

    def add_attribute(self, name, dtype=np.float32, components=1, level=None):
        """Adds an attribute whose records are zeros, with all levels up to `level` (default: the
        finest one of the store)."""
        wanted = np.dtype(dtype).newbyteorder("<").str
        known = {name: number for number, name in types.TYPES.items()}
        if wanted not in known:
            raise InvalidArgument(f"dtype: expected one of {', '.join(known)}, found {wanted}")
        store = self._changing()
        level = self._raw_info().finest_level if level is None else level
        LIBRARY.plait_store_add_attribute(store.address, text(name), known[wanted], components,
                                          level)

    def remove_attribute(self, name):
        """Removes an attribute with its levels."""
        self._check_names(name)
        LIBRARY.plait_store_remove_attribute(self._changing().address, text(name))

    def replace_attribute(self, name, replacement):
        """Removes attribute `name`; attribute `replacement` gets its name."""
        self._check_names(name, replacement)
        LIBRARY.plait_store_replace_attribute(self._changing().address, text(name),
                                              text(replacement))

    def subdivide(self, levels, scheme="loop", normals=False, limit=False, executor="auto",
                  threads=1, progress=None):
        """Refines "position" to `levels`, and leaves the commit to the caller."""
        with Watch("subdivide", progress) as watch:
            options = types.plait_subdivide_options(
                scheme=text(scheme), executor=text(executor), progress=watch.callback,
                levels=levels, threads=threads, normals=int(normals), limit=int(limit))
            LIBRARY.plait_store_subdivide(self._changing().address, byref(options))

    def commit(self):
        """Publishes all changes as the next version, if anything has changed."""
        LIBRARY.plait_store_commit(self._changing().address)

    def roll_back(self):
        """Brings the store back to its last commit."""
        LIBRARY.plait_store_roll_back(self._changing().address)

    def write_bounds(self, attribute="position", progress=None):
        """Computes where the patches are, and keeps it in a file of the store, so that boxes and
        rays need not read the surface first."""
        with Watch("bounds", progress) as watch:
            LIBRARY.plait_store_write_bounds_with_progress(
                self._changing().address, text(attribute), watch.callback, None)

    def verify(self, progress=None):
        """Reads every block and compares its checksum: a named tuple VerifyReport. Damage is no
        exception, it is in the report."""
        damaged = []
        report = types.plait_verify_report()
        with Watch("verify", progress) as watch:
            def keep(pointer, _):
                block = pointer.contents
                damaged.append(DamagedBlock(block.attribute.decode(), block.level, block.block,
                                            block.reason.decode(), block.file_offset,
                                            block.first_edge, block.edge_after))
            LIBRARY.plait_store_verify(self._store().address, watch.callback,
                                       types.plait_damage(watch.guard(keep)), None,
                                       byref(report))
        return VerifyReport(report.blocks, report.bytes, report.never_written,
                            report.damaged_count, damaged)

    def digest(self, level=None, threads=1, progress=None):
        """32 hexadecimal digits that depend on all records of a level, or of all levels, and not on
        backend, layout or executor."""
        digits = ctypes.create_string_buffer(types.DIGEST_BYTES)
        with Watch("digest", progress) as watch:
            LIBRARY.plait_store_digest(self._store().address,
                                       types.ALL_LEVELS if level is None else level, threads,
                                       watch.callback, None, digits)
        return digits.value.decode()

    def close(self):
        """Closes the store. Changes since the last commit are lost. Arrays that were read stay
        valid; files stay open until the last array that points into them is gone."""
        with self._lock:
            self._handle = None
            self._readers.clear()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self):
        if self._handle is None:
            return "<plait store, closed>"
        info = self.info
        where = f"'{info.path}'" if info.path else "in memory"
        return f"<plait store {where}: levels {info.base_level} to {info.finest_level}>"


def open_store(path, writable=False, memory=types.DEFAULT_BUDGET_BYTES, io_threads=None):
    """Opens the last committed version of a store.

    writable: True: for one writer; False: for reading, beside a writer.
    memory: the most memory for blocks; bytes, or a text such as "64MiB".
    io_threads: threads that read ahead and write behind; None: the library chooses.
    Raises NotFound, Damaged, NotSupported, and Busy if another writer has the store open. Warns of
    what this machine does not give the store: io_uring, locks.
    """
    options = types.plait_open_options(
        budget_bytes=_memory.bytes_of(memory), writable=int(writable),
        io_threads=types.AUTOMATIC_THREADS if io_threads is None else io_threads,
        durability=0, reserved=0)
    address = c_void_p()
    try:
        LIBRARY.plait_store_open(_functions.path(path), byref(options), byref(address))
    except Error as error:
        error.path = error.path or os.fsdecode(path)
        raise
    store = Store(_handles.store(address.value))
    for line in store._raw_info().notices.decode(errors="replace").splitlines():
        warnings.warn(line, RuntimeWarning, stacklevel=2)
    return store


def create(vertices, faces, path=None, backend=None, dtype=np.float32, layout=None, pipeline=None,
           block_bytes=types.DEFAULT_BLOCK_BYTES, memory=types.DEFAULT_BUDGET_BYTES, base_level=0,
           warn=None):
    """Makes a store from arrays, and opens it for writing.

    vertices: shape (vertices, 3), positions. faces: shape (triangles, 3), whole numbers,
    counterclockwise. The mesh must be an oriented 2-manifold, with or without border. The store
    drops vertices that no triangle uses, and puts faces in the order of the layout: see store.base.
    path: a directory that does not exist; None: only in memory. With a path, the store is committed.
    dtype: float32 or float64, of the attribute "position".
    warn: a function of a text, told what was changed in the mesh; None: Python warns.
    """
    vertices = np.ascontiguousarray(vertices, np.float64)
    given = np.asarray(faces)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InvalidArgument(f"vertices: expected shape (n, 3), found {vertices.shape}")
    if given.ndim != 2 or given.shape[1] != 3 or given.dtype.kind not in "iu":
        raise InvalidArgument(
            f"faces: expected whole numbers of shape (n, 3), found {given.dtype} of {given.shape}")
    if given.size and (given.min() < 0 or given.max() >= len(vertices)):
        raise InvalidArgument(f"faces: expected vertices 0 to {len(vertices) - 1}, found "
                              f"{given.min()} to {given.max()}")
    faces = np.ascontiguousarray(given, np.uint32)
    position = {"<f4": types.FLOAT32, "<f8": types.FLOAT64}.get(
        np.dtype(dtype).newbyteorder("<").str)
    if position is None:
        raise InvalidArgument(f"dtype: expected float32 or float64, found {np.dtype(dtype)}")
    if path is None and backend is None:
        backend = "memory"
    store = None
    try:
        with Watch("create") as watch:
            options = types.plait_store_options(
                backend=text(backend), pipeline=text(pipeline), layout=text(layout),
                block_bytes=_memory.bytes_of(block_bytes), budget_bytes=_memory.bytes_of(memory),
                warn=watch.warning(warn), base_level=base_level, io_threads=types.AUTOMATIC_THREADS,
                position_type=position, durability=0)
            address = c_void_p()
            LIBRARY.plait_store_create(b"" if path is None else _functions.path(path),
                                       vertices.ctypes.data, len(vertices), faces.ctypes.data,
                                       len(faces), byref(options), byref(address))
            store = Store(_handles.store(address.value))
        if path is not None:
            store.commit()
        return store
    except BaseException:  # what warn() raises comes when there is a store already
        if store is not None:
            store.close()  # removes the directory, which has no commit
        raise


def triangles(level, base_level=0):
    """The triangles of every patch at `level`: places in row order, counterclockwise, shape
    (4**(level - base_level), 3), uint32. They are the same for all patches."""
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
    return _reading.frozen(np.concatenate([up, down])[order].astype(np.uint32))
