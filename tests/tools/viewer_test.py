#!/usr/bin/env python3
"""The page of `plait publish --page` and `plait serve` in headless Chromium, which draws in software.

  viewer_test.py PROGRAM [--flight] [PICTURES]

  PROGRAM    plait
  --flight   only the flight of two minutes; without it, all others and a short flight
  PICTURES   a folder that keeps what the page drew, to look at

Skips (77) where there is no Chromium. PLAIT_CHROMIUM names another browser.
"""
import base64
import collections
import http.server
import json
import os
import pathlib
import queue
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib

PROGRAM = sys.argv[1]
LONG_FLIGHT = "--flight" in sys.argv
PICTURES = ([word for word in sys.argv[2:] if word != "--flight"] + [None])[0]
BROWSER = os.environ.get("PLAIT_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
# What each test page runs after the page's own script: it may call these, and ends with report().
PRELUDE = """
<script>
window.errors = [];
addEventListener("error", event => errors.push(String(event.message)));
addEventListener("unhandledrejection", event => errors.push(String(event.reason)));
const complain = console.error; console.error = (...words) => { errors.push(words.join(" ")); complain(...words); };
const until = test => new Promise(done => { const look = () => test() ? done() : setTimeout(look, 20); look(); });
const ask = name => fetch("/do/" + name, { method: "POST" }).then(answer => answer.text());
// One browser goes through all pages: each ends by going to the next one.
const report = async answer => {
  await fetch("/report", { method: "POST", body: JSON.stringify(answer) });
  location.replace(await (await fetch("/next")).text());
};
</script>
"""
SCRIPT = """
<script>
(async () => {
  try {
    plait.animate = false;
    %s
    await until(() => plait.ready || plait.failed);
    if (plait.canvas) Object.assign(plait.canvas.style, { width: "%dpx", height: "%dpx" });
    const settled = async () => { plait.settled = false; plait.redraw(); await until(() => plait.settled || plait.failed); };
    const pixels = () => { const gl = plait.gl, w = plait.canvas.width, h = plait.canvas.height, all = new Uint8Array(4 * w * h);
      gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all); return all; };
    // What plait render draws: the same camera, size and lights.
    const rendered = async () => { plait.setDark(false); plait.pixelError = 0.01; await settled(); plait.fitView(); await settled(); };
    let seed = 1; const random = () => (seed = (Math.imul(seed, 1103515245) + 12345) >>> 0) / 2 ** 32;
    const answer = { renderer: plait.renderer };
    %s
    Object.assign(answer, { failed: plait.failed, errors, words: document.getElementById("words").textContent, log: plait.log,
      planned: plait.planned, requests: plait.requests, bytes: plait.bytes, figures: document.getElementById("figures").textContent });
    await report(answer);
  } catch (error) { await report({ broken: String(error.stack || error), errors }); }
})();
</script>
"""


class Site(http.server.ThreadingHTTPServer):
    """Files of folders with ranges, as any web server gives them, and the reports of the page."""
    daemon_threads = True

    def __init__(self, folder):
        super().__init__(("127.0.0.1", 0), Handler)
        self.folder = pathlib.Path(folder)
        self.reports, self.pages = queue.Queue(), queue.Queue()
        threading.Thread(target=self.serve_forever, daemon=True).start()
        self.begin("", (640, 480))

    def begin(self, script, size, early=""):
        """What one look at a page finds."""
        self.script, self.log = SCRIPT % (early, *size, script), []
        self.ignore_ranges, self.broken, self.replaced, self.held, self.does = False, 0, {}, set(), {}
        self.release = threading.Event()

    def handle_error(self, *_):
        """The browser may end in the middle of an answer."""

    def url(self):
        return f"http://127.0.0.1:{self.server_address[1]}/"

    def content(self, path):
        """The bytes of a file, as they are or as the test replaced them; None if there are none."""
        if path.name in self.replaced:
            return self.replaced[path.name]
        return path.read_bytes() if path.is_file() else None


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def answer(self, status, body, headers=()):
        self.send_response(status)
        for name, value in (("Content-Length", len(body)), *headers):
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        if self.path == "/report":
            self.answer(200, b"")
            return self.server.reports.put(json.loads(body))
        self.answer(200, str(self.server.does[self.path.rsplit("/", 1)[1]]()).encode())

    def do_GET(self):
        site, path = self.server, self.path.split("?")[0].lstrip("/")
        if path == "next":
            return self.answer(200, site.pages.get().encode())
        if path == "first.html":
            return self.answer(200, b"<script>fetch('next').then(x => x.text()).then(x => location.replace(x))</script>")
        if path.endswith("test.html"):
            page = (site.folder / path.replace("test.html", "index.html")).read_text()
            page = page.replace("<body>", "<body>" + PRELUDE).replace("</body>", site.script + "</body>")
            return self.answer(200, page.encode(), [("Content-Type", "text/html; charset=utf-8")])
        file = site.folder / path
        content = site.content(file)
        if content is None:
            return self.answer(404, b"")
        if file.name in site.held:
            site.release.wait()
        tag = ("ETag", f'"{zlib.crc32(content)}"')
        wanted = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        if wanted and site.broken > 0:
            site.broken -= 1
            return self.answer(503, b"")
        if not wanted or site.ignore_ranges:
            site.log.append((file.name, 0, len(content)))
            return self.answer(200, content, [tag])
        first, last = int(wanted[1]), int(wanted[2])
        part = content[first:last + 1]
        site.log.append((file.name, first, len(part)))
        self.answer(206, part, [("Content-Range", f"bytes {first}-{first + len(part) - 1}/{len(content)}"), tag])


class Serve:
    """`plait serve` of a store."""

    def __init__(self, work, store, port=0):
        self.process = subprocess.Popen([PROGRAM, "serve", store, "--port", str(port), "--json"], cwd=work, text=True,
                                        stdout=subprocess.PIPE)
        text = ""
        while not text.endswith("}\n"):
            line = self.process.stdout.readline()
            assert line, f"plait serve {store} has ended"
            text += line
        self.address, self.port = (json.loads(text)[name] for name in ("address", "port"))

    def kill(self):
        self.process.kill()
        self.process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=600)
        assert self.process.returncode == 0, self.process.returncode


