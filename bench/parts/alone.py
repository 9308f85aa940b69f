#!/usr/bin/env python3
"""What parts cost: each part timed alone against one process for all, and two processes against one.

    bench/parts/alone.py PLAIT [--vertices N] [--levels L] [--parts P] [--rounds R] [--directory DIR]

Each round makes, one after another, a plan of one part, a plan of P parts by one process at a time, and the
same by two at a time, all with one thread. Prints medians. `expected` is the part's share of the seconds of
one process, by the faces that it refines (its ghosts too).
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
    parser.add_argument("--vertices", type=int, default=100000, help="of the base mesh, a torus")
    parser.add_argument("--levels", type=int, default=5)
    parser.add_argument("--parts", type=int, default=16)
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


def run(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def measure(plait, wanted):
    run(plait, "generate", "torus", "mesh.ply", "--vertices", str(wanted.vertices))

    def plan(parts):
        shutil.rmtree("plan", ignore_errors=True)
        return json.loads(run(plait, "plan", "mesh.ply", "plan", "--levels", str(wanted.levels),
                              "--normals", "--parts", str(parts), "--json"))["parts"]

    def seconds_of(part):
        start = time.perf_counter()
        run(plait, "part", "plan", str(part), "--threads", "1")
        return time.perf_counter() - start

    one, alone, by_one, by_two = [], [[] for _ in range(wanted.parts)], [], []
    for turn in range(wanted.rounds):
        plan(1)
        one.append(seconds_of(0))
        parts = plan(wanted.parts)
        for part, seconds in enumerate(alone):
            seconds.append(seconds_of(part))
        by_one.append(sum(seconds[-1] for seconds in alone))
        plan(wanted.parts)
        start = time.perf_counter()
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(seconds_of, range(wanted.parts)))
        by_two.append(time.perf_counter() - start)
        print(f"round {turn}: load {os.getloadavg()[0]:.1f}", flush=True)

    whole = statistics.median(one)
    own_faces = sum(part["faces"] - part["ghost_faces"] for part in parts)
    expected = [whole * part["faces"] / own_faces for part in parts]
    ratios = [statistics.median(seconds) / share for seconds, share in zip(alone, expected)]
    over = (statistics.median(by_one) - sum(expected)) / (wanted.parts - 1)
    twice = [a / b for a, b in zip(by_one, by_two)]
    print(f"one process, one part: {whole:.2f} s")
    print(f"{wanted.parts} parts, each alone: {statistics.median(by_one) / sum(expected):.3f} times expected; "
          f"the best {min(ratios):.3f}, the worst {max(ratios):.3f}; {1000 * over:.0f} ms a part more")
    print(f"two processes: {statistics.median(twice):.2f} times as fast as one "
          f"({min(twice):.2f} to {max(twice):.2f})")


if __name__ == "__main__":
    main()
