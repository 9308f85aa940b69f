"""Whole works: what the commands of the program do."""

from ctypes import byref
from typing import NamedTuple

from . import _functions, _memory
from . import _structures as types
from ._functions import LIBRARY, text, texts
from ._progress import Watch
from .errors import InvalidArgument
from .store import open_store

_EXISTING = {"refuse": 0, "replace": 1, "resume": 2}
_DURABILITY = {"commit": 0, "none": 1}
_PRECISION = {None: 0, "auto": 0, "float32": types.FLOAT32, "float64": types.FLOAT64}


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
    """What remesh() made. vertices and faces are those of the finest level; turned_faces: of these,
    how many are turned over. Lengths are in the units of the scan; distances are those of points
    spread over one surface to the closest points of the other, 0 if samples is 0. area_spread: of
    the areas of the small faces within a base face, 99th percentile to 1st: nine of ten base faces
    have at most percentile_90, and share_within_4 of them at most 4. base_meshes: how many were
    made, more than one only with refuse_turned."""

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
    """What compare() measured. diagonal, mean_edge: of the first surface. there: from the first to
    the second; back: from the second to the first."""

    diagonal: float
    mean_edge: float
    there: Distances
    back: Distances


def chosen(what, value, choices):
    """The number of a choice."""
    try:
        return choices[value]
    except (KeyError, TypeError):
        known = ", ".join(repr(name) for name in choices)
        raise InvalidArgument(f"{what}: expected one of {known}, found {value!r}") from None


def welded(weld):
    """The members of a request for `weld`: None or False, True, or a tolerance."""
    wanted = weld is not None and weld is not False
    return {"weld": int(wanted), "weld_tolerance": 0.0 if not wanted or weld is True else weld}


def subdivide(mesh, store, levels, *, scheme="loop", normals=False, limit=False, backend=None,
              compress=(), max_error=(), layout=None, executor="auto", precision=None, weld=None,
              block=None, max_slot=None, memory=None, threads=1, existing="refuse", durability="commit",
              verify=False, digest=False, ignore_size=False, progress=None, warn=None):
    """Refines the mesh of a file into a store, as `plait subdivide` does, and returns a named tuple
    Subdivision.

    mesh: a file: PLY, OBJ, OFF or STL, also .gz and .zst. store: the directory to make.
    levels: the level to reach. normals, limit: also make unit normals; project positions to the
    limit surface. backend, compress, max_error, layout, executor, precision, block, max_slot,
    memory, threads: as the options of the program. precision: "float32", "float64" or "auto".
    weld: True makes vertices of equal positions one, a number those at most so far apart.
    existing: "refuse", "replace" or "resume".
    progress: True for a bar, or a function of (phase, done, total) whose False cancels.
    warn: a function of a text, told what was changed in the mesh; None: Python warns.

    Ctrl-C cancels. After that and after an error nothing half-made is left; with "resume" the last
    commit stays.
    """
    compress_array, compress_count = texts(compress)
    errors_array, error_count = texts(max_error)
    result = types.plait_subdivision_result()
    with Watch("subdivide", progress) as watch:
        request = types.plait_subdivision_request(
            mesh_path=_functions.path(mesh), store_path=_functions.path(store),
            backend=text(backend), layout=text(layout), scheme=text(scheme),
            executor=text(executor), compress=compress_array, compress_count=compress_count,
            max_errors=errors_array, max_error_count=error_count,
            block_bytes=_memory.bytes_of(block or 0), max_slot_bytes=_memory.bytes_of(max_slot or 0),
            budget_bytes=_memory.bytes_of(memory or 0), progress=watch.callback,
            warn=watch.warning(warn), levels=levels, threads=threads,
            precision=chosen("precision", precision, _PRECISION),
            existing=chosen("existing", existing, _EXISTING),
            durability=chosen("durability", durability, _DURABILITY), normals=int(normals),
            limit=int(limit), verify=int(verify), digest=int(digest), ignore_size=int(ignore_size),
            **welded(weld))
        LIBRARY.plait_job_subdivide(byref(request), byref(result))
    return Subdivision(str(store), *(
        getattr(result, name).decode() if name == "digest" else getattr(result, name)
        for name in Subdivision._fields[1:]))


def convert(store, to, *, backend=None, compress=(), max_error=(), block=None, memory=None,
            threads=1, existing="refuse", verify=False, progress=None, warn=None):
    """Copies a store into another backend, compression or block size, as `plait convert` does, and
    returns a named tuple Conversion. The copy is like the store in everything that no argument
    changes.

    backend, compress, max_error, block, memory, threads: as the options of the program.
    existing: "refuse" or "replace". verify: read the copy back from the disk and compare it.
    progress, warn, Ctrl-C: as for subdivide().
    """
    compress_array, compress_count = texts(compress)
    errors_array, error_count = texts(max_error)
    result = types.plait_conversion_result()
    with Watch("convert", progress) as watch:
        request = types.plait_conversion_request(
            from_path=_functions.path(store), to_path=_functions.path(to), backend=text(backend),
            compress=compress_array, compress_count=compress_count, max_errors=errors_array,
            max_error_count=error_count, block_bytes=_memory.bytes_of(block or 0),
            budget_bytes=_memory.bytes_of(memory or 0), progress=watch.callback,
            warn=watch.warning(warn), threads=threads,
            existing=chosen("existing", existing, {"refuse": 0, "replace": 1}), verify=int(verify))
        LIBRARY.plait_job_convert(byref(request), byref(result))
    return Conversion(str(to), result.from_stored_bytes, result.stored_bytes,
                      result.digest.decode())


