"""Scenes of the benchmarks in Exudyn, such as the guide of large_deflection.py; needs the extra ``peers``."""

import importlib.util
import itertools
import math
import statistics
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

# Tried for every number of elements; the fastest that converges is the one compared.
NODES = ("NodeRigidBodyEP", "NodeRigidBodyRxyz", "NodeRigidBodyRotVecLG")
SOLVERS = ("EigenDense", "EigenSparse")
LOAD_STEPS = (1, 3)
TOLERANCES = (1e-8, 1e-6)
DENSE_UP_TO = 16


def installed() -> bool:
    """Whether Exudyn can be imported."""
    return importlib.util.find_spec("exudyn") is not None


def _exudyn():
    # The build without range checks is the faster one.
    sys.exudynFast = True  # type: ignore[attr-defined]
    import exudyn

    return exudyn


def guide(
    rigidity,
    length: float,
    distance: float,
    force: float,
    elements: int,
    node: str = NODES[0],
    masses: tuple[float, float] = (1.0, 0.0),
):
    """Two leaf springs upright, joined by a rigid stage: feet clamped, pushed along the drive direction.

    Drawn with the leaf springs along x and the drive along z, so that the frames of the nodes are those of the space
    and every kind of node starts at zero rotation.

    Args:
        rigidity: Section, as of ``flexmb.Rectangle(..., shear=True).rigidity()``.
        length: Of a leaf spring [m].
        distance: Between the leaf springs [m].
        force: On the stage, along the drive direction [N].
        elements: A leaf spring.
        node: Class of its nodes, which says how they turn.
        masses: Of both ends of the stage [kg].

    Returns:
        The container, which keeps the rest alive; the assembled system; the number of the loaded node.
    """
    import numpy as np
    from exudyn import itemInterface as item

    exudyn = _exudyn()
    ei_y, ei_z = float(rigidity.EIy), float(rigidity.EIz)
    section = exudyn.BeamSection()
    shear = ei_z / float(rigidity.shear_y), ei_y / float(rigidity.shear_z)
    section.stiffnessMatrix = np.diag([float(rigidity.EA), *shear, float(rigidity.GIt), ei_y, ei_z])
    section.massPerLength = float(rigidity.mass)
    section.inertia = np.diag([float(rigidity.Jx), float(rigidity.Jy), float(rigidity.Jz)])

    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(item.ObjectGround())
    turn = [1.0, 0.0, 0.0, 0.0] if node == "NodeRigidBodyEP" else [0.0, 0.0, 0.0]
    locked = [1, 1, 1, 1, 1, 1]
    tops = []
    for z in (0.0, distance):
        chain = [
            system.AddNode(getattr(item, node)(referenceCoordinates=[length * i / elements, 0.0, z, *turn]))
            for i in range(elements + 1)
        ]
        for ends in itertools.pairwise(chain):
            system.AddObject(
                item.ObjectBeamGeometricallyExact(nodeNumbers=list(ends), length=length / elements, sectionData=section)
            )
        foot = system.AddMarker(item.MarkerNodeRigid(nodeNumber=chain[0]))
        place = system.AddMarker(item.MarkerBodyRigid(bodyNumber=ground, localPosition=[0.0, 0.0, z]))
        system.AddObject(item.GenericJoint(markerNumbers=[place, foot], constrainedAxes=locked))
        tops.append(chain[-1])
    # The stage is a body on the first top, so that one joint is enough.
    points = [1e-12, 1e-12, 1e-12, 0, 0, 0]
    stage = system.AddObject(item.ObjectRigidBody(mass=masses[0], inertia=points, nodeNumber=tops[0]))
    if masses[1]:
        system.AddObject(item.ObjectRigidBody(mass=masses[1], inertia=points, nodeNumber=tops[1]))
    end = system.AddMarker(item.MarkerBodyRigid(bodyNumber=stage, localPosition=[0.0, 0.0, distance]))
    top = system.AddMarker(item.MarkerNodeRigid(nodeNumber=tops[1]))
    system.AddObject(item.GenericJoint(markerNumbers=[end, top], constrainedAxes=locked))
    system.AddLoad(item.LoadForceVector(markerNumber=top, loadVector=[0.0, 0.0, force]))
    system.Assemble()
    return container, system, tops[1]


