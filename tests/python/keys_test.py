"""Keys and numbers as numpy takes them, and the memory of what they pick."""

import random

import numpy as np
import plait
import pytest
from conftest import icosahedron, make


def keys(count):
    """Keys of all kinds, and pairs of them."""
    rng = random.Random(7)
    rows = [0, -1, count - 1, np.uint8(3), np.int8(-1), np.array(5), slice(None), slice(9, 2),
            slice(400, 3, -7), slice(None, None, 3), slice(None, None, -1), [], [5, 2, 2], (4, 1),
            np.array([[1, 2], [300, 4]]), np.array([], int), np.arange(count) % 5 == 0, [True] * count,
            np.ones(count - 1, bool), Ellipsis, None, 1.5, "x", [0.5], np.array([])]
    columns = [0, -1, 2, 3, slice(None), slice(None, None, -1), [0, 2], [], Ellipsis, None,
               np.array([True, False, True]), np.array(1)]
    yield from rows
    yield from ((), count, -count - 1, [count], [0, -count - 1])
    yield from ((row,) for row in rows)
    yield from ((row, column) for row in rows for column in columns)
    yield from ((rng.choice(rows), rng.choice(columns), rng.choice(columns)) for _ in range(300))
    yield np.arange(3 * count).reshape(count, 3) % 7 == 0
    yield None, slice(3, 5)
    yield [1, 2], [0, 1]


@pytest.mark.parametrize("backend", ["memory", "pread"])
def test_every_key_gives_what_numpy_gives(tmp_path, backend):
    store = make(icosahedron(), None if backend == "memory" else tmp_path / "s.plait", levels=3,
                 backend=backend, block_bytes=4096)
    store.add_attribute("one", np.int16)
    store.visit(lambda v: v.places % 30000, writes="one")
    for name in ("position", "one"):
        level = store[name][3]
        whole = np.array(level)
        for key in keys(len(level)):
            try:
                expected = whole[key]
            except (IndexError, TypeError, ValueError):
                with pytest.raises((IndexError, TypeError, ValueError)):
                    level[key]
                continue
            found = level[key]
            assert np.shape(found) == np.shape(expected), (name, key)
            np.testing.assert_array_equal(found, expected)
            assert np.asarray(found).dtype == expected.dtype
            if isinstance(found, np.ndarray):
                assert not found.flags.writeable, (name, key)


def test_a_truth_value_is_no_vertex(surface):
    for key in (True, np.bool_(False), np.array(True), (True, 0)):
        with pytest.raises(IndexError, match="is no key"):
            surface["position"][3][key]


def held(array):
    """The bytes that an array keeps in memory."""
    while array.base is not None and isinstance(array.base, np.ndarray):
        array = array.base
    return array.nbytes


def test_what_is_picked_holds_no_more(tmp_path, monkeypatch):
    from plait import attributes
    make(icosahedron(), tmp_path / "s.plait", levels=6, backend="pread", block_bytes=4096).close()
    level = plait.open(tmp_path / "s.plait")["position"][6]
    whole = np.array(level)
    monkeypatch.setattr(attributes, "_PIECE_BYTES", 8192)
    monkeypatch.setattr(attributes, "_NEAR_BYTES", 1024)
    largest = []
    read = type(level._reader).vertices

    def counted(reader, number, first, count):
        largest.append(count * reader.record_bytes)
        return read(reader, number, first, count)

    monkeypatch.setattr(type(level._reader), "vertices", counted)
    for key in (slice(None, None, 2), slice(None, None, 50), slice(None, None, 1000),
                slice(None, 7, -3), slice(9000, None, -700), (slice(None), 0), (slice(5, None), [2, 0]),
                (slice(None, None, 9), slice(1, 2)), np.arange(0, len(level), 3),
                np.arange(len(level)) % 4 == 1, [3, 30000, 4], (Ellipsis, 1)):
        del largest[:]
        found = level[key]
        np.testing.assert_array_equal(found, whole[key])
        assert held(found) == found.nbytes, key
        assert max(largest) <= 8192 + 12, key
    assert held(level[:, 0][:5]) < level.nbytes / 2


