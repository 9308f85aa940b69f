#!/usr/bin/env python3
"""The page of `plait publish --page` and `plait serve` in headless Chromium, which draws in software.

  viewer_test.py PROGRAM [PICTURES]

  PROGRAM    plait
  PICTURES   a folder that keeps what the page drew, to look at

Skips (77) where there is no Chromium. PLAIT_CHROMIUM names another browser.
"""
import base64
import http.server
import json
import os
import pathlib
import queue
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading

PROGRAM = sys.argv[1]
BROWSER = os.environ.get("PLAIT_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
# What each test page runs after the page's own script: it may call these, and ends with report().
PRELUDE = """
<script>
window.errors = [];
addEventListener("error", event => errors.push(String(event.message)));
addEventListener("unhandledrejection", event => errors.push(String(event.reason)));
const complain = console.error; console.error = (...words) => { errors.push(words.join(" ")); complain(...words); };
const report = answer => fetch("/report", { method: "POST", body: JSON.stringify(answer) });
const until = test => new Promise(done => { const look = () => test() ? done() : setTimeout(look, 20); look(); });
</script>
"""
SCRIPT = """
<script>
(async () => {
  try {
    await until(() => plait.ready || plait.failed);
    const settled = async () => { plait.settled = false; plait.redraw(); await until(() => plait.settled || plait.failed); };
    const pixels = () => { const gl = plait.gl, w = plait.canvas.width, h = plait.canvas.height, all = new Uint8Array(4 * w * h);
      gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all); return all; };
    let seed = 1; const random = () => (seed = (Math.imul(seed, 1103515245) + 12345) >>> 0) / 2 ** 32;
    const answer = { renderer: plait.renderer };
    %s
    Object.assign(answer, { failed: plait.failed, errors, words: document.getElementById("words").textContent, log: plait.log,
      requests: plait.requests, bytes: plait.bytes, figures: document.getElementById("figures").textContent });
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
        self.script, self.log, self.reports, self.ignore_ranges, self.broken = "", [], queue.Queue(), False, 0
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def handle_error(self, *_):
        """The browser may end in the middle of an answer."""

    def url(self):
        return f"http://127.0.0.1:{self.server_address[1]}/"


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
        self.answer(200, b"")
        self.server.reports.put(json.loads(body))

    def do_GET(self):
        site, path = self.server, self.path.split("?")[0].lstrip("/")
        if path.endswith("test.html"):
            page = (site.folder / path.replace("test.html", "index.html")).read_text()
            page = page.replace("<body>", "<body>" + PRELUDE).replace("</body>", SCRIPT % site.script + "</body>")
            return self.answer(200, page.encode(), [("Content-Type", "text/html; charset=utf-8")])
        file = site.folder / path
        if not file.is_file():
            return self.answer(404, b"")
        content = file.read_bytes()
        wanted = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        if wanted and site.broken > 0:
            site.broken -= 1
            return self.answer(503, b"")
        if not wanted or site.ignore_ranges:
            site.log.append((file.name, 0, len(content)))
            return self.answer(200, content)
        first, last = int(wanted[1]), int(wanted[2])
        part = content[first:last + 1]
        site.log.append((file.name, first, len(part)))
        self.answer(206, part, [("Content-Range", f"bytes {first}-{first + len(part) - 1}/{len(content)}")])


class Test:
    def __init__(self, work, pictures):
        self.work, self.pictures, self.site = pathlib.Path(work), pictures, Site(work)

    def plait(self, *words):
        return json.loads(subprocess.run([PROGRAM, *map(str, words), "--json"], cwd=self.work, check=True,
                                         stdout=subprocess.PIPE).stdout)

    def look(self, store, script, query="", size=(640, 480), page="test.html"):
        """What the page reports after `script`, which runs in it."""
        self.site.script, self.site.log = script, []
        with tempfile.TemporaryDirectory() as profile:
            browser = subprocess.Popen(
                [BROWSER, "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                 "--no-first-run", "--disable-extensions", "--disable-background-networking", "--disable-component-update",
                 "--disable-background-timer-throttling", f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}",
                 "--force-device-scale-factor=1", "--hide-scrollbars", f"{self.site.url()}{store}/{page}{query}"],
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
            try:
                answer = self.site.reports.get(timeout=240)
            finally:
                os.killpg(browser.pid, signal.SIGKILL)
                browser.wait()
        assert "broken" not in answer, answer
        assert "SwiftShader" in answer["renderer"], f"expected drawing in software, found {answer['renderer']}"
        if "picture" in answer and self.pictures:
            pathlib.Path(self.pictures, f"{store}.png").write_bytes(base64.b64decode(answer["picture"].split(",")[1]))
        return answer

    def run(self):
        self.plait("generate", "molecule", "closed.ply", "--vertices", "400", "--seed", "1")
        self.plait("subdivide", "closed.ply", "closed.plait", "--levels", "3", "--normals")
        published = self.plait("publish", "closed.plait", "closed", "--page")
        for test in (self.first_picture, self.beside_render, self.no_cracks, self.compressed_from_serve, self.ranges_ignored,
                     self.server_comes_back, self.little_memory):
            test(published)
            print(f"viewer_test: {test.__name__} passed", flush=True)

    def first_picture(self, published):
        answer = self.look("closed", """
            plait.animate = false;
            await settled();
            const all = pixels(), colours = new Set();
            for (let i = 0; i < all.length; i += 4) colours.add(all[i] << 16 | all[i + 1] << 8 | all[i + 2]);
            answer.colours = colours.size;
            answer.picture = plait.canvas.toDataURL();
            answer.pick = await plait.pickAt(plait.canvas.width >> 1, plait.canvas.height >> 1);
            """)
        assert answer["failed"] == "" and answer["errors"] == [], answer
        assert answer["colours"] > 200, f"expected a shaded picture, found {answer['colours']} colours"
        # What the server saw is what the page says that it read.
        assert sorted(map(tuple, answer["log"])) == sorted(x for x in self.site.log if x[0] != "index.html"), "requests"
        assert answer["bytes"] == sum(x[2] for x in answer["log"])
        first = answer["log"][0]
        assert first == ["view", 0, published["view_bytes"]], first
        pick = answer["pick"]
        assert pick is not None and len(pick["position"]) == 3 and len(pick["values"]["normal"]) == 3, pick
        print(f"viewer_test: {answer['figures']!r}")

    def no_cracks(self, _):
        answer = self.look("closed", """
            plait.animate = false;
            const view = plait.view, F = view.F, c = plait.camera;
            plait.forced = new Uint8Array(F).fill(view.levels);
            plait.fitView();
            await settled();
            plait.clear = [1, 0, 1];
            document.getElementById("normals").value = "stored";
            answer.found = []; answer.last = 0; answer.magenta = 0; answer.views = 0; answer.other = 0;
            for (let v = 0; v < 30; ++v) {
              for (let f = 0; f < F; ++f) plait.forced[f] = Math.floor(random() * (view.levels + 1));
              // Inside: just behind a face, looking anywhere.
              const f = Math.floor(random() * F), toward = plait.cameraNow().viewMatrix;
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
              const all = pixels();
              for (let i = 0; i < all.length; i += 4)
                if (all[i] === 255 && all[i + 1] === 0 && all[i + 2] === 255) ++answer.magenta; else ++answer.other;
              ++answer.views;
              if (answer.magenta > answer.last) answer.found.push([v, answer.magenta - answer.last]);
              if (answer.magenta && !answer.picture) answer.picture = plait.canvas.toDataURL();
              answer.last = answer.magenta;
            }
            """, size=(400, 300))
        assert answer["failed"] == "" and answer["errors"] == [], answer
        assert answer["other"] > 0 and answer["views"] == 30
        print(f"viewer_test: {answer['magenta']} magenta of {answer['magenta'] + answer['other']} pixels in {answer['views']} views")
        assert answer["magenta"] == 0, answer["found"]

    def beside_render(self, _):
        """The same camera, size and lights as plait render."""
        self.plait("generate", "icosphere", "ball.ply", "--vertices", "2562")
        self.plait("subdivide", "ball.ply", "ball.plait", "--levels", "2", "--normals")
        self.plait("publish", "ball.plait", "ball", "--page")
        self.plait("render", "ball.plait", "ball/render.png", "--size", "360x280")
        answer = self.look("ball", """
            plait.animate = false;
            plait.setDark(false);
            plait.pixelError = 0.01;
            Object.assign(plait.canvas.style, { width: "360px", height: "280px" });
            await settled();
            plait.fitView();
            await settled();
            const image = new Image();
            image.src = "render.png";
            await image.decode();
            const copy = source => { const to = document.createElement("canvas"); to.width = 360; to.height = 280;
              const context = to.getContext("2d"); context.drawImage(source, 0, 0); return context.getImageData(0, 0, 360, 280).data; };
            const a = copy(image), b = copy(plait.canvas);
            let sum = 0;
            for (let i = 0; i < a.length; ++i) sum += Math.abs(a[i] - b[i]);
            answer.difference = sum / (a.length / 4 * 3);
            answer.picture = plait.canvas.toDataURL();
            """)
        print(f"viewer_test: mean difference from plait render {answer['difference']:.2f} of 255")
        assert answer["failed"] == "" and answer["errors"] == [], answer
        assert answer["difference"] <= 2, answer["difference"]

    def compressed_from_serve(self, _):
        """A compressed store that plait serve decodes, and the page at another server."""
        self.plait("convert", "closed.plait", "small.plait", "--compress", "default")
        server = subprocess.Popen([PROGRAM, "serve", "small.plait", "--port", "0", "--json"], cwd=self.work, text=True,
                                  stdout=subprocess.PIPE)
        text = ""
        while not text.endswith("}\n"):
            text += server.stdout.readline()
        try:
            answer = self.look("closed", "plait.animate = false; plait.pixelError = 0.2; await settled();",
                               f"?store={json.loads(text)['address']}")
        finally:
            server.send_signal(signal.SIGINT)
            assert server.wait(timeout=60) == 0
        assert answer["failed"] == "" and answer["errors"] == [] and answer["requests"] > 3, answer
        assert self.site.log == [], self.site.log  # all records came from plait serve

    def little_memory(self, _):
        """What the memory cannot hold makes the allowed error larger, in words, and drawing goes on."""
        answer = self.look("closed", """
            plait.animate = false;
            plait.gpu.free.length = 4;
            plait.gpu.rows = 4;
            plait.pixelError = 0.001;
            plait.redraw();
            await until(() => plait.memoryFull);
            await settled();
            answer.factor = plait.factor; answer.resident = plait.gpu.rowOfPage.filter(row => row >= 0).length;
            """)
        assert answer["failed"] == "" and answer["errors"] == [], answer
        assert answer["factor"] > 1 and answer["resident"] <= 4 and "memory is full" in answer["figures"], answer

    def ranges_ignored(self, _):
        self.site.ignore_ranges = True
        answer = self.look("closed", "plait.pixelError = 0.01; plait.redraw(); await until(() => plait.failed);")
        self.site.ignore_ranges = False
        assert "does not know ranges" in answer["failed"] and answer["words"] == answer["failed"], answer

    def server_comes_back(self, _):
        self.site.broken = 3
        answer = self.look("closed", "plait.animate = false; await settled();")
        assert self.site.broken == 0 and answer["failed"] == "" and answer["words"] == "", answer


if BROWSER is None:
    print("viewer_test: skipped, because chromium is not installed (tools/dev/install_packages.sh pages)")
    sys.exit(77)
with tempfile.TemporaryDirectory() as work:
    kept = sys.argv[2] if len(sys.argv) > 2 else None
    if kept:
        os.makedirs(kept, exist_ok=True)
    Test(work, kept).run()
