"""The averaged motor as a functional mock-up unit (FMI 3.0 or 2.0, co-simulation): sources, description, library.

The FMU holds C sources that any importer can compile, and the library for this machine where a C compiler is found.
Inputs: ``drive``, ``load_force``, ``preload``; outputs: ``position``, ``velocity``, ``surface_amplitude``, ``power``,
``temperature_rise``.
Standard: fmi-standard.org, FMI 3.0 (2022) and 2.0 (2014).
"""

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

from studies.export.c_source import description, header, source, source_text, token
from studies.export.motor_model import AveragedMotor
from studies.refusal import RunError
from studies.results.content import provenance

MODEL = "sawmotor"  # the identifier: name of the library
STEP = 1e-5  # s, suggested to the importer
FMI_VERSIONS = ("3", "2")
PLATFORMS = {  # of FMI 3.0 and 2.0, and the library's ending
    ("Linux", "x86_64"): ("x86_64-linux", "linux64", ".so"),
    ("Linux", "aarch64"): ("aarch64-linux", "linux64", ".so"),
    ("Darwin", "arm64"): ("aarch64-darwin", "darwin64", ".dylib"),
    ("Darwin", "x86_64"): ("x86_64-darwin", "darwin64", ".dylib"),
    ("Windows", "AMD64"): ("x86_64-windows", "win64", ".dll"),
}
# name, causality, variability, unit, start (None: calculated), meaning; value references count from 1, as in the C file
VARIABLES = (
    ("drive", "input", "continuous", None, 0.0, "peak level of the drive; negative: the drive the other way"),
    ("load_force", "input", "continuous", "N", "load", "external force on the slider along +x"),
    ("preload", "input", "continuous", "N", "preload", "normal force that holds the slider down, positive"),
    ("position", "output", "continuous", "m", None, "of the slider along x"),
    ("velocity", "output", "continuous", "m/s", None, "of the slider along +x"),
    ("surface_amplitude", "output", "continuous", "m", None, "largest normal amplitude under the contacts, peak"),
    ("power", "output", "continuous", "W", None, "into the driven transducer in the steady state"),
    ("tangential_force", "local", "continuous", "N", None, "mean force of the surface on the slider along +x"),
    ("deformation", "local", "continuous", "m", None, "tangential, of the contacts"),
    ("approach", "local", "continuous", "m", None, "mean normal approach of the contacts"),
    ("sticks", "local", "discrete", "", None, "the slider sticks to the surface"),
    ("position_start", "parameter", "fixed", "m", 0.0, "position at the beginning"),
    ("temperature_rise", "output", "continuous", "K", None, "mean, of the stator above its surroundings"),
)  # fmt: skip
UNITS = {"V": 'kg="1" m="2" s="-3" A="-1"', "m": 'm="1"', "m/s": 'm="1" s="-1"', "N": 'kg="1" m="1" s="-2"',
         "W": 'kg="1" m="2" s="-3"', "K": 'K="1"', "rad": 'rad="1"', "rad/s": 'rad="1" s="-1"',
         "N.m": 'kg="1" m="2" s="-2"', "rpm": 'rad="1" s="-1" factor="0.10471975511965977"'}  # fmt: skip


class Variable(NamedTuple):
    """A variable of an FMU."""

    reference: int
    name: str
    causality: str
    variability: str
    unit: str  # empty: none, of a Boolean
    start: float | None  # None: calculated
    meaning: str


@dataclass(frozen=True, kw_only=True)
class FmuModel:
    """What an FMU is made of."""

    title: str
    lines: tuple[str, ...]  # description: title, drives, errors, neglected effects
    token: str
    sources: dict[str, str] = field(repr=False)  # motor.c, motor.h, fmu_variables.c
    variables: tuple[Variable, ...]


def fmu(motor: AveragedMotor, fmi: str = "3") -> tuple[bytes, str]:
    """Return the FMU of a motor along x as bytes, and why it holds no compiled library (empty if it does).

    Parameters
    ----------
    motor : AveragedMotor
    fmi : str
        "3" or "2".

    Raises
    ------
    RunError
        If the compiler refuses the sources.
    """
    starts: dict = {"load": motor.load, "preload": motor.preload}
    variables = [
        Variable(
            k, name, causality, variability, motor.unit if unit is None else unit, starts.get(start, start), meaning
        )
        for k, (name, causality, variability, unit, start, meaning) in enumerate(VARIABLES, 1)
    ]
    sources = {
        "motor.c": source(motor), "motor.h": header(motor), "fmu_variables.c": source_text("fmu_variables.c")
    }  # fmt: skip
    model = FmuModel(
        title=motor.title, lines=tuple(description(motor)), token=token(motor), sources=sources,
        variables=tuple(variables),
    )  # fmt: skip
    return fmu_of(model, fmi)


