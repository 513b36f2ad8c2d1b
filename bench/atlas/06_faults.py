"""Kills, signals, full and vanishing disks, damaged and foreign caches, eight sessions, jumping clocks, want of memory, each
system call failing in turn: is anything that was saved lost, anything half written, any reason unreported?

Full disks and read-only folders are file systems of their own, which needs root; without it they are left out and said so."""
import concurrent.futures
import json
import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import time

import charts

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from fault_cases import SCENE, Case, Desk, Disk, can_mount, read, strays, wait_for  # noqa: E402

TITLE = "Faults: what is lost, half written or unreported"
COLUMNS = ("tries", "lost", "half_written", "untold", "crashed")


def measure(run):
    mounts, start = can_mount(run.path("mount")), os.times()
    if not mounts:
        run.say("no root: file systems of their own are left out")

    def cases_of(study):
        found = study(run)
        for case in found:
            run.say(f"{case.fault}: {case.counts} {case.seen} {case.examples}")
        return found

    studies = [kills_of_renders, kills_of_saves, signals, damage, foreign, *([full_disks, file_systems_that_go] if mounts else []),
               folders_that_go, sessions, clocks, memory, system_calls, streams, names]
    with concurrent.futures.ThreadPoolExecutor(6) as pool:  # of folders of their own; most of their time is the programs'
        cases = [case for found in pool.map(cases_of, studies) for case in found]
    end = os.times()
    return {"settings": {"scene": SCENE, "quick": run.quick, "seed": run.seed, "file_systems": "tmpfs" if mounts else None,
                         "cpu_seconds": round(sum(end[:4]) - sum(start[:4]), 1), "load": round(os.getloadavg()[0], 1)},
            "cases": [case.json() for case in cases]}


# ---- killed -------------------------------------------------------------------------------------------------------------

def warm(desk, out, cache="t.cache"):
    os.makedirs(out, exist_ok=True)
    done = desk.do(desk.render(out, cache=cache))
    assert done.returncode == 0, done.stderr
    return desk.snapshot(out)


def kill_within(process, moment, signals=(signal.SIGKILL,), pause=0.0):
    """moment: called until it is true, or the process has ended. Whether it was still there."""
    while not moment():
        if process.poll() is not None:
            return False
    for i, one in enumerate(signals):
        if i:
            time.sleep(pause)
        process.send_signal(one)
    return True


def after(seconds):
    end = time.monotonic() + seconds
    return lambda: time.sleep(0.0005) or time.monotonic() >= end


def life_of(desk, command):
    spans = []
    for _ in range(3):
        start = time.monotonic()
        assert desk.do(command).returncode == 0
        spans.append(time.monotonic() - start)
    return statistics.median(spans)


def next_session(desk, case, out):
    """A session after all kills, an hour later: clears what they left, says so, and works."""
    left = [name for name in strays(out) if ".tmp" in name]
    hour_ago = time.time() - 3600
    for name in left:
        os.utime(os.path.join(out, name), (hour_ago, hour_ago))
    before = read(os.path.join(out, "t.cache"))
    done = desk.do([word for word in desk.render(out) if word != "--quiet"])
    if done.returncode != 0 or "loaded" not in done.stderr:
        case.bad("lost", f"the next session: {done.stderr}")
    for name in left:
        if f"removed {os.path.join(out, name)}" not in done.stderr:
            case.bad("untold", f"{name} was not said to be removed")
    if strays(out):
        case.bad("half_written", f"still left: {strays(out)}")
    desk.contains(case, before, os.path.join(out, "t.cache"))
    case.saw(f"{len(left)} temporary files removed by the next session")


