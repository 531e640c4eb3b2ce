"""Scenes that are refused: key, rule, value and unit in one sentence, whoever is asked to compute them.

One table for each scene that is spoilt: one that ships, or one of tests/studies/scenes.  A row holds the settings,
separated by semicolons, of which ``-KEY`` removes a key, and after the bar parts of the sentence, which begins with the
first of them.  ``SCENE > STUDY`` are scenes that a run takes and a study or an export does not, most as they are.
What a mesh or a table of pillars is refused for is tested where such files are read (test_piece_scene, test_pillars).
"""

import shutil

import pytest

from studies import Scene, SceneError, Wave, run
from studies.export.averaged_motor import averaged_motor
from studies.export.mask_files import gds_files
from studies.model.resolve import resolved
from studies.report.motor_datasheet import datasheet
from studies.scene import read_table
from studies.study_list import module
from tests.fem.drawings import chip, rectangle
from tests.studies.conftest import SMALL
from tests.studies.settings import assigned

NEGATIVE = [[-1e11 if i == j == 2 else 1e11 * (i == j) for j in range(6)] for i in range(6)]
SHORT = {
    "FALLING": "slider.friction_coefficient={static=0.3, sliding=0.15, speed=0.05}",
    "MM_PERIODS": "transducer.0.period=1 mm; transducer.1.period=1 mm",
    "NO_MODULI": "-slider.effective_modulus; -slider.tangential_modulus",
    "NO_GRID": "-slider.pillars.rows; -slider.pillars.columns",
    "PILLARS": """slider={mass="0.3 g", preload="1 mN", friction_coefficient=0.18, ball="silicon"}; """
    """slider.position=4.5 mm; slider.pillars={diameter="20 um", height="2 um", pitch="40 um", rows=4, columns=4}""",
    "CUT": "stator.material=LiNbO3 (Kovacs); stator.orientation=128YX",
    "STRIP": "piece.0.file=s.msh",
    "ALU": """MATERIAL={strip="aluminium"}""",
    "MATERIAL=": "piece.0.materials=",
    "ELECTRODE=": "piece.0.electrodes=",
    "TWO": 'slider.contacts=["-1 mm", "1 mm"]',
    "NEGATIVE_STIFFNESS": f"stator.material={{stiffness={NEGATIVE}, coupling={[[0.0] * 6] * 3}, "
    "permittivity=[[10, 0, 0], [0, 10, 0], [0, 0, 10]], density=5000}",
    "SLIDER": 'slider={mass=1, preload=1, friction_coefficient=1, ball="steel", contacts=1, radius=1, position=0.01}',
}
TABLES = {
    "twente": """
drive.frequency=9.6 | drive.frequency is 9.6 Hz, at which 10 periods ... of 160 mm: did you mean "9.6 MHz"?
drive.frequency=2200.0 | drive.frequency is 2200 Hz ... did you mean "2200 kHz"? A number without a unit is in Hz
slider.mas=1 | slider.mas ... did you mean mass?
sliders.mass=1 | sliders ... did you mean slider?
transducer.1.centre=1 | transducer.1.centre ... did you mean center?
slider.damping.tangental=1 | slider.damping.tangental ... did you mean tangential?
slider.mass=0 | slider.mass ... positive and finite ... 0.0 kg
slider.mass=-1 | slider.mass ... positive ... -1.0 kg
slider.mass=nan | slider.mass ... finite ... nan kg
slider.mass=inf | slider.mass ... finite ... inf kg
slider.mass=1e200 | slider.mass ... between 1e-30 and 1e+30 ... 1e+200 kg
slider.mass=1e-200 | slider.mass ... between 1e-30 and 1e+30 ... 1e-200 kg
drive.voltage=1e31 | drive.voltage ... between 0 and 1e+30 ... 1e+31 V
slider.mass=5 mm | slider.mass ... a mass ... '5 mm' ... a length
slider.mass=true | slider.mass ... True
slider.mass=2020-01-01 | slider.mass ... a mass ... '2020-01-01'
drive.frequency=2.2 Mhz | drive.frequency ... 'Mhz' is no known unit; did you mean MHz?
stator.orientation=Q | stator.orientation ... "128YX" or "ST-X" or another cut ... or three angles ... 'Q'
slider.preload=-1 mN | slider.preload ... zero or positive ... -0.001 N
slider.preload=wait | slider.preload ... "weight" ... 'wait'
slider.friction_coefficient=-0.1 | slider.friction_coefficient ... -0.1
slider.ball="steel" | slider.ball ... effective_modulus
slider.contacts=0 | slider.contacts ... integer from 1 ... 0
slider.contacts=[] | slider.contacts ... empty list
slider.contacts=["1 mm", 0.001] | slider.contacts ... differ
slider.contacts=["1 mm", "1 kg"] | slider.contacts.1 ... '1 kg'
slider.law=hertz | slider.law ... "elastic" ... 'hertz'
slider.reciprocal=1 | slider.reciprocal ... true or false
slider.position=170 mm | slider.position ... 0 to 160 mm ... 170 mm
slider.contacts=["0 mm", "81 mm"] | slider.position ... 161 mm
slider=3 | slider ... block of keys ... 3
drive.voltage=[] | drive.voltage ... empty list
drive.voltage=[1, -2] | drive.voltage.1 ... zero or positive ... -2.0 V
drive.voltage=5 A | drive.voltage ... a voltage ... '5 A'
drive.frequency=0 | drive.frequency ... positive
drive.frequency=2.2 rad/s | drive.frequency ... a frequency
drive.frequency=center | transducer.0.period ... a length in m ... got 'half-space'
drive.transducer=lift | drive.transducer ... did you mean left?
drive.source_impedance=[-5, 0] | drive.source_impedance.0 ... -5.0 ohm
transducer.0.finger_pairs=0 | transducer.0.finger_pairs ... integer
transducer.0.finger_pairs=9.5 | transducer.0.finger_pairs ... 9.5
transducer.0.metallisation=1 | transducer.0.metallisation ... 0.001 and 0.999 ... 1.0
transducer.0.metallisation=0.9999999 | transducer.0.metallisation ... 0.001 and 0.999 ... 0.9999999
transducer.0.metallisation=1e-4 | transducer.0.metallisation ... 0.001 and 0.999 ... 0.0001
slider.a\x1eb=1 | slider.a\\x1eb ... is no key
transducer.0.termination=closed | transducer.0.termination ... "open" or "short"
transducer.0.termination=[1, 2, 3] | transducer.0.termination ... [resistance, reactance]
transducer.1.name=left | transducer.1.name ... 'left'
transducer.1.center=170 mm | transducer.1.center ... 0 to 160 mm ... 170 mm
transducer=4 | transducer ... [[transducer]]
transducer.1.aperture=36 mm | transducer.1.aperture ... at most stator.width, 35 mm ... 36 mm
stator.ends=open | stator.ends ... "absorbing" ... 'open'
stator.bottom=fre | stator.bottom ... did you mean free?
stator.orientation=128XY | stator.orientation ... did you mean 128YX?
stator.orientation=[1, 2] | stator.orientation ... three angles
stator.thickness=infinite | stator.thickness ... "half-space"
stator.length=-1 | stator.length ... -1.0 m
title=3 | title ... text
slider.heights=["1 nm"] | slider.heights needs slider.contacts as a list of positions
slider.contacts=[0, "5 mm"]; slider.heights=["1 nm"] | slider.heights must hold one height ... 2 contacts, got 1
slider.shape=punch; slider.law=hysteretic | slider.law must be "elastic" with shape = "punch"
slider.shape=cone | slider.shape
slider.law=hysteretic; slider.adhesion={work=0.05,model="DMT"} | slider.adhesion has no hysteretic law: choose "elastic"
slider.adhesion={work=0.05,model="JKRS"} | slider.adhesion.model must be "DMT" or "meniscus" or "JKR" or "Maugis"
slider.adhesion={work=0.05,model="meniscus"} | slider.adhesion.surface_tension is required and missing: the model
slider.adhesion={work=0.05,contact_angle="5 deg",model="DMT"} | slider.adhesion.contact_angle must be left out
slider.adhesion={surface_tension=1,contact_angle="95 deg",model="meniscus"} | slider.adhesion.contact_angle
slider.reciprocal=true; slider.adhesion={work=0.05,model="DMT"} | slider.reciprocal cannot be true where balls attract
slider.normal_law=no_law.py | slider.normal_law names the file 'no_law.py', which cannot be read
transducer.0.pattern=+-+ | transducer.0.pattern must have 20 signs, two ... got 3: '+-+'
transducer.1.split=true; transducer.1.pattern=+-+- | transducer.1.pattern must have 40 ... four
transducer.0.pattern=+-x- | transducer.0.pattern must be a text of the signs + - 0 o
transducer.0.pattern=1 | transducer.0.pattern must be a text ... got 1
transducer.0.pattern='' | transducer.0.pattern must be a text
transducer.1.finger_pairs=2; transducer.1.pattern=0000 | transducer.1.pattern must leave at least one finger
transducer.0.finger_pairs=2; transducer.0.pattern=+0+o | transducer.0.pattern must have + and - ... driven
transducer.0.split=1 | transducer.0.split must be true or false
transducer.0.cell=dart | transducer.0.cell must be "plain" or "DART" or "EWC" ... did you mean DART?
transducer.0.cell=DART; transducer.0.split=true | transducer.0.split must be absent with the cell DART
transducer.0.mirrored=true | transducer.0.mirrored must be absent with the cell plain
transducer.0.cell=EWC; transducer.0.pattern=+-+ | transducer.0.pattern must have 30 signs, three for each
transducer.0.apodisation=kaiser | transducer.0.apodisation must be
transducer.0.apodisation=[1, 0.5] | transducer.0.apodisation must be one number for each of the 20 fingers, got 2
transducer.0.apodisation=[1, 2] | transducer.0.apodisation.1 must be between 0 and 1, got 2.0
transducer.0.apodisation=cosine; drive.burst=1 ms | transducer.0.apodisation must be absent with drive.burst
transducer.0.slant=0.1; stator.sides=mirror | transducer.0.slant must be absent with stator.sides = mirror
transducer.0.slant=0.1; transducer.1.angle=30; stator.ends=absorbing | transducer.0.slant must be absent where
transducer.0.slant=0.1; drive.burst=1 ms | transducer.0.slant ... each strip rings up by itself ... drive steadily
transducer.0.slant_strips=0 | transducer.0.slant_strips must be an integer from 1 to 256
transducer.0.chirp=1.2 | transducer.0.chirp must be between -1 and 1, got 1.2
transducer.0.patern=+-+- | transducer.0.patern ... did you mean pattern?
drive.sources={left="fast"} | drive.sources.left must be a plain number or "amplitude at phase deg"
drive.sources={left="1 at ten deg"} | drive.sources.left must be a plain number
drive.sources={left="-1 at 10 deg"} | drive.sources.left must be a plain number
drive.sources={left=true} | drive.sources.left must be a plain number
drive.sources={left=1, middle=1} | drive.sources must name one of the transducers, got 'middle'
drive.sources={left=0, right=0} | drive.sources must have at least one amplitude that is not 0
drive.sources={} | drive.sources must be a table of transducers
drive.sources=left | drive.sources must be a table of transducers
drive.power=1 W; drive.source_impedance=50 | drive.voltage must be absent with drive.power
-drive.voltage; drive.power=1 W | drive.power needs a drive.source_impedance
-drive.voltage; drive.power=1 V | drive.power ... a power
drive.match=best | drive.match must be "none" or "auto" or one or more blocks
drive.match=auto; drive.source_impedance=[0, 9] | drive.match needs ... for "auto"
drive.match=[{series_M=1}] | drive.match.0.series_M is no key of a scene; did you mean
drive.match=[{series_L="1 nF"}] | drive.match.0.series_L ... an inductance
drive.match=[{series_L=1, shunt_C=1}] | drive.match.0 must be a table of one
drive.match=[{shunt_R=1, Q=3}] | drive.match.0.Q must be absent
drive.match=auto; drive.source_impedance=50; drive.sources={left=1, right=1} | drive.match must be ... several sources
drive.recovery.receiver=left | drive.recovery.receiver must name a transducer that is not driven, got 'left'
drive.recovery.receiver=rigth | drive.recovery.receiver must name ... right
drive.recovery={receiver="right", load=[0, 20]} | drive.recovery.load must have a resistance
drive.recovery={receiver="right", load=50, rectifier=50} | drive.recovery.load must be absent with
drive.recovery={receiver="right", efficiency=0} | drive.recovery.efficiency
drive.recovery={receiver="right", gain=2} | drive.recovery.gain is no key
drive.recovery.receiver=right; transducer.1.termination=50 | transducer.1.termination must be absent on the receiving
NO_MODULI; slider.ball=steal | slider.ball ... steel
NO_MODULI; slider.ball=PZT-4 | slider.ball ... isotropic
NO_MODULI; slider.ball=LiNbO3 (Ogi) | slider.ball ... isotropic
stator.material=PTZ8 | stator.material ... PZT-8
stator.material=no.toml | stator.material names the file 'no.toml', which cannot be read: No such file
stator.material=steel | transducer ... not piezoelectric
transducer.0.center=2 mm | transducer.0
transducer.0.center=136 mm | transducer.1.center ... off those of
transducer.0.finger_pairs=500 | transducer.0 ... stator
MM_PERIODS; transducer.1.center=20 mm | transducer.1.center must keep the fingers ... the former begin at 1
transducer.1.center=158 mm; transducer.1.period=1 mm | transducer.1.center ... 0 to 160 mm, ... to 16
drive.burst=1 h | drive.burst ... 364 s ... got 3600 s
wave={frequency="2.2 MHz", normal_amplitude="1 nm", tangential_ratio=0.7} | wave must not stand beside [stator]
slider.friction=1 | slider.friction is no key of a scene; did you mean friction_coefficient?
slider.mu=1 | slider.mu is no key of a scene; did you mean friction_coefficient?
slider.force=1 | slider.force is no key of a scene; did you mean preload?
transducer.0.finger=1 | transducer.0.finger is no key of a scene; did you mean finger_pairs?
transducer.0.metallization=1 | transducer.0.metallization is no key of a scene; did you mean metallisation?
transducer.0.pitch=1 | transducer.0.pitch is no key of a scene; did you mean period?
stator.cut=1 | stator.cut is no key of a scene; did you mean orientation?
stator.height=1 | stator.height is no key of a scene; did you mean thickness?
stator.Q=1 | stator.Q is no key of a scene; did you mean mechanical_quality?
drive.freq=1 | drive.freq is no key of a scene; did you mean frequency?
slider.damper=1 | slider.damper is no key of a scene; did you mean damping?
drive.frequency=2.2 mHz | drive.frequency must be a frequency ... ; did you mean 2.2 MHz?
slider.effective_modulus=64 mPa | slider.effective_modulus must be a stiffness ... ; did you mean 64 MPa?
slider.preload=5 MN | slider.preload must be a force ... ; did you mean 5 mN?
stator.length=5 Mm | stator.length must be a length ... ; did you mean 5 mm?
slider.mass=1 Mg | slider.mass must be a mass ... ; did you mean 1 mg?
drive.voltage='' | drive.voltage must be a voltage ... got ''
drive.voltage=5:60 | drive.voltage must be START:STOP:N ... got '5:60'
drive.voltage=1:2:3:4 | drive.voltage must be START:STOP:N ... got '1:2:3:4'
drive.voltage=5:60:x | drive.voltage must ask for 1 to 10000000 values, got 'x'
drive.voltage=5:60:0 | drive.voltage must ask for 1 to 10000000 values, got '0'
drive.voltage=5:60:99999999 | drive.voltage must ask for 1 to 10000000 values, got '99999999'
drive.voltage=5:60:1 | drive.voltage must ask for at least 2 values between different ends, got '5:60:1'
drive.voltage=-5:5:3 | drive.voltage.0 must be zero or positive, got -5.0 V
drive.voltage=nan:1:2 | drive.voltage must be a voltage ... got 'nan'
drive.voltage=1 A:2 A:2 | drive.voltage must be a voltage ... got '1 A': 'A' has another dimension
drive.voltage=5:1 kV:3 | drive.voltage must have a unit at both ends or at neither, got '5:1 kV:3'
slider.contacts=[["0 mm", "5 mm"], ["0 mm", "-18 mm"]] | slider.position ... got a contact at y = -18 mm
slider.contacts=[["0 mm", "18 mm"], ["0 mm", "-6 mm"]] | slider.position ... got a contact at y = 18 mm
-slider.radius | slider.radius is required and missing
-slider.mass | slider.mass is required and missing
-slider.position | slider.position is required and missing
-slider.contacts | slider.contacts is required and missing
-slider.preload | slider.preload is required and missing
-slider.friction_coefficient | slider.friction_coefficient is required and missing
-slider.effective_modulus | slider.effective_modulus is required and missing
-slider.tangential_modulus | slider.tangential_modulus is required and missing
-stator | stator is missing
-stator.material | stator.material is required and missing
-stator.thickness | stator.thickness is required and missing
-stator.width | stator.width is required and missing
-stator.ends | stator.ends is required and missing
-drive | drive is missing
-drive.voltage | drive.voltage is required and missing
-drive.transducer | drive.transducer is required and missing
-drive.frequency | drive.frequency is required and missing
""",
    "rayleigh": """
drive.frequency=center | drive.frequency ... transducer
drive.voltage=3 | drive.voltage ... transducer
drive.transducer=left | drive.transducer ... transducer
stator.material.densty=1 | stator.material ... 'PZT-8'
SLIDER | slider must be absent without a [[transducer]]
drive.match=[{series_L="2.6 uH", Q=80}] | drive.match must be absent without a [[transducer]]: nothing is driven
drive.sources={left=1} | drive.sources must be absent without a [[transducer]]
uncertain.stator.length=1 % | uncertain needs a [slider]
NEGATIVE_STIFFNESS | stator.material.stiffness must be positive definite; its smallest eigenvalue is -1e+11 Pa
""",
    "twente-contact": """
slider.position=1 mm | slider.position ... [wave]
slider.contacts=["1 mm"] | slider.contacts ... [wave]
wave.normal_amplitude=[] | wave.normal_amplitude ... empty list
wave.tangential_ratio=x | wave.tangential_ratio ... 'x'
drive.frequency=1 | wave ... [drive]
NO_MODULI; slider.ball=steel | slider.ball must be absent with [wave]
wave.burst=1e6 | wave.burst ... at most ... 2.2e+12 cycles ... hours ... 1e+06 s
wave.burst=4; slider.law=hysteretic | wave.burst ... 2.73 s ... got 4 s
slider.friction_coefficient={static=1, sliding=0.1, speed="3 m"} | slider.friction_coefficient.speed must be a velocity
slider.friction_coefficient={static=0.3, sliding=0.1} | slider.friction_coefficient.speed is required and missing
slider.friction_coefficient={static=0.3} | slider.friction_coefficient.static needs sliding with speed
slider.friction_coefficient={sliding=0.3, speed=1.0} | slider.friction_coefficient.static is required and missing
slider.law=hysteretic; slider.stick_band=0.1 | slider.stick_band must be 0 with the hysteretic law, got 0.1 m/s
FALLING; slider.law=hysteretic | slider.law must be "elastic" with a table
FALLING; slider.reciprocal=true | slider.reciprocal must be false with a table
FALLING; slider.stick_band=0.1 | slider.stick_band must be 0 with a table
slider.law=no_law.py | slider.law names the file 'no_law.py', which cannot be read
FALLING; slider.law={name="a.py", source="b"} | slider.friction_coefficient must be a number with a law of one's own
slider.method=stepped | slider.method must be "auto" or "exact" or "averaged" for the steady state, got 'stepped'
slider.tilt=free | slider.tilt must be absent without [slider.pillars]
uncertain.slider.friction=0.01 | uncertain.slider.friction is no key of a scene; did you mean friction_coefficient?
uncertain.slider.preload=+- 1 mm | uncertain.slider.preload must be a force
uncertain.slider.preload=+- 1 N | uncertain.slider.preload, an end of whose interval
uncertain.slider.preload=0.0 | uncertain.slider.preload must be positive
uncertain.slider.shape=0.1 | uncertain.slider.shape must be the key of a number that this scene has, got 'sphere'
uncertain.slider.position=0.1 | uncertain.slider.position must be the key of a number that this scene has, got None
uncertain.wave.normal_amplitude=1 nm | uncertain.wave.normal_amplitude must be a percentage
uncertain.method=linear | uncertain must hold a tolerance
uncertain={slider={mass="2 %"}, method="quick"} | uncertain.method must be "linear" or "sampled", got 'quick'
uncertain.preload=2 % | uncertain.preload must be a key of a scene
uncertain.drive.voltage=5 % | uncertain.drive.voltage must be the key of a level that this scene has
uncertain.drive.power=5 % | uncertain.drive.power must be the key of a level that this scene has
uncertain.slider.preload=1 %; slider.preload=1 +- 0.1 mN | uncertain.slider.preload is given twice
-slider | slider is missing
-wave.frequency | wave.frequency is required and missing
-wave.normal_amplitude | wave.normal_amplitude is required and missing
-wave.tangential_ratio | wave.tangential_ratio is required and missing
""",
    "small": """
drive.burst=1 h; drive.frequency=center | drive.burst ... 354 s ... got 3600 s
slider.position=["9 mm", "13 mm"] | slider.position ... y from -12.5 to 12.5 mm, got a contact at y = 13 mm
slider.position=["9 mm"] | slider.position must be a length ... or [x, y]
slider.position=["-9 mm", 0] | slider.position.0 must be positive
slider.contacts=[["1 mm", "2 mm"], ["1 mm", "2 mm"]] | slider.contacts must differ
stator.sides=mirror; stator.diffraction=false | stator.sides must be absorbing where stator.diffraction is false
CUT; stator.ends=free; stator.diffraction=true | stator.diffraction must be false or absent: in this cut the field
drive.sources={left=1}; -drive.transducer; transducer.0.pattern=++++++ | transducer.0.pattern must have + and - fingers
""",
    "crossing": """
stator.ends=free | stator.ends must be absorbing where a transducer is turned
stator.sides=mirror | stator.sides must be absorbing where a transducer is turned
stator.diffraction=false | stator.diffraction must be true or absent where a transducer is turned
stator.material=LiNbO3 (Warner); stator.orientation=YZ | transducer may be ... unlike this cut of LiNbO3 (Warner)
transducer.1.pattern=oooo | transducer.1.pattern must have + and - fingers where a transducer is turned ... got 'oooo'
drive.transducer=front | drive.transducer must drive a transducer within 45 deg of x ... across by 'front' at 90 deg
-drive.transducer; drive.sources={front=1.0, left=0} | drive.sources must drive a transducer within 45 deg of x
transducer.1.center=["4 mm", "-2 mm"] | transducer.1.center ... 'front' off those of 'left': they overlap on the surface
transducer.1.center=["9 mm", "-12 mm"] | transducer.1.center ... y from -12.5 to 12.5 mm, got fingers from y = -12.875
transducer.1.center=["1 mm", "-9 mm"] | transducer.1.center ... 0 to 14 mm, got fingers from x = -1.5
transducer.1.center=["9 mm", "0.5 mm"] | slider.position must keep the contacts off 'front', got one at (9, 0) mm
transducer.1.angle=1 mm | transducer.1.angle must be an angle
""",
    "pillars": """
slider.contacts=3 | slider.contacts must be absent with [slider.pillars]
slider.radius=1e-3 | slider.radius must be absent with [slider.pillars]
slider.pillars.pitch=15e-6 | slider.pillars.pitch must be at least the diameter, 2e-05 m
slider.pillars.rows=2000; slider.pillars.columns=2000 | slider.pillars.rows ... at most 1000000 pillars, got 2000 x 2000
NO_GRID; slider.pillars.area=1e-5 | slider.pillars.area must hold at least one pillar
-slider.pillars.rows | slider.pillars.rows and columns are required
-wave.compliance; slider.loading=true | wave.compliance is required and missing
-wave.wavelength | wave.wavelength is required and missing
slider.tilt=free; slider.preload_at=[0.0, 1e-3] | slider.preload_at must lie ... side at smaller y lifts
slider.load=0.5 | slider.load must be at most ... its stall
slider.load=0.01; slider.tilt=pitch; slider.load_height=0.01 | slider.load_height must keep ... side at larger x lifts
slider.law=hysteretic | slider.law must be "elastic"
slider.method=exact | slider.method must be "auto" or "averaged"
slider.loading=harmonics; slider.backing=soft | slider.loading must be true or false where slider.backing is "soft"
-slider.pillars.diameter | slider.pillars.diameter is required and missing
slider.pillars.height_scatter=-1e-9 | slider.pillars.height_scatter must be zero or positive, got -1e-09 m
""",
    "driven-pillars": """
slider.position=29 mm | slider.position must keep the pillars on the stator, 0 to 0.03 m
slider.position=8 mm | slider.position must keep the pillars off the fingers of 'left'
slider.position=["18 mm", "6 mm"] | slider.position must keep the pillars on the stator, y from
""",
    "piece": """
piece.0.length_unit=m | piece.0 ... the group left is 1100 mm high, the stator is 1.1 mm thick: is the ... unit mm?
stator.thickness=2 mm | piece.0 ... the group left is 1.1 mm high, the stator is 2 mm thick
piece.0.position=3 mm | piece "plain" (3 to 4 mm) overlaps the transducer "t" (1.625 to 3.375 mm)
piece.0.position=3.375 mm | piece "plain" (3.375 to 4.375 mm) touches the transducer "t" (1.625 to 3.375 mm)
piece.0.position=["6 mm", "6.5 mm"] | piece "plain" (6 to 7 mm) overlaps the piece "plain" (6.5 to 7.5 mm)
piece.0.position=11.5 mm | piece.0 ... must lie on the stator, 0 to 12 mm, got 11.5 to 12.5 mm
piece.0.position=6 | piece.0 ... 0 to 12 mm, got 6000 to 6001 mm: is "6 mm" meant? A number without a unit
piece.0.position=["6 mm", "6 mm"] | piece.0.position must name different positions
piece.0.position=4 mm:11 mm:1000 | piece.0 ... at most as many positions as fit on the stator ... got 1000 of a mesh
piece.0.file=end.msh; piece.0.position=5 mm | piece.0 ("end") has no line group right ... end at x = 12 mm
piece.0.file=lost.msh | piece.0 ("lost") ... it must end at x = 0 mm, got 6 mm
piece.0.file=end.msh; piece.0.position=["5 mm", "7 mm"] | piece "end" (5 to 6 mm) and "end" (7 to 8 mm) are both
STRIP | piece.0.materials ... must give the solid of every surface group but "stator", got none for "strip"
STRIP; MATERIAL={strip="aluminium", alu="aluminium"} | piece.0.materials ... names "alu", which is no surface group
STRIP; MATERIAL={strip="aluminum foil"} | piece.0.materials.strip
STRIP; ALU; ELECTRODE={a="floating"} | piece.0.electrodes ... names "a", which is no line group electrode:NAME
STRIP; ALU; ELECTRODE={strip="left+"} | piece.0.electrodes ... must connect "strip" ... (t+, t-), got 'left+'
STRIP; MATERIAL={stator="aluminium", strip="aluminium"} | piece.0.materials ("s") must not name "stator"
stator.diffraction=true | stator.diffraction must be false or absent with a [[piece]]
stator.above=vacuum | stator.above must be none with a meshed piece
piece.0.file=none.msh | piece.0.file names "none.msh": the file cannot be read from
""",
    "chip": """
piece.0.position=1 mm | piece.0 ("chip") ... it must be the whole stator, 0 to 8 mm, got 1 to 9 mm
stator.length=8 m | piece.0 ("chip") ... is the file's length unit m?
stator.thickness=1 mm | piece.0 ("chip") ... from z = -1 mm (minus stator.thickness) to 0, got -1.1 to 0 mm
stator.ends=absorbing | stator.ends must be free with piece "chip" ... got 'absorbing'
ELECTRODE={p="t+"} | piece.0.electrodes ("chip") must connect a line group electrode:NAME to t-
PILLARS | slider.position must leave the pillars ... on the bare uniform stator: from 3.474 to 5.526 mm there
""",
    "rayleigh > load_line": "| slider is missing: this study needs a slider",
    "rayleigh > voltage_to_velocity": "| slider is missing",
    "rayleigh > admittance": "| transducer is missing: the study drives one",
    "rayleigh > frequency_response": "| transducer is missing: the study drives one",
    "rayleigh > gallery": "| transducer and slider are needed: the gallery shows a whole motor",
    "rayleigh > datasheet": "| slider is missing: a datasheet is of a whole motor",
    "rayleigh > gds": "| transducer is missing",
    "rayleigh > fmu": "| slider is missing",
    "twente-contact > dispersion": "| stator is missing: a prescribed wave has no section",
    "twente > fmu": 'TWO; slider.heights=["0 nm", "1 nm"] | slider.heights must be absent',
    "silicon-slider > fmu": "| slider.pillars must be absent: tables over two ratios do not hold heights",
    "pillars > regime_map": "| slider.pillars are not supported by this study",
    "pillars > load_line": "wave.normal_amplitude=1e-10 | wave.normal_amplitude must hold a value above 1.05 times",
    "small > load_line": "drive.voltage=1 | drive.voltage must hold a value above 1.05 times the threshold ... V",
    "small > gallery": "drive.voltage=1 | drive.voltage must hold a value above the threshold ... V",
    "small > datasheet": "drive.voltage=1 | drive.voltage must hold a value above the threshold ... V: nothing moves",
    "small > force_response": "slider.position=4 mm | slider.position must lie on the bare surface",
    "chip > p_matrix": "| piece must leave some uniform stator: this piece is all of it",
    "chip > reflector": "| piece must leave some uniform stator: this piece is all of it",
    "chip > gds": "transducer.0.metallisation=0.6 | transducer must have the fingers of the mesh",
}
CASES = [(name, *map(str.strip, row.split("| "))) for name, rows in TABLES.items() for row in rows.strip().split("\n")]


