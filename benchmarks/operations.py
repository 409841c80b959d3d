"""Only what the scene has is computed: operations of the compiled programs, by what is asked of them.

``python benchmarks/operations.py`` prints the table that README quotes and writes results/operations.json. Counted are
floating-point operations as the compiler estimates them, and transcendental functions among them; loops count once.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent


def chain(element, beams: int, force: float = 0.0, rotating: bool = True, **options):
    """A cantilever of beams, or of bars with masses.

    Args:
        element: Its type.
        beams: How many.
        force: Dead force at its end [N].
        rotating: Beams, whose inertia depends on how they are turned, or bars, whose masses are points.
        options: Of the elements.
    """
    import flexmb as fm

    section = fm.Rectangle(0.018, 0.0005, fm.Material(E=210e9, G=80e9, rho=7850.0))
    space = "y" in options
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (0.05 * i, 0.0, 0.0)[: 3 if space else 2])
    for i in range(beams):
        if rotating:
            b.add(element, f"n{i}", f"n{i + 1}", section=section, **options)
        else:
            b.add(element, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e5))
            b.fix(f"n{i + 1}", "y")
            b.mass(f"n{i + 1}", 0.1)
    b.fix("n0")
    if force:
        b.force(f"n{beams}", (force, 0.0, 0.0)[: 3 if space else 2])
    return b.build()


def main() -> None:
    """Count, print and save."""
    import jax
    from record import save

    import flexmb as fm
    from flexmb import planar, spatial
    from flexmb.linear.linearize import matrices
    from flexmb.linear.modes import _frequencies
    from flexmb.mechanics.loads import load_factors
    from flexmb.motion.coordinates_form import coordinates_form

    fm.enable_x64()

    def cost(function, *arguments):
        found = jax.jit(function).lower(*arguments).compile().cost_analysis()
        return {"operations": found["flops"], "transcendentals": found.get("transcendentals", 0.0)}

    def linearised(model):
        return cost(lambda p: matrices(model.topology, p, load_factors()).K0, model.parameters)

    def first(model):
        return cost(lambda p: _frequencies(model.topology, p, load_factors(), count=1), model.parameters)

    def motion(model):
        def residual(parameters, x, v):
            form = coordinates_form(model.topology, parameters)
            state = form.state_of(x, v, None)
            return form.residual(0.0, state, jax.numpy.zeros(form.size + form.held.shape[0]))

        n_x = model.topology.n_x
        return cost(residual, model.parameters, model.parameters.reference, jax.numpy.zeros(n_x))

    plane, space = chain(planar.beam, 4), chain(spatial.beam, 4, y=(0, 1, 0))
    loaded = chain(planar.beam, 4, force=1.0)
    bars = chain(planar.truss, 4, rotating=False)
    found = {
        "plane: stiffness alone, no load (no Newton, no inertia)": linearised(plane),
        "plane: stiffness alone, under load (Newton)": linearised(loaded),
        "plane: first frequency, no load": first(plane),
        "space: stiffness alone, no load": linearised(space),
        "space: first frequency, no load": first(space),
        "plane: equations of motion, beams": motion(plane),
        "plane: equations of motion, bars with point masses (constant mass)": motion(bars),
        "space: equations of motion, beams": motion(space),
    }
    for name, entry in found.items():
        print(f"{name:<70}{entry['operations']:12.0f} operations, {entry['transcendentals']:8.0f} transcendental")
    save("operations", {"found": found})


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