def fmu_of(model: FmuModel, fmi: str = "3") -> tuple[bytes, str]:
    """Return an FMU as bytes, and why it holds no compiled library (empty if it does); RunError as `fmu`."""
    sources = model.sources | {name: source_text(name) for name in (f"fmi{fmi}.c", "fmu_motor.c")}
    compiled = ("motor.c", f"fmi{fmi}.c")
    library, remark = _library(sources, compiled)
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", _description(model, fmi, compiled))
        archive.writestr("documentation/README.txt", "\n".join(model.lines) + "\n")
        for name, text in sources.items():
            archive.writestr(f"sources/{name}", text)
        if fmi == "3":
            archive.writestr("sources/buildDescription.xml", _build_description(compiled))
        if library is not None:
            three, two, ending = PLATFORMS[platform.system(), platform.machine()]
            archive.writestr(f"binaries/{three if fmi == '3' else two}/{MODEL}{ending}", library)
    return content.getvalue(), remark


def compiler() -> list[str] | None:
    """Return the command of the system's C compiler (CC, cc, gcc or clang); None without one."""
    command = os.environ.get("CC", "").split()
    if command:
        return command if shutil.which(command[0]) else None
    name = next((name for name in ("cc", "gcc", "clang") if shutil.which(name)), None)
    return None if name is None else [name]


def _library(sources: dict[str, str], compiled) -> tuple[bytes | None, str]:
    """Return the shared library of the sources, or None and why there is none."""
    command, names = compiler(), PLATFORMS.get((platform.system(), platform.machine()))
    if command is None or names is None:
        reason = "no C compiler was found (CC, cc, gcc, clang)" if names else f"{sys.platform} is unknown to it"
        return None, f"the FMU holds sources but no library, because {reason}: the importer has to compile it"
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        target = f"{MODEL}{names[2]}"
        flags = "-O2 -std=c99 -shared -fPIC -fvisibility=hidden -ffp-contract=off -fno-math-errno".split()
        call = [*command, *flags, "-o", target, *compiled, "-lm"]
        done = subprocess.run(call, cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            first = (done.stderr.strip().splitlines() or ["no message"])[0]
            raise RunError(f"the C compiler {command[0]} refuses the sources of the FMU: {first}")
        return (Path(folder) / target).read_bytes(), ""


def _description(model: FmuModel, fmi: str, compiled) -> str:
    text = quoteattr("; ".join(model.lines))
    head = (
        f'fmiVersion="{fmi}.0" modelName={quoteattr(model.title)} description={text} '
        f'generationTool="sawmotor {provenance()["version"]}"'
    )
    common = f'modelIdentifier="{MODEL}" canHandleVariableCommunicationStepSize="true"'
    step = f'<DefaultExperiment startTime="0" stopTime="0.3" stepSize="{STEP:g}"/>'
    outputs = [each.reference for each in model.variables if each.causality == "output"]
    variables = "".join(_variable(each, fmi) for each in model.variables)
    used = {each.unit for each in model.variables}
    units = "".join(f'<Unit name="{name}"><BaseUnit {base}/></Unit>' for name, base in UNITS.items() if name in used)
    if fmi == "3":
        fields = (
            f'<CoSimulation {common} canGetAndSetFMUState="true" canSerializeFMUState="true"/>'
            f"<UnitDefinitions>{units}</UnitDefinitions>{step}<ModelVariables>"
            '<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>'
            + f"{variables}</ModelVariables><ModelStructure>"
            + "".join(f'<Output valueReference="{k}"/>' for k in outputs)
            + "".join(f'<InitialUnknown valueReference="{k}"/>' for k in outputs)
            + "</ModelStructure>"
        )
        return _xml("fmiModelDescription", f"{head} instantiationToken={quoteattr(model.token)}", fields)
    files = "".join(f'<File name="{name}"/>' for name in compiled)
    places = [k for k, each in enumerate(model.variables, 1) if each.causality == "output"]
    unknowns = "".join(f'<Unknown index="{k}"/>' for k in places)
    fields = (
        f'<CoSimulation {common} canGetAndSetFMUstate="true"><SourceFiles>{files}</SourceFiles></CoSimulation>'
        f"<UnitDefinitions>{units}</UnitDefinitions>{step}<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure><Outputs>{unknowns}</Outputs>"
        f"<InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>"
    )
    return _xml("fmiModelDescription", f"{head} guid={quoteattr(model.token)}", fields)


def _variable(variable: Variable, fmi: str) -> str:
    reference, name, causality, variability, unit, start, meaning = variable
    head = f'name="{name}" valueReference="{reference}" description={quoteattr(meaning)} causality="{causality}"'
    numbers = (f' unit="{unit}"' if unit else "") + ("" if start is None else f' start="{start!r}"')
    kind = "Boolean" if name == "sticks" else {"2": "Real", "3": "Float64"}[fmi]
    if fmi == "3":
        return f'<{kind} {head} variability="{variability}"{numbers}/>'
    initial = ' initial="calculated"' if start is None else ""
    initial = ' initial="exact"' if causality == "parameter" else initial
    return f'<ScalarVariable {head} variability="{variability}"{initial}><{kind}{numbers}/></ScalarVariable>'


def _build_description(compiled) -> str:
    files = "".join(f'<SourceFile name="{name}"/>' for name in compiled)
    fields = (
        f'<BuildConfiguration modelIdentifier="{MODEL}"><SourceFileSet language="C99">{files}</SourceFileSet>'
        "</BuildConfiguration>"
    )
    return _xml("fmiBuildDescription", 'fmiVersion="3.0"', fields)


def _xml(name: str, attributes: str, fields: str) -> str:
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<{name} {attributes}>\n{fields}\n</{name}>\n'
