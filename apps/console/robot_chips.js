// The robots of the team with their states; each leads to its page. Everything is shown as text.

export default {
  template: `
    <ul class="c-robots" aria-label="Robots">
      <li v-if="!rows?.length"><span class="c-chip c-away" role="status">no robot is on the bus yet</span></li>
      <li v-for="[name, level, words] in rows || []" :key="name">
        <a class="c-chip" :class="['c-' + level, { 'c-here': name === chosen }]" :href="'/robot/' + encodeURIComponent(name)">
          <span class="c-dot" aria-hidden="true"></span>
          <span class="c-name">{{ name }}</span>
          <span class="c-words">{{ words }}</span>
        </a>
      </li>
    </ul>`,
  props: { rows: Array, chosen: String },
};
