"""Network parameters S, Y, Z, G and H of ports with any reference impedances, as S-parameters with one real reference.

Each kind of parameters gives the voltages and currents of the ports as linear functions of some basis, V and I; the
S-parameters with a real reference R are then (V - R I) (V + R I)^-1, of which no inverse is singular for a passive
network.  The incident and reflected waves of a port with the reference Z are

    a = k (V + Z I),  b = k (V - Z' I),

with Z' = Z* and k = 1 / (2 sqrt(Re Z)) for power waves (Kurokawa, IEEE Trans. MTT 13, 1965, 194), Z' = Z and
k = sqrt(Re Z) / (2 |Z|) for pseudo waves (Marks and Williams, J. Res. NIST 97, 1992, 533), Z' = Z and
k = 1 / (2 sqrt(Z)) for travelling waves.  All are the same for equal real references.
"""

import numpy as np

WAVES = ("power", "pseudo", "traveling")  # words of HFSS and scikit-rf in the comments of a file


def scattering(kind: str, values: np.ndarray, target: float, references: np.ndarray, wave: str = "power") -> np.ndarray:
    """Return S-parameters with a real reference.

    Parameters
    ----------
    kind : str
        "s", "y" (S), "z" (ohm), "g" or "h" (mixed, of two ports).
    values : ndarray, shape (n, ports, ports)
        Parameters.
    target : float
        Reference of the result, ohm.
    references : ndarray, shape (n, ports)
        Complex references of "s", ohm; unused for others.
    wave : str
        Definition of the waves of "s", one of `WAVES`.

    Returns
    -------
    ndarray, shape (n, ports, ports)

    Raises
    ------
    numpy.linalg.LinAlgError
        If the network has no such parameters.

    Examples
    --------
    >>> scattering("y", np.array([[[0.02]]]), 50.0, np.array([[50.0]])).real
    array([[[0.]]])
    """
    if kind == "s":
        if np.all(references == target):
            return values
        voltage, current = _of_waves(values, references, wave)
    else:
        voltage, current = _of_parameters(kind, values)
    incident, reflected = voltage + target * current, voltage - target * current
    return np.linalg.solve(incident.transpose(0, 2, 1), reflected.transpose(0, 2, 1)).transpose(0, 2, 1)


def in_ohm(kind: str, values: np.ndarray, references: np.ndarray) -> np.ndarray:
    """Return parameters in S and ohm from ones that are normalised to real references, as in Touchstone version 1.

    Voltages are then in units of sqrt(R) and currents of 1 / sqrt(R): y = Y R and z = Z / R at equal references.
    """
    root = np.sqrt(references)
    rows, columns = {
        "y": (1.0 / root, 1.0 / root), "z": (root, root),
        # rows V1, I2 by columns I1, V2; and rows I1, V2 by columns V1, I2
        "h": (root * [1, 0] + [0, 1] / root, root * [1, 0] + [0, 1] / root) if root.shape[1] == 2 else (root, root),
        "g": ([1, 0] / root + root * [0, 1], [1, 0] / root + root * [0, 1]) if root.shape[1] == 2 else (root, root),
        "s": (np.ones_like(root), np.ones_like(root)),
    }[kind]  # fmt: skip
    return rows[:, :, None] * values * columns[:, None, :]


def _of_waves(values: np.ndarray, references: np.ndarray, wave: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the voltages and currents of incident waves of 1."""
    size = {
        "power": 0.5 / np.sqrt(np.abs(references.real)),
        "pseudo": 0.5 * np.sqrt(np.abs(references.real)) / np.abs(references),
        "traveling": 0.5 / np.sqrt(references.astype(complex)),
    }[wave]
    back = np.conj(references) if wave == "power" else references
    one = np.eye(values.shape[1])
    current = (1.0 / (size * (references + back)))[:, :, None] * (one - values)
    voltage = one / size[:, :, None] - references[:, :, None] * current
    return voltage, current


def _of_parameters(kind: str, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return voltages and currents of a basis: currents of "z", voltages of "y", (I1, V2) of "h", (V1, I2) of "g"."""
    one = np.broadcast_to(np.eye(values.shape[1], dtype=complex), values.shape)
    if kind in "yz":
        return (one, values) if kind == "y" else (values, one)
    first, second = np.array(one), np.array(one)  # second: the quantities of the basis and of the rows exchanged
    if kind == "h":  # V1 = h11 I1 + h12 V2, I2 = h21 I1 + h22 V2
        first[:, 0], second[:, 1] = values[:, 0], values[:, 1]
    else:  # I1 = g11 V1 + g12 I2, V2 = g21 V1 + g22 I2
        first[:, 1], second[:, 0] = values[:, 1], values[:, 0]
    return first, second
