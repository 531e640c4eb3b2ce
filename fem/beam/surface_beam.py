"""Surface motion in three dimensions of a stator whose fingers end at y = +-W/2, per volt of the source.

The charge on the fingers is that of the section within the aperture and zero beyond.  For every lateral wavenumber the
bare stator's response to it is a sum of guided modes (line_source.py), so that at x to the right of a transducer

    u(x, y) = int dk_y / 2 pi  W sinc(k_y W / 2) exp(-i k_y y) sum_p a_p(k_y) T(kappa_p) exp(-i kappa_p (x - x_0)),

T the charges' transform, taken at kappa_p.  The contributions of all transducers add up: massless fingers scatter by
their charges alone.

On the axis y = 0, u_y vanishes by symmetry.

Left out: the charge near the ends of the fingers, which counts as some 0.07 periods more aperture at each; side faces;
that a passive transducer's charges follow the mean of the wave over its aperture - 0.89 to 0.96 of the section's for
20 wavelengths - and not the section's wave: an error of that share of what it sends back.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.beam.charges import ElectrodeCharges, electrode_charges
from fem.beam.lateral import LateralRule, lateral_rule
from fem.beam.line_source import LineSource, isotropic_about_normal, line_source
from fem.geometry import Stator
from fem.results.surface_wave import SurfaceWave

NEAREST = 0.5  # wavelengths from the fingers, within which the field is not given
KEPT = 1e-12  # share of a mode's amplitude that must be left at the nearest point for it to count
RULE_GAIN = 1.5  # power of the coarse rule's error that bounds the fine one's; 1.8 measured, 2 in theory
STATIC_CHUNK = 2000  # points at a time whose distances to all nodes are tabulated


class BeamError(ValueError):
    """A stator whose field in three dimensions is not covered, and why."""


@dataclass(frozen=True, kw_only=True)
class SurfaceBeam:
    """Surface motion in three dimensions.

    Attributes
    ----------
    wave : SurfaceWave
        Of the section, whose charges these are.
    source : LineSource
    charges : tuple of ElectrodeCharges
        Of each transducer from left to right.
    apertures : tuple of float
        m.

    Examples
    --------
    >>> beam = surface_beam(wave)  # doctest: +SKIP
    >>> u_x, u_y, u_z = beam.motion(0.08, 0.0)  # doctest: +SKIP
    """

    wave: SurfaceWave
    source: LineSource = field(repr=False)
    charges: tuple[ElectrodeCharges, ...] = field(repr=False)
    apertures: tuple[float, ...]

    def motion(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """u_x, u_y and u_z in m per V.

        Parameters
        ----------
        x, y : float or ndarray
            m from the stator's left end and from the middle of the apertures; broadcast against each other.

        Returns
        -------
        ndarray, shape (3, *shape of x and y)

        Raises
        ------
        BeamError
            Within half a wavelength of the fingers, where the modes do not converge.
        """
        return self._both_rules(x, y)[0]

    def relative_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """Estimate of the error over max(|u_x|, |u_z|) at each point: the integral's, and the section's.

        The integral's follows from half as many nodes.  The section's error is relative to the section's amplitude,
        which interference may make larger than the beam's.
        """
        fine, coarse = self._both_rules(x, y)
        size = abs(fine[[0, 2]]).max(axis=0)
        largest = float(size.max())
        rule = (abs(fine - coarse).max(axis=0) / largest) ** RULE_GAIN * largest / size
        section = abs(self.wave.motion(np.broadcast_arrays(x, y)[0])).max(axis=0)
        return rule + self.wave.relative_error * np.maximum(1.0, section / size)

    def _both_rules(self, x, y) -> tuple[np.ndarray, np.ndarray]:
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        flat = x.ravel(), y.ravel()
        self._refuse(*flat)
        total = np.zeros((2, 3, x.size), dtype=complex)
        for charges, aperture in zip(self.charges, self.apertures, strict=True):
            for side in (1, -1):
                edge = charges.x[-1] if side > 0 else charges.x[0]
                beyond = side * (flat[0] - edge) > 0
                if beyond.any():
                    total[..., beyond] += self._sent(
                        charges, aperture, side, *(each[beyond] for each in flat)
                    )
        return tuple(total.reshape(2, 3, *x.shape))

    def _refuse(self, x, y):
        if not np.all(np.isfinite(y)):
            raise BeamError("y must be finite")
        length, near = self.wave.length, NEAREST * self.wave.phase_velocity / self.wave.frequency
        if not np.all((x >= 0) & (x <= length)):
            raise BeamError(f"x must lie on the stator, 0 to {length:g} m")
        for charges in self.charges:
            inside = (x > charges.x[0] - near) & (x < charges.x[-1] + near)
            if inside.any():
                raise BeamError(
                    f"x = {x[inside][0]:g} m lies under a transducer or within half a wavelength, {near:.3g} m, of its "
                    "fingers: the field in three dimensions is not known there"
                )

    def _sent(self, charges, aperture: float, side: int, x, y) -> np.ndarray:
        """Motion that one transducer sends to one side, by the rule and by every second node, (2, 3, points)."""
        edge = charges.x[-1] if side > 0 else charges.x[0]
        along = side * (x - edge)
        source, reach = self.source, aperture / 2 + abs(y).max()
        modes = source.lasting(along.min(), KEPT)
        rule = lateral_rule(float(np.sqrt((source.wavenumbers[modes] ** 2).real.max())), reach, along.min())
        total = np.zeros((2, 3, len(x)), dtype=complex)
        backward = source.wavenumbers[modes].real < 0
        for chosen, contour, sign in ((modes[~backward], rule, 1), (modes[backward], rule.conjugate, -1)):
            if len(chosen):
                sent = _Spectrum(source, chosen, contour, sign, charges, aperture, edge, side)
                total += sent.motion(along, y)
        total += _static(source, charges, aperture, side, x, y)
        total[:, 0] *= side
        return total


class _Spectrum:
    """Amplitudes of some modes over k_y, of one transducer to one side; x -> -x turns the sign of u_x alone."""

    def __init__(self, source, chosen, rule: LateralRule, sign, charges, aperture, edge, side):
        wavenumbers = source.wavenumbers[chosen, None]
        self.lateral = rule.nodes
        self.along = sign * np.sqrt(wavenumbers**2 - rule.nodes**2)
        weights = rule.weights * aperture * np.sinc(rule.nodes * aperture / (2 * np.pi))
        common = weights * charges.transform(side * self.along, edge)
        tangential = source.tangential[chosen, None] * common
        self.shares = np.stack(
            [
                tangential,
                tangential * (rule.nodes / self.along),
                source.normal[chosen, None] * (wavenumbers / self.along) * common,
            ]
        )

    def motion(self, along, y) -> np.ndarray:
        """Sum over modes and k_y, by all nodes and by every second one, shape (2, 3, points)."""
        out = np.empty((2, 3, len(along)), dtype=complex)
        places, where = np.unique(along, return_inverse=True)
        for number, place in enumerate(places):
            here = np.flatnonzero(where == number)
            spectrum = np.sum(self.shares * np.exp(-1j * self.along * place), axis=1)
            angles = np.outer(self.lateral, y[here])
            even, odd = np.cos(angles), -1j * np.sin(angles)
            for coarse, step in ((0, 1), (1, 2)):
                some = step * spectrum[:, ::step]
                out[coarse][:, here] = some @ even[::step]
                out[coarse, 1, here] = some[1] @ odd[::step]
        return out


def _static(source, charges, aperture, side, x, y) -> np.ndarray:
    """Near field of the pole at k = 0, where kappa = -i |k_y|, in closed form, shape (3, points).

    The integral over k_y of a node at a distance X is a Laplace transform: with b = W/2 +- y, sum of arctan(b / X) / pi
    for u_x and difference of log(X^2 + b^2) / 2 pi for u_y.
    """
    out = np.zeros((3, len(x)), dtype=complex)
    if source.static == 0:
        return out
    for start in range(0, len(x), STATIC_CHUNK):
        some = slice(start, start + STATIC_CHUNK)
        distance = side * np.subtract.outer(x[some], charges.x)
        above, below = (aperture / 2 + sign * y[some, None] for sign in (1, -1))
        inward = np.arctan2(above, distance) + np.arctan2(below, distance)
        sideways = 0.5 * np.log((distance**2 + above**2) / (distance**2 + below**2))
        out[0, some] = inward @ charges.charge
        out[1, some] = sideways @ charges.charge
    return out * (source.static / np.pi)


def beam_refusal(stator: Stator) -> str:
    """Why the field in three dimensions of a stator is not known, in a sentence; empty where it is."""
    if stator.ends != "absorbing":
        return f"the field in three dimensions needs stator.ends = 'absorbing', got {stator.ends!r}"
    if not isotropic_about_normal(stator.solid):
        return (
            f"the field in three dimensions needs a solid isotropic about z, which {stator.solid.name} is not"
        )
    return ""


def surface_beam(wave: SurfaceWave) -> SurfaceBeam:
    """Field in three dimensions of a driven stator, from the section's solution.

    Parameters
    ----------
    wave : SurfaceWave
        Of `fem.driven_wave`, ends absorbing, the solid isotropic about z.

    Returns
    -------
    SurfaceBeam

    Raises
    ------
    BeamError
        For other cuts and ends.
    """
    solution = wave.solution
    refusal = beam_refusal(solution.fields.stator)
    if refusal:
        raise BeamError(refusal)
    transducers = solution.fields.transducers
    return SurfaceBeam(
        wave=wave,
        source=line_source(solution.fields.modes),
        charges=tuple(electrode_charges(solution, index) for index in range(len(transducers))),
        apertures=tuple(each.aperture for each in transducers),
    )
