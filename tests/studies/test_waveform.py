"""Waveforms of a burst: keys, files, and motion.

Truths: the rectangular burst, the steady velocity curve, its mean, and the integrator of `tests/oracles/contact_motion`
with the waveform written down a second time.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib import pyplot as plt

import contact
from studies import Scene, SceneError
from studies.command.export import names_file
from studies.export.averaged_motor import averaged_motor
from studies.export.simulators import drive_input
from studies.model.model import Model
from studies.model.resolve import build, resolved
from studies.model.wave_to_contact import Contact
from studies.record.run_pictures import trajectories
from studies.record.waveform import modulation
from studies.remarks.run_warnings import warnings_of
from studies.runs import run
from studies.solve.ring_up import ring_up
from tests.frozen import frozen
from tests.oracles.contact_motion import Motor
from tests.studies.settings import changed
from tests.studies.test_ring_up import chip

F = 2.2e6
# The seed's ball with 1/89 of its mass under the same preload: it follows within 1 ms
LIGHT = ("slider.mass=1e-6", "slider.preload=0.873 mN", "wave.normal_amplitude=10 nm")


def given(*settings: str) -> Scene:
    return changed("twente-contact", *LIGHT, *settings)


def motion(scene, tolerance=1e-3):
    record = run(scene, tolerance=tolerance)
    assert record.points[0]["status"] == "ok", record.points[0]
    ((_, found),) = record.trajectories
    return found


def steady(amplitude, scene):
    """The steady velocity at an amplitude of the wave, m."""
    driven = Contact.prescribed(build(scene))
    return contact.steady(driven.slider, driven.at(amplitude), tolerance=1e-6, method="averaged").velocity


def test_a_waveform_of_one_is_the_burst_bit_for_bit(tmp_path):
    file = tmp_path / "one.csv"
    file.write_text("time_ms,amplitude\n0,1\n1,1\n")
    plain = motion(given("wave.burst=2 ms"))
    shapes = (
        '{shape="modulated",depth=0,frequency="1 kHz"}', f'{{file="{file}"}}', '{shape="chirp",sweep=[0,0]}',
        '{shape="ramp",rise="0.45 us",fall=1e-15}',
    )  # fmt: skip
    for shape in shapes:
        shaped = motion(given("wave.burst=2 ms", f"wave.waveform={shape}"))
        assert shaped.method == plain.method
        for name in ("time", "velocity", "position"):
            np.testing.assert_array_equal(getattr(shaped, name), getattr(plain, name))
    rectangular, one = (run(chip(*shape), tolerance=2e-2) for shape in ((), (f'drive.waveform={{file="{file}"}}',)))
    for (_, a), (_, b) in zip(rectangular.trajectories, one.trajectories, strict=True):
        np.testing.assert_array_equal(a.velocity, b.velocity)
    assert rectangular.points[1]["velocity_at_burst_end_m_per_s"] == one.points[1]["velocity_at_burst_end_m_per_s"]


def test_a_slow_ramp_follows_the_steady_curve_and_lags_by_a_time():
    """The lag v_steady(A(t)) - v(t) is (time constant) dv/dt: half of it with a ramp twice as long."""
    lags = []
    for rise in (0.02, 0.04):
        scene = given(f"wave.burst={rise}", f'wave.waveform={{shape="ramp",rise={rise}}}')
        found = motion(scene)
        at = np.argmin(abs(found.time - 0.6 * rise))
        curve = steady(10e-9 * found.time[at] / rise, scene)
        lags.append((curve - found.velocity[at]) / curve)
    assert 0.0 < lags[1] < lags[0] < 0.1
    assert lags[0] / lags[1] == pytest.approx(2.0, rel=0.1)


def test_a_slow_modulation_gives_the_mean_of_the_steady_curve():
    depth, slow, size = 0.5, 100.0, 1.6e-9
    shape = f'wave.waveform={{shape="modulated",depth={depth},frequency={slow}}}'
    scene = given("wave.burst=20 ms", shape, f"wave.normal_amplitude={size}")
    found = motion(scene)
    last = (found.time > 0.01) & (found.time <= 0.02)
    mean = np.trapezoid(found.velocity[last], found.time[last]) / np.ptp(found.time[last])
    curve = [steady(size * (1 + depth * np.sin(2 * np.pi * k / 24)), scene) for k in range(24)]
    assert mean == pytest.approx(np.mean(curve), rel=1e-2)
    assert abs(np.mean(curve) / steady(size, scene) - 1) > 5e-2  # the curve is bent: the mean is another number


DURATION = 2e-4
# amplitude and phase of each waveform against time, written down a second time
ENVELOPES = {
    'shape="ramp",rise="100 us"': (lambda t: np.clip(t / 1e-4, 0, 1), lambda t: 0 * t),
    'shape="modulated",depth=0.5,frequency="20 kHz",fall="30 us"': (
        lambda t: (1 + 0.5 * np.sin(2 * np.pi * 2e4 * t)) * np.clip((DURATION - t) / 3e-5, 0, 1),
        lambda t: 0 * t,
    ),
    'shape="chirp",sweep=["-60 kHz","90 kHz"]': (
        lambda t: 1 + 0 * t,
        lambda t: 2 * np.pi * (-6e4 * t + 15e4 * t**2 / (2 * DURATION)),
    ),
}


@frozen([(text,) for text in ENVELOPES])
def integrated(text):
    """Time, s, and velocity, m/s, of the light ball once in each cycle of the burst, by `contact_motion`."""
    t = np.linspace(0.0, DURATION, 8001)
    amplitude, phase = ENVELOPES[text]
    slider = given().slider
    motor = Motor(
        mass=slider.mass, preload=slider.preload, frequency=F, normal=(10e-9,), tangential=(-7e-9j,), E=64e9, G=12e9,
        radius=1e-3, normal_damping=0.5, tangential_damping=1e-4, numbers=(0.08, 1.0, 1.0, 0.08, 1.0, np.inf),
        times=tuple(t), amplitude=tuple(amplitude(t)), phase=tuple(phase(t)), tolerance=1e-10,
    )  # fmt: skip
    times, rows, _ = motor.run(round(DURATION * F))
    return np.array([times, rows[:, 0]])


@pytest.mark.parametrize("text", ENVELOPES)
def test_the_motion_is_that_of_an_independent_integrator(text):
    found = motion(given(f"wave.burst={DURATION}", f"wave.waveform={{{text}}}"), tolerance=1e-4)
    times, velocity = integrated(text)
    exact = np.interp(found.time, times, velocity)
    clear = found.time >= times[0]
    assert found.velocity[-1] != 0.0
    within = found.time <= DURATION * (1 + 1e-9)
    worst = abs(found.velocity - exact)[clear & within].max() / abs(exact).max()
    assert worst < 2e-3
    end = np.argmin(abs(found.time - DURATION))
    assert found.velocity[end] == pytest.approx(velocity[-1], abs=2 * found.answer.error + 2e-4 * abs(velocity[-1]))


def test_a_file_gives_what_its_shape_gives(tmp_path):
    """A trapezoid, and a chirp as frequencies and as phases."""
    duration = 4e-4
    sweep = "shape=\"chirp\",sweep=['-20 kHz','40 kHz']"
    t = np.linspace(0, duration, 401)
    angle = np.degrees(2 * np.pi * (-2e4 * t + 6e4 * t**2 / (2 * duration)))
    texts = {
        'shape="ramp",rise="0.1 ms",fall="0.2 ms"': "time_us,amplitude\n0,0\n100,1\n200,1\n400,0\n",
        'shape="ramp",rise="0.1 ms",fall="0.2 ms" ': "Zeit;Amplitude\nus;%\n0,0;0\n100,0;100\n200,0;100\n400,0;0\n",
        'shape="ramp",rise="100 us",fall="0.2 ms"': "Time (us),Amplitude\n0,0\n100,1\n200,1\n400,0\n",
        sweep: f"# a remark\ntime_s,amplitude,frequency_offset_kHz\n0,1,-20\n{duration},1,40\n",
        sweep + " ": "time_s;amplitude;phase_deg\n" + "".join(f"{a};1;{b}\n" for a, b in zip(t, angle, strict=True)),
    }
    at = np.linspace(0, duration, 1000)
    for number, (shape, text) in enumerate(texts.items()):
        file = tmp_path / f"{number}.csv"
        file.write_text(text)
        both = [given(f"wave.burst={duration}", f"wave.waveform={{{each}}}") for each in (shape, f'file="{file}"')]
        first, second = (modulation(each) for each in both)
        np.testing.assert_allclose(first.envelope.at(at), second.envelope.at(at), atol=3e-4)
        assert second.offset == pytest.approx(first.offset, rel=1e-2)
        assert second.mean_square == pytest.approx(first.mean_square, rel=1e-6)


def test_the_power_of_a_waveform_is_its_mean_square(tmp_path):
    """1 + m^2/2 over whole periods; a third of an edge."""
    both = {
        '{shape="modulated",depth=0.8,frequency="10 kHz"}': 1 + 0.8**2 / 2,
        '{shape="ramp",rise="0.1 ms",fall="0.2 ms"}': (0.1 / 3 + 0.2 / 3 + 0.1) / 0.4,
    }
    short = tmp_path / "short.csv"  # it ends before the burst
    short.write_text("time_ms,amplitude\n0.1,1\n0.2,0.5\n")
    both[f'{{file="{short}"}}'] = (0.1 + 0.1 * (1 - 0.125) / 1.5 + 0.2 * 0.25) / 0.4
    for shape, expected in both.items():
        found = modulation(given("wave.burst=0.4 ms", f"wave.waveform={shape}"))
        assert found.mean_square == pytest.approx(expected, rel=1e-4)
    warm = ("drive.burst=0.4 ms", "stator.material.conductivity=1.25", "stator.material.heat_capacity=420")
    plain, shaped = (run(chip(*warm, *more), tolerance=5e-2) for more in ((), (f"drive.waveform={shape}",)))
    assert shaped.heat["burst_rise_K"] == pytest.approx(expected * plain.heat["burst_rise_K"], rel=1e-6)


def test_a_waveform_on_a_stator_arrives_later_and_has_its_error():
    """A ramp: the slider starts where the wave arrives, and a part of the drive's end is still under way."""
    scene = chip("drive.burst=0.2 ms", 'drive.waveform={shape="ramp",rise="0.1 ms"}', "drive.voltage=150")
    record = run(scene, tolerance=2e-2)
    ((_, found),) = record.trajectories
    assert found.method == "stepped"
    assert found.rang > 0.0
    speed = record.wave["phase_velocity_m_per_s"]
    early = found.time < 0.8 * (11e-3 - 4e-3) / speed
    assert abs(found.velocity[early]).max() < 1e-3 * abs(found.velocity).max()
    rectangular = run(replace(scene, drive=replace(scene.drive, waveform=None)), tolerance=2e-2)
    both = [each.points[0]["velocity_at_burst_end_m_per_s"] for each in (record, rectangular)]
    assert 0.3 < both[0] / both[1] < 0.85
    assert record.points[0]["velocity_m_per_s"] == rectangular.points[0]["velocity_m_per_s"]
    assert 0 < record.error["parts"]["stator"] < 2e-2


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (('drive.waveform={shape="ramp",rise="1 ms"}', "-drive.burst"), "drive.waveform needs a burst"),
        (('drive.waveform={shape="ramp"}',), "drive.waveform.rise is required and missing with the shape ramp"),
        (('drive.waveform={rise="1 us"}',), "drive.waveform.shape is required and missing"),
        (('drive.waveform={shape="chirp"}',), "drive.waveform.sweep is required and missing with the shape chirp"),
        (('drive.waveform={shape="ramp",rise="1 us",depth=0.5}',), "depth must be absent with the shape ramp"),
        (('drive.waveform={shape="ramp",rise="1 ms"}',), "rise and fall must together be at most the burst, 0.0001 s"),
        (('drive.waveform={file="a.csv",rise="1 us"}',), "drive.waveform.rise must be absent with file"),
        (('drive.waveform={shape="modulated",depth=1.5,frequency="1 kHz"}',), "depth must be between 0 and 1"),
        (
            ('drive.waveform={shape="ramp",rise="1 us"}', "drive.duty=0.5"),
            "drive.waveform must be absent with drive.duty",
        ),
    ],
)
def test_what_is_refused_at_once(settings, message):
    with pytest.raises(SceneError, match=message):
        chip(*settings)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (('drive.waveform={file="none.csv"}',), "drive.waveform.file"),
        (
            ('drive.waveform={shape="modulated",depth=0.5,frequency="500 kHz"}',),
            "drive.waveform.frequency must be at most 0.1 of the wave's frequency, 220000 Hz, got 500000 Hz",
        ),
        (('drive.waveform={shape="chirp",sweep=[0,"200 kHz"]}',), "drive.waveform must stay within 1.21e.05 Hz"),
        (
            ('drive.waveform={shape="chirp",sweep=["-3 MHz",0]}',),
            "drive.waveform.sweep must be at most 0.1 of the wave's frequency, 220000 Hz, got 3e.06 Hz",
        ),
        (('drive.waveform={shape="ramp",rise="1 us"}', "slider.method=exact"), 'slider.method "auto" or "stepped"'),
        (('drive.waveform={shape="ramp",rise="1 us"}', "slider.position=7 mm"), "stands over a transducer"),
    ],
)
def test_what_is_refused_when_it_runs(settings, message):
    with pytest.raises(SceneError, match=message):
        run(chip("drive.voltage=100", *settings), tolerance=2e-2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,level\n0,1\n1,1\n", "must have the columns time_s, amplitude"),
        ("Time (s),CH1 (V)\n0,1\n1,1\n", "a factor on the level, so divide ch1_V by the level in V"),
        ("time_s,amplitude_V\n0,1\n1,1\n", "a factor on the level, so divide amplitude_V by the level in V"),
        ("time_s,amplitude\n0,1\n0,0.5\n", "line 3, time must rise from line to line, got 0 s after 0 s"),
        (
            "time_s,amplitude\n0,1\n1,-0.5\n",
            "line 3, amplitude must not be negative, got -0.5: write a phase of 180 deg",
        ),
        ("time_s,amplitude\n0,0\n1e-5,0\n", "must have an amplitude that is not 0 in the burst"),
        ("time_s,amplitude,phase_deg,frequency_offset_Hz\n0,1,0,0\n1,1,0,0\n", "one of the columns phase_deg and"),
        ("time_s,amplitude\n0,one\n1,1\n", "must be a finite number, got 'one'"),
        ("time_s,amplitude\n0,1\n1\n", "must have 2 values, got 1"),
        ("time_s,amplitude,ch2_V,note\n0,1,0,0\n1,1,0,0\n", "frequency_offset_Hz alone: remove ch2_V, note"),
        (
            "time_s,amplitude,frequency_offset_MHz\n0,1,-3\n1,1,0\n",
            "frequency_offset must be at most 0.1 of the wave's frequency, 220000 Hz, got 3e.06 Hz",
        ),
    ],
)
def test_what_is_refused_of_a_file(tmp_path, text, message):
    file = tmp_path / "drive.csv"
    file.write_text(text)
    scene = given("wave.burst=0.4 ms", f'wave.waveform={{file="{file}"}}')
    with pytest.raises(SceneError, match=message) as raised:
        resolved(scene)  # what `sawmotor check` does
    assert str(raised.value).startswith("wave.waveform.file")