def settings(solver: str, steps: int, tolerance: float):
    """Settings of the static solver: full Newton, no files, nothing printed.

    Args:
        solver: Linear solver.
        steps: Load steps.
        tolerance: Of the residual, relative.
    """
    exudyn = _exudyn()
    chosen = exudyn.SimulationSettings()
    chosen.linearSolver.solverType = getattr(exudyn.LinearSolverType, solver)
    chosen.staticSolver.verboseMode = 0
    chosen.staticSolver.stepInformation = 0
    chosen.staticSolver.numberOfLoadSteps = steps
    chosen.staticSolver.newton.relativeTolerance = tolerance
    chosen.solution.file.write = False
    chosen.solution.sensors.active = False
    return chosen


def solution(built, chosen) -> Callable[[], float]:
    """A function that solves from the undeformed state and gives the stroke.

    Args:
        built: As from :func:`guide`.
        chosen: As from :func:`settings`.
    """
    exudyn = _exudyn()
    _, system, top = built

    def solve() -> float:
        if not system.SolveStatic(chosen, storeSolver=False, showCausingItems=False):
            raise RuntimeError("not converged")
        return float(system.GetNodeOutput(top, exudyn.OutputVariableType.Displacement)[2])

    # What is returned keeps the container alive.
    solve.built = built  # type: ignore[attr-defined]
    return solve


def fastest(rigidity, length: float, distance: float, force: float, elements: int) -> dict[str, Any]:
    """The fastest settings that give the stroke of the strictest ones to 1e-5.

    Args:
        rigidity: Section.
        length: Of a leaf spring [m].
        distance: Between the leaf springs [m].
        force: On the stage [N].
        elements: A leaf spring.

    Returns:
        ``solve``, ``stroke`` [m] and ``settings`` as a sentence.
    """
    tried = []
    for node in NODES:
        built = guide(rigidity, length, distance, force, elements, node)
        for solver, steps, tolerance in itertools.product(SOLVERS, LOAD_STEPS, TOLERANCES):
            if solver == "EigenDense" and elements > DENSE_UP_TO:
                continue
            solve = solution(built, settings(solver, steps, tolerance))
            try:
                stroke, spent = solve(), []
                for _ in range(5):
                    start = time.perf_counter()
                    solve()
                    spent.append(time.perf_counter() - start)
            except (RuntimeError, ValueError) as error:
                warnings.warn(f"Exudyn, {elements} elements, {node}, {solver}, {steps} steps: {error}", stacklevel=1)
                continue
            words = f"{node}, {solver}, load steps {steps}, relativeTolerance {tolerance:g}"
            tried.append((statistics.median(spent), tolerance, stroke, words, solve))
    strict = next(entry for entry in tried if entry[1] == min(TOLERANCES))
    good = [entry for entry in tried if abs(entry[2] / strict[2] - 1) < 1e-5]
    _, _, stroke, words, solve = min(good, key=lambda entry: entry[0])
    return {"solve": solve, "stroke": stroke, "settings": words}


def first_frequency(rigidity, length: float, distance: float, stage: float, elements: int) -> float:
    """First natural frequency of the unloaded guide, built anew [Hz].

    Args:
        rigidity: Section.
        length: Of a leaf spring [m].
        distance: Between the leaf springs [m].
        stage: Its mass, half of it at either end [kg].
        elements: A leaf spring.
    """
    masses = (stage / 2, stage / 2)
    _, system, _ = built = guide(rigidity, length, distance, 0.0, elements, "NodeRigidBodyRotVecLG", masses)
    values, _ = system.ComputeODE2Eigenvalues(numberOfEigenvalues=1, convert2Frequencies=True)
    del built
    return float(values[0])


def released(built, times, step: float) -> Callable[[], Any]:
    """A function that integrates the guide once its load is taken away, and gives the stroke at the times.

    The equilibrium under the load is found once, here. By the generalised-alpha method.

    Args:
        built: As from :func:`guide`.
        times: Equidistant, from zero, (n_t,) [s].
        step: Time step [s].

    Raises:
        RuntimeError: The equilibrium is not found.
    """
    from exudyn import itemInterface as item

    exudyn = _exudyn()
    _, system, top = built
    moved = exudyn.OutputVariableType.Displacement
    sensor = system.AddSensor(item.SensorNode(nodeNumber=top, storeInternal=True, outputVariableType=moved))
    system.Assemble()
    if not system.SolveStatic(settings(SOLVERS[1], 1, 1e-8), updateInitialValues=True):
        raise RuntimeError("not converged")
    system.SetLoadParameter(0, "loadVector", [0.0, 0.0, 0.0])
    start = system.systemData.GetODE2Coordinates()
    chosen = in_time(times[-1], round(times[-1] / step))
    chosen.solution.sensors.active = True
    chosen.solution.sensors.writePeriod = times[1] - times[0]
    # Tighter tolerances, its own too, end in Newton's method not converging at small steps or with more elements.
    chosen.timeIntegration.newton.relativeTolerance = 1e-4
    chosen.timeIntegration.newton.absoluteTolerance = 1e-6
    chosen.timeIntegration.generalizedAlpha.spectralRadius = 0.8

    def run():
        system.systemData.SetODE2Coordinates(start, configuration=exudyn.ConfigurationType.Initial)
        system.SolveDynamic(chosen, solverType=exudyn.DynamicSolverType.GeneralizedAlpha)
        return system.GetSensorStoredData(sensor)[:, 3]

    run.built = built  # type: ignore[attr-defined]
    return run


