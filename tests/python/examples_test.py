"""The programs of examples/python do what they say, as somebody runs them."""

import os
import pathlib
import runpy
import struct
import sys

import numpy as np
import plait
import pytest
from conftest import icosahedron, make, sheet

EXAMPLES = pathlib.Path(os.environ["PLAIT_SOURCE"]) / "examples" / "python"


def run(monkeypatch, capsys, name, *arguments):
    """What the program prints."""
    monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    return capsys.readouterr().out


@pytest.fixture
def sphere(tmp_path):
    """A sphere of radius 2 at level 4, whose vertices lie on it exactly enough."""
    path = tmp_path / "sphere.plait"
    with make(icosahedron(), path, levels=4, normals=True, block_bytes=4096, dtype=np.float64) as store:
        def push(vertices):
            length = np.linalg.norm(vertices["position"], axis=1, keepdims=True)
            return 2 * vertices["position"] / length

        store.visit(push, reads="position", writes="position")
        store.commit()
    return path


def test_curvature_of_a_sphere_is_one_over_its_radius(sphere, monkeypatch, capsys):
    shown = run(monkeypatch, capsys, "curvature.py", sphere, "1MiB")
    assert abs(float(shown.split()[-1]) - 0.5) < 1e-3
    with plait.open(sphere) as store:
        assert store["curvature"].dtype == np.float32
        for level in store["curvature"]:
            np.testing.assert_allclose(level, 0.5, rtol=0.02)
    # Again, over the old attribute.
    assert "to 0.4900," in run(monkeypatch, capsys, "curvature.py", sphere, "64MiB", 0.49)


def test_curvature_of_a_flat_surface_is_zero_also_at_its_border(tmp_path, monkeypatch, capsys):
    make(sheet(2), tmp_path / "flat.plait", levels=2).close()
    shown = run(monkeypatch, capsys, "curvature.py", tmp_path / "flat.plait")
    assert "0.0000 to 0.0000, on average 0.0000" in shown
    with plait.open(tmp_path / "flat.plait") as store:
        for level in store["curvature"]:
            np.testing.assert_allclose(level, 0, atol=1e-5)


def test_curvature_of_a_bent_sheet_is_told_of_its_finest_level(tmp_path, monkeypatch, capsys):
    def bend(vertices):
        x, y, _ = vertices["position"].T
        return np.stack([x, y, x * x / 4], 1)

    with make(sheet(2), tmp_path / "bent.plait", levels=3) as store:
        store.visit(bend, reads="position", writes="position")
        store.commit()
    shown = run(monkeypatch, capsys, "curvature.py", tmp_path / "bent.plait")
    with plait.open(tmp_path / "bent.plait") as store:
        finest = store["curvature"][3][:]
        assert finest.max() != store["curvature"][2][:].max()
    assert abs(finest.max() - 0.25) < 0.01  # half of the curvature of the parabola at its apex
    assert f" 0.0000 to {finest.max():.4f}, on average {finest.mean():.4f}" in shown


def test_smooth_brings_noise_down_and_keeps_the_size(sphere, monkeypatch, capsys):
    rng = np.random.default_rng(3)
    with plait.open(sphere, writable=True) as store:
        store.visit(lambda v: v["position"] + rng.normal(0, 0.01, v["position"].shape),
                    reads="position", writes="position")
        store.commit()

    def radii():
        with plait.open(sphere) as store:
            return np.linalg.norm(store["position"][4], axis=1)

    before = radii()
    with plait.open(sphere) as store:
        old = store["position"][4][:]
    shown = run(monkeypatch, capsys, "smooth.py", sphere, 6)
    with plait.open(sphere) as store:
        moved = np.linalg.norm(store["position"][4][:] - old, axis=1)
    assert f"moved by {moved.mean():.3g} on average, {moved.max():.3g} at most" in shown
    assert radii().std() < before.std() / 2 and abs(radii().mean() - 2) < 0.01
    assert "moved" not in plait.open(sphere)


def test_region_is_a_file_that_vtk_would_read(sphere, tmp_path, monkeypatch, capsys):
    file = tmp_path / "part.vtp"
    run(monkeypatch, capsys, "region_to_vtk.py", sphere, file, "0,0,0", "3,3,3", 3)
    with plait.open(sphere) as store:
        mesh = store.mesh(3, box=([0, 0, 0], [3, 3, 3]), attributes=["normal"])
    data = file.read_bytes()
    head, appended = data.split(b'<AppendedData encoding="raw">_')
    import xml.etree.ElementTree as ElementTree
    tree = ElementTree.fromstring(head + b"</VTKFile>")
    piece = tree.find("PolyData/Piece")
    assert int(piece.get("NumberOfPoints")) == len(mesh.vertices)
    found = {}
    for array in piece.iter("DataArray"):
        at = int(array.get("offset"))
        size, = struct.unpack_from("<Q", appended, at)
        kind = {"Float32": "<f4", "Float64": "<f8", "Int64": "<i8"}[array.get("type")]
        found[array.get("Name")] = np.frombuffer(appended, kind, size // np.dtype(kind).itemsize, at + 8)
    np.testing.assert_array_equal(found["Points"].reshape(-1, 3), mesh.vertices)
    np.testing.assert_array_equal(found["normal"].reshape(-1, 3), mesh.attributes["normal"])
    np.testing.assert_array_equal(found["connectivity"].reshape(-1, 3), mesh.triangles)
    assert found["offsets"][-1] == mesh.triangles.size


def test_dask_finds_the_box_of_the_sphere(sphere, monkeypatch, capsys):
    pytest.importorskip("dask.array")
    shown = run(monkeypatch, capsys, "dask_blocks.py", sphere)
    assert "2562 vertices" in shown and "center" in shown
    with plait.open(sphere) as store:
        every = np.concatenate([np.asarray(level) for level in store["position"]])
    assert f"box {every.min(axis=0)} to {every.max(axis=0)}" in shown


def test_box_is_drawn(sphere, tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    picture = tmp_path / "box.png"
    shown = run(monkeypatch, capsys, "plot_box.py", sphere, picture, "0,0,0", "3,3,3", 3)
    assert "patches" in shown
    import matplotlib.image
    pixels = matplotlib.image.imread(picture)
    assert pixels.shape[:2] == (600, 600) and pixels.std() > 0.02


def test_gear_is_a_closed_part_whose_edges_stay_sharp(tmp_path, monkeypatch, capsys):
    run(monkeypatch, capsys, "gear.py", tmp_path / "gear.ply")
    made = plait.remesh(tmp_path / "gear.ply", tmp_path / "gear.plait", 1000, 2, samples=100000)
    assert made.scan_faces == 46080 and made.base_faces == 1000 and made.turned_faces == 0
    assert made.scan_to_store_rms < 6e-5 * made.diagonal
    round_edges = plait.remesh(tmp_path / "gear.ply", tmp_path / "round.plait", 1000, 2, feature_angle="none")
    assert made.scan_to_store_rms < round_edges.scan_to_store_rms / 2
