"""Layers of the stator: from the text of a scene to its record, and every refusal with its key."""

import numpy as np
import pytest

import fem
from studies import Scene
from studies.model import fem_objects
from studies.model.resolve import build, resolved
from studies.refusal import SceneError
from studies.runs import run

CHIP = {
    "stator": {
        "material": "LiNbO3 (Kovacs)", "orientation": "128YX", "length": 4e-3, "width": 4e-3, "ends": "absorbing",
        "thickness": "half-space", "above": "vacuum",
    },
    "transducer": [
        {"name": "left", "center": 1.2e-3, "finger_pairs": 2, "period": "half-space", "metallisation": 0.5,
         "aperture": 2e-3}
    ],
    "drive": {"transducer": "left", "frequency": 10e6, "voltage": 10.0},
}  # fmt: skip
SILICA = {"material": "fused silica", "thickness": "0.05 lambda"}


def chip(layers, *, plane=None, **changes) -> Scene:
    table = {name: dict(block) if isinstance(block, dict) else block for name, block in CHIP.items()}
    table["transducer"] = [dict(table["transducer"][0]) | ({} if plane is None else {"plane": plane})]
    table["stator"]["layer"] = layers
    for key, value in changes.items():
        if isinstance(value, dict):
            table[key] = table.get(key, {}) | value
        else:
            table[key] = value
    return Scene.from_table("", table)


def test_layers_come_up_from_the_material_and_survive_being_written():
    bond = {"normal": "1e15 N/m^3", "tangential": 3e14}
    scene = chip([SILICA, {"material": "AlN (McNeil)", "thickness": "2 um", "bond": bond}], plane=1)
    assert Scene.from_table("", scene.to_table()) == scene
    made = build(scene).stator
    assert [each.name for each in made.solids] == ["LiNbO3 (Kovacs)", "fused silica", "AlN (McNeil)"]
    assert made.plane == 1
    assert made.layers[1].bond == fem.Bond(normal=1e15, tangential=3e14)


@pytest.mark.parametrize("above", ["vacuum", "none"])
def test_wavelengths_are_those_of_the_wave(above):
    """0.05 and 0.02 lambda of the wave that the same thicknesses in m guide."""
    layers = [SILICA, {"material": "AlN (McNeil)", "thickness": "0.002 \u03bb"}]
    scene = resolved(chip(layers, stator={"above": above}))
    surface = "open" if above == "none" else "vacuum"
    wave = fem.bound_wave(fem_objects.stator(scene.stator), 10e6, surface)
    assert [each.thickness for each in scene.stator.layer] == pytest.approx(
        [0.05 * wave.velocity / 10e6, 0.002 * wave.velocity / 10e6], rel=1e-12
    )


@pytest.mark.parametrize("plane", [0, 1])
def test_the_automatic_period_is_that_of_the_fingers_where_they_are(plane):
    """Half of the wave free and half of it shorted in the plane of the fingers, at the thickness in m."""
    scene = resolved(chip([SILICA], plane=plane or "surface"))
    stator = fem_objects.stator(scene.stator)
    stack, at = stator.layers, {"frequency": 10e6}
    free = fem.principal_wave(fem.layered_waves(stator.solid, stack, **at)).velocity
    shorted = fem.principal_wave(fem.layered_waves(stator.solid, stack, shorted=plane, **at)).velocity
    assert free == pytest.approx(3985.1587875, rel=1e-9)  # layered.md, section 3
    assert shorted == pytest.approx(
        (3964.8669604, 3855.6808216)[plane], rel=5e-3
    )  # there at 0.05 of its own wavelength
    assert scene.transducer[0].period * 10e6 == pytest.approx((free + shorted) / 2, rel=1e-9)


def test_a_run_has_the_wave_of_the_layers():
    record = run(chip([SILICA], plane=1), tolerance=1e-2)
    assert record.wave.phase_velocity_m_per_s == pytest.approx(3985.1587875, rel=2e-5)
    assert record.wave.surface_ratio == pytest.approx(1.0212900, rel=1e-4)


def test_a_film_of_the_same_solid_changes_nothing():
    same = {"material": "LiNbO3 (Kovacs)", "orientation": "128YX", "thickness": "0.05 lambda"}
    filmed, bare = (run(chip(layers), tolerance=1e-3) for layers in ([same], []))
    assert abs(filmed.surface.u_z_m_per_V - bare.surface.u_z_m_per_V).max() < 1e-4 * abs(bare.surface.u_z_m_per_V).max()
    assert filmed.electrical.admittance_S == pytest.approx(bare.electrical.admittance_S, rel=1e-5)


