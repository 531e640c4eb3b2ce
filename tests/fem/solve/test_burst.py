"""Envelopes of bursts.  Oracles: responses whose envelope has a closed form; geometry and speed for the stator."""

from types import SimpleNamespace

import numpy as np
import pytest

from fem.circuit import Drive
from fem.exceptions import ConvergenceError
from fem.solve.band_solution import frequency_band
from fem.solve.burst_envelope import burst_response
from tests.fem.stators import FREQUENCY, comb, cut, plate

F0 = 2.1e6


class Line:
    """A response given by a formula: what a band is asked for."""

    def __init__(self, response, *, low=0.6 * F0, high=1.45 * F0, error=0.0):
        self.response, self.limits, self.error = response, (low, high), error
        self.asked, self.frequencies = [], set()

    def waves(self, frequencies, drive):
        self.asked.append(drive)
        self.frequencies.update(frequencies)
        motions = (np.array([0.6j, 1.0]) * self.response(frequency) for frequency in frequencies)
        return [SimpleNamespace(motion=lambda place, u=u: u, relative_error=self.error) for u in motions]


def responded(response, *, duration=40e-6, tolerance=1e-4, max_frequencies=4096, **rest):
    asked = {
        "drive": "a",
        "frequency": F0,
        "duration": duration,
        "tolerance": tolerance,
        "max_frequencies": max_frequencies,
    }
    return burst_response(Line(response, **rest), 0.01, **asked)


def delayed(delay, transit):
    """A transducer as long as ``transit`` s, ``delay`` s away: its middle's wave, sin x / x."""
    return lambda f: (2 - 1j) * np.exp(-2j * np.pi * f * delay) * np.sinc((f - F0) * transit)


def test_a_transducer_far_away_makes_a_trapezoid():
    """Ramp as long as the transit, centred on the delay; down again after the burst; corners within 1 / band."""
    delay, transit = 12e-6, 6e-6
    found = responded(delayed(delay, transit))
    steady = (2 - 1j) * np.exp(-2j * np.pi * F0 * delay)
    assert found.steady_normal == pytest.approx(steady, rel=1e-12)
    assert found.steady_tangential == pytest.approx(0.6j * steady, rel=1e-12)
    rise = np.clip((found.time - delay) / transit + 0.5, 0, 1)
    fall = np.clip((found.time - 40e-6 - delay) / transit + 0.5, 0, 1)
    np.testing.assert_allclose(found.normal / steady, rise - fall, atol=0.02)
    corners = np.array([-3, 3, 37, 43]) * 1e-6 + delay
    clear = np.min(abs(found.time[:, None] - corners), axis=1) > 1.5e-6
    # sidelobes of sin x / x beyond the band, and the counter-rotating kick 1 / (4 pi f0 transit)
    np.testing.assert_allclose((found.normal / steady)[clear], (rise - fall)[clear], atol=8e-3)
    np.testing.assert_allclose(found.tangential, 0.6j * found.normal, atol=1e-12)
    worst = abs(found.normal / steady - (rise - fall)).max()
    assert worst < 2 * found.relative_error
    assert found.settling == pytest.approx(delay + 0.49 * transit, abs=1.5e-6)


def test_the_frequencies_fill_the_band():
    line = Line(delayed(12e-6, 6e-6))
    burst_response(line, 0.01, drive="a", frequency=F0, duration=40e-6, tolerance=1e-4)
    low, high = line.limits
    step = np.median(np.diff(sorted(line.frequencies)))
    assert 0 <= min(line.frequencies) - low < step
    assert 0 <= high - max(line.frequencies) < step


def test_another_duration_needs_no_other_solution():
    found = responded(delayed(12e-6, 6e-6))
    again, direct = found.lasting(25.3e-6), responded(delayed(12e-6, 6e-6), duration=25.3e-6)
    for name in ("time", "normal", "tangential", "settling", "band_error"):
        np.testing.assert_allclose(getattr(again, name), getattr(direct, name), rtol=1e-12, atol=1e-12)
    assert found.lasting(25.3e-6, share=0.5).band_error > 1.3 * again.band_error
    with pytest.raises(ValueError, match="duration must be positive"):
        found.lasting(-1.0)


