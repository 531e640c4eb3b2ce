"""The codes that kernels pass around: kinds of law, shapes, regimes, events, and why a computation ended.

Also the entries of a state and of a record, which every solver shares. The entries of an array that one solver uses
alone stand beside that array. No two enumerations of the package have the same name.
"""

from enum import IntEnum


class Tangential(IntEnum):
    """Kind of tangential law; the hysteretic one has a potential, so that a reciprocal force would add nothing."""

    ELASTIC = 0
    RECIPROCAL = 1
    HYSTERETIC = 2


class Shape(IntEnum):
    """Shape of each contact."""

    SPHERE = 0
    PUNCH = 1


class Regime(IntEnum):
    """Regime of a contact at an instant; the last two belong to the hysteretic law, instead of stick."""

    SEPARATED = 0
    STICK = 1
    SLIP = 2
    CREEP = 3
    ANNULUS = 4  # slip of an outer annulus
    GROW = 5  # an edge that grows without slip


class Guard(IntEnum):
    """Numbers of the guards, by regime: what each is positive for. All regimes have GAP, the others share numbers."""

    GAP = 0  # the contact is open (separated) or closed (all other regimes)
    STICK_LIMIT = 1  # deformation within the slip limit
    STICK_REVERSAL = 2  # deformation of the present sign
    SLIP_SPEED = 1  # slip or slip of an annulus goes on
    CREEP_SPEED = 1  # slower than the stick band
    CREEP_LIMIT = 2  # deformation beyond the slip limit
    ANNULUS_PIECE = 2  # the front has not come to the inner end of its piece of memory
    ANNULUS_EDGE = 3  # the front is inside the edge
    GROW_FORWARD = 1  # no slip forward
    GROW_BACKWARD = 2  # no slip backward


# the last guard of each regime, by `Regime`
LAST_GUARD = tuple(map(int, (
    Guard.GAP, Guard.STICK_REVERSAL, Guard.SLIP_SPEED, Guard.CREEP_LIMIT, Guard.ANNULUS_EDGE, Guard.GROW_BACKWARD,
)))  # fmt: skip


class Event(IntEnum):
    """Kind of an event, and its index in the tally of a run."""

    CONTACT = 0
    RELEASE = 1
    STICK_TO_SLIP = 2
    SLIP_TO_STICK = 3
    REVERSAL = 4
    GRAZE = 5
    WIPE_OUT = 11  # a piece of memory


class WorkCount(IntEnum):
    """Indices of the work in the same tally."""

    SEGMENTS = 6
    HALVINGS = 7
    SWEEPS = 8
    CYCLES = 9
    CHATTER = 10  # events at one instant beyond one per contact


class AttemptOutcome(IntEnum):
    """Outcome of an attempt to compute a segment."""

    ACCEPTED = 0
    TOO_ROUGH = 1
    NOT_CONVERGED = 2
    EVENT_AT_START = 3


class SlipWindow(IntEnum):
    """Whether a contact at its limit slips towards a side: never, in a window of the cycle, always."""

    NEVER = 0
    WINDOW = 1
    ALWAYS = 2


class SteadyRegime(IntEnum):
    """Regime of a steady state over a cycle."""

    UNKNOWN = 0
    STICK = 1
    SLIP = 2
    INTERMITTENT = 3


class Status(IntEnum):
    """Why a computation ended."""

    DONE = 0
    STICKS = 1  # a contact sticks through whole cycles
    UNSETTLED = 2  # no equilibrium or no finite motion was reached
    RUNAWAY = 3  # no velocity balances the load
    NEAR_THRESHOLD = 4  # held, but so near the threshold that averaging cannot tell
    NOT_FINITE = 5
    TOO_MANY = 6  # events
    FULL = 7  # memory
    STIFF = 8  # Picard's iteration does not converge, however short the segment


class At(IntEnum):
    """Indices in a state: of the slider, then the deformations of the contacts."""

    POSITION = 0  # z_s
    NORMAL_VELOCITY = 1  # z_s'
    VELOCITY = 2  # v
    DEFORMATIONS = 3  # the first of them, x_1


class Recorded(IntEnum):
    """Columns of the record of a run."""

    VELOCITY = 0
    POSITION = 1
    MEAN_VELOCITY = 2
