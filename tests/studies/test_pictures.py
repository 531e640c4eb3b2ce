"""The pictures that explain: what their lines and arrows hold, quantity and unit on every axis."""

import ast
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from contact import Orbit, Slider, burst, contact_history, steady
from studies.model import resolve
from studies.record import Record, pillar_pictures
from studies.record.blocks import WaveBlock
from studies.record.plots import COLOURS, DPI, SIZE, finished, lay_out, new_figure
from studies.record.point import Point
from studies.record.quantities import quantities, quantity
from studies.record.run_pictures import pictures
from studies.runs import run
from studies.scene import Scene
from studies.view import gallery_pictures
from studies.view.contact_view import SlowMotion, history_columns, strip
from studies.view.gallery_pictures import start_and_stop
from tests import seed_motor
from tests.studies.legible import assert_legible

STUDIES = Path(__file__).parents[2] / "studies"
UNIT = re.compile(r"\([^()]+\)| over ")  # a ratio has none
SLIDER = Slider(**seed_motor.SLIDER)
# a wave that runs to +x, of any phase
ORBIT = Orbit(frequency=2.2e6, normal=8e-9 * np.exp(0.7j), tangential=5.7e-9j * np.exp(0.75j))


@pytest.fixture(scope="module")
def waveforms():
    history = contact_history(SLIDER, ORBIT, stage="steady", skip=0, cycles=2, points_per_cycle=200)
    return history, history_columns(history)


def labelled(figure):
    """Whether every axis that has numbers says quantity and unit; shared ones say it once for the figure."""
    whole = figure.get_supxlabel(), figure.get_supylabel()
    for ax in figure.axes:
        for axis, words in ((ax.xaxis, ax.get_xlabel()), (ax.yaxis, ax.get_ylabel())):
            ticks = [tick for tick in axis.get_ticklabels() if tick.get_visible() and tick.get_text()]
            numbers = any(re.search(r"\d", tick.get_text()) for tick in ticks)
            if numbers and not UNIT.search(words) and not any(map(UNIT.search, whole)):
                return False
    return True


def test_a_map_with_equal_scales_is_legible_although_its_height_and_ticks_follow_from_its_width():
    """The beam of a chip of 60 x 13 mm: its label lay beyond the picture's left edge."""
    figure, ax = new_figure(1600 / DPI, 458 / DPI, dpi=DPI)
    x, y = np.linspace(0.0, 59.7, 20), np.linspace(-6.4, 6.4, 20)
    figure.colorbar(ax.pcolormesh(x, y, np.outer(y, x)), ax=ax, label="|u_z| (nm/V)")
    ax.set_aspect("equal")
    finished(ax, "x along the surface (mm)", "y across the surface (mm)", "beam", columns=0, grid=False)
    lay_out(figure)
    assert_legible(figure)


@pytest.mark.parametrize("share", [0.65, 1.0])
def test_words_that_are_longer_than_their_axis_lie_in_the_picture(share):
    """The title of a beam on a narrow chip beside its colour bar, and the label of a low axis, were cut."""
    figure, ax = new_figure(share * SIZE[0], share * SIZE[1], dpi=DPI)
    x, y = np.linspace(0.0, 14.0, 20), np.linspace(-12.5, 12.5, 20)
    figure.colorbar(ax.pcolormesh(x, y, np.outer(y, x)), ax=ax, label="|u_z| (nm/V)")
    ax.set_aspect("equal")
    title = "small motor\nbeam: |u_z|, peak, per volt; white: apertures; points: the slider's contacts"
    finished(ax, "x along the surface (mm)", "y across the surface (mm)", title, columns=0, grid=False)
    lay_out(figure)
    assert_legible(figure)
    figure, ax = new_figure(share * SIZE[0], share * SIZE[1], dpi=DPI)
    ax.plot([0.0, 1.0], label="|u_z|")
    finished(ax, "x along the surface (mm)", "amplitude per volt, peak (nm/V)", "two\nlines")
    lay_out(figure)
    assert_legible(figure)


@pytest.mark.parametrize("count", [1, 8, 20])
def test_the_power_below_pillars_is_legible_at_every_number_of_levels(count):
    points = [
        Point(voltage_V=5.74 * k, wave_power_in_W=0.01552 * k * k, wave_power_out_W=0.01454 * k * k,
              friction_power_W=9.8e-4 * k * k, thrust_power_W=0.0)
        for k in range(1, count + 1)
    ]  # fmt: skip
    scene = Scene.load("silicon-slider")
    figure, ax = new_figure(*SIZE, dpi=DPI)
    pillar_pictures.power(Record(scene=scene, tolerance=1e-3, points=tuple(points), seconds={"total": 1.0}), ax)
    lay_out(figure)
    assert_legible(figure)
    assert "93.7 %\nof 15.5 mW" in [each.get_text() for each in ax.texts]


