"""How the finite aperture spreads the beam: amplitude along its axis and across it, against the plane section.

Method: u_z of the scene (``twente`` when none is named) in three dimensions, from the section's charges within the
aperture and the guided modes at every lateral wavenumber; on the axis from the driven transducer to its neighbour or
the stator's end, and across the beam at the slider.  Beside it the section, and Fresnel's integral of the aperture
times the section's surface mode, attenuated but without the ripple of what comes back.  Expected: Fresnel's fringes,
with the plate's ripple on them; a mean over the aperture of 0.8 to 1 of the section.  Solids isotropic about the
normal, absorbing ends.  Run time: about 10 s.
"""

from collections.abc import Callable

from studies.chain import bridge, passband
from studies.chain.model_error import slit_ratio
from studies.refusal import RunError
from studies.scene import Scene, resolved
from studies.study import Finding, Panel, StudyRecord, of_record, study

__all__ = ["figure", "run"]

TAKES_SCENE = True
QUICK = {"count": 25}
COUNT = 400
CLEAR = 0.6  # wavelengths from the fingers where the axis begins


@study
def run(
    scene: str | Scene = "twente",
    *,
    count: int = COUNT,
    tolerance: float = 1e-3,
    progress: Callable[[str], None] | None = None,
) -> StudyRecord:
    """Return the amplitude on the axis and across the beam.

    Parameters
    ----------
    scene : str or Scene
        A path, a shipped name or a scene with transducers.
    count : int
        Points of each line.
    tolerance : float
        Relative, of the section's surface motion.
    progress : callable, optional
        Told what is being done.
    """
    import numpy as np

    import fem

    chosen = passband.driven_scene(scene)
    place, transducers = passband.place(chosen), resolved.transducers(chosen)
    driven = next(each for each in transducers if each.name == chosen.drive.transducer)
    try:
        wave = bridge.driven_section(chosen, tolerance=tolerance, places=(place,), progress=progress)
        beam = fem.surface_beam(wave, mirror_width=chosen.stator.mirror_width)
        x = _axis(chosen, transducers, driven, place, wave.phase_velocity / wave.frequency, count)
        y = np.linspace(-0.75, 0.75, count) * driven.aperture
        axis, across = beam.motion(x), beam.motion(place, y)
    except (fem.BeamError, fem.ConvergenceError) as error:
        raise RunError(f"the beam of this scene: {error}") from None
    section = wave.motion(np.append(x, place))
    known = np.polynomial.Polynomial.fit(
        x, np.log(abs(wave.rayleigh_motion(x)[1])), 1
    )  # attenuated, no ripple
    surface = np.exp(known(np.append(x, place)))
    slit = (driven.aperture, wave.phase_velocity / wave.frequency)
    away = x - driven.center
    panels = (
        _panel(
            "along",
            f"On the axis of {driven.name!r}",
            ("from the transducer's centre (mm)", away * 1e3),
            abs(axis[2]),
            abs(section[1, :-1]),
            surface[:-1] * [slit_ratio(*slit, abs(each)) for each in away],
        ),
        _panel(
            "across",
            f"Across the beam, {abs(place - driven.center) * 1e3:.3g} mm from the transducer's centre",
            ("y (mm)", y * 1e3),
            abs(across[2]),
            np.full(len(y), abs(section[1, -1])),
            surface[-1] * np.array([slit_ratio(*slit, abs(place - driven.center), each) for each in y]),
        ),
    )
    findings = _findings(beam, wave, driven, place, slit, across[:, abs(y) <= driven.aperture / 2], tolerance)
    return panels, findings


def _axis(scene: Scene, transducers, driven, place: float, wavelength: float, count: int):
    """Return places in m on the slider's side of the driven transducer, up to the next one or the end."""
    import numpy as np

    clear = CLEAR * wavelength
    if place >= driven.center:
        others = [each.extent[0] - clear for each in transducers if each.center > driven.center]
        return np.linspace(driven.extent[1] + clear, min(others, default=scene.stator.length), count)
    others = [each.extent[1] + clear for each in transducers if each.center < driven.center]
    return np.linspace(max(others, default=0.0), driven.extent[0] - clear, count)


def _panel(name, title, axis, beam, section, fresnel) -> Panel:
    label, at = axis
    data = {
        "axis": label,
        "at": at,
        "beam_m_per_V": beam,
        "section_m_per_V": section,
        "fresnel_m_per_V": fresnel,
    }
    return Panel(name=name, title=title, data=data)


def _findings(beam, wave, driven, place: float, slit: tuple, inside, tolerance: float) -> tuple[Finding, ...]:
    import numpy as np

    section = abs(wave.motion(place)[1])
    on_axis = float(abs(beam.motion(place)[2]) / section)
    expected = slit_ratio(*slit, abs(place - driven.center))
    mean = float(abs(np.mean(inside[2])) / section)
    error = float(beam.relative_error(place))
    return (
        Finding(
            statement="Under the slider the amplitude is that of an aperture's near field.",
            quantity="|u_z| on the axis over that of the plane section",
            expected=f"{expected:.3f} +- 0.1, Fresnel's integral",
            found=on_axis,
            confirmed=abs(on_axis - expected) < 0.1,
        ),
        Finding(
            statement="The beam keeps within the aperture.",
            quantity="mean of u_z over the aperture over that of the plane section",
            expected="between 0.8 and 1.02",
            found=mean,
            confirmed=0.8 < mean < 1.02,
        ),
        Finding(
            statement="The integral over the lateral wavenumber adds nothing to the section's error.",
            quantity="estimated relative error under the slider",
            expected="below twice the tolerance of the section",
            found=error,
            confirmed=error < 2 * tolerance,
        ),
    )


@of_record
def figure(record: Panel, ax):
    """Draw the beam as points, Fresnel's integral as a line and the section dashed."""
    from studies.report.figures import COLOURS, legend_below

    data = record.data
    ax.plot(data["at"], data["section_m_per_V"] * 1e9, "--", color=COLOURS["stick"], label="plane section")
    ax.plot(
        data["at"],
        data["fresnel_m_per_V"] * 1e9,
        "-",
        color=COLOURS["line"],
        linewidth=1,
        label="Fresnel's integral",
    )
    ax.plot(
        data["at"],
        data["beam_m_per_V"] * 1e9,
        "o",
        color=COLOURS["slip"],
        markersize=2,
        label="finite aperture",
    )
    ax.set_xlabel(data["axis"])
    ax.set_ylabel("|u_z| (nm per V)")
    ax.set_ylim(bottom=0)
    ax.set_title(record.title, fontsize="medium")
    ax.grid(alpha=0.3)
    legend_below(ax, columns=3)
    return ax
