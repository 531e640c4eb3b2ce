"""The block of the roughness of a slider's balls; `roughness_of_balls` makes its mean fields and samples."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from studies.scene.block import Block
from studies.scene.numbers import Quantity
from studies.scene.rule import RANDOM_SEED, TEXT

STARTS = 0.2e-3  # m/s: rough balls have no sharp threshold, for some asperity slips in every wave


@dataclass(frozen=True, kw_only=True)
class Roughness(Block):
    """Heights of the asperities of the balls: of many the mean field, with a seed or a file those of one ball."""

    block: ClassVar[str] = "slider.roughness"
    rms: Annotated[
        float | Any,
        Quantity("m"),
        "Standard deviation of the heights over the size of a contact, some um, not of the whole ball; required unless "
        "file is given.",
    ] = None
    asperity_radius: Annotated[float | None, Quantity("m"), "Radius of the asperities. Absent: 10 um."] = None
    density: Annotated[float | None, Quantity("1/m^2"), "Asperities per area. Absent: 0.05/(asperity_radius rms)."] = (
        None
    )
    seed: Annotated[
        int | None,
        RANDOM_SEED,
        "Seed of one sample of asperities, each with its own stick and slip: the answer is that of one ball, with the "
        "scatter of eight. Absent, without file: the mean field of many asperities.",
    ] = None
    file: Annotated[
        str | None,
        TEXT,
        "Patch of an atomic force microscope, instead of rms, asperity_radius and density: .gwy of Gwyddion, .npy, "
        "text or what SurfaceTopography reads; the path is relative to the folder of the scene. Its plane and its "
        "sphere are removed, and it continues periodically; seed places the ball on it, eight places give the scatter.",
    ] = None
    step: Annotated[
        float | None,
        Quantity("m"),
        "Size of a pixel of a file that does not state it, .npy or text, in m as its heights.",
    ] = None

    def check_given(self) -> Any:
        if self.file is None:
            if self.rms is None:
                yield "rms", 'is required and missing: give a length such as "3 nm", or slider.roughness.file'
            if self.step is not None:
                yield "step", "belongs to slider.roughness.file, which is missing"
            return
        for key in ("rms", "asperity_radius", "density"):
            if getattr(self, key) is not None:
                yield key, "must be absent with slider.roughness.file, whose heights have their own"

    @property
    def sampled(self) -> bool:
        """Whether it is a sample of asperities, and not the mean field of many."""
        return self.seed is not None or self.file is not None
