"""The position loop: its motor against contact, its answers on invented moves, its controllers and what it refuses."""

import json
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import contact
from studies.__main__ import main
from studies.export.averaged_motor import averaged_motor
from studies.export.motor_model import push
from studies.motor import positioning
from studies.motor.controllers import CONTROLLERS, Command, MotorNumbers, Reading, controller
from studies.motor.followed_motor import FollowedMotor
from studies.motor.position_loop import Drives, Loop, moved, replayed
from studies.motor.short_bursts import SCATTER_CYCLES, step_scatter
from studies.refusal import SceneError
from studies.scene import Scene


@cache
def motor():
    return averaged_motor(Scene.load("twente-contact").replace(wave={"normal_amplitude": ["3 nm", "12 nm"]}))


@cache
def numbers():
    return positioning.motor_numbers(motor()), math.copysign(1.0, push(motor().slider, orbits(12e-9)))


def orbits(level):
    return tuple(each.scaled(level) for each in motor().drives[0].orbits)


def move(start, name="two_phase", target=1e-5, settings=None, **loop):
    known, way = numbers()
    return moved(
        start, target, controller(name, settings or {}), known, Loop(**loop),
        Drives(direction=way, frequency=motor().drives[0].orbits[0].frequency),
    )  # fmt: skip


@pytest.mark.parametrize(("cycles", "steps"), [(25, 800), (1000, 800), (200, 100)])
def test_followed_motor_makes_the_steps_of_contact(cycles, steps):
    followed = FollowedMotor(motor(), steps=steps)
    followed.advance(cycles / 2.2e6, 12e-9)
    followed.advance(5e-3, 0.0)
    truth = contact.step(motor().slider, orbits(12e-9), cycles=cycles).displacement
    assert followed.position + followed.deformation == pytest.approx(truth, abs=1e-12, rel=1e-5)


def test_averaged_motor_makes_steps_to_a_part_of_the_elastic_deformation():
    slider = motor().slider
    elastic = slider.limit_slope * slider.rest_approach(1)
    for cycles in (100, 400, 1000, 3000):
        state = motor().start()
        state.advance(cycles / 2.2e6, 12e-9)
        state.advance(0.02, 0.0)
        truth = contact.step(slider, orbits(12e-9), cycles=cycles).displacement
        # a wave that stops at once leaves the contact where in the cycle it stood, up to two deformations
        assert abs(state.position + state.deformation - truth) < 0.6 * elastic + 2e-4 * abs(truth)


def test_bursts_with_a_wave_that_grows_and_fades_are_those_of_fixed_steps():
    time = np.linspace(0.0, 2e-5, 81)
    factor = 1.0 - np.cos(0.5 * np.pi * time / 2e-5) ** 2 + 0j
    whole = motor()
    from studies.export.reduced_motor import index

    parameters = whole.parameters.copy()
    own = index.FIRST_DRIVE
    parameters[own + index.RESPONSE_NODES], parameters[own + index.RESPONSE_STEP] = len(factor), time[1]
    parameters[own + index.RESPONSE] = len(whole.tables)
    first = replace(whole.drives[0], response=factor, response_step=float(time[1]))
    shaped = replace(
        whole, parameters=parameters, tables=np.concatenate([whole.tables, factor.view(float)]),
        drives=(first, whole.drives[1]),
    )  # fmt: skip
    for cycles in (60, 200, 1000):
        long = cycles / 2.2e6
        at = np.unique(np.concatenate([time, np.linspace(0.0, max(long, 3e-5), 200)]))
        grown = np.interp(at, time, factor.real)
        during = contact.Envelope(time=at, amplitude=grown, phase=0 * at)
        fading = np.interp(at + long, time, factor.real) - grown
        after = contact.Envelope(time=at, amplitude=np.abs(fading), phase=0 * at)
        truth = contact.step(whole.slider, orbits(12e-9), cycles=cycles, envelope=during, after=after).displacement
        for state, allowed in ((shaped.start(), 2e-10 + 2e-4 * abs(truth)), (FollowedMotor(shaped), 5e-12)):
            state.advance(long, 12e-9)
            state.advance(time[-1], 0.0)  # with the steps of a wave, which fades
            state.advance(0.02, 0.0)
            assert state.position + state.deformation == pytest.approx(truth, abs=allowed, rel=1e-5)


def test_a_followed_motor_under_load_gives_way_as_cattaneo_says():
    slider = motor().slider
    limit = slider.friction_coefficient * slider.preload
    state = FollowedMotor(motor(), force=-0.5 * limit)
    reach = slider.limit_slope * slider.rest_approach(1)
    assert state.deformation == pytest.approx(reach * (1.0 - 0.5 ** (2.0 / 3.0)), rel=1e-9)
    state.advance(0.01, 0.0, force=-0.5 * limit)
    assert abs(state.position) < 1e-15
    state.advance(0.01, 0.0, force=0.0)
    assert state.position + state.deformation == pytest.approx(reach * (1.0 - 0.5 ** (2.0 / 3.0)), rel=1e-9)


