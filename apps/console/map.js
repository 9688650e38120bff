// The map of a team on one canvas. It requests an update, draws it, and requests the next one (`requests.js`).
// Lengths in m, angles in rad, x to the right and y up. Emits what a person does: choose, goal, place.

import { RequestLoop, drawn } from "acromovi/requests.js";

const COLOURS = ["#3b82f6", "#e8892b", "#22a06b", "#c2459d", "#8b6cf0", "#c9a227", "#17a2b8", "#d9534f"];
const THEMES = {
  light: { ground: "#f7f9fb", grid: "#e6ebf0", wall: "#4a5663", thing: "#aab4bf", seen: "#5f6f80", ink: "#1d2733", paper: "#ffffff", door: "#0d8a78", goal: "#b0418d", warn: "#b06a00", free: "#ffffff", busy: "#4a5663" },
  dark: { ground: "#161b21", grid: "#222a32", wall: "#a9b6c3", thing: "#4a5663", seen: "#8798aa", ink: "#e3e8ee", paper: "#1b2128", door: "#35c9b1", goal: "#e08bc6", warn: "#f0a83c", free: "#20272f", busy: "#a9b6c3" },
};
const HEADER = 40; // bytes of a record before its ranges
const NOTHING = 0xffff;
const CLICK_PX = 5; // of the screen; a pointer that moves less has clicked
const NEAR_PX = 14; // from a robot that is meant
const TRAIL_M = 0.05;
const TRAIL_POINTS = 2000;
const SEEN_SIZE = 2048; // cells, of the picture of what a laser has seen
const [CLOSEST, FARTHEST] = [400, 2]; // px for a m

