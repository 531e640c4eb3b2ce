"""Fields of a stator for unit voltage at every port, and the short-circuit admittance matrix.

A port is a transducer with two electrodes, and its voltage is that between them.  The problem is linear, so that the
fields for unit voltage at each port, with the other ports at zero, give the answer for every circuit (`fem.circuit`).
Every transducer is condensed once (equal ones share their superelement); the fields in the uniform segments are sums of
guided modes.

A transducer carries no net charge, because its electrodes are a pair of terminals.  If the potential of the section
floats, the mean of the two potentials is arbitrary.  If the section is grounded (or absorbs below), the mean has the
value for which the net charge is zero, and it is eliminated here.  A transducer with a single electrode has no port.

With Q the charge of the positive electrode per metre of aperture, I = i omega Q aperture.  For the current that one
transducer causes in another, the aperture is the narrower of the two.  Net charges vanish per metre, on every strip
along y, whatever the apertures; with apertures of the transducers' own (fem.beam.reception) over the whole aperture.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from fem.condense.cascade_piece import Port
from fem.condense.electrode_conditions import electrode_potentials, transducer_ports, uncharged
from fem.condense.finger_columns import FingerColumns
from fem.condense.transducer import Condensation, finger_ports, on_electrodes, transducer_superelements
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.section import LineSpace
from fem.exceptions import ActivePortError, ConvergenceError
from fem.geometry import Stator, Transducer, outer_gaps
from fem.waveguide.guided_modes import GuidedModes, guided_modes
from fem.waveguide.line_force import LineForce
from fem.waveguide.scattering_network import Network, PortSolution, Scatterer
from fem.waveguide.stator_meshes import CondensedPieces, condensed_pieces, no_pieces

# rad per slowest wavelength: the eigenproblem gives k^2, and below this |k| only its rounding error
CUT_OFF = 1e-3
PASSIVE = 1e-3  # negative conductance over the largest admittance that counts as the discretisation's error
MAX_COLUMNS = 150_000  # finger-edge element columns of all transducers; about 1 min of condensation


@dataclass(frozen=True, kw_only=True)
class StatorCascade:
    """A stator on one discretisation: the network to be solved, and which transducer each of its scatterers is."""

    stator: Stator
    transducers: tuple[Transducer, ...]  # from left to right
    network: Network
    # of each scatterer of the network: number of its transducer, None for a meshed piece
    owners: tuple[int | None, ...]
    resolution: Resolution

    @property
    def modes(self) -> GuidedModes:
        """Modes of the uniform segments."""
        return self.network.modes

    @property
    def section(self) -> LineSpace:
        """Lines of the uniform segments."""
        return self.modes.section

    @property
    def frequency(self) -> float:
        """Frequency in Hz."""
        return self.modes.frequency

    def solved(self, solution: PortSolution | None = None) -> "PortFields":
        """Fields per volt at the ports, such that no transducer has a net charge.

        ``solution``: fields per unit of potential at the ports of the network, and from outside; by default those of
        `Network.solve`.
        """
        solution = solution or self.network.solve()
        medium = self.section.solid
        ports = [port for port in self.network.ports if port.kind != "force"]
        by_name = {each.name: each for each in self.transducers}
        apertures = np.array([by_name[port.name].aperture for port in ports])[:, None]
        voltage = np.array([port.kind == "voltage" for port in ports], dtype=bool)
        names = tuple(port.name for port in ports if port.kind == "voltage")
        charges = solution.reactions[: len(ports)]
        if solution.own_apertures:  # then what a charge acts on differs along y, and its mean is that of the aperture
            charges = apertures * charges
        weights = uncharged(charges, voltage)
        weights[:, : len(names)] /= medium.potential_unit
        # Widths over which charges are summed: of the two apertures the narrower one for charges that another port
        # causes, and the whole aperture for those by forces and waves from outside.
        widths = np.ones((len(names), weights.shape[1]))
        if not solution.own_apertures:
            own = apertures[voltage]
            widths *= own
            widths[:, : len(names)] = np.minimum(own, own.T)
        charge_unit = medium.stress_unit / medium.potential_unit
        currents = charge_currents(widths * (charges[voltage] @ weights) * charge_unit, self.frequency)
        check_passive(currents[:, : len(names)], names, self.frequency)
        fields = solution.weighted(weights)
        return PortFields(
            **vars(fields),
            stator=self.stator,
            transducers=self.transducers,
            network=self.network,
            owners=self.owners,
            resolution=self.resolution,
            names=names,
            admittances=currents[:, : len(names)],
            received=currents[:, len(names) :],
        )


@dataclass(frozen=True, kw_only=True)
class PortFields(StatorCascade, PortSolution):
    """A cascade and its fields for each of its excitations, the other ones at zero; no transducer has a net charge.

    The excitations are 1 V at each port, then 1 N/m of each force, then a wave of amplitude 1 from outside.
    ``sides`` (of `PortSolution`) holds the lines and the scaled potentials of each scatterer; the potentials are those
    of a transducer's two electrodes, or of every finger (fem.beam.reception), or of a meshed piece's ports.
    """

    names: tuple[str, ...]  # transducers that are ports, from left to right
    # shape (ports, ports): short-circuit admittance matrix in S, symmetric
    admittances: np.ndarray = field(repr=False)
    # shape (ports, forces and waves from outside): currents into the positive electrodes of shorted ports
    received: np.ndarray = field(repr=False)

    @property
    def displacements(self) -> np.ndarray:
        """Displacement in m under each force, along it, shape (forces, excitations).

        It is empty if the charges are those of each transducer's own aperture (`own_apertures`), whose solution has no
        reactions at the forces.
        """
        return self.reactions[sum(port.kind != "force" for port in self.network.ports) :]

    @property
    def unknowns(self) -> int:
        """Unknowns of the discretised problem that was condensed."""
        return sum(scatterer.piece.unknowns for scatterer in self.network.scatterers)

    def amplification(self, phase_range: float) -> tuple[float, float]:
        """Resonant amplification of small errors at this frequency, and the largest near it.

        Between reflecting ends the amplitudes are (1 - M)^-1 times what the transducers send (M: ``coupling`` of the
        propagating modes).  The effect of a small phase error is therefore proportional to 1 / |1 - mu|, with mu the
        eigenvalue of M nearest to 1.  With frequency the phases of the mu change, in the range of interest by at most
        ``phase_range`` (rad); their magnitudes hardly change.
        """
        # the phase of an evanescent mode does not change
        propagating = np.isin(self.waves, self.modes.propagating)
        factors = np.linalg.eigvals(self.coupling[np.ix_(propagating, propagating)])
        if not len(factors):
            return 1.0, 1.0
        angles = abs(np.angle(factors))
        # each mu turned towards 1 by at most phase_range
        nearest = abs(factors) * np.exp(1j * np.maximum(angles - phase_range, 0.0))
        return float(1 / abs(1 - factors).min()), float(1 / abs(1 - nearest).min())


def _with_mean_port(transducers: tuple[Transducer, ...], pieces: CondensedPieces, floating: bool) -> set[str]:
    """Names of the transducers whose mean potential is an unknown and has a port of its own.

    That is all of them, unless the section floats or one mesh is the whole stator.  In these two cases the mean of a
    transducer is arbitrary, except with electrodes in a meshed piece that is grounded; and where meshed pieces connect
    transducers to each other, the mean of only one of them is arbitrary.
    """
    names = {each.name for each in transducers}
    if not (floating or pieces.whole):
        return names
    # Transducers that meshed pieces connect form a group, which is named after its first transducer.
    group = {name: name for name in names}
    grounded: set[str] = set()  # names of groups
    for _, piece in pieces.between:
        connected = {group[port.name[:-1]] for port in piece.ports}
        group = {name: min(connected) if each in connected else each for name, each in group.items()}
        if connected & grounded or (connected and piece.grounded):
            grounded.add(min(connected))
    return {name for name, first in group.items() if name != first or first in grounded}


def stator_cascade(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float,
    resolution: Resolution,
    forces: tuple[LineForce, ...] = (),
    nearest: float = np.inf,
) -> StatorCascade:
    """Discretise and condense a stator at a frequency in Hz, with line forces on its bare surface.

    ``nearest``: smallest distance in m from a force of the places at which its motion is asked for.  The motion beside
    a line force grows as the logarithm of the distance, so that the elements are graded towards the surface down to
    this length, as below the edge of a finger.

    A ConvergenceError says that there are too many fingers, or that a mode is at its cut-off.
    """
    transducers = tuple(sorted(transducers, key=lambda transducer: transducer.center))
    drawn = stator.placement.whole is not None  # by a mesh: all fingers
    fingers = 0 if drawn else sum(len(transducer.signs) for transducer in transducers)
    if fingers * (resolution.edge_layers + 1) > MAX_COLUMNS:
        raise ConvergenceError(
            f"{fingers} fingers with {resolution.edge_layers} edge layers have more columns of elements than can be "
            "walked through in minutes: take fewer finger_pairs, or ask for a looser tolerance"
        )
    unit = stator.slowest_wavelength(frequency)
    scale = min((each.finger_width / 2 for each in transducers if not drawn), default=np.inf)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=min(scale, nearest))
    superelements = (
        [] if drawn else transducer_superelements(Condensation(section, frequency), stator, transducers, resolution)
    )
    modes = guided_modes(section, frequency)
    if modes.nearest_cut_off < CUT_OFF:
        raise ConvergenceError(
            f"a mode of the section is at its cut-off at {frequency:.12g} Hz, where the last digits decide: "
            "change the frequency by a part in 100000, or give the solid a mechanical_quality"
        )
    pieces = condensed_pieces(stator, modes, resolution)
    return joined_cascade(
        stator, transducers, superelements, modes=modes, resolution=resolution, pieces=pieces, forces=forces
    )


def joined_cascade(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    superelements: list[FingerColumns],
    *,
    modes: GuidedModes,
    resolution: Resolution,
    pieces: CondensedPieces | None = None,
    forces: tuple[LineForce, ...] = (),
) -> StatorCascade:
    """Join superelements, uniform segments and ends to a cascade.

    ``superelements``: one for each transducer from left to right, including its outer gaps; equal transducers share an
    object, and there are none if one mesh is the whole stator.  ``pieces``: meshed pieces and ends of the stator, by
    default no pieces and plain ends; ``forces``: on the bare surface.
    """
    pieces = pieces or no_pieces(stator, modes.section.length_unit)
    with_mean = _with_mean_port(transducers, pieces, modes.section.floating_potential)
    own_ports = [transducer_ports(each, each.name in with_mean) for each in transducers]
    ports = tuple(port for own in own_ports for port in own)
    potentials = [electrode_potentials(each, own) for each, own in zip(transducers, own_ports, strict=True)]
    first = np.cumsum([0, *map(len, own_ports)])
    numbers = [np.arange(*first[index : index + 2]) for index in range(len(transducers))]
    elements = _mesh_elements(modes, transducers, pieces, numbers, potentials, len(ports))
    if not pieces.whole:
        elements += _transducer_elements(
            modes, outer_gaps(stator, transducers), transducers, superelements, numbers, potentials
        )
    elements.sort(key=lambda each: each.position)
    network = Network(
        modes=modes,
        scatterers=tuple(each.scatterer for each in elements),
        positions=tuple(each.position for each in elements),
        start=pieces.start,
        stop=pieces.stop,
        ends=pieces.ends,
        ports=ports + tuple(_force_port(each, modes.section.length_unit) for each in forces),
        numbers=tuple(each.numbers for each in elements),
    )
    owners = tuple(each.owner for each in elements)
    return StatorCascade(stator=stator, transducers=transducers, network=network, owners=owners, resolution=resolution)


def by_finger(fields: PortFields) -> list[FingerColumns]:
    """Superelements of transducers with one potential for each finger, in a stator without meshed pieces."""
    each = zip(fields.network.scatterers, fields.transducers, strict=True)
    return [finger_ports(scatterer.columns, transducer.signs)[0] for scatterer, transducer in each]


def with_other_signs(
    fields: PortFields, pieces: list[FingerColumns], transducers: tuple[Transducer, ...]
) -> PortFields:
    """Fields of transducers whose fingers are the same, on other electrodes; apertures may differ too.

    ``pieces``: `by_finger` of the fields.
    """
    transducers = tuple(sorted(transducers, key=lambda transducer: transducer.center))
    superelements = [on_electrodes(piece, each.signs) for piece, each in zip(pieces, transducers, strict=True)]
    return joined_cascade(
        fields.stator, transducers, superelements, modes=fields.modes, resolution=fields.resolution
    ).solved()


class _CascadeElement(NamedTuple):
    """A transducer or a meshed piece in the cascade."""

    position: float  # of its left line, length units
    scatterer: Scatterer
    numbers: np.ndarray  # numbers of the network's ports that determine its potentials
    owner: int | None  # number of its transducer; None for a meshed piece


def _transducer_elements(
    modes: GuidedModes,
    gaps: list[tuple[float, float]],
    transducers: tuple[Transducer, ...],
    superelements: list[FingerColumns],
    numbers: list[np.ndarray],
    potentials: list[np.ndarray],
) -> list[_CascadeElement]:
    """Elements of the transducers; equal ones share a superelement and therefore a scatterer.  ``gaps``: outer gaps."""
    scatterers = {
        id(superelement): Scatterer(piece=superelement, modes=modes, potentials=own)
        for superelement, own in zip(superelements, potentials, strict=True)
    }
    unit = modes.section.length_unit
    return [
        _CascadeElement((each.extent[0] - gap[0]) / unit, scatterers[id(superelement)], numbers[index], index)
        for index, (each, gap, superelement) in enumerate(zip(transducers, gaps, superelements, strict=True))
    ]


def _mesh_elements(
    modes: GuidedModes,
    transducers: tuple[Transducer, ...],
    pieces: CondensedPieces,
    numbers: list[np.ndarray],
    potentials: list[np.ndarray],
    ports: int,
) -> list[_CascadeElement]:
    """Elements of the meshed pieces; an electrode in a mesh has the potential of the transducer's electrode."""
    by_electrode = {  # potential of each electrode for a unit at each of the network's ports
        f"{each.name}{sign}": np.eye(ports)[own_numbers].T @ own_potentials[electrode]
        for each, own_numbers, own_potentials in zip(transducers, numbers, potentials, strict=True)
        for electrode, sign in enumerate("+-")
    }
    elements = []
    for position, piece in pieces.between:
        table = np.array([by_electrode[port.name] for port in piece.ports]).reshape(-1, ports)
        used = np.flatnonzero(table.any(axis=0))
        scatterer = Scatterer(piece=piece, modes=modes, potentials=table[:, used])
        elements.append(_CascadeElement(position, scatterer, used, None))
    return elements


