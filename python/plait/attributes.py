"""Attributes of a store, and their levels as arrays."""

from typing import NamedTuple

import numpy as np

from . import _keys, _memory
from ._reading import frozen
from .errors import Error, NoSuchLevel

_PIECE_BYTES = 4 << 20  # read at once where only a part is kept
_NEAR_BYTES = 64 << 10  # a gap that is cheaper to read than to leave out


class Block(NamedTuple):
    """One block of a level.

    first: the number of its first vertex among those that the level creates.
    records: read-only, shape (count,) or (count, components).
    """

    first: int
    records: np.ndarray


class Attribute:
    """One attribute of a store: attribute[level] is the array of a level, attribute[-1] that of the
    finest one.

    It holds nothing open: it asks the store whenever it is used, so it shows what the store has now.
    """

    # What else is set on it would be lost, so it is refused.
    __slots__ = ("_store", "name", "__weakref__")

    def __init__(self, store, name):
        self._store = store
        self.name = name

    @property
    def dtype(self):
        """The numpy dtype of a component."""
        return self._store._reader(self.name).dtype

    @property
    def components(self):
        """Numbers in a record."""
        return self._store._reader(self.name).components

    @property
    def levels(self):
        """A range: the levels that it has, from the base level on."""
        reader = self._store._reader(self.name)
        return range(reader.base_level, reader.finest_level + 1)

    def __getitem__(self, level):
        """The vertices that `level` creates; for the base level, the base vertices. Those of coarser
        levels are not among them: see upto()."""
        return LevelArray(self._store, self.name, self._level(level))

    def _level(self, level):
        levels = self.levels
        found = _keys.operator.index(level)
        found += len(levels) + levels[0] if found < 0 else 0
        if found not in levels:
            raise NoSuchLevel(f"level {level} of '{self.name}': expected {levels[0]} to "
                              f"{levels[-1]}", self._store._where())
        return found

    def upto(self, level=None, memory=_memory.DEFAULT_LIMIT):
        """The records of all vertices of the mesh at `level`: those that the base level creates, then
        those of each finer level. A read-only array.

        level: default the finest one. memory: refuses to return more bytes; a number or a text such
        as "4GiB".
        """
        last = self._level(-1 if level is None else level)
        parts = [self[each] for each in range(self.levels[0], last + 1)]
        count = sum(map(len, parts))
        shape = (count,) + parts[0].shape[1:]
        needed = int(np.prod(shape, dtype=np.int64)) * parts[0].dtype.itemsize
        _memory.check(f"'{self.name}' up to level {last}", needed, memory, "take a coarser level")
        records = np.empty(shape, parts[0].dtype)
        first = 0
        for part in parts:
            for block in part.blocks():
                records[first:first + len(block.records)] = block.records
                first += len(block.records)
        return frozen(records)

    def __contains__(self, level):
        return level in self.levels

    def __len__(self):
        return len(self.levels)

    def __iter__(self):
        return (self[level] for level in self.levels)

    def __copy__(self):
        return Attribute(self._store, self.name)

    def __deepcopy__(self, _):
        return Attribute(self._store, self.name)

    def __reduce__(self):
        return _attribute_again, (self._store._identity("an attribute"), self.name)

    def __repr__(self):
        try:
            levels = self.levels
            return (f"<plait attribute '{self.name}': {self.dtype} x {self.components}, levels "
                    f"{levels[0]} to {levels[-1]}>")
        except Error as error:
            return f"<plait attribute '{self.name}': {error}>"


