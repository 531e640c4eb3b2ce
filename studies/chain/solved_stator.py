"""The few numbers of a solved stator that contacts and answers need; many scenes share one solution."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import contact
from studies.chain.nearby_motion import NearbyMotion, nearby_motions
from studies.chain.surface_blocks import unresolved
from studies.chain.surface_motion import SurfaceMotion
from studies.scene import Scene
from studies.scene.drive import Drive

COARSE_ERROR = 0.05  # relative error of the coarsest discretisation, which has no own estimate; 1.7 to 4.5 % measured
MAX_DRIVES = 10_000  # in memory
POSITION_KEYS = ("slider.position", "slider.contacts")


def changes_stator(key: str) -> bool:
    """Return whether a change of a key requires a new solution of the section or its circuit."""
    in_stator = key.startswith(("stator.", "transducer.", "drive."))
    return in_stator and key not in ("drive.voltage", "drive.power", "drive.burst")


class LocalMotion(NamedTuple):
    """Motion of the surface at one position, per volt of the source."""

    tangential: complex  # u_x, m per V
    normal: complex  # u_z, m per V
    relative_error: float
    covered: bool  # whether it lies under a transducer
    refusal: str  # why the motion there is no answer; empty where it is one
    nearby: NearbyMotion | None = None  # about the position; None where it was not evaluated, or lies at an end


@dataclass(frozen=True, kw_only=True)
class SolvedStator:
    """Motion at some positions and admittance of a solved stator, per volt of the source."""

    at: dict[tuple[float, float], LocalMotion]  # by position (x, y) in m
    frequency: float  # Hz
    admittance: complex  # S
    power: float  # mean, from all sources into the stator, W per V^2
    currents: dict[str, complex]  # into the positive electrode of each transducer, A per V

    @classmethod
    def of(cls, motion: SurfaceMotion, positions, *, coarse: bool = False, nearby: bool = False) -> "SolvedStator":
        """Evaluate a surface motion at positions (x, y) in m.

        ``coarse``: it is that of the coarsest discretisation; ``nearby``: also about each position.
        """
        tangential, _, normal = motion.at(positions)
        errors = [COARSE_ERROR] * len(positions) if coarse else motion.errors(positions)
        about = nearby_motions(motion, positions) if nearby else {}
        at = {}
        for position, u_x, u_z, error in zip(positions, tangential, normal, errors, strict=True):
            covered, refusal = motion.covered(position), unresolved(motion, [position])
            at[position] = LocalMotion(complex(u_x), complex(u_z), float(error), covered, refusal, about.get(position))
        return cls(
            at=at, frequency=float(motion.wave.frequency),
            admittance=motion.circuit.admittance, power=motion.circuit.power,
            currents=dict(zip(motion.circuit.names, motion.circuit.currents.tolist(), strict=True)),
        )  # fmt: skip

    def orbits(self, positions) -> tuple:
        """Return the contact.Orbit of 1 V at some of the positions."""
        return tuple(
            contact.Orbit(frequency=self.frequency, tangential=each.tangential, normal=each.normal)
            for each in (self.at[position] for position in positions)
        )


def stator_alone(scene: Scene) -> Scene:
    """Return the stator of a resolved scene alone, at 1 V and without burst."""
    alone = {name: getattr(scene, name) for name in ("stator", "transducer", "piece")}
    return Scene(**alone, drive=at_one_volt(scene.drive))


@lru_cache(MAX_DRIVES)
def at_one_volt(drive: Drive) -> Drive:
    """Return a drive at 1 V, without power and burst."""
    return replace(drive, voltage=(1.0,) if drive.levels else None, power=None, burst=None)
