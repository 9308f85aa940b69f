"""The caller's own numbers of faces and vertices, base levels, notes, and what else a program keeps
with its mesh."""

import pickle

import numpy as np
import plait
import pytest
from conftest import flat_patch, grid, icosahedron, make, sheet, write_ply


def shuffled(mesh, seed=1):
    """The same surface, with faces and vertices in an order without sense."""
    vertices, faces = mesh
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(vertices))
    number = np.empty(len(vertices), int)
    number[order] = np.arange(len(vertices))
    return vertices[order], number[faces][rng.permutation(len(faces))]


def test_faces_keep_the_numbers_of_the_caller():
    vertices, faces = shuffled(sheet(12))
    store = plait.create(vertices, faces)
    np.testing.assert_array_equal(store.base.triangles, faces)
    mine = np.arange(len(faces), dtype=np.float32)
    store.add_attribute("mine", np.float32)
    with store.patch_writer("mine", last_level=0) as patches:
        for face in range(len(faces)):
            patches.write_patch("mine", face, 0, np.full(3, mine[face]))
    np.testing.assert_array_equal(store.input.input_faces, np.arange(len(faces)))


def test_input_tells_where_everything_is():
    vertices, faces = shuffled(sheet(12))
    more = np.concatenate([vertices, [[7, 7, 7]]])  # no triangle uses it
    faces = faces.copy()
    faces[3] = faces[3][[0, 2, 1]]  # turned over
    told = []
    store = plait.create(more, faces, layout="hilbert", warn=told.append)
    maps = store.input
    assert len(told) == 2 and not np.array_equal(maps.input_faces, np.arange(len(faces)))
    none = np.iinfo(np.uint32).max
    assert maps.vertices[-1] == none and len(maps.vertices) == len(more)
    np.testing.assert_array_equal(store.base.vertices, more[maps.input_vertices])
    own = faces[maps.input_faces]
    own[maps.turned] = own[maps.turned][:, [0, 2, 1]]
    there = np.sort(maps.input_vertices[store.base.triangles], axis=1)
    np.testing.assert_array_equal(there, np.sort(own, axis=1))
    np.testing.assert_array_equal(maps.input_faces[maps.faces], np.arange(len(faces)))
    assert maps.turned.dtype == bool and maps.turned.sum() in (1, len(faces) - 1)
    for each in maps:
        with pytest.raises(ValueError):
            each[0] = 0


def test_the_loop_over_own_faces_is_right_after_subdivide(tmp_path):
    """Files get another order, and a base level makes four patches of each face."""
    vertices, faces = shuffled(sheet(6))
    write_ply(tmp_path / "m.ply", (vertices, faces))
    plait.subdivide(tmp_path / "m.ply", tmp_path / "s.plait", 2, scheme="midpoint")
    for store in (plait.open(tmp_path / "s.plait", writable=True),
                  plait.create(vertices, faces, base_level=1)):
        finest = store.levels[-1]
        mine = faces.sum(axis=1).astype(np.int32)  # anything that is known of each face
        store.add_attribute("mine", np.int32, level=store.levels[0])
        with store.patch_writer("mine", last_level=store.levels[0]) as patches:
            for face, own in enumerate(store.input.input_faces):
                patches.write_patch("mine", face, store.levels[0], np.full(3, mine[own]))
        for face, own in enumerate(store.input.input_faces):
            a, b, c = vertices[faces[own]][:, :2]
            inside = store.patch(face, finest)[:, :2].mean(axis=0)
            weights = np.linalg.solve(np.stack([b - a, c - a], 1), inside - a)
            assert (weights > 0).all() and weights.sum() < 1
        store.roll_back() if store.path else None
        store.close()


def test_triangles_know_the_base_level():
    store = plait.create(*icosahedron(), base_level=1)
    store.subdivide(3)
    points = store.patch(0, level=3)
    assert points[store.triangles(3)].shape == (16, 3, 3)
    np.testing.assert_array_equal(store.triangles(3), plait.triangles(3, base_level=1))
    with pytest.raises(plait.InvalidArgument):
        store.triangles(0)
    with pytest.raises(plait.InvalidArgument, match="expected a whole number"):
        store.triangles("3")


def test_upto_has_all_vertices_of_a_level(surface):
    position = surface["position"]
    for level in (0, 2, 3, None, -1):
        records = position.upto(level)
        last = 3 if level in (None, -1) else level
        assert len(records) == surface.counts(last).vertices and not records.flags.writeable
        np.testing.assert_array_equal(
            records, np.concatenate([np.array(position[each]) for each in range(last + 1)]))
    with pytest.raises(plait.TooLarge, match="level 3.*memory="):
        position.upto(memory=100)
    with pytest.raises(IndexError):
        position.upto(4)


