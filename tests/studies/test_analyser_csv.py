"""Tables of impedance and network analysers in many forms.  Oracle: a circuit in closed form."""

import numpy as np
import pytest

from studies.lab.analyser_heads import head_of
from studies.lab.measurement_csv import read_measured
from studies.lab.network_file import read_network
from studies.refusal import SceneError

FREQUENCY = np.array([2.1e6, 2.15e6, 2.2e6])
OMEGA = 2.0 * np.pi * FREQUENCY
ADMITTANCE = 1j * OMEGA * 1e-9 + 1.0 / (80.0 + 1j * OMEGA * 1e-5)
IMPEDANCE = 1.0 / ADMITTANCE
REFLECTION = (IMPEDANCE - 50.0) / (IMPEDANCE + 50.0)
DEGREES = 180.0 / np.pi


def table(*columns, separator=",", decimal=".", end="\n") -> str:
    """Columns of head and values."""
    heads = separator.join(head for head, _ in columns)
    rows = [separator.join(repr(float(v)).replace(".", decimal) for v in row) for row in zip(*(c for _, c in columns))]  # noqa: B905
    return end.join([heads, *rows]) + end


def z_and_phase(frequency="Frequency (Hz)", size="|Z| (Ohm)", phase="Phase (deg)", factors=(1.0, 1.0, DEGREES)):
    return (
        (frequency, FREQUENCY / factors[0]), (size, abs(IMPEDANCE) / factors[1]),
        (phase, np.angle(IMPEDANCE) * factors[2]),
    )  # fmt: skip


PREAMBLE = '!CSV A.01.01\n!Agilent Technologies, E4990A\n"Title: PZT chip",\nDate: 2024-05-01\n\nBEGIN CH1_DATA\n'


