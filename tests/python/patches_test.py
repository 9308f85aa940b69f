"""Patches, boxes, rays and welded meshes."""

import numpy as np
import plait
import pytest
from conftest import TETRAHEDRON, flat_patch, grid, icosahedron, make, sheet


def sorted_rows(vertices):
    return vertices[np.lexsort(vertices.T)]


def areas(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]].astype(float) for k in range(3))
    return np.cross(b - a, c - a) / 2


def test_patches_of_midpoints_are_flat():
    store = make(TETRAHEDRON, levels=4)
    patches = store.patches([2, 0, 3], level=4)
    for number, face in enumerate(patches.faces):
        expected = flat_patch(store, face, 16)
        np.testing.assert_array_equal(patches.records[number], expected)
        np.testing.assert_array_equal(store.patch(face, level=4), expected)
    np.testing.assert_array_equal(store.patch(0, level=1), flat_patch(store, 0, 2))
    np.testing.assert_array_equal(store.patch(1), store.patch(1, 4))


@pytest.mark.parametrize("dtype,components", [(np.float32, 1), (np.float64, 1), (np.float32, 3),
                                              (np.float64, 3), (np.uint8, 5), (np.int16, 1)])
def test_patches_of_all_sizes_of_records_are_the_vertices(dtype, components):
    store = make(sheet(2), levels=3)
    store.add_attribute("mine", dtype, components)
    numbers = np.random.default_rng(1)

    def fill(vertices):
        vertices["mine"] = numbers.integers(0, 100, vertices["mine"].shape)

    store.visit(fill, writes=["mine"])
    # The same records by the numbering of welded patches, and as whole levels.
    mesh = store.mesh(3, attributes=["mine"])
    level = np.concatenate([np.asarray(store["mine"][k]) for k in range(4)])
    assert len(mesh.attributes["mine"]) == len(level)
    np.testing.assert_array_equal(np.sort(mesh.attributes["mine"], axis=0), np.sort(level, axis=0))


def test_triangles_are_those_of_the_library():
    store = make(TETRAHEDRON, levels=4)
    for level in range(5):
        np.testing.assert_array_equal(plait.triangles(level),
                                      store._reader("position").triangles(level))
    assert plait.triangles(3, base_level=1).shape == (16, 3)
    assert areas(flat_patch(store, 0, 16), plait.triangles(4)).shape == (256, 3)
    with pytest.raises(plait.InvalidArgument):
        plait.triangles(-1)


def test_mesh_of_everything_has_each_vertex_once(surface):
    for level in range(4):
        mesh = surface.mesh(level)
        counts = surface.counts(level)
        assert len(mesh.vertices) == counts.vertices and len(mesh.triangles) == counts.faces
        assert mesh.triangles.dtype == np.uint32 and mesh.triangles.max() == counts.vertices - 1
        stored = np.concatenate([np.asarray(surface["position"][k]) for k in range(level + 1)])
        np.testing.assert_array_equal(sorted_rows(mesh.vertices), sorted_rows(stored))
        edges = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        uses = np.unique(edges, axis=0, return_counts=True)[1]
        assert set(uses) == {2} and len(uses) == counts.edges
    # Closed: the vector areas of all triangles add up to nothing.
    assert np.abs(areas(mesh.vertices, mesh.triangles).sum(axis=0)).max() < 1e-5


def test_mesh_of_a_sheet_has_its_area_and_its_border():
    store = make(sheet(3), levels=3)
    mesh = store.mesh(3)
    assert np.allclose(areas(mesh.vertices, mesh.triangles).sum(axis=0), [0, 0, 9])
    edges = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    uses = np.unique(edges, axis=0, return_counts=True)[1]
    assert np.count_nonzero(uses == 1) == 4 * 3 * 8


