// Ends a page whose session or certificate is over. The console tells it so. A page that slept, or was without its network,
// meanwhile has to find out: its websockets are refused then, which looks as if the console were away. So the console is
// asked, and the page loaded again if it says that the session is over. With a certificate that has expired there is no
// answer, so the page looks at its clock as well.

const PERIOD_MS = 3000;

export default {
  template: `<span hidden></span>`,
  props: { path: String, expires: Number, expired: String },
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
        // Otherwise the console or the network is away, of which the page tells anyway.
        if (this.expires && Date.now() / 1000 > this.expires) this.end(this.expired);
      }
    },
    // Leave for a page of HTML. It is made here: with a certificate that has expired nothing more can be loaded.
    end(page) {
      const text = page.replace("ORIGIN", location.origin);
      location.replace(URL.createObjectURL(new Blob([text], { type: "text/html" })));
    },
  },
};