@pytest.mark.parametrize(
    "text",
    [
        table(*z_and_phase()),
        table(*z_and_phase("freq_kHz", "Z_kohm", "theta_rad", (1e3, 1e3, 1.0))),
        table(*z_and_phase("f/MHz", "|Z| [Ω]", "θ (°)", (1e6, 1.0, DEGREES)), separator=";"),
        table(*z_and_phase("Frequency [MHz]", "Impedance (kOhm)", "Phase [deg]", (1e6, 1e3, DEGREES)), separator="\t"),
        table(*z_and_phase(), separator=";", decimal=","),
        table(*z_and_phase(), separator="\t", decimal=","),
        table(*z_and_phase(), separator=", "),
        table(*z_and_phase("Frequency(Hz)", "|Z|(Ohm)", "Phase(deg)"), separator="   "),
        table(*z_and_phase("Frequenz (kHz)", "abs(Z) (Ohm)", "Phasewinkel (°)", (1e3, 1.0, DEGREES)), separator=";",
              decimal=",", end="\r\n"),
        PREAMBLE + table(*z_and_phase()) + "END\n\nBEGIN CH2_DATA\nnothing\nEND\n",
        "# made up\n# Frequency (Hz), |Z| (Ohm), Phase (deg)\n" + table(*z_and_phase()).partition("\n")[2],
        "Frequency;|Z|;Phase\n(kHz);(Ohm);(deg)\n"
        + table(*z_and_phase(factors=(1e3, 1.0, DEGREES)), separator=";").partition("\n")[2],
        table(("Time (s)", FREQUENCY), *z_and_phase(), ("Bias (V)", FREQUENCY)),
        table(("Freq. (Hz)", FREQUENCY), ("Rs (Ohm)", IMPEDANCE.real), ("Xs (Ohm)", IMPEDANCE.imag)),
        table(("Frequency (Hz)", FREQUENCY), ("Re(Z) (mOhm)", 1e3 * IMPEDANCE.real), 
              ("Im(Z) (kΩ)", 1e-3 * IMPEDANCE.imag)),
        table(("freq / Hz", FREQUENCY), ("Z' / Ohm", IMPEDANCE.real), ("-Z'' / Ohm", -IMPEDANCE.imag)),
        table(("Frequency (Hz)", FREQUENCY), ("R", IMPEDANCE.real), ("X", IMPEDANCE.imag)),
        table(("Frequency (Hz)", FREQUENCY), ("G (mS)", 1e3 * ADMITTANCE.real), ("B (uS)", 1e6 * ADMITTANCE.imag)),
        table(("Frequency (Hz)", FREQUENCY), ("|Y| (S)", abs(ADMITTANCE)),
              ("Phase (deg)", DEGREES * np.angle(ADMITTANCE))),
        table(("Frequency (GHz)", FREQUENCY / 1e9), ("S11 (dB)", 20 * np.log10(abs(REFLECTION))),
              ("S11 (deg)", DEGREES * np.angle(REFLECTION))),
        table(("Freq(Hz)", FREQUENCY), ("S11 Log Mag(dB)", 20 * np.log10(abs(REFLECTION))),
              ("S11 Phase(deg)", DEGREES * np.angle(REFLECTION))),
        table(("freq[Hz]", FREQUENCY), ("re:Trc1_S11", REFLECTION.real), ("im:Trc1_S11", REFLECTION.imag),
              separator=";"),
        table(("freq[Hz]", FREQUENCY), ("db:Trc1_S11", 20 * np.log10(abs(REFLECTION))),
              ("ang:Trc1_S11", DEGREES * np.angle(REFLECTION)), separator=";"),
        table(*z_and_phase("f (Hz)", "Trace 1: Impedance: Magnitude (\u2126)", "Trace 2: Impedance: Phase (\u00b0)"),
              separator=";"),
        table(*z_and_phase("Frequenz / kHz", "Betrag Z / k\u03a9", "Phase Z / Grad", (1e3, 1e3, DEGREES)),
              separator="\t", decimal=","),
        "\n".join(",".join(f'"{cell}"' for cell in line.split(";"))
                  for line in table(*z_and_phase(), separator=";", decimal=",").splitlines()),
        table(("Frequency(Hz)", FREQUENCY), ("Return Loss(dB)", FREQUENCY), ("Phase(deg)", FREQUENCY),
              ("Rs", IMPEDANCE.real), ("Xs", IMPEDANCE.imag), ("|Z|", abs(IMPEDANCE))),
        table(("Frequency (Hz)", FREQUENCY), ("Re(S11)", REFLECTION.real), ("Im(S11)", REFLECTION.imag)),
        table(*z_and_phase("Frequency (Hz)", "|Z| (Ohm)", "Phase (deg)"))[:-1],
    ],
)  # fmt: skip
def test_a_table_is_the_reflection_of_the_circuit(text, tmp_path):
    file = tmp_path / "lab.csv"
    for encoding in ("utf-8", "utf-8-sig", "utf-16", *(() if any(ord(sign) > 255 for sign in text) else ("latin-1",))):
        file.write_bytes(text.encode(encoding))
        measured = read_measured(file)
        assert measured.quantity == "network"
        data = measured.network
        np.testing.assert_allclose(data.frequency, FREQUENCY, rtol=1e-13)
        np.testing.assert_allclose(data.scattering[:, 0, 0], REFLECTION, rtol=1e-11)
        np.testing.assert_allclose(data.admittance[:, 0, 0], ADMITTANCE, rtol=1e-10)


