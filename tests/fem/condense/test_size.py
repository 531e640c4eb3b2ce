"""Sizes counted from the geometry against what a solution really condenses, joins and solves for."""

from dataclasses import replace

import numpy as np
import pytest

from fem.condense import joined_fingers, transducer
from fem.condense.element_column import Column
from fem.condense.problem_size import stator_size
from fem.discretize.element_sizes import Resolution
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.section_mesh import read_mesh
from fem.waveguide.stator_meshes import StatorMeshes
from tests.fem.drawings import rectangle
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, solution, wave_of

PZT, CUT = cut("PZT-8", "Z"), cut("LiNbO3 (Warner)", "YZ")
PLAIN = plate(PZT)
TILTED = plate(CUT, length=5.0)
CASES = {
    "one": (PLAIN, (comb(PLAIN, "a", 1.5),)),
    "two alike": (PLAIN, (comb(PLAIN, "a", 1.0), comb(PLAIN, "b", 3.0))),
    "two kinds": (PLAIN, (comb(PLAIN, "a", 1.0), comb(PLAIN, "b", 2.9, metallisation=0.2))),
    "near neighbour": (PLAIN, (comb(PLAIN, "a", 1.0), comb(PLAIN, "b", 1.85))),
    "fingers left out and open": (PLAIN, (comb(PLAIN, "a", 1.7, finger_pairs=2, pattern="+-0o"),)),
    "split": (PLAIN, (comb(PLAIN, "a", 1.7, finger_pairs=2, split=True),)),
    "three pairs of a cut": (TILTED, (comb(TILTED, "a", 2.2, finger_pairs=3),)),
    "long period": (PLAIN, (comb(PLAIN, "a", 2.0, period=2.7),)),
}


@pytest.mark.parametrize("layers", [0, 1])
@pytest.mark.parametrize(("stator", "row"), CASES.values(), ids=CASES)
def test_counts_are_what_a_solution_does(monkeypatch, stator, row, layers):
    done = {"joined": 0, "condensed": 0}

    def counting(name):
        work = getattr(transducer, name)

        def counted(*args, **kwargs):
            done[name] += 1
            return work(*args, **kwargs)

        return counted

    for name in done:
        counted = counting(name)
        monkeypatch.setattr(transducer, name, counted)
        if hasattr(joined_fingers, name):
            monkeypatch.setattr(joined_fingers, name, counted)
    solved = solution(stator, row, order=3, layers=layers)
    size = stator_size(stator, row, frequency=FREQUENCY, resolution=solved.fields.resolution)
    assert {"joined": size.joins, "condensed": size.condensed} == done
    assert size.unknowns == wave_of(solved).unknowns
    assert size.line == len(solved.fields.modes.wavenumbers)
    assert size.scatterers == len({id(each.piece) for each in solved.fields.network.scatterers})
    assert size.complex == np.iscomplexobj(solved.fields.network.scatterers[0].piece.matrix)


def test_memory_of_the_blocks_is_that_of_their_arrays():
    row = CASES["one"][1]
    for solid in (PZT, lossless("PZT-8", "Z")):
        solved = solution(plate(solid), row, layers=1)
        size = stator_size(plate(solid), row, frequency=FREQUENCY, resolution=solved.fields.resolution)
        assert size.complex == (solid is PZT)
        assert size.block_bytes == pytest.approx(_bytes(solved.fields.network.scatterers[0].piece), rel=0.3, abs=0)


def _bytes(block):
    """Bytes of all arrays that a block and what it was joined of hold, each once."""
    seen, total = set(), 0
    waiting = [block]
    while waiting:
        one = waiting.pop()
        if id(one) in seen:
            continue
        seen.add(id(one))
        total += one.matrix.nbytes
        if isinstance(one.inside, Column):
            total += one.column.faces_from.nbytes
        else:
            total += one.pair.middle.nbytes
            waiting += [one.pair.left, one.pair.right]
    return total


def test_meshed_pieces_are_counted_as_they_are_condensed(tmp_path):
    """Two equal grooves: unknowns of both, and the blocks of one."""
    path = rectangle(tmp_path / "groove.msh", 0.9, PLAIN.thickness * 1e3, size=0.5, groove=(0.35, 0.2, 0.1))
    mesh, level = read_mesh(path, 1e-3), Resolution(order=4, edge_layers=1)
    places = PLAIN.length * np.array([0.6, 0.8])
    stator = replace(PLAIN, pieces=tuple(MeshPiece(name="g", mesh=mesh, position=float(x)) for x in places))
    row = CASES["one"][1]
    size, without = (stator_size(each, row, frequency=FREQUENCY, resolution=level) for each in (stator, PLAIN))
    (piece,) = StatorMeshes(stator, size.section, level, FREQUENCY).condensed(FREQUENCY).values()
    assert size.unknowns - without.unknowns == 2 * piece.unknowns
    blocks = sum(each.nbytes for each in (*piece.insides, *piece.factor.back))
    assert size.block_bytes - without.block_bytes == blocks
