"""Warnings of a run: each fires where its number passes the limit and not just below; shipped scenes give none.

The stator's part of the records is made up where only numbers enter; the formulas' oracles are closed forms.
"""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fem
from studies.__main__ import main
from studies.model.resolve import resolved
from studies.record import Record, text
from studies.record.point import Point
from studies.remarks import ball_surface
from studies.remarks.run_warnings import breakdown_voltage, warnings_of
from studies.runs import run
from studies.scene import Scene, read_table
from studies.solve.predictor import Predictor
from studies.solve.surface_motion import SurfaceMotion
from tests.contact.motors import slider as slider_of
from tests.studies.settings import assigned, changed


class Surface(SimpleNamespace):
    """A surface wave of one mode, or of two with a given transfer length."""

    def motion(self, x):
        x = np.asarray(x)
        return np.array([0.7j * np.ones(x.shape), np.ones(x.shape)]) * 2.4e-10

    def covered(self, x):
        return False


def scene(name, *settings) -> Scene:
    return resolved(changed(name, *settings))


def record(name, *settings, transfer_length=math.inf, points=(), summary=None) -> Record:
    """A record whose stator moves by 0.24 nm per volt everywhere."""
    chosen = scene(name, *settings)
    if chosen.wave is not None:
        wave = {"frequency_Hz": chosen.frequency}
        return Record(scene=chosen, tolerance=1e-3, wave=wave, points=points, summary=summary or {})
    velocity = 2172.0 if name.startswith("twente") else 3446.0
    surface = Surface(
        frequency=chosen.frequency,
        phase_velocity=velocity,
        transfer_length=transfer_length,
        relative_error=2e-4,
        circuit=SimpleNamespace(
            admittance=1e-3 + 1e-3j,
            voltage=1.0 + 0.0j,
            power=5e-4,
            names=(chosen.drive.transducer,),
            voltages=np.ones(1, complex),
            currents=np.zeros(1, complex),
        ),
    )
    return Record(
        scene=chosen,
        tolerance=1e-3,
        wave={
            "frequency_Hz": chosen.frequency,
            "phase_velocity_m_per_s": velocity,
            "normal_m_per_V": 2.4e-10,
            "tangential_m_per_V": 1.7e-10j,
            "standing_wave_ratio": 236.0,
            "relative_error": 2e-4,
        },
        electrical={"comb_voltage_per_volt": 1.0},
        surface={"x_m": np.zeros(1), "u_x_m_per_V": np.array([1.7e-10j])},
        surface_motion=SurfaceMotion(wave=surface),
        points=points,
        summary=summary or {},
    )


SURFACES = (ball_surface.STARTS, ball_surface.ROUGHNESS, ball_surface.MEMORY, ball_surface.CLEAN, ball_surface.WET)


def only(found: tuple[str, ...], *words: str) -> str:
    found = tuple(each for each in found if not each.startswith("the balls are computed smooth"))
    assert len(found) == 1, found
    assert all(word in found[0] for word in words), found[0]
    return found[0]


def test_the_made_up_record_gives_none():
    assert warnings_of(record("twente")) == ()
    assert warnings_of(record("lithium-niobate-yz")) == ()


def test_hertz_pressure_is_hertz():
    force, modulus, radius = 1.25, 110e9, 0.5e-3
    approach = (3 * force / (4 * modulus * math.sqrt(radius))) ** (2 / 3)
    slider = slider_of(radius=radius, effective_modulus=modulus)
    expected = (6 * force * modulus**2 / (math.pi**3 * radius**2)) ** (1 / 3)
    assert slider.pressure(approach) == pytest.approx(expected, rel=1e-12)
    assert expected == pytest.approx(2.28e9, rel=5e-3)
    # mean of a punch: P/(pi R^2) with P = 2 E R z
    punch = slider_of(radius=radius, effective_modulus=modulus, shape="punch")
    assert punch.pressure(force / (2 * modulus * radius)) == pytest.approx(force / (math.pi * radius**2))


