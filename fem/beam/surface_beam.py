"""Surface beam: motion of the surface in three dimensions, by the charges on fingers of finite length and by forces.

The fingers end at y = +-W/2, and motions are per volt of the source.  The charge of a finger is a sum of sheets, each
uniform over |y| < L_b / 2 (electrode_charges.py), whose waves add up, also between and under the fingers, because
massless fingers scatter by their charges alone (beam_of_charges.py).  In a solid isotropic about z with absorbing ends
there is one sheet over the whole aperture and several shorter ones, whose charges follow from the mean potentials over
the fingers (own_aperture.py, reception.py).  In other cuts and between reflecting ends the charge is that of the
section, uniform along y.  Free and clamped ends add the waves that they reflect at each k_y (faces.py).  On the axis
y = 0, u_y vanishes by symmetry.

Limits: the field is not resolved within a wavelength of the fingers' ends, because evanescent modes with a shorter
range are cut off at the edge of the aperture.  A strongly coupled plate mode near its cut-off changes the charge all
along short fingers (tests/fem/beam/test_volume.py).  In other cuts a transducer scatters the waves of a force as in
the section, times the mean of the force's beam over its aperture; forces need absorbing ends.
"""

import sys
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from fem.beam.beam_of_charges import AT_POINTS, IN_PICTURES, Agreement, ChargeSheet, EmittedBeam, Emitter, Strip
from fem.beam.electrode_charges import ElectrodeCharges, all_charges
from fem.beam.faces import Faces
from fem.beam.lateral import EVANESCENT, RULES, Points, inverse_transform
from fem.beam.line_source import ModeSource
from fem.beam.own_aperture import STEPS, sheet_lengths
from fem.beam.reception import with_apertures
from fem.circuit import Circuit
from fem.geometry import on_stator
from fem.parameters import refuses
from fem.results.driven_answer import SurfaceWave
from fem.results.power_balance import PowerBalance, power_balance
from fem.results.stator_solution import Solution

# The charge along a finger is a sum of steps (sheets of several lengths).  Its error over the change that fewer steps
# make: with the finest steps (measured: 0.2 to 0.4, test_finger_ends.py), and where a limit has left fewer (rms over 24
# points of five layouts on PZT-8 and PZT-4, 6 to 30 finger pairs of 15 and 20 wavelengths, against 22 steps: 0.5 to
# 1.6, at single points 2.4).
COARSER_SHARE, FEWER_SHARE = 0.5, 2.0
# Offsets along y, in half Fresnel lengths, at which that change is taken; the first is the point itself.
NEIGHBOURS = (0.0, -1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0)
# Part of the error that more steps do not reduce, because the charge across a finger is that of the section up to its
# ends: relative to the largest |u_z| at NEIGHBOURS, and in periods over the aperture.  Measured against boundary
# elements in three dimensions on PZT-8 (tests/validation/test_finite_fingers.py): 0.12 % rms of the section's |u_z|
# with 20 wavelengths; 0.0087 periods with 1.5 and 0.0066 with 5.  Where a limit has left fewer steps, those nearest to
# the ends are missing in all that are compared: up to 0.15 periods with 5 and 0.25 with 9 (test_reception.py).
ACROSS_SHARE, END_PERIODS, FEWER_END_PERIODS = 0.0015, 0.01, 0.1
# Part of the section's amplitude to which its error is at least relative.  At 144 points of twente and twente-left the
# error exceeds twice its estimate as often with 0.5 as with 1 (8 and 4 %, beside fingers and in minima), and more often
# with 0 (9 and 6 %); the truth is the solution two levels finer.
SECTION_SHARE = 0.5
TINY = 1e-300  # avoids division by zero


class BeamError(ValueError):
    """Raised for a stator whose field in three dimensions is not covered; the message says why."""