REFUSED = [
    ([{"material": "AlN (McNeil)", "thickness": "0.01 lambda"}], {}, "stator.layer", "must leave a wave bound"),
    ([{"material": "AlN (McNeil)", "thickness": "4 um"}], {}, "stator.layer", "AlN .* leaks"),
    ([{"material": "fused silica", "thickness": "3.2 lambda"}], {}, "stator.layer.0.thickness",
     r"3.2 wavelengths: it is the substrate; make it the material of the stator"),
    ([SILICA | {"thickness": "1e-9 lambda"}], {}, "stator.layer.0.thickness", "must be at least 1e-10 m, the size of"),
    ([SILICA], {"plane": 2}, "transducer.0.plane", 'must be "surface" or the number of layers above .* 1 to 1, got 2'),
    ([], {"plane": 1}, "transducer.0.plane", 'must be "surface" or absent without layers, got 1'),
    ([SILICA | {"thickness": "-0.1 lambda"}], {}, "stator.layer.0.thickness", "wavelengths such as .* got '-0.1"),
    ([SILICA | {"thickness": "0.1"}], {}, "stator.layer.0.thickness", "must be a length.*no unit"),
    ([SILICA | {"material": "silicat"}], {}, "stator.layer.0.material", "catalogue"),
    ([SILICA | {"bond": {"normal": 1e15, "tangential": -1.0}}], {}, "stator.layer.0.bond.tangential", "positive"),
    ([SILICA], {"drive": {"frequency": "center"}, "period": 0.4e-3}, "stator.layer.0.thickness",
     "must be a length in m where drive.frequency"),
    ([{"material": "AlN", "thickness": "100 nm"}], {"stator": {"temperature": 60.0}}, "stator.layer.0.material",
     r"needs temperature coefficients for stator.temperature, and AlN \(Tsubouchi\) has none"),
    ([SILICA], {"stator": {"diffraction": True}}, "stator.diffraction", "must not be true with layers"),
    ([{"material": "gold", "thickness": "1 um"}], {}, "transducer.plane", "must not touch a metal layer.*gold"),
    ([SILICA, {"material": "Al", "thickness": "1 um"}], {"plane": 1}, "transducer.plane", "metal layer.*aluminium"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("layers", "changes", "key", "rule"), REFUSED, ids=[each[2] + each[3][:20] for each in REFUSED]
)
def test_what_layers_cannot_be(layers, changes, key, rule):
    changes = dict(changes)
    period = changes.pop("period", None)
    if period is not None:
        changes["transducer"] = [CHIP["transducer"][0] | {"period": period}]
    with pytest.raises(SceneError, match=rule) as refused:
        resolved(chip(layers, **changes))
    assert [each.path for each in refused.value.problems] == [key]


def test_compliance_of_a_bound_wave():
    """A vanishing film leaves Gamma of the half-space; a film of it whole too; and power over amplitude gives it."""
    stator = fem_objects.stator(resolved(chip([SILICA | {"thickness": 1e-10}])).stator)
    bare = fem.wave_compliance(stator.solid, "vacuum")
    assert fem.bound_compliance(stator, 10e6) == pytest.approx(bare, rel=1e-5)
    same = {"material": "LiNbO3 (Kovacs)", "orientation": "128YX", "thickness": 5e-5}
    assert fem.bound_compliance(fem_objects.stator(chip([same]).stator), 10e6) == pytest.approx(bare, rel=1e-8)
    stator = fem_objects.stator(resolved(chip([SILICA])).stator)
    response = fem_response(stator)
    wave = fem.bound_wave(stator, 10e6)
    # u_z of a line force is -i Gamma F, by the residue of Gamma t_z/(k - k_R)
    assert abs(response) == pytest.approx(fem.bound_compliance(stator, 10e6), rel=2e-4)
    assert wave.velocity == pytest.approx(3985.1587875, rel=1e-9)


def fem_response(stator):
    from fem.discretize.depth_mesh import discretise
    from fem.waveguide.guided_modes import guided_modes

    resolution = fem.Resolution(order=8, edge_layers=0, absorber=3)
    section = discretise(stator, resolution, wavelength=stator.slowest_wavelength(10e6), surface_scale=np.inf)
    return fem.force_response(guided_modes(section, 10e6), "z").surface_wave[1]


def test_layers_at_a_temperature_have_their_own_constants():
    """Solved in the lengths before the expansion, as the stator's material: one factor on every layer."""
    scene = chip([SILICA], stator={"temperature": 60.0})
    warm = fem_objects.stator(resolved(scene).stator)
    table = fem.catalogue_table("LiNbO3 (Kovacs)")
    stretch = 1.0 + fem.expansion_along(table, "128YX", 60.0)
    silica = fem.solid_at("fused silica", 60.0)
    assert warm.layers[0].solid.stiffness == pytest.approx(stretch * silica.stiffness, rel=1e-12)
    assert warm.layers[0].solid.density == pytest.approx(stretch**3 * silica.density, rel=1e-12)
    assert warm.layers[0].solid.stiffness[0, 0] > fem.material("fused silica").stiffness[0, 0]
    record = run(scene, tolerance=1e-2)
    cold = run(chip([SILICA]), tolerance=1e-2)
    slower = record.wave.phase_velocity_m_per_s / cold.wave.phase_velocity_m_per_s - 1.0
    assert -40 * 80e-6 < slower < -20 * 40e-6
    stress = next(each for each in record.model_error if each["effect"] == "thermal stress of the layers")
    assert stress["quantity"] == "their stiffness"
    assert stress["size"] == pytest.approx(
        -5 * 35 * 15e-6, rel=0.02
    )  # from 25 degC; 128YX expands along x by 15.4 ppm/K, SiO2 by 0.5
    assert "thermal stress of the layers" not in {each["effect"] for each in cold.model_error}
