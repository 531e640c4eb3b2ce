"""The colour maps can be read by every eye: ends apart and even lightness under each colour-blindness."""

import matplotlib
import numpy as np
import pytest
from PIL import Image

from studies.refusal import SceneError
from studies.view.field_quantities import DIVERGING, QUANTITIES, SEQUENTIAL, palette, quantity

# Machado, Oliveira and Fernandes 2009, severity 1.0, on linear sRGB
BLINDNESS = {
    "normal": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}  # fmt: skip
XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def cielab(rgb):
    """CIE 1976 L*, a*, b* of linear sRGB under D65."""
    t = rgb @ XYZ.T / (XYZ @ np.ones(3))
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def colours(name, count):
    return matplotlib.colormaps[name](np.linspace(0.0, 1.0, count))[:, :3]


@pytest.mark.parametrize("eye", BLINDNESS)
def test_scales_are_read_by_every_eye(eye):
    seen = {
        name: cielab((linear(colours(name, 65)) @ np.transpose(BLINDNESS[eye])).clip(0, 1))
        for name in (DIVERGING, SEQUENTIAL)
    }
    signed = seen[DIVERGING]
    assert np.linalg.norm(signed[0] - signed[-1]) > 25  # ten just noticeable differences
    assert abs(signed[0, 0] - signed[-1, 0]) < 10  # neither sign looks the larger
    assert np.all(np.diff(signed[:33, 0]) > 0)
    assert np.all(np.diff(signed[32:, 0]) < 0)
    assert np.all(np.diff(seen[SEQUENTIAL][:, 0]) < 0)


def test_every_quantity_has_a_unit_and_an_unknown_one_is_refused():
    for name, each in QUANTITIES.items():
        assert quantity(name) is each
        assert all(each.entry(free).shown and each.entry(free).scale for free in (False, True))
    with pytest.raises(SceneError, match=r"^--quantity 'potental' does not exist; did you mean potential\?$"):
        quantity("potental")


def test_a_palette_holds_the_scale_and_the_marks():
    """A picture of scale, electrodes, axes, black and white is the same after it has been reduced, to 8 of 255."""
    marks = np.array([[204, 121, 167], [230, 159, 0], [0, 158, 115], [0, 0, 0], [255, 255, 255]])
    picture = np.concatenate([np.round(255 * colours(DIVERGING, 500)), marks]).astype(np.uint8)[None]
    reduced = Image.fromarray(picture).quantize(palette=palette(DIVERGING), dither=Image.Dither.NONE)
    back = np.asarray(reduced.convert("RGB")).astype(int)
    assert abs(back - picture).max() <= 8
    assert abs(back[0, -5:] - marks).max() <= 4
