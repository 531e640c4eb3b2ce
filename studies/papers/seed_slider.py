"""Slider behaviour in the seed paper: its Figs 2, 5(a) and 5(b), with its sentences and our numbers."""

import logging

import numpy as np

import contact
from studies.papers.seed import Seed
from studies.record.quantities import quantity
from studies.study_list import Panel, judged

LOGGER = logging.getLogger(__name__)

BURST = 0.3  # duration of the burst, s
STEPS = (1e-9, 3e-9, 5e-9, 10e-9, 20e-9)  # m
JUDGED = 10e-9  # amplitude in m of the burst whose slopes are judged


def figure_2(seed: Seed):
    """Fig. 2: tangential force against deformation."""
    across, up = quantity("history.deformation_m"), quantity("history.tangential_force_N")
    x, curves = {}, {}
    force_ratios, scaled_limits = [], []  # Q(x_max) / (mu P), and x_max / P^(2/3), which must not depend on P
    for share in (0.5, 1.0, 2.0):
        force = share * seed.slider.preload
        z = seed.slider.approach_under(force, 1)
        limit = seed.slider.limit_slope * z
        deformation = np.linspace(0, limit, 101)
        name = f"P = {force * 1e3:.3g} mN"
        Q = seed.slider.tangential_force(deformation, z)
        x[name], curves[name] = deformation * across.scale, Q * up.scale
        force_ratios.append(Q[-1] / (seed.slider.friction_coefficient * force))
        scaled_limits.append(limit / share ** (2 / 3))
    data = {"x": x, "left": curves, "x_axis": across.axis, "left_axis": up.heading}
    finding = judged('Fig. 2: "The displacement x_max(P) can be found by substituting Q = mu P in equation 2."',
                     "Q(x_max) / (mu P) at three P", force_ratios[1], expected="1",
                     holds=all(abs(ratio - 1) < 1e-12 for ratio in force_ratios)
                     and max(scaled_limits) - min(scaled_limits) < 1e-12 * max(scaled_limits),
                     remark="x_max grows as P^(2/3): it is (mu E/4 G) z")  # fmt: skip
    return [Panel(name="fig_2", title="Fig. 2: tangential stiffness", data=data)], [finding]


def figure_5a(seed: Seed):
    """Fig. 5(a): step response to a burst."""
    across, speed = quantity.time_s, quantity.velocity_m_per_s
    x, curves = {}, {}
    for amplitude in seed.steps or STEPS:
        LOGGER.info(f"seed figures: Fig. 5(a), {amplitude * 1e9:g} nm")
        steady = seed.steady(amplitude).velocity
        stopping = steady * seed.slider.mass / (seed.slider.friction_coefficient * seed.slider.preload)
        after = 1.1 * stopping + 2e-3
        motion = contact.burst(
            seed.slider, seed.orbits(amplitude), duration=BURST, after=after, tolerance=1e-2, samples=1500
        )
        name = f"{amplitude * 1e9:g} nm"
        x[name], curves[name] = motion.time * across.scale, motion.velocity * speed.scale
        if amplitude == JUDGED:
            judged_burst, final = motion, steady
    time = judged_burst.time
    rising = time <= judged_burst.duration
    v, end = judged_burst.velocity, judged_burst.velocity_at_burst_end
    up = rising & (v < 0.8 * end)
    down = ~rising & (v < 0.8 * end) & (v > 0.1 * end)

    def bend(part):
        """Return the largest distance of a part of the curve from its best straight line, over the final velocity."""
        line = np.polynomial.Polynomial.fit(time[part], v[part], 1)
        return float(np.max(abs(line(time[part]) - v[part])) / end)

    findings = [
        judged('Fig. 5(a): "After a certain time the slider converges to a steady state velocity."',
               f"v after {BURST} s over the steady velocity, 10 nm", end / final, expected="1 within 0.1",
               holds=abs(end / final - 1) < 0.1),
        judged('Section V: "The rising slope has a curved shape."',
               "largest distance from a straight line over v, to 80 % of v, 10 nm", bend(up),
               expected="more than 0.01", holds=bend(up) > 0.01),
        judged('Section V: "By contrast, the falling slope is linear with time due to dry friction."',
               "the same of the falling slope", bend(down), expected="less than 0.01, a tenth of the rising one's",
               holds=bend(down) < min(0.01, 0.1 * bend(up)), remark="what is left is R_t v"),
    ]  # fmt: skip
    data = {"x": x, "left": curves, "x_axis": across.axis, "left_axis": speed.axis}
    return [Panel(name="fig_5a", title=f"Fig. 5(a): burst of {BURST} s", data=data)], findings


def figure_5b(seed: Seed):
    """Fig. 5(b): steady velocity against amplitude."""
    threshold = contact.threshold_amplitude(seed.slider, seed.shape)
    release = contact.release_amplitude(seed.slider, seed.shape)
    speeds = np.array([seed.steady(amplitude).velocity for amplitude in seed.levels])
    below, above = (seed.steady(factor * threshold).velocity for factor in (0.99, 1.01))
    regimes = [seed.steady(factor * release).regime for factor in (0.99, 1.01)]
    findings = [
        judged('Fig. 5(b): "There is no effective slider motion when the wave amplitude is smaller then '
               'the threshold amplitude."', f"velocity 1 % below the threshold of {threshold * 1e9:.4g} nm (m/s)",
               below, expected="0", holds=below == 0),
        judged('Fig. 5(b): "The slider starts to move when the wave amplitude exceeds the threshold amplitude."',
               "velocity 1 % above it (m/s)", above, expected="more than 0", holds=above > 0),
        judged('Fig. 5(b): "There is always contact between wave and slider when the wave amplitude is below '
               'the release amplitude."', "release amplitude (nm); 1 % below slip, 1 % above intermittent",
               release * 1e9, expected="4.17258, closed form",
               holds=regimes == ["slip", "intermittent"] and abs(release / 4.17258e-9 - 1) < 1e-4),
    ]  # fmt: skip
    across, up = quantity.normal_amplitude_m, quantity.velocity_m_per_s
    data = {
        "x": np.array(seed.levels) * across.scale, "left": {"steady velocity": speeds * up.scale},
        "x_axis": across.axis, "left_axis": up.axis,
        "verticals": {"threshold (theory)": threshold * across.scale, "release (theory)": release * across.scale},
    }  # fmt: skip
    return [Panel(name="fig_5b", title="Fig. 5(b): steady velocity", data=data)], findings
