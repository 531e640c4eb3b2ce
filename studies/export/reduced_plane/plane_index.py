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
FIRST_ELEMENT = 26
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
STATE_SIZE = 52
