"""The beam of a finite aperture under the slider: one orbit through every door, the section where it is asked for."""

import numpy as np
import pytest

import contact
import fem
from studies import Scene, run, sweep
from studies.model import fem_objects
from studies.model.model import Model
from studies.model.wave_to_contact import contact_slider
from studies.solve.solved_stator import contact_of_run
from studies.solve.surface_motion import surface_motion
from studies.study_list import driven_contact

BALLS = [["-0.3 mm", "4 mm"], ["-0.2 mm", "-3 mm"], "0.3 mm"]
TOLERANCE = 1e-2


@pytest.fixture(scope="module")
def spread(small):
    """Three balls at their own places, the slider beside the axis."""
    return run(small.replace(slider={"position": ["9 mm", "1 mm"], "contacts": BALLS}), tolerance=TOLERANCE)


@pytest.fixture(scope="module")
def plane(small):
    return run(small.replace(stator={"diffraction": False}), tolerance=TOLERANCE)


def test_without_diffraction_the_answer_is_that_of_the_section(plane):
    """Property: bit-equal, whatever y says."""
    wave, scene = plane.surface_wave, plane.scene
    u_x, u_z = wave.motion(9e-3)
    assert plane.wave["normal_m_per_V"] == complex(u_z)
    assert plane.wave["relative_error"] == wave.relative_error
    slider, orbit = contact_slider(scene.slider), contact.Orbit(
        frequency=2.2e6, normal=complex(u_z), tangential=complex(u_x)
    )  # fmt: skip
    velocities = [contact.steady(slider, (orbit.scaled(v),), tolerance=TOLERANCE / 4).velocity for v in scene.levels]
    assert plane.velocity.tolist() == velocities
    assert "section_normal_m_per_V" not in plane.wave
    assert any("stator.diffraction is false" in each for each in plane.left_out)
    assert "finite aperture" in {each["effect"] for each in plane.model_error}
    beside = scene.replace(slider={"position": [9e-3, 5e-3]})
    assert run(beside, tolerance=TOLERANCE).velocity.tolist() == velocities


def test_each_ball_has_the_orbit_of_its_own_place(spread):
    beam = fem.surface_beam(spread.surface_wave)
    x, y = np.array([8.7e-3, 8.8e-3, 9.3e-3]), np.array([5e-3, -2e-3, 1e-3])
    assert np.allclose(spread.scene.slider.contact_positions, np.stack([x, y], axis=1), rtol=1e-12, atol=0.0)
    orbits = contact_of_run(spread).orbits
    u_x, u_y, u_z = beam.motion(x, y)
    assert np.allclose([each.normal for each in orbits], u_z, rtol=1e-6, atol=0.0)
    assert np.allclose([each.tangential for each in orbits], u_x, rtol=1e-6, atol=0.0)
    assert abs(spread.wave["normal_m_per_V"] / beam.motion(9e-3, 1e-3)[2] - 1) < 1e-6
    ratios = np.append(abs(u_y / u_x), abs(spread.wave["lateral_m_per_V"] / spread.wave["tangential_m_per_V"]))
    assert spread.wave["largest_lateral_ratio"] == pytest.approx(ratios.max(), rel=1e-5)
    assert spread.wave["section_normal_m_per_V"] == pytest.approx(spread.surface_wave.motion(9e-3)[1])
    assert spread.scene.stator.diffraction is True
    effects = {each["effect"] for each in spread.model_error}
    assert "finite aperture" not in effects
    assert "side faces" in effects


def test_the_mirror_image_of_a_slider_runs_as_fast(spread):
    """Property: y -> -y of position and balls; of the position alone it is another motor."""
    balls = [(-3e-4, -4e-3), (-2e-4, 3e-3), 3e-4]
    image = run(spread.scene.replace(slider={"position": (9e-3, -1e-3), "contacts": balls}), tolerance=TOLERANCE)
    assert np.allclose(image.velocity, spread.velocity, rtol=1e-6, atol=0.0)
    moved = run(spread.scene.replace(slider={"position": (9e-3, -1e-3)}), tolerance=TOLERANCE)
    assert not np.allclose(moved.velocity, spread.velocity, rtol=1e-3, atol=0.0)


