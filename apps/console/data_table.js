// A table with any values. Everything is shown as text.

export default {
  template: `
    <div class="a-scroll">
      <table class="c-table">
        <thead><tr><th scope="col" v-for="title in titles" :key="title">{{ title }}</th></tr></thead>
        <tbody>
          <tr v-for="(row, index) in rows || []" :key="index"><td v-for="(cell, at) in row" :key="at">{{ cell }}</td></tr>
          <tr v-if="!rows?.length"><td :colspan="titles.length" class="c-quiet">{{ empty }}</td></tr>
        </tbody>
      </table>
    </div>`,
  props: { titles: Array, rows: Array, empty: String },
};
