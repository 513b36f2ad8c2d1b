#!/usr/bin/env python3
"""Runs every bench program at its smallest, and every script of pictures and charts that takes seconds: whether they still work.

usage: bench/smoke.py [BUILD]    (build/release; `tress` and the target `benches` are built there)

Nothing here is a measurement. A program without a line in SMALLEST fails the run, so that a new one gets its own.
Scripts need Debian's python3-openimageio, python3-matplotlib and python3-numpy: run by /usr/bin/python3.
"""
import glob
import os
import resource
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LOCK = os.path.join(ROOT, "scenes", "curly_lock.json")
ORACLE = os.path.join(ROOT, "tests", "reference", "fiber3d.csv")
GOOGLE = ["--benchmark_min_time=0.001"]


def smallest(cache, folder):
    """{program: arguments}; a list of lists where a program has several commands."""
    small = ["--size", "12x12", "--spp", "1"]
    return {
        "environment": GOOGLE, "knots": GOOGLE, "lobes": GOOGLE, "queries": GOOGLE, "rays": GOOGLE,
        "table": GOOGLE + ["--benchmark_filter=density/5|traced_nodes/5|fit/64/100|look_up/20"],
        "vertex": GOOGLE + ["--benchmark_filter=converged|start_up(_shapes)?/1/"],
        "model_vertices": GOOGLE + ["--benchmark_filter=learned|chiang|session.*/30/"],
        "azimuthal_rivals": GOOGLE + ["--benchmark_filter=hard/(sketch 0.01|knots 32|deon2011 10|chiang2016|ou2012)/"],
        "ais": ["--rows", "2", "--only", "both"],
        "azimuth": ["deon2011", "TT", "30", "10", "10", "1", "90"],
        "azimuthal_curves": [],
        "far_field": ["--paths", "2000", "--e", "0.85", "--alpha", "0.1", "--theta", "30", "--phi", "45"],
        "fiber3d": [ORACLE], "fiber3d_tracer": [ORACLE, "2000"],
        "grid": ["2"], "learning": ["--rows", "4"], "longitudinal_shapes": ["--paths", "2000"],
        "models": ["--model", "chiang2016", "--samples", "1000"],
        "pekelis_rows": ["--rows", "2"], "picture_bias": [LOCK, cache] + small + ["--seeds", "2"],
        "ribbons": ["--truth-paths", "16384", "--e", "0.85", "--alpha", "0.2", "--theta", "30"],
        "rows": ["--rows", "8"], "sampled_rows": ["--rows", "2", "--paths", "4096"],
        "reciprocity": ["--model", "fiber3d,elliptical", "--paths", "2000"],
        "rough_far_field": ["--paths", "2000", "--points", "100", "--theta-bins", "12", "--phi-bins", "18", "--e", "0.85",
                            "--alpha", "0.2", "--theta", "30"],
        "steps": [LOCK, "--size", "12x12", "--spp", "2", "--seeds", "2"],
        "layered_conductor": ["--size", "8", "--samples", "2", "--truth", "2"],
        "lock_color": ["--paths", "200", "--eccentricity", "0.85", "--roughness", "0.2", "--tilt", "3", "--eta", "1.55"],
        "slab": ["--model", "elliptical", "--paths", "100"],
        "deeper": [LOCK, "--size", "12", "--spp", "2", "--teach", "1", "--pairs", "3"],
        "replay": [LOCK, "--width", "16", "--height", "16", "--teach", "1", "--repeat", "1", "--inside", "0.01"],
        "atlas_faults": ["bytes", cache, "--rows", "1"],
        "atlas_images": [LOCK, "-o", os.path.join(folder, "images.exr"), "--resolution", "12x12", "--spp", "1"],
        "atlas_learning": ["--rows", "4", "--rival-rows", "1"],
        "atlas_loop": [LOCK] + small + ["--seeds", "1"],
        "atlas_maps": ["--quick", "--samples", "200", "--slice", "alpha"],
        "atlas_pages": ["--pages", "1000", "--queries", "200"],
        "atlas_queries": ["--fibers", "1", "--queries", "2000", "--case", "elliptical"],
        "atlas_soak": [LOCK, "--lives", "2"] + small,
    }


