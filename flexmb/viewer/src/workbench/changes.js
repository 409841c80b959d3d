/** What is done to all that is selected. */
import { describe } from "./describe.js";

/** Delete it, and tell what went along. */
export async function remove(canvas) {
  const ids = [...canvas.store.state.selection];
  if (!ids.length) return;
  const one = ids.length === 1;
  const words = one ? describe(canvas, ids[0]) : `${ids.length} things`;
  const name = one ? canvas.thing(ids[0])?.name ?? "" : ids.length;
  const reply = await canvas.edit([{ op: "delete", ids }], `Delete ${name}`);
  if (!reply) return;
  const along = reply.also?.length ? ` ${reply.also.length} dependent things were deleted too.` : "";
  canvas.say(`Deleted ${words}.${along}`);
}

/** Copy it beside itself; the copies are then selected, to be moved. */
export async function duplicate(canvas) {
  const { document: own, selection } = canvas.store.state;
  if (!selection.length) {
    canvas.say("Select the things to copy.", true);
    return;
  }
  const step = String(Number((4 * canvas.step).toPrecision(12)));
  const by = own.dimension === 2 ? [step, `-${step}`] : [step, "0", "0"];
  const reply = await canvas.edit([{ op: "copy", ids: [...selection], by, count: 1 }], "Copy");
  if (!reply?.ids?.length) return;
  await canvas.reached(reply.revision);
  canvas.store.select(reply.ids);
  canvas.say(`${reply.ids.length} things copied.`);
}
