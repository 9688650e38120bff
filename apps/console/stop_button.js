// The red button that stops all robots; pressing Escape twice within a second does the same.

const TWICE_MS = 1000;
const SHOWN_MS = 8000;
const ANSWER_MS = 4000; // twice the time that the console gives the robots

export default {
  template: `
    <div class="c-stop-box">
      <button type="button" class="c-stop" aria-label="Stop all robots" aria-keyshortcuts="Escape Escape"
              title="Stop all robots (Escape twice)" @click="stop">STOP</button>
      <div class="c-stop-words" :class="{ 'c-failed': failed }" role="alert" v-show="words">{{ words }}</div>
    </div>`,
  props: { path: String },
  data() {
    return { words: "", failed: false };
  },
  mounted() {
    this.onKey = (event) => {
      if (event.key !== "Escape" || event.repeat) return;
      if (performance.now() - (this.pressed || -TWICE_MS) < TWICE_MS) this.stop();
      this.pressed = performance.now();
    };
    document.addEventListener("keydown", this.onKey, true);
  },
  unmounted() {
    document.removeEventListener("keydown", this.onKey, true);
  },
  methods: {
    async stop() {
      this.show("stopping all robots ...");
      try {
        const signal = AbortSignal.timeout?.(ANSWER_MS); // browsers of 2021 have none, and must stop robots as well
        const reply = await fetch(this.path, { method: "POST", keepalive: true, signal });
        if (!reply.ok) throw new Error(`${reply.status} ${await reply.text()}`);
        const told = await reply.json();
        const robots = Object.entries(told.robots);
        const failed = robots.filter(([, how]) => how !== "stopped");
        const away = told.away.length ? `; not reached, since away from the bus: ${told.away.join(", ")}` : "";
        if (!robots.length) this.show(`NOT STOPPED: no robot is on the bus${away}`, true);
        else if (failed.length) this.show(`NOT STOPPED: ${failed.map(([name, how]) => `${name}: ${how}`).join("; ")}${away}`, true);
        else this.show(`${robots.length === 1 ? robots[0][0] : `all ${robots.length} robots`} stopped${away}`, false, SHOWN_MS);
      } catch (error) {
        this.show(`NOT STOPPED: the console does not answer (${error.message}); use the button on the robot`, true);
      }
    },
    show(words, failed = false, forMs = 0) {
      Object.assign(this, { words, failed });
      clearTimeout(this.hide);
      if (forMs) this.hide = setTimeout(() => (this.words = ""), forMs); // otherwise until other words follow
    },
  },
};