def scripts(tress, folder):
    """[(name, command)] of those that take seconds."""
    python = "/usr/bin/python3"
    charts = [os.path.join(ROOT, "bench", "charts", "run.py"), "--tress", tress, "--quick", "-o", folder]
    return [
        ("charts/run.py 1 3", [python, *charts, "--chart", "1", "--chart", "3"]),
        ("figures/check_reading.py", [python, os.path.join(ROOT, "bench", "figures", "check_reading.py")]),
        ("image/estimators.py", [python, os.path.join(ROOT, "bench", "image", "estimators.py"), tress, LOCK, "--samples", "2",
                                 "--teach", "1", "--repeat", "2", "--size", "12x12"]),
        ("image/models.py", [python, os.path.join(ROOT, "bench", "image", "models.py"), os.path.dirname(tress), "--spp", "1",
                             "--seeds", "3", "--truth", "0", "--only", "curly lock, light", "-o",
                             os.path.join(folder, "models.json")]),
        ("image/varying_cost.py", [python, os.path.join(ROOT, "bench", "image", "varying_cost.py"), os.path.dirname(tress), "--spp",
                                   "1", "--seeds", "2"]),
        ("shots/kills.py", [python, os.path.join(ROOT, "bench", "shots", "kills.py"), os.path.dirname(tress), "--kills", "2",
                            "--spp", "4"]),
        ("shots/live_page.py", [python, os.path.join(ROOT, "bench", "shots", "live_page.py"), os.path.dirname(tress), "--rounds", "1",
                                "--cost-rounds", "1", "--size", "16x16", "--spp", "1", "--scene", LOCK]),
        ("shots/million.py", [python, os.path.join(ROOT, "bench", "shots", "million.py"), os.path.dirname(tress), "--strands", "300",
                              "--spp", "1", "--size", "12x12"]),
        ("shots/checkpoint_cost.py", [python, os.path.join(ROOT, "bench", "shots", "checkpoint_cost.py"), os.path.dirname(tress),
                                      "--rounds", "2", "--size", "16x16", "--spp", "1"]),
        ("shots/turntable.py", [python, os.path.join(ROOT, "bench", "shots", "turntable.py"), os.path.dirname(tress), "--frames",
                                "2", "--size", "12x12", "--spp", "2", "-o", os.path.join(folder, "turntable.json")]),
        ("shots/workers.py", [python, os.path.join(ROOT, "bench", "shots", "workers.py"), os.path.dirname(tress), "--caches", "3",
                              "--size", "12x12", "--spp", "2", "-o", os.path.join(folder, "workers.json")]),
    ]


def run(name, command, folder, environment=None):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env={**os.environ, **(environment or {})})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(f"{name:24} {cpu:7.1f} s of CPU", "" if done.returncode == 0 else f"  FAILED, exit {done.returncode}", flush=True)
    if done.returncode != 0:
        print(" ".join(command) + "\n" + (done.stdout[-2000:] + done.stderr[-2000:]).strip(), file=sys.stderr)
    ran = done.returncode == 0 and "Failed to match any benchmarks" not in done.stderr
    return ran, cpu


def main():
    build = os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else os.path.join(ROOT, "build", "release")
    tress = os.path.join(build, "tress")
    programs = {os.path.basename(path)[6:]: path for path in sorted(glob.glob(os.path.join(build, "bench", "bench_*")))
                if os.access(path, os.X_OK)}
    passed, failed, total = 0, [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        cache = os.path.join(folder, "small.cache")
        subprocess.run([tress, "render", LOCK, "-o", os.path.join(folder, "small.exr"), "--quiet", "--resolution", "16x16",
                        "--spp", "4", "--warm-cache", cache], check=True)
        lines = smallest(cache, folder)
        wanted = [("bench_" + name, [path, *lines[name]]) for name, path in programs.items() if name in lines]
        failed += [f"{name}: no line in bench/smoke.py" for name in programs if name not in lines]
        failed += [f"{name}: in bench/smoke.py, not built" for name in lines if name not in programs]
        for name, command in wanted + scripts(tress, folder):
            well, cpu = run(name, command, folder, {"TRESS_BENCH_ROWS": "4"})
            total += cpu
            passed += well
            failed += [] if well else [name]
    for name in failed:
        print(f"bench/smoke.py: {name}", file=sys.stderr)
    print(f"{passed} passed, {len(failed)} failed: {total:.0f} s of CPU")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
