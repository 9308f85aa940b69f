"""A pickle, a copy or a token of a level means one version of one store, wherever it is opened."""

import copy
import pickle
import shutil
import subprocess
import sys

import numpy as np
import plait
import pytest
from conftest import TETRAHEDRON, icosahedron, make


@pytest.fixture
def path(tmp_path):
    make(icosahedron(), tmp_path / "s.plait", levels=2, scheme="loop").close()
    return tmp_path / "s.plait"


def moved(path):
    """A later version."""
    with plait.open(path, writable=True) as writer:
        writer.visit(lambda v: v["position"] + 1, reads="position", writes="position")
        writer.commit()


def test_a_level_is_the_same_in_another_folder(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    level = plait.open("s.plait")["position"][2]
    whole, sent = np.array(level), pickle.dumps([level, plait.open("s.plait")["position"]])
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    again, attribute = pickle.loads(sent)
    np.testing.assert_array_equal(again, whole)
    np.testing.assert_array_equal(attribute[-1], whole)
    np.testing.assert_array_equal(copy.deepcopy(level), whole)
    code = "import pickle, sys; print(float(pickle.load(sys.stdin.buffer)[0][:].sum()))"
    done = subprocess.run([sys.executable, "-c", code], input=sent, capture_output=True, check=True,
                          cwd=tmp_path / "elsewhere")
    assert float(done.stdout) == float(whole.sum())


def test_a_pickle_of_another_version_is_refused(path):
    store = plait.open(path)
    level, attribute = store["position"][2], store["position"]
    sent = [pickle.dumps(each) for each in (level, attribute, store)]
    moved(path)
    for each in sent:
        with pytest.raises(plait.BadState, match="expected version 2 of the store .*found version 3"):
            pickle.loads(each)
    # Who has the version open still has it, and says so.
    assert pickle.loads(pickle.dumps(plait.open(path)["position"][2])).shape == level.shape
    with pytest.raises(plait.BadState, match="found version 3"):
        pickle.loads(pickle.dumps(level))


def test_another_store_of_the_same_name_is_refused(path):
    """pydata/xarray#4240, #4862: a path that was overwritten gave the old content, or the new one, as
    it came."""
    store = plait.open(path)
    level, whole = store["position"][2], np.array(store["position"][2])
    sent = pickle.dumps(level)
    shutil.rmtree(path)
    with pytest.raises(FileNotFoundError):
        pickle.loads(sent)
    make(TETRAHEDRON, path, levels=2).close()
    with pytest.raises(plait.BadState, match="another store"):
        pickle.loads(sent)
    np.testing.assert_array_equal(copy.deepcopy(level), whole)
    np.testing.assert_array_equal(copy.copy(level), whole)


def test_stores_of_one_name_in_two_folders_are_two(tmp_path, monkeypatch):
    """DaanVanVugt/h5pickle#7: a cache by name gave the first file for every other one."""
    sent = []
    for folder, mesh in (("a", icosahedron()), ("b", TETRAHEDRON)):
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        make(mesh, "s.plait", levels=1).close()
        sent.append(pickle.dumps(plait.open("s.plait")["position"][1]))
    levels = [pickle.loads(each) for each in sent]
    assert [len(level) for level in levels] == [30, 6]


def test_levels_of_one_process_share_one_store(path):
    store = plait.open(path)
    first, second = (pickle.loads(pickle.dumps(store["position"][level])) for level in (1, 2))
    assert first._store is second._store is not store
    assert first._store.info.budget_bytes == store.info.budget_bytes


def test_changes_that_nobody_else_sees_are_not_pickled(path):
    with plait.open(path, writable=True) as writer:
        level = writer["position"][2]
        pickle.loads(pickle.dumps(level))
        writer.add_attribute("x")
        for each in (level, writer["position"]):
            with pytest.raises(plait.BadState, match="commit"):
                pickle.dumps(each)
        writer.commit()
        assert "x" in pickle.loads(pickle.dumps(level))._store


def test_stores_are_pickled_or_say_why_not(path):
    store = plait.open(path, memory="8MiB")
    again = pickle.loads(pickle.dumps(store))
    assert again.info == store.info and again.digest() == store.digest()
    with plait.open(path, writable=True) as writer:
        with pytest.raises(TypeError, match="open for writing"):
            pickle.dumps(writer)
    memory = make(icosahedron(), levels=1)
    for each in (memory, memory["position"], memory["position"][1]):
        with pytest.raises(TypeError, match="in memory cannot be pickled"):
            pickle.dumps(each)
    np.testing.assert_array_equal(copy.deepcopy(memory["position"][1]), memory["position"][1])


def test_tokens_are_those_of_a_version(path):
    """dask/dask#849: equal descriptions gave two arrays one token; dask/dask#10808: a token must
    be the same after a pickle."""
    tokenize = pytest.importorskip("dask.base").tokenize
    store = plait.open(path)
    level = store["position"][2]
    token = tokenize(level)
    assert token == tokenize(plait.open(path)["position"][2]) == tokenize(copy.deepcopy(level))
    assert token == tokenize(pickle.loads(pickle.dumps(level)))
    assert token != tokenize(store["position"][1])
    other = path.parent / "other.plait"
    make((icosahedron()[0] * 2, icosahedron()[1]), other, levels=2, scheme="loop").close()
    assert repr(plait.open(other)["position"][2]) == repr(level)
    assert token != tokenize(plait.open(other)["position"][2])
    moved(path)
    assert token != tokenize(plait.open(path)["position"][2])
    assert token == tokenize(level)
    with plait.open(path, writable=True) as writer:
        mine = writer["position"][2]
        before = tokenize(mine)
        writer.visit(lambda v: v["position"] + 1, reads="position", writes="position")
        after = tokenize(mine)
        writer.visit(lambda v: v["position"] + 1, reads="position", writes="position")
        assert len({before, after, tokenize(mine)}) == 3
        writer.roll_back()
        assert tokenize(mine) == before
    first, second = (make(icosahedron(), levels=1)["position"][1] for _ in range(2))
    assert tokenize(first) == tokenize(first) != tokenize(second)


def test_refresh_takes_the_new_version(path):
    store = plait.open(path)
    level, kept = store["position"][2], store["position"][2][:7]
    old = np.array(level)
    assert store.refresh() is False
    moved(path)
    np.testing.assert_array_equal(level, old)
    assert store.refresh() is True and store.info.sequence == 3
    np.testing.assert_array_equal(level, old + np.float32(1))
    np.testing.assert_array_equal(kept, old[:7])
    shutil.rmtree(path)
    with pytest.raises(plait.NotFound):
        store.refresh()
    make(TETRAHEDRON, path, levels=2).close()
    assert store.refresh() is True and len(store.base.triangles) == 4 and len(level) == 24
    assert make(icosahedron(), levels=1).refresh() is False
