"""The command line: arguments only. JAX is imported inside the commands, so that help is quick."""

import sys
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Flexible multibody mechanisms: motion, frequencies, buckling, state space of a SPACAR input file; designs.",
)

ModelFile = Annotated[Path, typer.Argument(metavar="MODEL.dat", help="SPACAR input file.")]
Json = Annotated[str | None, typer.Option("--json", help="Write the answer as JSON here; - for standard output.")]
Save = Annotated[Path | None, typer.Option("--save", help="Save the answer as .npz or .mat.")]
Log = Annotated[Path | None, typer.Option("--log", help="Write the log of the run here.")]
Release = Annotated[str, typer.Option("--release", help="auto: release over-constraints.")]
Plot = Annotated[
    Path | None, typer.Option("--plot", help="Draw the answer as .png or .svg, or as .html to turn and play.")
]
MaxSteps = Annotated[int, typer.Option("--max-steps", min=1, help="Steps of a path (mode 10) at most.")]
Debug = Annotated[bool, typer.Option("--debug", help="Show a traceback for an unexpected fault.")]

EXIT_WRONG_CALL = 2


def _refuse(message: str) -> NoReturn:
    """End with one line on standard error for each fault of the file or the call."""
    print(message, file=sys.stderr)
    raise typer.Exit(EXIT_WRONG_CALL)


def _mode_number(mode: str | None, analysis: str | None) -> int:
    from .io.answers import MODES, RESERVED

    names = {name: number for number, (name, _) in MODES.items()}
    wanted = analysis if analysis is not None else mode
    if wanted is None or (mode is not None and analysis is not None):
        _refuse("flexmb run: give one of --mode and --analysis, such as --mode 7 or --analysis frequencies.")
    text = str(wanted)
    if text in names:
        return names[text]
    number = abs(int(text)) if text.lstrip("-").isdigit() else None
    if number in MODES:
        return number
    known = ", ".join(f"{n} ({name})" for n, (name, _) in MODES.items())
    if number in RESERVED or text in RESERVED.values():
        _refuse(f"flexmb run: mode {text} is reserved and not available yet. Available: {known}.")
    _refuse(f"flexmb run: there is no mode '{text}'. Available: {known}.")


def _check_call(release: str, json_path: str | None, save: Path | None, log: Path | None, plot: Path | None) -> None:
    """Refuse wrong options before anything is computed."""
    if release not in ("none", "auto"):
        _refuse(f"flexmb: --release takes auto or none, not '{release}'.")
    if save is not None and save.suffix not in (".npz", ".mat"):
        _refuse(f"flexmb: --save writes .npz or .mat, not '{save}'.")
    if plot is not None and plot.suffix not in (".png", ".svg", ".html"):
        _refuse(f"flexmb: --plot writes .png, .svg or .html, not '{plot}'.")
    for path in (json_path if json_path != "-" else None, save, log, plot):
        if path is not None and not Path(path).absolute().parent.is_dir():
            _refuse(f"flexmb: the folder of '{path}' does not exist.")


def _run(
    model: Path,
    number: int,
    json_path: str | None,
    save: Path | None,
    log: Path | None,
    release: str,
    max_steps: int = 200,
    plot: Path | None = None,
) -> None:
    from . import ModelError, SpacarError, enable_cache, enable_x64, read_spacar
    from .io.answers import answer
    from .io.files import save as save_answer
    from .io.files import to_json, write_whole
    from .io.tables import log as log_text
    from .io.tables import table

    _check_call(release, json_path, save, log, plot)
    enable_x64()
    try:
        enable_cache()
    except OSError:
        # Without a writable cache folder the program is slower and otherwise the same.
        pass
    try:
        source = model.read_text()
    except (OSError, UnicodeDecodeError) as fault:
        _refuse(f"flexmb: cannot read '{model}': {fault}")
    try:
        read = read_spacar(model)
    except SpacarError as fault:
        _refuse(str(fault))
    try:
        found = answer(
            read.builder,
            model.name,
            number,
            list(read.warnings),
            release,
            max_steps=max_steps,
            settings=read.settings,
        )
    except SpacarError as fault:
        _refuse(str(fault))
    except ModelError as fault:
        _refuse(f"{model.name}: {fault}")
    if json_path == "-":
        print(to_json(found.data))
    else:
        print(table(found.data))
    if json_path not in (None, "-"):
        write_whole(json_path, to_json(found.data).encode())
    if save is not None:
        save_answer(found.data, save)
    if log is not None:
        write_whole(log, log_text(found, source).encode())
    if plot is not None:
        _draw(found, number, plot)
    if found.exit_status:
        first = found.data["message"].splitlines()[0]
        print(f"{model.name}: {found.data['status']}: {first}", file=sys.stderr)
        raise typer.Exit(found.exit_status)