def test_edges_shorter_than_a_period_are_steps_and_said_to_be():
    found = {}
    for edge in ("0.4545 us", "0.4546 us"):  # a period is 0.45455 us
        scene = given("wave.burst=20 us", f'wave.waveform={{shape="ramp",rise="{edge}"}}')
        found[edge] = modulation(scene), [each for each in warnings_of(run(scene, tolerance=1e-2)) if "a step" in each]
    step, ramp = found.values()
    assert step == (None, ["wave.waveform.rise of 0.455 us is taken as a step: a period is 0.455 us"])
    assert ramp[0].envelope.time[1] == pytest.approx(0.4546e-6)
    assert ramp[1] == []


def test_a_file_is_read_once(tmp_path):
    """What is solved is what was checked, whatever becomes of the file."""
    file = tmp_path / "drive.csv"
    file.write_text("time_us,amplitude\n0,0\n10,1\n")
    scene = build(given("wave.burst=20 us", f'wave.waveform={{file="{file}"}}')).scene
    file.unlink()
    assert modulation(scene).mean_square == pytest.approx((1 / 3 + 1) / 2, rel=1e-6)
    with pytest.raises(SceneError, match=r"wave\.waveform\.file"):
        modulation(given("wave.burst=20 us", f'wave.waveform={{file="{file}"}}'))


