// The bar of a replay. The position is moved by the browser while it is dragged; the console seeks once it is let go.

const pad = (value) => String(Math.floor(value)).padStart(2, "0");

export default {
  template: `
    <section class="c-replay" aria-label="Replay of a recording">
      <span class="c-badge c-recorded" title="A recording: nothing can be commanded">REPLAY</span>
      <button type="button" class="c-play" :aria-label="paused ? 'Play' : 'Pause'" :title="paused ? 'Play' : 'Pause'"
              @click="$emit('toggle')"><svg viewBox="0 0 16 16" aria-hidden="true"><path :d="icon" /></svg></button>
      <span class="c-numbers c-position">{{ clockOf(shown) }} / {{ clockOf(duration) }}</span>
      <div class="c-track">
        <div class="c-marks" aria-hidden="true">
          <i v-for="(mark, index) in marks || []" :key="index" :class="'c-mark-' + mark[1]" :style="{ left: 100 * mark[0] + '%' }"></i>
        </div>
        <input type="range" min="0" :max="duration" step="0.05" :value="shown" aria-label="Position"
               :aria-valuetext="clockOf(shown)" :style="{ '--c-part': 100 * shown / (duration || 1) + '%' }"
               @input="drag" @change="seek" />
      </div>
      <select :value="speed" aria-label="Speed" @change="$emit('speed', { speed: Number($event.target.value) })">
        <option v-for="each in speeds" :key="each" :value="each">{{ each }}×</option>
      </select>
      <span class="c-quiet c-file" :title="words">{{ words }} · {{ clock }}</span>
    </section>`,
  props: { speeds: Array, duration: Number, words: String, elapsed: Number, paused: Boolean, speed: Number, clock: String, marks: Array },
  data() {
    return { dragged: null };
  },
  computed: {
    shown() {
      return this.dragged ?? this.elapsed;
    },
    icon() {
      return this.paused ? "M4 2.5v11l9-5.5z" : "M4 2.5h3v11H4zM9.5 2.5h3v11h-3z";
    },
  },
  watch: {
    elapsed() {
      if (!this.held) this.dragged = null;
    },
  },
  methods: {
    clockOf(seconds) {
      const hours = seconds >= 3600 ? `${Math.floor(seconds / 3600)}:` : "";
      return `${hours}${pad((seconds / 60) % 60)}:${pad(seconds % 60)}`;
    },
    drag(event) {
      this.held = true;
      this.dragged = Number(event.target.value);
    },
    seek(event) {
      this.held = false;
      this.$emit("seek", { elapsed: Number(event.target.value) });
    },
  },
};
