"""Whole works: what the commands of the program do.

The library describes each job and its options (plait_job_options), so the functions here have the
options of the program, with underscores for dashes, and pass_ for pass. An argument that is None stands for the default."""

import collections.abc
import inspect
import json
import keyword
import os
from ctypes import byref, c_void_p
from typing import NamedTuple

from . import _functions
from . import _structures as types
from ._functions import LIBRARY
from ._progress import Watch, truth
from .errors import InvalidArgument
from .store import open_store


class Subdivision(NamedTuple):
    """What subdivide() made. Counts are those of the finest level; times are in seconds."""

    path: str
    levels: int
    vertices: int
    edges: int
    faces: int
    stored_bytes: int
    import_seconds: float
    layout_seconds: float
    refine_seconds: float
    commit_seconds: float
    digest_seconds: float
    base_level: int
    resumed_level: int
    digest: str


class Conversion(NamedTuple):
    """What convert() made. digest: of all records, if the copy was verified."""

    path: str
    from_stored_bytes: int
    stored_bytes: int
    digest: str


class Import(NamedTuple):
    """What import_mesh() found and made. vertices and faces are those of the file, border_edges those
    of the base mesh; times are in seconds. had_choice: several base meshes are equally deep."""

    path: str
    levels: int
    base_level: int
    vertices: int
    faces: int
    base_vertices: int
    base_faces: int
    border_edges: int
    had_choice: bool
    stored_bytes: int
    read_seconds: float
    recover_seconds: float
    write_seconds: float


class Remeshing(NamedTuple):
    """What remesh() made. vertices and faces are those of the finest level as it is drawn, and
    from_vertices and from_faces those of all faces with all levels; turned_faces: of the latter,
    how many are turned over. Lengths are in the units of the scan; distances are those of points
    spread over one surface to the closest points of the other, 0 if samples is 0. area_spread: of
    the areas of the small faces within a base face, 99th percentile to 1st: nine of ten base faces
    have at most percentile_90, and share_within_4 of them at most 4. base_meshes: how many were
    made, more than one only with no_foldover."""

    path: str
    scan_faces: int
    base_vertices: int
    base_faces: int
    vertices: int
    faces: int
    turned_faces: int
    stored_bytes: int
    diagonal: float
    mean_edge: float
    scan_to_store_rms: float
    scan_to_store_max: float
    store_to_scan_rms: float
    store_to_scan_max: float
    area_spread_percentile_90: float
    area_spread_share_within_4: float
    base_meshes: int
    from_vertices: int
    from_faces: int
    digest: str


class Distances(NamedTuple):
    """From points spread over one surface to the closest points of another, in the units of the
    meshes; angles, in degrees, between the normals of the triangles there."""

    samples: int
    max: float
    rms: float
    mean: float
    percentile_99: float
    percentile_99_9: float
    mean_angle: float
    percentile_99_angle: float


class Comparison(NamedTuple):
    """What compare() measured. diagonal, mean_edge: of surface a. there: from a to b; back: from b
    to a."""

    diagonal: float
    mean_edge: float
    there: Distances
    back: Distances


def _described(job):
    """What the library says of a job."""
    made = c_void_p()
    LIBRARY.plait_job_options(job.encode(), byref(made))
    return json.loads(_functions.taken_text(made))


def _name(option):
    name = option["name"].replace("-", "_")
    return name + "_" if keyword.iskeyword(name) else name


def _default(option):
    """The value of Python that stands for the default of an option."""
    text = option["default"]
    if option["kind"] == "texts":
        return ()
    if option["kind"] == "flag":
        return text == "true"
    if text is None or option["kind"] in ("path", "text", "choice", "bytes"):
        return text
    if option["kind"] == "count":
        return int(text) if text.isdigit() else None
    return float(text)


def _signature(described):
    by_place = [option for option in described["options"] if option["position"] >= 0]
    by_place += sorted((option for option in described["options"] if option["position"] < 0
                        and (option["required"]
                             or (option["name"] in _BY_PLACE and option["kind"] == "count"))),
                       key=lambda option: not option["required"])
    by_name = [option for option in described["options"] if option not in by_place]
    last = max(at for at, option in enumerate(by_place) if option["required"])
    parameters = [
        inspect.Parameter(_name(option), inspect.Parameter.POSITIONAL_OR_KEYWORD,
                          default=inspect.Parameter.empty if at <= last else _default(option))
        for at, option in enumerate(by_place)]
    parameters += [inspect.Parameter(_name(option), inspect.Parameter.KEYWORD_ONLY,
                                     default=_default(option)) for option in by_name]
    parameters += [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None)
                   for name in ("progress", "warn")]
    return inspect.Signature(parameters)


_BY_PLACE = ("faces", "levels", "level")  # counts that may also be given without their names


def _text(value):
    """The text of an option, as bytes."""
    if truth(value) is not None:
        return b"true" if value else b"false"
    if isinstance(value, (str, os.PathLike, bytes)):
        return _functions.path(value)
    if isinstance(value, (int, float)) or hasattr(value, "__index__"):
        return str(value).encode()
    raise InvalidArgument(f"expected a text or a number, found {value!r}")


def _options(described, values):
    """NAME=VALUE for each argument that the caller has given."""
    given = []
    for option in described["options"]:
        value = values.get(_name(option))
        if value is None or (value is False and option["kind"] != "flag"):
            continue
        several = (option["kind"] == "texts" and isinstance(value, collections.abc.Iterable)
                   and not isinstance(value, (str, bytes, os.PathLike)))
        for each in value if several else (value,):
            given.append(option["name"].encode() + b"=" + _text(each))
    return given


