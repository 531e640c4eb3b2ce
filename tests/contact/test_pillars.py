"""Sliders on flat pillars: closed cycle against a plain stop operator, exact limits, energy, symmetry, bad input."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contact import Orbit, PassingWave, Pillars, Slider, mean_motion, pillar_load_line, pillar_motion, pillar_traction
from contact.averaged.cycle_mean import ContactMean, contact_cycles
from contact.averaged.cycle_pieces import CLOSED, FORWARD, cycle_arrays
from contact.body import Paths
from contact.law.elastic import coulomb
from contact.law.normal import PUNCH
from contact.problem import ContactFactors, Problem

GAMMA, RATIO, LENGTH, FREQUENCY = 2.5078e-12, 0.88995, 414.05e-6, 9.61e6


def grid(along, across, pitch=50e-6, **given):
    """Return pillars on a grid about the slider's centre, 3 mN on each."""
    x, y = (
        each.ravel()
        for each in np.meshgrid(
            (np.arange(along) - (along - 1) / 2) * pitch, (np.arange(across) - (across - 1) / 2) * 50e-6,
            indexing="ij",
        )
    )  # fmt: skip
    given = {"preload": 3e-3 * x.size, "friction_coefficient": 0.18} | given
    return Pillars(**({"x": x, "y": y, "normal_stiffness": 1.8e6, "tangential_stiffness": 1.52e6} | given))


def wave(**given):
    """Return a 128YX wave that runs towards +x with 20 nm."""
    usual = {"forward": 20e-9, "compliance": GAMMA, "strip_width": 5e-3}
    return PassingWave(**({"frequency": FREQUENCY, "wavelength": LENGTH, "ratio": RATIO} | usual | given))


def scatter(count, sigma, seed):
    """Return heights in m."""
    return np.random.default_rng(seed).normal(scale=sigma, size=count)


def cycles(h, a, b, c, w):
    """Return the columns of flat contacts, k_n = k_t = 1, by name; P_1 and Q_1 complex."""
    out = np.empty((len(h), len(ContactMean), 1))
    for i in range(len(h)):
        parts = h, a.real, -a.imag, b.real, -b.imag
        problem = Problem(
            stiffness=1.0, contact_damping=0.0, normal_damping=0.0, preload=1.0, tangential_damping=0.0, load=0.0,
            friction=float(c[i]), limit_slope=float(c[i]), stick_band=0.0, longest=1.0, normal=PUNCH, length=1.0,
            omega=1.0,
            paths=Paths(*(np.array([float(each[i])]) for each in parts)), law=coulomb(0),
            factors=ContactFactors(*np.ones((2, 1))),
        )  # fmt: skip
        contact_cycles(problem, 0.0, np.full(1, w[i]), FORWARD, CLOSED, cycle_arrays(1, 1), out[i])
    found = {each.name: out[:, each, 0] for each in ContactMean}
    found["P1"] = found["NORMAL_COS"] - 1j * found["NORMAL_SIN"]
    return found | {"Q1": found["TANGENTIAL_COS"] - 1j * found["TANGENTIAL_SIN"]}


def random_cycles(count=60):
    """Return mean approaches, amplitudes, slip limits and speeds that hop, ride, slip and stick, lengths about 1."""
    rng = np.random.default_rng(11)
    h = rng.uniform(-0.99, 2.5, count)
    a, b = (rng.uniform(0.2, 1.2, count) * np.exp(2j * np.pi * rng.random(count)) for _ in range(2))
    return h, a, b, rng.uniform(0.05, 1.5, count), rng.uniform(0.2, 1.0, count) * rng.choice([-1, 1], count)


def stop_operator(h, a, b, c, w, steps=5_000, turns=6):
    """Return P_0, P_1, Q_0, Q_1 (k = 1) and the friction work of contacts that follow small steps."""
    phase = 2.0 * np.pi * np.arange(steps + 1) / steps
    z = np.maximum(h + (a * np.exp(1j * phase[:, None])).real, 0.0)
    y = (b * np.exp(1j * phase[:, None])).real - w * phase[:, None]
    x, moved = np.empty_like(z), np.diff(y, axis=0)
    x[0], work = 0.0, 0.0
    for turn in range(turns):
        work = np.zeros(h.size)
        for k in range(steps):
            free = x[k] + moved[k]
            x[k + 1] = np.clip(free, -c * z[k + 1], c * z[k + 1])
            work += 0.5 * (c * z[k + 1] + c * z[k]) * abs(free - x[k + 1])
        if turn < turns - 1:
            x[0] = x[-1]
    factor = np.exp(-1j * phase)[:, None]

    def mean(values):
        return np.trapezoid(values, phase, axis=0) / (2.0 * np.pi)

    return mean(z), 2.0 * mean(z * factor), mean(x), 2.0 * mean(x * factor), work / (2.0 * np.pi)


