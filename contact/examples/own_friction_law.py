"""A friction law of one's own: with a constant coefficient it is Coulomb's, with viscous friction the slider is faster.

The wave slips fast below the slider, so that friction which grows with the slip speed drags it along more strongly.
"""

from dataclasses import replace

from contact import Orbit, Slider, UserLaw, mean_motion

PRELOAD, FRICTION = 0.089e-3 * 9.81, 0.08
slider = Slider(
    radius=1e-3, mass=0.089e-3, preload=PRELOAD, load=0.0, friction_coefficient=FRICTION, effective_modulus=64e9,
    tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.5,
    tangential_damping=1e-4,
)  # fmt: skip
LAW = """
MU, ETA = 0.08, {viscous}  # 1, s/m

def sliding(approach, normal_force, slip_speed, contact):
    return normal_force * (MU + ETA * slip_speed)
"""
wave = Orbit(frequency=2.2e6, normal=10e-9, tangential=-7e-9j)
built_in = mean_motion(slider, wave).velocity
same, viscous = (
    mean_motion(replace(slider, law=UserLaw("law.py", LAW.format(viscous=each))), wave).velocity for each in (0.0, 0.4)
)
print(
    f"Coulomb {1e3 * built_in:.4f} mm/s, as a law of one's own {1e3 * same:.4f}; viscous too {1e3 * viscous:.4f} mm/s"
)
assert viscous != same
assert abs(same / built_in - 1) < 1e-6
