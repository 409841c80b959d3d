/** Where everything is between the states that were computed. */

/** Two neighbouring states and the share of the second at a position from 0 to 1. */
function between(along, rows, position, evenly) {
  if (rows < 2) return { first: 0, second: 0, share: 0 };
  if (evenly) {
    const at = Math.min(Math.max(position, 0), 1) * (rows - 1);
    const first = Math.min(Math.floor(at), rows - 2);
    return { first, second: first + 1, share: at - first };
  }
  const time = along[0] + position * (along[rows - 1] - along[0]);
  let first = 0;
  let last = rows - 1;
  while (last - first > 1) {
    const middle = (first + last) >> 1;
    if (along[middle] <= time) first = middle;
    else last = middle;
  }
  const share = (time - along[first]) / (along[last] - along[first] || 1);
  return { first, second: last, share: Math.min(Math.max(share, 0), 1) };
}

/** Points, nodes, sides of sections and values to colour by, updated in place. */
export class Motion {
  constructor(data) {
    this.data = data;
    this.points = Float32Array.from(data.base);
    this.nodes = Float32Array.from(data.nodes.base);
    this.across = data.across && Float32Array.from(data.across);
    this.count = data.base.length / 3;
    this.values = data.colours && new Float32Array(this.count);
    this.rows = data.base.length ? data.states.length / data.base.length : 0;
  }

  /** Number of what is played: time of a motion, load factor of a path, nothing else. */
  along(position) {
    const { along, kind } = this.data;
    const { first, second, share } = between(along, along.length, position, kind === "path");
    return (1 - share) * along[first] + share * along[second];
  }

  update({ choice, amplitude, position }) {
    const { data } = this;
    if (data.kind === "modes") {
      const factor = amplitude * Math.sin(2 * Math.PI * position);
      this.each((out, base, states) => {
        const from = choice * base.length;
        for (let i = 0; i < base.length; i += 1) out[i] = base[i] + factor * states[from + i];
      });
      this.colour(0, 0, 0);
      return;
    }
    const { first, second, share } = between(data.along, this.rows, position, data.kind !== "motion");
    if (this.rows > 0) {
      this.each((out, base, states) => {
        const one = first * base.length;
        const two = second * base.length;
        for (let i = 0; i < base.length; i += 1) {
          const state = (1 - share) * states[one + i] + share * states[two + i];
          out[i] = base[i] + amplitude * (state - base[i]);
        }
      });
    }
    if (data.choices.length) this.colour(choice, choice, 0);
    else this.colour(first, second, share);
  }

  each(move) {
    const { data } = this;
    move(this.points, data.base, data.states);
    move(this.nodes, data.nodes.base, data.nodes.states);
    if (this.across) move(this.across, data.across, data.acrossStates);
  }

  colour(first, second, share) {
    if (!this.values) return;
    const { values } = this.data.colours;
    const rows = values.length / this.count;
    const one = Math.min(first, rows - 1) * this.count;
    const two = Math.min(second, rows - 1) * this.count;
    for (let i = 0; i < this.count; i += 1) this.values[i] = (1 - share) * values[one + i] + share * values[two + i];
  }
}
