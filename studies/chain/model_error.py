"""The effects that the model of one run neglects, each with a closed-form estimate of its size, and their sum.

The numerical error does not contain them. An effect is (effect, quantity, size, source): its size is relative to the
quantity named with it, unless a fifth entry states a unit. The estimates hold to a factor of about 2. Those of the
stator, of balls and of pillars are made by `stator_effects`, `ball_effects` and `pillar_effects`; they yield nothing
if an effect does not arise or if the model includes it.
"""

import math
from dataclasses import replace

from studies.chain.ball_effects import loads_on_wave, radiation, travel_over_ripple
from studies.chain.stator_effects import heating, large_strain, stator_effects
from studies.record import Record
from studies.record.text import percent

SHARED = ("u_z", "velocity")  # quantities at the slider whose relative changes add up to the model error
NO_ANSWER = 1.0  # smallest relative change for which the answer is refused
# A first-order upper bound, which causes only a warning
NEVER_DECISIVE = ("overtones of the wave under the pillars",)
# Keys of an effect in run.json: name, changed quantity, relative change (with a unit: change in that), source, unit
KEYS = ("effect", "quantity", "size", "source", "unit")


def model_error(record: Record) -> tuple[dict, ...]:
    """Return the neglected effects of a run with a driven stator, as in run.json.

    An effect that depends on the level has its largest size over the points, or for a slider on pillars its size at the
    largest level.
    """
    return _table(record, *_effects(record))


def _effects(record: Record) -> tuple[tuple, list[tuple]]:
    """Return the effects that do not depend on the level, and for each point those that do."""
    always: list[tuple] = []
    at_points: list[list[tuple]] = [[] for _ in record.points]
    if record.scene.on_pillars:
        from studies.chain.pillar_effects import pillar_rows

        at_points = pillar_rows(record)
    if record.surface_wave is not None:
        always = [*stator_effects(record), *radiation(record), *heating(record)]
        for rows, point, loads in zip(at_points, record.points, loads_on_wave(record), strict=True):
            rows += [*loads, *travel_over_ripple(record, point), *large_strain(record, point[record.level])]
    return _finite(always), [_finite(rows) for rows in at_points]


def _finite(rows: list[tuple]) -> tuple:
    return tuple(row for row in rows if math.isfinite(row[2]))


def _table(record: Record, always: tuple, at_points: list[tuple]) -> tuple[dict, ...]:
    if record.scene.on_pillars:
        of_points = list(max(zip(record.points, at_points, strict=True), key=lambda each: each[0][record.level])[1])
    else:
        of_points = sorted((row for rows in at_points for row in rows), key=lambda row: abs(row[2]))
    largest = {row[0]: row for row in of_points}
    return tuple(dict(zip(KEYS, row, strict=False)) for row in (*largest.values(), *always))


def with_model_error(record: Record) -> Record:
    """Return the record with its model error.

    The effects on u_z and on the velocity are added as if they all had the same sign. The ``model_relative_error`` of
    a point is the change of the velocity plus the change of u_z times ``amplitude_sensitivity`` (the relative change
    of the velocity divided by the relative change of the wave amplitude), with the sizes at that point. If one effect
    is as large as the quantity itself, the answer is refused: the record gets a shortfall.
    """
    always, at_points = _effects(record)
    rows = _table(record, always, at_points)
    if not rows:
        return record

    def share(quantity: str, rows) -> float:
        return sum(abs(size) for _, changed, size, *_ in rows if changed == quantity)

    points = []
    for point, own in zip(record.points, at_points, strict=True):
        if "amplitude_sensitivity" in point:
            velocity, u_z = share("velocity", always + own), share("u_z", always + own)
            point = point | {"model_relative_error": float(velocity + u_z * point["amplitude_sensitivity"])}
        points.append(point)
    shares = {quantity: share(quantity, (row.values() for row in rows)) for quantity in SHARED}
    error = record.error | ({"model": sum(shares.values())} if record.error else {})
    decisive = [
        row
        for row in rows
        if row["quantity"] in SHARED and abs(row["size"]) >= NO_ANSWER and row["effect"] not in NEVER_DECISIVE
    ]
    shortfall = record.shortfall
    if decisive and not record.refused:  # an earlier reason, such as a node of the wave, is kept
        worst = max(decisive, key=lambda row: abs(row["size"]))
        shortfall = (
            f"no answer: a neglected effect changes {worst['quantity']} by about {percent(worst['size'])} "
            f"({worst['effect']}); {100 * NO_ANSWER:g} % or more is refused"
        )
    refused = record.refused or bool(decisive)
    return replace(record, model_error=rows, points=tuple(points), error=error, shortfall=shortfall, refused=refused)
