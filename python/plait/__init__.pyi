"""Types of the package. tests/python/stub_test.py compares them with the package."""

from os import PathLike
from typing import Any, Callable, Iterator, Literal, NamedTuple, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

_Path = Union[str, bytes, PathLike]
_Size = Union[int, str]
_Names = Union[str, Sequence[str]]
_Box = tuple[ArrayLike, ArrayLike]
_Progress = Union[None, bool, Callable[[str, int, int], Optional[bool]]]

__version__: str

class Error(Exception):
    path: Optional[str]
    offset: Optional[int]
    def __init__(self, message: str, path: Optional[str] = ..., offset: Optional[int] = ...) -> None: ...

class NotFound(Error, FileNotFoundError): ...
class NoSuchAttribute(NotFound, KeyError): ...
class InvalidArgument(Error, ValueError): ...
class Damaged(Error): ...
class NotSupported(Error, NotImplementedError): ...
class InputOutputError(Error, OSError): ...
class NoSpace(InputOutputError): ...
class OutOfMemory(Error, MemoryError): ...
class TooLarge(Error, MemoryError): ...
class Busy(Error, BlockingIOError): ...
class BadState(Error, RuntimeError): ...
class Cancelled(Error): ...
class InternalError(Error): ...

class Base(NamedTuple):
    vertices: NDArray[np.float64]
    triangles: NDArray[np.uint32]

class Block(NamedTuple):
    first: int
    records: NDArray[Any]

class Conversion(NamedTuple):
    path: str
    from_stored_bytes: int
    stored_bytes: int
    digest: str

class Counts(NamedTuple):
    vertices: int
    edges: int
    faces: int

class DamagedBlock(NamedTuple):
    attribute: str
    level: int
    block: int
    reason: str
    file_offset: int
    first_edge: int
    edge_after: int

class Hits(NamedTuple):
    faces: NDArray[np.uint32]
    distances: NDArray[np.float64]

class Info(NamedTuple):
    path: str
    backend: str
    pipeline: str
    layout: str
    scheme: str
    program: str
    uuid: str
    sequence: int
    block_bytes: int
    budget_bytes: int
    stored_bytes: int
    base_level: int
    finest_level: int
    writable: bool

class Mesh(NamedTuple):
    vertices: NDArray[Any]
    triangles: NDArray[np.uint32]
    faces: NDArray[np.uint32]
    attributes: dict[str, NDArray[Any]]

class Patches(NamedTuple):
    faces: NDArray[np.uint32]
    records: NDArray[Any]

class Statistics(NamedTuple):
    blocks_read: int
    bytes_read: int
    blocks_written: int
    bytes_written: int
    blocks_prefetched: int
    blocks_evicted: int
    read_waits: int
    read_wait_ns: int
    write_waits: int
    write_wait_ns: int
    peak_frame_bytes: int

class Subdivision(NamedTuple):
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

class VerifyReport(NamedTuple):
    blocks: int
    bytes: int
    never_written: int
    damaged_count: int
    damaged: list[DamagedBlock]

class LevelArray:
    level: int
    dtype: np.dtype
    shape: tuple[int, ...]
    ndim: int
    size: int
    nbytes: int
    @property
    def name(self) -> str: ...
    @property
    def chunks(self) -> tuple[tuple[int, ...], ...]: ...
    def blocks(self) -> Iterator[Block]: ...
    def __len__(self) -> int: ...
    def __getitem__(self, key: Any) -> NDArray[Any]: ...
    def __iter__(self) -> Iterator[NDArray[Any]]: ...
    def __array__(self, dtype: Optional[DTypeLike] = ..., copy: Optional[bool] = ...) -> NDArray[Any]: ...
    @property
    def __array_interface__(self) -> dict[str, Any]: ...

class Attribute:
    name: str
    dtype: np.dtype
    components: int
    levels: range
    def __getitem__(self, level: int) -> LevelArray: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[LevelArray]: ...