def _job(job, name, result, text):
    """The function that runs a job. `result` makes what it returns of the report."""
    described = _described(job)
    signature = _signature(described)

    def run(*arguments, **named):
        bound = signature.bind(*arguments, **named).arguments
        given = _options(described, bound)
        report = c_void_p()
        with Watch(job, bound.get("progress")) as watch:
            LIBRARY.plait_job_run(job.encode(), _functions.texts(given), len(given),
                                  watch.callback, watch.warning(bound.get("warn")), None,
                                  byref(report))
        return result(json.loads(_functions.taken_text(report)))

    run.__name__ = run.__qualname__ = name
    run.__signature__ = signature
    lines = "\n".join(f"    {_name(option)}: {option['help']}." for option in described["options"])
    run.__doc__ = f"""{text}

{lines}
    progress: True for a bar, or a function of (phase, done, total) whose False cancels.
    warn: a function of a text, told what was changed in the input; None: Python warns.

    Sizes are numbers of bytes, or texts such as "64MiB". Ctrl-C cancels. After that and after an
    error nothing half-made is left; with resume the last commit stays.
    """
    return run


def _filled(kind, report, **members):
    """A named tuple from the members of a report; those that it does not have are in `members`."""
    return kind(*(members[name] if name in members else report[name] for name in kind._fields))


def _subdivision(report):
    return _filled(Subdivision, report, path=report["store"] or "",
                   digest=report.get("digest", ""), digest_seconds=report.get("digest_seconds", 0.0))


def _remeshing(report):
    distances = {f"{way}_{name}": report.get(way, {}).get(name, 0.0)
                 for way in ("scan_to_store", "store_to_scan") for name in ("rms", "max")}
    spread = {f"area_spread_{name}": value for name, value in report["area_spread"].items()}
    return _filled(Remeshing, report, path=report["store"],
                   scan_faces=report["scan_figures"]["faces"],
                   base_vertices=report["base_figures"]["vertices"],
                   base_faces=report["base_figures"]["faces"], digest=report.get("digest", ""),
                   **distances, **spread)


def _distances(report):
    return _filled(Distances, report, mean_angle=report["mean_normal_degrees"],
                   percentile_99_angle=report["percentile_99_normal_degrees"])


def _comparison(report):
    return Comparison(report["diagonal"], report["mean_edge"], _distances(report["a_to_b"]),
                      _distances(report["b_to_a"]))


subdivide = _job("subdivide", "subdivide", _subdivision,
                 """Refines the mesh of a file into a store, as `plait subdivide` does: a named tuple Subdivision.""")
convert = _job("convert", "convert", lambda report: _filled(Conversion, report, path=report["store"],
                                                 digest=report.get("digest", "")),
               """Copies a store, as `plait convert` does: a named tuple Conversion. The copy is like the store in
    everything that no argument changes.""")
import_mesh = _job("import", "import_mesh", lambda report: _filled(Import, report, path=report["store"]),
                   """Makes a store of a file whose triangles are those of a coarser mesh, split into four again and
    again, as `plait import` does: a named tuple Import. The store has positions and attributes with
    the bits of the file.""")
remesh = _job("remesh", "remesh", _remeshing,
              """Makes a store of a scan, which may be any triangle mesh, as `plait remesh` does: a named tuple
    Remeshing.""")
check = _job("check", "check", dict,
             """Says what is wrong with the mesh of a file, without changing it, as `plait check` does: a dict, that of
    --json.""")
compare = _job("compare", "compare", _comparison,
               """Measures the distances between two surfaces, each a mesh file or a store, as `plait compare` does: a
    named tuple Comparison. Both have to fit in memory.""")
export = _job("export", "export", dict,
              """Writes one level of a store, or a part of it, as a mesh file, as `plait export` does: a dict, that of
    --json.""")
run_pass = _job("pass", "run_pass", dict,
                """Smooths or moves the vertices of a store, or makes normals anew, as `plait pass` does: a dict, that
    of --json. Without `out` the commit makes the next version of the store.""")
generate = _job("generate", "generate", dict,
                """Makes a base mesh from a seed, as `plait generate` does: a dict, that of --json.""")
layout = _job("layout", "layout", dict,
              """Puts a mesh larger than memory in the order of a store, as `plait layout MESH OUT` does: a dict, that of
    --json. `subdivide` and `plan` take `out` as their mesh.""")
render = _job("render", "render", dict,
              """Draws one level of a store as a PNG, as `plait render` does: a dict, that of --json.""")
prune = _job("prune", "prune", dict,
             """Copies a store with fewer levels where fewer are enough, so that each face has a depth of its own, as
    `plait prune` does: a dict, that of --json.""")
publish = _job("publish", "publish", dict,
               """Copies a store so that browsers can show it from any web server, as `plait publish` does: a dict,
    that of --json.""")
plan = _job("plan", "plan", dict,
            """Cuts a subdivision, or a pass over a store in shards, into parts that many machines can make, as
    `plait plan` does: a dict, that of --json.""")
part = _job("part", "part", dict,
            """Makes one part of a plan, as `plait part` does: a dict, that of --json.""")
join = _job("join", "join", dict,
            """Makes a store, or the next version of one, of the parts of a plan, as `plait join` does: a dict, that of
    --json. BadState lists parts that are missing or damaged.""")
status = _job("status", "status", dict,
              """Says how far a plan is, as `plait status` does: a dict, that of --json.""")


def verify(store, memory=types.DEFAULT_BUDGET_BYTES, progress=None):
    """Reads every block of the store at a path and compares its checksum: a named tuple
    VerifyReport."""
    with open_store(store, memory=memory) as opened:
        return opened.verify(progress)
