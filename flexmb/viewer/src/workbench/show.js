/** What the drawing shows: which mode, how much of it, coloured by what. */
import { byId, choices, h, set, watch } from "./dom.js";
import { icon } from "./icons.js";

export function show(store, canvas) {
  const root = byId("show");
  const what = h("select", { id: "show-what", "aria-label": "What is shown" });
  const colour = h(
    "select",
    { id: "show-colour", "aria-label": "Coloured by" },
    new Option("plain", ""),
    new Option("stress", "stress"),
    new Option("sensitivity", "sensitivity"),
  );
  const amplitude = h("input", {
    type: "range",
    id: "amplitude",
    min: 0,
    max: 0.5,
    step: 0.005,
    value: 0.15,
    "aria-label": "Amplitude, as a share of the size",
  });
  const play = h("button", {
    type: "button",
    class: "plain",
    id: "play",
    "aria-pressed": "false",
    "aria-label": "Play the motion",
  });
  const fit = h(
    "button",
    { type: "button", class: "plain", id: "fit", title: "Fit the drawing into the window (f)" },
    "Fit",
  );
  const look = h("span", { class: "group", role: "group", "aria-label": "Look along" });
  for (const axis of ["x", "y", "z"]) {
    const one = h("button", { type: "button", class: "plain", "aria-label": `Look along ${axis}` }, axis);
    one.addEventListener("click", () => canvas?.look?.(axis));
    look.append(one);
  }
  // In space: the plane that is drawn on, and where it lies.
  const plane = h("select", { id: "plane", "aria-label": "Plane to draw on" }, new Option("xy", "2"), new Option("zx", "1"), new Option("yz", "0"));
  const height = h("input", { type: "text", id: "plane-height", size: 6, "aria-label": "Height of the plane [m]" });
  const planes = h("label", { title: "The plane to draw on, and its height [m] (keys X Y Z, [ ])" }, "Plane", plane, height);
  plane.addEventListener("change", () => canvas?.setPlane?.({ axis: Number(plane.value) }));
  height.addEventListener("change", () => {
    const value = canvas?.value?.(height.value);
    if (Number.isFinite(value)) canvas.setPlane({ height: value });
    planeIs();
  });
  byId("stage").addEventListener("plane", planeIs);
  function planeIs() {
    if (!canvas?.eye) return;
    plane.value = String(canvas.eye.axis);
    height.value = String(canvas.eye.height);
  }
  root.append(
    h("label", {}, "Show", what),
    h("label", {}, "Colour", colour),
    h("label", {}, "Amplitude", amplitude),
    play,
    h("span", { class: "spring" }),
    planes,
    look,
    fit,
  );
  let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;

  function playIcon() {
    play.replaceChildren(icon(playing ? "pause" : "play"));
    set(play, "aria-pressed", playing);
    set(play, "aria-label", playing ? "Pause the motion" : "Play the motion");
  }
  play.addEventListener("click", () => {
    playing = !playing;
    canvas?.play?.(playing);
    playIcon();
  });
  fit.addEventListener("click", () => canvas?.fit?.());
  amplitude.addEventListener("input", () => store.want({ amplitude: Number(amplitude.value) }).catch(() => {}));
  what.addEventListener("change", () => {
    const [state, mode] = what.value.split(" ");
    store.want({ state, ...(mode === undefined ? {} : { mode: Number(mode) }) }).catch(() => {});
  });
  colour.addEventListener("change", () => store.want({ colour: colour.value || null }).catch(() => {}));

  function update() {
    const { answers, want, document: own } = store.state;
    const modes = Object.entries(answers?.values ?? {}).filter(([key]) => key.startsWith("frequency"));
    const offered = modes.map(([, { text }], k) => ({
      value: `modes ${k}`,
      text: `Mode ${k + 1}${text ? `: ${text}` : ""}`,
    }));
    const loads = Object.keys(answers?.values ?? {}).filter((key) => key.startsWith("multiplier"));
    offered.push(
      ...loads.map((key, k) => ({ value: `buckling ${k}`, text: `Buckling ${k + 1}: × ${answers.values[key].text}` })),
    );
    offered.push({ value: "equilibrium", text: "Equilibrium" }, { value: "self-stress", text: "Self-stress" });
    const numbered = ["modes", "buckling"].includes(want.state);
    const now = numbered ? `${want.state} ${want.mode ?? 0}` : (want.state ?? "equilibrium");
    const word = want.state === "modes" ? "Mode" : "Buckling";
    if (numbered && !offered.some(({ value }) => value === now))
      offered.unshift({ value: now, text: `${word} ${(want.mode ?? 0) + 1}` });
    choices(what, offered, now);
    colour.value = want.colour ?? "";
    look.hidden = planes.hidden = own?.dimension !== 3;
  }
  watch(store, ["answers", "want", "document"], update);
  playIcon();
  planeIs();
  update();
}
