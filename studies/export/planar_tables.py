"""Tables of the mean torque of an averaged rotor, and the flat arrays that `reduced_plane` reads.

A row of the tables belongs to tau and phi, the sizes of the waves. There the contacts' forces are those of
`contact.plane.contact_forces`; the torque is the mean over a turn.
"""

from dataclasses import dataclass

import numpy as np

from contact import plane
from studies.export.force_grid import as_written
from studies.export.planar_body import Body, common_parameters
from studies.export.reduced_plane import plane_index as index
from studies.export.reduced_plane.plane_force_tables import BELOW, CLOSER, CLOSER_ABOVE, CLOSER_BELOW, KNEE, MIDDLE

# Nodes of tau, phi, speed and angle, of which there are two, with one drive and with two
NODES = {1: (31, 1, 33, 2), 2: (17, 7, 17, 2)}
BEYOND = 1.5  # of the scene's largest levels: up to there the tables reach
SMALL = 1e-3  # of tau's first step: waves at which the shares without a wave are taken
SAME = 1e-5  # of g: elements whose tables differ by less share one; a mean errs by 1e-7 to 1e-6


class Forces:
    """Exact mean forces of the elements of a body over mu P."""

    def __init__(self, body: Body):
        self.body, self.amplitudes = body, body.amplitudes()
        self.turned = [(each, body.waves(each)) for each in body.turned()]
        speeds = [
            each.peak_speed / amplitude
            for _, waves in self.turned
            for each, amplitude in zip(waves, self.amplitudes, strict=True)
        ]
        self.speed = max(speeds)  # v_1, 1/s

    def size(self, tau: float) -> float:
        """Return s in m at a ratio tau, under the slider's preload."""
        return self.body.rest_approach * (tau / (1.0 - tau)) ** 2

    def tau(self, size: float) -> float:
        """Return the ratio tau of s in m under the slider's preload."""
        return float(np.sqrt(size) / (np.sqrt(size) + np.sqrt(self.body.rest_approach)))

    def waves_at(self, waves: list, tau: float, phi: float) -> plane.SurfaceWaves:
        """Return the waves of all drives at the ratios tau and phi."""
        sizes = self.size(tau) * np.array([1.0 - phi, phi])[: len(waves)]
        parts = [each.scaled(s / a) for each, s, a in zip(waves, sizes, self.amplitudes, strict=True)]
        parts = [each for each, s in zip(parts, sizes, strict=True) if s > 0.0]
        frequencies = [frequency for each in parts for frequency in each.frequencies]
        return plane.SurfaceWaves(frequencies=frequencies, amplitudes=np.concatenate([p.amplitudes for p in parts]))

    def at(self, tau: float, phi: float, q: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return g, (k, elements, 2), at k ratios q = |v|/(v_1 s) and angles (rad), and the elements' shares."""
        body, s = self.body, self.size(tau)
        direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        v = (q * self.speed * s)[:, None] * direction
        totals, shares = np.zeros(1), np.zeros(1)
        for slider, waves in self.turned:
            n, preload = slider.count, slider.preload
            x, y = (np.broadcast_to(each, n) for each in (slider.x, slider.y))
            arms = np.stack([-(y - slider.axis[1]), x - slider.axis[0]], axis=1) / body.arm
            velocities, along = (each[:, :1, None] * arms for each in (v, direction))
            found = plane.contact_forces(slider, self.waves_at(waves, tau, phi), velocities, along)
            g, load = found.forces / (slider.friction_coefficient * preload), found.loads / preload
            torque = (g * arms).sum(axis=(1, 2))
            g = np.stack([torque, np.zeros_like(torque)], axis=1)[:, None]
            load = np.array([(load * np.linalg.norm(arms, axis=1)).sum()])
            totals, shares = totals + g / len(self.turned), shares + load / len(self.turned)
        return totals, shares


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Nodes of the tables."""

    tau: np.ndarray
    phi: np.ndarray
    q: np.ndarray  # speeds over v_1 s, the last one infinite
    angle: np.ndarray  # rad
    axis: float  # rad
    axes: int  # see `plane_force_tables.position`

    @classmethod
    def of(cls, forces: Forces, max_tau: float, nodes: tuple | None = None) -> "Grid":
        """Return the nodes of a body with one or two drives."""
        body = forces.body
        taus, phis, nus, angles = nodes or NODES[len(body.surfaces)]
        axes, axis = 2 * len(body.surfaces), 0.0
        part = np.arange(angles) / angles * axes
        sector = np.floor(part + 0.5)
        t = 2.0 * (part - sector)
        angle = axis + 2.0 * np.pi / axes * (sector + 0.5 * (CLOSER * t + (1.0 - CLOSER) * t**3))
        return cls(
            tau=np.linspace(0.0, max_tau, taus), phi=np.linspace(0.0, 1.0, phis), q=speeds(nus), angle=angle,
            axis=axis, axes=axes,
        )  # fmt: skip

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Number of nodes of each axis."""
        return self.tau.size, self.phi.size, self.q.size, self.angle.size


def speeds(count: int) -> np.ndarray:
    """Return q at the nodes of the speed, as `plane_force_tables.speed_position` places them."""
    part = np.linspace(0.0, 1.0, count)
    below, above = part / BELOW - 1.0, (part - BELOW) / (1.0 - BELOW)
    u = np.where(
        part < BELOW,
        MIDDLE * (1.0 + CLOSER_BELOW * below + (1.0 - CLOSER_BELOW) * below**3),
        MIDDLE + (1.0 - MIDDLE) * (CLOSER_ABOVE * above + (1.0 - CLOSER_ABOVE) * above**3),
    )
    with np.errstate(divide="ignore"):
        return np.append(KNEE * u[:-1] ** 2 / (1.0 - u[:-1] ** 2), np.inf)


def tables_of(forces: Forces, grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """Return share, g_x, g_y at rest, (elements, tau, phi, 3), and g + p n, (elements, tau, phi, nu, angle, 2)."""
    elements, (taus, phis, nus, angles) = len(forces.body.places), grid.shape
    rest, table = np.zeros((elements, taus, phis, 3)), np.zeros((elements, taus, phis, nus, angles, 2))
    q, angle = (each.ravel() for each in np.meshgrid(grid.q[:-1], grid.angle, indexing="ij"))
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    _, shares = forces.at(SMALL * grid.tau[1], 0.0, np.array([1.0]), np.zeros(1))
    rest[:, 0, :, 0] = shares[:, None]
    for i, tau in enumerate(grid.tau[1:], start=1):
        for j, phi in enumerate(grid.phi):
            g, shares = forces.at(tau, phi, q, angle)
            rest[:, i, j, 0] = shares
            rest[:, i, j, 1:] = g[:angles].mean(axis=0)
            residual = g + shares[:, None] * direction[:, None]
            table[:, i, j, :-1] = residual.swapaxes(0, 1).reshape(elements, nus - 1, angles, 2)
    return rest, table


def packed(
    body: Body, forces: Forces, grid: Grid, tables: tuple, *, creep: float, steps: tuple[float, float], rise: float
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return the flat arrays of `reduced_plane`, parameters and tables; ``steps``: the longest and the fast one, s."""
    taus, phis, nus, angles = grid.shape
    p = common_parameters(body, forces.amplitudes, len(body.places), creep=creep, steps=steps, rise=rise)
    p[index.TAU_NODES], p[index.PHI_NODES], p[index.NU_NODES], p[index.ANGLES] = taus, phis, nus, angles
    p[index.MAX_TAU], p[index.SPEED] = grid.tau[-1], forces.speed
    p[index.AXIS], p[index.AXES] = grid.axis, grid.axes
    rests, whole = tables
    parts, length = [], 0
    known: list[int] = []
    for number, place in enumerate(body.places):
        own = index.FIRST_ELEMENT + number * index.ELEMENT_SIZE
        p[own + index.ELEMENT_X], p[own + index.ELEMENT_Y] = place
        table = whole[number]
        around = np.concatenate([table[..., -1:, :], table, table[..., :2, :]], axis=-2)
        same = next((k for k in known if np.abs(rests[k] - rests[number]).max() < SAME
                     and np.abs(whole[k] - table).max() < SAME), None)  # fmt: skip
        if same is not None:
            other = index.FIRST_ELEMENT + same * index.ELEMENT_SIZE
            p[own + index.REST_TABLE :][:2] = p[other + index.REST_TABLE :][:2]
            continue
        known.append(number)
        for start, piece in ((index.REST_TABLE, rests[number].ravel()), (index.FORCE_TABLE, around.ravel())):
            p[own + start] = length
            parts.append(piece)
            length += piece.size
    return p, as_written(parts)