class Test:
    def __init__(self, work):
        self.work, self.site, self.browser = pathlib.Path(work), Site(work), None

    def start_browser(self):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.browser = subprocess.Popen(
            [BROWSER, "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
             "--no-first-run", "--disable-extensions", "--disable-background-networking", "--disable-component-update",
             "--disable-background-timer-throttling", "--enable-precise-memory-info", "--js-flags=--expose-gc",
             f"--user-data-dir={self.profile.name}", "--window-size=640,480", "--force-device-scale-factor=1",
             "--hide-scrollbars", self.site.url() + "first.html"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)

    def end_browser(self):
        os.killpg(self.browser.pid, signal.SIGKILL)
        self.browser.wait()
        self.profile.cleanup()

    def plait(self, *words):
        return json.loads(subprocess.run([PROGRAM, *map(str, words), "--json"], cwd=self.work, check=True,
                                         stdout=subprocess.PIPE).stdout)

    def look(self, store, script, query="", size=(400, 300), early="", **site):
        """What the page reports after `script`, which runs in it once the page is ready, and `early` before.
        `site` are members of the server."""
        self.site.begin(script, size, early)
        for name, value in site.items():
            setattr(self.site, name, value)
        self.site.pages.put(f"{self.site.url()}{store}/test.html{query}")
        answer = self.site.reports.get(timeout=1700)  # a page that hangs; a busy machine takes minutes
        assert "broken" not in answer, answer
        assert "SwiftShader" in answer["renderer"], f"expected drawing in software, found {answer['renderer']}"
        if "picture" in answer and PICTURES:
            pathlib.Path(PICTURES, f"{store}.png").write_bytes(base64.b64decode(answer["picture"].split(",")[1]))
        return answer

    def shown(self, *words, **site):
        """As look(), of a store that the page shows without an error."""
        answer = self.look(*words, **site)
        assert answer["failed"] == "" and answer["errors"] == [] and answer["words"] == "", answer
        return answer

    def run(self):
        self.plait("generate", "molecule", "closed.ply", "--vertices", "200", "--seed", "1")
        self.plait("subdivide", "closed.ply", "closed.plait", "--levels", "3", "--normals")
        self.published = self.plait("publish", "closed.plait", "closed", "--page")
        tests = (self.first_picture, self.beside_render, self.no_cracks, self.depths_of_faces, self.depths_beside_render,
                 self.other_stores, self.ranges_ignored, self.errors_of_the_server, self.server_dies_and_comes_back,
                 self.server_is_silent, self.forged_view, self.forged_depths, self.store_changes, self.little_memory, self.flight)
        self.start_browser()
        try:
            for test in [self.flight] if LONG_FLIGHT else tests:
                begin = time.monotonic()
                test()
                print(f"viewer_test: {test.__name__} passed in {time.monotonic() - begin:.1f} s", flush=True)
        finally:
            self.end_browser()

    def first_picture(self):
        answer = self.shown("closed", """
            await settled();
            const all = pixels(), colours = new Set();
            for (let i = 0; i < all.length; i += 4) colours.add(all[i] << 16 | all[i + 1] << 8 | all[i + 2]);
            answer.colours = colours.size;
            answer.picture = plait.canvas.toDataURL();
            // Once more from nothing, and beside it what the drawn depths need, vertex by vertex.
            answer.mark = plait.log.length;
            document.getElementById("normals").onchange();
            await settled();
            const view = plait.view, need = new Map();
            for (let f = 0; f < view.F; ++f) for (let depth = view.depthNow[f] >> 4, n = 1 << depth, j = 0; j <= n; ++j)
              for (let i = 0; i <= n - j; ++i) {
                const at = plait.addressOf(view, f, depth, i, j);
                if (at.depth) for (const name of ["position", "normal"]) {
                  const attribute = view.attributes.find(a => a.name === name), bytes = attribute.recordBytes;
                  const file = attribute.files[at.depth - 1], page = Math.floor(at.record / 2048);
                  need.set(file + page, [file, page * 2048 * bytes, 2048 * bytes]);
                }
              }
            answer.need = [...need.values()];
            answer.pick = await plait.pickAt(plait.canvas.width >> 1, plait.canvas.height >> 1);
            """, size=(640, 480))
        assert answer["colours"] > 200, f"expected a shaded picture, found {answer['colours']} colours"
        # What the server saw is what the page planned and says that it read, and what the view needs.
        saw = [x for x in self.site.log if x[0] != "index.html"]
        planned = [tuple(x) for x in answer["planned"]]
        assert sorted(saw) == sorted(planned) == sorted(map(tuple, answer["log"])), (saw, planned)
        assert answer["bytes"] == sum(x[2] for x in saw)
        assert planned[0] == ("view", 0, self.published["view_bytes"]), planned[0]
        needed = collections.Counter()
        for file, first, count in answer["need"]:
            size = (self.work / "closed" / file).stat().st_size
            needed.update((file, byte) for byte in range(first, min(first + count, size), 4))
        read = collections.Counter()
        for file, first, count in [tuple(x) for x in answer["log"]][answer["mark"]:-2]:  # without the pick
            read.update((file, byte) for byte in range(first, first + count, 4))
        # Files of levels end with zeros up to a whole page of the disk, which nobody reads.
        assert read and max(read.values()) == 1 and set(read) <= set(needed)
        missing = [(file, byte) for file, byte in needed if (file, byte) not in read]
        assert all((self.work / "closed" / file).read_bytes()[byte:byte + 4] == b"\0" * 4 for file, byte in missing[:200])
        assert len(missing) < 4096, len(missing)
        pick = answer["pick"]
        assert pick is not None and len(pick["position"]) == 3 and len(pick["values"]["normal"]) == 3, pick
        print(f"viewer_test: {answer['figures']!r}")

    def no_cracks(self):
        self.look_for_cracks("closed", 500)

    def look_for_cracks(self, store, views):
        """From places inside, with random depths of the view, of which no face takes more than it has."""
        answer = self.shown(store, """
            const view = plait.view, F = view.F, c = plait.camera, gl = plait.gl, views = %d;
            // The faces as the card has them, and the same that believe that there is nothing beyond their sides.
            const rows = Math.ceil(3 * F / 1536), faces = new Uint32Array(4 * 1536 * rows), buffer = gl.createFramebuffer();
            gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
            gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, plait.gpu.faces, 0);
            gl.readPixels(0, 0, 1536, rows, gl.RGBA_INTEGER, gl.UNSIGNED_INT, faces);
            gl.bindFramebuffer(gl.FRAMEBUFFER, null);
            const blind = faces.map((word, i) => i < 12 * F && i % 4 === 3 ? Math.floor(i / 12) : word);
            const putFaces = words => { gl.bindTexture(gl.TEXTURE_2D, plait.gpu.faces);
              gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 1536, rows, gl.RGBA_INTEGER, gl.UNSIGNED_INT, words); };
            plait.forced = new Uint8Array(F).fill(view.levels);
            plait.fitView();
            await settled();
            plait.clear = [1, 0, 1];
            document.getElementById("normals").value = "stored";
            const magenta = () => { let found = 0; const all = new Uint32Array(pixels().buffer);
              for (let i = 0; i < all.length; ++i) if (all[i] === 0xffff00ff) ++found; return found; };
            answer.found = []; answer.magenta = 0; answer.views = 0; answer.cracks = 0;
            for (let v = 0; v < views; ++v) {
              for (let f = 0; f < F; ++f) plait.forced[f] = Math.floor(random() * (view.levels + 1));
              // Inside: just behind a face, looking anywhere.
              const f = Math.floor(random() * F);
              c.azimuth = 360 * random(); c.elevation = 180 * random() - 90; c.focal = 0.5; c.shift = [0, 0];
              const at = i => [0, 1, 2].map(k => view.lattice[3 * view.corners[3 * f + i] + k] - view.centre[k]);
              const [p, q, r] = [at(0), at(1), at(2)], u = q.map((x, k) => x - p[k]), w = r.map((x, k) => x - p[k]);
              const n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]], size = Math.hypot(...n);
              const eye = p.map((x, k) => (x + q[k] + r[k]) / 3 - n[k] / size * 0.02 * view.radius);
              c.distance = 1e-3 * view.radius;
              c.target = [0, 0, 0];
              const now = plait.cameraNow();
              c.target = eye.map((x, k) => x - now.eye[k]);
              // All faces are drawn, so that only cracks can show what is behind.
              const drawn = plait.cameraNow();
              for (let k = 0; k < 20; ++k) drawn.planes[k] = k % 4 == 3 ? 1 : 0;
              plait.select(drawn, 0);
              plait.draw(drawn);
              const seen = magenta();
              ++answer.views;
              answer.magenta += seen;
              if (seen) answer.found.push([v, seen]);
              if (seen && !answer.picture) answer.picture = plait.canvas.toDataURL();
              // Faces that do not know of their neighbours must crack, or the test sees nothing.
              if (v >= 10) continue;
              putFaces(blind);
              plait.draw(drawn);
              answer.cracks += magenta();
              putFaces(faces);
            }
            """.replace("%d", str(views)), size=(200, 150))
        assert answer["views"] == views and answer["cracks"] > 0, answer["cracks"]
        print(f"viewer_test: {store}: {answer['magenta']} magenta pixels in {answer['views']} views; {answer['cracks']} where faces do not know their neighbours")
        assert answer["magenta"] == 0, answer["found"]

    def depths_of_faces(self):
        """A closed surface whose faces have depths of their own, of 0 to 3, next to each other in any way: a box whose sides have
        humps here and there."""
        generator, n = random.Random(1), 6
        numbers, places, faces = {}, [], []

        def vertex(place):
            if place not in numbers:
                numbers[place] = len(places)
                inner = [axis for axis in range(3) if place[axis] in (0, n)]
                hump = 10 ** -generator.uniform(0.5, 4) if len(inner) == 1 and generator.random() < 0.2 else 0
                places.append([x + (hump if axis in inner else 0) * (1 if x else -1) for axis, x in enumerate(place)])
            return numbers[place]

        for axis in range(3):
            for end in (0, n):
                for i in range(n):
                    for j in range(n):
                        around = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                        a, b, c, d = (vertex(tuple([u, v][(k - axis) % 3 - 1] if k != axis else end for k in range(3)))
                                      for u, v in (around if end else around[::-1]))
                        faces += [(a, b, c), (a, c, d)]
        (self.work / "box.ply").write_text(
            f"ply\nformat ascii 1.0\nelement vertex {len(places)}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
            + "".join("{} {} {}\n".format(*place) for place in places) + "".join("3 {} {} {}\n".format(*face) for face in faces))
        self.plait("subdivide", "box.ply", "box.plait", "--levels", "3", "--normals")
        self.plait("prune", "box.plait", "pruned.plait", "--max-distance", "0.0003", "--balance", "0")
        for store in ("box", "pruned"):
            self.plait("publish", f"{store}.plait", store, "--page")
        self.look_for_cracks("pruned", 200)
        answer = self.shown("pruned", """
            plait.pixelError = 1e-6;
            await settled();
            answer.own = [...plait.view.own];
            answer.alone = plait.canvas.toDataURL();
            const { view } = plait, found = view.records.map(() => new Set());
            answer.steps = [0, 0, 0, 0]; answer.deepest = [0, 0, 0, 0];
            answer.beyond = 0; answer.triangles = plait.triangles; answer.all = view.triangles;
            for (let f = 0; f < view.F; ++f) {
              ++answer.deepest[view.own[f]];
              if (plait.view.depthNow[f] > 16 * view.own[f]) ++answer.beyond;
              for (let side = 0; side < 3; ++side) ++answer.steps[Math.abs(view.own[f] - view.own[view.beyond[3 * f + side]])];
              for (let n = 1 << view.own[f], j = 0; j <= n; ++j) for (let i = 0; i <= n - j; ++i) {
                const { depth, record } = plait.addressOf(view, f, view.own[f], i, j);
                found[depth].add(record);
              }
            }
            // Each record of the store is a vertex, and each vertex has one record.
            answer.records = view.records;
            answer.found = found.map(each => each.size);
            answer.highest = found.map(each => [...each].reduce((a, b) => Math.max(a, b)) + 1);
            document.getElementById("colour").value = "#depths";
            await plait.chooseColour("#depths");
            await settled();
            answer.legend = document.getElementById("legend").textContent.trim();
            answer.picture = plait.canvas.toDataURL();
            const all = pixels(), colours = new Set();
            for (let i = 0; i < all.length; i += 4) colours.add(all[i] << 16 | all[i + 1] << 8 | all[i + 2]);
            answer.colours = colours.size;
            """)
        assert all(answer["steps"][:4]) and all(answer["deepest"]), (answer["steps"], answer["deepest"])
        assert answer["beyond"] == 0 and answer["triangles"] == answer["all"], answer
        assert answer["records"] == answer["found"] == answer["highest"], answer
        assert answer["legend"] == "03", answer["legend"]
        sizes = {f"attribute{a}.level{level:02}.1": -(-answer["records"][level] * 12 // 4096) * 4096 for a in (0, 1) for level in (1, 2, 3)}
        for name, size in sizes.items():
            assert (self.work / "pruned" / name).stat().st_size == size, (name, size)
        assert all(first + count <= sizes.get(file, 1 << 30) for file, first, count in self.site.log if file != "index.html")
        # The store of all levels, no face of which is drawn deeper than here, gives the same pixels.
        whole = self.shown("box", f"""
            plait.forced = Uint8Array.from({answer["own"]});
            await settled();
            answer.whole = plait.canvas.toDataURL();
            """)
        assert whole["whole"] == answer["alone"], "the same vertices look otherwise in the store with depths"
        self.picture("pruned")

    def depths_beside_render(self):
        """A convex shape, because plait render darkens hollows: an egg that is more curved at its ends."""
        head, _, body = (self.work / "ball.ply").read_bytes().partition(b"end_header\n")
        count = int(re.search(rb"element vertex (\d+)", head)[1])
        long = b"".join(struct.pack("<3f", 2 * x, y, z) for x, y, z in struct.iter_unpack("<3f", body[:12 * count]))
        (self.work / "egg.ply").write_bytes(head + b"end_header\n" + long + body[12 * count:])
        self.plait("subdivide", "egg.ply", "egg.plait", "--levels", "3", "--normals")
        self.plait("prune", "egg.plait", "pruned-egg.plait", "--max-distance", "0.005%")
        self.plait("publish", "pruned-egg.plait", "pruned-egg", "--page")
        self.plait("render", "pruned-egg.plait", "pruned-egg/render.png", "--size", "360x280")
        depths = self.difference_from_render("pruned-egg")["depths"]
        assert len(set(depths)) > 1, set(depths)

    def difference_from_render(self, store, query=""):
        answer = self.shown(store, """
            await rendered();
            const image = new Image();
            image.src = "render.png";
            await image.decode();
            const copy = source => { const to = document.createElement("canvas"); to.width = 360; to.height = 280;
              const context = to.getContext("2d"); context.drawImage(source, 0, 0); return context.getImageData(0, 0, 360, 280).data; };
            const a = copy(image), b = copy(plait.canvas);
            let sum = 0;
            for (let i = 0; i < a.length; ++i) sum += Math.abs(a[i] - b[i]);
            answer.difference = sum / (a.length / 4 * 3);
            answer.depths = [...plait.view.own];
            answer.picture = plait.canvas.toDataURL();
            """, query, size=(360, 280))
        print(f"viewer_test: {store}: mean difference from plait render {answer['difference']:.2f} of 255")
        assert answer["difference"] <= 2, answer["difference"]
        return answer

    def beside_render(self):
        """The same camera, size and lights as plait render."""
        self.plait("generate", "icosphere", "ball.ply", "--vertices", "642")
        self.plait("subdivide", "ball.ply", "ball.plait", "--levels", "2", "--normals")
        self.plait("publish", "ball.plait", "ball", "--page")
        self.plait("render", "ball.plait", "ball/render.png", "--size", "360x280")
        self.difference_from_render("ball")

    def picture(self, store):
        """What the page draws of a store, from `plait serve` or published: the pixels of both must be equal."""
        script = "await rendered(); answer.picture = plait.canvas.toDataURL();"
        self.plait("publish", f"{store}.plait", f"www-{store}", "--page", "--force")
        published = self.shown(f"www-{store}", script, size=(360, 280))
        with Serve(self.work, f"{store}.plait") as server:
            served = self.shown(f"www-{store}", script, f"?store={server.address}", size=(360, 280))
        assert [x for x in self.site.log if x[0] != "render.png"] == [], self.site.log  # all came from plait serve
        assert served["requests"] > 3 and served["picture"] == published["picture"], store
        return published["picture"]

    def other_stores(self):
        """Compressed, sharded, float64, with borders."""
        self.plait("convert", "closed.plait", "small.plait", "--compress", "default")
        self.plait("plan", "closed.ply", "closed.plan", "--levels", "3", "--normals", "--parts", "3")
        for part in range(3):
            self.plait("part", "closed.plan", part)
        self.plait("join", "closed.plan", "sharded.plait")
        assert list((self.work / "sharded.plait").glob("*.shard*")), "no shards"
        expected = self.picture("closed")
        for store in ("small", "sharded"):
            assert self.picture(store) == expected, f"{store} looks otherwise"
        self.plait("subdivide", "ball.ply", "wide.plait", "--levels", "2", "--normals", "--precision", "float64")
        self.picture("wide")
        shutil.copy(self.work / "ball/render.png", self.work / "www-wide")
        self.difference_from_render("www-wide")
        # A bowl upside down, which shades itself nowhere: plait render darkens hollows, the page does not.
        side = [k / 5 - 1 for k in range(11)]
        faces = [(x, x + 1, x + 12, x + 11) for j in range(10) for x in range(11 * j, 11 * j + 10)]
        (self.work / "bowl.ply").write_text(
            "ply\nformat ascii 1.0\nelement vertex 121\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 200\nproperty list uchar int vertex_indices\nend_header\n"
            + "".join(f"{x} {1 - (x * x + y * y) / 2} {-y}\n" for y in side for x in side)
            + "".join(f"3 {a} {b} {c}\n3 {a} {c} {d}\n" for a, b, c, d in faces))
        self.plait("subdivide", "bowl.ply", "bowl.plait", "--levels", "3", "--normals")
        self.picture("bowl")
        self.plait("render", "bowl.plait", "www-bowl/render.png", "--size", "360x280")
        self.difference_from_render("www-bowl")

    def ranges_ignored(self):
        answer = self.look("closed", "plait.pixelError = 0.01; plait.redraw(); await until(() => plait.failed);", ignore_ranges=True)
        assert "does not know ranges" in answer["failed"] and answer["words"] == answer["failed"], answer

    def errors_of_the_server(self):
        self.shown("closed", "await settled();", broken=3)
        assert self.site.broken == 0

    def server_dies_and_comes_back(self):
        servers = [Serve(self.work, "closed.plait")]
        address = servers[0].address

        def start():
            servers.append(Serve(self.work, "closed.plait", servers[0].port))

        try:
            answer = self.shown("closed", """
                await settled();
                const before = plait.requests, words = document.getElementById("words");
                await ask("kill");
                document.getElementById("normals").onchange();  // forgets all pages
                await until(() => words.textContent.includes("tries again"));
                answer.told = words.textContent;
                await ask("start");
                await settled();
                answer.more = plait.requests - before;
                """, f"?store={address}", does={"kill": servers[0].kill, "start": start})
        finally:
            servers[-1].kill()
        assert "does not answer" in answer["told"] and answer["more"] > 0, answer

    def server_is_silent(self):
        """A server that takes requests and never answers."""
        levels = {path.name for path in (self.work / "closed").glob("attribute*.level*")}
        answer = self.shown("closed", """
            const words = document.getElementById("words");
            await until(() => words.textContent.includes("tries again"));
            answer.told = words.textContent;
            await ask("answer");
            plait.patience = 30000;
            await settled();
            """, early="plait.patience = 300;", held=levels, does={"answer": lambda: (self.site.held.clear(), self.site.release.set())})
        assert "does not answer" in answer["told"], answer

    def forged_view(self):
        """Views that are no views: words, and nothing from elsewhere."""
        view = (self.work / "closed/view").read_bytes()
        table, packed = struct.unpack_from("<QQ", view, 104)
        content = zlib.decompress(view[120 + table:120 + table + packed])
        faces = struct.unpack_from("<Q", view, 48)[0]

        def at(offset, form, *numbers):
            forged = bytearray(view)
            struct.pack_into(form, forged, offset, *numbers)
            return bytes(forged)

        def with_content(made):
            z = zlib.compress(bytes(made))
            return view[:112] + struct.pack("<Q", len(z)) + view[120:120 + table] + z + view[-8:]

        def flipped(offset):
            return with_content(content[:offset] + bytes([content[offset] ^ 85]) + content[offset + 1:])

        name = b"attribute0.level03.1"
        assert name in view
        cases = {
            "empty": b"", "short": view[:100], "cut": view[:-100], "magic": b"x" + view[1:], "format": at(8, "<I", 77),
            "levels": at(12, "<I", 19), "many levels": at(12, "<I", 2**31), "vertices": at(40, "<Q", 2**50),
            "faces": at(48, "<Q", 2**33), "no faces": at(48, "<Q", 0), "origin": at(64, "<d", float("nan")),
            "step": at(88, "<d", 0.0), "error": at(96, "<d", float("inf")), "table": at(104, "<Q", 2**40),
            "position": at(120, "<I", 9), "attributes": at(124, "<I", 2**31),
            "name": view.replace(name, b"../../other/level03x"[:len(name)]), "type": view.replace(b"position\x01", b"position\x63"),
            "packed": view[:-200] + bytes(100) + view[-100:], "bomb": with_content(bytes(50 << 20)),
            "all faces one": with_content(bytes(4 * faces) + content[4 * faces:]),
            **{f"byte {place} of the content": flipped(place) for place in (0, 5, faces // 2, faces + 2, len(content) // 2)},
        }
        for case, forged in cases.items():
            answer = self.look("closed", "if (!plait.failed) await settled();", replaced={"view": forged})
            assert answer["errors"] == [] and answer["words"] == answer["failed"], (case, answer)
            if case.startswith("byte") and answer["failed"] == "":
                continue  # another surface, which is one
            assert "is not a view of a store" in answer["failed"], (case, answer["failed"])
            assert {x[0] for x in self.site.log} <= {"view"}, (case, self.site.log)
        answer = self.look("closed", "", replaced={"view": None})
        assert "plait publish makes this file" in answer["failed"], answer

    def forged_depths(self):
        """Depths that no face can have, or that other levels have: words."""
        view = (self.work / "pruned/view").read_bytes()
        table, packed = struct.unpack_from("<QQ", view, 104)
        content = zlib.decompress(view[120 + table:120 + table + packed])
        levels, = struct.unpack_from("<I", view, 12)
        faces, = struct.unpack_from("<Q", view, 48)
        begin = len(content) - (levels + 1) * faces

        def with_depths(depths, has=1):
            z = zlib.compress(content[:begin] + depths + content[begin + faces:])
            return view[:58] + struct.pack("<H", has) + view[60:112] + struct.pack("<Q", len(z)) + view[120:120 + table] + z + view[-8:]

        right = content[begin:begin + faces]
        assert with_depths(right)[:60] == view[:60] and set(right) == {0, 1, 2, 3}
        cases = {"beyond the levels": with_depths(b"\4" + right[1:]), "beyond 20": with_depths(right[:-1] + b"\25"),
                 "255": with_depths(b"\xff" * faces), "cut": with_depths(right[:-1]), "left out": with_depths(b""),
                 "not said": with_depths(right, has=0), "flag": with_depths(right, has=2)}
        for case, forged in cases.items():
            answer = self.look("pruned", "if (!plait.failed) await settled();", replaced={"view": forged})
            assert answer["errors"] == [] and "is not a view of a store" in answer["failed"], (case, answer)
            assert {x[0] for x in self.site.log} <= {"view"}, (case, self.site.log)
        for case, depths in (("deeper", b"\3" * faces), ("less deep", bytes(min(depth, 2) for depth in right[:-1]) + b"\3")):
            answer = self.look("pruned", "plait.pixelError = 1e-6; plait.redraw(); await until(() => plait.failed);",
                               replaced={"view": with_depths(depths)})
            assert "was changed" in answer["failed"] and answer["errors"] == [], (case, answer)

    def store_changes(self):
        """What is under the page goes, gets shorter, is of another version, or is no numbers."""
        finest = "attribute0.level03.1"
        whole = (self.work / "closed" / finest).read_bytes()
        deeper = """
            await settled();
            await ask("change");
            plait.pixelError = 0.001; document.getElementById("normals").onchange();
            await until(() => plait.failed);
            """
        for changed in (None, whole[:4096], bytes(8) + whole[8:]):
            def change(content=changed):
                self.site.replaced[finest] = content
            # The page has read the file before, so it knows how it was.
            answer = self.look("closed", "plait.pixelError = 0.001; plait.redraw();" + deeper, does={"change": change})
            assert "was changed" in answer["failed"] and answer["words"] == answer["failed"], answer
            assert answer["errors"] == [] or changed is None, answer["errors"]
        self.shown("closed", "plait.pixelError = 0.001; await settled();", replaced={finest: b"\xff" * len(whole)})

    def little_memory(self):
        """What the memory cannot hold makes the allowed error larger, in words, and drawing goes on."""
        answer = self.shown("closed", """
            plait.gpu.free.length = 4;
            plait.gpu.rows = 4;
            plait.pixelError = 0.001;
            plait.redraw();
            await until(() => plait.memoryFull);
            await settled();
            answer.factor = plait.factor; answer.resident = plait.gpu.rowOfPage.filter(row => row >= 0).length;
            """)
        assert answer["factor"] > 1 and answer["resident"] <= 4 and "memory is full" in answer["figures"], answer

    def flight(self):
        """A flight at 60 pictures a second, one of 50 or 150 drawn, in a memory that is too small for the store."""
        self.plait("subdivide", "closed.ply", "deep.plait", "--levels", "6", "--normals")
        self.plait("publish", "deep.plait", "deep", "--page")
        pictures, drawn = (7200, 150) if LONG_FLIGHT else (900, 50)
        answer = self.shown("deep", """
            const pictures = %d, { view, gpu, camera } = plait, resident = () => gpu.rowOfPage.filter(row => row >= 0).length;
            // Twice from nothing, with room for all: what was there before is not taken for there.
            plait.pixelError = 4;
            answer.resident = [];
            for (let k = 0; k < 2; ++k) {
              document.getElementById("normals").onchange();
              await settled();
              answer.resident.push(resident());
            }
            plait.animate = true;
            plait.pixelError = 0.1;
            let mostPages = 0, mostRequests = 0, stray = 0, heap = 0;
            for (let k = 0; k < pictures; ++k) {
              const t = k / 60;
              camera.azimuth = 50 * t; camera.elevation = 40 * Math.sin(t / 3);
              camera.distance = view.radius * (0.05 + 1.2 * (1 + Math.cos(t)));
              camera.target = [0, 1, 2].map(axis => 0.5 * view.radius * Math.sin(t / 2 + 2 * axis));
              plait.select(plait.cameraNow(), 1000 * t);
              for (const flight of plait.inFlight)
                if (!flight.abort.signal.aborted && flight.pages.every(page => gpu.seen[page] !== plait.frames)) ++stray;
              mostPages = Math.max(mostPages, resident());
              mostRequests = Math.max(mostRequests, plait.inFlight.size);
              if (k %% %d === 0) plait.draw(plait.cameraNow());
              if (k %% 5 === 0) await new Promise(done => setTimeout(done));
              if (k === pictures >> 2) { gc(); heap = performance.memory.usedJSHeapSize; }
            }
            await settled();
            gc();
            Object.assign(answer, { mostPages, mostRequests, stray, rows: gpu.rows, pages: gpu.pageCount, card: gpu.bytes,
              grown: performance.memory.usedJSHeapSize - heap });
            """ % (pictures, drawn), "?memory=4", size=(640, 480))
        assert answer["pages"] > answer["rows"] == 102, answer["rows"]
        assert answer["resident"][0] == answer["resident"][1] and 0 < answer["resident"][0] <= 30, answer["resident"]
        assert answer["rows"] * 0.9 < answer["mostPages"] <= answer["rows"], answer["mostPages"]
        assert answer["mostRequests"] <= 6 and answer["stray"] == 0, (answer["mostRequests"], answer["stray"])
        assert answer["card"] < 5 << 20 and answer["grown"] < 8 << 20, (answer["card"], answer["grown"])
        saw = collections.Counter(x for x in self.site.log if x[0] != "index.html")
        planned, read = (collections.Counter(map(tuple, answer[name])) for name in ("planned", "log"))
        assert saw <= planned and read <= saw, "requests"  # some were aborted before the server saw them
        print(f"viewer_test: {pictures} pictures, {sum(planned.values())} requests planned, {sum(read.values())} read whole")


if BROWSER is None:
    print("viewer_test: skipped, because chromium is not installed (tools/dev/install_packages.sh pages)")
    sys.exit(77)
with tempfile.TemporaryDirectory() as folder:
    if PICTURES:
        os.makedirs(PICTURES, exist_ok=True)
    Test(folder).run()
