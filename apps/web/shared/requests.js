// Requests over a websocket, one after the other: the next one is sent once the reply to the last has been drawn. So at
// most one reply is on its way, and nothing waits for a page that sleeps or a line that is slow.

const RETRY_MS = 500;

export function socketAddress(path) {
  return `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${path}`;
}

export class RequestLoop {
  // path: of the websocket. take(head, body, timing): draws a reply, and returns a promise that ends when it has;
  // timing: when it was requested and when it arrived, ms. lost(): called when the connection has been lost.
  // request(): returns the text of the next request.
  constructor(path, take, lost, request = () => "next") {
    Object.assign(this, { path, take, lost, request });
    this.ended = false;
    this.connect();
  }

  close() {
    this.ended = true;
    clearTimeout(this.retry);
    this.socket.close();
  }

  connect() {
    if (this.ended) return;
    this.socket = new WebSocket(socketAddress(this.path));
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.ask();
    this.socket.onmessage = async (event) => {
      const arrived = performance.now();
      const length = new DataView(event.data).getUint32(0);
      const head = JSON.parse(new TextDecoder().decode(new Uint8Array(event.data, 4, length)));
      await this.take(head, new Uint8Array(event.data, 4 + length), { asked: this.asked, arrived });
      this.ask();
    };
    this.socket.onclose = () => {
      if (this.ended) return;
      this.lost();
      this.retry = setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  ask() {
    this.asked = performance.now();
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(this.request());
  }
}

// Draw with the next frame of the screen. A page in the background draws nothing, so it requests nothing.
export function drawn(draw) {
  return new Promise((resolve) => {
    requestAnimationFrame(() => {
      draw();
      resolve();
    });
  });
}