def kills_of_renders(run):
    chance = random.Random(run.seed)
    cases = []
    for fault, tries, save in (("kill -9, any moment of a render", 8 if run.quick else 120, False),
                               ("kill -9 while a render saves", 6 if run.quick else 60, True)):
        desk, case = Desk(run, "kill_save" if save else "kill_render"), Case("killed", fault)
        out = desk.path("out")
        warm(desk, out)
        life = life_of(desk, desk.render(out))
        before = desk.snapshot(out)
        for seed in range(1, 20 * tries):
            if case.counts["tries"] == tries:
                break
            known = strays(out)
            process = desk.start(desk.render(out, seed=seed))
            if save:
                # A new temporary file is there, of the picture, the preview, the heat map or the cache, or a lock; then up to 3 ms.
                wanted, wait = chance.choice(("a.exr", "a.png", "h.exr", "t.cache")), chance.choice((0, chance.uniform(0, 0.003)))
                moment = lambda: any(name.startswith(wanted) for name in set(strays(out)) - set(known))  # noqa: B023, E731
                hit = kill_within(process, moment, signals=()) and kill_within(process, after(wait))
            else:
                hit = kill_within(process, after(chance.uniform(0, life)))
            stderr = process.communicate()[1].decode(errors="replace")
            if hit and process.returncode == -signal.SIGKILL:
                desk.judge(case, out, before, process.returncode, stderr, killed=True)
            before = desk.snapshot(out)
        next_session(desk, case, out)
        cases.append(case)
    return cases


def kills_of_saves(run):
    """Of a program that saves and saves (what a render does every ten minutes), and of cache merge."""
    chance = random.Random(run.seed + 1)
    desk, saves, merges = Desk(run, "kill_saves"), Case("killed", "kill -9, saves in a loop"), Case("killed", "kill -9, cache merge")
    out, big = desk.path("out"), desk.path("big.cache")
    warm(desk, out)
    shutil.copyfile(os.path.join(out, "t.cache"), big)
    cache, most = os.path.join(out, "t.cache"), 0
    os.remove(cache)
    for _ in range(10 if run.quick else 220):
        before = read(cache)
        process = subprocess.Popen([desk.program, "save", big, "-o", cache], stdout=subprocess.PIPE, text=True)
        first = process.stdout.readline()  # it is in its loop
        kill_within(process, after(chance.uniform(0, 0.03)))
        reported = [int(line) for line in [first, *process.communicate()[0].splitlines()] if line.strip()]
        most = max([most, *reported])
        saves.counts["tries"] += 1
        saves.saw("temporary files left") if strays(out) else None
        rows = desk.rows(cache)
        if sum(rows.values()) < most:
            saves.bad("lost", f"{most} rows were reported saved, {rows} are there")
        desk.whole(saves, cache, before, killed=True)
    next_session(desk, saves, out)

    parts = [desk.path(f"part{i}.cache") for i in range(3)]
    for i, part in enumerate(parts):
        command = desk.render(desk.folder, "--eccentricity", f"0.{70 + i}", cache=os.path.basename(part))
        assert desk.do(command).returncode == 0
    command = [desk.tress, "cache", "merge", cache, *parts, "-o", cache]
    shutil.copyfile(cache, big)
    life = life_of(desk, command)
    while merges.counts["tries"] < (10 if run.quick else 100):
        shutil.copyfile(big, cache)
        before = {"t.cache": read(cache)}
        process = desk.start(command)
        hit = kill_within(process, after(chance.uniform(0, 1.2 * life)))
        stderr = process.communicate()[1].decode()
        if hit and process.returncode == -signal.SIGKILL:
            desk.judge(merges, out, before, process.returncode, stderr, killed=True)
    next_session(desk, merges, out)
    return [saves, merges]


