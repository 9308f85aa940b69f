"""A store that this process has open."""

import ctypes
import os
import threading
import uuid
import warnings
import weakref
from ctypes import byref, c_uint32, c_uint64, c_void_p

import numpy as np

from . import _functions, _handles, _identity, _memory, _notes, _points, _reading, _records, mesh, visits
from . import _structures as types
from . import writing
from ._functions import LIBRARY, text
from ._progress import Watch
from ._results import (Base, Counts, DamagedBlock, Hits, Info, Input, Patches, Points, Statistics,
                       VerifyReport)
from .attributes import Attribute
from .errors import (BadState, Busy, Error, InvalidArgument, NoSuchAttribute, NoSuchLevel,
                     NotSupported)


class Store:
    """A store. Made by plait.open() and plait.create(); `with` closes it at the end of the block.

    Any number of threads may read one store at the same time, and the interpreter's lock is free
    while they do. A call that changes the store must be alone. In a process that was forked, every
    call fails with BadState: open the store again there.
    """

    def __init__(self, handle, path, memory, io_threads=None):
        self._handle = handle
        self._lock = threading.Lock()
        self._readers = {}
        self._pins = []  # an entry for each array without a copy
        self._patch_writers = weakref.WeakSet()
        self._shown = []  # what show() has made of this object
        self._changing = []  # an entry for each call that changes the store now
        self._lost = False  # whether close() would lose changes
        self._base = self._input = None
        # The working directory may be another one later, or in another process.
        self._absolute = os.path.abspath(path) if path else ""
        self._options = (memory, io_threads)
        self._name, self._edits = uuid.uuid4().hex, 0

    def __setattr__(self, name, value):
        if not name.startswith("_"):
            raise AttributeError(f"a store has no {name!r} that can be set, and would lose it: visit(), "
                                 "patch_writer(), set_text() and set_face_attribute() change the store")
        super().__setattr__(name, value)

    # ---- What it has

    def _store(self):
        handle = self._handle
        if handle is None:
            raise BadState("the store is closed")
        return handle

    def _raw_info(self):
        info = types.plait_store_info()
        self._store().call(LIBRARY.plait_store_get_info, byref(info))
        return info

    def _where(self):
        return self._absolute or None

    def _attribute_infos(self):
        store = self._store()
        for number in range(self._raw_info().attribute_count):
            info = types.plait_attribute_info()
            store.call(LIBRARY.plait_store_get_attribute, c_uint32(number), byref(info))
            yield info

    def _names(self):
        return [info.name.decode() for info in self._attribute_infos()]

    def _attribute_info(self, name):
        for info in self._attribute_infos():
            if info.name.decode() == name:
                return info
        there = ", ".join(f"'{each}'" for each in self._names())
        raise NoSuchAttribute(f"no attribute '{name}': the store has {there or 'none'}",
                              self._where())

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
        return _notes.Snapshot({name: Attribute(self, name) for name in self._names()},
                               "add_attribute() and patch_writer() change the store")

    @property
    def base(self):
        """The base mesh: a named tuple Base. The arrays are copies, made once."""
        if self._base is None:
            store = self._store()
            address, count = c_void_p(), c_uint64()
            store.call(LIBRARY.plait_store_get_base_positions, byref(address), byref(count))
            vertices = visits.copied(address.value, (count.value, 3), np.dtype("<f8"))
            store.call(LIBRARY.plait_store_get_faces, byref(address), byref(count))
            triangles = visits.copied(address.value, (count.value, 3), np.dtype("<u4"))
            self._base = Base(_reading.frozen(vertices), _reading.frozen(triangles))
        return self._base

    @property
    def input(self):
        """Where the vertices and faces of the mesh from which the store was made are now, and the other
        way round: a named tuple Input. The arrays are copies, made once."""
        if self._input is None:
            self._input = _points.input_maps(self._store())
        return self._input

    def triangles(self, level):
        """The triangles of every patch at `level`: places in row order, counterclockwise, shape
        (4**(level - base level), 3), uint32."""
        return mesh.triangles(level, self._raw_info().base_level)

    def points(self, level, places=slice(None)):
        """Where the vertices that `level` creates are on the base mesh, to sample height maps and
        textures: a named tuple Points.

        places: their numbers, as in store[name][level]: a slice, a list or an array.
        """
        level = _reading.whole("level", level)
        finer = self.counts(level).vertices
        coarser = self.counts(level - 1).vertices if level > self._raw_info().base_level else 0
        return _points.points(self._store(), level, _points.numbers(places, finer - coarser))

    def counts(self, level):
        """Vertices, edges and faces of the whole mesh at `level`: a named tuple Counts."""
        found = [c_uint64() for _ in range(3)]
        self._store().call(LIBRARY.plait_store_get_counts, _reading.whole("level", level),
                           *map(byref, found))
        return Counts(*(each.value for each in found))

    @property
    def depths(self):
        """The finest level of each base face, shape (faces,), int32: the same for all faces, unless the
        store was pruned. patch(face, depths[face]) reads all that there is of a face."""
        found = np.empty(len(self.base.triangles), np.int32)
        self._store().call(LIBRARY.plait_store_get_depths, c_void_p(found.ctypes.data), len(found))
        return _reading.frozen(found)

    @property
    def statistics(self):
        """What the pager did so far: a named tuple Statistics."""
        raw = types.plait_paging_statistics()
        self._store().call(LIBRARY.plait_store_get_statistics, byref(raw))
        return Statistics(*(getattr(raw, name) for name in Statistics._fields))

    # ---- Which version it is

    def _version(self):
        raw = self._raw_info()
        return bytes(raw.uuid).hex(), raw.sequence

    def _identity(self, what):
        """What a pickle says of this version."""
        if not self._absolute:
            raise TypeError(f"{what} of a store in memory cannot be pickled: it has no path")
        if self._lost:
            raise BadState(f"{what} of {self._absolute} cannot be pickled: the store has changes that "
                           "no other process can see; call commit() first", self._absolute)
        return _identity.Identity(self._absolute, *self._version(), self._options[0])

    def _token(self):
        """Equal for equal records. Changes that are not committed are those of this object."""
        if self._absolute and not self._lost:
            return (self._absolute, *self._version())
        return self._name, self._edits

    def __reduce__(self):
        identity = self._identity("a store")
        if self._raw_info().writable:
            raise TypeError("a store that is open for writing cannot be pickled: another process would "
                            "have it for reading; pickle what plait.open(path) returns")
        return _identity.opened, (identity,)

    def refresh(self):
        """Takes the last committed version, if somebody has made one since this store was opened for
        reading; attributes and levels of it show the new version then. Returns whether there was
        one. A store that is open for writing, or only in memory, has no newer version."""
        if not self._absolute or self._raw_info().writable:
            return False
        new = open_store(self._absolute, False, *self._options)
        if new._version() == self._version():
            new.close()
            return False
        with self._lock:
            old, self._handle = self._handle, new._handle
            self._base = self._input = None
            self._pins = []
        self._end_readers()
        old.end()
        return True

    # ---- Reading

    def _reader(self, name):
        reader = self._readers.get(name)
        if reader is None:
            with self._lock:
                reader = self._readers.get(name)
                if reader is None:
                    reader = self._readers[name] = self._new_reader(name)
        return reader

    def _new_reader(self, name):
        info = self._attribute_info(name)
        return _reading.AttributeReader(self._store(), info, self._raw_info().base_level, self._pins)

    def _end_readers(self):
        with self._lock:
            readers, self._readers = self._readers, {}
        for reader in readers.values():
            reader.end()

    def _end_patch_writers(self):
        for writer in list(self._patch_writers):
            writer._end()

    def _level_of(self, reader, level):
        if level is None:
            return reader.finest_level
        level = _reading.whole("level", level)
        if not reader.base_level <= level <= reader.finest_level:
            raise NoSuchLevel(f"level {level} of '{reader.name}': expected {reader.base_level} to "
                              f"{reader.finest_level}", self._where())
        return level

    def __getitem__(self, name):
        """An attribute: store["position"][5] is its level 5 as an array."""
        self._attribute_info(name)
        return Attribute(self, name)

    def __contains__(self, name):
        return name in self._names()

    def _ipython_key_completions_(self):
        return self._names()

    def patch(self, face, level=None, attribute="position"):
        """The records of a patch in row order: (0, 0), (1, 0), ..., (n, 0), (0, 1), ..., (0, n).

        face: 0 and more, as in store.base.triangles. level: default the finest of the attribute.
        Returns a read-only array of (n + 1)(n + 2) / 2 records, n = 2**(level - base level).
        """
        reader = self._reader(attribute)
        return reader.patch(_reading.whole("face", face), self._level_of(reader, level))

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

    def prefetch(self, faces, level=None, attribute="position"):
        """Begins to read patches that the program will read soon: those in front first, as far as the
        memory has room now, and 64 at most. Returns how many are in memory or on their way: call it
        again with the others later. What nobody reads stays in memory until end_prefetch()."""
        reader = self._reader(attribute)
        faces, count = _reading.face_list(faces), self._raw_info().face_count
        if len(faces) and faces.max() >= count:
            raise InvalidArgument(f"face {faces.max()}: expected 0 to {count - 1}")
        return reader.prefetch(faces, self._level_of(reader, level))

    def end_prefetch(self, attribute="position"):
        """Gives up the patches that prefetch() began to read and nobody has read since."""
        self._reader(attribute).end_prefetch()

    def faces_in_box(self, low, high, attribute="position"):
        """The faces whose bounds meet the box from `low` to `high`, ascending: uint32, read-only.

        The bounds of a face contain all vertices of its patch. The first call reads a file that
        write_bounds() has written, or else all levels of the attribute.
        """
        return self._reader(attribute).faces_in_box(
            _reading.three_numbers("low", low), _reading.three_numbers("high", high),
            self._raw_info().face_count)

    def along_ray(self, origin, direction, attribute="position"):
        """The faces whose bounds a ray meets, the nearest first: a named tuple Hits.

        origin, direction: three numbers each; distances are in lengths of the direction.
        """
        return Hits(*self._reader(attribute).faces_along_ray(
            _reading.three_numbers("origin", origin),
            _reading.three_numbers("direction", direction), self._raw_info().face_count))

    def mesh(self, level=None, box=None, faces=None, attributes=(), memory=_memory.DEFAULT_LIMIT):
        """Patches as one mesh, in which neighbouring patches share vertices: a named tuple Mesh.

        level: default the finest one. Faces with fewer levels (depths) have their own triangles, with
            the vertices of deeper neighbours on their sides, so that no gap is left; then the mesh is
            that of the whole surface. box: (low, high); faces: a list; neither: the whole surface.
        attributes: names of attributes whose records come along.
        memory: refuses to use more bytes; a number or a text such as "4GiB".
        """
        names = ["position"] + [attributes] if isinstance(attributes, str) else [
            "position", *attributes]
        readers = [self._reader(name) for name in dict.fromkeys(names)]
        for reader in readers:
            level = self._level_of(reader, level)
        if level > self.depths.min():
            if faces is not None or box is not None:
                raise NotSupported(f"mesh: level {level} of some faces: the faces have depths of their own,"
                                   f" {self.depths.min()} to {self.depths.max()}: take the whole surface, or"
                                   f" level {self.depths.min()}", self.path)
            return mesh.drawn(self, list(dict.fromkeys(names)), level, memory)
        if faces is None and box is None:
            count = self._raw_info().face_count
            _memory.check(f"mesh of {count} patches at level {level}",
                          mesh.needed_bytes(readers, count, level), memory,
                          "take a coarser level or a box")
            faces = _reading.frozen(np.arange(count, dtype=np.uint32))
        else:
            faces = self._faces(faces, box)
        return mesh.welded(readers, faces, level, memory)

    # ---- Computing and changing

    def _change(self, function, *arguments, keeps=False):
        """Calls a function that changes the store. Readers of this object would be in its way.
        keeps: what it changes is on the disk at once, or is none of the records."""
        handle = self._store()
        self._end_readers()
        self._changing.append(None)
        self._edits += 1
        try:
            result = handle.call(function, *arguments)
        except Busy as error:
            raise self._disturbed(error) from None
        finally:
            self._changing.pop()
        if not keeps:
            self._lost = True
        return result

    def _disturbed(self, error):
        """What is in the way of a change, in words of Python."""
        verb, found, _ = str(error).partition(": expected no reader of this store")
        if not found:
            return error
        count = len(self._pins)
        if self._shown:
            return Busy(f"{verb}: the store is shown: close() what plait.show() has returned",
                        error.path)
        if count == 0:
            return Busy(f"{verb}: another thread reads the store: wait until it has returned",
                        error.path)
        return Busy(f"{verb}: {count} array{' without a copy is' if count == 1 else 's without a copy are'}"
                    f" alive: delete {'it' if count == 1 else 'them'}, or keep numpy.array(...) of "
                    f"{'it' if count == 1 else 'them'} instead", error.path)

    def visit(self, function, reads=(), writes=(), rings=False, level=None, progress=None):
        """Computes on every vertex of the levels up to `level`, base vertices too, in one pass over
        the files, with memory for one batch.

        function: called with Vertices, many at once. It fills the attributes that the visit writes,
            or returns the records if the visit writes one. If it does neither for an attribute that
            the visit only writes, the visit ends with InvalidArgument. If it returns False, the visit
            ends with Cancelled.
        reads, writes: names of attributes. One that is in both is changed in place.
        rings: True: function also gets the neighbours of each vertex for all attributes in reads; a
            list of names: for these.
        level: default the finest one, which all attributes must have.
        progress: True for a bar, or a function of (phase, done, total).

        An attribute whose rings are read cannot be written: write to another one, and then call
        replace_attribute(). After an error the levels and base records that were written cannot be
        read until a pass has written them again, or roll_back() was called.
        """
        visited = visits.visited_attributes(self._attribute_info, reads, writes, rings)
        level = types.FINEST_LEVEL if level is None else _reading.whole("level", level)
        visits.visit(self._store(), self._change, visited, function, level, progress)

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
        for name in names:
            self._attribute_info(name)
        writer = writing.PatchWriter(self._change, known, self._raw_info().base_level, names,
                                     first_level, last_level, compare)
        self._patch_writers.add(writer)
        return writer

    def add_attribute(self, name, dtype=np.float32, components=1, level=None):
        """Adds an attribute whose records are zeros.

        name: 1 to 255 characters of [A-Za-z0-9_-]. dtype: of a component: int8 to int64, uint8 to
        uint64, float32 or float64. components: numbers in a record, 1 to 255. level: its finest one;
        None: the finest one of the store.
        """
        known = {name: number for number, name in types.TYPES.items()}
        wanted = _records.type_name(dtype, known)
        components = _reading.whole("components", components)
        if not 1 <= components <= 255:
            raise InvalidArgument(f"components: expected 1 to 255, found {components}")
        level = self.levels[-1] if level is None else _reading.whole("level", level)
        self._change(LIBRARY.plait_store_add_attribute, text(name), known[wanted], components, level)

    def remove_attribute(self, name):
        """Removes an attribute with its levels."""
        self._attribute_info(name)
        self._change(LIBRARY.plait_store_remove_attribute, text(name))

    def replace_attribute(self, name, replacement):
        """Removes attribute `name`; attribute `replacement` gets its name."""
        self._attribute_info(name)
        self._attribute_info(replacement)
        self._change(LIBRARY.plait_store_replace_attribute, text(name), text(replacement))

    def set_pipeline(self, name, pipeline):
        """Sets the pipeline of levels that later calls add to the attribute, such as
        "shuffle,zstd:1"; ranges of levels may have others: "shuffle,zstd:1;@1-3=lz4"."""
        self._attribute_info(name)
        self._change(LIBRARY.plait_store_set_pipeline, text(name), text(pipeline))

    def recode_attribute(self, name, pipeline):
        """Encodes all levels of an attribute anew with another pipeline, or several, as for
        set_pipeline(). The records stay as they are."""
        self._attribute_info(name)
        self._change(LIBRARY.plait_store_recode_attribute, text(name), text(pipeline))

    def set_base_records(self, name, records):
        """Writes the records of the base vertices, in the order of store.base.vertices: shape
        (vertices,) or (vertices, components). Numbers must fit the dtype of the attribute."""
        info = self._attribute_info(name)
        _notes.set_base_records(self._change, info, records)

    # ---- Notes

    @property
    def texts(self):
        """What people note about the store, such as units and author: a dict of texts by name."""
        return _notes.Snapshot(_notes.texts(self._store()), "set_text() changes the store")

    def set_text(self, name, value):
        """Notes a text, which the next commit records. None or "" removes it. name: 1 to 255
        characters of [A-Za-z0-9_-]. value: at most 64 KiB."""
        self._change(LIBRARY.plait_store_set_text, text(name), text(value))

    @property
    def face_attributes(self):
        """Attributes of the base faces, such as materials: a dict of read-only arrays by name, with
        one number for each face, in the order of store.base.triangles."""
        return _notes.Snapshot(_notes.face_attributes(self._store(), self._raw_info().face_count),
                               "set_face_attribute() changes the store")

    def set_face_attribute(self, name, numbers, dtype=None):
        """Writes an attribute of the base faces, and adds it if it is new.

        numbers: one for each face, in the order of store.base.triangles; of your own array by face of
        the input, array[store.input.input_faces]. dtype: None takes that of the attribute, or the
        smallest one that has the numbers.
        """
        _notes.set_face_attribute(self, name, numbers, dtype)

    def remove_face_attribute(self, name):
        """Removes an attribute of the base faces."""
        self._change(LIBRARY.plait_store_remove_face_attribute, text(name))

    # ---- Work on the whole store

    def subdivide(self, levels, scheme="loop", normals=False, limit=False, executor="auto",
                  threads=1, progress=None):
        """Refines "position" from its finest level to level `levels`, and leaves the commit to the caller.

        scheme: "loop", "butterfly" or "midpoint". normals: also makes attribute "normal", of unit
        length. limit: projects positions to the limit surface. executor: "auto", "fused", "sweep" or
        "transparent". threads: 0 for all processors. progress: True for a bar, or a function of
        (phase, done, total) whose False cancels. After an error that is no refusal, call roll_back():
        until then nobody can read or commit what is unfinished. Warns if float32 is too coarse for the
        vertices of that level.
        """
        with Watch("subdivide", progress) as watch:
            options = types.plait_subdivide_options(
                scheme=text(scheme), executor=text(executor), progress=watch.callback,
                warn=watch.warning(None), levels=_reading.whole("levels", levels), threads=threads, normals=int(normals),
                limit=int(limit))
            self._change(LIBRARY.plait_store_subdivide, byref(options))

    def commit(self):
        """Publishes all changes as the next version, if anything has changed."""
        self._change(LIBRARY.plait_store_commit, keeps=True)
        self._lost = False

    def roll_back(self):
        """Brings the store back to its last commit. Patch writers that were not finished end."""
        self._end_patch_writers()
        self._change(LIBRARY.plait_store_roll_back, keeps=True)
        self._lost = False

    def write_bounds(self, attribute="position", progress=None):
        """Computes where the patches are, and keeps it in a file of the store, so that boxes and
        rays need not read the surface first. progress: as for visit()."""
        with Watch("bounds", progress) as watch:
            self._change(LIBRARY.plait_store_write_bounds, text(attribute), watch.callback, None,
                         keeps=True)

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
            self._store().call(LIBRARY.plait_store_verify, watch.callback,
                               types.plait_damage(watch.guard(keep)), None, byref(report))
        return VerifyReport(report.blocks, report.bytes, report.never_written,
                            report.damaged_count, damaged)

    def digest(self, level=None, threads=1, progress=None):
        """32 hexadecimal digits that depend on all records of a level, or of all levels, and not on
        backend, layout or executor."""
        digits = ctypes.create_string_buffer(types.DIGEST_BYTES)
        with Watch("digest", progress) as watch:
            self._store().call(LIBRARY.plait_store_digest,
                               types.ALL_LEVELS if level is None else level, threads,
                               watch.callback, None, digits)
        return digits.value.decode()

    def close(self):
        """Closes the store, with all that it has open, and releases the lock of the writer. Changes
        since the last commit are lost: then Python warns (ResourceWarning). Arrays stay valid; a file
        stays open while an array without a copy points into it."""
        self._close(warns=True)

    def _close(self, warns):
        if self._changing:
            raise BadState(f"close {self._absolute or 'a store in memory'}: a call that changes the "
                           "store is under way: wait until it has returned", self._where())
        for shown in list(self._shown):
            shown.close()
        with self._lock:
            handle, self._handle = self._handle, None
        self._end_patch_writers()
        self._end_readers()
        if handle is not None:
            handle.end()
        if self._lost and self._absolute and warns:
            warnings.warn(self._losing("closed"), ResourceWarning, stacklevel=3)
        self._lost = False

    def _losing(self, what):
        return (f"{self._absolute}: {what} without commit(): the changes since the last commit are lost; "
                "call commit(), or roll_back() if that is meant")

    def __del__(self, warn=warnings.warn, kind=ResourceWarning):
        if getattr(self, "_lost", False) and self._absolute and self._handle is not None:
            warn(self._losing("given up"), kind, source=self)

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        self._close(warns=kind is None)

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
        raise error if error.path else error.about(os.fsdecode(path))
    store = Store(_handles.store(address.value), os.fsdecode(path), options.budget_bytes, io_threads)
    for line in store._raw_info().notices.decode(errors="replace").splitlines():
        warnings.warn(line, RuntimeWarning, stacklevel=2)
    return store
