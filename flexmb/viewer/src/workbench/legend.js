/** The scale of colours, in the upper left corner. */
import { shown } from "./arithmetic.js";

const TALL = 150;
const WIDE = 14;

export function legend({ pen, colours, words }, { label, table, low, high }) {
  const [x, y] = [46, 62];
  words.write(label, x, y - 16, colours.text);
  for (let i = 0; i < TALL; i += 1) {
    const entry = table[Math.round(((TALL - 1 - i) / (TALL - 1)) * (table.length - 1))];
    pen.fillStyle = `rgb(${entry.map((part) => Math.round(255 * part)).join(", ")})`;
    pen.fillRect(x, y + i, WIDE, 1.5);
  }
  const values = [high, (high + low) / 2, low];
  values.forEach((value, k) => words.write(shown(value), x + WIDE + 6, y + 4 + (k * (TALL - 8)) / 2, colours.text));
}
