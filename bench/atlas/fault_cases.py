"""What study 6 asks of every fault: that nothing saved is lost, nothing is half written, the reason is reported.

A Case counts tries of one fault. After each try `Desk.judge` looks at the folder: each output absent, as it was, or whole
and new; the cache a superset of what was saved (its merge with the old one is itself, to the byte); telemetry readable but
for a last line cut off by a kill."""
import json
import os
import shutil
import signal
import subprocess
import time

import OpenImageIO
import PIL.Image

SCENE = {"camera": {"frame": True}, "image": {"width": 16, "height": 16, "samples": 2},
         "environment": {"constant": [1, 1, 1]}, "materials": [{"name": "brown"}],
         "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.04, "material": "brown"}]}
STOPPED = (-signal.SIGKILL, -signal.SIGINT, -signal.SIGTERM)


class Case:
    """One row of the table."""

    def __init__(self, group, fault):
        self.group, self.fault = group, fault
        self.counts = dict(tries=0, lost=0, half_written=0, untold=0, crashed=0)
        self.seen, self.examples = {}, []

    def bad(self, what, why):
        self.counts[what] += 1
        if len(self.examples) < 3:
            self.examples.append(f"{what}: {why}"[:300])

    def saw(self, what):
        self.seen[what] = self.seen.get(what, 0) + 1

    def json(self):
        return {"group": self.group, "fault": self.fault, **self.counts, "seen": self.seen, "examples": self.examples}


def read(path):
    try:
        with open(path, "rb") as file:
            return file.read()
    except (FileNotFoundError, NotADirectoryError):
        return None


class Desk:
    """A folder with a scene, the programs, and what the outputs were before a try."""

    def __init__(self, run, name):
        self.run, self.folder = run, run.path(name)
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)
        self.tress, self.left = run.tress, set()  # left: by those killed
        self.program = os.path.join(run.build, "bench", "bench_atlas_faults")
        self.scene = self.path("scene.json")
        with open(self.scene, "w") as file:
            json.dump(SCENE, file)

    def path(self, name):
        return os.path.join(self.folder, name)

    def render(self, out, *more, seed=0, cache="t.cache", telemetry=None):
        """Command of a short render with every output in `out`."""
        at = lambda name: os.path.join(out, name)  # noqa: E731
        command = [self.tress, "render", self.scene, "-o", at("a.exr"), "--heatmap", at("h.exr"), "--telemetry",
                   telemetry or at("a.jsonl"), "--quiet", "--threads", "2", "--seed", seed, *more]
        return list(map(str, command + (["--warm-cache", at(cache)] if cache else [])))

    def do(self, command, shell=None, environment=None, timeout=120):
        """shell: what /bin/sh does around "$@"."""
        if shell:
            command = ["/bin/sh", "-c", shell, "sh", *command]
        return subprocess.run(list(map(str, command)), capture_output=True, text=True, errors="replace", timeout=timeout,
                              stdin=subprocess.DEVNULL, env={**os.environ, **(environment or {})})

    def start(self, command, **more):
        return subprocess.Popen(list(map(str, command)), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, **more)

    def rows(self, cache):
        return json.loads(self.do([self.tress, "cache", "info", cache, "--json"]).stdout)["rows"]

    def contains(self, case, before, cache):
        """Whether the cache file holds all that the bytes `before` held."""
        if before is None:
            return
        after = read(cache)
        if after == before:
            return
        if after is None:
            return case.bad("lost", f"{cache} is gone")
        old, joined = self.path("before.cache"), self.path("joined.cache")
        with open(old, "wb") as file:
            file.write(before)
        copy = self.path("after.cache")
        shutil.copyfile(cache, copy)
        done = self.do([self.tress, "cache", "merge", old, copy, "-o", joined])
        if done.returncode != 0:
            return case.bad("half_written", done.stderr)
        if read(joined) != after:
            case.bad("lost", f"{cache} lacks rows that it had")

    def whole(self, case, path, before, killed=False):
        """Each output absent, old, or whole."""
        after = read(path)
        if after == before:
            return
        if after is None:
            return case.bad("lost", f"{path} is gone")
        if path.endswith(".exr"):
            picture = OpenImageIO.ImageBuf(path)
            if not picture.read(force=True) or picture.has_error:
                case.bad("half_written", f"{path}: {picture.geterror()}")
        elif path.endswith(".png"):
            try:
                PIL.Image.open(path).load()
            except (OSError, SyntaxError) as error:
                case.bad("half_written", f"{path}: {error}")
        elif path.endswith(".jsonl"):
            lines = after.decode(errors="replace").split("\n")
            for i, line in enumerate(lines):
                if i == len(lines) - 1 and (killed or not line):
                    continue
                try:
                    json.loads(line)
                except ValueError:
                    case.bad("half_written", f"{path}: line {i + 1}: {line[:80]}")
        elif ".cache" in os.path.basename(path):
            self.contains(case, before, path)
            done = self.do([self.tress, "cache", "verify", path])
            if done.returncode != 0:
                case.bad("half_written", done.stderr)

    def snapshot(self, out):
        return {name: read(os.path.join(out, name)) for name in ("a.exr", "a.png", "h.exr", "t.cache", "a.jsonl")}

    def judge(self, case, out, before, status, stderr, named=(), killed=False):
        """named: of which names one must be named if it fails. No temporary file may stay unless it was killed."""
        case.counts["tries"] += 1
        case.saw(f"exit {status}")
        if status not in (0, 1, 2, 130, 143) and not (killed and status in STOPPED):
            case.bad("crashed", f"exit {status}: {stderr[-200:]}")
        if status in (1, 2) and not any(name in stderr for name in named or ("error", "telemetry stops")):
            case.bad("untold", stderr[-200:] or "nothing said")
        for name, content in before.items():
            self.whole(case, os.path.join(out, name), content, killed)
        left = set(strays(out)) - self.left
        if left and not killed:
            case.bad("half_written", f"left: {left}")
        if left:
            case.saw("killed with a temporary file or lock there")
            self.left |= left


def strays(folder):
    """Of saves: FILE.tmp-PID-N, locks, and anything hidden."""
    if not os.path.isdir(folder):
        return []
    return sorted(name for name in os.listdir(folder) if ".tmp" in name or name.startswith(".") or name.endswith(".lock"))


def wait_for(condition, seconds=20, step=0.002):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(step)
    return False


class Disk:
    """A file system of its own of `kilobytes`; needs root. Unmounted whatever happens."""

    def __init__(self, folder, kilobytes=None):
        self.folder, self.options = folder, ["-o", f"size={kilobytes}k"] if kilobytes else []

    def __enter__(self):
        os.makedirs(self.folder, exist_ok=True)
        subprocess.run(["mount", "-t", "tmpfs", *self.options, "tmpfs", self.folder], check=True)
        return self

    def read_only(self):
        subprocess.run(["mount", "-o", "remount,ro", self.folder], check=True)

    def __exit__(self, *_):
        while os.path.ismount(self.folder):
            subprocess.run(["umount", "-l", self.folder], check=True)


def can_mount(folder):
    try:
        with Disk(folder, 64):
            return True
    except (subprocess.CalledProcessError, OSError):
        return False
