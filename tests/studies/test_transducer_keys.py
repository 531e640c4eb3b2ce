"""Patterns, split fingers and impedances from the text of a scene to its record.

Properties: one and the same comb written in two ways, combs that change places, the circuit's closed forms.
"""

import tomllib
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from studies import Scene
from studies.model.model import Model
from studies.model.resolve import resolved
from studies.refusal import SceneError
from studies.runs import run
from studies.scene import read_table
from studies.scene.toml import document
from studies.stator import p_matrix
from studies.view.run_field import run_field
from tests.studies.settings import assigned

CHIP = [
    "stator.length=24 mm",
    "stator.thickness=1.5 mm",
    "transducer.0.period=0.98 mm",
    "transducer.1.period=0.98 mm",
    "transducer.0.center=5 mm",
    "transducer.1.center=19 mm",
    "transducer.0.finger_pairs=2",
    "transducer.1.finger_pairs=2",
    "slider.position=11 mm",
    "drive.voltage=60",
]


def chip(*settings, slider=False):
    table = read_table("twente")
    for setting in [*CHIP, *settings]:
        table = assigned(table, setting)
    scene = Scene.from_table("", table)
    return scene if slider else replace(scene, slider=None)


@cache
def answer(*settings):
    record = run(chip(*settings), tolerance=3e-2)
    return record.electrical, record.wave


def test_a_reflector_may_stand_where_nothing_is_driven():
    assert chip("transducer.1.pattern=oooo").transducer[1].pattern == "oooo"
    assert chip("transducer.1.pattern=++++").transducer[1].fingers == 4


def test_one_reach_is_that_of_all_fingers():
    each = chip("transducer.0.apodisation=0.5").transducer[0]
    assert each.overlaps == (0.5,) * 4
    assert chip("transducer.0.apodisation=[0.5]").transducer[0] == each
    assert chip("transducer.0.apodisation=[0.5, 0.5, 0.5, 0.5]").transducer[0].overlaps == each.overlaps


def test_fingers_that_all_reach_over_the_whole_aperture_are_plain_ones():
    assert answer("transducer.0.apodisation=1") == answer()


def test_a_wrong_count_is_said_once_with_the_key_of_a_scene():
    with pytest.raises(SceneError) as raised:
        chip("transducer.0.apodisation=[1.0, 0.5]")
    message = "transducer.0.apodisation must be one number for each of the 4 fingers, got 2"
    assert str(raised.value) == message


def test_patterns_and_impedances_survive_being_written():
    settings = ["transducer.0.pattern=+-0-", "transducer.1.split=true", "transducer.1.termination=50 ohm"]
    scene = chip(*settings, "drive.source_impedance=[25.0, -12.5]")
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene
    assert scene.transducer[1].termination == 50.0
    assert scene.drive.source_impedance == 25 - 12.5j


def test_fem_gets_the_comb_of_the_scene():
    scene = resolved(chip("transducer.0.pattern=+-0o", "transducer.1.split=true"))
    first, second = Model(scene).transducers
    assert first.signs == "+-0o"
    assert second.signs == "++--++--"
    assert second.pitch == pytest.approx(first.pitch / 2, rel=1e-14)


def test_one_comb_written_in_two_ways():
    plain, other = answer(), answer("transducer.0.pattern=+-+-", "transducer.1.pattern=+-+-")
    assert plain == other
    split = answer("transducer.0.split=true")
    assert split == answer("transducer.0.split=true", "transducer.0.pattern=++--++--")
    assert abs(split[0]["admittance_S"] / plain[0]["admittance_S"] - 1) > 0.1


def test_combs_that_change_places_turn_the_wave_over():
    (plain, wave), (turned, other) = answer(), answer("transducer.0.pattern=-+-+")
    assert turned["admittance_S"] == pytest.approx(plain["admittance_S"], rel=1e-10)
    assert other["normal_m_per_V"] == pytest.approx(-wave["normal_m_per_V"], rel=1e-10)


def test_the_source_s_impedance_divides_its_volt():
    bare, wave = answer()
    loaded, other = answer("drive.source_impedance=[30, 20]")
    share = 1 / (1 + (30 + 20j) * bare["admittance_S"])
    assert loaded["admittance_S"] == pytest.approx(bare["admittance_S"], rel=1e-10)
    assert loaded["comb_voltage_per_volt"] == pytest.approx(share, rel=1e-10)
    assert other["normal_m_per_V"] == pytest.approx(share * wave["normal_m_per_V"], rel=1e-10)
    assert loaded["power_W_per_V2"] == pytest.approx(abs(share) ** 2 * bare["power_W_per_V2"], rel=1e-10)


@pytest.mark.parametrize(("text", "impedance"), [("[15.0, 40.0]", 15 + 40j), ("0.2 kohm", 200.0)])
def test_a_termination_loads_the_driven_transducer(text, impedance):
    """Y_in = Y11 (1 + Z Y_open) / (1 + Z Y11) where mirror symmetry makes Y22 = Y11."""
    short = answer("transducer.1.termination=short")[0]["admittance_S"]
    opened = answer("transducer.1.termination=open")[0]["admittance_S"]
    loaded = answer(f"transducer.1.termination={text}")[0]["admittance_S"]
    expected = short * (1 + impedance * opened) / (1 + impedance * short)
    assert loaded == pytest.approx(expected, rel=1e-9)
    assert abs(opened / short - 1) > 1e-3
    assert abs(loaded / short - 1) > 1e-4


