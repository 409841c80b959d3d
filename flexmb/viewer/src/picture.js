/** The picture as one canvas: background, elements, marks and scale. */
import { css } from "./theme.js";

export function picture(stage, overlay, colours, scale) {
  const canvas = Object.assign(document.createElement("canvas"), { width: overlay.width, height: overlay.height });
  const pen = canvas.getContext("2d");
  pen.fillStyle = css(colours.back);
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.drawImage(stage.canvas, 0, 0, canvas.width, canvas.height);
  pen.drawImage(overlay, 0, 0);
  if (scale) legend(pen, stage, colours, scale);
  return canvas;
}

function legend(pen, { ratio, height }, colours, { table, low, high, label }) {
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  const tall = Math.min(160, height - 60);
  const fill = pen.createLinearGradient(0, 30 + tall, 0, 30);
  table.forEach((rgb, i) => fill.addColorStop(i / (table.length - 1), css(rgb.map((part) => Math.round(255 * part)))));
  pen.fillStyle = fill;
  pen.fillRect(16, 30, 14, tall);
  pen.fillStyle = css(colours.text);
  pen.font = "12px system-ui, sans-serif";
  pen.textBaseline = "middle";
  pen.fillText(label, 16, 16);
  for (const [share, value] of [[0, low], [0.5, (low + high) / 2], [1, high]]) {
    pen.fillText(String(Number(value.toPrecision(4))), 36, 30 + tall * (1 - share));
  }
}
