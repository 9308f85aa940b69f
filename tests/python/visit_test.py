"""Own computations on every vertex, against the welded mesh."""

import numpy as np
import plait
import pytest
from conftest import icosahedron, make, sheet


def means_by_mesh(mesh):
    """The mean of each vertex's neighbours, from the triangles of the whole mesh."""
    edges = np.unique(np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    sums, counts = np.zeros((len(mesh.vertices), 3)), np.zeros(len(mesh.vertices))
    for a, b in (edges.T, edges.T[::-1]):
        np.add.at(sums, a, mesh.vertices[b].astype(float))
        np.add.at(counts, a, 1)
    return sums / counts[:, None], counts


@pytest.mark.parametrize("mesh", [icosahedron(), sheet(3)], ids=["closed", "border"])
@pytest.mark.parametrize("levels", [0, 1, 3])
def test_rings_are_the_neighbours_of_the_mesh(mesh, levels):
    store = make(mesh, levels=levels, scheme="loop") if levels else plait.create(*mesh)
    store.add_attribute("mean", np.float64, 3)
    store.add_attribute("valence", np.int32)
    seen = []

    def mean(vertices):
        seen.append((len(vertices), vertices.valence, vertices.border, vertices.base))
        around = vertices.neighbours("position")
        assert around.shape == (len(vertices), vertices.valence, 3)
        assert vertices.levels.shape == vertices.places.shape == (len(vertices),)
        vertices["mean"] = around.astype(float).mean(axis=1)
        vertices["valence"] = vertices.valence

    store.visit(mean, reads=["position"], writes=["mean", "valence"], rings=True)
    whole = store.mesh(levels, attributes=["mean", "valence"])
    expected, counts = means_by_mesh(whole)
    np.testing.assert_allclose(whole.attributes["mean"], expected, atol=1e-12)
    np.testing.assert_array_equal(whole.attributes["valence"], counts)
    assert sum(count for count, *_ in seen) == store.counts(levels).vertices


def test_neighbours_are_counterclockwise():
    store = make(sheet(3), levels=2)
    store.add_attribute("turn", np.float64)

    def turn(vertices):
        spokes = vertices.neighbours("position").astype(float) - vertices["position"][:, None]
        after = spokes if vertices.border else np.roll(spokes, -1, axis=1)
        pairs = (spokes[:, :-1], spokes[:, 1:]) if vertices.border else (spokes, after)
        angles = np.arctan2(np.cross(*pairs)[..., 2], (pairs[0] * pairs[1]).sum(axis=-1))
        assert np.all(angles > 0)
        return angles.sum(axis=1)

    store.visit(turn, reads="position", writes="turn", rings=True)
    whole = store.mesh(2, attributes=["turn"])
    x, y = whole.vertices[:, 0], whole.vertices[:, 1]
    on = ((x == 0) | (x == 3)).astype(int) + ((y == 0) | (y == 3))
    np.testing.assert_allclose(whole.attributes["turn"], 2 * np.pi / 2.0 ** on, atol=1e-6)


def test_places_and_levels_name_the_vertices():
    store = make(icosahedron(), levels=3)
    store.add_attribute("name", np.uint64, 2)

    def name(vertices):
        vertices["name"] = np.stack([vertices.levels, vertices.places], 1)

    store.visit(name, reads="position", writes="name", rings=True)
    for level in range(4):
        there = np.asarray(store["name"][level])
        assert np.all(there[:, 0] == level)
        np.testing.assert_array_equal(there[:, 1], np.arange(len(there)))


def test_update_changes_in_place_and_coarser_levels_stay_alone(tmp_path):
    store = make(icosahedron(), tmp_path / "s.plait", levels=3)
    before = [np.array(store["position"][level]) for level in range(4)]
    store.visit(lambda vertices: 2 * vertices["position"], reads="position", writes="position",
                level=2)
    store.commit()
    for level in range(4):
        factor = 2 if level <= 2 else 1
        np.testing.assert_array_equal(store["position"][level], factor * before[level])


def test_replaced_attribute_has_the_new_records():
    store = make(icosahedron(), levels=2)
    store.add_attribute("smooth", np.float32, 3)
    store.visit(lambda vertices: vertices.neighbours("position").mean(axis=1), reads="position",
                writes="smooth", rings=True)
    smooth = np.array(store["smooth"][2])
    store.replace_attribute("position", "smooth")
    np.testing.assert_array_equal(store["position"][2], smooth)
    assert "smooth" not in store


def test_errors_of_the_function_come_out_and_the_level_is_unfinished(tmp_path):
    store = make(icosahedron(), tmp_path / "s.plait", levels=2)
    store.add_attribute("x")

    def fails(vertices):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        store.visit(fails, reads="position", writes="x")
    with pytest.raises(plait.BadState):
        store["x"][2][:]
    with pytest.raises(plait.Cancelled):
        store.visit(lambda vertices: False, writes="x")
    store.roll_back()
    assert "x" not in store


def test_records_that_are_kept_stay_as_they_were():
    store = make(icosahedron(), levels=3)
    kept = []
    store.visit(kept.append, reads="position", rings=True)
    total = np.concatenate([vertices["position"] for vertices in kept])
    whole = store.mesh(3).vertices
    np.testing.assert_array_equal(np.sort(total, axis=0), np.sort(whole, axis=0))
    with pytest.raises(ValueError):
        kept[0]["position"][0] = 1


def test_reading_needs_no_store_for_writing(tmp_path):
    make(icosahedron(), tmp_path / "s.plait", levels=2).close()
    store = plait.open(tmp_path / "s.plait")
    highest = []
    store.visit(lambda vertices: highest.append(vertices["position"].max()), reads="position")
    assert max(highest) == np.max([np.max(store["position"][level]) for level in range(3)])
    with pytest.raises(plait.BadState):
        store.visit(lambda vertices: 0 * vertices["position"], reads="position", writes="position")


def test_refusals_are_in_words():
    store = make(icosahedron(), levels=1)
    with pytest.raises(plait.InvalidArgument, match="write to another attribute"):
        store.visit(print, reads="position", writes="position", rings=True)
    with pytest.raises(plait.InvalidArgument, match="not in reads"):
        store.visit(print, reads="position", rings=["normal"])
    with pytest.raises(plait.InvalidArgument, match="attribute"):
        store.visit(print)
    with pytest.raises(plait.NoSuchAttribute):
        store.visit(print, reads="colour")
    with pytest.raises(KeyError, match="neither reads nor writes 'normal'"):
        store.visit(lambda vertices: vertices["normal"], reads="position")
    with pytest.raises(KeyError, match="no rings of 'position'"):
        store.visit(lambda vertices: vertices.neighbours("position"), reads="position")
    store.add_attribute("age", level=0)
    with pytest.raises(plait.InvalidArgument, match="level"):
        store.visit(print, reads=["age", "position"])


def test_a_function_that_fills_nothing_is_refused():
    store = make(icosahedron(), levels=1)
    store.add_attribute("h", level=1)
    with pytest.raises(plait.InvalidArgument, match="fills 'h'"):
        store.visit(lambda vertices: None, reads="position", writes="h")

    def fill(vertices):
        vertices["h"] = 0
    store.visit(fill, reads="position", writes="h")
    assert not np.any(store["h"][1])