def test_the_picture_colours_fingers_by_their_comb(tmp_path):
    from studies.record.files import write_run

    scene = chip("transducer.0.pattern=++-o", "transducer.1.pattern=0+-0", slider=True)
    record = run(replace(scene, slider=None), tolerance=3e-2)
    write_run(record, tmp_path, field=True)
    fingers = run_field(tmp_path).fingers
    assert {sign: len(strips) for sign, strips in fingers.items()} == {"+": 3, "-": 2, "o": 1}
    left = Model(record.scene).transducers[0].fingers
    assert fingers["-"][0] == tuple(left[2])
    assert fingers["o"] == [tuple(left[3])]


def test_a_cell_of_three_fingers_and_a_chirp_run_and_are_written():
    """The period of "auto" is found for the whole transducer; its waves spread as a beam."""
    uneven = "transducer.0.cell=DART", "transducer.0.chirp=0.05", "transducer.0.period=auto"
    scene = chip(*uneven, "stator.ends=absorbing", slider=True)
    record = run(scene, tolerance=3e-2)
    again = run(Scene.from_table("", tomllib.loads(document(record.scene.to_table()))), tolerance=3e-2)
    assert again.points[0]["velocity_m_per_s"] == record.points[0]["velocity_m_per_s"]
    assert 0.9e-3 < record.scene.transducer[0].period < 1.15e-3  # not the strong second harmonic, 1.97 mm
    assert record.scene.stator.diffraction is True
    assert record.surface_motion.spreads
    assert record.scene.transducer[0].gap == pytest.approx(record.scene.transducer[0].period / 8, rel=0.05)
    mirrored = run(chip("transducer.0.cell=DART", "transducer.0.mirrored=true"), tolerance=3e-2)
    plain = answer("transducer.0.cell=DART")
    assert abs(mirrored.electrical["admittance_S"] / plain[0]["admittance_S"] - 1) > 1e-4


def test_apodised_and_slanted_transducers_run_are_written_and_swept():
    """Plane strips between free ends, beams between absorbing ones; both ways to the admittances agree."""
    for more in (("transducer.0.apodisation=cosine",), ("transducer.1.slant=0.1", "transducer.1.slant_strips=3")):
        scene = chip(*more, "stator.diffraction=false", slider=True)
        record = run(scene, tolerance=3e-2)
        again = run(Scene.from_table("", tomllib.loads(document(record.scene.to_table()))), tolerance=3e-2)
        assert again.points[0]["velocity_m_per_s"] == record.points[0]["velocity_m_per_s"]
        assert record.scene.stator.diffraction is False
        assert record.electrical["power_residual"] < 1e-6
        model = Model(record.scene)
        ports = model.port_admittance(record.scene.frequency, 3e-2)
        volts = record.surface_motion.circuit.voltages
        driven = complex((ports.matrix @ volts)[0] / volts[0])
        assert driven == pytest.approx(record.electrical["admittance_S"], rel=3e-2)
    plain = run(chip("stator.diffraction=false", slider=True), tolerance=3e-2)
    assert abs(record.points[0]["velocity_m_per_s"] / plain.points[0]["velocity_m_per_s"] - 1) > 1e-5
    spread = run(chip("transducer.0.apodisation=cosine", "stator.ends=absorbing", slider=True), tolerance=3e-2)
    assert spread.scene.stator.diffraction is True
    assert spread.surface_motion.spreads
    off_axis = spread.surface_motion.at([(0.011, 0.0), (0.011, 0.012)])
    assert abs(off_axis[2, 1]) < 0.5 * abs(off_axis[2, 0])  # beside the aperture of 20 mm
    cells = chip("transducer.0.slant=0.1", "transducer.0.slant_strips=3", "transducer.0.cell=DART")
    assert run(replace(cells, stator=spread.scene.stator), tolerance=3e-2).electrical["power_residual"] < 1e-6


@pytest.fixture(scope="module")
def unidirectional():
    """P-matrices of 20 cells on 128YX lithium niobate at both ends of the main lobe and in the stop band."""
    scene = Scene.load("lithium-niobate-128yx")
    row = replace(scene.transducer[0], cell="DART")
    return p_matrix.run(replace(scene, transducer=(row,), slider=None), count=3, tolerance=0.2)


def test_the_directivity_is_stated_in_decibels_beside_that_of_coupled_modes(unidirectional):
    """20 log10 exp(kappa L) with |P11| = tanh(kappa L), of fingers that reflect electrically: 0.82 dB."""
    data, finding = unidirectional.panels[0].data, unidirectional.findings[-1]
    assert finding.quantity == "directivity, right over left, at 9.6 MHz where |P11| is largest, dB"
    assert finding.found == data.directivity_dB[1]
    limit = 20 * np.log10(np.exp(np.arctanh(data.reflection_shorted[1])))
    assert abs(finding.found) == pytest.approx(limit, rel=0.1)
    assert finding.expected == f"{limit:.3g} dB to one side by coupled modes"
    assert abs(finding.found) > 0.5


def test_the_directivity_is_the_power_to_the_right_over_that_to_the_left():
    """Of two modes on either side: 10 log10((9 + 1) / (0.5^2 + 0.75))."""
    parts = [SimpleNamespace(excitation=np.array([0.5, 0.75**0.5, 3j, -1.0]))]
    np.testing.assert_allclose(p_matrix.directivity_in_dB(parts), [10.0], rtol=1e-12)
