"""Behaviour of the contact point in the seed paper: its Figs 6 and 7, with its sentences and our numbers."""

import math

import numpy as np

from studies.papers.seed import Seed
from studies.record.quantities import Quantity, quantity
from studies.study_list import Panel, judged

CONSTANT, INTERMITTENT = 3e-9, 10e-9  # amplitudes of Figs 6(a) and 6(b), m
ACCELERATION = 2200  # cycles from rest: 1 ms


def _contact_panel(name: str, title: str, history, time: Quantity) -> Panel:
    force, velocity = quantity("history.tangential_force_N"), quantity("history.velocity_m_per_s")
    left = {"P": history.normal_force[:, 0], "10 Q": 10 * history.tangential_force[:, 0]}
    right = {"surface v_t": history.surface_velocity[:, 0], "slider v_s": history.slider_velocity}
    data = {
        "x": (history.time - history.time[0]) * time.scale,
        "left": {key: values * force.scale for key, values in left.items()},
        "right": {key: values * velocity.scale for key, values in right.items()},
        "x_axis": time.axis,
        "left_axis": f"P and 10 {force.heading}",
        "right_axis": velocity.axis,
    }
    return Panel(name=name, title=title, data=data)


def figure_6a(seed: Seed):
    """Fig. 6(a): constant contact."""
    history = seed.history(CONSTANT, stage="start", skip=ACCELERATION, cycles=2, points_per_cycle=200)
    force, speed = history.normal_force[:, 0], history.surface_velocity[:, 0]
    mean = float(history.tangential_force[:, 0].mean())
    findings = [
        judged('Fig. 6(a): "The normal force P reaches a maximum when the wave velocity v_t is positive."',
               "v_t at the largest P over its peak", speed[force.argmax()] / speed.max(),
               expected="near 1; and near -1 at the smallest P",
               holds=speed[force.argmax()] > 0.9 * speed.max() and speed[force.argmin()] < 0.9 * speed.min()),
        judged('Fig. 6(a): "Therefore, the average friction force, which drives the slider, becomes positive."',
               "mean Q over mu times the preload, 1 ms after the start",
               mean / (seed.slider.friction_coefficient * seed.slider.preload), expected="positive", holds=mean > 0),
        judged("Fig. 6(a): constant contact at 3 nm.", "smallest P over the preload",
               force.min() / seed.slider.preload, expected="positive", holds=force.min() > 0),
    ]  # fmt: skip
    panel = _contact_panel("fig_6a", "Fig. 6(a): constant contact, 3 nm", history, quantity.cycle_time_s)
    return [panel], findings


def figure_6b(seed: Seed):
    """Fig. 6(b): intermittent contact."""
    history = seed.history(INTERMITTENT, stage="start", skip=ACCELERATION, cycles=2, points_per_cycle=400)
    regimes = history.regime[:, 0]
    separated = float((regimes == "separated").mean())
    switching = judged('Fig. 6(b): "contact-no contact switching is present besides stick-slip switching."',
                       "share of a cycle without contact, 10 nm", separated,
                       expected="between 0 and 1, with stick and slip in the rest",
                       holds=0 < separated < 1 and {"stick", "slip"} <= set(regimes))  # fmt: skip
    panel = _contact_panel("fig_6b", "Fig. 6(b): intermittent contact, 10 nm", history, quantity.cycle_time_s)
    return [panel], [switching]


