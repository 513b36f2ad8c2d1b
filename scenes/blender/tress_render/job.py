"""The program `tress` as a child: finding it, starting a render, following it, ending it. Knows nothing of Blender."""

import json
import os
import shutil
import signal
import subprocess
import threading


def find_program(preferred):
    """The path that was set, else that of PATH. FileNotFoundError names what was looked for."""
    if preferred:
        if os.path.isfile(preferred) and os.access(preferred, os.X_OK):
            return preferred
        raise FileNotFoundError(f"{preferred}: not a program (Preferences, Add-ons, tress, Program)")
    found = shutil.which("tress")
    if found is None:
        raise FileNotFoundError("the program tress is not in PATH: set it in Preferences, Add-ons, tress, Program")
    return found


class Status:
    """What the last pass reported: a share of the work in [0, 1], and a sentence."""

    def __init__(self, share, text):
        self.share, self.text = share, text


class Job:
    """One render. `folder` has scene.json and takes picture.exr and telemetry.jsonl; those of an earlier render go. Goal: `pixels` with `samples`
    each, or until the noise is `noise`; `live`: whole pictures are saved on the way.

    follow() is to be called now and then; it never blocks.
    """

    def __init__(self, program, folder, options, pixels, samples=None, noise=None, live=True):
        self.folder = folder
        self.goal = (pixels, samples, noise)
        self.scene = os.path.join(folder, "scene.json")
        self.picture = os.path.join(folder, "picture.exr")
        self.telemetry = os.path.join(folder, "telemetry.jsonl")
        self.command = [program, "render", self.scene, "-o", self.picture, "--telemetry", self.telemetry,
                        "--precision", "float"] + options
        if live:
            self.command += ["--checkpoint", os.path.join(folder, "picture.checkpoint"), "--checkpoint-interval", "1",
                             "--checkpoint-deadline", "5"]
        for stale in (self.picture, self.telemetry):  # may have another size, and would be taken for news
            if os.path.exists(stale):
                os.remove(stale)
        self._said = []
        self._read = 0
        self._stamp = None
        self._child = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE, text=True, errors="replace")
        self._reader = threading.Thread(target=self._listen, daemon=True)
        self._reader.start()

    def _listen(self):
        for line in self._child.stderr:
            self._said.append(line.rstrip("\n"))

    def said(self):
        """Lines of the program so far."""
        return list(self._said)

    def warnings(self):
        return [line for line in self.said() if "warning" in line.lower()]

    def running(self):
        return self._child.poll() is None

    def status(self):
        """Of the newest pass; None where there is no news."""
        try:
            with open(self.telemetry, "rb") as file:
                file.seek(self._read)
                text = file.read()
        except OSError:
            return None
        end = text.rfind(b"\n") + 1
        self._read += end
        newest = None
        for line in text[:end].splitlines():
            try:
                fields = json.loads(line)
            except ValueError:
                continue
            if fields.get("type") == "pass":
                newest = fields
        return status_of(newest, *self.goal) if newest else None

    def new_picture(self):
        """Whether a whole picture was saved since the last call that said so."""
        try:
            entry = os.stat(self.picture)
        except OSError:
            return False
        stamp = (entry.st_mtime_ns, entry.st_size, entry.st_ino)
        if stamp == self._stamp:
            return False
        self._stamp = stamp
        return True

    def end(self, patience=15.0):
        """Asks it to end, which saves its cache; then makes it."""
        if self.running():
            self._child.send_signal(getattr(signal, "SIGTERM", signal.SIGINT))
            try:
                self._child.wait(patience)
            except subprocess.TimeoutExpired:
                self._child.kill()
                self._child.wait()
        self.close()

    def close(self):
        """Waits for it. Its exit status."""
        status = self._child.wait()
        self._reader.join(5)
        self._child.stderr.close()
        return status

    def error(self):
        """What it said last that was no progress: for a person."""
        errors = [line for line in self.said() if "error" in line.lower()]
        lines = errors or self.said()[-3:]
        return "\n".join(lines) or "tress ended without a word"


def status_of(line, pixels, samples=None, noise=None):
    """The status line of a pass of telemetry (adaptive/telemetry/README.md), and how far it is: of `pixels` with
    `samples` each, or until the noise is `noise`."""
    a_pixel = line.get("samples", 0) / max(pixels, 1)
    parts = [f"pass {line.get('pass', 0) + 1}", f"{a_pixel:.3g} samples a pixel"]
    if line.get("noise"):
        parts.append(f"noise {line['noise']:.2g}")
    if line.get("queries"):
        parts.append(f"{100 * line.get('converged_query_share', 0):.1f} % of queries on converged rows")
    share = a_pixel / samples if samples else 0.0
    if noise and line.get("noise"):
        share = (noise / line["noise"]) ** 2
    return Status(min(share, 1.0), ", ".join(parts))
