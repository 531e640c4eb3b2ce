"""Charges on the electrodes of a solved section; surface_beam.py computes the beam that these charges send.

Fingers that are massless and thin drive the stator through their charges alone.  The charge of a node on the surface is
the sum of the reactions of the potential in the columns of elements that meet there.  The field at any point is the sum
over all nodes of the charge times the response of the bare surface.

Along y the charge of a finger is a sum of sheets, each uniform over a length: the whole aperture, and shorter sheets
with the same middle, which together make a charge that is concentrated at the finger's ends (own_aperture.py).
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fem.beam.lateral import sheet_spectrum
from fem.condense.columns import distinct_columns
from fem.exceptions import InputError
from fem.results.evaluation import left_edge
from fem.results.solution import Solution

SAME_NODE = 1e-9  # length units: nodes of neighbouring columns that are nearer to each other are one node
# Largest phase k a in rad, with a half a finger's width, for which exp(i k x) is summed as a Taylor series, and its
# number of terms: 3^28 / 28! = 8e-17 is rounding.
MAX_PHASE, TERMS = 3.0, 28


class Fingers(NamedTuple):
    """First and last node of every finger (m), half the largest width (m), and the moments of the charges.

    With a = ``half_width`` and x_0 the middle of a finger, its moments and the transform of its charges are

        M_n = sum_j q_j ((x_j - x_0) / a)^n,                                                                (1)
        sum_j q_j exp(i k (x_j - x_0)) = sum_n (i k a)^n / n! M_n.                                          (2)
    """

    first: np.ndarray
    last: np.ndarray
    half_width: float
    moments: np.ndarray  # shape (..., fingers, TERMS)

    @classmethod
    def of(cls, x: np.ndarray, charge: np.ndarray, finger: np.ndarray) -> "Fingers":
        """Return the fingers of charges at nodes x from left to right, (..., nodes).

        ``finger``: number of each node's finger, (nodes,).
        """
        starts = np.flatnonzero(np.diff(finger, prepend=finger[0] - 1))
        stops = np.append(starts[1:], len(x))
        first, last = x[starts], x[stops - 1]
        # ``tiny`` avoids a division by zero if every finger is a single node (a line of charge)
        half = float((last - first).max()) / 2 or np.finfo(float).tiny
        local = (x - np.repeat((first + last) / 2, stops - starts)) / half
        moments = np.add.reduceat(charge[..., None] * np.vander(local, TERMS, increasing=True), starts, axis=-2)
        return cls(first, last, half, moments)

    @property
    def middles(self) -> np.ndarray:
        """Return x of the centres of the fingers, m."""
        return (self.first + self.last) / 2

    def phase(self, wavenumbers: np.ndarray) -> np.ndarray:
        """Return the phase of waves across half a finger, rad; below MAX_PHASE the series of `sums` is accurate."""
        return abs(wavenumbers) * self.half_width

    def powers(self, wavenumbers: np.ndarray) -> np.ndarray:
        """Return (i k a)^n / n! of equation (2), shape (TERMS, *shape of k)."""
        ratios = np.multiply.outer(1j * self.half_width / np.arange(1, TERMS), wavenumbers)  # i k a / n
        return np.cumprod(np.concatenate([np.ones((1, *wavenumbers.shape)), ratios]), axis=0)

    def sums(self, wavenumbers: np.ndarray) -> np.ndarray:
        """Return the transform (2) of the charges of each finger, shape (fingers, *shape of k)."""
        return np.tensordot(self.moments, self.powers(wavenumbers), axes=1)


@dataclass(frozen=True)
class ChargeSheet:
    """Charges that are uniform over |y - center| < length / 2; x, charge and finger as in `ElectrodeCharges`."""

    x: np.ndarray
    charge: np.ndarray
    finger: np.ndarray
    length: float
    center: float

    @cached_property
    def fingers(self) -> Fingers:
        """Fingers and the moments of their charges."""
        return Fingers.of(self.x, self.charge, self.finger)

    @property
    def lumps(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m) and sizes of three point charges per finger, for static fields.

        The charges (M_2 - M_1)/2, M_0 - M_2 and (M_2 + M_1)/2 at the finger's left end, middle and right end have its
        total charge, dipole moment and second moment.  Here the unit of length of M_n is half the finger's own width.
        """
        fingers = self.fingers
        half = np.maximum(fingers.last - fingers.first, np.finfo(float).tiny) / 2  # ``tiny``: as in `Fingers.of`
        total, dipole, second = (fingers.moments[:, power] * (fingers.half_width / half) ** power for power in range(3))
        positions = np.stack([fingers.middles - half, fingers.middles, fingers.middles + half])
        charges = np.stack([(second - dipole) / 2, total - second, (second + dipole) / 2])
        return positions.ravel(), charges.ravel()

    def transform(self, wavenumbers: np.ndarray, origin: float) -> np.ndarray:
        """T(k) = sum_j q_j exp(i k (x_j - x_0)) in C/m per V, for k in rad/m of any shape and x_0 = ``origin`` in m.

        Small k by finger, equation (2) of `Fingers`; large k by node.
        """
        k, fingers = np.asarray(wavenumbers), self.fingers
        out = np.empty(k.shape, dtype=complex)
        small = fingers.phase(k) < MAX_PHASE
        phases = np.exp(1j * np.multiply.outer(fingers.middles - origin, k[small]))
        out[small] = np.sum(fingers.sums(k[small]) * phases, axis=0)
        out[~small] = np.exp(1j * np.multiply.outer(k[~small], self.x - origin)) @ self.charge
        return out


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
        x, (charge,), finger = _node_charges(solution, piece, solution.sides(piece)[:, None])
        return ElectrodeCharges(x=x, charge=charge, finger=finger)
    sheets, weights = solution.fields.sheets[transducer], solution.weights
    x, charges, finger = _node_charges(solution, piece, np.stack([sheet.sides @ weights for sheet in sheets], axis=-1))
    section = solution.fields.section
    moment_unit = -section.solid.stress_unit / section.solid.potential_unit * section.length_unit
    signs = solution.fields.transducers[transducer].signs.replace("0", "")
    number = _finger_numbers(finger, signs)
    on_electrode = np.flatnonzero(number >= 0)  # open strips have no dipoles
    unit_dipole = _unit_dipole(x[on_electrode], number[on_electrode])
    for sheet, charge in zip(sheets, charges, strict=True):
        # The nodal charges contain those dipole moments that follow from the sides; ``dipoles`` are the others
        # (fem.waveguide.network.Sheet).
        charge[on_electrode] += unit_dipole * moment_unit * (sheet.dipoles @ weights)[number[on_electrode]]
    steps = tuple((sheet.length, charge) for sheet, charge in zip(sheets[1:], charges[1:], strict=True))
    return ElectrodeCharges(x=x, charge=charges[0], finger=finger, steps=steps)


