"""Envelopes, steps, stopping."""

import numpy as np
import pytest

from contact import ConvergenceError, Envelope, Orbit, Slider, burst, cycles_for, step
from contact.answers.rest_motion import rest_problem
from contact.problem import largest_resonance
from tests.contact.motors import orbit, slider, stop_motor
from tests.oracles.contact_stop import extrapolated


def flat(amplitude, phase):
    return Envelope(time=[0.0], amplitude=[amplitude], phase=[phase])


def run(o, **given):
    asked = {"duration": 3e-4, "after": 0.0, "tolerance": 1e-4, "samples": 2, "method": "stepped"}
    return burst(slider(), o, **(asked | given))


def test_a_flat_envelope_scales_the_wave():
    plain = run(orbit(6e-9))
    assert run(orbit(3e-9), envelope=flat(2.0, 0.0)).velocity_at_burst_end == pytest.approx(
        plain.velocity_at_burst_end, rel=1e-12
    )


def test_a_phase_that_runs_is_a_frequency():
    # a phase of -2 pi per 101 cycles takes 1/101 of the frequency away: 303 cycles are 300 of the slower wave
    slow = 300 / 303 * 2.2e6
    t = np.linspace(0.0, 300 / slow, 601)
    e = Envelope(time=t, amplitude=np.ones(601), phase=2.0 * np.pi * (slow - 2.2e6) * t)
    shifted = burst(
        slider(), orbit(10e-9), duration=300 / slow, after=0.0, tolerance=1e-5, samples=2, method="stepped", envelope=e
    )  # fmt: skip
    own = burst(
        slider(), orbit(10e-9, frequency=slow), duration=300 / slow, after=0.0, tolerance=1e-5, samples=2,
        method="stepped",
    )  # fmt: skip
    assert shifted.velocity_at_burst_end == pytest.approx(own.velocity_at_burst_end, rel=1e-5)


def test_tabulated_motion_is_that_of_the_envelope():
    from contact.body import Paths
    from contact.stepping.time_stepping import Knots, SurfaceRow, tabulate_cycle

    paths, number, cycle = Paths(*(np.array([a]) for a in (0.2, 0.3, -0.8, 0.5, 0.9))), 512, 3
    turn = 2.0 * np.pi
    knots = Knots(
        turn * np.array([0.5, 2.0, 3.2, 9.0]), np.array([0.4, 0.9, 1.3, 0.2]), np.array([0.1, -0.7, 1.0, 2.0])
    )
    tables = np.empty((4, number + 1, 1))
    assert tabulate_cycle(paths, number, cycle, knots, 0, tables) == 2
    phase = turn * (cycle + np.arange(number + 1) / number)
    factor = np.interp(phase, knots.at, knots.amplitude) * np.exp(1j * np.interp(phase, knots.at, knots.angle))
    u_z = np.real(factor * (0.3 + 0.8j) * np.exp(1j * phase))
    assert tables[SurfaceRow.U_Z, :, 0] == pytest.approx(u_z, abs=1e-12)
    h = turn / number
    for displacement, velocity in (
        (tables[SurfaceRow.U_Z], tables[SurfaceRow.W_Z]),
        (tables[SurfaceRow.U_X], tables[SurfaceRow.W_X]),
    ):
        for part in (slice(0, 100), slice(110, None)):  # the third knot lies at 102.4 steps
            u, rate = displacement[part], velocity[part]
            fourth = (8.0 * (u[3:-1] - u[1:-3]) - u[4:] + u[:-4]) / (12.0 * h)
            assert rate[2:-2] == pytest.approx(fourth, abs=1e-8)  # h^4/30


@pytest.mark.parametrize("mirrored", [False, True])
def test_what_happens_within_a_cycle_is_followed(mirrored):
    # a peak whose area is half a cycle, against the oracle without events
    at = np.array([0.0, 100.0, 100.5, 101.0]) / 2.2e6
    peak = Envelope(time=at, amplitude=[1.0, 1.0, 2.0, 1.0], phase=[0.0, 0.0, 0.4, 0.0])
    wave = orbit(6e-9).mirrored() if mirrored else orbit(6e-9)
    found, plain = (run(wave, envelope=e, tolerance=1e-6) for e in (peak, flat(1.0, 0.0)))
    motor = stop_motor(slider(), (orbit(6e-9),), times=tuple(at), amplitude=(1.0, 1.0, 2.0, 1.0), phase=(0, 0, 0.4, 0))
    right, unsure = extrapolated(lambda number: motor.run(660, number)[0][-1], 200)
    sign = -1.0 if mirrored else 1.0
    assert abs(found.velocity_at_burst_end - sign * right) < 2.0 * found.answer.error + unsure
    assert abs(plain.velocity_at_burst_end - sign * right) > 10.0 * found.answer.error
    assert found.status == "ok"


