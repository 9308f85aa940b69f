"""plait: meshes far larger than memory, as numpy arrays.

    import plait
    plait.subdivide("molecule.ply", "molecule.plait", levels=5, normals=True, progress=True)
    store = plait.open("molecule.plait")
    store["position"][5][:1000]              # vertices of level 5, as an array
    store.patch(0, level=5)                  # all vertices of one patch
    store.mesh(level=3, box=(low, high))     # vertices and triangles in a box

docs/python.md is the page about it.
"""

from ._functions import LIBRARY as _LIBRARY
from ._functions import path as _path
from .attributes import Attribute, Block, LevelArray
from ._making import create
from ._results import (Base, Counts, DamagedBlock, Hits, Info, Input, Patches, Points, Statistics,
                       VerifyReport)
from .errors import (AlreadyExists, BadState, Busy, Cancelled, Damaged, Error, InputOutputError,
                     InternalError, InvalidArgument, NoSpace, NoSuchAttribute, NoSuchLevel, NotFound,
                     NotSupported, OutOfMemory, TooLarge)
from .jobs import (Comparison, Conversion, Distances, Import, Remeshing, Subdivision, check,
                   compare, convert, export, generate, import_mesh, join, layout, part, plan, prune, publish, remesh, render,
                   run_pass, status, subdivide,
                   verify)
from .mesh import Mesh, triangles
from .showing import Shown, show
from .store import Store
from .store import open_store as open  # plait.open, as numpy has load and h5py has File
from .visits import Vertices
from .writing import PatchWriter

__version__ = _LIBRARY.plait_version_string().decode()


def build_info():
    """What the library has: a dict with the names of backends, codecs, filters, schemes, executors
    and layouts."""
    lines = _LIBRARY.plait_build_info().decode().splitlines()
    return {line.split(":")[0]: line.split(":")[1].split() for line in lines}


def load_plugin(file):
    """Loads a shared library that adds backends, codecs and filters, until the process ends."""
    _LIBRARY.plait_plugin_load(_path(file))


def __dir__():
    return [*__all__, "__version__", "__doc__"]


__all__ = [
    "AlreadyExists", "Attribute", "BadState", "Base", "Block", "Busy", "Cancelled", "Comparison", "Conversion", "Counts",
    "Damaged", "DamagedBlock", "Distances", "Error", "Hits", "Import", "Info", "Input", "InputOutputError", "InternalError",
    "InvalidArgument", "LevelArray", "Mesh", "NoSpace", "NoSuchAttribute", "NoSuchLevel", "NotFound",
    "NotSupported", "OutOfMemory", "PatchWriter", "Patches", "Points", "Remeshing", "Shown", "Statistics", "Store", "Subdivision", "TooLarge",
    "VerifyReport", "Vertices", "build_info", "check", "compare", "convert", "create", "export", "generate", "import_mesh", "join", "layout", "load_plugin",
    "open", "part", "plan", "prune", "publish", "remesh", "render", "run_pass", "show", "status", "subdivide",
    "triangles", "verify"]
