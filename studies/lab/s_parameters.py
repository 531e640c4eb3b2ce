"""S-parameters over frequency that a network analyser has measured."""

from dataclasses import dataclass, field, replace

import numpy as np

from studies.lab.waves import scattering
from studies.refusal import refuse_if

PASSIVE = 1e-9  # largest singular value of S, less 1, from which on it is remarked: rounding lies below


@dataclass(frozen=True, kw_only=True)
class NetworkData:
    """Measured S-parameters."""

    name: str  # of the file
    frequency: np.ndarray = field(repr=False)  # Hz, rising, shape (n,)
    scattering: np.ndarray = field(repr=False)  # complex, shape (n, ports, ports)
    reference: float  # impedance in ohm
    measured: np.ndarray | None = field(default=None, repr=False)  # of each element, shape (ports, ports); None: all
    remarks: tuple[str, ...] = ()  # on the reading of the file, for the user

    @property
    def ports(self) -> int:
        """Number of ports."""
        return self.scattering.shape[1]

    @property
    def elements(self) -> np.ndarray:
        """Whether each element of the matrix was measured, shape (ports, ports)."""
        return np.ones((self.ports, self.ports), bool) if self.measured is None else self.measured

    @property
    def complete(self) -> bool:
        """True if all elements of the matrix were measured."""
        return bool(np.all(self.elements))

    @property
    def coordinate(self) -> np.ndarray:
        """Frequency in Hz of each real part in `flat`."""
        return np.repeat(self.frequency, np.count_nonzero(self.elements))

    @property
    def admittance(self) -> np.ndarray:
        """Admittance matrix in S, (n, ports, ports)."""
        one = np.eye(self.ports)
        return np.linalg.solve(one + self.scattering, one - self.scattering) / self.reference

    def flat(self, values: np.ndarray | None = None) -> np.ndarray:
        """Return the measured elements, or those of other S-parameters, as real numbers: real parts, then imaginary."""
        chosen = (self.scattering if values is None else values)[:, self.elements]
        return np.concatenate([chosen.real.ravel(), chosen.imag.ravel()])

    def at(self, kept: np.ndarray) -> "NetworkData":
        """Return the data at some of its frequencies."""
        return replace(self, frequency=self.frequency[kept], scattering=self.scattering[kept])

    def within(self, low: float, high: float, option: str = "--band") -> "NetworkData":
        """Return the data at its frequencies from ``low`` to ``high`` in Hz; SceneError if there are none."""
        kept = (self.frequency >= low * (1 - 1e-12)) & (self.frequency <= high * (1 + 1e-12))
        own = f"{self.frequency[0] / 1e6:.6g} to {self.frequency[-1] / 1e6:.6g} MHz"
        refuse_if(not np.any(kept), option, f"must meet the frequencies of {self.name!r}, {own}")
        if np.all(kept):
            return self
        remark = f"{np.count_nonzero(kept)} of its {len(kept)} frequencies lie within --band"
        return replace(self.at(kept), remarks=(*self.remarks, remark))

    def one_port(self, number: int, option: str = "--port") -> "NetworkData":
        """Return the reflection at a port, counted from 1, with the others at the reference impedance."""
        refuse_if(
            not 1 <= number <= self.ports,
            option,
            f"must be one of the {self.ports} ports of {self.name!r}, got {number}",
        )
        at = number - 1
        refuse_if(
            not self.elements[at, at],
            option,
            f"must be a measured port of {self.name!r}, and S{number}{number} was not measured",
        )
        others = "" if self.ports == 1 else f", the others at {self.reference:g} ohm"
        chosen = self.scattering[:, at : at + 1, at : at + 1]
        return replace(
            self, scattering=chosen, measured=None,
            remarks=(*self.remarks, f"port {number} of {self.ports} is taken{others}"),
        )  # fmt: skip

    def with_reference(self, reference: float, option: str = "--z0") -> "NetworkData":
        """Return the data with another real reference impedance in ohm."""
        if reference == self.reference:
            return self
        rule = f"{self.name!r} has the reference {self.reference:g} ohm and elements that were not measured"
        refuse_if(not self.complete, option, f"must be {self.reference:g}: {rule}")
        ports = np.full(self.scattering.shape[:2], self.reference)
        remark = f"its reference of {self.reference:g} ohm is changed to {reference:g} ohm"
        return replace(
            self, scattering=scattering("s", self.scattering, reference, ports), reference=reference,
            remarks=(*self.remarks, remark),
        )  # fmt: skip


def gains(data: NetworkData) -> tuple[str, ...]:
    """Return a remark on S-parameters by which more power comes out than goes in; none if there are none."""
    values = np.where(data.elements, data.scattering, 0.0)
    gain = np.linalg.svd(values, compute_uv=False)[:, 0]
    worst = int(np.argmax(gain))
    if gain[worst] <= 1.0 + PASSIVE:
        return ()
    count = int(np.count_nonzero(gain > 1.0 + PASSIVE))
    where = f"{data.frequency[worst] / 1e6:.6g} MHz"
    return (
        f"more power comes out than goes in at {count} of {len(gain)} frequencies: the largest singular value of S is "
        f"{gain[worst]:.6g}, at {where}, and at most 1 is possible; is the calibration right?",
    )
