#!/usr/bin/env python3
"""Finds center, axes and box of all vertices of a store by dask, block by block.

    dask_blocks.py STORE

Every chunk is a block of the store. The threads of dask read blocks at the same time, and no level is
ever whole in memory. Needs python3-dask.
"""

import sys

import dask
import dask.array
import numpy as np
import plait


def main(path):
    with plait.open(path, memory="64MiB") as store:
        levels = [dask.array.from_array(level, chunks=level.chunks)
                  for level in store["position"]]
        points = dask.array.concatenate(levels).astype(np.float64)
        low, high, center, squares = dask.compute(
            points.min(axis=0), points.max(axis=0), points.mean(axis=0), points.T @ points)
    spread = squares / len(points) - np.outer(center, center)
    lengths, axes = np.linalg.eigh(spread)
    print(f"{len(points)} vertices in {points.npartitions} blocks")
    print(f"box {low} to {high}")
    print(f"center {center}")
    print(f"longest axis {axes[:, -1]}, standard deviation {lengths[-1] ** 0.5:.6g}")


if __name__ == "__main__":
    main(*sys.argv[1:])
