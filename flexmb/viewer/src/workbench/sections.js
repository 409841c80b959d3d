/** Sections and materials that are added with numbers to begin with. */
import { fieldsOf, namesOf, things } from "./model.js";

// What a first section is like [m]: a leaf spring of 20 by 0.5 mm, a wire of 1 mm, a tube of 10 by 1 mm.
const SIZES = {
  width: "20e-3",
  thickness: "0.5e-3",
  diameter: "1e-3",
  wall: "1e-3",
  wall_y: "1e-3",
  wall_z: "1e-3",
  height: "10e-3",
  neck: "0.5e-3",
  radius: "5e-3",
  along: "5e-3",
  across: "4.75e-3",
  flat: "5e-3",
  length: "0.1",
  ratio: "0.01",
};
const OWN_SIZES = {
  Tube: { diameter: "10e-3" },
  HollowRectangle: { thickness: "10e-3" },
  notch_filleted: { radius: "1e-3" },
};
const STEEL = { E: "210e9", G: "80e9", nu: "0.3", rho: "7850" };

/** Name that is free: "leaf", "leaf 2", … */
export function freeName(store, wanted) {
  const taken = new Set(things(store).map(({ name }) => name));
  let name = wanted;
  for (let k = 2; taken.has(name); k += 1) name = `${wanted} ${k}`;
  return name;
}

/** Add a section or material, a section with a material where there is none; the answer is its id. */
export async function addSection(store, call, wanted = null) {
  const ops = [];
  const fields = fieldsOf(store, call);
  const args = {};
  let material = namesOf(store, ["material"]).at(-1);
  if (fields.some(({ kind, optional }) => kind === "material" && !optional) && !material) {
    material = "steel";
    ops.push({ op: "add", thing: steel(store, material) });
  }
  for (const { name, kind, optional, default: usual } of fields) {
    if (kind === "material" && !optional) args[name] = material;
    else if (!optional && kind === "number") {
      args[name] = String(usual ?? OWN_SIZES[call]?.[name] ?? STEEL[name] ?? SIZES[name] ?? "1");
    }
  }
  if (call === "Material") args.rho = STEEL.rho;
  const name = freeName(store, wanted ?? call.split(".").at(-1).toLowerCase());
  ops.push({ op: "add", thing: { call, name, args } });
  const { ids } = await store.edit(ops, { label: `Add ${name}` });
  return ids.at(-1);
}

/** Steel by its numbers, to be changed. */
function steel(store, name) {
  const wanted = new Set((store.state.catalogue?.Material?.fields ?? []).map((field) => field.name));
  return {
    call: "Material",
    name,
    args: Object.fromEntries(
      Object.entries(STEEL).filter(([key]) => wanted.has(key) && !(key === "nu" && wanted.has("G"))),
    ),
  };
}
