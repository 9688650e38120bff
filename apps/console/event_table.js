// The rows of the timeline. Everything is shown as text. In a replay a click on an event, or Enter, goes to its time.

export default {
  template: `
    <table class="c-table c-events" :class="{ 'c-seeks': seeks }">
      <thead><tr><th scope="col" v-for="title in ['Time', 'Kind', 'About', 'What']" :key="title">{{ title }}</th></tr></thead>
      <tbody aria-live="polite">
        <tr v-for="row in rows || []" :key="row[0]" :class="{ 'c-later': row[5] > now }" :tabindex="seeks ? 0 : undefined"
            :title="seeks ? 'Go to this time' : undefined" @click="choose(row)" @keydown.enter="choose(row)">
          <td class="c-numbers c-quiet">{{ row[1] }}</td>
          <td><span class="c-kind" :class="'c-kind-' + row[2]">{{ row[2] }}</span></td>
          <td class="c-strong">{{ row[3] }}</td>
          <td>{{ row[4] }}</td>
        </tr>
        <tr v-if="!rows?.length"><td colspan="4" class="c-quiet">nothing has happened that these filters show</td></tr>
      </tbody>
    </table>`,
  props: { rows: Array, seeks: Boolean, now: { type: Number, default: Infinity } },
  methods: {
    choose(row) {
      if (this.seeks) this.$emit("choose", { number: row[0] });
    },
  },
};
