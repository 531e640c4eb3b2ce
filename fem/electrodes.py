"""Charges and currents of the combs, and the circuit they are part of.

Each transducer is one or two ports: the voltage between its combs (potentials +V/2 and -V/2) and, where the section
is grounded, the mean of the two.  The reactions q of the field problem are minus the charges per metre of aperture;
I = i omega Q.  Two transducers of different aperture share the narrower beam.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.geometry import Transducer

VOLTAGE = np.array([[0.5], [-0.5]])
VOLTAGE_AND_MEAN = np.array([[0.5, 1.0], [-0.5, 1.0]])


def port_potentials(floats: bool) -> np.ndarray:
    """Comb potentials of a transducer's ports, shape (2, ports); ``floats``: nothing fixes the mean potential."""
    return VOLTAGE if floats else VOLTAGE_AND_MEAN


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
    charges: np.ndarray, transducers: tuple[Transducer, ...], ports: int, frequency: float
) -> np.ndarray:
    """Short-circuit admittance matrix of all ports.

    Parameters
    ----------
    charges : ndarray, shape (n, n)
        Reactions q per unit port voltage, C/m per V.
    transducers : tuple of Transducer
    ports : int
        Ports of each.
    frequency : float
        Hz.

    Returns
    -------
    ndarray, shape (n, n)
        S.
    """
    apertures = np.repeat([transducer.aperture for transducer in transducers], ports)
    shared = np.minimum(apertures[:, None], apertures[None, :])
    return -2j * np.pi * frequency * shared * charges


def circuit(
    admittances: np.ndarray,
    transducers: tuple[Transducer, ...],
    ports: int,
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
    ports : int
        Ports of each.
    driven : str
        Name of the driven transducer: a source of 1 V behind ``source_impedance`` (ohm), combs at +V/2 and -V/2.

    Returns
    -------
    Circuit

    Raises
    ------
    ValueError
        If no transducer has that name.
    """
    names = [transducer.name for transducer in transducers]
    if driven not in names:
        raise ValueError(f"drive.transducer must be one of {', '.join(names)}, got {driven!r}")
    size = len(admittances)
    system, source = np.zeros((size, size), dtype=complex), np.zeros(size, dtype=complex)
    scale = abs(np.diag(admittances))
    unit = np.eye(size)
    for index, transducer in enumerate(transducers):
        voltage = index * ports
        if transducer.name == driven:
            system[voltage] = unit[voltage] + source_impedance * admittances[voltage]
            source[voltage] = 1.0
        elif transducer.termination == "open":
            system[voltage] = admittances[voltage] / scale[voltage]
        else:
            load = 0.0 if transducer.termination == "short" else transducer.termination
            system[voltage] = unit[voltage] + load * admittances[voltage]
        for mean in range(voltage + 1, voltage + ports):
            system[mean] = unit[mean] if transducer.name == driven else admittances[mean] / scale[mean]
    voltages = np.linalg.solve(system, source)
    return Circuit(voltages=voltages, currents=admittances @ voltages, driven=names.index(driven) * ports)