def own_units(source, units):
    """The texts of a module that end a phrase with a unit in parentheses, but docstrings, findings and refusals."""
    tree = ast.parse(source)
    elsewhere = [node for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)]
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name))
    elsewhere += [node for node in calls if node.func.id == "judged"]
    elsewhere += [node for node in ast.walk(tree) if isinstance(node, ast.Raise)]
    left_out = {id(inner) for node in elsewhere for inner in ast.walk(node)}
    texts = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str))
    return [each.value for each in texts if id(each) not in left_out and units.search(each.value)]


def test_no_module_outside_record_writes_the_unit_of_a_label_itself():
    """Labels and units of axes come from the table of quantities."""
    shown = {each.shown for each in quantities().values()} - {"", "1"}
    units = re.compile(rf" \((?:{'|'.join(map(re.escape, shown))})\)(?=$|[;:,\n])")
    assert own_units('ax.set_ylabel(f"{name} (mm/s)")', units)
    modules = [path for path in STUDIES.rglob("*.py") if "record" not in path.parts]
    assert len(modules) > 100
    assert {path.name: own for path in modules if (own := own_units(path.read_text(encoding="utf-8"), units))} == {}


def test_the_drawn_path_is_the_contact_s_clock(waveforms):
    """The drawn surface point moves at the history's surface velocity and rises as the approach does."""
    _, drawn = waveforms
    step = drawn["time_s"][1] - drawn["time_s"][0]
    speed = np.gradient(drawn["u_x_m"], step)[2:-2]
    np.testing.assert_allclose(speed, drawn["surface_velocity_m_per_s"][2:-2], atol=1e-3 * abs(speed).max())
    ball = drawn["u_z_m"] - drawn["approach_m"]  # the slider, far heavier than a wave's period, hardly moves
    assert np.ptp(ball) < 1e-3 * abs(ORBIT.normal)
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 2001))
    path = np.hypot((ORBIT.tangential * turn).real, (ORBIT.normal * turn).real)
    assert np.hypot(drawn["u_x_m"], drawn["u_z_m"]).max() == pytest.approx(path.max(), rel=1e-3)
    separated = drawn["regime"] == "separated"
    assert 0.2 < separated.mean() < 0.8
    assert not np.any(drawn["normal_force_N"][separated])
    assert drawn["slider_velocity_m_per_s"].mean() == pytest.approx(
        steady(SLIDER, ORBIT, tolerance=1e-6).velocity, rel=1e-9
    )


def test_slow_motion_shows_the_instant(waveforms):
    """Force arrows as long as the forces, the ball at its height, the cursor at the time, the colour of the regime."""
    _, drawn = waveforms
    motion = SlowMotion(drawn, title="slow")
    assert labelled(motion.figure)
    assert_legible(motion.figure)
    pictures = []
    for index in (50, 150):  # crest, trough
        motion.show(index)
        ax = motion.figure.axes[0]
        (circle,) = ax.patches
        bottom = circle.center[1] - circle.radius
        assert bottom == pytest.approx((drawn["u_z_m"][index] - drawn["approach_m"][index]) * 1e9, rel=1e-12)
        arrows = [text for text in ax.texts if text.arrow_patch is not None]
        assert len(arrows) == (2 if index == 50 else 0)
        assert ax.get_title().startswith(str(drawn["regime"][index]))
        lines = [line.get_xdata() for traces in motion.figure.axes[1:] for line in traces.lines]
        times = [x for x in lines if len(x) == 2 and x[0] == x[1]]  # the upright lines: the cursors
        assert len(times) == 5
        assert np.ravel(times) == pytest.approx(drawn["time_s"][index] * 1e9)
        motion.figure.canvas.draw()
        pictures.append(np.array(motion.figure.canvas.buffer_rgba()))
    assert np.mean(pictures[0] != pictures[1]) > 0.01


def test_a_strip_has_eight_snapshots_over_five_traces(waveforms):
    figure = strip(waveforms[1], title="strip")
    assert_legible(figure)
    assert len(figure.axes) == 13
    assert labelled(figure)
    labels = [ax.get_ylabel() for ax in figure.axes[8:]]
    assert labels == ["z (nm)", "x (nm)", "P (mN)", "Q (mN)", "v (mm/s)"]
    words = " ".join(text.get_text() for text in figure.findobj(Text))
    for meaning in ("z: approach", "x: tangential deformation", "P: normal force", "Q: friction force", "not to scale"):
        assert meaning in words


