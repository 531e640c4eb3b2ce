"""The surface rings down after a burst: limits in which the answer is known, and the same motion by another way."""

import numpy as np
import pytest

from contact import ConvergenceError, Envelope, Orbit, burst, step
from tests.contact.motors import orbit, slider, way_to_rest
from tests.frozen import frozen
from tests.oracles.contact_motion import Motor

F = 2.2e6


def fading(time_constant, longest, points=400):
    t = np.linspace(0.0, longest, points)
    return Envelope(time=t, amplitude=np.exp(-t / time_constant), phase=np.zeros(points))


def after(shape, s=None, cycles=400, **changed):
    asked = {
        "duration": cycles / F,
        "after": 2e-3 if shape is None else (2e-3, shape),
        "tolerance": 1e-4,
        "samples": 400,
        "method": "stepped",
    }
    return burst(s or slider(), orbit(5e-9), **(asked | changed))


def test_a_wave_that_goes_on_is_a_longer_burst():
    # Limit: a factor of one for 300 cycles is a burst that is longer by as many
    steady_on = Envelope(time=[0.0, 300.5 / F], amplitude=[1.0, 1.0], phase=[0.0, 0.0])
    rung, longer = after(steady_on), after(None, cycles=701)
    at = np.searchsorted(rung.time, 701 / F * (1.0 - 1e-9))
    assert rung.rang == pytest.approx(301 / F, rel=1e-12)
    assert rung.time[at] == pytest.approx(701 / F, rel=1e-12)
    assert rung.velocity[at] == pytest.approx(longer.velocity_at_burst_end, rel=1e-4)
    assert rung.velocity_at_burst_end < 0.9 * rung.velocity[at]


def test_a_wave_that_stops_at_once_is_no_ring_down():
    quick, none = after(fading(0.01 / F, 3.0 / F, 4000)), after(None)
    assert quick.velocity[-1] == pytest.approx(none.velocity[-1], abs=0.1 * none.velocity_at_burst_end)
    assert none.rang == 0.0
    assert none.after_ledger is not None


def test_a_slow_end_carries_the_slider_on_and_it_still_stops():
    none, rung = after(None), after(fading(200 / F, 2000 / F))
    assert rung.rang > 1000 / F
    travelled = [np.trapezoid(each.velocity, each.time) for each in (none, rung)]
    assert travelled[1] > 1.5 * travelled[0]
    assert np.max(rung.velocity) > rung.velocity_at_burst_end
    assert abs(rung.velocity[-1]) < 0.05 * np.max(rung.velocity)
    assert np.all(np.diff(rung.time) > 0.0)
    assert rung.time[-1] == pytest.approx(400 / F + 2e-3, rel=1e-9)
    assert rung.velocity_at_burst_end == none.velocity_at_burst_end


def test_a_fall_by_two_knots_is_that_by_many():
    # a line from 1 to 0 falls to a thousandth of the maximum after 0.999 of its 300 cycles
    ends = Envelope(time=[0.0, 300 / F], amplitude=[1.0, 0.0], phase=[0.0, 0.0])
    t = np.linspace(0.0, 300 / F, 601)
    two, many = after(ends), after(Envelope(time=t, amplitude=1.0 - t * F / 300, phase=np.zeros(601)))
    assert two.rang == many.rang == pytest.approx(300 / F, rel=1e-12)
    np.testing.assert_allclose(two.velocity, many.velocity, atol=1e-9 * np.max(abs(two.velocity)))


def test_a_step_of_the_envelope_at_the_burst_end_is_seen_by_the_whole_way_too():
    # the same swell and fade as one envelope over a longer burst
    t = np.array([0.0, 400.0, 700.0, 1000.0]) / F
    whole = Envelope(time=t, amplitude=[1.0, 1.0, 0.6, 0.4], phase=[0.0, 0.0, 0.3, 0.5])
    down = Envelope(time=t[1:] - t[1], amplitude=[1.0, 0.6, 0.4], phase=[0.0, 0.3, 0.5])
    joined, split = after(None, cycles=1000, envelope=whole, tolerance=1e-5), after(down, tolerance=1e-5)
    at = np.searchsorted(split.time, 1000 / F * (1.0 - 1e-9))
    assert split.velocity[at] == pytest.approx(joined.velocity_at_burst_end, rel=1e-3)


