"""The reader for VTK, and the plug-in of ParaView in pvpython."""

import os
import pathlib
import shutil
import subprocess
import sys
import types

import numpy as np
import plait
import pytest
from conftest import icosahedron, make, sheet

pytest.importorskip("vtkmodules.vtkCommonExecutionModel")
numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")
vtk = pytest.importorskip("plait.vtk")


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    path = tmp_path_factory.mktemp("vtk") / "ball.plait"
    make(icosahedron(), path, levels=4, scheme="loop", normals=True).close()
    return path


def arrays(data):
    """Points, triangles and the attributes of the points."""
    of_points = data.GetPointData()
    return (numpy_support.vtk_to_numpy(data.GetPoints().GetData()),
            numpy_support.vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3),
            {of_points.GetArrayName(n): numpy_support.vtk_to_numpy(of_points.GetArray(n))
             for n in range(of_points.GetNumberOfArrays())})


def test_reader_gives_the_mesh_of_the_store(ball):
    reader = vtk.Reader(ball, level=3, attributes=["normal"])
    reader.Update()
    data = reader.GetOutput()
    points, triangles, attributes = arrays(data)
    with plait.open(ball) as store:
        mesh = store.mesh(3, attributes=["normal"])
    assert np.array_equal(points, mesh.vertices) and points.dtype == np.float32
    assert np.array_equal(triangles, mesh.triangles)
    assert np.array_equal(attributes["normal"], mesh.attributes["normal"])
    assert data.GetPointData().GetNormals().GetName() == "normal"
    selection = reader.GetAttributes()
    assert [selection.GetArrayName(n) for n in range(selection.GetNumberOfArrays())] == ["normal"]
    selection.DisableAllArrays()
    reader.Update()
    assert reader.GetOutput().GetPointData().GetNumberOfArrays() == 0


def test_reader_takes_level_and_box_again(ball):
    reader = vtk.Reader(ball / "manifest" if (ball / "manifest").is_file() else ball)
    reader.Update()
    whole = reader.GetOutput().GetNumberOfPolys()
    assert whole == 20 * 4 ** 4
    reader.SetBox(([-2, -2, 0.6], [2, 2, 2]))
    reader.SetLevel(2)
    reader.Update()
    with plait.open(ball) as store:
        mesh = store.mesh(2, box=([-2, -2, 0.6], [2, 2, 2]))
    assert 0 < reader.GetOutput().GetNumberOfPolys() == len(mesh.triangles) < 20 * 16


def test_pieces_are_all_patches_once(ball):
    corners = []
    for piece in range(3):
        reader = vtk.Reader(ball, level=2)
        reader.UpdatePiece(piece, 3, 0)
        points, triangles, _ = arrays(reader.GetOutput())
        assert 0 < len(triangles) < 20 * 16
        corners.append(points[triangles].reshape(-1, 9))
    corners = np.concatenate(corners)
    with plait.open(ball) as store:
        mesh = store.mesh(2)
    expected = mesh.vertices[mesh.triangles].reshape(-1, 9)
    assert np.array_equal(corners[np.lexsort(corners.T)], expected[np.lexsort(expected.T)])


def test_arrays_of_vtk_outlive_reader_and_store(tmp_path):
    make(sheet(4), tmp_path / "s.plait", levels=3).close()
    data = vtk.read(tmp_path / "s.plait", level=3)
    points, triangles, _ = arrays(data)
    area = np.cross(points[triangles[:, 1]] - points[triangles[:, 0]],
                    points[triangles[:, 2]] - points[triangles[:, 0]])[:, 2].sum() / 2
    assert area == pytest.approx(16)


def test_what_cannot_be_read_is_refused_in_words(ball, tmp_path, capfd):
    with pytest.raises(plait.TooLarge):
        vtk.read(ball, memory="100KiB")
    with pytest.raises(plait.NotFound):
        vtk.read(tmp_path / "nothing.plait")
    reader = vtk.Reader(ball, memory="100KiB")
    reader.Update()
    assert reader.GetOutput().GetNumberOfPolys() == 0
    assert "limit is 100 KiB" in capfd.readouterr().err