def test_pressure_on_the_balls():
    four = ['slider.contacts=["-6 mm", "-2 mm", "2 mm", "6 mm"]', 'slider.ball="steel"', "slider.preload=5 N"]
    said = only(warnings_of(record("lithium-niobate-yz", *four)), "at rest", "1.5 GPa", "ISO 281", "larger balls")
    pressure = (6 * 1.25 * 101.155e9**2 / (math.pi**3 * 0.5e-3**2)) ** (1 / 3)
    assert f"{pressure / 1e9:.3g} GPa at rest" in said
    assert warnings_of(record("lithium-niobate-yz", *four[:2], "slider.preload=1 N")) == ()


def test_pressure_on_the_stator_and_on_the_crest():
    """Twente's ball with 172 mN: p0 = 515 MPa at rest, more on the crest; with 300 mN more at rest."""
    crest = record("twente", "slider.preload=0.172 N")
    points = (Point(voltage_V=60.0, tangential_amplitude_m=1e-9, contact_pressure_Pa=0.5174e9),)
    only(warnings_of(replace(crest, points=points)), "on the wave's crest", "the stator", "0.517 GPa", "TP-226")
    only(warnings_of(record("twente", "slider.preload=0.3 N")), "at rest", "the stator")
    assert warnings_of(record("twente", "slider.preload=0.1 N")) == ()
    assert warnings_of(record("twente", "slider.preload=0 N")) == ()


def test_field_in_the_gaps():
    gap = scene("twente").transducer[0].period / 4
    above = record("twente", f"drive.voltage={1.501e6 * gap}", "stator.ends=absorbing")
    found = [text for text in warnings_of(above) if "MV/m" in text]
    only(tuple(found), "1.5 MV/m", "depoling field", f"below {1.5e6 * gap:.3g} V")
    below = record("twente", f"drive.voltage={1.499e6 * gap}")
    assert not [text for text in warnings_of(below) if "MV/m" in text]


def test_breakdown_of_air():
    assert breakdown_voltage(1e-3) == pytest.approx(4.5e3, rel=0.2)  # 30 kV/cm, a little more over 1 mm
    assert breakdown_voltage(1e-6) == pytest.approx(breakdown_voltage(11e-6), rel=1e-2)
    assert 290 < breakdown_voltage(8e-6) < 340  # Paschen's minimum in air: 327 V at 7.5 um
    gap = 0.338e-3 / 4
    limit = breakdown_voltage(gap)
    found = warnings_of(record("lithium-niobate-yz", f"drive.voltage={1.01 * limit}"))
    only(found, "Paschen", f"{limit:.3g} V")
    assert warnings_of(record("lithium-niobate-yz", f"drive.voltage={0.99 * limit}")) == ()


def test_stress_of_the_wave():
    c = fem.material("PZT-8").stiffness
    strain = 2 * np.pi * 2.2e6 / 2172.0 * 1.7e-10
    limit = 34e6 / ((c[0, 0] - c[0, 2] ** 2 / c[2, 2]) * strain)
    found = [text for text in warnings_of(record("twente", f"drive.voltage={1.01 * limit}")) if "stress" in text]
    only(tuple(found), "34 MPa", f"below {limit:.3g} V")
    assert not [t for t in warnings_of(record("twente", f"drive.voltage={0.99 * limit}")) if "stress" in t]


def test_off_resonance():
    found = warnings_of(record("lithium-niobate-yz", "transducer.0.period=half-space"))
    only(found, "31 % larger at 9.812 MHz", 'drive.frequency = "center"', 'period = "auto"')
    assert warnings_of(record("lithium-niobate-yz", "transducer.0.period=auto")) == ()
    found = warnings_of(record("twente", "drive.frequency=2.3 MHz", "transducer.0.period=0.98736 mm"))
    only(found, "larger at 2.1", "off the transducer's resonance")
    assert warnings_of(record("twente", "drive.frequency=2.21 MHz", "transducer.0.period=0.98736 mm")) == ()
    split = ["transducer.0.split=true", "transducer.0.period=0.9 mm"]
    assert warnings_of(record("twente", *split)) == ()  # fingers that do not reflect have no such formula


