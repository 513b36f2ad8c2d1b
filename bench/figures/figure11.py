#!/usr/bin/env python3
"""The paper's figure 11 and more: one lock by every model of the program, the traced fiber `fiber3d` as the truth.

Every model has the same fibers: what each makes of roughness, absorption and eccentricity is said in its header
(src/models). Above each picture its mean over the truth's where there is hair, and by how much blocks of 8 x 8 pixels differ
from the truth's, root mean square over the truth's mean: the noise of both is in it, mostly that of `fiber3d`, which can only
be sampled; the noise of the truth itself, from its two halves, stands above it.
"""
import figures


def models(options):
    """Names of all models, ours first, as the program lists them when it is given a wrong one."""
    import subprocess
    done = subprocess.run([options.tress, "render", "x.json", "-o", "x.exr", "--model", "none-such"], capture_output=True,
                          text=True)
    words = done.stderr.split("expected ")[1].split(",")[0].split("|")
    return [word for word in words if word not in ("exact", "fiber3d")]


def main():
    options = figures.parse(__doc__, samples=128, size="240x360",
                            add=lambda parser: parser.add_argument("--truth-samples", type=int, default=512))
    scene = "scenes/curly_lock.json"
    half = max(1, options.truth_samples // 2)
    halves = [figures.render(options, scene, f"figure11_fiber3d_{seed}", "--model", "fiber3d", "--spp", half, "--seed", seed)
              for seed in (101, 102)]
    hair = figures.blocks(figures.coverage(halves[0])) > 0.5
    of_halves = [figures.blocks(figures.read(exr))[hair] for exr in halves]
    truth = 0.5 * (of_halves[0] + of_halves[1])

    def off(blocks, reference):
        return ((blocks - reference) ** 2).mean() ** 0.5 / truth.mean()

    picture = 0.5 * (figures.read(halves[0], behind=0.5) + figures.read(halves[1], behind=0.5))
    cells = [(f"fiber3d: halves {off(*of_halves) / 2:.3f}", picture)]
    for model in models(options):
        exr = figures.render(options, scene, f"figure11_{model}", "--model", model)
        found = figures.blocks(figures.read(exr))[hair]
        label = f"{model}: x {found.mean() / truth.mean():.3f}, {off(found, truth):.3f}"
        cells.append((label, figures.read(exr, behind=0.5)))
    columns = 4
    figures.sheet(options, "figure11", [cells[i:i + columns] for i in range(0, len(cells), columns)])


if __name__ == "__main__":
    main()
