"""A row whose pieces have no fingers: plain columns between transducers are not seen, in any of the results."""

from dataclasses import replace

import numpy as np
import pytest

from fem.beam.beam_of_section import aperture_beam
from fem.condense.finger_columns import condensed
from fem.condense.joined_fingers import repeated, with_ports
from fem.condense.transducer import Condensation, transducer_superelements
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.materials.christoffel import slowest_wavelength
from fem.results.field_evaluation import surface_of
from fem.results.interior_field import wave_field
from fem.results.power_balance import power_balance
from fem.results.stator_solution import driven_solution
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.port_fields import joined_cascade
from fem.waveguide.stator_meshes import CondensedPieces
from tests.fem.stators import FREQUENCY, comb, cut, plate, wave_of

LEVEL = Resolution(order=8, edge_layers=1)


def solutions(stator, row, place, columns):
    """A driven stator without and with a piece of bare columns of 0.1 wavelengths at a place, length units."""
    unit = slowest_wavelength(stator.solid, FREQUENCY)
    scale = min(each.finger_width / 2 for each in row)
    section = discretise(stator, LEVEL, wavelength=unit, surface_scale=scale)
    modes = guided_modes(section, FREQUENCY)
    transducers = transducer_superelements(Condensation(section, FREQUENCY), stator, row, LEVEL)
    bare = repeated(condensed(section, FREQUENCY, width=0.1, electrode=None), columns)
    piece = replace(with_ports(bare, []), floating_potential=section.floating_potential)
    for between in ((), ((place, piece),)):
        pieces = CondensedPieces(between=between, ends=(stator.ends,) * 2, start=0.0, stop=stator.length / unit)
        fields = joined_cascade(stator, row, transducers, modes=modes, resolution=LEVEL, pieces=pieces).solved()
        yield driven_solution(fields, "a")


@pytest.mark.parametrize("rest", [{}, {"bottom": "grounded", "ends": "free"}], ids=["floating", "grounded"])
def test_a_piece_without_fingers_is_a_part_of_the_row(rest):
    """Motion, admittance, power, interior and beam are those of the row without it."""
    stator = plate(cut("PZT-8", "Z", quality=200.0), length=9.0, **rest)
    unit = stator.thickness / 0.8
    row = comb(stator, "a", 2.0, finger_pairs=2), comb(stator, "b", 7.0, termination=50.0)
    plain, pieced = solutions(stator, row, 4.1, 7)
    assert pieced.fields.owners == (0, None, 1)
    assert pieced.circuit.admittance == pytest.approx(plain.circuit.admittance, rel=1e-8)
    x = np.linspace(0.1, 8.9, 60) * unit
    one, other = (surface_of(each).motion(x) for each in (plain, pieced))
    assert abs(other - one).max() < 1e-6 * abs(one).max()
    assert surface_of(pieced).covered(4.5 * unit)
    ours, theirs = power_balance(pieced), power_balance(plain)
    assert ours.residual < 1e-9
    assert (ours.solid, ours.loads) == pytest.approx((theirs.solid, theirs.loads), rel=1e-6)
    span = 4.0 * unit, 5.0 * unit
    inside = wave_field(wave_of(pieced), span=span, energies=True)
    exact = wave_field(wave_of(plain), span=span, places=tuple(inside.x), energies=True)
    same = [int(np.argmin(abs(exact.x - at))) for at in inside.x]
    for mine, true in (
        (inside.displacement, exact.displacement[same]),
        (inside.potential, exact.potential[same]),
        (inside.densities.power_flow, exact.densities.power_flow[same]),
    ):
        assert abs(mine - true).max() < 1e-4 * abs(true).max()
    if stator.ends == "absorbing":
        beams = [aperture_beam(wave_of(each), each).motion(5.5 * unit, 1e-3) for each in (plain, pieced)]
        assert abs(beams[1] - beams[0]).max() < 1e-6 * abs(beams[0]).max()