def _force_port(force: LineForce, unit: float) -> Port:
    """Port of a line force, in length units."""
    return Port(
        kind="force",
        name=force.name,
        component=force.component,
        position=force.position / unit,
        width=force.width / unit,
        center=force.center_y / unit,
    )


def check_passive(admittances: np.ndarray, names: tuple[str, ...], frequency: float) -> None:
    """Raise an ActivePortError if admittances at a frequency in Hz are not passive, beyond a share of `PASSIVE`."""
    if not len(names):
        return
    powers, volts = np.linalg.eigh((admittances.real + admittances.real.T) / 2)
    if powers[0] < -PASSIVE * abs(admittances).max():
        name = names[int(np.argmax(abs(volts[:, 0])))]
        raise ActivePortError(
            f"transducer {name!r} would give out power at {frequency / 1e6:.6g} MHz, a conductance of "
            f"{powers[0]:.3g} S beside an admittance of {abs(admittances).max():.3g} S: the computed field is not good "
            "enough here; ask for a smaller error, or take a longer aperture"
        )


def charge_currents(charges: np.ndarray, frequency: float) -> np.ndarray:
    """Currents in A of reactions int grad psi . D over an aperture, in C.

    Reactions are minus the charges of the electrodes, so that I = i omega Q changes its sign.
    """
    return -2j * np.pi * frequency * charges
