"""A transducer's admittance as a circuit: static capacitance and motional branches, for circuit simulators.

    Y = i omega C0 + 1/R0 + sum_k 1 / (R_k + i omega L_k + 1 / (i omega C_k))

With one branch it is the Butterworth-Van Dyke circuit (Van Dyke, Proc. IRE 16, 1928, 742), which has the main resonance
but not the sidelobes of a transducer; a few branches represent the whole passband (Foster's sum of resonances, with
losses).  The fit minimises the sum of |Y - Y_fitted|^2 over the frequencies.  Its unknowns are the logarithms of C0,
1/R0, 1/R_k and R_k/L_k, and the resonance frequencies themselves.  The elements therefore stay positive and the circuit
passive.
"""

from dataclasses import dataclass, field

import numpy as np

# Initial resonances of several branches cover this many widths at half maximum to both sides of the peak.  Each start
# may lead to another local minimum; the best one is kept.
SPREADS = (1.0, 1.5)


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
        Number of series branches R, L, C.

    Returns
    -------
    MotionalModel

    Raises
    ------
    ValueError
        If the conductance is positive at no frequency: no circuit of positive elements has such an admittance.
    """
    from scipy.optimize import least_squares

    if not np.max(np.real(admittance)) > 0.0:
        raise ValueError("the conductance must be positive at some frequency")
    fit = _Fit(np.asarray(frequency, dtype=float), np.asarray(admittance, dtype=complex))
    y, fits = fit.admittance, []
    # Start: C0 from the median of Im Y, 1/R0 = 1e-3 of the largest |Y|, and branches spread evenly about the peak that
    # share its conductance; R/L is smaller the more branches there are.
    for spread in SPREADS if branches > 1 else (0.0,):
        start = [np.log(abs(np.median(y.imag))), np.log(1e-3 * fit.scale)]
        for offset in np.linspace(-spread, spread, branches):
            start += [np.log(y.real.max() / branches), offset, np.log(1.0 / branches)]
        fits.append(least_squares(fit.residual, start, jac=fit.jacobian, method="trf", max_nfev=400))
    best = min(fits, key=lambda each: each.cost)
    static, leak, peak, resonance, rate = fit.parts(best.x)
    inductance = 1 / (peak * rate)
    return MotionalModel(
        capacitance=float(static / (2 * np.pi * fit.middle)),
        resistance=float(1 / leak),
        branches=np.stack([1 / peak, inductance, 1 / (inductance * resonance**2)], axis=1),
        limits=(float(fit.frequency[0]), float(fit.frequency[-1])),
        error=float(np.hypot(*best.fun.reshape(2, -1)).max()),
    )


class _Fit:
    """Residual of a circuit of one static capacitance and motional branches, and its derivatives.

    The unknowns are the logarithms of omega C0 at the peak of the conductance and of 1/R0 (S), then three per branch:
    logarithm of 1/R (S), offset of the resonance from that peak, counted in widths of the peak at half its maximum, and
    logarithm of R/L over the width in rad/s.
    """

    def __init__(self, frequency: np.ndarray, admittance: np.ndarray):
        self.frequency, self.admittance = frequency, admittance  # Hz, S
        self.omega, self.scale = 2 * np.pi * frequency, abs(admittance).max()
        self.middle = float(frequency[np.argmax(admittance.real)])
        self.width = _width_at_half_maximum(frequency, admittance.real)

    def parts(self, parameters: np.ndarray):
        """Return (omega C0, 1/R0, 1/R, omega_r, R/L): the first three in S, omega_r and R/L in rad/s.

        The last three are arrays over the branches; omega_r = 1/sqrt(L C) is a branch's resonance.
        """
        static, leak = np.exp(parameters[:2])
        peak, rate = np.exp(parameters[2::3]), 2 * np.pi * self.width * np.exp(parameters[4::3])
        return static, leak, peak, 2 * np.pi * (self.middle + parameters[3::3] * self.width), rate

    def terms(self, parameters: np.ndarray) -> np.ndarray:
        """Terms of Y and their derivatives by the parameters, shape (2 + 3 branches, frequencies).

        A branch is Y_k = peak / (1 + i q), with peak = 1/R and q = (omega - omega_r^2 / omega) / (R/L).  C0, 1/R0 and
        the peak enter by their logarithms, so that the derivative of each of these terms by its own logarithm is the
        term itself.
        """
        static, leak, peak, resonance, rate = (np.reshape(each, (-1, 1)) for each in self.parts(parameters))
        q = (self.omega - resonance**2 / self.omega) / rate
        branch = peak / (1 + 1j * q)
        # d q / d log(R/L) = -q; `q_by_offset` is d q / d(offset), the offset of the resonance counted in widths
        by_q = -1j * branch / (1 + 1j * q)
        q_by_offset = -2 * resonance / (self.omega * rate) * 2 * np.pi * self.width
        terms = np.stack([branch, by_q * q_by_offset, -by_q * q], axis=1).reshape(-1, len(self.omega))
        capacitive = 1j * self.omega * static / (2 * np.pi * self.middle)
        return np.concatenate([capacitive, leak + 0j * self.frequency, terms])

    def residual(self, parameters: np.ndarray) -> np.ndarray:
        terms = self.terms(parameters)
        difference = (terms[0] + terms[1] + terms[2::3].sum(axis=0) - self.admittance) / self.scale
        return np.concatenate([difference.real, difference.imag])

    def jacobian(self, parameters: np.ndarray) -> np.ndarray:
        terms = self.terms(parameters).T / self.scale
        return np.concatenate([terms.real, terms.imag])


def _width_at_half_maximum(frequency: np.ndarray, conductance: np.ndarray) -> float:
    """Return the width in Hz over which the conductance exceeds half of its largest value."""
    above = np.flatnonzero(conductance > conductance.max() / 2)
    step = float(np.mean(np.diff(frequency)))
    return max(float(frequency[above[-1]] - frequency[above[0]]), step)
