r"""Pull of a contact damper: where the law of Hunt and Crossley makes the normal force of a contact negative.

The force P (1 + chi z') changes its sign where a contact opens faster than 1/chi. A dry contact cannot pull: such a chi
is too large for the wave.
"""

import numpy as np

from contact.averaged.riding import riding_height
from contact.law.normal import load
from contact.passing_wave import Surface, prescribed
from contact.slider import Slider

# Phases of a cycle at which the force is sampled: the least force is found to 2e-7 of itself, the share to 5e-4.
PHASES = 4096


def damper_pull(slider: Slider, orbits: Surface) -> tuple[float, float]:
    """Return how strongly, and how long, the contact damper of a slider that rides on a wave pulls it down.

    Parameters
    ----------
    slider, orbits
        As for `steady`. The slider is taken to keep its height within a cycle (`riding_height`).

    Returns
    -------
    force : float
        Least normal force P (1 + chi z') of the contact that pulls most, N; 0 if none pulls.
    share : float
        Largest fraction of a cycle in which a contact pulls.

    Examples
    --------
    >>> from contact import Orbit, Slider, damper_pull
    >>> ball = Slider(radius=1e-3, mass=89e-6, preload=0.873e-3, load=0.0, friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=20.0, normal_damping=0.5, tangential_damping=1e-4)
    >>> force, share = damper_pull(ball, Orbit(frequency=2.2e6, normal=10e-9, tangential=-7e-9j))
    >>> f"{1e3 * force:.2f} mN, {100 * share:.0f} % of the cycle"
    '-1.84 mN, 20 % of the cycle'
    """
    chi = slider.contact_damping
    if chi == 0.0:
        return 0.0, 0.0
    slider, listed = prescribed(slider, orbits)
    fastest = listed.omega * float(listed.normal_size.max())
    if chi * fastest <= 1.0 or slider.preload == 0.0:
        return 0.0, 0.0
    phase = 2.0 * np.pi * np.arange(PHASES) / PHASES
    size = listed.normal_size[:, None]
    heights = riding_height(slider, listed) + slider.offsets(len(listed))
    approach = heights[:, None] + size * np.cos(phase)
    damped = 1.0 - chi * listed.omega * size * np.sin(phase)
    stiffness = slider.contacts(len(listed)).normal_stiffness[:, None]
    force = stiffness * load(approach, slider.profile) * damped
    return min(float(force.min()), 0.0), float(np.max(np.mean(force < 0.0, axis=1)))