def test_lossless_stator_with_reflecting_ends():
    said = warnings_of(record("lithium-niobate-yz", "stator.ends=free"))
    only(said, "lossless", "standing-wave ratio 236", "stator.mechanical_quality")
    assert warnings_of(record("lithium-niobate-yz", "stator.ends=free", "stator.mechanical_quality=5000")) == ()
    assert warnings_of(record("twente", "stator.ends=free")) == ()


def test_thin_plate():
    said = only(warnings_of(record("twente", transfer_length=0.15)), "150 mm of the stator's 160 mm", "5.1 wavelengths")
    assert "absorbing" in said
    assert warnings_of(record("twente", transfer_length=0.17)) == ()
    assert warnings_of(record("twente", "stator.bottom=absorbing", transfer_length=0.15)) == ()
    only(warnings_of(record("twente", "stator.thickness=0.9 mm")), "0.91 wavelengths", "plate wave")
    assert warnings_of(record("twente", "stator.thickness=1.1 mm")) == ()


def test_the_transfer_length_is_half_a_beat_of_the_plate_modes():
    """Oracle: where the surface mode's amplitude is lowest along a plate of 1.3 wavelengths."""
    chosen = scene("twente-left", "stator.thickness=1.3 mm", "drive.voltage=60")
    reached = run(chosen, tolerance=5e-2)
    length = reached.surface_wave.transfer_length
    only(tuple(text for text in reached.warnings if "other face" in text), f"{length * 1e3:.3g} mm")
    x = np.linspace(80e-3, 155e-3, 4000)
    size = abs(reached.surface_wave.rayleigh_motion(x)[1])
    lowest = x[1:-1][(size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])]
    assert len(lowest) == 2
    assert lowest[1] - lowest[0] == pytest.approx(2 * length, rel=3e-3)


def test_several_balls_at_one_place():
    only(warnings_of(record("twente-contact", "slider.contacts=4")), "4 balls at one position", "offsets")


def test_reversal_between_neighbouring_points():
    def moving(*speeds):
        return tuple(
            {"voltage_V": 10.0 * k, "velocity_m_per_s": v, "tangential_amplitude_m": 1e-9, "regime": "slip"}
            for k, v in enumerate(speeds, start=1)
        )

    found = warnings_of(record("twente", points=moving(-0.01, -0.02, 0.015, 0.02)))
    only(found, "between 20 V and 30 V", "-20 and 15 mm/s", "more values")
    only(warnings_of(record("twente", points=moving(-0.01, 0.0, 0.02))), "between 10 V and 30 V")
    assert warnings_of(record("twente", points=moving(-0.01, 0.0, -0.02))) == ()
    creeping = 0.009 * 2 * math.pi * 2.2e6 * 1e-9
    assert warnings_of(record("twente", points=moving(creeping, -0.02))) == ()