def _draw(found: Any, number: int, path: Path) -> None:
    """Draw an answer in a file; where there is none, the mechanism."""
    from .io.files import write_whole

    if path.suffix == ".html":
        from .viewer.answer import page

        write_whole(path, page(found))
    else:
        from .plot.answer import image

        write_whole(path, image(found, number, path.suffix[1:]))


def _guarded(debug: bool, *arguments: Any) -> None:
    """Turn a fault nobody foresaw into one line, unless a traceback is asked for."""
    try:
        _run(*arguments)
    except typer.Exit:
        raise
    except Exception as fault:
        if debug:
            raise
        first = (str(fault).splitlines() or [""])[0]
        print(f"flexmb: {type(fault).__name__}: {first} (--debug shows where)", file=sys.stderr)
        raise typer.Exit(1) from None


@app.command()
def run(
    model: ModelFile,
    mode: Annotated[str | None, typer.Option("--mode", help="0, 1, 4, 7, 8, 9 or 10.")] = None,
    analysis: Annotated[str | None, typer.Option("--analysis", help="Name of the mode.")] = None,
    json_path: Json = None,
    save: Save = None,
    log: Log = None,
    release: Release = "none",
    max_steps: MaxSteps = 200,
    plot: Plot = None,
    debug: Debug = False,
) -> None:
    """Analyse: 0 mobility, 1 simulate, 4 simulate-linearise, 7 frequencies, 8 buckling, 9 statespace, 10 path."""
    _guarded(debug, model, _mode_number(mode, analysis), json_path, save, log, release, max_steps, plot)


@app.command()
def check(
    model: ModelFile,
    json_path: Json = None,
    save: Save = None,
    log: Log = None,
    plot: Plot = None,
    debug: Debug = False,
) -> None:
    """Show degrees of freedom, over- and under-constraints; the same as mode 0."""
    _guarded(debug, model, 0, json_path, save, log, "none", 200, plot)


@app.command()
def demo(
    name: Annotated[str | None, typer.Argument(help="A shipped mechanism.")] = None,
    listing: Annotated[bool, typer.Option("--list", help="List the shipped mechanisms.")] = False,
    to: Annotated[Path | None, typer.Option("--to", help="Copy the mechanism to this folder instead.")] = None,
    debug: Debug = False,
) -> None:
    """Run the main job on a mechanism that ships with the package, or copy it out."""
    from .mechanisms import mechanism_path, mechanisms

    if listing:
        for key, text in mechanisms().items():
            print(f"{key:<14}{text}")
        return
    name = name or "pf3d"
    if name not in mechanisms():
        _refuse(f"flexmb demo: no mechanism '{name}'. Shipped: {', '.join(mechanisms())}.")
    path = mechanism_path(name)
    if to is not None:
        from .io.files import write_whole

        if not to.is_dir():
            _refuse(f"flexmb demo: the folder '{to}' does not exist.")
        write_whole(to / path.name, path.read_bytes())
        print(to / path.name)
        return
    picture = _demo_picture(name)
    for number in (0, 7, 9):
        _guarded(debug, path, number, None, None, None, "none", 200, picture if number == 7 else None)
        print()
    print(f"picture: {picture}")


