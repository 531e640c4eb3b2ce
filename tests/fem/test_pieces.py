"""Pieces of the stator given as meshes: what must not change, what must balance, and what other programs say."""

from dataclasses import replace

import numpy as np
import pytest

from fem.discretize.grading import Resolution
from fem.mesh.piece import MeshPiece
from fem.mesh.section_mesh import read_mesh
from fem.results.evaluation import surface_of
from fem.results.power_balance import power_balance
from fem.results.solution import solve_driven
from tests.fem.drawings import rectangle
from tests.fem.stators import comb, cut, plate

LEVEL = Resolution(order=8, edge_layers=3)
PLACES = np.array([0.3, 3.7, 4.3, 5.9, 6.4, 8.7])  # wavelengths; the last but two on the second piece


def _solved(stator, drive="a", level=LEVEL):
    row = (
        comb(stator, "a", 1.5, finger_pairs=2, metallisation=0.45),
        comb(stator, "b", 7.5, metallisation=0.45, termination=50.0),
    )
    return solve_driven(stator, row, frequency=2.3e6, drive=drive, resolution=level)


def _with_pieces(stator, path, places, **rest):
    """Pieces whose file is in wavelengths of the stator."""
    unit = stator.thickness / 0.8
    mesh = read_mesh(path, unit)
    return replace(
        stator,
        pieces=tuple(
            MeshPiece(name=f"p{k}", mesh=mesh, position=place * unit, **rest)
            for k, place in enumerate(places)
        ),
    )


def _motion(solution):
    unit = solution.fields.section.length_unit
    return surface_of(solution).motion(PLACES * unit)


@pytest.mark.parametrize(
    ("name", "orientation", "sides", "bound"),
    [
        ("PZT-4", "Z", {"ends": "absorbing", "bottom": "free"}, 1e-8),
        ("PZT-4", "Z", {"ends": "free", "bottom": "grounded"}, 1e-8),
        ("PZT-5H", "X", {"ends": "absorbing", "bottom": "clamped"}, 1e-8),
        # one element through 0.8 wavelengths: the section's own error
        ("LiNbO3 (Kovacs)", "128YX", {"ends": "absorbing", "bottom": "free"}, 3e-7),
    ],
)
def test_a_meshed_plain_stretch_is_invisible(tmp_path, name, orientation, sides, bound):
    """Two pieces of plain stator as irregular triangles change neither motion nor admittance; all of it balances.

    The piece's interface does not conform to the section's line: only the L2 projection keeps this (sampling at the
    nodes errs by 3e-2).
    """
    stator = plate(cut(name, orientation, quality=200), length=9.0, **sides)
    path = rectangle(tmp_path / "plain.msh", 0.9, 0.8, size=0.3)
    plain, meshed = _solved(stator), _solved(_with_pieces(stator, path, (3.6, 5.2)))
    size = abs(_motion(plain)).max()
    assert abs(_motion(meshed) - _motion(plain)).max() < bound * size
    before, after = plain.fields.admittances, meshed.fields.admittances
    assert abs(after - before).max() < bound * abs(before).max()
    # between free ends rounding is amplified by the resonances
    assert abs(after - after.T).max() < 5e-11 * abs(after).max()
    assert power_balance(meshed).residual < 1e-11


def test_a_groove_reflects_and_its_power_balances(tmp_path):
    """A groove with loss: what arrives is what leaves and what is lost inside, and the ports stay reciprocal."""
    stator = plate(cut("PZT-4", "Z", quality=300), length=9.0)
    path = rectangle(tmp_path / "groove.msh", 0.9, 0.8, size=0.45, groove=(0.35, 0.2, 0.1))
    level = Resolution(order=6, edge_layers=1)
    plain, grooved = (_solved(each, level=level) for each in (stator, _with_pieces(stator, path, (4.2,))))
    assert abs(_motion(grooved) - _motion(plain)).max() > 0.1 * abs(_motion(plain)).max()
    after = grooved.fields.admittances
    assert abs(after - after.T).max() < 1e-11 * abs(after).max()
    balance = power_balance(grooved)
    assert balance.residual < 1e-11
    assert balance.input == pytest.approx(balance.solid + balance.loads + balance.radiated, rel=1e-9)
