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
                # float64, and not one row after another in memory
                records = np.asfortranarray(patches[face].astype(float))
                writer.write_patch("copy", face, 3, records)
        store.commit()
        for level in store.levels:
            assert np.array_equal(store["copy"][level][:], store["position"][level][:])


def test_masked_numbers_are_refused(tmp_path):
    """A store has a number everywhere: what a masked array hides is not taken for one."""
    points, faces = icosahedron()
    hidden = np.ma.masked_array(points, mask=points > 0.9)
    number = f"{hidden.mask.sum()} that are masked"
    with pytest.raises(plait.InvalidArgument, match=number):
        plait.create(hidden, faces)
    plait.create(np.ma.masked_array(points), faces).close()  # nothing is masked
    with make(icosahedron(), tmp_path / "s.plait", levels=1) as store:
        store.add_attribute("height", np.float32)
        with store.patch_writer("height") as writer:
            with pytest.raises(plait.InvalidArgument, match="'height'.* found 1 that are masked"):
                writer.write_patch("height", 0, 1, np.ma.masked_equal(np.arange(6.0), 3))
            for face in range(20):
                writer.write_patch("height", face, 1, np.ones(6))
        with pytest.raises(plait.InvalidArgument, match="found 20 that are masked"):
            store.set_face_attribute("kind", np.ma.masked_all(20, np.uint8))


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
    store.add_attribute("at_once", np.int16)
    with store.patch_writer("at_once") as writer:
        for level in store.levels:
            for face in range(8):
                writer.write_level("at_once", face, level,
                                   np.full(len(store.patch(0, level=level)), level, np.int16))
    for level in store.levels:
        assert (store["at_once"][level][:] == level).all()


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
    for face in (8, -1, 1 << 32):
        with pytest.raises(plait.InvalidArgument, match=f"face {face}"):
            writer.write_patch("height", face, 2, np.zeros(15))
    with pytest.raises(plait.NoSuchAttribute):
        store.patch_writer("depth")
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
    plait.import_mesh(tmp_path / "fine.ply", tmp_path / "fine.plait", 2, force=True)
    assert list(plait.open(tmp_path / "fine.plait").levels) == [0, 1, 2]
    assert sorted(os.listdir(tmp_path)) == ["fine.plait", "fine.ply"]


def test_import_takes_the_options_of_the_program(tmp_path):
    with make(sheet(4), levels=3) as store:
        mesh = store.mesh()
    write_ply(tmp_path / "fine.ply", (mesh.vertices, mesh.triangles))
    done = plait.import_mesh(tmp_path / "fine.ply", tmp_path / "a.plait", 2, compress="small",
                             layout="given", precision="float64", block="64KiB", memory="8MiB")
    assert (done.base_level, done.base_faces, done.border_edges) == (0, 128, 32)
    with plait.open(done.path) as store:
        assert store.info.backend == "compressed" and store.info.block_bytes == 65536
        assert store.info.layout == "given" and store["position"].dtype == np.float64
        assert store.info.stored_bytes == done.stored_bytes
    done = plait.import_mesh(tmp_path / "fine.ply", tmp_path / "b.plait", backend="mmap",
                             max_slot=16 * 12)
    assert done.base_level > 0
    with plait.open(done.path) as store:
        assert store.info.backend == "mmap" and store.info.base_level == done.base_level


def test_import_says_what_is_odd_in_the_file(tmp_path):
    # A torus of seven vertices: all have six faces, so any vertex of the file may be a base vertex.
    seven = np.arange(7)
    faces = np.concatenate([np.stack([seven, (seven + 1) % 7, (seven + 3) % 7], 1),
                            np.stack([seven, (seven + 3) % 7, (seven + 2) % 7], 1)])
    with make((np.random.default_rng(1).random((7, 3)), faces), levels=1) as store:
        mesh = store.mesh()
    write_ply(tmp_path / "torus.ply", (mesh.vertices, mesh.triangles))
    with open(tmp_path / "torus.ply", "a", encoding="ascii") as file:
        file.write("more")
    told = []
    done = plait.import_mesh(tmp_path / "torus.ply", tmp_path / "torus.plait", warn=told.append)
    assert (done.levels, done.base_faces, done.had_choice) == (1, 14, True)
    assert len(told) == 1 and "4 bytes after the last element" in told[0]


