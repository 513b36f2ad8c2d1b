#!/usr/bin/env python3
"""The architecture, drawn from the includes: folders as boxes, in layers, with an arrow where a folder includes another.

    bench/figures/architecture.py            # writes src/architecture.svg; needs Debian's graphviz
    bench/figures/architecture.py --check    # exit 1 if the includes are no longer those that were drawn; needs no graphviz

An arrow that follows from others is left out: A -> C where A -> B -> C is drawn. The list of all arrows is a comment at
the head of the SVG, and --check compares that list.
"""
import argparse
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PICTURE = os.path.join(ROOT, "src", "architecture.svg")
ROOMS = ("include", "adaptive", "src", "bench/references", "bench/lab")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.M)
GROUPS = [  # title, color, the folders that begin so
    ("include/tress: what a host includes", "#dbe9f6", "include/tress"),
    ("adaptive: the learning service", "#dff0d8", "adaptive"),
    ("src: the renderer and its models", "#fbeccb", "src"),
    ("bench: the laboratory", "#f2dede", "bench"),
]

SAYS = {  # a phrase for a folder; one without is drawn with its name alone
    "include/tress": "versions, the C interface",
    "include/tress/base": "errors, random numbers,\nreplacement of files",
    "include/tress/adaptive": "the service's interface",
    "include/tress/fiber": "the BCSDF's interface",
    "adaptive/density": "what a row answers by",
    "adaptive/observations": "what a row remembers",
    "adaptive/convergence": "the stop test",
    "adaptive/fit": "the shipped fitters",
    "adaptive/table": "the life of a row",
    "adaptive/cache": "the table as a file",
    "adaptive/telemetry": "JSON lines",
    "src": "main",
    "src/capi": "the C interface",
    "src/base": "numerics, files, lanes",
    "src/fiber": "one fiber's optics",
    "src/models": "ours and the traced truth",
    "src/models/lobes": "what models share",
    "src/models/elliptical": "our model", "src/models/rough": "rows of samples",
    "bench/references": "the rivals by name",
    "bench/references/models": "the rivals' models",
    "bench/references/learners": "the rivals' learners",
    "bench/lab": "tress-lab",
    "src/image": "OpenEXR and PNG",
    "src/denoise": "halves of a picture\ninto one",
    "src/scene/model": "what a scene is",
    "src/scene/generate": "grooms and skies by recipe",
    "src/scene/read": "files into scenes",
    "src/scene/read/grooms": "a file format a row",
    "src/geometry": "Embree, hits, frames",
    "src/integrate": "path tracing, film",
    "src/cli": "the command line",
    "src/python": "import tress",
}


def folder_of(name):
    """The folder of a file of ours that an include names, None for all others."""
    for root in ("include", "adaptive", "src", "bench"):
        if os.path.isfile(os.path.join(ROOT, root, name)):
            return os.path.dirname(f"{root}/{name}")
    return None


def arrows():
    """Every pair (folder, folder that it includes), and every folder."""
    pairs, folders = set(), set()
    for room in ROOMS:
        for where, _, files in os.walk(os.path.join(ROOT, room)):
            folder = os.path.relpath(where, ROOT)
            for file in files:
                if not file.endswith((".h", ".cpp")):
                    continue
                with open(os.path.join(where, file)) as stream:
                    text = stream.read()
                folders.add(folder)
                for name in INCLUDE.findall(text):
                    other = folder_of(name)
                    if other and other != folder:
                        pairs.add((folder, other))
    return pairs, folders


def reduced(pairs):
    """The pairs that do not follow from others."""
    def reach(start, without):
        seen, front = set(), [start]
        while front:
            at = front.pop()
            for a, b in pairs:
                if a == at and (a, b) != without and b not in seen:
                    seen.add(b)
                    front.append(b)
        return seen
    return {(a, b) for a, b in pairs if b not in reach(a, (a, b))}


def listing(pairs):
    return "\n".join(f"{a} -> {b}" for a, b in sorted(pairs))


def dot(pairs, folders):
    out = ["digraph tress {", 'rankdir=TB; nodesep=0.25; ranksep=0.45; fontname="Helvetica"; splines=true;',
           'node [shape=box style="filled,rounded" fontname="Helvetica" fontsize=12 color="#808080"];',
           'edge [color="#606060" arrowsize=0.6];']
    for index, (title, color, start) in enumerate(GROUPS):
        out.append(f'subgraph cluster_{index} {{ label="{title}"; labeljust=l; color="#b0b0b0"; style=rounded;')
        for folder in sorted(folders):
            if folder == start or folder.startswith(start + "/"):
                label = "\\n".join([folder] + SAYS.get(folder, "").split("\n")).removesuffix("\\n")
                out.append(f'"{folder}" [fillcolor="{color}" label="{label}"];')
        out.append("}")
    out += [f'"{a}" -> "{b}";' for a, b in sorted(reduced(pairs))]
    return "\n".join(out + ["}"])


def drawn():
    """The list at the head of the picture; None without one."""
    if not os.path.isfile(PICTURE):
        return None
    with open(PICTURE) as stream:
        found = re.search(r"<!-- arrows\n(.*?)\n-->", stream.read(), re.S)
    # XML forbids "--" in comments: an arrow is written "to" there.
    return found.group(1).replace(" to ", " -> ") if found else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only compare")
    options = parser.parse_args()
    pairs, folders = arrows()
    if options.check:
        known = set((drawn() or "").splitlines())
        found = set(listing(pairs).splitlines())
        for arrow in sorted(found - known):
            print(f"src/architecture.svg: not drawn: {arrow}", file=sys.stderr)
        for arrow in sorted(known - found):
            print(f"src/architecture.svg: no longer there: {arrow}", file=sys.stderr)
        if known != found:
            sys.exit("to draw it again: bench/figures/architecture.py")
        return
    made = subprocess.run(["dot", "-Tsvg"], input=dot(pairs, folders), capture_output=True, text=True, check=True).stdout
    head = "<!-- arrows\n" + listing(pairs).replace(" -> ", " to ") + "\n-->\n"
    with open(PICTURE, "w") as stream:
        stream.write(made.replace("<svg ", head + "<svg ", 1))
    print(PICTURE)


if __name__ == "__main__":
    main()
