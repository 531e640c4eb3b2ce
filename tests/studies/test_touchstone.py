"""Touchstone files of all forms.  Oracles: circuits in closed form, definitions of the parameters, and scikit-rf."""

import numpy as np
import pytest

import fem
from studies.lab.network_file import read_network
from studies.lab.s_parameters import NetworkData
from studies.lab.waves import WAVES, in_ohm, scattering
from studies.refusal import SceneError
from studies.stator.network_deviation import deviations

skrf = pytest.importorskip("skrf")
FREQUENCY = np.array([2.1e6, 2.2e6, 2.3e6])
OMEGA = 2.0 * np.pi * FREQUENCY


def admittance(ports: int) -> np.ndarray:
    """Unlike capacitors to ground and resistors between neighbours, which are not reciprocal."""
    matrix = np.zeros((len(OMEGA), ports, ports), complex)
    for k in range(ports):
        matrix[:, k, k] += 1j * OMEGA * 1e-9 * (1 + k) + 1e-3 * (1 + k)
    for k in range(ports - 1):
        conductance = 4e-3 * (1 + k)
        matrix[:, k, k] += conductance
        matrix[:, k + 1, k + 1] += conductance
        matrix[:, k, k + 1] -= conductance
        matrix[:, k + 1, k] -= 0.5 * conductance  # not reciprocal: a transposed matrix is seen
    return matrix


def expected(ports: int, reference: float) -> np.ndarray:
    """S of this admittance, from its definition with equal references."""
    one, y = np.eye(ports), admittance(ports) * reference
    return np.array([(one - each) @ np.linalg.inv(one + each) for each in y])


def parameters(kind: str, ports: int) -> np.ndarray:
    """Parameters of this admittance in S and ohm: of h and g by their definitions, solved for."""
    y = admittance(ports)
    if kind == "y":
        return y
    if kind == "z":
        return np.linalg.inv(y)
    (y11, y12), (y21, y22) = y.transpose(1, 2, 0)
    if kind == "h":  # V1 = h11 I1 + h12 V2, I2 = h21 I1 + h22 V2
        rows = [[1 / y11, -y12 / y11], [y21 / y11, y22 - y21 * y12 / y11]]
    else:  # I1 = g11 V1 + g12 I2, V2 = g21 V1 + g22 I2
        rows = [[y11 - y12 * y21 / y22, y12 / y22], [-y21 / y22, 1 / y22]]
    return np.array(rows).transpose(2, 0, 1)


def normalised(kind: str, ports: int, reference: float) -> np.ndarray:
    """The same over one reference, as version 1 states them."""
    values = parameters(kind, ports)
    return values * {
        "y": reference, "z": 1 / reference, "h": np.array([[1 / reference, 1], [1, reference]]),
        "g": np.array([[reference, 1], [1, 1 / reference]]),
    }[kind]  # fmt: skip


def pair(value: complex, form: str) -> str:
    if form == "RI":
        return f"{float(value.real)!r} {float(value.imag)!r}"
    size = float(abs(value)) if form == "MA" else float(20 * np.log10(abs(value)))
    return f"{size!r} {float(np.degrees(np.angle(value)))!r}"


def text(kind, values, option, form="RI", unit=1e6, head=(), order="21_12", matrix="full") -> str:
    """A file of parameters; ``option``: of its option line; ``head``: lines of version 2 about it."""
    lines = [*head[:1], f"# {option}", *head[1:]]
    for at, each in zip(FREQUENCY, values, strict=True):
        ports = len(each)
        chosen = each.T if ports == 2 and order == "21_12" else each
        cells = {
            "full": chosen.ravel(), "lower": each[np.tril_indices(ports)], "upper": each[np.triu_indices(ports)],
        }[matrix]  # fmt: skip
        lines.append(" ".join([repr(float(at / unit)), *(pair(cell, form) for cell in cells)]))
    return "\n".join([*lines, *(["[End]"] if head else [])]) + "\n"


@pytest.mark.parametrize("form", ["RI", "MA", "DB"])
@pytest.mark.parametrize(("kind", "ports"), [("y", 1), ("z", 1), ("y", 2), ("z", 2), ("h", 2), ("g", 2), ("z", 3)])
@pytest.mark.parametrize("version", [1, 2])
def test_parameters_of_all_kinds_are_those_of_the_circuit(kind, ports, form, version, tmp_path):
    file, reference = tmp_path / f"lab.s{ports}p", 75.0
    head = () if version == 1 else (
        "[Version] 2.0", f"[Number of Ports] {ports}", "[Two-Port Data Order] 12_21", "[Number of Frequencies] 3",
        "[Network Data]",
    )  # fmt: skip
    values = normalised(kind, ports, reference) if version == 1 else parameters(kind, ports)
    option = f"MHz {kind.upper()} {form} R {reference:g}"
    file.write_text(text(kind, values, option, form, head=head, order="21_12" if version == 1 else "12_21"))
    found = read_network(file, "--measured")
    assert found.reference == reference
    np.testing.assert_allclose(found.frequency, FREQUENCY, rtol=1e-12)
    np.testing.assert_allclose(found.scattering, expected(ports, reference), atol=1e-12)
    np.testing.assert_allclose(found.admittance, admittance(ports), atol=1e-12)
    np.testing.assert_allclose(found.with_reference(50.0).scattering, expected(ports, 50.0), atol=1e-12)


