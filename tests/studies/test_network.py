"""The network study: S-parameters and files of a small scene, its options and their refusals."""

import numpy as np
import pytest
import skrf

import fem
from fem.waveguide.port_fields import stator_cascade
from studies import Scene
from studies.__main__ import main
from studies.model.fem_objects import stator
from studies.model.model import Model
from studies.model.resolve import build, resolved
from studies.refusal import RunError, SceneError
from studies.scene import read_table
from studies.stator import network
from studies.study_list import run_study


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
        stator(scene.stator), Model(scene).transducers, frequency=data["frequency_Hz"][2], tolerance=1e-3
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
    ports = stator_cascade(
        stator(scene.stator), Model(scene).transducers, frequency=2.2e6, resolution=fem.LEVELS[0]
    ).solved()
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
    # of 5 frequencies from 2.1 to 2.3 MHz those within the band
    assert np.array_equal(data["measured_scattering"], record.panel("smith").data["scattering"][1:4])
    np.testing.assert_allclose(data["measured_frequency_Hz"], [2.15e6, 2.2e6, 2.25e6], rtol=1e-12)
    said = " ".join(text for _, text in done.answer)
    assert "3 of its 5 frequencies lie within --band" in said
    for name in ("smith", "magnitude", "group_delay", "circuit_left"):
        ax = network.figure(done, Figure().add_subplot(), panel=name)
        texts = [each.get_label() for each in ax.lines]
        assert any("lab.s2p" in text for text in texts) == (name in ("smith", "magnitude"))


def test_a_file_of_another_reference_is_converted_and_exchanged_ports_are_remarked(record, tmp_path):
    file, frequency = tmp_path / "lab.s2p", record.panel("smith").data["frequency_Hz"]
    scattering = record.panel("smith").data["scattering"]
    file.write_text(fem.touchstone(frequency, scattering[:, ::-1, ::-1], 75.0, ()))
    done = network.run(chip(), band="2.1:2.3:5", measured=str(file), tolerance=2e-2)
    theirs = skrf.Network(str(file))
    theirs.renormalize(50.0)
    np.testing.assert_allclose(done.panel("smith").data["measured_scattering"], theirs.s, rtol=1e-9)
    said = " ".join(text for _, text in done.answer)
    assert "its reference of 75 ohm is changed to 50 ohm" in said
    assert "are ports exchanged? With the file's ports as transducers 2, 1 the deviation is" in said


def single() -> Scene:
    """The left transducer alone."""
    table = chip().to_table()
    table["transducer"] = table["transducer"][1:]
    table["drive"] |= {"transducer": "left"}
    return Scene.from_table("", table)


def test_one_port_of_a_file_of_several_is_taken(tmp_path):
    at = np.array([2.15e6, 2.2e6, 2.25e6])
    alone = network.run(single(), band=at, tolerance=2e-2).panel("smith").data["scattering"][:, 0, 0]
    both = np.zeros((3, 2, 2), complex)
    both[:, 0, 0], both[:, 1, 1], both[:, 0, 1] = 0.7, alone, 0.01
    both[:, 1, 0] = both[:, 0, 1]
    file = tmp_path / "lab.s2p"
    file.write_text(fem.touchstone(at, both, 50.0, ()))
    with pytest.raises(
        SceneError, match=r"must be a file of 1 ports, and 'lab\.s2p' has 2: --port N takes one of them"
    ):
        network.run(single(), band=at, measured=str(file), tolerance=2e-2)
    done = network.run(single(), band=at, measured=str(file), port="2", tolerance=2e-2)
    lines = [text for _, text in done.answer]
    (deviation,) = [float(text.split("deviation of S ")[1].split()[0]) for text in lines if "deviation of S" in text]
    assert deviation < 1e-12
    assert "port 2 of 2 is taken, the others at 50 ohm" in " ".join(lines)
    # the table of an impedance analyser is of one port too
    z = 50.0 * (1 + alone) / (1 - alone)
    rows = [f"{f / 1e6!r};{each.real!r};{each.imag!r}" for f, each in zip(at.tolist(), z.tolist(), strict=True)]
    table = tmp_path / "lab.csv"
    table.write_text("\n".join(["f (MHz);R (Ohm);X (Ohm)", *rows]).replace(".", ","))
    done = network.run(single(), band=at, measured=str(table), tolerance=2e-2)
    assert float(dict(done.answer)["measured"].split("deviation of S ")[1].split()[0]) < 1e-12
    for port, words in ((3, "--port must be one of the 2 ports"), ("x", "--port must be a number of a port")):
        with pytest.raises(SceneError, match=words):
            network.run(single(), band=at, measured=str(file), port=port, tolerance=2e-2)
    with pytest.raises(SceneError, match="--port takes one port for one transducer, and the scene has 2"):
        network.run(chip(), band=at, measured=str(file), port=1, tolerance=2e-2)
    with pytest.raises(SceneError, match="--port is a port of a measured file"):
        network.run(single(), band=at, port=1, tolerance=2e-2)


def test_frequencies_without_an_answer_do_not_lose_the_others(monkeypatch, tmp_path):
    """A band of a range does not converge: its frequencies are left out of the curves, and said."""
    from studies.solve import spectrum

    solved = Model.port_admittance

    def failing(model, group, tolerance):
        if group[0] > 2.3e6:
            raise fem.ConvergenceError("the field does not converge")
        return solved(model, group, tolerance)

    monkeypatch.setattr(Model, "port_admittance", failing)
    at = np.array([2.1e6, 2.2e6, 2.4e6])
    monkeypatch.setattr(spectrum, "groups", lambda scene, frequencies: np.split(frequencies, len(frequencies)))
    file = tmp_path / "lab.s1p"
    file.write_text(fem.touchstone(at, np.full((3, 1, 1), 0.5), 50.0, ()))
    done = network.run(single(), band=at, measured=str(file), tolerance=2e-2)
    np.testing.assert_array_equal(done.panel("smith").data["frequency_Hz"], at[:2])
    said = dict(done.answer)
    assert "from 2.4 to 2.4 MHz the field does not converge" in said["no answer"]
    assert said["measured"].startswith("lab.s1p: 2 frequencies, 2.1 to 2.2 MHz")
    from studies.export.instruments import Recording, touchstone_files

    made = touchstone_files(single(), "chip", Recording(band="2.1:2.5:3"), tolerance=2e-2)
    assert [line.split()[0] for line in made.files["chip.s1p"].splitlines() if line[0] not in "!#"] == [
        "2100000.0",
        "2300000.0",
    ]
    assert "no answer from 2.5 to 2.5 MHz the field does not converge" in dict(made.answer)[""]
    with pytest.raises(RunError, match="the field does not converge"):
        spectrum.port_admittances(build(single()), at, 2e-2)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"band": "2.1:2.3"}, "--band must be START:STOP:N"),
        ({"band": "2.3:2.1:5"}, "--band must rise"),
        ({"band": "2 mm:3 mm:5"}, "--band must be"),
        ({"z0": "0"}, "--z0 must be positive and finite"),
        ({"z0": "50 V"}, "--z0 .*an impedance"),
        ({"measured": "nothing.s2p", "band": "2.1:2.3:2"}, "--measured must be a network analyser's file"),
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
