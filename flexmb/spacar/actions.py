"""The actions of the keywords of SPACAR input files, one function a keyword.

Each function receives the reading, the line, and the parameters by name.
"""

from collections.abc import Callable
from typing import Any

from ..build.assemble import stack
from ..build.builder import Builder
from ..elements.nodes import ANGLE, ROTATION3, NodeKind
from ..elements.spectral import LARGEST_ORDER
from ..errors import printable
from ..model.topology import Role
from . import series as series
from .kinds import KINDS, NOTHING, SIZES, leaf_section
from .lines import DRAWING, Fault, Statement, is_zero, known
from .reading import NOUNS, Declared, Reading, Setting

Values = dict[str, Any]
VECTORS = ("y1", "y2", "y3", "axis1", "axis2", "axis3", "x1", "x2", "x3")


def declare(r: Reading, s: Statement, p: Values) -> None:
    """An element line, which introduces its nodes; a keyword has a kind for each of its forms."""
    kind = next(k for k in KINDS if k.keyword == s.keyword and set(k.node_names) <= set(p))
    number, nodes = p["element"], [p[name] for name in kind.node_names]
    if number in r.elements:
        raise Fault(f"is defined already on line {r.elements[number].statement.line}; give each element its own number")
    first = next(iter(r.elements.values()), None)
    if first is not None and first.kind.dimension != kind.dimension:
        names = {2: "planar", 3: "spatial"}
        other = f"{first.kind.keyword} on line {first.statement.line} is {names[first.kind.dimension]}"
        raise Fault(f"{kind.keyword} is {names[kind.dimension]}, but {other}; a mechanism is either planar or spatial")
    for p_end, q_end in (("xp", "xq") if "xp" in p else ("rotp", "rotq"), ("warpp", "warpq")):
        if p_end in p and p[p_end] == p[q_end]:
            raise Fault(f"joins node {p[p_end]} to itself; {kind.keyword} needs two nodes {p_end} and {q_end}")
    if p.get("p", 1) > LARGEST_ORDER:
        raise Fault(f"p, the coefficients of a strain field, must be at most {LARGEST_ORDER}, but is {p['p']}")
    named: dict[int, tuple[NodeKind, Statement]] = {}
    for node, node_kind in zip(nodes, kind.node_kinds, strict=True):
        known, line = r.nodes.get(node) or named.setdefault(node, (node_kind, s))
        if known.part != node_kind.part:
            raise Fault(
                f"takes node {node} for a {_part(node_kind)} node, but it is a {_part(known)} node on line"
                f" {line.line} ({line.keyword}); expected: {kind.keyword} {kind.form}"
            )
    r.nodes |= named
    vector = [p[name] for name in VECTORS if name in p]
    others = {prop: p[name] for name, prop in kind.numbers}
    r.elements[number] = Declared(s, kind, tuple(nodes), vector or None, p.get("p"), others)


def _part(kind: NodeKind) -> str:
    return {"position": "translational", "rotation": "rotational"}.get(kind.part, kind.part)


def position(r: Reading, s: Statement, p: Values) -> None:
    """X: position of a translational node."""
    kind = r.kind_of(p["node"])
    if kind.part != "position":
        line = r.nodes[p["node"]][1]
        where = f"({line.keyword} on line {line.line})"
        raise Fault(f"is a {_part(kind)} node {where}: only a translational node has a position")
    values = [p[name] for name in ("x", "y", "z") if name in p]
    if len(values) > kind.size:
        raise Fault(f"has {kind.size} coordinates in a planar mechanism, but {len(values)} are given")
    r.once(s, p["node"])
    r.positions[p["node"]] = values + [0.0] * (kind.size - len(values))


def section_numbers(r: Reading, s: Statement, p: Values) -> None:
    """ESTIFF, EM, EDAMP: numbers of an element's section."""
    declared = r.declared(p["element"])
    kind, values = declared.kind, p["value"]
    names = {"ESTIFF": kind.stiffness, "EM": kind.mass, "EDAMP": kind.damping}[s.keyword]
    if not names:
        instead = "put mass on nodes with XM" if s.keyword == "EM" else "it has no stiffness of its own"
        instead = "SECTION gives its stiffness and its mass" if kind.sized else instead
        raise Fault(f"{kind.keyword} takes no {s.keyword}: {instead}")
    if len(values) > len(names):
        raise Fault(f"{kind.keyword} takes at most {_counted(names)}, but {len(values)} are given")
    for name, value in zip(names, values, strict=False):
        if name == NOTHING and not is_zero(value):
            missing = "rotary inertia" if s.keyword == "EM" else "shear deformation"
            raise Fault(f"{kind.keyword} has no {missing}: this number must be 0, but is {value}")
        if name not in ("stiffness", "damping", "Jyz") and known(value) and value < 0:
            raise Fault(f"{name} must not be negative, but is {value}")
    counted = sum(not known(v) or v > 0 for v in (*values, 0, 0)[4:6])
    if kind.element.fields and s.keyword == "ESTIFF" and counted == 1:
        raise Fault(f"{kind.keyword} counts shear in both directions or in none: give shear_z and shear_y, or neither")
    _keep(r, s, p, values)


