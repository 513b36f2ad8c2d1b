#!/usr/bin/env python3
"""Writes bench/results/README.md: every stored figure with the commit it was made by and its date.

usage: bench/figures_table.py [--check]

--check writes nothing and ends with 1 where a figure names no commit of the history. The test StoredFigures asks the same of
every build.
"""
import glob
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
RESULTS = os.path.join(ROOT, "bench", "results")


def git(*words):
    done = subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else None


def stored():
    """[(name, context)] of every JSON in bench/results."""
    found = []
    for path in sorted(glob.glob(os.path.join(RESULTS, "**", "*.json"), recursive=True)):
        with open(path) as file:
            content = json.load(file)
        context = content.get("context", {}) if isinstance(content, dict) else {}
        found.append((os.path.relpath(path, RESULTS), context))
    return found


def main():
    lost, groups = [], {}
    for name, context in stored():
        commit = context.get("commit", "")
        if not re.fullmatch("[0-9a-f]{40}", commit) or git("merge-base", "--is-ancestor", commit, "HEAD") is None:
            lost.append(name)
        stem = re.sub(r"rows_.*\.json", "rows_*.json", name)
        groups.setdefault((stem, commit), []).append(context)
    for name in lost:
        print(f"{name}: no commit of the history", file=sys.stderr)
    if lost or "--check" in sys.argv:
        sys.exit(1 if lost else 0)
    rows = {}
    for (stem, commit), contexts in sorted(groups.items()):
        remarks = []
        if contexts[0].get("quick"):
            remarks.append("`--quick`")
        if contexts[0].get("changed_files"):
            remarks.append(f"{contexts[0]['changed_files']} files changed")
        name = stem.removesuffix(".json") + (f" ({len(contexts)})" if len(contexts) > 1 else "")
        rows.setdefault((commit, ", ".join(remarks)), []).append(name)
    lines = ["# Stored figures", "",
             "Written by `bench/figures_table.py`; `StoredFigures` holds that every commit is in the history. `./bootstrap bench --all`",
             "makes all again, in a night. *Changed*: files that were not committed.", "",
             "| commit | date | figures (files) | remarks |", "|---|---|---|---|"]
    for (commit, remarks), names in sorted(rows.items(), key=lambda row: row[1]):
        lines.append(f"| {commit[:10]} | {git('show', '-s', '--format=%cs', commit)} | {', '.join(names)} | {remarks} |")
    with open(os.path.join(RESULTS, "README.md"), "w") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
