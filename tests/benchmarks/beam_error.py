"""Stated against true errors of random motors whose wave spreads in three dimensions, through the whole chain.

Each scene is run at its tolerance and again with a section good to 2e-4 and three times as many lateral
wavenumbers; the difference of every velocity, over its reference speed, is compared with the error that the first run
states.  ``python -m tests.benchmarks.beam_error [SCENES] [SEED]``: about 5 CPU s for each scene.
"""

import sys
import time

import numpy as np

import fem.beam.lateral
from studies import Scene, run
from tests.seed_motor import SCENE_SLIDER

TOLERANCE, REFERENCE, NODES = 5e-2, 2e-4, 3.0


def drawn(draw) -> Scene:
    """Return a motor on a ceramic poled along z: apertures, places, lengths, circuits and side faces at random."""
    wavelength = 1e-3
    pairs = [int(draw.integers(2, 7)) for _ in "ab"]
    gap, margin = draw.uniform(4, 20) * wavelength, 2 * wavelength
    centers = [margin + pairs[0] / 2 * wavelength]
    centers.append(centers[0] + (sum(pairs) / 2) * wavelength + gap)
    apertures = draw.uniform(4, 20, 2) * wavelength
    width = max(apertures) * draw.uniform(1.1, 2.0)
    transducers = [
        {"name": name, "center": center, "finger_pairs": count, "metallisation": 0.5, "aperture": float(aperture)}
        for name, center, count, aperture in zip(("left", "right"), centers, pairs, apertures, strict=True)
    ]  # fmt: skip
    transducers[1]["termination"] = ["open", "short", 50.0][draw.integers(3)]
    place = centers[0] + pairs[0] / 2 * wavelength + draw.uniform(0.2, 0.8) * gap
    return Scene.from_table(
        "",
        {
            "stator": {
                "material": ["PZT-8", "PZT-4"][draw.integers(2)],
                "length": centers[1] + pairs[1] / 2 * wavelength + margin,
                "thickness": float(draw.uniform(1.2, 4.0) * wavelength),
                "width": float(width),
                "ends": "absorbing",
                "sides": ["absorbing", "absorbing", "mirror"][draw.integers(3)],
                "diffraction": True,
            },
            "transducer": transducers[: 1 + int(draw.integers(2))],
            "drive": {"frequency": 2.2e6, "transducer": "left", "voltage": [60.0, 120.0]},
            "slider": SCENE_SLIDER | {"position": [float(place), float(draw.uniform(-0.4, 0.4) * apertures[0])]},
        },
    )  # fmt: skip


def compared(scene: Scene) -> list[tuple[float, float]]:
    """Return stated and true error of every velocity."""
    found = run(scene, tolerance=TOLERANCE)
    before = fem.beam.lateral.SPACING
    try:
        fem.beam.lateral.SPACING = before / NODES
        truth = run(scene, tolerance=REFERENCE)
    finally:
        fem.beam.lateral.SPACING = before
    omega, rows = 2 * np.pi * scene.frequency, []
    for one, true in zip(found.points, truth.points, strict=True):
        if "velocity_m_per_s" not in one or "velocity_m_per_s" not in true:
            continue
        v = true["velocity_m_per_s"]
        speed = max(abs(v), omega * true["tangential_amplitude_m"] / 10)
        rows.append((one["relative_error"], abs(one["velocity_m_per_s"] - v) / speed))
    return rows


def main(scenes: int, seed: int) -> None:
    """Print a row for each scene and how many are honest."""
    draw, honest, known = np.random.default_rng(seed), 0, 0
    print("| scene | side faces | worst stated | worst true | worst true/stated | CPU s |\n|---|---|---|---|---|---|")
    for number in range(scenes):
        scene, begun = drawn(draw), time.process_time()
        rows = np.array(compared(scene)).reshape(-1, 2)
        if not len(rows):
            continue
        ratio = float((rows[:, 1] / np.maximum(rows[:, 0], 1e-12)).max())
        known, honest = known + 1, honest + (ratio <= 1)
        print(
            f"| {number} | {scene.stator.sides} | {rows[:, 0].max():.1e} | {rows[:, 1].max():.1e} | {ratio:.2f} "
            f"| {time.process_time() - begun:.1f} |",
            flush=True,
        )
    print(f"{honest} of {known} scenes within the stated error")


if __name__ == "__main__":
    given = [int(each) for each in sys.argv[1:3]]
    main(*given, *(20, 1)[len(given) :])
