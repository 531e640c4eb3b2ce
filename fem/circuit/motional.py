"""A transducer's admittance as a circuit: static capacitance and motional branches, for circuit simulators.

    Y = i omega C0 + 1/R0 + sum_k 1 / (R_k + i omega L_k + 1 / (i omega C_k))

With one branch it is the Butterworth-Van Dyke circuit (Van Dyke, Proc. IRE 16, 1928, 742), which has the resonance but
not the sidelobes of a row of fingers; a few branches follow the whole passband (Foster's sum of resonances, with
losses).  Elements are fitted by least squares of |Y - Y_fitted|, in logarithms, so that they stay positive and the
circuit passive.
"""

from dataclasses import dataclass, field

import numpy as np

SPREADS = (
    1.0,
    1.5,
)  # half widths about the middle over which the branches start; each may end in a minimum of its own


@dataclass(frozen=True, kw_only=True)
class MotionalModel:
    """Elements of a transducer's circuit; make it with `motional_model`.

    Attributes
    ----------
    capacitance : float
        C0 in F.
    resistance : float
        R0 in ohm, across C0.
    branches : ndarray, shape (n, 3)
        R in ohm, L in H and C in F of each series branch.
    limits : tuple of float
        Band of the fit, Hz.
    error : float
        Largest |Y - Y_fitted| over the largest |Y| in the band.
    """

    capacitance: float
    resistance: float
    branches: np.ndarray = field(repr=False)
    limits: tuple[float, float]
    error: float

    def admittance(self, frequency: np.ndarray) -> np.ndarray:
        """Y in S at frequencies in Hz."""
        omega = 2 * np.pi * np.asarray(frequency, dtype=float)
        series = [r + 1j * omega * inductance + 1 / (1j * omega * c) for r, inductance, c in self.branches]
        return 1j * omega * self.capacitance + 1 / self.resistance + sum(1 / each for each in series)

    def spice(self, name: str) -> str:
        """Return the SPICE subcircuit of two terminals, p and n."""
        low, high = (limit / 1e6 for limit in self.limits)
        lines = [
            f"* valid from {low:.6g} to {high:.6g} MHz: largest error {self.error:.2g} of the largest admittance",
            f".subckt {name} p n",
            f"C0 p n {self.capacitance:.9e}",
            f"R0 p n {self.resistance:.9e}",
        ]
        for k, (r, inductance, c) in enumerate(self.branches, start=1):
            lines += [f"R{k} p a{k} {r:.9e}", f"L{k} a{k} b{k} {inductance:.9e}", f"C{k} b{k} n {c:.9e}"]
        return "\n".join([*lines, f".ends {name}"]) + "\n"


def motional_model(frequency: np.ndarray, admittance: np.ndarray, branches: int = 1) -> MotionalModel:
    """Fit a static capacitance and motional branches to an admittance over a band.

    Parameters
    ----------
    frequency : ndarray, shape (n,)
        Hz, rising.
    admittance : ndarray, shape (n,)
        S.
    branches : int

    Returns
    -------
    MotionalModel
    """
    from scipy.optimize import least_squares

    f, y = np.asarray(frequency, dtype=float), np.asarray(admittance, dtype=complex)
    omega, scale, middle = 2 * np.pi * f, abs(y).max(), float(f[np.argmax(y.real)])
    width = _half_width(f, y.real)

    def parts(parameters: np.ndarray):
        """Static capacitance's and leak's admittances at the middle; conductance, place and rate of each branch."""
        static, across = np.exp(parameters[:2])
        peak, rate = np.exp(parameters[2::3]), 2 * np.pi * width * np.exp(parameters[4::3])
        return static, across, peak, 2 * np.pi * (middle + parameters[3::3] * width), rate

    def columns(parameters: np.ndarray) -> np.ndarray:
        """Y as a sum, and its derivatives: shape (2 + 3 branches, frequencies); a branch is peak / (1 + i q)."""
        static, across, peak, resonance, rate = (np.reshape(each, (-1, 1)) for each in parts(parameters))
        q = (omega - resonance**2 / omega) / rate
        one = peak / (1 + 1j * q)
        steep = -1j * one / (1 + 1j * q)  # dY/dq
        moved = -2 * resonance / (omega * rate) * 2 * np.pi * width
        branches = np.stack([one, steep * moved, -steep * q], axis=1).reshape(-1, len(f))
        return np.concatenate([1j * omega * static / (2 * np.pi * middle), across + 0j * f, branches])

    def residual(parameters: np.ndarray) -> np.ndarray:
        own = columns(parameters)
        apart = (own[0] + own[1] + own[2::3].sum(axis=0) - y) / scale
        return np.concatenate([apart.real, apart.imag])

    def slope(parameters: np.ndarray) -> np.ndarray:
        own = columns(parameters).T / scale
        return np.concatenate([own.real, own.imag])

    tries = []
    for spread in SPREADS if branches > 1 else (0.0,):
        start = [np.log(abs(np.median(y.imag))), np.log(1e-3 * scale)]
        for place in np.linspace(-spread, spread, branches):
            start += [np.log(y.real.max() / branches), place, np.log(1.0 / branches)]
        tries.append(least_squares(residual, start, jac=slope, method="trf", max_nfev=400))
    found = min(tries, key=lambda each: each.cost)
    static, across, peak, resonance, rate = parts(found.x)
    inductance = 1 / (peak * rate)
    return MotionalModel(
        capacitance=float(static / (2 * np.pi * middle)),
        resistance=float(1 / across),
        branches=np.stack([1 / peak, inductance, 1 / (inductance * resonance**2)], axis=1),
        limits=(float(f[0]), float(f[-1])),
        error=float(np.hypot(*found.fun.reshape(2, -1)).max()),
    )


def _half_width(frequency: np.ndarray, conductance: np.ndarray) -> float:
    """Return the width in Hz over which the conductance exceeds half of its largest value."""
    above = np.flatnonzero(conductance > conductance.max() / 2)
    step = float(np.mean(np.diff(frequency)))
    return max(float(frequency[above[-1]] - frequency[above[0]]), step)
