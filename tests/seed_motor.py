"""Numbers of the seed's motor: Feenstra and Breedveld's ball of steel on PZT, in SI units.

Plain numbers, so that oracles, which import nothing of the product, take them from here too.
"""

GRAVITY = 9.81  # m/s^2
MASS = 0.089e-3  # kg
PRELOAD = MASS * GRAVITY  # N: the weight
RADIUS = 1e-3  # m
FRICTION = 0.08
EFFECTIVE_MODULUS, TANGENTIAL_MODULUS = 64e9, 12e9  # Pa: E* and G*
NORMAL_DAMPING, TANGENTIAL_DAMPING = 0.5, 1e-4  # N s/m
FREQUENCY = 2.2e6  # Hz

BODY = {"mass": MASS, "preload": PRELOAD}
DAMPERS = {"normal_damping": NORMAL_DAMPING, "tangential_damping": TANGENTIAL_DAMPING}
BALL = {
    "radius": RADIUS, "friction_coefficient": FRICTION, "effective_modulus": EFFECTIVE_MODULUS,
    "tangential_modulus": TANGENTIAL_MODULUS,
}  # fmt: skip
# keywords of contact.Slider
SLIDER = {
    **BODY, **DAMPERS, **BALL, "load": 0.0, "law": "elastic", "reciprocal": False, "stick_band": 0.0,
    "contact_damping": 0.0,
}  # fmt: skip
# keys of the block [slider] of a scene: one ball under its weight
SCENE_SLIDER = {
    **BALL, "mass": MASS, "contacts": 1, "preload": "weight",
    "damping": {"normal": NORMAL_DAMPING, "tangential": TANGENTIAL_DAMPING},
}  # fmt: skip