def test_all_points_stick(tmp_path, capsys):
    words = ["run", "twente-contact", "--set", "wave.normal_amplitude=[1e-11, 2e-11]", "--no-plot", "--report"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr()
    kept = json.loads((tmp_path / "out" / "run.json").read_text())
    threshold = kept["summary"]["threshold_amplitude_m"] * 1e9
    text = only(tuple(kept["warnings"]), "sticks at every point", f"{threshold:.4g} nm")
    assert f"sawmotor: warning: {text}" in said.err
    assert "relative error  none: no point moves" in said.out
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Warnings" in page
    assert text in page


def test_a_run_without_warnings_has_no_such_block(tmp_path, capsys):
    flat = ["--set", "slider.shape=punch", "--set", "slider.radius=2 um"]  # balls are warned of as smooth and dry
    assert main(["run", "twente-contact", "--set", "wave.normal_amplitude=5 nm", *flat, "--json"]) == 0
    assert "warnings" not in json.loads(capsys.readouterr().out)


def test_a_second_steady_motion_is_said_with_both_velocities():
    found = run(scene("twente-contact", "wave.normal_amplitude=10 nm", "slider.damping.normal=0"), tolerance=1e-3)
    (point,) = found.points
    here, other = (f"{point[key] * 1e3:.4g}" for key in ("velocity_m_per_s", "other_velocity_m_per_s"))
    only(warnings_of(found), "goes on for ever", here, other, "slider.damping.normal")
    assert not any(
        "bounce" in text for text in warnings_of(run(scene("twente-contact", "wave.normal_amplitude=10 nm")))
    )


def test_a_preload_below_the_weight_is_said():
    """0.2 kg for 0.2 g: the preload includes the weight."""
    only(warnings_of(record("twente", "slider.preload=30 mN", "slider.mass=0.2")), "weight", "1962 mN")
    assert warnings_of(record("twente", "slider.preload=weight", "slider.mass=0.01")) == ()


def test_a_finite_aperture_that_the_section_leaves_out_is_said():
    """From a tenth of u_z."""
    small, large = ({"effect": "finite aperture", "quantity": "u_z", "size": size} for size in (-0.09, -0.11))
    assert warnings_of(replace(record("twente"), model_error=(small,))) == ()
    only(warnings_of(replace(record("twente"), model_error=(large,))), "-11 % of u_z", "stator.diffraction = true")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["slider.radius=0.5"], "slider.radius = 0.5 m means balls of 1 m on a stator whose surface is 0.035 m across"),
        (["slider.radius=0.017"], None),
        (["slider.radius=0.018"], "slider.radius = 0.018 m"),
        (['slider.contacts=["0 mm", ["1.2 mm", "1.5 mm"], "-4 mm"]'], "1 and 2 are 1.921 mm apart"),
        (['slider.contacts=["0 mm", ["1.2 mm", "1.65 mm"], "-4 mm"]'], None),
        (["slider.friction_coefficient=15"], "slider.friction_coefficient is 15"),
        (["slider.friction_coefficient=1.5"], None),
        (['slider.preload="60 N"', 'slider.radius="5 mm"'], "radius of 152 um at rest, 0.15 wavelengths"),
    ],
)
def test_sizes_that_no_motor_has(settings, words):
    from studies.remarks.scene_warnings import scene_warnings

    said = [each for each in scene_warnings(scene("twente", *settings)) if "lies over" not in each]
    assert (words is None) == (not said)
    assert words is None or words in said[0]


def test_radius_in_metres_of_a_given_wave():
    from studies.remarks.scene_warnings import scene_warnings

    assert "slider.radius is 0.5 m" in next(scene_warnings(scene("twente-contact", "slider.radius=0.5")))


@pytest.mark.parametrize(("frequency", "warned"), [("2.2", True), ("2.2 MHz", False)])
def test_an_audible_frequency_of_a_given_wave(frequency, warned):
    from studies.remarks.scene_warnings import scene_warnings

    said = list(scene_warnings(scene("twente-contact", f"wave.frequency={frequency}")))
    assert len(said) == warned
    assert all("wave.frequency is 2.2 Hz, and the waves of motors have 10 kHz or more" in each for each in said)


@pytest.mark.parametrize(("frequency", "warned"), [("9.6", True), ("9.6 MHz", False), ("90 MHz", True)])
def test_a_frequency_that_no_surface_wave_of_the_period_has(frequency, warned):
    from studies.remarks.scene_warnings import scene_warnings

    table = assigned(read_table("lithium-niobate-128yx"), f"drive.frequency={frequency}")
    said = [each for each in scene_warnings(Scene.from_table("", table)) if "mean a wave" in each]
    assert len(said) == warned