def signals(run):
    chance = random.Random(run.seed + 2)
    desk, cases = Desk(run, "signals"), []
    out = desk.path("out")
    warm(desk, out)
    life = life_of(desk, desk.render(out, "--spp", 4))
    for fault, sent in (("SIGINT, any moment", [signal.SIGINT]), ("SIGTERM, any moment", [signal.SIGTERM]),
                        ("SIGINT twice", [signal.SIGINT] * 2), ("SIGTERM, then SIGINT", [signal.SIGTERM, signal.SIGINT])):
        case = Case("signals", fault)
        while case.counts["tries"] < (2 if run.quick else 15):
            before = desk.snapshot(out)
            process = desk.start(desk.render(out, "--spp", 4, seed=chance.randrange(1 << 30)))
            hit = kill_within(process, after(chance.uniform(0, 1.2 * life)), sent, chance.uniform(0, 0.05))
            stderr = process.communicate()[1].decode(errors="replace")
            if not hit:
                continue
            desk.judge(case, out, before, process.returncode, stderr, killed=process.returncode < 0)
            if process.returncode in (130, 143):
                summary = [json.loads(line) for line in open(os.path.join(out, "a.jsonl"))][-1]
                if summary["type"] != "summary" or read(os.path.join(out, "a.exr")) == before["a.exr"]:
                    case.bad("lost", "interrupted, but not saved")
        next_session(desk, case, out)
        cases.append(case)
    return cases


# ---- damaged, foreign ---------------------------------------------------------------------------------------------------

def damage(run):
    desk = Desk(run, "damage")
    out = desk.path("out")
    warm(desk, out)
    small = desk.path("small.cache")
    found = json.loads(desk.do([desk.program, "bytes", os.path.join(out, "t.cache"), "--rows", 2 if run.quick else 6, "-o",
                                small], timeout=900).stdout)
    cases = []
    for what, fault in (("flips", f"every byte of {found['bytes']} to each other value"),
                        ("truncations", "every truncation"), ("tails", "more bytes than there are")):
        case = Case("damaged cache", fault)
        case.counts.update(tries=found[what]["tries"], half_written=found[what]["tries"] - found[what]["refused"],
                           untold=found[what]["unnamed"])
        case.seen = found[what]["reasons"]
        cases.append(case)
    chance, whole = random.Random(run.seed + 3), read(small)
    flipped, cut = Case("damaged cache", "flips, by the command line"), Case("damaged cache", "truncations, by the command line")
    for case, tries in ((flipped, 6 if run.quick else 60), (cut, 6 if run.quick else 60)):
        for i in range(tries):
            bad = bytearray(whole)
            if case is flipped:
                bad[chance.randrange(len(bad))] ^= 1 << chance.randrange(8)
            else:
                del bad[chance.randrange(len(bad)):]
            refuse(desk, case, bytes(bad), renders=i % 10 == 0)
    return cases + [flipped, cut]


def refuse(desk, case, content, renders=True):
    """Refused by every command by name of the reason; left as it is."""
    cache = desk.path("bad.cache")
    commands = {"verify": ([desk.tress, "cache", "verify", cache], 1), "info": ([desk.tress, "cache", "info", cache], 1),
                "merge": ([desk.tress, "cache", "merge", cache, cache, "-o", cache], 1)}
    if renders:
        commands["append"] = (desk.render(desk.folder, cache="bad.cache"), 0)
        commands["require"] = (desk.render(desk.folder, "--cache-mode", "require", cache="bad.cache"), 1)
        commands["prebake"] = ([desk.tress, "cache", "prebake", desk.scene, "-o", cache], 1)
    for name, (command, status) in commands.items():
        with open(cache, "wb") as file:
            file.write(content)
        done = desk.do(command)
        case.counts["tries"] += 1
        if done.returncode < 0 or done.returncode > 2:
            case.bad("crashed", f"{name}: {done.returncode}")
        if done.returncode != status:
            case.bad("untold", f"{name}: exit {done.returncode}, {status} expected: {done.stderr[-200:]}")
        if not ("bad.cache" in done.stderr and "expected" in done.stderr and "found" in done.stderr):
            case.bad("untold", f"{name}: {done.stderr[-200:]}")
        if read(cache) != content:
            case.bad("lost", f"{name} wrote over it")
    return case


