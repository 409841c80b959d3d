"""Export of a mechanism as a functional mock-up unit (FMU): one file that other simulation programs import."""

import hashlib
import io
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from ..arguments import Flag, Positive, checked
from ..display import kind_of
from ..errors import warn
from ..files import check_writable, write_whole
from ..linear.linearize import Linearization
from ..model.model import Model
from ..statics.coarse import warn_of_stressed_start
from ..trajectory.linear_along import TimeVarying
from . import plant as plants
from .description import Placed, build_description, check_unique_names, description, ordered_variables, scalars
from .plant import Plant, Variable
from .writer import c_array, c_numbers

SYSTEMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}
PROCESSORS = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
LONGEST = 600


def place_of_binary(identifier: str, fmi: int) -> str | None:
    """Path of the binary for this platform in a unit; None if FMI has no name for the platform."""
    system, processor = SYSTEMS.get(sys.platform), PROCESSORS.get(platform.machine().lower())
    if system is None or processor is None:
        return None
    folder = f"{processor}-{system[0]}"
    if fmi == 2 and processor == "x86_64":
        folder = {"linux": "linux64", "darwin": "darwin64", "windows": "win64"}[system[0]]
    return f"binaries/{folder}/{identifier}{system[1]}"


def compiler_command() -> list[str] | None:
    """Command of a C compiler: $CC, or else cc, gcc or clang; None without any."""
    words = shlex.split(os.environ.get("CC", ""))
    for candidate in [words] if words else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(candidate[0]):
            return candidate
    return None


def shared_library(files: dict[str, bytes], main: str) -> tuple[bytes | None, str]:
    """A shared library of C sources, reproducible to the byte; or None, and why there is none."""
    command = compiler_command()
    if command is None:
        compiler = os.environ.get("CC")
        return (
            None,
            f"there is no C compiler '{compiler}'" if compiler else "there is no C compiler (cc, gcc, clang, or $CC)",
        )
    # The library contains no paths, times or build numbers, and no fused multiply-adds.
    options = ["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared"]
    if sys.platform != "win32":
        options.append("-fPIC")
    if sys.platform.startswith("linux"):
        options += ["-s", "-Wl,--build-id=none"]
    with tempfile.TemporaryDirectory(prefix="flexmb") as folder:
        for name, content in files.items():
            (Path(folder) / name).write_bytes(content)
        call = [*command, *options, "-o", "library", main, "-lm"]
        try:
            run = subprocess.run(call, cwd=folder, capture_output=True, timeout=LONGEST, check=False)
        except (OSError, subprocess.TimeoutExpired) as fault:
            return None, f"{command[0]} did not work: {fault}"
        if run.returncode:
            lines = run.stderr.decode(errors="replace").strip().splitlines() or ["no reason given"]
            return None, f"{command[0]} refused them: {next((line for line in lines if 'error' in line), lines[0])}"
        return (Path(folder) / "library").read_bytes(), ""


FOLDER = Path(__file__).parent
TABLE_FILE = "matrices.bin"


def sources(plant: Plant, found: list[Placed], token: str, fmi: int, settable: bool) -> dict[str, bytes]:
    """Contents of the files to compile, by name; the unit reads matrices that are not settable from a file."""
    kernel = ["nonlinear.c"] if plant.source else ["linear.c"]
    files = {name: (FOLDER / name).read_bytes() for name in ("core.c", "algebra.c", "fmi.c", *kernel, f"fmi{fmi}.c")}
    if plant.source:
        files["plant.c"] = plant.source.encode()
    files["data.h"] = _data(plant, found, token, fmi, settable).encode()
    return files


