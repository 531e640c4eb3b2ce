"""Indices into the flat arrays of parameters and state of the averaged motor, in Python and in C.

tau = sqrt(s)/(sqrt(s) + sqrt(h + s)) and nu = V/(v_1 s) are the axes of the force tables, with the mean approach h, the
normal amplitude s and the slider velocity V; R(tau) is the table of the mean normal force, g(tau, nu) that of the mean
tangential force (`studies.export.reduced_motor`).
"""

import numpy as np

Array = np.ndarray

# of the parameters (a flat array of doubles)
MASS = 0
NORMAL_DAMPING = 1
TANGENTIAL_DAMPING = 2
CONTACT_DAMPING = 3
FRICTION = 4
LIMIT_SLOPE = 5
STIFFNESS = 6  # n K of all contacts, N/m^e
EXPONENT = 7  # 1.5 or 1
TAU_NODES = 8  # number of tau nodes
NU_NODES = 9  # number of nodes of each side of nu
DRIVES = 10  # 1 or 2
MAX_STEP = 11
FAST_STEP = 12
RING_STEP = 13
DEAD_BOUNCE = 14  # relative to the approach at rest: below it the approach follows the wave at once
FIRST_DRIVE = 15
# of the parameters of each drive, from its first on
AMPLITUDE = 0  # largest |u_z| of the contacts per unit of the drive, m: s of a steady wave
SATURATION = 1  # v_1, (m/s)/m: from V = v_1 s on friction has one direction throughout the cycle
RESPONSE_NODES = 2  # 0: the wave follows at once
RESPONSE_STEP = 3  # s
POWER = 4  # W per squared unit of the drive
LOADS = 5  # where the table R begins
FORCES = 6  # where the table g begins
RESPONSE = 7  # where the step response begins, real and imaginary part
FACING = 8  # 1, or -1 where the table g is that of the mirrored wave
DRIVE_SIZE = 9

# of the state (a flat array of doubles)
TIME = 0
POSITION = 1
VELOCITY = 2
DEFORMATION = 3  # of contacts that stick, m; see `deformation`
APPROACH = 4
APPROACH_RATE = 5
STICKS = 6  # 1: the contact sticks
BOUNCES = 7  # 1: the slider bounces on the wave
SURFACE = 8  # normal amplitude under the slider, m
FORCE = 9  # Q, N
ACTIVE = 10  # drive whose wave counts
PRELOAD = 11  # of the last step, N
RIDE = 12  # mean approach on the wave, m
BOUNCE_RATE = 13  # angular frequency of the bounce about it, rad/s
PINNED = 14  # at the upper (1) or lower (-1) limit of a spring that slips; 0 where the contacts do not stick at all
DEPTH = 15  # approach that carries <P> without a wave, m; 0 if it and the next two must be computed again
LOWEST = 16  # deformations at which slip begins, m
HIGHEST = 17
CELL = 18  # cell of the table g that was read last, from 1 and with the sign of V; 0: none
CUBIC = 19  # 4 coefficients of the cubic over that cell, 19 to 22
HISTORY = 23
# of the history of each drive, from its first on
LEVEL = 0  # present value of the drive, zero or positive
COUNT = 1  # number of stored changes
SETTLED = 2  # sum of the changes that have settled
CHANGES = 3  # pairs (time, change)
ENTRIES = 48
HISTORY_SIZE = 99  # CHANGES + 2 ENTRIES
STATE_SIZE = 221  # HISTORY + 2 HISTORY_SIZE
