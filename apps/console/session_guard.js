// A page that slept, or was without its network, while its session ended. Its websockets are refused then, which looks as
// if the console were away; so the console is asked, and the page loaded again if it says that the session is over.

const PERIOD_MS = 3000;

export default {
  template: `<span hidden></span>`,
  props: { path: String },
  mounted() {
    this.timer = setInterval(() => this.look(), PERIOD_MS);
  },
  unmounted() {
    clearInterval(this.timer);
  },
  methods: {
    async look() {
      if (window.socket?.connected) return;
      try {
        const reply = await fetch(this.path, { cache: "no-store" });
        if (reply.status === 401 || reply.status === 403) location.reload();
      } catch {
        return; // the console or the network is away
      }
    },
  },
};
