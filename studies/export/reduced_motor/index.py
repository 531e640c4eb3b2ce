"""Indices into the flat arrays of parameters and state of the averaged motor, in Python and in C.

tau = sqrt(s)/(sqrt(s) + sqrt(h + s)) and nu = V/(v_1 s) are the axes of the force tables, with the mean approach h, the
normal amplitude s and the slider velocity V; R(tau) is the table of the mean normal force, g(tau, nu) that of the mean
tangential force (`studies.export.reduced_motor`).
"""

import numpy as np

Array = np.ndarray

# Indices of the parameters (a flat array of doubles)
MASS = 0  # kg
NORMAL_DAMPING = 1  # d_n, N s/m
TANGENTIAL_DAMPING = 2  # d_t, N s/m
CONTACT_DAMPING = 3  # chi, s/m
FRICTION = 4  # coefficient mu
LIMIT_SLOPE = 5  # c: contacts slip at a deformation of c times the approach
STIFFNESS = 6  # n K of all contacts, N/m^e
EXPONENT = 7  # e: 1.5 for spheres, 1 for flat punches
TAU_NODES = 8  # number of tau nodes
NU_NODES = 9  # number of nodes of each side of nu
DRIVES = 10  # 1 or 2
MAX_STEP = 11  # longest time step of slip on a steady wave, s
FAST_STEP = 12  # that of all other motion, s
RING_STEP = 13  # that of sticking contacts on a steady wave, and of slip during a bounce on a wave, s
DEAD_BOUNCE = 14  # amplitude at which a bounce ends, over |steady approach| + normal amplitude (`bounce.settle`)
THERMAL_TIME = 15  # time constant of the stator's mean temperature, s; 0: its temperature is not known
# Of contacts that attract each other, or whose force is no power of the approach (`contact_spring`, `force_tables`)
CONTACTS = 16  # number n
PULL = 17  # constant attraction of each closed contact, N
START = 18  # approach at which a contact of a table opens, m; 0 of a power
MAKES = 19  # crest h + s from which contacts that open in each cycle close again, m
FORCE_NODES = 20  # of the table of the force at rest; 0: a power
FORCE_TABLE = 21  # where that table begins
FORCE_SCALE = 22  # L of the places of its nodes, m (`contact_spring.place`)
DEEPEST = 23  # approach over START of the last node, m
SPRING = 24  # 1: sticking contacts have the spring of the table; 0: that of a power
DEPTHS = 25  # number of nodes of the crest's approach in R and g; 0: R and g hold at each
SPLIT = 26  # rows of R and g whose contacts do not open in the cycle
FASTEST = 27  # sqrt(nu) of the last column of g
FIRST_DRIVE = 28
# Indices of the parameters of each drive; the block of the first one begins at FIRST_DRIVE
AMPLITUDE = 0  # largest |u_z| of the contacts per unit of the drive, m: s of a steady wave
SATURATION = 1  # v_1, (m/s)/m: from V = v_1 s on friction has one direction throughout the cycle
RESPONSE_NODES = 2  # 0: the wave follows at once
RESPONSE_STEP = 3  # s
POWER = 4  # W per squared unit of the drive
LOADS = 5  # where the table R begins
FORCES = 6  # where the table g begins
RESPONSE = 7  # where the step response begins, real and imaginary part
FACING = 8  # 1, or -1 where the table g is that of the mirrored wave
WARMTH = 9  # steady mean rise of the stator above its surroundings, K per squared unit of the drive
PULLS = 10  # where the table of the mean attraction over the repulsion at the crest begins; -1: none
SIZES = 11  # where the normal amplitudes of the contacts over the largest begin
DRIVE_SIZE = 12

# Indices of the state (a flat array of doubles)
TIME = 0  # s
POSITION = 1  # m
VELOCITY = 2  # V, m/s
DEFORMATION = 3  # of contacts that stick, m; see `deformation`
APPROACH = 4  # mean approach h, m
APPROACH_RATE = 5  # m/s
STICKS = 6  # 1: the contact sticks
BOUNCES = 7  # 1: the slider bounces on the wave
SURFACE = 8  # normal amplitude s of the wave under the slider, m
FORCE = 9  # mean tangential force Q on the slider, N
ACTIVE = 10  # drive whose wave counts
PRELOAD = 11  # of the last step, N
STEADY_APPROACH = 12  # mean approach at which <P> is the preload on the present wave, m
BOUNCE_OMEGA = 13  # angular frequency of the bounce about it, rad/s
PINNED = 14  # at the upper (1) or lower (-1) limit of a spring that slips; 0 where the contacts do not stick at all
DEPTH = 15  # approach that carries <P> without a wave, m; 0 if it and the next two must be computed again
LOWEST = 16  # deformation at which the slider begins to slip towards +x, m
HIGHEST = 17  # and towards -x, m
CELL = 18  # cell of the table g that was read last, from 1 and with the sign of V; 0: none
CUBIC = 19  # 4 coefficients of the cubic over that cell, 19 to 22
TEMPERATURE = 23  # mean rise of the stator above its surroundings, K
HISTORY = 24
# Indices of the history of each drive; that of the first one begins at HISTORY
LEVEL = 0  # present value of the drive, zero or positive
COUNT = 1  # number of stored changes
SETTLED = 2  # sum of the changes that have settled
CHANGES = 3  # pairs (time in s, change of the drive)
ENTRIES = 48  # largest number of stored changes
HISTORY_SIZE = 99  # CHANGES + 2 ENTRIES
STATE_SIZE = 222  # HISTORY + 2 HISTORY_SIZE