def import_mesh(mesh, store, levels=None, *, backend=None, compress=(), layout=None,
                precision=None, weld=None, block=None, max_slot=None, memory=None, threads=1,
                existing="refuse", durability="commit", ignore_size=False, progress=None,
                warn=None):
    """Makes a store of a file whose triangles are those of a coarser mesh, split into four again
    and again, as `plait import` does, and returns a named tuple Import. The store has positions and
    attributes with the bits of the file.

    mesh: a file: PLY, OBJ, OFF or STL, also .gz and .zst. levels: so many; None: all that there
    are. precision: "float32" or "float64"; None: as the file needs it. The other arguments are those of
    subdivide().
    """
    compress_array, compress_count = texts(compress)
    result = types.plait_import_result()
    with Watch("import", progress) as watch:
        request = types.plait_import_request(
            mesh_path=_functions.path(mesh), store_path=_functions.path(store),
            backend=text(backend), layout=text(layout), compress=compress_array,
            compress_count=compress_count, block_bytes=_memory.bytes_of(block or 0),
            max_slot_bytes=_memory.bytes_of(max_slot or 0),
            budget_bytes=_memory.bytes_of(memory or 0), progress=watch.callback,
            warn=watch.warning(warn), levels=levels or 0, threads=threads,
            precision=chosen("precision", precision, _PRECISION),
            existing=chosen("existing", existing, {"refuse": 0, "replace": 1}),
            durability=chosen("durability", durability, _DURABILITY), ignore_size=int(ignore_size),
            **welded(weld))
        LIBRARY.plait_job_import(byref(request), byref(result))
    return Import(str(store), *(
        bool(result.had_choice) if name == "had_choice" else getattr(result, name)
        for name in Import._fields[1:]))


def remesh(scan, store, faces, levels=3, *, min_component=0, fill_holes=0, refuse_turned=False,
           distances=False, samples=1_000_000, precision=None, weld=None, backend=None, memory=None, threads=1,
           existing="refuse", digest=False, ignore_size=False, progress=None, warn=None):
    """Makes a store of a scan, which may be any triangle mesh, as `plait remesh` does, and returns
    a named tuple Remeshing.

    scan: a file: PLY, OBJ, OFF or STL, also .gz and .zst. faces: of the base mesh, at most.
    levels: the finest level. min_component: removes components of fewer faces. fill_holes: fills
    holes of at most so many edges. refuse_turned: makes base meshes anew, at most 8, while small
    faces are turned over; an error if some stay. distances: adds attribute "distance", how far the
    scan is from the store at each vertex, in the units of the scan. samples: points of the report
    for each direction; 0 for no distances there. The other arguments are those of subdivide().
    """
    result = types.plait_remesh_result()
    with Watch("remesh", progress) as watch:
        request = types.plait_remesh_request(
            scan_path=_functions.path(scan), store_path=_functions.path(store),
            backend=text(backend), faces=faces, samples=samples, min_component=min_component,
            fill_holes=fill_holes, budget_bytes=_memory.bytes_of(memory or 0),
            progress=watch.callback, warn=watch.warning(warn), levels=levels, threads=threads,
            existing=chosen("existing", existing, {"refuse": 0, "replace": 1}),
            refuse_turned=int(refuse_turned), digest=int(digest), ignore_size=int(ignore_size),
            distances=int(distances), precision=chosen("precision", precision, _PRECISION),
            **welded(weld))
        LIBRARY.plait_job_remesh(byref(request), byref(result))
    return Remeshing(str(store), *(
        result.digest.decode() if name == "digest" else getattr(result, name)
        for name in Remeshing._fields[1:]))


def compare(first, second, level=None, *, samples=1_000_000, threads=1, progress=None, warn=None):
    """Measures the distances between two surfaces, each a mesh file or a store, as `plait compare`
    does, and returns a named tuple Comparison. Both have to fit in memory.

    level: of stores; None: the finest. samples: points on each surface.
    """
    result = types.plait_comparison_result()
    with Watch("compare", progress) as watch:
        request = types.plait_comparison_request(
            first_path=_functions.path(first), second_path=_functions.path(second),
            samples=samples, progress=watch.callback, warn=watch.warning(warn),
            level=types.FINEST_LEVEL if level is None else level, threads=threads)
        LIBRARY.plait_job_compare(byref(request), byref(result))
    there, back = (Distances(*(getattr(each, name) for name in Distances._fields))
                   for each in (result.there, result.back))
    return Comparison(result.diagonal, result.mean_edge, there, back)


def verify(store, memory=types.DEFAULT_BUDGET_BYTES, progress=None):
    """Reads every block of the store at a path and compares its checksum: a named tuple
    VerifyReport."""
    with open_store(store, memory=memory) as opened:
        return opened.verify(progress)