def test_where_steps_do_not_apply_it_is_refused():
    with pytest.raises(ConvergenceError, match=r"an envelope cannot be followed by method stepped: .*stick_band"):
        after(fading(100 / F, 900 / F), slider(stick_band=1e-3), method="exact")


HOPPING = [(1, 0.4), (2, 0.0)]  # number of balls, load over the friction limit
DRIVEN, DECAY = 40, 5.0  # cycles of the drive, and of the ring-down to 1/e
AMPLITUDE = np.append(
    1.0 - np.exp(-np.arange(DRIVEN + 1.0) / DECAY), np.exp(-np.arange(1.0, 14 * DECAY) / DECAY)
)  # at the ends of the cycles


def hopping(contacts, load):
    """Return slider and waves of hopping balls, the second of them lower and a quarter of a period late."""
    heights = (0.0, -1e-9)[:contacts] if contacts > 1 else ()
    body = slider(
        mass=2e-4, preload=2e-3 * contacts, load=load * 0.2 * 2e-3 * contacts, friction_coefficient=0.2,
        normal_damping=1.0, tangential_damping=0.2, heights=heights,
    )  # fmt: skip
    waves = tuple(
        Orbit(frequency=F, normal=18e-9 * turn, tangential=-12e-9j * turn) for turn in (1.0, -1.0j)[:contacts]
    )
    return body, waves


# Oracle: explicit Runge-Kutta of order 8 between located events
@frozen(HOPPING)
def rung_down(contacts, load):
    """Place in m, deformations and approaches at rest of the balls in m, after the ring-down and 600 cycles."""
    s, waves = hopping(contacts, load)
    motor = Motor(
        mass=s.mass, preload=s.preload, load=s.load, frequency=F, normal=tuple(w.normal for w in waves),
        tangential=tuple(w.tangential for w in waves), radius=s.radius, E=s.effective_modulus, G=s.tangential_modulus,
        normal_damping=1.0, tangential_damping=0.2, heights=s.heights, numbers=(0.2, 1.0, 1.0, 0.2, 1.0, np.inf),
        times=tuple(np.arange(AMPLITUDE.size) / F), amplitude=tuple(AMPLITUDE), phase=(0.0,) * AMPLITUDE.size,
    )  # fmt: skip
    _, _, state = motor.run(AMPLITUDE.size - 1)
    _, _, (_, y, _, _) = motor.run(600, every=600, state=state, silent=True)
    return np.array([y[-1], *y[3 : 3 + contacts], *(motor.rest_height() + motor.offsets)])


@pytest.mark.parametrize(("contacts", "load"), HOPPING)
def test_the_final_position_after_a_ring_down_is_the_independent_one_within_its_error(contacts, load):
    def envelope(values):
        return Envelope(time=np.arange(values.size) / F, amplitude=values, phase=np.zeros(values.size))

    s, waves = hopping(contacts, load)
    answer = step(
        s, waves, cycles=DRIVEN, envelope=envelope(AMPLITUDE[: DRIVEN + 1]), after=envelope(AMPLITUDE[DRIVEN:])
    )
    place, *deformed = rung_down(contacts, load)
    deformations, at_rest = np.split(np.array(deformed), 2)
    c, K = 0.2 * s.effective_modulus / (4.0 * s.tangential_modulus), s.normal_stiffness
    final = place + way_to_rest(at_rest, deformations, c, load=s.load / (0.2 * K))
    assert answer.displacement == pytest.approx(final, abs=answer.error)
    assert answer.error < 2e-3 * abs(final)