def test_the_closed_cycle_is_that_of_a_stop_operator_in_small_steps():
    # Oracle: the model as it is written down, of second order in the step
    h, a, b, c, w = random_cycles()
    w[:5] *= 3.0  # some slip all the time
    found = cycles(h, a, b, c, w)
    P0, P1, Q0, Q1, work = stop_operator(h, a, b, c, w)
    assert found["NORMAL"] == pytest.approx(P0, abs=1e-6)
    assert found["P1"] == pytest.approx(P1, abs=1e-6)
    assert found["TANGENTIAL"] == pytest.approx(Q0, abs=2e-3)
    assert found["Q1"] == pytest.approx(Q1, abs=2e-3)
    assert found["FRICTION"] == pytest.approx(work, abs=2e-3)
    assert 10 < np.sum(found["SHARE"] < 1.0) < 50


def test_the_closed_cycle_closes_the_energy_balance():
    # Conservation: -Im(P_1 a* + Q_1 b*)/2 = <Q> w + friction, for k_n = k_t = 1
    h, a, b, c, w = random_cycles(400)
    found = cycles(h, a, b, c, w)
    given = 0.5 * (found["Q1"] * b.conj()).imag
    assert given == pytest.approx(found["TANGENTIAL"] * w + found["FRICTION"], abs=3e-15)
    assert found["FRICTION"].min() >= 0.0


@pytest.mark.parametrize("preload", [3e-3, 60e-3])
def test_one_pillar_is_the_punch_of_the_first_order(preload):
    # Twin: the quadrature for any profile
    k_n, k_t = 1.8e6, 1.52e6
    slider = Slider(
        radius=10e-6, mass=1e-2, preload=preload, load=0.0, friction_coefficient=0.18, effective_modulus=k_n / 20e-6,
        tangential_modulus=k_t / 80e-6, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
        normal_damping=0.0, tangential_damping=0.0, shape="punch",
    )  # fmt: skip
    old = mean_motion(slider, Orbit(frequency=FREQUENCY, normal=20e-9, tangential=1j * RATIO * 20e-9))
    found = pillar_motion(grid(1, 1, preload=preload), wave(), loading=False)
    assert found.velocity == pytest.approx(old.first_order, rel=1e-11)
    many = pillar_motion(grid(7, 9, preload=63 * preload), wave(), loading=False)
    assert many.velocity == pytest.approx(found.velocity, rel=1e-12)


def gaussian(rows, sigma=10e-9, steps=800):
    """Return 10^4 pillars on 5 mm whose heights are a normal distribution itself, in equal rows, as weights."""
    place = (np.arange(rows) + 0.5) / rows * 5e-3 - 2.5e-3
    s = ((np.arange(steps) + 0.5) / steps * 2.0 - 1.0) * 6.0
    share = np.exp(-0.5 * s * s)
    return grid(
        1, 1, x=np.repeat(place, steps), y=np.zeros(rows * steps), heights=np.tile(s * sigma, rows),
        weights=np.tile(1e4 / rows * share / share.sum(), rows), preload=30.0,
    )  # fmt: skip


def test_ten_thousand_pillars_are_as_fast_as_independent_programs_say():
    # Published with the model: -0.92621972 m/s flat, -0.81965753 m/s with 10 nm of scatter, without loading; the
    # second is the limit of its own quadrature to 3e-6
    assert pillar_motion(grid(100, 100), wave(), loading=False).velocity == pytest.approx(-0.92621972, abs=6e-9)
    assert pillar_motion(gaussian(1), wave(), loading=False).velocity == pytest.approx(-0.81965753, rel=4e-6)


