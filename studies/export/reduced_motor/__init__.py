r"""The averaged motor as step functions in a subset of Python that `c_translation` turns into C.

Model
-----
The slider is heavy on the time scale of the wave, so that the cycle means of the contact forces move it (first-order
averaging, as `contact.burst(method="averaged")`)::

    m h'' = preload - <P>(h, s) (1 + chi h') - d_n h'         h: mean approach of the contacts, m
    m V'  = Q - d_t V + F                                     V: slider velocity along +x, m/s; F: external force
    slip:   Q = mu <P> g(tau, nu),   tau = sqrt(s)/(sqrt(s) + sqrt(h + s)),   nu = V/(v_1 s)
    stick:  Q = mu <P> (1 - (1 - |x|/(c h_0))^e) sign x,   x' = -V,   x within the limits of slip

s is the largest normal amplitude |u_z| of the contacts, v_1 s the slider velocity beyond which friction has one
direction throughout the cycle, and <P> = n K (h + s)^e R(tau), with e = 3/2 for spheres and 1 for flat punches.  All
orbits grow with the drive, so that mean forces depend on (h, s, V) through the two ratios tau and nu only: R and g are
tables over them that hold for every amplitude, preload and mass.  g jumps at V = 0 where the contacts can stick; the
two sides of the jump are the limits of slip, and the spring between them is that of a surface at rest, h_0 its approach
under <P>: exact without a wave, and an approximation on a wave below the threshold.

The wave follows its drive by the step response of the surface under the slider, a table over time: inputs are
piecewise constant, and the last `ENTRIES` changes of each drive are stored.  If two drives act at the same time, only
the larger wave counts.

Integration: slip by the explicit midpoint rule in steps of at most `MAX_STEP`; stick by Nystrom's method of order 4 in
steps of `RING_STEP`; the approach by the classical Runge-Kutta method; `FAST_STEP` while the wave changes and while
the slider bounces on a surface at rest. Ends of stick and slip are located within their step. Tables are read by cubic
interpolation over four neighbours; on a steady wave (`glide`, `hold`) constant values are read once.
"""

from studies.export.reduced_motor.approach import steady_approach
from studies.export.reduced_motor.contact_spring import (
    contact_force,
    power,
    power_share,
    rest_approach,
    spring_deformation,
    spring_share,
)
from studies.export.reduced_motor.force_tables import (
    friction_force,
    mean_load,
    normal_force,
    share_at,
    slip_force,
    steady_load,
    traction_share,
)
from studies.export.reduced_motor.sticking import deformation
from studies.export.reduced_motor.time_steps import advance, begin

__all__ = [
    "advance",
    "begin",
    "contact_force",
    "deformation",
    "friction_force",
    "mean_load",
    "normal_force",
    "power",
    "power_share",
    "rest_approach",
    "share_at",
    "slip_force",
    "spring_deformation",
    "spring_share",
    "steady_approach",
    "steady_load",
    "traction_share",
]
# in the order of their C in one file
MODULES = tuple("index contact_spring force_tables surface_wave bounce sticking sliding time_steps".split())
