// Sites, containers and agents. Everything is shown as text.

export default {
  template: `
    <div class="a-tree" role="group" aria-label="Agents of the team">
      <details v-for="site in sites || []" :key="site.site" open>
        <summary class="c-strong">{{ site.site }}</summary>
        <details v-for="container in site.containers" :key="container.name" class="a-container" open>
          <summary>
            <span :class="{ 'c-alarmed': !container.answers }">{{ container.name }}</span>
            <span class="c-quiet a-about">{{ container.about }}</span>
          </summary>
          <ul class="c-plain">
            <li v-for="agent in container.agents" :key="agent.name">
              <button type="button" class="a-agent" :class="{ 'a-chosen': agent.name === chosen }"
                      :aria-pressed="agent.name === chosen" @click="$emit('choose', { name: agent.name })">
                <span class="a-dot" :class="'a-' + agent.state" aria-hidden="true"></span>
                <span class="a-name">{{ agent.name }}</span>
                <span class="a-state" :class="{ 'a-rests': agent.state !== 'active' }">{{ agent.state }}</span>
                <span v-if="agent.services.length" class="a-services c-quiet">{{ agent.services.join(", ") }}</span>
                <span v-if="detailed" class="a-services c-quiet">
                  <span v-for="(value, key) in agent.properties" :key="key" class="a-property">{{ key }}: {{ value }}</span>
                </span>
              </button>
            </li>
          </ul>
          <p v-if="!container.agents.length && container.answers" class="c-quiet a-empty">no agents</p>
        </details>
      </details>
      <p v-if="!sites?.length" class="c-quiet">{{ empty }}</p>
    </div>`,
  props: { sites: Array, chosen: String, detailed: Boolean, empty: String },
  emits: ["choose"],
};
