"""How warm a stator becomes: from the powers that stay in it to temperatures, in one point or along it.

`HeatedPlate` holds the plate and how it is cooled; its mean temperature and time constant are closed forms. `profile`
solves for the temperature along x. `resonance` says what heating does to a resonance at a fixed frequency, and to a
power that grows with the temperature. Bodies are thin: the temperature is uniform over the cross-section, which holds
for a Biot number below 0.1 (`HeatedPlate.biot_number`).
"""

from fem.heat.plate import HeatedPlate
from fem.heat.profile import HeatSource, TemperatureProfile, profile
from fem.heat.resonance import FOLDOVER_LIMIT, foldover_number, folds, heated_powers, runaway_rise

__all__ = [
    "FOLDOVER_LIMIT",
    "HeatSource",
    "HeatedPlate",
    "TemperatureProfile",
    "foldover_number",
    "folds",
    "heated_powers",
    "profile",
    "runaway_rise",
]
