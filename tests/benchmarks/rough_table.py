"""Rough balls on the ball of Feenstra and Breedveld: mean field, samples, friction, and the time of a point.

    python -m tests.benchmarks.rough_table

It prints the approach, stiffness and pressure of the mean field for six surfaces; the force of six asperities with and
without interaction; velocities with a stop for each, with the memory of coupled ones, and by the oracle that couples
them step by step; threshold and velocities of eight samples and of the mean field over those of the smooth elastic
ball; both limits of a vanishing roughness; and the CPU time of a point.
"""

import time

import numpy as np

from contact import Asperities, MeanField, RoughBalls, Roughness, asperity_motion, mean_motion, steady
from tests.contact.test_asperity_motion import HEIGHTS, apart, orbit
from tests.contact.test_memory_motion import body, coupled_velocity
from tests.contact.test_rough import FORCES, HERTZ, PRELOAD, TABLE, E, R, six

AMPLITUDES = (2e-9, 3e-9, 5e-9, 8e-9)


def ratios(balls, smooth) -> list[float]:
    """Return the velocities over those of a smooth ball, and the amplitude for 0.2 mm/s in nm."""
    values = [balls.velocity(orbit(each), tolerance=1e-3).value for each in AMPLITUDES]
    return [balls.threshold(orbit(1e-9), 0.2e-3, tolerance=3e-3), *np.divide(values, smooth)]


def main() -> None:
    """Print the tables."""
    print("rms nm, radius um: approach nm, k/k_Hertz, p(0)/p_0 (printed by an independent program)")
    for rms, beta, *printed in TABLE:
        field = MeanField(R, E, Roughness(rms=rms * 1e-9, asperity_radius=beta * 1e-6)).under(PRELOAD)
        middle = np.polyfit(field.r[:4] ** 2, field.pressure[:4], 2)[-1] / HERTZ["pressure"]
        own = 1e9 * field.approach, field.stiffness / HERTZ["stiffness"], middle
        print(f"{rms:5g} {beta:3g}: " + "  ".join(f"{a:.6g} ({b:g})" for a, b in zip(own, printed, strict=True)))
    print("six asperities: approach nm, force N, without interaction")
    for z, coupled, alone in FORCES:
        each = [Asperities(x=[0.0], y=[0.0], heights=[h], radius=10e-6) for h in HEIGHTS]
        free = sum(float(one.forces(R, E, z * 1e-9)[0]) for one in each)
        print(f"{z:3d}: {six().forces(R, E, z * 1e-9).sum():.7e} ({coupled:.7e})  {free:.7e} ({alone:.7e})")
    print("six asperities without interaction, a stop each: m/s, by equal balls at their heights")
    for amplitude in (3e-9, 8e-9):
        balls = mean_motion(body(law="elastic", radius=10e-6, heights=tuple(HEIGHTS)), (orbit(amplitude),) * 6)
        own = asperity_motion(body(law="elastic"), apart(HEIGHTS), orbit(amplitude), tolerance=1e-5).value
        print(f"{1e9 * amplitude:g} nm: {float(balls.first_order):.8f}, as asperities 1 cm apart {own:.8f}")
    print("memory against asperities coupled step by step: m/s")
    samples = {"six": six()} | {f"seed {seed}": Roughness(rms=3e-9).drawn(seed, 5e-6) for seed in (1, 2, 3)}
    for name, sample in samples.items():
        for amplitude in (4e-9, 8e-9):
            found = RoughBalls(body(), [sample]).motion(orbit(amplitude), tolerance=1e-4)
            expected, _ = coupled_velocity(sample, orbit(amplitude), found.heights[0], found.answer.value)
            print(f"{name:7} {1e9 * amplitude:g} nm: {found.answer.value:.7f} {expected:.7f}")
    smooth = [float(mean_motion(body(law="elastic"), orbit(each)).first_order) for each in AMPLITUDES]
    hysteretic = [float(steady(body(), orbit(each), tolerance=1e-5).velocity) for each in AMPLITUDES]
    print("limits: velocity over that of the smooth ball with the same law, less 1, rms 1e-14 m")
    for law, reference in (("elastic", smooth), ("hysteretic", hysteretic)):
        balls = RoughBalls(body(law=law), [MeanField(R, E, Roughness(rms=1e-14))], 8e-9)
        print(f"{law:10}", ratios(balls, reference)[1:] - np.ones(4))
    print("over the smooth elastic ball: amplitude nm for 0.2 mm/s, velocity at 2, 3, 5, 8 nm")
    for rms in (1e-9, 3e-9, 10e-9):
        surfaces = [Roughness(rms=rms).drawn(seed, 6e-6) for seed in range(8)]
        for law in ("elastic", "hysteretic"):
            rows = np.array([ratios(RoughBalls(body(law=law), [each], 8e-9), smooth) for each in surfaces])
            texts = [f"{np.median(each):.3f} ({each.min():.3f} to {each.max():.3f})" for each in rows.T]
            print(f"{1e9 * rms:g} nm, samples, {law:10}", *texts)
        mean = ratios(RoughBalls(body(), [MeanField(R, E, Roughness(rms=rms))], 8e-9), smooth)
        print(f"{1e9 * rms:g} nm, mean field, memory", *(f"{each:.3f}" for each in mean))
    print("CPU of a point of the mean field of 3 nm, us")
    balls = RoughBalls(body(), [MeanField(R, E, Roughness(rms=3e-9))], 8e-9)
    for amplitude in AMPLITUDES:
        balls.velocity(orbit(amplitude), tolerance=2.5e-4)
        start = time.process_time()
        for _ in range(200):
            balls.velocity(orbit(amplitude), tolerance=2.5e-4)
        print(f"{1e9 * amplitude:g} nm: {(time.process_time() - start) / 200 * 1e6:.0f}")


if __name__ == "__main__":
    main()
