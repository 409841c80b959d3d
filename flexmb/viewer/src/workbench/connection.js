/** The socket to the server: opens, opens again when it is lost, and hands over what comes. */

// Time before another try [ms], doubled at each up to the last.
const SOONEST = 150;
const LATEST = 2000;

export class Connection {
  /** `opened()` and `closed(reason)` are told when; `heard(message)` gets every message. */
  constructor(address, { opened, closed, heard }) {
    Object.assign(this, { address, opened, closed, heard });
    this.pause = SOONEST;
    this.ended = false;
    // A machine that wakes up, or a page that comes to the front, does not wait for the next try.
    window.addEventListener("online", () => this.hurry());
    document.addEventListener("visibilitychange", () => this.hurry());
    this.open();
  }

  get ready() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  open() {
    clearTimeout(this.timer);
    const socket = new WebSocket(this.address);
    this.socket = socket;
    socket.onopen = () => {
      this.pause = SOONEST;
      this.opened();
    };
    socket.onmessage = ({ data }) => this.heard(JSON.parse(data));
    socket.onclose = ({ reason }) => {
      if (socket !== this.socket) return;
      this.closed(reason);
      if (this.ended) return;
      this.timer = setTimeout(() => this.open(), this.pause);
      this.pause = Math.min(2 * this.pause, LATEST);
    };
  }

  hurry() {
    const waits = this.socket.readyState === WebSocket.CLOSED && !document.hidden && !this.ended;
    if (waits) this.open();
  }

  send(text) {
    this.socket.send(text);
  }

  close() {
    this.ended = true;
    this.socket.close();
  }
}
