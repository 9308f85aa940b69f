"""Whole works, progress and Ctrl-C."""

import gc
import os
import signal
import sys
import threading

import numpy as np
import plait
import pytest
from conftest import TETRAHEDRON, icosahedron, make, write_ply


def test_subdivide_makes_the_store_that_arrays_make(tmp_path):
    mesh = write_ply(tmp_path / "m.ply", icosahedron())
    told = []
    done = plait.subdivide(mesh, tmp_path / "o.plait", levels=3, normals=True, digest=True,
                           layout="given", progress=lambda *each: told.append(each))
    assert done.vertices == 642 and done.faces == 1280 and done.levels == 3
    assert done.refine_seconds > 0 and done.stored_bytes > 0 and done.path.endswith("o.plait")
    store = plait.open(tmp_path / "o.plait")
    assert store.digest() == done.digest and len(done.digest) == 32
    vertices = np.array(icosahedron()[0], np.float32)
    arrays = make((vertices, icosahedron()[1]), levels=3, scheme="loop", normals=True,
                  layout="given")
    assert arrays.digest() == done.digest
    assert {phase for phase, *_ in told} >= {"commit"} and told[-1][1] <= told[-1][2]


def test_subdivide_takes_the_options_of_the_program(tmp_path):
    mesh = write_ply(tmp_path / "m.ply", icosahedron())
    path = tmp_path / "o.plait"
    plait.subdivide(mesh, path, 2, scheme="midpoint", compress=["default", "@1=lz4"], block="64KiB",
                    precision="float64", memory="8MiB", threads=2)
    store = plait.open(path)
    assert store.info.backend == "compressed" and store.info.block_bytes == 65536
    assert store["position"].dtype == np.float64 and store.info.scheme == "midpoint"
    store.close()
    with pytest.raises(plait.InvalidArgument, match="o.plait"):
        plait.subdivide(mesh, path, 1)
    plait.subdivide(mesh, path, 1, force=True)
    assert list(plait.open(path).levels) == [0, 1]
    for wrong in ({"force": "maybe"}, {"precision": "float16"}, {"scheme": "soap"},
                  {"levels": 99}, {"max_error": "soap"}, {"memory": "1 mile"}):
        with pytest.raises(plait.InvalidArgument):
            plait.subdivide(mesh, tmp_path / "n.plait", **{"levels": 1, **wrong})
    with pytest.raises(plait.NotSupported, match="soap"):
        plait.subdivide(mesh, tmp_path / "n.plait", 1, compress="soap")
    assert not (tmp_path / "n.plait").exists()


def test_convert_copies_all_records(tmp_path):
    source, copy = tmp_path / "s.plait", tmp_path / "c.plait"
    make(icosahedron(), source, levels=4, normals=True, backend="pread").close()
    told = []
    done = plait.convert(source, copy, compress="small", block="16KiB", verify=True,
                         progress=lambda *each: told.append(each))
    with plait.open(source) as one, plait.open(copy) as other:
        assert one.digest() == other.digest() == done.digest
        assert other.info.backend == "compressed" and other.info.block_bytes == 16384
    assert done.stored_bytes < done.from_stored_bytes and done.path == str(copy)
    assert {"convert", "read the copy back", "digest of the source", "publish"} == {
        each[0] for each in told}
    with pytest.raises(plait.InvalidArgument, match="c.plait"):
        plait.convert(source, copy)
    plait.convert(source, copy, backend="mmap", force=True)
    assert plait.open(copy).info.backend == "mmap"
    plait.convert(source, copy, max_error="1e-3", force=True, verify=True)
    with plait.open(source) as one, plait.open(copy) as other:
        difference = np.asarray(one["position"][4]) - other["position"][4]
        assert 0 < np.abs(difference).max() <= 1e-3
    with pytest.raises(plait.InvalidArgument, match="choose backend compressed"):
        plait.convert(source, tmp_path / "n.plait", backend="pread", compress="small")
    with pytest.raises(plait.InvalidArgument, match="the same"):
        plait.convert(source, source, force=True)
    with pytest.raises(plait.Cancelled):
        plait.convert(source, tmp_path / "n.plait", progress=lambda *_: False)
    assert sorted(os.listdir(tmp_path)) == ["c.plait", "s.plait"]


