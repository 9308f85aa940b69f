"""Attributes and their levels as arrays."""

import pickle
import threading

import numpy as np
import plait
import pytest
from conftest import TETRAHEDRON, icosahedron, make, sheet
from plait import _reading


def test_level_has_the_properties_of_an_array(surface):
    level = surface["position"][3]
    # Each of the 30 edges has 16 vertices of level 3.
    assert level.shape == (480, 3) and level.ndim == 2 and level.dtype == np.float32
    assert level.nbytes == 480 * 12 and len(level) == 480 and level.size == 1440
    assert list(surface.levels) == [0, 1, 2, 3]
    assert set(surface.attributes) == {"position", "normal"}
    assert list(surface["normal"].levels) == [0, 1, 2, 3]


def test_slices_are_those_of_the_whole(surface):
    level = surface["position"][3]
    whole = np.array(level)
    assert whole.shape == level.shape
    for key in (slice(None), slice(5, 300), slice(-7, None), slice(400, 20, -3), slice(0, 480, 7),
                slice(9, 9), 17, -1, Ellipsis, (slice(3, 90), 1), (5, 2), (slice(None), slice(0, 2)),
                (Ellipsis, 0), (), (slice(2, 5), [0, 2]), (7, [2, 0]), ([9, 1], 2), [4, 4, 470, 1], np.array([[1, 2], [300, 4]]), whole[:, 0] > 0):
        np.testing.assert_array_equal(level[key], whole[key])
    with pytest.raises(IndexError):
        level[480]
    with pytest.raises(IndexError):
        level[[0, 480]]
    with pytest.raises(IndexError):
        level[np.ones(3, bool)]
    with pytest.raises(IndexError):
        level[[0.5]]


def test_numpy_functions_take_a_level(surface):
    level = surface["normal"][2]
    assert np.allclose(np.linalg.norm(np.asarray(level), axis=1), 1, atol=1e-6)
    assert np.sum(level, axis=0).shape == (3,)
    assert np.array(level, np.float64).dtype == np.float64
    interface = level.__array_interface__
    assert interface["shape"] == level.shape and interface["typestr"] == "<f4"


def test_blocks_are_the_whole_and_chunks_are_their_sizes(surface):
    level = surface["position"][3]
    blocks = list(level.blocks())
    assert [len(block.records) for block in blocks] == list(level.chunks[0])
    assert [block.first for block in blocks] == list(np.cumsum((0,) + level.chunks[0][:-1]))
    np.testing.assert_array_equal(np.concatenate([block.records for block in blocks]), level[:])
    assert len(blocks) > 1  # 4,096 bytes are 21 slots of 16 records


def test_arrays_are_read_only_and_stay_after_close(surface):
    level = surface["position"][3]
    kept = [level[3:40], surface.patch(0), surface.patches([1, 2]).records, surface.base.vertices,
            surface.mesh(2).vertices, surface.faces_in_box([-2] * 3, [2] * 3),
            next(level.blocks()).records, level[[1, 5]]]
    before = [array.copy() for array in kept]
    surface.close()
    for array, copy in zip(kept, before):
        np.testing.assert_array_equal(array, copy)
        with pytest.raises(ValueError):
            array[...] = 0
    with pytest.raises(plait.BadState, match="closed"):
        surface.patch(0)


def test_slices_of_mapped_and_memory_stores_are_no_copies(tmp_path):
    memory = make(icosahedron(), levels=3)
    make(icosahedron(), tmp_path / "mapped.plait", levels=3, backend="mmap").close()
    make(icosahedron(), tmp_path / "read.plait", levels=3, backend="pread").close()
    mapped, read = plait.open(tmp_path / "mapped.plait"), plait.open(tmp_path / "read.plait")

    def address(store):
        return store["position"][3][10:20].__array_interface__["data"][0]

    def same(store):
        first, second = store["position"][3][10:20], store["position"][3][10:20]
        return np.shares_memory(first, second)

    assert same(memory) and same(mapped) and not same(read)
    for store in (memory, mapped, read):
        np.testing.assert_array_equal(store["position"][3][10:20], memory["position"][3][10:20])


def test_large_slices_have_the_places_in_a_page_that_blocks_have(tmp_path):
    make(icosahedron(), tmp_path / "large.plait", levels=8, backend="pread").close()
    level = plait.open(tmp_path / "large.plait")["position"][8]
    whole = np.concatenate([block.records for block in level.blocks()])
    for first, in_block in ((0, 0), (level.chunks[0][0] + 1000, 1000)):
        part = level[first:]
        assert part.nbytes >= 4 << 20 and part.flags.c_contiguous and not part.flags.writeable
        np.testing.assert_array_equal(part, whole[first:])
        assert part.__array_interface__["data"][0] % 4096 == in_block * 12 % 4096