def in_time(end: float, steps: int):
    """Settings of the generalised-alpha method: fixed steps, no files, nothing printed.

    Args:
        end: Time [s].
        steps: Number of time steps.
    """
    exudyn = _exudyn()
    chosen = exudyn.SimulationSettings()
    chosen.linearSolver.solverType = getattr(exudyn.LinearSolverType, SOLVERS[1])
    chosen.solution.file.write = False
    chosen.solution.sensors.active = False
    chosen.timeIntegration.endTime = end
    chosen.timeIntegration.numberOfSteps = steps
    chosen.timeIntegration.verboseMode = 0
    return chosen


def _motion(built, end: float, steps: int, read, tolerance: float = 1e-8) -> Callable[[], Any]:
    """A function that integrates from the undeformed state at rest, and gives what ``read()`` then finds."""
    exudyn = _exudyn()
    chosen, (_, system) = in_time(end, steps), built
    chosen.timeIntegration.newton.relativeTolerance = tolerance

    def run():
        if not system.SolveDynamic(chosen, solverType=exudyn.DynamicSolverType.GeneralizedAlpha):
            raise RuntimeError("not converged")
        return read()

    run.built = built  # type: ignore[attr-defined]
    return run


def _cables(length, mass, bending, stretching, gravity, elements: int, held: tuple[int, ...]):
    """A rod of cables along x in the plane, some coordinates of its first node held; the container, system, nodes."""
    from exudyn import itemInterface as item

    exudyn = _exudyn()
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddNode(item.NodePointGround())
    own = length / elements
    nodes = [
        system.AddNode(item.NodePoint2DSlope1(referenceCoordinates=[own * i, 0.0, 1.0, 0.0]))
        for i in range(elements + 1)
    ]
    for ends in itertools.pairwise(nodes):
        cable = item.ObjectANCFCable2D(
            physicsLength=own,
            physicsMassPerLength=mass,
            physicsBendingStiffness=bending,
            physicsAxialStiffness=stretching,
            nodeNumbers=list(ends),
        )
        body = system.AddObject(cable)
        if gravity:
            marker = system.AddMarker(item.MarkerBodyMass(bodyNumber=body))
            system.AddLoad(item.LoadMassProportional(markerNumber=marker, loadVector=[0.0, -gravity, 0.0]))
    fixed = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in held:
        own = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        system.AddObject(item.CoordinateConstraint(markerNumbers=[fixed, own]))
    return container, system, nodes


def cantilever(length, bending, stretching, load, elements: int) -> Callable[[], Any]:
    """A function that bends a rod, held at its end, by a load across its tip, and gives the place of the tip.

    Args:
        length: Of the rod [m].
        bending: Rigidity [N m^2].
        stretching: Rigidity [N].
        load: Downward [N].
        elements: Cables in the plane.
    """
    from exudyn import itemInterface as item

    # The slope's direction is the clamp: its length is a strain.
    container, system, nodes = _cables(length, 1.0, bending, stretching, 0.0, elements, (0, 1, 3))
    point = system.AddMarker(item.MarkerNodePosition(nodeNumber=nodes[-1]))
    system.AddLoad(item.LoadForceVector(markerNumber=point, loadVector=[0.0, -load, 0.0]))
    system.Assemble()
    place = _exudyn().OutputVariableType.Position
    tried: list[tuple[float, Any, Any]] = []
    for tolerance, steps in itertools.product(sorted(TOLERANCES), LOAD_STEPS):
        chosen = settings(SOLVERS[1], steps, tolerance)

        def solve(chosen=chosen):
            if not system.SolveStatic(chosen, storeSolver=False, showCausingItems=False):
                raise RuntimeError("not converged")
            return system.GetNodeOutput(nodes[-1], place)[:2]

        try:
            found, spent = solve(), []
            for _ in range(3):
                begin = time.process_time()
                solve()
                spent.append(time.process_time() - begin)
        except (RuntimeError, ValueError):
            continue
        tried.append((min(spent), found, solve))
    if not tried:
        raise RuntimeError(f"Exudyn bends no cantilever of {elements} cables")
    # The strictest comes first.
    good = [entry for entry in tried if math.dist(entry[1], tried[0][1]) < 1e-7 * length]
    best = min(good, key=lambda entry: entry[0])[2]
    best.built = container, system  # type: ignore[attr-defined]
    return best