def test_a_pruned_store_has_a_depth_for_each_face(tmp_path):
    whole = make(icosahedron(), tmp_path / "whole.plait", levels=3, scheme="loop")
    assert whole.depths.tolist() == [3] * 20
    wanted = np.full(20, 1, np.uint8)
    wanted[4] = 3
    whole.set_face_attribute("wanted", wanted)
    whole.commit()
    report = plait.prune(tmp_path / "whole.plait", tmp_path / "pruned.plait", depth_by="wanted")
    with plait.open(tmp_path / "pruned.plait") as store:
        depths = store.depths
        assert depths[4] == 3 and sorted(set(depths)) == [1, 2, 3] and not depths.flags.writeable
        assert report["raised_faces"] == 3 and report["vertices"] == store.counts(3).vertices
        for face, depth in enumerate(depths):
            patch = store.patch(face, int(depth))
            assert np.array_equal(patch, whole.patch(face, int(depth)))
            if depth < 3:
                with pytest.raises(plait.InvalidArgument, match="depth of the face"):
                    store.patch(face, 3)
        # Each vertex of a level is at the point that is said of it.
        for level in (1, 2, 3):
            records, points = store["position"][level][:], store.points(level)
            of_level = store.counts(level).vertices - store.counts(level - 1).vertices
            assert len(records) == of_level
            for record, face, i, j, size in zip(records, *points):
                place = j * (size + 1) - j * (j - 1) // 2 + i
                assert np.array_equal(whole.patch(int(face), level)[place], record)
        assert len(store.mesh(level=1).triangles) == 80
        with pytest.raises(plait.NotSupported, match="whole surface"):
            store.mesh(faces=[4])
        with pytest.raises(plait.TooLarge):
            store.mesh(memory=100)
        # Closed: each edge once in each direction; vertices, edges and faces are those that are counted.
        for level in (2, 3):
            mesh = store.mesh(level, attributes="position")
            counts = store.counts(level)
            ends = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
            edges = set(map(tuple, ends))
            assert len(edges) == len(ends) == 2 * counts.edges and edges == {(b, a) for a, b in edges}
            assert mesh.vertices.shape == (counts.vertices, 3)
            assert len(mesh.triangles) == counts.faces and set(mesh.triangles.ravel()) == set(
                range(counts.vertices)) and counts.vertices - counts.edges + counts.faces == 2
            # The deepest face has its own patch in it.
            patch = whole.patch(4, level)
            assert set(map(tuple, patch)) <= set(map(tuple, mesh.vertices))
        # A visit has the vertices that there are.
        seen = []
        store.visit(lambda vertices: seen.append(vertices["position"].copy()), reads="position")
        assert sum(map(len, seen)) == store.counts(3).vertices
        assert np.array_equal(np.sort(np.concatenate(seen), axis=0),
                              np.sort(store["position"].upto(3), axis=0))
        # Vertices that only one face of an edge has are on a border; the surface has no other.
        with_rings = []
        store.visit(lambda vertices: with_rings.append(
            (len(vertices["position"]), vertices.border)), reads="position", rings=True)
        assert sum(count for count, _ in with_rings) == store.counts(3).vertices
        sides = {tuple(sorted((face[k], face[(k + 1) % 3]))): [] for face in whole.base.triangles
                 for k in range(3)}
        for face, depth in zip(whole.base.triangles, depths):
            for k in range(3):
                sides[tuple(sorted((face[k], face[(k + 1) % 3])))].append(2 ** int(depth))
        assert sum(count for count, border in with_rings if border) == sum(
            abs(a - b) for a, b in sides.values())
        store.verify()
    report = plait.convert(tmp_path / "pruned.plait", tmp_path / "uniform.plait", depth="uniform",
                           warn=[].append)
    assert report.path == str(tmp_path / "uniform.plait")
    with plait.open(tmp_path / "uniform.plait") as store:
        assert store.depths.tolist() == [3] * 20
        assert np.array_equal(store.patch(4, 3), whole.patch(4, 3))


