"""Charges on the electrodes of a solved section; beam_of_charges.py computes the beam that these charges send.

Fingers that are massless and thin drive the stator through their charges alone.  The charge of a node on the surface is
the sum of the reactions of the potential in the columns of elements that meet there.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.beam.beam_of_charges import ChargeSheet
from fem.beam.lateral import sheet_spectrum
from fem.condense.electrode_conditions import charged
from fem.condense.finger_columns import distinct_columns
from fem.condense.reaction_moments import SAME_NODE
from fem.results.field_evaluation import left_edge
from fem.results.stator_solution import Solution


@dataclass(frozen=True, kw_only=True)
class ElectrodeCharges:
    """Charges on the fingers of one transducer.

    Attributes
    ----------
    x : ndarray, shape (nodes,)
        Positions in m from the stator's left end, increasing.
    charge : ndarray, shape (nodes,)
        Of the sheet over the whole aperture: C per metre along y, per volt of the source; complex.
    finger : ndarray of int, shape (nodes,)
        Number of the finger of each node.
    steps : tuple of (float, ndarray)
        Of each shorter sheet: its length along y (m), and its charges, (nodes,).  Along y the sum of all sheets is a
        step function, hence the name.
    """

    x: np.ndarray = field(repr=False)
    charge: np.ndarray = field(repr=False)
    finger: np.ndarray = field(repr=False)
    steps: tuple[tuple[float, np.ndarray], ...] = field(default=(), repr=False)

    def plane_transform(self, vector: np.ndarray, aperture: float, origin: float) -> np.ndarray:
        """Fourier transform in the plane at wave vectors (k_x, k_y), shape (2, n), about the centre, in C per V."""
        return sum(
            sheet.transform(vector[0], origin) * sheet_spectrum(sheet.length, vector[1])
            for sheet in self.sheets(aperture, 0.0)
        )

    def sheets(self, aperture: float, center: float) -> list[ChargeSheet]:
        """Uniform sheets whose charges add up to these, for an aperture and its centre along y in m."""
        return [
            ChargeSheet(self.x, charge, self.finger, length, center)
            for length, charge in ((aperture, self.charge), *self.steps)
        ]


def electrode_charges(solution: Solution, transducer: int) -> ElectrodeCharges:
    """Charges on a transducer's fingers; ``transducer``: its number, from left to right."""
    piece = solution.fields.owners.index(transducer)
    if not solution.fields.sheets:
        x, (charge,), finger = _node_charges(solution, transducer, solution.sides(piece)[:, None])
        return ElectrodeCharges(x=x, charge=charge, finger=finger)
    sheets, weights = solution.fields.sheets[transducer], solution.weights
    sides = np.stack([sheet.sides @ weights for sheet in sheets], axis=-1)
    x, charges, finger = _node_charges(solution, transducer, sides)
    section = solution.fields.section
    moment_unit = -section.solid.stress_unit / section.solid.potential_unit * section.length_unit
    signs = solution.fields.transducers[transducer].signs.replace("0", "")
    number = _finger_numbers(finger, signs)
    on_electrode = np.flatnonzero(number >= 0)  # open strips have no dipoles
    unit_dipole = _unit_dipole(x[on_electrode], number[on_electrode])
    for sheet, charge in zip(sheets, charges, strict=True):
        # The nodal charges contain those dipole moments that follow from the sides; ``dipoles`` are the others
        # (fem.waveguide.scattering_network.Sheet).
        charge[on_electrode] += unit_dipole * moment_unit * (sheet.dipoles @ weights)[number[on_electrode]]
    steps = tuple((sheet.length, charge) for sheet, charge in zip(sheets[1:], charges[1:], strict=True))
    return ElectrodeCharges(x=x, charge=charges[0], finger=finger, steps=steps)


def all_charges(solution: Solution) -> tuple[ElectrodeCharges, ...]:
    """Charges of every transducer, from left to right."""
    return tuple(electrode_charges(solution, index) for index in range(len(solution.fields.transducers)))


def _finger_numbers(finger: np.ndarray, signs: str) -> np.ndarray:
    """Number of each node's finger, counting the fingers "+" and "-" only; -1 on an open strip."""
    connected = charged(signs)
    return np.where(connected, np.cumsum(connected) - 1, -1)[finger - finger[0]]


def _unit_dipole(x: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Nodal charges, 1/m, of a dipole moment of 1 on each finger, for the nodes (m) and the number of their finger.

    Across a finger of half width a the density is that of an isolated strip, 1 / (pi (a^2 - x^2)^(1/2)), times x.  It
    is integrated, as d arcsin(x / a) / pi, between the midpoints to the neighbouring nodes, and normalised.
    """
    dipoles = [np.empty(0)]
    for each in range(number.max(initial=-1) + 1):
        nodes = x[number == each]
        half = (nodes[-1] - nodes[0]) / 2
        s = (nodes - nodes[0]) / half - 1
        midpoints = np.concatenate([[-1.0], (s[1:] + s[:-1]) / 2, [1.0]])
        strip = np.diff(np.arcsin(midpoints)) / np.pi
        dipoles.append(strip * s / (np.sum(strip * s**2) * half))
    return np.concatenate(dipoles)


def _node_charges(solution: Solution, transducer: int, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions in m of a transducer's nodes on metal, their charges in C/m, (sheets, nodes), and their finger numbers.

    ``sides``: unknowns of the transducer's two lines and its potentials, (2 n + potentials, sheets).
    """
    fields, section, piece = solution.fields, solution.fields.section, solution.fields.owners.index(transducer)
    row = fields.transducers[transducer]  # of uneven fingers the smallest half of a cell, or less
    half_cell = 1.001 * (row.pitch / 2 if row.even else row.finger_width / 2 + row.half_gap) / section.length_unit
    positions, reactions, metal = [], [], []
    for part, starts, part_sides in distinct_columns(fields.network.scatterers[piece].columns, sides, finest=half_cell):
        own = part.surface_reactions
        positions.append(np.add.outer(own.position, starts).ravel())
        reaction = np.tensordot(own.rows, part_sides, axes=1)  # (nodes, sheets, occurrences)
        reactions.append(np.moveaxis(reaction, 1, 0).reshape(sides.shape[1], -1))
        metal.append(np.repeat(own.on_metal, len(starts)))
    position = left_edge(solution, piece) + np.concatenate(positions) * section.length_unit
    from_left = np.argsort(position, kind="stable")
    position, on_metal = position[from_left], np.concatenate(metal)[from_left]
    reaction = np.concatenate(reactions, axis=1)[:, from_left]
    # Neighbouring columns share a node: their reactions are added, and it is covered if either column is.
    node = np.cumsum(np.diff(position, prepend=-np.inf) > SAME_NODE * section.length_unit) - 1
    first = np.searchsorted(node, np.arange(node[-1] + 1))
    node_reaction = np.add.reduceat(reaction, first, axis=1)
    covered = np.logical_or.reduceat(on_metal, first)
    finger = np.cumsum(np.diff(covered.astype(int), prepend=0) == 1)
    unit = -section.solid.stress_unit / section.solid.potential_unit  # the charge is minus the reaction
    return position[first][covered], unit * node_reaction[:, covered], finger[covered]