@pytest.mark.parametrize(
    ("real", "imag", "unit", "size", "invert"),
    [
        *(("R", "X", unit, size, False) for unit, size in
          (("Ohm", 1.0), ("kOhm", 1e3), ("MOhm", 1e6), ("mOhm", 1e-3), ("k\u03a9", 1e3), ("M\u2126", 1e6))),
        *(("G", "B", unit, size, True) for unit, size in
          (("S", 1.0), ("mS", 1e-3), ("uS", 1e-6), ("\u00b5S", 1e-6), ("nS", 1e-9), ("Siemens", 1.0))),
    ],
)  # fmt: skip
def test_every_unit_of_impedance_and_admittance_is_its_prefix(real, imag, unit, size, invert, tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text(f"f (Hz),{real} ({unit}),{imag} ({unit})\n2e6,3,-4\n", encoding="utf-8")
    (found,) = read_network(file, "--measured").admittance[:, 0, 0]
    value = (3 - 4j) * size
    # the reflection is 1 less something small: its digits are lost in the admittance of a large impedance
    assert found == pytest.approx(value if invert else 1.0 / value, rel=1e-6)


def test_another_reference_of_s11_is_that_of_the_file(tmp_path):
    reflection = (IMPEDANCE - 75.0) / (IMPEDANCE + 75.0)
    text = table(("Frequency (Hz)", FREQUENCY), ("Re(S11)", reflection.real), ("Im(S11)", reflection.imag))
    file = tmp_path / "lab.csv"
    file.write_text("! Z0 = 75 Ohm\n" + text)
    data = read_network(file, "--measured")
    np.testing.assert_allclose(data.admittance[:, 0, 0], ADMITTANCE, rtol=1e-10)
    assert "S11 with a reference of 75 ohm" in data.remarks
    file.write_text(text)
    assert "S11 with a reference of 50 ohm, which it does not state" in read_network(file, "--measured").remarks


def test_falling_frequencies_are_reversed_and_rest_is_left_out(tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text("Frequency (kHz);R (Ohm);X (Ohm)\n2200;3;-70\n2100;2;-75\n0;1e9;0\n")
    data = read_network(file, "--measured")
    np.testing.assert_allclose(data.frequency, [2.1e6, 2.2e6], rtol=1e-14)
    np.testing.assert_allclose(1.0 / data.admittance[:, 0, 0], [2 - 75j, 3 - 70j], rtol=1e-12)
    assert "its frequencies fall: they are reversed" in data.remarks
    assert "the point at 0 Hz is left out" in data.remarks


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Frequency,R (Ohm),X (Ohm)\n2e6,1,2\n", "must state the unit of 'Frequency', such as Frequency (Hz)"),
        ("Frequency (Hz),|Z| (Ohm)\n2e6,1\n", "must have |Z| with its phase, R with X, G with B, or S11"),
        ("Frequency (Hz),|Z| (Ohm),Phase\n2e6,1,-1.5\n", "must state the unit of 'Phase', such as Phase (deg)"),
        ("Frequency (Hz),S11,Phase (deg)\n2e6,-10,-15\n", "must state the unit of 'S11', such as S11 (dB)"),
        ("x\nFrequency (Hz),R (Ohm),X (Ohm)\n2e6,1,2\n\n3e6,1,?\n", "line 5, X (Ohm) must be a finite number, got '?'"),
        ("Frequency (Hz),R (Ohm),X (Ohm)\n2e6,1,2\n3e6,1\n", "line 3, must have 3 values, got 2"),
        ("Frequency (Hz),R (Ohm),X (Ohm)\n2000000,0,1,5,2,5\n", "decimal commas need tabs or semicolons"),
        ("Frequency (Hz);R (Ohm);X (Ohm)\n2.000.000,5;1;2\n", "mixes decimal points and commas"),
        ("Frequency (Hz),R (Ohm),X (Ohm)\n2e6,1,2\n1e6,1,2\n3e6,1,2\n", "must have frequencies that rise or fall"),
        ("Frequency (Hz),R (Ohm),X (Ohm)\n0,1,2\n", "must have frequencies above 0 Hz"),
        ("Frequency (Hz),R (Ohm),X (Ohm)\n", "must hold at least one line of numbers"),
        ("Frequency (Hz),|Z| (Ohm),Phase (deg)\n2e6,-1,2\n", "must have magnitudes that are zero or positive"),
        ("Frequency (Hz),R (Ohm),Rs (Ohm),X (Ohm)\n2e6,1,1,2\n", "must hold one column of each quantity"),
    ],
)
def test_a_table_that_is_not_one_is_refused_by_its_line(text, said, tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text(text)
    with pytest.raises(SceneError) as caught:
        read_measured(file)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "cell", ["x_mm", "u_z_phase_deg", "u_z_magnitude_nm", "v_z_real_mm_per_s", "voltage_V", "y_m", "time_s", "Cp (pF)"]
)
def test_heads_of_other_files_are_none_of_an_analyser(cell):
    assert head_of(cell) is None
