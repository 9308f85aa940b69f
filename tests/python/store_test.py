"""Opening, making, changing and closing stores; errors by kind."""

import os
import pickle

import numpy as np
import plait
import pytest
from conftest import TETRAHEDRON, icosahedron, make, sheet


def test_store_says_what_it_has(tmp_path):
    path = tmp_path / "s.plait"
    make(sheet(2), path, levels=2, backend="pread").close()
    with plait.open(path, memory="8MiB") as store:
        info = store.info
        assert info.path == str(path) == store.path and info.backend == "pread"
        assert info.budget_bytes == 8 << 20 and info.sequence == 2 and not info.writable
        assert info.scheme == "midpoint" and len(info.uuid) == 32 and info.stored_bytes > 0
        assert store.counts(0) == plait.Counts(9, 16, 8)
        assert store.counts(2) == plait.Counts(81, 8 * 16 * 3 // 2 + 16, 128)
        assert store.base.vertices.shape == (9, 3) and store.base.triangles.shape == (8, 3)
        assert "position" in store and "normal" not in store
        assert "levels 0 to 2" in repr(store) and "float32 x 3" in repr(store["position"])
        assert "shape" in repr(store["position"][1])
        store["position"][2][:]
        assert store.statistics.blocks_read >= 1
    assert "closed" in repr(store)


def test_create_refuses_what_is_no_mesh(tmp_path):
    vertices, faces = TETRAHEDRON
    for wrong in ((vertices[:, :2], faces), (vertices, faces + 1), (vertices, faces - 1),
                  (vertices, faces.astype(float)), (vertices, faces[:, :2]),
                  (vertices, np.concatenate([faces, faces[:1]]))):
        with pytest.raises(plait.InvalidArgument):
            plait.create(*wrong, tmp_path / "s.plait")
    with pytest.raises(ValueError):
        plait.create(vertices, faces, dtype=np.int32)
    assert not (tmp_path / "s.plait").exists()


def test_create_keeps_arrays_of_any_kind(tmp_path):
    vertices, faces = icosahedron()
    plain = plait.create(vertices.tolist(), faces.tolist(), layout="given")
    strided = plait.create(np.asfortranarray(vertices), faces.astype(np.int16)[::1], layout="given")
    np.testing.assert_array_equal(plain.base.triangles, strided.base.triangles)
    np.testing.assert_array_equal(plain.base.vertices, vertices)
    told = []
    more = np.concatenate([vertices, [[5, 5, 5]]])
    assert len(plait.create(more, faces, warn=told.append).base.vertices) == 12
    assert "unused" in told[0] or "dropped" in told[0]
    with pytest.warns(UserWarning, match="1 of 13 vertices dropped") as warned:
        plait.create(more, faces)
    assert warned[0].filename == __file__
    doubled = plait.create(vertices, faces, dtype="float64")
    assert doubled["position"].dtype == np.float64


def test_create_with_a_path_is_committed(tmp_path):
    plait.create(*TETRAHEDRON, tmp_path / "s.plait").close()
    with plait.open(tmp_path / "s.plait", writable=True) as store:
        assert list(store.levels) == [0]
        store.subdivide(2)
    with plait.open(tmp_path / "s.plait") as store:
        assert list(store.levels) == [0], "changes without a commit are lost"


def test_errors_have_kinds_and_places(tmp_path):
    with pytest.raises(FileNotFoundError) as error:
        plait.open(tmp_path / "none.plait")
    assert isinstance(error.value, plait.NotFound) and "none.plait" in error.value.path
    assert "none.plait" in str(error.value)
    copy = pickle.loads(pickle.dumps(error.value))
    assert copy.path == error.value.path and str(copy) == str(error.value)
    path = tmp_path / "s.plait"
    writer = make(TETRAHEDRON, path, levels=1)
    with pytest.raises(plait.Busy):
        plait.open(path, writable=True)
    reader = plait.open(path)
    with pytest.raises(plait.BadState):
        reader.add_attribute("mine")
    with pytest.raises(plait.InvalidArgument, match="budget"):
        plait.open(path, memory=1)
    writer.close()
    plait.open(path, writable=True).close()


def test_errors_speak_of_python_and_have_the_path(tmp_path):
    path = tmp_path / "s.plait"
    make(TETRAHEDRON, path, levels=1).close()
    reader = plait.open(path)
    for call in (lambda: plait.open(tmp_path / "none.plait"), lambda: reader.commit(),
                 lambda: plait.create(*TETRAHEDRON, path), lambda: plait.open(tmp_path),
                 lambda: plait.convert(tmp_path / "none.plait", tmp_path / "new.plait"),
                 lambda: reader.remove_attribute("none"),
                 lambda: plait.subdivide(tmp_path / "none.ply", tmp_path / "new.plait", 1)):
        with pytest.raises(plait.Error) as error:
            call()
        assert "plait_" not in str(error.value).replace(str(tmp_path), "")
        assert error.value.path in map(str, (path, tmp_path, tmp_path / "none.plait",
                                             tmp_path / "none.ply")), error.value
    with pytest.raises(plait.BadState, match="open it for writing"):
        reader.commit()
    with plait.open(path, writable=True) as writer:
        for call in (lambda: writer.remove_attribute("none"),
                     lambda: writer.replace_attribute("position", "none")):
            with pytest.raises(KeyError, match="no attribute 'none': the store has 'position'"):
                call()


def test_a_reader_keeps_its_version(tmp_path):
    path = tmp_path / "s.plait"
    writer = make(icosahedron(), path, levels=2)
    reader = plait.open(path)
    old = np.array(reader["position"][2])
    writer.visit(lambda vertices: vertices["position"] + 1, reads="position", writes="position")
    writer.commit()
    np.testing.assert_array_equal(reader["position"][2], old)
    np.testing.assert_array_equal(plait.open(path)["position"][2], old + np.float32(1))


def test_roll_back_brings_back_the_last_commit(tmp_path):
    store = make(icosahedron(), tmp_path / "s.plait", levels=1)
    digest = store.digest()
    store.subdivide(3)
    assert store.levels[-1] == 3
    store.roll_back()
    assert store.levels[-1] == 1 and store.digest() == digest


def test_write_bounds_keeps_the_boxes_in_a_file(tmp_path):
    path = tmp_path / "s.plait"
    store = make(icosahedron(), path, levels=3)
    store.write_bounds()
    store.close()
    reader = plait.open(path)
    assert len(reader.faces_in_box([-9] * 3, [9] * 3)) == 20
    assert reader.statistics.blocks_read == 0
    assert list(path.glob("*.bounds"))


def test_a_forked_process_is_refused_in_words(tmp_path):
    path = tmp_path / "s.plait"
    store = make(icosahedron(), path, levels=2)
    level = store["position"][2]
    child = os.fork()
    if child == 0:
        good = 0
        for call in (lambda: store.patch(0), lambda: level[:], lambda: store.commit(),
                     lambda: store.mesh()):
            try:
                call()
            except plait.BadState as error:
                good += "fork" in str(error)
        with plait.open(path) as again:
            good += again.patch(0).shape == (15, 3)
        os._exit(good)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 5
    assert store.patch(0).shape == (15, 3)


def test_library_says_what_it_has():
    info = plait.build_info()
    assert "pread" in info["backends"] and "loop" in info["schemes"]
    assert info["version"] == [plait.__version__]
    with pytest.raises(plait.Error):
        plait.load_plugin("/nowhere/x.so")
