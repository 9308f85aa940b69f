#!/usr/bin/env python3
"""What parts of a plan cost, with one thread each, on a torus.

    bench/parts/parts.py alone PLAIT [--vertices N] [--levels L] [--parts P] [--rounds R] [--directory DIR]
    bench/parts/parts.py fused PLAIT [the same] [--iterations K]

alone: each part timed alone against one process for all, and two processes against one. Each round makes, one after
another, a plan of one part, a plan of P parts by one process at a time, and the same by two at a time. `expected` is
the part's share of the seconds of one process, by the faces that it refines (its ghosts too).

fused: iterations of smoothing over a store in shards: one plan for each, against one plan for all. Each round makes
two stores in P shards. In the first one it plans, makes and joins K passes one after another, in the second one a plan
with K iterations; two processes make the parts. Checks that both stores have one digest. The floor is the time of
writing the bytes of all positions to one file and syncing it, as often as each of the two commits them.

Both print medians over the rounds.
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
    commands = parser.add_subparsers(dest="command", required=True)
    for measure, vertices, parts in ((alone, 100000, 16), (fused, 20000, 4)):
        command = commands.add_parser(measure.__name__)
        command.set_defaults(measure=measure)
        command.add_argument("plait")
        command.add_argument("--vertices", type=int, default=vertices, help="of the base mesh")
        command.add_argument("--levels", type=int, default=5)
        command.add_argument("--parts", type=int, default=parts)
        command.add_argument("--rounds", type=int, default=5)
        command.add_argument("--directory", help="where the stores go; default: the temporary one")
        if measure is fused:
            command.add_argument("--iterations", type=int, default=5)
    wanted = parser.parse_args()
    wanted.plait = os.path.abspath(wanted.plait)
    with tempfile.TemporaryDirectory(dir=wanted.directory) as here:
        os.chdir(here)
        run(wanted, "generate", "torus", "mesh.ply", "--vertices", wanted.vertices)
        wanted.measure(wanted)


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


def alone(wanted):
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


def fused(wanted):
    def finish(plan, store):
        make_by_two(wanted, plan)
        run(wanted, "join", plan, store)
        shutil.rmtree(plan)

    def smooth(store, plans, iterations):
        for _ in range(plans):
            planned.update(json.loads(run(wanted, "plan", "--pass", "smooth", "--fuse-iterations", iterations, store,
                                          "pass", "--json")))
            finish("pass", store)

    def timed(store, plans, iterations):
        for name in ("shards", store):
            shutil.rmtree(name, ignore_errors=True)
        run(wanted, "plan", "mesh.ply", "shards", "--levels", wanted.levels, "--parts", wanted.parts)
        finish("shards", store)
        os.sync()
        return seconds_of(smooth, store, plans, iterations)

    def write(size, block):
        with open("floor", "wb") as file:
            for _ in range(size >> 20):
                file.write(block)
            os.fsync(file.fileno())

    planned, apart, together, floors = {}, [], [], []
    for turn in range(wanted.rounds):
        apart.append(timed("apart.plait", wanted.iterations, 1))
        together.append(timed("together.plait", 1, wanted.iterations))
        digests = {run(wanted, "digest", store).split()[-1] for store in ("apart.plait", "together.plait")}
        assert len(digests) == 1, digests
        floors.append(seconds_of(write, planned["bytes"], os.urandom(1 << 20)))
        print(f"round {turn}: {apart[-1]:.2f} s, {together[-1]:.2f} s, floor {floors[-1]:.2f} s, "
              f"load {os.getloadavg()[0]:.1f}", flush=True)
    ghosts = 100 * planned["ghost_faces"] / sum(part["faces"] for part in planned["parts"])
    floor = median(floors)
    print(f"{planned['bytes'] / 1e6:.0f} MB in {wanted.parts} parts; one plan has {ghosts:.1f} % ghosts")
    for name, seconds, commits in ((f"{wanted.iterations} plans", apart, wanted.iterations),
                                   ("one plan", together, 1)):
        print(f"{name} {median(seconds):.2f} s ({min(seconds):.2f} to {max(seconds):.2f}), "
              f"floor {commits * floor:.2f} s")


if __name__ == "__main__":
    main()
