"""What the exported motor is worth in a simulator: a burst of 0.3 s with a load step, its error and its speed.

``python tests/benchmarks/simulator_burst.py [SCENE ...]`` (twente-contact, twente) prints a row for each scene and
level.  The exported C code is run by a master written in C at a communication step of 10 us: drive from 0 s, load from
0.15 s, nothing from 0.29 s on.  The truth is the contact followed through every cycle (`studies.motor.followed_motor`,
400 steps per cycle), sampled every millisecond; its own error is the difference to 200 steps per cycle.  Errors are
over the steady velocity.  The load is 30 % of the friction force.

Measured (CPU times of one core, shared with other work):

scene           level   steady m/s   driven   loaded   stopped  of the truth   times real time
twente-contact  5 nm    0.0286       7.4e-6   7.0e-6   3.9e-6   8.8e-6         160
twente-contact  10 nm   0.0693       2.9e-6   3.4e-6   1.7e-6   9.6e-6         149
twente-contact  20 nm   0.1529       1.3e-6   2.7e-6   1.8e-6   4.8e-5         145
twente          15 V    0.0133       1.2e-5   1.6e-5   2.6e-5   5.8e-6         149
twente          30 V    0.0387       5.1e-6   6.0e-6   7.9e-6   6.0e-6         153
twente          60 V    0.0907       7.9e-6   1.1e-6   4.4e-7   1.1e-5         141
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import contact
from studies.export.averaged_motor import averaged_motor
from studies.export.c_source import header, source
from studies.export.fmu import compiler
from studies.motor.followed_motor import FollowedMotor
from studies.scene import Scene

STEP, SAMPLE = 1e-5, 1e-3  # s
LOADED, OFF, END = 0.15, 0.29, 0.3  # s
SHARES = (0.25, 0.5, 1.0)  # of the scene's largest level
REPEATS = 20
MASTER = r"""
#include <stdio.h>
#include <time.h>
#include "motor.h"
int main(void) {
    sawmotor_state state;
    for (int k = 0; k < REPEATS; k++) {
        sawmotor_start(&state, SAWMOTOR_PRELOAD, 0.0);
        for (int n = 0; n < STEPS; n++) {
            sawmotor_advance(&state, n < OFF ? LEVEL : 0.0, n < LOADED ? 0.0 : FORCE, SAWMOTOR_PRELOAD, STEP);
            if (k == 0 && (n + 1) % SAMPLE == 0) printf("%.17g\n", sawmotor_velocity(&state));
        }
    }
    printf("%.17g\n", (double)clock() / CLOCKS_PER_SEC / REPEATS);
    return 0;
}
"""


def exported(motor, level: float, force: float) -> tuple[np.ndarray, float]:
    """Return the velocities of the exported C code at the samples, m/s, and the CPU time of a burst, s."""
    numbers = {
        "REPEATS": REPEATS, "STEPS": round(END / STEP), "OFF": round(OFF / STEP), "LOADED": round(LOADED / STEP),
        "SAMPLE": round(SAMPLE / STEP), "LEVEL": repr(level), "FORCE": repr(force), "STEP": repr(STEP),
    }  # fmt: skip
    defined = "".join(f"#define {name} {value}\n" for name, value in numbers.items())
    with tempfile.TemporaryDirectory() as folder:
        texts = {"motor.c": source(motor), "motor.h": header(motor), "main.c": defined + MASTER}
        for name, text in texts.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        flags = ["-O2", "-std=gnu99", "-ffp-contract=off", "-fno-math-errno"]
        call = [*compiler(), *flags, "-o", "burst", "main.c", "motor.c", "-lm"]
        subprocess.run(call, cwd=folder, check=True)
        said = subprocess.run([f"{folder}/burst"], capture_output=True, text=True, check=True).stdout
    *velocity, seconds = map(float, said.split())
    return np.array(velocity), seconds


def followed(motor, level: float, force: float, steps: int) -> np.ndarray:
    """Return the velocities of the contact followed through every cycle, m/s."""
    state, velocity = FollowedMotor(motor, steps=steps), []
    for n in range(round(END / SAMPLE)):
        state.advance(
            SAMPLE, level if n < round(OFF / SAMPLE) else 0.0, force=force if n >= round(LOADED / SAMPLE) else 0.0
        )
        velocity.append(state.velocity)
    return np.array(velocity)


def main(names: list[str]) -> None:
    """Print the table."""
    print("scene, level, steady m/s | error: driven, loaded, after the stop, of the truth | times real time")
    for name in names:
        motor = averaged_motor(Scene.load(name))
        slider = motor.slider
        for share in SHARES:
            level = share * motor.levels[-1]
            steady = float(contact.mean_motion(slider, motor.orbits_at(level)).velocity)
            force = -0.3 * slider.friction_coefficient * motor.preload * float(np.sign(steady))
            velocity, seconds = exported(motor, level, force)
            truth, coarse = (followed(motor, level, force, steps) for steps in (400, 200))
            error, own = np.abs(velocity - truth) / abs(steady), np.max(np.abs(truth - coarse)) / abs(steady)
            parts = (slice(0, 150), slice(150, 290), slice(290, 300))
            texts = ", ".join(f"{np.max(error[part]):.1e}" for part in parts)
            print(f"{name}, {level:.3g}, {steady:.4f} | {texts}, {own:.1e} | {END / seconds:.0f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or ["twente-contact", "twente"])