def figure_7(seed: Seed):
    """Figs 7(a) and 7(b): after the burst."""
    slider, frequency = seed.slider, seed.shape[0].frequency
    friction = slider.friction_coefficient * slider.preload
    stopping = seed.steady(CONSTANT).velocity * slider.mass / friction
    whole = seed.history(
        CONSTANT, stage="after", skip=0, cycles=1.1 * stopping * frequency, points_per_cycle=2000 / stopping / frequency
    )
    slipping = whole.regime[:, 0] == "slip"
    last = np.flatnonzero(slipping)[-1]
    stop = float(whole.time[last])
    ratio = whole.tangential_force[slipping & (whole.time > 6e-3), 0] / friction
    cycles = 1.5e-3 * frequency
    ring = seed.history(CONSTANT, stage="after", skip=stop * frequency, cycles=cycles, points_per_cycle=1500 / cycles)
    sticking = ring.regime[:, 0] == "stick"
    deformation = abs(ring.deformation[sticking, 0])
    limit = slider.limit_slope * slider.rest_approach(1)
    v, t = ring.slider_velocity[sticking], ring.time[sticking]
    rising = np.flatnonzero((v[:-1] < 0) & (v[1:] >= 0))
    crossings = t[rising] - v[rising] * (t[rising + 1] - t[rising]) / (v[rising + 1] - v[rising])
    period = float(np.mean(np.diff(crossings)))
    spans = [abs(v[(t >= start) & (t < start + period)]).max() for start in crossings[:-1]]
    decrement = float(math.log(spans[0] / spans[-1]) / (len(spans) - 1))
    findings = [
        judged('Fig. 7(a): "only slip will be present and the applied slider force F_s equals approximately '
               'mu P sign(v_s)."', "Q over mu times the preload from 6 ms after the burst to the stop, mean",
               ratio.mean(), expected="-1: friction opposes v_s",
               holds=np.max(abs(ratio + 1)) < 1e-3 and slipping[:last].all()),
        judged('Fig. 7(b): "The friction switches to stick when the velocity v_f becomes zero."',
               "largest |x| while sticking over x_max at rest: the ring starts at the slip limit",
               deformation.max() / limit, expected="1", holds=abs(deformation.max() / limit - 1) < 1e-2),
        judged('Section IV: "oscillation ... due to the combination of tangent stiffness, mass and damper."',
               "frequency of the ring (Hz)", 1 / period,
               expected=f"{ring_at_slip_limit(slider):.0f}, by energy at the slip limit, within 1 %",
               holds=abs(1 / period / ring_at_slip_limit(slider) - 1) < 0.01),
        judged('Section IV: "A damped oscillation will occur."', "logarithmic decrement of v_s per period", decrement,
               expected="visible in a few periods: more than 0.03", holds=decrement > 0.03,
               remark="the elastic law leaves it to R_t; micro-slip (Mindlin and Deresiewicz) at the slip limit would "
               "lose 0.15 (mu P)^2/(a G) per cycle of the 0.1125 stored, a decrement of 0.67: Fig. 7(b) needs that, "
               "which the paper leaves out, or a damper that would stop the motor"),
    ]  # fmt: skip
    panels = [
        _contact_panel("fig_7a", "Fig. 7(a): after the burst, slip", whole, quantity.time_s),
        _contact_panel("fig_7b", "Fig. 7(b): after the burst, stick", ring, quantity.time_s),
    ]  # fmt: skip
    return panels, findings


def ring_at_slip_limit(slider) -> float:
    """Return the frequency (Hz) of the tangential ring of one ball at rest whose amplitude is the slip limit.

    Quarter period by energy, (1/4) T = int_0^{x_max} dx/sqrt(2 (W(x_max) - W(x))/m), regularised at the turning point
    by x = x_max sin(psi); W is the integral of Q = mu K (z^1.5 - (z - x/c)^1.5).
    """
    z, c = slider.rest_approach(1), slider.limit_slope
    node, weight = np.polynomial.legendre.leggauss(64)
    psi, weight = 0.25 * np.pi * (node + 1.0), 0.25 * np.pi * weight
    short = 2.0 * z * np.sin(0.25 * np.pi - 0.5 * psi) ** 2  # (x_max - x)/c without cancellation
    lost = slider.friction_coefficient * slider.normal_stiffness * c * (short * z**1.5 - 0.4 * short**2.5)
    return float(0.25 / np.sum(weight * c * z * np.cos(psi) / np.sqrt(2.0 * lost / slider.mass)))
