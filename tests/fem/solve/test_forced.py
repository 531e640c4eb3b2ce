"""Line forces in a row: reciprocity with voltages, power, pieces that are not there, and the half-space's Gamma."""

from dataclasses import replace

import numpy as np
import pytest

from fem.analytic.half_space import rayleigh
from fem.analytic.wave_compliance import wave_compliance
from fem.circuit import Drive
from fem.discretize.element_sizes import Resolution
from fem.exceptions import InputError
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.section_mesh import read_mesh
from fem.results.field_evaluation import surface_of
from fem.results.power_balance import power_balance
from fem.results.stator_solution import driven_solution
from fem.solve.band_solution import frequency_band
from fem.solve.driven_stator import driven_wave
from fem.solve.forced_surface import forced_wave
from fem.waveguide.line_force import LineForce, force_response
from fem.waveguide.port_fields import stator_cascade
from tests.fem.drawings import rectangle
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate

LEVEL = Resolution(order=6, edge_layers=1)


def forces_at(stator, *places):
    """Forces in turn along z and x; places in wavelengths."""
    unit = stator.thickness / 0.8
    return tuple(
        LineForce(name=f"f{k}", position=place * unit, component="zx"[k % 2]) for k, place in enumerate(places)
    )


def fields_of(stator, forces, row=None):
    row = row or (comb(stator, "a", 2.0, finger_pairs=2), comb(stator, "b", 6.5, termination=200.0 - 80.0j))
    return stator_cascade(stator, row, frequency=FREQUENCY, resolution=LEVEL, forces=forces).solved()


ROWS = (
    (cut("PZT-8", "Z", quality=150.0), {"ends": "free", "bottom": "grounded"}),
    (cut("PZT-8", "Z", quality=150.0), {"ends": "clamped"}),
    (cut("PZT-8", "Z"), {}),
    (cut("LiNbO3 (Kovacs)", "128YX", quality=400.0), {"bottom": "absorbing"}),
)


@pytest.mark.parametrize(("solid", "rest"), ROWS)
def test_forces_and_voltages_answer_each_other(solid, rest):
    """The velocity at a place per volt is the current per newton; forces are reciprocal too.

    Both follow from different columns of the row: Y^T = Y for voltages, and Maxwell-Betti.
    """
    stator = plate(solid, length=9.0, **rest)
    forces = forces_at(stator, 0.2, 0.7, 4.2, 4.3, 8.6)
    fields = fields_of(stator, forces)
    width, ports = 0.02, len(fields.names)
    velocity = 2j * np.pi * FREQUENCY * fields.displacements[:, :ports] * width
    assert abs(velocity - fields.received.T).max() < 1e-9 * abs(velocity).max()
    among = fields.displacements[:, ports:]
    assert abs(among - among.T).max() < 1e-9 * abs(among).max()
    motion = surface_of(driven_solution(fields, "a")).motion(np.array([each.position for each in forces]))
    weights = driven_solution(fields, "a").weights
    moved = fields.displacements @ weights
    expected = np.array([motion["xz".index(each.component), k] for k, each in enumerate(forces)])
    assert abs(moved - expected).max() < 1e-10 * abs(expected).max()


@pytest.mark.parametrize("rest", [{"ends": "free", "bottom": "grounded"}, {"bottom": "absorbing"}])
def test_forces_meet_transducers_of_unequal_apertures(rest):
    """Each transducer moves the surface over its own aperture: int velocity dy per volt is the current per N/m.

    The mean potentials on a grounded section, by which no transducer has a net charge on any metre, reach as far along
    y as the voltage that causes them.
    """
    stator = plate(cut("LiNbO3 (Kovacs)", "128YX", quality=400.0), length=9.0, **rest)
    row = (comb(stator, "a", 2.0, finger_pairs=2), comb(stator, "b", 5.0, aperture=0.05))
    row = stator_cascade(
        stator, row, frequency=FREQUENCY, resolution=LEVEL, forces=forces_at(stator, 0.2, 0.7, 3.6, 8.6)
    )
    fields, raw = row.solved(), row.network.solve()
    potentials = np.array([own[-2:, :2] for own in fields.sides])  # (transducers, electrodes, ports)
    by_port = np.array([potentials[:, 0] - potentials[:, 1], potentials.mean(axis=1)])  # voltages, means
    by_port = np.swapaxes(by_port, 0, 1) * np.array([0.02, 0.05])  # last axis: of the port whose voltage it is
    expected = 2j * np.pi * FREQUENCY * raw.reactions[4:, :4] @ by_port.reshape(4, 2)
    assert abs(fields.received.T - expected).max() < 1e-9 * abs(expected).max()
    means = abs(raw.reactions[4:, 1:4:2] @ by_port[:, 1]).max()  # what the means add
    assert means > 1e-3 * abs(raw.reactions[4:, :4] @ by_port.reshape(4, 2)).max()