def _data(plant: Plant, variables: list[Placed], token: str, fmi: int, settable: bool) -> str:
    n_t = 0 if plant.source else 1 if plant.times is None else len(plant.times)
    kinds = {
        kind: [entry for entry in variables if entry.kind == kind] for kind in ("input", "state", "parameter", "output")
    }
    # FMI 2.0 has no arrays: each entry has a reference.
    arrays = [entry for entry in kinds["parameter"] if np.ndim(entry.variable.start)] if fmi == 3 else []
    starts = [np.ravel(entry.variable.start) for kind in ("input", "state", "parameter") for entry in kinds[kind]]
    counts = {
        "N_T": n_t,
        "N_U": len(plant.inputs),
        "N_X": len(plant.states),
        "N_P": sum(np.size(entry.variable.start) for entry in kinds["parameter"]),
        "N_Y": len(plant.outputs),
        "N_NOMINAL": plant.n_nominal,
        "N_ABSOLUTE": len(plant.displacements),
        "HAS_D": int("D" in plant.matrices),
        "SETTABLE": int(settable),
        "N_MEMORY": len(plant.memory),
        "N_WORK": plant.work,
        "N_ARRAYS": max(len(arrays), 1),
    }
    lines = ["/* The numbers of one plant; core.c says what they are. Generated. */"]
    lines += [f"#define {name} {count}" for name, count in counts.items()]
    lines += [f'#define TOKEN "{token}"', f'#define TABLE_FILE "{TABLE_FILE}"']
    # Without arrays one entry with an unused reference.
    at, sizes = [entry.reference for entry in arrays], [np.size(entry.variable.start) for entry in arrays]
    lines += [c_array("unsigned int", "ARRAY_AT", [str(place) for place in at or [4294967295]])]
    lines += [c_array("size_t", "ARRAY_SIZE", [str(size) for size in sizes or [0]])]
    # Without displacements one unused entry: C has no empty arrays.
    lines += [c_array("size_t", "ABSOLUTE_OF", [str(i) for i in plant.displacements or [0]])]
    lines += [c_numbers("ABSOLUTE_FROM", [plant.outputs[i].origin for i in plant.displacements] or [0.0])]
    lines += [c_numbers("NOMINAL", [v.nominal for v in plant.states])]
    lines += [c_numbers("START", np.concatenate([*starts, np.ravel(plant.memory)]))]
    if n_t > 1:
        lines += [c_numbers("TIMES", plant.times)]
    return "\n".join(lines) + "\n"


# Most numbers of matrices that are parameters. FMI 2.0 lists each number.
MOST_SETTABLE = {2: 5_000, 3: 50_000}
TIME_OF_FILES = (1980, 1, 1, 0, 0, 0)


class Fmu(NamedTuple):
    """The file of :func:`flexmb.save_fmu`.

    Attributes:
        path: The file.
        fmi: Version of the standard, 2 or 3.
        inputs: Inputs in order, each with name, unit and start value.
        outputs: Outputs likewise.
        states: States likewise.
        parameters: Parameters that importers can set; an array is one parameter.
        binary: Place in the file of the library for this platform; None if the file has only sources.
    """

    path: Path
    fmi: int
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    states: tuple[Variable, ...]
    parameters: tuple[Variable, ...]
    binary: str | None

    def __repr__(self) -> str:
        def listed(variables: Sequence[Variable]):
            return ", ".join(f"{v.name} [{v.unit}]" if v.unit else v.name for v in variables) or "none"

        return (
            f"FMU '{self.path}' (FMI {self.fmi}.0, {self.binary or 'sources alone'})\n"
            f"inputs: {listed(self.inputs)}\noutputs: {listed(self.outputs)}\n"
            f"states: {len(self.states)}\nparameters: {listed(self.parameters)}"
        )