def test_start_and_stop_end_on_the_slope_of_friction():
    motion = burst(SLIDER, ORBIT, duration=4e-3, after=8e-3, tolerance=1e-2, samples=200)
    figure = start_and_stop([("8 nm", motion)], acceleration=0.08 * 9.81, title="start")
    assert_legible(figure)
    assert labelled(figure)
    end = figure.axes[1]
    slopes = {line.get_label(): line.get_xydata() for line in end.lines}
    theory = slopes["mu preload / m (theory)"]
    assert abs((theory[1] - theory[0])[1] / (theory[1] - theory[0])[0]) == pytest.approx(0.08 * 9.81, rel=1e-12)
    assert theory[0, 1] == pytest.approx(motion.velocity_at_burst_end * 1e3, rel=1e-12)


def test_orbits_turn_the_way_the_arrows_say():
    """A wave to +x turns anticlockwise, x right and z up: against itself at the crest."""
    positions = np.array([0.01, 0.02, 0.03])
    normal = np.exp([0.3j, -2.0j, 1.1j])
    tangential = np.array([0.7j, 0.6j, -0.7j]) * normal
    assert gallery_pictures.anticlockwise(tangential, normal).tolist() == [True, True, False]
    figure = gallery_pictures.orbits(positions, tangential, normal, title="orbits")
    figure.canvas.draw()
    assert labelled(figure)
    assert_legible(figure)
    for ax, a, b in zip(figure.axes, tangential, normal, strict=True):
        (arrow,) = (text for text in ax.texts if text.arrow_patch is not None)
        instants = np.linspace(0, 2 * np.pi, 10001)
        crest = instants[np.argmax((b * np.exp(1j * instants)).real)]
        velocity = (1j * a * np.exp(1j * crest)).real
        assert np.sign(arrow.xy[0] - arrow.xyann[0]) == np.sign(velocity)
    assert "2 anticlockwise (blue), 1 clockwise" in figure.get_suptitle()


def test_amplitude_shows_a_run_s_surface_whole_and_from_near():
    x, k = np.linspace(0, 0.16, 20001), 2 * np.pi / 1e-3
    u_z = 3e-10 * (np.exp(-1j * k * x) + 0.1 * np.exp(1j * k * x))
    columns = {"x_m": x, "u_z_m_per_V": u_z, "u_x_m_per_V": 0.7j * u_z}
    record = Record(
        scene=resolve.resolved(Scene.load("twente-left")), tolerance=1e-3, wave={"frequency_Hz": 2.2e6}, surface=columns
    )
    figure = gallery_pictures.amplitude(record, wavelength=1e-3, focus=("slider", 0.08))
    assert_legible(figure)
    assert labelled(figure)
    whole, near = figure.axes
    assert "|u_z| 1.22 " in near.get_title()
    assert near.get_xlim() == pytest.approx((76.0, 84.0))
    assert whole.lines[0].get_ydata().max() == pytest.approx(0.33, rel=1e-3)


def test_depth_profile_puts_points_on_lines():
    depth = np.linspace(0, 3, 50)
    theory = {"Re u_z": np.exp(-depth), "Im u_x": -np.exp(-2 * depth)}
    points = {"Re u_z": np.exp(-depth[::5]), "Im u_x": -np.exp(-2 * depth[::5])}
    figure = gallery_pictures.depth_profile(depth, theory, {"section": (depth[::5], points)}, title="depth")
    assert_legible(figure)
    assert labelled(figure)
    for line, dots in ((0, 2), (1, 3)):
        drawn, marks = figure.axes[0].lines[line].get_xydata(), figure.axes[0].lines[dots].get_xydata()
        np.testing.assert_allclose(np.interp(marks[:, 0], *drawn.T), marks[:, 1], atol=1e-12)


