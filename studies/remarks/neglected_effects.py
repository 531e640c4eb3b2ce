"""The list ``left_out`` of run.json: the effects that the models of a scene neglect, with reasons.

Each private function covers one part of the motor and yields pairs (condition, sentence). A sentence is listed if its
condition is true.
"""

from collections.abc import Iterator

import fem
from studies.model.contact_moduli import direction_dependence
from studies.model.model import Model
from studies.scene import Scene
from studies.solve.ring_up import RingUp

Conditions = Iterator[tuple[bool, str]]
UNCOUPLED = "out-of-plane displacement: uncoupled in this orientation"
NORMAL, TANGENTIAL = "viscous damping along z, R_n2", "viscous damping along x, R_t"


def left_out(
    model: Model, *, beam: bool = False, reason: str = "", ringing: RingUp | None = None, trajectories=()
) -> tuple[str, ...]:
    """Return the sentences about the effects that are neglected in the answer to a resolved scene.

    Parameters
    ----------
    model : Model
    beam : bool
        True if a beam model with finite apertures computes the surface motion.
    reason : str
        Why there is no beam (`studies.model.fem_objects.section_reason`).
    ringing : RingUp or None
        Ring-up of the surface in a burst; None if the slider stands over a transducer or a meshed piece.
    trajectories : sequence of (float, contact.Trajectory)
        Level (V or m) and motion of every burst.
    """
    scene, conditions = model.scene, list[tuple[bool, str]]()
    if scene.wave is not None:
        conditions.append((True, "stator, transducers and electric field: the surface motion is prescribed"))
    elif scene.transducer:
        conditions += [*_driven(model), *_diffraction(model, beam, reason), *_recovery(scene)]
        if scene.slider is not None and scene.burst is not None:
            conditions += _ring_up(scene.slider, ringing, trajectories)
    else:
        conditions += _free(model)
    conditions += _contact(model)
    return tuple(sentence for holds, sentence in conditions if holds)


def _free(model: Model) -> Conditions:
    """Yield the neglected effects of a free wave, in a scene without transducers."""
    fields = model.plain.fields
    yield True, "electrodes: the scene has no transducer"
    yield True, "finite elements along x: the wave is a mode of the section through the depth"
    plain = "the free wave is that of the plain stator; sawmotor study reflector computes their reflections"
    yield bool(model.scene.piece), f"meshed pieces: {plain}"
    yield "uy" not in fields, UNCOUPLED
    yield "phi" not in fields, "electric potential: the solid is not piezoelectric in this orientation"


def _driven(model: Model) -> Conditions:
    """Yield the neglected effects in the section of a driven stator."""
    stator, scene = model.plain, model.scene
    names = stator.fields
    symmetric = fem.media(stator.solids, names)[0].parity is not None
    thin = (stator.thickness + stator.coating) * scene.frequency < _surface_speed(stator, scene.frequency)
    follow = "they follow from the others, as x -> -x is a symmetry of this orientation"
    yield "uy" not in names, UNCOUPLED
    yield symmetric, f"half of the guided modes: {follow}"
    yield stator.above == "none", "electric field in the vacuum above: D_n = 0 on the bare surface"
    yield thin, "a Rayleigh wave: the plate is thinner than a wavelength, so that the wave is a plate mode"
    segments = model.stator.placement.whole is None
    yield segments, "finite elements in the uniform segments: the field there is a sum of guided modes"
    yield True, "the field inside the stator: only the motion of the surface is computed"


def _surface_speed(stator, frequency: float) -> float:
    """Return the velocity in m/s of the half-space's surface wave at a frequency in Hz, or 0 if it has none."""
    try:
        return fem.bound_wave(stator, frequency, "open").velocity
    except fem.ConvergenceError:
        return 0.0


def _diffraction(model: Model, beam: bool, reason: str) -> Conditions:
    """Yield the parts of the answer that neglect diffraction, with the reason."""
    if not beam:
        yield True, f"diffraction: the wave is that of the plane section ({reason})"
        return
    scene = model.scene
    where = "the field inside" if scene.driven_obliquely else "surface.csv and the field inside"
    burst, reflects = scene.burst is not None and scene.slider is not None, scene.stator.ends != "absorbing"
    anisotropic = len(scene.transducer) > 1 and not fem.isotropic_about_normal(model.solid)
    between = "beam spreading between the transducers: in this cut, reception is that of plane waves"
    returning = "beam spreading of the waves that return to the transducers: their circuit is that of the plane section"
    yield True, f"diffraction in {where}: plane waves are assumed there; --field adds surface_map.csv, with diffraction"
    yield burst, "diffraction in the shape of the burst's ring-up: that of the plane section is used"
    yield scene.crossed, "scattering of a beam by the metal of a transducer that it crosses"
    yield reflects, returning
    yield anisotropic and not reflects, between


