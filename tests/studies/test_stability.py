"""The atlas of extreme cases and the study of what is left out: verdicts that can fall, references that can speak."""

import json
import math
import warnings

import numpy as np
import pytest

import fem
from studies.evidence import left_out, stability
from studies.evidence.omission import OMISSIONS
from studies.evidence.stability import chain as stability_chain
from studies.evidence.stability import extreme_contacts as stability_contact
from studies.evidence.stability import free as stability_free
from studies.evidence.stability import stator as stability_stator
from studies.evidence.stability.reference_solutions import stored_references
from studies.evidence.stability.verdict import Case, NoReference, Outcome, judge, judged
from studies.refusal import RunError
from studies.study_list import STUDIES
from tests import stability_cases


def case_of(module, part: str, varied: str, value: float) -> Outcome:
    return judge(module, Case(part=part, varied=varied, value=value, unit=""))


def raising(error: Exception):
    def posed():
        raise error

    return posed


def warned():
    warnings.warn("overflow", RuntimeWarning, stacklevel=1)
    return 0.0, 1e-4, True


@pytest.mark.parametrize(
    ("posed", "verdict"),
    [
        (lambda: (1e-4, 1e-4, True), "right"),
        (lambda: (1.9e-4, 1e-4, True), "right"),
        (lambda: (2.1e-4, 1e-4, True), "WRONG"),
        (lambda: (0.9e-5, 1e-9, True), "right"),  # a hundredth of the tolerance: nothing was asked of the estimate
        (lambda: (1.1e-5, 1e-9, True), "WRONG"),
        (lambda: (math.nan, 1e-4, True), "WRONG"),
        (lambda: (1e-4, math.nan, True), "WRONG"),
        (lambda: (1e-3, 2e-3, True), "flagged"),
        (lambda: (1e-4, 1e-4, "the error is larger than asked for"), "flagged"),
        (raising(RunError("too thick")), "refused"),
        (raising(NoReference("none")), "flagged"),
        (raising(fem.InputError("stator.length", "must be positive", 0.0, "m")), "refused"),
        (raising(ValueError("array must not contain infs")), "WRONG"),
        (raising(ZeroDivisionError("division")), "WRONG"),
        (warned, "WRONG"),
    ],
)
def test_a_verdict_follows_error_estimate_and_what_was_raised(posed, verdict):
    assert judged(posed, 1e-3).verdict == verdict


@pytest.mark.parametrize(
    ("module", "part", "varied", "value", "verdict"),
    [
        (stability_free, "free wave", "Poisson's ratio", 0.4999999, "right"),
        (stability_free, "free wave", "mechanical quality", 5.0, "right"),
        (stability_free, "free wave", "coupling", 10.0, "right"),
        (stability_free, "free wave", "frequency", 1e13, "right"),
        pytest.param(stability_stator, "stator", "metallisation", 0.02, "right", marks=pytest.mark.slow),
        pytest.param(
            stability_stator, "stator", "distance from a piece's resonance", 0.0, "refused", marks=pytest.mark.slow
        ),
        (stability_stator, "stator", "distance from a cut-off", 0.0, "refused"),
        (stability_stator, "stator", "thickness, thick", 100.0, "refused"),
    ],
)
def test_a_few_cases_come_out_as_they_should(module, part, varied, value, verdict):
    outcome = case_of(module, part, varied, value)
    assert outcome.verdict == verdict, outcome
    assert bool(outcome.guard) == (verdict != "right")


def test_the_stored_corners_are_those_that_are_drawn():
    assert stability_contact.CORNERS == stability_cases.corners()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        pytest.param(name, value, marks=() if (name, value) == ("thickness, thin", 0.05) else pytest.mark.slow)
        for name, value in stability_cases.STORED
    ],
)
def test_the_stored_references_are_those_of_one_sparse_matrix(name, value):
    admittance, motion = stability_cases.stator_reference(name, value)
    stored = stored_references()[name, value]
    assert stored[0] == pytest.approx(admittance, rel=1e-7)
    assert stored[1] == pytest.approx(motion, rel=0, abs=1e-7 * abs(motion).max())


