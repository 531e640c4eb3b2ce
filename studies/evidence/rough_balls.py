"""Threshold and velocity of rough balls over those of smooth ones, the table `studies/remarks/rough_balls.csv`.

``python -m studies.evidence.rough_balls`` computes it: samples of asperities that slip with memory
(`contact.RoughBalls`), on a ball of 1 mm with c = 0.107 under an orbit of u_x/u_z = 0.67, for Johnson's number
alpha = sigma/z_0 and the amplitude over z_0, the approach at rest.  Values are ratios to the smooth ball with the
elastic law: median, lowest and highest of eight balls, and their mean field.  alpha = 0 is the smooth ball with the
hysteretic law.
"""

import csv
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import contact

TABLE = Path(__file__).parents[1] / "remarks" / "rough_balls.csv"
SAMPLES = 8
ALPHAS = (0.2, 0.4, 0.6, 1.0, 1.5, 2.1, 3.0, 4.5, 6.4)
AMPLITUDES = (0.17, 0.22, 0.28, 0.35, 0.42, 0.52, 0.64, 0.85, 1.06, 1.35, 1.7, 2.4, 3.4)  # |u_z| over z_0
STARTS = 0.2e-3  # m/s: velocity at the threshold
TOLERANCE = 3e-3  # of the velocities of rough balls
FREQUENCY, RATIO = 2.2e6, 0.67


def ball(law: str = "elastic") -> contact.Slider:
    """Return the smooth ball of Feenstra and Breedveld."""
    return contact.Slider(
        radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=0.0, friction_coefficient=0.08, effective_modulus=64e9,
        tangential_modulus=12e9, law=law, reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.5,
        tangential_damping=0.0,
    )  # fmt: skip


def orbit(amplitude: float) -> contact.Orbit:
    """Return the surface's motion with a normal amplitude in m."""
    return contact.Orbit(frequency=FREQUENCY, normal=amplitude, tangential=-1j * RATIO * amplitude)


def surfaces(alpha: float, rest: float) -> list[contact.RoughBalls]:
    """Return the samples, and last their mean field, with asperities as far out as the largest wave brings to touch."""
    body, rough = ball("hysteretic"), contact.Roughness(rms=alpha * rest)
    largest = max(AMPLITUDES[-1], 2.0 * alpha)
    reach = float(np.sqrt(2e-3 * (2.0 * largest * rest + 4.0 * rough.rms)))
    field = contact.MeanField(body.radius, body.effective_modulus, rough)
    return [contact.RoughBalls(body, [each]) for each in [*(rough.drawn(k, reach) for k in range(SAMPLES)), field]]


def threshold(speed: Callable[[float], float]) -> float:
    """Return the amplitude over z_0 at which a speed in m/s, a rising function of it, passes `STARTS`."""
    return float(brentq(lambda share: speed(share) - STARTS, AMPLITUDES[0] / 2.0, 2.0 * AMPLITUDES[-1], rtol=1e-4))


def rows() -> list[list[float]]:
    """Return the rows of the table: alpha, amplitude (0 for the threshold), median, lowest, highest, mean field."""
    rest = ball().rest_approach(1)

    def smooth(share: float) -> float:
        return float(contact.mean_motion(ball(), orbit(share * rest)).velocity)

    def limit(share: float) -> float:
        return float(contact.steady(ball("hysteretic"), orbit(share * rest), tolerance=1e-4).velocity)

    speeds, starts = np.array([smooth(share) for share in AMPLITUDES]), threshold(smooth)

    def of(alpha: float, thresholds: Sequence[float], velocities: np.ndarray) -> list[list[float]]:
        found = [[alpha, 0.0, *_of_samples(np.array(thresholds) / starts)]]
        for k, share in enumerate(AMPLITUDES):
            if speeds[k] > STARTS:
                found.append([alpha, share, *_of_samples(velocities[:, k] / speeds[k])])
        return found

    table = of(0.0, [threshold(limit)] * 2, np.array([[limit(share) for share in AMPLITUDES]] * 2))
    for alpha in ALPHAS:
        balls = surfaces(alpha, rest)
        thresholds = [each.threshold(orbit(rest), STARTS, tolerance=TOLERANCE) for each in balls]
        velocities = [
            [each.velocity(orbit(share * rest), tolerance=TOLERANCE).value for share in AMPLITUDES] for each in balls
        ]
        table += of(alpha, thresholds, np.array(velocities))
        print(f"alpha {alpha:g}", file=sys.stderr, flush=True)
    return table


def _of_samples(ratios: np.ndarray) -> list[float]:
    """Return median, lowest and highest of the samples, and the mean field, which is the last."""
    return [float(each) for each in (np.median(ratios[:-1]), *np.sort(ratios[:-1])[[0, -1]], ratios[-1])]


def main() -> None:
    """Write the table."""
    table = rows()
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["alpha", "amplitude_over_approach", "median", "lowest", "highest", "mean_field"])
        writer.writerows([[f"{each:.4g}" for each in row] for row in table])


if __name__ == "__main__":
    main()
