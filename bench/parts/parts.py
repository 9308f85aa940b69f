#!/usr/bin/env python3
"""What parts of a plan cost, with one thread each, on a torus.

    bench/parts/parts.py PLAIT [--vertices N] [--levels L] [--parts P] [--rounds R] [--directory DIR]

Each part timed alone against one process for all, and two processes against one. Each round makes, one after
another, a plan of one part, a plan of P parts by one process at a time, and the same by two at a time. `expected` is
the part's share of the seconds of one process, by the faces that it refines (its ghosts too).

Prints medians over the rounds.
"""
import argparse
import json
import os
import shutil
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from statistics import median


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("plait")
    parser.add_argument("--vertices", type=int, default=100000, help="of the base mesh")
    parser.add_argument("--levels", type=int, default=5)
    parser.add_argument("--parts", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--directory", help="where the stores go; default: the temporary one")
    wanted = parser.parse_args()
    wanted.plait = os.path.abspath(wanted.plait)
    with tempfile.TemporaryDirectory(dir=wanted.directory) as here:
        os.chdir(here)
        run(wanted, "generate", "torus", "mesh.ply", "--vertices", wanted.vertices)
        measure(wanted)


def run(wanted, *words):
    command = (wanted.plait, *map(str, words))
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def make_part(wanted, plan, part):
    run(wanted, "part", plan, part, "--threads", 1)


def make_by_two(wanted, plan):
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda part: make_part(wanted, plan, part), range(wanted.parts)))


def seconds_of(work, *arguments):
    start = time.perf_counter()
    work(*arguments)
    return time.perf_counter() - start


def measure(wanted):
    def plan(parts):
        shutil.rmtree("plan", ignore_errors=True)
        return json.loads(run(wanted, "plan", "mesh.ply", "plan", "--levels", wanted.levels, "--normals",
                              "--parts", parts, "--json"))["parts"]

    one, by_part, by_one, by_two = [], [[] for _ in range(wanted.parts)], [], []
    for turn in range(wanted.rounds):
        plan(1)
        one.append(seconds_of(make_part, wanted, "plan", 0))
        parts = plan(wanted.parts)
        for part, seconds in enumerate(by_part):
            seconds.append(seconds_of(make_part, wanted, "plan", part))
        by_one.append(sum(seconds[-1] for seconds in by_part))
        plan(wanted.parts)
        by_two.append(seconds_of(make_by_two, wanted, "plan"))
        print(f"round {turn}: load {os.getloadavg()[0]:.1f}", flush=True)

    own_faces = sum(part["faces"] - part["ghost_faces"] for part in parts)
    expected = [median(one) * part["faces"] / own_faces for part in parts]
    ratios = [median(seconds) / share for seconds, share in zip(by_part, expected)]
    over = (median(by_one) - sum(expected)) / (wanted.parts - 1)
    twice = [a / b for a, b in zip(by_one, by_two)]
    print(f"one process, one part: {median(one):.2f} s")
    print(f"{wanted.parts} parts, each alone: {median(by_one) / sum(expected):.3f} times expected; "
          f"the best {min(ratios):.3f}, the worst {max(ratios):.3f}; {1000 * over:.0f} ms a part more")
    print(f"two processes: {median(twice):.2f} times as fast as one ({min(twice):.2f} to {max(twice):.2f})")


if __name__ == "__main__":
    main()