def foreign(run):
    desk = Desk(run, "foreign")
    out = desk.path("out")
    whole = warm(desk, out)["t.cache"]
    done = desk.do(desk.render(out, "--model", "pekelis2015", cache="other.cache"))
    assert done.returncode == 0, done.stderr
    version = lambda number, order: whole[:8] + number.to_bytes(4, order) + whole[12:]  # noqa: E731
    files = {"of another model": read(os.path.join(out, "other.cache")), "of a later format": version(3, "little"),
             "of another byte order": version(1, "big"), "with another magic": b"\x89PNG\r\n\x1a\n" + whole[8:],
             "empty": b"", "a text": b"notes of somebody, long enough for a header and more", "zeros": bytes(4096)}
    cases = [refuse(desk, Case("foreign cache", name), content) for name, content in files.items() if name != "of another model"]
    other = Case("foreign cache", "of another model")
    cache = os.path.join(out, "other.cache")
    for command, status in ((desk.render(out, cache="other.cache"), 0),
                            (desk.render(out, "--cache-mode", "require", cache="other.cache"), 1),
                            ([desk.tress, "cache", "merge", os.path.join(out, "t.cache"), cache, "-o", cache], 1)):
        done = desk.do(command)
        other.counts["tries"] += 1
        if done.returncode != status or "model" not in done.stderr or "other.cache" not in done.stderr:
            other.bad("untold", f"exit {done.returncode}: {done.stderr[-200:]}")
        if read(cache) != files["of another model"]:
            other.bad("lost", "written over")
    return [other, *cases]


# ---- disks --------------------------------------------------------------------------------------------------------------

def commands_of(desk, out):
    """Every command that writes, with the names of what it writes."""
    at = lambda name: os.path.join(out, name)  # noqa: E731
    fit = [desk.tress, "fit", "--lobe", "TT", "--e", ".85", "--theta-d", "30", "--phi", "45", "--sigma", "20"]
    part, other = desk.path("part.cache"), desk.path("other.cache")
    plain = [desk.tress, "render", desk.scene, "--quiet", "--threads", "2", "-o", desk.path("elsewhere.exr")]
    return {"picture, preview": ([*plain[:-1], at("a.exr")], ("a.exr", "a.png")),
            "cache of a render": ([*plain, "--spp", "16", "--warm-cache", at("t.cache")], ("t.cache",)),
            "telemetry": ([*plain, "--telemetry", at("a.jsonl"), "--telemetry-level", "rows", "--spp", "16"], ("a.jsonl",)),
            "heat map": ([*plain, "--heatmap", at("h.exr")], ("h.exr",)), "fit -o": ([*fit, "-o", at("f.png")], ("f.png",)),
            "merge -o": ([desk.tress, "cache", "merge", part, other, "-o", at("t.cache")], ("t.cache",)),
            "prebake -o": ([desk.tress, "cache", "prebake", desk.path("bake.json"), "-o", at("p.cache"), "--model", "elliptical",
                            "--epsilon", "0.5", "--quiet"], ("p.cache",))}


def disk_desk(run, name):
    desk = Desk(run, name)
    for part, shape in (("part.cache", "0.85"), ("other.cache", "0.7")):
        assert desk.do(desk.render(desk.folder, "--spp", "16", "--eccentricity", shape, cache=part)).returncode == 0
    shutil.copyfile(desk.scene, desk.path("bake.json"))
    return desk


