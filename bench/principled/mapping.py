"""Principled Hair in tress over Cycles, and the widths of lobes that bring them nearest: /usr/bin/python3 mapping.py TRESS FOLDER ...

FOLDER is what bench/principled/cycles.py left. A ratio is of means over all pixels of a transparent film, ours over Cycles'.

mapping.py TRESS FOLDER table [NAME...]  ratios as the program has them, with standard errors, and what is the groom's, what the look's;
                                         `--model chiang2016` first: then also over that model at the node's own widths
mapping.py TRESS FOLDER fit [NAME...]    factors of the widths, by least squares; --hold-out WORD leaves out names that have it
mapping.py TRESS FOLDER cost [NAME...]   CPU time to equal noise of the node's own model (chiang2016) over that of --model
mapping.py TRESS FOLDER sheet [NAME...] -o FILE.png  Cycles left, ours right
"""

import argparse
import json
import math
import os
import pathlib
import re
import resource
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scenes" / "blender" / "tress_render"))
import files  # noqa: E402

AIM = 0.03
SOURCE = ROOT / "src" / "fiber" / "principled_hair.cpp"  # the one place of the factors


def factors_of_the_program():
    text = SOURCE.read_text()
    lambdas, azimuths = (re.search(name + r"\{([^}]*)\}", text)[1].split(",") for name in ("lambda_per_deviation", "azimuth_per_deviation"))
    numbers = [*lambdas[:3], *azimuths[:2]]
    return dict(zip(("R", "TT", "TRT", "azimuth_TT", "azimuth_TRT"), map(float, numbers)))


HALF_WIDTHS = {"R": 0.334, "TT": 0.334, "TRT": 0.334, "azimuth_TT": 1.0, "azimuth_TRT": 1.0}  # equal half widths of the lobes
LOGISTIC = math.sqrt(3) / (2 * math.pi)  # lambda of a logistic in theta_h over the standard deviation of theta_i
NODES_OWN = {"R": LOGISTIC, "TT": LOGISTIC, "TRT": LOGISTIC, "azimuth_TT": 1.0, "azimuth_TRT": 1.0}  # what chiang2016 makes the node's widths of


def deviation(beta):
    return 0.726 * beta + 0.812 * beta**2 + 3.7 * beta**20


def azimuthal_deviation(beta):
    return (0.265 * beta + 1.194 * beta**2 + 5.372 * beta**22) * math.sqrt(math.pi / 8) * math.pi / math.sqrt(3)


def absorption(look):
    """Of the node's melanin or color (Chiang et al. 2016)."""
    if "color" in look:
        b = look["radial_roughness"]
        to = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
        return [(math.log(c) / to)**2 for c in look["color"]]
    amount = -math.log(max(1 - look["melanin"], 1e-4))
    red = look["redness"]
    return [amount * ((1 - red) * e + red * p) for e, p in zip((0.506, 0.841, 1.653), (0.343, 0.733, 1.924))]


def explicit(look, factors):
    """The material of a `principled`, in widths of lobes: what src/fiber/principled_hair.cpp does."""
    whole = deviation(look["roughness"])
    by_lobe = {"R": deviation(look["roughness"] * (1 - look["coat"])), "TT": 0.5 * whole, "TRT": 2 * whole, "TRRT": 2 * whole}
    azimuth = azimuthal_deviation(look["radial_roughness"])
    degrees = {lobe: min(max(math.degrees(factors[lobe.replace("TRRT", "TRT")] * d), 0.25), 45) for lobe, d in by_lobe.items()}
    blurs = {lobe: min(max(math.degrees(factors["azimuth_" + lobe.replace("TRRT", "TRT")] * azimuth), 0.5), 45)
             for lobe in ("TT", "TRT", "TRRT")}
    material = {"eccentricity": 1, "roughness": 0.02, "eta": look["eta"], "tilt_deg": look["offset_deg"], "sigma_a": absorption(look),
                "longitudinal_lambda_deg": degrees, "azimuthal_sigma_deg": blurs, "longitudinal_shape": "gaussian"}
    gains = {lobe: factors["gain_" + lobe] for lobe in ("R", "TT", "TRT") if "gain_" + lobe in factors}
    if gains:
        material["gain"] = gains
    return material


def render(program, folder, samples, seed=0, factors=None, options=(), depth=64):
    """Pixels (height, width, 3), and the standard error of the mean of all."""
    scene = json.loads((folder / "scene.json").read_text())
    if factors:
        for material in scene["materials"]:
            if "principled" in material:
                material.update(explicit(material.pop("principled"), factors))
    trial = folder / "trial.json"
    trial.write_text(json.dumps(scene))
    picture = folder / "trial.exr"
    subprocess.run([program, "render", trial, "-o", picture, "--spp", str(samples), "--seed", str(seed), "--max-depth", str(depth),
                    "--precision", "float", "--quiet", *options], check=True)
    channels = files.read_exr(picture).channels
    pixels = np.stack([channels[c] for c in "RGB"], 2).astype(float)
    variance = np.stack([channels["variance." + c] for c in "RGB"], 2).astype(float)
    picture.unlink()  # pictures rewritten within a second would be read stale by some readers
    return pixels, np.sqrt(variance.sum((0, 1))).mean() / pixels[:, :, 0].size  # channels go together


