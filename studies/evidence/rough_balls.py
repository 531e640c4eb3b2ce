"""Threshold and velocity of rough balls over those of smooth ones, the table `studies/remarks/rough_balls.csv`.

``python -m studies.evidence.rough_balls`` computes it: samples of asperities that slip with memory
(`contact.RoughBalls`), on a ball of 1 mm with c = 0.107 under an orbit of u_x/u_z = 0.67, for Johnson's number
alpha = sigma/z_0 and the amplitude over z_0, the approach at rest.  Values are ratios to the smooth ball with the
elastic law: median, lowest and highest of eight balls, and their mean field.  alpha = 0 is the smooth ball with the
hysteretic law.
"""

import csv
import sys
from pathlib import Path

import numpy as np

import contact

TABLE = Path(__file__).parents[1] / "remarks" / "rough_balls.csv"
SAMPLES = 8
ALPHAS = (0.2, 0.4, 0.6, 1.0, 1.5, 2.1, 3.0, 4.5, 6.4)
AMPLITUDES = (0.17, 0.22, 0.28, 0.35, 0.42, 0.52, 0.64, 0.85, 1.06, 1.35, 1.7, 2.4, 3.4)  # |u_z| over z_0
STARTS = 0.2e-3  # m/s: velocity at the threshold
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


def velocities(alpha: float, rest: float) -> np.ndarray:
    """Return the velocities in m/s of the samples, and last of the mean field, at all amplitudes."""
    body, rough = ball("hysteretic"), contact.Roughness(rms=alpha * rest)
    reach = float(np.sqrt(2e-3 * (2.0 * AMPLITUDES[-1] * rest + 4.0 * rough.rms)))
    surfaces = [rough.drawn(seed, reach) for seed in range(SAMPLES)]
    field = contact.MeanField(body.radius, body.effective_modulus, rough)
    balls = [contact.RoughBalls(body, [each]) for each in [*surfaces, field]]
    return np.array(
        [[each.velocity(orbit(share * rest), tolerance=3e-3).value for share in AMPLITUDES] for each in balls]
    )


def threshold(speeds: np.ndarray) -> float:
    """Return the amplitude over z_0 at which the speed passes `STARTS`, from a rising curve of speeds."""
    k = int(np.argmax(speeds > STARTS))
    if k == 0:
        return float(AMPLITUDES[0]) if speeds[0] > STARTS else float(AMPLITUDES[-1])
    share = (STARTS - speeds[k - 1]) / (speeds[k] - speeds[k - 1])
    return float(np.exp(np.interp(share, [0, 1], np.log(AMPLITUDES[k - 1 : k + 1]))))


def rows() -> list[list[float]]:
    """Return the rows of the table: alpha, amplitude (0 for the threshold), median, lowest, highest, mean field."""
    rest = ball().rest_approach(1)
    orbits = [orbit(share * rest) for share in AMPLITUDES]
    smooth = np.array([contact.mean_motion(ball(), each).velocity for each in orbits])
    limit = np.array([contact.steady(ball("hysteretic"), each, tolerance=1e-4).velocity for each in orbits])
    curves = {0.0: np.array([limit, limit])} | {alpha: velocities(alpha, rest) for alpha in ALPHAS}
    table = []
    for alpha, found in curves.items():
        starts = np.array([threshold(each) / threshold(smooth) for each in found])
        table.append([alpha, 0.0, *_of_samples(starts)])
        for k, share in enumerate(AMPLITUDES):
            if smooth[k] > STARTS:
                table.append([alpha, share, *_of_samples(found[:, k] / smooth[k])])
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