def test_every_door_has_the_same_orbit(spread, small):
    """Run, sweep and the studies' driven contact."""
    given = small.replace(slider={"position": ["9 mm", "1 mm"], "contacts": BALLS})
    rows = sweep(
        given.replace(drive={"voltage": "120 V"}),
        {"slider.position": [["9 mm", "1 mm"], ["9 mm", "-2 mm"]]},
        tolerance=TOLERANCE,
    ).to_dataframe()
    assert rows["velocity_m_per_s"][0] == pytest.approx(spread.velocity[-1], rel=1e-3)
    assert rows["normal_amplitude_m"][0] == pytest.approx(spread.normal_amplitude[-1], rel=1e-3)
    assert abs(rows["velocity_m_per_s"][1] / rows["velocity_m_per_s"][0] - 1) > 1e-3
    driven = driven_contact(given, tolerance=TOLERANCE)
    orbits = contact_of_run(spread).orbits
    assert np.allclose([each.normal for each in driven.orbits], [each.normal for each in orbits], rtol=1e-3, atol=0.0)


def test_a_burst_moves_as_the_beam(small, small_run):
    """The ring-up is a factor on the beam's orbit: the amplitude of the points is the beam's."""
    beam = fem.surface_beam(small_run.surface_wave).motion(9e-3)
    assert small_run.normal_amplitude[-1] == pytest.approx(120 * abs(beam[2]), rel=1e-9)
    assert small_run.scene.stator.diffraction is True


def test_between_free_ends(small):
    """Absent, the section stands for the beam and the answer says why; asked for, the circuit is the section's."""
    free = small.replace(stator={"ends": "free"}, drive={"voltage": "120 V"})
    record = run(free, tolerance=0.05)
    assert any("between reflecting ends the beam takes" in each for each in record.left_out)
    assert record.scene.stator.diffraction is None
    spread = run(free.replace(stator={"diffraction": True}), tolerance=0.05)
    assert any("circuit is that of the plane section" in each for each in spread.left_out)
    assert spread.electrical["admittance_S"] == pytest.approx(record.electrical["admittance_S"], rel=0.02)
    assert abs(spread.normal_amplitude[0] / record.normal_amplitude[0] - 1) > 5e-3


def test_where_the_beam_is_not_known(small):
    """In a cut between free ends the section stands for it."""
    free = small.replace(
        stator={"ends": "free", "material": "LiNbO3 (Kovacs)", "orientation": "128YX"}, drive={"voltage": "5 V"}
    )
    refusal = fem.beam_refusal(fem_objects.stator(free.stator))
    assert fem_objects.section_reason(free.stator, fem_objects.stator(free.stator), [(0.0, 1e-3)]) == refusal


def test_lateral_motion_is_reported(small):
    record = run(
        small.replace(
            slider={"position": ["9 mm", "3.5 mm"]},
            transducer={"left": {"aperture": "4 mm"}},
            drive={"voltage": "20 V"},
        ),
        tolerance=0.05,
    )
    assert record.wave["largest_lateral_ratio"] > 0.1
    assert any("sideways" in each for each in record.warnings)


def test_the_error_is_that_of_a_finer_section_at_the_beam(small):
    """Honest: the beam of a much finer section differs by less than the stated error."""
    loose, fine = (run(small.replace(drive={"voltage": "20 V"}), tolerance=each) for each in (5e-2, 1e-4))
    difference = abs(loose.wave["normal_m_per_V"] - fine.wave["normal_m_per_V"])
    assert difference <= loose.wave["relative_error"] * abs(fine.wave["normal_m_per_V"])


def test_places_are_read_and_written(small):
    scene = small.replace(slider={"position": ["9 mm", "-1 mm"], "contacts": [["1 mm", "2 mm"], "-1 mm", [0, 0]]})
    assert scene.slider.center == (9e-3, -1e-3)
    assert scene.slider.offsets == ((1e-3, 2e-3), (-1e-3, 0.0), (0.0, 0.0))
    assert Scene.from_table("", scene.to_table()) == scene


