"""The few numbers of a solved stator that contacts and answers need; many scenes share one solution."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import contact
from studies.model.model import model_of
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.solve.nearby_motion import NearbyMotion, nearby_motions
from studies.solve.surface_motion import SurfaceMotion

COARSE_ERROR = 0.05  # relative error of the coarsest discretisation, which has no own estimate; 1.7 to 4.5 % measured


class LocalMotion(NamedTuple):
    """Motion of the surface at one position, per volt of the source."""

    tangential: complex  # u_x, m per V
    normal: complex  # u_z, m per V
    relative_error: float
    covered: bool  # whether it lies under a transducer
    refusal: str  # why the motion there is no answer; empty where it is one
    nearby: NearbyMotion | None = None  # about the position; None where it was not evaluated, or lies at an end
    lateral: complex = 0.0  # u_y, m per V

    @property
    def amplitudes(self) -> tuple[float, float]:
        """|u_z| and |u_x|, m per V."""
        return abs(self.normal), abs(self.tangential)


@dataclass(frozen=True, kw_only=True)
class SolvedStator:
    """Motion at some positions and admittance of a solved stator, per volt of the source."""

    at: dict[tuple[float, float], LocalMotion]  # by position (x, y) in m
    section_error: float  # relative, of the section alone; that of a beam is larger
    goal: float  # that the section was solved to
    frequency: float  # Hz
    admittance: complex  # S
    power: float  # mean, from all sources into the stator, of all frequencies, W per V^2
    currents: dict[str, complex]  # into the positive electrode of each transducer, A per V

    @classmethod
    def of(
        cls, motion: SurfaceMotion, positions, *, goal: float = 0.0, coarse: bool = False, nearby: bool = False
    ) -> "SolvedStator":
        """Evaluate a surface motion at positions (x, y) in m.

        ``goal``: of the section; ``coarse``: it is that of the coarsest discretisation; ``nearby``: also about
        each position.
        """
        components = motion.at(positions).T
        errors = [COARSE_ERROR] * len(positions) if coarse else motion.errors(positions)
        about = nearby_motions(motion, positions) if nearby else [None] * len(positions)
        at = {}
        for position, (u_x, u_y, u_z), error, near in zip(positions, components, errors, about, strict=True):
            covered, refusal = motion.covered(position), motion.unresolved([position])
            at[position] = LocalMotion(complex(u_x), complex(u_z), float(error), covered, refusal, near, complex(u_y))
        return cls(
            at=at, section_error=float(motion.wave.relative_error), goal=goal, frequency=float(motion.wave.frequency),
            admittance=motion.circuit.admittance, power=motion.circuit.power,
            currents=dict(zip(motion.circuit.names, motion.circuit.currents.tolist(), strict=True)),
        )  # fmt: skip

    def orbits(self, positions) -> tuple:
        """Return the contact.Orbit of 1 V at some of the positions."""
        return tuple(
            contact.Orbit(frequency=self.frequency, tangential=each.tangential, normal=each.normal)
            for each in (self.at[position] for position in positions)
        )


def contact_of_run(record: Record) -> Contact:
    """Return the contact of a run that has a slider."""
    model, motion = model_of(record.scene), record.surface_motion
    if record.scene.wave is not None:
        return Contact.prescribed(model, record)
    driven = Contact.of_stator(model, SolvedStator.of(motion, record.scene.positions), lambda: motion)
    if record.scene.planar:
        from studies.solve.plane_surface import surface_of_run

        driven = replace(driven, surface=surface_of_run(record))
    return replace(driven, stator_error=float(record.wave.relative_error), record=record)