def test_the_loaded_wave_leaves_as_independent_programs_say(monkeypatch):
    # Their wave runs forward only: -0.81081891 m/s, exit 19.688829 nm, +1.2997665 rad
    from contact.averaged import row_cycle

    def forward_only(turns, force, slope, amplitude, g, incident):
        here, half, found = incident[0], 0.5j * g, amplitude.copy()
        own = slope[:, 0, 0]
        for j, turn in enumerate(turns):
            before = here * turn
            found[j, 0] = (before + half * (force[j, 0] - own[j] * amplitude[j, 0])) / (1.0 - half * own[j])
            here = (2.0 * found[j, 0] - before) / turn
        return found

    two = pillar_motion(gaussian(100, steps=100), wave())
    monkeypatch.setattr(row_cycle, "march", forward_only)
    # no step of Newton's, which knows both ways
    monkeypatch.setattr(row_cycle.RowCycle, "tangent", lambda self, *_: None)
    found = pillar_motion(gaussian(100, steps=400), wave())
    assert found.velocity == pytest.approx(-0.81081891, rel=4e-5)
    assert 20.0 * abs(found.exit_over_entry) == pytest.approx(19.688829, abs=2e-5)
    assert np.angle(found.exit_over_entry) == pytest.approx(1.2997665, abs=6e-6)
    # what runs back changes the velocity by 0.5 to 0.8 per cent
    assert 0.005 < abs(two.velocity / found.velocity - 1.0) < 0.008


@pytest.mark.parametrize(
    ("K", "first_order", "exact"),
    [
        pytest.param(1e12, -2.757e-4, -2.7557e-4, marks=pytest.mark.slow),
        pytest.param(1e13, -2.757e-3, -2.7411e-3, marks=pytest.mark.slow),
        (5e13, -1.379e-2, -1.2833e-2),
    ],
)
def test_springs_to_a_heavy_slider_advance_the_wave(K, first_order, exact):
    # dk = -Gamma (K_n + r^2 K_t), K per area, K_t = 0.844 K_n; at 10 wavelengths' length and never slipping. The rows
    # are of first order in Gamma K/k: the exact roots of the half-space are 0.05, 0.6 and 7 % smaller
    length, rows = 10 * LENGTH, 4000
    stiffness = K * length * 5e-3 / rows
    place = (np.arange(rows) + 0.5) / rows * length
    slider = grid(
        1, 1, x=place, y=0.0 * place, normal_stiffness=stiffness, tangential_stiffness=0.844 * stiffness,
        friction_coefficient=50.0, preload=rows * stiffness * 50e-9,
    )  # fmt: skip
    found = pillar_motion(slider, wave())
    assert (found.held, found.duty) == (True, 1.0)
    k = 2.0 * math.pi / LENGTH
    turns = round((first_order * k * length + np.angle(found.exit_over_entry)) / (2.0 * math.pi))
    advance = (2.0 * math.pi * turns - np.angle(found.exit_over_entry)) / (k * length)
    assert advance == pytest.approx(first_order, rel=1.5e-3)
    assert advance / exact - 1.0 == pytest.approx(first_order / exact - 1.0, abs=1.6e-3)
    # no friction work: nothing is lost
    left = abs(found.exit_over_entry) ** 2 + abs(found.reflected_over_entry) ** 2
    assert left == pytest.approx(1.0, abs=1e-12)


def test_equal_waves_from_both_sides_move_a_symmetric_slider_nowhere():
    slider = grid(24, 3, pitch=73e-6)
    found = pillar_motion(slider, wave(backward=20e-9))
    assert abs(found.velocity) < 2e-13
    # and it is the symmetry that does it
    assert abs(pillar_motion(slider, wave(backward=20e-9j)).velocity) > 1e-2


def test_the_mirrored_slider_runs_the_other_way():
    slider = grid(20, 10, heights=scatter(200, 8e-9, 1), tilt="pitch", preload_at=(1e-4, 0.0))
    turned = replace(slider, x=-slider.x, preload_at=(-1e-4, 0.0))
    here = pillar_motion(slider, wave(backward=7e-9j, strip_width=1e-3))
    there = pillar_motion(turned, wave(forward=7e-9j, backward=20e-9, strip_width=1e-3))
    assert there.velocity == pytest.approx(-here.velocity, rel=1e-10)
    assert there.tilt[0] == pytest.approx(-here.tilt[0], rel=1e-8)
    assert there.exit_over_entry == pytest.approx(here.exit_over_entry, rel=1e-10)


def test_small_forces_add_their_jumps():
    # dU = i Gamma/w (P_1 - i r Q_1) exp(i k x) of each pillar by itself
    slider = grid(3, 1, heights=[0.0, 3e-9, -2e-9])
    found = pillar_motion(slider, wave(strip_width=1.0), loading=True)
    k = 2.0 * math.pi / LENGTH
    jump = 1j * GAMMA * (found.first_normal - 1j * RATIO * found.first_tangential) * np.exp(1j * k * slider.x)
    assert found.exit_over_entry - 1.0 == pytest.approx(jump.sum() / 20e-9, rel=1e-12, abs=1e-15)


