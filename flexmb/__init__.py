"""Differentiable analysis of flexible multibody mechanisms.

Names are loaded on first use, so that importing the package costs nothing; ``__init__.pyi`` lists them.
"""

import importlib

__version__ = "0.1.0"

_ROOMS = {
    "elements": ("planar", "spatial", "sections"),
    "elements.sections": (
        "Circle",
        "Damping",
        "HollowRectangle",
        "Material",
        "Rectangle",
        "Rigidity",
        "Tube",
        "damping_from_ratio",
        "torsion_approximate",
        "torsion_series",
        "warping_factor",
    ),
    "elements.element": ("Element",),
    "elements.nodes": ("Angle", "Point2", "Point3", "Rotation3"),
    "build.builder": ("Builder",),
    "model.model": ("Model",),
    "errors": ("AnalysisError", "FlexmbWarning", "MechanismError", "ModelError", "SpacarError"),
    "results": ("RESULTS",),
    "analysis.mobility": ("Mobility", "mobility"),
    "analysis.equilibrium": ("Equilibrium", "equilibrium"),
    "analysis.linearize": ("Linearization", "linearize", "second_transfer"),
    "analysis.modal": ("Modes", "frequencies", "modes", "poles"),
    "analysis.buckling": ("Buckling", "buckling", "buckling_loads"),
    "analysis.path": ("Path", "path"),
    "analysis.critical": ("CriticalPoint", "limit_load"),
    "analysis.configuration": ("Configuration", "configuration"),
    "analysis.simulate": ("Motion", "Observed", "simulate"),
    "analysis.moving": ("linearize_motion", "steady_motion"),
    "analysis.closed_loop": ("Sampled",),
    "mechanics.controlled_form": ("Feedback",),
    "mechanics.drive": ("Table",),
    "solvers.energy_keeping": ("EnergyKeeping",),
    "solvers.generalized_alpha": ("GeneralizedAlpha",),
    "solvers.rosenbrock": ("Rodas5P",),
    "analysis.stress": ("Location", "SectionResultants", "Stress", "section_resultants", "stress"),
    "analysis.compliance": ("compliance", "directional_compliance"),
    "analysis.tracking": ("follow_modes", "frequency_like", "mode_assurance", "smooth_maximum", "smooth_minimum"),
    "design.designs": ("Designs", "grid", "latin_hypercube", "monte_carlo"),
    "design.sensitivities": ("Sensitivities", "Tolerances", "sensitivities", "tolerances"),
    "design.sweep": ("Sweep", "sweep"),
    "design.tune": ("Tuned", "tune"),
    "design.lean": ("Lean", "lean"),
    "design.too_lean": ("too_lean",),
    "design.objectives": ("mass", "settling_time", "stiffness"),
    "iosystem": ("to_nonlinear_system",),
    "statespace": ("state_matrices", "to_statespace"),
    "io.motion_file": ("save_motion",),
    "io.spacar": ("read_spacar", "write_spacar"),
    "io.spacar_light": ("LightResults", "Struct", "StructArray", "spacar_light", "spacar_light_model"),
    "math.compile": ("jit",),
    "setup": ("enable_cache", "enable_x64"),
    "viewer.view": ("View", "view"),
    "": ("plot",),
}
_WHERE = {name: room for room, names in _ROOMS.items() for name in names}
_MODULES = ("planar", "spatial", "sections", "plot")


def __getattr__(name: str):
    if name not in _WHERE:
        raise AttributeError(f"module 'flexmb' has no attribute '{name}'")
    if name in _MODULES:
        value = importlib.import_module(f".{_WHERE[name]}.{name}".replace("..", "."), __name__)
    else:
        value = getattr(importlib.import_module(f".{_WHERE[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_WHERE])