def test_progress_that_returns_false_cancels_and_nothing_is_left(tmp_path):
    mesh = write_ply(tmp_path / "m.ply", icosahedron())
    with pytest.raises(plait.Cancelled):
        plait.subdivide(mesh, tmp_path / "o.plait", 4, progress=lambda *_: False)
    assert sorted(os.listdir(tmp_path)) == ["m.ply"]


@pytest.mark.parametrize("work", ["subdivide", "verify", "digest", "bounds", "visit"])
def test_control_c_cancels_and_the_store_is_as_before(tmp_path, work):
    mesh = write_ply(tmp_path / "m.ply", icosahedron())
    path = tmp_path / "s.plait"
    make(icosahedron(), path, levels=4, block_bytes=4096).close()
    store = plait.open(path, writable=True)
    calls = []

    def interrupt(*_):
        calls.append(1)
        if len(calls) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        if work == "subdivide":
            plait.subdivide(mesh, tmp_path / "new.plait", 5, progress=interrupt)
        elif work == "verify":
            store.verify(interrupt)
        elif work == "digest":
            store.digest(progress=interrupt)
        elif work == "bounds":
            store.write_bounds(progress=interrupt)
        else:
            store.visit(lambda vertices: interrupt(), reads="position", rings=True)
    assert len(calls) < 10
    assert sorted(os.listdir(tmp_path)) == ["m.ply", "s.plait"]
    assert len(store.digest()) == 32 and store.verify().damaged_count == 0


@pytest.mark.parametrize("progress", [None, lambda *_: None])
def test_control_c_while_the_library_runs_is_not_lost(progress):
    """The signal comes while no line of Python runs: the handler is called where a callback begins."""
    handler = signal.getsignal(signal.SIGINT)
    beside = threading.Event()

    def interrupt():
        beside.wait()
        os.kill(os.getpid(), signal.SIGINT)

    for _ in range(5):
        store = make(icosahedron(), levels=2)
        beside.clear()
        thread = threading.Thread(target=interrupt)
        thread.start()
        gc.collect()  # Python drops what a signal raises in the destructor of an old store
        with pytest.raises(KeyboardInterrupt):
            beside.set()
            store.subdivide(8, progress=progress)
            thread.join()  # if it was late
        assert signal.getsignal(signal.SIGINT) is handler


def test_own_handlers_of_control_c_are_called():
    calls = []
    before = signal.signal(signal.SIGINT, lambda *_: calls.append(1))
    try:
        store = make(icosahedron(), levels=2)
        store.digest(progress=lambda *_: calls or os.kill(os.getpid(), signal.SIGINT))
        assert len(calls) == 1
    finally:
        signal.signal(signal.SIGINT, before)


def test_exceptions_of_the_progress_function_come_out(tmp_path):
    store = make(icosahedron(), levels=2)

    def fails(*_):
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        store.digest(progress=fails)
    assert len(store.digest()) == 32


