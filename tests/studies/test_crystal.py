"""A cut made visible.  Oracles: the definitions of named cuts, symmetries of the rotated tensors, pixels."""

import json

import numpy as np
import pytest
from PIL import Image

from studies.__main__ import main
from studies.refusal import SceneError
from studies.report.free_surface import axes, axes_figure, half_space_answer, half_space_wave, save_axes, tables_text


def crystal(material, orientation):
    return half_space_wave(material, orientation=orientation, surface="open")


def test_named_cuts_stand_where_their_names_say():
    """128YX: X along x, the normal turned by 128 degrees from Y about X; YZ: Z along x, Y out of the surface."""
    turned = axes(crystal("LiNbO3 (Kovacs)", "128YX")["crystal"])
    assert turned["X"] == (1.0, 0.0, 0.0)
    assert turned["Y"][2] == pytest.approx(np.cos(np.radians(128)), rel=1e-12)
    assert turned["Z"][2] == pytest.approx(np.sin(np.radians(128)), rel=1e-12)
    plain = axes(crystal("LiNbO3 (Kovacs)", "YZ")["crystal"])
    assert plain["Z"] == (1.0, 0.0, 0.0)
    assert plain["Y"] == (0.0, 0.0, 1.0)
    frame = np.array([turned[name] for name in "XYZ"])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1.0, rel=1e-14)


def test_a_wrong_cut_has_other_tables():
    """The rotated tensors are those that the wave is computed with, and differ between mirror cuts 128 and -128."""
    import fem

    right, wrong = (crystal("LiNbO3 (Kovacs)", [0, theta, 0]) for theta in (38, -38))
    solid = fem.rotated(fem.material("LiNbO3 (Kovacs)"), [0, 38, 0])
    np.testing.assert_array_equal(right["crystal"]["stiffness_Pa"], solid.stiffness)
    np.testing.assert_array_equal(right["crystal"]["coupling_C_per_m2"], solid.coupling)
    assert right["crystal"]["density_kg_per_m3"] == solid.density
    relative = np.array(right["crystal"]["permittivity_relative"]) * 8.8541878128e-12
    np.testing.assert_allclose(relative, solid.permittivity, rtol=1e-9)
    assert tables_text(right["crystal"]) != tables_text(wrong["crystal"])
    trace = [np.trace(np.array(each["crystal"]["permittivity_relative"])) for each in (right, wrong)]
    assert trace[0] == pytest.approx(trace[1], rel=1e-12)


def test_the_text_shows_the_entries_of_a_poled_ceramic():
    """6mm about the normal: c11 = c22, c44 = c55, e31 = e32, e15 in the row of x; units and rounding noise."""
    answer = crystal("PZT-8", "Z")
    text = half_space_answer(answer)
    stiff = text.split("stiffness c (GPa), rotated")[1].splitlines()[2:8]
    rows = {line.split()[0]: line.split()[1:] for line in stiff}
    assert rows["11"][0] == rows["22"][1]
    assert rows["23"][3] == rows["13"][4]
    assert rows["11"][3:] == ["0", "0", "0"]
    coupling = [line.split() for line in text.split("coupling e (C/m^2), rotated")[1].splitlines()[2:5]]
    assert coupling[2][1] == coupling[2][2]
    assert coupling[0][1:5] == ["0"] * 4
    assert float(coupling[0][5]) == pytest.approx(answer["crystal"]["coupling_C_per_m2"][0][4], rel=1e-4)
    c11 = answer["crystal"]["stiffness_Pa"][0][0]
    assert float(rows["11"][0]) == pytest.approx(c11 / 1e9, rel=1e-4)
    assert "-0.00000" not in text


def test_what_lies_across_the_section_is_marked():
    from matplotlib.figure import Figure

    ax = axes_figure(crystal("LiNbO3 (Kovacs)", "128YX"), Figure().add_subplot())
    texts = [text.get_text() for text in ax.texts]
    assert "Y (0.79 into the page)" in texts
    assert "Z (0.62 into the page)" in texts
    assert "X" in texts


def test_the_picture_has_its_arrows(monkeypatch, tmp_path):
    monkeypatch.setattr("studies.record.plots.DPI", 150)
    save_axes(crystal("LiNbO3 (Kovacs)", "YZ"), tmp_path / "cut.png")
    pixels = np.asarray(Image.open(tmp_path / "cut.png").convert("RGB")).astype(int)
    height = pixels.shape[0]
    green = abs(pixels - [0, 158, 115]).max(axis=2) < 12  # Y, out of the surface
    orange = abs(pixels - [213, 94, 0]).max(axis=2) < 12  # Z, along x
    assert green.sum() > 300
    assert orange.sum() > 300
    assert np.flatnonzero(green.any(axis=1)).max() < 0.55 * height
    assert np.ptp(np.flatnonzero(orange.any(axis=0))) > 2 * np.ptp(np.flatnonzero(orange.any(axis=1)))


def test_the_command_prints_and_draws(monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert main(["wave", "PZT-8", "--plot", "cut.png"]) == 0
    assert "stiffness c (GPa), rotated" in capsys.readouterr().out
    assert (tmp_path / "cut.png").stat().st_size > 5000
    assert main(["wave", "PZT-8", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["crystal"]["axes_in_crystal"]["z"] == [0.0, 0.0, 1.0]
    assert len(answer["crystal"]["stiffness_Pa"]) == 6


def test_a_picture_that_cannot_be_is_refused(tmp_path):
    answer = crystal("PZT-8", "Z")
    with pytest.raises(SceneError, match=r"--plot must end in one of \.png"):
        save_axes(answer, tmp_path / "cut.xyz")
    with pytest.raises(SceneError, match="--plot cannot write"):
        save_axes(answer, tmp_path / "no" / "cut.png")
