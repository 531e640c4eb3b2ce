"""Which waves a section guides: wavenumber against frequency, of the plate's modes and of the Rayleigh wave.

Method: guided modes of the bare section of the scene (``rayleigh`` when none is named), from a twelfth of its drive
frequency to a fifth above it, those that hardly decay; beside them the half-space's Rayleigh wave.  The same solver on
a steel plate of half the thickness in shear wavelengths is held against the Rayleigh-Lamb equation, root by root.
Expected: at the drive frequency the section's surface wave has the half-space's velocity to 1e-4 if the plate is 4
wavelengths thick or more (a thin plate: no such thing); every root of Rayleigh-Lamb found once, to 1e-9.  Run time:
about 10 s.
"""

from collections.abc import Callable

from studies.scene import Scene, resolved
from studies.study import Finding, Panel, StudyRecord, of_record, study

__all__ = ["figure", "rayleigh_lamb", "run"]

TAKES_SCENE = True
QUICK = {"count": 9}
COUNT = 60
LOWEST, HIGHEST = 1 / 12, 1.2  # of the drive frequency
DECAY = 0.01  # |Im k| over |Re k| below which a mode propagates
TOLERANCE = 1e-8  # of the modes' wavenumbers
THICK = 4.0  # wavelengths: above it the faces' waves hardly split
YOUNGS_MODULUS, POISSON_RATIO, DENSITY = 210e9, 0.3, 7850.0
PLATE = 1e-3  # m
PLATE_FREQUENCIES = (0.4e6, 1.1e6, 2.0e6, 3.1e6, 4.3e6)  # of 1 mm of steel: up to 1.3 shear wavelengths


@study
def run(
    scene: str | Scene = "rayleigh",
    *,
    count: int = COUNT,
    progress: Callable[[str], None] | None = None,
) -> StudyRecord:
    """Return propagating wavenumbers against frequency.

    Parameters
    ----------
    scene : str or Scene
        A path, a shipped name or a scene with a stator.
    count : int
        Frequencies.
    progress : callable, optional
        Told what is being done.
    """
    import numpy as np

    import fem

    if scene.stator is None:
        scene.refuse("stator", "is missing: a given wave has no section to guide it")
    scene = resolved.resolved(scene)
    stator, drive = resolved.stator(scene.stator), scene.frequency
    frequencies = np.linspace(LOWEST, HIGHEST, count) * drive
    progress(f"{count} frequencies of {scene.title}")
    modes = _propagating(stator, frequencies)
    half_space = fem.rayleigh(stator.solid, "open" if stator.above == "none" else "vacuum").velocity
    free = fem.free_wave(stator, frequency=drive, tolerance=1e-6)
    progress("steel plate against Rayleigh-Lamb")
    plate, lamb = _steel(PLATE_FREQUENCIES)
    panels = (
        Panel(
            name="section",
            title=f"{scene.title}: {len(modes[0])} propagating modes",
            data={"frequency_Hz": modes[0], "wavenumber_rad_per_m": modes[1], "surface_share": modes[2],
                  "line_Hz": frequencies, "line_rad_per_m": 2 * np.pi * frequencies / half_space},
        ),
        Panel(
            name="steel_plate",
            title="1 mm of steel",
            data={"frequency_Hz": plate[0], "wavenumber_rad_per_m": plate[1],
                  "line_Hz": lamb[0], "line_rad_per_m": lamb[1]},
        ),
    )  # fmt: skip
    findings = (_surface_wave(stator, drive, free, half_space), *_against_lamb(plate))
    return panels, findings


@of_record
def figure(record: Panel, ax):
    """Draw wavenumbers of the modes as points and theory as a line or, of many roots, as fine dots."""
    from studies.report.figures import COLOURS, titled

    data = record.data
    at, wavenumbers = data["frequency_Hz"] / 1e6, data["wavenumber_rad_per_m"] / 1e3
    line = data["line_Hz"] / 1e6, data["line_rad_per_m"] / 1e3
    if "surface_share" in data:
        ax.plot(at, wavenumbers, ".", color=COLOURS["stick"], markersize=2.5, label="modes of the section")
        near = data["surface_share"] > 0.25
        ax.plot(
            at[near], wavenumbers[near], ".", color=COLOURS["slip"], markersize=4, label="near the surface"
        )
        ax.plot(*line, color=COLOURS["line"], linewidth=1, label="Rayleigh wave of the half-space (theory)")
    else:
        ax.plot(*line, ".", color=COLOURS["line"], markersize=1.5, label="Rayleigh-Lamb (theory)")
        ax.plot(at, wavenumbers, "o", color=COLOURS["intermittent"], markersize=5, fillstyle="none",
                label="modes of the section")  # fmt: skip
    ax.set_xlabel("frequency (MHz)")
    ax.set_ylabel("wavenumber (rad/mm)")
    titled(ax, record.title)
    ax.set_ylim(bottom=0)
    ax.grid(alpha=0.3)
    ax.legend(frameon=False, fontsize="small", loc="upper left")
    return ax