def test_bars_are_as_long_as_the_powers_and_energies():
    electrical = {"power_W_per_V2": 3.6e-3, "power_radiated_W_per_V2": 2.2e-3, "power_dissipated_W_per_V2": 1.4e-3}
    drawn = quantity("transducer_power_W_per_V2")
    figure = gallery_pictures.bars(gallery_pictures.powers(electrical), drawn, "power")
    figure.canvas.draw()
    assert [bar.get_width() for bar in figure.axes[0].patches] == pytest.approx([3.6, 2.2, 1.4])
    assert UNIT.search(figure.axes[0].get_xlabel())
    assert_legible(figure)
    books = steady(SLIDER, ORBIT, tolerance=1e-6).ledger
    entries, balance = gallery_pictures.ledger_entries(books)
    assert balance.startswith("balance to ")
    figure = gallery_pictures.bars(entries, quantity("cycle_energy_J"), "8 nm")
    assert_legible(figure)
    bars = {
        label.get_text(): bar.get_width()
        for label, bar in zip(figure.axes[0].get_yticklabels(), figure.axes[0].patches, strict=True)
    }
    assert bars["wave, friction force"] == pytest.approx(books.wave_tangential * 1e12)
    supplied = bars.pop("wave, friction force") + bars.pop("wave, normal force")
    assert sum(bars.values()) == pytest.approx(supplied, rel=1e-5)


def test_power_along_the_stator_is_drawn_in_milliwatt():
    x = np.linspace(0, 0.1, 11)
    figure = gallery_pictures.power_along(x, 1e-3 * x, covered=[(0.01, 0.02)], fed=2e-3, title="flow")
    assert_legible(figure)
    assert labelled(figure)
    assert figure.axes[0].lines[0].get_ydata()[-1] == pytest.approx(0.1)


def test_weights_of_the_depth_integrate_polynomials():
    from fem.discretize.spectral import line_nodes

    z = line_nodes(np.array([-2.0, -0.5, 0.0]), 4)
    assert gallery_pictures.depth_weights(z, 4) @ z**4 == pytest.approx(32 / 5, rel=1e-12)


@pytest.mark.parametrize("levels", [[0.3e-9, 0.5e-9], [0.5e-9, 3e-9, 10e-9]])
def test_the_picture_of_the_velocity_says_when_nothing_moves(levels):
    from studies.record.run_pictures import velocity
    from studies.runs import run
    from studies.scene import Scene, read_table
    from studies.scene.override import replaced

    table = replaced(read_table("twente-contact"), "wave.normal_amplitude", levels)
    record = run(Scene.from_table("", table), tolerance=1e-3)
    figure, ax = new_figure(7.0, 4.3)
    velocity(record, ax)
    assert_legible(figure)
    stuck = "at rest: the slider sticks at every level" in [text.get_text() for text in ax.texts]
    assert stuck == (levels[-1] < 0.6e-9)
    assert not stuck or ax.get_ylim() == (-1.0, 1.0)


def test_the_surface_s_picture_marks_each_groove():
    scene = Scene.load("reflector").replace(drive={"voltage": 30.0}, slider=None)
    _, ax = new_figure(7.0, 4.3)
    record = replace(run(scene, tolerance=1e-2), surface_motion=None)  # as the drawing process receives it
    pictures(record)["surface"](ax)
    marked = [patch for patch in ax.patches if patch.get_facecolor()[:3] == to_rgb(COLOURS["second"])]
    starts = [patch.get_x() for patch in marked]
    assert starts == pytest.approx([1e3 * each for each in scene.piece[0].position], abs=1e-6)


def test_the_surface_s_picture_marks_the_finite_aperture_under_the_slider():
    """The run's own motion there, which the curves of the plane section do not show."""
    scene = Scene.load("twente")
    wave = {"frequency_Hz": 2.2e6, "normal_m_per_V": 0.2e-9j, "tangential_m_per_V": 0.15e-9}
    columns = {"x_m": np.array([0.0, 0.16]), "u_z_m_per_V": np.full(2, 3e-10j), "u_x_m_per_V": np.full(2, 2e-10j)}
    plane = Record(scene=resolve.resolved(scene), tolerance=1e-3, wave=wave, surface=columns)
    for spreads in (False, True):
        figure, ax = new_figure(7.0, 4.3)
        record = replace(plane, wave=plane.wave | WaveBlock(section_normal_m_per_V=3e-10j)) if spreads else plane
        pictures(record)["surface"](ax)
        assert_legible(figure)
        assert labelled(figure)
        assert ax.get_ylim() == pytest.approx((0.0, 1.12 * 0.3))  # the curve at 0.3 nm/V is off the frame
        points = [line.get_xydata()[0].tolist() for line in ax.lines if line.get_marker() == "D"]
        assert points == (pytest.approx(np.array([[80.0, 0.2], [80.0, 0.15]])) if spreads else [])