def test_node_at_the_centre_of_balls_beside_it():
    found = run(scene("lithium-niobate-128yx", 'slider.position="6 mm"', 'drive.voltage="60 V"'), tolerance=0.05)
    assert not found.shortfall
    assert any("u_z vanishes at the slider's centre" in each for each in found.warnings)


def test_no_answer_where_the_wave_has_a_node_under_every_ball():
    """In the middle of a transducer u_z vanishes by symmetry; a quarter wavelength beside it the balls only rub."""
    section = ["slider.contacts=1", "stator.diffraction=false", 'drive.voltage="60 V"']
    found = run(scene("lithium-niobate-128yx", *section, 'slider.position="6 mm"'), tolerance=0.05)
    assert found.shortfall.startswith("no answer: u_z vanishes under the slider")
    assert found.refused
    beside = run(scene("lithium-niobate-128yx", *section, 'slider.position="6.1 mm"'), tolerance=0.05)
    assert "vanishes" not in beside.shortfall


def of_the_seed(*settings) -> Record:
    """The run of twente-contact at 10 nm with some settings changed."""
    return run(changed("twente-contact", "wave.normal_amplitude=10 nm", *settings))


@pytest.mark.parametrize("law", ["elastic", "hysteretic"])
def test_a_load_above_friction_is_said_and_a_runaway_has_no_answer(law):
    """V = (load - mu preload)/R_t: 1 N made -10 km/s with an error of 0 and no word; friction holds 69.85 uN."""
    law = f'slider.law="{law}"'
    dragged = of_the_seed("slider.load=1 mN", law)
    assert float(dragged.velocity[0]) == pytest.approx(-(1e-3 - 69.8472e-6) / 1e-4, rel=1e-5)
    assert dragged.exit_code == 0
    only(dragged.warnings, "slider.load, 0.001 N, exceeds the friction that holds the slider, 6.985e-05 N")
    below, above = (of_the_seed(f"slider.load={(69.8472e-6 + 1e-4 * each):.9g}", law) for each in (199.9, 200.1))
    assert float(below.velocity[0]) == pytest.approx(-199.9, rel=1e-4)
    why = "runaway: the slider would run at -200.1 m/s, and from 200 m/s on"
    assert above.points[0]["status"].startswith(f"no answer: {why}")
    assert above.shortfall.startswith(f"1 of 1 points have no answer: {why}")
    assert (above.exit_code, "velocity_m_per_s" in above.points[0]) == (3, False)
    answer = Predictor(above.scene.to_table(), tolerance=1e-3).answers([{}, {"slider.load": 1.0}])
    assert all(each.point.status.startswith("no answer: runaway") for each in answer)


@pytest.mark.parametrize(
    ("settings", "strain"),
    [
        (["wave.normal_amplitude=0.1 mm"], 2 * math.pi * 2.2e6 * 1e-4 / 3000),
        (["wave.normal_amplitude=1 um", "wave.tangential_ratio=10"], 2 * math.pi * 2.2e6 * 1e-5 / 3000),
        (["wave.normal_amplitude=10 um", "wave.wavelength=1 mm"], 2 * math.pi * 1e-5 / 1e-3),
        (["wave.normal_amplitude=0.4 um"], None),  # strain 0.0018, an effect of 0.9 %
    ],
)
def test_a_prescribed_wave_of_absurd_amplitude_is_refused_as_one_of_a_stator(settings, strain):
    """The strain times 5: listed from 1 %, warned of from 10 %, refused from 100 %."""
    answer = of_the_seed(*settings)
    if strain is None:
        assert {each["effect"] for each in answer.model_error} <= {*SURFACES}
        assert all(each.startswith("the balls are computed smooth") for each in answer.warnings)
        assert answer.shortfall == ""
        return
    (effect,) = (each for each in answer.model_error if each["effect"] not in SURFACES)
    assert effect["size"] == pytest.approx(5 * strain, rel=1e-12)
    assert any("nonlinear elasticity" in each for each in answer.warnings) == (5 * strain >= 0.1)
    refused = 5 * strain >= 1
    assert ("nonlinear elasticity" in answer.shortfall) == refused == (answer.exit_code != 0)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["slider.friction_coefficient=0"], "none: without friction the wave does not move the slider"),
        (["slider.preload=0"], "none: without a preload the wave does not move the slider"),
        (["slider.friction_coefficient=0", "slider.load=1 uN"], "none: the load exceeds friction and moves"),
    ],
)
def test_without_friction_no_load_is_blamed_that_is_zero(settings, words):
    assert f"threshold       {words}" in text.answer(of_the_seed(*settings))


