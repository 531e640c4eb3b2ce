"""Every column of every file and of a sweep: its quantity, its unit and its sign.

Truth: the results of ``fem`` and ``contact`` themselves, asked once more; relations between columns (power and
conductance, n balls and one); the sense in which a Rayleigh wave turns.
"""

import csv
import math

import numpy as np
import pytest

import contact
import fem
from studies import Scene, sweep
from studies.model.balls import prescribed_orbits
from studies.model.wave_to_contact import contact_slider
from studies.record.files import write_run
from studies.solve.solved_stator import SolvedStator, contact_of_run
from studies.solve.surface_motion import SurfaceMotion


def columns(path):
    """Return the columns of a table, numbers where they are."""
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    return {name: [_number(row[k]) for row in rows] for k, name in enumerate(head)}


def _number(text):
    try:
        return float(text)
    except ValueError:
        return text


@pytest.fixture(scope="module")
def files(small_run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    write_run(small_run, folder, field=False)
    return {path.stem: columns(path) for path in folder.glob("*.csv")}


def test_the_table_of_velocities_has_every_value_of_every_point(files, small_run):
    table = files["velocity"]
    assert set(table) == {key for point in small_run.points for key in point}
    for index, point in enumerate(small_run.points):
        for key, column in table.items():
            wanted = point.get(key, "")
            assert column[index] == (str(wanted) if isinstance(wanted, bool) else wanted), key


def test_the_points_have_the_amplitudes_of_the_wave_and_the_velocities_of_the_contact(small_run, small):
    u_x, _, u_z = fem.surface_beam(small_run.surface_wave).motion(small.slider.position)
    tangential, normal = abs(complex(u_x)), abs(complex(u_z))
    slider = contact_slider(small_run.scene.slider)
    for point in small_run.points:
        volt = point["voltage_V"]
        assert point["normal_amplitude_m"] == pytest.approx(normal * volt, rel=1e-12)
        assert point["tangential_amplitude_m"] == pytest.approx(tangential * volt, rel=1e-12)
        orbit = contact.Orbit(frequency=2.2e6, tangential=complex(u_x) * volt, normal=complex(u_z) * volt)
        state = contact.steady(slider, orbit, tolerance=1e-6)
        assert point["velocity_m_per_s"] == pytest.approx(state.velocity, rel=1e-2)
        assert point["regime"] == state.regime


def test_the_table_of_the_surface_is_the_motion_of_the_wave(files, small_run):
    table = {name: np.array(values) for name, values in files["surface"].items()}
    assert set(table) == {"x_m"} | {f"u_{k}_m_per_V_{part}" for k in "xz" for part in ("re", "im")}
    x = table["x_m"]
    assert (x.min(), x.max()) == pytest.approx((0.0, 14e-3), abs=1e-4)
    beside = (x > 7e-3) & (x < 12e-3)  # not under the transducer
    assert beside.sum() > 20
    for name, wanted in zip("xz", small_run.surface_wave.motion(x[beside]), strict=True):
        column = table[f"u_{name}_m_per_V_re"] + 1j * table[f"u_{name}_m_per_V_im"]
        np.testing.assert_allclose(column[beside], wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())


def test_the_table_of_trajectories_is_in_metres_and_seconds(files, small_run):
    table = {name: np.array(values) for name, values in files["trajectory"].items()}
    assert list(table) == ["voltage_V", "time_s", "velocity_m_per_s", "normal_position_m"]
    for (level, motion), point in zip(small_run.trajectories, small_run.points, strict=True):
        at = table["voltage_V"] == level
        assert at.sum() == len(motion.time)
        np.testing.assert_array_equal(table["time_s"][at], motion.time)
        np.testing.assert_array_equal(table["velocity_m_per_s"][at], motion.velocity)
        np.testing.assert_array_equal(table["normal_position_m"][at], motion.position)
        end = np.argmin(abs(table["time_s"][at] - 5e-5))  # of the burst
        speed = table["velocity_m_per_s"][at][end]
        assert speed == pytest.approx(point["velocity_at_burst_end_m_per_s"], rel=0.05)
        slider = small_run.scene.slider
        # Hertz (Johnson 1985, eq. 4.23): the rest approach of a ball under the preload
        modulus = slider.effective_modulus * math.sqrt(slider.radius)
        rest = (3 * slider.preload / (4 * modulus)) ** (2 / 3)
        assert table["normal_position_m"][at][0] == pytest.approx(-rest, rel=1e-6)


@pytest.fixture(scope="module")
def rows(small):
    over = {"slider.position": [9e-3, 10.2e-3]}
    return sweep(small, over, also=("limits", "thrust", "efficiency"), tolerance=1e-2).columns()


def test_the_columns_of_a_sweep_are_those_of_a_run(rows, small_run):
    wave, electrical, summary = small_run.wave, small_run.electrical, small_run.summary
    known = {"point", "slider.position", "drive.voltage"}
    admittance = electrical["admittance_S"]
    for row, point in enumerate(small_run.points):
        volt = point["voltage_V"]
        assert rows["drive.voltage"][row] == volt
        wanted = {
            "normal_amplitude_m": abs(wave["normal_m_per_V"]) * volt,
            "tangential_amplitude_m": abs(wave["tangential_m_per_V"]) * volt,
            "frequency_Hz": 2.2e6,
            "conductance_S": admittance.real,
            "susceptance_S": admittance.imag,
            "power_W": electrical["power_W_per_V2"] * volt**2,
            "velocity_m_per_s": point["velocity_m_per_s"],
            "threshold_factor": summary["threshold_voltage_V"] / volt,
            "release_factor": summary["release_voltage_V"] / volt,
        }
        for name, value in wanted.items():
            assert rows[name][row] == pytest.approx(value, rel=1e-2), name
        assert rows["regime"][row] == point["regime"]
        assert rows["status"][row] == "ok"
        assert rows["relative_error"][row] < 1e-2
        known |= wanted.keys() | {"regime", "status", "relative_error"}
    assert set(rows) - known == {"thrust_N", "contact_efficiency", "motor_efficiency"}


def test_thrust_and_efficiency_of_a_sweep_are_the_contact_s(rows, small_run):
    """Thrust: the load that stops the slider.  Efficiency at half of it: load times speed over the power."""
    slider = contact_slider(small_run.scene.slider)
    for row, point in enumerate(small_run.points):
        u_x, u_z = (complex(small_run.wave[f"{side}_m_per_V"]) for side in ("tangential", "normal"))
        orbit = contact.Orbit(frequency=2.2e6, tangential=u_x, normal=u_z).scaled(point["voltage_V"])
        thrust = contact.blocked_thrust(slider, (orbit,))[0]
        assert rows["thrust_N"][row] == pytest.approx(thrust, rel=2e-2)
        assert 0 < rows["motor_efficiency"][row] < rows["contact_efficiency"][row] < 1


def test_three_balls_push_three_times_as_hard_as_one_with_a_third_of_everything():
    whole = {"mass": 2.67e-4, "preload": 2.6e-3, "load": 0.0, "contacts": 3}
    dampers = {"normal": 1.5, "tangential": 3e-4}
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": [6e-9]})
    three = scene.replace(slider=whole | {"damping": dampers})
    third = {key: value / 3 for key, value in whole.items() if key != "contacts"} | {"contacts": 1}
    one = scene.replace(slider=third | {"damping": {key: value / 3 for key, value in dampers.items()}})
    found = [sweep(each, {}, also=("thrust",)).columns() for each in (three, one)]
    assert found[0]["velocity_m_per_s"] == pytest.approx(found[1]["velocity_m_per_s"], rel=1e-6)
    assert found[0]["thrust_N"][0] == pytest.approx(3 * found[1]["thrust_N"][0], rel=1e-3)


def test_the_orbit_under_the_ball_is_the_motion_of_the_wave(small_run):
    """Both components with their phases: a quarter of a period between them is the difference between + and -."""
    wave, slider = small_run.surface_wave, small_run.scene.slider
    (orbit,) = SolvedStator.of(SurfaceMotion(wave=wave), slider.contact_positions).orbits(slider.contact_positions)
    u_x, u_z = wave.motion(slider.position)
    assert orbit.tangential == pytest.approx(complex(u_x), rel=1e-12)
    assert orbit.normal == pytest.approx(complex(u_z), rel=1e-12)
    assert orbit.frequency == 2.2e6


def velocity_at_the_crest(orbit):
    """Return the surface's velocity along x when u_z is at its largest: Re(i omega u_x exp(-i arg u_z)), m/s."""
    crest = orbit.normal.conjugate() / abs(orbit.normal)
    return (2j * math.pi * orbit.frequency * orbit.tangential * crest).real


def test_the_crest_of_a_rayleigh_wave_moves_against_it(small_run):
    """Retrograde (Rayleigh 1885): the wave runs to +x, its crest moves to -x and takes the slider with it."""
    (orbit,) = contact_of_run(small_run).orbits
    speed = 2 * math.pi * orbit.frequency * abs(orbit.tangential)
    assert velocity_at_the_crest(orbit) < -0.8 * speed
    assert all(point["velocity_m_per_s"] < 0 for point in small_run.points)


def test_the_crest_of_a_given_wave_moves_to_plus_x():
    wave = Scene.load("twente-contact").wave
    (orbit,) = prescribed_orbits(wave)
    speed = 2 * math.pi * wave.frequency * wave.tangential_ratio
    assert velocity_at_the_crest(orbit) == pytest.approx(speed, rel=1e-12)
