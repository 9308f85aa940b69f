"""Meshes and stores that the tests share."""

import numpy as np
import plait
import pytest

TETRAHEDRON = (np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float),
               np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))


def icosahedron():
    """Vertices of valence 5."""
    g = (1 + 5 ** 0.5) / 2
    v = np.array([[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g],
                  [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]])
    f = np.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
                  [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
                  [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]])
    return v, f


def sheet(size=3):
    """A square of size x size unit cells in the plane z = 0, with a border."""
    x, y = np.meshgrid(np.arange(size + 1.0), np.arange(size + 1.0))
    v = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)
    f = []
    for j in range(size):
        for i in range(size):
            a, b = j * (size + 1) + i, (j + 1) * (size + 1) + i
            f += [[a, a + 1, b + 1], [a, b + 1, b]]
    return v, np.array(f)


def write_ply(path, mesh):
    """The mesh as a file, in text."""
    vertices, faces = mesh
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty float x\n"
                   "property float y\nproperty float z\n"
                   f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in np.asarray(vertices).tolist())
        file.writelines(f"3 {a} {b} {c}\n" for a, b, c in faces.tolist())
    return path


def make(mesh, path=None, levels=3, scheme="midpoint", normals=False, **options):
    """A store that is refined and, with a path, committed."""
    store = plait.create(*mesh, path, **options)
    store.subdivide(levels, scheme=scheme, normals=normals)
    if path is not None:
        store.commit()
    return store


@pytest.fixture(params=["memory", "pread", "mmap", "compressed"])
def surface(request, tmp_path):
    """The icosahedron at level 3 with normals, on several backends, opened for reading."""
    if request.param == "memory":
        yield make(icosahedron(), levels=3, scheme="loop", normals=True, block_bytes=4096)
        return
    path = tmp_path / "surface.plait"
    make(icosahedron(), path, levels=3, scheme="loop", normals=True, backend=request.param,
         block_bytes=4096).close()
    with plait.open(path) as store:
        yield store


def grid(size):
    """The points (i, j) of a patch in row order."""
    return np.array([(i, j) for j in range(size + 1) for i in range(size + 1 - j)])


def flat_patch(store, face, size):
    """Where midpoints put the vertices of a patch: on its flat base face."""
    a, b, c = store.base.vertices[store.base.triangles[face]]
    i, j = grid(size).T[:, :, None] / size
    return a + (b - a) * i + (c - a) * j
