#!/usr/bin/env python3
"""Draws the part of a surface that is in a box.

    plot_box.py STORE OUT.png LOW HIGH [LEVEL]      such as 0,0,0 1,1,1 4

Only the patches in the box are read. Needs python3-matplotlib.
"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as pyplot
import plait


def main(path, picture, low, high, level=None):
    box = [[float(number) for number in corner.split(",")] for corner in (low, high)]
    with plait.open(path) as store:
        mesh = store.mesh(None if level is None else int(level), box=box)
    print(f"{len(mesh.faces)} patches, {len(mesh.vertices)} vertices, "
          f"{len(mesh.triangles)} triangles")
    axes = pyplot.figure(figsize=(6, 6)).add_subplot(projection="3d")
    if len(mesh.triangles):
        axes.plot_trisurf(*mesh.vertices.T, triangles=mesh.triangles, color="0.8", shade=True)
    axes.set_aspect("equal")
    pyplot.savefig(picture, dpi=100)


if __name__ == "__main__":
    main(*sys.argv[1:])
