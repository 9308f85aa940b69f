"""Errors are also those of Python, with its fields and in its words."""

import errno
import os
import pickle
import re
import warnings

import numpy as np
import plait
import pytest
from conftest import TETRAHEDRON, icosahedron, make, write_ply
from plait import errors


def test_files_that_are_there_or_not(tmp_path):
    path = tmp_path / "s.plait"
    make(TETRAHEDRON, path, levels=1).close()
    write_ply(tmp_path / "m.ply", TETRAHEDRON)
    source = tmp_path / "source.plait"
    make(TETRAHEDRON, source, levels=1).close()
    for call in (lambda: plait.create(*TETRAHEDRON, path),
                 lambda: plait.subdivide(tmp_path / "m.ply", path, 1),
                 lambda: plait.convert(source, path)):
        with pytest.raises(FileExistsError) as error:
            call()
        assert isinstance(error.value, plait.AlreadyExists) and isinstance(error.value, ValueError)
        assert error.value.errno == errno.EEXIST and error.value.filename == str(path)
    with pytest.raises(FileNotFoundError) as error:
        plait.open(tmp_path / "none.plait")
    assert error.value.errno == errno.ENOENT
    assert error.value.filename == error.value.path == str(tmp_path / "none.plait")
    again = pickle.loads(pickle.dumps(error.value))
    assert (again.errno, again.filename, str(again)) == (
        error.value.errno, error.value.filename, str(error.value))
    assert plait.NoSpace("full").errno == errno.ENOSPC


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is forbidden to root")
def test_the_number_of_the_system_is_kept(tmp_path):
    make(TETRAHEDRON, tmp_path / "s.plait", levels=1).close()
    (tmp_path / "s.plait").chmod(0)
    with pytest.raises(OSError) as error:
        plait.open(tmp_path / "s.plait")
    assert error.value.errno == errno.EACCES


def test_a_path_ends_where_it_ends(tmp_path):
    path = str(tmp_path / "s.plait")
    make(TETRAHEDRON, path, levels=1).close()
    for call in (lambda: plait.open(path + "\0zzz"), lambda: plait.create(*TETRAHEDRON, path + "\0a"),
                 lambda: plait.open(path)["position\0x"] and None,
                 lambda: make(TETRAHEDRON, levels=1).add_attribute("x\0y"),
                 lambda: plait.verify(path + "\0")):
        with pytest.raises((ValueError, KeyError)):
            call()


def test_messages_are_in_words_of_python(tmp_path):
    path = tmp_path / "s.plait"
    store = make(icosahedron(), path, levels=2)
    store.add_attribute("short", level=1)
    with pytest.raises(plait.InvalidArgument, match=r"add_attribute\(level=2\)"):
        store.visit(lambda v: None, reads=["short"], level=2)
    with pytest.raises(ZeroDivisionError):
        store.visit(lambda v: 1 / 0, writes="short")
    with pytest.raises(plait.BadState, match=r"roll_back\(\)") as error:
        store["short"][1][:]
    assert "Store::" not in str(error.value)
    store.roll_back()
    reader = plait.open(path)
    with pytest.raises(plait.BadState, match="writable=True"):
        reader.add_attribute("x")
    with pytest.raises(plait.NotSupported) as error:
        plait.create(*TETRAHEDRON, tmp_path / "t.plait", backend="none")
    assert "PLAIT_PLUGINS" not in str(error.value) and "load_plugin" in str(error.value)
    # What the library says where threads together need more frames than there are.
    assert re.match("read in fewer threads at once, .*, or allow more by memory=",
                    errors.in_words("end pins or views, or raise the budget"))


def test_arguments_of_a_wrong_kind_are_named():
    store = make(icosahedron(), levels=2)
    for call, name in ((lambda: store.add_attribute("q", np.float32, (3,)), "components"),
                       (lambda: store.add_attribute("q", np.float32, 0), "components"),
                       (lambda: store.add_attribute("q", "nonsense"), "dtype"),
                       (lambda: store.add_attribute("q", level="2"), "level"),
                       (lambda: store.patch(0, "normal"), "level"),
                       (lambda: store.patch("0"), "face"),
                       (lambda: store.patches([0], level=1.5), "level"),
                       (lambda: store.counts("1"), "level"),
                       (lambda: store.subdivide("4"), "levels")):
        with pytest.raises(plait.InvalidArgument, match=f"{name}: expected"):
            call()


def test_subdivide_says_when_float32_is_too_coarse():
    points, faces = icosahedron()
    far = np.round(100 * np.asarray(points)) + 5e6
    with pytest.warns(UserWarning, match="float32 has steps of 0.5 where edges are"):
        store = plait.create(far, faces, dtype=np.float32)
    with pytest.warns(UserWarning, match="float32 has steps of 0.5 where edges are .* at level 5"):
        store.subdivide(5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plait.create(far, faces, dtype=np.float64).subdivide(5)
        make(icosahedron(), levels=5)


def test_subdivide_keeps_an_attribute_normal_of_another_kind():
    store = make(TETRAHEDRON, levels=0)
    store.add_attribute("normal", np.uint8)
    with pytest.raises(plait.InvalidArgument, match="found uint8 x 1: remove it"):
        store.subdivide(2, normals=True)
    assert store["normal"].dtype == np.uint8


def test_outputs_name_what_they_leave_out_and_replace_no_link(tmp_path):
    with make(TETRAHEDRON, tmp_path / "s.plait", levels=2) as store:
        store.add_attribute("early", np.uint8, level=0)
        store.commit()
    assert "early" in plait.export(tmp_path / "s.plait", tmp_path / "a.ply", force=True)["left_out"]
    os.symlink("a.ply", tmp_path / "link.ply")
    with pytest.raises(plait.InvalidArgument, match="link.ply: it is a symbolic link"):
        plait.export(tmp_path / "s.plait", tmp_path / "link.ply", force=True)


def test_the_package_shows_what_it_has():
    shown = {name for name in dir(plait) if not name.startswith("_")}
    assert shown == set(plait.__all__)
    assert plait.store.Store is plait.Store  # the modules are there, and in nobody's way
