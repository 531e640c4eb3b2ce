"""Laws from a user's file by all three methods, beside an independent integrator.

Kernels call a user's functions by address, so that they are compiled once for all laws with the same functions.
"""

import textwrap
from dataclasses import replace

import pytest

from contact import UserLaw, burst, mean_motion, steady
from contact.exceptions import InputError
from contact.jit import compiled
from tests.contact.motors import friction_motor, orbit, slider
from tests.oracles.contact_friction import follow

# viscous and Coulomb friction; with a coefficient above KINKED Stribeck's curve in two straight lines, whose kink in
# the slip speed is no event of the exact method
VISCOUS = """
    MU, ETA = 0.15, 0.4  # 1, s/m
    KINKED = 0.35
    STATIC, SLIDING, SPEED = 0.3, 0.15, 0.02

    def sliding(approach, normal_force, slip_speed, contact):
        if contact.friction_coefficient < KINKED:
            return normal_force * (MU + ETA * slip_speed)
        if slip_speed < SPEED:
            return normal_force * (STATIC - (STATIC - SLIDING) * slip_speed / SPEED)
        return normal_force * SLIDING
    """
# the viscous law with a spring of its own, stiffer and linear
LINEAR = (
    VISCOUS
    + """
    def stiffness(approach, contact):
        return 8.0 * contact.tangential_modulus * (contact.radius * approach) ** 0.5

    def limit(approach, normal_force, contact):
        return MU * normal_force / stiffness(approach, contact)

    def stuck(approach, normal_force, deformation, contact):
        return stiffness(approach, contact) * deformation
    """
)


def law(text):
    return UserLaw("law.py", textwrap.dedent(text))


@pytest.mark.parametrize(("shape", "near"), [("punch", 2e-8), ("sphere", 1e-6)])
def test_a_users_law_with_a_kink_is_followed_to_the_truncation(shape, near):
    s, waves, same = friction_motor(law(VISCOUS), lambda p, w: 0.3 - 0.15 * min(w / 0.02, 1.0), shape)
    s = replace(s, friction_coefficient=0.4)
    state, _, _, tangential, _ = follow(same, 6)
    exact = burst(s, waves, duration=6 / 2.2e6, after=0.0, tolerance=1e-9, samples=6, method="exact")
    assert exact.velocity_at_burst_end == pytest.approx(state[2], rel=near)
    assert exact.ledger.wave_tangential == pytest.approx(tangential, rel=near)
    assert exact.ledger.relative_residual < 1e-9
    assert exact.statistics["halvings"] > 20  # the kinks shorten the segments
    steps = burst(s, waves, duration=6 / 2.2e6, after=0.0, tolerance=1e-5, samples=6, method="stepped")
    apart = abs(steps.velocity_at_burst_end - exact.velocity_at_burst_end)
    assert apart < 2.0 * steps.answer.error + 2.0 * exact.answer.error


# Oracle: DOP853 between events, as in test_friction.py
def test_a_viscous_law_moves_as_the_independent_integrator_says():
    s, waves, same = friction_motor(law(VISCOUS), lambda p, w: 0.15 + 0.4 * w, "punch")
    state, _, _, tangential, _ = follow(same, 6)
    exact = burst(s, waves, duration=6 / 2.2e6, after=0.0, tolerance=1e-9, samples=6, method="exact")
    assert exact.velocity_at_burst_end == pytest.approx(state[2], rel=1e-7)
    assert exact.ledger.wave_tangential == pytest.approx(tangential, rel=1e-7)


@pytest.mark.parametrize("text", [VISCOUS, pytest.param(LINEAR, marks=pytest.mark.slow)], ids=["viscous", "linear"])
def test_bursts_of_a_law_from_a_file_agree_by_all_three_methods(text):
    s, wave = slider(friction=law(text)), orbit(6e-9)
    runs = [
        burst(s, wave, duration=3500 / 2.2e6, after=0.0, tolerance=1e-4, samples=4, method=method)
        for method in ("exact", "stepped", "averaged")
    ]
    reference = max(abs(runs[0].velocity_at_burst_end), wave.omega * abs(wave.tangential) / 10.0)
    for run in runs[1:]:
        apart = abs(run.velocity_at_burst_end - runs[0].velocity_at_burst_end) / reference
        assert apart < 2.0 * (run.relative_error + runs[0].relative_error)


