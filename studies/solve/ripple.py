"""Steady velocity of a slider over half a wavelength about its position: mean over place, lowest and highest value.

Where waves from both sides meet, as from a transducer that reflects, the amplitude and with it the steady velocity
depend on the place, with a period of half a wavelength. The velocity of one position is then not that of a motor that
travels. The contact is solved at places along the interval, each as if the slider stayed there, on the surface motion
that is known there (`nearby_motion`). The interval is halved until a polynomial through the velocities agrees with one
through every second of them.

The mean is over place. The mean over time of a slider that is slow enough to take the velocity of each place is the
harmonic mean, which is lower; a heavy slider, which keeps its velocity over half a wavelength, lies near the mean over
place.
"""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

import contact
from studies.model.scene_errors import slider_keys
from studies.model.wave_to_contact import Contact, scaled
from studies.record.blocks import SummaryBlock
from studies.record.point import Point
from studies.solve import chebyshev
from studies.solve.averaged_states import AveragedState, averaged_states
from studies.solve.nearby_motion import NearbyMotion
from studies.solve.point_answer import SliderAnswer
from studies.solve.refinement import SHARE
from studies.solve.slider_burst import STEADY_METHODS, method_of

PLACES = 17  # velocities in an interval, of which every second makes the polynomial of comparison
# Where averaging does not apply, each place needs the motion itself: its places are taken until the polynomials agree
EXACT_PLACES = (9, 17, 33)
# Where averaging misses its share of the tolerance, every fourth of PLACES is solved exactly, or every second
CORRECTED = (4, 2)
HALVINGS = 5  # of the interval, to 1/64 wavelength; the velocity has kinks where the slider begins to stick
DRAWN = 129  # places of the polynomial at which its extremes are looked for; they miss 1e-4 of a ripple of one period
MAX_UNKNOWN = 4  # of PLACES without an averaged state that are solved one by one