@pytest.mark.parametrize(("solid", "rest"), ROWS)
def test_the_power_of_forces_balances(solid, rest):
    stator = plate(solid, length=9.0, **rest)
    fields = fields_of(stator, forces_at(stator, 0.3, 4.2, 8.6))
    solved = driven_solution(fields, "a", np.array([1.0, 0.4j, -0.7]))
    balance = power_balance(solved)
    assert balance.loads == pytest.approx(0.5 * 200.0 * abs(solved.circuit.currents[1]) ** 2, rel=1e-9)
    assert balance.residual < 1e-9
    assert balance.input > 0
    assert balance.input == pytest.approx(balance.solid + balance.loads + balance.radiated, rel=1e-9)


def test_a_bare_stator_answers_as_a_segment_without_end():
    """Absorbing ends and no pieces: the motion is that of the plain segment, on both sides of each of two forces."""
    stator = plate(cut("PZT-8", "Z"), length=6.0)
    forces = forces_at(stator, 2.0, 3.1)
    fields = stator_cascade(stator, (), frequency=FREQUENCY, resolution=LEVEL, forces=forces).solved()
    x = np.linspace(0.1, 5.9, 40) * stator.thickness / 0.8
    for k, each in enumerate(forces):
        found = surface_of(driven_solution(fields, None, np.eye(2)[k])).motion(x)
        exact = np.array([force_response(fields.modes, each.component).motion(at - each.position) for at in x])
        assert abs(found - exact.T).max() < 1e-11 * abs(exact).max()


def test_a_plain_mesh_beside_a_force_changes_nothing(tmp_path):
    """The force's near field passes a meshed plain stretch as it passes the segment."""
    stator = plate(cut("PZT-4", "Z", quality=300.0), length=9.0)
    unit = stator.thickness / 0.8
    mesh = read_mesh(rectangle(tmp_path / "plain.msh", 0.7, 0.8, size=0.35), unit)
    meshed = replace(stator, pieces=(MeshPiece(name="p", mesh=mesh, position=3.5 * unit),))
    force = forces_at(stator, 3.3)
    row = (comb(stator, "a", 7.0),)
    x = np.array([0.2, 1.9, 3.2, 3.4, 4.5, 5.0, 8.7]) * unit
    level = Resolution(order=8, edge_layers=2)
    motions = []
    for each in (stator, meshed):
        fields = stator_cascade(each, row, frequency=FREQUENCY, resolution=level, forces=force).solved()
        solved = driven_solution(fields, None, np.ones(1))
        motions.append(surface_of(solved).motion(x))
        assert power_balance(solved).residual < 1e-9
    assert abs(motions[1] - motions[0]).max() < 1e-6 * abs(motions[0]).max()


def test_the_surface_wave_between_reflecting_transducers_is_gamma():
    """Behind absorbing ends, far away: |u_z| = Gamma F; with an open transducer beside the force it is not."""
    solid = lossless("PZT-8", "Z")
    stator = replace(plate(solid, length=30.0), thickness=np.inf)
    unit = plate(solid).thickness / 0.8
    force = LineForce(name="f", position=10.0 * unit, component="z")
    given = {"frequency": FREQUENCY, "tolerance": 1e-3, "places": (25.0 * unit,)}
    alone = forced_wave(stator, (), (force,), **given)
    expected = wave_compliance(solid, "open")
    assert abs(alone.rayleigh_motion(25.0 * unit)[1]) == pytest.approx(expected, rel=1e-4, abs=0)
    row = (comb(stator, "t", 5.0, finger_pairs=4, period=2.0, termination="open"),)
    beside = forced_wave(stator, row, (replace(force, amplitude=2.0),), **given)
    assert abs(abs(beside.rayleigh_motion(25.0 * unit)[1]) / expected / 2 - 1) > 1e-3