@pytest.mark.slow  # a kernel of its own for laws with a spring and without; test_friction.py has it for another
@pytest.mark.parametrize(("text", "residual"), [(VISCOUS, 1e-8), (LINEAR, 1e-6)], ids=["viscous", "linear"])
def test_steady_states_of_a_law_from_a_file_agree(text, residual):
    s, wave = slider(friction=law(text)), orbit(6e-9)
    exact, mean = steady(s, wave, tolerance=1e-6), mean_motion(s, wave)
    assert exact.velocity == pytest.approx(mean.velocity, rel=1e-6)
    assert exact.ledger.relative_residual < residual
    plain = steady(slider(friction_coefficient=0.15), wave, tolerance=1e-6)
    assert abs(exact.velocity / plain.velocity - 1.0) > 5e-4


# Closed form: dragged along a surface at rest, load = P (MU + ETA v) + R_t v
def test_an_edited_law_is_another_law(tmp_path):
    file = tmp_path / "law.py"
    for eta in (0.4, 0.8, 0.4):
        file.write_text(textwrap.dedent(VISCOUS).replace("ETA = 0.15, 0.4", f"ETA = 0.15, {eta}"))
        s = slider(law=str(file), load=4e-4, tangential_damping=1e-3)
        v = abs(steady(s, orbit(0.0), tolerance=1e-6).velocity)
        assert v > 0.01
        assert s.preload * (0.15 + eta * v) + 1e-3 * v == pytest.approx(s.load, rel=1e-9)
    # the text is part of the name of what is kept on disk of the law, but not of what is kept of the kernels
    first, second = (slider(friction=law(VISCOUS.replace("0.4", eta))).tangential_law for eta in ("0.4", "0.8"))
    assert first.callbacks.sliding.name != second.callbacks.sliding.name
    assert first.callbacks.sliding.word == second.callbacks.sliding.word
    assert first._replace(callbacks=None, numbers=None) == second._replace(callbacks=None, numbers=None)


# Closed form: dragged along a surface at rest, load = P mu (1 + 0.1 * 5) + R_t v; mu alone with integers of 64 bits
@pytest.mark.parametrize(
    "factor",
    [
        "1.0 + 10 ** POWER * 5.0",
        "1 + pow(TEN, -1) * 5",
        "1 + 5 * WEIGHTS[2 * 1]",
        "1 + BIG * BIG / 2e20",
        "1 + halves()",
    ],
)
def test_whole_numbers_are_those_of_python(factor):
    text = f"""
    TEN, POWER, BIG, WEIGHTS = 10, -1, 10**10, (0.5, 0.2, 0.1)

    def halves():
        total = 0.0
        for k in range(2, 3):
            total += 2 ** -k * 2
        return total

    def sliding(approach, normal_force, slip_speed, contact):
        return 0.08 * normal_force * ({factor})
    """
    s = slider(friction=law(text), load=4e-4, tangential_damping=1e-3)
    v = abs(steady(s, orbit(0.0), tolerance=1e-6).velocity)
    assert s.preload * 0.12 + 1e-3 * v == pytest.approx(s.load, rel=1e-9)


APART = r"must be the same in Python and compiled, but in law\.py sliding\(1e-13, .* compiled by numba"


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        # an index that only whole numbers make, beside a power of two whole numbers
        ("i, n = 2 * 1, -1\n        return normal_force * (0.0, 0.2, 0.1)[i] * 2**n", APART),
        ("return normal_force * float(str(0.1))", "whose sliding numba cannot compile"),
        ("return normal_force * HEAP['mu']", "whose sliding numba cannot compile: TypingError"),
        ("COUNT.append(1)\n        return normal_force * 0.1 * len(COUNT)", "whose sliding numba cannot compile"),
    ],
)
def test_a_law_that_is_another_when_compiled_is_refused(body, sentence, monkeypatch):
    monkeypatch.setattr(compiled, "ORDINARY", {})  # what cannot be native code is tried with numba's own
    text = f"""
    HEAP, COUNT = {{"mu": 0.1}}, [1]

    def sliding(approach, normal_force, slip_speed, contact):
        {body}
    """
    with pytest.raises(InputError, match=sentence):
        slider(friction=law(text))


@pytest.mark.parametrize("name", ["guard", "follow", "memory"])
def test_guards_and_memory_of_a_users_law_are_refused(name):
    with pytest.raises(InputError, match=rf"slider\.law must not define {name}, but law\.py does"):
        law(VISCOUS + f"\n    def {name}(*arguments):\n        return 1.0\n    ")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("MU = 0.1", "must define sliding"),
        ("def sliding(force): return force", "takes other arguments"),
        ("def sliding(", "cannot be run: SyntaxError"),
        ("def sliding(a, p, w, c): return -p", "zero or positive, and finite"),
        ("def sliding(a, p, w, c): return p / (w - w)", "cannot be evaluated: ZeroDivisionError"),
    ],
)
def test_a_law_that_is_none_is_refused(text, sentence):
    with pytest.raises(InputError, match=sentence):
        slider(friction=UserLaw("law.py", text))
