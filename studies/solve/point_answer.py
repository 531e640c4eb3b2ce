"""The answer at one level of the drive: the point of a record, and what is no column of it."""

from dataclasses import dataclass, field
from typing import Any

from studies.model.wave_to_contact import Contact
from studies.record.blocks import ErrorBlock, SummaryBlock
from studies.record.point import Point
from studies.record.status import Status
from studies.record.values import Columns


@dataclass(frozen=True, kw_only=True)
class PointAnswer:
    """The answer at one level."""

    point: Point  # only the status if there is no answer
    # parts of the velocity's error, over its reference speed
    from_stator: float = 0.0
    from_contact: float = 0.0
    trajectory: Any = field(default=None, repr=False)  # of a burst
    motion: Any = field(default=None, repr=False)  # contact.SteadyState
    averaged: bool = False  # True where the steady state is an averaged one
    thrust: float | None = None  # blocked thrust of one of the equal parts of a slider, N; of averaged states
    refused: bool = False  # True where the scene was refused


@dataclass(frozen=True, kw_only=True)
class SliderAnswer:
    """The answers of a motor at one or more levels."""

    answers: tuple[PointAnswer, ...]
    driven: Contact | Any = field(default=None, repr=False)  # that gave them; None where there is none
    summary: SummaryBlock = field(default_factory=SummaryBlock)  # threshold, release and ripple
    pillars: Columns = field(default_factory=Columns)  # columns of pillars.csv
    slider_wave: Columns = field(default_factory=Columns)  # columns of slider_wave.csv

    @property
    def answered(self) -> bool:
        """Whether one of the levels has an answer."""
        return any(each.point.answered for each in self.answers)

    @property
    def points(self) -> tuple[Point, ...]:
        """The points of the record."""
        return tuple(each.point for each in self.answers)

    @property
    def trajectories(self) -> tuple[tuple[float, Any], ...]:
        """Level and motion of each burst."""
        return tuple((each.point.level, each.trajectory) for each in self.answers if each.trajectory is not None)

    @property
    def error(self) -> ErrorBlock:
        """Error of the worst point and its parts; empty without an answer."""
        answered = [each for each in self.answers if each.point.answered]
        if not answered:
            return ErrorBlock()
        worst = max(answered, key=lambda each: each.from_stator + each.from_contact)
        parts = {"stator": worst.from_stator, "contact": worst.from_contact}
        return ErrorBlock(relative=worst.from_stator + worst.from_contact, parts=parts)

    def shortfall(self, tolerance: float) -> str:
        """Return why these are no answers within a tolerance; empty if they are."""
        failed = [each.point for each in self.answers if not each.point.answered]
        if failed:
            why = Status.reason_in(failed[0].status)
            return f"{len(failed)} of {len(self.answers)} points have no answer: {why}"
        error = self.error
        if error.relative is None or error.relative <= tolerance:
            return ""
        stator, contact = error.parts["stator"], error.parts["contact"]
        wider = ", or give a larger tolerance" if error.relative < 1.0 else ""  # a tolerance is below 1
        return (
            f"the velocity's error is {error.relative:.1e} (stator {stator:.1e}, contact {contact:.1e}), "
            f"{tolerance:.1e} was asked for: see error.parts{wider}"
        )
