"""What all charts share: running programs and counting their CPU time, converged references, intervals, JSON, drawing.

A chart is a module bench/charts/NN_name.py (NN its number) with

    TITLE = "..."                          # of the chart
    def measure(run): return {...}         # plain data for JSON, with the settings it was made by
    def draw(data, path): ...              # from that data alone: Chart(...).save(path), which adds .png and .svg
    def references(run): ...               # if it has any: run.reference(...) at the samples that full runs want

and bench/charts/run.py finds it by its number. Everything of one chart is measured in one run on one machine. Two errors
are never mixed: *noise* is against the same model converged (all equal-error times), *model error* is the converged picture
against that of `fiber3d`. Timings are CPU time, ratios of them rather than seconds, of rounds in which the rivals take turns.
"""
import hashlib
import io
import itertools
import json
import os
import platform
import random
import statistics
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "figures"))
import figures  # noqa: E402
import matplotlib  # noqa: E402
import numpy  # noqa: E402
import OpenImageIO  # noqa: E402
import PIL.Image  # noqa: E402

matplotlib.rcParams["svg.hashsalt"] = "tress"  # the same SVG of the same JSON
import matplotlib.pyplot as pyplot  # noqa: E402

ROOT = figures.ROOT
SHARED = os.path.join(os.path.dirname(ROOT), "shared")
reference_chunk = 32  # samples of one picture of a reference
PICTURE_FOLDERS = ("include", "adaptive", "src/fiber", "src/models", "bench/references", "src/scene", "src/geometry",
                   "src/integrate")


# ---- programs -------------------------------------------------------------------------------------------------------

# A small process between, which forks: a child's peak memory is counted from the process that it is forked from, and this one
# has numpy. Writes the wait status, CPU seconds and kilobytes of the child to the file descriptor it is given.
LAUNCHER = """import os, sys
child = os.fork()
if child == 0:
    os.execvp(sys.argv[2], sys.argv[2:])
_, status, usage = os.wait4(child, 0)
os.write(int(sys.argv[1]), f"{status} {usage.ru_utime + usage.ru_stime} {usage.ru_maxrss}".encode())"""


class Done:
    """A program that has ended: its standard output, CPU seconds of all its threads, wall seconds, peak memory."""

    def __init__(self, command, environment=None):
        start = time.monotonic()
        reading, writing = os.pipe()
        done = subprocess.run([sys.executable, "-S", "-E", "-c", LAUNCHER, str(writing), *command], capture_output=True,
                              text=True, pass_fds=[writing], env={**os.environ, **(environment or {})})
        self.wall = time.monotonic() - start
        os.close(writing)
        with os.fdopen(reading) as pipe:
            words = pipe.read().split()
        self.stdout, self.stderr = done.stdout, done.stderr
        code = os.waitstatus_to_exitcode(int(words[0])) if words else done.returncode
        if code != 0 or not words:
            raise RuntimeError(f"{' '.join(command)}\nexit {code}\n{self.stderr}")
        self.cpu, self.peak_bytes = float(words[1]), int(words[2]) * 1024


class Rendered(Done):
    """A render: its picture and what its telemetry says."""

    def __init__(self, command, picture, telemetry):
        super().__init__(command)
        self.picture = picture
        with open(telemetry) as lines:
            self.events = [json.loads(line) for line in lines]
        self.passes = [event for event in self.events if event["type"] == "pass"]
        self.summary = [event for event in self.events if event["type"] == "summary"][-1]
        self.pass_cpu = sum(event["cpu_seconds"] for event in self.passes)  # without start-up
        self.noise = self.summary["noise"]  # relative, as the program estimates it


