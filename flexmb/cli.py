"""The command line: arguments only. Commands import JAX inside, so that help is quick."""

import contextlib
import functools
import inspect
import io
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperCommand, TyperGroup
from typer.exceptions import TyperException

from . import __version__
from .errors import AnalysisError, MechanismError, ModelError, SpacarError, StudyError, heard, printable, warn
from .setup import enable_cache, enable_x64

EXIT_FAILED, EXIT_WRONG_CALL = 1, 2
# Exit codes of shells for programs that a signal ended: Ctrl-C, and a closed pipe.
EXIT_INTERRUPTED, EXIT_NOBODY_READS = 130, 141
MOST_STEPS = 100_000
LONGEST_MESSAGE = 300
# Files that this call has written, to be listed after Ctrl-C.
WRITTEN: list[Any] = []
PICTURES = (".png", ".svg", ".pdf")
# Modes that export a co-simulation unit.
OF_UNITS = {"9": "linear", "3": "time-varying", "4": "time-varying", "1": "nonlinear"}


class Once(TyperCommand):
    """A command that refuses an option given twice instead of taking the last."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse, as the base class does."""
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for param in order:
            if order.count(param) > 1 and not getattr(param, "multiple", False) and param.param_type_name == "option":
                ctx.fail(f"{param.opts[0]} is given twice; give it once.")
        return super().parse_args(ctx, args)


class Program(TyperGroup):
    """The program: every fault of the call is one line on standard error, with exit status 2."""

    def main(self, *args: Any, **options: Any) -> NoReturn:
        """Run, and end the process with the exit status."""
        _prepare_streams()
        try:
            code = super().main(*args, **{**options, "prog_name": "flexmb", "standalone_mode": False})
        except typer.Exit as end:
            code = end.exit_code
        except TyperException as fault:
            context: Any = getattr(fault, "ctx", None)
            where = context.command_path if context else "flexmb"
            words = " ".join(fault.format_message().split()) or "Give a command"
            message = "".join(map(printable, words[:LONGEST_MESSAGE]))
            _complain(f"{where}: {message.rstrip('.')} ({where} --help).")
            code = EXIT_WRONG_CALL
        sys.exit(code or 0)

    def invoke(self, ctx: Any) -> Any:
        """Run a command; after Ctrl-C, say what is kept."""
        WRITTEN.clear()
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as stop:
            written = [*map(str, stop.args), *(f"'{printable(path)}' is written" for path in WRITTEN)]
            _complain(f"flexmb: interrupted from the keyboard; {'; '.join(written) or 'nothing is kept'}.")
            raise typer.Exit(EXIT_INTERRUPTED) from None


app = typer.Typer(
    cls=Program,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Flexible multibody mechanisms: motion, frequencies, buckling, state space of a SPACAR input file; designs.",
)

ModelFile = Annotated[Path, typer.Argument(metavar="MODEL.dat", help="SPACAR input file.")]
Json = Annotated[
    str | None, typer.Option("--json", help="Write the answer as JSON to this file; - for standard output.")
]
Save = Annotated[Path | None, typer.Option("--save", help="Save the answer to a .npz or .mat file.")]
Log = Annotated[Path | None, typer.Option("--log", help="Write the log of the run to this file.")]
Release = Annotated[str, typer.Option("--release", help="auto releases over-constraints.")]
Plot = Annotated[
    Path | None, typer.Option("--plot", help="Draw the answer as .png, .svg or .pdf, or as .html to rotate and play.")
]
PagePlot = Annotated[Path | None, typer.Option("--plot", help="Draw the page as .png, .svg or .pdf.")]
StudyFile = Annotated[Path, typer.Argument(metavar="STUDY.toml", help="Model, parameters and answers.")]
StudyPlot = Annotated[Path | None, typer.Option("--plot", help="Draw the answer as .png, .svg or .pdf.")]
Numbers = Annotated[list[str] | None, typer.Option("--set", metavar="NAME=NUMBER", help="Value of {NAME} in the file.")]
Asks = Annotated[
    list[str] | None,
    typer.Option(
        "--ask", metavar="QUESTION", help="Question for each state, such as 'stiffness 3.y'; an unknown one lists all."
    ),
]
MaxSteps = Annotated[
    int | None,
    typer.Option(
        "--max-steps", min=1, max=MOST_STEPS, help="Largest number of steps of a path (mode 10), 200 by default."
    ),
]
Debug = Annotated[bool, typer.Option("--debug", help="Show a traceback for an unexpected fault.")]


