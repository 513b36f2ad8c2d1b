"""The screenshots of src/live/README.md, a minute or two of CPU. Of the lobe viewer three models of nine are kept in the picture.

    tests/browser/screenshots.py TRESS CHROMIUM SCENE FOLDER
"""
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from chromium import Page  # noqa: E402

tress, laboratory, chromium, scene, folder = sys.argv[1:6]
os.makedirs(folder, exist_ok=True)
work = tempfile.TemporaryDirectory(prefix="tress_screenshots_")
SET = "(id, x, event) => { const e = document.getElementById(id); e.value = x; e.dispatchEvent(new Event(event)); }"


def at(name):
    return os.path.join(work.name, name)


def keep(page, name, height, scale=1):
    """The page from its top."""
    file = os.path.join(folder, name)
    page.picture(file, (0, 0, page.value("window.innerWidth"), height), scale)
    size = os.path.getsize(file)
    print(f"{file}: {size} bytes", flush=True)
    if size > 200000:
        raise AssertionError("a screenshot in the repository has at most 200,000 bytes")


def live():
    render = subprocess.Popen([tress, "render", scene, "-o", at("hair.exr"), "--spp", "100000", "--resolution", "270x360",
                               "--layers", "TT,TRT", "--serve"], stderr=subprocess.PIPE, text=True)
    page = None
    try:
        address = next(line.split()[-1] for line in render.stderr if "live page: " in line)
        page = Page(chromium, 1100, 1000)
        page.open(address)
        page.until("document.getElementById('picture')?.dataset.version >= 1 && passes.length >= 12", 300)
        page.value(f"({SET})('zoom', 1, 'change')")
        page.value(f"({SET})('slider-melanin', 0.3, 'input')")
        page.until("look.sent === 0 && passes.length >= 48", 300)
        page.value(f"({SET})('beside', 'look', 'change')")
        page.until("shown.look && slices.length && shown.latest.version >= 8", 300)
        page.value("document.getElementById('pause').click()")
        page.until("document.getElementById('state').textContent.startsWith('paused')", 300)
        keep(page, "live_wide.png", 1000, 0.75)
        page.size(390, 1000)
        page.until("document.documentElement.scrollWidth <= 390", 10)
        keep(page, "live_narrow.png", 1000, 0.75)
        page.value("document.getElementById('stop').click()")
        render.stderr.read()
        render.wait(60)
    finally:
        if page:
            page.close()
        if render.poll() is None:
            render.kill()
            render.wait()


def opened(file, width, ready):
    page = Page(chromium, width, 1000)
    page.open("file://" + os.path.realpath(file))
    page.until(ready)
    return page


def report():
    for name in ("cold", "warm"):
        subprocess.run([tress, "render", scene, "-o", at(name + ".exr"), "--spp", "16", "--resolution", "128x128", "--quiet",
                        "--telemetry", at(name + ".jsonl"), "--telemetry-level", "rows", "--warm-cache", at("r.cache")], check=True)
    subprocess.run([tress, "report", at("cold.jsonl"), at("warm.jsonl"), "-o", at("report.html"), "--quiet"], check=True)
    page = opened(at("report.html"), 1100, "document.querySelectorAll('.chart canvas').length === 7")
    try:
        keep(page, "report.png", 1300, 0.7)
    finally:
        page.close()


def lobes():
    subprocess.run([laboratory, "lobes", "-o", at("lobes.html"), "--e", "0.75", "--quiet"], check=True)
    page = opened(at("lobes.html"), 1100, "document.querySelectorAll('#rows .chart canvas').length > 0")
    try:
        page.value("document.querySelectorAll('.maps tr').forEach((row, i) => { if (i > 3) row.remove(); })")
        keep(page, "lobes.png", page.value("Math.ceil(document.getElementById('rows').getBoundingClientRect().top)"), 0.7)
    finally:
        page.close()


lobes()
report()
live()