class Run:
    """What a measurement may use. quick: all charts together in five minutes; then a chart takes what it can."""

    def __init__(self, tress, folder, quick=False, seed=0):
        self.build = os.path.dirname(os.path.abspath(tress))
        self.tress = os.path.join(self.build, "bench", "tress-lab")  # tress with the rivals
        self.folder, self.quick, self.seed = folder, quick, seed
        self.short = False  # of a chart that has such a mode
        self.rounds = None  # of those that the caller wants other than the chart's own
        self.reference_folder = os.environ.get("TRESS_REFERENCES", os.path.join(ROOT, "build", "references"))
        os.makedirs(folder, exist_ok=True)
        os.makedirs(self.reference_folder, exist_ok=True)
        self.inputs = {}

    def path(self, name):
        return os.path.join(self.folder, name)

    def say(self, text):
        print(f"  {text}", file=sys.stderr, flush=True)

    def bench(self, name, *arguments, environment=None):
        """Runs build/.../bench/bench_NAME."""
        program = os.path.join(self.build, "bench", "bench_" + name)
        return Done([program, *map(str, arguments)], environment)

    def google_benchmark(self, name, pattern=".", min_time=0.05, repetitions=1, environment=None):
        """bench_NAME's JSON: a list of {name, cpu_time (ns), ...}, one a repetition, taken in random order; counters are
        beside cpu_time under their own names."""
        out = self.bench(name, f"--benchmark_filter={pattern}", f"--benchmark_min_time={min_time}",
                         f"--benchmark_repetitions={repetitions}", "--benchmark_enable_random_interleaving=true",
                         "--benchmark_format=json", environment=environment)
        found = json.loads(out.stdout)["benchmarks"]
        return [one for one in found if one.get("run_type", "iteration") == "iteration"]

    def scene(self, name):
        """The path of a scene of the project, or of ../shared/data (None where that is absent); noted with its hash."""
        for top in (ROOT, os.path.join(SHARED, "data"), SHARED):
            found = os.path.join(top, name)
            if os.path.exists(found):
                self.inputs[name] = content_hash(found)
                return found
        self.say(f"{name}: absent, left out")
        return None

    def variant(self, scene, name, change):
        """A scene in this run's folder: `scene` after change(its JSON)."""
        options = type("Options", (), {"output": self.folder})
        return figures.variant(options, scene, name, change)

    def render(self, scene, name, *flags, seed=None, threads=None):
        picture, telemetry = self.path(name + ".exr"), self.path(name + ".jsonl")
        command = [self.tress, "render", scene, "-o", picture, "--telemetry", telemetry, "--quiet", *map(str, flags)]
        command += ["--seed", str(self.seed if seed is None else seed)]
        if threads:
            command += ["--threads", str(threads)]
        return Rendered(command, picture, telemetry)

    def reference(self, scene, *flags, samples):
        """The mean of renders of `reference_chunk` samples under seeds of their own, `samples` at least. They are kept in the
        folder of references under a hash of the scene, its files, the flags and the code that makes pictures: what is there
        is used, all of it, and what is missing is made, so that an interrupted run goes on where it was."""
        folder = os.path.join(self.reference_folder, reference_key(scene, flags))
        os.makedirs(folder, exist_ok=True)
        wanted = -(-samples // reference_chunk)
        parts = []
        for part in itertools.count():
            out = os.path.join(folder, f"{part}.exr")
            if not os.path.exists(out):
                if part >= wanted:
                    break
                self.say(f"reference {os.path.basename(scene)} {' '.join(map(str, flags))}: {part + 1} of {wanted}")
                unfinished = os.path.join(folder, f"unfinished_{os.getpid()}.exr")
                Done([self.tress, "render", scene, "-o", unfinished, "--quiet", "--spp", str(reference_chunk), "--seed",
                      str(1_000_000 + part), *map(str, flags)])
                os.replace(unfinished, out)
                os.remove(unfinished.replace(".exr", ".png"))
            parts.append(out)
        return Reference(parts)


class Reference:
    """The mean of independent pictures, and how noisy it still is."""

    def __init__(self, parts):
        pictures = [figures.read(part) for part in parts]
        self.pixels = numpy.mean(pictures, axis=0, dtype=numpy.float64)
        self.samples = reference_chunk * len(parts)
        self.hair = figures.coverage(parts[0]) > 0.5
        # Variance of the mean, per pixel and channel, from how the parts differ.
        many = len(pictures)
        self.variance = numpy.var(pictures, axis=0, ddof=1, dtype=numpy.float64) / many if many > 1 else None

    def mean(self):
        return float(self.pixels[self.hair].mean())

    def noise_of(self, picture):
        """Root mean square difference where there is hair over the reference's mean there; the reference's own noise is
        taken out by squares."""
        difference = (figures.read(picture).astype(numpy.float64) - self.pixels)[self.hair]
        own = self.variance[self.hair].mean() if self.variance is not None else 0.0
        return float(max(0.0, (difference ** 2).mean() - own) ** 0.5 / self.mean())

    def bias_of(self, picture):
        """Mean of picture - reference where there is hair, over the reference's mean there."""
        return float((figures.read(picture).astype(numpy.float64) - self.pixels)[self.hair].mean() / self.mean())

    def model_error(self, other, side=8):
        """How far this converged picture is from `other`, the truth: root mean square difference of means of side x side
        pixels over the truth's mean, the noise of both taken out by squares."""
        hair = figures.blocks(other.hair.astype(float)[..., None], side)[..., 0] > 0.5
        off = (figures.blocks(self.pixels, side) - figures.blocks(other.pixels, side))[hair]
        noise = sum((figures.blocks(one.variance, side)[hair].mean() / side ** 2) for one in (self, other)
                    if one.variance is not None)
        truth = figures.blocks(other.pixels, side)[hair].mean()
        return float(max(0.0, (off ** 2).mean() - noise) ** 0.5 / truth)


def content_hash(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()[:16]


def picture_sources():
    """Paths of the sources that make pictures."""
    return sorted(os.path.join(top, name) for folder in PICTURE_FOLDERS for top, _, names in os.walk(os.path.join(ROOT, folder))
                  for name in names if name.endswith((".cpp", ".h")))


def reference_key(scene, flags):
    """Of everything that makes the picture: the scene and the files it names, the flags, the sources."""
    total = hashlib.sha256()

    def add(path):
        with open(path, "rb") as file:
            total.update(file.read())

    add(scene)
    if scene.endswith(".json"):
        with open(scene) as file:
            content = json.load(file)
        stack = [content]
        while stack:
            value = stack.pop()
            if isinstance(value, dict):
                stack += value.values()
                name = value.get("file")
                if isinstance(name, str):
                    add(os.path.join(os.path.dirname(scene), name))
            elif isinstance(value, list):
                stack += value
    for flag in map(str, flags):
        total.update(flag.encode() + b"\0")
        if os.path.isfile(flag):
            add(flag)
    for path in picture_sources():
        add(path)
    return total.hexdigest()[:20]


# ---- statistics -----------------------------------------------------------------------------------------------------

def interval(values):
    """{median, low, high, values}: low and high hold the median of such values at 95 % or better by order statistics, and
    are the least and the greatest where there are fewer than nine. The values stay in the order of the rounds."""
    ordered = sorted(values)
    many = len(ordered)
    below = 0
    if many >= 9:
        # P(the median lies below the k-th smallest) = sum of binomials; take the largest k that keeps 2.5 % a side.
        chance, term = 0.0, 0.5 ** many
        for k in range(many // 2):
            chance += term
            if chance > 0.025:
                break
            below = k + 1
            term = term * (many - k) / (k + 1)
        below = max(0, below - 1)
    return {"median": statistics.median(ordered), "low": ordered[below], "high": ordered[many - 1 - below],
            "values": list(values)}


def by_name(measured, quantity="cpu_time"):
    """{name: interval} of what google_benchmark() found."""
    found = {}
    for one in measured:
        found.setdefault(one["run_name"], []).append(one[quantity])
    return {name: interval(values) for name, values in found.items()}


def interleaved(rivals, rounds, seed=0):
    """rivals: {name: function(round) -> {quantity: number}}. Every round asks all of them, in an order of its own.
    {name: {quantity: interval}}."""
    order, shuffle = list(rivals), random.Random(seed)
    found = {name: {} for name in rivals}
    for turn in range(rounds):
        shuffle.shuffle(order)
        for name in order:
            for quantity, value in rivals[name](turn).items():
                found[name].setdefault(quantity, []).append(value)
    return {name: {quantity: interval(values) for quantity, values in quantities.items()}
            for name, quantities in found.items()}


def fit_growth(xs, ys):
    """Least squares of ln y = ln a + b ln x: {"factor", "exponent", "error"} with the standard error of b."""
    x, y = numpy.log(numpy.asarray(xs, float)), numpy.log(numpy.asarray(ys, float))
    slope, level = numpy.polyfit(x, y, 1)
    rest = y - (level + slope * x)
    error = 0.0
    if len(x) > 2:
        error = float(numpy.sqrt((rest ** 2).sum() / (len(x) - 2) / ((x - x.mean()) ** 2).sum()))
    return {"factor": float(numpy.exp(level)), "exponent": float(slope), "error": error}


# ---- results --------------------------------------------------------------------------------------------------------

def context(run):
    """What a result was made by and on."""
    def git(*words):
        done = subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True)
        return done.stdout.strip() if done.returncode == 0 else "unknown"

    cpu = "unknown"
    if os.path.exists("/proc/cpuinfo"):
        with open("/proc/cpuinfo") as lines:
            cpu = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), cpu)
    compiler = "unknown"
    cache = os.path.join(run.build, "CMakeCache.txt")
    if os.path.exists(cache):
        with open(cache) as lines:
            name = next((line.split("=")[1].strip() for line in lines if line.startswith("CMAKE_CXX_COMPILER:")), "")
        if name:
            compiler = subprocess.run([name, "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    return {"commit": git("rev-parse", "HEAD"), "changed_files": len(git("status", "--porcelain").splitlines()),
            "compiler": compiler, "cpu": cpu, "cores": os.cpu_count(), "system": platform.platform(),
            "load": os.getloadavg()[0], "seed": run.seed, "quick": run.quick}


def shortened(content):
    """The same with six digits a number: more are not known."""
    if isinstance(content, dict):
        return {key: shortened(value) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [shortened(value) for value in content]
    return float(f"{content:.6g}") if isinstance(content, float) else content


def save(path, content):
    """JSON, whole or not at all."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path + ".tmp", "w") as file:
        json.dump(shortened(content), file, indent=1)
        file.write("\n")
    os.replace(path + ".tmp", path)


# ---- drawing --------------------------------------------------------------------------------------------------------

# One color and mark a rival on every chart.
STYLES = {
    "elliptical": ("#d62728", "o"), "fitted": ("#d62728", "o"), "sketch": ("#d62728", "o"),
    "corrected": ("#ff7f0e", "s"), "exact": ("#7f7f7f", "D"), "fiber3d": ("#000000", "*"),
    "deon2011": ("#1f77b4", "v"), "deon2022": ("#56b4e9", "v"),
    "chiang2016": ("#2ca02c", "^"), "marschner2003": ("#9467bd", "<"),
    "ou2012": ("#8c564b", ">"), "pekelis2015": ("#e377c2", "P"), "pekelis2015-printed": ("#f7b6d2", "X"),
    "eager": ("#ff9896", "s"), "em": ("#17becf", "^"), "appendix": ("#bcbd22", "v"),
    "appendix-literal": ("#dbdb8d", "x"), "ais": ("#08306b", "D"), "table": ("#5f0f40", "P"), "cycles": ("#393b79", "h"),
    "cold": ("#d62728", "o"), "warm": ("#fb9a99", "o"), "prebaked": ("#a50f15", "D"),
    "quadrature": ("#7fa8d9", "d"), "rough": ("#006d2c", "o"), "rough warm": ("#74c476", "o"),
    "rough touching": ("#00441b", "s"),
}


def style(name):
    """{"color", "marker"} of a rival; of one with settings ("deon2011 35", "deon2011/35") that of its first word."""
    color, marker = STYLES.get(name) or STYLES.get(name.replace("/", " ").split()[0], ("#444444", "."))
    return {"color": color, "marker": marker}


class Chart:
    """Where a chart is drawn to: a grid of axes, saved as PNG and SVG."""

    def __init__(self, title, columns=1, rows=1, width=5.2, height=4.0):
        self.figure, axes = pyplot.subplots(rows, columns, figsize=(width * columns, height * rows), squeeze=False)
        self.axes = [axis for row in axes for axis in row]
        self.figure.suptitle(title, fontsize=11)

    def save(self, path_without_suffix):
        self.figure.tight_layout()
        self.figure.savefig(path_without_suffix + ".svg", metadata={"Date": None}, bbox_inches="tight")
        pixels = io.BytesIO()
        self.figure.savefig(pixels, format="png", dpi=110, bbox_inches="tight")
        pyplot.close(self.figure)
        # 256 colors: a third of the bytes, and these pictures are in the repository.
        picture = PIL.Image.open(pixels).convert("RGB").quantize(256, dither=PIL.Image.Dither.NONE)
        picture.save(path_without_suffix + ".png", optimize=True)
