#!/usr/bin/env python3
"""Smooths a surface and writes it back.

    smooth.py STORE [PASSES]

Each pass moves every vertex half of the way to the mean of its neighbours, and then out again, so
that the surface does not shrink (G. Taubin, "A signal processing approach to fair surface design",
1995). The store is committed once, at the end: until then readers see the old surface, and Ctrl-C
leaves it as it was.
"""

import sys

import numpy as np
import plait


def towards_the_mean(part):
    """A function that moves vertices by a part of the way to the mean of their neighbours."""

    def move(vertices):
        position = vertices["position"].astype(np.float64)
        if vertices.border:
            return position
        return position + part * (vertices.neighbours("position").mean(axis=1) - position)

    return move


def main(path, passes=1):
    with plait.open(path, writable=True) as store:
        for _ in range(int(passes)):
            for part in (0.5, -0.53):
                store.add_attribute("moved", store["position"].dtype, 3)
                store.visit(towards_the_mean(part), reads=["position"], writes=["moved"],
                            rings=True, progress=True)
                store.replace_attribute("position", "moved")
        finest = store["position"][store.levels[-1]]
        total, most = 0.0, 0.0
        with plait.open(path) as before:  # the last commit, until the next one
            for block, old in zip(finest.blocks(), before["position"][store.levels[-1]].blocks()):
                moved = np.linalg.norm(block.records - old.records, axis=1)
                total, most = total + moved.sum(dtype=np.float64), max(most, moved.max())
        print(f"vertices of the finest level moved by {total / len(finest):.3g} on average, "
              f"{most:.3g} at most")
        del finest, block
        store.commit()


if __name__ == "__main__":
    main(*sys.argv[1:])
