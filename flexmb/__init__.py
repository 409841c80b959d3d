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
    "checks.mobility": ("Mobility", "mobility"),
    "statics.equilibrium": ("Equilibrium", "equilibrium"),
    "linear.linearize": ("Linearization", "linearize", "second_transfer"),
    "linear.modes": ("Modes", "frequencies", "modes", "poles"),
    "linear.buckling": ("Buckling", "buckling", "buckling_loads"),
    "paths.path": ("Path", "path"),
    "paths.critical": ("CriticalPoint", "limit_load"),
    "statics.configuration": ("Configuration", "configuration"),
    "motion.simulate": ("Motion", "Observed", "simulate"),
    "motion.linearize_motion": ("linearize_motion", "steady_motion"),
    "motion.loop": ("Sampled",),
    "motion.controlled_form": ("Feedback",),
    "motion.drive": ("Table",),
    "motion.energy_keeping": ("EnergyKeeping",),
    "motion.generalized_alpha": ("GeneralizedAlpha",),
    "motion.rosenbrock": ("Rodas5P",),
    "linear.stress": ("Location", "SectionResultants", "Stress", "section_resultants", "stress"),
    "linear.compliance": ("compliance", "directional_compliance"),
    "linear.measures": ("follow_modes", "frequency_like", "mode_assurance", "smooth_maximum", "smooth_minimum"),
    "design.designs": ("Designs", "grid", "latin_hypercube", "monte_carlo"),
    "design.sensitivities": ("Sensitivities", "Tolerances", "sensitivities", "tolerances"),
    "design.sweep": ("Sweep", "sweep"),
    "design.tune": ("Tuned", "tune"),
    "design.lean": ("Lean", "lean"),
    "design.too_lean": ("too_lean",),
    "design.objectives": ("mass", "settling_time", "stiffness"),
    "control.nonlinear_system": ("to_nonlinear_system",),
    "control.state_space": ("state_matrices", "to_statespace"),
    "answers.motion_file": ("save_motion",),
    "spacar.spacar": ("read_spacar",),
    "spacar.write": ("write_spacar",),
    "spacar.light": ("LightResults", "Struct", "StructArray", "spacar_light", "spacar_light_model"),
    "compilation.compile": ("jit",),
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
