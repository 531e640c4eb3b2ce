r"""Motion of the slider's face within a cycle: what a vibrometer on the slider sees.

With the first harmonics P_1 and Q_1 of the contacts' forces, the face moves at contact i by

    w_i = -(sum P_1)/(m omega^2) + P_1i/k_s,        x_i likewise with Q_1,

the rigid motion of the mass m and, of a slider on pillars, the dent of its own body under the foot of a pillar, a punch
of the radius a on a half-space: k_s = 2 a E/(1 - nu^2), and 8 a G/(2 - nu) along the wave (Johnson, *Contact
Mechanics*, eq. 3.36 and section 7.2). The amplitudes are means over the contacts, weighted with the load that each
carries; the delay is the phase of sum P_0i w_i conj(x_i).

Between the pillars the face moves as its mean plane does, under a pressure that travels with the wave: |G p_1|/k, p_1
the pressure and G the compliance of a half-space at the wave's velocity (`fem.travelling_compliance`). This part is a
column of its own.
"""

from contextlib import suppress

import numpy as np

import contact
import fem
from studies.model import pillars
from studies.model.wave_to_contact import Contact
from studies.record.point import Point


def face_point(driven: Contact, state, level: float) -> Point:
    """Return the motion of the slider's face in a `contact.SteadyState` at a level; empty where it is not known."""
    if level <= 0.0 or driven.scene.slider.preload_force <= 0.0:
        return Point()
    forces = None
    if state.loaded is not None:
        forces, frequency = state.loaded.forces, state.loaded.wave.frequency
    else:
        orbits = state.orbits
        frequency = orbits.frequency
        with suppress(contact.ConvergenceError):
            forces = contact.mean_forces(driven.slider, orbits, contact.mean_motion(driven.slider, orbits))
    if forces is None or not forces.normal.sum() > 0.0:
        return Point()
    weights = np.broadcast_to(driven.slider.contacts(forces.normal.size).weight, forces.normal.shape)
    inertia = driven.moving_slider.mass * (2.0 * np.pi * frequency) ** 2
    normal, tangential, delay = face_motion(forces, weights, inertia, 0.0 if state.loaded is None else _feet(driven))
    point = Point(face_normal_m=normal, face_tangential_m=tangential)
    if normal > 0.0 and tangential > 0.0:
        point |= Point(face_delay_deg=delay)
    return point | _mean_plane(driven, state, weights)


def face_motion(forces, weights: np.ndarray, inertia: float, feet) -> tuple[float, float, float]:
    """Return normal and tangential amplitude of the face in m, and the delay of the tangential motion in degrees.

    Parameters
    ----------
    forces : contact.MeanForces
    weights : ndarray, shape (n,)
        Number of contacts that each stands for.
    inertia : float
        m omega^2, N/m; infinite for a slider that keeps its height.
    feet : ndarray, shape (2, n) or (2, 1), or 0
        Normal and tangential compliance of the body under each contact, m/N.
    """
    firsts = np.array([forces.first_normal, forces.first_tangential])
    motion = firsts * feet - (firsts @ weights)[:, None] / inertia
    carried = weights * forces.normal / float(weights @ forces.normal)
    normal, tangential = (float(np.abs(each) @ carried) for each in motion)
    return normal, tangential, float(np.angle((carried * motion[0]) @ motion[1].conj(), deg=True))


def foot_compliances(solid: fem.Solid, radius) -> np.ndarray:
    """Return normal and tangential compliance of an isotropic solid under a punch of a radius in m, m/N."""
    shear, lame = float(solid.stiffness[3, 3]), float(solid.stiffness[0, 1])
    ratio = lame / (2.0 * (lame + shear))
    return np.array([(1.0 - ratio) / (4.0 * shear * radius), (2.0 - ratio) / (8.0 * shear * radius)])


def _body(driven: Contact):
    """Return the material of a slider on pillars."""
    return fem.material(driven.scene.slider.ball or pillars.SILICON)


def _feet(driven: Contact) -> np.ndarray:
    """Return the compliances of the slider's body under each pillar, m/N, shape (2, n)."""
    return foot_compliances(_body(driven), pillars.layout(driven.scene.slider).diameter / 2)


def _mean_plane(driven: Contact, state, weights: np.ndarray) -> Point:
    """Return the motion of the mean plane between the pillars."""
    rows = state.loaded
    if rows is None:
        return Point()
    geometry, wave = pillars.layout(driven.scene.slider), rows.wave
    if geometry.x.size < 2 or wave.wavelength <= 0.0:
        return Point()
    area = (float(np.ptp(geometry.x)) + geometry.pitch) * pillars.strip_width(driven.scene.slider)
    way = 1.0 if abs(wave.forward) >= abs(wave.backward) else -1.0
    turned = weights * np.exp(1j * way * wave.wavenumber * geometry.x)
    traction = np.array([rows.forces.first_tangential @ turned, rows.forces.first_normal @ turned]) / area
    try:
        compliance = fem.travelling_compliance(_body(driven), wave.frequency * wave.wavelength)
    except fem.InputError:  # a soft slider: the pressure runs faster than its bulk waves
        return Point()
    # the slider's body lies above its face: z and the pressure change their signs, and so do the mixed terms
    mirror = np.array([[1.0, way], [way, 1.0]]) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    along, up = np.abs((mirror * compliance) @ traction) / wave.wavenumber
    return Point(face_wave_normal_m=float(up), face_wave_tangential_m=float(along))
