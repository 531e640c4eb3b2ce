"""Reflection of the surface wave at grooves, from the motion that NGSolve alone computes.

A plate between free ends has single fingers on both sides of the grooves.  Each of them is an excitation of its own.
Left and right of the grooves the motion of the surface is a sum of exp(-i k_p x) and exp(+i k_p x): the wavenumbers
come from the samples of all excitations together (ESPRIT; Roy and Kailath, IEEE Trans. ASSP 37 (1989) 984), the
amplitudes from a least-squares fit.  With as many independent excitations as waves arrive, outgoing = S incident
gives S, whatever the ends reflect.  Of the program only the tables of materials are used.
"""

import numpy as np

from fem.materials import material, rotated
from tests.validation.ngsolve_pieces import FREQUENCY, Drawing, Reference

THICKNESS, SIDE = 1.1, 17.0  # mm; the grooves begin SIDE from the left end and end SIDE before the right one
CLEAR = 4.0, 3.5  # mm without samples before the grooves and behind the fingers, where evanescent waves live
FINGERS = 1.0 + 0.37 * np.arange(9)  # mm from either end; unequal to half of any wavelength
WIDTH = 0.2
CASES = {"groove": [(0.0, 0.25, 0.15)], "five grooves": [(0.5 * k, 0.25, 0.1) for k in range(5)]}


def drawing_of(case: str) -> tuple[Drawing, float]:
    """Drawing, and the length of the grooves from edge to edge, mm."""
    grooves = CASES[case]
    extent = grooves[-1][0] + grooves[-1][1]
    length = 2 * SIDE + extent
    outline = [(0.0, 0.0), (0.0, -THICKNESS), (length, -THICKNESS), (length, 0.0)]
    for x, width, depth in grooves[::-1]:
        outline += [(SIDE + x + width, 0.0), (SIDE + x + width, -depth), (SIDE + x, -depth), (SIDE + x, 0.0)]
    lefts = [*FINGERS, *(length - FINGERS - WIDTH)]
    return (
        Drawing(
            regions=[("stator", outline)],
            electrodes={f"e{k}": [((x, 0.0), (x + WIDTH, 0.0))] for k, x in enumerate(lefts)},
            singular=[(SIDE + a, -d) for x, width, d in grooves for a in (x, x + width)],
        ),
        extent,
    )


def sampled(case: str, *, order: int, layers: int, size: float):
    """Places left and right of the grooves, mm from their edges, and u_x and u_z there: (excitations, 2, places)."""
    drawing, extent = drawing_of(case)
    solved = Reference(drawing, {"stator": rotated(material("PZT-4"), "Z")}, order=order, layers=layers, size=size)
    solved.solve(FREQUENCY)
    distance = np.linspace(CLEAR[0], SIDE - FINGERS[-1] - WIDTH - CLEAR[1], 81)
    places, motions = (-distance[::-1], distance), []
    for x, edge in zip(places, (SIDE, SIDE + extent), strict=True):
        at = [solved.mesh(float(each), -1e-9) for each in x + edge]
        motions.append(
            np.array([[[f.components[c](p) for p in at] for c in (0, len(solved.axes) - 1)] for f in solved.fields])
        )
    return places, motions


def scattering(places, motions, waves: int = 5):
    """S (2 waves, 2 waves) of u_z at the outer edges of what lies between the sampled places.

    Returns
    -------
    k : ndarray, shape (waves,)
        Of the waves to the right, rad/mm.
    S : ndarray
    residual : float
        Of the fit, relative.
    """
    from scipy.optimize import least_squares

    channels = [each.reshape(-1, each.shape[-1]) for each in motions]
    channels = [each / np.linalg.norm(each, axis=1)[:, None] for each in channels]

    def bases(k):
        """Waves both ways and a constant; the last k is that of an evanescent wave, from the grooves and fingers."""
        found = []
        for x in places:
            near, far = np.sort(abs(x[[0, -1]])) * np.sign(x[0])
            inner = np.exp(-1j * np.outer(x, np.append(k[:-1], -k[:-1])))
            outer = np.exp(-1j * k[-1] * abs(np.subtract.outer(x, [near, far])))
            found.append(np.hstack([inner, outer, np.ones((len(x), 1))]))
        return found

    def misfit(parameters):
        gaps = []
        for basis, rows in zip(bases(parameters[::2] + 1j * parameters[1::2]), channels, strict=True):
            q = np.linalg.qr(basis)[0]
            gaps.append((rows.T - q @ (q.conj().T @ rows.T)).ravel())
        gap = np.concatenate(gaps)
        return np.concatenate([gap.real, gap.imag])

    start = np.append(_wavenumbers(channels, float(places[0][1] - places[0][0]), waves), 0.001 - 2.8j)
    fit = least_squares(misfit, np.stack([start.real, start.imag], axis=1).ravel(), xtol=1e-13, ftol=1e-13)
    k = fit.x[::2] + 1j * fit.x[1::2]
    out, into = [], []
    for side, (basis, motion) in enumerate(zip(bases(k), motions, strict=True)):
        amplitudes = np.linalg.lstsq(basis, motion[:, 1].T, rcond=None)[0]
        right, left = amplitudes[:waves], amplitudes[waves : 2 * waves]
        into.append(left if side else right)
        out.append(right if side else left)
        static = np.linalg.lstsq(basis, motion[:, 0].T, rcond=None)[0][-1:]
    into.append(static)  # a constant u_x: the flux of D through the plate, from the fingers left to those right
    return (k[:waves], np.vstack(out) @ np.linalg.pinv(np.vstack(into)), float(np.sqrt(np.mean(fit.fun**2) * 81)))


def _wavenumbers(channels: list, step: float, waves: int) -> np.ndarray:
    """First guess for the waves to the right, largest first."""
    pencil = 40
    columns = [row[i : i + pencil] for rows in channels for row in rows for i in range(rows.shape[1] - pencil + 1)]
    columns += [column[::-1] for column in columns]  # x -> -x: k and -k stand together
    vectors = np.linalg.svd(np.array(columns).T, full_matrices=False)[0][:, : 2 * waves + 1]
    shift = np.linalg.lstsq(vectors[:-1], vectors[1:], rcond=None)[0]
    k = 1j * np.log(np.linalg.eigvals(shift)) / step
    right = k[k.real > 0.05]
    return np.array([(each - k[np.argmin(abs(k + each))]) / 2 for each in sorted(right, key=lambda v: -v.real)])


def main() -> None:
    """Print the surface wave's wavenumber, reflection and transmission in every case."""
    for case in CASES:
        k, s, residual = scattering(*sampled(case, order=8, layers=7, size=0.5))
        n = len(k)
        print(f'"{case}": k {k[0]:.6f} rad/mm, R {s[0, 0]:.6f}, T {s[n, 0]:.6f}, residual {residual:.1e}', flush=True)


if __name__ == "__main__":
    main()