def rayleigh_lamb(frequency: float, thickness: float, longitudinal: float, shear: float):
    """Return the real wavenumbers of a free isotropic plate at a frequency, rad/m, ascending.

    Roots of (q^2 - k^2)^2 cos(p h) sin(q h) / q + 4 k^2 p sin(p h) cos(q h) (symmetric motion) and of
    (q^2 - k^2)^2 sin(p h) cos(q h) / p + 4 k^2 q cos(p h) sin(q h) (antisymmetric), h half the thickness,
    p^2 = (omega / v_L)^2 - k^2, q^2 = (omega / v_S)^2 - k^2 (Graff, *Wave Motion in Elastic Solids*, 1975, section
    8.1), both real whatever the signs of p^2 and q^2.

    Parameters
    ----------
    frequency : float
        Hz.
    thickness : float
        m.
    longitudinal, shear : float
        Bulk velocities in m/s.
    """
    import numpy as np
    from scipy.optimize import brentq

    half, omega = thickness / 2, 2 * np.pi * frequency
    stretching = 2 * shear * np.sqrt(1 - (shear / longitudinal) ** 2)
    bending = np.sqrt(
        omega * np.sqrt(12) / (stretching * thickness)
    )  # of a thin plate; no mode is slower than both
    found = []
    for symmetric in (True, False):

        def residual(k, symmetric=symmetric):
            p, q = (np.sqrt((omega / v) ** 2 - k * k + 0j) * half for v in (longitudinal, shear))
            kh, first, second = k * half, (p, q), (q, p)
            a, b = first if symmetric else second
            left = (q * q - kh * kh) ** 2 * np.cos(a) * np.sinc(b / np.pi)
            right = 4 * kh * kh * np.sin(a) * a * np.cos(b)
            return (left + right).real * np.exp(-abs(p.imag) - abs(q.imag))

        grid = np.linspace(0.0, bending + 1.1 * omega / shear, 4001)[1:]
        values = residual(grid)
        for index in np.flatnonzero(np.sign(values[1:]) != np.sign(values[:-1])):
            found.append(brentq(residual, grid[index], grid[index + 1], xtol=1e-9, rtol=1e-14))
    return np.sort(found)


def _propagating(stator, frequencies):
    """Frequency (Hz), wavenumber (rad/m) and nearness to the surface (1: the nearest) of the modes that propagate."""
    import numpy as np

    import fem

    rows = []
    for frequency in frequencies:
        modes = fem.guided_modes(stator, frequency=float(frequency), tolerance=TOLERANCE, propagating=True)
        k = modes.wavenumbers
        moving = np.flatnonzero(abs(k.imag) < DECAY * abs(k.real))
        near = modes.surface_share[moving] * frequency  # a surface wave's share is one over its depth
        rows += [(frequency, abs(k[i].real), s) for i, s in zip(moving, near, strict=True)]
    table = np.array(rows).reshape(-1, 3).T
    return table[0], table[1], table[2] / max(table[2].max(initial=0.0), 1e-300)


def _steel(frequencies):
    """Modes of the steel plate at some frequencies, and roots of Rayleigh-Lamb at many, both (Hz, rad/m)."""
    import numpy as np

    import fem

    solid = fem.isotropic(
        name="steel", youngs_modulus=YOUNGS_MODULUS, poisson_ratio=POISSON_RATIO, density=DENSITY
    )
    stator = fem.Stator(solid=solid, length=1.0, thickness=PLATE, ends="absorbing")
    plate = _propagating(stator, np.array(frequencies))[:2]
    many = np.linspace(0.02, 1.0, 50) * frequencies[-1]
    roots = [(f, k) for f in many for k in rayleigh_lamb(f, PLATE, *_speeds())]
    return plate, np.array(roots).T


def _speeds() -> tuple[float, float]:
    shear = YOUNGS_MODULUS / 2 / (1 + POISSON_RATIO)
    ratio = 2 * (1 - POISSON_RATIO) / (1 - 2 * POISSON_RATIO)
    return (ratio * shear / DENSITY) ** 0.5, (shear / DENSITY) ** 0.5


def _surface_wave(stator, frequency: float, free, half_space: float) -> Finding:
    thickness = stator.thickness * frequency / half_space
    off = abs(free.velocity / half_space - 1)
    return Finding(
        statement="The surface wave of a thick section is the half-space's.",
        quantity=f"relative difference of velocities at {frequency / 1e6:g} MHz, {thickness:.3g} wavelengths thick",
        expected=f"below 1e-4 from {THICK:g} wavelengths on",
        found=float(off),
        confirmed=bool(off < 1e-4) or not (stator.absorbs_below or thickness > THICK),
    )


def _against_lamb(plate) -> list[Finding]:
    import numpy as np

    missing, worst = 0, 0.0
    for frequency in PLATE_FREQUENCIES:
        roots = rayleigh_lamb(frequency, PLATE, *_speeds())
        modes = np.sort(plate[1][plate[0] == frequency])
        missing += abs(len(roots) - len(modes))
        if len(roots) == len(modes):
            worst = max(worst, float(np.max(abs(modes / roots - 1))))
    return [
        Finding.judged(
            "Every root of Rayleigh-Lamb is a mode and every mode a root.",
            "modes too many or too few",
            missing,
            high=1,
            expected="0",
        ),
        Finding.judged(
            "The modes have the wavenumbers of Rayleigh-Lamb.",
            "largest relative difference",
            worst,
            high=1e-9,
        ),
    ]
