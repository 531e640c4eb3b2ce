"""A network analyser's file: S-parameters over frequency (Touchstone 1, `fem.read_touchstone`)."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import fem
from studies.refusal import SceneError

TOUCHSTONE = re.compile(r"\.s(?P<ports>\d+)p", re.IGNORECASE)


@dataclass(frozen=True, kw_only=True)
class NetworkData:
    """S-parameters as measured.

    Attributes
    ----------
    name : str
        Of the file.
    frequency : ndarray, shape (n,)
        Hz, rising.
    scattering : ndarray, shape (n, ports, ports)
        Complex.
    reference : float
        Impedance in ohm.
    """

    name: str
    frequency: np.ndarray = field(repr=False)
    scattering: np.ndarray = field(repr=False)
    reference: float

    @property
    def ports(self) -> int:
        """Number of ports."""
        return self.scattering.shape[1]

    @property
    def coordinate(self) -> np.ndarray:
        """Frequency of each number of `flat`, of the real parts alone."""
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
        If it cannot be read, is no such file, or its frequencies do not rise.
    """
    ports = TOUCHSTONE.fullmatch(path.suffix)
    if ports is None:
        raise SceneError(option, f"must be a Touchstone file, .s1p, .s2p ..., got {path.name!r}")
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise SceneError(option, f"{str(path)!r} cannot be read: {error.strerror}") from None
    try:
        at, values, own = fem.read_touchstone(text, int(ports["ports"]))
    except fem.InputError as error:
        raise SceneError(option, f"{path.name!r} {error.rule}") from None
    if not (np.all(np.isfinite(at)) and np.all(np.isfinite(values))):
        raise SceneError(option, f"{path.name!r} must hold finite numbers only")
    if at[0] <= 0.0 or np.any(np.diff(at) <= 0.0):
        raise SceneError(option, f"{path.name!r} must have rising frequencies above 0 Hz")
    return NetworkData(name=path.name, frequency=at, scattering=values, reference=own)
