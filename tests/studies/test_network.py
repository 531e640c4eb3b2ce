"""The network study: S-parameters and files of a small scene, its options and their refusals."""

import numpy as np
import pytest
import skrf

import fem
from fem.waveguide.port_fields import stator_cascade
from studies import Scene
from studies.__main__ import main
from studies.chain.fem_model import stator, transducers
from studies.chain.resolve import resolved
from studies.refusal import SceneError
from studies.scene import read_table
from studies.stator import network
from studies.study import run_study


def chip(**transducer) -> Scene:
    """Two unlike transducers on a short block, the right one first in the scene."""
    table = read_table("twente")
    del table["slider"]
    table["stator"] |= {"length": "16 mm", "thickness": "1.5 mm"}
    left, right = table["transducer"]
    left |= {"center": "4 mm", "finger_pairs": 3, "period": "0.98 mm"} | transducer
    right |= {"center": "13 mm", "finger_pairs": 2, "period": "0.98 mm"}
    table["transducer"] = [right, left]
    return Scene.from_table("", table)


@pytest.fixture(scope="module")
def record():
    return network.run(chip(), band="2.1:2.3:5", z0="75", tolerance=2e-2)


def test_the_parameters_are_those_of_the_admittances_in_the_scenes_order(record):
    data = record.panel("magnitude").data
    assert data["ports"] == ["right", "left"]
    assert data["reference_ohm"] == 75.0
    assert data["frequency_Hz"] == pytest.approx(np.linspace(2.1e6, 2.3e6, 5), rel=1e-15)
    scene = resolved(chip())
    alone = fem.port_admittance(
        stator(scene.stator), transducers(scene), frequency=data["frequency_Hz"][2], tolerance=1e-3
    )
    assert alone.names == ("left", "right")
    expected = alone.scattering(75.0)[::-1, ::-1]
    assert abs(data["scattering"][2] - expected).max() < 2e-2
    assert abs(data["scattering"][2, 0, 0] - data["scattering"][2, 1, 1]) > 0.02
    assert all(finding.confirmed for finding in record.findings[:3])
    assert [finding.expected for finding in record.findings[3:]] == ["below 0.1"] * 2  # not: better than one branch


def test_a_closed_lossless_stator_has_a_unitary_matrix():
    """Nothing is lost between free ends: every singular value of S is 1, to rounding."""
    table = chip().to_table()
    table["stator"] |= {"mechanical_quality": 1e15, "dielectric_loss": 0, "ends": "free"}
    scene = resolved(Scene.from_table("", table))
    ports = stator_cascade(stator(scene.stator), transducers(scene), frequency=2.2e6, resolution=fem.LEVELS[0]).solved()
    unit = np.eye(2)
    s = np.linalg.solve(unit + 50 * ports.admittances, unit - 50 * ports.admittances)
    assert abs(np.linalg.svd(s, compute_uv=False) - 1).max() < 1e-12
    assert abs(s[0, 1] - s[1, 0]) < 1e-13


def test_a_layout_that_no_band_takes_is_solved_one_by_one():
    done = network.run(chip(pattern="+-0-+-"), band="2.19:2.21:2", tolerance=5e-2)
    assert done.panel("magnitude").data["scattering"].shape == (2, 2, 2)


def test_the_files_are_read_by_scikit_rf(record, tmp_path):
    files = network.tables(record)
    assert sorted(files) == ["circuit_left.cir", "circuit_right.cir", "network.s2p"]
    (tmp_path / "network.s2p").write_text(files["network.s2p"])
    read, data = skrf.Network(str(tmp_path / "network.s2p")), record.panel("magnitude").data
    assert np.array_equal(read.s, data["scattering"])
    assert np.array_equal(read.f, data["frequency_Hz"])
    assert ".subckt left_bvd p n" in files["circuit_left.cir"]


def test_the_delay_is_the_way_s_at_any_spacing_of_the_frequencies():
    """Between the transducers' middles 9 mm at 2182 m/s; at 200 kHz the phase turns by 0.8 from one to the next."""
    done = network.run(chip(), band="1.9:2.5:4", tolerance=5e-2)
    assert np.median(done.panel("group_delay").data["group_delay_s"]) == pytest.approx(9e-3 / 2182, rel=0.3)


def test_a_measurement_is_drawn_over_it(record, tmp_path):
    from matplotlib.figure import Figure

    file = tmp_path / "lab.s2p"
    file.write_text(network.tables(record)["network.s2p"])
    done = network.run(chip(), band="2.15 MHz:2250 kHz:3", z0=75, measured=str(file), tolerance=5e-2)
    data = done.panel("smith").data
    assert np.array_equal(data["measured_scattering"], record.panel("smith").data["scattering"])
    for name in ("smith", "magnitude", "group_delay", "circuit_left"):
        ax = network.figure(done, Figure().add_subplot(), panel=name)
        texts = [each.get_label() for each in ax.lines]
        assert any("lab.s2p" in text for text in texts) == (name in ("smith", "magnitude"))
    with pytest.raises(SceneError, match="--measured has the reference 75 ohm: give --z0 75, not 50"):
        network.run(chip(), band="2.1:2.3:3", measured=str(file))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"band": "2.1:2.3"}, "--band must be START:STOP:N"),
        ({"band": "2.3:2.1:5"}, "--band must rise"),
        ({"band": "2 mm:3 mm:5"}, "--band must be"),
        ({"z0": "0"}, "--z0 must be positive and finite"),
        ({"z0": "50 V"}, "--z0 .*an impedance"),
        ({"measured": "nothing.s2p", "band": "2.1:2.3:2"}, "--measured must be a Touchstone file"),
    ],
)
def test_impossible_options_are_refused(options, words):
    with pytest.raises(SceneError, match=words):
        network.run(chip(), tolerance=0.2, **options)


def test_other_studies_take_no_such_options(tmp_path):
    with pytest.raises(SceneError, match="--z0 is not taken by the study admittance"):
        run_study("admittance", None, tmp_path, options={"z0": "50"})


def test_the_command_hands_its_options_on(capsys):
    assert main(["study", "network", "twente", "--band", "2.3:2.1:5"]) == 2
    assert "--band must rise" in capsys.readouterr().err


def test_the_smith_chart_has_the_circles_of_its_resistances_and_reactances(record):
    """Resistance r: centre r/(1 + r), radius 1/(1 + r); reactance x: centre 1 + 1j/x, radius 1/|x| (Smith 1939)."""
    from matplotlib.figure import Figure

    lines = network.figure(record, Figure().add_subplot(), panel="smith").lines
    grid = [each.get_xdata() + 1j * each.get_ydata() for each in lines if each.get_label().startswith("_")]
    resistances, reactances = list(network.CIRCLES), [x for x in (*network.CIRCLES, *np.negative(network.CIRCLES)) if x]
    arcs = [each for each in grid if abs(each.imag[0] - each.imag[-1]) > 1e-2]
    assert len(arcs) == len(reactances)
    for r, circle in zip(resistances, grid, strict=False):
        np.testing.assert_allclose(abs(circle - r / (1 + r)), 1 / (1 + r), rtol=1e-12)
    for x, arc in zip(reactances, arcs, strict=True):
        np.testing.assert_allclose(abs(arc - 1 - 1j / x), 1 / abs(x), rtol=1e-9)