def section(r: Reading, s: Statement, p: Values) -> None:
    """SECTION: sizes and material of a leaf spring."""
    kind = r.declared(p["element"]).kind
    if not kind.sized:
        raise Fault(f"{kind.keyword} takes ESTIFF and EM instead of SECTION; SECTION is for LEAF and PLLEAF")
    values = [p[name] for name in SIZES if name in p]
    if all(map(known, values)):
        for fault in leaf_section(values).faults():
            raise Fault(f"has {fault.removesuffix(', or give nu')}")
    _keep(r, s, p, values)


def clamp(r: Reading, s: Statement, p: Values) -> None:
    """CLAMP: which ends of a leaf spring are clamped."""
    kind = r.declared(p["element"]).kind
    if not kind.sized:
        raise Fault(f"{kind.keyword} takes no CLAMP: CLAMP states the clamped ends of a LEAF or PLLEAF")
    for name in ("first", "last"):
        if p[name] > 1:
            raise Fault(f"{name} must be 1 for a clamped end or 0 for a free one, but is {p[name]}")
    _keep(r, s, p, [p["first"], p["last"]])


def _keep(r: Reading, s: Statement, p: Values, values: list[Any]) -> None:
    """Keep the numbers of an element's line, which may occur once."""
    r.once(s, p["element"])
    r.lines.setdefault(p["element"], {})[s.keyword] = values


def _counted(names: tuple[str, ...]) -> str:
    listed = [name for name in dict.fromkeys(names) if name != NOTHING]
    return f"{len(names)} number{'s' if len(names) > 1 else ''} ({', '.join(listed)})"


def _take_role(r: Reading, s: Statement, owner: int, components: list[int], kind: str, repeatable: bool) -> list[int]:
    """Give entries a role, and return their numbers, each once."""
    noun, again = NOUNS[kind], []
    named: dict[int, int] = {}
    for i, component in enumerate(components):
        if component in components[:i]:
            raise Fault(f"{noun} {component} is named twice")
        for number in r.meant(owner, component, kind):
            named.setdefault(number, component)
    for number, component in named.items():
        first = r.roles.get((kind, owner, number))
        if first is not None and (first.keyword != s.keyword or not repeatable):
            raise Fault(
                f"{noun} {component} has a role already by {first.keyword} on line {first.line}; only one role is"
                " allowed"
            )
        if first is not None:
            again.append(f"{noun} {component} of {kind} {owner} is named already on line {first.line}")
    for text in again[:1]:
        r.warn(s, text)
    r.roles |= {(kind, owner, number): s for number in named}
    return list(named)


def fix(r: Reading, s: Statement, p: Values) -> None:
    """FIX: coordinates at their start values; all by default."""
    size = r.kind_of(p["node"]).size
    components = p.get("coordinate", list(range(1, size + 1)))
    _take_role(r, s, p["node"], components, "node", repeatable=True)
    r.builder.fix(str(p["node"]), *components)


def release(r: Reading, s: Statement, p: Values) -> None:
    """RLSE: deformations that may change."""
    numbers = _take_role(r, s, p["element"], p["deformation"], "element", repeatable=True)
    r.builder.release(str(p["element"]), *numbers)
    if r.declared(p["element"]).kind.keyword in ("RBEAM", "PINBODY", "PLRBEAM", "PLPINBODY"):
        r.warn(s, "deformations of a rigid offset are measured along axes that start global and turn with p")


def degree_of_freedom(r: Reading, s: Statement, p: Values) -> None:
    """DYNX, DYNE: degrees of freedom."""
    kind, owner, components = target(p)
    r.builder.dof(str(owner), *_take_role(r, s, owner, components, kind, repeatable=False), kind=kind)


def prescribed(r: Reading, s: Statement, p: Values) -> None:
    """INPUTX, INPUTE in the kinematics block: prescribed coordinates or deformations, at their start values so far."""
    kind, owner, components = target(p)
    for component in components:
        r.single(owner, component, kind)
    for component in _take_role(r, s, owner, components, kind, repeatable=True):
        r.builder.prescribe(str(owner), component, kind=kind)


def target(p: Values) -> tuple[str, int, Any]:
    """Whether a line concerns a node or an element, its number, and the numbers of coordinates or deformations."""
    if "node" in p:
        return "node", p["node"], p["component"] if "component" in p else p["coordinate"]
    return "element", p["element"], p["deformation"]