@pytest.mark.slow
def test_a_lossy_layer_under_a_tilted_cut_is_judged_by_its_own_convergence():
    assert case_of(stability_free, "free wave", "cut", 6.0).verdict in ("refused", "right")


@pytest.mark.slow
@pytest.mark.parametrize("varied", ["source impedance", "three contacts", "mirror image", "load"])
def test_the_chain_agrees_with_its_references(varied):
    """A slider that 1 N pulls runs away: it has no answer from the velocity of the slowest surface waves on."""
    for value in stability_chain.VARIED[varied][1]:
        outcome = case_of(stability_chain, "chain", varied, value)
        if (varied, value) == ("load", 1.0):
            assert (outcome.verdict, "runaway" in outcome.guard) == ("flagged", True)
        else:
            assert outcome.verdict == "right", outcome


def rows():
    """Cases of two parts as the study keeps them."""
    made = []
    for part in stability.PARTS:
        for number, verdict in enumerate(("right", "flagged", "refused")):
            answered = verdict != "refused"
            case = Case(part=part, varied="a quantity", value=10.0**number, unit="m")
            error, estimate = (1e-5, 3e-5) if answered else (math.nan, math.nan)
            guard = "" if verdict == "right" else "a|guard"
            outcome = Outcome(
                verdict=verdict, guard=guard, relative_error=error, relative_estimate=estimate, seconds=0.5
            )
            made.append(stability.case_row(case, outcome))
    return made


def record():
    made = rows()
    return stability.StudyRecord(
        name="stability",
        panels=tuple(
            stability.part_panel(part, [row for row in made if row["part"] == part]) for part in stability.PARTS
        ),
        findings=stability.atlas_findings(made),
        seconds=1.0,
    )


def test_the_atlas_leaves_tables_pictures_and_numbers(tmp_path):
    found = record()
    json.dumps(found.to_dict(), allow_nan=False)
    files = stability.tables(found)
    assert files["cases.csv"].count("\n") == 13
    assert "| chain | a quantity | 1 m | 100 m | 3 | 1 | 1 | 1 |  | 0.33 | 1.5 | a/guard |" in files["summary.md"]
    stability.draw(found, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        "free_wave.png", "stator.png", "contact.png", "chain.png", "error_against_estimate.png",
    }  # fmt: skip


def test_a_part_of_the_atlas_is_not_judged_by_its_number_of_cases():
    """`--quick` takes one case of two parts."""
    made = rows()
    few, wrong = stability.atlas_findings(made, whole=False)
    assert (few.confirmed, wrong.confirmed) == (None, True)
    assert few.expected == "at least 150 in the whole study"
    assert stability.atlas_findings(made)[0].confirmed is False


def test_one_wrong_answer_contradicts_the_atlas():
    made = rows()
    assert [finding.confirmed for finding in stability.atlas_findings(made * 13)] == [True, True]
    made[0] |= {"verdict": "WRONG"}
    assert [finding.confirmed for finding in stability.atlas_findings(made * 13)] == [True, False]


def test_both_studies_are_listed():
    assert {"stability", "left_out"} <= set(STUDIES)


QUICK = (
    "out-of-plane displacement",
    "electric potential",
    "absorbing layers at the ends",
    "complex arithmetic in the pieces",
)


@pytest.mark.parametrize("omission", [each for each in OMISSIONS if each.part in QUICK], ids=lambda each: each.part)
def test_the_answer_is_the_same_with_a_part_included(omission):
    first, second = omission.without(), omission.included()
    assert first.values == pytest.approx(second.values, rel=0, abs=omission.allowed * abs(second.values).max())
    assert first.unknowns != second.unknowns or np.any(first.values != second.values), "the two are one run"


@pytest.mark.slow
def test_every_part_that_is_left_out_is_measured_and_found_the_same():
    found = left_out.run()
    assert all(finding.confirmed for finding in found.findings), str(found)
    assert "| out-of-plane displacement |" in left_out.tables(found)["left_out.md"]
