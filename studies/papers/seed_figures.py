"""Figures of the seed paper, computed with our model, and the statements of the paper about them.

P. J. Feenstra and P. C. Breedveld, *Analysis of a Surface Acoustic Wave Motor*: Figs 2, 5(a), 5(b), 6(a), 6(b), 7(a)
and 7(b), each with sentences of the paper and the numbers that confirm or contradict them.
Method: the slider of ``twente-contact`` on its prescribed wave. The paper states neither its dampers nor its ratio of
amplitudes; those of the scene are used. Expected: all statements are confirmed except the damping in Fig. 7(b). With
the elastic law, only R_t damps the ring, and an R_t that is large enough to be visible would stop the motor; the losses
of a hysteretic law have the right size. Run time: about 15 s.
"""

import logging

from studies.papers.seed import Seed
from studies.papers.seed_contact import figure_6a, figure_6b, figure_7
from studies.papers.seed_slider import figure_2, figure_5a, figure_5b
from studies.record.plots import COLOURS, legend_below, titled
from studies.study_list import Answered, Panel, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"steps": (10e-9,)}
FEW = 25  # curves with at most this number of values are drawn as points


@study()
def run(*, steps: tuple[float, ...] = ()) -> Answered:
    """Return the panels of the paper's figures and the findings beside its sentences.

    Parameters
    ----------
    steps : tuple of float
        Amplitudes of the bursts of Fig. 5(a) in m, 10 nm among them; the paper's when empty.
    """
    seed = Seed(steps=steps)
    panels, findings = [], []
    for make in (figure_2, figure_5a, figure_5b, figure_6a, figure_6b, figure_7):
        LOGGER.info(f"seed figures: {str(make.__doc__).split(':')[0]}")
        of_figure, checks = make(seed)
        panels += of_figure
        findings += checks
    return panels, findings


@of_record
def figure(record: Panel, ax):
    """Draw the curves of a panel on the left axis and, if there are any, on a second axis on the right."""
    data = record.data
    palette = iter([COLOURS["slip"], COLOURS["intermittent"], COLOURS["second"], COLOURS["line"], "#CC79A7", "#56B4E9"])
    axes = [(ax, data["left"], data["left_axis"])]
    if "right" in data:
        axes.append((ax.twinx(), data["right"], data["right_axis"]))
    lines = []
    for side, curves, label in axes:
        for name, values in curves.items():
            style = "o" if len(values) <= FEW else "-"
            lines += side.plot(data["x"][name] if isinstance(data["x"], dict) else data["x"], values, style,
                               color=next(palette), linewidth=1, markersize=4, label=name)  # fmt: skip
        side.set_ylabel(label)
    for (name, at), style in zip(data.get("verticals", {}).items(), (":", "--"), strict=False):
        lines.append(ax.axvline(at, color=COLOURS["line"], linestyle=style, linewidth=1, label=name))
    ax.set_xlabel(data["x_axis"])
    titled(ax, record.title)
    ax.grid(alpha=0.3)
    legend_below(ax, lines, columns=5)
    return ax
