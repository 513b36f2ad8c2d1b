#!/usr/bin/env python3
"""What a million strands of 16 points cost, in .hair, .usda and .abc: to read, and to render.

usage: bench/shots/million.py [BUILD] [--strands 1000000] [--points 16] [--spp 4] [--size 64x64] [--no-render] [-o FILE]

A row a file: CPU time of `tress info` and the largest resident memory of it, also over that of the floats of the groom, three
a point and one for its width; then the same of `tress render`. What the program takes before it has read anything is in both.
Files are made in a folder of their own and removed. Needs numpy, some 2 GB of disk, and for the render 4 GB of memory.
"""
import argparse
import json
import multiprocessing
import os
import struct
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def write_files(files, strands, points_a_strand):
    """In a process of its own: what it takes would count as memory of those that are started after it."""
    import numpy as np
    sys.path.insert(0, os.path.join(ROOT, "tests", "scene", "grooms"))
    import ogawa_writer

    class Archive(ogawa_writer.Archive):
        """Samples of arrays without a list of numbers."""

        def sample(self, pod, values):
            return self.data(bytes(16) + values.tobytes()) if isinstance(values, np.ndarray) else super().sample(pod, values)

    # A lock of 20 cm, a little waved, thinner towards the tip.
    random = np.random.default_rng(1)
    along = np.linspace(0, 1, points_a_strand, dtype=np.float32)
    phase = random.uniform(0, 2 * np.pi, (strands, 1)).astype(np.float32)
    points = np.empty((strands, points_a_strand, 3), np.float32)
    points[:, :, :2] = random.uniform(-10, 10, (strands, 1, 2))
    points[:, :, 0] += along * np.sin(3 * along + phase) / 2
    points[:, :, 1] += along * np.cos(3 * along + phase) / 2
    points[:, :, 2] = -20 * along
    widths = np.tile(np.linspace(0.008, 0.004, points_a_strand, dtype=np.float32), strands)

    header = struct.pack("<4sIIII", b"HAIR", strands, widths.size, 2 | 4, points_a_strand - 1)
    with open(files["hair"], "wb") as out:
        out.write(header.ljust(128, b"\0"))
        points.tofile(out)
        widths.tofile(out)
    archive = Archive()
    geometry = [archive.array("P", "f32", points, 3),
                archive.array("nVertices", "i32", np.full(strands, points_a_strand, np.int32)),
                archive.scalar("curveBasisAndType", "u8", (0, 0, 2, 2)),
                archive.array("width", "f32", widths, 1, ogawa_writer.scope("vtx"))]
    curves = archive.object([archive.nested(".geom", geometry, "schema=AbcGeom_Curve_v2")], [])
    with open(files["abc"], "wb") as out:
        out.write(archive.finish(archive.object([], [("hair", curves, ogawa_writer.CURVE)])))


def measured(command):
    """CPU seconds in the program and in the system, and the largest resident memory in bytes, of it alone."""
    process = os.posix_spawn(command[0], command, os.environ, file_actions=[
        (os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0), (os.POSIX_SPAWN_OPEN, 2, os.devnull, os.O_WRONLY, 0)])
    _, status, usage = os.wait4(process, 0)
    if status != 0:
        sys.exit(" ".join(command) + " failed")
    return {"user_s": usage.ru_utime, "system_s": usage.ru_stime, "bytes": usage.ru_maxrss * 1024}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("--strands", type=int, default=1_000_000)
    parser.add_argument("--points", type=int, default=16)
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--size", default="64x64")
    parser.add_argument("--no-render", action="store_true")
    parser.add_argument("-o", "--output")
    options = parser.parse_args()
    tress = os.path.join(os.path.abspath(options.build), "tress")
    floats = 16 * options.strands * options.points
    rows = []
    with tempfile.TemporaryDirectory(prefix="tress_million_") as folder:
        files = {ending: os.path.join(folder, "million." + ending) for ending in ("hair", "usda", "abc")}
        writer = multiprocessing.Process(target=write_files, args=(files, options.strands, options.points))
        writer.start()
        writer.join()
        measured([tress, "convert", files["hair"], files["usda"]])
        print("| file | MB | read: CPU s | memory MB | over the floats | render: CPU s | memory MB |\n|---|---|---|---|---|---|---|")
        for ending, path in files.items():
            read = measured([tress, "info", path])
            row = {"file": ending, "bytes": os.path.getsize(path), "read": read, "over_floats": read["bytes"] / floats}
            text = "| .%s | %.0f | %.2f | %.0f | %.2f |" % (ending, row["bytes"] / 1e6, read["user_s"] + read["system_s"],
                                                          read["bytes"] / 1e6, row["over_floats"])
            if not options.no_render:
                row["render"] = measured([tress, "render", path, "-o", os.path.join(folder, "a.exr"), "--cm-per-unit", "1", "--up", "z",
                                          "--spp", str(options.spp), "--resolution", options.size])
                text += " %.0f | %.0f |" % (row["render"]["user_s"] + row["render"]["system_s"], row["render"]["bytes"] / 1e6)
            rows.append(row)
            print(text, flush=True)
    if options.output:
        with open(options.output, "w") as out:
            json.dump({"strands": options.strands, "points_a_strand": options.points, "floats_bytes": floats, "files": rows}, out, indent=1)


if __name__ == "__main__":
    main()