def test_levels_are_found_as_in_a_list():
    store = plait.create(*icosahedron(), base_level=1)
    store.subdivide(3)
    position = store["position"]
    assert 2 in position and 0 not in position and 4 not in position and -1 not in position
    assert position[-1].level == 3 and position[-3].level == 1 and position[np.int8(2)].level == 2
    for wrong in (0, 4, -4):
        with pytest.raises(plait.NoSuchLevel, match="expected 1 to 3") as error:
            position[wrong]
        assert isinstance(error.value, IndexError) and isinstance(error.value, plait.NotFound)
    with pytest.raises(TypeError):
        position["2"]
    assert [level.level for level in position] == [1, 2, 3]


def test_points_are_where_vertices_are():
    store = make(sheet(3), levels=3)
    for level in store.levels:
        whole = np.array(store["position"][level])
        points = store.points(level)
        assert len(points.face) == len(whole) and (points.size == 1 << level).all()
        for number, (face, i, j, size) in enumerate(zip(*points)):
            place, = np.flatnonzero((grid(size) == (i, j)).all(axis=1))
            np.testing.assert_allclose(flat_patch(store, face, size)[place], whole[number])
        some = store.points(level, [3, -1, 0])
        np.testing.assert_array_equal(some.face, points.face[[3, -1, 0]])
        np.testing.assert_array_equal(some.i, points.i[[3, -1, 0]])
    assert len(store.points(2, slice(5, 9)).j) == 4 and len(store.points(2, []).j) == 0
    with pytest.raises(IndexError):
        store.points(2, [10 ** 6])


def test_a_visit_knows_the_points_of_its_vertices():
    store = make(sheet(3), levels=3)
    store.add_attribute("high", np.float64)

    def height(vertices):  # of a map over each face: i + j, in parts of the side
        points = vertices.points()
        return (points.i + points.j) / points.size

    store.visit(height, writes="high")
    for level in store.levels:
        points = store.points(level)
        np.testing.assert_array_equal(store["high"][level], (points.i + points.j) / points.size)


def test_texts_and_face_attributes_are_kept(tmp_path):
    path = tmp_path / "s.plait"
    vertices, faces = shuffled(sheet(4))
    material = np.arange(len(faces)) + 250
    with plait.create(vertices, faces, path, layout="hilbert") as store:
        assert store.texts == {} and store.face_attributes == {}
        store.set_text("units", "mm")
        store.set_text("author", "Åsa")
        store.set_text("units", "m")
        store.set_face_attribute("material", material[store.input.input_faces])
        store.set_face_attribute("flag", np.zeros(len(faces), int))
        store.set_face_attribute("flag", np.ones(len(faces), int))
        for wrong in (np.full(len(faces), 256), np.full(len(faces), -1), np.full(len(faces), 1.5),
                      np.zeros(3, int)):
            with pytest.raises(plait.InvalidArgument, match="'flag'"):
                store.set_face_attribute("flag", wrong)
        store.set_face_attribute("gone", np.ones(len(faces), int), dtype=np.uint32)
        store.remove_face_attribute("gone")
        store.set_face_attribute("height", np.arange(len(faces)) / 4)
        store.set_face_attribute("shift", np.arange(len(faces)) - 200)
        store.commit()
    with plait.open(path) as store:
        assert store.texts == {"author": "Åsa", "units": "m"}
        attributes = store.face_attributes
        assert set(attributes) == {"material", "flag", "height", "shift"}
        assert attributes["height"].dtype == np.float64 and attributes["shift"].dtype == np.int16
        np.testing.assert_array_equal(attributes["height"], np.arange(len(faces)) / 4)
        np.testing.assert_array_equal(attributes["shift"], np.arange(len(faces)) - 200)
        assert attributes["material"].dtype == np.uint16 and attributes["flag"].dtype == np.uint8
        np.testing.assert_array_equal(attributes["material"][store.input.faces], material)
        assert (attributes["flag"] == 1).all() and not attributes["flag"].flags.writeable
        with pytest.raises(plait.BadState):
            store.set_text("units", "km")


def test_base_records_are_written():
    store = make(icosahedron(), levels=1)
    store.add_attribute("age", np.int16)
    store.set_base_records("age", range(12))
    np.testing.assert_array_equal(store["age"][0], np.arange(12))
    store.set_base_records("position", store.base.vertices * 2)
    np.testing.assert_array_equal(store["position"][0], (store.base.vertices * 2).astype("f4"))
    for wrong in (np.arange(11), np.full(12, 40000), np.zeros((12, 2), np.int16), np.zeros(12)):
        with pytest.raises(plait.InvalidArgument, match="'age'"):
            store.set_base_records("age", wrong)
    with pytest.raises(KeyError):
        store.set_base_records("none", range(12))


def test_pipelines_are_set_and_changed(tmp_path):
    with make(icosahedron(), tmp_path / "s.plait", levels=4, backend="compressed") as store:
        before, large = store.digest(), store.info.stored_bytes
        store.recode_attribute("position", "none")
        store.commit()
        assert store.info.stored_bytes > large and store.digest() == before
        store.add_attribute("x", level=0)
        store.set_pipeline("x", "shuffle,zstd:1")
        with pytest.raises(plait.Error):
            store.set_pipeline("x", "no such pipeline")
        store.commit()