def all_charges(solution: Solution) -> tuple[ElectrodeCharges, ...]:
    """Charges of every transducer, from left to right."""
    return tuple(electrode_charges(solution, index) for index in range(len(solution.fields.transducers)))


def sheets_of_forces(solution: Solution) -> list[ChargeSheet]:
    """Strips of the forces of a solution, with N/m in place of charges."""
    if solution.forces is None:
        return []
    unit, ports = solution.fields.section.length_unit, solution.fields.network.ports
    forces = [each for each in ports if each.kind == "force"]
    for each in forces:
        if not np.isfinite(each.width):
            raise InputError("force.width", "must be finite in three dimensions", each.width, "m", owner=each.name)
    return [
        ChargeSheet(
            x=np.array([each.place * unit]),
            charge=np.array([amplitude]),
            finger=np.zeros(1, dtype=int),
            length=each.width * unit,
            center=each.center * unit,
        )
        for each, amplitude in zip(forces, solution.forces, strict=True)
    ]


def _finger_numbers(finger: np.ndarray, signs: str) -> np.ndarray:
    """Number of each node's finger, counting the fingers "+" and "-" only; -1 on an open strip."""
    charged = np.array([sign in "+-" for sign in signs])
    return np.where(charged, np.cumsum(charged) - 1, -1)[finger - finger[0]]


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


def _node_charges(solution: Solution, piece: int, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions in m of a piece's nodes on metal, their charges in C/m, (sheets, nodes), and their finger numbers.

    ``piece``: number of the piece in the row; ``sides``: unknowns of the transducer's two lines and its potentials,
    (2 n + potentials, sheets).
    """
    fields, section, left = solution.fields, solution.fields.section, left_edge(solution, piece)
    half_cell = 1.001 * fields.transducers[fields.owners[piece]].pitch / 2 / section.length_unit
    positions, reactions, metal = [], [], []
    for part, starts, part_sides in distinct_columns(fields.network.scatterers[piece].piece, sides, finest=half_cell):
        own = part.surface_reactions
        positions.append(np.add.outer(own.position, starts).ravel())
        reaction = np.tensordot(own.rows, part_sides, axes=1)  # (nodes, sheets, places)
        reactions.append(np.moveaxis(reaction, 1, 0).reshape(sides.shape[1], -1))
        metal.append(np.repeat(own.on_metal, len(starts)))
    position = left + np.concatenate(positions) * section.length_unit
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
