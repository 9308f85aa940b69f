#!/usr/bin/env python3
"""Iterations of smoothing over a store in shards: one plan for each, against one plan for all.

    bench/parts/fused.py PLAIT [--vertices N] [--levels L] [--parts P] [--iterations K] [--rounds R] [--directory DIR]

Each round makes two stores of one torus in P shards. In the first one it plans, makes and joins K passes one
after another, in the second one a plan with K iterations; the parts are made by two processes at a time, with
one thread each. Checks that both stores have one digest. Prints medians, and as a floor the time of writing the
bytes of all positions to one file and syncing it, as often as each of the two commits them.
"""
import argparse
import json
import os
import shutil
import statistics
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("plait")
    parser.add_argument("--vertices", type=int, default=20000, help="of the base mesh, a torus")
    parser.add_argument("--levels", type=int, default=5)
    parser.add_argument("--parts", type=int, default=4)
    parser.add_argument("--iterations", type=int, default=5)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--directory", help="where the stores go; default: the temporary one")
    wanted = parser.parse_args()
    plait = os.path.abspath(wanted.plait)
    here = tempfile.mkdtemp(dir=wanted.directory)
    try:
        os.chdir(here)
        measure(plait, wanted)
    finally:
        shutil.rmtree(here)


def measure(plait, wanted):
    def run(*command):
        return subprocess.run((plait, *command), check=True, stdout=subprocess.PIPE, text=True).stdout

    def finish(plan, store):
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(lambda part: run("part", plan, str(part), "--threads", "1"), range(wanted.parts)))
        run("join", plan, store)
        shutil.rmtree(plan)

    def timed(store, plans, iterations):
        for name in ("shards", store):
            shutil.rmtree(name, ignore_errors=True)
        run("plan", "mesh.ply", "shards", "--levels", str(wanted.levels), "--parts", str(wanted.parts))
        finish("shards", store)
        os.sync()
        start = time.perf_counter()
        for _ in range(plans):
            planned = json.loads(run("plan", "--pass", "smooth", "--fuse-iterations", str(iterations), store, "pass",
                                     "--json"))
            finish("pass", store)
        return time.perf_counter() - start, planned

    def write(size):
        block = os.urandom(1 << 20)
        start = time.perf_counter()
        with open("floor", "wb") as file:
            for _ in range(size >> 20):
                file.write(block)
            os.fsync(file.fileno())
        return time.perf_counter() - start

    run("generate", "torus", "mesh.ply", "--vertices", str(wanted.vertices))
    apart, together, floors = [], [], []
    for turn in range(wanted.rounds):
        seconds, planned = timed("apart.plait", wanted.iterations, 1)
        apart.append(seconds)
        seconds, planned = timed("together.plait", 1, wanted.iterations)
        together.append(seconds)
        digests = {run("digest", store).split()[-1] for store in ("apart.plait", "together.plait")}
        assert len(digests) == 1, digests
        floors.append(write(planned["bytes"]))
        print(f"round {turn}: {apart[-1]:.2f} s, {together[-1]:.2f} s, floor {floors[-1]:.2f} s, "
              f"load {os.getloadavg()[0]:.1f}", flush=True)
    faces = sum(part["faces"] for part in planned["parts"])
    a, b, floor = statistics.median(apart), statistics.median(together), statistics.median(floors)
    ghosts = 100 * planned["ghost_faces"] / faces
    print(f"{planned['bytes'] / 1e6:.0f} MB in {wanted.parts} parts; one plan has {ghosts:.1f} % ghosts")
    print(f"{wanted.iterations} plans {a:.2f} s ({min(apart):.2f} to {max(apart):.2f}), "
          f"floor {wanted.iterations * floor:.2f} s")
    print(f"one plan {b:.2f} s ({min(together):.2f} to {max(together):.2f}), floor {floor:.2f} s")


if __name__ == "__main__":
    main()
