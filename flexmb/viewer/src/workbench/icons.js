/** Small drawings of what can be added, by the last word of its call or by its group. */

const SVG = "http://www.w3.org/2000/svg";
const DRAWN = {
  select: "M5 3l12 7-5.5 1.3L9 17z",
  node: "M12 8.5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7z",
  measure: "M3 16L16 3l5 5L8 21zM7 12l2 2M10 9l3 3M13 6l2 2",
  beam: "M4 19C8 8 16 16 20 5M4 19h.01M20 5h.01",
  leaf_spring: "M4 19C8 8 16 16 20 5M7 20C11 9 19 17 22 7",
  truss: "M5 18L19 6M5 18m-2 0a2 2 0 1 0 4 0 2 2 0 1 0-4 0M19 6m-2 0a2 2 0 1 0 4 0 2 2 0 1 0-4 0",
  rigid_beam: "M3 17L14 6l4 4L7 21zM18.5 5.5m-2 0a2 2 0 1 0 4 0 2 2 0 1 0-4 0",
  rigid_body: "M3 17L17 3l4 4L7 21z",
  hinge: "M12 12m-3.5 0a3.5 3.5 0 1 0 7 0 3.5 3.5 0 1 0-7 0M3 20l6.5-5.5M21 20l-6.5-5.5",
  slider: "M3 16h18M3 20h18M8 8h8v6H8z",
  prismatic: "M3 8h18M3 16h18M8 10h8v4H8z",
  spring_damper: "M3 12h3l2-5 3 10 3-10 3 10 2-5h2",
  rotary_spring_damper: "M12 12c1-2 4-1 3 1.5S10 17 8 14s1-8 5-8 8 4 7 9",
  gear: "M12 12m-4 0a4 4 0 1 0 8 0 4 4 0 1 0-8 0M12 3v4M12 17v4M3 12h4M17 12h4M5.6 5.6l2.9 2.9M15.5 15.5l2.9 2.9M18.4 5.6l-2.9 2.9M8.5 15.5l-2.9 2.9",
  belt: "M6 12m-3 0a3 3 0 1 0 6 0 3 3 0 1 0-6 0M17 12m-4.5 0a4.5 4.5 0 1 0 9 0 4.5 4.5 0 1 0-9 0M6 9l11-1.5M6 15l11 1.5",
  fix: "M12 4v10M5 14h14M7 14l-3 5M12 14l-3 5M17 14l-3 5",
  prescribe: "M3 12h12M11 8l4 4-4 4M19 5v14",
  mass: "M12 12m-7 0a7 7 0 1 0 14 0 7 7 0 1 0-14 0M12 5v14M5 12h14",
  inertia: "M12 12m-7 0a7 7 0 1 0 14 0 7 7 0 1 0-14 0M12 12m-2 0a2 2 0 1 0 4 0 2 2 0 1 0-4 0",
  body: "M5 8c0-5 14-5 14 0v8c0 5-14 5-14 0z",
  force: "M4 20L19 5M11 5h8v8",
  moment: "M6 17a8 8 0 1 1 11 1M17 12v6h-6",
  gravity: "M12 3v17M6 14l6 6 6-6",
  dof: "M3 12h18M7 8l-4 4 4 4M17 8l4 4-4 4",
  input: "M3 12h11M10 8l4 4-4 4M17 5h4v14h-4",
  output: "M3 5h4v14H3M9 12h12M17 8l4 4-4 4",
  material: "M4 20V8l8-4 8 4v12zM4 8l8 4 8-4M12 12v8",
  section: "M4 9h16v6H4z",
  block: "M4 4h7v7H4zM13 4h7v7h-7zM4 13h7v7H4zM13 13h7v7h-7z",
  cross_pivot: "M5 4h14M5 20h14M6 4l12 16M18 4L6 20",
  parallel_guide: "M4 20h4M16 20h4M6 20V6M18 20V6M4 6h16",
  temperature: "M10 4v10a4 4 0 1 0 4 0V4a2 2 0 0 0-4 0z",
  element: "M5 18L19 6M3.5 18h3M17.5 6h3",
  support: "M12 5l7 11H5zM4 20h16",
  load: "M4 20L19 5M11 5h8v8",
  signal: "M3 12h4l3-7 4 14 3-7h4",
  freedom: "M3 12h18M7 8l-4 4 4 4M17 8l4 4-4 4",
  undo: "M8 5L4 9l4 4M4 9h10a6 6 0 0 1 0 12h-3",
  redo: "M16 5l4 4-4 4M20 9H10a6 6 0 0 0 0 12h3",
  theme: "M20 14A8.5 8.5 0 1 1 10 4a7 7 0 0 0 10 10z",
  help: "M9 9a3 3 0 1 1 4.5 2.6c-1 .6-1.5 1.2-1.5 2.4M12 18h.01M12 12m-9.5 0a9.5 9.5 0 1 0 19 0 9.5 9.5 0 1 0-19 0",
  play: "M7 4l13 8-13 8z",
  pause: "M8 5v14M16 5v14",
  remove: "M6 6l12 12M18 6L6 18",
  add: "M12 5v14M5 12h14",
};

export function icon(call, group = "element") {
  const last = call.split(".").at(-1);
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", DRAWN[last] ?? DRAWN[group] ?? DRAWN.element);
  svg.append(path);
  return svg;
}

/** A line through the last values of something. */
export function sparkline(values) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 64 18");
  svg.setAttribute("aria-hidden", "true");
  const line = document.createElementNS(SVG, "polyline");
  const dot = document.createElementNS(SVG, "circle");
  dot.setAttribute("r", "2");
  svg.append(line, dot);
  redraw(svg, values);
  return svg;
}

export function redraw(svg, values) {
  const [line, dot] = svg.children;
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const whole = high - low || 1;
  const place = (value, i) => [
    values.length < 2 ? 62 : (62 * i) / (values.length - 1),
    high > low ? 16 - (14 * (value - low)) / whole : 9,
  ];
  line.setAttribute(
    "points",
    values
      .map((value, i) =>
        place(value, i)
          .map((part) => part.toFixed(1))
          .join(","),
      )
      .join(" "),
  );
  const [x, y] = values.length ? place(values.at(-1), values.length - 1) : [62, 9];
  dot.setAttribute("cx", String(x));
  dot.setAttribute("cy", String(y));
}