def test_forces_act_together_with_their_amplitudes_and_phases():
    """The half-space's wave of F_z and F_x at one place: U_z = -i Gamma (F_z + F_x conj(U_x/U_z)), by reciprocity."""
    solid = lossless("PZT-8", "Z")
    stator = replace(plate(solid, length=30.0), thickness=np.inf)
    unit = plate(solid).thickness / 0.8
    normal, tangential = 2.0 - 1.0j, 3.0j
    forces = tuple(
        LineForce(name=component, position=10.0 * unit, component=component, amplitude=amplitude)
        for component, amplitude in (("z", normal), ("x", tangential))
    )
    place = 25.0 * unit
    wave = forced_wave(stator, (), forces, frequency=FREQUENCY, tolerance=1e-3, places=(place,))
    half_space = rayleigh(solid, "open")
    motion = wave.rayleigh_motion(place)
    ratio = motion[0] / motion[1]
    assert abs(ratio) == pytest.approx(half_space.surface_ratio, rel=1e-4)
    travelled = np.exp(-2j * np.pi * FREQUENCY / half_space.velocity * 15.0 * unit)
    expected = -1j * wave_compliance(solid, "open") * (normal + tangential * np.conj(ratio)) * travelled
    assert motion[1] == pytest.approx(expected, rel=1e-2, abs=0)
    assert abs(motion[1]) == pytest.approx(abs(expected), rel=1e-4, abs=0)


def test_the_current_per_newton_is_the_velocity_per_volt():
    """Reciprocity of two public answers: of a force into a shorted transducer, and of a volt at the force's place."""
    stator = plate(cut("PZT-8", "Z", quality=150.0), length=9.0)
    row = (comb(stator, "a", 2.0, finger_pairs=2, termination="short"),)
    place = 5.3 * stator.thickness / 0.8
    given = {"frequency": FREQUENCY, "tolerance": 1e-4, "places": (place * 1.2,)}
    force = LineForce(name="f", position=place, component="z", amplitude=3.0 - 4.0j)
    received = forced_wave(stator, row, (force,), **given).circuit.currents[0]
    velocity = (
        2j * np.pi * FREQUENCY * driven_wave(stator, row, drive="a", **given | {"places": (place,)}).motion(place)[1]
    )
    assert received == pytest.approx(velocity * force.amplitude * row[0].aperture, rel=1e-3)


@pytest.mark.parametrize("component", ["x", "z"])
def test_a_band_receives_as_it_sends(component):
    """Current per newton against velocity per volt, through one reduced model: reciprocity to its projection."""
    stator = plate(cut("PZT-8", "Z", quality=150.0), length=9.0)
    row = (
        comb(stator, "a", 2.0, finger_pairs=2, termination="short"),
        comb(stator, "b", 7.3, finger_pairs=2, termination=50.0),
    )
    place = 4.6 * stator.thickness / 0.8
    drive = Drive(sources={"a": 1.0}, impedance=20.0)
    given = {"lowest": 0.98 * FREQUENCY, "highest": 1.02 * FREQUENCY, "tolerance": 1e-2, "places": (place,)}
    band = frequency_band(stator, row, drive=drive, **given)
    at = np.array([0.985, 1.0, 1.017]) * FREQUENCY
    circuits = band.forced(at, LineForce(name="f", position=place, component=component), drive)
    received = [each.currents[0] for each in circuits]
    motion = np.array([each.motion(place)["xz".index(component)] for each in band.waves(at, drive)])
    velocity = 2j * np.pi * at * motion
    assert received == pytest.approx(velocity * row[0].aperture, rel=1e-6)


def test_a_force_under_a_transducer_is_refused():
    stator = plate(cut("PZT-8", "Z"), length=9.0)
    with pytest.raises(InputError, match=r"force 'f0'.position must lie on the bare surface"):
        fields_of(stator, forces_at(stator, 2.0))
    with pytest.raises(InputError, match='component must be "x" or "z"'):
        LineForce(name="f", position=0.0, component="y")
    with pytest.raises(InputError, match=r"force 'f'.amplitude must be a finite number, real or complex, got inf N/m"):
        LineForce(name="f", position=0.0, amplitude=np.inf)
    silent = LineForce(name="f", position=0.0, amplitude=0.0)
    with pytest.raises(InputError, match=r"force.amplitude must differ from zero for one force at least, got 0"):
        forced_wave(stator, (), (silent,), frequency=FREQUENCY, tolerance=1e-2, places=(1e-3,))