@pytest.mark.parametrize(("chi", "pulls"), [(5.0, False), (20.0, True)])
def test_a_contact_damper_that_pulls_is_remarked_and_no_error(chi, pulls):
    answer = of_the_seed(f"slider.damping.contact={chi}")
    assert answer.exit_code == 0
    if not pulls:
        assert not any("slider.damping.contact" in each for each in answer.warnings)
        return
    only(answer.warnings, "slider.damping.contact, 20 s/m", "up to 1.84 mN during 20 % of a cycle")


@pytest.mark.parametrize("order", [1, -1])
def test_each_transducer_has_the_field_of_its_own_voltage_in_its_own_gaps(order):
    """60 V at the wide gaps of the one, 30 V at gaps a twentieth as wide of the other, in either order."""
    narrow = record("twente", "transducer.1.metallisation=0.975", "drive.voltage=60")
    gap = narrow.scene.transducer[1].period / 80
    circuit = narrow.surface_wave.circuit
    circuit.names, circuit.voltages = ("left", "right")[::order], np.array([1.0, 0.5j])[::order]
    circuit.currents = np.zeros(2, complex)
    scene = replace(narrow.scene, transducer=narrow.scene.transducer[::order])
    found = [text for text in warnings_of(replace(narrow, scene=scene)) if "MV/m" in text]
    only(tuple(found), f"transducer right, 30 V over {gap * 1e6:.3g} um", f"{30 / gap / 1e6:.3g} MV/m",
         f"keep the drive below {1.5e6 * gap * 2:.3g} V")  # fmt: skip
    circuit.voltages = np.array([1.0, 0.3])[::order]  # and not the largest voltage in the narrowest gaps
    assert not [text for text in warnings_of(replace(narrow, scene=scene)) if "MV/m" in text]


@pytest.mark.parametrize(
    ("keys", "gap"),
    [
        ({}, 0.2 / 2),
        ({"split": True}, 0.2 / 4),
        ({"pattern": "+-+-+-"}, 0.2 / 2),
        ({"pattern": "+00--0"}, 3 / 2 - 0.8 / 2),
        ({"pattern": "++o-00"}, 2 * 0.2 / 2),
        ({"pattern": "+0+0+0"}, None),
    ],
)
def test_the_gap_between_fingers_of_both_electrodes(keys, gap):
    """Three periods of 1 mm, fingers of 0.8 of the pitch; an open strip divides the gap into two."""
    block = replace(scene("twente").transducer[0], period=1e-3, finger_pairs=3, metallisation=0.8, **keys)
    assert block.gap == (None if gap is None else pytest.approx(1e-3 * gap, rel=1e-12))


def test_a_second_source_off_its_resonance_is_said_by_its_name():
    """Both are driven; the first is at its centre."""
    settings = ("drive.frequency=2.21 MHz", "transducer.0.period=0.98736 mm", "transducer.1.period=0.93 mm")
    made = record("twente", *settings)
    drive = replace(made.scene.drive, sources=(("left", 1.0), ("right", 1.0)))
    found = warnings_of(replace(made, scene=replace(made.scene, drive=drive)))
    only(tuple(text for text in found if "resonance" in text), "off the resonance of transducer right")
    assert not [text for text in warnings_of(made) if "resonance" in text]  # the right one is not driven