def lumped(r: Reading, s: Statement, p: Values) -> None:
    """XM: mass of a translational node, rotary inertia of a rotational one."""
    kind, values = r.kind_of(p["node"]), p["value"]
    r.entries(p["node"], [], "node")
    if kind.part == "warping":
        raise Fault("is a warping node and has no lumped mass: the sixth number of EM of BEAMW is Jw")
    count = {"position": 1, "rotation": 1 if kind is ANGLE else 6}[kind.part]
    if len(values) != count:
        names = "mass" if kind.part == "position" else "J" if kind is ANGLE else "Ixx Ixy Ixz Iyy Iyz Izz"
        raise Fault(f"{_part(kind)} node takes {count} ({names}), but {len(values)} are given")
    r.once(s, p["node"])
    if kind.part == "position":
        if known(values[0]) and values[0] < 0:
            raise Fault(f"mass must not be negative, but is {values[0]}; only a rotational node may have that")
        r.builder.mass(str(p["node"]), values[0])
    else:
        r.builder.inertia(str(p["node"]), values[0] if kind is ANGLE else stack(values))


def force(r: Reading, s: Statement, p: Values) -> None:
    """XF, DELXF: forces; of a spatial rotation 3 moment components, or 4 duals of the Euler parameters."""
    kind, values, increment = r.kind_of(p["node"]), p["value"], s.keyword == "DELXF"
    r.entries(p["node"], [], "node")
    spatial = kind is ROTATION3
    if spatial and len(values) not in (3, 4):
        forms = "3 moment components, or 4 duals of the Euler parameters"
        raise Fault(f"rotational node takes {forms}; {len(values)} are given")
    if len(values) > kind.size:
        raise Fault(f"{_part(kind)} node takes at most {kind.size} components, but {len(values)} are given")
    moment = spatial and len(values) == 3
    r.once(s, p["node"], moment)
    # Missing components are zero.
    values = values if moment else values + [0.0] * (kind.size - len(values))
    (r.builder.moment if moment else r.builder.force)(str(p["node"]), values, increment=increment)


# Warning about a line; modes that use velocities and accelerations leave it out.
RATES_IDLE = "velocity and acceleration are for modes 1 to 6; other modes have no time and do not use them"


def start_of(builder: Builder, kind: str, of: int | str, number: int) -> Any:
    """Value of a coordinate in the undeformed mechanism, from which a Builder counts; 0 for a deformation."""
    return builder.nodes[str(of)].start[number - 1] if kind == "node" else 0.0


def motion(r: Reading, s: Statement, p: Values) -> None:
    """INPUTX, INPUTE in the dynamics block: value of a prescribed coordinate or deformation."""
    kind, owner, component = target(p)
    r.require(owner, component, kind, Role.PRESCRIBED)
    r.once(s, owner, component)
    r.builder.prescribe(str(owner), component, p["value"] - start_of(r.builder, kind, owner, component), kind=kind)
    rates = p.get("velocity", 0.0), p.get("acceleration", 0.0)
    r.settings.setdefault(s.keyword, []).append((owner, component, p["value"], *rates))
    if any(not is_zero(rate) for rate in rates):
        r.warn(s, RATES_IDLE)


def motion_increment(r: Reading, s: Statement, p: Values) -> None:
    """DELINPX, DELINPE: increment of a prescribed value over the load path."""
    kind, owner, component = target(p)
    r.require(owner, component, kind, Role.PRESCRIBED)
    r.once(s, owner, component)
    r.builder.prescribe(str(owner), component, p["increment"], increment=True, kind=kind)


def _element_values(r: Reading, s: Statement, p: Values, spread: Callable[..., dict[int, float]]) -> list[float]:
    """Values of an element's deformations; ``spread`` converts values of a beam to values of a spectral beam."""
    element, values = p["element"], p["value"]
    roles = r.entries(element, list(range(1, len(values) + 1)), "element")
    r.once(s, element)
    member = r.builder.members[str(element)]
    if r.declared(element).kind.sized:
        first = member.element.fields[0][0]
        if nonzero := [i for i, v in enumerate(values[: first - 1], 1) if not is_zero(v)]:
            keyword = r.declared(element).kind.keyword
            raise Fault(
                f"{keyword} accepts only values of single coefficients, from deformation {first} on; value {nonzero[0]}"
                " must be 0"
            )
    elif member.element.fields:
        start, end = (r.builder.nodes[member.nodes[k]].start for k in (0, 2))
        length = sum((q - p) ** 2 for p, q in zip(start, end, strict=True)) ** 0.5
        try:
            values_by_number = spread(member.element, length, values)
        except ValueError as fault:
            raise Fault(str(fault)) from None
        values = [values_by_number.get(n, 0.0) for n in range(1, max(values_by_number, default=1) + 1)]
        roles = member.roles[: len(values)]
    numbered = enumerate(zip(roles, values, strict=True), 1)
    held = (Role.FIXED, Role.PRESCRIBED)
    idle = [str(i) for i, (role, v) in numbered if role in held and not is_zero(v)]
    if idle:
        listed = f"{'deformation' if len(idle) == 1 else 'deformations'} {', '.join(idle)}"
        r.warn(s, f"{listed} of element {element} is fixed, so the value has no effect")
    return values


