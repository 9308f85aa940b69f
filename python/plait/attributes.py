"""Attributes of a store, and their levels as arrays."""

from typing import NamedTuple

import numpy as np

from .errors import NotFound


class Block(NamedTuple):
    """One block of a level.

    first: the number of its first vertex among those that the level creates.
    records: read-only, shape (count,) or (count, components).
    """

    first: int
    records: np.ndarray


class Attribute:
    """One attribute of a store: attribute[level] is the array of a level.

    name: as in the store. dtype: of a component. components: numbers in a record.
    levels: the levels that it has, from the base level on.
    """

    def __init__(self, reader, path):
        self._reader = reader
        self._path = path
        self.name = reader.name
        self.dtype = reader.dtype
        self.components = reader.components
        self.levels = range(reader.base_level, reader.finest_level + 1)

    def __getitem__(self, level):
        """The vertices that `level` creates; for the base level, the base vertices."""
        if level not in self.levels:
            raise NotFound(f"level {level} of '{self.name}': expected {self.levels[0]} to "
                           f"{self.levels[-1]}", self._path)
        return LevelArray(self._reader, int(level), self._path)

    def __len__(self):
        return len(self.levels)

    def __iter__(self):
        return (self[level] for level in self.levels)

    def __repr__(self):
        return (f"<plait attribute '{self.name}': {self.dtype} x {self.components}, levels "
                f"{self.levels[0]} to {self.levels[-1]}>")


class LevelArray:
    """The records of the vertices that one level creates, in the order of the file, as an array
    whose content stays in the store until somebody slices it.

    shape: (vertices,) for records of one component, else (vertices, components).
    chunks: the blocks of the level, as dask takes chunks: reads of whole chunks are the fastest.

    Slices are read-only numpy arrays. With backend memory, and with mmap in a store that was opened
    for reading, a slice of consecutive vertices is no copy; it stays valid after the store is
    closed. While such a slice exists, the store cannot be changed.
    """

    def __init__(self, reader, level, path):
        self._reader = reader
        self._path = path
        self.level = level
        self.dtype = reader.dtype
        self.shape = reader.shape(reader.vertex_count(level))
        self.ndim = len(self.shape)
        self.size = int(np.prod(self.shape, dtype=np.int64))
        self.nbytes = self.size * self.dtype.itemsize
        self._chunks = None

    @property
    def name(self):
        """The name of the attribute."""
        return self._reader.name

    @property
    def chunks(self):
        """The sizes of the blocks in each dimension, as dask takes them."""
        if self._chunks is None:
            edges = np.append(self._reader.block_starts(self.level), len(self))
            blocks = tuple(int(size) for size in np.diff(edges) if size > 0)
            self._chunks = (blocks,) if self.ndim == 1 else (blocks, (self.shape[1],))
        return self._chunks

    def blocks(self):
        """Yields the blocks of the level, one after another, as named tuples (first, records)."""
        first = 0
        for count in self.chunks[0]:
            yield Block(first, self._reader.vertices(self.level, first, count))
            first += count

    def __len__(self):
        return self.shape[0]

    def __getitem__(self, key):
        if isinstance(key, slice):  # the usual case first: the others take a microsecond to tell
            first, after, step = key.indices(self.shape[0])
            if step == 1:
                return self._reader.vertices(self.level, first, max(after - first, 0))
            return self._rows(key)
        if key is Ellipsis or isinstance(key, tuple) and not key:
            key = slice(None)
        key, rest = (key[0], key[1:]) if isinstance(key, tuple) else (key, ())
        if key is Ellipsis:  # the dimension of the components, as in array[..., 0]
            return self._rows(slice(None))[(Ellipsis,) + rest]
        rows = self._rows(key)
        if not rest:
            return rows
        if any(isinstance(each, (list, np.ndarray)) for each in rest) and not isinstance(
                key, (int, np.integer, slice)):
            raise IndexError("expected a list in one dimension, found lists in several: pick the "
                             "vertices first")
        return rows[rest if isinstance(key, (int, np.integer)) else (slice(None),) + rest]

    def _rows(self, key):
        if isinstance(key, (int, np.integer)):
            if not -len(self) <= key < len(self):
                raise IndexError(f"vertex {key}: expected -{len(self)} to {len(self) - 1}")
            return self._reader.vertices(self.level, int(key) % len(self), 1)[0]
        if isinstance(key, slice):
            picked = range(*key.indices(len(self)))
            if not picked:
                return self._reader.vertices(self.level, 0, 0)
            low, high = min(picked[0], picked[-1]), max(picked[0], picked[-1])
            records = self._reader.vertices(self.level, low, high - low + 1)
            step = picked.step
            return records[::step] if step > 0 else records[::-1][::-step]
        return self._picked(np.asarray(key))

    def _picked(self, wanted):
        """Vertices of a list or a mask: each stretch of neighbours is read once."""
        if wanted.dtype == bool:
            if wanted.shape != (len(self),):
                raise IndexError(f"mask: expected shape {(len(self),)}, found {wanted.shape}")
            wanted = np.flatnonzero(wanted)
        if wanted.size == 0:
            return np.empty(wanted.shape + self.shape[1:], self.dtype)
        if wanted.dtype.kind not in "iu":
            raise IndexError(f"expected whole numbers or a mask, found {wanted.dtype}")
        if wanted.min() < -len(self) or wanted.max() >= len(self):
            raise IndexError(f"expected -{len(self)} to {len(self) - 1}, found {wanted.min()} to "
                             f"{wanted.max()}")
        flat = wanted.astype(np.int64).ravel() % len(self)
        order = np.argsort(flat, kind="stable")
        ascending = flat[order]
        near = max(1, (64 << 10) // self._reader.record_bytes)  # a gap that is cheaper to read
        cuts = np.flatnonzero(np.diff(ascending) > near) + 1
        records = np.empty((flat.size,) + self.shape[1:], self.dtype)
        for stretch, places in zip(np.split(ascending, cuts), np.split(order, cuts)):
            first = int(stretch[0])
            there = self._reader.vertices(self.level, first, int(stretch[-1]) - first + 1)
            records[places] = there[stretch - first]
        records.flags.writeable = False
        return records.reshape(wanted.shape + self.shape[1:])

    def __array__(self, dtype=None, copy=None):
        whole = self[:]
        return whole if dtype is None or np.dtype(dtype) == self.dtype else whole.astype(dtype)

    @property
    def __array_interface__(self):
        whole = self[:]
        return {"version": 3, "shape": self.shape, "typestr": self.dtype.str,
                "data": memoryview(whole)}

    def __iter__(self):
        for block in self.blocks():
            yield from block.records

    def __reduce__(self):
        if not self._path:
            raise TypeError("a store in memory cannot be pickled: it has no path")
        return _reopened, (self._path, self.name, self.level)

    def __repr__(self):
        return (f"<plait level {self.level} of '{self.name}': {self.dtype}, shape {self.shape}, "
                f"{self.nbytes} bytes>")


def _reopened(path, name, level):
    from .store import open_store
    return open_store(path)[name][level]
