"""The live page, the report and the lobe viewer in a real browser.

    tests/browser/pages_in_chromium.py TRESS LABORATORY CHROMIUM SCENE FOLDER    # screenshots are left in FOLDER
"""
import json
import os
import shutil
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from chromium import Page  # noqa: E402

tress, laboratory, chromium, scene, folder = sys.argv[1:6]
shutil.rmtree(folder, ignore_errors=True)  # a cache of an earlier run would leave nothing to learn
os.makedirs(folder)


def at(name):
    return os.path.join(folder, name)


def check(holds, what):
    if not holds:
        raise AssertionError(what)
    print("ok:", what, flush=True)


# The sum of what the canvas shows.
LIGHT = """(() => { const c = document.getElementById('picture'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
  let sum = 0; for (let i = 0; i < d.length; i += 4) sum += d[i] + d[i + 1] + d[i + 2]; return sum; })()"""
SET = "(id, x, event) => { const e = document.getElementById(id); e.value = x; e.dispatchEvent(new Event(event)); }"


# Clicks the middle of the rectangle of a node that has converged.
NODE = """(() => { const i = slices.findIndex((s) => s.states.includes('c')), s = slices[i], node = s.states.indexOf('c');
  const map = document.querySelectorAll('#maps .map')[i]; map.scrollIntoView({block: 'center'}); const b = map.getBoundingClientRect();
  const high = s.b.length, x = Math.floor(node / high), y = high - 1 - node % high;
  return [b.left + (x + 0.5) / s.a.length * b.width, b.top + (y + 0.5) / high * b.height]; })()"""


def served(*options, layers="TT,TRT"):
    """A render that goes on until it is stopped, and the address of its page."""
    render = subprocess.Popen([tress, "render", scene, "-o", at("live.exr"), "--spp", "1000000", "--resolution", "64x64",
                               "--threads", "1", "--layers", layers, "--serve", *options], stderr=subprocess.PIPE, text=True)
    return render, next(line.split()[-1] for line in render.stderr if "live page: " in line)


def click_row(page):
    """The words about a converged row that is clicked."""
    page.until("slices.some((slice) => slice.states.includes('c'))")
    box = page.value(NODE)
    for kind in ("mousePressed", "mouseReleased"):
        page.call("Input.dispatchMouseEvent", type=kind, x=box[0], y=box[1], button="left", clickCount=1)
    page.until("document.getElementById('row-words').textContent.includes('converged')")
    return page.value("document.getElementById('row-words').textContent")


def edit_ramp(page):
    """The color is made a ramp, which mouse and keys change, each time with another picture, and one color again."""
    stops = "JSON.stringify(look.color.ramp.map(([place]) => place))"

    def seen():
        page.until("look.sent === 0 && !look.waits && passes.length >= 2")

    def press(key):
        for kind in ("keyDown", "keyUp"):
            page.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode={"Delete": 46}.get(key, 39))

    def mouse(kind, x, y):
        page.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)

    page.value("document.querySelector('#color button').click()")
    seen()
    check(page.value("look.moved.melanin === undefined && " + stops) == "[0,1]", "a color becomes a ramp of two stops, and melanin gives way")
    light = page.value(LIGHT)
    page.value("""(() => { const picker = document.querySelector('#color input[aria-label="color of stop 2"]');
      picker.value = '#ff4000'; picker.dispatchEvent(new Event('input')); })()""")
    seen()
    check(page.value(LIGHT) != light and page.value("look.color.ramp[1][1].join()") == "0.999,0.0513,0.001", "its tip gets a color, linear")
    left, top, width, height = page.value("""(() => { const strip = document.querySelector('.strip'); strip.scrollIntoView({block: 'center'});
      const b = strip.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()""")
    for kind in ("mousePressed", "mouseReleased"):
        mouse(kind, left + 0.5 * width, top + 6)
    seen()
    check(abs(page.value("look.color.ramp[1][0]") - 0.5) < 0.01 and page.value("look.color.ramp.length") == 3, "a click on the strip adds a stop")
    at = left + width * page.value("look.color.ramp[1][0]")
    mouse("mousePressed", at, top + 24)
    mouse("mouseMoved", left + 0.75 * width, top + 24)
    mouse("mouseReleased", left + 0.75 * width, top + 24)
    seen()
    check(abs(page.value("look.color.ramp[1][0]") - 0.75) < 0.01 and page.value("look.color.ramp.length") == 3, "a stop is dragged")
    before = page.value("look.color.ramp[1][0]")
    press("ArrowRight")
    seen()
    check(abs(page.value("look.color.ramp[1][0]") - before - 0.01) < 1e-6, "an arrow moves the stop that has the focus")
    check("--color '{\"ramp\":[[0," in page.value("document.getElementById('look').textContent"), "the ramp is shown as an option")
    page.picture(os.path.join(folder, "live_ramp.png"))
    press("Delete")
    seen()
    check(page.value(stops) == "[0,1]", "Delete removes it")
    page.value("document.querySelector('#color button').click()")
    seen()
    check(page.value("Array.isArray(look.color) && document.querySelector('.strip').hidden"), "and it is one color again")


