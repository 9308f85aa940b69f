#!/usr/bin/env python3
"""`plait serve` as a client sees it: ranges, HEAD, names that try to get out, a port in use, Ctrl-C, damage.

  serve_test.py PROGRAM
"""
import http.client
import json
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import zlib

PROGRAM = sys.argv[1]


class Server:
    def __init__(self, work, *words):
        # A shell that started the test in the background has told it to ignore SIGINT.
        self.process = subprocess.Popen([PROGRAM, "serve", *words, "--json"], cwd=work, text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        text = ""
        while not text.endswith("}\n"):
            line = self.process.stdout.readline()
            assert line, self.process.communicate()
            text += line
        self.about = json.loads(text)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.errors = self.process.communicate(timeout=600)[1]
        assert self.process.returncode == 0, (self.process.returncode, self.errors)

    def ask(self, path, method="GET", **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.about["port"], timeout=600)
        connection.putrequest(method, path, skip_accept_encoding=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, answer.headers, body


def plait(work, *words, status=0):
    done = subprocess.run([PROGRAM, *words], cwd=work, capture_output=True, text=True)
    assert done.returncode == status, (words, done)
    return done


def ranges(work, server):
    whole = (work / "www/attribute0.level03.1").read_bytes()
    status, headers, body = server.ask("/attribute0.level03.1")
    size = int(headers["Content-Length"])
    assert status == 200 and body == whole[:size] and not any(whole[size:]), (status, size)
    for text, first, after in (("bytes=0-0", 0, 1), ("bytes=5-70004", 5, 70005), ("bytes=1000-", 1000, size),
                               ("bytes=-7", size - 7, size), (f"bytes=9-{size + 99}", 9, size)):
        status, headers, body = server.ask("/attribute0.level03.1", Range=text)
        assert status == 206 and body == whole[first:after], (text, status, len(body))
        assert headers["Content-Range"] == f"bytes {first}-{after - 1}/{size}", (text, headers["Content-Range"])
    for text in (f"bytes={size}-", "bytes=7-3", "bytes=0-1,5-6", "bytes=x", "bytes=-0"):
        status, _, body = server.ask("/attribute0.level03.1", Range=text)
        assert status == 416 and body == b"", (text, status)
    status, headers, body = server.ask("/view", "HEAD")
    assert status == 200 and int(headers["Content-Length"]) == server.about["view_bytes"] and body == b""
    # Both made it from the same records; the copy has a UUID of its own, which the checksum covers.
    assert server.ask("/view")[2][32:-8] == (work / "www/view").read_bytes()[32:-8]
    assert server.ask("/view")[1]["Access-Control-Allow-Origin"] == "*"
    assert b"<canvas" in server.ask("/")[2]
    base = server.ask("/attribute0.base.1")[2]
    assert base == (work / "www/attribute0.base.1").read_bytes()


def faces_of(view):
    """Places of the corners, numbers of the places, coordinates and errors, read as docs/format.md says."""
    levels, = struct.unpack_from("<I", view, 12)
    vertices, faces, _, far = struct.unpack_from("<QQII", view, 40)
    table, packed = struct.unpack_from("<QQ", view, 104)
    content = zlib.decompress(view[120 + table:120 + table + packed])
    assert len(view) == 128 + table + packed and len(content) == faces + 4 * far + 16 * vertices + levels * faces
    at = faces

    def planes(count):
        nonlocal at
        at += 4 * count
        return [sum(content[at - 4 * count + plane * count + i] << 8 * plane for plane in range(4)) for i in range(count)]

    def signed(numbers):
        return [number >> 1 ^ -(number & 1) for number in numbers]

    distances, numbers = iter(planes(far)), signed(planes(vertices))
    coordinates = list(zip(*(signed(planes(vertices)) for _ in range(3))))
    numbers = [sum(numbers[:place + 1]) for place in range(vertices)]
    begins, ends = [[] for _ in range(vertices)], [[] for _ in range(vertices)]
    corners, grid, last = [], [], (0, 0, 0)
    for f in range(faces):
        here = []
        for i, divisor in enumerate((36, 6, 1)):
            kind = content[f] // divisor % 6
            known = (corners[-1] if f else []) if i == 0 else begins[here[-1]] + (ends[here[0]] if i == 2 else [])
            candidates = [place for place in dict.fromkeys(known) if place not in here]
            place = len(grid) if kind == 0 else len(grid) - 1 - next(distances) if kind == 5 else candidates[kind - 1]
            if kind == 0:
                grid.append(tuple(x + y for x, y in zip(last, coordinates[place])))
            here.append(place)
            last = grid[place]
        for p, q in zip(here, here[1:] + here[:1]):
            if q in begins[p]:
                begins[p].remove(q)
                if p in ends[q]:
                    ends[q].remove(p)
            else:
                begins[q], ends[p] = [p, *begins[q]][:8], [q, *ends[p]][:8]
        corners.append(here)
    assert next(distances, None) is None and len(grid) == vertices
    return corners, numbers, grid


def view_as_the_format_says(work, name):
    """Its base vertices are where the store has them, but for the lattice; its faces are a closed surface."""
    view = (work / name / "view").read_bytes()
    corners, numbers, grid = faces_of(view)
    origin, step = struct.unpack_from("<3d", view, 64), struct.unpack_from("<d", view, 88)[0]
    records = (work / name / "attribute0.base.1").read_bytes()
    assert sorted(numbers) == list(range(len(grid)))
    for number, place in zip(numbers, grid):
        for axis, record in enumerate(struct.unpack_from("<3f", records, 12 * number)):
            assert abs(origin[axis] + step * place[axis] - record) <= 0.501 * step, (number, axis)
    passed = [edge for a, b, c in corners for edge in ((a, b), (b, c), (c, a))]
    assert len(set(passed)) == len(passed) and {(b, a) for a, b in passed} == set(passed)


def no_way_out(work, server):
    (work / "secret").write_text("secret")
    (work / "s.plait/link").symlink_to(work / "secret")
    for path in ("/../secret", "/%2e%2e/secret", "/..%2fsecret", "/%2e%2e%2fsecret", "//../secret", "/./../secret", "/link",
                 "/manifest", "/lock", "/" + str(work / "secret"), "/view/../../secret", "/view%00", "/attribute0.level09.1"):
        status, _, body = server.ask(path)
        assert status == 404 and b"secret" not in body, (path, status, body)
    (work / "s.plait/link").unlink()
    before = sorted(path.name for path in (work / "s.plait").iterdir())
    for method in ("POST", "PUT", "DELETE", "PATCH"):
        status, _, _ = server.ask("/view", method, **{"Content-Length": "0"})
        assert 400 <= status < 500, (method, status)
    assert before == sorted(path.name for path in (work / "s.plait").iterdir())


def port_in_use(work):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        done = plait(work, "serve", "s.plait", "--port", port, status=1)
        assert done.stderr.count("\n") == 1 and port in done.stderr and "in use" in done.stderr, done.stderr
    done = plait(work, "serve", "missing.plait", status=2)
    assert done.stderr.count("\n") == 1 and "missing.plait" in done.stderr, done.stderr


def damage(work):
    """A damaged block ends the answer early; a damaged view is refused."""
    level = work / "www/attribute0.level03.1"
    content = bytearray(level.read_bytes())
    content[100] ^= 1
    level.write_bytes(content)
    with Server(work, "www", "--port", "0") as server:
        try:
            body = server.ask("/attribute0.level03.1")[2]
        except http.client.IncompleteRead as error:
            body = error.partial
        assert len(body) < 100, len(body)
    assert "attribute0.level03.1" in server.errors and server.errors.count("\n") == 1, server.errors
    view = work / "www/view"
    content = bytearray(view.read_bytes())
    content[200] ^= 1
    view.write_bytes(content)
    done = plait(work, "serve", "www", "--port", "0", status=1)
    assert "checksum" in done.stderr and done.stderr.count("\n") == 1, done.stderr
    done = plait(work, "verify", "www", status=1)
    assert "view" in done.stdout + done.stderr, done
    view.write_bytes(content[:150])
    assert "view" in plait(work, "serve", "www", "--port", "0", status=1).stderr


with tempfile.TemporaryDirectory() as name:
    work = pathlib.Path(name)
    plait(work, "generate", "molecule", "m.ply", "--vertices", "300", "--seed", "1")
    plait(work, "subdivide", "m.ply", "s.plait", "--levels", "3", "--normals", "--compress", "default")
    report = json.loads(plait(work, "publish", "s.plait", "www", "--page", "--json").stdout)
    assert report["view_bytes"] == (work / "www/view").stat().st_size
    assert report["first_view"] == {"requests": 2, "bytes": report["view_bytes"] + (work / "www/index.html").stat().st_size}
    assert "whole" in plait(work, "verify", "www").stdout
    view_as_the_format_says(work, "www")
    with Server(work, "s.plait", "--port", "0") as server:
        ranges(work, server)
        no_way_out(work, server)
    assert server.errors == "", server.errors
    port_in_use(work)
    damage(work)
