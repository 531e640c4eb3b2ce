"""What the driven stator refuses: sizes that take too long, and frequencies at which its algebra is singular."""

import numpy as np
import pytest

from fem.condense.joined_fingers import joined
from fem.condense.transducer import Condensation, FingerShape, half_cells
from fem.discretize.element_sizes import Resolution
from fem.exceptions import ConvergenceError
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, section, solution, wave_of

PZT = cut("PZT-8", "Z")


def clamped_piece(frequency: float):
    """Middle line of a finger's cell, sides clamped, of a lossless plate: its matrix, and the cell's halves."""
    depth = section(plate(lossless("PZT-8", "Z")), order=5)
    shape = FingerShape(half_finger=0.13, half_gaps=(0.13, 0.13))
    rising, falling = half_cells(Condensation(depth, frequency), shape, Resolution(order=5, edge_layers=0))
    n, phi = depth.size, depth.surface_dofs["phi"]
    keep = np.setdiff1d(np.arange(n), [phi])
    middle = rising.matrix[n : 2 * n, n : 2 * n] + falling.matrix[:n, :n]
    return middle[np.ix_(keep, keep)], (rising, falling, phi)


def resonance() -> float:
    """Frequency in Hz at which the piece resonates, by bisection on its negative eigenvalues."""

    def negatives(frequency):
        return int(np.sum(np.linalg.eigvalsh(clamped_piece(frequency)[0]) < 0))

    low, high = 0.6 * FREQUENCY, 1.6 * FREQUENCY
    fewer = negatives(low)
    assert negatives(high) > fewer
    for _ in range(55):
        middle = (low + high) / 2
        low, high = (middle, high) if negatives(middle) == fewer else (low, middle)
    return (low + high) / 2


def test_a_piece_that_resonates_between_clamped_lines_is_refused_there_and_only_there():
    at = resonance()
    rising, falling, phi = clamped_piece(at)[1]
    with pytest.raises(ConvergenceError, match="resonates at this very frequency"):
        joined(rising, falling, phi=phi, electrode=0)
    rising, falling, phi = clamped_piece(at * (1 + 1e-6))[1]
    assert np.all(np.isfinite(joined(rising, falling, phi=phi, electrode=0).matrix))


def cut_off() -> float:
    """First frequency in Hz above that of the stators at which a mode of the lossless plate has no wavenumber."""
    from scipy.linalg import eigvals

    at = 1.3 * FREQUENCY
    for _ in range(20):  # the elements follow the wavelength
        depth = section(plate(lossless("PZT-8", "Z")), order=5, frequency=at)
        low, high = (depth.matrices(factor * FREQUENCY)[2] for factor in (1, 2))
        squares = eigvals((4 * low - high) / 3, (low - high) / 3)
        squares = squares[np.isfinite(squares)]
        real = squares.real[(abs(squares.imag) < 1e-9 * abs(squares)) & (squares.real > 1.2)]
        at = float(FREQUENCY * np.sqrt(real.min()))
    return at


def test_a_cut_off_of_the_lossless_plate_is_refused_there_and_only_there():
    at = cut_off()
    stator = plate(lossless("PZT-8", "Z"))
    fingers = (comb(stator, "a", 2.0),)
    with pytest.raises(ConvergenceError, match="cut-off"):
        solution(stator, fingers, frequency=at)
    solution(stator, fingers, frequency=at * (1 + 1e-4))


def test_a_section_of_ten_minutes_is_refused_with_its_time():
    stator = plate(PZT, thickness=300.0)
    with pytest.raises(ConvergenceError, match=r"300 wavelengths.*6\.3e\+03 unknowns.*3\.1e\+02 minutes"):
        section(stator, order=5)
    deep, less = (plate(PZT, thickness=depth, bottom="absorbing") for depth in (300.0, 8.0))
    assert section(deep, order=5).size == section(less, order=5).size


def test_more_fingers_than_can_be_walked_through_are_refused():
    stator = plate(PZT, length=1e5)
    with pytest.raises(ConvergenceError, match="150002 fingers"):
        solution(stator, (comb(stator, "a", 5e4, finger_pairs=75001),))


def test_a_very_long_surface_is_sampled_less_often_and_as_truly():
    stator = plate(PZT, length=2e4)
    wave = wave_of(solution(stator, (comb(stator, "a", 2.0),)))
    x, motion = wave.samples()
    assert 50_000 < len(x) < 51_000
    place = int(np.argmax(abs(motion[1])))
    assert motion[:, place] == pytest.approx(wave.motion(x[place]), rel=1e-12, abs=0)