def test_visits_refuse_numbers_that_do_not_fit():
    store = make(icosahedron(), levels=2)
    for name, dtype, components in (("k", np.uint8, 1), ("i", np.int16, 1), ("f", np.float32, 1)):
        store.add_attribute(name, dtype, components)
    wrong = {"k": [lambda n: [1.7] * n, lambda n: [300] * n, lambda n: [-3] * n, lambda n: 1.5,
                   lambda n: np.full(n, 256, np.int64), lambda n: ["a"] * n],
             "i": [lambda n: np.full(n, 1_000_000), lambda n: np.full(n, 1j)],
             "f": [lambda n: np.full(n, 1e300), lambda n: np.full(n, 1j)]}
    for name, values in wrong.items():
        for value in values:
            with pytest.raises(plait.InvalidArgument, match=f"'{name}'"):
                store.visit(lambda v: value(len(v)), writes=name)
            with pytest.raises(plait.InvalidArgument, match=f"'{name}'"):
                store.visit(lambda v: v.__setitem__(name, value(len(v))), writes=name)
    store.visit(lambda v: [7] * len(v), writes="k")  # numbers that fit, of any type
    store.visit(lambda v: np.full(len(v), -5, np.int64), writes="i")
    store.visit(lambda v: np.full(len(v), 0.1), writes="f")
    assert (store["k"][2][:] == 7).all() and (store["i"][2][:] == -5).all()
    assert (store["f"][2][:] == np.float32(0.1)).all()


def test_truth_values_of_numpy_are_truth_values():
    store, whole = make(icosahedron(), levels=1), make(icosahedron(), levels=1)
    store.add_attribute("x")
    for no in (False, np.bool_(False), np.array(False)):
        with pytest.raises(plait.Cancelled):
            store.visit(lambda v: no, reads="position", writes="x")
        with pytest.raises(plait.Cancelled):
            whole.digest(progress=lambda *_: no)
    for yes in (True, np.bool_(True), np.array(True)):
        with pytest.raises(plait.InvalidArgument, match="returned True"):
            store.visit(lambda v: yes, reads="position", writes="x")
        whole.digest(progress=lambda *_: yes)


def test_patch_writers_refuse_whole_numbers_that_do_not_fit():
    store = make(icosahedron(), levels=1)
    store.add_attribute("i", np.int16)
    with store.patch_writer("i") as patches:
        for face in range(20):
            patches.write_patch("i", face, 1, np.full(6, -7, np.int64))
        for wrong in (np.full(6, 1_000_000), np.full(6, 40000, np.uint16)):
            with pytest.raises(plait.InvalidArgument, match="expected -32768 to 32767"):
                patches.write_patch("i", 0, 1, wrong)
        patches.write_patch("i", np.int64(0), np.uint8(1), np.full(6, 9, np.uint8))
    assert set(store["i"].upto()) == {-7, 9}


def test_arrays_of_the_caller_are_not_kept():
    store = make(icosahedron(), levels=2)
    mine = np.array([3, 4], np.uint32)
    for kept in (store.patches(mine).faces, store.mesh(faces=mine).faces):
        with pytest.raises(ValueError):
            kept[0] = 9
        mine[0] = 7
        assert kept[0] == 3
        mine[0] = 3


def test_masked_keys_are_refused():
    """What a masked array hides picks nothing and leaves nothing out: numpy takes what lies under it."""
    with make(icosahedron(), levels=1) as store:
        level = store["position"][1]
        points = np.ma.masked_greater(level[:], 0.5)
        for key in (points[:, 0] > 0, np.ma.masked_equal([0, 1, 2], 1)):
            with pytest.raises(plait.InvalidArgument, match="key: .* that are masked"):
                level[key]