def test_remesh_takes_the_options_of_the_program(tmp_path):
    with make(icosahedron(), levels=4, scheme="loop") as store:
        mesh = store.mesh()
    # A hole of three edges, and a second component of two triangles.
    vertices = np.concatenate([mesh.vertices, mesh.vertices[:4] * 0.1 + 3])
    extra = len(mesh.vertices) + np.array([[0, 1, 2], [0, 2, 3]])
    triangles = np.concatenate([mesh.triangles[1:], extra])
    write_ply(tmp_path / "scan.ply", (vertices, triangles))
    done = plait.remesh(tmp_path / "scan.ply", tmp_path / "s.plait", 80, 2, min_component=10,
                        fill_holes=3, samples=2000, backend="mmap")
    # The hole becomes three triangles around a new vertex.
    assert done.scan_faces == 5122 and done.faces == done.base_faces * 16
    with plait.open(done.path) as store:
        assert list(store.levels) == [0, 1, 2] and store.info.backend == "mmap"
        assert store.info.stored_bytes == done.stored_bytes
    found = plait.compare(tmp_path / "scan.ply", done.path, samples=2000)
    assert 0 < done.store_to_scan_rms <= done.store_to_scan_max < 2 * found.back.max
    corners = mesh.vertices[mesh.triangles]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert done.mean_edge == pytest.approx(edges.mean(), rel=0.01)
    with pytest.raises(plait.InvalidArgument):
        plait.remesh(tmp_path / "scan.ply", done.path, 80)
    again = plait.remesh(tmp_path / "scan.ply", done.path, 80, 1, min_component=10, fill_holes=3,
                         samples=0, force=True, no_foldover=True, distances=True)
    assert again.faces == again.base_faces * 4 and again.base_meshes == 1
    assert 1 <= again.area_spread_percentile_90 < 4 and again.area_spread_share_within_4 > 0.9
    found = plait.compare(tmp_path / "scan.ply", done.path, samples=20000)
    with plait.open(done.path) as store:
        distance = store.mesh(attributes=["distance"]).attributes["distance"]
    # Those of the scan's vertices, and not of points between them.
    assert distance.dtype == np.float32
    assert 0.5 * found.there.max < distance.max() < 1.5 * found.there.max
    vertices, triangles = sheet(40)
    vertices[:, 2] = 6 * np.random.default_rng(1).random(len(vertices))
    write_ply(tmp_path / "crumpled.ply", (vertices, triangles))
    with pytest.raises(plait.InvalidArgument, match="8 base meshes, at "):
        plait.remesh(tmp_path / "crumpled.ply", tmp_path / "no.plait", 60, samples=0,
                     no_foldover=True)


def test_remesh_within_a_distance_leaves_faces_the_levels_that_they_need(tmp_path):
    with make(icosahedron(), levels=4, scheme="loop") as store:
        mesh = store.mesh()
    write_ply(tmp_path / "scan.ply", (mesh.vertices, mesh.triangles))
    near = plait.remesh(tmp_path / "scan.ply", tmp_path / "near.plait", levels=4,
                        max_distance="0.5%", samples=20000)
    assert near.vertices < near.from_vertices and near.faces < near.from_faces
    assert max(near.scan_to_store_max, near.store_to_scan_max) <= 0.005 * near.diagonal
    with plait.open(near.path) as store:
        assert len(store.depths) == near.base_faces
        assert len(store.mesh().vertices) == near.vertices
    near = plait.remesh(tmp_path / "scan.ply", tmp_path / "near.plait", levels=4,
                        max_distance="0.5%", samples=20000, depth="uniform", force=True)
    assert near.vertices == near.from_vertices


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