def test_patches_are_read_ahead(tmp_path):
    make(icosahedron(), tmp_path / "s.plait", levels=4, backend="pread").close()
    with plait.open(tmp_path / "s.plait") as store:
        assert 0 <= store.prefetch(range(20), level=4) <= 20
        np.testing.assert_array_equal(store.patch(3), store.patches([3]).records[0])
        store.end_prefetch()
        with pytest.raises(plait.InvalidArgument):
            store.prefetch([20])


def test_positions_that_float32_does_not_keep_are_float64_by_default(tmp_path):
    vertices, faces = icosahedron()
    near = np.asarray(vertices, np.float64)
    far = near + [431234.5, 5412345.25, 0]
    assert plait.create(near, faces)["position"].dtype == np.float32
    told = []
    store = plait.create(far, faces, warn=told.append)
    assert store["position"].dtype == np.float64
    assert np.array_equal(store["position"][0], far)
    assert len(told) == 1 and "positions are float64" in told[0]
    told.clear()
    assert plait.create(far, faces, dtype=np.float32, warn=told.append)["position"].dtype == np.float32
    assert len(told) == 1 and "auto" in told[0]
    assert plait.create(near * 1e300, faces, warn=told.append)["position"].dtype == np.float64
    with pytest.raises(plait.InvalidArgument, match="no number for"):
        plait.create(near * 1e300, faces, dtype=np.float32)


@pytest.mark.parametrize("dtype", [complex, "M8[s]", str, bool])
def test_what_is_no_number_is_no_position(dtype):
    vertices, faces = icosahedron()
    with pytest.raises(plait.InvalidArgument, match="vertices: expected numbers, found"):
        plait.create(np.asarray(vertices).astype(int).astype(dtype), faces)


def test_positions_that_float64_rounds_are_counted():
    vertices, faces = icosahedron()
    whole = (np.asarray(vertices) * 2**40).astype(np.int64)
    assert plait.create(whole, faces).base.vertices.shape == whole.shape
    far = whole.copy()
    far[[3, 5], 0] += 2**60 + 1
    with pytest.warns(UserWarning, match="rounds coordinates of 2 of 12 vertices"):
        plait.create(far, faces)
    told = []
    plait.create(np.asarray(vertices, np.longdouble) / 3, faces, warn=told.append)
    assert len(told) == 1 and "of 12 vertices" in told[0]


@pytest.mark.parametrize("dtype, first", [(np.float32, 2**24 + 1), (np.float64, 2**53 + 1)])
def test_whole_numbers_that_an_attribute_rounds_are_refused(dtype, first):
    store = plait.create(*icosahedron())
    store.add_attribute("number", dtype)
    with store.patch_writer("number", last_level=0) as patches:
        patches.write_patch("number", 0, 0, np.array([first - 1] * 3))
        with pytest.raises(plait.InvalidArgument, match=f"found {first} and 0 others that it rounds"):
            patches.write_patch("number", 1, 0, np.array([0, first, 1]))
        for face in range(1, len(store.base.triangles)):
            patches.write_patch("number", face, 0, np.zeros(3))


def test_a_dict_that_is_a_copy_takes_no_change():
    store = plait.create(*icosahedron())
    store.set_text("units", "mm")
    store.set_face_attribute("part", np.arange(20))
    for found, key, way in ((store.attributes, "position", "add_attribute"), (store.texts, "units", "set_text"),
                            (store.face_attributes, "part", "set_face_attribute")):
        with pytest.raises(TypeError, match=way):
            found["new"] = found[key]
        for change in (lambda: found.update({key: 1}), lambda: found.pop(key), found.clear,
                       lambda: found.setdefault("new", 1), lambda: found.__delitem__(key)):
            with pytest.raises(TypeError, match="is a copy"):
                change()
    own = dict(store.texts)
    own["units"] = "m"
    assert store.texts == {"units": "mm"} == pickle.loads(pickle.dumps(store.texts))


def test_what_is_set_on_a_store_is_refused_and_not_lost():
    vertices, faces = icosahedron()
    store = plait.create(vertices, faces)
    for name in ("position", "texts", "note"):
        with pytest.raises(AttributeError, match=f"no '{name}' that can be set, .* patch_writer"):
            setattr(store, name, vertices)
    store.add_attribute("height", np.float32)
    for each in (store.attributes["height"], store.attributes["height"][0]):
        with pytest.raises(AttributeError):
            each.records = vertices
    seen = []

    def wrong(found):
        with pytest.raises(AttributeError):
            found.height = 1
        found["height"] = 1
        seen.append(len(found["position"]))

    store.visit(wrong, reads=["position"], writes=["height"])
    assert sum(seen) == len(vertices)