def of_cycles(folder):
    found = np.load(folder / "cycles.npz")
    seeds = found["seeds"]
    return found["picture"][:, :, :3].astype(float), seeds.mean(1).std(ddof=1) / math.sqrt(len(seeds)) if len(seeds) > 1 else math.nan


def names_in(folder, wanted):
    there = sorted(path.parent.name for path in folder.glob("*/cycles.npz"))
    return [name for name in there if not wanted or any(word == name or word in name.split(".") for word in wanted)]


def table(args):
    factors = HALF_WIDTHS if args.half_widths else None
    if args.model == "chiang2016":
        factors = NODES_OWN
    if args.factors:
        factors = json.loads(args.factors)
    rows = {}
    for name in names_in(args.folder, args.names):
        theirs, of_theirs = of_cycles(args.folder / name)
        ours, of_ours = render(args.program, args.folder / name, args.samples, 0, factors, ["--model", args.model])
        ratio = ours.mean() / theirs.mean()
        rows[name] = {"ratio": ratio, "error": ratio * math.hypot(of_theirs / theirs.mean(), of_ours / ours.mean()),
                      "channels": (ours.mean((0, 1)) / theirs.mean((0, 1))).tolist(), "blocks": off(ours, theirs)}
        line = f"{name:16s} {ratio:.3f} +- {rows[name]['error']:.3f}   {channels_of(rows[name]['channels'])}   blocks {rows[name]['blocks']:.3f}"
        by_node = args.folder / name / "chiang2016.npz"
        if args.model != "chiang2016" and by_node.exists():
            node, of_node = np.load(by_node)["picture"], float(np.load(by_node)["error"])
            by = ours.mean() / node.mean()
            channels = (ours.mean((0, 1)) / node.mean((0, 1))).tolist()
            rows[name] |= {"by_node": by, "by_node_error": by * math.hypot(of_node / node.mean(), of_ours / ours.mean()),
                           "by_node_channels": channels, "by_node_blocks": off(ours, node)}
            line += (f"   by chiang2016 {by:.3f} +- {rows[name]['by_node_error']:.3f}   {channels_of(channels)}"
                     f"   blocks {rows[name]['by_node_blocks']:.3f}")
        print(line, flush=True)
        if args.model == "chiang2016":
            np.savez(args.folder / name / "chiang2016.npz", picture=ours, error=of_ours)
    for key, what in (("ratio", "Cycles"), ("by_node", "chiang2016 at the node's widths")):
        if all(key in row for row in rows.values()):
            print(f"{sum(abs(row[key] - 1) < AIM for row in rows.values())} of {len(rows)} within {AIM} of {what}")
            two_way(rows, key)
    if args.output:
        git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
        found = {"context": {"commit": git.stdout.strip(), "load": os.getloadavg()[0], "samples": args.samples, "model": args.model},
                 "factors": factors or factors_of_the_program(), "scenes": rows}
        pathlib.Path(args.output).write_text(json.dumps(found, indent=1) + "\n")


def cost(args):
    """Cold: what a row costs to learn is in it."""
    def spent():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    ratios = {}
    for name in names_in(args.folder, args.names):
        costs = []
        for model in ("chiang2016", args.model):
            before = spent()
            _, error = render(args.program, args.folder / name, args.samples, 0, None, ["--model", model])
            costs.append((spent() - before) * error**2)
        ratios[name] = costs[0] / costs[1]
        print(f"{name:16s} {ratios[name]:.2f}", flush=True)
    found = sorted(ratios.values())
    print(f"of {len(found)}: from {found[0]:.2f} to {found[-1]:.2f}, median {np.median(found):.2f}")


def channels_of(ratios):
    return ", ".join(f"{ratio:.3f}" for ratio in ratios)


def sheet(args):
    """Cycles left, ours right, a look a column and a groom a row; as PNG."""
    import matplotlib.image
    names = names_in(args.folder, args.names)
    grooms, looks = ([*dict.fromkeys(name.split(".")[i] for name in names)] for i in (0, 1))
    rows = []
    for groom in grooms:
        row = []
        for look in looks:
            folder = args.folder / f"{groom}.{look}"
            row += [of_cycles(folder)[0], render(args.program, folder, args.samples, 0, None, ["--model", args.model])[0]]
        rows.append(np.concatenate(row, 1))
    linear = np.clip(np.concatenate(rows, 0), 0, 1)
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9)**(1 / 2.4) - 0.055)
    matplotlib.image.imsave(args.output, coded)


