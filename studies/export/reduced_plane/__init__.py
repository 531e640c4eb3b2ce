r"""The averaged motor in the plane as step functions in a subset of Python that `c_translation` turns into C.

Model
-----
The mean forces of one period of the waves move the slider, first-order averaging as in `contact.plane.averaged_path`::

    m V' = sum Q_e - F - R V,      J omega' = sum (X_e Q_y,e - Y_e Q_x,e) - M - R_yaw omega
    Q_e  = mu P g_e(tau, phi, v_e),      v_e = V + omega e_z x r_e

e counts the elements: the contacts, or one element for a rotor, at the end of an arm. The heights follow the waves at
once: they are those at which the mean normal forces carry the preload P. The mean force of a contact is computed over
the common period of the waves (`plane_cycle`), a rotor's torque, the mean over a turn, is read from a table.

The table is that of one or two drives of different frequencies, whose largest normal amplitudes under the contacts are
s_1 and s_2,

    s = s_1 + s_2,   phi = s_2/s,   tau = sqrt(s)/(sqrt(s) + sqrt(h)),   h = (P/K)^(1/e): the approach at rest.

All forces grow as a power of the lengths, so that g holds for every preload and mass. Its table has polar velocities,
q = |v|/(v_1 s) and an angle, and holds what distinguishes g from the friction of a surface at rest, g + p n with
n = v/|v| and the element's share p of the preload; it is zero at tau = 0 and at infinite q. v_1 s is the largest speed
of the surface along itself. Below the speed `CREEP` g runs linearly through the middle of its values at rest: a slider
that friction holds creeps.

The wave follows its drive as 1 - exp(-t/rise).

Integration: Alexander's SDIRK method of order 2, L-stable, in steps of at most `MAX_STEP`, `FAST_STEP` while the wave
changes; velocities by Newton's method. Tables are read by cubic interpolation over four neighbours.
"""

from studies.export.reduced_plane.plane_force_tables import element_force
from studies.export.reduced_plane.plane_integration import advance, begin

__all__ = ["advance", "begin", "element_force"]
# in the order of their C in one file
MODULES = tuple("plane_index plane_matrix plane_cycle plane_force_tables plane_integration".split())
