"""plait.show(): the server in this process, and the frame of a notebook."""

import http.client
import re
import socket
import subprocess
import sys
import threading

import numpy as np
import plait
import pytest
from conftest import icosahedron, make


def ask(shown, path, method="GET", **headers):
    host = re.fullmatch(r"http://([^/]+)/", shown.url).group(1)
    connection = http.client.HTTPConnection(host, timeout=600)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, answer.headers, body


@pytest.fixture
def path(tmp_path):
    make(icosahedron(), tmp_path / "ball.plait", levels=3, scheme="loop", normals=True,
         backend="compressed").close()
    return tmp_path / "ball.plait"


def test_page_view_and_records_are_served(path):
    with plait.show(path) as shown, plait.open(path) as store:
        status, headers, page = ask(shown, "/")
        assert status == 200 and b"<canvas" in page and headers["Content-Type"].startswith("text/html")
        assert ask(shown, "/?store=x")[2] == page
        view = ask(shown, "/view")[2]
        assert view[:8] == b"plaitvew"
        names = [name.decode() for name in re.findall(rb"attribute\d\.level\d\d\.\d+", view)]
        assert len(names) == 6  # three levels of two attributes
        records = ask(shown, "/" + names[2])[2]
        assert records == store["position"][3][:].tobytes()
        base = re.search(rb"attribute0\.base\.\d+", view).group(0).decode()
        assert np.array_equal(np.frombuffer(ask(shown, "/" + base)[2], "<f4").reshape(-1, 3),
                              store["position"][0][:])


def test_ranges_are_those_of_the_file(path):
    with plait.show(path) as shown:
        whole = ask(shown, "/")[2]
        size = len(whole)
        for text, first, after in (("bytes=0-0", 0, 1), ("bytes=5-704", 5, 705), ("bytes=100-", 100, size),
                                   ("bytes=-7", size - 7, size), (f"bytes=9-{size + 9}", 9, size)):
            status, headers, body = ask(shown, "/", Range=text)
            assert status == 206 and body == whole[first:after], text
            assert headers["Content-Range"] == f"bytes {first}-{after - 1}/{size}"
        for text in (f"bytes={size}-", "bytes=7-3", "bytes=0-1,5-6", "bytes=x", "bytes=-0", "bytes=-"):
            assert ask(shown, "/", Range=text)[0] == 416, text
        status, headers, body = ask(shown, "/", "HEAD")
        assert status == 200 and int(headers["Content-Length"]) == size and body == b""
        assert ask(shown, "/", "OPTIONS")[1]["Access-Control-Allow-Headers"] == "Range"


def test_no_request_leads_out_of_the_store(path):
    (path.parent / "secret").write_text("secret")
    with plait.show(path) as shown:
        for name in ("/../secret", "/%2e%2e/secret", "//../secret", "/manifest", f"/{path.parent}/secret", "*", "/view/x"):
            status, _, body = ask(shown, name)
            assert status == 404 and body == b"", name
        assert ask(shown, "/view", "POST")[0] == 501 and ask(shown, "/view", "DELETE")[0] == 501


def test_notebook_gets_a_frame(path):
    shown = plait.show(path, width=300, height="40%")
    text = shown._repr_html_()
    assert text.startswith("<iframe ") and f'src="{shown.url}"' in text
    assert 'width="300"' in text and 'height="40%"' in text
    assert shown.url in repr(shown)
    shown.close()
    assert shown.url == "" and "closed" in shown._repr_html_() and "<iframe" not in shown._repr_html_()
    shown.close()


def test_closed_server_answers_nobody(path):
    shown = plait.show(path)
    host, port = re.fullmatch(r"http://(.*):(\d+)/", shown.url).groups()
    with socket.create_connection((host, int(port)), timeout=600) as kept:
        kept.sendall(b"GET /view HTTP/1.1\r\nHost: x\r\n\r\n")
        assert kept.recv(10).startswith(b"HTTP/1.1 ")
        threads = [each for each in threading.enumerate() if each.name == "plait.show"]
        shown.close()
        for thread in threads:
            thread.join(600)
            assert not thread.is_alive()
        while kept.recv(1 << 16):  # to the end of the connection
            pass
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((host, int(port)), timeout=600)


def test_store_that_is_open_is_shown_as_it_was_committed(path):
    with plait.open(path, writable=True) as store:
        with plait.show(store) as shown:
            tag = ask(shown, "/view")[1]["ETag"]
            store.add_attribute("height", np.float32)  # the server has the store open for itself
            with pytest.raises(plait.BadState, match="commit"):
                plait.show(store)
            store.commit()
            assert ask(shown, "/view")[1]["ETag"] == tag
        with plait.show(store) as shown:
            assert ask(shown, "/view")[1]["ETag"] != tag and b"height" in ask(shown, "/view")[2]


def test_store_in_memory_cannot_be_changed_while_it_is_shown():
    store = make(icosahedron(), levels=2)
    shown = plait.show(store)
    assert ask(shown, "/view")[0] == 200
    with pytest.raises(plait.Busy, match="plait.show"):
        store.subdivide(3)
    shown.close()
    store.subdivide(3)
    shown = plait.show(store)
    store.close()  # ends what shows it
    assert shown.url == ""


def test_what_cannot_be_shown_is_refused_in_words(path):
    with pytest.raises(plait.NotFound):
        plait.show(path.parent / "missing.plait")
    with plait.show(path) as shown, pytest.raises(OSError, match="in use") as caught:
        plait.show(path, port=int(shown.url.rsplit(":", 1)[1][:-1]))
    assert "show at 127.0.0.1" in str(caught.value)
    with pytest.raises(plait.InvalidArgument):
        plait.show(path, port=70000)
    with pytest.warns(RuntimeWarning, match="no password"):
        plait.show(path, host="0.0.0.0").close()
    with plait.create(*icosahedron(), dtype=None) as flat:
        flat.add_attribute("height", np.float32)
        flat.remove_attribute("position")
        with pytest.raises(plait.NotFound):
            plait.show(flat)
        flat.set_text("units", "mm")  # nothing holds the store


def test_damaged_block_ends_the_answer_early_and_is_told(path, tmp_path):
    plait.publish(path, tmp_path / "www")  # has its view, so that nothing reads the records before
    file = tmp_path / "www" / "attribute0.level03.1"
    content = bytearray(file.read_bytes())
    content[100] ^= 1
    file.write_bytes(content)
    with plait.show(tmp_path / "www") as shown:
        with pytest.warns(RuntimeWarning, match="attribute0.level03.1"), pytest.raises(http.client.IncompleteRead):
            ask(shown, "/attribute0.level03.1")
        assert ask(shown, "/attribute0.level02.1")[0] == 200


def test_interpreter_ends_with_what_is_shown(path, tmp_path):
    program = tmp_path / "shows.py"
    program.write_text(f"import plait\nshown = plait.show({str(path)!r})\nprint(shown.url)\n")
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=600, check=True)
    assert done.stdout.startswith("http://127.0.0.1:") and done.stderr == ""


def test_forked_process_ends_without_the_server(path, tmp_path):
    program = tmp_path / "forks.py"
    program.write_text(f"""
import os, sys, plait
shown = plait.show({str(path)!r})
child = os.fork()
if child == 0:
    sys.exit(7)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
import urllib.request
assert urllib.request.urlopen(shown.url + "view").status == 200
""")
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
