"""Attributes, levels and whatever else a program keeps hold nothing open: only an array without a copy
stands in the way of a change."""

import gc
import sys
import threading
import warnings

import numpy as np
import plait
import pytest
from conftest import TETRAHEDRON, icosahedron, make


def writer_with_handles(path, **options):
    """A store that is open for writing, and everything that a notebook may show of it."""
    store = make(icosahedron(), path, levels=2, **options)
    store.add_attribute("age", np.int16)
    store.commit()
    attribute, level = store["position"], store["position"][2]
    blocks = level.blocks()
    next(blocks)
    shown = [attribute, level, store.attributes, blocks, iter(attribute), store["age"], repr(level),
             store.statistics, store.info, level.chunks, level.shape]
    return store, shown


@pytest.mark.parametrize("backend", ["pread", "mmap", "compressed", "memory"])
def test_handles_do_not_stand_in_the_way_of_changes(tmp_path, backend):
    store, shown = writer_with_handles(None if backend == "memory" else tmp_path / "s.plait",
                                       backend=backend)
    level = shown[1]
    old = np.array(level)
    store.add_attribute("more", np.float32)
    store.visit(lambda v: v["position"] + 1, reads="position", writes="position")
    store.commit()
    np.testing.assert_array_equal(level, old + np.float32(1))
    with store.patch_writer("more") as patches:
        for face in range(20):
            patches.write_patch("more", face, 2, store.patch(face)[:, 0])
    store.replace_attribute("age", "more")
    assert shown[5].dtype == np.float32 and "age" in repr(shown[5])
    store.commit()
    store.remove_attribute("age")
    with pytest.raises(KeyError, match="no attribute 'age'"):
        shown[5].levels
    assert "no attribute 'age'" in repr(shown[5])
    store.roll_back()


def test_close_ends_what_is_ours_and_releases_the_lock(tmp_path):
    path = tmp_path / "s.plait"
    store, shown = writer_with_handles(path)
    patches = store.patch_writer("age")
    store.close()
    with plait.open(path, writable=True) as again:
        again.add_attribute("x")
        again.roll_back()
    for use in (lambda: shown[1][:], lambda: shown[0].levels,
                lambda: patches.write_patch("age", 0, 2, np.zeros(15, np.int16)),
                lambda: shown[1].shape, patches.finish, store.commit):
        with pytest.raises(plait.BadState, match="closed"):
            use()
    assert "closed" in repr(shown[1]) and "closed" in repr(shown[0])


def test_a_kept_exception_holds_nothing(tmp_path):
    """h5py/h5py#2539: a cell that failed leaves its frames in sys.last_traceback, and the file stayed
    locked until the kernel ended."""
    path = tmp_path / "s.plait"
    store = make(icosahedron(), path, levels=2)
    store.add_attribute("x")
    kept = []
    for fails in (lambda: store.patch(99), lambda: store["position"][2][9999],
                  lambda: store.visit(lambda v: v["none"], reads="position"),
                  lambda: store.visit(lambda v: 1 / 0, reads="position", writes="x"),
                  lambda: store.patch_writer("x").finish(), lambda: store.faces_in_box([0], [1])):
        try:
            fails()
        except Exception as error:
            kept.append((error, sys.exc_info()))
    assert len(kept) == 6
    store.roll_back()
    store.add_attribute("y")
    store.commit()
    store.close()
    plait.open(path, writable=True).close()
    assert kept


def test_a_level_of_a_closed_store_never_shows_another_one(tmp_path):
    """h5py/h5py#231: a closed dataset came back to life, because the next file got its identifier."""
    first = make(icosahedron(), tmp_path / "a.plait", levels=1)
    level = first["position"][1]
    first.close()
    others = [make(TETRAHEDRON, tmp_path / f"{n}.plait", levels=1) for n in range(4)]
    assert all(len(store["position"][1]) == 6 for store in others)
    with pytest.raises(plait.BadState, match="closed"):
        level[:]


def test_after_the_block_the_lock_is_free_and_the_level_says_closed(tmp_path):
    """h5py/h5py#2299, pydata/xarray#7187: a name that is left over from a `with` kept the file."""
    path = tmp_path / "s.plait"
    make(icosahedron(), path, levels=2).close()
    with plait.open(path, writable=True) as store:
        level = store["position"][2]
        part = level[3:9]
    with plait.open(path, writable=True):
        assert part.shape == (6, 3)
        with pytest.raises(plait.BadState, match="closed"):
            level[0]