def test_a_resonance_rings_up_and_down_exponentially():
    rate = 2.5e5
    found = responded(lambda f: 1 / (1 + 2j * np.pi * (f - F0) / rate), duration=30e-6)
    on = -np.expm1(-rate * found.time)
    off = -np.expm1(-rate * np.maximum(found.time - 30e-6, 0))
    aside = (found.time > 1.5e-6) & (abs(found.time - 30e-6) > 1.5e-6)
    # the kick of the counter-rotating half: rate / (2 omega0)
    np.testing.assert_allclose(found.normal[aside], (on - off)[aside], atol=1.2 * rate / (4 * np.pi * F0) * 2)
    assert found.settling == pytest.approx(np.log(100) / rate, rel=0.1)


def test_switching_off_kicks_by_the_phase_that_the_source_has_then():
    """Of a resonance: exp(-2i phase) rate / (2i omega0 - rate) exp(-rate t), after whole cycles and an eighth."""
    rate, duration = 2.5e5, (40 + 1 / 8) / F0
    found = responded(lambda f: 1 / (1 + 2j * np.pi * (f - F0) / rate), duration=duration)
    after = found.time - duration
    clear = (after > 2e-6) & (after < 10e-6)
    plain = np.exp(-rate * after) - np.exp(-rate * found.time)
    kick = rate / (4j * np.pi * F0 - rate)
    expected = kick * (np.exp(-rate * found.time) - np.exp(-0.5j * np.pi) * np.exp(-rate * after))
    rest = (found.normal - plain)[clear]
    np.testing.assert_allclose(rest, expected[clear], atol=0.15 * abs(kick))


def test_the_energy_over_time_is_that_over_frequency():
    """Parseval, with the spectrum of the burst itself: what the band's ends cut off is below 1e-3."""
    delay, transit, duration = 12e-6, 6e-6, 20e-6
    found = responded(delayed(delay, transit), duration=duration)
    over_time = np.trapezoid(abs(found.normal) ** 2, found.time)
    f = np.linspace(0.5 * F0, 1.5 * F0, 20001)
    x = f - F0
    both = duration * np.sinc(x * duration) * np.exp(-1j * np.pi * x * duration)
    y = f + F0
    both = both + duration * np.sinc(y * duration) * np.exp(-1j * np.pi * y * duration)
    over_frequency = np.trapezoid(abs(delayed(delay, transit)(f) * both) ** 2, f)
    assert over_time == pytest.approx(over_frequency, rel=5e-3)


def test_a_wider_band_errs_less_and_its_error_says_so():
    exact_delay, transit = 12e-6, 6e-6
    worst, claimed = [], []
    for half in (0.1, 0.2, 0.4):
        found = responded(delayed(exact_delay, transit), low=(1 - half) * F0, high=(1 + half) * F0)
        rise = np.clip((found.time - exact_delay) / transit + 0.5, 0, 1)
        fall = np.clip((found.time - 40e-6 - exact_delay) / transit + 0.5, 0, 1)
        worst.append(abs(found.normal / found.steady_normal - (rise - fall)).max())
        claimed.append(found.relative_error)
    assert worst[0] > 1.5 * worst[1] > 2 * worst[2]
    assert all(error < 2 * claim for error, claim in zip(worst, claimed, strict=True))


def test_a_late_echo_asks_for_more_frequencies():
    echo = lambda f: 1 + 0.3 * np.exp(-2j * np.pi * f * 80e-6)  # noqa: E731
    near = responded(delayed(5e-6, 3e-6))
    far = responded(lambda f: delayed(5e-6, 3e-6)(f) * echo(f), duration=160e-6)
    assert far.frequencies > 3 * near.frequencies
    settled = 1 / (1 + 0.3 * np.exp(-2j * np.pi * F0 * 80e-6))
    before = np.interp(60e-6, far.time, abs(far.normal / far.steady_normal))
    assert before == pytest.approx(abs(settled), rel=5e-3)


def test_what_never_settles_is_refused():
    with pytest.raises(ConvergenceError, match="still rings"):
        responded(lambda f: 1 / (1 + 2e4j * (f / F0 - 1) * np.pi * 10), tolerance=1e-3, max_frequencies=200)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"frequency": 0.5 * F0}, r"frequency must lie in the band, 1\.26e\+06 to .* got 1050000\.0 Hz"),
        ({"duration": 0.0}, r"duration must be positive and finite, got 0\.0 s"),
    ],
)
def test_an_impossible_burst_is_refused(changes, words):
    asked = {"drive": "a", "frequency": F0, "duration": 1e-5, "tolerance": 1e-2} | changes
    with pytest.raises(ValueError, match=words):
        burst_response(Line(delayed(5e-6, 3e-6)), 0.0, **asked)


