"""The averaged motor of a slider in the plane: a body moved by tabulated mean forces, and its state over time."""

from dataclasses import dataclass, field, replace

import numpy as np

from studies.export import reduced_plane as model
from studies.export.motor_model import OfScene, refuse_preload
from studies.export.planar_body import Body
from studies.export.reduced_plane import plane_index as index
from studies.refusal import RunError, refuse_if

ENOUGH = 1e-9  # of the rates: a motor whose motion changes less in a step is steady
STEADY_STEP, STEADY_STEPS = 0.05, 1000  # s; the implicit steps on the way to the steady motion, and how many


@dataclass(frozen=True, kw_only=True)
class PlanarMotor(OfScene):
    """A motor whose slider moves in the plane, or turns, by the cycle means of the contact forces.

    Errors are relative to max(|v|, omega |u_t|/10), v the largest speed of a contact.
    """

    body: Body = field(repr=False)
    drives: tuple[str, ...]  # names of the sources of each frequency
    load: tuple[float, float, float]  # of the scene, as it acts on the slider: forces in N, torque in N m
    limits: tuple[float, ...]  # largest levels of all drives together at the scene's preload, of tables; else empty
    # largest error of the mean force over mu preload at random points, and its 95 % quantile
    force_error: tuple[float, float] = (0.0, 0.0)
    velocity_error: float = 0.0  # largest, of the steady motion at the scene's levels and parts of them
    averaging_error: float = 0.0  # of those by averaging
    left_out: tuple[str, ...] = ()

    @property
    def preload(self) -> float:
        """Preload of the scene, N."""
        return self.body.slider.preload * self.body.share

    @property
    def amplitudes(self) -> list[float]:
        """Largest |u_z| under the contacts of each drive for a level of 1, m."""
        return self.parameters[index.AMPLITUDE :][: len(self.drives)].tolist()

    @property
    def reach_in_words(self) -> str:
        """How far the levels reach."""
        if not self.limits:
            return "any level"
        ends = (f"{limit:.3g} {self.unit} of {name}" for limit, name in zip(self.limits, self.drives, strict=True))
        return f"{' or '.join(ends)} alone, under the preload of {self.preload:.4g} N"

    @property
    def freedom(self) -> str:
        """Freedom of the slider."""
        return self.body.freedom

    @property
    def state_size(self) -> int:
        """Number of values of a state."""
        return index.STATE_SIZE + index.ELEMENT_STATE * int(self.parameters[index.ELEMENTS])

    def start(self) -> "PlanarState":
        """Return the motor at rest at its first place."""
        numbers = np.zeros(self.state_size)
        model.begin(self.parameters, numbers)
        return PlanarState(motor=self, numbers=numbers)

    def steady(self, *levels: float) -> np.ndarray:
        """Return the rates (V_x, V_y, yaw rate) at levels of the drives under the load, at the first place."""
        steps = self.parameters.copy()
        steps[index.MAX_STEP], steps[index.RISE] = STEADY_STEP, 0.0
        state = replace(self, parameters=steps).start()
        arms = np.array([1.0, 1.0, max(np.hypot(*each) for each in self.body.places) or 1.0])
        for _ in range(STEADY_STEPS):
            before = state.rates
            state.advance(STEADY_STEP, *levels, load=self.load)
            state.numbers[index.POSE : index.POSE + 3] = 0.0
            if state.rests:
                break  # friction holds it: the creep is no motion
            if np.abs((state.rates - before) * arms).max() <= ENOUGH * np.abs(state.rates * arms).max():
                break
        return state.rates


@dataclass(frozen=True, kw_only=True)
class PlanarState:
    """State of a motor in the plane; `advance` changes it in place."""

    motor: PlanarMotor = field(repr=False)
    numbers: np.ndarray = field(repr=False)

    def advance(
        self, duration: float, *levels: float, load: tuple[float, float, float] = (0.0, 0.0, 0.0),
        preload: float | None = None,
    ) -> None:  # fmt: skip
        """Advance by a duration in s under constant inputs.

        Parameters
        ----------
        levels : float
            Of each drive, V or m, zero or positive.
        load : (F_x, F_y, torque)
            Acting on the slider along +x, +y and positive yaw, N and N m.
        preload : float, optional
            N, positive; the scene's when absent.

        Raises
        ------
        SceneError
            For a negative level or a preload that is not positive.
        RunError
            If the motion is not finite, or the tables do not reach as far as the levels.
        """
        preload = self.motor.preload if preload is None else preload
        refuse_if(min(levels) < 0.0, "level", f"must be zero or positive, got {min(levels)!r}")
        refuse_preload(preload)
        both = (*map(float, levels), 0.0)[:2]
        failed = model.advance(
            self.motor.parameters, self.motor.tables, self.numbers, *both, *map(float, load), float(preload),
            float(duration),
        )  # fmt: skip
        if failed == 2:
            raise RunError(f"the tables reach up to {self.motor.reach_in_words}: lower the levels or raise the preload")
        if failed:
            raise RunError("the averaged motion is not finite: check levels, forces and preload")

    time = property(lambda self: float(self.numbers[index.TIME]))
    pose = property(lambda self: self.numbers[index.POSE : index.POSE + 3].copy())
    rates = property(lambda self: self.numbers[index.RATES : index.RATES + 3].copy())
    rests = property(lambda self: bool(self.numbers[index.RESTS]))

    def copy(self) -> "PlanarState":
        """Return an independent copy."""
        return replace(self, numbers=self.numbers.copy())