def test_the_averaged_motor_goes_the_way_of_the_followed_one():
    state = FollowedMotor(motor())
    true = move(state, noise=0.0, resolution=0.0)
    assert true.settled
    assert abs(true.error_at_rest) < 1e-9
    (finer,) = replayed(FollowedMotor(motor(), steps=800), (true,), Loop())
    assert np.abs(finer - true.position).max() < 1e-10
    (averaged,) = replayed(motor().start(), (true,), Loop())
    first_burst = np.flatnonzero(np.diff(true.level) != 0.0)[2]
    assert np.abs(averaged - true.position)[:first_burst].max() < 5e-10
    # afterwards the phase of the ring is lost, and the error grows while the slider slides, as the export states
    ring = motor().ring_speed
    slides = np.cumsum(np.diff(true.time, prepend=0.0) * (np.abs(true.velocity) > ring))
    assert np.all(np.abs(averaged - true.position) < 1e-9 + 2.0 * ring * slides)
    assert any(f"up to {ring:.2g} m/s" in each for each in motor().left_out)


def test_a_slider_let_go_at_the_limit_of_slip_rings_at_the_stated_speed():
    slider = motor().slider
    state = motor().start(force=-(1.0 - 1e-9) * slider.friction_coefficient * slider.preload)
    speeds = []
    for _ in range(2000):
        state.advance(1e-7, 0.0)
        speeds.append(abs(state.velocity))
    assert max(speeds) == pytest.approx(motor().ring_speed, rel=1e-3)


def test_there_and_back_within_2_nm_with_a_sensor_of_1_nm():
    state = motor().start()
    there = move(state)
    back = move(state, target=0.0)
    for found in (there, back):
        assert found.settled
        assert abs(found.error_at_rest) < 2e-9
        assert found.within[1e-7] < found.within[1e-8] <= found.within[2e-9]
        assert found.bursts["coarse"] == 1
    assert back.level[np.flatnonzero(back.level)[0]] < 0.0 < there.level[np.flatnonzero(there.level)[0]]


def test_a_load_that_comes_is_worked_against():
    disturbed = move(motor().start(), force=-2e-5, force_at=0.0)
    assert disturbed.settled
    assert abs(disturbed.error_at_rest) < 2e-9


@pytest.mark.parametrize("name", ["burst_length", "dead_zone_pi"])
def test_other_controllers_arrive(name):
    found = move(motor().start(), name, target=1e-6, resolution=1e-9, noise=0.0)
    assert abs(found.error_at_rest) < 2e-9


def test_a_delayed_sensor_is_seen_late():
    seen = []

    def control(reading):
        seen.append(reading.position)
        return Command(level=numbers()[0].level, duration=reading.period)

    known, way = numbers()
    found = moved(
        motor().start(),
        1e-5,
        control,
        known,
        Loop(noise=0.0, resolution=0.0, delay=3e-4, limit=2e-3),
        Drives(direction=way),
    )
    true = np.interp(1e-4 * np.arange(len(seen)), found.time, found.position)
    np.testing.assert_allclose(seen[3:], true[:-3], atol=1e-15)
    assert seen[:3] == [0.0, 0.0, 0.0]


class Jumping:
    """A motor that stands where it is told: the level is its position."""

    time = position = velocity = deformation = 0.0

    def advance(self, duration, level, *, force, preload):
        self.time += duration
        self.position = level if level else self.position


def test_times_overshoot_and_bursts_of_an_invented_move():
    path = iter([0.5e-6, 1.2e-6, 1.05e-6, 1.005e-6, 1.001e-6, 1.001e-6, 1.001e-6])
    known = MotorNumbers(level=1.0, dead_zone=0.0, acceleration=1.0, braking=1.0, delay=0.0, speed_per_level=1.0)

    def control(reading):
        place = next(path, None)
        reading.memory["settled"] = place is None
        return Command(level=place or 0.0, duration=reading.period, phase="burst" if place else "rest")

    found = moved(
        Jumping(), 1e-6, control, known, Loop(noise=0.0, period=1e-3), Drives(powers=(2.0, 0.0), frequency=1e6)
    )
    assert found.overshoot == pytest.approx(0.2e-6)
    assert found.within[1e-7] == pytest.approx(2.1e-3)  # the first instant of the third period
    assert found.within[1e-8] == pytest.approx(3.1e-3)
    assert found.within[2e-9] == pytest.approx(4.1e-3)
    assert found.bursts == {"burst": 7}
    assert found.cycles == pytest.approx(7e3)
    assert found.error_at_rest == pytest.approx(1e-9, abs=1e-12)
    assert found.energy == pytest.approx(
        2.0 * 1e-3 * sum(x**2 for x in (0.5e-6, 1.2e-6, 1.05e-6, *[1.001e-6] * 4)), rel=3e-3
    )


def test_a_slider_within_one_elastic_deformation_comes_back():
    # a few cycles strain the contacts: while they last the slider is drawn along, and comes back afterwards
    slider = motor().slider
    elastic = slider.limit_slope * slider.rest_approach(1)
    state = motor().start()
    state.advance(4 / 2.2e6, 12e-9)
    farthest = 0.0
    for _ in range(200):
        state.advance(2e-6, 0.0)
        farthest = max(farthest, abs(state.position))
    stays = abs(state.position + state.deformation)
    assert stays < 0.8 * farthest
    assert stays < elastic


