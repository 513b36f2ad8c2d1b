#!/usr/bin/env python3
"""The paper's figure 11 and more: one lock by every model of the program, the traced fiber `fiber3d` as the truth.

Every model has the same fibers: what each makes of roughness, absorption and eccentricity is said in its header
(src/models). Under each picture its mean over the truth's, and what it differs by: relMSE against the truth, the noise of
both included, as `fiber3d`, which can only be sampled, has most of it.
"""
import figures


def models(options):
    """Names of all models, ours first, as the program tells them when it is given a wrong one."""
    import subprocess
    done = subprocess.run([options.tress, "render", "x.json", "-o", "x.exr", "--model", "none-such"], capture_output=True,
                          text=True)
    words = done.stderr.split("expected ")[1].split(",")[0].split("|")
    return [word for word in words if word not in ("exact", "fiber3d")]


def main():
    options = figures.parse(__doc__, samples=128, size="240x360",
                            add=lambda parser: parser.add_argument("--truth-samples", type=int, default=512))
    scene = "scenes/curly_lock.json"
    truth_file = figures.render(options, scene, "figure11_fiber3d", "--model", "fiber3d", "--spp", options.truth_samples)
    truth = figures.read(truth_file)
    cells = [("fiber3d (truth)", figures.read(truth_file, behind=0.5))]
    for model in models(options):
        exr = figures.render(options, scene, f"figure11_{model}", "--model", model)
        ratio = figures.read(exr).mean() / truth.mean()
        difference = figures.diff(options, exr, truth_file)["relMSE"]
        cells.append((f"{model}: mean x {ratio:.3f}, relMSE {difference:.3g}", figures.read(exr, behind=0.5)))
    columns = 4
    figures.sheet(options, "figure11", [cells[i:i + columns] for i in range(0, len(cells), columns)])


if __name__ == "__main__":
    main()