class Vertices:
    levels: NDArray[np.int32]
    places: NDArray[np.uint64]
    valence: int
    border: bool
    base: bool
    def __len__(self) -> int: ...
    def __getitem__(self, name: str) -> NDArray[Any]: ...
    def __setitem__(self, name: str, records: ArrayLike) -> None: ...
    def neighbours(self, name: str) -> NDArray[Any]: ...

class PatchWriter:
    def write_patch(self, name: str, face: int, level: int, records: ArrayLike) -> None: ...
    def write_level(self, name: str, face: int, level: int, records: ArrayLike) -> None: ...
    def finish(self) -> None: ...
    def __enter__(self) -> PatchWriter: ...
    def __exit__(self, kind: Any, *_: object) -> None: ...

class Distances(NamedTuple):
    samples: int
    max: float
    rms: float
    mean: float
    percentile_99: float
    percentile_99_9: float
    mean_angle: float
    percentile_99_angle: float

class Comparison(NamedTuple):
    diagonal: float
    mean_edge: float
    there: Distances
    back: Distances

class Import(NamedTuple):
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

class Store:
    @property
    def info(self) -> Info: ...
    @property
    def path(self) -> str: ...
    @property
    def levels(self) -> range: ...
    @property
    def attributes(self) -> dict[str, Attribute]: ...
    @property
    def base(self) -> Base: ...
    @property
    def statistics(self) -> Statistics: ...
    def counts(self, level: int) -> Counts: ...
    def __getitem__(self, name: str) -> Attribute: ...
    def __contains__(self, name: str) -> bool: ...
    def patch(self, face: int, level: Optional[int] = ..., attribute: str = ...) -> NDArray[Any]: ...
    def patches(self, faces: Optional[ArrayLike] = ..., *, box: Optional[_Box] = ..., level: Optional[int] = ..., attribute: str = ..., memory: _Size = ...) -> Patches: ...
    def faces_in_box(self, low: ArrayLike, high: ArrayLike, attribute: str = ...) -> NDArray[np.uint32]: ...
    def along_ray(self, origin: ArrayLike, direction: ArrayLike, attribute: str = ...) -> Hits: ...
    def mesh(self, level: Optional[int] = ..., box: Optional[_Box] = ..., faces: Optional[ArrayLike] = ..., attributes: _Names = ..., memory: _Size = ...) -> Mesh: ...
    def visit(self, function: Callable[[Vertices], Any], reads: _Names = ..., writes: _Names = ..., rings: Union[bool, _Names] = ..., level: Optional[int] = ..., progress: _Progress = ...) -> None: ...
    def patch_writer(self, attributes: _Names = ..., first_level: Optional[int] = ..., last_level: Optional[int] = ..., compare: bool = ...) -> PatchWriter: ...
    def add_attribute(self, name: str, dtype: DTypeLike = ..., components: int = ..., level: Optional[int] = ...) -> None: ...
    def remove_attribute(self, name: str) -> None: ...
    def replace_attribute(self, name: str, replacement: str) -> None: ...
    def subdivide(self, levels: int, scheme: str = ..., normals: bool = ..., limit: bool = ..., executor: str = ..., threads: int = ..., progress: _Progress = ...) -> None: ...
    def commit(self) -> None: ...
    def roll_back(self) -> None: ...
    def write_bounds(self, attribute: str = ..., progress: _Progress = ...) -> None: ...
    def verify(self, progress: _Progress = ...) -> VerifyReport: ...
    def digest(self, level: Optional[int] = ..., threads: int = ..., progress: _Progress = ...) -> str: ...
    def close(self) -> None: ...
    def __enter__(self) -> Store: ...
    def __exit__(self, *_: object) -> None: ...