class LevelArray:
    """The records of the vertices that one level creates, in the order of the file, as an array
    whose content stays in the store until somebody slices it.

    It takes the keys of numpy, and holds nothing open: it asks the store whenever it is used.

    Slices are read-only numpy arrays, and have only what was asked for. With backend memory, and with
    mmap in a store that was opened for reading, a slice of consecutive vertices is no copy; it stays
    valid after the store is closed. While such a slice exists, the store cannot be changed.
    """

    # What else is set on it would be lost, so it is refused.
    __slots__ = ("_store", "name", "level", "__weakref__")

    def __init__(self, store, name, level):
        self._store = store
        self.name = name
        self.level = level

    @property
    def _reader(self):
        return self._store._reader(self.name)

    @property
    def dtype(self):
        """The numpy dtype of a component."""
        return self._reader.dtype

    @property
    def shape(self):
        """(vertices,) for records of one component, else (vertices, components)."""
        reader = self._reader
        return reader.shape(reader.vertex_count(self.level))

    @property
    def ndim(self):
        """1 or 2."""
        return len(self.shape)

    @property
    def size(self):
        """Numbers in all records."""
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def nbytes(self):
        """Bytes of all records."""
        return self.size * self.dtype.itemsize

    @property
    def chunks(self):
        """The sizes of the blocks in each dimension, as dask takes chunks: reads of whole chunks are
        the fastest."""
        edges = np.append(self._reader.block_starts(self.level), len(self))
        blocks = tuple(int(size) for size in np.diff(edges) if size > 0)
        return (blocks,) + tuple((size,) for size in self.shape[1:])

    def blocks(self):
        """Yields the blocks of the level, one after another, as named tuples (first, records)."""
        first = 0
        for count in self.chunks[0]:
            yield Block(first, self._reader.vertices(self.level, first, count))
            first += count

    def __len__(self):
        return self._reader.vertex_count(self.level)

    def __getitem__(self, key):
        reader = self._reader
        count = reader.vertex_count(self.level)
        if isinstance(key, slice):  # the usual case first: the others take microseconds to tell
            first, after, step = key.indices(count)
            if step == 1:
                return reader.vertices(self.level, first, max(after - first, 0))
        shape = reader.shape(count)
        parts, place = _keys.elements(key, len(shape))
        of_rows, rest = parts[place], parts[place + 1:]
        if isinstance(of_rows, slice):
            if place == 0:  # at most one element of the rest picks components
                return self._stretched(reader, range(*of_rows.indices(count)), tuple(rest))
            records, local = self._stretched(reader, range(*of_rows.indices(count)), ()), slice(None)
        elif isinstance(of_rows, int):
            number = _keys.checked(np.array([of_rows]), count)
            records, local = self._picked(reader, number), 0
        elif of_rows.dtype == bool:
            rows = _keys.masked(of_rows, shape)
            records = self._picked(reader, rows)
            local = np.ones(len(rows), bool) if of_rows.ndim == 1 else of_rows[rows]
        else:
            records = self._picked(reader, _keys.checked(of_rows, count).ravel())
            local = np.arange(len(records)).reshape(of_rows.shape)
        parts[place] = local
        picked = records[tuple(parts)]
        if not isinstance(picked, np.ndarray):
            return picked
        return frozen(picked.copy() if picked.nbytes < records.nbytes else picked)

    def _stretched(self, reader, rows, rest):
        """Vertices of a range, in pieces: memory for what is kept, and not for what lies between."""
        if rows.step == 1 and all(isinstance(each, slice) and each == slice(None) for each in rest):
            return reader.vertices(self.level, rows.start, len(rows))
        if abs(rows.step) * reader.record_bytes > _NEAR_BYTES and not rest:
            return self._picked(reader, np.arange(rows.start, rows.stop, rows.step))
        tail = (slice(None),) + rest
        records = np.empty((len(rows),) + np.empty(reader.shape(1))[tail].shape[1:], reader.dtype)
        ascending, target = (rows, records) if rows.step > 0 else (rows[::-1], records[::-1])
        at_once = max(1, _PIECE_BYTES // (reader.record_bytes * ascending.step))
        for first in range(0, len(ascending), at_once):
            piece = ascending[first:first + at_once]
            there = reader.vertices(self.level, piece[0], piece[-1] - piece[0] + 1)
            target[first:first + len(piece)] = there[::piece.step][tail]
        return frozen(records)

    def _picked(self, reader, wanted):
        """Vertices of a list: those that are near each other are read together."""
        order = np.argsort(wanted, kind="stable")
        ascending = wanted[order]
        near = max(1, _NEAR_BYTES // reader.record_bytes)
        pieces = ascending // max(1, _PIECE_BYTES // reader.record_bytes)
        cuts = np.flatnonzero((np.diff(ascending) > near) | (np.diff(pieces) > 0)) + 1
        records = np.empty(reader.shape(wanted.size), reader.dtype)
        if wanted.size:
            for stretch, places in zip(np.split(ascending, cuts), np.split(order, cuts)):
                first = int(stretch[0])
                there = reader.vertices(self.level, first, int(stretch[-1]) - first + 1)
                records[places] = there[stretch - first]
        return frozen(records)

    def __array__(self, dtype=None, copy=None):
        whole = self[:]
        if dtype is not None and np.dtype(dtype) != whole.dtype:
            return whole.astype(dtype)
        return whole.copy() if copy else whole

    @property
    def __array_interface__(self):
        whole = self[:]
        return {"version": 3, "shape": whole.shape, "typestr": whole.dtype.str,
                "data": memoryview(whole)}

    def __iter__(self):
        for block in self.blocks():
            yield from block.records

    def __copy__(self):
        return LevelArray(self._store, self.name, self.level)

    def __deepcopy__(self, _):
        return LevelArray(self._store, self.name, self.level)

    def __reduce__(self):
        return _level_again, (self._store._identity("a level"), self.name, self.level)

    def __dask_tokenize__(self):
        return "plait.LevelArray", self._store._token(), self.name, self.level

    def __repr__(self):
        try:
            return (f"<plait level {self.level} of '{self.name}': {self.dtype}, shape {self.shape}, "
                    f"{self.nbytes} bytes>")
        except Error as error:
            return f"<plait level {self.level} of '{self.name}': {error}>"


def _attribute_again(identity, name):
    """The attribute of a pickle."""
    from ._identity import shared
    return shared(identity)[name]


def _level_again(identity, name, level):
    """The level of a pickle."""
    return _attribute_again(identity, name)[level]
