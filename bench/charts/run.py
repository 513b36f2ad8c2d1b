#!/usr/bin/env python3
"""Measures and draws the charts of speed against accuracy, or the atlas of where methods fail.

usage: bench/charts/run.py [--all] [--atlas] [--quick] [--short] [--chart N ...] [--references] [--draw] [-o FOLDER] [--tress PROGRAM] [--seed N] [--rounds N]

    (nothing)      every chart in full, up to an hour each
    --all          everything that bench/results stores, into it: the charts with their references, the atlas, the tables of
                   bench/tables.py, and bench/results/README.md, which says by which commits. A night
    --atlas        the studies of bench/atlas in place of the charts; what follows holds for both
    --quick        every chart in five minutes altogether: fewer rows, smaller pictures, more noise
    --short        of chart 9: small pictures of every groom, three rounds, some fifteen minutes of CPU
    --chart N      these charts only, by number or name
    --references   makes the converged references that the charts compare with (hours; goes on where it was stopped)
    --rounds N     of the charts of pictures (4, 5, 6, 9): how often rivals take turns, in place of the chart's own number
    --draw         draws from the JSON that is there, measures nothing

Writes NAME.json, NAME.png and NAME.svg into FOLDER (build/charts or build/atlas; of full runs bench/results/charts and
bench/results/atlas hold what the documents say). References are kept in build/references, or in the folder that TRESS_REFERENCES names. Needs Debian's
python3-openimageio, python3-matplotlib and python3-numpy (/usr/bin/python3), and tress and the target `benches`, built.
"""
import argparse
import glob
import importlib.util
import json
import os
import subprocess
import sys
import time

import charts


def modules(folder):
    """{number and name: module} of every chart in this folder of bench/, in order."""
    found = {}
    for path in sorted(glob.glob(os.path.join(charts.ROOT, "bench", folder, "[0-9][0-9]_*.py"))):
        name = os.path.basename(path)[:-3]
        spec = importlib.util.spec_from_file_location("chart_" + name, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        found[name] = module
    return found


def chosen(found, wanted):
    """The charts that `wanted` names: "4", "04_image" or "image"; all of them if it is empty."""
    if not wanted:
        return found
    names = {}
    for word in wanted:
        fits = [name for name in found if word in (name, name[3:], name[:2]) or word.zfill(2) == name[:2]]
        if not fits:
            sys.exit(f"--chart {word}: expected one of {', '.join(str(int(n[:2])) + ' (' + n[3:] + ')' for n in found)}")
        names.update({name: found[name] for name in fits})
    return names


def everything(tress):
    """Each part in a process of its own, so that one that fails leaves the others; the number of those that failed."""
    results, here = os.path.join(charts.ROOT, "bench", "results"), os.path.abspath(__file__)
    tables = os.path.join(charts.ROOT, "bench", "tables.py")
    parts = [[here, "--references", "--tress", tress], [here, "--tress", tress, "-o", os.path.join(results, "charts")],
             [here, "--atlas", "--tress", tress, "-o", os.path.join(results, "atlas")],
             [tables, "--tress", tress, "-o", results], [os.path.join(charts.ROOT, "bench", "figures_table.py")]]
    return sum(subprocess.run([sys.executable, *part]).returncode != 0 for part in parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--atlas", dest="folder", action="store_const", const="atlas", default="charts")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--chart", action="append", default=[], metavar="N")
    parser.add_argument("--references", action="store_true")
    parser.add_argument("--draw", action="store_true")
    parser.add_argument("-o", "--output")
    parser.add_argument("--tress", default=os.path.join(charts.ROOT, "build", "release", "tress"))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rounds", type=int)
    parser.add_argument("--check", action="store_true", help="only whether these are arguments")
    options = parser.parse_args()
    wanted = chosen(modules(options.folder), options.chart)
    if options.check:
        return
    if options.all:
        sys.exit(everything(options.tress))
    work = os.path.join(charts.ROOT, "build", options.folder)
    output = options.output or work
    os.makedirs(output, exist_ok=True)
    failed = []
    for name, module in wanted.items():
        target = os.path.join(output, name + ".json")
        start = time.monotonic()
        if not options.draw:
            print(f"{name}: {module.TITLE}", file=sys.stderr, flush=True)
            run = charts.Run(options.tress, os.path.join(work, name), options.quick, options.seed)
            run.rounds, run.short = options.rounds, options.short
            if options.references:
                if hasattr(module, "references"):
                    module.references(run)
                continue
            before = charts.context(run)
            try:
                data = module.measure(run)
            except RuntimeError as error:  # a program that failed: the other charts are still drawn
                print(f"{name}: {error}", file=sys.stderr)
                failed.append(name)
                continue
            after = charts.context(run)
            charts.save(target, {"chart": name, "context": {**before, "load_after": after["load"], "inputs": run.inputs,
                                                            "seconds": round(time.monotonic() - start, 1)},
                                 "data": data})
        elif options.references or not os.path.exists(target):
            continue
        with open(target) as file:
            stored = json.load(file)
        module.draw(stored["data"], os.path.join(output, name))
        print(os.path.join(output, name + ".png"))
    if failed:
        sys.exit("not measured: " + ", ".join(failed))


if __name__ == "__main__":
    main()