@pytest.mark.parametrize(
    "option",
    ["MHz S RI R 50", "R 50 MHz S RI", "RI s mhz r 50", "S R 50 RI MHz ! a comment", "MHz RI", "R 50 RI MHZ S"],
)
def test_the_option_line_s_fields_stand_in_any_order(option, tmp_path):
    file = tmp_path / "lab.s2p"
    file.write_text(text("s", expected(2, 50.0), option))
    np.testing.assert_allclose(read_network(file, "--measured").scattering, expected(2, 50.0), rtol=1e-14)


@pytest.mark.parametrize("unit", [("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6), ("GHz", 1e9), ("", 1e9)])
def test_every_unit_of_frequency(unit, tmp_path):
    file = tmp_path / "lab.s1p"
    file.write_text(text("s", expected(1, 50.0), f"{unit[0]} S RI R 50", unit=unit[1]))
    np.testing.assert_allclose(read_network(file, "--measured").frequency, FREQUENCY, rtol=1e-12)


@pytest.mark.parametrize("matrix", ["lower", "upper"])
@pytest.mark.parametrize("ports", [2, 3])
def test_triangular_matrices_of_version_2_are_symmetric(matrix, ports, tmp_path):
    file, whole = tmp_path / f"lab.s{ports}p", expected(ports, 50.0)
    whole = 0.5 * (whole + whole.transpose(0, 2, 1))
    head = ("[Version] 2.0", f"[Number of Ports] {ports}", f"[Matrix Format] {matrix.title()}", "[Network Data]")
    file.write_text(text("s", whole, "MHz S RI R 50", head=head, matrix=matrix))
    np.testing.assert_allclose(read_network(file, "--measured").scattering, whole, rtol=1e-14)


REFERENCES = np.array([[50 + 10j, 75 - 5j], [51 + 10j, 76 - 5j], [52 + 10j, 77 - 5j]])


@pytest.mark.parametrize("wave", WAVES)
def test_waves_of_complex_references_of_each_port_and_frequency_are_scikit_rf_s(wave):
    theirs = skrf.network.y2s(admittance(2), REFERENCES, s_def=wave)
    np.testing.assert_allclose(scattering("s", theirs, 50.0, REFERENCES, wave), expected(2, 50.0), atol=1e-12)


@pytest.mark.parametrize("stated", ["power", "pseudo", "traveling", ""])
def test_a_file_s_own_definition_of_waves_holds(stated, tmp_path):
    file, wave = tmp_path / "lab.s2p", stated or "traveling"  # what HFSS means where it says nothing
    values = skrf.network.y2s(admittance(2), REFERENCES, s_def=wave)
    lines = text("s", values, "MHz S RI R 50").splitlines()
    comments = [f"! S-parameter uses the {stated} definition"] if stated else ["! Exported from HFSS"]
    for line, z in zip(lines[1:], REFERENCES, strict=True):
        first, second = (f"{float(each.real)!r} {float(each.imag)!r}" for each in z)
        comments += [line, "! Gamma 1 2 3 4", "! 5 6", f"! Port Impedance {first}", f"! {second}"]
    file.write_text("\n".join([comments[0], lines[0], *comments[1:]]) + "\n")
    found = read_network(file, "--measured")
    np.testing.assert_allclose(found.scattering, expected(2, 50.0), atol=1e-12)
    assert f"its references are changed to 50 ohm, {wave} waves" in found.remarks


def test_references_of_each_port_in_the_option_line_and_one_that_is_complex(tmp_path):
    file = tmp_path / "lab.s2p"
    values = skrf.network.y2s(admittance(2), np.array([50.0, 75.0]))
    file.write_text(text("s", values, "MHz S RI R 50 75"))
    np.testing.assert_allclose(read_network(file, "--measured").scattering, expected(2, 50.0), atol=1e-12)
    file.write_text(text("s", skrf.network.y2s(admittance(2), 50.0 + 5j, s_def="power"), "MHz S RI R 50+5j"))
    np.testing.assert_allclose(read_network(file, "--measured").scattering, expected(2, 50.0), atol=1e-12)
    head = ("[Version] 2.0", "[Number of Ports] 2", "[Two-Port Data Order] 21_12", "[Reference] 50+5j", "75-2j",
            "[Network Data]")  # fmt: skip
    values = skrf.network.y2s(admittance(2), np.array([50 + 5j, 75 - 2j]), s_def="power")
    file.write_text(text("s", values, "MHz S RI R 50", head=head))
    np.testing.assert_allclose(read_network(file, "--measured").scattering, expected(2, 50.0), atol=1e-12)


def test_parameters_normalised_to_references_of_each_port_are_theirs_over_square_roots():
    references = np.broadcast_to([50.0, 75.0], (3, 2))
    root = np.sqrt(references)
    z = parameters("z", 2) / (root[:, :, None] * root[:, None, :])
    np.testing.assert_allclose(in_ohm("z", z, references), parameters("z", 2), rtol=1e-13)
    # v1 = h11 i1 + h12 v2, i2 = h21 i1 + h22 v2 with v = V / sqrt(R), i = I sqrt(R)
    scale = np.array([[1 / 50.0, np.sqrt(75.0 / 50.0)], [np.sqrt(75.0 / 50.0), 75.0]])
    np.testing.assert_allclose(in_ohm("h", parameters("h", 2) * scale, references), parameters("h", 2), rtol=1e-13)


def test_what_scikit_rf_2_2_0_makes_of_these_files(tmp_path):
    """Surprises of scikit-rf 2.2.0, scikit-rf.org, for which Touchstone files are read here."""
    if skrf.__version__ != "2.2.0":
        pytest.skip("of another version")
    file = tmp_path / "lab.s1p"
    file.write_text(text("y", normalised("y", 1, 50.0), "MHz Y RI R 50"))
    np.testing.assert_allclose(skrf.Network(str(file)).y, 2500.0 * admittance(1), rtol=1e-9)
    np.testing.assert_allclose(read_network(file, "--measured").admittance, admittance(1), rtol=1e-9)
    file.write_text(text("s", expected(1, 50.0), "R 50 MHz S RI"))
    with pytest.raises(ValueError, match=r"illegal|could not convert|complex"):
        skrf.Network(str(file))
    # waves of a file, read into an empty network, stay power waves
    two = tmp_path / "lab.s2p"
    lines = text("s", skrf.network.y2s(admittance(2), REFERENCES, s_def="traveling"), "MHz S RI R 50").splitlines()
    rows = [f"{line}\n! Port Impedance {z[0].real} {z[0].imag} {z[1].real} {z[1].imag}"
            for line, z in zip(lines[1:], REFERENCES, strict=True)]  # fmt: skip
    two.write_text("\n".join([lines[0], *rows]) + "\n")
    empty = skrf.Network()
    empty.read_touchstone(str(two))
    assert (empty.s_def, skrf.Network(str(two)).s_def) == ("power", "traveling")


def test_a_point_at_rest_and_noise_are_left_out_and_zeros_are_not_measured(tmp_path):
    file = tmp_path / "lab.s2p"
    file.write_text("# MHz S RI R 50\n0 1 0 0 0 0 0 1 0\n2.1 .1 .2 .3 .4 0 0 0 0\n2.2 .1 .2 .3 .4 0 0 0 0\n"
                    "2 3 .1 10 .2\n2.1 3 .1 10 .2\n")  # fmt: skip
    found = read_network(file, "--measured")
    np.testing.assert_allclose(found.frequency, [2.1e6, 2.2e6], rtol=1e-12)
    assert found.elements.tolist() == [[True, False], [True, False]]
    assert "the point at 0 Hz is left out" in found.remarks
    assert "noise parameters are left out" in found.remarks
    assert "S12, S22 of zeros only: taken as not measured" in found.remarks
    assert found.flat().tolist() == [0.1, 0.3, 0.1, 0.3, 0.2, 0.4, 0.2, 0.4]
    assert len(found.coordinate) == 4
    # deviations of the measured elements alone; the input admittance with the other port at the reference
    predicted = found.scattering + np.array([[0.1, 5.0], [0.0, 5.0]])
    lines = deviations(found, predicted, ["left", "right"])
    assert f"deviation of S {0.1 / np.sqrt(2):.3g} rms" in lines[0][1]
    left = [text for label, text in lines if label == "left"]
    s, other = 0.1 + 0.2j, 0.2 + 0.2j
    conductances = [((1 - each) / (1 + each) / 50.0).real * 1e3 for each in (s, other)]
    assert f"G {conductances[0]:.5g} mS measured, {conductances[1]:.5g} mS predicted" in left[1]
    assert not [text for label, text in lines if label == "right"]
    with pytest.raises(SceneError, match="S22 was not measured"):
        found.one_port(2)


@pytest.mark.parametrize("kind", ["y", "z"])
def test_zeros_of_other_parameters_are_neither_a_short_nor_an_open(kind, tmp_path):
    file = tmp_path / "lab.s2p"
    file.write_text(f"# MHz {kind.upper()} RI R 50\n2.1 1 .2 0 0 0 0 0 0\n")
    with pytest.raises(SceneError, match=r"holds zeros only in .12, .21, .22: not measured"):
        read_network(file, "--measured")


def test_a_gain_is_remarked_and_a_negative_conductance_has_no_circuit():
    at = np.linspace(2e6, 2.4e6, 21)
    s = np.full((21, 1, 1), 1.0001 + 0.02j)

    data = NetworkData(name="a.s1p", frequency=at, scattering=s, reference=50.0)
    lines = deviations(data, s * 0.99, ["left"])
    assert not any("loss" in text for _, text in lines)
    with pytest.raises(ValueError, match="the conductance must be positive at some frequency"):
        fem.motional_model(at, np.full(21, -1e-6 + 1e-4j))


def test_a_gain_of_1_3_is_remarked(tmp_path):
    file = tmp_path / "lab.s1p"
    file.write_text("# MHz S MA R 50\n2.1 0.5 0\n2.2 1.3 10\n")
    (remark,) = read_network(file, "--measured").remarks
    assert "at 1 of 2 frequencies: the largest singular value of S is 1.3, at 2.2 MHz" in remark


HEAD = "[Version] 2.0\n# MHz S RI R 50\n[Number of Ports] 2\n"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.s2p", "# MHz S RI R 50\n2.1 .1 .2 .3 .4 .3 .4 .1 .2\n2.2 .1 .2 .3\n", "4 of 9 numbers after 1 frequencies"),
        ("a.s3p", "# MHz S RI R 50\n2.1 1 2 3 4 5 6\n1 2 3 4 5 6\n1 2 3 4\n", "17 of 19 numbers after 0 frequencies"),
        ("a.s1p", "# MHz S RI R 50\n2.1 .1 .2 .3 .4 .3 .4 .1 .2\n", "line 2: must hold a frequency and 2 numbers"),
        ("a.s1p", "# MHz S RI Q 50\n2.1 .1 .2\n", "line 1: the option line must hold a unit"),
        ("a.s1p", "# MHz S RI R\n2.1 .1 .2\n", "line 1: must state a reference"),
        ("a.s1p", "# MHz S RI R -50\n2.1 .1 .2\n", "line 1: must state a reference"),
        ("a.s1p", "! x\n2.1 .1 .2\n", "must have an option line, such as"),
        ("a.s1p", "# MHz S RI R 50 75\n2.1 .1 .2\n", "must state one reference, or one of each of 1 ports"),
        ("a.s1p", "# MHz H RI R 50\n2.1 .1 .2\n", "must have two ports for parameters H, got 1"),
        ("a.s1p", "# MHz S RI R 50\n2.1 .1 .x\n", "line 2: must hold numbers, got '.x'"),
        ("a.s1p", "# MHz S RI R 50\n2.1 .1 inf\n", "line 2: must hold finite numbers only"),
        ("a.s1p", "# MHz S RI R 50\n2.2 .1 .2\n2.1 .1 .2\n", "must have rising frequencies"),
        ("a.s1p", "# MHz S RI R 50\n0 .1 .2\n", "must have frequencies above 0 Hz"),
        ("a.s2p", HEAD + "[Network Data]\n2.1 .1 .2 .3 .4 .3 .4 .1 .2\n", "must state [Two-Port Data Order]"),
        (
            "a.s2p",
            HEAD + "[Two-Port Data Order] 12_21\n[Number of Frequencies] 2\n[Network Data]\n2.1 1 2 3 4 3 4 1 2\n",
            "ends with 0 of 9 numbers after 1 of 2 frequencies",
        ),
        ("a.s2p", HEAD + "[Mixed-Mode Order] D1,2 C1,2\n", "line 4: holds mixed-mode parameters"),
        ("a.s3p", HEAD, "line 3: must state 3 ports, got '2'"),
        ("a.s2p", HEAD + "[Reference] 50\n[End]\n", "must state the references of 2 ports, got 1"),
        ("a.s2p", HEAD + "[Reference] 50\n0\n[End]\n", "line 5: must state references with positive real parts"),
    ],
)  # fmt: skip
def test_a_damaged_file_is_one_true_sentence(name, content, said, tmp_path):
    file = tmp_path / name
    file.write_text(content)
    with pytest.raises(SceneError) as caught:
        read_network(file, "--measured")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
