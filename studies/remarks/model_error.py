"""The effects that the model of one run neglects, each with a closed-form estimate of its size, and their sum.

The numerical error does not contain them. The estimates hold to a factor of about 2. They are made by `stator_effects`,
`ball_effects` and `loaded_wave_effects`; these yield nothing if an effect does not arise or if the model includes it.
"""

import math
from collections.abc import Iterable
from dataclasses import replace

from studies.record import Record
from studies.record.blocks import Effect, ErrorBlock
from studies.record.point import Point
from studies.record.text import percent
from studies.remarks.ball_effects import OVERTONES, loads_on_wave, radiation, travel_over_ripple
from studies.remarks.ball_surface import AT_LARGEST, ball_surface, ball_surface_at
from studies.remarks.loaded_wave_effects import effects_at_points
from studies.remarks.plane_effects import across, spin
from studies.remarks.stator_effects import AMPLITUDE, heating, large_strain, stator_effects
from studies.solve.solved_stator import contact_of_run

SHARED = (AMPLITUDE, "velocity")  # quantities at the slider whose relative changes add up to the model error
NO_ANSWER = 1.0  # smallest relative change for which the answer is refused


def model_error(record: Record) -> tuple[Effect, ...]:
    """Return the neglected effects of a run with a driven stator or a prescribed wave, as in run.json.

    An effect that depends on the level has its largest size over the points, or for a slider on pillars and for the
    surfaces of balls its size at the largest level.
    """
    return tuple(_largest(record, *_effects(record)))


def on_passing_wave(record: Record) -> bool:
    """Whether the slider of a run stands on waves that pass below it."""
    return record.scene.slider is not None and contact_of_run(record).passing


def _effects(record: Record) -> tuple[tuple[Effect, ...], list[tuple[Effect, ...]], bool]:
    """Return the effects that do not depend on the level, for each point those that do, and `on_passing_wave`."""
    always: list[tuple] = []
    at_points: list[list[tuple]] = [[] for _ in record.points]
    passing = on_passing_wave(record)
    if passing:
        at_points = effects_at_points(record)
    if record.surface_wave is not None:
        of_contacts, loads = ([], at_points) if passing else (radiation(record), loads_on_wave(record))
        always = [*stator_effects(record), *of_contacts, *heating(record)]
        at_points = [list(each) for each in loads]
        for own, point in zip(at_points, record.points, strict=True):
            own += [*travel_over_ripple(record, point), *large_strain(record, point.level)]
    elif record.scene.wave is not None:
        for own, point in zip(at_points, record.points, strict=True):
            own += large_strain(record, point.level)
    always += [*ball_surface(record), *spin(record), *across(record)]
    for own, point in zip(at_points, record.points, strict=True):
        own += ball_surface_at(record, point)
    return _finite(always), [_finite(own) for own in at_points], passing


def _finite(effects: list[tuple]) -> tuple[Effect, ...]:
    found = (Effect(**dict(zip(Effect.__annotations__, values, strict=False))) for values in effects)
    return tuple(each for each in found if math.isfinite(each.size))


def _largest(record: Record, always: tuple, at_points: list[tuple], passing: bool) -> list[Effect]:
    """Return each effect once, with the size that `model_error` states."""
    levels = [point.level for point in record.points]
    last = at_points[levels.index(max(levels))] if levels else ()
    if passing:
        of_points = last
    else:
        everywhere = (each for own in at_points for each in own if each.effect not in AT_LARGEST)
        of_points = (
            *(each for each in last if each.effect in AT_LARGEST),
            *sorted(everywhere, key=lambda each: abs(each.size)),
        )
    return [*{each.effect: each for each in of_points}.values(), *always]


def _total(effects: Iterable[Effect], quantity: str) -> float:
    return sum(abs(each.size) for each in effects if each.quantity == quantity)


def with_model_error(record: Record) -> Record:
    """Return the record with its model error.

    The effects on u_z and on the velocity are added as if they all had the same sign. The ``model_relative_error`` of
    a point is the change of the velocity plus the change of u_z times ``amplitude_sensitivity`` (the relative change
    of the velocity divided by the relative change of the wave amplitude), with the sizes at that point. If one effect
    is as large as the quantity itself, the answer is refused: the record gets a shortfall.
    """
    always, at_points, passing = _effects(record)
    largest = _largest(record, always, at_points, passing)
    if not largest:
        return record
    points = []
    for point, own in zip(record.points, at_points, strict=True):
        if point.amplitude_sensitivity is not None:
            u_z, velocity = (_total(always + own, quantity) for quantity in SHARED)
            point |= Point(model_relative_error=float(velocity + u_z * point.amplitude_sensitivity))
        points.append(point)
    model = sum(_total(largest, quantity) for quantity in SHARED)
    error = record.error | ErrorBlock(model=model if record.error else None)
    shortfall, refused = record.shortfall, record.refused
    # the size of the overtones is a first-order upper bound, which causes only a warning
    decisive = [each for each in largest if each.quantity in SHARED and each.effect != OVERTONES]
    worst = max(decisive, key=lambda each: abs(each.size), default=None)
    if worst is not None and abs(worst.size) >= NO_ANSWER and not refused:  # an earlier reason is kept
        refused = True
        shortfall = (
            f"no answer: a neglected effect changes {worst.quantity} by about {percent(worst.size)} "
            f"({worst.effect}); {100 * NO_ANSWER:g} % or more is refused"
        )
    return replace(
        record, model_error=tuple(largest), points=tuple(points), error=error, shortfall=shortfall, refused=refused
    )