def _recovery(scene: Scene) -> Conditions:
    """Yield the neglected effects in the circuit that recovers power."""
    recovery = scene.drive.recovery
    if recovery is not None:
        diodes = "harmonics of the rectifier and voltage drop of its diodes: it is taken as a resistance"
        yield recovery.rectifier is not None, diodes
        yield recovery.circulation, "phase errors and reflections in the return path: the combiner is ideal"


def _ring_up(slider, ringing: RingUp | None, trajectories) -> Conditions:
    """Yield the neglected parts of the ring-up and ring-down of the surface in a burst."""
    if ringing is None:
        yield True, "the burst's ring-up: the slider stands over a transducer or a meshed piece"
        return
    if slider.planar:
        yield True, "the shape of the burst's ring-up: an exponential one that costs the same time, see points' error"
        return
    count = len(trajectories)
    without_ring_down = sum(motion.rang == 0.0 for _, motion in trajectories)
    without_ring_up = sum(motion.method != "stepped" for _, motion in trajectories)
    bursts = f"in {without_ring_down} of {count} bursts the surface stops when the drive ends"
    yield without_ring_down > 0, f"the burst's ring-down: {bursts}"
    bursts = f"{without_ring_up} of {count} bursts, which are computed on a steady wave"
    yield without_ring_up > 0, f"the burst's ring-up ({ringing.sentence}) in {bursts}"
    differences = "differences of the burst's ring-up between the balls: that at the slider's centre is used for all"
    yield slider.computed_contacts > 1, differences


def _contact(model: Model) -> Conditions:
    """Yield the neglected effects in the slider and its contacts."""
    scene, slider = model.scene, model.scene.slider
    if slider is None:
        yield True, "slider and contact: the scene has none"
        return
    if slider.pillars is not None:
        yield from _pillars(scene)
        return
    merged = f"{slider.share - 1} of {slider.contacts} contacts: all move in phase, and one of them is computed"
    yield slider.share > 1, merged
    yield scene.burst is None, "motion from rest: without a burst, the periodic state is computed directly"
    memory = f"in the {slider.tangential_law} law, the friction force depends on the present motion only"
    yield not slider.remembers, f"memory of the contact: {memory}"
    reaction = "reaction of the tangential spring on the normal motion: slider.reciprocal is false"
    yield not slider.reciprocal, reaction
    for key, damper in (("contact", "damping in the contact, R_n1"), ("normal", NORMAL), ("tangential", TANGENTIAL)):
        yield getattr(slider.damping, key) == 0, f"{damper}: slider.damping.{key} is zero"
    if scene.stator is not None:
        sizes = direction_dependence(model.solid)
        yield bool(sizes), f"the contact's dependence on direction: {sizes}"
        fixed = scene.burst is not None and slider.travel is False
        yield fixed, "change of the wave along the slider's travel: slider.travel is false"
    yield True, "the slider's reaction on the wave"
    if slider.planar:
        yield from _plane(model)


def _plane(model: Model) -> Conditions:
    """Yield the neglected effects of a motion in the plane."""
    scene = model.scene
    two = "a contact has one tangential stiffness for all directions, which differs by some per cent on a crystal"
    yield scene.stator is not None and not fem.isotropic_about_normal(model.solid), f"two tangential stiffnesses: {two}"
    yield scene.slider.turns, "spin of a contact about its own normal: see model_error for its size"
    other = "power and heat are those of the sources at the first frequency"
    yield scene.drive is not None and len(scene.drive.frequencies) > 1, f"power at other frequencies: {other}"


def _pillars(scene: Scene) -> Conditions:
    """Yield the neglected effects in a slider on pillars."""
    slider, pillars = scene.slider, scene.slider.pillars
    known_compliance = scene.wave is None or scene.wave.compliance is not None
    yield True, "bounce and vibration of the slider: it is too heavy to follow the wave within a cycle"
    yield scene.burst is None, "motion from rest: without a burst, the averaged equilibrium is computed directly"
    yield not known_compliance, "the slider's reaction on the wave: wave.compliance is absent"
    yield known_compliance and slider.loading is False, "the slider's reaction on the wave: slider.loading is false"
    if known_compliance and slider.loading is not False:
        overtones = "overtones that run back" if slider.loading == "harmonics" else "overtones of the wave"
        yield True, f"{overtones}, and scattering by pillars into other waves: see model_error for their sizes"
        no_part = "the transducers reflect no part of the wave that the slider has reflected"
        yield scene.stator is not None, f"second reflections: {no_part}"
    yield not pillars.interaction, "stiffening of pillars by their neighbours: slider.pillars.interaction is false"
    yield pillars.height is None, "the pillars' own compliance: slider.pillars.height is absent"
    yield slider.damping.tangential == 0, f"{TANGENTIAL}: slider.damping.tangential is zero"
