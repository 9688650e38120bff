// Drives a robot by pointer, keys and gamepad. While it is active it sends its command ten times a second, and at once
// when it changes; each one has the console's latest time (`tick`), by which the console knows how old it is.

import { socketAddress } from "acromovi/requests.js";

const PERIOD_MS = 100;
const SOONEST_MS = 20; // between two commands
const LATE_MS = 400; // of the timer, after which the browser was asleep and nothing counts that was held before
const RETRY_MS = 500;
const DEAD = 0.15; // of a gamepad's stick
const MODIFIERS = new Set(["Meta", "Control", "Alt", "AltGraph"]);
const KEYS = {
  ArrowUp: [1, 0], w: [1, 0], ArrowDown: [-1, 0], s: [-1, 0],
  ArrowLeft: [0, 1], a: [0, 1], ArrowRight: [0, -1], d: [0, -1],
};

export default {
  template: `
    <div class="c-drive" :class="{ 'c-active': active }">
      <div class="c-stick" ref="stick" tabindex="0" role="application" :aria-disabled="!active"
           aria-label="Joystick: drag it, or hold the arrow keys or w, a, s, d; the space bar stops"
           @pointerdown="onDown" @pointermove="onMove" @pointerup="letGo" @pointercancel="letGo" @lostpointercapture="letGo"
           @contextmenu.prevent>
        <span class="c-arrow c-north">▲</span><span class="c-arrow c-south">▼</span>
        <span class="c-arrow c-west">◀</span><span class="c-arrow c-east">▶</span>
        <span class="c-knob" :style="{ left: 50 - angular * 36 + '%', top: 50 - linear * 36 + '%' }"></span>
      </div>
      <div class="c-drive-words" role="status">{{ words }}</div>
    </div>`,
  props: { path: String, active: Boolean },
  data() {
    return { linear: 0, angular: 0, latched: false, isOpen: false, pad: "" };
  },
  computed: {
    words() {
      if (!this.isOpen) return "no connection to the console: the robot is stopped";
      if (!this.active) return "Take control to drive: drag the joystick, hold arrow keys or WASD, or use a gamepad.";
      if (this.latched) return "stopped: let go of everything to drive on";
      return this.pad ? `gamepad: ${this.pad}` : "Hold a key or drag the joystick; let go to stop.";
    },
  },
  created() {
    Object.assign(this, { held: new Set(), drag: null, tick: 0, sentAt: 0, timedAt: 0, ended: false });
  },
  mounted() {
    this.listeners = [
      [window, "keydown", (event) => this.onKey(event, true)],
      [window, "keyup", (event) => this.onKey(event, false)],
      [window, "blur", () => this.letGoOfAll()],
      // A menu that opens takes the keyup. On the stick none opens, where a finger that holds it would ask for one.
      [window, "contextmenu", (event) => event.defaultPrevented || this.letGoOfAll()],
      [document, "visibilitychange", () => this.letGoOfAll()],
    ];
    for (const [target, name, call] of this.listeners) target.addEventListener(name, call);
    this.timer = setInterval(() => this.onTimer(), PERIOD_MS);
    this.connect();
  },
  unmounted() {
    this.ended = true;
    clearInterval(this.timer);
    clearTimeout(this.soon);
    for (const [target, name, call] of this.listeners) target.removeEventListener(name, call);
    this.socket.close();
  },
  watch: {
    active(on) {
      this.letGoOfAll();
      if (on) this.$refs.stick.focus({ preventScroll: true });
    },
  },
  methods: {
    connect() {
      if (this.ended) return;
      this.socket = new WebSocket(socketAddress(this.path));
      this.socket.onopen = () => (this.isOpen = true);
      this.socket.onmessage = (event) => {
        const told = JSON.parse(event.data);
        this.tick = told.tick;
        this.latched = told.latched;
      };
      this.socket.onclose = () => {
        this.isOpen = false;
        this.letGoOfAll();
        if (!this.ended) setTimeout(() => this.connect(), RETRY_MS);
      };
    },
    onTimer() {
      const now = performance.now();
      if (now - this.timedAt > LATE_MS) this.letGoOfAll();
      this.timedAt = now;
      this.look();
      if (this.active || now - this.sentAt > 1000) this.send(true);
    },
    look() {
      const [linear, angular] = this.wanted();
      if (linear === this.linear && angular === this.angular) return false;
      Object.assign(this, { linear, angular });
      return true;
    },
    wanted() {
      if (!this.active) return [0, 0];
      const pad = this.gamepad();
      if (this.drag) return this.drag;
      if (this.held.size) {
        const sum = [...this.held].map((key) => KEYS[key]).reduce(([v, w], [x, y]) => [v + x, w + y], [0, 0]);
        return sum.map((part) => Math.max(-1, Math.min(1, part)));
      }
      return pad;
    },
    gamepad() {
      const pad = [...(navigator.getGamepads?.() || [])].find((each) => each?.connected && each.axes.length >= 2);
      this.pad = pad ? pad.id.slice(0, 60) : "";
      if (!pad) return [0, 0];
      const part = (value) => (Math.abs(value) < DEAD ? 0 : Math.round(value * 100) / 100);
      return [0 - part(pad.axes[1]), 0 - part(pad.axes[0])].map((value) => Math.max(-1, Math.min(1, value)) || 0);
    },
    change() {
      if (this.look()) this.send(false);
    },
    send(isPeriodic) {
      const now = performance.now();
      if (this.socket.readyState !== WebSocket.OPEN) return;
      const isNeutral = !this.linear && !this.angular;
      clearTimeout(this.soon);
      const early = SOONEST_MS - (now - this.sentAt);
      if (!isPeriodic && !isNeutral && early > 0) {
        this.soon = setTimeout(() => this.send(false), early);
        return;
      }
      this.sentAt = now;
      this.socket.send(JSON.stringify({ tick: this.tick, linear: this.linear, angular: this.angular }));
    },
    onKey(event, isDown) {
      if (event.metaKey || event.ctrlKey || event.altKey || MODIFIERS.has(event.key)) {
        this.letGoOfAll(); // macOS sends no keyup of a key that is released while Cmd is down
        return;
      }
      const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
      if (!isDown) {
        if (this.held.delete(key)) this.change();
        return;
      }
      const isText = event.target.closest?.("input, textarea, select, [contenteditable], .q-slider, .c-map, .rv-viewer");
      if (!this.active || isText) return;
      if (key === " ") {
        this.letGoOfAll();
        if (event.target.closest?.(".c-stick, body") && !event.target.closest?.("button, a")) event.preventDefault();
        return;
      }
      if (!KEYS[key]) return;
      event.preventDefault();
      if (event.repeat && !this.held.has(key)) return; // a key that was held before everything was let go
      this.held.add(key);
      this.change();
    },
    onDown(event) {
      if (!this.active || event.button !== 0) return;
      this.$refs.stick.setPointerCapture(event.pointerId);
      this.drag = [0, 0];
      this.onMove(event);
    },
    onMove(event) {
      if (!this.drag) return;
      const box = this.$refs.stick.getBoundingClientRect();
      const part = (value) => Math.max(-1, Math.min(1, value / 0.36));
      const angular = part(0.5 - (event.clientX - box.left) / box.width);
      const linear = part(0.5 - (event.clientY - box.top) / box.height);
      const round = (value) => (Math.abs(value) < 0.06 ? 0 : Math.round(value * 100) / 100);
      this.drag = [round(linear), round(angular)];
      this.change();
    },
    letGo() {
      if (!this.drag) return;
      this.drag = null;
      this.change();
    },
    letGoOfAll() {
      this.held.clear();
      this.drag = null;
      this.change();
    },
  },
};
