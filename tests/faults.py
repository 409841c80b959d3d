"""Faults put into the package, one at a time, and whether the tests see them: `python tests/faults.py [room ..]`.

A suite that passes says nothing about what it would let through. Each fault here is a small one, such as are really
made: a sign, a factor, a transposed matrix, an early return, a status that is forgotten. Each names the few tests that
should see it. Faults are put into a copy of the package in a temporary folder, never into the working tree.
Tests marked as slow are left out: what the suite runs without being asked has to see 80 % of the faults. What only a
slow one sees says so, `slow=True`, and is asked of that one.

    python tests/faults.py                # all of them, which takes an hour or more
    python tests/faults.py cli control    # those of some rooms
    python tests/faults.py --only C0      # those whose texts or files contain a word
    python tests/faults.py --list         # only whether each still finds its place; the suite does so too

A fault whose text does not occur exactly once in its file is stale and must be mended; all stale ones are listed at
once, and nothing is run. Before the faults of a room its tests run on the copy as it is: what fails then proves
nothing.
"""

import argparse
import importlib
import os
import shutil
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]
# Where the package must not be taken from.
OURS = (ROOT, ROOT / "tests")
# Loaded once, for all tests.
LIBRARIES = ("jax.numpy", "scipy.integrate", "scipy.optimize", "scipy.spatial.transform", "typer.testing")
# What a run needs beside the package itself.
BESIDE = ("tests", "notebooks", "benchmarks", "pyproject.toml", "README.md")
# The share of faults that the suite sees within its ten minutes; slow tests see the others.
ENOUGH = 0.8
PASSED, FAILED, BROKEN = 0, 1, 3
# A test that a fault sends into an endless loop has seen it.
LONGEST = 900


class Fault(NamedTuple):
    """One fault.

    Attributes:
        file: Of the package, from its folder.
        old: Text that occurs in it once.
        new: What stands there instead.
        tests: What pytest is called with: files or tests from ``tests/``, and ``-k`` with an expression.
        slow: Whether slow tests alone see it.
    """

    file: str
    old: str
    new: str
    tests: str
    slow: bool = False

    @property
    def room(self) -> str:
        """Folder of the file, or its own name at the root of the package."""
        return self.file.partition("/")[0].removesuffix(".py")

    def __str__(self) -> str:
        return f"{self.file}: {self.old.strip()!r} -> {self.new.strip()!r}"


def stale(faults: list[Fault], package: Path = ROOT / "flexmb") -> list[str]:
    """What is wrong with faults whose text does not occur exactly once."""
    found = []
    for fault in faults:
        path = package / fault.file
        count = path.read_text(encoding="utf-8").count(fault.old) if path.is_file() else -1
        if count != 1:
            what = "there is no such file" if count < 0 else f"its text occurs {count} times"
            found.append(f"{what}: {fault}")
    return found


def copied(folder: Path) -> None:
    """Copy what a run needs to a folder."""
    leave = shutil.ignore_patterns("__pycache__", "node_modules", ".hypothesis", ".pytest_cache")
    shutil.copytree(ROOT / "flexmb", folder / "flexmb", ignore=leave)
    for name in BESIDE:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, ignore=leave)
        elif (ROOT / name).is_file():
            shutil.copy2(ROOT / name, folder / name)


def tested(folder: Path, tests: str, slow: bool) -> tuple[int, str]:
    """Exit status of pytest in a folder, and the last of what it said; slow tests are run where asked for.

    In a process of its own that takes over the libraries that this one has loaded: they take as long as most tests.
    """
    words = [f"tests/{word}" if word.partition("::")[0].endswith(".py") else word for word in split(tests)]
    said = folder / "said.txt"
    child = os.fork()
    if child == 0:
        status = BROKEN
        try:
            signal.alarm(LONGEST)
            with said.open("w") as out:
                os.dup2(out.fileno(), 1)
                os.dup2(out.fileno(), 2)
            os.chdir(folder)
            os.environ.update(PYTHONPATH=str(folder), PYTHONDONTWRITEBYTECODE="1")
            sys.dont_write_bytecode = True
            sys.path[:] = [str(folder), *(place for place in sys.path if Path(place).resolve() not in OURS)]
            which = "--slow=only" if slow else "--slow=out"
            status = int(pytest.main(["-x", "-p", "no:cacheprovider", "--no-header", which, *words]))
            sys.stdout.flush()
        except BaseException:
            os.write(2, traceback.format_exc().encode())
        finally:
            os._exit(status)
    _, ended = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(ended) if os.WIFEXITED(ended) else FAILED, said.read_text(errors="replace")[-2000:]


def split(tests: str) -> list[str]:
    """Words of a call of pytest; all behind -k is one expression."""
    files, flag, expression = tests.partition(" -k ")
    return files.split() + (["-k", expression] if flag else [])


def put(folder: Path, fault: Fault) -> str:
    """Put a fault into the copy and return the text as it was."""
    path = folder / "flexmb" / fault.file
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    return text


def is_right(folder: Path, faults: list[Fault]) -> bool:
    """Whether the tests pass in the copy without a fault, each call once."""
    good = True
    for tests, slow in dict.fromkeys((fault.tests, fault.slow) for fault in faults):
        status, said = tested(folder, tests, slow)
        if status != PASSED:
            good = False
            print(f"  does not pass without a fault ({status}): {tests}\n{said}", flush=True)
    return good