@dataclass(frozen=True, kw_only=True)
class SurfaceBeam:
    """Surface motion in three dimensions.

    Attributes
    ----------
    wave : SurfaceWave
        Solution of the section.
    solution : Solution
        Voltages and currents if each transducer receives the mean of the beams over its aperture.
    source : ModeSource
        Response of the bare stator to a line of charge; without transducers to the first force.
    charges : tuple of ElectrodeCharges
        One per transducer, from left to right.
    apertures, centers : tuple of float
        Length and centre of the fingers of each transducer along y, m.
    strips : tuple of Strip
        Forces, each with the response of the bare stator to it.
    scattering_error : float
        Relative error of the waves that transducers send in answer to forces.
    agreement : Agreement
        Of two rules for the integral over k_y, at which no finer one is taken.
    received_error : float
        Error of the currents that forces send into transducers at a voltage of zero, over the largest of them.
    mirror_width : float or None
        Distance in m of two side faces that reflect like mirrors; None if the sides do not reflect.
    complete : bool
        True: within a wavelength of the charges the part of the section's motion that no mode represents is added
        (`_local`).  False: only the modes of ``source`` are summed.
    faces : Faces or None
        Free or clamped ends; None if the ends absorb.

    Examples
    --------
    >>> beam = surface_beam(wave)  # doctest: +SKIP
    >>> u_x, u_y, u_z = beam.motion(0.08, 0.0)  # doctest: +SKIP
    """

    wave: SurfaceWave
    solution: Solution = field(repr=False)
    source: ModeSource = field(repr=False)
    charges: tuple[ElectrodeCharges, ...] = field(repr=False)
    apertures: tuple[float, ...]
    centers: tuple[float, ...]
    mirror_width: float | None = None
    complete: bool = True
    faces: Faces | None = field(default=None, repr=False)
    strips: tuple[Strip, ...] = ()
    scattering_error: float = 0.0
    received_error: float = 0.0
    agreement: Agreement = AT_POINTS

    def motion(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """u_x, u_y and u_z in m per V, or in m under forces.

        Parameters
        ----------
        x, y : float or ndarray
            Distances in m from the stator's left end and from its middle line, broadcast against each other.  Many
            points at few different x, or on a grid, cost little more than a few points.

        Returns
        -------
        ndarray, shape (3, *shape of x and y)

        Raises
        ------
        BeamError
            If a point lies outside the stator.
        """
        return self.motion_by_rules(x, y)[0]

    def relative_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """Estimate of the error over max(|u_x|, |u_z|) at each point.

        It is the sum of three errors.

        1. The error of the integral over k_y.  The rules with a half and a quarter of the nodes differ from the full
           rule by e_2 and e_4, and the error is estimated as e_2^2 / e_4.  This is right if errors are a power of the
           node spacing, do not depend on it or, with e_4 near 1, fall exponentially.  In cuts where the integral ends
           before all waves are evanescent along x, the change by an earlier end is added.
        2. The error of the section's solution.  It is relative to the amplitude in the section, which can be larger
           than the amplitude of the beam where waves interfere: the larger of the beam's amplitude and SECTION_SHARE
           of the section's is taken.
        3. The part of the section's motion that the sum of modes at k_y = 0 does not represent.  Within a wavelength of
           the fingers this part is added to the field over the width of the aperture.
        """
        return self.motion_and_error(x, y)[1]

    def motion_and_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0):
        """`motion`, (3, *shape), and `relative_error`, (*shape), which lists the three errors added here."""
        fine, half, quarter, narrow = self.motion_by_rules(x, y)
        size = abs(fine[[0, 2]]).max(axis=0)
        largest = float(size.max())
        # 1. e_2^2 / e_4.  e_4 is raised to e_2, which bounds the estimate by e_2, and limited to 1: if a quarter of the
        # nodes is far too few, a huge e_4 must not make the estimate small.
        e_2, e_4 = (abs(fine - coarser).max(axis=0) / largest for coarser in (half, quarter))
        of_rule = e_2**2 / np.clip(e_4, np.maximum(e_2, TINY), 1.0) * largest / size
        of_rule = of_rule + abs(fine - narrow).max(axis=0) / size  # an earlier end of the integral
        if self.faces is not None:  # the static part of the reflection depends on |k_y|
            x_of_points, y_of_points = (each.ravel() for each in np.broadcast_arrays(x, y))
            static = self._reflected(self.faces, x_of_points, y_of_points, self.faces.static)
            of_rule = of_rule + abs(static[0, 0]).reshape(size.shape) / size
        # 2. and 3. in m, computed once for each distinct x
        positions, where = np.unique(np.broadcast_to(x, size.shape), return_inverse=True)
        at_positions = (self.wave.motion(positions), self.motion_beyond_modes(positions))
        section, beyond_modes = (abs(each).max(axis=0)[where.reshape(size.shape)] for each in at_positions)
        beyond_modes = np.maximum(beyond_modes, self.source.error * section)
        if self.strips:  # transducers receive less than in the section, where beams do not spread
            spread = self._spread(np.broadcast_to(x, size.shape))
            section, beyond_modes = section * spread, beyond_modes * spread
            beyond_modes = beyond_modes + self._error_of_forces(np.broadcast_to(x, size.shape), y, size)
        of_section = np.maximum(size, SECTION_SHARE * section) * self.wave.relative_error
        return fine, of_rule + (of_section + beyond_modes) / size

    @property
    def length(self) -> float:
        """Length of the surface, m."""
        return self.wave.length

    def in_section(self, x: float, y: float) -> float:
        """Coordinate x in m, in the section `wave`, of a point (x, y) in m."""
        return x

    @property
    def circuit(self) -> Circuit:
        """Voltages and currents of the circuit for this motion."""
        return self.solution.circuit

    @cached_property
    def power(self) -> PowerBalance:
        """Power balance of the waves averaged over the apertures.

        Raises
        ------
        BeamError
            Under forces: the motion below a strip that gives its power is not resolved.
        """
        if self.strips:
            raise BeamError("the power balance of forces on strips is not computed; that of `fem.forced_wave` is")
        if self.solution.fields is self.wave.solution.fields:
            return self.wave.power
        return power_balance(self.solution)

    @cached_property
    def coarser(self) -> "SurfaceBeam | None":
        """The same beam with fewer steps of the charge along the fingers; None if the charge is uniform."""
        steps = [len(each.steps) for each in self.charges]
        if not any(steps):
            return None
        fields = self.wave.solution.fields
        for fineness in range(1, len(STEPS)):
            fewer = with_apertures(fields, self.mirror_width, fineness)
            solution = replace(self.solution, fields=fewer)
            beam = replace(self, solution=solution, charges=all_charges(solution))
            if [len(each.steps) for each in beam.charges] != steps:
                return beam
        return None

    @property
    def _finest(self) -> bool:
        """True if no limit of the solution has left fewer steps along the fingers than there are."""
        each = zip(self.charges, self.solution.fields.transducers, strict=True)
        return all(len(own.steps) + 1 == len(sheet_lengths(transducer, most=sys.maxsize)) for own, transducer in each)

    def charge_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray | None:
        """Relative error of |u_z| by the approximate charge of the fingers: along them, and across them at their ends.

        Along a finger the charge is a sum of steps, whose error is estimated from the change by taking fewer.  The
        change oscillates along y, and can vanish at a point by chance: the estimate takes the larger of the change at
        the point and its root mean square over NEIGHBOURS, points beside it within half the Fresnel length (wavelength
        times distance)^(1/2).  It bounds the difference from 100 steps in transducers on PZT
        (tests/fem/beam/test_finger_ends.py).  Added to it is the error that more steps do not reduce (ACROSS_SHARE,
        END_PERIODS).  None if the charge is uniform along the fingers.
        """
        if self.coarser is None:
            return None
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        reach = np.sqrt(self.wavelength * self._emitted.distances(x.ravel())).reshape(x.shape) / 2
        beside = y + np.multiply.outer(NEIGHBOURS, reach)
        if self.mirror_width is not None:
            beside = np.clip(beside, -self.mirror_width / 2, self.mirror_width / 2)
        along = np.broadcast_to(x, beside.shape)
        fewer, all_steps = (abs(beam.motion(along, beside)[2]) for beam in (self.coarser, self))
        change = abs(fewer - all_steps)
        share, periods = (COARSER_SHARE, END_PERIODS) if self._finest else (FEWER_SHARE, FEWER_END_PERIODS)
        ends = periods * max(each.period / each.aperture for each in self.solution.fields.transducers)
        steps = share * np.maximum(change[0], np.sqrt(np.mean(change**2, axis=0)))
        return (steps + ACROSS_SHARE * all_steps.max(axis=0)) / all_steps[0] + ends

    def unresolved(self, x: float, y: float) -> bool:
        """True for a point (m) beside fingers or within a wavelength of their ends, in other cuts (`CutSource`).

        The field lacks the waves that leave at more than 45 degrees there, and `relative_error` does not include them.
        On YZ lithium niobate they are 0.06 to 6 times the motion, and 0.01 of it a wavelength or more before the
        fingers.
        """
        near = abs(self.wavelength)
        transducers = self.solution.fields.transducers
        beside = [(*each.extent, each.center_y, each.aperture) for each in transducers]
        sheets = [strip.sheet for strip in self.strips]
        beside += [(sheet.x[0], sheet.x[0], sheet.center, sheet.length) for sheet in sheets]
        return self.source.omits_oblique and any(
            start - near < x < stop + near and abs(y - center) > length / 2 - near
            for start, stop, center, length in beside
        )

    def with_side_faces(self, width: float | None) -> "SurfaceBeam":
        """Beam of the same charges between mirrors ``width`` (m) apart, or without mirrors if None."""
        return replace(self, mirror_width=width)

    def with_longer_fingers(self, periods: float) -> "SurfaceBeam":
        """The same charges per length on fingers that are longer at both ends by a number of periods."""
        longer = (each.aperture + 2 * periods * each.period for each in self.solution.fields.transducers)
        return replace(self, apertures=tuple(longer))

    @property
    def surface_mode(self) -> "SurfaceBeam":
        """The same beam with the field of the surface wave alone."""
        faces = self.faces and self.faces.surface_mode
        strips = tuple(each._replace(source=each.source.surface_mode) for each in self.strips)
        return replace(self, source=self.source.surface_mode, complete=False, faces=faces, strips=strips)

    def surface_wavenumbers(self, lateral: np.ndarray) -> np.ndarray:
        """Slowness curve: complex wavenumber along x of the surface wave at real lateral wavenumbers, rad/m.

        Its slope at 0 is minus the tangent of the power-flow angle; -k times its second derivative at 0 is 1 + gamma,
        gamma the anisotropy parameter of the diffraction.
        """
        return self.source.surface_wavenumbers(np.asarray(lateral, dtype=float))

    @cached_property
    def _sheets(self) -> list[ChargeSheet]:
        """Charge sheets of all transducers, from left to right."""
        each = zip(self.charges, self.apertures, self.centers, strict=True)
        return [sheet for charges, aperture, center in each for sheet in charges.sheets(aperture, center)]

    @cached_property
    def emitters(self) -> list[Emitter]:
        """Sources of waves: the charges of all transducers, if there are any, then each force."""
        return self._emitting(self._sheets)

    @property
    def pictured(self) -> "SurfaceBeam":
        """The same beam for a picture: to 2 % of the largest motion beside fingers, and better elsewhere."""
        return replace(self, agreement=IN_PICTURES)

    @cached_property
    def _emitted(self) -> EmittedBeam:
        """Waves of all charges and forces, without those that the ends reflect."""
        return EmittedBeam(self.emitters, self.wavelength, self.mirror_width, self.agreement)

    @cached_property
    def _section_emitters(self) -> list[Emitter]:
        """`emitters` with the charges of the section, uniform along y: one sheet for each transducer."""
        each = zip(self._section_charges, self.apertures, self.centers, strict=True)
        uniform = [replace(charges, steps=()).sheets(aperture, center)[0] for charges, aperture, center in each]
        return self._emitting(uniform)

    def _emitting(self, sheets: list[ChargeSheet]) -> list[Emitter]:
        charges = [Emitter(self.source, sheets)] if sheets else []
        return charges + [Emitter(each.source, [each.sheet]) for each in self.strips]

    @cached_property
    def _section_charges(self) -> tuple[ElectrodeCharges, ...]:
        return all_charges(self.wave.solution)

    def motion_by_rules(self, x, y) -> tuple[np.ndarray, ...]:
        """Motion by all RULES of the integral over k_y: all nodes, half, a quarter, and an earlier end."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        shape, x, y = x.shape, x.ravel(), y.ravel()
        self._refuse(x, y)
        total = self._emitted.by_rules(x, y)
        near = self._emitted.near(x)
        if self.complete and near.any():
            total[..., near] += self._local(x[near], y[near])
        if self.faces is not None:
            total += self._reflected(self.faces, x, y, self.faces.included)
        return tuple(total.reshape(RULES, 3, *shape))

    @refuses(BeamError)
    def _refuse(self, x, y):
        if rule := on_stator(x, self.wave.length):
            yield f"x {rule}"
        limit = np.inf if self.mirror_width is None else self.mirror_width / 2
        if not np.all(np.isfinite(y) & (abs(y) <= limit)):
            yield f"y must be finite and lie between the side faces, +-{limit:g} m"

    def _reflected(self, faces: Faces, x, y, modes: np.ndarray) -> np.ndarray:
        """Motion of the waves that the end faces reflect, in some modes, shape (RULES, 3, points)."""
        points = Points.of(x, y)
        reflected = faces.reflected(self._emitted.reach(y), self._sheets, self.mirror_width)
        spectra = partial(reflected.spectra, points.x, self.wave.length, modes=modes)
        return inverse_transform(reflected, self._sheets, points, spectra, self.mirror_width is None)

    def _local(self, x, y) -> np.ndarray:
        """Part of the section's motion beyond the modes, within the width of the nearest emitter, (3, points).

        Under forces it is that of the forces alone: a transducer receives less than in the section, where beams do not
        spread.
        """
        positions, column = np.unique(x, return_inverse=True)
        sheets = [sheet for emitter in self._section_emitters for sheet in emitter.sheets]
        distances = np.array([abs(np.subtract.outer(positions, sheet.x)).min(axis=1) for sheet in sheets])
        nearest = distances.argmin(axis=0)[column]  # number of the nearest sheet to each point
        lengths, centers = (np.array([getattr(each, key) for each in sheets])[nearest] for key in ("length", "center"))
        within = abs(y - centers) < lengths / 2
        if self.strips:
            within &= nearest >= len(self.charges)  # the sheets of the forces follow those of the charges
        all_axes = np.insert(self.motion_beyond_modes(positions), 1, 0.0, axis=0)  # with u_y = 0
        return all_axes[:, column] * within

    def _error_of_forces(self, x: np.ndarray, y, size: np.ndarray) -> np.ndarray:
        """Errors in m by the waves that transducers scatter, and by the evanescent waves that end near a strip."""
        near = np.min([abs(x - each.sheet.x[0]) for each in self.strips], axis=0)
        error = size * np.exp(-EVANESCENT[0] * near / abs(self.wavelength))
        if self.charges:
            scattered = replace(self, strips=(), complete=False)
            error = error + self.scattering_error * abs(scattered.motion(x, y)).max(axis=0)
        return error

    def _spread(self, x: np.ndarray) -> np.ndarray:
        """Ratio of a strip's beam to its wave in the section: width over (wavelength times distance)^1/2, at most 1."""
        wavelength = abs(self.wavelength)
        ratios = []
        for sheet in (each.sheet for each in self.strips):
            distance = abs(x - sheet.x[0])
            spread = sheet.length / np.sqrt(wavelength * np.maximum(distance, wavelength))
            ratios.append(np.where(distance < wavelength, 1.0, spread))
        return np.minimum(np.max(ratios, axis=0), 1.0)

    def motion_beyond_modes(self, positions) -> np.ndarray:
        """Motion of the section at ``positions`` (m) minus that of the modes at k_y = 0 by the same charges.

        Shape (2, positions): u_x and u_z in m. It measures what the modes of the beam leave out.
        """
        remainder = self.wave.motion(positions)
        for emitter in self._section_emitters:
            remainder -= emitter.plane_waves(positions, self.wavelength).T[[0, 2]]
        if self.faces is not None:
            plane = self.faces.plane(self._section_emitters[0].sheets)
            ones = np.ones((len(self.apertures), 1))
            remainder -= plane.spectra(positions, self.wave.length, ones, self.faces.included)[..., 0].T[[0, 2]]
        if self.charges:  # the pole at k = 0: u_x = +-static times the charge, + to the right of it
            charges = self._section_emitters[0]
            left_of = np.append(0.0, np.cumsum(charges.charge))[np.searchsorted(charges.x, positions, side="right")]
            remainder[0] -= self.source.static * (2 * left_of - charges.charge.sum())
        return remainder

    @property
    def wavelength(self) -> float:
        """Wavelength of the surface wave, m."""
        return self.wave.phase_velocity / self.wave.frequency
