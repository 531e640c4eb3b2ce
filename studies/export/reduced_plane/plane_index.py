"""Indices of the flat arrays p (parameters) and state of the averaged motor in the plane, whose tables are one array.

Tables: for each element (share p, g_x, g_y at rest) over tau and phi, then g + p n over tau, phi, speed and angle
of the velocity, x and y alternating. Angles lie closer together about the waves' axes (`angle_position`);
one stands before the turn and two after it again.
"""

from typing import Any

Array = Any

# parameters
MASS = 0  # kg
INERTIA = 1  # kg m^2
DAMPING = 2  # R, N s/m
YAW_DAMPING = 3  # N m s
FRICTION = 4
STIFFNESS = 5  # K of all contacts, N/m^e
EXPONENT = 6
MOVES = 7  # 1: x and y are free
TURNS = 8  # 1: the yaw is free
ARMS_TURN = 9  # 1: the elements turn with the body
ELEMENTS = 10
DRIVES = 11
TAU_NODES = 12
PHI_NODES = 13
NU_NODES = 14  # of the speed
ANGLES = 15  # of a turn
MAX_TAU = 16  # of the table
SPEED = 17  # v_1, 1/s
CREEP = 18  # m/s
MAX_STEP = 19  # s
FAST_STEP = 20  # s
RISE = 21  # s
AMPLITUDE = 22  # and 23: largest |u_z| of a level of 1, m
AXIS = 24  # rad: direction of the waves' axis
AXES = 25  # number of axes in a turn about which the angles lie closer: 2 or 4
STEPS = 26  # in a cycle of one wave, of the coarser of two lengths; 0: the forces stand in tables
COMMON_CYCLES = 27  # of the fastest wave, in the common period of both
OMEGA = 28  # and 29: of each drive, rad/s
OMEGA_RATIO = 30  # and 31: to the fastest, with a common period
TILTS = 32  # 1: statics give the contacts' loads; 0: they have one height
LOAD_X = 33  # and 34: point of the preload over the largest arms
STEPS_OF_BOTH = 35  # in a cycle of the fastest of two waves
FIRST_ELEMENT = 36
ELEMENT_SIZE = 4
ELEMENT_X = 0  # m
ELEMENT_Y = 1
REST_TABLE = 2  # start in the tables
FORCE_TABLE = 3

# state
TIME = 0
POSE = 1  # x, y, yaw
RATES = 4
LEVEL = 7  # and 8: of the wave, in the unit of the drives
RESTS = 9  # 1: no element is faster than the creep
FORCE = 10  # Q_x, Q_y, moment
TAU = 13
PHI = 14
OUTSIDE = 15  # 1: the table did not reach as far
# work
STEP_FORCE = 16  # of the last evaluation
MATRIX = 19  # 3 x 4
TRIAL = 31
RESIDUAL = 34
START = 37
BASE = 40
FIRST_RATE = 43
NEW_RESIDUAL = 46
FOUND = 49  # g_x, g_y, share
WAVE = 52  # and 53: levels of both waves
CYCLES = 54  # of the fastest wave in the period
RATIO = 55  # and 56
FASTEST = 57  # rad/s
SLOPE = 58  # derivatives of g_x and g_y in v_x, v_y: xx, xy, yx, yy
NORMAL = 62  # of an element: mean normal force over its stiffness, its derivative, phase of the least approach
RIDES = 65  # preload under which the approaches stand, N
CYCLE_STEPS = 66
STATE_SIZE = 67
# behind them, for each element
ELEMENT_STATE = 2
APPROACH = 0  # mean, m
LOWEST = 1  # phase of the least one, rad of the fastest wave

# of an element whose forces are computed, in place of its tables
STIFFNESS_SHARE = 0
LIMIT_SLOPE = 1  # c
ARM_X = 2  # place in m, of the loads by statics
ARM_Y = 3
ORBIT = 4  # cosine and sine of u_x, u_y, u_z of the first wave and of the second for a level of 1, m
ORBIT_SIZE = 12
