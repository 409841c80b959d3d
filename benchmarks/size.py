"""Time and memory against size: a rack of 10 to 10 000 beams, dense and sparse, beside PyNite for the static part.

``python benchmarks/size.py`` prints the table that README quotes, writes results/size.json and draws results/size.png.
Times are those of the processor.
"""

import importlib.util
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
RUNS = 7
# Bays and floors; a rack has 2 bays x floors beams and one column more.
RACKS = ((2, 2), (4, 4), (7, 7), (12, 12), (22, 23), (40, 40), (70, 71))
DENSE = 300
PEER = 3500
BAY = 0.05


def rack(bays: int, floors: int):
    """Builder of a planar rack of leaf springs under its own weight and a force at its corner.

    Args:
        bays: Bays side by side.
        floors: Floors.
    """
    import flexmb as fm
    from flexmb import planar

    section = fm.Rectangle(0.018, 0.0005, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    for i in range(bays + 1):
        for j in range(floors + 1):
            b.node(f"n{i}_{j}", (BAY * i, BAY * j))
    for i in range(bays + 1):
        for j in range(floors):
            b.add(planar.beam, f"n{i}_{j}", f"n{i}_{j + 1}", section=section)
            if i < bays:
                b.add(planar.beam, f"n{i}_{j + 1}", f"n{i + 1}_{j + 1}", section=section)
        b.fix(f"n{i}_0")
    # Small enough for linear programs to have the same answer.
    b.force(f"n{bays}_{floors}", (1e-4, 0.0))
    return b


def pynite(bays: int, floors: int):
    """Displacement of the corner by PyNite, a linear program for frames, built and solved by its sparse solver.

    Args:
        bays: Bays side by side.
        floors: Floors.
    """
    from Pynite import FEModel3D

    model = FEModel3D()
    model.add_material("steel", 210e9, 80e9, 0.3, 0.0)
    width, thickness = 0.018, 0.0005
    model.add_section("leaf", width * thickness, thickness * width**3 / 12, width * thickness**3 / 12, 1e-12)
    for i in range(bays + 1):
        for j in range(floors + 1):
            model.add_node(f"n{i}_{j}", BAY * i, BAY * j, 0.0)
            held = j == 0
            model.def_support(f"n{i}_{j}", held, held, True, True, True, held)
    for i in range(bays + 1):
        for j in range(floors):
            model.add_member(f"c{i}_{j}", f"n{i}_{j}", f"n{i}_{j + 1}", "steel", "leaf")
            if i < bays:
                model.add_member(f"b{i}_{j}", f"n{i}_{j + 1}", f"n{i + 1}_{j + 1}", "steel", "leaf")
    model.add_node_load(f"n{bays}_{floors}", "FX", 1e-4)

    def solve():
        model.analyze_linear(sparse=True, check_stability=False, check_statics=False)
        return model.nodes[f"n{bays}_{floors}"].DX["Combo 1"]

    return solve


def main() -> None:
    """Compute, time, print, save and draw."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from record import PACKAGES, RESULTS, SLOW, once, peak_memory, processor_times, save, show

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache()
    found, run, slow, versions = {}, {}, {}, PACKAGES
    has_peer = importlib.util.find_spec("Pynite") is not None
    if has_peer:
        versions = (*versions, "PyNiteFEA")
    else:
        print("PyNite is not installed and is left out: pip install -e '.[peers]' brings it.")
    for bays, floors in RACKS:
        begin = time.perf_counter()
        builder = rack(bays, floors)
        model = builder.build(check=False)
        built = time.perf_counter() - begin
        beams, corner = len(model.labels.elements), f"n{bays}_{floors}"

        def static(model=model):
            return fm.equilibrium(model, sparse=True).x.block_until_ready()

        def lowest(model=model):
            return fm.frequencies(model, count=4, sparse=True).block_until_ready()

        begin = time.process_time()
        at, values = static(), lowest()
        entry = {"build_s": built, "first_s": time.process_time() - begin}
        moved = float(at[model.labels.known(corner)[0]]) - BAY * bays
        run[f"static, sparse: {beams}"], run[f"four frequencies, sparse: {beams}"] = static, lowest
        if beams <= DENSE:
            dense = builder.build()
            exact = fm.frequencies(dense, count=4, sparse=False)
            np.testing.assert_allclose(values, exact, rtol=1e-7)
            np.testing.assert_allclose(fm.equilibrium(dense, sparse=False).x, at, atol=1e-12)
            run[f"static, dense: {beams}"] = lambda m=dense: fm.equilibrium(m, sparse=False).x.block_until_ready()
            run[f"four frequencies, dense: {beams}"] = lambda m=dense: fm.frequencies(
                m, count=4, sparse=False
            ).block_until_ready()
        if has_peer and beams <= PEER:
            solve = pynite(bays, floors)
            displaced, took = once(solve)
            entry["peer_apart"] = abs(displaced / moved - 1)
            # It compiles nothing, so that its first run counts where it is long.
            if took["median"] < SLOW:
                run[f"static, PyNite: {beams}"] = solve
            else:
                slow[f"static, PyNite: {beams}"] = took
        entry["peak_GB"] = peak_memory()
        found[beams] = entry
        print(f"{beams:6d} beams: " + ", ".join(f"{name} {value:.2g}" for name, value in entry.items()), flush=True)
    timed = processor_times(run, RUNS) | slow
    show("A rack of leaf springs, compiled", timed)
    save("size", {"found": found, "times": timed}, versions)
    figure, axes = plt.subplots(figsize=(6.8, 4.6), layout="constrained")
    families: dict[str, list[tuple[int, float]]] = {}
    for name, t in timed.items():
        family, beams = name.rsplit(": ", 1)
        families.setdefault(family, []).append((int(beams), t["median"]))
    for (family, points), marker in zip(families.items(), "osD^v", strict=False):
        axes.loglog(*zip(*points, strict=True), marker=marker, label=family)
    axes.set(xlabel="beams", ylabel="processor time, compiled [s]", title="A planar rack of leaf springs")
    axes.grid(alpha=0.4)
    axes.legend(fontsize=8)
    figure.savefig(RESULTS / "size.png", dpi=120)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
