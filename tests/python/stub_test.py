"""The stub file says what the package has."""

import ast
import inspect
import pathlib

import plait

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
