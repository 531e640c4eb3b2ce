"""The normal force of a slider's contacts that is not that of smooth dry ones: adhesion, or a law of the user."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from studies.scene.block import Block
from studies.scene.numbers import Quantity
from studies.scene.rule import TEXT, Plain, choice

HOLDING = ("JKR", "Maugis")  # models whose contact ends beyond the approach at which it begins


@dataclass(frozen=True, kw_only=True)
class Adhesion(Block):
    """Attraction of balls in contact, as a table; the friction limit follows from the elastic force alone."""

    block: ClassVar[str] = "slider.adhesion"
    parameters_of = "contact.AdhesionRules"
    model: Annotated[
        str,
        choice("DMT", "meniscus", *HOLDING),
        "DMT: 2 pi work R (Derjaguin, Muller and Toporov); meniscus: of a liquid, 4 pi surface_tension R cos("
        "contact_angle). JKR (Johnson, Kendall and Roberts) and Maugis (Maugis and Dugdale, from DMT to JKR) hold on "
        "beyond the touch and lose energy in every hop.",
    ]
    work: Annotated[
        float | None, Quantity("J/m^2"), "Work of adhesion w of ball and stator; with all models but meniscus."
    ] = None
    separation: Annotated[
        float | None, Quantity("m"), "Equilibrium separation of the surfaces; with the model Maugis. Absent: 0.3 nm."
    ] = None
    surface_tension: Annotated[
        float | None, Quantity("N/m"), "Surface tension of the liquid; with the model meniscus."
    ] = None
    contact_angle: Annotated[
        float, Quantity("deg", zero=True, below=90.0), "Contact angle of the liquid; with the model meniscus."
    ] = 0.0

    @property
    def holds(self) -> bool:
        """Whether a contact ends beyond the approach at which it begins."""
        return self.model in HOLDING


@dataclass(frozen=True, kw_only=True)
class NormalLawText(Block):
    """A normal law of the user with its source, as a resolved scene keeps it."""

    block: ClassVar[str] = "slider.normal_law"
    name: Annotated[str, TEXT, "Name of the file."]
    source: Annotated[
        str,
        Plain("the text of a file", lambda value: isinstance(value, str) and value != "", {"type": "string"}),
        "Content of the file: Python code that defines force(approach, contact) in SI units.",
    ]

    def __str__(self) -> Any:
        return self.name
