// The socket: newest frames only, acknowledged one by one, and none that is old when it comes.
//
// The server has at most four frames on the way. After a stall of this page those four are stale:
// they are acknowledged and dropped, and what comes next is the present.

const STALE_MS = 100;
const AGAIN_MS = 1000;
const FORGET_MS = 30000;

/** The quickest frame of late says how the server's clock and ours stand to each other. */
class ServerClock {
  #offset = Infinity;
  #before = Infinity;
  #since = 0;

  age(sent) {
    const now = performance.now();
    if (now - this.#since > FORGET_MS) {
      this.#before = this.#offset;
      this.#offset = Infinity;
      this.#since = now;
    }
    this.#offset = Math.min(this.#offset, now - sent);
    return now - sent - Math.min(this.#offset, this.#before);
  }
}

export class Connection {
  #socket = null;
  #clock = new ServerClock();
  #token;
  #listener;
  #ever = false;
  stale = 0;

  constructor(token, listener) {
    this.#token = token;
    this.#listener = listener;
    if (token) this.#open();
    else listener.closed(false);
  }

  say(message) {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(message));
  }

  #open() {
    const socket = new WebSocket(`ws://${location.host}/socket`, ["cohaptic", this.#token]);
    this.#socket = socket;
    socket.onopen = () => {
      this.#ever = true;
      this.#clock = new ServerClock();
      this.#listener.opened();
    };
    socket.onmessage = (event) => this.#take(JSON.parse(event.data));
    socket.onclose = () => {
      this.#listener.closed(this.#ever);
      setTimeout(() => this.#open(), AGAIN_MS);
    };
  }

  #take(message) {
    if (message.type !== "frame") {
      this.#listener[message.type]?.(message);
      return;
    }
    message.age = this.#clock.age(message.clock);
    const fresh = message.age < STALE_MS;
    if (fresh) this.#listener.frame(message);
    else {
      this.stale += 1;
      this.#listener.rows(message);
    }
    this.say({ ack: message.number });
  }
}