DOORS = {"": lambda scene: run(scene, tolerance=0.1), "datasheet": datasheet, "fmu": averaged_motor}
DOORS["gds"] = lambda scene: gds_files(scene, "chip", tolerance=0.1)


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    """A folder with the scenes of tests/studies/scenes and the meshes that they name."""
    folder = shutil.copytree(SMALL.parent, tmp_path_factory.mktemp("refused") / "scenes")
    mesh = {"size": 0.5}
    rectangle(folder / "plain.msh", 1.0, 1.1, **mesh)
    rectangle(folder / "end.msh", 1.0, 1.1, **mesh, groups=("left", "bottom"))
    rectangle(folder / "lost.msh", 1.0, 1.1, **mesh, groups=("right", "bottom"))
    strip = ("left", "right", "bottom", "electrode:strip")
    rectangle(folder / "s.msh", 1.0, 1.1, **mesh, strip=(0.4, 0.2, 0.1), groups=strip)
    fingers = {"p": [[1.625, 1.875], [2.625, 2.875]], "m": [[2.125, 2.375], [3.125, 3.375]]}
    chip(folder / "chip.msh", 8.0, 1.1, fingers, **mesh)
    return folder


def spoilt(table: dict, settings: str) -> dict:
    """Return a scene's table changed by settings that are separated by semicolons."""
    for short, whole in SHORT.items():
        settings = settings.replace(short, whole)
    return assigned(table, *filter(None, settings.split("; ")))