def test_source_and_response_are_passed_on():
    line = Line(delayed(5e-6, 3e-6), error=3e-3)
    drive = Drive(sources={"left": 1.0}, impedance=5j)
    found = burst_response(line, 0.0, drive=drive, frequency=F0, duration=1e-5, tolerance=1e-2)
    assert line.asked == [drive] * len(line.asked)
    assert found.response_error == 3e-3
    assert found.relative_error == found.band_error + found.step_error + 3e-3


@pytest.fixture(scope="module")
def stators():
    """A short block with one comb of 5 pairs, its ends absorbing and free, prepared for a band."""
    found = {}
    for ends in ("absorbing", "free"):
        stator = plate(cut("PZT-8", "Z", quality=100.0), length=24.0, thickness=1.0, ends=ends)
        row = comb(stator, "a", 6.0, finger_pairs=5, period=1.01)
        band = frequency_band(
            stator, (row,), lowest=0.8 * FREQUENCY, highest=1.25 * FREQUENCY, drive="a", tolerance=0.1
        )
        place = 17.0 * stator.length / 24.0
        found[ends] = (
            stator,
            row,
            place,
            band,
            burst_response(band, place, drive="a", frequency=FREQUENCY, duration=60e-6, tolerance=3e-2),
        )
    return found


def test_the_stator_s_wave_comes_when_it_can_and_settles_at_the_single_frequency(stators):
    stator, row, place, band, found = stators["absorbing"]
    wave = band.wave(FREQUENCY, drive="a")
    assert found.steady_normal == pytest.approx(complex(wave.motion(place)[1]), rel=1e-12)
    assert found.early < 5e-3
    size = abs(found.normal) / abs(found.steady_normal)
    arrival, transit = (place - row.center) / wave.phase_velocity, 5 * row.period / wave.phase_velocity
    fastest = np.sqrt(stator.solid.stiffness.max() / stator.solid.density) * 1.2  # stiffened by the coupling
    assert size[found.time < 0.7 * (place - row.extent[1]) / fastest].max() < 1e-2
    half = found.time[np.flatnonzero(size > 0.5)[0]]
    assert half == pytest.approx(arrival, abs=0.2 * transit)
    at_end = np.interp(60e-6, found.time, size)
    assert at_end == pytest.approx(1.0, abs=0.01)
    assert np.interp(60e-6 + arrival + 3 * transit, found.time, size) < 0.1


def test_free_ends_send_echoes_at_their_time(stators):
    """Both blocks agree until the wave that went left has been sent back; then they do not."""
    _, row, place, _, free = stators["free"]
    absorbing = stators["absorbing"][-1]
    speed = stators["free"][3].wave(FREQUENCY, drive="a").phase_velocity
    echo = (place + row.center - 2.5 * row.period) / speed  # the nearest finger's
    common = np.linspace(0, 50e-6, 2000)
    values = [np.interp(common, each.time, each.normal) / abs(absorbing.steady_normal) for each in (free, absorbing)]
    apart = abs(values[0] - values[1])
    assert apart[common < 0.8 * echo].max() < 0.1
    assert apart[common > echo].max() > 0.3


RATE = 2.5e5  # of a resonance 1 / (1 + 2 pi i (f - F0) / RATE): its envelope U obeys U' = RATE (a(t) - U)


def resonance(f):
    return 1 / (1 + 2j * np.pi * (f - F0) / RATE)


KICK = 2.4 * RATE / (4 * np.pi * F0)  # bound of the counter-rotating half at a switch, as above


def test_a_shape_of_one_is_the_rectangular_burst():
    """The same sum of steps, on instants of its own; a turned constant turns the motion."""
    plain = responded(delayed(12e-6, 6e-6))
    for factor in (1.0, 0.5 * np.exp(0.7j)):
        shaped = plain.lasting(40e-6, shape=lambda t, factor=factor: factor + 0.0 * t)
        inside = shaped.time < plain.time[-1]
        expected = np.interp(shaped.time, plain.time, plain.normal)[inside]
        near = abs(shaped.normal[inside] - factor * expected) / abs(plain.steady_normal)
        # linear interpolation at the corners; a turned source has another counter-rotating kick
        assert near.max() < 0.02
        assert near.mean() < 2e-3


