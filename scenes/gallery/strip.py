#!/usr/bin/python3
"""Renders the gallery's pictures that are of several renders, and lays them side by side: strip.py NAME -o FOLDER.

NAME is turntable, cold_and_warm or models; selection joins stored pictures without a render. The renders stay in FOLDER (default
build/gallery), the strip is NAME.png there, cold_and_warm at half the size and selection at one height. Needs Debian's
python3-openimageio and python3-numpy.
"""
import argparse
import os
import subprocess

import numpy
import OpenImageIO

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
DEMO = os.path.join(os.path.dirname(HERE), "demo.json")
GAP = 3  # pixels between two pictures
MODELS = ("rough", "elliptical", "chiang2016", "deon2011", "marschner2003", "ou2012")
VIEWS = 5  # of the turntable, as its scene has frames
SELECTION = ("black_straight", "white_fur", "red_low_sun", "blond_curls", "macro_fiber", "wet_strands")
SELECTION_HEIGHT = 150  # pixels of every picture of it; no picture is smaller


def renders(name, folder):
    """The renders of a strip, in order: the name of each and its arguments."""
    if name == "turntable":  # one render of several frames
        return [("turn.####", [os.path.join(HERE, "turntable.json"), "--frames", f"0-{VIEWS - 1}", "--model", "rough", "--denoise", "--noise", "0.03"])]
    if name == "models":
        return [(model, [DEMO, "--model", model, "--resolution", "96x128", "--spp", "32", "--denoise"]) for model in MODELS]
    cache = os.path.join(folder, "demo.cache")
    if os.path.exists(cache):
        os.remove(cache)
    demo = [DEMO, "--denoise", "--warm-cache", cache]
    return [("cold", demo), ("warm", [*demo, "--cache-mode", "frozen"])]


def half(pixels):
    """Means of 2 x 2 pixels, of what a display shows."""
    height, width = pixels.shape[0] // 2, pixels.shape[1] // 2
    blocks = pixels[:2 * height, :2 * width].reshape(height, 2, width, 2, 3)
    return numpy.round(blocks.mean((1, 3))).astype(numpy.uint8)


def as_it_is(pixels):
    return pixels


def at_selection_height(pixels):
    """Made smaller as a whole, of what a display shows."""
    height, width = pixels.shape[:2]
    whole = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(width, height, 3, OpenImageIO.UINT8))
    whole.set_pixels(OpenImageIO.ROI(0, width, 0, height, 0, 1, 0, 3), numpy.ascontiguousarray(pixels))
    columns = round(width * SELECTION_HEIGHT / height)
    small = OpenImageIO.ImageBufAlgo.resize(whole, roi=OpenImageIO.ROI(0, columns, 0, SELECTION_HEIGHT, 0, 1, 0, 3))
    return small.get_pixels(OpenImageIO.UINT8)


def side_by_side(pngs, output, change):
    """Writes the pictures of these files, each as change makes it, as one; all have the height of the lowest."""
    pictures = [change(OpenImageIO.ImageBuf(png).get_pixels(OpenImageIO.UINT8)[:, :, :3]) for png in pngs]
    rows = min(picture.shape[0] for picture in pictures)
    pictures = [picture[:rows] for picture in pictures]
    gap = numpy.full((pictures[0].shape[0], GAP, 3), 255, numpy.uint8)
    row = [part for picture in pictures for part in (gap, picture)][1:]
    strip = numpy.ascontiguousarray(numpy.concatenate(row, 1))
    out = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(strip.shape[1], strip.shape[0], 3, OpenImageIO.UINT8))
    out.set_pixels(OpenImageIO.ROI(0, strip.shape[1], 0, strip.shape[0], 0, 1, 0, 3), strip)
    out.write(output)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=("turntable", "cold_and_warm", "models", "selection"))
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "build", "gallery"), help="folder")
    parser.add_argument("--tress", default=os.path.join(ROOT, "build", "release", "bench", "tress-lab"), help="the program")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    if options.name == "selection":
        stored = [os.path.join(HERE, name + ".png") for name in SELECTION]
        return side_by_side(stored, os.path.join(options.output, "selection.png"), at_selection_height)
    pngs = []
    for name, arguments in renders(options.name, options.output):
        exr = os.path.join(options.output, name + ".exr")
        subprocess.run([options.tress, "render", *arguments, "-o", exr], check=True)
        pngs += [exr[:-4].replace("####", f"{view:04}") + ".png" for view in range(VIEWS if "####" in name else 1)]
    side_by_side(pngs, os.path.join(options.output, options.name + ".png"), half if options.name == "cold_and_warm" else as_it_is)


if __name__ == "__main__":
    main()