def test_what_changes_in_a_mesh_is_a_warning_and_exceptions_of_warn_come_out(tmp_path):
    vertices, faces = icosahedron()
    mesh = write_ply(tmp_path / "m.ply", (np.concatenate([vertices, [[5, 5, 5]]]), faces))
    with pytest.warns(UserWarning, match="1 of 13 vertices dropped") as warned:
        plait.subdivide(mesh, tmp_path / "o.plait", 1)
    assert warned[0].filename == __file__
    told = []
    plait.subdivide(mesh, tmp_path / "o.plait", 1, force=True, warn=told.append)
    assert len(told) == 1

    def interrupt(words):
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        plait.subdivide(mesh, tmp_path / "n.plait", 4, warn=interrupt)
    assert sorted(os.listdir(tmp_path)) == ["m.ply", "o.plait"]
    for path in (None, tmp_path / "c.plait"):
        with pytest.raises(KeyboardInterrupt):
            plait.create(np.concatenate([vertices, [[5, 5, 5]]]), faces, path, warn=interrupt)
    assert sorted(os.listdir(tmp_path)) == ["m.ply", "o.plait"]


def test_verify_reports_damage_with_its_place(tmp_path):
    path = tmp_path / "s.plait"
    make(icosahedron(), path, levels=3, backend="pread", block_bytes=4096).close()
    assert plait.verify(path).damaged_count == 0
    files = sorted(path.glob("*3*"), key=lambda file: file.stat().st_size)
    with open(files[-1], "r+b") as file:
        file.seek(100)
        byte = file.read(1)
        file.seek(100)
        file.write(bytes([byte[0] ^ 1]))
    report = plait.verify(path)
    assert report.damaged_count == 1 and report.blocks > 3 and report.bytes > 0
    damaged = report.damaged[0]
    assert damaged.attribute == "position" and damaged.level == 3 and "checksum" in damaged.reason
    store = plait.open(path)
    with pytest.raises(plait.Damaged) as error:
        store["position"][3][:]
    assert str(path) in error.value.path and error.value.offset is not None


def test_bar_is_drawn_on_a_terminal_only(monkeypatch, tmp_path):
    class Terminal:
        text = ""

        def write(self, text):
            self.text += text

        def flush(self):
            pass

        def isatty(self):
            return True

    store = make(TETRAHEDRON, levels=3)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    store.digest(progress=True)
    assert "digest: " in terminal.text and "%" in terminal.text
    terminal.text = ""
    terminal.isatty = lambda: False
    store.digest(progress=True)
    assert terminal.text == ""


def test_bar_in_a_notebook_updates_one_output(monkeypatch):
    shown = []

    class Handle:
        def update(self, content, raw):
            shown.append(content["text/plain"])

    class Display:
        @staticmethod
        def display(content, raw, display_id):
            return Handle()

    class IPython:
        @staticmethod
        def get_ipython():
            return type("Shell", (), {"kernel": 1})()

    monkeypatch.setitem(sys.modules, "IPython", IPython)
    monkeypatch.setitem(sys.modules, "IPython.display", Display)
    make(TETRAHEDRON, levels=3).digest(progress=True)
    assert shown and "digest" in shown[0] and shown[-1] == ""


def test_check_says_what_is_wrong_and_changes_nothing(tmp_path):
    vertices, faces = TETRAHEDRON
    soup = write_ply(tmp_path / "m.ply", (vertices[faces].reshape(-1, 3), np.arange(12).reshape(4, 3)))
    found = plait.check(soup)
    assert found["seam_vertices"] == 12 and found["repaired"]["components"] == 4
    with pytest.warns(UserWarning, match="8 vertices became others"):
        found = plait.check(soup, weld=True)
    assert found["merged_vertices"] == 8 and found["found"]["clean"]
    assert found["repaired"]["border_edges"] == 0
    assert os.listdir(tmp_path) == ["m.ply"]


def test_a_cancelled_picture_leaves_no_file(tmp_path):
    mesh = write_ply(tmp_path / "m.ply", icosahedron())
    plait.subdivide(mesh, tmp_path / "s.plait", levels=1)
    with pytest.raises(plait.Cancelled):
        plait.render(tmp_path / "s.plait", tmp_path / "a.png", size="64x64",
                     progress=lambda *_: False)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["m.ply", "s.plait"]