@checked
def save_fmu(
    system: Any,
    path: str | os.PathLike,
    *,
    fmi: Literal[3, 2] = 3,
    start: Mapping[str, float] | Sequence[float] | None = None,
    units: Mapping[str, str] | None = None,
    modes: int | Sequence[int] | None = None,
    bandwidth: float | None = None,
    substep: Positive | None = None,
    nonlinear: Flag = False,
    loads: Mapping[str, Callable] | None = None,
    motion: Mapping[str, Callable] | None = None,
) -> Fmu:
    """Save a mechanism as a functional mock-up unit, which Simulink, Dymola, OpenModelica and others import.

    The unit supports co-simulation and model exchange. It runs without Python and flexmb. It contains sources in C99.
    If this machine has a C compiler (``$CC``, cc, gcc or clang), it also contains the library for this platform.
    Exporting twice gives the same bytes.

    In co-simulation the inputs are constant during each step:

    - The solution of a linear plant is exact, by a matrix exponential. The unit stores this matrix for further steps of
      the same length.
    - A time-varying plant moves by a Magnus series of fourth order, in substeps that end at the knots. Before the first
      knot and after the last one, its matrices and nominal values stay constant.
    - A nonlinear plant moves by a Rosenbrock method of order five, with the importer's relative tolerance or 1e-6.
      The tolerance is relative to the size of a state, but at least to a millimetre or a milliradian. Each step
      evaluates the equations once per state for the Jacobian. The unit looks for forces that act only within a step,
      such as stops, at 17 places of the step.

    In model exchange the unit returns rates to the importer's solver. Light damping at kilohertz is hard for such
    solvers: keep fewer ``modes``, or use co-simulation.

    Args:
        system: Model or Linearization with named inputs and outputs; control.StateSpace; or a time-varying system
            along a motion, :class:`flexmb.trajectory.TimeVarying`. Inputs and outputs of a time-varying unit are
            nominal values plus deviations. The nominal values are further outputs, named "nominal u" and "nominal y".
        path: Path of the file; it ends in .fmu. The unit has the name of the file.
        fmi: Version of the standard, 3 or 2.
        start: Start values of states, by name, or all in order; zero by default. Importers can set them: "state q".
        units: SI units by the names of inputs, outputs and states, such as "m/s" or "N.m". A Model or Linearization
            knows the units of forces and motions.
        modes: Modes of a Model or Linearization, see :func:`flexmb.to_statespace`.
        bandwidth: Bandwidth of a Model or Linearization [Hz], see :func:`flexmb.to_statespace`.
        substep: Longest step of the integration of a time-varying system, () [s]; by default a quarter of the shortest
            time between two knots. It is a parameter of the unit.
        nonlinear: Export the nonlinear equations of a Model instead of its linear state space. flexmb translates the
            right-hand side to C. The unit starts at the builder's start values, unless ``start`` has others.
        loads: Loads of a nonlinear unit as functions of time, see :class:`flexmb.motion.Drives`.
        motion: Prescribed motion of a nonlinear unit, see :class:`flexmb.motion.Drives`.

    Returns:
        Fmu with names and units. A position y [m] counts from the undeformed mechanism, or in a linear unit from the
        state of the linearisation; the description of y states this. Each position has an additional output "absolute
        y". A, B, C and a D that is not zero are parameters. A time-varying unit has these matrices at all knots, and u0
        and y0. They are arrays in FMI 3.0 (up to 50000 numbers) and scalars "A[1,2]" in FMI 2.0 (up to 5000). Larger
        matrices are files in the folder of resources and cannot be set.

    Raises:
        ValueError: The path has another ending, the version does not exist, an argument does not belong to this system,
            or the state space is sampled. FMI forbids a name, or two variables of the unit have the same name.
        ModelError: As :func:`flexmb.to_statespace`; for a nonlinear unit, an element or a function of time calls back
            to Python or has no translation, or a simulation cannot compute an output.
        TypeError: The system has another type.
        OSError: The file cannot be written.

    Warns:
        FlexmbWarning: There is no compiler, or it fails: the unit has only sources. A strain or an imperfection
            stresses a nonlinear mechanism at its start.

    Source:
        Functional Mock-up Interface 3.0 and 2.0; THEORY.md 14, eq. (14.50) to (14.54).
    """
    path = Path(path)
    if path.suffix != ".fmu" or not path.stem:
        raise ValueError(f"A functional mock-up unit is a file whose name ends in .fmu, not '{path}'.")
    if nonlinear:
        if not isinstance(system, Model):
            raise ValueError(
                f"`nonlinear` is for a Model, not {kind_of(system)}. The damping of fm.damped belongs to linear"
                " equations: damp the elements of the model instead, by fm.sections.damping_from_ratio."
            )
        given = {"modes": modes, "bandwidth": bandwidth, "substep": substep}
        if extra := [f"`{name}`" for name, value in given.items() if value is not None]:
            raise ValueError(f"`nonlinear` is for a Model as it is. Leave out {' and '.join(extra)}.")
        if start is None and system.parameters.start is None:
            warn_of_stressed_start(
                system, "Give values of states by `start`, or give start values in the builder, not both."
            )
        plant = plants.nonlinear(system, loads, motion)
    elif loads is not None or motion is not None:
        raise ValueError("`loads` and `motion` are for a nonlinear plant: give nonlinear=True.")
    else:
        plant = _plant_of(system, modes, bandwidth, substep)
    plant = plants.plant_with_units(plant, units)
    plant = plants.with_unique_names(plants.started(plant, start))
    check_writable(path)
    content, binary, parameters = _unit(plant, path.stem, fmi)
    write_whole(path, content)
    return Fmu(path, fmi, plant.inputs, plant.outputs, plant.states, parameters, binary)


