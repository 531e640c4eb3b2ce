"""How warm a stator becomes: from the powers that stay in it to temperatures, in one point or along it.

`HeatedPlate` holds the plate and how it is cooled; its mean temperature and time constant are closed forms.
`temperature_profile` solves for the temperature along x. `foldover_number` and its neighbours say what heating does to
a resonance at a fixed frequency, and `runaway_rise` what a power does that grows with the temperature;
`heated_states` finds the steady states of any sampled dependence of the heat on the temperature. Bodies are thin:
the temperature is uniform over the cross-section, which holds for a Biot number below 0.1 (`HeatedPlate.biot_number`).
"""

from fem.heat.continuation import HeatedState, drive_folds, heated_states, sampled_foldover_number
from fem.heat.hot_resonance import FOLDOVER_LIMIT, foldover_number, folds, heated_powers, runaway_rise
from fem.heat.plate import MAX_BIOT_NUMBER, HeatedPlate
from fem.heat.plate_temperature import HeatSource, TemperatureProfile, temperature_profile

__all__ = [
    "FOLDOVER_LIMIT",
    "MAX_BIOT_NUMBER",
    "HeatSource",
    "HeatedPlate",
    "HeatedState",
    "TemperatureProfile",
    "drive_folds",
    "foldover_number",
    "folds",
    "heated_powers",
    "heated_states",
    "runaway_rise",
    "sampled_foldover_number",
    "temperature_profile",
]
