// Signs of life of the browser, while something that was asked for in the page is under way.

const PERIOD_MS = 300;

export default {
  template: `<span hidden></span>`,
  props: { beats: Boolean },
  emits: ["pulse"],
  mounted() {
    this.timer = setInterval(() => this.beats && this.$emit("pulse", {}), PERIOD_MS);
  },
  unmounted() {
    clearInterval(this.timer);
  },
};