def full_disks(run):
    desk = disk_desk(run, "full")
    out, cases, read_only = desk.path("disk"), [], Case("disk", "read-only folder, every output")
    for what, (command, written) in commands_of(desk, out).items():
        if what == "prebake -o" and run.quick:
            continue
        case = Case("disk", f"full: {what}")
        with Disk(out) as disk:
            assert (done := desk.do(command)).returncode == 0, done.stderr
            pages = sum(-(-os.path.getsize(os.path.join(out, name)) // 4096) for name in written)
        heavy = what == "prebake -o"
        for old in (False, True):
            rooms = sorted({1, 2, pages // 2, pages - 1, pages, pages + 1} - {0}) if run.quick or heavy else range(1, min(pages, 14) + 2)
            for room in rooms:
                if heavy and (old or room not in (1, pages // 2, pages - 1)):
                    continue
                with Disk(out, 4 * (room + (len(written) if old else 0))):
                    for name in written if old else ():
                        with open(os.path.join(out, name), "wb") as file:
                            file.write(read(desk.path("part.cache"))[:4000] if not name.endswith("t.cache") else b"")
                        if name.endswith("t.cache"):
                            os.remove(os.path.join(out, name))
                    before = {name: read(os.path.join(out, name)) for name in written if not name.endswith(".jsonl")}
                    done = desk.do(command)
                    desk.judge(case, out, before, done.returncode, done.stderr, named=written)
                    for name in written:
                        desk.whole(case, os.path.join(out, name), None) if name.endswith(".jsonl") else None
        cases.append(case)
        with Disk(out) as disk:
            if what == "cache of a render":
                shutil.copyfile(desk.path("part.cache"), os.path.join(out, "t.cache"))
            disk.read_only()
            before = {name: read(os.path.join(out, name)) for name in written}
            done = desk.do(command)
            desk.judge(read_only, out, before, done.returncode, done.stderr, named=written)
            if done.returncode != 1:
                read_only.bad("untold", f"{what}: exit {done.returncode}")
    return [*cases, read_only]


def folders_that_go(run):
    return vanishing(run, {"folder removed": lambda out, disk: shutil.rmtree(out),
                           "folder replaced by a file": lambda out, disk: (shutil.rmtree(out), open(out, "w").close())})


def file_systems_that_go(run):
    return vanishing(run, {"file system unmounted": lambda out, disk: disk.__exit__(),
                           "file system turned read-only": lambda out, disk: disk.read_only()})


def vanishing(run, ways):
    cases = []
    for way, take_away in ways.items():
        desk, case = Desk(run, "vanish_" + way.replace(" ", "_")), Case("disk", f"{way} during a render")
        for i in range(2 if run.quick else 5):
            out = desk.path(f"out{i}")
            mounted = "file system" in way
            with Disk(out) if mounted else open(os.devnull) as disk:
                os.makedirs(out, exist_ok=True)
                telemetry = desk.path(f"run{i}.jsonl")
                process = desk.start(desk.render(out, "--spp", 1000000, telemetry=telemetry))
                wait_for(lambda: b'"pass"' in (read(telemetry) or b""))
                take_away(out, disk)
                process.send_signal(signal.SIGINT)
                stderr = process.communicate()[1].decode(errors="replace")
                # Reported, or saved to what is now at that place.
                saved = os.path.exists(os.path.join(out, "a.exr")) and os.path.exists(os.path.join(out, "t.cache"))
                case.counts["tries"] += 1
                case.saw(f"exit {process.returncode}")
                if process.returncode < 0:
                    case.bad("crashed", stderr[-200:])
                if process.returncode != (130 if saved else 1):
                    case.bad("untold", f"exit {process.returncode}, saved: {saved}: {stderr[-200:]}")
                if not saved and not ("a.exr" in stderr and "t.cache" in stderr):
                    case.bad("untold", stderr[-200:])
                if os.path.isdir(out) and strays(out):
                    case.bad("half_written", f"{strays(out)}")
        cases.append(case)
    return cases


# ---- sessions, clocks, memory, system calls -------------------------------------------------------------------------------

def sessions(run):
    chance, cases = random.Random(run.seed + 4), []
    for number, killed in ((2, 0), (8, 0), (8, 3)):
        desk = Desk(run, f"sessions{number}{killed}")
        case = Case("sessions", f"{number} on one cache" + (f", {killed} of them killed" if killed else ""))
        cache = desk.path("t.cache")
        for turn in range(1 if run.quick else 3):
            before, running = read(cache), []
            for i in range(number):
                folder = desk.path(f"{turn}_{i}")
                os.makedirs(folder, exist_ok=True)
                command = desk.render(folder, "--eccentricity", f"0.{70 + i}", cache="../t.cache", seed=turn)
                running.append((desk.start(command), time.monotonic()))
            for process, _ in running[:killed]:
                kill_within(process, after(chance.uniform(0, 1)))
            for i, (process, _) in enumerate(running):
                stderr = process.communicate()[1].decode()
                case.counts["tries"] += 1
                case.saw(f"exit {process.returncode}")
                if process.returncode != 0 and process.returncode != -signal.SIGKILL:
                    case.bad("crashed", f"exit {process.returncode}: {stderr[-200:]}")
                if process.returncode == 0 and "saved" not in stderr:
                    case.bad("untold", stderr)
                if process.returncode == 0:  # alone it learns the same: same seed, fiber of its own, nothing shared at first
                    own = desk.path(f"{turn}_{i}_own")
                    if turn == 0:
                        os.makedirs(own, exist_ok=True)
                        assert desk.do(desk.render(own, "--eccentricity", f"0.{70 + i}", seed=turn)).returncode == 0
                        desk.contains(case, read(os.path.join(own, "t.cache")), cache)
            desk.whole(case, cache, before)
        cases.append(case)
    return cases


def shim(desk):
    """The preloaded library, compiled here; None without a compiler."""
    target = desk.path("fault_shim.so")
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "fault_shim.c")
    done = subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", target, source, "-ldl"], capture_output=True, text=True)
    return target if done.returncode == 0 else None


def clocks(run):
    desk = Desk(run, "clocks")
    out, library = desk.path("out"), shim(desk)
    before = warm(desk, out)
    jumping, future = Case("clock", "wall clock jumps a day to and fro at every look"), Case("clock", "files of tomorrow, of 1970")
    if library:
        for i in range(1 if run.quick else 5):
            before = desk.snapshot(out)
            start = time.monotonic()
            done = desk.do(desk.render(out, "--time", "1", seed=i), environment={"LD_PRELOAD": library, "FAULT_CLOCK": "1"})
            desk.judge(jumping, out, before, done.returncode, done.stderr)
            lines = [json.loads(line) for line in open(os.path.join(out, "a.jsonl"))]
            if lines[-1].get("stopped_by") != "time" or not 0 <= lines[-1]["seconds"] < time.monotonic() - start:
                jumping.bad("untold", f"{lines[-1].get('stopped_by')} after {lines[-1].get('seconds')} s")
            if any(not 0 <= line["seconds"] < 60 for line in lines if line["type"] == "pass"):
                jumping.bad("untold", "a pass of negative or absurd length")
    for stamp in (time.time() + 86400, 0):
        before = desk.snapshot(out)
        stray = os.path.join(out, "t.cache.tmp-99-0")
        shutil.copyfile(os.path.join(out, "a.png"), stray)
        for name in ("t.cache", "a.exr", "t.cache.tmp-99-0"):
            os.utime(os.path.join(out, name), (stamp, stamp))
        done = desk.do(desk.render(out))
        desk.judge(future, out, before, done.returncode, done.stderr)
        if f"removed {stray}" not in done.stderr:
            future.bad("untold", "the leftover stays")
    return [jumping, future] if library else [future]


def memory(run):
    desk, limits, ceiling = Desk(run, "memory"), Case("memory", "address space of 45 to 300 MB"), Case("memory", "--table-memory .0001 to 1 MB")
    out = desk.path("out")
    warm(desk, out)
    for megabytes in range(45, 300, 40 if run.quick else 10):
        before = desk.snapshot(out)
        done = desk.do(desk.render(out), shell=f"ulimit -v {megabytes * 1000}; exec \"$@\"")
        if done.returncode == 127:
            limits.saw("the loader finds no room")
            continue
        desk.judge(limits, out, {name: content for name, content in before.items()}, done.returncode, done.stderr, named=("memory", "pthread_create"))
    for megabytes in ("0.0001", "0.001", "0.01", "0.05", "0.2", "1"):
        before = desk.snapshot(out)
        done = desk.do(desk.render(out, "--table-memory", megabytes))
        desk.judge(ceiling, out, before, done.returncode, done.stderr, named=("memory",))
    return [limits, ceiling]


def system_calls(run):
    desk, cases = Desk(run, "calls"), []
    library = shim(desk)
    if not library:
        run.say("no C compiler: failing system calls are left out")
        return []
    out = desk.path("out")
    warm(desk, out)
    assert desk.do(desk.render(desk.folder, "--eccentricity", "0.7", cache="other.cache")).returncode == 0
    merge = [desk.tress, "cache", "merge", os.path.join(out, "t.cache"), desk.path("other.cache"), "-o", os.path.join(out, "t.cache")]
    kept = read(os.path.join(out, "t.cache"))
    for call, errors in (("open", (24, 13)), ("write", (28, 5)), ("fsync", (5, 28)), ("rename", (5,)), ("fchmod", (1,))):
        case = Case("system calls", f"{call} fails, each in turn")
        for command in [merge] if run.quick else [merge, desk.render(out)]:
            for error in errors:
                for at in range(1, 40):
                    with open(os.path.join(out, "t.cache"), "wb") as file:
                        file.write(kept)
                    reported, before = desk.path("reported"), desk.snapshot(out)
                    if os.path.exists(reported):
                        os.remove(reported)
                    done = desk.do(command, environment={"LD_PRELOAD": library, "FAULT_CALL": call, "FAULT_AT": str(at),
                                                         "FAULT_ERRNO": str(error), "FAULT_MARK": reported})
                    if not os.path.exists(reported):
                        break
                    desk.judge(case, out, before, done.returncode, done.stderr)
                    if done.returncode == 0 and call != "fchmod":
                        case.bad("untold", f"{command[1]}: {call} {at} failed, exit 0")
        cases.append(case)
    case, before = Case("system calls", "a file system without locks"), desk.snapshot(out)
    done = desk.do(desk.render(out), environment={"LD_PRELOAD": library, "FAULT_LOCKS": "1"})
    desk.judge(case, out, before, done.returncode, done.stderr)
    return [*cases, case]


# ---- streams, names -------------------------------------------------------------------------------------------------------

def streams(run):
    desk, case = Desk(run, "streams"), Case("streams", "full, closed, or a pipe that nobody reads")
    out, cache = desk.path("out"), desk.path("out/t.cache")
    warm(desk, out)
    looks = ([desk.tress, "cache", "info", cache], [desk.tress, "cache", "verify", cache, "--json"],
             [desk.tress, "diff", desk.path("out/a.exr"), desk.path("out/a.exr"), "--json"], [desk.tress, "--help"],
             [desk.tress, "fit", "--lobe", "TT", "--e", ".85", "--theta-d", "30", "--phi", "45", "--sigma", "20", "--json"])
    tries = [(look, f"exec \"$@\" {where}", 1, "standard output") for look in looks for where in ("> /dev/full", ">&-")]
    pipe = desk.path("pipe")
    os.mkfifo(pipe)
    shapes = {"exec \"$@\" 2>&-": 0, "exec \"$@\" 2> /dev/full": 0, "exec \"$@\" 0>&- 1>&- 2>&-": 0}
    tries += [(desk.render(out), shape, status, None) for shape, status in shapes.items()]
    tries += [(desk.render(out, "--spp", "64", telemetry=pipe), f"head -n 1 {pipe} > /dev/null & exec \"$@\"", 1, "telemetry stops"),
              (desk.render(out, telemetry="/dev/full"), "exec \"$@\"", 1, "/dev/full"),
              (desk.render(out), "ulimit -f 4; exec \"$@\"", 1, "a.exr")]
    for command, shell, status, words in tries:
        before = desk.snapshot(out)
        done = desk.do(command, shell=shell)
        desk.judge(case, out, before, done.returncode, done.stderr, named=(words,) if words else ())
        if done.returncode != status:
            case.bad("untold", f"{shell}: {command[1]}: exit {done.returncode}: {done.stderr[-200:]}")
    return [case]


def names(run):
    desk, case = Desk(run, "names"), Case("names", "links, devices, folders, lengths, alphabets")
    out = desk.path("out")
    warm(desk, out)
    real = desk.path("real")
    os.makedirs(real)
    shutil.copyfile(os.path.join(out, "t.cache"), os.path.join(real, "c"))
    os.chmod(os.path.join(real, "c"), 0o640)
    os.chown(os.path.join(real, "c"), 12345 if os.geteuid() == 0 else -1, -1)
    os.remove(os.path.join(out, "t.cache"))
    os.symlink(os.path.join(real, "c"), os.path.join(out, "t.cache"))
    os.link(os.path.join(real, "c"), os.path.join(real, "hard"))
    hard, owner = read(os.path.join(real, "hard")), os.stat(os.path.join(real, "c")).st_uid
    before = desk.snapshot(out)
    done = desk.do(desk.render(out, seed=3))
    desk.judge(case, out, before, done.returncode, done.stderr)
    status = os.stat(os.path.join(real, "c"))
    for good, why in ((os.path.islink(os.path.join(out, "t.cache")), "the link became a file"),
                      (read(os.path.join(real, "hard")) == hard, "the hard link changed"),
                      (status.st_mode & 0o777 == 0o640 and status.st_uid == owner, "permissions or owner changed")):
        if not good:
            case.bad("lost", why)
    os.symlink("/dev/null", desk.path("null.exr"))
    os.makedirs(desk.path("folder.exr"))
    long = "x" * 247
    plain = [desk.tress, "render", desk.scene, "--quiet", "--spp", "1"]
    odd = desk.path("\u00e4 \u9aea\n'")
    for command, status in (([*plain, "-o", desk.path("null.exr")], 1), ([*plain, "-o", desk.path("folder.exr")], 1),
                            ([*plain, "-o", desk.path("b.exr"), "--warm-cache", desk.path("folder.exr")], 1),
                            ([*plain, "-o", desk.path("b.exr"), "--telemetry", desk.path("folder.exr")], 1),
                            ([*plain, "-o", desk.path("b.exr"), "--warm-cache", "/dev/null", "--cache-mode", "scratch"], 1),
                            ([*plain, "-o", desk.path("b.exr"), "--warm-cache", desk.path("b.exr")], 2),
                            ([*plain, "-o", desk.path(long + ".exr")], 1), ([*plain, "-o", desk.path("b.exr"), "--warm-cache", desk.path(long)], 1),
                            ([*plain, "-o", odd + ".exr", "--warm-cache", odd, "--telemetry", odd + ".jsonl"], 0)):
        done = desk.do(command)
        desk.judge(case, desk.folder, {}, done.returncode, done.stderr)
        if done.returncode != status:
            case.bad("untold", f"{command[6:]}: exit {done.returncode}")
    if not os.path.exists("/dev/null") or os.path.isfile("/dev/null"):
        case.bad("lost", "/dev/null is gone")
    return [case]


# ---- the table ------------------------------------------------------------------------------------------------------------

def draw(data, path):
    cases = data["cases"]
    chart = charts.Chart("Faults: tries, and how often something was lost, half written, unreported, or crashed", columns=1, rows=1,
                         width=11, height=0.8 + 0.21 * (len(cases) + 1))
    axis = chart.axes[0]
    axis.set_axis_off()
    text = [[case["group"], case["fault"], *(f"{case[name]:,}" for name in COLUMNS)] for case in cases]
    text.append(["all", "", *(f"{sum(case[name] for case in cases):,}" for name in COLUMNS)])
    good, bad = "#d9f0d3", "#f4a582"
    colors = [["white", "white", "white", *(bad if value.replace(",", "") != "0" else good for value in row[3:])] for row in text]
    table = axis.table(cellText=text, cellColours=colors, loc="center", cellLoc="left", bbox=[0, 0, 1, 1],
                       colLabels=["", "fault", "tries", "lost", "half written", "unreported", "crashed"],
                       colWidths=[0.14, 0.42, 0.1, 0.08, 0.1, 0.08, 0.08])
    table.auto_set_font_size(False)
    table.set_fontsize(8)
    for (row, column), cell in table.get_celld().items():
        cell.set_linewidth(0.3)
        if row in (0, len(text)):
            cell.set_text_props(weight="bold")
        if column >= 2:
            cell.set_text_props(ha="right")
    chart.save(path)