def live_page_of_samples():
    """Of the default model: a map of its directions, whose rows are clicked."""
    render, address = served()
    page = Page(chromium, 1300, 1500)
    try:
        page.open(address)
        page.until("document.querySelectorAll('#maps .map').length >= 1 && passes.length >= 3")
        words = click_row(page)
        check("rough" in words, f"a clicked row of samples is described: {words}")
        about = page.value("document.getElementById('about').textContent")
        check("epsilon 0.07" in about, f"rows of samples have an epsilon of their own: {about}")
        page.picture(at("live_samples.png"))
        check(page.errors == [], f"no script fails: {page.errors}")
    finally:
        page.close()
        render.kill()
        render.wait()


def live_page():
    render, address = served("--model", "elliptical")
    page = None
    try:
        page = Page(chromium, 1300, 1500)
        page.open(address)
        page.until("Number(document.getElementById('picture')?.dataset.version) >= 1")
        check(page.value(LIGHT) > 0, "the picture arrives")
        first = page.value("document.getElementById('picture').dataset.version")
        page.until(f"Number(document.getElementById('picture').dataset.version) > {first}")
        check(True, "the picture changes")
        page.until("document.querySelectorAll('#maps .map').length >= 3 && passes.length >= 5")
        check(page.value("document.querySelectorAll('#charts canvas').length") == 6, "six charts")
        before = page.value(LIGHT)
        page.value(f"({SET})('exposure', 2, 'input')")
        check(page.value(LIGHT) > 1.2 * before, "the exposure makes it brighter")
        page.value(f"({SET})('exposure', 0, 'input')")
        check(page.value("document.getElementById('view').value") == "standard", "colors are shown by the scene's view")
        page.value(f"({SET})('view', 'agx', 'change')")
        check(page.value(LIGHT) != before, "or by another")
        page.value(f"({SET})('view', 'standard', 'change')")
        page.value(f"({SET})('layer', 'TRT', 'change')")
        page.until("shown.latest.layer === 'TRT'")
        page.value(f"({SET})('layer', 'beauty', 'change')")
        click_row(page)
        page.until("document.querySelectorAll('#row-charts canvas').length === 4")
        words = page.value("document.getElementById('row-words').textContent")
        check("converged" in words and "components" in words, f"a clicked row is shown: {words}")
        check(page.value("document.querySelectorAll('#sliders input').length") == 5, "five sliders")
        version, light = page.value("shown.latest.version"), page.value(LIGHT)
        page.value(f"({SET})('slider-melanin', 0, 'input')")
        page.value(f"({SET})('slider-lights', 3, 'input')")
        page.until("look.sent === 0 && !look.waits && Object.keys(look.moved).length === 2 && passes.length >= 4")
        check(page.value("shown.latest.version") > version and page.value(LIGHT) > 1.3 * light, "sliders make another picture")
        words = page.value("document.getElementById('look').textContent")
        check("--melanin 0 --light-scale 3" in words, f"and name what they are as options: {words[-90:]}")
        edit_ramp(page)
        page.until("document.querySelectorAll('#maps .map').length >= 3 && passes.length >= 8")
        check(page.value("duration(42) + ', ' + duration(78000)") == "42 s, 22 h", "time that is left is shown in units that are read at once")
        beside = page.value("(() => { const p = document.getElementById('picture').getBoundingClientRect(), s = document.getElementById('look').getBoundingClientRect(); return s.left >= p.right && s.top < p.bottom; })()")
        check(beside, "where there is room, the sliders are beside the picture")
        page.value("document.getElementById('pause').click()")
        page.until("document.getElementById('state').textContent.startsWith('paused')")
        count = page.value("passes.length")
        page.value("new Promise((done) => setTimeout(done, 2500))")
        check(page.value("passes.length") <= count + 1, "a paused render does not go on")
        page.value("window.scrollTo(0, 0)")
        page.picture(at("live_wide.png"))
        page.size(390, 1400)
        page.picture(at("live_narrow.png"))
        check(page.value("document.getElementById('picture').getBoundingClientRect().right") <= 390, "a picture that is to fit is seen whole")
        page.until("document.documentElement.scrollWidth <= 390", 10)
        check(True, "a narrow page does not scroll sideways")
        page.value("document.getElementById('save').click()")
        page.until("document.getElementById('said').textContent === 'saved'")
        check(os.path.getsize(at("live.exr")) > 1000, "saved while paused")
        page.value("document.getElementById('stop').click()")
        render.stderr.read()
        check(render.wait(60) == 0, "the page stops the render")
        check(page.errors == [], f"no script fails: {page.errors}")
        check(all(url.startswith((address, "data:", "about:")) for url in page.addresses), "nobody else is asked")
    finally:
        if page:
            page.close()
        if render.poll() is None:
            render.kill()
            render.wait()