def open(path: _Path, writable: bool = ..., memory: _Size = ..., io_threads: Optional[int] = ...) -> Store: ...
def create(vertices: ArrayLike, faces: ArrayLike, path: Optional[_Path] = ..., backend: Optional[str] = ..., dtype: DTypeLike = ..., layout: Optional[str] = ..., pipeline: Optional[str] = ..., block_bytes: _Size = ..., memory: _Size = ..., base_level: int = ..., warn: Optional[Callable[[str], Any]] = ...) -> Store: ...
def triangles(level: int, base_level: int = ...) -> NDArray[np.uint32]: ...
def subdivide(input: _Path, output: Optional[_Path], levels: int, *, scheme: Optional[str] = ..., precision: Optional[Literal["float32", "float64"]] = ..., normals: bool = ..., limit: bool = ..., backend: Optional[str] = ..., compress: _Names = ..., max_error: _Names = ..., layout: Optional[str] = ..., block: Optional[_Size] = ..., max_slot: Optional[_Size] = ..., durability: Literal["commit", "none"] = ..., memory: Optional[_Size] = ..., threads: int = ..., executor: str = ..., verify: bool = ..., digest: bool = ..., ignore_size: bool = ..., force: bool = ..., resume: bool = ..., progress: _Progress = ..., warn: Optional[Callable[[str], Any]] = ...) -> Subdivision: ...
def import_mesh(input: _Path, output: _Path, levels: Optional[int] = ..., *, precision: Optional[Literal["float32", "float64"]] = ..., backend: Optional[str] = ..., compress: _Names = ..., layout: Optional[str] = ..., block: Optional[_Size] = ..., max_slot: Optional[_Size] = ..., memory: Optional[_Size] = ..., threads: int = ..., durability: Literal["commit", "none"] = ..., force: bool = ..., ignore_size: bool = ..., progress: _Progress = ..., warn: Optional[Callable[[str], Any]] = ...) -> Import: ...
def remesh(input: _Path, output: _Path, faces: int, levels: int = ..., *, min_component: int = ..., fill_holes: int = ..., no_foldover: bool = ..., distances: bool = ..., samples: int = ..., backend: Optional[str] = ..., memory: Optional[_Size] = ..., threads: int = ..., digest: bool = ..., force: bool = ..., ignore_size: bool = ..., progress: _Progress = ..., warn: Optional[Callable[[str], Any]] = ...) -> Remeshing: ...
def compare(a: _Path, b: _Path, level: Optional[int] = ..., *, samples: int = ..., threads: int = ..., progress: _Progress = ..., warn: Optional[Callable[[str], Any]] = ...) -> Comparison: ...
def convert(input: _Path, output: _Path, *, backend: Optional[str] = ..., compress: _Names = ..., max_error: _Names = ..., block: Optional[_Size] = ..., memory: Optional[_Size] = ..., threads: int = ..., verify: bool = ..., force: bool = ..., progress: _Progress = ..., warn: Optional[Callable[[str], Any]] = ...) -> Conversion: ...
def plan(input: _Path, plan: _Path, levels: Optional[int] = ..., *, parts: Optional[int] = ..., scheme: Optional[str] = ..., precision: Optional[Literal["float32", "float64"]] = ..., normals: bool = ..., limit: bool = ..., layout: Optional[str] = ..., compress: _Names = ..., block: Optional[_Size] = ..., max_slot: Optional[_Size] = ..., calibrate: bool = ..., pass_: Optional[str] = ..., factor: float = ..., amplitude: float = ..., seed: int = ..., diagonal: Optional[float] = ..., fuse_iterations: int = ..., result: Optional[str] = ..., parameters: Optional[str] = ..., memory: Optional[_Size] = ..., threads: int = ..., sbatch: Optional[_Path] = ..., array: int = ..., progress: _Progress = ..., warn: Optional[Callable[[str], Any]] = ...) -> dict[str, Any]: ...
def part(plan: _Path, part: int, *, offset: int = ..., again: bool = ..., memory: Optional[_Size] = ..., threads: int = ..., progress: _Progress = ..., warn: Optional[Callable[[str], Any]] = ...) -> dict[str, Any]: ...
def join(plan: _Path, output: _Path, *, verify: bool = ..., concat: bool = ..., force: bool = ..., memory: Optional[_Size] = ..., progress: _Progress = ..., warn: Optional[Callable[[str], Any]] = ...) -> dict[str, Any]: ...
def verify(store: _Path, memory: _Size = ..., progress: _Progress = ...) -> VerifyReport: ...
def build_info() -> dict[str, list[str]]: ...
def load_plugin(file: _Path) -> None: ...
