"""Published values of SAW motors, and ranges for the unpublished ones: the input of `published_motors`.

M. Kurosawa, M. Takahashi, T. Higuchi, IEEE Trans. UFFC 45 (1998) 1229; P. J. Feenstra, P. C. Breedveld, *Analysis of a
Surface Acoustic Wave Motor*; D. Tjeung, M. Hughes, L. Yeo, J. Friend (2011); Raj and Behera, Sensors and Actuators A
(2025), doi 10.1016/j.sna.2025.117012.
"""

from dataclasses import dataclass
from itertools import product

GRAVITY = 9.81
STEEL_DENSITY = 7850.0


@dataclass(frozen=True, kw_only=True)
class Unknown:
    """A quantity that a paper does not state exactly: the assumed value and the swept range, in SI units."""

    name: str
    taken: float | str
    swept: tuple[float | str, ...]
    unit: str = ""
    scale: float = 1.0

    def __str__(self):
        if isinstance(self.taken, str):
            return f"{self.name} {' or '.join(map(str, self.swept))}"
        low, high = min(self.swept) * self.scale, max(self.swept) * self.scale
        return f"{self.name} {low:.4g} to {high:.4g}{' ' * bool(self.unit)}{self.unit}"


@dataclass(frozen=True, kw_only=True)
class Source:
    """The published and the unknown quantities of one paper, in SI units."""

    published: dict[str, float]
    unknowns: dict[str, Unknown]

    def __getitem__(self, name: str) -> Unknown:
        return self.unknowns[name]


def corners(unknowns: dict[str, Unknown]):
    """Yield every combination of the swept values, by name."""
    for values in product(*(unknown.swept for unknown in unknowns.values())):
        yield dict(zip(unknowns, values, strict=True))


KUROSAWA = Source(
    published={
        "voltage_V": 180.0,
        "frequency_Hz": 10e6,
        "radius_m": 0.5e-3,
        "amplitude_m": 10e-9,
        "velocity_m_per_s": 0.43,
        "thrust_N": 1e-3,
        "acceleration_m_per_s2": 23 * GRAVITY,
        "contact_radius_m": 3e-6,
        "pressure_Pa": 390e6,
        "mass_kg": STEEL_DENSITY * 4.18879 * 0.5e-3**3,
    },
    unknowns={
        # of the contact
        "friction": Unknown(name="friction", taken=0.15, swept=(0.1, 0.15, 0.3)),
        "preload": Unknown(name="preload", taken=6.5e-3, swept=(6e-3, 7e-3), unit="mN", scale=1e3),
        "amplitude": Unknown(name="amplitude", taken=10e-9, swept=(9e-9, 11e-9), unit="nm", scale=1e9),
        "frequency": Unknown(name="frequency", taken=10e6, swept=(9.5e6, 10.5e6), unit="MHz", scale=1e-6),
        "modulus": Unknown(name="E*", taken=101e9, swept=(95e9, 115e9), unit="GPa", scale=1e-9),
        "law": Unknown(name="law", taken="elastic", swept=("elastic", "hysteretic")),
        "air": Unknown(name="R_t", taken=0.0, swept=(0.0, 5e-6), unit="N s/m"),
        # of the stator
        "pairs": Unknown(name="finger pairs", taken=10, swept=(5, 10, 20)),
        "material": Unknown(name="constants", taken="LiNbO3 (Kovacs)", swept=("LiNbO3 (Kovacs)", "LiNbO3 (Warner)")),
    },
)
TANGENTIAL_OVER_NORMAL = 0.21  # G*/E* of steel on lithium niobate
NORMAL_DAMPING = 0.16  # N s/m: it lets the bounce of the start die out and hardly moves the steady speed

SEED = Source(
    published={"constant_contact_m": 3e-9, "intermittent_m": 10e-9},
    unknowns={"modulus": Unknown(name="E*", taken=64e9, swept=(60e9, 68e9), unit="GPa", scale=1e-9)},
)

TJEUNG = Source(
    published={"preload_N": 41.1e-6, "radius_m": 0.5e-3, "torque_Nm": 5.37e-9, "turns_per_s": 1900 / 60},
    unknowns={"friction": KUROSAWA["friction"]},
)

RAJ = Source(
    published={
        "frequency_Hz": 13.5e6,
        "amplitude_m": 12e-9,
        "preload_N": 5e-3,
        "friction": 0.45,
        "velocity_at_least_m_per_s": 0.3,
    },
    unknowns={
        # surface and mass of the silicon slider are unknown: represent it by one ball with a wide range of sizes
        "radius": Unknown(name="radius", taken=1e-3, swept=(0.3e-3, 3e-3), unit="mm", scale=1e3),
        "mass": Unknown(name="mass", taken=10e-6, swept=(5e-6, 20e-6), unit="mg", scale=1e6),
        "modulus": Unknown(name="E*", taken=89e9, swept=(80e9, 100e9), unit="GPa", scale=1e-9),
        "amplitude": Unknown(name="amplitude", taken=12e-9, swept=(11e-9, 13e-9), unit="nm", scale=1e9),
    },
)

LEFT_ASIDE = (
    (
        "Kurosawa's silicon sliders (1.1 m/s and 3.5 N; 1.5 m/s and 12 N)",
        "many etched projections share the preload; their number, shape and height are not stated here",
    ),
    (
        "Shigematsu and others 2003, a start free of stick and slip",
        "no source at hand states a number for it; their steps are computed with silicon sliders of usual sizes",
    ),
    (
        "Tjeung and others, speed (1900 rpm)",
        "the amplitude of the surface is not stated: at the rim it must exceed 5 nm, which the wave can give",
    ),
    (
        "Shilton and others 2012, run-up from rest (an exponential)",
        "its slider and amplitude are not stated here, so there is nothing to compute that would be their motor's",
    ),
    (
        "Feenstra and Breedveld, speed against amplitude",
        "simulated, with dampers called arbitrary, and no voltage is stated; see the study seed_figures",
    ),
)