def test_pyvista_reads_a_store(ball, monkeypatch):
    """PyVista calls what its entry point names, and gives on what the function returns."""
    stand_in = types.ModuleType("pyvista")
    stand_in.wrap = lambda data: ("wrapped", data)
    monkeypatch.setitem(sys.modules, "pyvista", stand_in)
    kind, data = vtk.read_for_pyvista(str(ball), level=2, attributes=["normal"])
    assert kind == "wrapped" and data.GetNumberOfPolys() == 20 * 16
    assert data.GetPointData().GetNormals().GetName() == "normal"


# Debian 12 has ParaView 5.11.0 and Python 3.11, which lacks a function that ParaView's own module for
# plug-ins in Python imports.
PARAVIEW = """
import inspect, sys
if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec
from paraview.simple import *
LoadPlugin(sys.argv[1], ns=globals())
reader = PlaitReader(FileName=sys.argv[2], Level=2, Attributes=["normal"])
reader.UpdatePipeline()
information = reader.GetDataInformation()
print("polygons", information.GetNumberOfCells(), list(reader.PointData.keys()))
reader.Box = [-2, 2, -2, 2, 0.6, 2]
reader.UpdatePipeline()
print("in the box", reader.GetDataInformation().GetNumberOfCells())
print("opened", OpenDataFile(sys.argv[2]) is not None)
"""


def test_plug_in_of_paraview(ball, tmp_path):
    program = os.environ.get("PLAIT_PVPYTHON") or shutil.which("pvpython")
    if program is None:
        pytest.skip("ParaView is not installed")
    script = tmp_path / "script.py"
    script.write_text(PARAVIEW)
    plugin = pathlib.Path(plait.__file__).parent / "paraview_plugin.py"
    done = subprocess.run([program, "--force-offscreen-rendering", script, plugin, ball],
                          capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    with plait.open(ball) as store:
        mesh = store.mesh(2, box=([-2, -2, 0.6], [2, 2, 2]))
    assert "polygons 320 ['normal']" in done.stdout, done.stdout + done.stderr
    assert f"in the box {len(mesh.triangles)}\n" in done.stdout


def test_reader_shows_a_new_version_after_modified(tmp_path):
    path = tmp_path / "s.plait"
    make(icosahedron(), path, levels=2, normals=True).close()
    reader = vtk.Reader(path)
    reader.Update()
    low = reader.GetOutput().GetBounds()[0]
    with plait.open(path, writable=True) as writer:
        writer.visit(lambda v: 10 * v["position"], reads="position", writes="position")
        writer.add_attribute("height", np.float32)
        writer.remove_attribute("normal")
        writer.commit()
    reader.Update()  # nothing was asked for
    assert reader.GetOutput().GetBounds()[0] == low
    reader.Modified()
    reader.Update()
    assert reader.GetOutput().GetBounds()[0] == pytest.approx(10 * low)
    names = reader.GetAttributes()
    assert names.ArrayExists("height") and not names.ArrayExists("normal")
    names.EnableArray("height")
    reader.Update()
    assert reader.GetOutput().GetPointData().HasArray("height")
    shutil.rmtree(path)
    make(sheet(2), path, levels=1).close()  # another store of the same name
    names.DisableArray("height")
    reader.SetFileName(str(path))
    reader.Modified()
    reader.Update()
    assert reader.GetOutput().GetNumberOfPolys() == 8 * 4


def test_reader_takes_boxes_of_arrays_and_one_name(ball):
    low, high = np.array([-2.0, -2, 0.6]), np.array([2.0, 2, 2])
    reader = vtk.Reader(ball, level=2, box=(low, high), attributes="normal")
    reader.SetBox((low, high))
    reader.Update()
    part = reader.GetOutput().GetNumberOfPolys()
    assert 0 < part < 320 and reader.GetOutput().GetPointData().HasArray("normal")
    low[2] = -9  # the box is that of the call
    reader.Modified()
    reader.Update()
    assert reader.GetOutput().GetNumberOfPolys() == part
    reader.SetBox((low, [2, 2, 2]))
    reader.Update()
    assert reader.GetOutput().GetNumberOfPolys() == 320
    reader.SetBox(None)
    with pytest.raises(plait.InvalidArgument, match="box"):
        reader.SetBox(3)
    for wrong in (([0], [1]), ("abc", "def")):
        with pytest.raises((plait.InvalidArgument, ValueError)):
            reader.SetBox(wrong)
