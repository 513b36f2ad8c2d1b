#!/usr/bin/env python3
"""The live page: how soon the picture follows a slider, and what the page costs a render.

usage: bench/shots/live_page.py [BUILD] [-o FILE] [--rounds 3] [--size 400x400] [--cost-rounds 6] [--spp 16] [--scene SCENE]

Follows. One render waits for changes; each round moves every slider once, to a value it never had, as the page does (control, then
status every 0.1 s and the picture). Wall time and CPU time of the program, from the change to the first picture (every 64th pixel)
and to one sample a pixel. Half of a look's time passes before the next change, so that the render is never just starting.

Costs. The same render with and without a page that somebody watches (status, newest picture and table every second), in turns: the
mean of the rounds' ratios less 1 and its standard error, of wall time and of CPU time.
"""
import argparse
import json
import math
import os
import re
import resource
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TICK = os.sysconf("SC_CLK_TCK")


class Page:
    """What live.js asks of the program, without a browser."""

    def __init__(self, program):
        self.program = program
        for line in program.stderr:
            found = re.search(r"live page: (http\S+)", line)
            if found:
                self.url = found.group(1)
                break
        self.pass_count, self.table = 0, 0

    def get(self, path):
        """None where the page must ask again later."""
        try:
            with urllib.request.urlopen(self.url + path, timeout=10) as answer:
                return answer.read()
        except urllib.error.HTTPError as error:
            if error.code == 503:
                return None
            raise

    def status(self, since):
        answer = self.get(f"status?since={since}")
        return answer and json.loads(answer)

    def control(self, **words):
        request = urllib.request.Request(self.url + "control", json.dumps(words).encode(), {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=10) as answer:
            return json.loads(answer.read())

    def turn(self):
        """As every second in the browser."""
        status = self.status(self.pass_count)
        if status is None:
            return
        self.pass_count = status["first"] + len(status["passes"])
        if status["picture"] > 0:
            self.get("picture?layer=beauty")
        if status["table"] != self.table and self.get("table") is not None:
            self.table = status["table"]

    def cpu(self):
        fields = open(f"/proc/{self.program.pid}/stat").read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / TICK


def started(command):
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def follow(page, moved):
    """(wall, CPU) of the first picture and of one sample a pixel."""
    wall, cpu = time.monotonic(), page.cpu()
    look = page.control(do="look", values=moved)["look"]
    first = None
    while True:
        status = page.status(1)
        if status and status["look"] >= look:
            if first is None and status["picture"] >= status["first_of_look"] and page.get("picture?layer=beauty"):
                first = time.monotonic() - wall, page.cpu() - cpu
            last = status["passes"][-1] if status["passes"] else None
            if first and last and last["samples"] >= last["image_pixels"] and last["seconds"] <= time.monotonic() - wall:
                return first, (time.monotonic() - wall, page.cpu() - cpu)
        time.sleep(0.1)


def follows(plain, rounds):
    program = started(plain + ["--spp", "100000", "--serve"])
    page, found = Page(program), {}
    while not (status := page.status(0)) or not status["passes"]:
        time.sleep(0.2)
    sliders, moved = status["sliders"], {}
    for number in range(rounds):
        for slider in sliders:
            share = (number + 0.5) / rounds
            steps = round((0.1 + 0.8 * share) * (slider["most"] - slider["least"]) / slider["step"])
            moved[slider["name"]] = slider["least"] + steps * slider["step"]
            found.setdefault(slider["name"], []).append(follow(page, moved))
            time.sleep(found[slider["name"]][-1][1][0] / 2)
    page.control(do="stop")
    program.stderr.read()
    program.wait()
    return found


def timed(command, watched):
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    program = started(command)
    if watched:
        page = Page(program)
        while program.poll() is None:
            try:
                page.turn()
            except OSError:
                break
            try:
                program.wait(1)
            except subprocess.TimeoutExpired:
                pass
    program.stderr.read()
    if program.wait() != 0:
        raise SystemExit(" ".join(command))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() - start, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def mean_and_error(ratios):
    mean = sum(ratios) / len(ratios)
    return mean, math.sqrt(sum((x - mean) ** 2 for x in ratios) / max(1, len(ratios) - 1) / len(ratios))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--cost-rounds", type=int, default=6)
    parser.add_argument("--size", default="400x400")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--scene", default=os.path.join(ROOT, "scenes", "straight_groom.json"))
    options = parser.parse_args()
    found = {"scene": os.path.basename(options.scene), "size": options.size, "threads": os.cpu_count(), "load": os.getloadavg()[0]}
    with tempfile.TemporaryDirectory() as folder:
        plain = [os.path.join(os.path.abspath(options.build), "tress"), "render", options.scene, "-o",
                 os.path.join(folder, "a.exr"), "--resolution", options.size]
        print("slider         first picture: wall, CPU, s   one sample a pixel: wall, CPU, s   (median, most)")
        for name, times in follows(plain, options.rounds).items():
            columns = [sorted(one[when][what] for one in times) for when in (0, 1) for what in (0, 1)]
            found[name] = [[column[len(column) // 2], column[-1]] for column in columns]
            print(f"{name:14}", "   ".join(f"{median:5.2f} {most:5.2f}" for median, most in found[name]), flush=True)
        command = plain + ["--spp", str(options.spp)]
        wall, cpu = [], []
        for number in range(options.cost_rounds):
            order = (False, True) if number % 2 == 0 else (True, False)
            times = {watched: timed(command + (["--serve"] if watched else []), watched) for watched in order}
            wall.append(times[True][0] / times[False][0] - 1)
            cpu.append(times[True][1] / times[False][1] - 1)
            found["seconds"] = times[False]
        for name, ratios in (("wall", wall), ("cpu", cpu)):
            if not ratios:
                continue
            found[name + "_cost"] = mean_and_error(ratios)
            print(f"watched page, {name} time: {found[name + '_cost'][0]:+.4f} +- {found[name + '_cost'][1]:.4f}")
    if options.output:
        with open(options.output, "w") as stream:
            json.dump(found, stream, indent=1)


if __name__ == "__main__":
    main()
