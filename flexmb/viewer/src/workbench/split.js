/** The line between two panels, moved by mouse or keyboard. */
import { byId } from "./dom.js";

export function split() {
  const line = byId("split");
  const upper = byId("upper");
  const limit = (share) => Math.min(85, Math.max(15, share));
  const place = (share) => {
    const now = Math.round(limit(share));
    upper.style.setProperty("--upper", `${now}%`);
    line.setAttribute("aria-valuenow", String(now));
  };
  line.addEventListener("pointerdown", (event) => {
    line.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  line.addEventListener("pointermove", (event) => {
    if (!line.hasPointerCapture(event.pointerId)) return;
    const { top, height } = line.parentElement.getBoundingClientRect();
    place((100 * (event.clientY - top)) / height);
  });
  line.addEventListener("keydown", (event) => {
    const by = { ArrowUp: -4, ArrowDown: 4 }[event.key];
    if (!by) return;
    event.preventDefault();
    place(Number(line.getAttribute("aria-valuenow")) + by);
  });
}
