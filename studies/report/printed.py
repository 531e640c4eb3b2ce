"""A run on one printed page (A4, PDF): answer, warnings, motor and assumptions as text, and pictures below it."""

import io
import textwrap
from pathlib import Path

from studies.record import Record, plots, run_pictures
from studies.record.text import answer, labelled
from studies.report import run_drawings
from studies.report.contents import contents
from studies.results.content import provenance

FILE = "report.pdf"
A4 = (8.27, 11.69)  # inches
MARGIN, COLUMNS, ROWS = 0.55, 3, 2  # inches; pictures side by side, and rows of them
DPI = 300  # of the pictures, which are images on the page
# size in which a picture is drawn over that of a run's own: its words of 10 points have 5 on the page, not 3.4
DRAWN, GAP = 0.65, 0.1  # GAP: inches between pictures
LETTER, LINE = 0.602, 1.25  # width of a letter of the monospaced font and height of a line, over the font's size
LARGEST, SMALLEST = 8.0, 4.5  # points, of the text
# of the pictures, those that come first where there are more than a page takes
ORDER = ("velocity", "layout", "surface", "beam", "load_line", "trajectory", "measured", "section_field")


def write_pdf(record: Record, path: Path) -> None:
    """Write the page of a record: text from the top, as large as its half of the page permits, pictures below it.

    Parameters
    ----------
    record : Record
    path : Path
        Of the file.
    """
    figure, _ = plots.new_figure(*A4, rows=0)
    figure.set_layout_engine(None)
    width, height = A4[0] - 2 * MARGIN, A4[1] - 2 * MARGIN
    pictures = _pictures(record)
    rows = -(-len(pictures) // COLUMNS)
    cell = width / COLUMNS, width / COLUMNS * plots.SIZE[1] / plots.SIZE[0]
    size, lines = fitted(text(record), width, height - rows * cell[1] - 0.6)
    figure.text(MARGIN / A4[0], 1 - MARGIN / A4[1], record.scene.title or "A run of sawmotor", fontsize=12, va="top",
                parse_math=False, wrap=True)  # fmt: skip
    figure.text(MARGIN / A4[0], 1 - (MARGIN + 0.35) / A4[1], "\n".join(lines), fontsize=size, va="top",
                family="monospace", linespacing=LINE, parse_math=False)  # fmt: skip
    for k, image in enumerate(pictures):
        left, down = MARGIN + k % COLUMNS * cell[0], MARGIN + (rows - 1 - k // COLUMNS) * cell[1] + 0.15
        ax = figure.add_axes((left / A4[0], down / A4[1], (cell[0] - GAP) / A4[0], (cell[1] - GAP) / A4[1]))
        ax.imshow(image)
        ax.axis("off")
    version = f"sawmotor {provenance()['version']}; tolerance {record.tolerance:g}; exp(+i omega t), peak values"
    figure.text(MARGIN / A4[0], 0.6 * MARGIN / A4[1], version, fontsize=6)
    figure.savefig(path, format="pdf")


def text(record: Record) -> list[str]:
    """Return the lines of the page: the points, what else was found, warnings, the motor, and what was assumed."""
    lines = answer(record).splitlines()[1:]
    # of what the model leaves out, "left out" has the number; the page has the list
    kept = [line for line in lines if not line.startswith(("left out", "seconds"))]
    left_out = "; ".join(record.left_out)
    entries = [("warning", list(record.warnings)), *contents(record.scene), ("left out", left_out)]
    return [*kept, *labelled((name, rows) for name, rows in entries if rows)]


def fitted(lines: list[str], width: float, height: float) -> tuple[float, list[str]]:
    """Return the largest size in points at which the lines, wrapped, take no more than a width and height in inches.

    At the smallest size the lines that are too many are left out, and the last one says how many.
    """
    size = LARGEST
    while True:
        letters = int(72 * width / (LETTER * size))
        wrapped = [part for line in lines for part in textwrap.wrap(line, letters, subsequent_indent=" " * 16) or [""]]
        room = int(72 * height / (LINE * size * 1.05))
        if len(wrapped) <= room or size <= SMALLEST:
            break
        size -= 0.25
    if len(wrapped) > room:
        wrapped = [*wrapped[: room - 1], f"({len(wrapped) - room + 1} more lines: sawmotor run)"]
    return size, wrapped


def _pictures(record: Record) -> list:
    """Return the pictures of the run as arrays of colours, the first of `ORDER`."""
    from matplotlib.image import imread

    drawn = run_pictures.pictures(record) | run_drawings.drawings(record)
    names = sorted(drawn, key=lambda name: ORDER.index(name) if name in ORDER else len(ORDER))
    images = []
    for name in names[: COLUMNS * ROWS]:
        file = io.BytesIO()
        plots.saved(file, drawn[name], size=(DRAWN * plots.SIZE[0], DRAWN * plots.SIZE[1]), dpi=DPI, format="png")
        file.seek(0)
        images.append(imread(file))
    return images
