"""Surface motion: continuous along the stator, split into modes, and named by its direction."""

from dataclasses import replace

import numpy as np
import pytest

from fem.exceptions import ConvergenceError
from fem.results.field_evaluation import recovered
from fem.results.surface import CondensedPiece, UniformSegment, standing_wave_ratio
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, solution, wave_of

CASES = (
    (cut("PZT-8", "Z"), {"ends": "free"}),
    (cut("PZT-5H", "X"), {"ends": "clamped", "bottom": "grounded"}),
    (lossless("LiNbO3 (Warner)", "YZ"), {"ends": "absorbing"}),
    (cut("LiNbO3 (Ogi)", (17.0, 31.0, 49.0)), {"ends": "free"}),
)


@pytest.fixture(scope="module", params=CASES, ids=[f"{solid.name} {solid.frame}" for solid, _ in CASES])
def wave(request):
    solid, rest = request.param
    stator = plate(solid, length=8.0, **rest)
    pair = comb(stator, "a", 1.7, finger_pairs=2), comb(stator, "b", 6.1, period=0.9)
    return wave_of(solution(stator, pair, order=6, layers=1))


def test_pieces_tile_the_stator(wave):
    kinds = [type(piece) for piece in wave.pieces]
    assert kinds == [UniformSegment, CondensedPiece, UniformSegment, CondensedPiece, UniformSegment]
    for before, after in zip(wave.pieces[:-1], wave.pieces[1:], strict=False):
        assert before.stop == pytest.approx(after.start, rel=1e-12)
    assert (wave.pieces[0].start, wave.pieces[-1].stop) == pytest.approx((0, wave.length))


def test_motion_is_continuous(wave):
    """From modes on one side of a border and from columns on the other; within the columns too."""
    size = np.abs(wave.samples()[1]).max()
    for before, after in zip(wave.pieces[:-1], wave.pieces[1:], strict=False):
        at = np.array([after.start])
        assert np.abs(before.motion(at) - after.motion(at)).max() < 1e-7 * size
    for index in range(len(wave.pieces) // 2):
        _, values = recovered(wave.solution, index).surface_nodes
        assert np.abs(values[:-1, -1] - values[1:, 0]).max() < 1e-10 * size


def test_places(wave):
    x, motion = wave.samples()
    assert np.all(np.diff(x) > 0)
    assert (x[0], x[-1]) == (0, wave.length)
    assert np.array_equal(wave.motion(x), motion)
    grid = x[:12].reshape(3, 4)
    assert np.array_equal(wave.motion(grid).reshape(2, 12), motion[:, :12])
    assert wave.normal_at(x[5]) == pytest.approx(motion[1, 5], rel=1e-12)
    assert wave.covered(wave.pieces[1].start + 1e-6)
    assert not wave.covered(wave.pieces[2].start + 1e-6)
    with pytest.raises(ValueError, match="x must lie on the stator, 0 to"):
        wave.motion(1.001 * wave.length)
    with pytest.raises(ValueError, match="x must lie on the stator"):
        wave.motion(np.nan)


def test_rayleigh_part(wave):
    """A sum of two waves of one wavenumber: it solves u'' = -k^2 u; under a transducer it is refused."""
    stretch = wave.pieces[2]
    middle, step = 0.5 * (stretch.start + stretch.stop), 1e-3 * wave.phase_velocity / FREQUENCY
    part = wave.rayleigh_motion(middle + step * np.arange(-1, 2))
    k = stretch.wavenumbers[stretch.rayleigh]
    if len(k) == 1:
        bend = part[:, 0] - 2 * part[:, 1] + part[:, 2]
        assert bend == pytest.approx(2 * (np.cos(k[0] * step) - 1) * part[:, 1], rel=1e-6, abs=0)
    every = stretch.motion(np.array([middle]), only=np.arange(len(stretch.wavenumbers)))
    assert every == pytest.approx(wave.motion(np.array([middle])), rel=1e-12)
    with pytest.raises(ValueError, match="lies under a transducer"):
        wave.rayleigh_motion(wave.pieces[1].start + 1e-6)


def test_wave_runs_away_from_its_transducer():
    """Retrograde far to the right and to the left: u_x = +i r u_z where it runs to +x, -i r where to -x; no echo."""
    stator = plate(lossless("PZT-8", "Z"), length=20.0, thickness=4.0)
    wave = wave_of(solution(stator, (comb(stator, "a", 10.0, finger_pairs=4),), order=6, layers=1))
    right, left = (wave.rayleigh_motion(share * wave.length) for share in (0.9, 0.1))
    assert np.imag(right[0] / right[1]) == pytest.approx(wave.surface_ratio, rel=1e-3)
    assert np.imag(left[0] / left[1]) == pytest.approx(-wave.surface_ratio, rel=1e-3)
    only = [index for index in range(len(wave.pieces[-1].left)) if abs(wave.pieces[-1].left[index]) > 0]
    assert only == []


def test_standing_wave_ratio():
    """One wave alone: 1 but for the plate's other modes; free ends: a standing wave."""
    solid = cut("PZT-8", "Z", quality=200.0)
    ratios = {}
    for ends in ("absorbing", "free"):
        stator = plate(solid, length=30.0, thickness=1.0, ends=ends)
        wave = wave_of(solution(stator, (comb(stator, "a", 5.0, finger_pairs=3),)))
        ratios[ends] = wave.standing_wave_ratio(15.0 * wave.length / 30.0)
        x = np.linspace(14.2, 15.8, 3001) * wave.length / 30.0
        reach = wave.phase_velocity / FREQUENCY
        inside = x[np.abs(x - 0.5 * wave.length) <= reach]
        size = np.abs(wave.normal_at(inside))
        assert ratios[ends] >= 0.98 * size.max() / size.min()
    assert 1 < ratios["absorbing"]
    assert ratios["free"] != pytest.approx(ratios["absorbing"], rel=1e-2)


def test_an_amplitude_that_no_stator_reaches_is_refused(wave):
    """Beyond a micrometre per volt a motion is an artefact: refused wherever it is asked for, not passed on."""
    grown = [
        replace(piece, right=1e7 * piece.right, left=1e7 * piece.left) if isinstance(piece, UniformSegment) else piece
        for piece in wave.pieces
    ]
    loud, at = replace(wave, pieces=tuple(grown)), 0.5 * (wave.pieces[2].start + wave.pieces[2].stop)
    assert abs(wave.motion(at)).max() < 1e-6
    for asked in (loud.motion, loud.rayleigh_motion, loud.standing_wave_ratio):
        with pytest.raises(ConvergenceError, match="more than 1e-06 m per V"):
            asked(at)


@pytest.mark.parametrize("shift", [0.0, 0.011, 0.3, 0.499])
@pytest.mark.parametrize("back", [0.05, 0.9, 0.999])
def test_a_node_between_the_samples_of_a_standing_wave_is_found(shift, back):
    """24 samples to a wavelength, wherever a node lies: (1 + r) / (1 - r) of a wave and r of it from the other side."""
    phase = np.linspace(-2 * np.pi, 2 * np.pi, 49) + 2 * np.pi * shift / 24
    found = standing_wave_ratio(np.exp(-1j * phase) + back * np.exp(1j * phase))
    assert found == pytest.approx((1 + back) / (1 - back), rel=2e-2 if back > 0.99 else 1e-3)
