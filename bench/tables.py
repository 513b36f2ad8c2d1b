#!/usr/bin/env python3
"""Measures what the tables of bench/README.md were made of: bench/results/*.json, each with its command and its context.

usage: bench/tables.py [--tress PROGRAM] [-o FOLDER] [--only TEXT ...] [--list]

    (nothing)      all of them into build/tables (some twenty minutes of CPU)
    -o FOLDER      bench/results, to store them
    --only TEXT    those whose names contain one of these
    --list         names and commands

`./bootstrap bench --all` does this, all charts and all of the atlas. Each program of bench/accuracy may print or write JSON;
here "context" (commit, compiler, load, seconds of CPU) and "command" are put beside what it says.
"""
import argparse
import json
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "charts"))
import charts  # noqa: E402

TO_STDOUT = {"models", "knots"}  # the others write the file that --json names


def tables():
    """{file in bench/results: [program, argument, ...]}, in the order of the documents."""
    found = {}

    def rows(name, *arguments):
        found[f"rows_{name}.json"] = ["rows", *arguments]

    for domain in ("wide", "hard"):
        for epsilon in (".01", ".001"):
            base = ["--domain", domain, "--epsilon", epsilon]
            rows(f"{domain}_{epsilon}", "--rows", "2000", *base)
            rows(f"{domain}_{epsilon}_10000", "--rows", "10000", "--seed", "7", *base)
            for learner in ("sketch", "eager", "em", "appendix", "appendix-literal", "table", "ais"):
                if learner != "ais" or epsilon == ".01":
                    rows(f"{learner}_{domain}_{epsilon}", "--rows", "1000", "--learner", learner, *base)
        base = ["--rows", "2000", "--domain", domain, "--epsilon", ".01"]
        rows(f"{domain}_.01_split", "--trt", "split", *base)
        for sigma_a in ("1", "3"):
            rows(f"{domain}_.01_sigma_a_{sigma_a}", "--sigma-a", sigma_a, *base)
    rows("narrow_.01", "--rows", "2000", "--domain", "narrow", "--epsilon", ".01")
    for vertices in ("4", "32"):
        rows(f"wide_.01_{vertices}_a_pass", "--rows", "2000", "--domain", "wide", "--epsilon", ".01", "--vertices", vertices)
    for domain in ("wide", "hard"):
        found[f"ais_{domain}.json"] = ["ais", "--rows", "1000", "--domain", domain, "--set", "core", "--only", "both"]
    found["ais_paper.json"] = ["ais", "--rows", "300", "--domain", "paper", "--set", "core"]
    found["ais_paper_variants.json"] = ["ais", "--rows", "100", "--domain", "paper", "--set", "variants"]
    found["models.json"] = ["models"]
    found["knots_micro.json"] = ["knots", "--benchmark_min_time=0.03", "--benchmark_repetitions=3", "--benchmark_format=json"]
    found["far_field.json"] = ["far_field"]
    found["sampled_rows.json"] = ["sampled_rows", "--rows", "300"]
    found["rough_far_field.json"] = ["rough_far_field"]
    found["rough_far_field_36x36.json"] = ["rough_far_field", "--model", "rough", "--theta-bins", "36", "--phi-bins", "36"]
    found["slab.json"] = ["slab"]
    found["reciprocity.json"] = ["reciprocity"]
    return found


def measure(run, name, command, folder):
    target = os.path.join(folder, name)
    wanted = list(command[1:])
    if command[0] not in TO_STDOUT:
        wanted += ["--json", target]
    before = charts.context(run)
    done = run.bench(command[0], *wanted)
    if command[0] in TO_STDOUT:
        data = json.loads(done.stdout)
    else:
        with open(target) as file:
            data = json.load(file)
    if isinstance(data, list):
        data = {"cases": data}
    context = {**data.get("context", {}), **before, "load_after": os.getloadavg()[0], "cpu_seconds": round(done.cpu, 1)}
    del context["quick"], context["seed"]  # the programs' own seeds are in what they say
    charts.save(target, {"command": "bench_" + " ".join(command), "context": context,
                         **{key: value for key, value in data.items() if key != "context"}})
    print(f"{name:40} {done.cpu:7.1f} s of CPU", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tress", default=os.path.join(charts.ROOT, "build", "release", "tress"))
    parser.add_argument("-o", "--output", default=os.path.join(charts.ROOT, "build", "tables"))
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    wanted = {name: command for name, command in tables().items()
              if not options.only or any(text in name for text in options.only)}
    if options.list:
        for name, command in wanted.items():
            print(f"{name:40} bench_{' '.join(command)}")
        return
    os.makedirs(options.output, exist_ok=True)
    run = charts.Run(options.tress, os.path.join(charts.ROOT, "build", "tables"))
    failed = []
    for name, command in wanted.items():
        try:
            measure(run, name, command, options.output)
        except RuntimeError as error:
            print(f"{name}: {error}", file=sys.stderr)
            failed.append(name)
    if failed:
        sys.exit("not measured: " + ", ".join(failed))


if __name__ == "__main__":
    main()