def test_a_ramp_lags_behind_a_resonance_by_its_time_constant():
    duration, rise = 80e-6, 40e-6
    found = responded(resonance).lasting(duration, shape=lambda t: np.clip(t / rise, 0.0, 1.0) + 0j)
    t = found.time

    def ramp(t):
        """Response to t / rise from 0 on."""
        t = np.maximum(t, 0.0)
        return (t + np.expm1(-RATE * t) / RATE) / rise

    exact = ramp(t) - ramp(t - rise) - np.where(t > duration, -np.expm1(-RATE * (t - duration)), 0.0)
    clear = (t > 1e-6) & (abs(t - duration) > 1.5e-6) & (t < duration + 20e-6)
    np.testing.assert_allclose(found.normal[clear], exact[clear], atol=KICK)
    before = clear & (t < duration)  # no switch, no kick: what the band rounds and cuts off
    np.testing.assert_allclose(found.normal[before], exact[before], atol=2e-3)
    assert np.mean(abs(found.normal - exact)[t < duration]) < 2 * found.mean_error


def test_a_modulation_passes_the_side_bands_of_the_response():
    """(1 + m sin wt) in steady state: carrier 1, side bands with H(f0 +- w); of any response, here a delayed one."""
    depth, slow = 0.6, 40e3
    response = delayed(12e-6, 6e-6)
    duration = 150e-6
    found = responded(response, duration=duration).lasting(
        duration, shape=lambda t: 1.0 + depth * np.sin(2 * np.pi * slow * t) + 0j
    )
    turn = np.exp(2j * np.pi * slow * found.time)
    up, down = response(F0 + slow), response(F0 - slow)
    exact = response(F0) + depth / 2j * (up * turn - down / turn)
    settled = (found.time > 30e-6) & (found.time < duration)
    np.testing.assert_allclose(found.normal[settled], exact[settled], atol=2e-3 * abs(response(F0)))


def test_a_fast_chirp_is_that_of_an_independent_integrator():
    """The envelope's own differential equation by scipy; fast against the ring-up of 4 us, so far from H(f(t))."""
    from scipy.integrate import solve_ivp

    duration, reach = 60e-6, 90e3

    def shape(t):
        return np.exp(2j * np.pi * (-reach * t + reach * t**2 / duration))

    found = responded(resonance, low=0.55 * F0, high=1.45 * F0).lasting(duration, shape=shape)
    inside = (found.time > 2e-6) & (found.time < duration - 2e-6)
    exact = solve_ivp(
        lambda t, u: RATE * (shape(t) - u), (0.0, duration), [0j], t_eval=found.time[inside], rtol=1e-10, atol=1e-12
    ).y[0]
    np.testing.assert_allclose(found.normal[inside], exact, atol=KICK)
    f = F0 - reach + 2 * reach * found.time[inside] / duration
    quasi_static = resonance(f) * shape(found.time[inside])
    assert abs(quasi_static - exact).max() > 4 * KICK  # the test has something to find
    assert np.mean(abs(found.normal[inside] - exact)) < 2 * found.mean_error


def test_a_slow_chirp_follows_the_frequency_response():
    """H(f(t)) a(t), to the rate of the sweep times the square of the ring-up time."""
    reach, duration = 90e3, 4e-3

    def shape(t):
        return np.exp(2j * np.pi * (-reach * t + reach * t**2 / duration))

    found = responded(resonance).lasting(duration, shape=shape)
    inside = (found.time > 50e-6) & (found.time < duration - 2e-6)
    f = F0 - reach + 2 * reach * found.time[inside] / duration
    exact = resonance(f) * shape(found.time[inside])
    lag = 2 * np.pi * 2 * reach / duration / RATE**2
    assert lag < 6e-3
    np.testing.assert_allclose(found.normal[inside], exact, atol=1.5 * lag + 2e-3)


def test_switching_a_turned_source_kicks_by_its_own_phase():
    """As above for rectangular bursts: exp(-2i phase) with the phase that the source has at each switch."""
    duration, turn = (40 + 1 / 8) / F0, 0.6
    found = responded(resonance).lasting(duration, shape=lambda t: np.exp(1j * turn) + 0.0 * t)
    after = found.time - duration
    clear = (after > 2e-6) & (after < 10e-6)
    plain = np.exp(-RATE * after) - np.exp(-RATE * found.time)
    kick = RATE / (4j * np.pi * F0 - RATE) * np.exp(-2j * turn)
    expected = kick * (np.exp(-RATE * found.time) - np.exp(-0.5j * np.pi) * np.exp(-RATE * after))
    rest = (found.normal * np.exp(-1j * turn) - plain)[clear]
    np.testing.assert_allclose(rest, expected[clear], atol=0.15 * abs(kick))
