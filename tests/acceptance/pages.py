"""Reads pages: their figures, lines, marks and pictures, and what a browser makes of them."""
import base64
import pathlib
import re
import shutil
import subprocess
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


# Appended to a copy of the page: it writes what was loaded, also in vain, and what the page says at the pointer.
TELL = """<script>addEventListener("load",function(){setTimeout(function(){
function write(id,text){var p=document.createElement("pre");p.id=id;p.textContent=text;document.body.appendChild(p)}
write("requests",performance.getEntriesByType("resource").map(function(e){return e.name}).join(" "));
var map=document.querySelector("image[data-span]"),box=map.getBoundingClientRect();
map.ownerSVGElement.dispatchEvent(new PointerEvent("pointermove",{clientX:box.left+0.503*box.width,clientY:box.top+0.503*box.height}));
write("pointer",map.closest("figure").querySelector("output").textContent)},300)})</script>"""


def shown(folder, text):
    """The browser's messages, the page's requests, its words at the pointer and its DOM."""
    file = pathlib.Path(folder) / "shown.html"
    file.write_text(text.replace("</body>", TELL + "</body>"))
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run",
               f"--user-data-dir={folder}/profile", "--enable-logging=stderr", "--virtual-time-budget=2000",
               "--dump-dom", file.as_uri()]
    made = subprocess.run(command, capture_output=True, timeout=60, stdin=subprocess.DEVNULL)
    dom = made.stdout.decode()
    messages = [line for line in made.stderr.decode(errors="replace").splitlines() if "CONSOLE" in line]
    told = re.search('<pre id="requests">(.*?)</pre>', dom, re.S)
    sent = None if told is None else [url for url in told[1].split() if not url.startswith("data:")]
    pointer = re.search('<pre id="pointer">(.*?)</pre>', dom, re.S)
    return messages, sent, pointer and pointer[1], dom