def test_a_motion_that_needs_its_events_has_no_answer_with_a_waveform():
    """Never the answer of the rectangular burst instead."""
    shape = 'wave.waveform={shape="ramp",rise="50 us"}'
    prescribed = given("wave.burst=1 ms", "slider.reciprocal=true", shape)
    for scene in (prescribed, chip("drive.voltage=150", "slider.reciprocal=true", shape.replace("wave.w", "drive.w"))):
        record = run(scene, tolerance=2e-2)
        assert "envelope" in record.points[0]["status"]
        assert not record.trajectories
        assert record.shortfall


def test_an_fmu_goes_with_its_drive_and_moves_as_the_run(tmp_path):
    """The averaged motor under the exported table, against the contact stepped through every cycle."""
    shape = 'wave.waveform={shape="modulated",depth=0.5,frequency="200 Hz",rise="5 ms"}'
    scene = given("wave.burst=20 ms", shape, "wave.normal_amplitude=[5e-9, 10e-9]")
    table = drive_input(scene, "motor")["motor.drive.csv"]
    head, *rows = table.splitlines()
    assert head == "time,drive"
    time, drive = np.array([row.split(",") for row in rows], float).T
    assert (time[-1], drive[0], drive[-1]) == (0.02, 0.0, 0.0)
    state = averaged_motor(scene, tolerance=1e-3).start()
    ((_, _), (_, exact)) = run(scene, tolerance=1e-3).trajectories
    ticks, velocity = np.linspace(0.0, 0.02, 401), [0.0]
    for tick in ticks[:-1]:
        state.advance(5e-5, float(np.interp(tick + 2.5e-5, time[:-1], drive[:-1])))
        velocity.append(state.velocity)
    late = ticks > 5e-3
    expected = np.interp(ticks, exact.time, exact.velocity)
    assert abs(np.array(velocity) - expected)[late].max() < 1e-2 * expected.max()
    chirp = given("wave.burst=20 ms", 'wave.waveform={shape="chirp",sweep=[0,"1 kHz"]}')
    with pytest.raises(SceneError, match=r"wave\.waveform must keep phase and frequency here"):
        drive_input(chirp, "motor")
    with pytest.raises(SceneError, match="must be a directory, as there are several files"):
        names_file(tmp_path / "motor.fmu", SimpleNamespace(format="fmu", scan=None), scene)