def _demo_picture(name: str) -> Path:
    """Where the demo leaves its picture: here, or among temporary files where this folder takes none."""
    import os
    import tempfile

    folder = Path.cwd()
    return (folder if os.access(folder, os.W_OK) else Path(tempfile.mkdtemp())) / f"{name}.png"


def _study(path: Path, json_path: str | None, save: Path | None, plot: Path | None, debug: bool, work: Any) -> None:
    """Run a design study and write its answer; ``work`` returns data, table, exit status, what saves it, the result."""
    from . import enable_cache, enable_x64
    from .design.study import StudyError, read_study
    from .errors import AnalysisError, ModelError, SpacarError
    from .io.files import to_json, write_whole

    _check_call("none", json_path, save, None, plot)
    if plot is not None and plot.suffix == ".html":
        _refuse(f"flexmb: --plot of a study writes .png or .svg, not '{plot}'.")
    enable_x64()
    try:
        enable_cache()
    except OSError:
        pass
    try:
        data, text, status, saved, found = work(read_study(path))
    except (StudyError, OSError) as fault:
        _refuse(f"flexmb: {fault}")
    except AnalysisError as fault:
        print(f"{path.name}: {fault.code}: {str(fault).splitlines()[0]}", file=sys.stderr)
        raise typer.Exit(1) from None
    except Exception as fault:
        if debug:
            raise
        first = (str(fault).splitlines() or [""])[0]
        if isinstance(fault, ValueError) and not isinstance(fault, ModelError):
            _refuse(str(fault) if isinstance(fault, SpacarError) else f"{path.name}: {first}")
        print(f"flexmb: {type(fault).__name__}: {first} (--debug shows where)", file=sys.stderr)
        raise typer.Exit(1) from None
    print(to_json(data) if json_path == "-" else text)
    if json_path not in (None, "-"):
        write_whole(json_path, to_json(data).encode())
    if save is not None:
        saved(save)
    if plot is not None:
        from .plot.answer import study_image

        write_whole(plot, study_image(found, plot.suffix[1:]))
    if status:
        print(f"{path.name}: {data['status']}: {data['message']}", file=sys.stderr)
        raise typer.Exit(status)


StudyFile = Annotated[Path, typer.Argument(metavar="STUDY.toml", help="Model, parameters and answers.")]


@app.command()
def sweep(
    study: StudyFile,
    json_path: Json = None,
    save: Save = None,
    checkpoint: Annotated[Path | None, typer.Option("--checkpoint", help="Go on from this .npz, and write it.")] = None,
    plot: Plot = None,
    debug: Debug = False,
) -> None:
    """Compute many designs of a model with parameters: grid, Latin hypercube or Monte Carlo."""

    def work(read):
        from . import __version__
        from .design.study import sweep_answer, sweep_table

        options = {"chunk": int(read.plan["chunk"])} if "chunk" in read.plan else {}
        found = read.sweep(checkpoint=checkpoint, progress=sys.stderr.isatty(), **options)
        data = sweep_answer(read, found, __version__)
        return data, sweep_table(found), int(data["status"] != "ok"), found.save, found

    _study(study, json_path, save, plot, debug, work)


@app.command()
def tune(study: StudyFile, json_path: Json = None, save: Save = None, plot: Plot = None, debug: Debug = False) -> None:
    """Find parameters within bounds that meet targets and keep limits."""

    def work(read):
        from . import __version__
        from .design.study import tune_answer
        from .io.files import save_arrays

        found = read.tune(throw=False, progress=sys.stderr.isatty())
        data = tune_answer(read, found, __version__)

        def saved(path):
            about = {name: data[name] for name in ("study", "status", "reason", "active")}
            save_arrays(path, {**found.dimensions, **found.answers, **_named("history_", found.history)}, about)

        return data, str(found), int(data["status"] != "ok"), saved, found

    _study(study, json_path, save, plot, debug, work)


def _named(before: str, arrays: dict[str, Any]) -> dict[str, Any]:
    return {before + name: array for name, array in arrays.items()}


def main() -> None:
    """Run the command line."""
    app()