def test_a_view_outlives_its_store_and_a_cycle_keeps_the_lock_until_it_is_collected(tmp_path):
    path = tmp_path / "s.plait"
    make(icosahedron(), path, levels=3).close()
    store = plait.open(path, writable=True)
    part = store["position"][3][:9]
    expected = part.copy()
    store.close()
    plait.open(path, writable=True).close()
    assert (part == expected).all()

    class Owner:
        pass
    owner = Owner()
    owner.store, owner.itself = plait.open(path, writable=True), owner
    owner.level = owner.store["position"][2]
    del owner
    gc.collect()
    plait.open(path, writable=True).close()


def test_busy_counts_the_arrays_that_python_has():
    store = make(icosahedron(), levels=2)
    level = store["position"][2]
    first, second, copy, row = level[:5], level[7:9], level[::3], level[3]
    with pytest.raises(plait.Busy, match="2 arrays without a copy are alive: delete them"):
        store.add_attribute("x")
    kept = first[1:3]  # a part of an array keeps the whole
    del first, second
    with pytest.raises(plait.Busy, match="1 array without a copy is alive: delete it"):
        store.visit(lambda v: v["position"], reads="position", writes="position")
    del kept
    store.add_attribute("x")
    assert len(copy) == 40 and row.shape == (3,)


def test_busy_says_that_this_process_is_the_writer(tmp_path):
    writer = make(icosahedron(), tmp_path / "s.plait", levels=1)
    with pytest.raises(plait.Busy, match="in use by this process, which writes it"):
        plait.open(tmp_path / "s.plait", writable=True)
    writer.close()


def test_close_within_a_call_that_changes_the_store_is_refused(tmp_path):
    store = make(icosahedron(), tmp_path / "s.plait", levels=2)
    store.add_attribute("x")
    with pytest.raises(plait.BadState, match="under way"):
        store.visit(lambda v: store.close(), reads="position", writes="x")
    store.visit(lambda v: v["position"][:, 0], reads="position", writes="x")
    store.commit()
    store.close()
    with plait.open(tmp_path / "s.plait") as again:
        assert "x" in again


def test_leaving_a_block_without_commit_warns(tmp_path):
    path = tmp_path / "s.plait"
    make(icosahedron(), path, levels=1).close()
    with pytest.warns(ResourceWarning, match="closed without commit") as warned:
        with plait.open(path, writable=True) as store:
            store.add_attribute("x")
    assert warned[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with plait.open(path, writable=True) as store:
            store.write_bounds()
            store.visit(lambda v: None, reads="position")
        with plait.open(path, writable=True) as store:
            store.add_attribute("y")
            store.commit()
        with plait.open(path, writable=True) as store:
            store.add_attribute("z")
            store.roll_back()
        with plait.open(path) as store:
            store["position"][1][:]
        with pytest.raises(ZeroDivisionError):
            with plait.open(path, writable=True) as store:
                store.add_attribute("z")
                1 / 0
        with plait.create(*icosahedron()) as store:
            store.subdivide(1)


def test_giving_up_a_store_without_commit_warns(tmp_path):
    """Nobody called close(): a script that ends, or forgets its store."""
    path = tmp_path / "s.plait"
    with pytest.warns(ResourceWarning, match="s.plait: given up without commit"):
        store = plait.create(*icosahedron(), path)
        store.subdivide(1, scheme="midpoint")
        del store
        gc.collect()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        store = plait.open(path, writable=True)
        store.add_attribute("x")
        store.commit()
        del store
        store = plait.create(*icosahedron())
        store.subdivide(1)
        del store
        gc.collect()



def test_a_thread_that_reads_while_the_store_is_closed_meets_no_freed_object(tmp_path):
    path = tmp_path / "s.plait"
    make(icosahedron(), path, levels=4, backend="pread", block_bytes=4096).close()
    for _ in range(20):
        store = plait.open(path, memory="64KiB")
        level, ended, begun = store["position"][4], [], threading.Event()

        def read():
            try:
                while True:
                    level[:]
                    begun.set()
            except plait.Error as error:
                ended.append(error)
            finally:
                begun.set()

        thread = threading.Thread(target=read)
        thread.start()
        begun.wait()
        store.close()
        thread.join()
        assert isinstance(ended[0], plait.BadState) and "closed" in str(ended[0])
    gc.collect()