def test_the_picture_shows_the_waveform():
    scene = given("wave.burst=1 ms", 'wave.waveform={shape="ramp",rise="0.5 ms"}')
    figure, ax = plt.subplots()
    trajectories(run(scene, tolerance=1e-2), ax)
    (right,) = (each for each in figure.axes if "amplitude of the drive" in each.get_ylabel())
    x, y = right.lines[0].get_data()
    np.testing.assert_allclose(np.interp([0.25, 0.75], x, y), [0.5, 1.0], atol=1e-9)
    plt.close(figure)


def test_two_sources_with_a_phase_each_superpose_under_a_waveform():
    """The motion of both is that of one plus that of the other at its phase; the circuit is the same for all three."""
    base = (
        "stator.length=30 mm", "stator.thickness=3 mm", "stator.mechanical_quality=40", "drive.burst=60 us",
        *(f"transducer.{k}.{key}" for k in (0, 1) for key in ("period=0.98 mm", "finger_pairs=6")),
        "transducer.0.center=5 mm", "transducer.1.center=25 mm", "slider.position=17 mm", "drive.voltage=60",
        "-drive.transducer", 'drive.waveform={shape="chirp",sweep=["-20 kHz","30 kHz"],rise="20 us"}',
    )  # fmt: skip

    def motion_of(left, right):
        scene = resolved(changed("twente", *base, f"drive.sources={{left={left}, right={right}}}"))
        found = ring_up(Model(scene), scene.slider.center).response
        return found.time, found.normal

    (t, both), (_, one), (_, other) = (
        motion_of(*each) for each in (("1", '"0.7 at 90 deg"'), ("1", "0"), ("0", '"0.7 at 90 deg"'))
    )
    assert abs(one).max() > 0.1 * abs(both).max()
    assert abs(other).max() > 0.1 * abs(both).max()
    size = min(map(len, (both, one, other)))
    inside = t[:size] < 60e-6
    np.testing.assert_allclose(both[:size][inside], (one[:size] + other[:size])[inside], atol=0.02 * abs(both).max())
