"""Makes the parts of a plan in workers of Dask, and joins them.

    dask_parts.py PLAN STORE [SCHEDULER]      without an address: workers on this machine

The workers run the program plait, so they need no library. If a worker dies, Dask gives its part to
another one. The same command again makes only what is missing.
"""
import json
import subprocess
import sys

from dask.distributed import Client


def missing_parts(plan, store):
    """Joins the parts if all are done. Returns those that are missing or damaged."""
    join = subprocess.run(["plait", "join", plan, store, "--json"], capture_output=True, text=True)
    if join.returncode not in (0, 4):
        raise SystemExit(join.stderr)
    report = json.loads(join.stdout)
    return sorted(report.get("missing", []) + report.get("bad", []))


def make(plan, part):
    subprocess.run(["plait", "part", plan, str(part), "--threads", "1"], check=True)


def main(plan, store, scheduler=None):
    parts = missing_parts(plan, store)
    if parts:
        with Client(scheduler) as client:
            client.gather([client.submit(make, plan, part, pure=False, retries=2) for part in parts])
        parts = missing_parts(plan, store)
    if parts:
        raise SystemExit(f"parts are missing: {parts}")


if __name__ == "__main__":
    main(*sys.argv[1:])
