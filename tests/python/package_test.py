"""The wheel: built without a network, with the library inside, and used where nothing else is."""

import hashlib
import importlib.metadata
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import zipfile

import plait
import pytest

SOURCE = pathlib.Path(os.environ["PLAIT_SOURCE"]) / "python"


@pytest.fixture
def builder():
    spec = importlib.util.spec_from_file_location("plait_build", SOURCE / "plait_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def clean_environment(path):
    """Without the variables by which the tests find package and library."""
    kept = {name: value for name, value in os.environ.items()
            if name not in ("PLAIT_LIBRARY", "PYTHONPATH", "PLAIT_SOURCE")}
    return {**kept, "PYTHONPATH": str(path)}


def test_wheel_works_where_nothing_else_is(builder, tmp_path):
    name = builder.build_wheel(tmp_path)
    assert name.startswith("plait-0.1.0-py3-none-linux")
    with zipfile.ZipFile(tmp_path / name) as wheel:
        names = wheel.namelist()
        for line in wheel.read("plait-0.1.0.dist-info/RECORD").decode().splitlines():
            file, digest, size = line.split(",")
            if digest:
                data = wheel.read(file)
                found = builder.base64.urlsafe_b64encode(hashlib.sha256(data).digest())
                assert digest == "sha256=" + found.rstrip(b"=").decode() and len(data) == int(size)
            names.remove(file)
        assert not names
        wheel.extractall(tmp_path / "installed")
    for file in ("libplait.so.0", "py.typed", "__init__.pyi", "store.py"):
        assert (tmp_path / "installed" / "plait" / file).exists()
    licence = tmp_path / "installed" / "plait-0.1.0.dist-info" / "LICENSE"
    assert licence.read_bytes() == (SOURCE.parent / "LICENSE").read_bytes()
    code = ("import plait, numpy as np; s = plait.create(np.eye(4, 3) - .2, "
            "[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]); s.subdivide(2); "
            "print(plait.__file__, len(s.mesh().vertices))")
    shown = subprocess.run([sys.executable, "-c", code], env=clean_environment(tmp_path / "installed"),
                           cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert shown.split() == [str(tmp_path / "installed" / "plait" / "__init__.py"), "34"]


def test_wheel_names_the_reader_to_pyvista(builder, tmp_path):
    with zipfile.ZipFile(tmp_path / builder.build_wheel(tmp_path)) as wheel:
        wheel.extractall(tmp_path / "installed")
    package, = importlib.metadata.distributions(name="plait", path=[str(tmp_path / "installed")])
    assert package.version == plait.__version__ and package.requires == ["numpy"]
    found, = package.entry_points
    assert (found.group, found.name) == ("pyvista.readers", ".plait")
    pytest.importorskip("vtkmodules.vtkCommonExecutionModel")
    assert callable(found.load())
    tomllib = pytest.importorskip("tomllib")
    project = tomllib.loads((SOURCE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"] == {found.group: {found.name: found.value}}
    assert project["dependencies"] == package.requires
    for key, name in {"description": "Summary", "requires-python": "Requires-Python",
                      "version": "Version"}.items():
        assert project[key] == package.metadata[name]
    assert project["license"]["text"] == package.metadata["License"]


@pytest.mark.parametrize("how", ["pip", "build"])
def test_the_usual_programs_make_the_package_without_a_network(how, tmp_path):
    if subprocess.run([sys.executable, "-m", how, "--version"], capture_output=True,
                      check=False).returncode:
        pytest.skip(f"{how} is not installed")
    shutil.copytree(SOURCE, tmp_path / "python", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(SOURCE.parent / "LICENSE", tmp_path)
    environment = {**os.environ, "PIP_NO_INDEX": "1", "HOME": str(tmp_path)}
    out = tmp_path / "out"
    if how == "pip":  # numpy is there already
        command = ["pip", "install", "--no-deps", "--target", out, tmp_path / "python"]
    else:
        command = ["build", "--no-isolation", "--outdir", out, tmp_path / "python"]
    done = subprocess.run([sys.executable, "-m", *command], env=environment, cwd=tmp_path,
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    if how == "pip":
        assert (out / "plait" / "libplait.so.0").exists() and (out / "plait" / "py.typed").exists()
    else:
        assert sorted(each.suffix for each in out.iterdir()) == [".gz", ".whl"]


def test_the_commands_of_the_page_install_the_package(tmp_path):
    """On Debian 12 the system's pip refuses to install anything outside of a virtual environment."""
    pytest.importorskip("ensurepip")
    shutil.copytree(SOURCE, tmp_path / "python", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(SOURCE.parent / "LICENSE", tmp_path)
    page = (SOURCE.parent / "docs" / "python.md").read_text(encoding="utf-8")
    commands = page.split("```sh\n")[1].split("```")[0].replace("python3 -m venv", f"{sys.executable} -m venv")
    environment = {**os.environ, "PIP_NO_INDEX": "1", "HOME": str(tmp_path)}
    done = subprocess.run(["sh", "-ec", commands], env=environment, cwd=tmp_path, capture_output=True,
                          text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    shown = subprocess.run([tmp_path / "env" / "bin" / "python", "-c", "import plait; print(plait.__file__)"],
                           env=clean_environment(""), cwd=tmp_path, check=True, capture_output=True,
                           text=True).stdout
    assert shown.startswith(str(tmp_path / "env"))


def test_source_archive_makes_the_same_wheel(builder, tmp_path):
    name = builder.build_sdist(tmp_path)
    with tarfile.open(tmp_path / name) as archive:
        archive.extractall(tmp_path)
    code = "import plait_build, sys; print(plait_build.build_wheel(sys.argv[1]))"
    (tmp_path / "out").mkdir()
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "out")], check=True,
                   cwd=tmp_path / "plait-0.1.0", env=clean_environment(tmp_path / "plait-0.1.0"))
    wheel = builder.build_wheel(tmp_path)
    with zipfile.ZipFile(tmp_path / wheel) as here, zipfile.ZipFile(tmp_path / "out" / wheel) as there:
        assert [(entry.filename, entry.CRC) for entry in here.infolist()] == [
            (entry.filename, entry.CRC) for entry in there.infolist()]


def test_versions_are_one(builder):
    assert builder.VERSION == plait.__version__
    assert f'version = "{plait.__version__}"' in (SOURCE / "pyproject.toml").read_text()


def test_without_a_library_the_import_says_where_it_looked(tmp_path):
    code = "import plait"
    environment = {**clean_environment(SOURCE), "PLAIT_LIBRARY": str(tmp_path / "none.so")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 1 and "PLAIT_LIBRARY" in done.stderr and "none.so" in done.stderr