def _prepare_streams() -> None:
    """Escape characters that a stream cannot encode, and open closed streams, whose numbers files would take."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _complain(message: str) -> None:
    """Print faults on standard error, one per line."""
    with contextlib.suppress(OSError):
        print(message, file=sys.stderr, flush=True)


def _refuse(message: str) -> NoReturn:
    """End with exit status 2 after one line on standard error per fault."""
    _complain(message)
    raise typer.Exit(EXIT_WRONG_CALL)


def _print_text(text: str) -> None:
    """Print on standard output; exit if that fails."""
    if sys.stdout is None:
        _refuse("flexmb: cannot write to standard output: it is closed.")
    try:
        print(text, flush=True)
    except OSError as fault:
        # The rest of the buffer would fail again at exit.
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(fault, BrokenPipeError):
            raise typer.Exit(EXIT_NOBODY_READS) from None
        _refuse(f"flexmb: cannot write to standard output: {fault.strerror}.")


@contextlib.contextmanager
def _writing(path: Any) -> Iterator[None]:
    """Refuse a path that cannot be written to."""
    try:
        yield
    except OSError as fault:
        _refuse(f"flexmb: cannot write '{printable(path)}': {fault.strerror or fault}.")


def _store(path: Any, write: Callable[[Any], bytes | None]) -> None:
    """Write a file if its path is given, by a function that writes it or returns its content."""
    from .files import write_whole

    if path not in (None, "-"):
        with _writing(path):
            if (content := write(path)) is not None:
                write_whole(path, content)
        WRITTEN.append(path)


def _prepare_jax() -> None:
    """Switch on double precision and the cache of compiled code."""
    enable_x64()
    with contextlib.suppress(OSError):
        # Without a writable cache folder the program is only slower.
        enable_cache()


def _mode_number(mode: str | None, analysis: str | None) -> int:
    from .answers.answers import mode_of, modes

    requested = analysis if analysis is not None else mode
    if requested is None or (mode is not None and analysis is not None):
        _refuse("flexmb run: give one of --mode and --analysis, such as --mode 7 or --analysis frequencies.")
    text = str(requested)
    # For a negative mode SPACAR draws nothing; the analysis is the same.
    if re.fullmatch(r"-?\d{1,9}", text, re.ASCII):
        with contextlib.suppress(KeyError):
            return mode_of(int(text.removeprefix("-"))).number
    names = {entry.name: entry.number for entry in modes().values()}
    if text in names:
        return names[text]
    known = ", ".join(f"{entry.number} ({entry.name})" for entry in modes().values())
    _refuse(f"flexmb run: there is no mode '{printable(text)}'. Available: {known}.")


def _check_files(
    source: Path | None = None, about: str = "flexmb", plots: Iterable[str] = PICTURES, **files: Any
) -> None:
    """Refuse wrong endings, files that cannot be written, and the input file, before anything is computed."""
    from .files import check_writable

    endings = {"save": (".npz", ".mat"), "plot": (*plots,), "to": (".fmu",)}
    for name, path in files.items():
        *most, last = endings.get(name, ("",))
        if path is not None and name in endings and path.suffix not in (*most, last):
            allowed = f"{', '.join(most)} or {last}" if most else last
            _refuse(f"{about}: --{name} writes {allowed}, not '{printable(path)}'.")
    if (log := files.get("log")) is not None and str(log) == "-":
        _refuse("flexmb: --log writes a file, not '-': of the answers --json - alone goes to standard output.")
    used = {} if source is None else {os.path.realpath(source): "the input file"}
    for name, path in files.items():
        if path is None or (name == "json" and path == "-"):
            continue
        if not Path(path).absolute().parent.is_dir():
            _refuse(f"flexmb: the folder of '{printable(path)}' does not exist.")
        first = used.setdefault(os.path.realpath(path), f"--{name}")
        if first != f"--{name}" and (Path(path).is_file() or not Path(path).exists()):
            _refuse(f"flexmb: --{name} would write over {first}: '{printable(path)}'.")
        with _writing(path):
            check_writable(path)


def _check_release(release: str) -> None:
    if release not in ("none", "auto"):
        _refuse(f"flexmb: --release takes auto or none, not '{printable(release)}'.")


@contextlib.contextmanager
def _refusing(name: str = "", path: Any = None, how: str = "read") -> Iterator[None]:
    """Refuse faults of input files and studies; with ``name`` also faults of a model, with ``path`` of other files."""
    try:
        yield
    except SpacarError as fault:
        _refuse(str(fault))
    except StudyError as fault:
        _refuse(f"flexmb: {fault}")
    except ModelError as fault:
        if not name:
            raise
        _refuse("\n".join(f"{name}: {line}" for line in str(fault).splitlines()))
    except OSError as fault:
        if path is None:
            raise
        named = fault.filename if isinstance(fault.filename, str) else path
        _refuse(f"flexmb: cannot {how} '{printable(named)}': {fault.strerror or fault}.")


def _number(about: str, word: str) -> float:
    """Number of an option; ``about`` begins the message on a fault."""
    from .spacar.lines import Fault, parse

    try:
        return parse("", "value", (word.strip(),))["value"]
    except Fault as fault:
        _refuse(f"flexmb: {about}: {str(fault).partition(';')[0]}.")


def _numbers(option: str, such_as: str, assignments: list[str] | None) -> dict[str, float]:
    """Numbers by name from texts such as "t=0.5e-3"."""
    numbers: dict[str, float] = {}
    for text in assignments or ():
        name, _, word = (part.strip() for part in text.rpartition("="))
        if not name:
            _refuse(f"flexmb: {option} takes NAME=NUMBER, such as {such_as}, not '{printable(text)}'.")
        if name in numbers:
            _refuse(f"flexmb: {option} gives '{printable(name)}' twice; give it once.")
        numbers[name] = _number(f"{option} {printable(name)}", word)
    return numbers


def _read(model: Path, assignments: list[str] | None) -> tuple[Any, dict[str, float]]:
    """Content of the input file, and the values of its parameters."""
    from . import read_spacar

    numbers = _numbers("--set", "t=0.5e-3", assignments)
    if "pi" in numbers:
        _refuse("flexmb: --set pi: {pi} is 3.14159.. in every file; give the parameter another name.")
    with _refusing(path=model):
        read = read_spacar(model, numbers=numbers)
    for name in numbers:
        if name not in read.parameters:
            known = ", ".join(f"{{{n}}}" for n in read.parameters) or "none"
            _refuse(
                f"flexmb: --set {printable(name)}: {read.name} has no {{{printable(name)}}}; it has:"
                f" {printable(known)}."
            )
    return read, numbers


def _print_answer(
    data: dict[str, Any],
    name: str,
    text: str | None,
    json_path: str | None = None,
    plot: Path | None = None,
    result: Any = None,
    picture: str = "",
) -> None:
    """Write, draw and print an answer with its warnings; exit with status 1 if its status is not "ok"."""
    from .answers.answer_files import to_json

    _store(json_path, lambda _: to_json(data).encode())
    if plot is not None and result is not None:
        from .plot.answer import image_of

        _store(plot, lambda path: image_of(result, path.suffix[1:], picture))
    if json_path == "-" or text is not None:
        warnings = "".join(f"warning: {warning}\n" for warning in data["warnings"])
        _print_text(to_json(data) if json_path == "-" else f"{warnings}{text}")
    if data["status"] != "ok":
        _end_failed(data, name, EXIT_FAILED)


def _end_failed(data: dict[str, Any], name: str, status: int) -> NoReturn:
    """End with an exit status after one line on standard error about an answer."""
    _complain(f"{name}: {data['status']}: {(data['message'].splitlines() or [''])[0]}")
    raise typer.Exit(status)


def _run(
    model: Path,
    number: int,
    json_path: str | None = None,
    save: Path | None = None,
    log: Path | None = None,
    plot: Path | None = None,
    assignments: list[str] | None = None,
    ask: list[str] | None = None,
    **options: Any,
) -> None:
    """Answer a mode with the options of its answer."""
    from .answers.answer_files import save as save_answer
    from .answers.answer_files import to_json
    from .answers.answers import QuestionError, also_asked, answer
    from .answers.tables import log as log_text
    from .answers.tables import table

    _check_files(model, plots=(*PICTURES, ".html"), json=json_path, save=save, log=log, plot=plot)
    _prepare_jax()
    read, _ = _read(model, assignments)
    # A file name that is not valid UTF-8 is escaped, so that any JSON reader takes it.
    name = os.fsencode(model.name).decode(errors="backslashreplace")
    # A model fault that is raised: the file does not even describe a mechanism.
    with _refusing(read.name):
        result = answer(read.builder, name, number, list(read.warnings), settings=read.settings, **options)
    try:
        result.data.update(also_asked(result, ask or ()))
    except QuestionError as fault:
        _refuse(f"flexmb run: --ask: {fault}.")
    _store(json_path, lambda _: to_json(result.data).encode())
    _store(save, lambda path: save_answer(result.data, path))
    _store(log, lambda _: log_text(result, read.text).encode(errors="backslashreplace"))
    _store(plot, lambda path: _drawn(result, path.suffix))
    _print_text(to_json(result.data) if json_path == "-" else table(result.data))
    if result.exit_status:
        _end_failed(result.data, read.name, result.exit_status)


def _drawn(result: Any, ending: str) -> bytes:
    """Picture or page of an answer; without an answer, of the mechanism."""
    if ending == ".html":
        from .viewer.view import page

        return page(result)
    from .plot.answer import image

    return image(result, ending[1:])


def _version(requested: bool) -> None:
    if requested:
        _print_text(f"flexmb {__version__}")
        raise typer.Exit


@app.callback()
def program(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_version, help="Show the version.")
    ] = False,
) -> None:
    """Flexible multibody mechanisms: motion, frequencies, buckling, state space of a SPACAR input file; designs."""


def command(function: Callable[..., None]) -> Callable[..., None]:
    """Add a command that refuses repeated options, and shows tracebacks only with --debug."""

    @functools.wraps(function)
    def call(debug: bool = False, **options: Any) -> None:
        try:
            function(**options)
        except typer.Exit:
            raise
        except Exception as fault:
            if debug:
                raise
            first = printable((str(fault).splitlines() or [""])[0])
            _complain(f"flexmb: {type(fault).__name__}: {first} (--debug shows where)")
            raise typer.Exit(EXIT_FAILED) from None

    signature = inspect.signature(function)
    debug = inspect.Parameter("debug", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Debug)
    vars(call)["__signature__"] = signature.replace(parameters=[*signature.parameters.values(), debug])
    call.__annotations__ = {**function.__annotations__, "debug": Debug}
    return app.command(cls=Once)(call)


@command
def run(
    model: ModelFile,
    mode: Annotated[
        str | None, typer.Option("--mode", help="Number of the mode, such as 7; an unknown one lists all.")
    ] = None,
    analysis: Annotated[str | None, typer.Option("--analysis", help="Name of the mode, instead of its number.")] = None,
    numbers: Numbers = None,
    json_path: Json = None,
    save: Save = None,
    log: Log = None,
    release: Release = "none",
    max_steps: MaxSteps = None,
    ask: Asks = None,
    plot: Plot = None,
) -> None:
    """Analyse: 0 mobility, 1 simulate, 4 simulate-linearise, 7 frequencies, 8 buckling, 9 statespace, 10 path.

    Along a trajectory: 2 inverse, 3 trajectory-linearisation, 5 perturbation, 6 superposition.
    """
    number = _mode_number(mode, analysis)
    _check_release(release)
    _run(model, number, json_path, save, log, plot, numbers, ask=ask, release=release, max_steps=max_steps)


@command
def check(
    model: ModelFile,
    numbers: Numbers = None,
    json_path: Json = None,
    save: Save = None,
    log: Log = None,
    plot: Plot = None,
) -> None:
    """Show degrees of freedom, over- and under-constraints; the same as mode 0."""
    _run(model, 0, json_path, save, log, plot, numbers)


@command
def verdict(
    model: ModelFile,
    stroke: Annotated[
        str,
        typer.Option("--stroke", metavar="[NAME=]NUMBER", help="Stroke to both sides, with its coordinate: 3.x=5e-3."),
    ],
    limit: Annotated[
        list[str] | None,
        typer.Option("--limit", metavar="NAME=NUMBER", help="Limit of a curve, such as 'frequency 1=50'."),
    ] = None,
    numbers: Numbers = None,
    json_path: Json = None,
    plot: PagePlot = None,
) -> None:
    """Show forces and limits of a stroke on one page; with --set also the effect of these numbers."""
    from . import read_spacar
    from . import verdict as judge
    from .design.stroke import StrokeError

    name, equals, word = stroke.rpartition("=")
    length = _number("--stroke takes [NAME=]NUMBER, such as 3.x=5e-3", word)
    limits = _numbers("--limit", "force=2", limit)
    _check_files(model, "flexmb verdict", json=json_path, plot=plot)
    _prepare_jax()
    (read, dimensions), assessment = _read(model, numbers), None
    data: dict[str, Any] = {"model": printable(model.name), "flexmb": __version__, "status": "ok", "message": ""}

    def build(**numbers: Any) -> Any:
        return read_spacar(model, numbers=numbers).builder.build()

    with heard() as heard_warnings:
        try:
            built: Any = build if dimensions else read.builder.build()
            target: Any = {name.strip(): length} if equals else length
            assessment = judge(built, target, dimensions=dimensions or None, limits=limits)
            data |= assessment.to_dict()
        except StrokeError as fault:
            _refuse(f"flexmb verdict: --stroke: {fault}")
        except (ModelError, AnalysisError) as fault:
            data |= {"status": getattr(fault, "code", "not_valid"), "message": str(fault)}
        except ValueError as fault:
            _refuse(f"flexmb verdict: {' '.join(str(fault).split())}")
    data["warnings"] = [*read.warnings, *dict.fromkeys(heard_warnings)]
    _print_answer(
        data, read.name, None if assessment is None else str(assessment), json_path, plot, assessment, "verdict"
    )


@command
def fmu(
    model: ModelFile,
    to: Annotated[Path, typer.Option("--to", help="Write the unit to this .fmu file.")],
    mode: Annotated[
        str, typer.Option("--mode", help="9: linear; 3 or 4: time-varying along a motion; 1: nonlinear.")
    ] = "9",
    fmi: Annotated[str, typer.Option("--fmi", help="Version of the standard, 3 or 2.")] = "3",
    numbers: Numbers = None,
    release: Release = "none",
) -> None:
    """Save the mechanism as a functional mock-up unit, for Simulink, Dymola, OpenModelica and others."""
    _check_files(about="flexmb fmu", to=to)
    if fmi not in ("2", "3"):
        _refuse(f"flexmb fmu: --fmi takes 3 or 2, not '{printable(fmi)}'.")
    _check_release(release)
    if mode not in OF_UNITS:
        known = ", ".join(f"{number} ({meaning})" for number, meaning in OF_UNITS.items())
        _refuse(f"flexmb fmu: there is no unit of mode '{printable(mode)}'. Available: {known}.")
    _prepare_jax()
    from .answers.answers import reader_warnings

    read, _ = _read(model, numbers)
    heard_warnings, unit, status, message = [], None, "ok", ""
    with _refusing(read.name), _writing(to):
        try:
            with heard() as heard_warnings:
                unit = _unit(read, int(mode), release)(to, int(fmi))
            WRITTEN.append(to)
        except (AnalysisError, MechanismError) as fault:
            status, message = fault.code, str(fault)
    warnings = [*reader_warnings(int(mode), read.warnings), *dict.fromkeys(heard_warnings)]
    data = {"status": status, "message": message, "warnings": warnings}
    _print_answer(data, read.name, None if unit is None else repr(unit))


def _unit(read: Any, number: int, release: str) -> Callable[[Path, Any], Any]:
    """Function that saves the unit of a mode, after its analysis."""
    import dataclasses

    import jax.numpy as jnp

    from . import save_fmu, trajectory
    from .answers.answers import answer
    from .answers.mode_1_simulate import motions_of
    from .fmu.plant import units_of
    from .model.topology import Role
    from .spacar.trajectories import laws_of

    def with_signals(model: Any) -> Any:
        if not model.labels.inputs or not model.labels.outputs:
            raise ModelError(
                "INPUTF: an FMU needs an input and an output: INPUTF or INPUTS, and OUTX, OUTE or the like; of a"
                " trajectory NOMF or NOMS, and REFX, REFE or the like"
            )
        return model

    if number == 1:
        model = with_signals(read.builder.build(release=release))
        motion = motions_of(model, read.settings) | laws_of(read.builder, model.labels, read.settings, Role.PRESCRIBED)
        return lambda to, fmi: save_fmu(model, to, fmi=fmi, nonlinear=True, motion=motion)
    result: Any = answer(read.builder, read.name, number, [], release, settings=read.settings)
    for text in result.data["warnings"]:
        warn(text)
    if result.exit_status:
        raise AnalysisError(result.data["status"], result.data["message"])
    with_signals(result.model)
    if number == 9:
        if not result.data["states"]:
            raise ModelError("INPUTX, INPUTE: every motion is prescribed; an FMU of mode 9 needs a degree of freedom")
        return lambda to, fmi: save_fmu(result.lin, to, fmi=fmi)
    system = trajectory.time_varying(result.found)
    # The nominal inputs are among the loads of the motion; the answer has them.
    system = dataclasses.replace(system, u0=jnp.asarray(result.data["u0"], float))
    units = units_of(result.model, system.state_labels)
    return lambda to, fmi: save_fmu(system, to, fmi=fmi, units=units)


@command
def demo(
    name: Annotated[str | None, typer.Argument(help="A shipped mechanism.")] = None,
    listing: Annotated[bool, typer.Option("--list", help="List the shipped mechanisms.")] = False,
    to: Annotated[Path | None, typer.Option("--to", help="Copy the mechanism to this folder instead.")] = None,
) -> None:
    """Analyse a mechanism that ships with the package, or copy it to a folder."""
    from .mechanisms import mechanism_path, mechanisms

    if listing:
        if name is not None or to is not None:
            _refuse("flexmb demo: --list takes neither a mechanism nor --to.")
        _print_text("\n".join(f"{key:<14}{text}" for key, text in mechanisms().items()))
        return
    name = name or "pf3d"
    if name not in mechanisms():
        _refuse(f"flexmb demo: no mechanism '{printable(name)}'. Shipped: {', '.join(mechanisms())}.")
    path = mechanism_path(name)
    if to is not None:
        _copy(path, to)
        return
    import tempfile

    from .files import check_writable

    picture = Path.cwd() / f"{name}.png"
    try:
        check_writable(picture)
    except OSError:
        picture = Path(tempfile.mkdtemp()) / picture.name
    for number in (0, 7, 9):
        _run(path, number, plot=picture if number == 7 else None)
        _print_text("")
    _print_text(f"picture: {picture}")


def _copy(path: Path, to: Path) -> None:
    """Copy a shipped mechanism to a folder, unless another file of that name is there."""
    from .files import write_whole

    if not to.is_dir():
        _refuse(f"flexmb demo: the folder '{printable(to)}' does not exist.")
    target, content = to / path.name, path.read_bytes()
    with _writing(target):
        if target.exists() and (not target.is_file() or target.read_bytes() != content):
            _refuse(f"flexmb demo: '{printable(target)}' is there already and differs; move it away first.")
        write_whole(target, content)
    _print_text(str(target))


def _study(
    command: str,
    path: Path,
    json_path: str | None,
    save: Path | None,
    plot: Path | None,
    work: Any,
    read_study: Callable[[Path], Any] | None = None,
) -> None:
    """Run a study and write its answer; ``work`` returns data, table, saving function and result."""
    if read_study is None:
        from .design.study_file import read_study

    _check_files(path, f"flexmb {command}", json=json_path, save=save, plot=plot)
    _prepare_jax()
    name, heard_warnings, read, text, result = printable(path.name), [], None, None, None
    with _refusing(path=path, how="read or write"):
        try:
            with heard() as heard_warnings:
                read = read_study(path)
                data, text, saved, result = work(read)
        except (AnalysisError, ModelError) as fault:
            # The JSON reports the failure too.
            why = (str(fault).splitlines() or [""])[0]
            data = {"study": name, "flexmb": __version__, "status": getattr(fault, "code", "not_valid"), "message": why}
        else:
            _store(save, saved)
    data["warnings"] = [*(read.warnings if read else ()), *dict.fromkeys(heard_warnings)]
    _print_answer(data, name, text, json_path, plot, result)


@command
def sweep(
    study: StudyFile,
    json_path: Json = None,
    save: Save = None,
    checkpoint: Annotated[
        Path | None, typer.Option("--checkpoint", help="Store finished designs in this file, and continue from it.")
    ] = None,
    plot: StudyPlot = None,
) -> None:
    """Compute many designs of a model with parameters: grid, Latin hypercube or Monte Carlo."""
    others = {os.path.realpath(other) for other in (study, json_path, save, plot) if other not in (None, "-")}
    if checkpoint is not None and os.path.realpath(checkpoint) in others:
        _refuse(f"flexmb sweep: --checkpoint needs a file of its own, not '{printable(checkpoint)}'.")

    def work(read: Any):
        from .design.study import sweep_answer, sweep_table

        if plot is not None and not any(len(set(v.tolist())) > 1 for v in read.designs().values()):
            _refuse("flexmb sweep: --plot needs two designs at least, which differ in a parameter.")
        try:
            result = read.sweep(checkpoint=checkpoint, progress=sys.stderr.isatty())
        except KeyboardInterrupt:
            if checkpoint is None:
                raise KeyboardInterrupt("nothing is kept: --checkpoint FILE keeps the designs that are done") from None
            hint = f"'{printable(checkpoint)}' keeps the designs that are done; the same command goes on from them"
            raise KeyboardInterrupt(hint) from None
        return sweep_answer(read, result, __version__), sweep_table(result), result.save, result

    _study("sweep", study, json_path, save, plot, work)


@command
def tune(study: StudyFile, json_path: Json = None, save: Save = None, plot: StudyPlot = None) -> None:
    """Find parameters within bounds that meet targets and keep limits."""

    def work(read: Any):
        from .design.study import tune_answer
        from .files import save_arrays

        names = [*read.values, *read.answers]
        for name in {"about", *(f"history_{name}" for name in (*names, "objective", "violation"))}.intersection(names):
            if save is not None:
                _refuse(
                    f"flexmb: {read.name}: '{name}' is a name that --save uses for another array: choose another name."
                )
        result = read.tune(throw=False, progress=sys.stderr.isatty())
        data = tune_answer(read, result, __version__)

        def saved(path: Path):
            about = {name: data[name] for name in ("study", "status", "reason", "active")}
            histories = {f"history_{name}": values for name, values in result.history.items()}
            save_arrays(path, {**result.dimensions, **result.answers, **histories}, about)

        return data, str(result), saved, result

    _study("tune", study, json_path, save, plot, work)


@command
def robustness(study: StudyFile, json_path: Json = None, save: Save = None, plot: StudyPlot = None) -> None:
    """Compute yield, percentiles and worst cases of made mechanisms with scatter."""

    def work(read: Any):
        from .design.study import robustness_answer, robustness_table

        result = read.robustness(progress=sys.stderr.isatty())
        data = robustness_answer(read, result, __version__)
        return data, robustness_table(result, data), result.samples.save, result

    _study("robustness", study, json_path, save, plot, work)


@command
def fit(
    study: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="Model, parameters and measurements.")],
    json_path: Json = None,
    save: Save = None,
    plot: StudyPlot = None,
) -> None:
    """Fit parameters to measurements, with intervals and undetermined combinations of parameters."""

    def read_study(path: Path):
        from .identification.fit_study import read_fit_study

        return read_fit_study(path)

    def work(read: Any):
        from .files import save_arrays
        from .identification.fit_study import fit_answer, fit_arrays

        result = read.fit()
        data = fit_answer(read, result, __version__)
        arrays = {} if save is None else fit_arrays(result)

        def saved(path: Path):
            save_arrays(path, arrays, {name: data[name] for name in ("study", "status", "reason", "active", "labels")})

        return data, str(result), saved, result

    _study("fit", study, json_path, save, plot, work, read_study)


@command
def edit(
    model: Annotated[
        Path | None, typer.Argument(metavar="[MODEL.dat]", help="SPACAR input file; without it a new mechanism.")
    ] = None,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port of the page; 0 for any free port.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """Open the workbench in the browser, to draw and change a mechanism and see its answers. Ctrl-C ends it."""
    from .workbench.command import serve

    serve(model, port, browser, tell=_print_text, refuse=_refuse)


def main() -> None:
    """Run the command line."""
    # Threads of LAPACK would wait at full speed, which takes a sixth of a short run.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    app()
