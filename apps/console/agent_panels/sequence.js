// The live sequence diagram of the messages between agents. Requests what is new, draws it, and requests again; while it
// is paused, nothing is requested. Emits `open` {number} for a message that a person chooses. Everything is text.

import { RequestLoop, drawn } from "acromovi/requests.js";

const KEPT = 500; // messages in the browser
const SHOWN = 200; // arrows drawn at most
const ROW = 30; // px between two messages
const LANE = 168; // px between two lifelines at least
const WIDEST = 380; // px between two lifelines at most
const TIMES = 84; // px for the times at the left
const NAME = 24; // characters of a lifeline's name
const NEAR = 40; // px from the end, within which the diagram follows new messages

const [NUMBER, TIME, SENDER, RECEIVERS, PERFORMATIVE, PROTOCOL, CONVERSATION, CONTENT, IS_NO] = Array(9).keys();

export default {
  template: `
    <div class="a-sniffer">
      <div class="rv-row a-filters">
        <label class="a-field">Agent
          <input v-model="agent" list="a-agents" placeholder="part of a name" autocomplete="off"></label>
        <datalist id="a-agents"><option v-for="name in names" :key="name" :value="name"></option></datalist>
        <label class="a-field">Performative
          <select v-model="performative"><option value="">any</option>
            <option v-for="each in performatives" :key="each">{{ each }}</option></select></label>
        <label class="a-field">Protocol
          <select v-model="protocol"><option value="">any</option>
            <option v-for="each in protocols" :key="each">{{ each }}</option></select></label>
        <label class="a-field">Conversation
          <input v-model="conversation" placeholder="beginning of its id" autocomplete="off" class="a-short"></label>
        <button type="button" class="a-button" :aria-pressed="paused" @click="pause">{{ paused ? "Resume" : "Pause" }}</button>
        <button type="button" class="a-button" @click="messages = []">Clear</button>
        <span class="c-quiet" role="status">{{ status }}</span>
      </div>
      <div class="a-diagram" ref="scroll" tabindex="0" role="group" aria-label="Sequence diagram of messages">
        <div class="a-lanes" v-if="shown.length" :style="{ width: width + 'px' }" aria-hidden="true">
          <span v-for="(name, index) in lanes" :key="name" class="a-lane" :title="name" :style="{ left: x(index) + 'px' }">{{ short(name, NAME) }}</span>
        </div>
        <svg :width="width" :height="height" v-if="shown.length">
          <g v-for="(name, index) in lanes" :key="name">
            <line class="a-life" :x1="x(index)" :x2="x(index)" y1="0" :y2="height"></line>
          </g>
          <g v-for="arrow in arrows" :key="arrow.key" class="a-arrow" :class="{ 'a-no': arrow.isNo, 'a-open': arrow.number === opened }"
             tabindex="0" role="button" :aria-label="arrow.label" :style="{ '--a-hue': arrow.hue }"
             @click="open(arrow.number)" @keydown.enter.prevent="open(arrow.number)" @keydown.space.prevent="open(arrow.number)">
            <title>{{ arrow.label }}</title>
            <rect class="a-hit" x="0" :width="width" :y="arrow.y - 19" :height="28"></rect>
            <text class="a-time" x="4" :y="arrow.y - 2">{{ arrow.clock }}</text>
            <path class="a-line" :d="arrow.path"></path>
            <path class="a-head" :d="arrow.head"></path>
            <text class="a-word" :x="arrow.textX" :y="arrow.y - 5" :text-anchor="arrow.anchor">{{ arrow.text }}</text>
          </g>
        </svg>
        <p v-else class="c-quiet a-empty">{{ words || (messages.length ? "no message fits the filters" : "nothing has been said yet; ask an agent for something") }}</p>
      </div>
    </div>`,
  props: { path: String, opened: Number },
  emits: ["open"],
  data() {
    return { messages: [], agent: "", performative: "", protocol: "", conversation: "", paused: false, lost: 0, words: "", connected: true, room: 0 };
  },
  created() {
    this.NAME = NAME;
    this.number = 0;
    this.hues = new Map();
  },
  mounted() {
    this.updates = new RequestLoop(
      this.path,
      (head) => this.take(head),
      () => (this.connected = false),
      () => String(this.number),
    );
  },
  unmounted() {
    this.updates.close();
  },
  computed: {
    fitting() {
      const name = this.agent.trim().toLowerCase();
      return this.messages.filter(
        (row) =>
          (!name || [row[SENDER], ...row[RECEIVERS]].some((each) => each.toLowerCase().includes(name))) &&
          (!this.performative || row[PERFORMATIVE] === this.performative) &&
          (!this.protocol || row[PROTOCOL] === this.protocol) &&
          row[CONVERSATION].startsWith(this.conversation.trim()),
      );
    },
    shown() {
      return this.fitting.slice(-SHOWN);
    },
    lanes() {
      return [...new Set(this.shown.flatMap((row) => [row[SENDER], ...row[RECEIVERS]]))];
    },
    names() {
      return [...new Set(this.messages.flatMap((row) => [row[SENDER], ...row[RECEIVERS]]))].sort();
    },
    performatives() {
      return [...new Set(this.messages.map((row) => row[PERFORMATIVE]))].sort();
    },
    protocols() {
      return [...new Set(this.messages.map((row) => row[PROTOCOL]).filter(Boolean))].sort();
    },
    lane() {
      return Math.min(Math.max((this.room - TIMES - 20) / (this.lanes.length || 1), LANE), WIDEST);
    },
    width() {
      return Math.max(TIMES + this.lanes.length * this.lane + 10, this.room);
    },
    height() {
      return this.arrows.length * ROW + 20;
    },
    arrows() {
      const place = new Map(this.lanes.map((name, index) => [name, this.x(index)]));
      const arrows = [];
      for (const row of this.shown) {
        for (const receiver of row[RECEIVERS].length ? row[RECEIVERS] : [row[SENDER]]) {
          arrows.push(this.arrow(row, receiver, place, (arrows.length + 1) * ROW - 4));
        }
      }
      return arrows;
    },
    status() {
      if (!this.connected) return "the connection to the console is lost; trying again";
      if (this.paused) return "paused";
      const lost = this.lost ? `, ${this.lost} left out` : "";
      const hidden = this.messages.length - this.fitting.length;
      return `${this.fitting.length} messages${hidden ? `, ${hidden} filtered out` : ""}${lost}`;
    },
  },
  methods: {
    async take(head) {
      this.connected = true;
      this.room = this.$refs.scroll.clientWidth;
      const scroll = this.$refs.scroll;
      const follows = scroll.scrollHeight - scroll.scrollTop - scroll.clientHeight < NEAR;
      this.words = head.words;
      if (head.number < this.number) this.messages = []; // the console was started again
      this.number = head.number;
      if (head.rows.length) {
        this.lost += head.left_out;
        this.messages = [...this.messages, ...head.rows].slice(-KEPT);
        await this.$nextTick();
      }
      await drawn(() => {
        if (head.rows.length && follows) scroll.scrollTop = scroll.scrollHeight;
        if (head.rows.length) this.$el.dispatchEvent(new CustomEvent("drawn", { detail: { number: head.number } }));
      });
      while (this.paused && !this.updates.ended) await new Promise((resolve) => (this.wake = resolve));
    },
    pause() {
      this.paused = !this.paused;
      if (!this.paused) this.wake?.();
    },
    // Show the messages of one agent.
    filterBy(name) {
      this.agent = name;
    },
    open(number) {
      this.$emit("open", { number });
    },
    x(index) {
      return TIMES + (index + 0.5) * this.lane;
    },
    short(text, longest) {
      return text.length > longest ? `${text.slice(0, longest - 1)}…` : text;
    },
    clock(time) {
      const at = new Date(time * 1000);
      return `${at.toTimeString().slice(0, 8)}.${String(at.getMilliseconds()).padStart(3, "0")}`;
    },
    hue(conversation) {
      if (!this.hues.has(conversation)) this.hues.set(conversation, (this.hues.size * 67 + 210) % 360);
      return this.hues.get(conversation);
    },
    arrow(row, receiver, place, y) {
      const [from, to] = [place.get(row[SENDER]), place.get(receiver)];
      const own = from === to;
      const way = to > from ? 1 : -1;
      const end = own ? from : to - way * 2;
      const text = `${row[PERFORMATIVE]} ${row[CONTENT]}`.trim();
      const room = own ? 40 : Math.max(Math.floor((Math.abs(to - from) - 16) / 6.3), 10);
      const clock = this.clock(row[TIME]);
      return {
        key: `${row[NUMBER]} ${receiver}`,
        number: row[NUMBER],
        isNo: row[IS_NO],
        hue: this.hue(row[CONVERSATION]),
        y,
        clock,
        label: `${clock} ${row[SENDER]} to ${receiver}: ${text}`,
        path: own ? `M${from} ${y - 8}h22v8h-20` : `M${from} ${y}H${end}`,
        head: own ? `M${from + 2} ${y}l8 -4v8z` : `M${end} ${y}l${-way * 8} -4v8z`,
        text: this.short(text, room),
        textX: own ? from + 28 : (from + to) / 2,
        anchor: own ? "start" : "middle",
      };
    },
  },
};