def soft_rod(scene, elements: int) -> Callable[[], Any]:
    """A function that bends the rod of peers.py in space by its weight, and gives the place of the tip.

    Args:
        scene: As ``peers.SCENE``.
        elements: Geometrically exact beams.
    """
    import numpy as np
    from exudyn import itemInterface as item

    exudyn, own = _exudyn(), scene.length / elements
    section = exudyn.BeamSection()
    fields = ("EA", "GAy", "GAz", "GIt", "EIy", "EIz")
    section.stiffnessMatrix = np.diag([getattr(scene.stiffness, name) for name in fields])
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    nodes = [
        system.AddNode(item.NodeRigidBodyRotVecLG(referenceCoordinates=[own * i, 0.0, 0.0, 0.0, 0.0, 0.0]))
        for i in range(elements + 1)
    ]
    for ends in itertools.pairwise(nodes):
        system.AddObject(item.ObjectBeamGeometricallyExact(nodeNumbers=list(ends), length=own, sectionData=section))
    markers = [system.AddMarker(item.MarkerNodeRigid(nodeNumber=node)) for node in nodes]
    place = system.AddMarker(item.MarkerBodyRigid(bodyNumber=system.AddObject(item.ObjectGround())))
    system.AddObject(item.GenericJoint(markerNumbers=[place, markers[0]], constrainedAxes=[1] * 6))
    for marker, share in zip(markers, [0.5, *[1.0] * (elements - 1), 0.5], strict=True):
        weight = [share * own * scene.inertia.mass * number for number in scene.gravity]
        system.AddLoad(item.LoadForceVector(markerNumber=marker, loadVector=weight))
    system.Assemble()
    chosen = settings(SOLVERS[1], 4, 1e-8)

    def solve():
        if not system.SolveStatic(chosen, storeSolver=False, showCausingItems=False):
            raise RuntimeError("not converged")
        return system.GetNodeOutput(nodes[-1], exudyn.OutputVariableType.Position)

    solve.built = container, system  # type: ignore[attr-defined]
    return solve


def pendulum(
    length, mass, bending, stretching, gravity, elements: int, end: float, steps: int, tolerance: float = 1e-8
) -> Callable[[], Any]:
    """A function that lets a rod fall about its end from the horizontal, and gives the place of its tip.

    Args:
        length: Of the rod [m].
        mass: Per length [kg/m].
        bending: Rigidity [N m^2].
        stretching: Rigidity [N].
        gravity: [m/s^2].
        elements: Cables in the plane.
        end: Time [s].
        steps: Number of time steps.
        tolerance: Of Newton's method, relative; 1e-8 is Exudyn's own.
    """
    container, system, nodes = _cables(length, mass, bending, stretching, gravity, elements, (0, 1))
    system.Assemble()
    place = _exudyn().OutputVariableType.Position
    return _motion((container, system), end, steps, lambda: system.GetNodeOutput(nodes[-1], place)[:2], tolerance)