def _plant_of(system: Any, modes: Any, bandwidth: Any, substep: float | None) -> Plant:
    of_mechanism, varies = isinstance(system, Model | Linearization), isinstance(system, TimeVarying)
    if not of_mechanism and (modes is not None or bandwidth is not None):
        raise ValueError("`modes` and `bandwidth` are for a Model or a Linearization: reduce other systems beforehand.")
    if not varies and substep is not None:
        raise ValueError("`substep` is for a time-varying system: leave it out for other systems.")
    if isinstance(system, Model | Linearization):
        return plants.mechanism_plant(system, modes, bandwidth)
    if isinstance(system, TimeVarying):
        return plants.time_varying_plant(system, substep)
    if isinstance(system, Plant):
        return system
    import control

    if isinstance(system, control.StateSpace):
        return plants.state_space_plant(system)
    raise TypeError(
        f"save_fmu takes a Model, a Linearization, a control.StateSpace or a time-varying system, not"
        f" {type(system).__name__}."
    )


def _unit(plant: Plant, title: str, fmi: int) -> tuple[bytes, str | None, tuple[Variable, ...]]:
    """Content of the file, place of its library for this platform, and parameters that importers can set."""
    settable = bool(plant.matrices) and sum(m.size for m in plant.matrices.values()) <= MOST_SETTABLE[fmi]
    # C name of the unit's functions.
    identifier = re.sub(r"\W", "_", title, flags=re.ASCII)
    identifier = f"_{identifier}" if identifier[0].isdigit() else identifier
    placed_variables = ordered_variables(plant, settable)
    check_unique_names(plant, placed_variables)
    listed = list(scalars(placed_variables)) if fmi == 2 else placed_variables

    def contents(token: str) -> tuple[dict[str, bytes], bytes]:
        of_c = sources(plant, placed_variables, token, fmi, settable)
        return of_c, description(plant, listed, identifier, title, token, fmi)

    # The token follows from the content of the unit: the same content has the same token.
    of_c, xml = contents("")
    resources = {}
    if plant.matrices and not settable:
        # A one, then each matrix at all knots.
        table = np.concatenate([np.ones(1), *(np.ravel(m) for m in plant.matrices.values())])
        resources[f"resources/{TABLE_FILE}"] = table.astype("<f8").tobytes()
    digest = hashlib.sha256()
    for name, content in sorted({**of_c, "xml": xml, **resources}.items()):
        digest.update(f"{name} {len(content)} ".encode() + content)
    of_c, xml = contents("{" + str(uuid.uuid5(uuid.NAMESPACE_OID, digest.hexdigest())) + "}")
    files = {"modelDescription.xml": xml, **resources}
    files |= {f"sources/{name}": content for name, content in of_c.items()}
    if fmi == 3:
        files["sources/buildDescription.xml"] = build_description(identifier)
    binary = place_of_binary(identifier, fmi)
    library, why = shared_library(of_c, f"fmi{fmi}.c") if binary else (None, "FMI has no name for this platform")
    if binary is not None and library is not None:
        files[binary] = library
    else:
        binary = None
        warn(
            f"The FMU '{title}' contains only its sources, since {why}. Simulink compiles them; other importers need"
            " the compiled library: export the FMU on a machine with a C compiler."
        )
    parameters = tuple(entry.variable for entry in placed_variables if entry.kind == "parameter")
    return _packed(files), binary, parameters


def _packed(files: dict[str, bytes]) -> bytes:
    """A zip archive without dates: the same files give the same bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name, file in sorted(files.items(), key=lambda pair: (pair[0] != "modelDescription.xml", pair[0])):
            member = zipfile.ZipInfo(name, TIME_OF_FILES)
            member.create_system = 3
            member.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            member.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(member, file)
    return content.getvalue()
