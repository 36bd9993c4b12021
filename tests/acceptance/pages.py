"""Reads pages: their figures, lines, marks and pictures, and what a browser makes of them."""
import base64
import html
import http.server
import json
import os
import pathlib
import re
import shutil
import subprocess
import threading
import zlib

SVG, HTML = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xhtml}"
CHROMIUM = shutil.which("chromium")


def figures(root):
    """By their captions."""
    return {f.find(HTML + "figcaption").text: f for f in root.iter(HTML + "figure")}


def group(figure, series):
    return next(g for g in figure.iter(SVG + "g") if g.get("data-series") == series)


def marks(figure, series):
    return [(float(c.get("data-x")), float(c.get("data-y"))) for c in group(figure, series) if c.get("data-x")]


def line(figure, series):
    path = next(p for p in group(figure, series) if p.get("data-points"))
    return [tuple(map(float, p.split(","))) for p in path.get("data-points").split()]


def axis_titles(figure):
    labels = {text.get("class"): text.text for text in figure.iter(SVG + "text")}
    return labels["label mid"], labels["label"]


def embedded(root):
    """The command's JSON, which scripts read from the page."""
    return json.loads(next(s.text for s in root.iter(HTML + "script") if s.get("id") == "report"))


def bar_cells(root, table=None):
    """Values and texts of the table cells with a bar."""
    return [(float(c.get("data-value")), "".join(c.itertext())) for x in root.iter(HTML + "table") if table in (None, x.get("class"))
            for c in x.iter(HTML + "td") if c.get("data-value")]


def text_of(root):
    """The words that a reader sees, without scripts and the style sheet."""
    hidden = {id(x) for name in ("script", "style", "title") for x in root.iter(HTML + name)}
    return " ".join(" ".join(t for x in root.iter() if id(x) not in hidden for t in (x.text or "", x.tail or "")).split())


def close(found, wanted, tolerance=1e-5):
    """Six digits are written."""
    return abs(found - wanted) <= tolerance * abs(wanted) + 1e-15


def decoded(image):
    """Width, height and palette indices of our PNG, row by row from the top."""
    data = base64.b64decode(image.get("href").split(",")[1], validate=True)
    chunks, at = {}, 8
    while at < len(data):
        length = int.from_bytes(data[at:at + 4], "big")
        body = data[at + 4:at + 8 + length]
        assert zlib.crc32(body) == int.from_bytes(data[at + 8 + length:at + 12 + length], "big")
        chunks[body[:4]] = body[4:]
        at += 12 + length
    width, height = (int.from_bytes(chunks[b"IHDR"][i:i + 4], "big") for i in (0, 4))
    rows = zlib.decompress(chunks[b"IDAT"])
    assert len(rows) == height * (width + 1) and len(chunks[b"PLTE"]) == 3 * 256
    return width, height, [rows[r * (width + 1) + 1:(r + 1) * (width + 1)] for r in range(height)]


# Appended to a copy of the page: it writes what was loaded, also in vain, what the page says at the pointer, what keys do, and
# what a checker of accessibility finds, if there is one.
TELL = """<script>addEventListener("load",()=>setTimeout(async()=>{
const write=(id,text)=>{const p=document.createElement("pre");p.id=id;p.textContent=text;document.body.appendChild(p)};
write("requests",performance.getEntriesByType("resource").map(e=>e.name).join(" "));
write("width",document.documentElement.scrollWidth-innerWidth);
const map=document.querySelector("image[data-span]");
if(map){const box=map.getBoundingClientRect();
map.ownerSVGElement.dispatchEvent(new PointerEvent("pointermove",{clientX:box.left+0.503*box.width,clientY:box.top+0.503*box.height}));
write("pointer",map.closest("figure").querySelector("output").textContent)}
const press=(item,...keys)=>keys.forEach(key=>item.dispatchEvent(new KeyboardEvent("keydown",{key,bubbles:true}))),keys={};
const canvas=document.querySelector("canvas"),said=()=>canvas.parentNode.querySelector("output").textContent;
if(canvas){keys.largest=said();press(canvas,"p");keys.previous=said();press(canvas,"n");keys.back=said();
press(canvas,"ArrowLeft");keys.turned=canvas.getAttribute("data-view");press(canvas,"+");keys.closer=canvas.getAttribute("data-view");
press(canvas,"0");keys.reset=canvas.getAttribute("data-view")}
const line=Array.from(document.querySelectorAll("figure [data-points]")).find(l=>l.getBoundingClientRect().width);
if(line){const svg=line.ownerSVGElement,figure=svg.closest("figure"),ticks=()=>Array.from(svg.querySelectorAll(".axes .tick"),t=>t.textContent).join(" ");
press(svg,"ArrowRight","ArrowRight");keys.value=figure.querySelector("output").textContent;keys.point=line.getAttribute("data-points").split(" ")[1];
keys.whole=[line.getAttribute("d"),ticks()];press(svg,"+");keys.zoomed=[line.getAttribute("d"),ticks()];press(svg,"0");keys.again=[line.getAttribute("d"),ticks()];
const key=figure.querySelector(".legend button");if(key){key.click();keys.off=line.closest("[data-series]").style.display;key.click();keys.on=line.closest("[data-series]").style.display}}
write("keys",JSON.stringify(keys));
if(window.axe)write("axe",JSON.stringify((await axe.run(document,{resultTypes:["violations"]})).violations.map(v=>[v.impact,v.id,v.nodes[0].html.slice(0,200)])))
},300))</script>"""