export default {
  template: `
    <div class="c-map" tabindex="0" role="application" :aria-label="label" @keydown="onKey">
      <canvas ref="canvas" role="img" :aria-label="label" :class="{ 'c-aim': mode !== 'look' && chosen }"
              @pointerdown="onDown" @pointermove="onMove" @pointerup="onUp" @pointercancel="onCancel"
              @wheel.prevent="onWheel"></canvas>
      <div class="c-map-note" role="status">{{ lost || frames }}</div>
      <div class="c-map-tools">
        <button type="button" aria-label="Zoom in" title="Zoom in (+)" @click="zoom(1.3)">+</button>
        <button type="button" aria-label="Zoom out" title="Zoom out (-)" @click="zoom(1 / 1.3)">−</button>
        <button type="button" aria-label="Show all of the map" title="Show all (0)" @click="fit">⤢</button>
      </div>
      <ul class="c-unseen" aria-label="Robots on the map">
        <li v-for="row in rows" :key="row">{{ row }}</li>
      </ul>
    </div>`,
  props: { path: String, chosen: String, mode: String, layers: Array, follow: Boolean },
  data() {
    return { frames: "", lost: "", rows: [] };
  },
  computed: {
    label() {
      const drag = this.mode === "place" ? "; drag a robot, or click a place for the chosen one" : "";
      const how = drag || (this.mode === "look" ? "" : "; click to set a place, drag to set a heading");
      return `Map of the team${this.chosen ? `, ${this.chosen} chosen` : ""}${how}`;
    },
  },
  created() {
    this.world = { floor: null, robots: [], trails: {}, poses: {}, missions: {}, seen: {}, located: {}, goals: {}, overlays: [], patrol: {}, people: [], grid: null };
    this.view = null; // x and y of the middle, m, and px for a m
    this.pointers = new Map();
    this.aim = null;
    this.held = null; // a robot that is dragged to another place: its name, and x, y and heading there
    this.moved = false; // by a person; otherwise the view fits the map
  },
  mounted() {
    this.resize = new ResizeObserver(() => this.redraw());
    this.resize.observe(this.$el);
    this.themes = new MutationObserver(() => this.redraw());
    this.themes.observe(document.body, { attributes: true, attributeFilter: ["class"] });
    this.updates = new RequestLoop(
      this.path,
      (head, body, timing) => this.take(head, body, timing),
      () => (this.lost = "The connection to the console is lost; the map is old. Trying again."),
    );
    this.clock = setInterval(() => this.tellRows(), 2000);
    this.$el.toScreen = (x, y) => this.toScreen(x, y); // for programs that click
  },
  unmounted() {
    clearInterval(this.clock);
    this.resize.disconnect();
    this.themes.disconnect();
    this.updates.close();
  },
  watch: {
    chosen() {
      this.redraw();
    },
    layers() {
      this.redraw();
    },
    follow() {
      this.redraw();
    },
  },
  methods: {
    // Updates.

    async take(head, body) {
      this.lost = "";
      if (head.floor) this.world.floor = head.floor;
      if (head.robots) this.world.robots = head.robots;
      for (const part of ["missions", "located", "goals", "overlays", "patrol", "people"]) if (head[part]) this.world[part] = head[part];
      if (head.frames !== undefined) this.frames = head.frames;
      for (const [name, trail] of Object.entries(head.trails || {})) {
        this.world.trails[name] = trail.map((value) => value / 1000);
      }
      const stamps = this.readPoses(head.names, new DataView(body.buffer, body.byteOffset, head.live));
      let at = head.live;
      for (const [name, count] of Object.entries(head.cells)) {
        this.addSeen(name, new DataView(body.buffer, body.byteOffset + at, count * 4), count);
        at += count * 4;
      }
      if (head.grid) await this.takeGrid(head.grid, body.subarray(at, at + head.grid.bytes));
      await drawn(() => {
        this.draw();
        const when = (performance.timeOrigin + performance.now()) / 1000;
        this.$el.dispatchEvent(new CustomEvent("drawn", { detail: { stamps, at: when } }));
      });
    },
    readPoses(names, data) {
      const stamps = {};
      const poses = {};
      for (let at = 0; at < data.byteLength; ) {
        const [number, discs, beams] = [0, 4, 6].map((offset) => data.getUint16(at + offset, true));
        const floats = [0, 1, 2, 3, 4].map((index) => data.getFloat32(at + 16 + 4 * index, true));
        const ranges = (from, count) =>
          Array.from({ length: count }, (_, index) => data.getUint16(at + HEADER + 2 * (from + index), true));
        const name = names[number];
        const [x, y, heading, linear, angular] = floats;
        poses[name] = { x, y, heading, linear, angular, sonar: ranges(0, discs), beams: ranges(discs, beams) };
        stamps[name] = data.getFloat64(at + 8, true);
        this.lengthen(name, x, y);
        at += HEADER + 2 * (discs + beams);
        at += (8 - (at % 8)) % 8;
      }
      this.world.poses = poses;
      return stamps;
    },
    lengthen(name, x, y) {
      const trail = (this.world.trails[name] ||= []);
      if (trail.length && Math.hypot(x - trail.at(-2), y - trail.at(-1)) < TRAIL_M) return;
      trail.push(x, y);
      if (trail.length > 2 * TRAIL_POINTS) trail.splice(0, 2);
    },
    addSeen(name, data, count) {
      let seen = this.world.seen[name];
      if (!seen) {
        const canvas = document.createElement("canvas");
        canvas.width = canvas.height = SEEN_SIZE;
        seen = this.world.seen[name] = { canvas, box: null };
      }
      const pen = seen.canvas.getContext("2d");
      pen.fillStyle = "#8090a0";
      for (let index = 0; index < count; index += 1) {
        const [x, y] = [data.getInt16(4 * index, true), data.getInt16(4 * index + 2, true)];
        pen.fillRect(x + SEEN_SIZE / 2, SEEN_SIZE / 2 - 1 - y, 1, 1);
        const box = (seen.box ||= [x, y, x, y]);
        seen.box = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)];
      }
    },
    async takeGrid(grid, packed) {
      const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
      const cells = new Int8Array(await new Response(stream).arrayBuffer());
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [grid.width, grid.height];
      const pen = canvas.getContext("2d");
      const image = pen.createImageData(grid.width, grid.height);
      for (let row = 0; row < grid.height; row += 1) {
        for (let column = 0; column < grid.width; column += 1) {
          const value = cells[row * grid.width + column];
          const to = 4 * ((grid.height - 1 - row) * grid.width + column);
          image.data.set(value < 0 ? [0, 0, 0, 0] : [96, 112, 128, Math.round(value * 2.55)], to);
        }
      }
      pen.putImageData(image, 0, 0);
      this.world.grid = { ...grid, canvas };
    },
    tellRows() {
      this.rows = this.world.robots.map((robot) => {
        const pose = this.world.poses[robot.name];
        if (!pose) return `${robot.name}: ${robot.words}, place not known`;
        const [x, y] = this.onMap(robot, pose.x, pose.y);
        const { goal, route } = this.world.missions[robot.name] || {};
        const [goalX, goalY] = goal ? this.onMap(robot, goal[0], goal[1]) : [];
        const way = route?.length ? `, by a way of ${route.length} places` : "";
        const mission = goal ? `, on its way to x ${goalX.toFixed(1)} m, y ${goalY.toFixed(1)} m${way}` : "";
        return `${robot.name}: ${robot.words}, at x ${x.toFixed(1)} m, y ${y.toFixed(1)} m${mission}`;
      });
    },

    // From metres to the screen.

    onMap(robot, x, y) {
      const [px, py, heading] = robot.place;
      const [c, s] = [Math.cos(heading), Math.sin(heading)];
      return [px + c * x - s * y, py + s * x + c * y];
    },
    poseOnMap(robot) {
      const pose = this.world.poses[robot.name];
      if (!pose) return null;
      const [x, y] = this.onMap(robot, pose.x, pose.y);
      return { ...pose, x, y, heading: pose.heading + robot.place[2] };
    },
    bounds() {
      const box = [Infinity, Infinity, -Infinity, -Infinity];
      const add = (x, y, around = 0) => {
        box[0] = Math.min(box[0], x - around);
        box[1] = Math.min(box[1], y - around);
        box[2] = Math.max(box[2], x + around);
        box[3] = Math.max(box[3], y + around);
      };
      const floor = this.world.floor || { shapes: [], lines: [], points: [] };
      for (const shape of [...floor.shapes, ...floor.lines, floor.points]) {
        for (let at = 0; at + 1 < shape.length; at += 2) add(shape[at] / 1000, shape[at + 1] / 1000);
      }
      for (const robot of this.world.robots) {
        const pose = this.poseOnMap(robot);
        if (pose) add(pose.x, pose.y, box[0] === Infinity || !floor.shapes.length ? 1.5 : 0);
        const seen = this.world.seen[robot.name];
        if (!seen?.box) continue;
        for (const [x, y] of [[0, 1], [2, 3], [0, 3], [2, 1]]) {
          add(...this.onMap(robot, seen.box[x] * floor.cell, seen.box[y] * floor.cell));
        }
      }
      return box[0] === Infinity ? [-4, -4, 4, 4] : box;
    },
    fit() {
      this.moved = false;
      this.redraw();
    },
    fitted(width, height) {
      const [left, low, right, high] = this.bounds();
      const scale = Math.min(width / (right - left + 0.8), (height - 92) / (high - low + 0.4));
      return { x: (left + right) / 2, y: (low + high) / 2 + 9 / scale, scale: Math.min(Math.max(scale, FARTHEST), 150) };
    },
    toMetres(px, py) {
      const box = this.$refs.canvas.getBoundingClientRect();
      return [
        this.view.x + (px - box.left - box.width / 2) / this.view.scale,
        this.view.y - (py - box.top - box.height / 2) / this.view.scale,
      ];
    },
    toScreen(x, y) {
      const box = this.$refs.canvas.getBoundingClientRect();
      return [
        box.left + box.width / 2 + (x - this.view.x) * this.view.scale,
        box.top + box.height / 2 - (y - this.view.y) * this.view.scale,
      ];
    },

    // Drawing.

    redraw() {
      if (this.waiting) return;
      this.waiting = true;
      requestAnimationFrame(() => {
        this.waiting = false;
        this.draw();
      });
    },
    draw() {
      const canvas = this.$refs.canvas;
      if (!canvas) return;
      const ratio = Math.min(window.devicePixelRatio || 1, 2);
      const [width, height] = [this.$el.clientWidth, this.$el.clientHeight];
      if (!width || !height) return;
      if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
        [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
      }
      const theme = THEMES[document.body.classList.contains("body--dark") ? "dark" : "light"];
      if (!this.moved || !this.view) this.view = this.fitted(width, height);
      const chosen = this.world.robots.find((robot) => robot.name === this.chosen);
      const followed = this.follow && chosen && this.poseOnMap(chosen);
      if (followed) {
        Object.assign(this.view, { x: followed.x, y: followed.y });
        this.moved = true;
      }
      const pen = canvas.getContext("2d");
      pen.setTransform(1, 0, 0, 1, 0, 0);
      pen.fillStyle = theme.ground;
      pen.fillRect(0, 0, canvas.width, canvas.height);
      const scale = this.view.scale * ratio;
      pen.setTransform(scale, 0, 0, -scale, canvas.width / 2 - this.view.x * scale, canvas.height / 2 + this.view.y * scale);
      this.px = 1 / this.view.scale; // m of a px of the screen
      this.drawLines(pen, theme, width, height);
      this.drawFloor(pen, theme);
      const colours = new Map(this.world.robots.map((robot, index) => [robot.name, COLOURS[index % COLOURS.length]]));
      for (const robot of this.world.robots) this.drawReadings(pen, theme, robot, colours.get(robot.name));
      for (const robot of this.world.robots) this.drawMission(pen, theme, robot, colours.get(robot.name));
      for (const robot of this.world.robots) this.drawLocated(pen, theme, robot, colours.get(robot.name));
      this.drawGoals(pen, theme);
      this.drawPatrol(pen, theme, colours);
      for (const robot of this.world.robots) this.drawOverlays(pen, robot, colours.get(robot.name));
      this.drawPeople(pen, theme);
      for (const robot of this.world.robots) this.drawRobot(pen, theme, robot, colours.get(robot.name));
      if (this.aim) this.drawAim(pen, colours.get(this.chosen) || theme.ink);
      if (this.held) {
        const robot = this.world.robots.find((each) => each.name === this.held.robot);
        if (robot) this.drawRobot(pen, theme, robot, colours.get(robot.name) || theme.ink, this.held);
      }
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      this.drawNames(pen, theme, width, height);
      this.drawScale(pen, theme, width, height);
    },
    drawLines(pen, theme, width, height) {
      const step = [1, 2, 5, 10, 20, 50].find((each) => each * this.view.scale > 36) || 100;
      const [w, h] = [(width / 2) * this.px, (height / 2) * this.px];
      pen.strokeStyle = theme.grid;
      pen.lineWidth = this.px;
      pen.beginPath();
      for (let x = Math.ceil((this.view.x - w) / step) * step; x <= this.view.x + w; x += step) {
        pen.moveTo(x, this.view.y - h);
        pen.lineTo(x, this.view.y + h);
      }
      for (let y = Math.ceil((this.view.y - h) / step) * step; y <= this.view.y + h; y += step) {
        pen.moveTo(this.view.x - w, y);
        pen.lineTo(this.view.x + w, y);
      }
      pen.stroke();
    },
    drawFloor(pen, theme) {
      const { floor, grid, seen } = this.world;
      if (grid && this.layers.includes("walls")) {
        const robot = this.world.robots.find((each) => each.name === grid.robot);
        pen.save();
        if (grid.in_odom && robot) this.enter(pen, robot.place);
        else if (this.world.located[grid.robot]) this.enter(pen, this.world.located[grid.robot].frame);
        this.enter(pen, grid.origin);
        pen.imageSmoothingEnabled = false;
        pen.scale(grid.resolution, -grid.resolution);
        pen.drawImage(grid.canvas, 0, -grid.height);
        pen.restore();
      }
      if (floor && this.layers.includes("walls")) {
        this.fillShapes(pen, floor.things, theme.thing);
        this.fillShapes(pen, floor.shapes, theme.wall);
        pen.strokeStyle = theme.wall;
        pen.lineWidth = 1.6 * this.px;
        pen.beginPath();
        for (const [x1, y1, x2, y2] of floor.lines) {
          pen.moveTo(x1 / 1000, y1 / 1000);
          pen.lineTo(x2 / 1000, y2 / 1000);
        }
        pen.stroke();
        const dot = Math.max(0.04, 1.4 * this.px);
        for (let at = 0; at + 1 < floor.points.length; at += 2) {
          pen.fillRect(floor.points[at] / 1000 - dot / 2, floor.points[at + 1] / 1000 - dot / 2, dot, dot);
        }
      }
      if (!this.layers.includes("seen")) return;
      for (const robot of this.world.robots) {
        const picture = seen[robot.name];
        if (!picture) continue;
        pen.save();
        this.enter(pen, robot.place);
        pen.imageSmoothingEnabled = false;
        pen.scale(floor.cell, -floor.cell);
        pen.drawImage(picture.canvas, -SEEN_SIZE / 2, -SEEN_SIZE / 2);
        pen.restore();
      }
    },
    fillShapes(pen, shapes, colour) {
      pen.fillStyle = colour;
      pen.beginPath();
      for (const shape of shapes) {
        for (let at = 0; at < shape.length; at += 2) {
          pen[at ? "lineTo" : "moveTo"](shape[at] / 1000, shape[at + 1] / 1000);
        }
        pen.closePath();
      }
      pen.fill();
    },
    enter(pen, [x, y, heading]) {
      pen.translate(x, y);
      pen.rotate(heading);
    },
    drawReadings(pen, theme, robot, colour) {
      const pose = this.poseOnMap(robot);
      if (this.layers.includes("trails")) this.drawTrail(pen, robot, colour);
      if (!pose || !robot.is_there) return;
      pen.save();
      this.enter(pen, [pose.x, pose.y, pose.heading]);
      if (this.layers.includes("sonar")) this.drawSonar(pen, robot, pose, colour);
      if (this.layers.includes("laser") && pose.beams.length) this.drawLaser(pen, robot, pose, colour);
      pen.restore();
    },
    drawTrail(pen, robot, colour) {
      const trail = this.world.trails[robot.name] || [];
      pen.save();
      this.enter(pen, robot.place);
      pen.strokeStyle = colour;
      pen.globalAlpha = 0.55;
      pen.lineWidth = Math.max(0.03, 1.8 * this.px);
      pen.lineJoin = "round";
      pen.beginPath();
      for (let at = 0; at < trail.length; at += 2) {
        const jumps = at && Math.hypot(trail[at] - trail[at - 2], trail[at + 1] - trail[at - 1]) > 1.0;
        pen[at && !jumps ? "lineTo" : "moveTo"](trail[at], trail[at + 1]);
      }
      pen.stroke();
      pen.restore();
    },
    drawSonar(pen, robot, pose, colour) {
      pen.fillStyle = colour;
      pen.globalAlpha = robot.name === this.chosen ? 0.2 : 0.1;
      pen.beginPath();
      robot.sonar.forEach((disc, number) => {
        const range = pose.sonar[number];
        if (!disc || range === undefined || range === NOTHING) return;
        const [x, y, heading, view] = disc;
        pen.moveTo(x, y);
        pen.arc(x, y, range / 1000, heading - view / 2, heading + view / 2);
        pen.closePath();
      });
      pen.fill();
    },
    drawLaser(pen, robot, pose, colour) {
      const { x, y, heading, first, step } = robot.laser;
      pen.save();
      this.enter(pen, [x, y, heading]);
      pen.fillStyle = colour;
      pen.globalAlpha = robot.name === this.chosen ? 0.13 : 0.07;
      pen.beginPath();
      pen.moveTo(0, 0);
      const points = [];
      pose.beams.forEach((range, index) => {
        if (range === NOTHING) return;
        const angle = first + step * index;
        points.push([(Math.cos(angle) * range) / 1000, (Math.sin(angle) * range) / 1000]);
        pen.lineTo(...points.at(-1));
      });
      pen.closePath();
      pen.fill();
      pen.globalAlpha = 0.95;
      const dot = Math.max(0.03, 2 * this.px);
      for (const [px, py] of points) pen.fillRect(px - dot / 2, py - dot / 2, dot, dot);
      pen.restore();
    },
    drawMission(pen, theme, robot, colour) {
      const mission = this.world.missions[robot.name];
      if (!mission || !this.layers.includes("missions")) return;
      pen.save();
      this.enter(pen, robot.place);
      pen.strokeStyle = theme.door;
      pen.lineWidth = Math.max(0.05, 3 * this.px);
      for (const [x, y, width, normal, confidence] of mission.doors) {
        const across = normal + Math.PI / 2;
        const [dx, dy] = [(Math.cos(across) * width) / 2, (Math.sin(across) * width) / 2];
        pen.globalAlpha = 0.3 + 0.7 * confidence;
        pen.beginPath();
        pen.moveTo(x - dx, y - dy);
        pen.lineTo(x + dx, y + dy);
        pen.stroke();
      }
      pen.globalAlpha = 1;
      pen.strokeStyle = pen.fillStyle = colour;
      pen.lineWidth = Math.max(0.025, 2 * this.px);
      pen.setLineDash([7 * this.px, 5 * this.px]);
      pen.beginPath();
      mission.route.forEach(([x, y], index) => pen[index ? "lineTo" : "moveTo"](x, y));
      pen.stroke();
      pen.setLineDash([]);
      if (mission.goal) this.drawGoal(pen, mission.goal);
      pen.restore();
    },
    // The pose by the localization, with twice its deviations: an ellipse, and a wedge for the heading.
    drawLocated(pen, theme, robot, colour) {
      const located = this.world.located[robot.name];
      if (!located?.pose || !located.deviations || !this.layers.includes("located")) return;
      const [x, y, heading] = located.pose;
      const [dx, dy, turn] = located.deviations.map((each) => 2 * each);
      pen.save();
      pen.translate(x, y);
      pen.fillStyle = pen.strokeStyle = located.is_believed ? colour : theme.warn;
      pen.lineWidth = 1.6 * this.px;
      if (!located.is_believed) pen.setLineDash([5 * this.px, 4 * this.px]);
      pen.save();
      pen.rotate(located.frame[2]);
      pen.beginPath();
      pen.ellipse(0, 0, Math.max(dx, 3 * this.px), Math.max(dy, 3 * this.px), 0, 0, 2 * Math.PI);
      pen.restore();
      pen.globalAlpha = 0.18;
      pen.fill();
      pen.globalAlpha = 1;
      pen.stroke();
      const far = Math.max(0.7, 34 * this.px);
      pen.globalAlpha = 0.3;
      pen.beginPath();
      pen.moveTo(0, 0);
      pen.arc(0, 0, far, heading - Math.min(turn, Math.PI), heading + Math.min(turn, Math.PI));
      pen.closePath();
      pen.fill();
      pen.restore();
    },
    overlaysOf(robot) {
      return this.layers.includes("overlays") ? this.world.overlays.filter((each) => each.robot === robot.name) : [];
    },
    // What applications show: lines that end in a point, in the frame that they name.
    drawOverlays(pen, robot, colour) {
      const pose = this.poseOnMap(robot);
      if (!pose) return;
      for (const { frame, points, lines } of this.overlaysOf(robot)) {
        pen.save();
        this.enter(pen, frame === "odom" ? robot.place : [pose.x, pose.y, pose.heading]);
        pen.strokeStyle = pen.fillStyle = colour;
        pen.lineWidth = 2 * this.px;
        pen.setLineDash([3 * this.px, 4 * this.px]);
        pen.beginPath();
        for (const [x1, y1, x2, y2] of lines) {
          pen.moveTo(x1, y1);
          pen.lineTo(x2, y2);
        }
        pen.stroke();
        pen.setLineDash([]);
        pen.beginPath();
        for (const [x, y] of points) {
          pen.moveTo(x + 7 * this.px, y);
          pen.arc(x, y, 7 * this.px, 0, 2 * Math.PI);
        }
        pen.stroke();
        pen.restore();
      }
    },
    // The tours of a patrol, closed, as each room comes again; and its alarms, filled while the intruder is seen.
    drawPatrol(pen, theme, colours) {
      if (!this.layers.includes("overlays")) return;
      pen.save();
      pen.lineWidth = 1.6 * this.px;
      pen.setLineDash([1.6 * this.px, 5 * this.px]);
      pen.globalAlpha = 0.8;
      for (const [robot, places] of this.world.patrol.tours || []) {
        pen.strokeStyle = colours.get(robot) || theme.ink;
        pen.beginPath();
        places.forEach(([x, y], index) => pen[index ? "lineTo" : "moveTo"](x, y));
        pen.closePath();
        pen.stroke();
      }
      pen.setLineDash([]);
      pen.globalAlpha = 1;
      pen.strokeStyle = pen.fillStyle = "#d3382c";
      pen.lineWidth = 2 * this.px;
      const size = Math.max(0.16, 9 * this.px);
      for (const [x, y, , isSeen] of this.world.patrol.alarms || []) {
        pen.beginPath();
        pen.moveTo(x, y + size);
        pen.lineTo(x + size, y - 0.8 * size);
        pen.lineTo(x - size, y - 0.8 * size);
        pen.closePath();
        if (isSeen) pen.fill();
        pen.stroke();
      }
      pen.restore();
    },
    // People of the emulated world: shoulders, and a head that is towards where they look.
    drawPeople(pen, theme) {
      if (!this.layers.includes("walls")) return;
      for (const place of this.world.people) {
        pen.save();
        this.enter(pen, place);
        pen.fillStyle = theme.ink;
        pen.globalAlpha = 0.45;
        pen.beginPath();
        pen.ellipse(0, 0, Math.max(0.13, 4 * this.px), Math.max(0.24, 7 * this.px), 0, 0, 2 * Math.PI);
        pen.fill();
        pen.globalAlpha = 0.9;
        pen.beginPath();
        pen.arc(0.05, 0, Math.max(0.1, 3.5 * this.px), 0, 2 * Math.PI);
        pen.fill();
        pen.restore();
      }
    },
    goalsShown() {
      const all = this.world.goals;
      return all[this.chosen] || Object.values(all)[0] || [];
    },
    drawGoals(pen, theme) {
      if (!this.layers.includes("goals")) return;
      const size = 6 * this.px;
      for (const { kind, pose } of this.goalsShown()) {
        pen.save();
        this.enter(pen, pose);
        pen.fillStyle = kind.includes("Dock") ? theme.door : theme.goal;
        pen.strokeStyle = theme.paper;
        pen.lineWidth = 1.5 * this.px;
        pen.beginPath();
        if (kind.includes("Dock")) pen.rect(-size, -size, 2 * size, 2 * size);
        else {
          pen.moveTo(1.6 * size, 0);
          pen.lineTo(0, size);
          pen.lineTo(-size, 0);
          pen.lineTo(0, -size);
        }
        pen.closePath();
        pen.fill();
        pen.stroke();
        pen.restore();
      }
    },
    drawGoal(pen, [x, y, heading]) {
      const size = Math.max(0.12, 8 * this.px);
      pen.lineWidth = 2 * this.px;
      pen.beginPath();
      pen.arc(x, y, size, 0, 2 * Math.PI);
      pen.stroke();
      pen.beginPath();
      pen.arc(x, y, size / 2.6, 0, 2 * Math.PI);
      pen.fill();
      if (typeof heading !== "number") return;
      pen.beginPath();
      pen.moveTo(x, y);
      pen.lineTo(x + 2.4 * size * Math.cos(heading), y + 2.4 * size * Math.sin(heading));
      pen.stroke();
    },
    drawRobot(pen, theme, robot, colour, pose = this.poseOnMap(robot)) {
      if (!pose) return;
      const { front, rear, width } = robot;
      const half = width / 2;
      const chamfer = Math.min(half, front) * 0.7;
      pen.save();
      this.enter(pen, [pose.x, pose.y, pose.heading]);
      pen.globalAlpha = robot.is_there ? 1 : 0.35;
      pen.beginPath();
      pen.moveTo(-rear, -half * 0.8);
      pen.lineTo(-rear, half * 0.8);
      pen.lineTo(-rear + half * 0.4, half);
      pen.lineTo(front - chamfer, half);
      pen.lineTo(front, half - chamfer);
      pen.lineTo(front, chamfer - half);
      pen.lineTo(front - chamfer, -half);
      pen.lineTo(-rear + half * 0.4, -half);
      pen.closePath();
      pen.fillStyle = robot.level === "alarm" ? "#d3382c" : colour;
      pen.fill();
      pen.lineWidth = robot.name === this.chosen ? 3 * this.px : 1.2 * this.px;
      pen.strokeStyle = robot.name === this.chosen ? theme.ink : theme.paper;
      pen.stroke();
      pen.beginPath();
      pen.moveTo(front * 0.78, 0);
      pen.lineTo(front * 0.1, half * 0.55);
      pen.lineTo(front * 0.1, -half * 0.55);
      pen.closePath();
      pen.fillStyle = "#fff";
      pen.fill();
      pen.restore();
    },
    drawAim(pen, colour) {
      pen.strokeStyle = pen.fillStyle = colour;
      this.drawGoal(pen, [this.aim.x, this.aim.y, this.aim.heading]);
    },
    drawNames(pen, theme, width, height) {
      if (!this.layers.includes("names")) return;
      pen.font = "600 12px Roboto, sans-serif";
      pen.textAlign = "center";
      const place = (x, y) => [width / 2 + (x - this.view.x) * this.view.scale, height / 2 - (y - this.view.y) * this.view.scale];
      for (const robot of this.world.robots) {
        const pose = this.poseOnMap(robot);
        if (!pose) continue;
        const [x, y] = place(pose.x, pose.y);
        const text = robot.level === "ok" ? robot.name : `${robot.name} · ${robot.words}`;
        const below = y + Math.max(robot.rear, robot.front, robot.width) * this.view.scale + 14;
        this.drawLabel(pen, theme, text, x, below);
        pen.font = "12px Roboto, sans-serif";
        this.overlaysOf(robot).forEach(({ words }, index) => this.drawLabel(pen, theme, words, x, below + 17 * (index + 1)));
        pen.font = "600 12px Roboto, sans-serif";
      }
      pen.font = "500 12px Roboto, sans-serif";
      if (this.layers.includes("goals")) {
        for (const { name, pose } of this.goalsShown()) {
          const [x, y] = place(pose[0], pose[1]);
          pen.fillText(name, x, y - 12);
        }
      }
      if (this.layers.includes("overlays")) {
        for (const [x, y, number] of this.world.patrol.alarms || []) {
          const [left, top] = place(x, y);
          this.drawLabel(pen, theme, `alarm ${number}`, left, top - 16);
        }
      }
      pen.font = "12px Roboto, sans-serif";
      pen.globalAlpha = 0.55;
      const named = new Set(this.layers.includes("goals") ? this.goalsShown().map((goal) => goal.name) : []);
      for (const [name, x, y] of this.world.floor?.places || []) {
        if (!named.has(name)) pen.fillText(name, ...place(x / 1000, y / 1000));
      }
      pen.globalAlpha = 1;
    },
    drawLabel(pen, theme, text, x, y) {
      const half = pen.measureText(text).width / 2 + 5;
      pen.globalAlpha = 0.82;
      pen.fillStyle = theme.paper;
      pen.beginPath();
      pen.roundRect(x - half, y - 12, 2 * half, 17, 4);
      pen.fill();
      pen.globalAlpha = 1;
      pen.fillStyle = theme.ink;
      pen.fillText(text, x, y);
    },
    drawScale(pen, theme, width, height) {
      const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((each) => each * this.view.scale > 50) || 100;
      const [x, y, long] = [width - 16, height - 14, step * this.view.scale];
      pen.strokeStyle = pen.fillStyle = theme.ink;
      pen.lineWidth = 1.5;
      pen.beginPath();
      pen.moveTo(x - long, y - 5);
      pen.lineTo(x - long, y);
      pen.lineTo(x, y);
      pen.lineTo(x, y - 5);
      pen.stroke();
      pen.font = "12px Roboto, sans-serif";
      pen.textAlign = "center";
      pen.fillText(`${step} m`, x - long / 2, y - 5);
    },

    // What a person does.

    robotAt(px, py) {
      const [x, y] = this.toMetres(px, py);
      let [found, best] = ["", Infinity];
      for (const robot of this.world.robots) {
        const pose = this.poseOnMap(robot);
        if (!pose) continue;
        const far = Math.hypot(pose.x - x, pose.y - y);
        const near = Math.max(robot.front, robot.rear, NEAR_PX * this.px);
        if (far < near && far < best) [found, best] = [robot.name, far];
      }
      return found;
    },
    goalAt(px, py) {
      const [x, y] = this.toMetres(px, py);
      const near = (goal) => Math.hypot(goal.pose[0] - x, goal.pose[1] - y) < NEAR_PX * this.px;
      return (this.world.goals[this.chosen] || []).find(near)?.name;
    },
    onDown(event) {
      if (event.button !== 0 || !this.view) return;
      this.$el.focus({ preventScroll: true });
      this.$refs.canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, startX: event.clientX, startY: event.clientY });
      this.aim = this.held = null;
      const [name, [x, y]] = [this.robotAt(event.clientX, event.clientY), this.toMetres(event.clientX, event.clientY)];
      if (this.mode === "look" || this.pointers.size !== 1) return;
      if (name && this.mode === "place") {
        const pose = this.poseOnMap(this.world.robots.find((robot) => robot.name === name));
        this.held = { robot: name, x: pose.x, y: pose.y, heading: pose.heading, byX: pose.x - x, byY: pose.y - y };
      } else if (!name && this.chosen) this.aim = { x, y, heading: null };
      this.redraw();
    },
    onMove(event) {
      const pointer = this.pointers.get(event.pointerId);
      if (!pointer) return;
      const [before, others] = [{ ...pointer }, [...this.pointers.values()].filter((each) => each !== pointer)];
      Object.assign(pointer, { x: event.clientX, y: event.clientY });
      if (others.length) {
        this.aim = this.held = null;
        const [other] = others;
        const apart = (a) => Math.hypot(a.x - other.x, a.y - other.y);
        this.zoom(apart(pointer) / Math.max(apart(before), 1), (pointer.x + other.x) / 2, (pointer.y + other.y) / 2);
      } else if (Math.hypot(pointer.x - pointer.startX, pointer.y - pointer.startY) >= CLICK_PX) {
        pointer.dragged = true;
        const [x, y] = this.toMetres(pointer.x, pointer.y);
        if (this.held) {
          [this.held.x, this.held.y] = [x + this.held.byX, y + this.held.byY];
        } else if (this.aim) {
          this.aim.heading = Math.atan2(y - this.aim.y, x - this.aim.x);
        } else this.pan(pointer.x - before.x, pointer.y - before.y);
      }
      this.redraw();
    },
    onUp(event) {
      const pointer = this.pointers.get(event.pointerId);
      this.pointers.delete(event.pointerId);
      if (!pointer) return;
      if (this.held && pointer.dragged) {
        const { robot, x, y } = this.held;
        this.$emit("choose", { robot });
        this.$emit("place", { robot, x, y, heading: null });
        this.held = null;
      } else if (this.aim) {
        const [kind, aim] = [this.mode === "send" ? "goal" : this.mode, this.aim];
        const name = kind === "goal" && aim.heading === null && this.goalAt(event.clientX, event.clientY);
        if (name) this.$emit("named", { robot: this.chosen, name });
        else this.$emit(kind, { robot: this.chosen, ...aim });
        this.aim = null;
      } else if (!pointer.dragged && !this.pointers.size) {
        this.held = null;
        this.$emit("choose", { robot: this.robotAt(event.clientX, event.clientY) });
      }
      this.redraw();
    },
    onCancel(event) {
      this.pointers.delete(event.pointerId);
      this.aim = this.held = null;
      this.redraw();
    },
    onWheel(event) {
      this.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), event.clientX, event.clientY);
    },
    onKey(event) {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const pans = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] };
      if (pans[event.key]) this.pan(...pans[event.key]);
      else if (event.key === "+" || event.key === "=") this.zoom(1.3);
      else if (event.key === "-") this.zoom(1 / 1.3);
      else if (event.key === "0") this.fit();
      else if (event.key === "n") this.chooseNext();
      else return;
      event.preventDefault();
      this.redraw();
    },
    chooseNext() {
      const names = this.world.robots.map((robot) => robot.name);
      this.$emit("choose", { robot: names[(names.indexOf(this.chosen) + 1) % names.length] || "" });
    },
    pan(dx, dy) {
      if (!this.view) return;
      this.view.x -= dx / this.view.scale;
      this.view.y += dy / this.view.scale;
      this.moved = true;
    },
    zoom(factor, px, py) {
      if (!this.view) return;
      const box = this.$refs.canvas.getBoundingClientRect();
      const [atX, atY] = [px ?? box.left + box.width / 2, py ?? box.top + box.height / 2];
      const [x, y] = this.toMetres(atX, atY);
      this.view.scale = Math.min(Math.max(this.view.scale * factor, FARTHEST), CLOSEST);
      const [newX, newY] = this.toMetres(atX, atY);
      this.view.x += x - newX;
      this.view.y += y - newY;
      this.moved = true;
      this.redraw();
    },
  },
};