def prestress(r: Reading, s: Statement, p: Values) -> None:
    """ESIG, DELESIG: stress resultants added to those of the stiffness."""
    values = _element_values(r, s, p, series.resultants)
    r.builder.prestress(str(p["element"]), *values, increment=s.keyword == "DELESIG")


def strain(r: Reading, s: Statement, p: Values) -> None:
    """EINIT: deformations without stress."""
    r.builder.strain(str(p["element"]), *_element_values(r, s, p, series.strain_coefficients))


def expansion(r: Reading, s: Statement, p: Values) -> None:
    """ALPHA: coefficient of thermal expansion of an element."""
    kind = r.declared(p["element"]).kind
    if kind.element.thermal is None:
        raise Fault(f"{kind.keyword} takes no ALPHA: temperature does not deform it")
    if kind.sized:
        raise Fault(f"{kind.keyword} takes no ALPHA: alpha is the last number of its SECTION")
    _keep(r, s, p, [p["value"]])


def temperature(r: Reading, s: Statement, p: Values) -> None:
    """TEMP, DELTEMP: change of temperature of an element or of its two ends, and gradients across."""
    element, values = p["element"], p["value"]
    axes = r.declared(element).kind.dimension - 1
    r.entries(element, [], "element")
    if len(values) not in (1, 2, 2 + axes):
        across = "along y and along z" if axes == 2 else "across"
        raise Fault(
            f"element takes the change, or that of its first and its last end, or both and the gradient {across}, but"
            f" {len(values)} numbers are given"
        )
    r.once(s, element)
    gradient = None if len(values) < 3 else values[2:] if axes == 2 else values[2]
    r.builder.temperature(str(element), values[:2], gradient=gradient, increment=s.keyword == "DELTEMP")


def gravity(r: Reading, s: Statement, p: Values) -> None:
    """GRAVITY: acceleration."""
    r.once(s)
    values = [p[name] for name in ("gx", "gy", "gz") if name in p]
    if r.builder.dimension == 3 and len(values) != 3:
        raise Fault("a spatial mechanism needs three components: gx gy gz")
    if r.builder.dimension == 2 and any(not is_zero(value) for value in values[2:]):
        raise Fault(f"a planar mechanism has no third axis: gz must be 0, but is {values[2]}")
    r.builder.gravity(values[: r.builder.dimension])


def setting(r: Reading, s: Statement, p: Values) -> None:
    """TIMESTEP, ERROR, ITERSTEP: numbers for an analysis."""
    r.once(s)
    for name in ("end", "absolute", "relative", "tolerance"):
        if name in p and known(p[name]) and p[name] <= 0:
            raise Fault(f"{name} must be positive, but is {p[name]}")
    r.settings[s.keyword] = Setting(s.line, p)
    if s.keyword == "ITERSTEP":
        r.warn(s, "has no effect: a path (mode 10) chooses its load steps and iterates to round-off")


def start_value(r: Reading, s: Statement, p: Values) -> None:
    """STARTDX, STARTDE: start values of a degree of freedom."""
    kind, owner, component = target(p)
    r.require(owner, component, kind, Role.DOF)
    r.once(s, owner, component)
    velocity = p.get("velocity", 0.0)
    r.settings.setdefault(s.keyword, []).append((owner, component, p["value"], velocity))
    start = start_of(r.builder, kind, owner, component)
    r.builder.start(str(owner), component, p["value"] - start, velocity, kind=kind)


def routine(r: Reading, s: Statement, p: Values) -> None:
    """USERSIG, USERINP: a Python function given beside the file."""
    r.once(s)
    if p["name"] not in r.callables:
        name = printable(p["name"])
        raise Fault(f"needs the user routine '{name}': pass read_spacar(..., callables={{'{name}': function}})")
    r.settings[s.keyword] = (p["name"], r.callables[p["name"]])
    r.warn(s, "the function stays in settings and has no effect in an analysis: pass it to simulate (loads=, motion=)")


def log_level(r: Reading, s: Statement, p: Values) -> None:
    """OUTLEVEL, LEVELLOG: amount of output in the log of the predecessor."""
    r.settings[s.keyword] = (p["log"], p["store"])
    r.warn(s, "has no effect: all transfer functions are always available")


def drawing(r: Reading, s: Statement) -> None:
    """A line of the visualization section, kept unchanged."""
    r.settings.setdefault(DRAWING.upper(), []).append(s.raw)
    r.drawn.append(s)