@dataclass(frozen=True, kw_only=True)
class Ripple:
    """Steady velocity over half a wavelength about a position, m/s along +x."""

    mean: float  # over place
    lowest: float  # algebraically smallest: of a slider that runs to -x the fastest
    highest: float
    mean_over_time: float | None  # of a slider that takes the velocity of each place; None if it stops at one
    error: float  # of the mean and of both ends

    @property
    def range(self) -> float:
        """Highest less lowest velocity, m/s."""
        return self.highest - self.lowest

    def point(self, reference: float, from_wave: float = 0.0) -> Point:
        """Return the ripple as values of a point.

        ``reference``: speed in m/s of its error; ``from_wave``: further error over that speed.
        """
        return Point(
            mean_velocity_m_per_s=self.mean, lowest_velocity_m_per_s=self.lowest,
            highest_velocity_m_per_s=self.highest, mean_velocity_relative_error=self.error / reference + from_wave,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class NearbyContact:
    """A slider that is moved along x from its position by less than a quarter of a wavelength."""

    driven: Contact = field(repr=False)
    motions: tuple[NearbyMotion, ...] = field(repr=False)  # about each ball
    low: float  # displacements in m between which all of them are known
    high: float
    tolerance: float

    @classmethod
    def of(cls, driven: Contact, tolerance: float) -> "NearbyContact | None":
        """Return the contact about the slider's position; None where no motion about a ball is known."""
        if driven.solved is None:
            return None
        balls = [driven.solved.at[position].nearby for position in driven.scene.slider.contact_positions]
        motions = tuple(each for each in balls if each is not None)
        low, high = max((each.low for each in motions), default=0.0), min((each.high for each in motions), default=0.0)
        if len(motions) < len(balls) or not high > low:
            return None
        return cls(driven=driven, motions=motions, low=low, high=high, tolerance=tolerance)

    def orbits(self, displacements) -> list[tuple[tuple, float]]:
        """Return the orbits of 1 V and the largest relative error of the balls, at each displacement in m."""
        frequency, balls = self.driven.orbits[0].frequency, [each.at(displacements) for each in self.motions]

        def orbit(u_x, u_z):
            return contact.Orbit(frequency=frequency, tangential=complex(u_x), normal=complex(u_z))

        return [
            (tuple(orbit(u_x[k], u_z[k]) for u_x, u_z, _ in balls), float(max(error[k] for *_, error in balls)))
            for k in range(len(displacements))
        ]

    def exact(self, orbits: tuple, level: float) -> tuple[float, float]:
        """Return the velocity of the motion itself in m/s and its error, at a level."""
        method = method_of(self.driven.scene, "the steady state", STEADY_METHODS)
        with slider_keys():
            state = contact.steady(
                self.driven.slider, scaled(orbits, level), tolerance=SHARE * self.tolerance, method=method
            )
        return state.velocity, state.answer.error


class Known(NamedTuple):
    """What is known of the slider at its position, at a level."""

    velocity: float  # m/s
    stator_factor: float  # relative error of the velocity by the stator over that of the surface motion


def with_ripple(answer: SliderAnswer, tolerance: float) -> SliderAnswer:
    """Return the answer of a slider on balls with mean and range of its points, and the ripple in its summary.

    The columns are added if the range exceeds the tolerance at one point or more.
    """
    driven = answer.driven
    nearby, answered = NearbyContact.of(driven, tolerance), [each for each in answer.answers if each.point.answered]
    if nearby is None or not answered:
        return answer
    error = driven.stator_error or 1.0
    known = {each.point.level: Known(each.point.velocity_m_per_s, each.from_stator / error) for each in answered}
    found, sizes, answers = ripples(nearby, known), [], []
    for each in answer.answers:
        ripple = found.get(each.point.level) if each.point.answered else None
        if ripple is not None:
            point, size = ripple_point(ripple, driven.at(each.point.level))
            sizes.append(size)
            each = replace(each, point=each.point | point)
        answers.append(each)
    if not sizes:
        return answer
    center = driven.scene.slider.center[0]
    summary = answer.summary | SummaryBlock(
        velocity_ripple=max(sizes), ripple_from_m=center + nearby.low, ripple_to_m=center + nearby.high
    )
    return replace(answer, answers=tuple(answers) if max(sizes) > tolerance else answer.answers, summary=summary)


def ripple_point(ripple: Ripple, orbits: tuple) -> tuple[Point, float]:
    """Return the ripple as values of a point with these orbits at its position, and its range over the speed of these.

    That speed is the reference of the error.
    """
    reference = contact.reference_speed(ripple.mean, orbits) or 1.0
    return ripple.point(reference), ripple.range / reference


def ripples(nearby: NearbyContact, known: dict[float, Known]) -> dict[float, Ripple]:
    """Return the ripple at each level at which the slider's motion at its position is known.

    A level is absent if the contact has no answer at one of the places.
    """
    searches = [_Search(nearby, level, each) for level, each in known.items() if level > 0.0]
    waiting = [(search, nearby.low, nearby.high) for search in searches]
    for _ in range(HALVINGS + 1):
        waiting = _halved(nearby, waiting)
    rest = Ripple(mean=0.0, lowest=0.0, highest=0.0, mean_over_time=None, error=0.0)
    return {search.level: search.ripple() for search in searches if not search.failed} | (
        {0.0: rest} if 0.0 in known else {}
    )


def _halved(nearby: NearbyContact, waiting: list[tuple]) -> list[tuple]:
    """Solve the contact in each waiting interval of a search, and return the halves of those that are too wide."""
    inside = 0.5 * (1.0 + chebyshev.points(PLACES))
    orbits = {(low, high): nearby.orbits(low + (high - low) * inside) for _, low, high in waiting}
    slider = nearby.driven.slider
    contacts = [
        (slider, balls, error, search.level) for search, *ends in waiting for balls, error in orbits[tuple(ends)]
    ]
    states, halves = averaged_states(contacts) if contacts else [], []
    for k, (search, low, high) in enumerate(waiting):
        try:
            wide = search.take(low, high, orbits[low, high], states[k * PLACES : (k + 1) * PLACES])
        except contact.ConvergenceError:
            search.failed = True
            continue
        if wide and not search.failed:
            middle = 0.5 * (low + high)
            halves += [(search, low, middle), (search, middle, high)]
    return halves


class _Piece(NamedTuple):
    """Velocities at the Chebyshev points of an interval."""

    width: float  # m
    velocity: np.ndarray  # m/s
    error: np.ndarray  # by contact and stator, m/s
    misfit: float  # largest distance from the polynomial through every second velocity, m/s


class _Search:
    """The velocities about the slider's position at one level."""

    def __init__(self, nearby: NearbyContact, level: float, known: Known) -> None:
        self.nearby, self.level, self.known = nearby, level, known
        self.scale = contact.reference_speed(known.velocity, nearby.driven.at(level))
        self.failed = False
        self._narrowest = (nearby.high - nearby.low) / 2**HALVINGS
        self._pieces: list[_Piece] = []
        # exact less averaged velocity at Chebyshev points of the whole interval, m/s, and the error of its polynomial
        self._correction, self._correction_error = np.zeros(3), 0.0

    def take(self, low: float, high: float, orbits: list[tuple[tuple, float]], states: list[AveragedState]) -> bool:
        """Add the averaged states in an interval; return True, without adding them, if it must be halved."""
        allowed = SHARE * self.nearby.tolerance * self.scale
        unknown = [k for k, state in enumerate(states) if state.regime == "unknown"]
        whole = (low, high) == (self.nearby.low, self.nearby.high)
        if whole and len(unknown) > MAX_UNKNOWN:
            self._take_exactly(allowed)
            return False
        speeds = [
            contact.reference_speed(state.velocity, scaled(balls, self.level))
            for (balls, _), state in zip(orbits, states, strict=True)
        ]
        velocity, of_contact, of_stator = np.array(
            [(state.velocity, state.from_contact, state.from_stator) for state in states], dtype=float
        ).T
        of_contact, of_stator = of_contact * speeds, of_stator * speeds
        if whole and not unknown and of_contact.max() > allowed:
            self._correct(orbits, velocity, allowed)
        if self._correction.any():
            places = (np.array([low, high]) - self.nearby.low) / (self.nearby.high - self.nearby.low)
            inside = 2.0 * (places[0] + np.ptp(places) * 0.5 * (1.0 + chebyshev.points(PLACES))) - 1.0
            velocity = velocity + chebyshev.interpolation(self._correction.size, inside) @ self._correction
            of_contact = np.full(PLACES, self._correction_error)
        error = of_contact + of_stator
        for k in unknown:
            velocity[k], error[k] = self._exact(*orbits[k])
        if _misfit(velocity) > allowed and high - low > 1.001 * self._narrowest:
            return True
        self._add(high - low, velocity, error)
        return False

    def _add(self, width: float, velocity: np.ndarray, error: np.ndarray) -> None:
        self._pieces.append(_Piece(width, velocity, error, _misfit(velocity)))

    def _take_exactly(self, allowed: float) -> None:
        """Add the velocities of the motion itself over the whole interval; ``allowed``: misfit in m/s."""
        low, high = self.nearby.low, self.nearby.high
        most = EXACT_PLACES[-1]
        orbits = self.nearby.orbits(low + (high - low) * 0.5 * (1.0 + chebyshev.points(most)))
        solved: dict[int, tuple[float, float]] = {}
        for count in EXACT_PLACES:
            chosen = range(0, most, (most - 1) // (count - 1))
            solved |= {k: self._exact(*orbits[k]) for k in chosen if k not in solved}
            velocity, error = np.transpose([solved[k] for k in chosen])
            if _misfit(velocity) <= allowed:
                break
        self._add(high - low, velocity, error)

    def _exact(self, orbits: tuple, error: float) -> tuple[float, float]:
        """Return the velocity of the motion itself in m/s, and its error by contact and stator."""
        velocity, of_contact = self.nearby.exact(orbits, self.level)
        speed = contact.reference_speed(velocity, scaled(orbits, self.level))
        return velocity, of_contact + self.known.stator_factor * error * speed

    def _correct(self, orbits: list[tuple[tuple, float]], velocity: np.ndarray, allowed: float) -> None:
        """Compare the averaged velocities of the whole interval with exact ones at some places."""
        solved: dict[int, tuple[float, float]] = {}
        for step in CORRECTED:
            chosen = range(0, PLACES, step)
            solved |= {k: self.nearby.exact(orbits[k][0], self.level) for k in chosen if k not in solved}
            exact, errors = np.transpose([solved[k] for k in chosen])
            self._correction = exact - velocity[::step]
            self._correction_error = _misfit(self._correction) + errors.max()
            if self._correction_error <= allowed:
                break

    def ripple(self) -> Ripple:
        """Return mean, range and error of all intervals."""
        widths = np.array([each.width for each in self._pieces])
        shares = widths / widths.sum()
        means = [chebyshev.weights(each.velocity.size) @ each.velocity for each in self._pieces]
        drawn = np.concatenate([_drawn(each.velocity) for each in self._pieces])
        all_places = np.concatenate([each.velocity for each in self._pieces])
        # a polynomial overshoots where the slider begins to stick: no place has another direction than those solved
        if not np.any(all_places > 0.0):
            drawn = np.minimum(drawn, 0.0)
        if not np.any(all_places < 0.0):
            drawn = np.maximum(drawn, 0.0)
        moving = bool(np.all(all_places > 0.0) or np.all(all_places < 0.0))
        inverse = [chebyshev.weights(each.velocity.size) @ (1.0 / each.velocity) for each in self._pieces if moving]
        return Ripple(
            mean=float(shares @ means), lowest=float(drawn.min()), highest=float(drawn.max()),
            mean_over_time=float(1.0 / (shares @ inverse)) if moving else None,
            error=float(max(each.misfit + each.error.max() for each in self._pieces)),
        )  # fmt: skip


def _misfit(values: np.ndarray) -> float:
    """Return the largest distance of values at Chebyshev points from the polynomial through every second of them."""
    count = values.size
    return float(
        np.abs(chebyshev.interpolation((count + 1) // 2, chebyshev.points(count)) @ values[::2] - values).max()
    )


def _drawn(values: np.ndarray) -> np.ndarray:
    """Return values at Chebyshev points, and values of the polynomial between them."""
    return np.append(values, chebyshev.interpolation(values.size, np.linspace(-1.0, 1.0, DRAWN)) @ values)