def test_an_answer_that_is_known_is_the_same_in_another_company(spread):
    """Property: what was computed is returned again, place by place, in the order asked for."""
    places = [(9e-3, 0.0), (4e-3, 0.0), (8e-3, 2e-3)]
    motion = surface_motion(spread.surface_wave, spread.scene.stator, places)
    first = motion.at(places)
    assert np.all(np.isfinite(first))
    assert (motion.at(places[::-1]) == first[:, ::-1]).all()
    assert motion.relative_error(places) == max(motion.errors(places))
    assert abs(motion.at([(8e-3, -2e-3)])[2, 0] / first[2, 2] - 1) < 1e-6


def test_the_files_of_the_field_hold_the_beam(spread, tmp_path):
    """Read by meshio and numpy: the motion of the beam at places picked from the files."""
    import meshio

    spread.save(tmp_path / "run", field=True)
    table = np.genfromtxt(tmp_path / "run" / "surface_map.csv", delimiter=",", names=True)
    mesh = meshio.read(tmp_path / "run" / "surface_map.vtu")
    assert len(mesh.points) == len(table)
    for row in (len(table) // 3, 2 * len(table) // 3 + 7):
        x, y = table["x_m"][row], table["y_m"][row]
        expected = spread.surface_motion.beam.motion(x, y)
        real = mesh.point_data["displacement_m_per_V_real"][row]
        assert mesh.points[row] == pytest.approx((x, y, 0.0), abs=1e-12)
        for k, name in enumerate("xyz"):
            found = table[f"u_{name}_m_per_V_re"][row] + 1j * table[f"u_{name}_m_per_V_im"][row]
            assert abs(found - expected[k]) < 1e-3 * abs(expected).max()
            assert real[k] == pytest.approx(found.real, rel=1e-9, abs=1e-18)


def test_the_beam_is_drawn_from_above(spread, tmp_path):
    """The picture's numbers are the beam's, its points the balls; both files are written."""
    from matplotlib.figure import Figure

    from studies.__main__ import main
    from studies.report.beam_map import draw_surface_map, surface_map

    beam = spread.surface_motion.beam
    ax = draw_surface_map(beam, spread.scene, Figure().add_subplot())
    _, _, motion = surface_map(beam, spread.scene.stator)
    assert np.allclose(np.ravel(ax.collections[0].get_array()), abs(motion[2]).T.ravel() * 1e9, rtol=1e-12, atol=0.0)
    points = sorted(map(tuple, ax.lines[0].get_xydata() / 1e3))
    assert np.allclose(points, sorted(spread.scene.slider.contact_positions), rtol=1e-12, atol=0.0)
    spread.save(tmp_path / "run")
    files = tmp_path / "beam.png", tmp_path / "beam.html"
    wanted = ["--screenshot", str(files[0]), "--html", str(files[1])]
    assert main(["view", str(tmp_path / "run"), "--show", "beam", *wanted]) == 0
    assert all(each.stat().st_size > 10_000 for each in files)


def test_side_faces_that_reflect_make_the_beam_of_its_images(small):
    """Nine images of the aperture in both faces; the model error then says what faces that absorb would change."""
    given = small.replace(drive={"voltage": ["30 V"]})
    wide, mirrored = (run(given.replace(stator={"sides": each}), tolerance=1e-2) for each in ("absorbing", "mirror"))
    beam, width = wide.surface_motion.beam, given.stator.width
    images = sum(beam.motion(9e-3, k * width)[2] for k in range(-4, 5))
    assert abs(mirrored.surface_motion.at([(9e-3, 0.0)])[2, 0]) == pytest.approx(abs(images), rel=3e-3)
    sizes = [
        next(each["size"] for each in record.model_error if each["effect"] == "side faces")
        for record in (wide, mirrored)
    ]
    # of the charges that either run has
    assert (1 + sizes[0]) * (1 + sizes[1]) == pytest.approx(1.0, rel=2e-3)
    assert abs(sizes[0]) > 1e-2


def test_the_beam_is_the_default_in_any_cut_and_beside_the_axis():
    """The section does not know y: on 128YX it made the velocity of outer balls 2.4 times too large."""
    assert Model(Scene.load("lithium-niobate-128yx")).diffracts
    motor = Scene.load("twente-left").replace(stator={"ends": "free"})
    assert not Model(motor).diffracts
    assert Model(motor.replace(slider={"contacts": (("0 mm", "-3.5 mm"), ("0 mm", "3.5 mm"))})).diffracts
