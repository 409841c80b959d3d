"""Perturbation method and linear time-varying system beside the full nonlinear motion: a flexible arm that is turned.

python -m benchmarks along
"""

import functools
import time

# Arm of six beams: length [m], EI [N m^2], mass per length [kg/m], load at the tip [kg], inertia of the hub [kg m^2].
LENGTH, BENDING, MASS, LOAD, HUB = 1.0, 400.0, 0.5, 0.3, 0.05
BEAMS, TRAVEL, DURATION, END = 6, 0.5, 0.3, 0.8
TRAVELS = (1.0, 0.5, 0.25, 0.125)
RUNS = 7


def arm():
    """Flexible arm with a load on a hub that a motor turns."""
    import flexmb as fm
    from flexmb import planar

    section = fm.Rigidity(EA=1e6, EIy=BENDING, mass=MASS)
    b = fm.Builder()
    names = ["hub", *(f"n{i}" for i in range(1, BEAMS)), "tip"]
    for i, name in enumerate(names):
        b.node(name, (LENGTH * i / BEAMS, 0.0))
    for i in range(BEAMS):
        b.add(planar.beam, names[i], names[i + 1], name=f"part{i}", section=section, released=(2, 3))
        b.dof(f"part{i}", 2, 3)
    b.fix("hub", "x", "y")
    b.mass("tip", LOAD)
    b.inertia("hub", HUB)
    b.dof("hub", "phi")
    b.input("hub", "phi")
    b.output("tip", "y")
    return b.build()


def nominal_of(model, travel: float, count: int):
    """Nominal motion of the arm held straight.

    Args:
        model: The arm.
        travel: How far it is turned [rad].
        count: Number of times.
    """
    import numpy as np

    import flexmb as fm

    law = fm.trajectory.septic(0.0, travel, DURATION)
    return fm.trajectory.inverse_dynamics(model, {"hub.phi": law}, np.linspace(0, END, count))


def full_motion(model, moment, rtol: float):
    """Where the tip is in the full nonlinear motion, at 81 times, (81, 2) [m].

    Args:
        model: The arm.
        moment: Of the motor, function of time.
        rtol: Tolerance.
    """
    import numpy as np

    import flexmb as fm

    times = np.linspace(0, END, 81)
    return np.asarray(fm.simulate(model, times, loads={"hub.rotation.phi": moment}, rtol=rtol).position("tip"))


def perturbed(nominal, modes: int | None):
    """The same by the perturbation method.

    Args:
        nominal: Nominal motion.
        modes: How many slowly varying modes; None: all degrees of freedom.
    """
    import numpy as np

    import flexmb as fm

    tip = np.asarray(fm.trajectory.perturbation(nominal, modes=modes).motion().position("tip"))
    return tip[:: (len(tip) - 1) // 80]


def answered(system, times, u, substeps: int):
    """Outputs of a linear time-varying system.

    Args:
        system: The system.
        times: Times [s].
        u: Moment of the motor at them [N m].
        substeps: Steps from each time to the next.
    """
    import numpy as np

    return np.asarray(system.solution(times, u, substeps=substeps)[0])


def add(found: dict, run: dict, name: str, call, error) -> None:
    """Note the error of a variant and its first call, and that it is to be timed.

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.
        name: Name.
        call: What is timed.
        error: Function of what it gives [-].
    """
    begin = time.process_time()
    off = float(error(call()))
    first = time.process_time() - begin
    found[name] = {"error": off, "first_s": first}
    run[name] = call
    print(f"{name:<50} error {off:.1e}, first {first:.1f} s", flush=True)


def main() -> None:
    """Compute, time, print, save and draw."""
    import numpy as np
    from record import PACKAGES, chart, processor_times, save, show

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache()
    model = arm()
    amplitudes, exactly = {}, {}
    for travel in TRAVELS:
        nominal = nominal_of(model, travel, 161)
        (moment,) = nominal.inputs.values()
        exact = exactly[travel] = full_motion(model, moment, 1e-9)
        straight = np.asarray(nominal.motion.position("tip"))[::2]
        vibration, off = (float(np.max(np.abs(of - exact))) for of in (straight, perturbed(nominal, None)))
        amplitudes[str(travel)] = {"vibration_m": vibration, "error_m": off}
        print(f"turned by {travel} rad: vibration {1e3 * vibration:.3f} mm, error {1e3 * off:.5f} mm", flush=True)
    nominal = nominal_of(model, TRAVEL, 161)
    (moment,) = nominal.inputs.values()
    exact = exactly[TRAVEL]
    vibration = amplitudes[str(TRAVEL)]["vibration_m"]

    def error(tip):
        return np.max(np.abs(tip - exact)) / vibration

    found, run = {}, {}
    for rtol in (1e-3, 1e-4, 1e-5, 1e-6):
        add(found, run, f"full nonlinear motion: {rtol:g}", functools.partial(full_motion, model, moment, rtol), error)
    for family, modes in (("perturbation method", None), ("the same, 3 modes", 3)):
        for count in (81, 161):
            own = nominal_of(model, TRAVEL, count)
            add(found, run, f"{family}: {count} times", functools.partial(perturbed, own, modes), error)
    # A response to another moment, of a system that is there already; its error is that of its own steps.
    pushed = np.sin(20 * np.asarray(nominal.t)) ** 3
    whole = fm.trajectory.time_varying(nominal)
    known = np.asarray(whole.solution(nominal.t, pushed, rtol=1e-10)[0])
    for family, system in (
        ("linear time-varying system", whole),
        ("the same, reduced to 3 modes", whole.reduced(3)),
    ):
        for steps in (1, 2, 4):
            call = functools.partial(
                lambda s, n: np.asarray(s.solution(nominal.t, pushed, substeps=n)[0]), system, steps
            )
            name = f"{family}: {steps} steps"
            add(found, run, name, call, lambda y: np.max(np.abs(y - known)) / np.max(np.abs(known)))
    timed = processor_times(run, RUNS)
    show("Flexible arm, compiled, times of the processor", timed)
    save("along", {"found": found, "times": timed, "amplitudes": amplitudes}, (*PACKAGES, "diffrax"))
    title = f"Flexible arm of {BEAMS} beams, turned by {TRAVEL} rad in {DURATION} s"
    chart("along", found, timed, title, "time of the processor", "error over the largest vibration, or output")


if __name__ == "__main__":
    main()