def test_words_over_a_standing_wave_have_a_background_and_one_label_serves_both_axes():
    """The words lay on the curves, and the label reached from the lower axes alone to its end."""
    x = np.linspace(0.0, 0.16, 2000)
    standing = 3e-10 * np.cos(2 * np.pi * x / 1e-3) + 0j
    wave = {
        "frequency_Hz": 2.2e6,
        "phase_velocity_m_per_s": 2200.0,
        "normal_m_per_V": 3e-10,
        "tangential_m_per_V": 2e-10,
    }
    columns = {"x_m": x, "u_z_m_per_V": standing, "u_x_m_per_V": 0.7j * standing}
    scene = resolve.resolved(Scene.load("twente"))
    scene = replace(scene, title="A title that ends in its line just before the unit of its own frequency")
    figure, ax = new_figure(*SIZE, dpi=DPI)
    pictures(Record(scene=scene, tolerance=1e-3, wave=wave, surface=columns))["surface"](ax)
    assert_legible(figure)
    (upper,) = (each for each in figure.axes if each is not ax)
    (words,) = upper.texts
    assert "wavelengths about the slider" in words.get_text()
    box = Text.get_window_extent(ax.yaxis.label)
    middle = 0.5 * (ax.bbox.y0 + upper.bbox.y1)
    assert 0.5 * (box.y0 + box.y1) == pytest.approx(middle, abs=0.02 * figure.bbox.height)
    assert upper.get_title().splitlines()[-1] == "2.2 MHz"  # a number stays with its unit


def test_run_plot_shows_what_the_run_draws(tmp_path, monkeypatch, capsys):
    """Windows are opened after the numbers are saved; where none can be, the run is refused before it begins."""
    from matplotlib import pyplot

    from studies.__main__ import main

    words = ["run", "twente-contact", "--set", "wave.normal_amplitude=[3e-9, 10e-9]", "--plot", "--no-plot"]
    monkeypatch.setattr("sys.argv", ["sawmotor", *words, "--out", str(tmp_path / "a")])
    monkeypatch.setattr(pyplot, "get_backend", lambda: "agg")
    assert main() == 3
    assert "pip install PySide6" in capsys.readouterr().err
    assert not (tmp_path / "a").exists()
    monkeypatch.setattr(pyplot, "get_backend", lambda: "qtagg")
    shown = []
    monkeypatch.setattr(pyplot, "show", lambda: shown.append((tmp_path / "a" / "run.json").exists()))
    assert main() == 0
    assert shown == [True]
    (ax,) = pyplot.gcf().axes
    assert ax.get_ylabel() == "slider velocity (mm/s)"
    pyplot.close("all")


@pytest.mark.parametrize(
    ("levels", "title"), [(["8 nm", "10 nm"], "every point: intermittent"), (["0.5 nm", "10 nm"], None)]
)
def test_a_legend_stands_only_where_it_tells_regimes_apart(levels, title):
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": levels})
    record = replace(run(scene, tolerance=1e-2), summary={})  # without the lines of threshold and release
    _, ax = new_figure(7.0, 4.3)
    pictures(record)["velocity"](ax)
    legend = ax.get_legend()
    if title is None:
        assert [each.get_text() for each in legend.get_texts()] == ["stick", "intermittent"]
        assert ax.get_title() == scene.title
    else:
        assert legend is None
        assert ax.get_title() == f"{scene.title}\n{title}"


def of_plane(name, **columns):
    """Return the record of a scene in the plane whose points have these columns."""
    scene = Scene.load(name)
    rows = [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
    points = [
        {"voltage_V": 20.0 * (k + 1), "velocity_m_per_s": 0.0, "regime": "slip"} | row for k, row in enumerate(rows)
    ]
    return Record(scene=scene, tolerance=1e-3, points=tuple(points))


def test_velocity_of_a_rotor_is_its_rotation():
    record = of_plane("rotor", rotation_rpm=[-40.0, -120.0], mean_rotation_rpm=[-35.0, -114.0])
    ax = pictures(record)["velocity"](new_figure(6, 4)[1])
    assert ax.get_ylabel() == quantity.rotation_rpm.axis
    drawn = {line.get_label(): line.get_ydata().tolist() for line in ax.lines}
    assert drawn["slip"] == [-40.0, -120.0]
    assert drawn["mean over a turn"] == [-35.0, -114.0]
    assert not any("at rest" in each.get_text() for each in ax.texts)


def test_velocity_in_the_plane_has_both_directions():
    record = of_plane("twente-planar", velocity_m_per_s=[-0.03, -0.08], lateral_velocity_m_per_s=[0.01, 0.02])
    drawn = {line.get_label(): line.get_ydata() for line in pictures(record)["velocity"](new_figure(6, 4)[1]).lines}
    assert drawn["slip"] == pytest.approx([-30.0, -80.0])
    assert drawn["across (y)"] == pytest.approx([10.0, 20.0])