LOOK = {"roughness": 0.25, "eccentricity": 0.7, "tilt": 1, "lights": 2}
RAMP = {"ramp": [[0, [0.05, 0.03, 0.02]], [1, [0.7, 0.4, 0.2]]], "interpolation": "smooth"}
OPTIONS = ["--roughness", "0.25", "--eccentricity", "0.7", "--cuticle-tilt", "1", "--light-scale", "2"]


def asked(address, path, words=None):
    """The answer of a render's page; a refusal is an answer."""
    request = urllib.request.Request(address + path, words and json.dumps(words).encode(), {"Content-Type": "application/json"})
    try:
        return json.load(urllib.request.urlopen(request))
    except urllib.error.HTTPError as refused:
        return json.load(refused)


def looks():
    """A picture whose look was changed is bit for bit the one that is rendered with it: without rows, and from a frozen cache."""
    small = ["--spp", "3", "--resolution", "48x48", "--quiet"]
    subprocess.run([tress, "render", scene, "-o", at("make.exr"), "--warm-cache", at("look.cache"), *small, *OPTIONS], check=True)
    for name, words, look, color in (
            ("exact", ["--model", "exact"], {"values": LOOK | {"melanin": 5}}, ["--melanin", "5"]),
            ("frozen", ["--warm-cache", at("look.cache"), "--cache-mode", "frozen"], {"values": LOOK, "color": RAMP},
             ["--color", json.dumps(RAMP)])):
        subprocess.run([tress, "render", scene, "-o", at(name + "_fresh.exr"), *small, *OPTIONS, *color, *words], check=True)
        render = subprocess.Popen([tress, "render", scene, "-o", at(name + ".exr"), *[w for w in small if w != "--quiet"], "--serve", *words],
                                  stderr=subprocess.PIPE, text=True)
        try:
            address = next(line.split()[-1] for line in render.stderr if "live page: " in line)
            asked(address, "control", {"do": "pause"})  # before the first pass
            threading.Thread(target=render.stderr.read, daemon=True).start()
            while not asked(address, "status?since=0")["passes"]:
                time.sleep(0.02)
            refused = asked(address, "control", {"do": "look", "values": {"melanin": 1e9}})
            check("melanin: expected 0..8" in refused["error"], f"refused by name: {refused['error']}")
            refused = asked(address, "control", {"do": "look", "values": {}, "color": {"ramp": [[2, [0.5, 0.5, 0.5]]]}})
            check("--color/ramp/0/0: expected" in refused["error"], f"so is a color: {refused['error']}")
            asked(address, "control", {"do": "look", **look})
            check(render.wait(120) == 0, "the render ends with its samples")
        finally:
            if render.poll() is None:
                render.kill()
                render.wait()
        found = json.loads(subprocess.run([tress, "diff", "--json", at(name + "_fresh.exr"), at(name + ".exr")], capture_output=True, check=True).stdout)
        check(found["identical"], f"{name}: the picture is that of a fresh render: {found}")


def samples_of(address, which):
    """Samples a pixel of a picture that the page shows."""
    layer = urllib.request.urlopen(f"{address}picture?which={which}&layer=samples").read()
    return max(memoryview(layer).cast("f"))


def no_picture_is_old():
    """What is paused, and the look before a change, are shown as they are. Copies of all layers take so long that the page is otherwise passes behind."""
    render, address = served("--model", "elliptical", layers="all")
    address = address.rstrip("/") + "/"

    def rendered():
        passes = asked(address, "status?since=0")["passes"]
        return passes[-1]["samples"] / passes[-1]["image_pixels"] if passes else 0

    def until(holds):
        for _ in range(3000):
            if holds():
                return
            time.sleep(0.02)
        raise TimeoutError

    try:
        threading.Thread(target=render.stderr.read, daemon=True).start()
        until(lambda: rendered() >= 20)
        asked(address, "control", {"do": "pause"})
        until(lambda: asked(address, "status?since=0")["paused"] and samples_of(address, "") == rendered())
        check(True, f"a paused picture has all of its {rendered():g} samples")
        asked(address, "control", {"do": "resume"})
        paused = rendered()
        until(lambda: rendered() >= 2 * paused)
        at_least = rendered()
        asked(address, "control", {"do": "look", "values": {"melanin": 0.3}})
        until(lambda: asked(address, "status?since=0")["look"] == 1)
        check(samples_of(address, "look") >= at_least, f"the look before has all of its samples, {at_least:g} or more")
    finally:
        render.kill()
        render.wait()


