"""The whole motor moved on under constant inputs: wave, bounce, stick and slip in turn."""

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.bounce import fall, ride, settle
from studies.export.reduced_motor.contact_spring import rest_approach, spring_deformation
from studies.export.reduced_motor.force_tables import bounded
from studies.export.reduced_motor.index import Array
from studies.export.reduced_motor.sliding import glide, slip_step
from studies.export.reduced_motor.sticking import hold, stick_step
from studies.export.reduced_motor.surface_wave import change_drive, forget, wave


@compiled
def begin(p: Array, tables: Array, state: Array, preload: float, force: float) -> float:
    """Put the slider at rest at time 0 and position 0, its contacts deformed by an external force in N; return 0."""
    i: int = 0
    while i < index.STATE_SIZE:
        state[i] = 0.0
        i = i + 1
    state[index.APPROACH] = rest_approach(p, preload)
    state[index.STICKS] = 1.0
    limit = p[index.FRICTION] * preload
    held = bounded(-force, -limit, limit)
    state[index.DEFORMATION] = spring_deformation(p, preload, held)
    state[index.FORCE] = held
    return 0.0


@compiled
def advance(
    p: Array, tables: Array, state: Array, level: float, force: float, preload: float, duration: float
) -> float:
    """Move the motor by a duration in s under constant inputs; return 0, or 1 where a number is not finite.

    `level`: of the drive, V or m, negative for the second drive; `force`: external, N along +x; `preload`: N, positive.
    """
    drive: int = 0
    second: int = int(p[index.DRIVES]) - 1
    changed = change_drive(p, state, 0, max(level, 0.0))
    if second == 1:
        changed = abs(changed) + abs(change_drive(p, state, 1, max(-level, 0.0)))
    done = 0.0
    start = state[index.TIME]
    pending = state[index.HISTORY + index.COUNT]
    if second == 1:
        pending = pending + state[index.HISTORY + index.HISTORY_SIZE + index.COUNT]
    anew = 1.0 if changed != 0.0 or state[index.PRELOAD] != preload else 0.0
    state[index.PRELOAD] = preload
    while done < duration * (1.0 - 1e-12):
        if pending > 0.0:
            pending = forget(p, state, 0)
            if second == 1:
                pending = pending + forget(p, state, 1)
            if pending == 0.0:
                anew = anew + 1.0
        if pending > 0.0 or anew > 0.0:
            anew = 0.0
            s = wave(p, tables, state, 0, state[index.TIME])
            drive = 0
            if second == 1:
                other = wave(p, tables, state, 1, state[index.TIME])
                if other > s:
                    drive = 1
                    s = other
            state[index.ACTIVE] = drive
            state[index.SURFACE] = s
            state[index.DEPTH] = 0.0
            state[index.CELL] = 0.0
            ride(p, tables, state, drive, s, preload)
            settle(p, state, s)
        elif state[index.BOUNCES] > 0.5:
            settle(p, state, state[index.SURFACE])
        drive = int(state[index.ACTIVE])
        if pending == 0.0 and state[index.BOUNCES] < 0.5:
            if state[index.STICKS] < 0.5:
                done = duration - glide(p, tables, state, force, preload, duration - done)
            elif (
                state[index.VELOCITY] == 0.0 and abs(state[index.FORCE] + force) <= 1e-12 * p[index.FRICTION] * preload
            ):
                done = duration  # at rest
            else:
                done = duration - hold(p, tables, state, force, preload, duration - done)
            state[index.TIME] = start + done
        if done < duration * (1.0 - 1e-12):
            d = p[index.MAX_STEP]
            if pending > 0.0 or state[index.STICKS] > 0.5:
                d = p[index.FAST_STEP]
            elif state[index.BOUNCES] > 0.5:  # on a surface at rest contacts stick and slip in turn
                d = p[index.RING_STEP] if state[index.SURFACE] > 0.0 else p[index.FAST_STEP]
            d = min(d, duration - done)
            s = state[index.SURFACE]
            if pending > 0.0:
                s = wave(p, tables, state, drive, state[index.TIME] + 0.5 * d)
            h = state[index.APPROACH]
            if state[index.BOUNCES] > 0.5:
                h = fall(p, tables, state, drive, s, preload, d)
            left = d
            turns: int = 0
            while left > 0.0 and turns < 4:
                if state[index.STICKS] > 0.5:
                    left = stick_step(p, tables, state, h, s, force, left)
                else:
                    left = slip_step(p, tables, state, h, s, force, left)
                turns = turns + 1
            done = done + d
            state[index.TIME] = start + done
    if pending > 0.0:
        state[index.SURFACE] = wave(p, tables, state, int(state[index.ACTIVE]), state[index.TIME])
    check = state[index.POSITION] + state[index.VELOCITY] + state[index.APPROACH] + state[index.DEFORMATION]
    return 0.0 if check - check == 0.0 else 1.0