def main(arguments: list[str]) -> int:
    """Run what is asked for; 0 where enough faults are killed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("rooms", nargs="*", help="rooms of the package; all without")
    parser.add_argument("--list", action="store_true", help="only look whether each fault finds its place")
    parser.add_argument("--only", default="", help="only faults whose text, file or tests contain this")
    parser.add_argument("--trust", action="store_true", help="do not run the tests without faults first")
    options = parser.parse_args(arguments)
    chosen = [f for f in FAULTS if not options.rooms or f.room in options.rooms]
    chosen = [f for f in chosen if options.only in f"{f} {f.tests}"]
    if wrong := stale(chosen):
        print("\n".join(["Stale:", *wrong]))
        return 1
    if options.list:
        print(f"{len(chosen)} faults in {len({f.room for f in chosen})} rooms, all of which find their place")
        return 0
    killed, survived = [], []
    for library in LIBRARIES:
        importlib.import_module(library)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copied(folder)
        for room in dict.fromkeys(f.room for f in chosen):
            own = [f for f in chosen if f.room == room]
            print(f"{room}:", flush=True)
            if not options.trust and not is_right(folder, own):
                return 1
            for fault in own:
                text, began = put(folder, fault), time.monotonic()
                try:
                    status, said = tested(folder, fault.tests, fault.slow)
                finally:
                    (folder / "flexmb" / fault.file).write_text(text, encoding="utf-8")
                (killed if status == FAILED else survived).append(fault)
                word = {PASSED: "SURVIVED", FAILED: "killed"}.get(status, f"NO TEST RAN ({status}): {said}")
                seen = [line for line in said.splitlines() if line.startswith("FAILED ")]
                by = "".join(f"  by {line.split()[1]}" for line in seen)
                print(f"  {word:9} {time.monotonic() - began:4.0f} s  {fault}{by}", flush=True)
    share = len(killed) / max(len(chosen), 1)
    print(f"{len(killed)} of {len(chosen)} killed, {100 * share:.1f} %")
    print("\n".join(f"survived: {fault}" for fault in survived))
    return 0 if share >= ENOUGH else 1


PROFILES = "elements/test_profile.py -k against_shooting"
TRACED = "test_laws_of_answers.py -k under_a_trace"
FAULTS = [
    # The command line and what it answers.
    Fault(
        "cli.py",
        "_end_failed(result.data, read.name, result.exit_status)",
        "raise typer.Exit(0)",
        "test_cli.py -k ends_early",
    ),
    Fault("cli.py", "_run(model, 0, json_path", "_run(model, 7, json_path", "test_cli.py -k check_is"),
    Fault(
        "cli.py", "raise typer.Exit(EXIT_FAILED) from None", "raise typer.Exit(0) from None", "test_cli.py -k foresaw"
    ),
    Fault(
        "cli.py",
        "            if debug:\n                raise",
        "            if True:\n                raise",
        "test_cli.py -k every_command",
    ),
    Fault("cli.py", "{name.strip(): length} if equals", "{name.strip(): -length} if equals", "test_cli.py -k verdict"),
    Fault("cli.py", 'if data["status"] != "ok":', "if False:", "design/test_study.py -k exit_1"),
    Fault("cli.py", "        WRITTEN.append(path)\n", "", "test_cli.py -k says_what_it_keeps"),
    Fault(
        "cli.py",
        "            if checkpoint is None:\n                raise",
        "            if True:\n                raise",
        "test_cli.py -k says_what_it_keeps",
    ),
    Fault(
        "cli.py", 'PICTURES = (".png", ".svg", ".pdf")', 'PICTURES = (".png", ".svg")', "test_cli.py -k appear_whole"
    ),
    Fault(
        "checks/releases.py",
        "RLSE {self.of} {self.number}",
        "RLSE {self.number} {self.of}",
        "test_cli.py -k on_request",
    ),
    Fault("cli.py", "code = EXIT_WRONG_CALL", "code = 0", "test_cli.py -k wrong_call"),
    Fault("cli.py", "return names[text]", "return 7", "test_cli.py -k by_number_and_by_name"),
    Fault(
        "answers/answer_parts.py",
        "@ values / 4 if len(indices) == 4",
        "@ values / 2 if len(indices) == 4",
        "answers/test_answers.py",
    ),
    Fault("answers/mode_9_statespace.py", '"bode" if moved else ""', '""', "plot/test_plot.py -k command_line"),
    Fault("answers/mode_0_mobility.py", ", structural=True", "", "test_cli.py -k overconstrained"),
    Fault("answers/answer_parts.py", "[None if v < 0 else f for", "[abs(f) for", "answers/test_answers.py -k falls"),
    Fault(
        "answers/mode_7_frequencies.py",
        '"stable": mode_set.stable,',
        '"stable": True,',
        "answers/test_answers.py -k falls",
    ),
    Fault(
        "answers/mode_4_simulate_linearise.py",
        "linearised=True",
        "linearised=False",
        "test_cli.py -k json_of_a_motion",
    ),
    Fault("answers/answer_parts.py", "damped = np.any(", "damped = not np.any(", "test_cli.py -k printed_state_space"),
    Fault(
        "answers/mode_1_simulate.py",
        "to_frequency(values.real).tolist(), real",
        "(6 * to_frequency(values.real)).tolist(), real",
        "test_cli.py -k json_of_a_motion",
    ),
    Fault(
        "answers/mode_1_simulate.py",
        '"velocities": over_time(motion.xd',
        '"velocities": over_time(motion.x',
        "test_cli.py -k json_of_a_motion",
    ),
    Fault(
        "answers/mode_1_simulate.py",
        "velocity * t + 0.5 * acceleration",
        "velocity * t + acceleration",
        "answers/test_answers.py -k with_an_acceleration",
    ),
    Fault(
        "answers/mode_1_simulate.py",
        "for number in (value - start[index], *rates)",
        "for number in (value, *rates)",
        "spacar/test_lines.py -k simulation_takes",
    ),
    Fault(
        "answers/mode_1_simulate.py",
        '"status": "ok" if code == RESULTS.successful else code.name',
        '"status": "ok"',
        "test_cli.py -k ends_early",
    ),
    Fault("answers/answer_parts.py", '"  ".join(f"{v:12.5g}"', '"  ".join(f"{abs(v):12.5g}"', "answers/test_tables.py"),
    Fault("answers/mode_8_buckling.py", 'f"{v:.7g}"', 'f"{abs(v):.7g}"', "answers/test_tables.py"),
    Fault("answers/mode_7_frequencies.py", "{im:+.7g}j", "{im:.7g}j", "answers/test_tables.py"),
    Fault(
        "answers/mode_10_path.py",
        "{'yes' if s['stable'] else 'NO':6}",
        "{'NO' if s['stable'] else 'yes':6}",
        "answers/test_tables.py",
    ),
    Fault("answers/mode_1_simulate.py", "row(rows[-1])", "row(rows[0])", "answers/test_tables.py"),
    Fault(
        "answers/answer_files.py",
        "np.asarray(getattr(motion, name))",
        "np.asarray(motion.x)",
        "motion/test_observed.py",
    ),
    Fault("answers/answer_files.py", '"sigma": "N, N m",', "", "motion/test_observed.py"),
    Fault("answers/answer_files.py", "if not reached.all():", "if False:", "motion/test_observed.py"),
    Fault(
        "answers/answer_files.py",
        "[signal.name for signal in labels.inputs]",
        "[signal.name for signal in labels.outputs]",
        "motion/test_observed.py",
    ),
    Fault(
        "answers/answer_files.py", 'names if arrays["u"].shape[1] else []', "names", "motion/test_observed.py -k file"
    ),
    Fault("spacar/write.py", 'without.append("shear")', "pass", "elements/test_materials.py -k damping_of_shear"),
    # Linearised equations.
    Fault(
        "linear/compliance.py", "return 2 * lbar(coordinates)", "return lbar(coordinates)", "linear/test_compliance.py"
    ),
    Fault(
        "linear/compliance.py",
        "rotation_matrix(rotation).T @ row",
        "rotation_matrix(rotation) @ row",
        "linear/test_compliance.py",
    ),
    Fault("linear/compliance.py", "[[c, s], [-s, c]]", "[[c, -s], [s, c]]", "linear/test_compliance.py"),
    Fault(
        "linear/compliance.py",
        "np.where(takes_part(rows, free), np.inf, values)",
        "values",
        "linear/test_loose.py -k beside_a_free",
    ),
    Fault(
        "linear/linearize.py",
        "D0=dfe.T @ damping @ dfe",
        "D0=-dfe.T @ damping @ dfe",
        "control/test_state_space.py -k oscillator",
    ),
    Fault(
        "linear/linearize.py",
        "mass_matrix(topology, parameters, at.x)",
        "mass_matrix(topology, parameters, parameters.reference)",
        "linear/test_linearize.py -k turned",
    ),
    Fault(
        "linear/linearize.py",
        "sum(parts), self.K0, self.N0, self.G0)",
        "sum(parts), self.K0, self.N0)",
        "mechanics/test_constraint_forces.py",
    ),
    Fault("linear/spectrum.py", "1 / positive - shift", "1 / positive", "mechanics/test_constraint_forces.py"),
    Fault(
        "linear/spectrum.py",
        "xp.where(usual, values, 1.0))) / (2 * np.pi)",
        "xp.where(usual, values, 1.0)))",
        "linear/test_derivatives.py",
    ),
    Fault(
        "linear/spectrum.py",
        "[-k / stiff, -c / (w * heavy)]]",
        "[-k / stiff, c / (w * heavy)]]",
        "control/test_state_space.py -k oscillator",
    ),
    Fault(
        "linear/buckling.py",
        "pencil(-(g + g.T) / 2",
        "pencil((g + g.T) / 2",
        "test_cli.py -k printed_numbers",
    ),
    Fault("linear/buckling.py", "stays = at.K0 + at.G0", "stays = at.K0", "paths/test_path.py -k preload", slow=True),
    Fault(
        "linear/buckling.py",
        "jnp.linalg.eigvals(factorise(k).solve(-g))",
        "jnp.linalg.eigvals(factorise(k).solve(g))",
        "spacar/test_light.py -k buckling",
        slow=True,
    ),
    Fault(
        "elements/surface.py",
        "sigma_x**2 + 3 * tau**2",
        "sigma_x**2 + tau**2",
        "linear/test_stress.py -k smooth",
    ),
    Fault("linear/compliance.py", "< -NEGATIVE_WORK:", "< -1e9:", "linear/test_compliance.py"),
    Fault(
        "elements/spectral_planar.py",
        "lengths=(ELONGATION, SHEAR)",
        "lengths=()",
        "test_stability.py -k path_in_metres",
    ),
    Fault("linear/stress.py", "self.names[element]", "self.names[-element]", "linear/test_stress.py"),
    Fault("linear/measures.py", "(a.T @ m @ b) ** 2", "np.abs(a.T @ m @ b)", "linear/test_measures.py"),
    Fault(
        "linear/measures.py", "numbers[rows] = columns", "numbers[columns] = rows", "linear/test_measures.py -k in_turn"
    ),
    Fault("linear/loose.py", "if share[i] < 0][:4]", "if share[i] > 0][:4]", "linear/test_loose.py -k negative_mass"),
    # Damping of a model.
    Fault("linear/damping.py", "2 * zeta * w * mu", "zeta * w * mu", "linear/test_damping.py -k one_mass"),
    Fault("linear/damping.py", "sizes[0] - 1)[::-1]]", "sizes[0] - 1)]", "linear/test_damping.py -k two_masses"),
    Fault("linear/damping.py", "rayleigh[1] * m.K0", "rayleigh[1] * m.M0", "linear/test_damping.py -k two_masses"),
    Fault(
        "linear/damping.py",
        "massive & (values > VIBRATES_ABOVE_SHIFT * shift)",
        "massive & (values > -np.inf)",
        "linear/test_damping.py -k does_not_vibrate",
    ),
    Fault("linear/damping.py", "slopes / (2 * np.pi)", "slopes", "linear/test_damping.py -k derivatives"),
    Fault("linear/damping.py", "np.asarray(value)[i] == other", "True", "linear/test_damping.py -k stiff_guide"),
    Fault("linear/spectrum.py", "heavy)]])", "heavy / w)]])", "control/test_state_space.py -k oscillator"),
    Fault(
        "math/matrix_functions.py",
        "by_arguments * np.eye(len(mu))) @",
        "by_arguments) @",
        "linear/test_damping.py -k two_masses",
    ),
    Fault(
        "math/matrix_functions.py", "n * 2 * p[None, :]", "n * 2 * p[:, None]", "linear/test_damping.py -k derivatives"
    ),
    Fault(
        "math/matrix_functions.py",
        "slopes[None, :]) / 2",
        "slopes[None, :])",
        "linear/test_damping.py::test_derivatives",
    ),
    Fault("elements/sections.py", "ratio / (np.pi * frequency)", "ratio / frequency", "linear/test_damping.py -k leaf"),
    # State space.
    Fault(
        "control/state_space.py",
        "moved[:, :n_u], keep",
        "-moved[:, :n_u], keep",
        "control/test_state_space.py",
    ),
    Fault("control/state_space.py", "keep - moved", "keep + moved", "control/test_state_space.py"),
    Fault(
        "control/state_space.py",
        "through[0] + c_q[2] @ keep @ pull",
        "through[0]",
        "control/test_state_space.py",
    ),
    Fault(
        "control/second_order_form.py",
        "passed.append(-sign *",
        "passed.append(sign *",
        "control/test_second_order_form.py -k every_kind",
    ),
    Fault(
        "control/second_order_form.py",
        "return row @ first[indices] - turning",
        "return row @ first[indices] + turning",
        "control/test_signals.py -k steady_motion",
        slow=True,
    ),
    Fault(
        "control/second_order_form.py",
        "2 * row @ first[indices], along",
        "row @ first[indices], along",
        "control/test_signals.py -k steady_motion",
        slow=True,
    ),
    Fault("control/second_order_form.py", "m.M0, m.C0 + m.D0, m.K", "m.M0, m.C0, m.K", "control/test_state_space.py"),
    Fault(
        "control/held.py",
        "curvature - loads) @ z + about_axes",
        "curvature) @ z + about_axes",
        "control/test_second_order_form.py -k loaded_leaf",
        slow=True,
    ),
    Fault(
        "control/held.py",
        "@ m.reactions[euler]",
        "@ (0 * m.reactions[euler])",
        "control/test_second_order_form.py -k loaded_leaf",
        slow=True,
    ),
    Fault(
        "control/state_space.py",
        "b1 - damping @ at_once",
        "b1 + damping @ at_once",
        "control/test_second_order_form.py -k shakes",
    ),
    Fault(
        "control/state_space.py",
        "rates = inverse.solve(b1",
        "rates = 0 * inverse.solve(b1",
        "control/test_second_order_form.py -k wall",
    ),
    Fault(
        "motion/controlled_form.py",
        "u_by = factorise(jnp.eye(self.places.inputs) - u_by_y @ by_input).solve(u_by)",
        "",
        "motion/test_loop.py -k tangent_of",
    ),
    # Functional mock-up units: functions in C.
    Fault("fmu/flatten.py", "else (name, meaning, *map", "else (name, *map", "fmu/test_translate.py -k primitive"),
    Fault("fmu/writer.py", "min(life[0], first), max(life[1], end - 1)", "life", "fmu/test_translate.py -k primitive"),
    Fault("fmu/writer.py", "merged[-1][1] == stride * length", "merged", "fmu/test_translate.py -k primitive"),
    Fault("fmu/primitives.py", "self.inside is None else", "True else", "fmu/test_translate.py -k primitive"),
    Fault(
        "fmu/primitives.py",
        "down, across, count = not turned,",
        "down, across, count = turned,",
        "fmu/test_translate.py -k primitive",
    ),
    Fault("fmu/runtime.c", "a != a || b != b ? NAN : a > b", "a > b", "fmu/test_translate.py -k primitive"),
    Fault(
        "fmu/translate.py",
        "[new if self._has_own_buffer(new, block)",
        "[new if True",
        "fmu/test_translate.py -k primitive",
    ),
    Fault("fmu/flatten.py", "refuse_callbacks(program.jaxpr)", "pass", "fmu/test_translate.py -k refused"),
    Fault("fmu/plant_steps.c", "tries <= PLANT_FINER", "tries < 1", "fmu/test_translate.py -k space", slow=True),
    Fault("checks/mobility.py", 'in ("internal", "warping")', 'in ("warping",)', "checks/test_mobility.py -k leaf"),
    Fault("control/truncation.py", "inertia @ (keep.T @ forces))", "0)", "control/test_truncation.py -k rigid"),
    Fault("control/truncation.py", "share[:, None])", "-share[:, None])", "control/test_truncation.py -k rigid"),
    Fault("control/truncation.py", "hertz <= bandwidth", "hertz >= bandwidth", "control/test_truncation.py -k margins"),
    Fault("control/truncation.py", "NEGLIGIBLE * np.sqrt", "1e3 * np.sqrt", "control/test_truncation.py -k error"),
    Fault("control/second_order_form.py", "s**2 * m, forces", "s * m, forces", "control/test_truncation.py -k error"),
    Fault(
        "control/truncation.py",
        "np.abs(np.array(truncated_responses) - right)",
        "np.abs(np.array(truncated_responses))",
        "control/test_truncation.py -k error",
    ),
    # Frequency responses and noise.
    Fault(
        "control/harmonic.py",
        "c @ s + m @ s2",
        "c @ s + m @ s",
        "control/test_frequency_response.py -k dimensions",
        slow=True,
    ),
    Fault(
        "control/harmonic.py",
        "+ adjoint @ (_expanded",
        "- adjoint @ (_expanded",
        "control/test_frequency_response.py -k repeated",
    ),
    Fault(
        "control/harmonic.py",
        "np.array([1, 1j, -1, -1j, 1])",
        "np.array([1, 1j, 1, -1j, 1])",
        "control/test_frequency_response.py -k shakes",
    ),
    Fault(
        "control/harmonic.py",
        "jnp.abs(inverse) <= RESONANCE_HIT",
        "jnp.abs(inverse) < 0 * RESONANCE_HIT",
        "control/test_frequency_response.py -k repeated",
    ),
    Fault("control/noise.py", "* densities / 2", "* densities", "control/test_noise.py -k one_mass", slow=True),
    Fault("control/noise.py", "(-DECAYING_POLE if exact else GROWING_NOISE)", "1", "control/test_noise.py -k loop"),
    Fault(
        "control/feedback.py",
        "beyond_round_off(b - moved @ follows, moved",
        "beyond_round_off(b, moved",
        "control/test_noise.py -k one_mass",
        slow=True,
    ),
    Fault(
        "control/feedback.py",
        "[a + bd @ by_z, bd",
        "[a - bd @ by_z, bd",
        "control/test_noise.py -k lyapunov",
        slow=True,
    ),
    Fault(
        "math/matrix_functions.py", "lower=adjoint)", "lower=False)", "control/test_noise.py -k derivatives", slow=True
    ),
    Fault(
        "control/nonlinear_system.py",
        "self.memory = self.memory_before",
        "pass",
        "control/test_nonlinear_system.py -k loop_of_python_control",
        slow=True,
    ),
    Fault(
        "control/nonlinear_system.py",
        "if self.count == MANY:",
        "if self.count < 0:",
        "control/test_nonlinear_system.py -k many_evaluations",
    ),
    Fault(
        "elements/section.py",
        "return self.E / (2 * (1 + self.nu))",
        "return self.E / (2 + self.nu)",
        "build/test_mistaken_units.py -k nu_or_g",
    ),
    Fault(
        "build/mistaken_units.py",
        "soft = density < limits.DENSEST_GEL and (",
        "soft = density < limits.DENSEST_GEL or (",
        "build/test_mistaken_units.py",
    ),
    Fault(
        "build/mistaken_units.py",
        "if np.max(reach) > limits.LARGEST_MECHANISM:",
        "if np.min(reach) > limits.LARGEST_MECHANISM:",
        "build/test_mistaken_units.py",
    ),
    Fault(
        "identification/fitted.py",
        "linear = ((places - self.unit[i]) * change / ",
        "linear = ((places - self.unit[i]) / ",
        "identification/test_fit.py -k profile",
    ),
    Fault(
        "plot/canvas.py",
        "width = np.where(np.isfinite(deviations), 2 * deviations, 0.0)",
        "width = np.where(np.isfinite(deviations), deviations, 0.0)",
        "identification/test_fit.py -k picture",
    ),
    Fault(
        "display.py",
        "name = names[len(names) - count + entry.component - 1]",
        "name = names[len(names) - count - 1]",
        "test_results.py -k within_an_element",
    ),
    Fault(
        "control/nonlinear_system.py",
        "state[:n] / form.sizes, state[n:] / form.sizes",
        "state[:n], state[n:]",
        "control/test_nonlinear_system.py",
    ),
    Fault(
        "control/nonlinear_system.py",
        "form.acceleration(t, at)[0] * form.sizes",
        "form.acceleration(t, at)[0]",
        "control/test_nonlinear_system.py",
    ),
    # Motion.
    Fault(
        "motion/loop.py", "return target - read", "return read - target", "motion/test_simulate.py -k linear_mechanism"
    ),
    Fault("motion/loop.py", "return sign * read", "return read", "motion/test_loop.py -k positive_feedback", slow=True),
    Fault(
        "motion/loop.py",
        "if loop.sign is None and controller.reads is not None",
        "if loop.sign is None and controller.reads",
        "motion/test_loop.py -k positive_feedback",
        slow=True,
    ),
    Fault(
        "motion/loop.py",
        "target = target[places]",
        "target = target[: len(places)]",
        "motion/test_loop.py -k reads_by_name",
        slow=True,
    ),
    Fault(
        "control/stability.py",
        "inner, inner_loop = _without_given_motion(plant, driven), loop",
        "inner, inner_loop = plant, loop",
        "control/test_loops.py -k leaves_out_the_given_motion",
    ),
    Fault(
        "motion/controllers.py",
        "return at_time(a, t) @ z + at_time(b, t) @ y",
        "return at_time(a, t) @ z - at_time(b, t) @ y",
        "motion/test_simulate.py -k closed_loop",
        slow=True,
    ),
    Fault(
        "motion/controllers.py",
        "return at_time(c, t) @ z + at_time(d, t) @ y",
        "return at_time(c, t) @ z - at_time(d, t) @ y",
        "motion/test_simulate.py -k sampled_loop",
    ),
    Fault(
        "motion/drives_by_name.py",
        'kind = "local moment" if signal.local',
        'kind = "local moment" if not signal.local',
        "control/test_signals.py -k axes_of_the_body",
        slow=True,
    ),
    Fault(
        "motion/drives_by_name.py",
        "        if name not in known:\n            hint",
        "        if False:\n            hint",
        "motion/test_loop.py -k asked_by_name",
    ),
    Fault(
        "motion/controllers.py",
        'known = {name.replace(".", " "): i for i, name in enumerate(there)}',
        'known = {name.replace(".", " "): 0 for i, name in enumerate(there)}',
        "control/test_loops.py -k where_they_are_wanted",
    ),
    Fault(
        "control/loops.py",
        "1 - jnp.exp(-feedback.period / tracking)",
        "1 + jnp.exp(-feedback.period / tracking)",
        "control/test_loops.py -k recursion",
    ),
    Fault(
        "control/loops.py",
        "round(delay / period)\n",
        "round(delay / period) + 1\n",
        "control/test_loops.py -k recursion",
    ),
    Fault("control/loops.py", "return u + extra", "return u - extra", "control/test_loops.py -k recursion"),
    Fault(
        "control/stability.py",
        "loop: Any = -sign * returned",
        "loop: Any = sign * returned",
        "control/test_loops.py -k pd_by_hand",
    ),
    Fault(
        "control/stability.py",
        "np.log(roots[roots != 0]) / period",
        "np.log(roots[roots != 0]) * period",
        "control/test_loops.py -k within_the_circle",
    ),
    Fault(
        "control/pole_placement.py",
        "m * filtered * a2 - d -",
        "m * filtered * a2 + d -",
        "control/test_loops.py -k where_they_are_wanted",
    ),
    Fault(
        "control/pole_placement.py",
        "[1, depth * width * w, w**2]",
        "[1, width * w, w**2]",
        "control/test_loops.py -k test_notch",
    ),
    Fault(
        "motion/step_control.py",
        "diffrax.RESULTS.where(away,",
        "diffrax.RESULTS.where(away & False,",
        "motion/test_solve.py -k failures",
    ),
    Fault(
        "results.py",
        "    if not throw or not isinstance(result, jax",
        "    if True or not isinstance(result, jax",
        TRACED,
    ),
    Fault("statics/equilibrium.py", "or_nan(solved, solved.result, throw)", "solved", TRACED),
    Fault("linear/modes.py", "return or_nan(values, result, throw)", "return values", TRACED),
    Fault("motion/simulate.py", '"x": motion.x, "xd"', '"xd"', TRACED),
    Fault("math/derivative.py", "none = square <= 0", "none = ~(square > 0)", "math/test_derivative.py"),
    Fault(
        "math/sparse.py",
        "in (False, True):",
        "in (False,):",
        "linear/test_sparse.py::test_a_cantilever_of_any_size_vibrates_alike[False]",
    ),
    Fault(
        "math/sparse.py",
        "equilibrating(tangent, factored.by_diagonal)",
        "equilibrating(tangent)",
        "linear/test_sparse.py::test_a_cantilever_of_any_size_vibrates_alike[False]",
    ),
    Fault("arguments.py", "leaf.copy() if isinstance", "leaf if isinstance", "build/test_builder.py -k written_into"),
    Fault(
        "statics/equilibrium.py",
        "solved.known(model, target)",
        "solved.known(None, target)",
        "linear/test_states.py -k go_together",
    ),
    Fault("model/model.py", "        require_double_precision()\n", "", "build/test_builder.py -k double_precision"),
    Fault(
        "workbench/server.py",
        "        atexit.register(self.close)\n",
        "",
        "workbench/test_server.py -k left_to_the_process",
    ),
    Fault(
        "workbench/dat_file.py",
        "if message not in map(no_element_message, joined):",
        "if True:",
        "workbench/test_dat_file.py -k refused_leaves",
    ),
    Fault(
        "results.py",
        "number * factor.reshape(shape) + jnp.reshape(lost, shape if jnp.ndim(lost) else ())",
        "jnp.where(failed, jnp.nan, number)",
        TRACED,
    ),
    Fault(
        "linear/sparse_solve.py",
        "if all(np.all(np.isfinite(number)) for",
        "if all(True for",
        "linear/test_sparse.py -k failed_before",
    ),
    Fault(
        "statics/equilibrium.py",
        'if name not in ("asked_of", "factors")',
        "if True",
        "linear/test_states.py -k stored_without",
    ),
    Fault(
        "trajectory/vibrations.py",
        "holding - _servo_forces(m,",
        "holding + 0 * _servo_forces(m,",
        "trajectory/test_vibrations.py -k servo",
        slow=True,
    ),
    Fault("math/derivative.py", "jax.tree.map(same, value)", "value", "math/test_derivative.py"),
    Fault(
        "numerical_limits.py", "SUDDEN_OVER_USUAL = 5.0", "SUDDEN_OVER_USUAL = 50.0", "motion/test_sudden.py -k where"
    ),
    Fault("motion/sudden.py", "sharp[last] + 1", "sharp[last]", "motion/test_sudden.py -k where"),
    Fault(
        "motion/sudden.py",
        "known := undifferentiated(f)",
        "known := f",
        "motion/test_sudden.py -k where",
    ),
    Fault(
        "motion/simulate.py",
        "[drive.value for drive in driven]\n    if",
        "[]\n    if",
        "motion/test_sudden.py -k own",
    ),
    Fault("compilation/program.py", "sin cos square", "sin cos square exp", "motion/test_sudden.py -k waves"),
    Fault(
        "motion/controlled_form.py",
        "Constant(u[places.forces[1]])",
        "Constant(-u[places.forces[1]])",
        "motion/test_loop.py",
    ),
    Fault(
        "motion/controlled_form.py",
        "Constant(u[places.stresses[1]])",
        "Constant(-u[places.stresses[1]])",
        "motion/test_loop.py",
    ),
    Fault(
        "motion/controlled_form.py",
        '"deformation": e, "deformation rate": ed}',
        '"deformation": e, "deformation rate": -ed}',
        "motion/test_loop.py",
    ),
    Fault("motion/controlled_form.py", "moved = at.x - parameters.reference", "moved = at.x", "motion/test_loop.py"),
    Fault(
        "motion/drive.py", "LoadFactors(1.0, increment)", "LoadFactors(increment, increment)", "motion/test_drive.py"
    ),
    Fault(
        "motion/drive.py",
        "matrix = 2 * jnp.einsum",
        "matrix = jnp.einsum",
        "control/test_signals.py -k input_acts_as",
        slow=True,
    ),
    Fault(
        "motion/drive.py",
        "values[i] + share *",
        "values[i] - share *",
        "motion/test_bends.py::test_where_a_table_bends_it_is_that_of_one_piece_and_moves_no_steps",
    ),
    Fault(
        "motion/coordinates_form.py",
        "sigma = sigma + drive.stress",
        "sigma = sigma - drive.stress",
        "motion/test_drive.py",
    ),
    Fault(
        "motion/coordinates_form.py",
        "LoadFactors(1.0, drive.increment), x)\n        if drive.force",
        "LoadFactors(1.0, 0.0), x)\n        if drive.force",
        "motion/test_drive.py",
    ),
    Fault(
        "motion/coordinates_form.py",
        "x = accumulate(x, top.x.prescribed, drive.x)",
        "x = accumulate(x, top.x.prescribed, -drive.x)",
        "motion/test_drive.py",
    ),
    Fault(
        "motion/coordinates_form.py",
        "sigma = sigma + self.S_d @ ed",
        "sigma = sigma - self.S_d @ ed",
        "motion/test_simulate.py::test_sampled_loop_of_a_linear_mechanism_is_that_of_control",
    ),
    Fault(
        "motion/coordinates_form.py",
        "return z - factors.solve(residual + left_side), self",
        "return z, self",
        "motion/test_simulate.py -k pendulum",
        slow=True,
    ),
    Fault("motion/motion.py", "form = under_inputs(model, undriven, u)", "form = undriven", "motion/test_loop.py"),
    Fault("motion/motion.py", "else -constant @ moving", "else constant @ moving", "motion/test_observed.py"),
    Fault(
        "motion/motion.py",
        "power = (other + reactions) @ coordinates.v - (",
        "power = (other + reactions) @ coordinates.v + (",
        "motion/test_observed.py",
    ),
    Fault(
        "motion/motion.py",
        "elastic + drive.loads.prestress @ stored",
        "elastic - drive.loads.prestress @ stored",
        "motion/test_observed.py",
    ),
    Fault(
        "motion/simulate.py",
        "initial.xd if isinstance(initial, Configuration) else zero_rates",
        "zero_rates",
        "motion/test_simulate.py -k begins_with",
    ),
    Fault("motion/integrate.py", "if problem.still or not", "if True or not", "motion/test_start.py"),
    Fault(
        "linear/stress.py",
        "edges[1:-1] + BESIDE",
        "edges[1:-1] - BESIDE",
        "linear/test_stress.py -k both_sides",
        slow=True,
    ),
    Fault("linear/stress.py", "PLACES_OF_SERIES if", "PLACES if", "linear/test_stress.py -k between_the_ends"),
    Fault("linear/stress.py", "PARTS / np.sqrt", "2 / np.sqrt", "linear/test_stress.py -k groove", slow=True),
    Fault(
        "linear/stress.py", "2 if points else", "2 if points is None else", "linear/test_stress.py -k groove", slow=True
    ),
    Fault(
        "paths/imperfection.py",
        '("incremental", True)',
        '("incremental", False)',
        "paths/test_stops.py -k modes_of_an",
        slow=True,
    ),
    Fault(
        "motion/start.py",
        "elsewhere or np.any(np.abs(rates",
        "elsewhere and np.any(np.abs(rates",
        "motion/test_start.py -k hangs_on",
        slow=True,
    ),
    Fault(
        "build/dofs.py",
        "labels=dataclasses.replace(model.labels, found=tuple(map(str, (*x, *e))))",
        "labels=model.labels",
        "motion/test_start.py -k hangs_on",
        slow=True,
    ),
    Fault(
        "motion/start.py",
        "longest, 1.0) / CONFIGURATION_STEP)",
        "longest, 1.0) / 1e9)",
        "motion/test_start.py -k turned_far",
    ),
    Fault(
        "motion/start.py",
        'else ("x", "e", "temperature")',
        'else ("x", "e")',
        "motion/test_start.py -k heat",
        slow=True,
    ),
    Fault(
        "motion/start.py",
        "return jnp.concatenate(values), jnp.concatenate(rates)",
        "return (jnp.concatenate(values),)",
        "motion/test_start.py -k left_alone",
    ),
    Fault(
        "motion/start.py",
        "state.w * reduced.sizes)",
        "0.0 * state.w)",
        "motion/test_start.py -k values_are_kept",
        slow=True,
    ),
    Fault(
        "motion/integrate.py",
        "reached = reached | met",
        "reached = jnp.array(True)",
        "motion/test_start.py -k assembled",
        slow=True,
    ),
    Fault(
        "motion/integrate.py",
        "result[jnp.argmax(over)], RESULTS.successful)",
        "result[-1], RESULTS.successful)",
        "motion/test_loop.py",
    ),
    Fault(
        "motion/solve.py",
        "jnp.where(ends, RESULTS.successful,",
        "jnp.where(ends, result,",
        "compilation/test_captured.py -k event",
    ),
    Fault("motion/solve.py", "jnp.where(lost, RESULTS.event_not_found, result)", "result", "motion/test_events.py"),
    Fault("motion/solve.py", '"step_ts": span.stops', '"step_ts": None', "motion/test_sudden.py"),
    Fault(
        "motion/steps_again.py", "(limit - 1) // room * room", "0 * limit", "motion/test_solve.py -k long", slow=True
    ),
    Fault(
        "motion/steps_again.py",
        "jnp.add, by_state, of_still",
        "lambda own, _: own, by_state, of_still",
        "motion/test_solve.py -k by_hand",
    ),
    Fault("motion/steps_again.py", "m.end, (by_end, by_z1)", "m.end, m.end", "motion/test_solve.py -k by_hand"),
    Fault(
        "motion/steps_again.py",
        "jnp.where(lost, jnp.nan, leaf)",
        "leaf",
        "motion/test_solve.py -k not_reached",
        slow=True,
    ),
    Fault("motion/steps_again.py", "ends + (stop - was)", "ends", "motion/test_solve.py -k stops", slow=True),
    Fault("motion/steps_again.py", "ends + (span.t0 - known.t0)", "ends", "motion/test_solve.py -k by_hand"),
    Fault(
        "motion/rosenbrock.py",
        "equations.settle(t1, outcome.end, outcome.mass)",
        "outcome.end",
        "motion/test_projected.py",
    ),
    Fault("motion/events.py", "return (passed | (count > 1))", "return (count > 1)", "motion/test_events.py"),
    Fault("motion/events.py", "(passed | (count > 1)) & shorter", "passed & shorter", "motion/test_events.py"),
    Fault("motion/events.py", "return after & ~before", "return before & ~after", "motion/test_events.py"),
    Fault(
        "motion/events.py",
        "if way else (before > 0) & (after <= 0)",
        "if not way else (before > 0) & (after <= 0)",
        "motion/test_events.py",
    ),
    Fault("motion/events.py", "way is not False and ", "", "motion/test_events.py"),
    Fault("motion/step_control.py", "refused = refused | kinked", "refused = kinked", "motion/test_events.py"),
    Fault(
        "motion/solve.py",
        "jnp.where(regular, result, RESULTS.singular_mass)",
        "result",
        "motion/test_solve.py -k failures",
    ),
    Fault("motion/solver.py", "equations_of(terms).settle(t1, y1), error", "y1, error", "motion/test_projected.py"),
    Fault(
        "motion/stages.py",
        "gamma=0.21193756319429014",
        "gamma=0.21193757319429014",
        "motion/test_rosenbrock.py",
    ),
    Fault(
        "motion/stages.py",
        "jnp.sum(rows, axis=0), bent",
        "0 * jnp.sum(rows, axis=0), bent",
        "motion/test_solve.py -k steps_themselves",
        slow=True,
    ),
    Fault(
        "motion/generalized_alpha.py",
        "gamma = 0.5 + force_share",
        "gamma = 0.6 + force_share",
        "motion/test_fixed_steps.py",
    ),
    Fault(
        "motion/step_control.py",
        "(t1 - t0) * jnp.abs(y_error.w)",
        "0 * jnp.abs(y_error.w)",
        "motion/test_solve.py -k states",
        slow=True,
    ),
    Fault(
        "motion/reduced_form.py",
        "at.C0 + at.D0, at.M0",
        "at.D0, at.M0",
        "motion/test_simulate.py -k negative_lumped",
        slow=True,
    ),
    Fault(
        "motion/moving_matrices.py",
        "+ 2 * by_x.mass @ turning",
        "+ by_x.mass @ turning",
        "motion/test_linearized.py -k not_its_angle",
    ),
    Fault(
        "motion/moving_matrices.py",
        "g0 = z.T @ (curvature - loads) @ z",
        "g0 = z.T @ (curvature + loads) @ z",
        "motion/test_linearized.py",
    ),
    Fault(
        "motion/moving_matrices.py",
        "by_x.by_x - curvature) @ z",
        "by_x.by_x) @ z",
        "motion/test_linearized.py -k not_its",
    ),
    Fault(
        "motion/energy_keeping.py",
        "last = 2 * (s_1 - s_0) / h - rate",
        "last = (s_1 - s_0) / h",
        "motion/test_fixed_steps.py",
    ),
    # Elements.
    Fault(
        "elements/planar.py",
        "damping.EA / l0, *beams.bending",
        "damping.EIy / l0, *beams.bending",
        "elements/test_damping.py",
    ),
    Fault("elements/spatial.py", "(p + center @ axes)", "(p + axes @ center)", "elements/test_bodies.py"),
    Fault("elements/planar.py", "[p + axes @ center,", "[p - axes @ center,", "elements/test_bodies.py"),
    Fault(
        "elements/section.py",
        "holds(nu < 0.5)",
        "holds(nu <= 0.5)",
        "build/test_builder.py -k sections_that_cannot_be",
    ),
    Fault("build/step.py", "axis=0) + parallel -", "axis=0) -", "build/test_step.py -k parallel"),
    Fault(
        "mechanics/blocks.py",
        'element_properties["damping"].time * stiffness',
        'element_properties["damping"].time**2 * stiffness',
        "elements/test_materials.py -k damping_is",
    ),
    Fault(
        "linear/stress.py",
        "jnp.max(self.von_mises, axis=-1) / self._limit(quantity)",
        'jnp.max(self.von_mises, axis=-1) / self._limit("strength")',
        "elements/test_materials.py -k by_name",
    ),
    Fault(
        "elements/spatial.py",
        "bending_z = beams.bending_damping(d.EIz, d.GAy",
        "bending_z = beams.bending_damping(d.EIy, d.GAy",
        "elements/test_damping.py",
    ),
    Fault("elements/beams.py", "turning = length_or_zero(ref)", "turning = 0.0", "elements/test_bodies.py -k plate"),
    Fault("elements/beams.py", "(1 + phi) ** 2)", "(1 + phi))", "elements/test_damping.py -k share"),
    Fault(
        "build/idle.py", 'ELASTIC if key == "section" else', '(*ELASTIC, "damping") if True else', "build/test_idle.py"
    ),
    Fault("elements/spatial.py", "[d.EA / l0, d.GIt / l0**3", "[d.EA / l0, d.GIt / l0", "elements/test_damping.py"),
    Fault(
        "elements/spectral_planar.py",
        "damping, section, order, _length(ref, curvature), CLOSURE, _names(shear)",
        'damping, section, order, _length(ref, curvature), CLOSURE, ("EA", "EA")',
        "elements/test_damping.py",
    ),
    Fault(
        "elements/spectral_spatial.py",
        "damping, section, order, _length(ref, curvature, order), 6, _names(shear)",
        'damping, section, order, _length(ref, curvature, order), 6, ("EA", "GIt", "EIz", "EIy", *_names(shear)[4:])',
        "elements/test_damping.py",
    ),
    Fault(
        "elements/general.py",
        "about_center + mass * jnp.outer(center, center)",
        "about_center",
        "elements/test_general.py -k moments_of_mass",
    ),
    Fault("elements/general.py", ".set(-jyz)", ".set(jyz)", "elements/test_general.py -k moments_of_mass"),
    Fault(
        "elements/general.py", "[0, 3, 4, 5, 1, 2]", "[0, 1, 2, 3, 4, 5]", "elements/test_general.py -k same_stiffness"
    ),
    Fault(
        "elements/general.py",
        "1 / (2.0 * np.arange(order) + 1)",
        "1 / (np.arange(order) + 1.0)",
        "elements/test_general.py -k same_stiffness",
    ),
    Fault(
        "elements/general.py",
        "np.maximum(places, places.T)",
        "places",
        "elements/test_general.py -k same_stiffness",
    ),
    Fault(
        "elements/general.py",
        "return faults + _faults_of_stiffness(stiff, STRAINS[size])",
        "return faults",
        "elements/test_general.py -k impossible_stiffness",
    ),
    Fault(
        "elements/general.py",
        "if not shear and stiff.shape[0] == 6:",
        "if False:",
        "elements/test_general.py -k shear_must_fit",
    ),
    Fault(
        "workbench/mirror.py",
        '"shear_z", "twist", "curvature_y"',
        '"shear_z", "twist", "curvature_z"',
        "workbench/test_mirror.py -k other_signs",
    ),
    Fault(
        "elements/spectral_planar.py",
        "(vectors), block_diag(*sums)",
        "(vectors), block_diag(sums[0], 0.0 * sums[1])",
        "elements/test_damping.py -k spectral_beam_that_turns",
    ),
    Fault(
        "elements/spectral_planar.py",
        "block_diag(*sums)",
        "block_diag(sums[0], jnp.diag(jnp.diag(sums[1])))",
        "elements/test_spectral.py -k timoshenko",
        slow=True,
    ),
    Fault(
        "elements/spectral_planar.py", ", pulls) + turning", ", pulls)", "linear/test_stress.py -k falls_about_a_hinge"
    ),
    Fault(
        "elements/spectral_spatial.py",
        '"Jx", "Jy", "Jz", "Jyz"',
        '"Jx", "Jz", "Jy", "Jyz"',
        "elements/test_damping.py -k spectral_beam_that_turns",
    ),
    # Chains in motion.
    Fault(
        "motion/chain_form.py",
        "self._pulled(self.stiffness, strain) + self._pulled(self.damping, ed)",
        "self._pulled(self.stiffness, strain)",
        "motion/test_chain.py -k what_follows",
        slow=True,
    ),
    Fault(
        "motion/coordinates_form.py",
        "acting.force - self.applied(t, at.x), at",
        "acting.force + self.applied(t, at.x), at",
        "motion/test_chain.py -k what_follows",
        slow=True,
    ),
    Fault("mechanics/sparse_order.py", "np.array_equal(known, entries)", "True", "mechanics/test_sparse_order.py"),
    Fault(
        "mechanics/sparse_order.py",
        "self.too_large = True",
        "self.too_large = False",
        "motion/test_net.py -k memory",
    ),
    Fault(
        "statics/sparse.py",
        "functools.partial(on_host_thread, functools.partial(_answer, **how))",
        "functools.partial(_answer, **how)",
        "statics/test_sparse.py -k thread",
    ),
    Fault(
        "paths/sparse_critical.py",
        'with explained_failures("Take other steps (step)"):\n        soft',
        "if True:\n        soft",
        "paths/test_sparse_path.py -k named",
        slow=True,
    ),
    Fault(
        "statics/solver_choice.py",
        "if count is not None and answers < count:",
        "if False:",
        "linear/test_states.py -k fewer_answers",
    ),
    Fault(
        "linear/about.py",
        "if any(is_concrete(a) and not is_concrete(b) for a, b in pairs):",
        "if False:",
        "linear/test_states.py -k traced_numbers",
    ),
    Fault(
        "identification/modal_data.py",
        "upper - solution.x) < 0.01",
        "upper - solution.x) < 0.0",
        "identification/test_modal_data.py -k bound",
    ),
    Fault(
        "workbench/session.py",
        "same = [name for name in self._shown if name not in changed]",
        "same: list[str] = []",
        "workbench/test_session.py -k leaves_as_it_was",
    ),
    Fault("linear/buckling.py", "raise refused from None", "pass", "paths/test_sparse_path.py -k by_name", slow=True),
    Fault(
        "linear/sparse_solve.py",
        "functools.partial(on_host_thread, finite)",
        "finite",
        "linear/test_sparse.py -k thread",
    ),
    Fault(
        "compilation/host.py",
        "list(map(np.array, numbers))",
        "list(map(np.asarray, numbers))",
        "compilation/test_host.py -k copies",
    ),
    Fault("compilation/host.py", "if number.shape != place.shape", "if False", "compilation/test_host.py -k fails"),
    Fault("compilation/host.py", ', casting="same_kind"', ', casting="unsafe"', "compilation/test_host.py -k fails"),
    Fault(
        "compilation/host.py",
        "return frame.contents.interface.contents.make_error(",
        "return None and frame.contents.interface.contents.make_error(",
        "compilation/test_host.py -k fails",
    ),
    Fault(
        "compilation/host.py",
        "np.asarray(a, s.dtype)",
        "0 * np.asarray(a, s.dtype)",
        "compilation/test_host.py -k once",
    ),
    Fault("compilation/host.py", 'jax.default_backend() != "cpu" or ', "", "compilation/test_host.py -k other"),
    Fault("compilation/host.py", "if Run.interrupted:", "if False:", "compilation/test_host.py -k interruption"),
    Fault(
        "compilation/host.py", "self._before(signal.SIGINT, None)", "pass", "compilation/test_host.py -k interruption"
    ),
    Fault(
        "compilation/host.py", "if is_within_run() else None", "if True else None", "compilation/test_host.py -k kind"
    ),
    Fault(
        "compilation/host.py",
        "hashlib.blake2b(text, digest_size=16).hexdigest()",
        '"always"',
        "compilation/test_host.py -k beyond",
    ),
    Fault("math/linear.py", 'b: Float[Array, "*#n j k"]', 'b: Float[Array, "*#n k j"]', "test_shapes.py", slow=True),
    Fault(
        "compilation/kept.py",
        "        host.program_on_disk(program)\n",
        "",
        "compilation/test_kept.py -k calls_the_host",
    ),
    Fault(
        "compilation/kept.py",
        '"jax_default_device", None) is not None',
        '"jax_default_device", None) is ...',
        "compilation/test_settings.py -k chosen",
    ),
    Fault("compilation/kept.py", 'os.environ.get("EQX_ON_ERROR")', "None", "compilation/test_kept.py -k key"),
    Fault(
        "compilation/kept.py",
        "[str(jax.typeof(leaf)) for leaf in leaves]",
        "len(leaves)",
        "compilation/test_settings.py -k from_disk",
    ),
    Fault("compilation/kept.py", '"jax_debug_nans", ', "", "compilation/test_settings.py -k none"),
    Fault(
        "compilation/compile.py",
        ", _is_anywhere(leaves), ",
        ", True, ",
        "compilation/test_settings.py -k another_device",
    ),
    Fault(
        "compilation/host.py", "and _calls_host(program)", "and False", "compilation/test_host.py -k part_was_traced"
    ),
    Fault("compilation/kept.py", "folder is None or", "False or", "compilation/test_settings.py -k nothing"),
    Fault(
        "compilation/kept.py",
        'not jax.config.values["jax_enable_compilation_cache"]',
        "False",
        "compilation/test_settings.py -k nothing",
    ),
    Fault(
        "compilation/kept.py", "if module.__file__ and", "if False and", "compilation/test_kept.py -k may_have_changed"
    ),
    Fault(
        "compilation/kept.py",
        '"EQX_ON_ERROR"), jax.default_backend()',
        '"EQX_ON_ERROR")',
        "compilation/test_kept.py -k key",
    ),
    Fault("compilation/kept.py", "mkdir(mode=0o700, ", "mkdir(", "compilation/test_kept.py -k users_alone"),
    Fault("setup.py", '(path, path / "programs")):', "(path,)):", "compilation/test_kept.py -k folder_of_programs"),
    Fault(
        "mechanics/sparse_order.py",
        'return {"unknowns": self._unknowns, "count": self.count}',
        "return vars(self)",
        "compilation/test_kept.py -k calls_the_host",
    ),
    Fault(
        "mechanics/sparse_order.py",
        "solution if fits else on_host_thread(factors.solve, right, transposed)",
        "solution",
        "mechanics/test_sparse_order.py -k fit",
    ),
    Fault("math/sparse.py", "if known is not ordering", "if known is None", "math/test_dissection.py -k often"),
    Fault("cli.py", "os.environ.setdefault(", "os.environ.get(", "test_cli.py -k waits"),
    Fault("math/dissection.py", "order[::-1]", "order", "math/test_dissection.py -k grow"),
    Fault("math/dissection.py", "(levels == middle) & beyond", "beyond", "math/test_dissection.py"),
    Fault("math/dissection.py", "np.where(even, sizes,", "np.where(~even, sizes,", "math/test_dissection.py -k grow"),
    Fault("math/sparse.py", "other.fill < factors.fill", "True", "math/test_dissection.py -k often"),
    Fault("math/sparse.py", "        matrix.sort_indices()\n", "", "statics/test_sparse.py -k units_make", slow=True),
    Fault("math/sparse.py", "real + 1j * imag[0]", "real - 1j * imag[0]", "mechanics/test_sparse_order.py"),
    Fault(
        "motion/integrator.py",
        "by_diffrax = jumps is not None or integrator.event is not None",
        "by_diffrax = False",
        "motion/test_large_derivatives.py -k jumps",
    ),
    Fault(
        "compilation/host.py",
        "called.defjvp(_refused)",
        "called.defjvp(lambda at, _: (called(*at), called(*at)))",
        "motion/test_large_derivatives.py -k second",
        slow=True,
    ),
    Fault(
        "motion/integrator.py",
        "if why is None and not is_concrete(top):",
        "if False:",
        "motion/test_large_derivatives.py -k serves",
    ),
    Fault(
        "mechanics/sparse_order.py",
        "factors.answer(right, transposed, refine=False)",
        "factors.answer(right, False, refine=False)",
        "motion/test_large_derivatives.py -k solutions",
    ),
    Fault(
        "mechanics/sparse_order.py",
        "order.product(pieces, z) + diagonal * z",
        "order.product(pieces, z)",
        "motion/test_large_derivatives.py -k solutions",
    ),
    Fault(
        "motion/chain_form.py",
        "(residual_sizes[2] <= CHAIN",
        "(residual_sizes[1] <= CHAIN",
        "motion/test_net.py -k milligram",
    ),
    Fault(
        "mechanics/tree.py",
        "turns * CONJUGATE if spatial",
        "turns if spatial",
        "motion/test_tree_form.py -k in_space",
    ),
    # Ends of spectral beams that are computed.
    Fault("mechanics/tree.py", "jnp.where(back, inverse, turns)", "turns", "motion/test_tree_form.py -k in_space"),
    Fault(
        "motion/tree_form.py",
        "sum(forces, -self.applied(t, at.x))",
        "sum(forces)",
        "motion/test_tree_form.py -k in_space",
    ),
    Fault(
        "motion/tree_form.py",
        "jnp.pad(to.x[beams.c], columns)",
        "jnp.pad(0 * to.x[beams.c], columns)",
        "motion/test_tree_form.py -k held",
        slow=True,
    ),
    Fault(
        "motion/tree_form.py",
        "along = along + acting.sigma[beams.e]",
        "along = along",
        "motion/test_tree_form.py -k in_space",
    ),
    Fault(
        "motion/tree_form.py",
        "edd = acting.kinematics.edd + strain.edd",
        "edd = strain.edd",
        "motion/test_tree_form.py",
    ),
    Fault(
        "mechanics/tree.py",
        "if visit.beam.block in blocks}",
        "if visit.beam.block not in blocks}",
        "motion/test_tree_form.py -k last_ends",
    ),
    Fault(
        "mechanics/tree.py",
        'read.intersection(_at(visit, "turns")) for visit',
        'read.intersection(_at(visit, "ends")) for visit',
        "motion/test_tree_form.py -k last_ends",
    ),
    Fault(
        "motion/tree_beams.py",
        "sdd = sdd - jax.jvp",
        "sdd = sdd + jax.jvp",
        "motion/test_tree_form.py -k in_space",
    ),
    Fault(
        "motion/tree_beams.py",
        "by_x = self._derived_forces(x, weights, way)",
        "by_x = 0 * self._derived_forces(x, weights, way)",
        "motion/test_tree_form.py -k tangent",
        slow=True,
    ),
    # Large mechanisms: what is unstable, far apart or fails.
    Fault(
        "statics/stable.py",
        "if size < -NEGATIVE_SHARE * (np.abs(motion)",
        "if size < -1e9 * (np.abs(motion)",
        "statics/test_stable.py -k elements_own",
    ),
    Fault(
        "statics/sparse.py",
        "np.array(finite and is_unstable(elements, symmetric))",
        "np.array(False)",
        "design/test_unstable.py -k sparse_factors",
    ),
    Fault(
        "linear/linearize.py",
        "collect(RESULTS.unstable_state)",
        "pass",
        "design/test_unstable.py -k sparse_factors",
    ),
    Fault(
        "numerical_limits.py",
        "EIGENVALUES_APART = 1e4",
        "EIGENVALUES_APART = 1e40",
        "linear/test_sparse.py -k round_off_of",
    ),
    Fault(
        "linear/sparse_solve.py",
        "with contextlib.suppress(AnalysisError), one_thread():",
        "with one_thread():",
        "linear/test_sparse.py -k stops_no_other",
    ),
    Fault(
        "linear/modes.py",
        "bool(np.all(values[:1] > 0)), int(",
        "bool(values[0] > 0), int(",
        "linear/test_sparse.py -k nothing_moves",
    ),
    Fault("linear/sparse_poles.py", "if not every:", "if False:", "linear/test_sparse.py -k nothing_moves"),
    Fault("linear/sparse_buckling.py", "if n <= h:", "if False:", "linear/test_sparse.py -k nothing_moves"),
    Fault(
        "mechanics/blocks.py",
        "x = jnp.concatenate(x) if isinstance(x, list) else x",
        "x = x",
        "motion/test_tree_form.py -k users_own",
        slow=True,
    ),
    Fault("compilation/program.py", "level.get(v, 0) > i", "level.get(v, 0) > i + 1", "compilation/test_program.py"),
    Fault(
        "compilation/program.py",
        "carried[i] = [v for v in read if level.get(v) == i]",
        "carried[i] = [v for v in read if level.get(v, i) <= i]",
        "compilation/test_program.py",
    ),
    # Sections that vary along a spectral beam.
    Fault(
        "elements/spectral.py",
        "return 1.0 / jnp.where(stiff > 0, stiff, 1.0)",
        "return jnp.where(stiff > 0, stiff, 1.0)",
        PROFILES,
    ),
    Fault("elements/spectral.py", "np.tri(m, k=-1)", "np.tri(m, k=0)", PROFILES),
    Fault(
        "elements/spectral.py",
        "jnp.minimum(ends, end)",
        "ends * end",
        "elements/test_profile.py -k shape_of",
    ),
    Fault(
        "elements/profile.py",
        "jnp.asarray(place > b, int)",
        "jnp.asarray(place < b, int)",
        "elements/test_profile.py -k shape_of",
    ),
    Fault("elements/profile.py", "uneven or heavy:", "uneven:", "elements/test_profile.py -k refused_by_name"),
    Fault(
        "elements/profile.py",
        '(*STIFF, "mass")]).reshape',
        '(*["EIy"] * 4, "mass")]).reshape',
        "elements/test_profile.py -k refused_by_name",
    ),
    Fault("elements/sections.py", "(_by_series if", "(torsion_series if", "design/test_possible.py -k checks_of_all"),
    Fault(
        "linear/stress.py",
        "jnp.where(anew[:, None], powers, 0.0)",
        "powers",
        "linear/test_stress.py -k both_sides",
        slow=True,
    ),
    Fault("blocks/site.py", "if self.element is not None:", "if False:", "blocks/test_blocks.py -k a_given"),
    Fault(
        "elements/spectral_planar.py",
        "return slopes + (self.rule.shears",
        "return slopes + 2 * (self.rule.shears",
        "linear/test_stress.py -k elastica",
        slow=True,
    ),
    Fault(
        "elements/spectral.py",
        "if not counted and not all(holds(as_floats(number) <= 0) for number in stated):",
        "if False:",
        "elements/test_spectral.py -k neither",
    ),
    Fault(
        "elements/leaf_planar.py",
        "return check_shear(False, section_rigidities(",
        "return [] and check_shear(False, section_rigidities(",
        "elements/test_spectral.py -k neither",
    ),
    Fault(
        "build/builder.py",
        "copied(as_known(value))",
        "copied(value)",
        "design/test_possible.py -k known_numbers",
        slow=True,
    ),
    Fault(
        "build/builder.py",
        "with jax.core.eval_context():\n            faults",
        "if True:\n            faults",
        "design/test_possible.py -k known_numbers",
        slow=True,
    ),
    Fault(
        "build/clamps.py",
        "jax.ensure_compile_time_eval() if",
        "contextlib.nullcontext() if",
        "design/test_possible.py -k known_numbers",
        slow=True,
    ),
    Fault(
        "design/evaluate.py",
        "impossible |= ~fine & fine[0]",
        "impossible |= ~fine & ~fine[0]",
        "design/test_possible.py -k block",
    ),
    Fault(
        "collecting.py",
        "current[0] == jax.extend.core.get_opaque_trace_state()",
        "current[0]",
        "design/test_possible.py -k conditions",
    ),
    Fault("blocks/site.py", "above=0, fault=ModelError", "above=0", "design/test_possible.py -k block"),
    Fault("blocks/pivots.py", "holds(half_angle < np.pi / 2)", "holds(True)", "design/test_possible.py -k block"),
    Fault(
        "elements/profile.py",
        "> SMOOTH_COMPLIANCE * means",
        "> 1e9 * means",
        "elements/test_profile.py -k refused_by_name",
    ),
    Fault(
        "elements/profile.py",
        "gauss(NODES), fewer,",
        "gauss(NODES), gauss(NODES),",
        "elements/test_profile.py -k smooth_groove",
    ),
    Fault("elements/sections.py", "neck + 2 * across * _rise", "neck + across * _rise", PROFILES),
    Fault(
        "linear/stress.py",
        "s.at(place, length)",
        "s.at(0.0, length)",
        "elements/test_profile.py -k stress_and",
        slow=True,
    ),
    Fault(
        "elements/beams.py", "* beam_length(ref) * CUBIC_MASS,", "* CUBIC_MASS,", "elements/test_drag.py -k rayleigh"
    ),
    Fault("elements/beams.py", "q - ref.q, turned[1]", "q - ref.q, turned[0]", "elements/test_drag.py -k rayleigh"),
    Fault("compilation/recompiled.py", "number == THIRD", "number >= THIRD", "compilation/test_recompiled.py"),
    Fault("compilation/recompiled.py", "and not _within.get()", "", "compilation/test_recompiled.py"),
    Fault("elements/beams.py", "phi = 12 * shear", "phi = 6 * shear", "elements/test_laws.py -k sway"),
    Fault("elements/beams.py", "(60 * l0)", "(30 * l0)", "elements/test_laws.py -k shortening"),
    Fault("elements/spatial.py", "twist = twist + coupled", "", "elements/test_laws.py -k integrated_rods"),
    Fault(
        "linear/damping.py",
        "return jnp.asarray(losses)",
        "return losses",
        "linear/test_damping.py -k serve_within",
        slow=True,
    ),
    Fault("compilation/kept.py", " + text)", ")", "compilation/test_kept.py -k text_of_the_package"),
    Fault(
        "compilation/kept.py",
        "map(importlib.metadata.version, LIBRARIES)",
        "LIBRARIES",
        "compilation/test_kept.py -k versions_of",
    ),
    Fault("compilation/compile.py", "_programs_left -= 1", "pass", "compilation/test_room.py"),
    Fault("compilation/compile.py", "if _programs_left < 0:", "if True:", "compilation/test_room.py"),
    Fault("compilation/compile.py", "int(FULL * most - used)", "int(most - used)", "compilation/test_room.py"),
    Fault(
        "elements/spatial.py",
        "ref.rot_q, near[0], axis)[:1]",
        "ref.rot_q, near[0], axis)[1:2]",
        "elements/test_joints.py",
    ),
    Fault(
        "elements/joints.py",
        "TURNED_TWICE = 2.0 *",
        "TURNED_TWICE = 1.0 *",
        "elements/test_joints.py -k about_the_axis",
    ),
    Fault(
        "elements/joints.py", "along - pitch * turn", "along + pitch * turn", "elements/test_transmission.py -k screw"
    ),
    Fault(
        "elements/shared_laws.py",
        "mesh_stiffness(ref=ref, stiffness=damping)",
        "diagonal_damping(2)(ref=ref, damping=damping)",
        "elements/test_damping.py -k mesh",
    ),
    Fault(
        "elements/shared_laws.py",
        "law(e[0], ed[0], ",
        "law(e[0], -ed[0], ",
        "elements/test_laws_of_users.py",
    ),
    Fault(
        "elements/transmission.py",
        "start - radius_p * e[1] + radius_q",
        "start + radius_p * e[1] + radius_q",
        "elements/test_transmission.py -k belt",
    ),
    Fault(
        "elements/transmission.py",
        "turn_p + ratio * turn_q",
        "turn_p - ratio * turn_q",
        "elements/test_transmission.py -k planet",
    ),
    Fault(
        "elements/surface.py",
        "sigma = n / area + 6 * (my / thickness * z - mz",
        "sigma = n / area + 6 * (my / thickness * z + mz",
        "elements/test_sections.py -k balances",
    ),
    Fault(
        "elements/surface.py", "parabola = 1.5 / area", "parabola = 1.0 / area", "elements/test_sections.py -k balances"
    ),
    Fault(
        "elements/surface.py",
        "torsion = t / (2 * between_y",
        "torsion = t / (between_y",
        "elements/test_sections.py -k thin_box",
    ),
    # What is below the mechanics: arrays and compiled code.
    Fault("math/rotation.py", "LBAR[_i, _k, _j] = -1.0, 1.0", "LBAR[_i, _k, _j] = 1.0, -1.0", "math/test_rotation.py"),
    Fault("math/rotation.py", "turn * jnp.round(", "turn * jnp.floor(", "elements/test_joints.py"),
    Fault(
        "math/rotation.py",
        "np.transpose(LBODY, (2, 0, 1))",
        "np.transpose(LBAR, (2, 0, 1))",
        "math/test_rotation.py -k relative",
    ),
    Fault("math/rotation.py", "coefficients[:, 1:] @ axes", "coefficients[:, 1:]", "math/test_rotation.py -k relative"),
    Fault(
        "math/rotation.py", "vector @ QUARTER @ change", "change @ QUARTER @ vector", "math/test_rotation.py -k polar"
    ),
    Fault(
        "math/rotation.py", "rotation_matrix(ref_rot).T @ v", "rotation_matrix(ref_rot) @ v", "math/test_rotation.py"
    ),
    Fault(
        "mechanics/tree.py",
        "base = compose(base, earlier(poses.before[0]))",
        "base = compose(base, earlier(poses.before[-1]))",
        "motion/test_tree_form.py -k in_space",
    ),
    Fault("math/rotation.py", "(CROSS @ ey) @ ex", "-(CROSS @ ey) @ ex", "math/test_rotation.py -k initial_frame"),
    Fault(
        "math/rigid.py",
        "c1 = -_bracket(a1, a2)",
        "c1 = _bracket(a1, a2)",
        "elements/test_spectral.py -k princeton",
        slow=True,
    ),
    Fault(
        "math/quadrature.py",
        "/ (4.0 * np.arange(order) + 2)",
        "/ (2.0 * np.arange(order) + 1)",
        "math/test_quadrature.py",
    ),
    Fault("math/linear.py", "pivots > 10 * n", "pivots > -10 * n", "math/test_linear.py -k definite"),
    Fault(
        "math/linear.py",
        "change = da - mu[None, :] * db",
        "change = da",
        "math/test_linear.py -k derivatives_of_simple",
    ),
    Fault(
        "math/linear.py",
        "matrix = factors.matrix.T if transposed",
        "matrix = factors.matrix if transposed",
        "math/test_linear.py -k derivative_of_a",
    ),
    Fault("math/derivative.py", "DIFFERENTIATED = 2", "DIFFERENTIATED = 1", "statics/test_configuration.py"),
    Fault(
        "control/harmonic.py",
        "jnp.abs(turned.T)) < TURN",
        "jnp.abs(turned.T)) < 1.0",
        "control/test_frequency_response.py -k almost_without_mass",
        slow=True,
    ),
    Fault(
        "control/harmonic.py",
        "vectors - vectors @ jnp.triu(",
        "vectors - 0.0 * vectors @ jnp.triu(",
        "control/test_frequency_response.py -k almost_without_mass",
        slow=True,
    ),
    Fault(
        "trajectory/linear_along.py", "not is_concrete(self.A)", "False", "trajectory/test_linear_along.py -k refused"
    ),
    Fault(
        "math/linear.py",
        "return _solution(self, right, False)",
        "return _by_factors(self, right, False)",
        "design/test_sensitivities.py -k loaded_equilibrium",
    ),
    Fault(
        "math/subspace.py",
        "if size <= threshold:",
        "if False:",
        "math/test_subspace.py",
    ),
    Fault("math/subspace.py", "np.argsort(-np.array(sizes)", "np.argsort(np.array(sizes)", "math/test_subspace.py"),
    Fault(
        "math/subspace.py",
        "if values.size), default=0.0)",
        "if values.size), default=0.0) / 100",
        "math/test_subspace.py",
    ),
    Fault("build/dofs.py", "and determines(effects)", "and False", "build/test_dofs.py -k of_a_chain"),
    Fault(
        "mechanics/deformation.py",
        "(rows, columns)), shape=shape)",
        "(rows, columns % 700)), shape=shape)",
        "build/test_dofs.py",
    ),
    Fault(
        "compilation/program.py",
        "first.setdefault(value, v) for v",
        "v for v",
        "compilation/test_program.py -k what_several",
    ),
    Fault(
        "mechanics/prepared.py",
        "return lambda x, ref, properties: function(x, ref, deforming(block, properties))",
        "return lambda x, ref, properties: function(x, x, deforming(block, properties))",
        "elements/test_leaf.py -k fold_beside",
        slow=True,
    ),
    Fault(
        "build/idle.py",
        "if entry in missing] if idle else []",
        "if entry in missing] if not idle else []",
        "build/test_idle.py",
    ),
    Fault(
        "build/idle.py",
        "(without == 0) & (beside != 0)",
        "(beside != 0)",
        "build/test_idle.py",
    ),
    Fault(
        "build/idle.py",
        "or np.any(resisted[list(free)])",
        "or not np.any(resisted[list(free)])",
        "build/test_idle.py",
    ),
    Fault(
        "paths/imperfection.py",
        "start = None if start is None else (q + start[0], start[1])",
        "start = start",
        "paths/test_stops.py -k starts_in_its_shape",
        slow=True,
    ),
    Fault(
        "paths/imperfection.py",
        "start = (q, jnp.zeros_like(q)) if start is None else",
        "start = None if start is None else",
        "paths/test_stops.py -k starts_in_its_shape",
        slow=True,
    ),
    Fault(
        "paths/imperfection.py",
        "put(jnp.asarray(bent), topology.e.held, 0.0), model",
        "jnp.asarray(bent), model",
        "paths/test_stops.py -k what_is_held",
        slow=True,
    ),
    Fault(
        "fmu/save.py",
        "if start is None and system.parameters.start is None:",
        "if start is not None:",
        "fmu/test_save.py -k start_stressed",
    ),
    Fault(
        "results.py",
        "number * factor.reshape(shape) + jnp.reshape(lost",
        "number * jnp.reshape(factor.reshape(shape) + lost",
        "motion/test_events.py -k derivatives_until",
        slow=True,
    ),
    Fault(
        "motion/controllers.py",
        "return basis @ jnp.linalg.pinv(c @ basis)",
        "return basis @ (c @ basis).T",
        "control/test_loops.py -k led_back_alike",
    ),
    Fault(
        "motion/simulate.py",
        "isinstance(requested_times, jax.core.Tracer)",
        "isinstance(times, jax.core.Tracer)",
        "motion/test_events.py -k sampled_controller",
        slow=True,
    ),
    Fault(
        "build/idle.py",
        "if not is_concrete((starts, arguments)):",
        "if not is_concrete(starts):",
        "build/test_idle.py -k traced_numbers",
    ),
    Fault(
        "answers/answers.py",
        '"steps" not in mode_of(mode).needs',
        '"steps" in mode_of(mode).needs',
        "test_cli.py -k belong_to_no_path",
    ),
    Fault(
        "statics/coarse.py",
        "is_concrete(strain) and np.any",
        "is_concrete(strain) and not np.any",
        "paths/test_stops.py -k start_stressed",
        slow=True,
    ),
    Fault(
        "statics/sparse.py",
        "carried = e + jax.lax.stop_gradient(known - e)",
        "carried = e",
        "statics/test_sparse.py -k light_loads",
        slow=True,
    ),
    Fault(
        "statics/newton_search.py",
        "predicted = size * (size / self.before) ** 2",
        "predicted = size",
        "statics/test_large_deflection.py -k turns_on_the_way",
    ),
    Fault(
        "mechanics/staged.py",
        "jnp.concatenate([slopes.T @ of_shape, of_outer])",
        "jnp.concatenate([0 * slopes.T @ of_shape, of_outer])",
        "mechanics/test_staged.py",
    ),
    Fault(
        "mechanics/staged.py",
        "hessian + jnp.pad(of_inner",
        "hessian + 0 * jnp.pad(of_inner",
        "mechanics/test_staged.py",
    ),
    Fault(
        "mechanics/staged.py",
        "return jax.tree.map(lambda derivatives: derivatives[..., self._place], by_all), value",
        "return by_all, value",
        "mechanics/test_staged.py",
    ),
    Fault(
        "motion/motion.py",
        "power = power + grown @ stored",
        "power = power - grown @ stored",
        "motion/test_observed.py",
    ),
    Fault(
        "motion/loop.py",
        "inputs=len(labels.inputs),",
        "inputs=sum(len(found[kind]) for kind in found),",
        "trajectory/test_about_motion.py",
    ),
    Fault(
        "trajectory/about_motion.py",
        "    u0 = u0 + inputs_that_move(motion)\n",
        "",
        "trajectory/test_about_motion.py",
    ),
    Fault(
        "trajectory/about_motion.py",
        "[:, np.array(moving)].T / jnp.where(squares > 0, squares, 1.0)",
        "[:, np.array(moving)].T",
        "trajectory/test_about_motion.py",
    ),
    Fault(
        "trajectory/about_motion.py",
        "difference - difference[0] * (term.order == 0)",
        "difference",
        "trajectory/test_about_motion.py",
    ),
    Fault(
        "linear/buckling.py",
        "all_scaled and float(moved) > BENT",
        "not all_scaled and float(moved) > BENT",
        "linear/test_buckling.py -k as_they_are",
    ),
    Fault(
        "control/noise.py",
        "if is_concrete((undamped, poles)) and",
        "if is_concrete(undamped) and",
        "control/test_noise.py -k no_compiled",
        slow=True,
    ),
    Fault("control/noise.py", "    refuse_without_anything(lin)\n", "", "linear/test_loose.py -k neither_mass"),
    Fault(
        "linear/modes.py",
        "    refuse_without_anything(lin, damped=False)\n",
        "",
        "linear/test_loose.py -k neither_mass",
    ),
    Fault("linear/loose.py", "    if not damped:\n", "    if damped:\n", "linear/test_loose.py -k damping_alone"),
    Fault(
        "control/state_space.py",
        "        refuse_without_anything(lin)\n",
        "        pass\n",
        "linear/test_loose.py -k neither_mass",
    ),
    Fault("fmu/plant.py", "if massless := without_mass(model):", "if massless := '':", "linear/test_loose.py -k unit"),
    Fault(
        "motion/step_control.py",
        "fixed = jax.lax.stop_gradient((t0, t1))",
        "fixed = t0, t1",
        "motion/test_bends.py -k time_of_a_jump",
        slow=True,
    ),
    Fault(
        "motion/step_control.py",
        "next_t0 = next_t0 + jnp.where(keep, t1 - fixed[1], t0 - fixed[0])",
        "pass",
        "motion/test_bends.py -k time_of_a_jump",
        slow=True,
    ),
    Fault(
        "linear/buckling.py",
        "(multiplier, moved, model.parameters.increment is None and where.at is None)",
        "(multiplier, moved, model.parameters.increment is None)",
        "linear/test_buckling.py -k as_it_lies",
        slow=True,
    ),
    Fault(
        "compilation/kept.py",
        "if check == _check(path, content) else",
        "if True else",
        "compilation/test_kept.py -k flipped_bit",
    ),
    # Mechanics, checks, statics, paths.
    Fault(
        "mechanics/signals.py", "return -dfe[signal.index]", "return dfe[signal.index]", "control/test_state_space.py"
    ),
    Fault(
        "mechanics/signals.py",
        "return 2 * (lbody if local",
        "return (lbody if local",
        "control/test_signals.py -k static_gain",
    ),
    Fault(
        "mechanics/signals.py",
        "[axis] + rotation_since(reference",
        "[axis] - rotation_since(reference",
        "control/test_signals.py -k sensors",
    ),
    Fault(
        "mechanics/inertia.py", "total - jax.jvp(rate", "total + jax.jvp(rate", "linear/test_stress.py -k falls_about"
    ),
    Fault(
        "mechanics/loads.py",
        "matrix = matrix + weight_stiffness",
        "matrix = matrix - weight_stiffness",
        "elements/test_bodies.py -k weight_turns",
    ),
    Fault(
        "mechanics/loads.py",
        "if b is None else a + b",
        "if b is None else a",
        "motion/test_drive.py -k increment",
        slow=True,
    ),
    Fault(
        "mechanics/residual.py",
        "curvature = curvature - load_stiffness(",
        "curvature = curvature + load_stiffness(",
        "linear/test_compliance.py",
    ),
    Fault(
        "mechanics/stress_resultants.py",
        "else sigma + loads.prestress",
        "else sigma - loads.prestress",
        "motion/test_observed.py",
    ),
    Fault(
        "mechanics/stress_resultants.py",
        "e if free is None else e - free",
        "e if free is None else e + free",
        "mechanics/test_temperature.py::test_a_free_element_becomes_an_arc_without_stress",
        slow=True,
    ),
    Fault(
        "mechanics/deformation.py",
        "right = -excess[topology.e.given]",
        "right = excess[topology.e.given]",
        "linear/test_linearize.py",
    ),
    Fault(
        "mechanics/deformation.py",
        "product.at[first:].add(of_dof[:, dependent] @ follow)",
        "product.at[first:].add(of_dependent[:, dof].T @ follow)",
        "mechanics/test_transfer.py",
    ),
    Fault("checks/releases.py", "round(-least[k], 9)", "round(least[k], 9)", "checks/test_mobility.py"),
    Fault("checks/releases.py", "least[k], gaps[k] = 0.0,", "_, gaps[k] = 0.0,", "checks/test_releases.py -k bricard"),
    Fault("checks/releases.py", "np.any(volumes[1:]", "np.any(-volumes[1:]", "checks/test_releases.py -k bricard"),
    Fault("checks/releases.py", "    fixed -= {", "    _ = {", "checks/test_releases.py -k signal"),
    Fault("checks/mobility.py", "len(self.rows))) * self.rows[:, None]", "len(self.rows)))", "checks/test_mobility.py"),
    Fault(
        "checks/mobility.py",
        "Mobility(len(constrained) - rank, len(free) - rank",
        "Mobility(len(free) - rank, len(constrained) - rank",
        "checks/test_mobility.py",
    ),
    Fault("checks/releases.py", "if sizes[start, k] > TAKES_NO_PART and", "if", "checks/test_mobility.py"),
    Fault("statics/stable.py", "negative = values < -", "negative = values > -", "statics/test_stable.py -k signs"),
    Fault("statics/stable.py", "slogdet(k)[0] >= 0", "slogdet(k)[0] <= 0", "statics/test_stable.py -k signs"),
    Fault(
        "statics/stable.py",
        "ROUND_OFF * np.max(np.abs(values)",
        "0.0 * np.max(np.abs(values)",
        "statics/test_stable.py -k signs",
    ),
    Fault("statics/stable.py", "SHARE * resisting", "0.0 * resisting", "statics/test_stable.py -k signs"),
    Fault(
        "statics/stable.py",
        "return negative_under_constraints(tangent, factored, assembled.n) != 0",
        "return False",
        "statics/test_stable.py -k columns",
    ),
    Fault(
        "statics/equilibrium.py",
        "np.asarray(to_x) @ motions",
        "np.asarray(to_x) @ motions[:, :1]",
        "statics/test_stable.py -k counted",
    ),
    Fault(
        "statics/newton_search.py",
        "(still | (steps.tries > 0))",
        "(steps.tries >= 0)",
        "statics/test_stable.py -k columns",
    ),
    Fault(
        "spacar/read.py",
        "if words and rigid:",
        "if not words and rigid:",
        "spacar/test_read.py -k test_warning",
    ),
    Fault("statics/stroke.py", "number {unstable[0]}", "number {unstable[-1]}", "statics/test_stable.py -k follow"),
    Fault(
        "control/frequency_response.py",
        "unstable = m.moving is None and",
        "unstable = m.moving is not None and",
        "control/test_frequency_response.py -k head",
    ),
    Fault(
        "control/frequency_response.py",
        "unstable = is_unstable(",
        "unstable = not is_unstable(",
        "control/test_frequency_response.py -k column",
        slow=True,
    ),
    Fault(
        "statics/sparse.py",
        "hangs = code == RESULTS.singular_stiffness and",
        "hangs = code == RESULTS.successful and",
        "statics/test_sparse.py::test_what_hangs_is_found_inside_compiled_code_too",
    ),
    Fault(
        "statics/stable.py",
        "elastic + curved < -NEGATIVE_SHARE",
        "elastic + curved > -NEGATIVE_SHARE",
        "statics/test_stable.py -k beside",
    ),
    Fault(
        "statics/stable.py",
        "SHARE * (abs(elastic) + abs(curved))",
        "0.0 * (abs(elastic) + abs(curved))",
        "statics/test_stable.py -k beside",
    ),
    Fault(
        "math/sparse.py",
        "scale = scale / np.sqrt(np.where((largest > 0) & ~positive, largest, 1.0))",
        "pass",
        "math/test_negative_where_held.py",
    ),
    Fault(
        "linear/sparse_spectrum.py",
        ", scale[:n, None] * basis",
        ", basis",
        "linear/test_lanczos.py",
    ),
    Fault(
        "statics/configuration.py",
        "parameters.reference + share * (x - parameters.reference)",
        "x",
        "motion/test_start.py -k turned_far",
    ),
    Fault(
        "motion/integrate.py",
        "| ~jnp.all(jnp.isfinite(states.u[:, -1]), axis=1)",
        "",
        "control/test_loops.py -k event",
        slow=True,
    ),
    Fault(
        "motion/motion.py",
        "missing, count = np.arange(len(reached))[which][~reached[which]], ",
        "missing, count = [], ",
        "control/test_loops.py -k event",
        slow=True,
    ),
    Fault(
        "statics/coarse.py",
        "relaxed = e + free @ relaxing",
        "relaxed = e - free @ relaxing",
        "motion/test_start.py -k stretch",
        slow=True,
    ),
    Fault(
        "statics/coarse.py",
        "needless[0] > NEEDLESS_ENERGY * needless[1]",
        "needless[0] < NEEDLESS_ENERGY * needless[1]",
        "motion/test_start.py -k stretch",
        slow=True,
    ),
    Fault(
        "trajectory/inverse.py",
        "farthest = int(np.argmax(sizes))",
        "farthest = int(np.argmin(sizes))",
        "motion/test_start.py -k stretch",
        slow=True,
    ),
    Fault("design/evaluate.py", "({frames[-1].line})", "({frames[0].line})", "design/test_sweep.py -k by_its_line"),
    Fault("design/evaluate.py", ", traceable(subject_of(build)):", ":", "design/test_sweep.py -k by_its_line"),
    Fault(
        "design/search.py",
        "if not problem.only_targets and (missed",
        "if problem.only_targets and (missed",
        "design/test_tune.py -k wishes",
    ),
    Fault("spacar/read.py", "if free and ", "if not free and ", "spacar/test_read.py -k test_warning"),
    Fault("design/stroke.py", "int(indices[int(number) - 1])", "int(indices[-int(number)])", "test_cli.py -k by_its"),
    Fault("cli.py", 'f"{warnings}{text}"', 'f"{text}"', "design/test_study.py -k warnings_stand"),
    Fault(
        "motion/moving_matrices.py",
        "jnp.where(finite, RESULTS.successful, RESULTS.singular_mass)",
        "jnp.where(finite, RESULTS.successful, RESULTS.not_finite)",
        "trajectory/test_vibrations.py -k without_mass",
        slow=True,
    ),
    Fault(
        "statics/coarse.py",
        "np.abs(e) > ROUND_OFF * max(extent, 1.0)",
        "np.abs(e) >= 0",
        "motion/test_start.py -k as_a_whole",
        slow=True,
    ),
    Fault(
        "statics/newton_search.py",
        "jnp.any(correction.estimated != 0)",
        "jnp.any(correction.estimated < -1e300)",
        "statics/test_sparse.py -k inside_compiled",
    ),
    Fault(
        "statics/stable.py",
        "return ~jnp.all(jnp.isfinite(jnp.linalg.cholesky",
        "return jnp.all(jnp.isfinite(jnp.linalg.cholesky",
        "statics/test_stable.py -k follow",
    ),
    Fault("statics/stroke.py", "return begin, (state", "return start, (state", "statics/test_stroke.py -k pushed"),
    Fault(
        "statics/stroke.py",
        "lambda new, old: jnp.where(good, new, old)",
        "lambda new, old: new",
        "statics/test_stroke.py -k beyond",
    ),
    Fault(
        "statics/solve.py",
        "at.jacobian.T @ at.sigma - at.force)[constrained]",
        "at.jacobian.T @ at.sigma + at.force)[constrained]",
        "mechanics/test_laws.py -k reactions",
    ),
    Fault(
        "statics/newton_search.py",
        "end.softness > 1 / CRITICAL",
        "end.softness < 0",
        "statics/test_refusals.py -k bifurcation",
        slow=True,
    ),
    Fault(
        "linear/linearize.py",
        "check_stiffness(model, m.result, throw)",
        "check_stiffness(model, m.result, False)",
        "linear/test_linearize.py -k beyond",
    ),
    Fault(
        "statics/newton_search.py",
        "result=jnp.where(failed, correction.failure, s.result)",
        "result=jnp.where(failed, s.result, s.result)",
        "linear/test_linearize.py -k without_raising",
    ),
    Fault(
        "statics/configuration.py",
        "return x, tangent.DFx @ qd, e",
        "return x, -tangent.DFx @ qd, e",
        "motion/test_simulate.py -k velocity_of_its",
        slow=True,
    ),
    Fault(
        "paths/stepper.py",
        "imbalance = -nodal_forces(",
        "imbalance = nodal_forces(",
        "paths/test_path.py -k flat_truss",
    ),
    Fault(
        "paths/stepper.py",
        "else load_factors(1.0, load)",
        "else load_factors(0.0, load)",
        "paths/test_path.py -k preload",
        slow=True,
    ),
    Fault(
        "paths/walk.py",
        "np.sign(excess[i]) * np.sign(excess[i + 1]) <= 0",
        "excess[i] < 0 <= excess[i + 1]",
        "paths/test_stops.py -k way_back",
    ),
    Fault(
        "paths/walk.py",
        "return None if turn is None else [(turn.length, turn.step)]",
        "return []",
        "paths/test_stops.py -k turns_back_within",
    ),
    Fault(
        "paths/walk.py",
        "taken = self.finish(begin._replace(tangent=direction), length, new, [])",
        "taken = AcceptedStep(begin._replace(tangent=direction), length, new, [], None)",
        "paths/test_stops.py -k any_bifurcation",
    ),
    Fault(
        "paths/walk.py",
        "if along_phi > along_load:",
        "if False:",
        "paths/test_stops.py -k any_bifurcation",
    ),
    Fault(
        "paths/walk.py",
        "self.steps.append(at)",
        "self.steps.append(taken.end)",
        "paths/test_stops.py -k load_factors",
    ),
    Fault(
        "paths/walk.py",
        "and number in switch",
        "and switch",
        "paths/test_stops.py -k any_bifurcation",
    ),
    Fault(
        "paths/stops.py",
        "        with heard():\n",
        "        if True:\n",
        "paths/test_stops.py -k stress_is_met",
        slow=True,
    ),
    Fault(
        "viewer/notebook.py",
        '{"font.size": 9}',
        '{"backend": "agg", "font.size": 9}',
        "viewer/test_notebook.py -k card_leaves",
    ),
    Fault("paths/stops.py", "above=0 if name == STRESS else None", "above=None", "paths/test_stops.py -k not_met"),
    Fault(
        "paths/imperfection.py",
        "loads=Loads(), increment=None, strain=None",
        "strain=None",
        "paths/test_stops.py -k imperfect_column",
        slow=True,
    ),
    Fault(
        "paths/imperfection.py",
        "return shape / (largest * np",
        "return shape / (np",
        "paths/test_stops.py -k imperfect_column",
        slow=True,
    ),
    Fault(
        "paths/imperfection.py",
        "[nothing, -e[constrained]]",
        "[nothing, 0 * e[constrained]]",
        "paths/test_sparse_path.py -k begins_bent",
        slow=True,
    ),
    Fault(
        "paths/imperfection.py",
        "loads=Loads(), increment=parameters.loads",
        "loads=parameters.loads",
        "paths/test_stops.py -k limit_point",
        slow=True,
    ),
    Fault(
        "paths/critical.py",
        "sign / largest, 0.0",
        "1.0 / largest, 0.0",
        "paths/test_path.py -k without_a_potential",
        slow=True,
    ),
    # Temperature.
    Fault(
        "elements/beams.py",
        "alpha * length * (change[0] + change[1]) / 2",
        "alpha * length * change[1]",
        "mechanics/test_temperature.py -k free_element",
    ),
    Fault(
        "elements/planar.py",
        "alpha * gradient * l0**2 / 2, (2,)",
        "-alpha * gradient * l0**2 / 2, (2,)",
        "mechanics/test_temperature.py -k free_element",
    ),
    Fault(
        "elements/planar.py",
        "offset - gradient[0] / 2 * across",
        "offset + gradient[0] / 2 * across",
        "mechanics/test_temperature.py -k free_element",
    ),
    Fault(
        "elements/spatial.py",
        "bent[1], bent[1], -bent[0], -bent[0]",
        "bent[1], bent[1], bent[0], bent[0]",
        "mechanics/test_temperature.py -k free_element",
    ),
    Fault(
        "elements/spectral.py",
        "(weights[:, None] / _compliance(section, places, length, names))",
        "weights[:, None]",
        "mechanics/test_temperature.py -k free_element",
    ),
    Fault(
        "elements/spectral_spatial.py",
        '"EIz": -gradient[0]',
        '"EIz": gradient[0]',
        "mechanics/test_temperature.py -k free_element",
    ),
    Fault(
        "mechanics/blocks.py",
        "rigidity = rigidity if rigidity.expands else dataclasses.replace(rigidity, alpha=0.0)",
        "rigidity = dataclasses.replace(rigidity, alpha=0.0)",
        "mechanics/test_temperature.py -k free_element",
    ),
    Fault(
        "mechanics/stress_resultants.py",
        "relieved = -stiffness @",
        "relieved = stiffness @",
        "mechanics/test_temperature.py -k heat",
    ),
    Fault(
        "statics/newton_search.py",
        "loads.temperature)[fixed])",
        "0 * loads.temperature)[fixed])",
        "mechanics/test_temperature.py -k free_element",
    ),
    Fault(
        "motion/coordinates_form.py",
        '"increment", "temperature")',
        '"increment")',
        "mechanics/test_temperature.py -k rigid_arm",
        slow=True,
    ),
    Fault(
        "motion/motion.py",
        "power = power - conservative @",
        "power = power + conservative @",
        "mechanics/test_temperature.py -k rigid_arm",
        slow=True,
    ),
    Fault(
        "motion/drive.py",
        "accumulate(temperature, tuple(drive.at), warmer)",
        "put(temperature, tuple(drive.at), warmer)",
        "mechanics/test_temperature.py -k rigid_arm",
        slow=True,
    ),
    Fault(
        "motion/drives_by_name.py",
        "has_table(value) and not fixed_indices",
        "has_table(value) and fixed_indices",
        "mechanics/test_temperature.py -k is_named",
    ),
    Fault(
        "build/assemble.py",
        '(c != "thermal" or name in warm)',
        'c != "thermal"',
        "mechanics/test_temperature.py -k free_element",
    ),
    # Building.
    Fault(
        "build/description.py",
        "        twin.dofs = list(keys)\n",
        "        twin.dofs = sorted(keys)\n",
        "build/test_builder.py -k can_be_named",
    ),
    Fault("model/model.py", "[16, *(len(name) + 1 for name in grouped)]", "[16]", "build/test_builder.py -k long_name"),
    Fault(
        "build/properties.py",
        'first += "; every function of an element takes `ref` by name, as in def f(.., *, ref)"',
        "pass",
        "build/test_properties.py -k wrong_shapes",
    ),
    Fault(
        "build/description.py",
        "is_element = symbol[:1] ==",
        "is_element = of[:1] ==",
        "build/test_builder.py -k can_be_named",
    ),
    Fault(
        "build/description.py",
        ' or f"{before} {number}" in self.nodes',
        "",
        "build/test_builder.py -k that_are_not_given",
    ),
    Fault(
        "lazy.py",
        "return sorted(offered(package))",
        "return sorted(vars(sys.modules[package]))",
        "elements/test_element_text.py",
    ),
    Fault("build/check_element.py", "yield ZERO, self._zero()", 'yield ZERO, (0.0, "")', "build/test_check_element.py"),
    Fault(
        "build/check_element.py", "yield RIGID, self._rigid()", 'yield RIGID, (0.0, "")', "build/test_check_element.py"
    ),
    Fault(
        "build/check_element.py",
        "yield KINETIC, self._kinetic()",
        'yield KINETIC, (0.0, "")',
        "build/test_check_element.py",
    ),
    Fault("build/check_element.py", "float(name not in KINKED)", "1.0", "build/test_check_element.py -k how_nearly"),
    Fault("math/rotations.py", "1 - square / 8", "1 - square / 4", "math/test_rotations.py"),
    Fault(
        "math/rotations.py",
        "jnp.cross(second[1:], first[1:])",
        "jnp.cross(first[1:], second[1:])",
        "math/test_rotations.py",
    ),
    Fault("spacar/outlines.py", "(outer - inner) / 2", "outer - inner", "spacar/test_outlines.py -k beam_theory"),
    Fault(
        "spacar/outlines.py",
        "Rectangle(width, thickness, NONE)",
        "Rectangle(thickness, width, NONE)",
        "spacar/test_outlines.py -k beam_theory",
    ),
    Fault("numerical_limits.py", "SIZES_ALIKE = 0.02", "SIZES_ALIKE = 1e6", "spacar/test_outlines.py -k do_not_go"),
    Fault(
        "plot/answer.py",
        "            _add_stress(figure, stressed)",
        "            pass",
        "spacar/test_outlines.py -k draws_it",
        slow=True,
    ),
    Fault("elements/element_text.py", "element.usual\n", "element\n", "elements/test_element_text.py -k of_ones_own"),
    Fault(
        "elements/spatial.py",
        "jnp.stack([arc[1], -arc[0]])",
        "jnp.stack([arc[1], arc[0]])",
        "mechanics/test_temperature.py -k arc_without",
    ),
    Fault(
        "elements/planar.py",
        "[_rigid_beam(p, rot_p, q, ref=ref), _hinge(rot_p, rot_q, ref=ref)]",
        "[_rigid_beam(p, rot_p, q, ref=ref), 0 * _hinge(rot_p, rot_q, ref=ref)]",
        "elements/test_transmission.py -k clamped_at_both",
    ),
    Fault("build/dofs.py", "if named > ndof:", "if False:", "build/test_builder.py -k too_few"),
    Fault(
        "build/dofs.py",
        "builder.release(proposal.of, proposal.component,",
        "builder.release(proposal.of, 2,",
        "spacar/test_tutorial.py -k on_request",
    ),
    Fault(
        "build/assemble.py",
        "stack([pair[i] for pair",
        "stack([pair[1 - i] for pair",
        "motion/test_simulate.py -k derivative_of_a_motion",
        slow=True,
    ),
    Fault("model/model.py", '"ndof": nx - nxo - neo}', '"ndof": nx - nxo}', "checks/test_mobility.py -k self_stress"),
    # Leaf springs.
    Fault("elements/leaf.py", "[[0.14], [0.40]", "[[0.14], [0.10]", "elements/test_leaf.py -k tip_of", slow=True),
    Fault(
        "elements/leaf_ends.py",
        "sign * skew_compliance",
        "skew_compliance",
        "elements/test_leaf_ends.py -k seen_from",
    ),
    Fault(
        "elements/leaf_ends.py", "EVEN, ODD = (2,", "EVEN, ODD = (4,", "elements/test_leaf_ends.py -k skew_c", slow=True
    ),
    Fault(
        "elements/leaf_ends.py",
        "weights * 6 * nodes * (1 - nodes)",
        "weights",
        "elements/test_leaf_ends.py -k leave_a_leaf_spring_stable",
        slow=True,
    ),
    Fault("elements/leaf_ends.py", "jnp.where(a < 1, shared, 0.0)", "0.0", "elements/test_leaf_ends.py -k lengths"),
    Fault(
        "elements/leaf_ends.py",
        '"GIt" in names else -1.0}',
        '"GIt" in names else 1.0}',
        "elements/test_leaf_ends.py -k own",
        slow=True,
    ),
    Fault(
        "elements/spectral_planar.py",
        "turn - jnp.sum(line.jumps[:, 2])",
        "turn",
        "elements/test_leaf_ends.py -k own",
        slow=True,
    ),
    Fault(
        "elements/roots.py",
        "* spreading_length(share) * per_width",
        "* per_width",
        "elements/test_leaf_ends.py -k half_space",
    ),
    Fault(
        "elements/leaf_ends.py",
        "b**1.5 + 1.4 * over**3",
        "b**3",
        "elements/test_leaf_ends.py -k width_and_thickness",
        slow=True,
    ),
    Fault("build/ends_in_line.py", "return wide, thick", "return width, thick", "elements/test_leaf_ends.py -k have"),
    Fault(
        "build/ends_in_line.py",
        'if leaves[name].properties["clamped"] is None:',
        "if True:",
        "elements/test_leaf_ends.py -k statement_on_clamps",
    ),
    Fault(
        "build/ends_in_line.py",
        "_least(member, float(length))) < 0:",
        "_least(member, float(length))) < -9:",
        "elements/test_leaf_ends.py -k too_short",
        slow=True,
    ),
    Fault("elements/leaf.py", "- self.beyond / length", "", "elements/test_leaf.py -k as_one_piece"),
    Fault(
        "elements/leaf.py",
        "jnp.minimum(layer, longest)",
        "layer",
        "elements/test_leaf.py -k are_independent",
    ),
    Fault("elements/leaf.py", "0.5 + 0.5 * self.clamped", "0.5", "elements/test_leaf.py -k whole_of_a_short"),
    Fault(
        "build/clamps.py",
        "or is_fold(builder, at, following[0]):",
        "or not is_fold(builder, at, following[0]):",
        "elements/test_leaf.py -k as_one_piece",
    ),
    Fault("elements/leaf.py", "(curved + bent) ** 2", "bent**2", "elements/test_curves.py -k energy_of"),
    Fault("elements/leaf.py", "coupling + coupling.T", "coupling", "elements/test_curves.py -k energy_of"),
    Fault(
        "elements/curves.py",
        "compose_turns(first * CONJUGATE, line",
        "compose_turns(first, line",
        "elements/test_curves.py -k in_space_as",
        slow=True,
    ),
    Fault("elements/curves.py", "if not holds(off < SAME_LINE)", "if False", "elements/test_curves.py -k does_not_fit"),
    Fault(
        "elements/leaf_stress.py",
        "nu * bent * (curved + bent)",
        "nu * bent**2",
        "elements/test_leaf_stress.py -k curved_strip",
    ),
    Fault("plot/sections.py", "if curve is not None", "if False", "plot/test_plot.py -k twisted_strip"),
    Fault(
        "build/clamps.py",
        "if end is not None and curvature",
        "if False and curvature",
        "elements/test_curves.py -k goes_on",
    ),
    Fault("elements/leaf.py", "-weights * stiff", "weights * stiff", "elements/test_leaf.py -k width_that", slow=True),
    Fault("elements/leaf.py", "IN_PLANE = 0.30", "IN_PLANE = 0.0", "elements/test_leaf.py -k width_that", slow=True),
    Fault("elements/leaf.py", "[0.065], [", "[0.01], [", "elements/test_leaf.py -k tip_of", slow=True),
    Fault("elements/leaf.py", "[0.10]])", "[0.0]])", "elements/test_leaf_sizes.py -k how_far"),
    Fault("elements/leaf.py", "[[0.27], [", "[[0.0], [", "elements/test_leaf_sizes.py -k how_far"),
    Fault("elements/leaf.py", "OF_THICK = 12.0", "OF_THICK = 0.0", "elements/test_leaf.py -k cannot_warp", slow=True),
    Fault("elements/bent_strip.py", "a / (u * b)", "a / (u * s)", "elements/test_leaf_sizes.py -k bent_strip"),
    Fault("elements/leaf.py", "length + self.beyond)", "length)", "elements/test_leaf_sizes.py -k all_pieces"),
    Fault(
        "elements/leaf.py",
        "(softer * (sideways @ c)",
        "0 * (softer * (sideways @ c)",
        "elements/test_leaf.py -k beyond",
    ),
    Fault("elements/leaf.py", "12 * (distorting - 1)", "12 * 0", "elements/test_curves.py -k energy_of"),
    Fault("elements/leaf_stress.py", "5] / (1 + softer)", "5]", "elements/test_leaf_sizes.py -k distorted_strip"),
    Fault(
        "elements/leaf_stress.py",
        "LACKS, BENDS, SLOWEST, FASTER = 0.77,",
        "LACKS, BENDS, SLOWEST, FASTER = 1.6,",
        "elements/test_leaf_sizes.py -k what_fades",
    ),
    Fault(
        "elements/leaf_stress.py",
        "/ (1 + fourth / HALVED)",
        "",
        "elements/test_leaf_sizes.py -k what_fades",
    ),
    Fault(
        "build/curved_leaves.py",
        "length, at = length + ",
        "length, at = 0 * ",
        "elements/test_leaf_sizes.py -k may_be_short",
    ),
    Fault("build/curved_leaves.py", "or is_fold(builder, at, near)", "", "elements/test_leaf_sizes.py -k short_leg"),
    Fault("build/curved_leaves.py", "wide < NARROWEST", "wide < 0", "elements/test_leaf_sizes.py -k not_compared"),
    Fault("build/holes.py", "near < NEAREST", "near < 0", "elements/test_holes.py -k out_of_range"),
    Fault(
        "build/clamps.py", "if is_holed(section):", "if False:", "elements/test_holes.py -k mechanism_with", slow=True
    ),
    Fault("elements/holes.py", "long + missing * my", "long + my", "elements/test_holes.py -k compliance_of"),
    Fault("elements/holes.py", "jnp.stack([*powers", "jnp.hstack([*powers", "elements/test_holes.py -k stacked"),
    Fault("elements/holes.py", "(1 - 0.4 * IN_MIDDLE)", "1", "elements/test_holes.py -k positive"),
    Fault("build/ends_in_line.py", "0) & ~rigid", "0) & (rigid < 0)", "elements/test_leaf_ends.py -k without_a_rigid"),
    Fault("build/plain_beams.py", "(bends @ places) / bends.sum()", "0.0", "build/test_plain_beams.py"),
    Fault("build/plain_beams.py", "1 / (n**2 - 1)", "1 / (n**2 + 9)", "build/test_plain_beams.py -k one_coefficient"),
    Fault("build/plain_beams.py", "2 * section.wall_y * ", "section.wall_y * ", "build/test_plain_beams.py -k tubes"),
    Fault(
        "build/plain_beams.py",
        "for end in chain.ends)",
        "for end in chain.ends[:1])",
        "build/test_plain_beams.py -k strip",
    ),
    Fault("elements/leaf.py", "(keeps * longer**2", "(longer**2", "elements/test_leaf.py -k section_of"),
    Fault("elements/leaf.py", "= flatter * longer", "= 0.0 * longer", "elements/test_leaf.py -k section_of"),
    Fault("elements/leaf.py", "weights * pulled, bent", "weights, bent", "elements/test_curves.py -k section_of"),
    Fault("elements/leaf_ends.py", "2.5 * mean", "1e-3 * mean", "elements/test_leaf_ends.py -k foot_at", slow=True),
    Fault(
        "elements/leaf_stress.py",
        "longer / 2) * scale",
        "longer) * scale",
        "elements/test_leaf_stress.py -k twisted_and",
    ),
    Fault(
        "elements/leaf_stress.py",
        "longer * relaxed / 360",
        "longer / 360",
        "elements/test_leaf_stress.py -k twisted_and",
    ),
    Fault("elements/bent_strip.py", "1 - q * r - q,", "1 - q * r,", "elements/test_leaf_sizes.py -k bent_strip"),
    Fault(
        "elements/leaf.py",
        "1 + material.poisson() * flat",
        "1 + 0 * flat",
        "elements/test_leaf.py -k temperature",
        slow=True,
    ),
    Fault(
        "elements/leaf.py",
        "if faults := check_section(section, ref, curvature, count)",
        "if faults := []",
        "elements/test_leaf.py -k bad",
    ),
    Fault("elements/leaf_stress.py", "-youngs * slope", "youngs * slope", "elements/test_leaf_stress.py -k beside"),
    Fault("elements/leaf_stress.py", "(1 + fallen) * jnp.exp", "jnp.exp", "elements/test_leaf_stress.py -k solid"),
    Fault(
        "elements/leaf_stress.py",
        "- drop / 2 * AT_Z",
        "- drop * AT_Z",
        "elements/test_leaf_stress.py -k flattening",
        slow=True,
    ),
    Fault(
        "elements/leaf_stress.py",
        "*resultants[:3], numbers.GIt * rate",
        "*resultants[:4]",
        "elements/test_leaf_stress.py -k closed_form",
        slow=True,
    ),
    Fault(
        "elements/surface.py", "across * (across - sigma_x)", "across**2", "elements/test_leaf_stress.py -k at_a_stroke"
    ),
    Fault("elements/sections.py", "_rise(x / along)", "_rise(x / across)", "elements/test_profile.py -k hinges"),
    Fault(
        "elements/sections.py",
        "jnp.abs(place - 0.5) * length - flat / 2",
        "jnp.abs(place - 0.5) * length - flat / 3",
        "elements/test_profile.py -k hinges",
    ),
    Fault("build/clamps.py", "THICK = 3.0", "THICK = 3.3", "elements/test_leaf.py -k what_clamps"),
    Fault("build/clamps.py", "< np.cos(FOLD)), False", "< 0.0), False", "elements/test_leaf.py -k what_clamps"),
    Fault(
        "build/clamps.py", "if stated and flags is not None and", "if False and", "elements/test_leaf.py -k contradict"
    ),
    # Warping beams.
    Fault("elements/beams.py", "2 * bimoment / t", "2 * bimoment * t", "elements/test_warping.py -k least_energy"),
    Fault("elements/beams.py", "even - odd) / 2", "odd - even) / 2", "elements/test_warping.py -k least_energy"),
    Fault("elements/spatial.py", "coupling / l0", "coupling", "elements/test_warping.py -k by_the_closed_form"),
    Fault("elements/spatial.py", "section.rigidity().Jw * ", "", "elements/test_warping.py -k inertia_of_warping"),
    Fault("elements/sections.py", "(w * t) ** 3 / 144", "(w * t) ** 3 / 12", "elements/test_warping.py -k fold_shares"),
    Fault(
        "build/clamps.py",
        "clamped.restrained or untwisted",
        "clamped.restrained",
        "elements/test_warping.py -k what_restrains",
    ),
    Fault("build/clamps.py", "if number not in element.measured", "", "elements/test_warping.py -k keeps_flat"),
    Fault("spacar/kinds.py", 'properties["clamped"] = False', "pass", "spacar/test_beamw.py -k closed_form"),
    Fault(
        "spacar/write.py",
        "roles = self.clamped.nodes",
        "roles = self.builder.nodes",
        "spacar/test_beamw.py -k is_written",
    ),
    Fault(
        "spacar/light_model.py",
        '("fix", "fix_orien", "fix_warp")',
        '("fix", "fix_orien")',
        "spacar/test_light.py -k share_their_warping",
    ),
    # Building blocks.
    Fault("blocks/site.py", "first[1], -first[0]", "-first[1], first[0]", "blocks/test_blocks.py -k in_the_plane"),
    Fault(
        "blocks/site.py", "= np.cross(first, self.y)", "= -np.cross(first, self.y)", "blocks/test_blocks.py -k in_space"
    ),
    Fault(
        "blocks/site.py",
        "return spatial.leaf_spring, section",
        "return spatial.spectral_beam, section",
        "blocks/test_blocks.py -k solid or clamped",
        slow=True,
    ),
    Fault(
        "build/clamps.py",
        "        if flat and restrained:\n            break",
        "",
        "blocks/test_blocks.py -k a_body_between",
    ),
    Fault("blocks/guides.py", "along=-s.axes[0]", "along=s.axes[0]", "blocks/test_blocks.py -k in_space"),
    Fault("blocks/pivots.py", "-side * (1 - ratio)", "-side * ratio", "blocks/test_blocks.py -k in_space"),
    Fault(
        "blocks/pivots.py",
        "(middle, end(1, side, far=True))",
        "(middle, end(1, side, far=False))",
        "blocks/test_blocks.py",
    ),
    Fault("blocks/springs.py", "second * xp.cos(fold)", "length * xp.cos(fold)", "blocks/test_blocks.py -k in_space"),
    Fault("elements/necks.py", "2 * radius - depth", "2 * radius", "blocks/test_blocks.py -k notch_hinge", slow=True),
    Fault(
        "elements/necks.py",
        "rigidity.GIt * self.twist",
        "rigidity.GIt",
        "blocks/test_blocks.py -k beside_solid",
        slow=True,
    ),
    Fault("elements/necks.py", "deep > DEEPEST or", "False and", "blocks/test_blocks.py -k stocky_neck"),
    # Design.
    Fault("design/tune.py", "best = min(runs", "best = max(runs", "design/test_tune.py -k several_starts"),
    Fault(
        "design/chunks.py",
        "for index, future in enumerate(futures)}",
        "for index, future in enumerate(futures[::-1])}",
        "design/test_checkpoint.py -k any_order",
    ),
    Fault(
        "design/sweep.py",
        '"the designs": identity(dict(designs)),',
        '"the designs": identity(list(designs)),',
        "design/test_checkpoint.py -k another_sweep",
    ),
    Fault(
        "design/chunks.py",
        "answers[name][failed] = np.nan",
        "pass",
        "design/test_possible.py design/test_sweep.py -k fails",
    ),
    Fault(
        "design/sweep.py",
        "parts.append((todo[index], (values, codes)))",
        "parts.append((todo[-1], (values, codes)))",
        "design/test_checkpoint.py -k goes_on",
    ),
    Fault("design/checkpoint.py", "self.file.seek(good)", "pass", "design/test_checkpoint.py"),
    Fault(
        "design/checkpoint.py",
        "codes[computed], stored",
        "codes[: len(computed)] + 1, stored",
        "design/test_checkpoint.py -k load",
    ),
    Fault("design/checkpoint.py", "max(len(along), 1)", "1", "design/test_sweep.py -k saved_sweep"),
    Fault(
        "design/swept.py", "no_worse &= a[:, None] <= b", "no_worse &= a[:, None] < b", "design/test_sweep.py -k front"
    ),
    Fault(
        "design/swept.py",
        '(1 if sense == "minimize" else -1)',
        '(-1 if sense == "minimize" else 1)',
        "design/test_sweep.py -k front",
    ),
    Fault(
        "design/swept.py",
        "np.isin(self.codes, ANSWERED) & ",
        "",
        "design/test_sweep.py -k front",
    ),
    Fault("design/identity.py", "yield np.ascontiguousarray(array).tobytes()", "pass", "design/test_identity.py"),
    Fault("questions/question.py", "int(text) - 1]", "0]", "design/test_study_parts.py -k answer"),
    Fault("questions/coordinate.py", "places[int(component) - 1]", "places[0]", "design/test_study_parts.py -k raised"),
    Fault(
        "questions/von_mises.py",
        "return known.maximum",
        "return known.smooth_maximum()",
        "design/test_study_parts.py -k stress",
    ),
    Fault(
        "questions/load_multiplier.py",
        "return number_along_axis(buckling_loads(model",
        "return number_along_axis(2 * buckling_loads(model",
        "design/test_study_parts.py -k column",
    ),
    Fault(
        "design/study.py",
        "if failed < len(found.codes) else",
        "if failed <= len(found.codes) else",
        "design/test_study.py -k failed_sweep",
    ),
    Fault(
        "questions/node_stiffness.py",
        "return 1 / flexibility[i, i]",
        "return flexibility[i, i]",
        "design/test_study_parts.py -k sway",
    ),
    Fault("design/settling.py", "jnp.where(outside[samples], jnp.inf, t)", "t", "design/test_settling.py"),
    Fault(
        "design/sensitivities.py",
        "slopes * point / values[:, None]",
        "slopes * point",
        "design/test_sensitivities.py -k table_is",
    ),
    Fault(
        "design/tolerance.py",
        "sensitivities.slopes * (sensitivities.slopes @ covariance)",
        "np.abs(sensitivities.slopes * np.sqrt(np.diag(covariance)))",
        "design/test_sensitivities.py -k propagation",
    ),
    Fault(
        "design/problem.py",
        "(1 if minimize else -1)",
        "(-1 if minimize else 1)",
        "design/test_tune.py -k several_starts",
    ),
    Fault("design/problem.py", "scale = largest or abs(v)", "scale = abs(v)", "design/test_tune.py -k force_curve"),
    Fault(
        "design/tune.py",
        "own if reference is None else reference",
        "own",
        "design/test_tune.py -k combination",
    ),
    Fault(
        "design/tune.py", "at_start[0] != 0, at_start[0]", "True, at_start[0]", "design/test_tune.py -k start_of_zero"
    ),
    Fault("design/tune.py", "best = min(tried, key=rank)", "best = tried[-1]", "design/test_tune.py -k choices"),
    Fault(
        "design/tune.py",
        "np.all(dependence, axis=0)",
        "np.any(dependence, axis=0)",
        "design/test_tune.py -k combination",
    ),
    Fault("design/tuned.py", "if count > MOST:", "if False:", "design/test_tune.py -k choices_that"),
    Fault(
        "design/stroke.py", "at.sigma[index] - held", "held.sigma[index] - at", "design/test_verdict.py -k deformation"
    ),
    Fault("design/stroke.py", "margins = 1 + ", "margins = ", "design/test_verdict.py -k buckling", slow=True),
    Fault("design/stroke.py", "1 / (row @ ", "(row @ ", "design/test_verdict.py -k snaps"),
    Fault("design/over_stroke.py", "yields, 1 / jnp", "yields, 2 / jnp", "design/test_verdict.py -k snaps"),
    Fault(
        "design/over_stroke.py",
        "turned else x[part] - rest[part]",
        "turned else x[part]",
        "design/test_verdict.py -k reached_is_found",
    ),
    Fault("design/over_stroke.py", "> ALONG_AXIS:", "> 2:", "design/test_verdict.py -k in_space"),
    Fault(
        "design/over_stroke.py",
        "[:, :1] == index",
        "[:, :2] == index",
        "design/test_verdict.py::test_what_turns_a_node_in_space_is_no_parasitic_motion",
        slow=True,
    ),
    Fault(
        "design/over_stroke.py",
        "change - about * (about @ change)",
        "change",
        "design/test_verdict.py -k in_space",
    ),
    Fault("design/verdict.py", "not lower < upper:", "False:", "design/test_verdict.py -k is_refused"),
    Fault(
        "design/verdict.py", "every += [(a + b) / 2, b]", "every += [b]", "design/test_verdict.py -k between_strokes"
    ),
    Fault(
        "design/verdict.py", "-0.5 < excess(b) < 0", "0.5 < excess(b) < 0", "design/test_verdict.py -k between_strokes"
    ),
    Fault(
        "design/judgement.py",
        "1 if first.upper is None",
        "1 if True",
        "design/test_verdict.py -k say_what_moves_it",
        slow=True,
    ),
    Fault(
        "design/verdict.py",
        "return min(reached",
        "return max(reached",
        "design/test_verdict.py -k deformation",
    ),
    Fault("plot/verdict.py", "finite / finite[zero_stroke]", "finite", "design/test_verdict.py -k snaps"),
    Fault("design/designs.py", 'indexing="ij"', 'indexing="xy"', "design/test_sweep.py -k grid_is"),
    Fault(
        "plot/sweep.py",
        "front_rows = front.rows[mask[front.rows]]",
        "front_rows = front.rows[:1]",
        "plot/test_designs.py -k front",
    ),
    Fault("plot/sweep.py", "reduce_C_function=np.mean", "reduce_C_function=np.max", "plot/test_designs.py -k hexagons"),
    # Input files, SPACAR Light.
    Fault(
        "spacar/actions.py",
        'p["value"] - start, velocity, kind=kind',
        'p["value"], velocity, kind=kind',
        "spacar/test_read.py -k settings",
    ),
    Fault(
        "spacar/actions.py",
        'increment=s.keyword == "DELESIG"',
        'increment=s.keyword == "ESIG"',
        "spacar/test_read.py -k round_trip",
    ),
    Fault("spacar/trajectories.py", "start < other.end and ", "", "spacar/test_trajectories.py -k round_trip"),
    Fault("spacar/trajectories.py", "and end <= start", "and end < start", "spacar/test_trajectories.py -k one_fault"),
    Fault(
        "spacar/trajectories.py",
        "role is Role.PRESCRIBED and",
        "role is Role.DOF and",
        "spacar/test_trajectories.py -k one_fault",
    ),
    Fault(
        "spacar/trajectories.py",
        "if nominal and not outputs",
        "if outputs and not nominal",
        "spacar/test_trajectories.py -k one_fault",
    ),
    Fault(
        "spacar/trajectories.py",
        "legs, float(start), float(reference)",
        "legs, 0.0, float(reference)",
        "answers/test_trajectory.py -k not_used",
    ),
    Fault(
        "spacar/trajectories.py",
        "leg.value - reference), leg.value",
        "leg.value), leg.value",
        "answers/test_trajectory.py -k follow",
    ),
    Fault("spacar/trajectories.py", "if leg.start > breaks[-1]:", "if True:", "answers/test_trajectory.py -k follow"),
    Fault("spacar/trajectories.py", '"jerk": 60.75', '"jerk": 60.0', "answers/test_trajectory.py -k thirds"),
    Fault(
        "answers/mode_2_inverse.py",
        "(found.y0) + origins(motion.model)",
        "(found.y0)",
        "answers/test_trajectory.py::test_vibrations_on_a_base_that_moves",
        slow=True,
    ),
    Fault(
        "answers/mode_5_perturbation.py",
        'step["f0"] = -f0',
        'step["f0"] = f0',
        "answers/test_trajectory.py -k base",
        slow=True,
    ),
    Fault(
        "answers/mode_5_perturbation.py",
        "qd=_start(nominal.motion.model, led), ",
        "",
        "answers/test_trajectory.py -k base",
        slow=True,
    ),
    Fault(
        "answers/mode_5_perturbation.py",
        "nominal_data(nominal, total_motion)",
        "nominal_data(nominal)",
        "answers/test_trajectory.py -k base",
        slow=True,
    ),
    Fault(
        "answers/mode_2_inverse.py",
        "builder.dofs = driven + builder.dofs",
        "builder.dofs += driven",
        "answers/test_trajectory.py::test_linearised_equations_of_the_joints",
        slow=True,
    ),
    Fault(
        "answers/mode_2_inverse.py",
        "direct + (others if remaining else [])",
        "direct",
        "answers/test_trajectory.py -k let_go",
        slow=True,
    ),
    Fault(
        "answers/mode_1_simulate.py",
        " | laws_of(asked.builder, model.labels, settings, Role.PRESCRIBED)",
        "",
        "answers/test_trajectory.py -k base",
        slow=True,
    ),
    Fault(
        "spacar/trajectories.py", "if moves and not constrained:", "if False:", "spacar/test_signals.py -k cannot_be"
    ),
    Fault(
        "spacar/trajectories.py",
        "(kind, str(owner), component), axis))",
        "(kind, str(owner), component), 2))",
        "spacar/test_signals.py -k axes",
    ),
    Fault("answers/answer_files.py", 'in ("path", "steps")', 'in ("path",)', "answers/test_trajectory.py -k saved"),
    Fault("spacar/write.py", "way.start, way.end,", "way.end, way.start,", "spacar/test_trajectories.py -k round_trip"),
    Fault(
        "spacar/kinds.py",
        '_BEAM = ("EA", "GIt", "EIy", "EIz"',
        '_BEAM = ("EA", "GIt", "EIz", "EIy"',
        "spacar/test_read.py -k beam_numbers",
    ),
    Fault(
        "spacar/series.py",
        "(length, length / 2, length / 6)",
        "(length, length / 2, length / 3)",
        "spacar/test_series.py -k prestress",
    ),
    Fault("spacar/arithmetic.py", '(sign == "**"))', '(sign == "*"))', "spacar/test_arithmetic.py -k python"),
    Fault(
        "spacar/light_results.py",
        "return self._compliance(True)",
        "return self._compliance(False)",
        "spacar/test_light.py -k turned_support",
        slow=True,
    ),
    Fault(
        "spacar/light_results.py",
        'self._ends(), properties.get("y")',
        "self._ends(), None",
        "spacar/test_light.py -k local_axes",
    ),
    Fault(
        "spacar/light_results.py",
        "for part in existing], axis=0) / 2",
        "for part in existing], axis=0)",
        "spacar/test_light.py -k turned_support",
        slow=True,
    ),
    Fault(
        "spacar/light_results.py",
        "np.arctan2(r[:, 2, 1], r[:, 2, 2])",
        "np.arctan2(-r[:, 2, 1], r[:, 2, 2])",
        "spacar/test_light.py -k every_form",
    ),
    Fault(
        "spacar/light.py",
        "initial, increment = (any(",
        "increment, initial = (any(",
        "spacar/test_light.py -k initial_loads",
    ),
    # Whole jobs of a designer.
    Fault(
        "statics/solve.py",
        "reactions, loads + reactions",
        "reactions, reactions",
        "test_jobs.py -k folded",
    ),
    Fault("elements/sections.py", "w * t**3 / 12, t * w**3", "w * t**3 / 12.1, t * w**3", "test_jobs.py -k identified"),
    Fault(
        "motion/motion.py",
        "is_constrained == 1.0, force, 0.0",
        "is_constrained == 1.0, -force, 0.0",
        "test_jobs.py -k four_bar",
        slow=True,
    ),
    Fault(
        "statics/stroke.py",
        "*acting_at(topology, parameters, at), iterations",
        "*acting_at(topology, parameters, at)[:2], -acting_at(topology, parameters, at)[2], iterations",
        "test_jobs.py -k constant",
    ),
    Fault(
        "linear/damping.py",
        "asarray(ratio, float), (n,)",
        "asarray(2 * ratio, float), (n,)",
        "test_jobs.py -k stage",
    ),
    Fault("design/swept.py", "candidates[~worse.any(axis=0)]", "candidates", "design/test_sweep.py -k front_of_many"),
    Fault("cli.py", "{option} takes NAME=NUMBER", "{option} takes NAME", "test_jobs.py -k misused"),
    # Results asked by name.
    Fault("statics/solve.py", "at.force - weight(", "at.force + weight(", "model/test_by_name.py -k reactions_of"),
    Fault("model/by_name.py", "component, 0.5)", "component, 2.0)", "model/test_by_name.py -k shaft"),
    Fault("motion/motion.py", "applied + reactions", "reactions", "motion/test_drive.py -k at_once", slow=True),
    # Paths, modes and load multipliers of large mechanisms by sparse matrices.
    Fault(
        "statics/sparse.py",
        "self.e - strained)), constrained, self._multipliers)",
        "self.e - strained)), constrained, 0.0)",
        "paths/test_sparse_path.py -k driven_and",
        slow=True,
    ),
    Fault(
        "paths/sparse_path.py",
        "np.asarray(states)[chosen]",
        "np.asarray(states)[0]",
        "paths/test_sparse_states.py::test_answers_about_a_state_are_those_of_the_dense_path",
    ),
    Fault(
        "paths/sparse_path.py",
        "SparsePath(**critical, **shared",
        "SparsePath(**{**critical, 'load_factor': 0 * critical['load_factor']}, **shared",
        "paths/test_sparse_states.py -k loads_of_their_points",
        slow=True,
    ),
    Fault(
        "paths/sparse_path.py",
        "below + np.sum(values < 0, axis=1)",
        "np.sum(values < 0, axis=1)",
        "paths/test_sparse_path.py -k again",
        slow=True,
    ),
    Fault("paths/sparse_critical.py", "negative - int(np.sum(rough < -shift))", "0", "paths/test_sparse_critical.py"),
    Fault(
        "paths/sparse_critical.py",
        "if np.min(np.abs(values)) < doubted",
        "if False and np.min(np.abs(values)) < doubted",
        "paths/test_sparse_critical.py",
    ),
    Fault(
        "paths/sparse_critical.py",
        "if abs(quotient) < DOUBTED",
        "if False and abs(quotient) < DOUBTED",
        "paths/test_sparse_critical.py",
    ),
    Fault(
        "paths/sparse_critical.py",
        "count - int(np.sum(values < middle))",
        "count - int(np.sum(values < 0))",
        "paths/test_sparse_critical.py",
    ),
    Fault(
        "paths/sparse_critical.py",
        "*force.shape[1:]))]), transposed)[:n] / size",
        "*force.shape[1:]))]), transposed)[:n]",
        "paths/test_sparse_critical.py",
    ),
    Fault(
        "paths/path.py",
        "hanging and walker.code == RESULTS.singular_stiffness",
        "hanging and walker.code == RESULTS.max_steps",
        "paths/test_sparse_states.py -k hanging",
        slow=True,
    ),
    Fault(
        "compilation/compile.py",
        "with jax.ensure_compile_time_eval():\n        return type",
        "if True:\n        return type",
        "compilation/test_compile.py -k comes_first",
    ),
    Fault(
        "model/model.py",
        "if not is_concrete(model.topology):",
        "if False:",
        "trajectory/test_inverse.py -k wrong",
        slow=True,
    ),
    Fault("model/model.py", "if numbers and not", "if False and not", "test_arguments.py -k concrete"),
    Fault(
        "trajectory/inverse.py",
        "as_written.get(name, name)",
        "name",
        "trajectory/test_inverse.py -k by_a_dimension",
        slow=True,
    ),
    Fault(
        "trajectory/inverse.py",
        "if followed and len(followed) != len(remaining)",
        "if followed",
        "trajectory/test_inverse.py -k by_a_dimension",
        slow=True,
    ),
    Fault(
        "design/sensitivities.py",
        "from ..compilation.by_meaning import jit",
        "from ..compilation.compile import jit",
        "compilation/test_by_meaning.py -k again",
    ),
    Fault(
        "design/tune.py",
        "from ..compilation.by_meaning import jit",
        "from ..compilation.compile import jit",
        "compilation/test_by_meaning.py -k again",
    ),
    Fault(
        "design/chunks.py",
        "from ..compilation.by_meaning import jit",
        "from ..compilation.compile import jit",
        "compilation/test_by_meaning.py -k again",
    ),
    Fault(
        "build/assemble.py",
        "with jax.core.eval_context():",
        "if True:",
        "compilation/test_by_meaning.py -k known_numbers",
    ),
    Fault(
        "compilation/compile.py",
        "with one_thread(), jax.core.eval_context():",
        "with one_thread():",
        "compilation/test_by_meaning.py -k known_numbers",
    ),
    Fault(
        "compilation/by_meaning.py",
        "if not is_concrete(program.numbers):",
        "if False:",
        "compilation/test_by_meaning.py",
    ),
    Fault(
        "compilation/by_meaning.py",
        "compile.exact(tuple(sorted(options.items()))), kinds",
        "kinds",
        "compilation/test_by_meaning.py -k options",
    ),
    Fault(
        "compilation/by_meaning.py",
        "leaves[:count], *leaves[count:]",
        "leaves[:count], *leaves[:count]",
        "compilation/test_by_meaning.py",
    ),
    Fault(
        "compilation/by_meaning.py",
        "@functools.lru_cache(compile.MOST_VARIANTS)\n",
        "",
        "compilation/test_by_meaning.py -k anew",
    ),
    Fault(
        "linear/traced_poles.py",
        "left_vector / np.sum(terms)",
        "left_vector",
        "linear/test_traced_poles.py -k closed_form",
    ),
    Fault(
        "linear/traced_poles.py",
        "[:, None], transposed)[:, 0]",
        "[:, None])[:, 0]",
        "linear/test_sparse_poles.py -k differences",
        slow=True,
    ),
    Fault(
        "linear/traced_poles.py",
        "np.sum(np.abs(poles - s) <= REPEATED_EIGENVALUE * np.abs(s)) > 1",
        "False",
        "linear/test_traced_poles.py -k repeated",
    ),
    Fault("linear/modes.py", "if count > 2 * n:", "if False:", "linear/test_traced_poles.py -k more_poles"),
    Fault("linear/modes.py", "check(result, True)", "result", "linear/test_traced_poles.py -k collected"),
    Fault("linear/traced_poles.py", "values**2 * m", "values * m", "linear/test_traced_poles.py -k closed_form"),
    Fault(
        "linear/traced_poles.py", "2 * middle * m + c", "2 * middle * m", "linear/test_traced_poles.py -k closed_form"
    ),
    Fault(
        "linear/traced_poles.py", "scale * u[:, column]", "u[:, column]", "linear/test_traced_poles.py -k closed_form"
    ),
    Fault(
        "linear/traced_poles.py",
        "np.linalg.inv(meeting).conj()",
        "np.linalg.inv(meeting)",
        "linear/test_traced_poles.py",
    ),
    Fault(
        "linear/traced_poles.py",
        "    if sizes[-many] > SOLVED_BY_VECTOR or not least",
        "    if not least",
        "linear/test_traced_poles.py",
    ),
    Fault(
        "linear/traced_poles.py",
        "not least > MEETING_POLES * change_norm",
        "False",
        "linear/test_traced_poles.py -k meet",
    ),
    Fault("linear/traced_poles.py", "if len(nearest) < count or", "if", "linear/test_traced_poles.py -k codes"),
    Fault(
        "linear/traced_poles.py",
        'kind="stable")[:count])\n        values',
        'kind="stable")[-count:])\n        values',
        "linear/test_traced_poles.py -k nearest",
    ),
    Fault("paths/limit.py", "(rate * last > 0) & (turn > 0)", "turn >= 0", "paths/test_sparse_limit.py"),
    Fault(
        "paths/limit.py",
        "return -left_null_vector(",
        "return left_null_vector(",
        "paths/test_sparse_limit.py",
    ),
    Fault("paths/limit.py", "1.0, jnp.nan)", "1.0, 1.0)", "paths/test_sparse_limit.py"),
    Fault(
        "paths/limit.py",
        "passed = good & (new.tangent.load <= 0)",
        "passed = good & (new.tangent.load <= -2)",
        "paths/test_sparse_limit.py",
    ),
    Fault(
        "math/bordered.py",
        "return -self._left / self._by_left",
        "return self._left / self._by_left",
        "math/test_bordered.py",
    ),
    Fault(
        "math/bordered.py",
        "return self._whole.solve(right_side, transposed=True)[:-1]",
        "return self._whole.solve(right_side)[:-1]",
        "math/test_bordered.py",
    ),
    Fault(
        "linear/sparse_spectrum.py",
        "equilibrating(self.tangent, factored.by_diagonal)",
        "equilibrating(self.tangent)",
        "linear/test_sparse.py -k any_size",
    ),
    Fault(
        "linear/sparse_spectrum.py",
        "if not passed_over(values):",
        "if True:",
        "linear/test_sparse.py -k every_copy",
        slow=True,
    ),
    Fault(
        "linear/sparse_spectrum.py",
        "if not np.all(wrong <= most):",
        "if False:",
        "linear/test_lanczos.py -k modes_that",
    ),
    Fault(
        "linear/sparse_spectrum.py",
        "moved = factored.solve(np.vstack([basis / scale[:n, None],",
        "moved = factored.solve(np.vstack([2 * basis / scale[:n, None],",
        "linear/test_lanczos.py",
    ),
    Fault(
        "linear/sparse_buckling.py",
        "Balanced(about.x, about.sigma[constrained], about.e, ",
        "Balanced(about.x, 0 * about.sigma[constrained], about.e, ",
        "paths/test_sparse_states.py -k of_a_held_elongation",
        slow=True,
    ),
    Fault(
        "linear/sparse_buckling.py",
        "return elastic + of_stress(sigma, loads.gravity) + value",
        "return elastic + value",
        "linear/test_buckling.py -k derivative",
        slow=True,
    ),
    Fault(
        "linear/buckling.py",
        "put(extra, topology.e.held, 0.0)",
        "extra",
        "linear/test_buckling.py -k prestress_that_is_held",
        slow=True,
    ),
    Fault(
        "build/builder.py",
        'if release == "auto" and not check:',
        "if False:",
        "build/test_dofs.py -k not_looked_for",
    ),
    Fault(
        "build/builder.py",
        'if release == "auto":\n                raise',
        "if False:\n                raise",
        "build/test_dofs.py -k not_looked_for",
    ),
    Fault(
        "linear/buckling.py",
        "about = linearized_by_elements(model, factors) if",
        "about = linearized_by_elements(model, LoadFactors(0.0, 0.0)) if",
        "linear/test_buckling.py::test_loads_that_move_a_mechanism_far_before_it_buckles_are_told",
        slow=True,
    ),
    Fault(
        "statics/tangent.py",
        "(rows, columns, -matrices)",
        "(rows, columns, matrices)",
        "paths/test_sparse_states.py -k frequencies",
        slow=True,
    ),
    Fault(
        "linear/sparse_solve.py",
        "slopes = -jnp.diagonal(y[n + h :])",
        "slopes = jnp.diagonal(y[n + h :])",
        "linear/test_sparse.py -k derivatives_are",
        slow=True,
    ),
    Fault(
        "linear/sparse_spectrum.py",
        "shares[:, ::-1][:, :count]",
        "shares[:, :count]",
        "linear/test_sparse.py -k mass_on_many",
        slow=True,
    ),
    # Many short beams.
    Fault(
        "linear/sparse_buckling.py",
        "buckled._replace(values=np.where(bounded, -elastic",
        "buckled or buckled._replace(values=np.where(bounded, -elastic",
        "math/test_by_deformations.py -k buckle",
    ),
    Fault(
        "linear/sparse_spectrum.py",
        "return refined_solution(shifted, self.factors.solve, right, np.ones(n))",
        "return self.factors.solve(right)",
        "math/test_by_deformations.py -k vibrate",
    ),
    Fault("math/by_deformations.py", "z, before = z + step,", "z, before = z,", "math/test_by_deformations.py -k bend"),
    Fault(
        "math/by_deformations.py",
        "+ product(elements.curved, v, size=n_x)",
        "",
        "math/test_by_deformations.py -k assembled",
        slow=True,
    ),
    Fault(
        "math/by_deformations.py",
        "+ 1j * product(elements.lossy,",
        "+ 2j * product(elements.lossy,",
        "math/test_by_deformations.py -k assembled",
        slow=True,
    ),
    Fault(
        "linear/sparse_poles.py",
        "except AnalysisError:\n",
        "except ZeroDivisionError:\n",
        "paths/test_sparse_path.py -k driven_and",
        slow=True,
    ),
    Fault(
        "statics/sparse.py",
        "            if better:",
        "            if False:",
        "math/test_by_deformations.py -k forward_and_reverse",
        slow=True,
    ),
    Fault("build/assemble.py", "else stacked[places]", "else stacked", "build/test_properties.py -k traced_once"),
    Fault(
        "linear/sparse_poles.py",
        "< count:\n                raise",
        "<= count:\n                raise",
        "math/test_by_deformations.py -k settle",
    ),
    Fault(
        "paths/sparse_critical.py",
        "np.concatenate([motions, step], axis=1)",
        "motions",
        "paths/test_sparse_critical.py",
    ),
    Fault(
        "paths/sparse_critical.py",
        "if turn > 0 and not step_sizes[np.argmin(np.abs(values))] <= LOST_MOTION:",
        "if False:",
        "paths/test_sparse_critical.py",
    ),
    Fault(
        "paths/sparse_critical.py",
        "values, motions = ritz(motions)",
        "values = np.sort(np.einsum('ij,ij->j', motions, motions))",
        "math/test_by_deformations.py -k bifurcate",
        slow=True,
    ),
    Fault(
        "paths/sparse_critical.py",
        "sign * np.sign(soft[i].real)\n",
        "sign\n",
        "paths/test_sparse_critical.py",
    ),
    Fault(
        "math/by_deformations.py",
        "np.where(change <= still, 0.0, ",
        "np.where(False, 0.0, ",
        "math/test_by_deformations.py -k bear_alone",
    ),
    Fault(
        "linear/sparse_solve.py",
        "return jax.tree.leaves(function(*arguments))",
        "return jax.tree.map(np.zeros_like, jax.tree.leaves(function(*arguments)))",
        "design/test_sweep.py -k large_mechanisms_in_sweeps",
        slow=True,
    ),
    Fault(
        "statics/sparse.py",
        "return solution.reshape(right.shape), np.array",
        "return 0 * solution.reshape(right.shape), np.array",
        "design/test_sweep.py -k derivatives_of_large",
        slow=True,
    ),
    Fault(
        "linear/sparse_solve.py",
        "value * (mass @ y[:n])",
        "0 * (mass @ y[:n])",
        "linear/test_sparse.py -k derivatives_are",
        slow=True,
    ),
    Fault(
        "math/by_deformations.py",
        "if not before <= left:",
        "if False:",
        "math/test_by_deformations.py -k help",
        slow=True,
    ),
    # Large mechanisms without a potential.
    Fault(
        "statics/tangent.py",
        "[*pulling, *load_pieces(topology, parameters, factors, x)]",
        "pulling",
        "linear/test_sparse_poles.py -k slowest",
    ),
    Fault(
        "linear/sparse_solve.py",
        "transpose_solve=solve(True)",
        "transpose_solve=solve(False)",
        "linear/test_sparse_poles.py -k differences",
        slow=True,
    ),
    Fault(
        "linear/sparse_poles.py",
        "return at.shift + 1 / inverse",
        "return 1 / inverse",
        "linear/test_sparse_poles.py -k free",
    ),
    Fault(
        "linear/sparse_poles.py",
        "if i > 0 and np.max(np.abs(values), initial=0.0) <= least * (1 + TRUE_POLE):",
        "if i > 0:",
        "linear/test_sparse_poles.py::test_free_motions_have_poles_at_zero",
    ),
    Fault(
        "linear/spectrum.py", "order[: count + int(pair)]", "order[:count]", "linear/test_sparse_poles.py -k slowest"
    ),
    Fault(
        "control/second_order_form.py",
        "_carried(lin, transposed(elements), held, library)",
        "_carried(lin, elements, held, library)",
        "linear/test_sparse_poles.py -k responses",
        slow=True,
    ),
    Fault(
        "control/harmonic.py",
        "((0, n_multipliers), (0, 0))), transposed=True)",
        "((0, n_multipliers), (0, 0))))",
        "linear/test_sparse_poles.py -k differences",
        slow=True,
    ),
    Fault("math/sparse.py", "return -1 if odd % 2 else 1", "return 1", "paths/test_sparse_critical.py -k sign"),
    Fault(
        "math/sparse.py",
        "return n - int(connected",
        "return n - 1 + 0 * int(connected",
        "paths/test_sparse_critical.py -k sign",
    ),
    Fault(
        "paths/sparse_critical.py",
        "(-1) ** n_constraints * factored",
        "factored",
        "paths/test_sparse_critical.py -k sign",
    ),
    Fault(
        "linear/sparse_poles.py",
        "is_real(values) & (np.real(values) > 0)",
        "is_real(values) | (np.real(values) > 0)",
        "linear/test_sparse_poles.py -k steadiness",
        slow=True,
    ),
    Fault(
        "linear/sparse_poles.py",
        "values = 1 / inverse[np.abs(inverse) > MASSLESS_SHARE * at.n * np.max(np.abs(inverse), initial=0.0)]",
        "values = 1 / inverse",
        "linear/test_sparse_poles.py -k steadiness",
        slow=True,
    ),
    Fault(
        "linear/sparse_poles.py",
        "self._moved(matrix @ (self._scale * v)) / self._scale",
        "self._moved(matrix @ v) / self._scale",
        "linear/test_sparse_poles.py -k steadiness",
        slow=True,
    ),
    Fault("paths/sparse_path.py", "stable[i] = is_steady", "_ = is_steady", "paths/test_path.py -k takes_stability"),
    Fault(
        "math/sparse.py",
        "raise AnalysisError(RESULTS.out_of_memory.name, RESULTS.out_of_memory.message) from None",
        "pass",
        "statics/test_sparse.py -k memory_that_does_not_suffice",
        slow=True,
    ),
    Fault("model/model.py", "if needed > available:", "if False:", "statics/test_sparse.py -k memory_does_not_hold"),
    Fault("math/bordered.py", "self._corner * first", "0.0 * first", "math/test_bordered.py"),
    Fault("math/bordered.py", "entire[-1] *= self._by_column", "entire[-1] *= 1.0", "math/test_bordered.py"),
    Fault(
        "math/sparse.py",
        "last[0].dtype != data.dtype or",
        "False or",
        "paths/test_sparse_states.py -k response",
        slow=True,
    ),
    Fault(
        "control/truncation.py",
        "off_resonance = np.abs(grid[:, None] - hertz) >",
        "off_resonance = np.abs(grid[:, None] - hertz) >= 0 *",
        "paths/test_sparse_states.py -k resonance",
    ),
    Fault(
        "linear/sparse_buckling.py",
        "(put(first, constrained, 0.0),)",
        "(first,)",
        "paths/test_sparse_states.py -k coupled",
        slow=True,
    ),
    # Questions about a stated state.
    Fault(
        "linear/modes.py",
        "matrices(topology, parameters, target)",
        "matrices(topology, parameters, LoadFactors(1.0, 0.0))",
        "linear/test_states.py -k share",
        slow=True,
    ),
    Fault(
        "paths/stepper.py",
        "load_factors(load, 0.0) if",
        "load_factors(1.0, 0.0) if",
        "questions/test_over_states.py::test_critical_points_are_states_too",
        slow=True,
    ),
    Fault("linear/stress.py", "axis=(-3, -2, -1))", "axis=(-2, -1))", "linear/test_states.py -k one_call", slow=True),
    Fault("motion/motion.py", "<= SAME_TIME *", "<= 1.0 *", "linear/test_states.py -k no_time_of", slow=True),
    Fault(
        "spacar/light.py",
        "return damped(lin",
        "return lin or damped(lin",
        "spacar/test_light.py -k damping_ratio",
        slow=True,
    ),
    # What is drawn along a path.
    Fault(
        "questions/node_stiffness.py",
        "return 1 / flexibility\n",
        "return flexibility\n",
        "questions/test_over_states.py::test_critical_points_are_states_too",
        slow=True,
    ),
    Fault(
        "paths/path.py",
        "numbers: Any = critical.x, last_strain, None, critical.load_factor",
        "numbers: Any = critical.x, last_strain, None, 1.0",
        "questions/test_over_states.py -k critical",
    ),
    Fault(
        "plot/canvas.py",
        "return 1 / by, prefix",
        "return by, prefix",
        "plot/test_plot.py::test_mechanism_shows_supports_dofs_loads_and_names",
    ),
    Fault(
        "plot/canvas.py", "round(value * factor, 6)", "round(value / factor, 6)", "plot/test_plot.py -k shows_supports"
    ),
    Fault(
        "plot/canvas.py",
        "moved = _free(boxes[i], bounds, occupied)",
        "moved = boxes[i]",
        "plot/test_plot.py -k many_self",
    ),
    Fault(
        "plot/stress.py", "np.argmax(np.abs(values))", "np.argmin(np.abs(values))", "plot/test_plot.py -k cantilever"
    ),
    # Trajectories.
    Fault(
        "trajectory/varying_equations.py",
        "if rtol is not None and traced:",
        "if False:",
        "trajectory/test_linear_along.py -k beside_a_number",
    ),
    Fault(
        "trajectory/varying_equations.py",
        "2 * (h[:-1] + h[1:])",
        "(h[:-1] + h[1:])",
        "trajectory/test_linear_along.py -k scipy",
    ),
    Fault(
        "trajectory/varying_equations.py",
        "+ h**2 * second[:, :, None, None]",
        "+ h**2 * first[:, :, None, None]",
        "trajectory/test_linear_along.py -k order_five",
    ),
    Fault(
        "trajectory/slow_modes.py",
        "return common - flexibility @ stiffness @ common, flexibility",
        "return common, flexibility",
        "trajectory/test_linear_along.py -k reduction",
        slow=True,
    ),
    Fault(
        "trajectory/linear_along.py",
        "np.swapaxes(row, 1, -1).reshape",
        "row.reshape",
        "trajectory/test_linear_along.py -k names_of_spacar",
    ),
    Fault(
        "trajectory/linear_along.py",
        "np.any(np.asarray(times) > last + slack)",
        "False",
        "trajectory/test_linear_along.py -k cannot",
    ),
    Fault(
        "trajectory/vibrations.py",
        "-holding, jnp",
        "holding, jnp",
        "trajectory/test_vibrations.py -k nonlinear_motion",
        slow=True,
    ),
    Fault(
        "trajectory/vibrations.py",
        "(*driven, *loads_of_freedoms(model.topology, self.t, -self.held))",
        "driven",
        "trajectory/test_vibrations.py -k nonlinear_motion",
        slow=True,
    ),
    Fault(
        "motion/motion.py",
        "under_inputs(model, without_inputs, u)",
        "without_inputs",
        "trajectory/test_vibrations.py -k controller",
        slow=True,
    ),
    Fault("trajectory/laws.py", "cbrt(far * j**2 / 2)", "cbrt(far * j**2)", "trajectory/test_laws.py -k shortest"),
    Fault("trajectory/laws.py", "5: (15 / 8,", "5: (15 / 7,", "trajectory/test_laws.py -k limits"),
    Fault("trajectory/laws.py", "range(1, (degree + 1) // 2)", "range(1, 1)", "trajectory/test_laws.py -k splines"),
    Fault("trajectory/laws.py", "-np.pi * ratio / root", "-np.pi * ratio", "trajectory/test_laws.py -k shapers"),
    Fault("trajectory/inverse.py", "second - reached", "second", "trajectory/test_inverse.py -k dimension", slow=True),
    Fault(
        "trajectory/about_motion.py",
        "lambda _, f: -f[:, n:]",
        "lambda _, f: f[:, n:]",
        "trajectory/test_inverse.py -k held",
        slow=True,
    ),
    Fault(
        "trajectory/inverse.py",
        "(missed < MISSED_CONFIGURATION)",
        "(missed < 1.0)",
        "trajectory/test_inverse.py -k beyond_the_arm",
        slow=True,
    ),
    Fault(
        "trajectory/inverse.py",
        "jnp.where(plant, RESULTS.successful,",
        "jnp.where(True, RESULTS.successful,",
        "trajectory/test_inverse.py -k wrong_inputs",
        slow=True,
    ),
    Fault(
        "trajectory/flexible.py", "p[:stable] - x @ p[stable:]", "p[:stable]", "trajectory/test_flexible.py -k fourier"
    ),
    Fault("trajectory/flexible.py", "if np.any(on_axis):", "if False:", "trajectory/test_flexible.py -k refused"),
    Fault(
        "trajectory/flexible.py",
        "if np.max(jumps) > JUMP_OF_LAW",
        "if np.max(jumps) > 1e9 * JUMP_OF_LAW",
        "trajectory/test_flexible.py -k refused",
    ),
    Fault(
        "trajectory/inverse.py",
        "if self.moved and parameters.start is not None",
        "if False",
        "trajectory/test_inverse.py -k elbow",
        slow=True,
    ),
    Fault(
        "trajectory/laws.py",
        "xp.where(way == 0, 1.0, xp.abs(way))",
        "xp.abs(way)",
        "trajectory/test_laws.py -k nowhere",
    ),
    Fault("control/state_space.py", "if not off < REPORTED_ERROR", "if off < 0", "control/test_state_space.py -k word"),
    Fault("motion/drives_by_name.py", "weight * function(t)", "function(t)", "motion/test_loop.py -k actuator"),
    Fault(
        "cli.py",
        'dataclasses.replace(system, u0=jnp.asarray(result.data["u0"], float))',
        "dataclasses.replace(system)",
        "answers/test_trajectory.py -k unit",
        slow=True,
    ),
    # Functional mock-up units.
    Fault(
        "fmu/algebra.c",
        "a[i * n + j] *= d[i] / d[j]",
        "a[i * n + j] *= d[j] / d[i]",
        "fmu/test_save.py::test_time_varying_plant_agrees_with_an_independent_integration",
    ),
    Fault(
        "fmu/linear.c",
        "- off / 2 * (there[i] - back[i])",
        "+ off / 2 * (there[i] - back[i])",
        "fmu/test_save.py -k independent",
    ),
    Fault("fmu/linear.c", "y[j] += m[OF_Y0 + j]", "y[j] -= m[OF_Y0 + j]", "fmu/test_save.py -k independent"),
    Fault("fmu/linear.c", "if (unit->stale) {", "if (unit->stale < 0) {", "fmu/test_save.py -k can_be_set"),
    Fault("fmu/core.c", "if (memcmp(state", "if (0 && memcmp(state", "fmu/test_save.py -k can_be_set"),
    Fault("fmu/core.c", "strcmp(token, TOKEN) != 0", "strcmp(token, TOKEN) == 2", "fmu/test_save.py -k importer"),
    Fault(
        "fmu/nonlinear.c",
        "(rates[i] - k[i]) / (at[n]",
        "(k[i] - rates[i]) / (at[n]",
        "fmu/test_save.py -k own_integrator",
    ),
    Fault("fmu/nonlinear.c", "&& passes_over(unit, t, step, x, to)", "&& 0", "fmu/test_save.py -k stop"),
    Fault("fmu/plant.py", "#define BENDS {int(bends)}", "#define BENDS 0", "fmu/test_save.py -k stop"),
    Fault("mechanics/loads.py", '"save_fmu": "Build', '"plant": "Build', "fmu/test_save.py -k stop"),
    Fault("fmu/save.py", "np.ones(1)", "np.zeros(1)", "fmu/test_save.py -k large"),
    Fault(
        "fmu/description.py", 'if "D" in plant.matrices or', 'if "A" in plant.matrices or', "fmu/test_save.py -k valid"
    ),
    Fault("fmu/plant.py", "if v.name in shared else v", "if not shared else v", "fmu/test_save.py -k valid"),
    Fault("fmu/plant.py", "if system.dt:", "if system.dt is True:", "fmu/test_save.py -k refused"),
    Fault("fmu/save.py", "if run.returncode:", "if run.returncode < 0:", "fmu/test_save.py -k refuses"),
    Fault("cli.py", 'if fmi not in ("2", "3"):', 'if fmi not in ("1", "2", "3"):', "test_cli.py -k fmu"),
    # Pictures, pages, files.
    Fault(
        "plot/state.py", "base + scale * (x - base)", "base - scale * (x - base)", "plot/test_plot.py -k deformed_shape"
    ),
    Fault("plot/bode.py", "DECAY) * 2 * np.pi * hertz", "DECAY) * hertz", "plot/test_plot.py -k bode"),
    Fault("plot/bode.py", "(1j + DECAY)", "(1j - DECAY)", "plot/test_plot.py -k bode"),
    Fault("plot/bode.py", "np.unwrap(np.angle(response))", "np.angle(response)", "plot/test_plot.py -k bode"),
    Fault("linear/modes.py", "if hertz >= 0 else", "if True else", "plot/test_plot.py -k say_so"),
    Fault("viewer/page.py", '.replace("<", "\\\\u003c")', "", "viewer/test_view.py -k names_cannot"),
    Fault("viewer/scene.py", "rate = 1 / (2 * step)", "rate = 1 / step", "viewer/test_view.py -k modes_move"),
    Fault(
        "workbench/live.py",
        "message=message, stale=True, **self._good)",
        "message=message, stale=False, **self._good)",
        "workbench/test_live.py -k keeps_the_last",
    ),
    Fault("workbench/live.py", "-1.0 if before @ shape < 0 else 1.0", "1.0", "workbench/test_stage.py -k side"),
    Fault("workbench/counts.py", '"over": 0,', '"over": 1,', "workbench/test_counts.py -k tutorial"),
    Fault("workbench/session.py", "now - self._last < PACE", "False", "workbench/test_preview.py"),
    Fault("workbench/from_builder.py", "if len(positions) == 1 and", "if", "workbench/test_merged.py"),
    Fault("workbench/calls_of.py", "row.get(number, 0.0)", "0.0", "workbench/test_from_builder.py -k every_feature"),
    Fault("workbench/dat_file.py", "str(int(owner) + 1)", "str(int(owner) + 2)", "workbench/test_dat_file.py -k saved"),
    Fault("workbench/values.py", "short.adjusted() <= 9", "short.adjusted() <= 30", "workbench/test_sums.py"),
    Fault("workbench/values.py", 'return f"-{_term(a)}"', 'return f"-{a}"', "workbench/test_sums.py"),
    Fault("workbench/compare.py", "/ abs(before)", "/ before", "workbench/test_compare.py"),
    Fault(
        "workbench/live_answers.py",
        "1 / entry if entry",
        "entry if entry",
        "workbench/test_live.py -k public_functions",
        slow=True,
    ),
    Fault("workbench/ways.py", "0.0) + slope / value", "0.0) + slope", "workbench/test_ways.py -k powers", slow=True),
    Fault("files.py", "if name not in new_names:\n", "if True:\n", "answers/test_files.py"),
    Fault(
        "errors.py",
        "            messages.append(text)\n        return\n",
        "            pass\n",
        "test_cli.py -k warnings_of_the_package",
    ),
    Fault(
        "results.py",
        "np.max(np.where(np.isin(codes, ANSWERED)",
        "np.min(np.where(np.isin(codes, ANSWERED)",
        "test_errors.py -k worst_of_a_batch",
    ),
    # Matrices of elements, held in one way by statics, paths, modes and responses.
    Fault(
        "math/element_matrices.py",
        "SparseFactors(self._matrix(self._d) + ",
        "SparseFactors(self._matrix(self._k) + ",
        "statics/test_sparse.py -k told_apart",
    ),
    Fault(
        "paths/sparse_walk.py",
        "by_state + turn.forces_of",
        "by_state - turn.forces_of",
        "paths/test_sparse_path.py -k driven_and",
        slow=True,
    ),
    Fault(
        "statics/tangent.py",
        "unconstrained[at][:, :, None] * matrices * unconstrained[by][:, None, :]",
        "matrices",
        "paths/test_sparse_states.py -k coupled",
        slow=True,
    ),
    Fault(
        "compilation/program.py",
        "if not isinstance(function, Record):",
        "if True:",
        "compilation/test_kept.py -k laws_and_tables",
    ),
    Fault("arguments.py", "if not is_concrete(arrays):", "if True:", "compilation/test_known_numbers.py"),
    Fault(
        "compilation/by_meaning.py",
        "program = captured(functools.partial(function, **options), *shapes, formal=FORMAL)",
        "pass",
        "compilation/test_by_meaning.py -k other_derivatives",
    ),
    Fault(
        "compilation/by_meaning.py",
        "compile.exact(tuple(sorted(options.items())))",
        "tuple(sorted(options.items()))",
        "compilation/test_by_meaning.py -k not_the_same",
    ),
    Fault(
        "compilation/compile.py",
        "return tuple(map(exact, thing))",
        "return thing",
        "compilation/test_by_meaning.py -k not_the_same",
    ),
    Fault("paths/walk.py", "len(self.steps) == 1 and begin.singular", "False", "paths/test_path.py -k elastic"),
    Fault(
        "statics/equilibrium.py",
        "if missing := without_stiffness(known):",
        "if (missing := without_stiffness(known)) and False:",
        "paths/test_path.py -k elastic",
    ),
    Fault("compilation/compile.py", "if used > share * most:", "if False:", "compilation/test_room.py"),
    # Where loads bend.
    Fault(
        "motion/stages.py",
        "t - jax.lax.stop_gradient(jnp.maximum(t - end, 0.0))",
        "t",
        "motion/test_bends.py -k beyond_it",
        slow=True,
    ),
    Fault(
        "motion/drives_by_name.py",
        "jax.lax.stop_gradient(jnp.asarray(table.times, float))",
        "jnp.asarray(table.times, float)",
        "motion/test_bends.py -k table",
    ),
    Fault(
        "motion/drive.py",
        "jnp.where(t > times[-1], values[-1], inside)",
        "jnp.minimum(inside, values[-1])",
        "motion/test_bends.py -k table",
    ),
    Fault(
        "motion/drives_by_name.py",
        "if jumps.ndim != 1:",
        "if np.ndim(drives.jumps) != 1:",
        "motion/test_bends.py -k one_by",
    ),
    Fault("motion/simulate.py", "with _naming_the_adjoint():", "if True:", "motion/test_bends.py -k forward"),
    Fault(
        "motion/drive.py",
        "leaves = jax.tree.leaves(value, is_leaf=lambda leaf: isinstance(leaf, Table))",
        "leaves = [value]",
        "motion/test_bends.py -k made_of",
    ),
    # Within jax.jit what is known is known; what goes too far between two times.
    Fault(
        "motion/simulate.py",
        "np.all(np.isfinite(np.asarray(initial.x)[-1]))",
        "np.all(np.isfinite(np.asarray(initial.x[-1])))",
        "motion/test_simulate.py -k velocity_of_its",
        slow=True,
    ),
    Fault(
        "trajectory/laws.py",
        "known = exact if xp is np else jax.lax.stop_gradient(exact)",
        "known = jax.lax.stop_gradient(exact)",
        "trajectory/test_laws.py -k splines_pass",
    ),
    Fault(
        "arguments.py",
        "isinstance(value, dict) or (not traced",
        "(not traced",
        "test_arguments.py -k test_numbers",
    ),
    Fault("trajectory/inverse.py", "> most * size:", "> 1e9 * most:", "trajectory/test_inverse.py -k too_many"),
    # Degrees of freedom that are found beside named ones; what modes leave out; loops, noise and flutter.
    Fault(
        "build/dofs.py",
        "for i in block.element.lengths if i < len(fields)",
        "for i in ()",
        "build/test_dofs.py -k beside_the_stage",
    ),
    Fault(
        "control/state_space.py",
        "left_out(by_p[i] * (orders >= i).astype(float))",
        "left_out(by_p[i] * 0.0)",
        "control/test_truncation.py -k carried_along",
        slow=True,
    ),
    Fault(
        "control/state_space.py",
        "c_q[1] = c_q[1] - by_rates",
        "c_q[1] = c_q[1] + by_rates",
        "control/test_truncation.py -k carried_along",
        slow=True,
    ),
    Fault(
        "control/truncation.py",
        "-matrix_times(elements.damping, shapes, size=n_x)]",
        "matrix_times(elements.damping, shapes, size=n_x)]",
        "control/test_truncation.py -k carried_along",
        slow=True,
    ),
    Fault(
        "control/truncation.py",
        "(large_form.orders >= i).astype(float)",
        "(large_form.orders > i).astype(float)",
        "control/test_truncation.py -k carried_along",
        slow=True,
    ),
    Fault(
        "control/stability.py",
        "    if not n_passed:\n",
        "    if True:\n",
        "control/test_loops.py -k sampled_loop_feels",
    ),
    Fault(
        "control/feedback.py",
        "c = jnp.where(massive | (jnp.abs(c) > NEGLIGIBLE",
        "c = jnp.where(massive | (jnp.abs(c) >= 0 * NEGLIGIBLE",
        "control/test_noise.py -k motions_without_mass",
    ),
    Fault(
        "control/noise_frequencies.py",
        "sharp = steps > CHANGE_OF_RESPONSE",
        "sharp = steps > 100",
        "control/test_noise.py::test_a_loop_without_damping_that_a_function_of_frequencies_closes_is_told",
    ),
    Fault(
        "control/noise_frequencies.py",
        "np.max(off, axis=1) > CURVED_DENSITY * size",
        "np.max(off, axis=1) > 100 * size",
        "control/test_noise.py -k lines_and_jumps",
        slow=True,
    ),
    Fault(
        "control/noise_frequencies.py",
        "steps == 1.0",
        "steps > 0.0",
        "control/test_noise.py -k lines_and_jumps",
        slow=True,
    ),
    Fault(
        "control/noise_frequencies.py",
        "with jax.ensure_compile_time_eval():",
        "with jax.disable_jit(False):",
        "control/test_noise.py -k lines_and_jumps",
        slow=True,
    ),
    Fault(
        "control/noise_frequencies.py", "    if gaps.size:\n", "    if False:\n", "control/test_noise.py -k too_rough"
    ),
    Fault(
        "control/noise_frequencies.py",
        "hertz >= grid[0]",
        "hertz >= grid[-1]",
        "control/test_noise.py -k resonance_without",
    ),
    Fault(
        "control/noise_frequencies.py",
        "hertz <= grid[-1])",
        "hertz >= 0)",
        "control/test_noise.py -k resonance_without",
    ),
    Fault(
        "control/noise_frequencies.py",
        "if abs(excess) > UNRESOLVED_SHARE",
        "if abs(excess) > 1e9 * UNRESOLVED_SHARE",
        "control/test_noise.py -k do_not_resolve_a_resonance",
    ),
    Fault(
        "control/noise.py",
        "DRIFTING_NOISE * np.asarray",
        "1e9 * np.asarray",
        "control/test_noise.py -k one_mass",
        slow=True,
    ),
    Fault(
        "control/pole_placement.py",
        "one_mass(_moved(plant[y_index, to]))",
        "one_mass(plant[y_index, to])",
        "control/test_loops.py -k floor_that_moves",
    ),
    Fault(
        "control/pole_placement.py",
        "abs(rate) * fast > POSITION_OUTPUT",
        "abs(rate) * fast > 1e-9 * POSITION_OUTPUT",
        "control/test_loops.py -k floor_that_moves",
    ),
    Fault(
        "trajectory/about_motion.py",
        "if excitation.given is not None:",
        "if False:",
        "trajectory/test_vibrations.py -k inputs_of",
        slow=True,
    ),
    Fault(
        "linear/buckling.py",
        "is_real(inverse) & _is_resolved(operator, inverse, conditions)",
        "is_real(inverse)",
        "linear/test_buckling.py -k follows_a_column",
        slow=True,
    ),
    Fault(
        "linear/buckling.py",
        "hidden = (complex_ones > noise)",
        "hidden = (complex_ones < 0)",
        "linear/test_buckling.py -k follows_a_column",
        slow=True,
    ),
    Fault(
        "answers/answer_parts.py",
        "    if m.symmetric:\n        return",
        "    if True:\n        return",
        "answers/test_answers.py -k fixed_axis",
        slow=True,
    ),
    Fault(
        "linear/spectrum.py",
        "return not any_grows(",
        "return any_grows(",
        "answers/test_answers.py -k fixed_axis",
        slow=True,
    ),
    Fault(
        "numerical_limits.py",
        "FAR_BEFORE_BUCKLING = 0.3",
        "FAR_BEFORE_BUCKLING = 1e9",
        "linear/test_buckling.py -k far_before",
    ),
    Fault(
        "linear/sparse_buckling.py",
        "dx = x - reference if",
        "dx = x if",
        "linear/test_buckling.py -k far_before",
    ),
    Fault(
        "linear/measures.py",
        "    if of_modes.q_labels == model.q_labels:",
        "    if True:",
        "linear/test_measures.py -k whatever",
    ),
    Fault(
        "linear/about.py", "if shape != their_shape or any(", "if False and any(", "linear/test_states.py -k together"
    ),
    Fault(
        "linear/about.py",
        "(at.labels.x, at.labels.elements) != (",
        "(at.labels.x, labels.elements) != (",
        "linear/test_states.py -k together",
    ),
    Fault(
        "motion/events.py",
        "if value.dtype == bool and",
        "if value.dtype == int and",
        "compilation/test_captured.py -k told",
    ),
    Fault(
        "motion/kinks.py",
        "changes > JUMP_AT_KINK * first",
        "changes > 9 * first",
        "motion/test_kinks.py -k jumps",
        slow=True,
    ),
    Fault(
        "build/clamps.py",
        "clamps, warps = clamps | angled, warps",
        "flat, warps = flat | angled, warps",
        "design/test_other_clamps.py -k widths",
        slow=True,
    ),
    Fault(
        "build/clamps.py",
        "if free and was is not None",
        "if was is not None",
        "design/test_other_clamps.py -k widths",
        slow=True,
    ),
    Fault(
        "design/chunks.py", "except (ValueError, *REFUSED):", "except ZeroDivisionError:", "design/test_other_clamps.py"
    ),
    Fault(
        "design/chunks.py",
        "            except REFUSED:",
        "            except ZeroDivisionError:",
        "design/test_other_clamps.py",
    ),
    Fault(
        "design/checkpoint.py", "set(values) != set(", "list(values) != list(", "design/test_checkpoint.py -k any_order"
    ),
    Fault("design/evaluate.py", "max(codes, default=", "min([], default=", "design/test_unstable.py -k compiled"),
    Fault("design/settling.py", "max_squarings=SQUARINGS", "max_squarings=2", "design/test_settling.py -k stiff"),
    Fault(
        "design/search.py",
        "if all(problem.violation",
        "if any(problem.violation",
        "design/test_tune.py -k infeasible",
        slow=True,
    ),
    Fault("design/lean.py", "np.where(given > 0, given, 1.0)", "1.0", "design/test_lean.py -k side_by_side"),
    Fault(
        "design/lean.py",
        "np.asarray(lin.matrices.e)[free] * weight\n",
        "0 * weight\n",
        "design/test_lean.py -k constant_load",
    ),
    Fault("compilation/program.py", "if any(_may_bend(", "if all(_may_bend(", "compilation/test_program.py -k bend"),
    Fault(
        "results.py",
        "worse = graded[worst] > grade",
        "worse = graded[worst] < grade",
        "design/test_unstable.py -k worse",
    ),
    Fault("statics/stroke.py", "jnp.where(jnp.any(unstable)", "jnp.where(jnp.all(unstable)", "design/test_unstable.py"),
    Fault("linear/linearize.py", "    collect_unstable([m", "    print([m", "design/test_unstable.py -k compliance"),
    Fault(
        "statics/stable.py",
        "        collect(jnp.where(unstable, ",
        "        collect(jnp.where(False, ",
        "design/test_unstable.py -k sweep",
    ),
    Fault("design/tune.py", "if best.unit.tobytes() in", "if best.unit in", "design/test_unstable.py -k optima"),
    Fault(
        "design/sensitivities.py",
        "if result is RESULTS.unstable_state:",
        "if result is RESULTS.critical_state:",
        "design/test_unstable.py -k optima",
    ),
    # Designs whose leaf springs are clamped otherwise.
    Fault(
        "build/clamps.py",
        "jnp.min(jnp.stack(thick)) >= THICK",
        "jnp.min(jnp.stack(thick)) >= 100",
        "design/test_other_clamps.py -k sweep",
        slow=True,
    ),
    Fault(
        "build/clamps.py",
        "flat |= jnp.abs(along @ along_other) < np.cos(FOLD)",
        "flat |= flat",
        "design/test_other_clamps.py -k sweep",
        slow=True,
    ),
    Fault(
        "design/chunks.py",
        "codes == RESULTS.other_clamps",
        "codes == 99",
        "design/test_other_clamps.py -k sweep",
        slow=True,
    ),
    Fault(
        "design/tune.py",
        "np.any(codes == RESULTS.other_clamps)",
        "False",
        "design/test_other_clamps.py -k search",
        slow=True,
    ),
    # Parameters from measurements.
    Fault(
        "identification/problem.py",
        "change[i] / prior.deviation",
        "change[i]",
        "identification/test_fit.py -k combination",
    ),
    Fault(
        "design/tolerance.py",
        "added = np.maximum(added, np.maximum(",
        "added = np.minimum(added, np.maximum(",
        "design/test_sensitivities.py -k many_dimensions",
    ),
    Fault("identification/fitted.py", "(1 + level) / 2", "level", "identification/test_fit.py -k straight"),
    Fault(
        "identification/study_data.py",
        "for name in columns if name in header} | dict(chosen)",
        "for name in columns if name in header and not chosen} | dict(chosen)",
        "identification/test_fit_study.py -k override",
    ),
    Fault(
        "identification/fit.py",
        "np.abs(differences) / np.sqrt(remaining), sizes",
        "differences / np.sqrt(remaining), sizes",
        "identification/test_uneven.py -k proportion",
    ),
    Fault(
        "identification/response_data.py",
        "np.hypot(real, imaginary), 2)",
        "np.abs(np.log(np.hypot(real, imaginary))), 2)",
        "identification/test_uneven.py -k proportion",
    ),
    Fault(
        "identification/fit.py",
        "chi2.cdf(square, freedom)",
        "chi2.sf(square, freedom)",
        "identification/test_fit.py -k far_below",
    ),
    Fault(
        "identification/problem.py",
        "known = self.items[0].scatter is not None",
        "known = True",
        "identification/test_fit.py -k unit_of_values",
    ),
    Fault(
        "identification/measurement.py",
        "(item.scatter, differences, lower=True)",
        "(item.scatter, differences)",
        "identification/test_fit.py -k covariance",
    ),
    Fault(
        "identification/mode_pairing.py",
        "hungarian_algorithm(-alike)",
        "hungarian_algorithm(alike)",
        "identification/test_measurements.py",
    ),
    Fault("identification/problem.py", "^{-change[i]", "^{change[i]", "identification/test_fit.py -k combination"),
    Fault(
        "identification/response_data.py",
        "-2 * np.pi * places",
        "2 * np.pi * places",
        "identification/test_measurements.py -k response",
    ),
    Fault(
        "identification/repeated.py",
        "weighted = end.slopes",
        "weighted = slopes",
        "identification/test_repeated.py -k closed_form",
    ),
    Fault(
        "identification/fitted.py",
        "np.sqrt(squares / max(",
        "np.sqrt(squares + 0 * max(",
        "identification/test_repeated.py",
    ),
    Fault(
        "identification/study_data.py",
        "if any(row[len(header) :]):",
        "if False:",
        "identification/test_fit_study.py -k one_line",
    ),
    Fault(
        "identification/fitted.py",
        "ends.converged & ~refused",
        "ends.converged | refused",
        "identification/test_repeated.py -k impossible",
    ),
    Fault(
        "identification/fit.py", "not one.converged, one.cost", "one.converged, one.cost", "identification/test_fit.py"
    ),
    # Words and calls.
    Fault("cli.py", 'str(log) == "-"', 'str(log) == "--"', "test_cli.py -k wrong_call"),
    Fault("spacar/write.py", "if stiffness and not idle", "if stiffness", "spacar/test_read.py -k survives"),
    Fault(
        "linear/modes.py", "or without_stiffness(lin.model)", 'or ""', "statics/test_refusals.py -k without_stiffness"
    ),
    Fault(
        "linear/buckling.py",
        "    check_stiffness(model, result, throw)",
        "    check_stiffness(model, result, False)",
        "statics/test_refusals.py -k without_stiffness",
    ),
    # Kinks of laws and controllers.
    Fault(
        "motion/kinks.py",
        "refused = jnp.any(changes > 0) & (t1 - t0 > short)",
        "refused = jnp.any(changes > 0) & False",
        "motion/test_kinks.py::test_derivatives_across_the_limit_of_a_controller",
    ),
    Fault(
        "numerical_limits.py",
        "STEP_AT_KINK = 1e-6",
        "STEP_AT_KINK = 1e-1",
        "motion/test_kinks.py::test_derivatives_across_the_limit_of_a_controller",
    ),
    Fault("motion/kinks.py", "or _controller_may_bend(equations)", "or False", "motion/test_kinks.py -k limit"),
    Fault("motion/kinks.py", "> jnp.abs(change))", "> jnp.inf)", "motion/test_kinks.py -k met_and_left"),
    Fault("motion/kinks.py", "h * begin.w - moved", "0 * moved", "motion/test_kinks.py -k met_and_left"),
    Fault(
        "motion/kinks.py",
        "ptp(straight, axis=0), changes)",
        "ptp(straight, axis=0), 0.0)",
        "motion/test_kinks.py -k met_within",
        slow=True,
    ),
    Fault("motion/kinks.py", "bend > KINK_OVER_SLOPE * steep", "bend > 0 * steep", "motion/test_kinks.py -k smoothly"),
    Fault("motion/kinks.py", "bend > KINK_OVER_USUAL * usual", "bend > 0 * usual", "motion/test_kinks.py -k smoothly"),
    Fault("motion/kinks.py", "steep > NEGLIGIBLE *", "steep > 0 *", "motion/test_kinks.py -k smoothly"),
    Fault("linear/spectrum.py", "    if np.any(c):", "    if False:", "paths/test_path.py -k takes_stability"),
    Fault(
        "linear/sparse_poles.py",
        "    if assembled.damping.count_nonzero():",
        "    if False:",
        "paths/test_path.py -k takes_stability",
    ),
    Fault(
        "answers/mode_1_simulate.py",
        "/ max(extent, 1.0)",
        "/ extent",
        "answers/test_answers.py -k tolerances",
        slow=True,
    ),
    Fault(
        "answers/answers.py", "if not (moves and", "if not (mode == 1 and", "answers/test_trajectory.py -k rates_are"
    ),
    Fault("cli.py", "        if name in numbers:\n", "        if False:\n", "test_cli.py -k wrong_call"),
    Fault(
        "motion/sudden.py",
        "not named and not is_concrete(f)",
        "not is_concrete(f)",
        "motion/test_sudden.py -k to_be_named",
    ),
    Fault(
        "motion/sudden.py",
        "if steps[at] > max(JUMP_OF_RANGE,",
        "if steps[at] < max(JUMP_OF_RANGE,",
        "motion/test_sudden.py -k to_be_named",
    ),
    Fault(
        "statics/newton_search.py", "refused = refused & ~loose", "pass", "statics/test_stable.py -k double_pendulum"
    ),
    Fault("build/plain_beams.py", "np.radians(15.0)", "np.radians(1.0)", "build/test_plain_beams.py -k along_an_arc"),
    Fault(
        "statics/newton_search.py",
        "unknown_motions > 0 and not prescribed and self",
        "True",
        "statics/test_refusals.py -k crank",
    ),
    Fault(
        "control/stability.py",
        "seen = np.concatenate([poles, closed])",
        "seen = poles",
        "control/test_loops.py -k far_beyond",
    ),
    Fault(
        "control/stability.py",
        "pairs.append((0.0, float(np.real(self(0.0)))))",
        "pass",
        "control/test_loops.py -k jumps_at",
    ),
    Fault(
        "control/stability.py",
        "if abs(abs(near) - abs(far)) < LEVEL_AT_REST * abs(far):",
        "if False:",
        "control/test_loops.py -k rigid_motion_that",
    ),
    Fault("control/stability.py", "    if plant.dt:", "    if False:", "control/test_loops.py -k bad_controllers"),
    Fault(
        "motion/controllers.py", "if wrong := [name", "if False and [name", "control/test_loops.py -k bad_controllers"
    ),
    Fault("control/stability.py", "= UNSURE * np", "= 1e9 * np", "control/test_loops.py -k slow_motion_beside"),
    Fault("control/stability.py", "low[passes]", "low", "control/test_loops.py -k weak_coupling"),
    Fault(
        "control/stability.py",
        "return grid[np.diff(grid, prepend=0.0) > TWIN_FREQUENCIES * grid]",
        "return found",
        "control/test_loops.py -k least_distance",
    ),
    Fault(
        "build/idle.py",
        "@jit_beside_options\ndef _diagonals",
        "def _diagonals",
        "build/test_idle.py -k one_program",
    ),
    Fault(
        "trajectory/inverse.py",
        "computed(lambda xp, result: xp.max(result), solution.result)",
        "jnp.max(solution.result)",
        "trajectory/test_inverse.py -k no_operation",
    ),
    Fault(
        "trajectory/laws.py",
        "np.shape(self.coefficients)[2:]",
        "()",
        "trajectory/test_laws.py -k several_numbers",
    ),
    Fault(
        "trajectory/about_motion.py",
        "signs[1:] * signs[:-1] < 0",
        "signs[1:] * signs[:-1] < -2",
        "trajectory/test_linear_along.py -k dead_point",
        slow=True,
    ),
    Fault("motion/full_turns.py", "speed = 2 *", "speed = 4 *", "motion/test_full_turns.py"),
    Fault("motion/full_turns.py", "between(lam, start)", "between(lam, lam[:1])", "motion/test_full_turns.py"),
    Fault(
        "motion/full_turns.py",
        " & (np.abs(missing[:, part.axis]) > SEEN)",
        "",
        "motion/test_full_turns.py -k plan",
    ),
    Fault(
        "motion/full_turns.py",
        "np.all(np.isfinite(x), axis=1)",
        "np.isfinite(t)",
        "motion/test_full_turns.py -k failure",
        slow=True,
    ),
    Fault(
        "motion/simulate.py",
        "    if feedback is not None:\n        warn_of",
        "    if False:\n        warn_of",
        "motion/test_full_turns.py",
    ),
    Fault(
        "trajectory/inverse.py",
        "        warn_of_full_turns(motion, model.parameters.reference)\n",
        "        pass\n",
        "motion/test_full_turns.py -k plan",
    ),
    # Near dead points: corrections that end early, and what round-off decides.
    Fault(
        "statics/configuration.py", "continuation.step < steps + MORE_TURNS", "False", "statics/test_configuration.py"
    ),
    Fault("numerical_limits.py", "FOLDED_MECHANISM = 1e5", "FOLDED_MECHANISM = 1e25", "statics/test_configuration.py"),
    Fault(
        "statics/configuration.py",
        "sizes) > FOLDED_MECHANISM * before)",
        "sizes) > 3 * FOLDED_MECHANISM)",
        "statics/test_configuration.py",
    ),
    Fault(
        "statics/configuration.py",
        " & (off < CONSTRAINTS_MET) & (end.change <= SETTLED_CONFIGURATION)",
        "",
        "statics/test_configuration.py",
    ),
    # Beams that are too few.
    Fault("numerical_limits.py", "COARSE_ANGLE = 0.2", "COARSE_ANGLE = 0.3", "statics/test_coarse.py"),
    Fault("statics/coarse.py", "block.splits[len(block.splits) // 2]", "block.splits[1]", "statics/test_coarse.py"),
    Fault("statics/stroke.py", "warn_of_coarse(model, fields[1])", "pass", "statics/test_coarse.py"),
    Fault("paths/path.py", "warn_of_coarse(path.model, path.e)", "pass", "statics/test_coarse.py"),
    Fault("linear/linearize.py", "warn_of_coarse(model, m.e)", "pass", "statics/test_coarse.py"),
    Fault("linear/linearize.py", "warn_of_coarse(model, equilibrium[1])", "pass", "statics/test_coarse.py"),
    Fault("motion/simulate.py", "warn_of_coarse(model, motion.e)", "pass", "statics/test_coarse.py"),
    Fault(
        "elements/spatial.py",
        "_check_beam,\n    angles=(2, 3,",
        "_check_beam,\n    angles=(3,",
        "statics/test_coarse.py",
    ),
    # State spaces along a motion, in one.
    Fault(
        "answers/mode_1_simulate.py",
        "np.flatnonzero(matrices.result == RESULTS.successful).tolist()",
        "range(len(matrices.result))",
        "answers/test_trajectory.py -k differ",
    ),
    Fault(
        "answers/mode_1_simulate.py",
        "tuple(massless_freedoms(np.asarray(matrices.M0[i])))",
        "()",
        "answers/test_trajectory.py -k differ",
    ),
    Fault("linear/loose.py", "if _is_negative(at_time)), None)", "if False), None)", "linear/test_loose.py"),
    # What is prescribed to stay begins where it is; where nothing is measured, nothing is computed.
    Fault("motion/simulate.py", "not np.any(np.asarray(value)))", "True)", "motion/test_start.py"),
    Fault("setup.py", "    looked_at.touch()", "    pass", "compilation/test_kept.py -k oldest"),
    Fault("setup.py", "st_mtime < BETWEEN", "st_mtime < 1e3 * BETWEEN", "compilation/test_kept.py -k oldest"),
    Fault("control/noise_frequencies.py", "if np.any(endless):", "if False:", "control/test_noise.py -k rough"),
    # Where others have run, what they replaced is looked for.
    Fault(
        "motion/simulate.py",
        "if places == list(range(len(known))):",
        "if True:",
        "motion/test_simulate.py -k turns",
    ),
    Fault(
        "control/stability.py",
        "at, values = _with_turns(function, at, values)",
        "pass",
        "control/test_loops.py -k close_to_each_other",
    ),
    Fault(
        "control/stability.py",
        "if self.period else self._d)]",
        "if self.period else 0.0)]",
        "control/test_loops.py -k passes_at_once",
    ),
    Fault(
        "control/stability.py",
        "most = 10 * np.max(np.abs(seen))",
        "most = 10 * np.max(np.abs(poles))",
        "control/test_loops.py -k far_beyond",
    ),
    Fault(
        "paths/walk.py",
        "if len(motions) > 1 and self.is_neutral(taken, crossing, phi):",
        "if False:",
        "paths/test_path.py -k round_bar",
        slow=True,
    ),
    Fault(
        "design/study.py",
        'np.geomspace if self.scales.get(n) == "log"',
        "np.geomspace if False",
        "design/test_study.py -k logarithm",
    ),
    Fault(
        "design/study.py",
        "np.clip(np.exp(designs[n]), *bounds[n])",
        "designs[n]",
        "design/test_study.py -k logarithm",
    ),
    Fault(
        "control/stability.py",
        "*zip(least.tolist(), where.tolist(), strict=True))",
        "(np.inf, 0.0))",
        "control/test_loops.py -k lightly_damped",
    ),
    Fault(
        "control/stability.py",
        "if not is_concrete((a, b, c, d)):",
        "if False:",
        "control/test_loops.py -k traced_gains_are_refused",
    ),
    Fault(
        "control/loops.py",
        "if not is_concrete((a, b, c, d, delay)):",
        "if False:",
        "control/test_loops.py -k traced_gains_are_refused",
    ),
    Fault(
        "motion/simulate.py",
        "Start(initial.x, rates, _counted(model, initial, initial.e))",
        "Start(initial.x, rates)",
        "motion/test_simulate.py -k turns",
    ),
    Fault(
        "control/nonlinear_system.py",
        "np.concatenate([start.x, start.e])",
        "np.concatenate([start.x, 0 * start.e])",
        "control/test_nonlinear_system.py -k turns",
    ),
    Fault(
        "control/nonlinear_system.py",
        "initial=0.0) / STEP)",
        "initial=0.0) / 1e9)",
        "control/test_nonlinear_system.py -k turns",
    ),
    Fault("fmu/plant_steps.c", "far > PLANT_STEP ? ", "0 ? ", "fmu/test_translate.py -k turns", slow=True),
    Fault(
        "trajectory/inverse.py",
        "*goals) / STEP)",
        "*goals) / 10)",
        "trajectory/test_inverse.py -k turns",
    ),
    Fault(
        "trajectory/inverse.py",
        "x=jnp.where(within, at.x, jnp.nan)",
        "x=at.x",
        "trajectory/test_inverse.py -k out_of_reach",
        slow=True,
    ),
    Fault(
        "control/stability.py",
        "float(np.real(self(highest)))",
        "self._d",
        "control/test_loops.py -k sampled_loop_feels",
    ),
    Fault(
        "control/noise_frequencies.py",
        "    if np.any(sharp):\n",
        "    if False:\n",
        "control/test_noise.py -k without_damping_that",
    ),
    Fault(
        "control/noise_frequencies.py",
        "lin, grid = jax.lax.stop_gradient((lin, grid))",
        "pass",
        "control/test_noise.py -k is_traced",
        slow=True,
    ),
    Fault(
        "math/linear.py",
        "* vectors.T, axis=1), vectors, conditions",
        "* vectors, axis=1), vectors, conditions",
        "linear/test_buckling.py -k unsymmetric",
        slow=True,
    ),
    Fault("build/dofs.py", "np.ndarray) and beside:", "np.ndarray):", "build/test_dofs.py -k serve_others"),
    Fault(
        "build/dofs.py",
        "found=tuple(map(str, (*x, *e)))",
        "found=()",
        "build/test_dofs.py -k are_known_as_found",
    ),
    Fault(
        "build/dofs.py",
        'effects[[model.labels.x[i].kind == "position" for i in free]] /= TURNS_BACK',
        "pass",
        "build/test_dofs.py -k swings_by",
    ),
    Fault(
        "statics/coarse.py",
        "is_odd & (strokes > LONGEST_STROKE)",
        "is_odd & (strokes > 100 * LONGEST_STROKE)",
        "statics/test_coarse.py -k skew_and_twisted",
        slow=True,
    ),
    Fault("build/dofs.py", "if block.element.grounded]", "if False]", "build/test_dofs.py -k drag_changes"),
    Fault(
        "build/dofs.py",
        "(1 + (entry.component > 1))",
        "0",
        "statics/test_prescribed_rotation.py -k released_about_another",
    ),
    Fault(
        "build/assemble.py",
        "found[free[0]] = [roles[free[0]][0], Role.FIXED, Role.FIXED]",
        "found[free[0]] = [roles[free[0]][0], Role.FIXED, Role.DEPENDENT]",
        "statics/test_prescribed_rotation.py -k turns_as_far",
    ),
    Fault(
        "build/assemble.py",
        "and moved.isdisjoint({*turns} - {*free})",
        "",
        "statics/test_prescribed_rotation.py -k input_turns",
    ),
    Fault(
        "motion/drives_by_name.py",
        "for holding in labels.holding(str(name)):",
        "for holding in ():",
        "statics/test_prescribed_rotation.py -k two_axes_are_refused",
    ),
    Fault(
        "checks/releases.py",
        "axes[entry.component - 1]",
        "axes[entry.component % 3]",
        "statics/test_prescribed_rotation.py -k released_about_another",
    ),
    Fault(
        "build/builder.py",
        "described if check else with_started(described)",
        "described",
        "build/test_dofs.py -k keeps_its_start",
    ),
    Fault(
        "math/linear.py",
        "custom_linear_solve(lambda x: matrix @ x,",
        "custom_linear_solve(lambda x: jax.lax.stop_gradient(matrix) @ x,",
        "math/test_linear.py::test_derivative_of_a_solution",
    ),
    Fault("elements/joints.py", "[0, 1], [-1, 0]])", "[0, 1], [0, 0]])", "elements/test_joints.py -k however_far"),
    Fault("elements/joints.py", "[[1.0, 0], [0, 1], [0, 1],", "[[1.0, 0], [0, 1], [0, 0],", "elements/test_joints.py"),
    Fault(
        "motion/linearized.py",
        "change > STEADY_EQUATIONS:",
        "change > 1e9:",
        "elements/test_joints.py -k whirl",
        slow=True,
    ),
    Fault(
        "linear/modes.py", "at is not None or collects():", "at is not None:", "design/test_unstable.py -k frequency"
    ),
    Fault("linear/buckling.py", "is_concrete((values, moved)):", "False:", "linear/test_buckling.py -k far_before"),
    Fault(
        "statics/newton_search.py",
        "still & self.idle & jnp.all(",
        "still & False & jnp.all(",
        "statics/test_sparse.py -k zero_asks",
    ),
    Fault(
        "statics/newton_search.py",
        "self.idle & jnp.all(s.trial.x == self.parameters.reference)",
        "self.idle",
        "statics/test_stroke.py -k goes_back",
    ),
    Fault(
        "math/sparse.py",
        "if not self.regular and np.all(np.isfinite(matrix.data)):",
        "if False:",
        "statics/test_sparse.py -k units_make",
        slow=True,
    ),
    Fault(
        "motion/loop.py",
        "if signal.quantity in MOTIONS:\n            # A",
        "if False:\n            # A",
        "trajectory/test_about_motion.py::test_walls_that_one_input_moves_do_so_together_but_for_a_constant_distance",
        slow=True,
    ),
    Fault(
        "math/derivative.py",
        "return known if use_known else number",
        "return number",
        "motion/test_solve.py -k failures",
    ),
    Fault("paths/over_load.py", "if not self.critical_points:", "if False:", "paths/test_sparse_states.py -k is_named"),
    Fault(
        "arguments.py",
        "if is_concrete(array) and not np.all(np.diff(array) > 0):",
        "if False:",
        "trajectory/test_linear_along.py -k says_so",
    ),
    Fault(
        "control/held.py",
        "without_gravity(parameters, increment=True)",
        "without_gravity(parameters)",
        "control/test_second_order_form.py -k weight_counts",
        slow=True,
    ),
    # The command line, files and answers.
    Fault(
        "cli.py",
        "(read.warnings if read else ()), *dict.fromkeys(heard_warnings)]",
        "(read.warnings if read else ())]",
        "design/test_study.py -k warnings_of_the_work",
    ),
    Fault(
        "design/checkpoint.py",
        "            warn(\n",
        "            str(\n",
        "design/test_study.py -k incomplete_checkpoint",
    ),
    Fault("cli.py", 'if "pi" in numbers:', "if False:", "test_cli.py -k wrong_call"),
    Fault("spacar/lines.py", ' if name != "pi"', "", "test_cli.py -k wrong_call"),
    Fault(
        "spacar/read.py",
        "statements(text, numbers)",
        "statements(text, numbers or None)",
        "spacar/test_arithmetic.py -k needs_no_numbers",
    ),
    Fault("spacar/read.py", 'if "pi" in numbers:', "if False:", "spacar/test_arithmetic.py -k needs_no_numbers"),
    Fault(
        "design/stroke.py",
        'raise StrokeError(f"{called} is fixed',
        'raise ModelError(f"{called} is fixed',
        "test_cli.py -k wrong_call",
    ),
    Fault("control/state_space.py", "if condensed and not names:", "if not names:", "test_cli.py -k driven_throughout"),
    Fault(
        "control/state_space.py",
        "axis=tuple(range(np.ndim(flags) - 1))).tolist()",
        "axis=0).tolist()",
        "test_cli.py -k driven_throughout",
    ),
    Fault("cli.py", 'if not result.data["states"]:', "if False:", "test_cli.py -k driven_throughout"),
    Fault("design/over_stroke.py", "> close:", "> 1:", "design/test_verdict.py -k reached_is_found"),
    Fault(
        "design/over_stroke.py",
        "min(side, key=abs) for side in sides",
        "max(side, key=abs) for side in sides",
        "design/test_verdict.py -k reached_is_found",
    ),
    Fault(
        "linear/buckling.py",
        "jnp.where(nothing, jnp.inf, jnp",
        "jnp.where(False, jnp.inf, jnp",
        "linear/test_buckling.py -k own_axis",
        slow=True,
    ),
    Fault(
        "linear/sparse_buckling.py",
        "    bounded &= np.any(",
        "    _ = np.any(",
        "linear/test_buckling.py -k own_axis",
        slow=True,
    ),
    Fault("spacar/read.py", 'if "ALPHA" in lines and', "if False and", "spacar/test_read.py -k expansion"),
    Fault("spacar/write.py", "and name in self.warmed ", "", "spacar/test_read.py -k expansion"),
    Fault(
        "design/judgement.py",
        "if sizes[i] > NEGLIGIBLE * max(1.0, np.max(sizes)):",
        "if True:",
        "design/test_verdict.py -k say_what_moves_it",
        slow=True,
    ),
    Fault("cli.py", "except StrokeError as", "except ZeroDivisionError as", "test_cli.py -k its_number"),
    Fault("answers/labelled.py", '.replace("²", "^2")', "", "answers/test_labelled.py -k stands_over_time", slow=True),
    Fault(
        "answers/labelled.py",
        'turned[:, j], "rad"',
        'turned[:, 0], "rad"',
        "answers/test_labelled.py -k rotations",
        slow=True,
    ),
    Fault(
        "control/universal_file.py", '"rz": 6, "phi": 6', '"rz": 6, "phi": 4', "answers/test_labelled.py -k universal"
    ),
    Fault(
        "linear/linearize.py",
        "at.asked_of, at.factors\n",
        "at.asked_of, LoadFactors(1.0, 1.0)\n",
        "linear/test_states.py -k state_to_ask",
    ),
    Fault(
        "workbench/from_model.py",
        'if "clamped" in properties and name in self.stated:',
        'if "clamped" in properties:',
        "workbench/test_from_builder.py -k clamps",
    ),
    # Scatter of parameters, and what measurements say.
    Fault(
        "design/scatter.py",
        "np.expm1(self.sizes[0] * scores)",
        "self.sizes[0] * scores",
        "design/test_scatter.py -k lognormal_parameter",
    ),
    Fault(
        "design/scatter.py",
        "lower + np.sqrt(below * width * -lower)",
        "lower + np.sqrt(below * width * upper)",
        "design/test_scatter.py -k distribution",
    ),
    Fault(
        "design/scatter.py",
        "scores @ correlation_root(scatter, layout).T",
        "scores",
        "design/test_scatter.py -k copula",
    ),
    Fault(
        "design/scatter.py",
        "powers = correlation[:, :, None] ** np.arange(1, TERMS)",
        "powers = correlation[:, :, None] * np.ones(TERMS - 1)",
        "design/test_scatter.py -k copula",
    ),
    Fault(
        "design/scatter.py",
        "if name not in values:\n            raise",
        "if not values:\n            raise",
        "design/test_scatter.py -k missing",
    ),
    Fault(
        "design/tolerance.py",
        "second = covariance + np.outer(shift, shift)",
        "second = np.outer(shift, shift)",
        "design/test_scatter.py -k square",
    ),
    Fault(
        "design/tolerance.py",
        "difference = (rows - quadratic(some))[good]",
        "difference = rows[good]",
        "design/test_scatter.py -k square",
    ),
    Fault(
        "design/robust.py",
        "np.clip(np.quantile(values, share), low, high)",
        "np.quantile(values, share)",
        "design/test_scatter.py -k beyond_all",
    ),
    Fault("design/problem.py", "np.any(np.isnan(numbers_of))", "False", "design/test_scatter.py -k no_numbers"),
    Fault("design/robust.py", "fine &= rows <= np", "fine &= rows >= np", "design/test_scatter.py -k percentiles"),
    Fault(
        "design/statistics.py",
        "(count + 1) * share, (count + 1) * (1 - share)",
        "(count + 1) * (1 - share), (count + 1) * share",
        "design/test_scatter.py -k statistics_are",
    ),
    Fault("design/statistics.py", "rows[1:].T", "rows[:0].T", "design/test_scatter.py -k only_scatters"),
    Fault(
        "design/statistics.py",
        "margin >= 0, sign",
        "margin > 0, sign",
        "design/test_scatter.py -k statistics_are",
    ),
    Fault(
        "design/statistics.py",
        "if wants_yield and not acceptable:",
        "if wants_yield and acceptable is None and False:",
        "design/test_scatter.py -k questions",
    ),
    Fault(
        "design/robust.py",
        "**{against: (None, float(level))}",
        "**{against: (None, np.inf)}",
        "design/test_scatter.py -k front",
    ),
    Fault(
        "identification/comparison.py",
        "norm.cdf(distance / 2)",
        "norm.cdf(distance)",
        "identification/test_comparison.py -k distance",
    ),
    Fault(
        "identification/comparison.py",
        "if name not in (parameters or {}):",
        "if False:",
        "identification/test_comparison.py -k parameters",
    ),
    Fault(
        "identification/measurement.py",
        "    if item.relative:",
        "    if False:",
        "identification/test_measurements.py -k another_unit",
    ),
    Fault(
        "identification/study_data.py",
        'entry["relative_deviation"] * np.abs(values)',
        'entry["relative_deviation"]',
        "identification/test_fit_study.py -k table",
    ),
    Fault(
        "identification/study_data.py",
        "not math.isfinite(float(text))",
        "False",
        "identification/test_fit_study.py -k one_line",
    ),
    Fault(
        "identification/fit_study.py",
        "item.answer(model, **known, **parameters)",
        "item.answer(model, **parameters)",
        "identification/test_fit_study.py -k table",
    ),
    Fault(
        "identification/modal_data.py",
        "if deviation is not None and noise > TOO_FAR:",
        "if False:",
        "identification/test_modal_data.py -k not_explain",
    ),
    Fault(
        "identification/fitted.py",
        'if self.problem.loss != "linear":',
        "if False:",
        "identification/test_posterior.py -k refused",
    ),
    Fault(
        "design/scatter.py",
        "np.sqrt(below * width * -lower)",
        "np.sqrt(below * width * upper)",
        "design/test_scatter.py -k each_distribution",
    ),
    Fault(
        "design/scatter.py",
        "return np.expm1(self.sizes[0] * scores)",
        "return self.sizes[0] * scores",
        "design/test_scatter.py -k lognormal_parameter",
    ),
    Fault(
        "design/scatter.py",
        "matrix[i, j] = matrix[j, i] = value",
        "matrix[i, j] = value",
        "design/test_scatter.py -k copula",
    ),
    Fault("design/scatter.py", "/ np.sqrt(k + 1)", "/ np.sqrt(k + 2)", "design/test_scatter.py -k copula"),
    Fault(
        "design/scatter.py",
        "if not lower <= 0 <= upper or lower == upper:",
        "if False:",
        "design/test_scatter.py -k wrong_scatter",
    ),
    Fault(
        "design/scatter.py",
        "if pair in pairs or pair[::-1] in pairs:",
        "if pair in pairs:",
        "design/test_scatter.py -k wrong_scatter",
    ),
    Fault(
        "design/scatter.py",
        "spreads += [scatter.spreads.get(name)] * size",
        "spreads += [scatter.spreads.get(name)]",
        "design/test_scatter.py -k entries_of_arrays",
    ),
    Fault(
        "design/robust.py",
        "fine &= rows >= np.broadcast_to(lower",
        "fine &= rows <= np.broadcast_to(lower",
        "design/test_scatter.py -k cube_of_a_normal",
    ),
    Fault(
        "design/statistics.py",
        "variance = jnp.var(values, axis=-1, ddof=1)",
        "variance = jnp.var(values, axis=-1)",
        "design/test_scatter.py -k statistics_are_those",
    ),
    Fault(
        "design/statistics.py",
        "margin = sign * (samples",
        "margin = (samples",
        "design/test_scatter.py -k best_yield",
    ),
    Fault(
        "identification/comparison.py",
        "answers[item.name] - item.values",
        "answers[item.name]",
        "identification/test_comparison.py -k distance_of",
    ),
    Fault(
        "identification/fit_study.py",
        "known = {name: fixed[name] for name in item.parameters if name in fixed}",
        "known = {}",
        "identification/test_fit_study.py -k table_a_response",
    ),
    Fault(
        "linear/stress.py",
        "if at is not None and not (is_concrete(factor)",
        "if at is None and not (is_concrete(factor)",
        "linear/test_states.py -k go_together",
    ),
    Fault(
        "plot/sweep.py",
        "np.unique(sweep_result.axes[name])",
        "np.asarray(sweep_result.axes[name])",
        "plot/test_designs.py -k any_order",
    ),
    Fault(
        "motion/simulate.py",
        "np.any(differs := differs_beyond_round_off",
        "not np.any(differs := differs_beyond_round_off",
        "motion/test_simulate.py -k another_length",
    ),
    Fault("design/judgement.py", "np.any(np.isnan(limit.used))", "False", "design/test_verdict.py -k let_go"),
    Fault("design/over_stroke.py", "if stroke != 0:", "if False:", "design/test_verdict.py -k is_told"),
    Fault(
        "answers/answers.py",
        "for text in heard_warnings if LEAVES_OUT not in text",
        "for text in heard_warnings if LEAVES_OUT in text",
        "answers/test_answers.py -k warnings_of_a_motion",
        slow=True,
    ),
]

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