def test_a_step_under_an_envelope_whose_phase_bends_keeps_its_error():
    # Right: velocity Verlet with the envelope at every step (issue 44); the load bends the contacts meanwhile
    loaded = Slider(
        radius=0.0009392736459504882, mass=3.1560027013267385e-05, preload=0.002348228211070161,
        load=0.0003824619158497123, friction_coefficient=0.30961498442618973, effective_modulus=120618394012.4004,
        tangential_modulus=26088548832.194614, law="elastic", reciprocal=False, stick_band=0.0,
        contact_damping=0.06759431316781364, normal_damping=0.7875000651649494, tangential_damping=0.017299874120187218,
        heights=(0.0, 6.407233644254052e-10),
    )  # fmt: skip
    waves = (
        Orbit(
            frequency=859208.4895702864, normal=1.3357389836195002e-09,
            tangential=4.7931534239604726e-11 - 6.241918144303028e-10j,
        ),
        Orbit(
            frequency=859208.4895702864, normal=6.433817757022636e-10 - 1.1705804214384664e-09j,
            tangential=-5.239260440589251e-10 - 3.426577790348868e-10j,
        ),
    )  # fmt: skip
    time = [0.0, 8.14703309496033e-05, 0.0001629406618992066]
    bent = Envelope(time=time, amplitude=[1.0, 1.0, 1.0], phase=[0.0, 1.2213997421691722, -0.6041182723990519])
    found = step(loaded, waves, cycles=140, envelope=bent)
    assert found.displacement == pytest.approx(-3.2485e-9, abs=2.0 * found.error + 5e-14)
    assert found.error < 1e-3 * abs(found.displacement)


@pytest.mark.parametrize(("mass", "resonance"), [(0.9e-6, 2.54), (0.6e-6, 3.11), (0.4e-6, 3.81)])
def test_the_error_of_fixed_steps_holds_for_stiff_contacts(mass, resonance):
    # Oracle: without an envelope the event-driven solver follows the same motion; a stiff contact needs more steps at
    # both levels, and equal numbers would state no error
    stiff, wave = slider(mass=mass, normal_damping=0.03, tangential_damping=0.0), orbit(1e-8, frequency=50e3)
    problem = rest_problem(stiff, (wave,))
    assert largest_resonance(problem) == pytest.approx(resonance, abs=0.01)
    exact = step(stiff, wave, cycles=12).displacement
    found = step(stiff, wave, cycles=12, envelope=flat(1.0, 0.0))
    assert abs(found.displacement - exact) < 2.0 * found.error < 0.05 * abs(exact)


def test_ring_up_starts_slower():
    t = np.linspace(0.0, 1e-3, 400)
    e = Envelope(time=t, amplitude=-np.expm1(-t / 5e-5), phase=np.zeros(400))
    assert e.amplitude[0] == 0.0
    assert e.at(np.array([5e-5]))[0] == pytest.approx(1.0 - np.exp(-1.0), rel=1e-3)  # chords
    ringing, sudden = run(orbit(10e-9), envelope=e), run(orbit(10e-9))
    assert 0.3 < ringing.velocity_at_burst_end / sudden.velocity_at_burst_end < 0.95
    assert burst(
        slider(), orbit(10e-9), duration=3e-4, after=0.0, tolerance=1e-3, samples=2, envelope=e
    ).method == "stepped"  # fmt: skip
    with pytest.raises(ConvergenceError, match="no envelope"):
        burst(
            slider(), orbit(3e-9), duration=1e-5, after=0.0, tolerance=1e-3, samples=2, method="exact", envelope=e
        )  # fmt: skip


@pytest.mark.parametrize(
    ("given", "sentence"),
    [({"time": [1.0, 0.0]}, "time"), ({"amplitude": [1.0, -1.0]}, "amplitude"), ({"phase": [0.0]}, "phase")],
)
def test_envelopes_that_are_refused(given, sentence):
    good = {"time": [0.0, 1.0], "amplitude": [1.0, 1.0], "phase": [0.0, 0.0]}
    with pytest.raises(ValueError, match=f"envelope.{sentence}"):
        Envelope(**(good | given))


def test_a_step_is_the_area_under_the_velocity():
    # Oracle: trapezoidal sums over burst and slide, sampled densely; the ring's own offset stays below x_max
    found = step(slider(), orbit(10e-9), cycles=1500)
    whole = burst(slider(), orbit(10e-9), duration=1500 / 2.2e6, after=0.02, tolerance=1e-6, samples=200000)
    area = float(np.trapezoid(whole.velocity, whole.time))
    assert found.cycles == 1500
    assert found.displacement == pytest.approx(area, abs=1e-9)
    assert found.displacement == pytest.approx(found.during + found.stopping, rel=1e-14)
    assert found.velocity == pytest.approx(whole.velocity_at_burst_end, rel=1e-6)
    assert 0.0 < found.ring <= 1.0001 * slider().limit_slope * 2.0 * slider().rest_approach(1)