@pytest.mark.parametrize(("name", "settings", "sentence"), CASES, ids=[f"{c[0]}:{c[1]}" for c in CASES])
def test_a_bad_scene_is_refused_with_key_rule_value_and_unit(scenes, monkeypatch, name, settings, sentence):
    monkeypatch.chdir(scenes)
    scene, _, door = name.partition(" > ")
    file = scenes / f"{scene}.toml"
    table = read_table(file if file.exists() else scene)
    with pytest.raises(SceneError) as refusal:
        DOORS.get(door, lambda scene: module(door).run(scene))(Scene.from_table("", spoilt(table, settings)))
    said, parts = str(refusal.value), sentence.split(" ... ")
    assert said.startswith(parts[0])
    assert all(part in said for part in parts), said
    assert "\n" not in said


def test_an_empty_scene_lacks_a_stator():
    with pytest.raises(SceneError, match=r"^stator is missing"):
        Scene.from_table("", {})


def test_zero_voltage_is_no_error():
    assert Scene.from_table("", spoilt(read_table("twente"), "drive.voltage=0")).levels == (0.0,)


def test_python_construction_is_refused_in_the_same_words():
    with pytest.raises(SceneError, match=r"^wave\.frequency must be positive and finite, got -1\.0 Hz$"):
        Wave(frequency=-1, normal_amplitude=1e-9, tangential_ratio=0.7)


@pytest.mark.parametrize("settings", ["wave.burst=100", "wave.burst=2; slider.law=hysteretic"])
def test_a_long_burst_is_not_refused(settings):
    assert resolved(Scene.from_table("", spoilt(read_table("twente-contact"), settings))).burst > 1
