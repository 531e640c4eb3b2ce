"""How often the 95 % intervals of a fit hold the true value: synthetic velocity curves with noise of known size.

``python tests/benchmarks/fit_coverage.py [SETS]`` fits friction coefficient, preload and the amplitude per volt of
`twente-contact` to SETS (100) curves of 20 points with 1 % + 0.2 mm/s of normal noise and prints how many intervals
hold the truth, 4 CPU s each.  Measured: 93, 93 and 93 of 100.  100 sets of a
binomial with 95 %: 91 to 99 in 96 of 100 cases.
"""

import sys
import time
from dataclasses import replace

import numpy as np

from studies import Scene
from studies.inverse import Measurement, fit, read_parameter
from studies.inverse.free_parameters import AMPLITUDE_PER_VOLT
from studies.inverse.prediction import MeasurementPredictor

FREE = ("slider.friction_coefficient=0.01:0.6", "slider.preload=0.1 mN:8 mN", "amplitude_per_volt=0.05 nm:1 nm")
PER_VOLT = 2e-10  # m/V, the true one


def main(sets: int) -> None:
    scene = Scene.load("twente-contact")
    predictor = MeasurementPredictor(scene)
    levels = tuple(np.linspace(5.0, 100.0, 20))
    asked = Measurement(name="curve", quantity="velocity", level_key="voltage_V", levels=levels)
    velocity = predictor.predict([(asked, {AMPLITUDE_PER_VOLT: PER_VOLT})])[0]
    deviation = 0.01 * velocity + 2e-4
    parameters = [read_parameter(text) for text in FREE]
    true = {each.key: predictor.value(each.key) or PER_VOLT for each in parameters}
    inside, opened, begun = dict.fromkeys(true, 0), dict.fromkeys(true, 0), time.process_time()
    for seed in range(sets):
        noisy = velocity + deviation * np.random.default_rng(seed).standard_normal(20)
        found = fit(scene, [replace(asked, values=tuple(noisy), deviations=tuple(deviation))], parameters)
        for key, (low, high) in found.intervals.items():
            opened[key] += low is None or high is None
            inside[key] += (low is None or low <= true[key]) and (high is None or true[key] <= high)
        if seed % 10 == 9:
            print(seed + 1, inside, opened, f"{(time.process_time() - begun) / (seed + 1):.2f} CPU s each", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