def blocks(pixels, size=8):
    height, width, _ = pixels.shape
    return pixels[:height // size * size, :width // size * size].reshape(height // size, size, width // size, size, 3).mean((1, 3))


def off(ours, theirs):
    """Relative L2 of squares of 8 x 8 pixels."""
    a, b = blocks(theirs), blocks(ours)
    return math.sqrt(((a - b)**2).sum() / (a**2).sum())


def two_way(rows, key="ratio"):
    """Logarithms of ratios as the sum of what is the groom's and what the look's, by least squares; what is left is of both."""
    names = list(rows)
    grooms, looks = sorted({n.split(".")[0] for n in names}), sorted({n.split(".")[1] for n in names})
    if len(grooms) * len(looks) != len(names) or len(grooms) < 2 or len(looks) < 2:
        return
    log = np.log([[rows[f"{g}.{k}"][key] for k in looks] for g in grooms])
    of_groom, of_look = log.mean(1), log.mean(0)
    rest = log - of_groom[:, None] - of_look[None, :] + log.mean()
    print("groom " + ", ".join(f"{g} {math.exp(x):.3f}" for g, x in zip(grooms, of_groom)))
    print("look  " + ", ".join(f"{k} {math.exp(x):.3f}" for k, x in zip(looks, of_look)))
    print(f"rest  {rest.std():.3f}, at most {abs(rest).max():.3f}; whole {log.std():.3f}")


def fit(args):
    """Gauss-Newton on the logarithms of the factors, by finite differences of pictures of one seed."""
    names = [n for n in names_in(args.folder, args.names) if not any(word in n.split(".") for word in args.hold_out)]
    factors = json.loads(args.factors) if args.factors else factors_of_the_program()
    free = args.free.split(",")
    for step in range(args.steps):
        usual = [residuals(args, name, factors) for name in names]
        base = np.concatenate(usual)
        columns = []
        for key in free:
            moved = {**factors, key: factors[key] * math.exp(args.difference)}
            columns.append((np.concatenate([residuals(args, name, moved) for name in names]) - base) / args.difference)
        jacobian = np.stack(columns, 1)
        damping = args.damping * len(names) * np.eye(len(free))
        change = np.linalg.solve(jacobian.T @ jacobian + damping, -jacobian.T @ base)
        change = np.clip(change, -0.4, 0.4)
        for key, by in zip(free, change):
            factors[key] *= math.exp(by)
        np.savez(args.folder / f"fit_{step}.npz", jacobian=jacobian, base=base, names=names, free=free)
        print(f"step {step}: rms {math.sqrt((base**2).mean()):.4f} over {len(names)} scenes; then " +
              json.dumps({k: round(v, 4) for k, v in factors.items()}), flush=True)
    print(json.dumps(factors))


def residuals(args, name, factors):
    """Per channel the logarithm of the ratio, with the weight of its light; and blocks over their root mean square, with less."""
    theirs, _ = of_cycles(args.folder / name)
    if args.target == "chiang2016":
        theirs = np.load(args.folder / name / "chiang2016.npz")["picture"]
    ours, _ = render(args.program, args.folder / name, args.samples, 1, factors, ["--model", args.model])
    a, b = theirs.mean((0, 1)), ours.mean((0, 1))
    whole = math.log(b.mean() / a.mean())
    colors = 0.3 * np.log(b / a)
    x, y = blocks(theirs), blocks(ours)
    return np.concatenate([[whole], colors, args.by_blocks * (y - x).reshape(-1) / math.sqrt((x**2).sum())])


def main():
    cli = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cli.add_argument("program")
    cli.add_argument("folder", type=pathlib.Path)
    cli.add_argument("what", choices=["table", "fit", "cost", "sheet"])
    cli.add_argument("names", nargs="*", help="grooms, looks or both with a dot; all")
    cli.add_argument("--samples", type=int, default=64)
    cli.add_argument("--model", default="elliptical", help="default elliptical; chiang2016 has the node's own widths, whatever the mapping")
    cli.add_argument("--half-widths", action="store_true", help="widths that are as wide at half their height, nothing fitted")
    cli.add_argument("--factors", help="JSON: of R, TT, TRT, azimuth_TT, azimuth_TRT, in place of the program's own; gain_R and so on")
    cli.add_argument("--free", default="R,TT,TRT,azimuth_TT,azimuth_TRT")
    cli.add_argument("--hold-out", nargs="*", default=[])
    cli.add_argument("--steps", type=int, default=2)
    cli.add_argument("--difference", type=float, default=0.2)
    cli.add_argument("--damping", type=float, default=1e-4)
    cli.add_argument("--by-blocks", type=float, default=0.3)
    cli.add_argument("--target", choices=["cycles", "chiang2016"], default="cycles")
    cli.add_argument("-o", "--output")
    args = cli.parse_args()
    {"table": table, "fit": fit, "cost": cost, "sheet": sheet}[args.what](args)


if __name__ == "__main__":
    main()
