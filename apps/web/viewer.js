// One image of the page: requests, draws, and requests the next one. Emits what a person does with pointer and keys.

import { RequestLoop, drawn } from "acromovi/requests.js";

const LARGEST = 1920; // px of the canvas; larger images are drawn smaller
const REPEAT_MS = 250; // between two steps of a key that is held, and between two places of a drag
const CLICK_PX = 4; // of the screen; a pointer that moves less has clicked
const BOX_COLOURS = { colours: "#ffd21f", motion: "#3ddcff" };

export default {
  template: `
    <div class="rv-viewer" tabindex="0" role="group" :aria-label="label"
         @keydown="onKey" @keyup="onKeyUp" @blur="onKeyUp">
      <canvas ref="canvas" role="img" :aria-label="label" width="320" height="240"
              @pointerdown="onDown" @pointermove="onMove" @pointerup="onUp" @pointercancel="grab = null"></canvas>
      <div class="rv-caption">
        <span class="rv-label">{{ label }}</span>
        <span class="rv-age" :class="{ 'rv-old': isOld }" role="status">{{ ageText }}</span>
      </div>
      <div class="rv-words" v-show="words" aria-live="polite">{{ words }}</div>
    </div>`,
  props: { path: String, label: String, old: Number, program: String, mode: String },
  data() {
    return { ageText: "no image yet", isOld: false, words: "" };
  },
  mounted() {
    this.drawn = null; // of the latest image: number, age in s when it was drawn, and when that was, ms
    this.clock = setInterval(() => this.showAge(), 100);
    this.images = new RequestLoop(
      this.path,
      (head, file, timing) => this.take(head, file, timing),
      () => (this.words = `the connection to ${this.program} is lost; trying again`),
    );
  },
  unmounted() {
    clearInterval(this.clock);
    this.images.close();
  },
  methods: {
    async take(head, file, timing) {
      this.words = head.words;
      let image = null;
      if (file.length) {
        try {
          image = await createImageBitmap(new Blob([file]));
        } catch {
          this.words = "the image is damaged and cannot be drawn";
        }
      }
      await drawn(() => {
        if (image) this.draw(image, head);
        else if (head.numbers) this.drawNumbers(head.numbers);
        else if (head.is_empty) this.clear();
        if (image || head.numbers) {
          const now = performance.now();
          const wayBack = Math.max(0, timing.arrived - timing.asked - head.waited * 1000) / 2;
          const age = head.age === undefined ? null : head.age + (wayBack + now - timing.arrived) / 1000;
          this.drawn = { age, at: now };
          this.showAge();
          const at = (performance.timeOrigin + now) / 1000;
          this.$el.dispatchEvent(new CustomEvent("drawn", { detail: { number: head.number, stamp: head.stamp, at } }));
        }
      });
    },
    showAge() {
      if (!this.drawn) {
        this.ageText = "no image yet";
        this.isOld = false;
      } else if (this.drawn.age === null) {
        this.ageText = "age unknown";
      } else {
        const age = this.drawn.age + (performance.now() - this.drawn.at) / 1000;
        this.isOld = age > this.old;
        const text = Math.abs(age) < 1 ? `${Math.round(age * 1000)} ms` : `${age.toFixed(1)} s`;
        this.ageText = this.isOld ? `OLD IMAGE: ${text}` : `age ${text}`;
      }
    },
    clear() {
      const canvas = this.$refs.canvas;
      canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
      this.drawn = null;
    },
    draw(image, head) {
      const canvas = this.$refs.canvas;
      const scale = Math.min(1, LARGEST / Math.max(image.width, image.height));
      this.size = [image.width, image.height];
      if (canvas.width !== Math.round(image.width * scale) || canvas.height !== Math.round(image.height * scale)) {
        canvas.width = Math.round(image.width * scale);
        canvas.height = Math.round(image.height * scale);
        canvas.style.setProperty("--rv-ratio", image.width / image.height);
      }
      const pen = canvas.getContext("2d");
      pen.drawImage(image, 0, 0, canvas.width, canvas.height);
      image.close();
      pen.font = `${Math.max(10, canvas.width / 32)}px sans-serif`;
      for (const box of head.boxes || []) this.drawBox(pen, scale, box);
      if (this.grab && this.mode === "train" && this.grab.to) this.drawRegion(pen, scale);
    },
    drawBox(pen, scale, box) {
      const [x, y] = [box.left * scale, box.top * scale];
      pen.strokeStyle = pen.fillStyle = BOX_COLOURS[box.source] || "#fff";
      pen.lineWidth = Math.max(1, pen.canvas.width / 240);
      pen.strokeRect(x, y, (box.right - box.left + 1) * scale, (box.bottom - box.top + 1) * scale);
      pen.fillText(box.label, x + 1, Math.max(y - 3, pen.canvas.width / 32));
    },
    drawRegion(pen, scale) {
      const region = this.region();
      pen.strokeStyle = "#fff";
      pen.setLineDash([4, 3]);
      pen.strokeRect(region[0] * scale, region[1] * scale, region[2] * scale, region[3] * scale);
      pen.setLineDash([]);
    },
    drawNumbers(numbers) {
      const canvas = this.$refs.canvas;
      [canvas.width, canvas.height] = [512, 384];
      const pen = canvas.getContext("2d");
      pen.fillStyle = "#fff";
      pen.fillRect(0, 0, canvas.width, canvas.height);
      const rows = Object.entries(numbers).filter(([name]) => name !== "from");
      const most = Math.max(1, ...rows.flatMap(([, row]) => row));
      const colours = { blue: "#1f5fd6", green: "#17803d", red: "#c62828" };
      for (const [name, row] of rows) {
        pen.strokeStyle = colours[name] || "#333";
        pen.lineWidth = 1.5;
        pen.beginPath();
        row.forEach((count, at) => {
          const y = canvas.height - 4 - (count / most) * (canvas.height - 12);
          pen.lineTo((at / row.length) * canvas.width, y);
          pen.lineTo(((at + 1) / row.length) * canvas.width, y);
        });
        pen.stroke();
      }
    },
    place(event) {
      const box = this.$refs.canvas.getBoundingClientRect();
      const inside = (value, size) => Math.min(Math.max(value, 0), 1) * size;
      return [
        inside((event.clientX - box.left) / box.width, this.size[0]),
        inside((event.clientY - box.top) / box.height, this.size[1]),
      ];
    },
    region() {
      const { from, to } = this.grab;
      const corner = [0, 1].map((axis) => Math.floor(Math.min(from[axis], to[axis])));
      return [...corner, ...[0, 1].map((axis) => Math.ceil(Math.max(from[axis], to[axis])) - corner[axis])];
    },
    onDown(event) {
      if (!this.size || event.button !== 0) return;
      this.$refs.root?.focus();
      this.$refs.canvas.setPointerCapture(event.pointerId);
      const from = this.place(event);
      this.grab = { from, to: null, x: event.clientX, y: event.clientY, sent: 0 };
    },
    onMove(event) {
      if (!this.grab) return;
      const apart = Math.hypot(event.clientX - this.grab.x, event.clientY - this.grab.y);
      if (!this.grab.to && apart < CLICK_PX) return;
      const isFirst = !this.grab.to;
      this.grab.to = this.place(event);
      const now = performance.now();
      if (this.mode === "steer" && (isFirst || now - this.grab.sent >= REPEAT_MS)) this.sendDrag(isFirst, now);
    },
    onUp(event) {
      const grab = this.grab;
      if (!grab) return;
      if (grab.to) {
        grab.to = this.place(event);
        if (this.mode === "train") this.$emit("region", { region: this.region(), size: this.size });
        else if (this.mode === "steer") this.sendDrag(!grab.sent, performance.now());
      } else if (this.mode === "steer") {
        this.$emit("point", { at: grab.from, size: this.size });
      }
      this.grab = null;
    },
    sendDrag(isFirst, now) {
      this.grab.sent = now;
      this.$emit("drag", { from: this.grab.from, to: this.grab.to, size: this.size, is_first: isFirst });
    },
    onKey(event) {
      if (this.mode === "show" || event.ctrlKey || event.altKey || event.metaKey) return;
      const known = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "+", "-", "c", " ", "Escape"];
      if (!known.includes(event.key)) return;
      event.preventDefault();
      const now = performance.now();
      if (event.repeat && now - (this.stepped || 0) < REPEAT_MS) return;
      this.stepped = now;
      this.held = event.repeat ? event.key : null;
      this.$emit("key", { key: event.key });
    },
    onKeyUp() {
      if (this.held) this.$emit("key", { key: "Escape" }); // a key that was held moves the head no longer
      this.held = null;
    },
  },
};
