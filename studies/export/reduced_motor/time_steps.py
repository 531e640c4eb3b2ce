"""Integration of the motor in time under constant inputs: wave, bounce, stick and slip."""

from math import exp

from contact.jit.compiled import compiled, native
from studies.export.reduced_motor import index
from studies.export.reduced_motor.bounce import bounce_step, settle, steady_approach, update_steady_approach
from studies.export.reduced_motor.contact_spring import spring_deformation
from studies.export.reduced_motor.force_tables import bounded, steady_load
from studies.export.reduced_motor.index import Array
from studies.export.reduced_motor.sliding import glide, slip_step
from studies.export.reduced_motor.sticking import hold, rests, stick_step
from studies.export.reduced_motor.surface_wave import change_drive, forget, wave


@native("f1 f1 f1 f f")
def begin(p: Array, tables: Array, state: Array, preload: float, force: float) -> int:
    """Put the slider at rest at time 0 and position 0, its contacts deformed by an external force in N; return 0."""
    i: int = 0
    while i < index.STATE_SIZE:
        state[i] = 0.0
        i = i + 1
    state[index.APPROACH] = steady_approach(p, tables, 0, 0.0, preload, 0)
    state[index.STICKS] = 1.0
    load = steady_load(p, tables, 0, state[index.APPROACH], 0.0, preload)
    slip_limit = p[index.FRICTION] * load
    held = bounded(-force, -slip_limit, slip_limit)
    state[index.DEFORMATION] = spring_deformation(p, tables, load, held)
    state[index.FORCE] = held
    return 0


@compiled
def warm(p: Array, state: Array, level: float, duration: float) -> float:
    """Advance the stator's mean temperature, exactly for a constant level; it does not act on the motion."""
    own: int = index.FIRST_DRIVE
    if p[index.THERMAL_TIME] > 0.0:
        if level < 0.0 and p[index.DRIVES] > 1.5:
            own = index.FIRST_DRIVE + index.DRIVE_SIZE
        steady = p[own + index.WARMTH] * level * level
        left = exp(-duration / p[index.THERMAL_TIME])
        state[index.TEMPERATURE] = steady + (state[index.TEMPERATURE] - steady) * left
    return 0.0


@native("f1 f1 f1 f f f f")
def advance(p: Array, tables: Array, state: Array, level: float, force: float, preload: float, duration: float) -> int:
    """Advance the motor by a duration in s under constant inputs; return 0, or 1 if a number is not finite.

    `level`: of the drive, V or m, negative for the second drive; `force`: external, N along +x; `preload`: N, positive.
    In the code s is the normal amplitude of the wave and h the mean approach, both in m.
    """
    drive: int = 0
    regime_changes: int = 0
    two_drives: int = int(p[index.DRIVES]) - 1
    changed = change_drive(p, state, 0, max(level, 0.0))
    if two_drives == 1:
        changed = abs(changed) + abs(change_drive(p, state, 1, max(-level, 0.0)))
    warm(p, state, level, duration)
    start = state[index.TIME]
    done = 0.0  # part of the duration, s
    # number of changes to which the surface has not settled; while there are any the wave varies
    unsettled = state[index.HISTORY + index.COUNT]
    if two_drives == 1:
        unsettled = unsettled + state[index.HISTORY + index.HISTORY_SIZE + index.COUNT]
    # above 0: quantities that depend on the wave and the preload must be computed again
    outdated = 1.0 if changed != 0.0 or state[index.PRELOAD] != preload else 0.0
    state[index.PRELOAD] = preload
    while done < duration * (1.0 - 1e-12):
        # 1. The wave now, that of the drive with the larger amplitude; the approach and the bounce on it.
        if unsettled > 0.0:
            unsettled = forget(p, state, 0)
            if two_drives == 1:
                unsettled = unsettled + forget(p, state, 1)
            if unsettled == 0.0:
                outdated = outdated + 1.0
        if unsettled > 0.0 or outdated > 0.0:
            outdated = 0.0
            s = wave(p, tables, state, 0, state[index.TIME])
            drive = 0
            if two_drives == 1:
                other = wave(p, tables, state, 1, state[index.TIME])
                if other > s:
                    drive = 1
                    s = other
            state[index.ACTIVE] = drive
            state[index.SURFACE] = s
            state[index.DEPTH] = 0.0
            state[index.CELL] = 0.0
            update_steady_approach(p, tables, state, drive, s, preload)
            settle(p, state, s)
        elif state[index.BOUNCES] > 0.5:
            settle(p, state, state[index.SURFACE])
        drive = int(state[index.ACTIVE])
        # 2. On a steady wave without bounce: the whole rest, or up to the end of slip or stick.
        if unsettled == 0.0 and state[index.BOUNCES] < 0.5:
            if state[index.STICKS] < 0.5:
                done = duration - glide(p, tables, state, force, preload, duration - done)
            elif rests(p, tables, state, force, preload) > 0.5:
                done = duration
            else:
                done = duration - hold(p, tables, state, force, preload, duration - done)
            state[index.TIME] = start + done
        # 3. Otherwise one step with the wave and the approach in its middle; slip and stick may alternate within it.
        if done < duration * (1.0 - 1e-12):
            step = p[index.MAX_STEP]
            if unsettled > 0.0 or state[index.STICKS] > 0.5:
                step = p[index.FAST_STEP]
            elif state[index.BOUNCES] > 0.5:  # on a surface at rest contacts stick and slip in turn
                step = p[index.RING_STEP] if state[index.SURFACE] > 0.0 else p[index.FAST_STEP]
            step = min(step, duration - done)
            s = state[index.SURFACE]
            if unsettled > 0.0:
                s = wave(p, tables, state, drive, state[index.TIME] + 0.5 * step)
            h = state[index.APPROACH]
            if state[index.BOUNCES] > 0.5:
                h = bounce_step(p, tables, state, drive, s, preload, step)
            left = step
            regime_changes = 0
            while left > 0.0 and regime_changes < 4:
                if state[index.STICKS] > 0.5:
                    left = stick_step(p, tables, state, h, s, force, left)
                else:
                    left = slip_step(p, tables, state, h, s, force, left)
                regime_changes = regime_changes + 1
            done = done + step
            state[index.TIME] = start + done
    if unsettled > 0.0:
        state[index.SURFACE] = wave(p, tables, state, int(state[index.ACTIVE]), state[index.TIME])
    total = state[index.POSITION] + state[index.VELOCITY] + state[index.APPROACH] + state[index.DEFORMATION]
    return 0 if total - total == 0.0 else 1  # inf - inf and nan - nan are not 0
