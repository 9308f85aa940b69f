"""Every line of code of docs/python.md runs, and it prints what the page says."""

import os
import pathlib
import re

import plait
import pytest
from conftest import icosahedron, make, write_ply

PAGE = pathlib.Path(os.environ["PLAIT_SOURCE"]) / "docs" / "python.md"


def blocks(language):
    return re.findall(r"```%s\n(.*?)```" % language, PAGE.read_text(encoding="utf-8"), re.S)


def base_mesh():
    """4,002 faces as the page has them would take long: a sphere of 320 faces."""
    mesh = make(icosahedron(), levels=2, scheme="loop").mesh(2)
    return mesh.vertices, mesh.triangles


def test_code_of_the_page_runs(tmp_path, monkeypatch, capsys):
    pytest.importorskip("dask.array")
    write_ply(tmp_path / "molecule.ply", base_mesh())
    write_ply(tmp_path / "fine.ply", base_mesh())
    monkeypatch.chdir(tmp_path)
    code = blocks("python")
    assert len(code) >= 8
    names = {}
    for number, block in enumerate(code[:4] + code):  # a notebook runs its cells again
        exec(compile(block, f"docs/python.md, block {number + 1}", "exec"), names)
    shown = capsys.readouterr().out
    assert "nothing.plait" in shown
    words = re.sub(r"[\d.]+ MiB of|\d+ patches", "", blocks("text")[0]).strip()
    assert words in re.sub(r"[\d.]+ MiB of|\d+ patches", "", shown)
    assert len(names["faces"]) == 512 and names["store"].levels[-1] == 5
    assert {"height", "depth", "smooth"} <= set(plait.open("torus.plait").attributes)
    assert names["imported"].levels == 2 and names["made"].base_faces <= 101
    assert names["corners"].shape == (1024, 3, 3) and names["some"].shape == (3, 3)


def test_code_of_the_page_for_vtk_runs(tmp_path, monkeypatch):
    pytest.importorskip("vtkmodules.vtkCommonExecutionModel")
    make(icosahedron(), tmp_path / "torus.plait", levels=5, normals=True).close()
    monkeypatch.chdir(tmp_path)
    names = {"low": [-2, -2, -2], "high": [2, 2, 0]}
    block, = blocks("vtk")
    exec(compile(block, "docs/python.md, VTK", "exec"), names)
    assert names["surface"].GetNumberOfPolys() == 20 * 16
    assert 0 < names["reader"].GetOutput().GetNumberOfPolys() <= 20 * 256
