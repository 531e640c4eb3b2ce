"""A network analyser's file: S-parameters over frequency (Touchstone 1 and 2, read by scikit-rf)."""

import re
import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from studies.refusal import SceneError, needed

TOUCHSTONE = re.compile(r"\.s(?P<ports>\d+)p", re.IGNORECASE)


@dataclass(frozen=True, kw_only=True)
class NetworkData:
    """Measured S-parameters."""

    name: str  # of the file
    frequency: np.ndarray = field(repr=False)  # Hz, rising, shape (n,)
    scattering: np.ndarray = field(repr=False)  # complex, shape (n, ports, ports)
    reference: float  # impedance in ohm

    @property
    def ports(self) -> int:
        """Number of ports."""
        return self.scattering.shape[1]

    @property
    def coordinate(self) -> np.ndarray:
        """Frequency in Hz of each real part in `flat`."""
        return np.repeat(self.frequency, self.ports**2)

    @property
    def admittance(self) -> np.ndarray:
        """Admittance matrix in S, (n, ports, ports)."""
        one = np.eye(self.ports)
        return np.linalg.solve(one + self.scattering, one - self.scattering) / self.reference

    def flat(self) -> np.ndarray:
        """Return the S-parameters as real numbers: real parts, then imaginary parts."""
        return np.concatenate([self.scattering.real.ravel(), self.scattering.imag.ravel()])


def read_network(path: Path, option: str) -> NetworkData:
    """Return the data of a Touchstone file.

    Raises
    ------
    SceneError
        If it cannot be read, is no Touchstone file, or its frequencies do not rise.
    """
    ports = TOUCHSTONE.fullmatch(path.suffix)
    if ports is None:
        raise SceneError(option, f"must be a Touchstone file, .s1p, .s2p ..., got {path.name!r}")
    network = needed("skrf", "a Touchstone file").Network()
    try:
        with warnings.catch_warnings():  # frequencies that do not rise are refused below
            warnings.simplefilter("ignore")
            network.read_touchstone(str(path))
    except OSError as error:
        raise SceneError(option, f"{str(path)!r} cannot be read: {error.strerror}") from None
    except Exception as error:  # scikit-rf raises errors of many kinds
        text = " ".join(str(error).split())
        raise SceneError(option, f"{path.name!r} is no Touchstone file of {ports['ports']} ports: {text}") from None
    if network.f.size == 0 or network.nports != int(ports["ports"]):
        rule = f"must hold S-parameters of {ports['ports']} ports, got {network.f.size} frequencies"
        raise SceneError(option, f"{path.name!r} {rule} of {network.nports} ports")
    own = float(network.z0[0, 0].real)
    if np.any(network.z0 != own):  # ports with references of their own, which version 2 allows
        network.renormalize(own)
    at, values = network.f, network.s
    if not (np.all(np.isfinite(at)) and np.all(np.isfinite(values))):
        raise SceneError(option, f"{path.name!r} must hold finite numbers only")
    if at[0] <= 0.0 or np.any(np.diff(at) <= 0.0):
        raise SceneError(option, f"{path.name!r} must have rising frequencies above 0 Hz")
    return NetworkData(name=path.name, frequency=at, scattering=values, reference=own)
