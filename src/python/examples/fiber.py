"""One fiber: a row beside its reference, where light goes, and a furnace that closes."""

# %% A row of the table, learned on its own
import os

import numpy as np
import tress

small = bool(os.environ.get("TRESS_EXAMPLE_SMALL"))
row = tress.fit("TRT", eccentricity=0.8, theta_d=20)
print(f"TRT: energy {row['energy']:.4f}, error {row['relative_l2']:.4f} by {row['components']} components")

# %% The BCSDF over arrays: S, a density per dtheta_i dphi_i, of every direction of a grid
cells = 48 if small else 180
theta = (np.arange(cells) + 0.5) / cells * np.pi - np.pi / 2
phi = (np.arange(2 * cells) + 0.5) / (2 * cells) * 2 * np.pi - np.pi
area = (np.pi / cells) ** 2
blond = tress.Bcsdf(tress.Material(hair="blond", eccentricity=0.8))
lobes = blond.lobes(0.3, 0.9, theta[:, None], phi)
for name, energy in zip(tress.LOBES, lobes.sum(axis=(0, 1)) * area):
    print(f"{name:9}", np.round(energy, 4))

# %% Sampled and evaluated agree: the same energy by other means
drawn = blond.sample(np.full(2000 if small else 100000, 0.3), 0.9)
print("by samples", drawn.weight.mean(axis=0).round(3), "by quadrature", (lobes.sum(axis=(0, 1, 2)) * area).round(3))

# %% Rows that learn while they are asked
learned = tress.Bcsdf(tress.Material(hair="blond", eccentricity=0.8), estimator="fitted")
for stream in range(4 if small else 12):
    learned.sample(np.full(1000 if small else 20000, 0.3), 0.9, stream=stream)
    print(learned.publish())