def swelling(cycles):
    """A wave that grows over 150 cycles after a delay of 60, and its end, which comes as late and takes as long."""
    t = np.arange(0.0, cycles + 301.0) / 2.2e6
    rise = np.clip((t * 2.2e6 - 60.0) / 150.0, 0.0, 1.0)
    fall = np.clip((t * 2.2e6 - cycles - 60.0) / 150.0, 0.0, 1.0)
    on = t * 2.2e6 < cycles + 0.5
    whole = Envelope(time=t, amplitude=rise - fall, phase=np.zeros(len(t)))
    after = Envelope(time=t[~on] - cycles / 2.2e6, amplitude=(rise - fall)[~on], phase=np.zeros(sum(~on)))
    return whole, after


@pytest.mark.parametrize("cycles", [100, 700])
def test_a_step_takes_in_what_the_wave_does_after_the_drive(cycles):
    """Oracle: the area under the velocity of a burst with the same envelopes; of 100 cycles most comes after them."""
    envelope, after = swelling(cycles)
    found = step(slider(), orbit(10e-9), cycles=cycles, envelope=envelope, after=after)
    fading = (after.time[-1] + 10.0 * found.stopping_time, after)
    whole = run(orbit(10e-9), envelope=envelope, duration=cycles / 2.2e6, after=fading, samples=20000)
    area = float(np.trapezoid(whole.velocity, whole.time))
    assert found.displacement == pytest.approx(area, rel=5e-3, abs=1.1 * found.ring)
    assert found.displacement == pytest.approx(found.during + found.stopping, rel=1e-14)
    assert found.velocity == pytest.approx(whole.velocity_at_burst_end, rel=1e-3)
    # the wave is spent 210 cycles after the drive's end
    assert 0.99 * 210 / 2.2e6 < found.stopping_time < 0.99 * 210 / 2.2e6 + 1.2e-3
    cut = step(slider(), orbit(10e-9), cycles=cycles, envelope=envelope)
    assert abs(found.displacement) > 1.3 * abs(cut.displacement)


def test_cycles_for_a_step_know_how_the_wave_grows():
    before, enough = cycles_for(slider(), orbit(10e-9), displacement=5e-9, envelopes=swelling)
    assert before.displacement < 5e-9 <= enough.displacement
    assert enough.cycles == before.cycles + 1
    envelope, after = swelling(enough.cycles)
    assert step(slider(), orbit(10e-9), cycles=enough.cycles, envelope=envelope, after=after) == enough


def test_where_one_cycle_is_enough_none_falls_short():
    asked = []

    def envelopes(cycles):
        asked.append(cycles)
        return flat(1.0, 1.57), None

    before, enough = cycles_for(slider(), orbit(10e-9), displacement=1e-10, envelopes=envelopes)
    assert min(asked) == 1  # a burst of no cycles has no envelope
    assert (before.cycles, before.displacement, enough.cycles) == (0, 0.0, 1)
    assert enough.displacement > 1e-10


def test_stopping_distance_of_a_quiet_slider():
    # Closed form v^2/(2 mu g) once the bounce has died, no tangential damper: heavy normal damping makes it so
    s = slider(normal_damping=5.0, tangential_damping=0.0)
    found = step(s, orbit(10e-9), cycles=12000)
    brake = s.friction_coefficient * s.preload / s.mass
    assert found.stopping == pytest.approx(found.velocity**2 / (2.0 * brake), rel=3e-2)
    assert found.stopping_time == pytest.approx(found.velocity / brake, rel=3e-2)


def test_cycles_for_a_step_of_two_nanometres():
    before, after = cycles_for(slider(), orbit(5e-9), displacement=2e-9)
    assert after.cycles == before.cycles + 1
    assert before.displacement < 2e-9 <= after.displacement
    assert step(slider(), orbit(5e-9), cycles=after.cycles) == after
    left, _ = cycles_for(slider(), orbit(5e-9).mirrored(), displacement=2e-9)
    assert left.displacement == -before.displacement


def test_no_wave_makes_no_step_whatever_the_load():
    found = step(slider(load=3e-5), orbit(0.0), cycles=20)
    assert found.displacement == pytest.approx(0.0, abs=1e-9 * slider().rest_approach(1))


def test_a_slider_that_friction_cannot_hold():
    with pytest.raises(ConvergenceError, match="never stops"):
        step(slider(load=1e-3), orbit(5e-9), cycles=10)
