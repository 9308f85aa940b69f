"""The stub file says what the package has."""

import ast
import inspect
import os
import pathlib
import subprocess
import sys

import plait
import pytest

STUB = ast.parse((pathlib.Path(plait.__file__).parent / "__init__.pyi").read_text(encoding="utf-8"))


def parameters(function):
    """Names and kinds, and which have defaults, of a function in the stub."""
    arguments = function.args
    positional = [each.arg for each in arguments.posonlyargs + arguments.args]
    optional = positional[len(positional) - len(arguments.defaults):] if arguments.defaults else []
    only = [each.arg for each in arguments.kwonlyargs]
    optional += [name for name, default in zip(only, arguments.kw_defaults) if default is not None]
    return positional, only, set(optional)


def parameters_of(function):
    found = inspect.signature(function).parameters.values()
    positional = [each.name for each in found if each.kind == each.POSITIONAL_OR_KEYWORD]
    only = [each.name for each in found if each.kind == each.KEYWORD_ONLY]
    return positional, only, {each.name for each in found if each.default is not each.empty}


def public(names):
    return {name for name in names if not name.startswith("_")}


def test_stub_has_the_names_of_the_package():
    declared = {node.name for node in STUB.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    assert declared == set(plait.__all__)
    for name in plait.__all__:
        assert getattr(plait, name).__doc__, name


def test_functions_of_the_stub_have_the_parameters_of_the_package():
    checked = 0
    for node in STUB.body:
        if isinstance(node, ast.FunctionDef):
            assert parameters(node) == parameters_of(getattr(plait, node.name)), node.name
            checked += 1
        elif isinstance(node, ast.ClassDef):
            kind = getattr(plait, node.name)
            for each in node.body:
                if isinstance(each, ast.FunctionDef) and not each.decorator_list:
                    found = getattr(kind, each.name)
                    if each.name not in ("__exit__", "__array__"):
                        assert parameters(each) == parameters_of(found), (node.name, each.name)
                        checked += 1
    assert checked > 30


def test_classes_of_the_stub_have_the_members_of_the_package():
    for node in STUB.body:
        if not isinstance(node, ast.ClassDef):
            continue
        kind = getattr(plait, node.name)
        assert [base.id for base in node.bases if base.id != "NamedTuple"] == [
            base.__name__ for base in kind.__bases__ if base not in (object, tuple)], node.name
        fields = [each.target.id for each in node.body if isinstance(each, ast.AnnAssign)]
        if issubclass(kind, tuple):
            assert tuple(fields) == kind._fields, node.name
        functions = public(each.name for each in node.body if isinstance(each, ast.FunctionDef))
        present = public(name for name, value in vars(kind).items()
                         if inspect.isfunction(value) or isinstance(value, property))
        assert functions == present, node.name


def mypy(folder, module, *arguments):
    """What mypy says about this package as it is here. It leaves out modules of others that are not
    installed."""
    pytest.importorskip("mypy")
    settings = folder / "mypy.ini"
    settings.write_text("[mypy]\nignore_missing_imports = True\n")
    package = str(pathlib.Path(plait.__file__).parent.parent)
    option = "--mypy-config-file" if module == "mypy.stubtest" else "--config-file"
    done = subprocess.run([sys.executable, "-m", module, *arguments, option, str(settings)],
                          env={**os.environ, "MYPYPATH": package}, cwd=folder, text=True,
                          capture_output=True, check=False)
    return done.returncode, done.stdout + done.stderr


def test_mypy_finds_the_stub_and_the_package_equal(tmp_path):
    # Objects that only the package makes; modules whose types the stub does not tell.
    (tmp_path / "left_out").write_text(r"""
plait\.(Attribute|LevelArray|PatchWriter|Shown|Store|Vertices)\.__init__
plait\.__dir__
plait\.(_identity|_results|attributes|jobs|mesh|paraview_plugin|store|vtk)(\..*)?
""")
    failed, shown = mypy(tmp_path, "mypy.stubtest", "plait", "--ignore-missing-stub", "--concise",
                         "--allowlist", "left_out", "--ignore-unused-allowlist")
    assert not failed, shown


def test_mypy_takes_a_program_that_is_right_and_no_other(tmp_path):
    (tmp_path / "right.py").write_text("""
import numpy as np
import plait

def box_of(path: str) -> plait.Mesh:
    plait.subdivide("m.ply", path, 5, normals=True, progress=True, warn=print)
    with plait.open(path, memory="64MiB") as store:
        level = store["position"][store.levels[-1]]
        part = level[10:20].astype(np.float64)
        hits = store.along_ray([0, 0, 5], part[0])
        first: int = next(level.blocks()).first
        for face in hits.faces:
            store.patch(int(face), level=first)
        try:
            return store.mesh(4, box=(part.min(axis=0), part.max(axis=0)), attributes=["normal"])
        except plait.TooLarge as error:
            raise SystemExit(f"{error}: {error.path}")

def push(vertices: plait.Vertices) -> object:
    return vertices["position"] + vertices.neighbours("position").mean(axis=1)

with plait.create(np.eye(4, 3), [[0, 1, 2]]) as made:
    made.visit(push, reads="position", writes=["moved"], rings=True)
""")
    failed, shown = mypy(tmp_path, "mypy", "--strict", "right.py")
    assert not failed, shown
    wrong = ["plait.open(3)", "plait.open('s').mesh(level='4')", "plait.open('s').levels()",
             "plait.subdivide('m', 's', 5, durability='maybe')", "plait.verify('s').vertices"]
    (tmp_path / "wrong.py").write_text("\n".join(["import plait", *wrong]))
    failed, shown = mypy(tmp_path, "mypy", "--strict", "wrong.py")
    assert failed and [line for line in range(2, 7) if f"wrong.py:{line}: error" in shown] == [
        2, 3, 4, 5, 6], shown