def axe_core():
    """The script of axe-core, which npm installs: of $AXE_CORE, or beside npm's global packages; None without it."""
    places = [os.environ.get("AXE_CORE", ""), "/usr/lib/node_modules/axe-core/axe.min.js", "/usr/local/lib/node_modules/axe-core/axe.min.js"]
    return next((pathlib.Path(p).read_text() for p in places if p and pathlib.Path(p).is_file()), None)


def written(dom, name):
    """What TELL wrote."""
    found = re.search(f'<pre id="{name}">(.*?)</pre>', dom, re.S)
    return found and html.unescape(found[1])


def printed_pages(folder, text, size):
    """Pages on paper of a size that CSS names."""
    file, made = pathlib.Path(folder) / "printed.html", pathlib.Path(folder) / "printed.pdf"
    file.write_text(text.replace("@page{", f"@page{{size:{size};", 1))
    subprocess.run([CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run",
                    f"--user-data-dir={folder}/profile", "--virtual-time-budget=2000", f"--print-to-pdf={made}", file.as_uri()],
                   capture_output=True, timeout=60, stdin=subprocess.DEVNULL)
    return max(int(n) for n in re.findall(rb"/Count (\d+)", made.read_bytes()))


# Before the page's body: when it is painted and loaded, what keeps the main thread for more than 50 ms, and the same while it scrolls.
WATCH = """<script>const tasks=[];new PerformanceObserver(l=>l.getEntries().forEach(e=>tasks.push(e.duration))).observe({type:"longtask",buffered:true});
addEventListener("load",()=>setTimeout(()=>{const loaded=performance.getEntriesByType("navigation")[0].loadEventEnd,opened=tasks.splice(0);let y=0;
function step(){scrollTo(0,y+=80);if(y<document.documentElement.scrollHeight)requestAnimationFrame(step);else setTimeout(()=>
fetch("/",{method:"POST",body:JSON.stringify({loaded,opened,scrolled:tasks})}),300)}requestAnimationFrame(step)},1000))</script>"""


def opened(folder, text):
    """Milliseconds until a page is loaded, and of the tasks above 50 ms while it opens and while it scrolls, in real time; served from
    this machine, as a browser that prints its DOM does not wait."""
    told, done = {}, threading.Event()

    class Server(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            self.wfile.write(text.replace("<main>", WATCH + "<main>", 1).encode() if self.path == "/" else b"")

        def do_POST(self):
            told.update(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.end_headers()
            done.set()

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Server) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = subprocess.Popen([CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", f"--user-data-dir={folder}/profile",
                                    "--remote-debugging-port=0", "--window-size=1280,900", f"http://127.0.0.1:{server.server_port}/"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        done.wait(60)
        browser.terminate()
        browser.wait()
        server.shutdown()
    return told


def shown(folder, text, width=1280, checker=None):
    """The browser's messages, the page's requests, its words at the pointer and its DOM."""
    file = pathlib.Path(folder) / "shown.html"
    more = f"<script>{checker}</script>" if checker else ""
    file.write_text(text.replace("<head>", "<head>" + more, 1).replace("</body>", TELL + "</body>"))
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run",
               f"--user-data-dir={folder}/profile", "--enable-logging=stderr", f"--virtual-time-budget={20000 if checker else 2000}", f"--window-size={width},900",
               "--dump-dom", file.as_uri()]
    made = subprocess.run(command, capture_output=True, timeout=60, stdin=subprocess.DEVNULL)
    dom = made.stdout.decode()
    messages = [line for line in made.stderr.decode(errors="replace").splitlines() if "CONSOLE" in line]
    told = written(dom, "requests")
    sent = None if told is None else [url for url in told.split() if not url.startswith("data:")]
    return messages, sent, written(dom, "pointer"), dom