def test_mesh_of_some_faces_is_a_part_of_the_whole():
    store = make(sheet(3), levels=2)
    rng = np.random.default_rng(5)
    for _ in range(20):
        faces = rng.permutation(18)[:rng.integers(1, 18)]
        mesh = store.mesh(2, faces=faces)
        points = np.concatenate([store.patch(face, 2) for face in faces])
        np.testing.assert_array_equal(sorted_rows(np.unique(points, axis=0)),
                                      sorted_rows(mesh.vertices))
        for number, face in enumerate(faces):
            np.testing.assert_array_equal(
                mesh.vertices[mesh.triangles[16 * number:16 * number + 16]],
                store.patch(face, 2)[plait.triangles(2)])
    with pytest.raises(plait.InvalidArgument, match="face 3 is named twice"):
        store.mesh(2, faces=[3, 3])
    assert len(store.mesh(2, faces=[]).vertices) == 0


def test_boxes_find_faces_and_meshes():
    store = make(sheet(8), levels=2)
    faces = store.faces_in_box([2.25, 2.25, -1], [2.5, 2.5, 1])
    corners = store.base.vertices[store.base.triangles[faces]]
    assert np.all(corners.min(axis=1) <= [2.5, 2.5, 1]) and len(faces) == 2
    np.testing.assert_array_equal(store.patches(box=([2.25, 2.25, -1], [2.5, 2.5, 1])).faces, faces)
    mesh = store.mesh(2, box=([2.25, 2.25, -1], [2.5, 2.5, 1]))
    assert len(mesh.triangles) == 32 and len(mesh.vertices) == 25
    np.testing.assert_array_equal(mesh.faces, faces)
    assert len(store.faces_in_box([20, 20, 20], [30, 30, 30])) == 0
    assert len(store.faces_in_box([-np.inf] * 3, [np.inf] * 3)) == 128
    with pytest.raises(plait.InvalidArgument):
        store.faces_in_box([np.nan, 0, 0], [1, 1, 1])
    with pytest.raises(plait.InvalidArgument, match="3 numbers"):
        store.faces_in_box([0, 0], [1, 1, 1])
    for wrong in ([0, 0, 0, 1, 1, 1], ([0, 0, 0],), 3):
        with pytest.raises(plait.InvalidArgument, match="two points"):
            store.mesh(2, box=wrong)
    with pytest.raises(plait.InvalidArgument, match="either"):
        store.patches([1], box=([0, 0, 0], [1, 1, 1]))


def test_rays_meet_the_nearest_faces_first():
    store = make(icosahedron(), levels=1)
    hits = store.along_ray([10, 0.1, 0.2], [-2, 0, 0])
    assert len(hits.faces) >= 2 and np.all(np.diff(hits.distances) >= 0)
    assert 4 < hits.distances[0] < 4.6
    with pytest.raises(plait.InvalidArgument):
        store.along_ray([0, 0, 0], [0, 0, 0])


def test_limits_of_memory_are_refused_in_words():
    store = make(icosahedron(), levels=3)
    with pytest.raises(plait.TooLarge, match=r"20 patches at level 3: needs .* the limit is 1 KiB"):
        store.patches(range(20), memory="1KiB")
    with pytest.raises(plait.TooLarge, match="mesh of 20 patches at level 3.*coarser level or a box"):
        store.mesh(memory=1000)
    with pytest.raises(MemoryError):
        store.mesh(box=([-9] * 3, [9] * 3), memory="1k")
    for wrong in ("much", "inf", -1, "-1MiB", 1 << 64):
        with pytest.raises(plait.InvalidArgument, match="KiB"):
            store.patches([0], memory=wrong)


def test_faces_and_levels_that_are_not_there_are_refused():
    store = make(TETRAHEDRON, levels=2)
    for call in (lambda: store.patch(4), lambda: store.patch(1 << 32), lambda: store.patch(-1), lambda: store.patches([0, 4]), lambda: store.mesh(faces=[9]),
                 lambda: store.patches([-1]), lambda: store.patches([0.5])):
        with pytest.raises(plait.InvalidArgument):
            call()
    for call in (lambda: store.patch(0, 3), lambda: store.patches([0], level=-1),
                 lambda: store.mesh(7), lambda: store["position"][3]):
        with pytest.raises(plait.NotFound, match="level"):
            call()
    with pytest.raises(plait.NoSuchAttribute, match="'position'"):
        store.patch(0, attribute="colour")
    assert grid(2).tolist() == [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [0, 2]]
