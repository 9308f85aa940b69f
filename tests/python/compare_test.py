"""Distances between surfaces that are far from each other, and threads without progress."""

import subprocess
import sys
import threading

import plait
import pytest
from conftest import icosahedron, make, sheet, write_ply


@pytest.fixture
def apart(tmp_path):
    """Two surfaces in other units and at another place."""
    vertices, faces = sheet(40)
    write_ply(tmp_path / "a.ply", (vertices * 1000 + 1e5, faces))
    with make(icosahedron(), levels=5, scheme="loop") as store:
        mesh = store.mesh()
    write_ply(tmp_path / "b.ply", (mesh.vertices, mesh.triangles))
    return tmp_path / "a.ply", tmp_path / "b.ply"


def test_surfaces_that_do_not_overlap_are_warned_of(apart, tmp_path):
    with pytest.warns(UserWarning, match="boxes of the two surfaces do not overlap: .*same units"):
        plait.compare(*apart, samples=100)
    told = []
    plait.compare(apart[1], apart[1], samples=100, warn=told.append)
    assert not told


def test_progress_moves(apart):
    told = []
    plait.compare(*apart, samples=100_000, warn=lambda _: None,
                  progress=lambda phase, done, total: told.append((phase, done)) and None)
    done = [now for phase, now in told if phase.startswith("distance")]
    assert len(done) >= 2 * 100_000 / 32768 and done == sorted(done)
    assert max(after - before for before, after in zip(done, done[1:])) <= 32768


INTERRUPTED = """
import os, signal, sys, plait

def tell(phase, done, total):
    if done > 0:
        os.kill(os.getpid(), signal.SIGINT)
        seen.append(done)

seen = []
try:
    plait.compare(sys.argv[1], sys.argv[2], samples=10**7, progress=tell, warn=lambda _: None)
except KeyboardInterrupt:
    print("interrupted", len(seen))
"""


def test_an_interrupt_ends_the_comparison_at_the_next_step(apart):
    done = subprocess.run([sys.executable, "-c", INTERRUPTED, *apart], capture_output=True, text=True,
                          check=True)
    assert done.stdout.split()[0] == "interrupted" and int(done.stdout.split()[1]) <= 2


def test_threads_without_progress_call_nothing_of_python(monkeypatch):
    """python/cpython#87135: a daemon thread in a callback is ended in the middle of the library."""
    from plait import _progress
    calls = []
    monkeypatch.setattr(_progress.Watch, "_tell", lambda *_: calls.append(threading.current_thread()))
    store = make(icosahedron(), levels=3)
    del calls[:]
    work = threading.Thread(target=lambda: (store.digest(), store.verify()))
    work.start()
    work.join()
    assert not calls
    store.digest()
    assert calls
