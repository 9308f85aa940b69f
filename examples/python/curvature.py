#!/usr/bin/env python3
"""Computes the mean curvature at every vertex of a store, and keeps it as an attribute.

    curvature.py STORE [MEMORY [MOST]]

The store may be much larger than MEMORY (default 64MiB): the visit has a window of blocks and one
batch of vertices in memory. Larger curvatures than MOST become MOST: a few vertices at thin triangles
would have most of the colours of a picture. The curvature normal is the cotangent Laplacian over twice the area around
the vertex (M. Meyer, M. Desbrun, P. Schroeder, A. Barr, "Discrete differential-geometry operators for
triangulated 2-manifolds", 2003). On a sphere of radius r the mean curvature is 1/r everywhere.
"""

import sys

import numpy as np
import plait


def mean_curvature(vertices):
    """The mean curvature of many vertices with equally many neighbours."""
    center = vertices["position"][:, None].astype(np.float64)
    ring = vertices.neighbours("position") - center  # from the vertex to its neighbours
    if vertices.border:
        return np.zeros(len(vertices))
    after, before = np.roll(ring, -1, axis=1), np.roll(ring, 1, axis=1)

    def cotangent(a, b):
        return (a * b).sum(-1) / np.linalg.norm(np.cross(a, b), axis=-1)

    # The angles opposite the edge to each neighbour, in the two triangles at the edge.
    weight = cotangent(-before, ring - before) + cotangent(-after, ring - after)
    area = (weight * (ring * ring).sum(-1)).sum(axis=1) / 8  # nearer to this vertex than to others
    normal = -(weight[..., None] * ring).sum(axis=1) / (4 * area[:, None])
    return np.linalg.norm(normal, axis=1)


def main(path, memory="64MiB", most=np.inf):
    most = float(most)
    with plait.open(path, writable=True, memory=memory) as store:
        if "curvature" in store:
            store.remove_attribute("curvature")
        store.add_attribute("curvature", np.float32)
        store.visit(lambda vertices: np.minimum(mean_curvature(vertices), most), reads=["position"],
                    writes=["curvature"], rings=True, progress=True)
        store.commit()
        finest = store["curvature"][store.levels[-1]]
        low, high, total = np.inf, -np.inf, 0.0
        for block in finest.blocks():
            low, high = min(low, block.records.min()), max(high, block.records.max())
            total += block.records.sum(dtype=np.float64)
        print(f"mean curvature of the finest level: {low:.4f} to {high:.4f}, "
              f"on average {total / len(finest):.4f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
