"""Asperities on a half-space that displace each other normally and tangentially: stepped return mapping.

Each asperity is a Hertzian cap whose force is that of a row of springs (Popov and Hess; Hertz's P'' over eta),
and each spring slips by Coulomb's law on its own. The asperities see each other as point forces on a half-space, with
the displacements 1/(pi E r) and, of Cattaneo's and Mindlin's mean over the directions, 1/(4 pi G r). In each step of
time the approaches follow from the normal forces of all, and the deformations from the tangential forces of all, by
Newton's method. Nothing is assumed of how the asperities slip together.
"""

import numpy as np


class CoupledAsperities:
    """Places and heights of n asperities in m (`free`: u_j at z = 0), their radius, E, G and mu; springs of each."""

    def __init__(self, x, y, free, radius, E, G, mu, *, interact=True, deepest, springs=60):
        self.free, self.mu = np.asarray(free, float), mu
        self.k, self.c = 4 / 3 * E * np.sqrt(radius), mu * E / (4 * G)
        r = np.hypot(np.subtract.outer(x, x), np.subtract.outer(y, y))
        np.fill_diagonal(r, np.inf)
        self.normal = interact / (np.pi * E * r)
        self.tangential = interact / (4 * np.pi * G * r)
        # springs at the depths of equal parts of Hertz's P'' ~ eta^(-1/2), each at its centre of mass
        root = np.linspace(0, np.sqrt(deepest), springs + 1)
        self.eta = (root[1:] ** 3 - root[:-1] ** 3) / (3 * np.diff(root))
        self.weight = 1.5 * self.k * np.diff(root) * mu / self.c

    def approaches(self, z, start=None):
        """Solve u = free + z - C P(u)."""
        free = self.free + z
        u = np.minimum(free, 0.5 * np.max(free)) if start is None else start
        for _ in range(200):
            up = np.maximum(u, 0)
            left = u + self.normal @ (self.k * up**1.5) - free
            if np.max(np.abs(left)) < 1e-13 * np.max(np.abs(free)):
                break
            u = u - np.linalg.solve(np.eye(u.size) + self.normal * (1.5 * self.k * np.sqrt(up)), left)
        return u

    def means(self, z, surface, drift, cycles=3):
        """Return the means of sum P and sum Q over the last of some cycles.

        z, surface: the approach of the ball and the surface's x at equal steps of a cycle; drift: the slider's travel
        in a cycle. `work` and `loss` are then the work of the surface's x in that cycle, and what slip of the springs
        takes, J.
        """
        steps = len(z)
        paths, u = [], None
        for each in z:
            u = self.approaches(each, u)
            paths.append(u)
        P = np.mean([np.sum(self.k * np.maximum(u, 0) ** 1.5) for u in paths])
        moves = surface - np.roll(surface, 1) - drift / steps
        n = self.free.size
        stretched, total, identity = np.zeros((n, self.eta.size)), 0.0, np.eye(n)
        own = np.zeros(n)  # displacement of each asperity by the others
        for _ in range(cycles):
            total = self.work = self.loss = 0.0
            for u, move, shift in zip(paths, moves, surface - np.roll(surface, 1), strict=True):
                limit = self.c * np.maximum(u[:, None] - self.eta, 0)
                step = np.full(n, move)
                for _attempt in range(60):
                    trial = stretched + step[:, None]
                    held = np.clip(trial, -limit, limit)
                    Q = held @ self.weight
                    left = step + self.tangential @ Q - own - move
                    if np.max(np.abs(left)) < 1e-9 * (abs(move) + 1e-16):
                        break
                    stiffness = (np.abs(trial) < limit) @ self.weight
                    step = step - np.linalg.solve(identity + self.tangential * stiffness, left)
                before = (stretched @ self.weight).sum()
                self.work += 0.5 * (Q.sum() + before) * shift
                self.loss += 0.5 * np.sum((held + stretched) * (trial - held) * self.weight)
                stretched, own = held, self.tangential @ Q
                total += Q.sum() / steps
        return P, total
