"""Each job has the same options and the same defaults in C++, in C, in the program and in Python."""

import inspect
import json
import os
import re
import subprocess

import plait
import plait.jobs
import pytest
from ctypes import byref, c_void_p

from plait import _functions

def python_name(option):
    return "pass_" if option == "pass" else option.replace("-", "_")


# A row of --help. A later CLI11 writes "N [3]" for "N=3".
OPTION = re.compile(r"  (--[a-z-]+|[A-Z]+)(?: [^ =]+)??(?:=(\S+)| \[([^A-Z]*?)\])?(?: \.\.\.)?"
                    r"(?: REQUIRED)?(?:  |$)")
# Of a command that is more than its job: orders are compared without the job.
OF_THE_COMMAND_ALONE = {"layout": ("layout", "png", "force")}
FUNCTIONS = {"import": "import_mesh", "pass": "run_pass"}  # where the name of the job is a word of Python


def in_c():
    """{job: {option: (kind, default)}}"""
    made = c_void_p()
    _functions.LIBRARY.plait_job_options(None, byref(made))
    return {job["name"]: {option["name"]: (option["kind"], option["default"])
                          for option in job["options"]}
            for job in json.loads(_functions.taken_text(made))}


JOBS = in_c()


def in_cpp():
    """The same, of the program tests/jobs/print_jobs.cpp."""
    shown = subprocess.run([os.environ["PLAIT_PRINT_JOBS"]], capture_output=True, text=True,
                           check=True).stdout
    found = {}
    for line in shown.splitlines():
        job, option, kind, default = line.split(" ", 3)
        found.setdefault(job, {})[option] = (kind, None if default == "-" else default)
    return found


def test_there_are_jobs():
    assert {"subdivide", "plan", "part", "join", "import", "remesh", "convert", "check", "compare", "pass",
            "generate", "render"} <= set(JOBS)


def test_jobs_of_cpp_are_those_of_c():
    assert in_cpp() == JOBS


@pytest.mark.parametrize("job", JOBS)
def test_command_has_the_options_and_defaults(job):
    shown = subprocess.run([os.environ["PLAIT_PROGRAM"], job, "--help"], capture_output=True,
                           text=True, check=True).stdout
    found = {}
    for line in shown.splitlines():
        match = OPTION.match(line)
        if match:
            found[match.group(1).lower().lstrip("-")] = match.group(2) or match.group(3)
    for name in ("json", "plugin"):  # of all commands
        assert found.pop(name, None) is None
    for name in OF_THE_COMMAND_ALONE.get(job, {}):
        found.pop(name)
    assert found == {name: None if kind == "flag" else default
                     for name, (kind, default) in JOBS[job].items()}


@pytest.mark.parametrize("job", JOBS)
def test_function_of_python_has_the_options_and_defaults(job):
    function = getattr(plait, FUNCTIONS.get(job, job))
    found = {name: parameter.default
             for name, parameter in inspect.signature(function).parameters.items()}
    for name in ("progress", "warn"):
        assert found.pop(name) is None
    expected = {}
    for name, (kind, default) in JOBS[job].items():
        expected[python_name(name)] = (
            default == "true" if kind == "flag" else () if kind == "texts"
            else int(default) if kind == "count" and default and default.isdigit()
            else None if kind == "count" else float(default) if kind == "number" and default
            else default)
    assert {name: None if default is inspect.Parameter.empty else default
            for name, default in found.items()} == expected


@pytest.mark.parametrize("job", JOBS)
def test_stub_has_the_options(job):
    path = os.path.join(os.path.dirname(plait.__file__), "__init__.pyi")
    with open(path, encoding="utf-8") as stub:
        line = re.search(r"^def %s\((.*)\) ->" % FUNCTIONS.get(job, job), stub.read(), re.M)
    names = re.findall(r"(\w+): ", line.group(1))
    assert sorted(names) == sorted([python_name(name) for name in JOBS[job]]
                                   + ["progress", "warn"])


def test_generate_and_render_make_the_files_of_the_program(tmp_path):
    program = os.environ["PLAIT_PROGRAM"]
    told = []
    made = plait.generate("open-sheet", tmp_path / "a.ply", vertices=500, seed=3,
                          progress=lambda *each: told.append(each))
    assert made["vertices"] == 500 and made["kind"] == "open-sheet" and made["seed"] == 3
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told) and told
    subprocess.run([program, "generate", "open-sheet", tmp_path / "b.ply", "--vertices", "500", "--seed", "3"],
                   check=True, stdout=subprocess.DEVNULL)
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    with pytest.raises(plait.AlreadyExists):
        plait.generate("torus", tmp_path / "a.ply", vertices=500)
    plait.subdivide(tmp_path / "a.ply", tmp_path / "s.plait", levels=2)
    drawn = plait.render(tmp_path / "s.plait", tmp_path / "a.png", size="160x120", view="10,60", up="z")
    assert (drawn["width"], drawn["height"], drawn["level"]) == (160, 120, 2)
    subprocess.run([program, "render", tmp_path / "s.plait", tmp_path / "b.png", "--size", "160x120",
                    "--view", "10,60", "--up", "z"], check=True, stdout=subprocess.DEVNULL)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
