"""Charges and currents of the combs, and the circuit they are part of.

Every transducer, driven or not, is one port in the sense of network theory (Pozar, *Microwave Engineering*, 2012,
section 4.2): its two electrodes are a terminal pair, and the current into one is the current out of the other, so
that a transducer as a whole carries no net charge.  The field problem is solved for the voltage between the electrodes
(potentials +V/2 and -V/2) and, where the section is grounded, also for their common mean potential; the mean is then
the one at which the net charge vanishes.  Source and terminations see the same N ports, so that their admittance
matrix is symmetric.  A mean held at zero for the driven transducer alone would be another constraint than that of
the passive ones (Y12 differs from Y21 by 10 % on a grounded plate), and over a half-space it would make the answer
depend on the depth at which the potential is fixed.

The reactions q of the field problem are minus the charges per metre of aperture; I = i omega Q.  Two transducers of
different aperture share the narrower beam.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.geometry import Transducer


@dataclass(frozen=True, kw_only=True)
class Ports:
    """Basis of the potentials of a transducer's electrodes.

    Attributes
    ----------
    kinds : tuple of str
        "voltage" between two combs, "mean" of all there are.
    potentials : ndarray, shape (2, ports)
        Of the positive and the negative comb, per unit of each port.
    """

    kinds: tuple[str, ...]
    potentials: np.ndarray = field(repr=False)


def ports_of(transducer: Transducer, floats: bool) -> Ports:
    """Independent potentials of a transducer's electrodes; the mean has no effect where the section ``floats``."""
    combs = [sign in transducer.signs for sign in "+-"]
    found = []
    if all(combs):
        found.append(("voltage", (0.5, -0.5)))
    if any(combs) and not floats:
        found.append(("mean", tuple(map(float, combs))))
    potentials = np.array([potentials for _, potentials in found]).reshape(-1, 2).T
    return Ports(kinds=tuple(kind for kind, _ in found), potentials=potentials)


@dataclass(frozen=True, kw_only=True)
class Circuit:
    """Port voltages per volt of the source.

    Attributes
    ----------
    voltages : ndarray, shape (ports,)
        Complex, V per V.
    currents : ndarray, shape (ports,)
        Into the positive combs, A per V.
    driven : int
        Port of the driven transducer's voltage.
    """

    voltages: np.ndarray = field(repr=False)
    currents: np.ndarray = field(repr=False)
    driven: int

    @property
    def admittance(self) -> complex:
        """Of the driven transducer, the others terminated as they are, in S."""
        return complex(self.currents[self.driven] / self.voltages[self.driven])

    @property
    def power(self) -> float:
        """Mean power into the driven combs in W per V^2 of the source (peak)."""
        return float(0.5 * np.real(self.voltages[self.driven] * np.conj(self.currents[self.driven])))


def port_admittances(
    charges: np.ndarray, transducers: tuple[Transducer, ...], ports: list[Ports], frequency: float
) -> np.ndarray:
    """Short-circuit admittance matrix of all ports.

    Parameters
    ----------
    charges : ndarray, shape (n, n)
        Reactions q per unit port voltage, C/m per V.
    transducers : tuple of Transducer
    ports : list of Ports
        One each.
    frequency : float
        Hz.

    Returns
    -------
    ndarray, shape (n, n)
        S.
    """
    counts = [len(each.kinds) for each in ports]
    apertures = np.repeat([transducer.aperture for transducer in transducers], counts)
    shared = np.minimum(apertures[:, None], apertures[None, :])
    return -2j * np.pi * frequency * shared * charges


def circuit(
    admittances: np.ndarray,
    transducers: tuple[Transducer, ...],
    ports: list[Ports],
    *,
    driven: str,
    source_impedance: complex,
) -> Circuit:
    """Solve the circuit of one source and the other transducers' terminations.

    Parameters
    ----------
    admittances : ndarray, shape (n, n)
        S, of `port_admittances`.
    transducers : tuple of Transducer
    ports : list of Ports
        One each.
    driven : str
        Name of the driven transducer: a source of 1 V behind ``source_impedance`` (ohm) between its two electrodes.

    Returns
    -------
    Circuit

    Raises
    ------
    ValueError
        If no transducer has that name, or it has one comb only.
    """
    names = [transducer.name for transducer in transducers]
    if driven not in names:
        raise ValueError(f"drive.transducer must be one of {', '.join(names)}, got {driven!r}")
    size = len(admittances)
    system, source = np.zeros((size, size), dtype=complex), np.zeros(size, dtype=complex)
    scale = abs(np.diag(admittances))
    unit = np.eye(size)
    row, port = 0, None
    for transducer, own in zip(transducers, ports, strict=True):
        lit = transducer.name == driven
        for kind in own.kinds:
            if kind == "mean":  # no net charge on the transducer
                system[row] = admittances[row] / scale[row]
            elif lit:
                port = row
                system[row] = unit[row] + source_impedance * admittances[row]
                source[row] = 1.0
            elif transducer.termination == "open":
                system[row] = admittances[row] / scale[row]
            else:
                load = 0.0 if transducer.termination == "short" else transducer.termination
                system[row] = unit[row] + load * admittances[row]
            row += 1
    if port is None:
        raise ValueError(f"drive.transducer must have two combs, but {driven!r} has not")
    voltages = np.linalg.solve(system, source)
    return Circuit(voltages=voltages, currents=admittances @ voltages, driven=port)