def report():
    """Of a run whose rows cannot pass, so that some are left to list, and of one that they serve."""
    for name in ("cold", "warm"):
        subprocess.run([tress, "render", scene, "-o", at(name + ".exr"), "--spp", "4", "--resolution", "48x48", "--quiet",
                        "--model", "rough", "--epsilon", "0.005", "--warm-cache", at("r.cache"),
                        "--telemetry", at(name + ".jsonl"), "--telemetry-level", "rows"], check=True)
    subprocess.run([tress, "report", at("cold.jsonl"), at("warm.jsonl"), "-o", at("report.html"), "--quiet"], check=True)
    page = Page(chromium, 1300, 1600)
    try:
        page.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)
        page.open("file://" + os.path.realpath(at("report.html")))
        page.until("document.querySelectorAll('main table').length >= 2")
        check(page.value("document.querySelectorAll('.chart canvas').length") == 9, "nine charts, offline")
        check(page.value("""[...document.querySelectorAll('.chart canvas')].every((c) => c.getContext('2d').getImageData(0, 0, c.width, c.height)
          .data.some((x) => x > 0))"""), "every chart is drawn")
        check("of rough, chi-square" in page.value("document.body.textContent"), "what the error of a row of samples is")
        check("light of all" in page.value("document.body.textContent"), "rows that have not converged, by their light")
        check(page.errors == [], f"no script fails: {page.errors}")
        check(all(url.startswith(("file:", "data:", "about:")) for url in page.addresses), "nobody is asked")
        page.picture(at("report.png"))
    finally:
        page.close()


def lobes():
    subprocess.run([laboratory, "lobes", "-o", at("lobes.html"), "--e", "0.75", "--sigma-a", "0.1,0.2,0.4", "--paths", "40000",
                    "--bins", "18x18", "--quiet"], check=True)
    page = Page(chromium, 1300, 1600)
    try:
        page.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)
        page.open("file://" + os.path.realpath(at("lobes.html")))
        page.until("document.querySelectorAll('#rows .chart canvas').length > 0")
        models = page.value("lobes.far_fields.length")
        check(page.value("document.querySelectorAll('.maps canvas').length") == 5 * models >= 45, "a map of each lobe and model")
        check(page.value("""[...document.querySelectorAll('.maps td[data-lobe=whole] canvas')].every((c) => {
          const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; return new Set(d).size > 20; })"""), "with light in it")
        check(page.value("document.querySelectorAll('#slices canvas').length") == 3, "a slice, polar and Cartesian")
        check(page.value("""(() => { const chart = document.querySelector('#slices .chart canvas').chart, field = lobes.far_fields[2], size = (Math.PI / 18) * (2 * Math.PI / 18);
          return chart.data.datasets[2].data.every(({y}, j) => Math.abs(y * size - field.lobes.whole.flux[0][chosen.theta][j]) <= 1e-12); })()"""),
              "which has the numbers of the far field")
        title = page.value("document.getElementById('slice-title').textContent")
        box = page.value("""(() => { const b = document.querySelector('td[data-model=rough][data-lobe=TRT] canvas').getBoundingClientRect();
          return [b.left + 0.7 * b.width, b.top + 0.3 * b.height]; })()""")
        for kind in ("mousePressed", "mouseReleased"):
            page.call("Input.dispatchMouseEvent", type=kind, x=box[0], y=box[1], button="left", clickCount=1)
        clicked = page.value("document.getElementById('slice-title').textContent")
        check(clicked != title and clicked.startswith("TRT"), f"a click on a map chooses: {clicked}")
        page.value(f"({SET})('channel', 2, 'change')")
        check(page.value("document.querySelector('td[data-model=fiber3d][data-lobe=TT] small').textContent.includes(short(lobes.far_fields[0].lobes.TT.energy[2], 4))"),
              "the energy of the blue channel")
        check(page.value("document.querySelectorAll('#rows .chart canvas').length") == 3 * 15, "15 rows: curves, error, components")
        check(page.value("document.documentElement.scrollWidth <= 1300"), "wide")
        page.picture(at("lobes_wide.png"))
        page.size(390, 1400)
        page.until("document.documentElement.scrollWidth <= 390", 10)
        check(True, "a narrow page does not scroll sideways")
        page.picture(at("lobes_narrow.png"))
        check(page.errors == [], f"no script fails: {page.errors}")
        check(all(url.startswith(("file:", "data:", "about:")) for url in page.addresses), "nobody is asked")
    finally:
        page.close()


looks()
no_picture_is_old()
report()
lobes()
live_page()
live_page_of_samples()