def test_a_user_s_function_drives_the_motor(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(
        "def bang(reading):\n"
        "    error = reading.target - reading.position\n"
        "    return (reading.motor.level if error > 3e-7 else 0.0), 0.5 * reading.period\n"
    )
    words = [
        "study",
        "positioning",
        "twente-contact",
        "--quick",
        "--controller",
        "mine.py:bang",
        "--loop",
        "limit=20e-3",
    ]
    assert main([*words, "--target", "2 um"]) == 0
    said = capsys.readouterr().out
    assert "0 to 2 um" in said
    answer = json.loads((tmp_path / "results/positioning-study-twente-contact/study.json").read_text())
    assert answer["panels"]["positioning"]["there_position_m"][-1] > 1.5e-6
    assert (tmp_path / "results/positioning-study-twente-contact/single_steps.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--target", "1 kg"], "--target must be a length"),
        (["--target", "0"], "--target must not be 0"),
        (["--target", "-2"], "mm, which the motor travels at full speed in the time limit of 1 s"),
        (["--controller", "two_phas"], "--controller 'two_phas' does not exist; did you mean two_phase?"),
        (["--controller", "none.py:f"], "--controller 'none.py' is no file"),
        (["--controller", "broken.py:f"], "--controller 'broken.py' cannot be run: NameError"),
        (["--controller", "empty.py:f"], "--controller 'empty.py' has no function 'f'"),
        (["--loop", "resolutoin=1e-9"], "resolutoin is no number of the loop or of two_phase"),
        (["--loop", "period=0"], "--loop period must be positive"),
        (["--loop", 'delay="1 mm"'], "--loop delay must be a time"),
    ],
)
def test_wrong_loops_are_one_sentence_and_write_nothing(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.py").write_text("f = undefined\n")
    (tmp_path / "empty.py").write_text("g = 1\n")
    before = set(tmp_path.iterdir())
    assert main(["study", "positioning", "twente-contact", *words]) == 2
    assert said in capsys.readouterr().err
    assert set(tmp_path.iterdir()) == before


def test_a_target_beyond_the_stator_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["study", "positioning", "twente", "--target", "100 mm"]) == 2
    said = capsys.readouterr().err
    assert "--target must keep the slider on the free surface" in said
    assert "got 100 mm" in said
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(SceneError, match="must keep the slider"):
        positioning.refuse_beyond(Scene.load("twente"), -61e-3)
    positioning.refuse_beyond(Scene.load("twente"), -50e-3)


def test_a_target_the_other_way_is_refused_before_tables_and_ring_ups_are_computed(monkeypatch):
    monkeypatch.setattr(positioning, "averaged_motor", lambda *_, **__: pytest.fail("the motor was computed first"))
    short = Scene.load("twente-left").replace(
        stator={"length": "30 mm", "thickness": "1 mm", "diffraction": False},
        transducer={"left": {"finger_pairs": 2, "center": "6 mm"}}, slider={"position": "20 mm"},
    )  # fmt: skip
    with pytest.raises(SceneError, match=r'--target must be negative, such as "-10 um": .*, got 2 um'):
        positioning.run(short, target="2 um")


def test_a_controller_that_answers_nonsense_is_refused(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("def none(reading):\n    return None\n\n\ndef broken(reading):\n    return 1 / 0\n")
    reading = Reading(time=0.0, position=0.0, target=1.0, period=1e-4, motor=numbers()[0])
    with pytest.raises(SceneError, match="must return a finite level"):
        controller(f"{file}:none", {})(reading)
    with pytest.raises(SceneError, match="failed at 0 s: ZeroDivisionError"):
        controller(f"{file}:broken", {})(reading)


def test_scatter_of_a_step_follows_from_the_tolerances():
    # far from the steady speed a step goes with the friction force: 12.5 % of friction at 95 % are 6.4 % of a step
    scene = Scene.load("twente-contact").replace(
        wave={"normal_amplitude": "12 nm"}, uncertain={"slider.friction_coefficient": 0.01}
    )
    mean, deviation = step_scatter(scene, motor())
    truth = contact.step(motor().slider, orbits(12e-9), cycles=SCATTER_CYCLES).displacement
    assert mean == pytest.approx(truth, rel=0.1)
    assert deviation == pytest.approx(0.01 / 1.96 / 0.08 * truth, rel=0.5)
    assert step_scatter(Scene.load("twente-contact"), motor()) is None


def test_controllers_are_data():
    for name, kind in CONTROLLERS.items():
        assert controller(name, {"tolerance": 3e-9}) == replace(kind(), tolerance=3e-9)
    assert math.isinf(controller("burst_length", {}).coarse)


def test_a_wave_below_the_threshold_is_refused_by_its_own_key():
    low = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["0.1 nm"]})
    with pytest.raises(SceneError, match=r"wave.normal_amplitude must reach above the threshold, 0.\d+ nm, got 0.1 nm"):
        positioning.motor_numbers(replace(motor(), scene=low, levels=(1e-10,)))