SCENES = {
    "scatter": (grid(60, 8, heights=scatter(480, 10e-9, 2)), wave(strip_width=0.4e-3), 0.0),
    "100 N, heavy load": (grid(40, 5, heights=scatter(200, 10e-9, 3), preload=2.0), wave(strip_width=0.5e-3), 0.1),
    "300 N": (grid(100, 100, preload=300.0), wave(), 0.0),
    "a thousand rows, 100 N on a strip of 2 mm": (
        grid(1000, 1, pitch=20e-6, heights=scatter(1000, 10e-9, 3), weights=10.0, preload=100.0),
        wave(strip_width=2e-3), 5.0,
    ),
    "rows half a wavelength apart": (grid(40, 20, pitch=0.5 * LENGTH), wave(strip_width=1e-3), 0.0),
    "waves from both sides": (grid(50, 4, heights=scatter(200, 8e-9, 4)), wave(backward=9e-9j), 0.0),
    "free to tilt": (
        grid(30, 30, heights=scatter(900, 5e-9, 5), tilt="free", preload_at=(3e-4, -2e-4), load_height=1e-3),
        wave(strip_width=1.5e-3), 0.3,
    ),
    "soft backing": (grid(30, 30, heights=scatter(900, 5e-9, 6), backing="soft"), wave(strip_width=1.5e-3), 0.0),
    "another cut": (grid(30, 5, heights=scatter(150, 5e-9, 7)), wave(ratio=0.7 + 0.3j, strip_width=0.3e-3), 0.0),
    "short contacts that answer many times over": (
        grid(60, 20, heights=scatter(1200, 2e-9, 9), weights=30.0, preload=60.0, friction_coefficient=0.3),
        wave(forward=40e-9, strip_width=4e-3), 0.0,
    ),
    "damper": (grid(20, 5, tangential_damping=0.05), wave(strip_width=0.3e-3), 0.0),
    "a wave towards -x": (grid(20, 5), wave(forward=0.0, backward=20e-9, strip_width=0.3e-3), 0.02),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_the_wave_pays_for_friction_and_thrust_and_no_more(name):
    slider, passing, load = SCENES[name]
    found = pillar_motion(slider, passing, load=load, loading=True)
    assert abs(found.ledger_residual) < 1e-12
    assert 0.0 <= found.friction_power <= found.wave_power_in
    assert slider.weights @ found.normal_force == pytest.approx(slider.preload, rel=1e-11)
    assert found.traction == pytest.approx(
        found.load + slider.tangential_damping * found.velocity, abs=1e-11 * slider.preload
    )
    assert found.load == math.copysign(load, found.velocity)
    assert slider.weights @ found.friction == pytest.approx(found.friction_power)
    assert found.relative_error < 1e-9
    work = found.wave_work
    assert work == pytest.approx(found.wave_power_in - found.wave_power_out, abs=1e-12 * found.wave_power_in)


def test_newtons_step_is_exact_where_contacts_stick():
    # Linear springs: one step from any amplitudes leads to those that the sweeps find
    from contact.averaged.coupled_motion import CoupledSearch

    passing = wave(backward=6e-9j, strip_width=2e-4, loading=True)
    search = CoupledSearch(grid(30, 1, friction_coefficient=50.0, preload=30 * 1.8e6 * 60e-9), passing)
    rest = search.rest(1.0)
    cycle, found = search.cycle, (search.cycle.forward.copy(), search.cycle.backward.copy())
    # within the range of stick of the same cycle
    cycle.forward, cycle.backward = 0.9 * found[0], found[1] * (1.0 + 0.1j)
    place = cycle.approaches(rest.height, 0.0, 0.0)
    forces = cycle.forces(place, 0.0, 1.0)
    slope = cycle.tangent(place, 0.0, 1.0, forces)
    cycle.waves = cycle.waves + cycle.wave_step(cycle.forces(place, 0.0, 1.0), slope)
    for now, then in zip((cycle.forward, cycle.backward), found, strict=True):
        assert now == pytest.approx(then, abs=1e-8 * 20e-9)


@pytest.mark.parametrize("rows", [1, 2, 40])
def test_the_amplitudes_of_linear_rows_keep_the_jumps_of_both_waves(rows):
    # Equations (1) and (2) of `march`, with amplitudes on both sides that follow from the means
    from contact.averaged.march import march, real_form

    def drawn(*shape):
        return draw.normal(size=shape) + 1j * draw.normal(size=shape)

    draw, g = np.random.default_rng(rows), 0.1
    turn = np.exp(-1j * np.sort(draw.uniform(0.0, 20.0, rows)))
    force, q, incident, slope = drawn(rows, 2), drawn(rows, 2), drawn(2), draw.normal(size=(rows, 4, 4))
    found = march(turn, force, slope, q, g, incident)
    forward, backward = np.full(rows + 1, incident[0]), np.full(rows + 1, incident[1])
    for j in range(rows):
        forward[j + 1] = 2.0 * found[j, 0] / turn[j] - forward[j]
    for j in range(rows - 1, -1, -1):
        backward[j] = 2.0 * found[j, 1] * turn[j] - backward[j + 1]
    there = force + (slope @ (found - q).view(float)[..., None])[..., 0].view(complex)
    assert np.diff(forward) == pytest.approx(1j * g * there[:, 0] / turn, abs=1e-12)
    assert np.diff(backward) == pytest.approx(-1j * g * there[:, 1] * turn, abs=1e-12)
    linear = drawn(rows, 2, 2)  # as in complex numbers
    assert real_form(linear) @ q.view(float)[..., None] == pytest.approx(
        (linear @ q[..., None]).view(float).reshape(rows, 4, 1)
    )


def test_a_wave_that_falls_to_a_tenth_leaves_the_traction_of_a_small_wave():
    # On the small wave nothing touches at the height of the large one: the search begins anew
    slider = grid(3, 1, heights=[0.0, 3e-9, -2e-9], preload=3e-3)
    traction = pillar_traction(slider, wave(), loading=False)
    traction(-0.2)
    assert traction(-0.2, 0.1) == pytest.approx(pillar_traction(slider, wave(forward=2e-9), loading=False)(-0.2))


def test_the_tilted_slider_is_in_balance():
    slider, passing, load = SCENES["free to tilt"]
    found = pillar_motion(slider, passing, load=load, loading=True)
    F = slider.preload
    # it runs towards -x, so the load pulls towards +x, 1 mm above the surface, and presses the side at larger x
    assert found.load == -load
    assert np.sum(found.normal_force * slider.x) == pytest.approx(F * 3e-4 + 1e-3 * load, rel=1e-9)
    assert np.sum(found.normal_force * slider.y) == pytest.approx(-F * 2e-4, rel=1e-9)
    assert found.tilt[0] > 1e-6


def test_a_soft_backing_presses_every_row_alike():
    slider, passing, _ = SCENES["soft backing"]
    found = pillar_motion(slider, passing, loading=True)
    rows = found.normal_force.reshape(30, 30).sum(axis=1)
    assert rows == pytest.approx(np.full(30, slider.preload / 30), rel=1e-11)


def test_a_load_line_ends_at_the_stall_and_both_ends_of_the_band():
    slider, passing = grid(10, 5, heights=scatter(50, 10e-9, 8)), wave(strip_width=0.25e-3)
    line = pillar_load_line(slider, passing, points=6)
    assert line.load == pytest.approx(np.linspace(0.0, line.stall, 6), rel=1e-9)
    assert np.all(np.diff(abs(line.velocity)) < 0.0)
    assert line.velocity[-1] == 0.0
    assert line.motions[0].velocity == pytest.approx(pillar_motion(slider, passing).velocity, rel=1e-9)
    near = pillar_motion(slider, passing, load=0.999 * line.stall)
    assert 0.0 < -near.velocity < 0.05 * -line.velocity[0]
    # hopping contacts forget, riding ones keep their stretch: a band
    assert line.held_up_to == pytest.approx(line.stall, rel=1e-6)
    low = replace(passing, forward=2e-9)
    riding = pillar_load_line(slider, low, points=3)
    assert riding.held_up_to > 2.5 * riding.stall > 0.0
    held = pillar_motion(slider, low, load=0.5 * (riding.held_up_to + riding.stall))
    assert (held.held, held.velocity) == (True, 0.0)
    with pytest.raises(ValueError, match=rf"load must be at most {line.held_up_to:.6g} N, .* its stall"):
        pillar_motion(slider, passing, load=1.1 * line.held_up_to)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"heights": [0.0, 1.0]}, "slider.heights must hold one height per contact, 4, got 2"),
        ({"heights": [0.0, math.nan, 0.0, 0.0]}, "slider.heights must be finite, got nan m"),
        ({"normal_stiffness": -1.0}, "slider.normal_stiffness must be positive and finite, got -1.0 N/m"),
        ({"preload": 0.0}, "slider.preload must be positive and finite, got 0.0 N"),
        ({"tilt": "free", "preload_at": (1e-3, 0.0)}, r"must lie .* \(0.001, 0\) m: .* side at smaller x lifts"),
        ({"tilt": "free", "preload_at": (0.0, -1e-3)}, "the side at larger y lifts"),
        ({"tilt": "pitch", "backing": "soft"}, 'tilt must be "held" where slider.backing is "soft"'),
        ({"x": 0.0, "y": [0.0, 1.0, 2.0, 3.0]}, "slider.y must hold one position per contact, 1, got 4"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(given, sentence):
    with pytest.raises(ValueError, match=sentence):
        grid(2, 2, **given)


def test_a_load_far_above_the_surface_that_lifts_a_side_is_refused():
    low = grid(10, 5, tilt="pitch", load_height=1e-4)
    assert not pillar_motion(low, wave(), load=5e-3, loading=False).held
    with pytest.raises(
        ValueError, match=r"load_height must keep .* load of 0.005 N within .* side at (larger|smaller) x"
    ):
        pillar_motion(replace(low, load_height=1e-2), wave(), load=5e-3, loading=False)


def test_a_wave_that_is_loaded_needs_its_compliance_and_width():
    with pytest.raises(ValueError, match=r"wave.strip_width is required"):
        wave(strip_width=None)
    with pytest.raises(ValueError, match=r"compliance .* is required where the slider loads the wave"):
        pillar_motion(grid(2, 2), wave(compliance=0.0), loading=True)


@pytest.mark.parametrize("loading", [False, True])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_few_pillars_of_unequal_height_balance(count, loading):
    """The pitch of a slider on two pillars takes up their heights; on more, the forces and moments balance.

    The heights differ by ten times the amplitude: at first one pillar alone touches, which does not hold the pitch.
    """
    given = {"preload": 0.6e-3 * count, "normal_stiffness": 2e6, "tangential_stiffness": 1.7e6, "tilt": "pitch"}
    passing, apart = wave(forward=1e-9, strip_width=2e-4), 80e-6
    level = pillar_motion(grid(count, 1, pitch=apart, **given), passing, loading=loading)
    for seed in range(4):
        heights = scatter(count, 10e-9, seed)
        found = pillar_motion(grid(count, 1, pitch=apart, heights=heights, **given), passing, loading=loading)
        forces, x = found.normal_force, (np.arange(count) - (count - 1) / 2) * apart
        assert np.sum(forces) == pytest.approx(0.6e-3 * count, rel=1e-10)
        assert abs(np.sum(forces * x)) < 1e-10 * np.sum(forces) * apart
        if count == 2:
            assert found.velocity == pytest.approx(level.velocity, rel=1e-9)
            assert found.tilt[0] == pytest.approx(level.tilt[0] - np.diff(heights)[0] / apart, rel=1e-8)


@pytest.mark.parametrize(("along", "across", "preload", "amplitude"), [
    (20, 4, 1e-6, 80e-9), (40, 5, 2e-6, 30e-9), (60, 6, 5e-6, 80e-9), (97, 6, 1.2e-6, 55e-9),
])  # fmt: skip
def test_a_preload_of_a_micronewton_is_carried_at_the_crests(along, across, preload, amplitude):
    # The forces' rounding over the preload is larger there, by the amplitude over the depth of the contact. Closed form
    # of pillars that stick during their short contact, |phase| < theta: the mean of the surface's velocity over it, and
    # preload = n k A (sin theta - theta cos theta)/pi
    found = pillar_motion(grid(along, across, preload=preload, tilt="free"), wave(forward=amplitude), loading=True)
    theta = (3.0 * np.pi * preload / (along * across * 1.8e6 * amplitude)) ** (1.0 / 3.0)
    crest = 2.0 * np.pi * FREQUENCY * RATIO * amplitude
    assert 1.0 + found.velocity / crest == pytest.approx(theta**2 / 6.0, rel=0.05)
    assert found.relative_error < 1e-9
    assert found.tilt == pytest.approx((0.0, 0.0), abs=1e-10)
