/** Texts over a picture, each where there is room for it: earlier ones keep their place. */

const CELL = [7, 13];
const FONT = "12px system-ui, sans-serif";

export class Words {
  /** `back` is the colour around the letters, so that they stand out from what they lie on. */
  constructor(pen, width, height, back) {
    Object.assign(this, { pen, width, height, back, taken: new Set() });
  }

  /** Whether the text found room. */
  write(content, x, y, colour, align = "left", font = FONT) {
    const { pen, taken } = this;
    if (x < 0 || y < 0 || x > this.width || y > this.height) return false;
    pen.font = font;
    const wide = pen.measureText(content).width;
    const left = { left: x, right: x - wide, center: x - wide / 2 }[align];
    const cells = [];
    for (let i = Math.floor(left / CELL[0]); i <= Math.floor((left + wide) / CELL[0]); i += 1) {
      for (let j = Math.floor((y - 6) / CELL[1]); j <= Math.floor((y + 5) / CELL[1]); j += 1) cells.push(`${i},${j}`);
    }
    if (cells.some((cell) => taken.has(cell))) return false;
    for (const cell of cells) taken.add(cell);
    const { lineWidth } = pen;
    pen.textAlign = align;
    pen.textBaseline = "middle";
    pen.lineWidth = 3;
    pen.strokeStyle = this.back;
    pen.strokeText(content, x, y);
    pen.fillStyle = colour;
    pen.fillText(content, x, y);
    pen.lineWidth = lineWidth;
    return true;
  }
}
