// The rows of the timeline. Everything is shown as text.

export default {
  template: `
    <table class="c-table c-events">
      <thead><tr><th scope="col" v-for="title in ['Time', 'Kind', 'About', 'What']" :key="title">{{ title }}</th></tr></thead>
      <tbody aria-live="polite">
        <tr v-for="(row, index) in rows || []" :key="index">
          <td class="c-numbers c-quiet">{{ row[0] }}</td>
          <td><span class="c-kind" :class="'c-kind-' + row[1]">{{ row[1] }}</span></td>
          <td class="c-strong">{{ row[2] }}</td>
          <td>{{ row[3] }}</td>
        </tr>
        <tr v-if="!rows?.length"><td colspan="4" class="c-quiet">nothing has happened that these filters show</td></tr>
      </tbody>
    </table>`,
  props: { rows: Array },
};
