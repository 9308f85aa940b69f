"""Patch writers, and stores that are made of a program's own meshes."""

import os
import threading

import numpy as np
import plait
import pytest
from conftest import icosahedron, make, sheet, write_ply


def test_patches_that_are_written_read_back(tmp_path):
    with make(icosahedron(), tmp_path / "s.plait", levels=3, scheme="loop") as store:
        store.add_attribute("copy", np.float32, 3)
        faces = range(20)
        patches = [store.patch(face) for face in faces]
        with store.patch_writer("copy", compare=True) as writer:
            for face in reversed(faces):
                writer.write_patch("copy", face, 3, patches[face].astype(float))
        store.commit()
        for level in store.levels:
            assert np.array_equal(store["copy"][level][:], store["position"][level][:])


def test_two_threads_write_one_store(tmp_path):
    store = make(icosahedron(), levels=4, scheme="loop")
    patches = [store.patch(face) for face in range(20)]
    store.add_attribute("copy", np.float32, 3)
    with store.patch_writer(["copy"]) as writer:
        def write(faces):
            for face in faces:
                writer.write_patch("copy", face, 4, patches[face])
        threads = [threading.Thread(target=write, args=(range(first, 20, 2),)) for first in (0, 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert np.array_equal(store["copy"][4][:], store["position"][4][:])


def test_writer_fills_one_level_after_another():
    store = make(sheet(2), levels=2)
    store.add_attribute("level", np.int16)
    for level in store.levels:
        with store.patch_writer("level", first_level=level, last_level=level) as writer:
            count = len(plait.triangles(level)) and len(store.patch(0, level=level))
            for face in range(8):
                writer.write_level("level", face, level, np.full(count, level, np.int16))
    for level in store.levels:
        assert (store["level"][level][:] == level).all()


def test_missing_and_wrong_patches_are_refused():
    store = make(sheet(2), levels=2)
    store.add_attribute("height", np.float32)
    writer = store.patch_writer("height", compare=True)
    with pytest.raises(plait.InvalidArgument, match=r"expected records of shape \(15,\)"):
        writer.write_patch("height", 0, 2, np.zeros(14))
    with pytest.raises(plait.InvalidArgument, match="expected float32, found complex128"):
        writer.write_patch("height", 0, 2, np.zeros(15, complex))
    with pytest.raises(plait.NotFound):
        writer.write_patch("depth", 0, 2, np.zeros(15))
    for face in range(7):
        writer.write_patch("height", face, 2, np.zeros(15))
    with pytest.raises(plait.InvalidArgument, match="height"):
        writer.write_patch("height", 7, 2, np.ones(15))
    with pytest.raises(plait.BadState, match="height"):
        writer.finish()
    with pytest.raises(plait.BadState):
        store["height"][2][:]
    writer.write_patch("height", 7, 2, np.zeros(15))
    writer.finish()
    assert (store["height"][2][:] == 0).all()
    with pytest.raises(plait.BadState):
        writer.write_patch("height", 0, 2, np.zeros(15))


def test_an_exception_in_the_block_is_not_hidden():
    store = make(sheet(2), levels=2)
    store.add_attribute("height", np.float32)
    with pytest.raises(ZeroDivisionError):
        with store.patch_writer("height"):
            raise ZeroDivisionError
    with pytest.raises(plait.BadState):
        store["height"][2][:]


def test_import_finds_the_levels(tmp_path):
    with make(icosahedron(), levels=3, scheme="loop") as store:
        mesh = store.mesh()
    order = np.random.default_rng(1).permutation(len(mesh.triangles))
    write_ply(tmp_path / "fine.ply", (mesh.vertices, mesh.triangles[order]))
    seen = []
    done = plait.import_mesh(tmp_path / "fine.ply", tmp_path / "fine.plait", threads=2,
                             progress=lambda *now: seen.append(now))
    assert (done.levels, done.base_vertices, done.base_faces) == (3, 12, 20)
    assert (done.vertices, done.faces, done.border_edges) == (642, 1280, 0) and seen
    with plait.open(done.path) as store:
        assert np.array_equal(np.unique(store.mesh().vertices, axis=0),
                              np.unique(mesh.vertices, axis=0))
    with pytest.raises(plait.InvalidArgument, match="level"):
        plait.import_mesh(tmp_path / "fine.ply", tmp_path / "more.plait", levels=4)
    with pytest.raises(plait.InvalidArgument):
        plait.import_mesh(tmp_path / "fine.ply", tmp_path / "fine.plait")
    plait.import_mesh(tmp_path / "fine.ply", tmp_path / "fine.plait", 2, existing="replace")
    assert list(plait.open(tmp_path / "fine.plait").levels) == [0, 1, 2]
    assert sorted(os.listdir(tmp_path)) == ["fine.plait", "fine.ply"]


def test_remesh_makes_a_store_of_any_mesh(tmp_path):
    with make(icosahedron(), levels=4, scheme="loop") as store:
        mesh = store.mesh()
    write_ply(tmp_path / "scan.ply", (mesh.vertices, mesh.triangles))
    done = plait.remesh(tmp_path / "scan.ply", tmp_path / "scan.plait", faces=80, levels=3,
                        samples=2000, digest=True)
    assert done.scan_faces == 5120 and done.base_faces <= 81 and done.turned_faces == 0
    assert done.faces == done.base_faces * 64
    assert 0 < done.scan_to_store_rms <= done.scan_to_store_max < 0.01 * done.diagonal
    with plait.open(done.path) as store:
        assert store.counts(3).vertices == done.vertices and store.digest() == done.digest
    found = plait.compare(tmp_path / "scan.ply", done.path, samples=2000, threads=2)
    assert found.diagonal == done.diagonal and found.there.samples == 2000
    assert 0 < found.there.rms <= found.there.max < 0.01 * done.diagonal
    coarse = plait.compare(tmp_path / "scan.ply", done.path, level=0, samples=2000)
    assert coarse.back.rms > 10 * found.back.rms
    same = plait.compare(tmp_path / "scan.ply", tmp_path / "scan.ply", samples=100)
    assert same.there.max == same.back.max == pytest.approx(0, abs=1e-7)
    with pytest.raises(plait.Cancelled):
        plait.compare(tmp_path / "scan.ply", done.path, progress=lambda *_: False)
    with pytest.raises(plait.InvalidArgument, match="level"):
        plait.compare(tmp_path / "scan.ply", done.path, level=7)
    with pytest.raises(plait.Cancelled):
        plait.remesh(tmp_path / "scan.ply", tmp_path / "no.plait", 80, progress=lambda *_: False)
    assert sorted(os.listdir(tmp_path)) == ["scan.plait", "scan.ply"]
