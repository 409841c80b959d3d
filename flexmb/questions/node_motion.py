"""Velocities and accelerations of a node in a motion: "velocity top.x", "acceleration top.phi"."""

from .question import Question, by_component, component_answer

QUESTIONS = tuple(
    Question(
        name,
        ("node", "axis"),
        component_answer(name, f"angular_{name}"),
        by_component(f"m/{per}", f"rad/{per}"),
        of_many=True,
        differentiable=False,
    )
    for name, per in {"velocity": "s", "acceleration": "s²"}.items()
)