def test_large_reads_write_what_they_return_and_nothing_beside(tmp_path):
    make(icosahedron(), tmp_path / "large.plait", levels=8, backend="pread").close()
    store = plait.open(tmp_path / "large.plait")
    level, faces = store["position"][8], np.arange(11, dtype=np.uint32)
    reader, patches = store._reader("position"), store.patches(faces, level=8).records
    whole = np.concatenate([block.records for block in level.blocks()])
    huge_page = 2 << 20
    room = np.empty(whole.nbytes + patches.nbytes + 2 * huge_page, np.uint8)

    def read(function, expected, after, *arguments):
        """Reads to where the array ends `after` bytes after the end of a huge page."""
        room[:] = 171
        at = (after - expected.nbytes - room.ctypes.data) % huge_page
        function(reader._reader.address, reader._name, *arguments, room.ctypes.data + at,
                 expected.nbytes)
        end = at + expected.nbytes
        assert expected.nbytes > 2 * huge_page
        assert (room[:at] == 171).all() and (room[end:] == 171).all()
        np.testing.assert_array_equal(room[at:end], expected.reshape(-1).view(np.uint8))

    for after in (0, 1, huge_page - 1, 4096, 12345):
        read(_reading._read_vertices, whole[1000:], after, 8, 1000, len(whole) - 1000)
        read(_reading._copy_patches, patches, after, faces.ctypes.data, len(faces), 8)
    room[:] = 171
    with pytest.raises(plait.InvalidArgument):
        _reading._read_vertices(reader._reader.address, reader._name, 8, 1000, len(whole),
                                room.ctypes.data, whole.nbytes)
    assert (room == 171).all()


def test_a_slice_without_copy_stands_in_the_way_of_changes():
    store = make(icosahedron(), levels=2)
    kept = store["position"][2][:5]
    with pytest.raises(plait.Busy, match="1 array without a copy is alive"):
        store.add_attribute("age")
    assert kept.shape == (5, 3)
    del kept
    store.add_attribute("age")
    assert "age" in store and store["age"][2].shape == (120,)


def test_scalars_have_one_dimension(tmp_path):
    store = make(TETRAHEDRON, levels=2)
    for dtype in (np.float64, np.int8, np.uint16, np.int64):
        name = np.dtype(dtype).name
        store.add_attribute(name, dtype)
        assert store[name][2].shape == (24,) and store[name][2].dtype == dtype
        assert not np.any(store[name][2])
    store.add_attribute("pair", np.int32, 2, level=1)
    assert store["pair"][1].shape == (6, 2) and list(store["pair"].levels) == [0, 1]
    store.remove_attribute("pair")
    with pytest.raises(KeyError):
        store["pair"]


def test_borders_give_blocks_of_several_sizes(tmp_path):
    make(sheet(4), tmp_path / "sheet.plait", levels=4, block_bytes=4096).close()
    level = plait.open(tmp_path / "sheet.plait")["position"][4]
    assert sum(level.chunks[0]) == len(level) and len(set(level.chunks[0])) > 1


def test_dask_takes_blocks_as_chunks(surface):
    array = pytest.importorskip("dask.array")
    level = surface["position"][3]
    lazy = array.from_array(level, chunks=level.chunks)
    assert lazy.numblocks == (len(level.chunks[0]), 1)
    np.testing.assert_allclose(lazy.max(axis=0).compute(scheduler="threads"),
                               np.asarray(level).max(axis=0))


def test_a_level_is_pickled_by_its_path(surface):
    level = surface["position"][2]
    if not surface.path:
        with pytest.raises(TypeError, match="memory"):
            pickle.dumps(level)
        return
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(level))[:], level[:])


def test_many_threads_read_one_store(surface):
    level = surface["position"][3]
    whole, failures = np.array(level), []

    def read(seed):
        numbers = np.random.default_rng(seed)
        for _ in range(200):
            first, after = sorted(numbers.integers(0, 481, 2))
            face = int(numbers.integers(0, 20))
            if not np.array_equal(level[first:after], whole[first:after]) or not np.array_equal(
                    surface.patch(face, 2), patches[face]):
                failures.append(seed)

    patches = [surface.patch(face, 2) for face in range(20)]
    threads = [threading.Thread(target=read, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures
