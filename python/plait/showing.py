"""Shows a store in the browser: a small server in this process, and a frame for notebooks."""

import atexit
import ctypes
import html
import http.server
import ipaddress
import os
import re
import socket
import socketserver
import sys
import threading
import warnings
from ctypes import byref, c_char_p, c_void_p

from . import _functions, _handles
from . import _structures as types
from ._functions import LIBRARY
from ._progress import Watch
from .errors import BadState, Error, InvalidArgument, NotFound
from .store import Store, open_store

_SENT_AT_ONCE = 1 << 20
_open = set()  # a frame of a notebook needs its server when nobody has the object any more


class Shown:
    """A store that show() serves. `with` ends it at the end of the block; otherwise it ends with
    close() or with the interpreter."""

    def __init__(self, store, owns, server, frame):
        self._store, self._owns, self._server, self._frame = store, owns, server, frame
        store._shown.append(self)
        _open.add(self)
        threading.Thread(target=server.serve_forever, args=(0.1,), name="plait.show",
                         daemon=True).start()

    @property
    def url(self):
        """The address of the page, for a browser on this machine; empty after close()."""
        if self._server is None:
            return ""
        host, port = self._server.server_address[:2]
        return f"http://{host}:{port}/"

    def close(self):
        """Ends the server. The page says then that no server answers."""
        server, self._server = self._server, None
        if server is None:
            return
        server.end()
        _open.discard(self)
        self._store._shown.remove(self)
        if self._owns:
            self._store.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self):
        return f"<plait shows {self._store._absolute or 'a store in memory'}: {self.url or 'closed'}>"

    def _repr_html_(self):
        """The page in a frame, for notebooks."""
        if self._server is None:
            return f"<p>{html.escape(repr(self))}</p>"
        width, height = (html.escape(str(size), quote=True) for size in self._frame)
        return (f'<iframe src="{html.escape(self.url, quote=True)}" width="{width}" height="{height}" '
                'style="border: 0" allowfullscreen></iframe>')


def show(store, *, host="127.0.0.1", port=0, width="100%", height=600,
         memory=types.DEFAULT_BUDGET_BYTES, progress=None):
    """Shows a store in the browser. Returns a Shown: in a notebook, a frame with the page.

    store: a path, or a store that is open. Of a store on the disk, its last commit is shown.
    host: who reaches the server: this machine alone, or with "0.0.0.0" others too, without a
    password. port: 0: any free one. width, height: of the frame, as HTML has them.
    memory: the most memory for blocks, if the store is on the disk. progress: as for verify().

    If the store has no view of its version (plait publish writes one), the call first reads all
    positions. A store in memory cannot be changed while it is shown.
    """
    owns = not isinstance(store, Store)
    if owns or store._absolute:
        if not owns and store._lost:
            raise BadState(f"show {store._absolute}: the store has changes that were not committed: "
                           "call commit() first", store._absolute)
        store, owns = open_store(store if owns else store._absolute, memory=memory), True
    try:
        served = _serve(store, progress)
        try:
            server = _listen(host, port, served, store._store())
        except BaseException:
            served.end()
            raise
    except BaseException:
        if owns:
            store.close()
        raise
    return Shown(store, owns, server, (width, height))


def _serve(store, progress):
    address = c_void_p()
    with Watch("view", progress) as watch:
        store._store().call(LIBRARY.plait_served_open, watch.callback, None, byref(address))
    return _handles.Handle(address.value, LIBRARY.plait_served_close)


def _listen(host, port, served, store):
    try:
        server = _Server((host, port), served, store)
    except OverflowError as error:
        raise InvalidArgument(f"show at {host}:{port}: {error}") from None
    except OSError as error:
        raise type(error)(error.errno, f"show at {host}:{port}: {error.strerror}") from None
    if not ipaddress.ip_address(server.server_address[0]).is_loopback:
        warnings.warn("other machines can read the store: there is no password and no encryption",
                      RuntimeWarning, stacklevel=3)
    return server


@atexit.register
def _close_all():
    for shown in list(_open):
        shown.close()


class _Server(http.server.ThreadingHTTPServer):
    """Answers GET and HEAD, as `plait serve` does, in threads that do not keep the interpreter."""

    daemon_threads = True

    def __init__(self, address, served, store):
        self.served, self.store, self.connections, self.process = served, store, set(), os.getpid()
        super().__init__(address, _Handler)

    def server_bind(self):
        """Without the name of this machine, for which HTTPServer would ask the network."""
        socketserver.TCPServer.server_bind(self)

    def end(self):
        if self.process == os.getpid():  # a process that was forked has no thread to wait for
            self.shutdown()
            for connection in list(self.connections):
                _end_connection(connection)
        self.server_close()
        self.served.end()

    def process_request(self, request, client_address):
        self.connections.add(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request):
        self.connections.discard(request)
        super().shutdown_request(request)

    def handle_error(self, request, client_address):
        """A browser goes away when it likes; all else is a fault, which is told."""
        error = sys.exc_info()[1]
        if not isinstance(error, (ConnectionError, TimeoutError)):
            super().handle_error(request, client_address)

    def read(self, function, *arguments):
        """Calls a function of the served store. The store stays until the call has returned."""
        self.store.call(lambda _: self.served.call(function, *arguments))


def _end_connection(connection):
    try:
        connection.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass  # the browser was first


class _Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "plait", ""
    timeout = 60  # of a connection on which nothing comes: its thread ends
    disable_nagle_algorithm = True

    def log_message(self, *_):
        """Nobody is told who asked."""

    def do_OPTIONS(self):
        """What a browser asks before a page of another server reads ranges."""
        self.send_response(204)
        self.send_header("Access-Control-Allow-Origin", "*")
        self.send_header("Access-Control-Allow-Headers", "Range")
        self.send_header("Access-Control-Allow-Methods", "GET, HEAD")
        self.end_headers()

    def do_HEAD(self):
        self.do_GET()

    def do_GET(self):
        path, file = c_char_p(self.path.split("?")[0].encode("latin-1")), types.plait_served_file()
        try:
            self.server.read(LIBRARY.plait_served_find, path, byref(file))
        except NotFound:
            return self._refuse(404, ())
        except BadState:  # it was closed
            return self._refuse(503, ())
        asked = self.headers.get("Range")
        part = range_of(asked, file.bytes)
        if part is None:
            return self._refuse(416, [("Content-Range", f"bytes */{file.bytes}")])
        first, after = part
        headers = [("Content-Type", file.content_type.decode()), ("ETag", f'"{file.tag.decode()}"')]
        if asked:
            headers.append(("Content-Range", f"bytes {first}-{after - 1}/{file.bytes}"))
        self._begin(206 if asked else 200, after - first, headers)
        if self.command == "GET":
            self._send(path, first, after)

    def _begin(self, status, count, headers):
        self.send_response(status)
        for name, value in (("Content-Length", str(count)), ("Accept-Ranges", "bytes"),
                            ("Access-Control-Allow-Origin", "*"),
                            ("Access-Control-Expose-Headers", "Content-Range, ETag"),
                            ("X-Content-Type-Options", "nosniff"), ("Cache-Control", "no-cache"),
                            *headers):
            self.send_header(name, value)
        self.end_headers()

    def _refuse(self, status, headers):
        self._begin(status, 0, headers)

    def _send(self, path, first, after):
        buffer = ctypes.create_string_buffer(min(_SENT_AT_ONCE, after - first))
        while first < after:
            count = min(len(buffer), after - first)
            try:
                self.server.read(LIBRARY.plait_served_read, path, first, buffer, count)
            except Error as error:  # the reader of the answer sees that bytes are missing
                self.close_connection = True
                if not isinstance(error, BadState):  # of a store that was closed
                    warnings.warn(f"show: {error}", RuntimeWarning)
                return
            self.wfile.write(memoryview(buffer)[:count])
            first += count


def range_of(header, size):
    """The bytes of a file that a header Range asks for, as (first, after); None if there are none."""
    if not header:
        return 0, size
    found = re.fullmatch(r"bytes=(\d*)-(\d*)", header.strip())
    if not found or found.groups() == ("", ""):
        return None
    first, last = found.groups()
    if not first:
        first, after = max(0, size - int(last)), size
    else:
        first, after = int(first), min(size, int(last) + 1 if last else size)
    return (first, after) if first < after else None
