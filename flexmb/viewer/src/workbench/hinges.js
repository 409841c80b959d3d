/** A hinge where elements meet: one of them gets a rotation of its own there, and the hinge joins the two. */
import { freeName } from "./naming.js";
import { listOf } from "./plan.js";

/** Whether a call is drawn as a hinge: by its node, and the element that turns there. */
export const isHinge = (call) => /^(planar|spatial)\.hinge$/.test(call);

export const SLOTS = [
  { field: "nodes", what: "node" },
  { field: "nodes", what: "element" },
];

/** Operations that hinge an element at one of its nodes, and the nodes of the hinge. */
export function hinged(canvas, node, element, taken) {
  const line = canvas.plan.byElement.get(element);
  const names = listOf(line.args.nodes);
  // One name for each end, or one for its place and one for its rotation.
  const full = names.length === 2 ? names.flatMap((name) => [name, name]) : names.slice();
  const at = full.indexOf(node);
  if (at < 0 || full.length !== 4) {
    throw new Error(`${element} has no end at ${node} that could turn: click an element that ends at this node.`);
  }
  const name = freeName(canvas, `${node} turn`, taken);
  full[at + 1] = name;
  const ops = [
    { op: "add", thing: { call: "rotation", name, args: {} } },
    { op: "set", address: `${line.id}/nodes`, to: full },
  ];
  return { ops, nodes: [node, name] };
}