def spaghetti(elements: int, end: float, load: float, steps: int) -> Callable[[], Any]:
    """A function that moves the free rod of REFERENCES.md D1 up to the peak of its load, and gives its ends.

    Drawn along x, so that the frames of the nodes are those of the space.

    Args:
        elements: Beams.
        end: Time of the peak [s].
        load: T at the peak.
        steps: Number of time steps.
    """
    import numpy as np
    from exudyn import itemInterface as item

    exudyn = _exudyn()
    section = exudyn.BeamSection()
    section.stiffnessMatrix = np.diag([1e4, 1e4, 1e4, 500.0, 500.0, 500.0])
    section.massPerLength = 1.0
    section.inertia = np.diag([20.0, 10.0, 10.0])
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    turn = [0.0, 0.0, 0.0]
    nodes = [
        system.AddNode(item.NodeRigidBodyRotVecLG(referenceCoordinates=[10.0 * i / elements, 0.0, 0.0, *turn]))
        for i in range(elements + 1)
    ]
    for ends in itertools.pairwise(nodes):
        system.AddObject(
            item.ObjectBeamGeometricallyExact(nodeNumbers=list(ends), length=10.0 / elements, sectionData=section)
        )
    # Axes of the drawing in space: the rod lies from (6, 0, 0) to (0, 8, 0).
    axes = np.array([[-0.6, 0.8, 0.0], [-0.8, -0.6, 0.0], [0.0, 0.0, 1.0]])
    start = np.array([6.0, 0.0, 0.0])
    force, moment = axes @ [load / 10, 0.0, 0.0], axes @ [0.0, -load / 2, -load]
    marker = system.AddMarker(item.MarkerNodeRigid(nodeNumber=nodes[0]))
    for kind, peak in ((item.LoadForceVector, force), (item.LoadTorqueVector, moment)):
        rises = {"loadVectorUserFunction": lambda _, t, given: [t / end * number for number in given]}
        system.AddLoad(kind(markerNumber=marker, loadVector=list(peak), **rises))
    system.Assemble()
    place = exudyn.OutputVariableType.Position

    def ends_in_space():
        return np.concatenate([start + axes.T @ system.GetNodeOutput(node, place) for node in (nodes[0], nodes[-1])])

    return _motion((container, system), end, steps, ends_in_space)


def net(length, mass, bending, stretching, gravity, cells: int, end: float, steps: int, **newton) -> Callable[[], Any]:
    """A function that lets a square net fall that hangs at its upper corners, and gives where its lower edge is.

    Cables along and across are hinged to each other where they cross.

    Args:
        length: Of a cable from edge to edge [m].
        mass: Per length [kg/m].
        bending: Rigidity [N m^2].
        stretching: Rigidity [N].
        gravity: [m/s^2].
        cells: Meshes along an edge; each side of one is an ANCF cable.
        end: Time [s].
        steps: Number of time steps.
        newton: Settings of Newton's method: relativeTolerance, useModifiedNewton.
    """
    import numpy as np
    from exudyn import itemInterface as item

    exudyn = _exudyn()
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddNode(item.NodePointGround())
    fixed = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    own, every = length / cells, range(cells + 1)

    def node(i, j, *slope):
        return system.AddNode(item.NodePoint2DSlope1(referenceCoordinates=[own * i, -own * j, *slope]))

    along, across = ({(i, j): node(i, j, *slope) for i in every for j in every} for slope in ((1.0, 0.0), (0.0, -1.0)))
    sides = [(along[i, j], along[i + 1, j]) for i in every[:-1] for j in every]
    sides += [(across[i, j], across[i, j + 1]) for i in every for j in every[:-1]]
    for ends in sides:
        cable = item.ObjectANCFCable2D(
            physicsLength=own,
            physicsMassPerLength=mass,
            physicsBendingStiffness=bending,
            physicsAxialStiffness=stretching,
            nodeNumbers=list(ends),
        )
        marker = system.AddMarker(item.MarkerBodyMass(bodyNumber=system.AddObject(cable)))
        system.AddLoad(item.LoadMassProportional(markerNumber=marker, loadVector=[0.0, -gravity, 0.0]))

    def marked(node, coordinate):
        return system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))

    for at, coordinate in itertools.product(along, (0, 1)):
        pair = [marked(along[at], coordinate), marked(across[at], coordinate)]
        system.AddObject(item.CoordinateConstraint(markerNumbers=pair))
        if at in ((0, 0), (cells, 0)):
            system.AddObject(item.CoordinateConstraint(markerNumbers=[fixed, pair[0]]))
    system.Assemble()
    place = exudyn.OutputVariableType.Position
    chosen = in_time(end, steps)
    for name, value in newton.items():
        setattr(chosen.timeIntegration.newton, name, value)

    def run():
        if not system.SolveDynamic(chosen, solverType=exudyn.DynamicSolverType.GeneralizedAlpha):
            raise RuntimeError("not converged")
        return np.concatenate(
            [system.GetNodeOutput(along[at], place)[:2] for at in ((cells, cells), (cells // 2, cells))]
        )

    run.built = container, system  # type: ignore[attr-defined]
    return run
