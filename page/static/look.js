// A picture with what was found over it: zoom (wheel, + −), pan (drag), handles to drag (or Tab and arrow keys).
// All dragging happens here; the result is sent once, on release.
export default {
  template: `
  <div class="look" ref="box" tabindex="0" @keydown="key" :aria-label="label" role="application">
    <svg ref="svg" :viewBox="view.join(' ')" preserveAspectRatio="xMidYMid meet"
         @wheel.prevent="wheel" @pointerdown="down" @pointermove="move" @pointerup="up" @pointercancel="up">
      <image v-if="src" :href="src" x="0" y="0" :width="width" :height="height" preserveAspectRatio="none"/>
      <polyline v-if="layers.surface" class="surface" :points="flat(layers.surface)"/>
      <line v-for="(l, i) in layers.lines || []" :key="'l' + i" class="fitted" :x1="l[0]" :y1="l[1]" :x2="l[2]" :y2="l[3]"/>
      <line v-for="(y, i) in windowLines" :key="'w' + i" class="window" :class="{on: tool === 'window'}" x1="0" :y1="y" :x2="width" :y2="y"/>
      <line v-if="base" class="base" :x1="base[0]" :y1="base[1]" :x2="base[2]" :y2="base[3]"/>
      <rect v-if="roi" class="roi" :x="roi[0]" :y="roi[1]" :width="roi[2]" :height="roi[3]"/>
      <line v-if="two && (tool === 'ruler' || tool === 'plumb')" class="ruler" :x1="two[0]" :y1="two[1]" :x2="two[2]" :y2="two[3]"/>
      <polyline v-if="path" class="track" :points="path"/>
      <g v-for="(p, i) in dots" :key="'t' + i"><circle :class="{stray: p[3], now: p[0] === frame}" class="dot" :cx="p[1]" :cy="p[2]" :r="(p[0] === frame ? 9 : 4) * unit"
         @pointerdown.stop="strike(p)"><title>frame {{ p[0] }}{{ p[3] ? ', left out' : '' }}</title></circle></g>
      <circle v-for="h in handles" :key="h.id" class="handle" :cx="h.x" :cy="h.y" :r="8 * unit" tabindex="0" :data-handle="h.id"
         :aria-label="h.id" @pointerdown.stop="grab($event, h)" @keydown.stop="nudge($event, h)"/>
    </svg>
  </div>`,
  props: {src: String, width: Number, height: Number, layers: Object, tool: String, frame: Number, label: String},
  data() { return {view: [0, 0, this.width || 1, this.height || 1], held: null, start: null, unit: 1, mine: {}, two: null, moved: false}; },
  computed: {
    base() { return this.mine.base || this.layers.base; },
    roi() { return this.mine.roi || this.layers.roi; },
    windowLines() {
      const {crest} = this.layers, w = this.mine.window || this.layers.window;
      if (!crest || !this.base || !w) return [];
      const foot = this.at(crest[0]);
      return w.map(p => foot - p / 100 * (foot - crest[1]));
    },
    dots() { return this.layers.track || []; },
    path() { return this.dots.length ? this.dots.filter(p => !p[3]).map(p => p[1] + ',' + p[2]).join(' ') : ''; },
    handles() {
      const b = this.base, r = this.roi;
      if (this.tool === 'base' && b) return [{id: 'base-left', x: b[0] + .04 * (b[2] - b[0]), y: this.at(b[0] + .04 * (b[2] - b[0]))},
                                             {id: 'base-right', x: b[2] - .04 * (b[2] - b[0]), y: this.at(b[2] - .04 * (b[2] - b[0]))}];
      if (this.tool === 'roi' && r) return [{id: 'roi-0', x: r[0], y: r[1]}, {id: 'roi-1', x: r[0] + r[2], y: r[1]},
                                            {id: 'roi-2', x: r[0], y: r[1] + r[3]}, {id: 'roi-3', x: r[0] + r[2], y: r[1] + r[3]}];
      if (this.tool === 'window') return this.windowLines.map((y, i) => ({id: 'window-' + i, x: this.width * (.5 + .1 * i), y}));
      if ((this.tool === 'ruler' || this.tool === 'plumb') && this.two) return [{id: 'end-0', x: this.two[0], y: this.two[1]}, {id: 'end-1', x: this.two[2], y: this.two[3]}];
      return [];
    },
  },
  watch: {
    layers() { if (!this.held) this.mine = {}; },
    width() { this.whole(); }, height() { this.whole(); },
    tool(now) {
      const w = this.width, h = this.height;
      this.mine = {};
      if (now === 'ruler') this.two = [.35 * w, .5 * h, .65 * w, .5 * h];
      if (now === 'plumb') this.two = [.5 * w, .2 * h, .5 * w, .8 * h];
      if (now === 'roi' && !this.roi) this.mine = {roi: [.1 * w, .1 * h, .8 * w, .8 * h].map(Math.round)};
      if (now === 'base' && !this.base) this.mine = {base: [0, .9 * h, w, .9 * h]};
    },
  },
  mounted() { this.whole(); this.sizes = new ResizeObserver(() => this.measure()); this.sizes.observe(this.$refs.svg); },
  unmounted() { this.sizes.disconnect(); },
  methods: {
    flat(points) { return points.map(p => p[0] + ',' + p[1]).join(' '); },
    at(x) { const b = this.base; return b[1] + (b[3] - b[1]) * (x - b[0]) / (b[2] - b[0]); },
    whole() { this.view = [0, 0, this.width || 1, this.height || 1]; this.measure(); },
    measure() {
      const matrix = this.$refs.svg && this.$refs.svg.getScreenCTM();
      if (matrix && matrix.a) this.unit = 1 / matrix.a;
    },
    place(event) {
      const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.$refs.svg.getScreenCTM().inverse());
      return [point.x, point.y];
    },
    zoom(by, at) {
      const [x, y, w, h] = this.view, size = Math.min(this.width, Math.max(40, w * by)), f = size / w;
      if (size >= this.width) return this.whole();
      this.view = [at[0] - (at[0] - x) * f, at[1] - (at[1] - y) * f, size, h * f];
      this.$nextTick(this.measure);
    },
    wheel(event) { this.zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, this.place(event)); },
    down(event) {
      if (this.tool === 'follow') { const p = this.place(event); this.$emit('moved', {what: 'follow', value: [this.frame, p[0], p[1]]}); return; }
      this.start = {at: this.place(event), view: [...this.view]}; this.$refs.svg.setPointerCapture(event.pointerId);
    },
    grab(event, h) { this.held = h.id; this.$refs.svg.setPointerCapture(event.pointerId); },
    move(event) {
      const p = this.place(event);
      if (this.held) { this.shift(this.held, p); return; }
      if (!this.start) return;
      const [dx, dy] = [p[0] - this.start.at[0], p[1] - this.start.at[1]];
      this.view = [this.view[0] - dx, this.view[1] - dy, this.view[2], this.view[3]];
    },
    up() { if (this.held) this.send(this.held); this.held = null; this.start = null; },
    shift(id, [x, y]) {
      const [what, which] = id.split('-');
      if (what === 'base') {
        const b = [...this.base], left = which === 'left', anchor = left ? b[2] : b[0], other = this.at(anchor);
        const slope = (y - other) / ((x - anchor) || 1e-9);
        this.mine = {base: left ? [b[0], other + slope * (b[0] - anchor), b[2], b[3]] : [b[0], b[1], b[2], other + slope * (b[2] - anchor)]};
      } else if (what === 'roi') {
        const r = this.roi, right = r[0] + r[2], foot = r[1] + r[3], clamp = (v, top) => Math.round(Math.min(top, Math.max(0, v)));
        x = clamp(x, this.width); y = clamp(y, this.height);
        const x0 = which % 2 ? r[0] : Math.min(x, right - 24), x1 = which % 2 ? Math.max(x, r[0] + 24) : right;
        const y0 = which > 1 ? r[1] : Math.min(y, foot - 24), y1 = which > 1 ? Math.max(y, r[1] + 24) : foot;
        this.mine = {roi: [x0, y0, x1 - x0, y1 - y0]};
      } else if (what === 'window') {
        const {crest} = this.layers, foot = this.at(crest[0]), w = [...(this.mine.window || this.layers.window)];
        w[+which] = Math.round(Math.min(100, Math.max(0, 100 * (foot - y) / (foot - crest[1]))));
        if (w[1] - w[0] >= 10) this.mine = {window: w};
      } else if (what === 'end') {
        const t = [...this.two]; t[2 * which] = x; t[2 * which + 1] = y; this.two = t;
      }
    },
    send(id) {
      const what = id.split('-')[0];
      if (what === 'end') this.$emit('moved', {what: this.tool, value: this.two});
      else if (this.mine[what]) this.$emit('moved', {what, value: this.mine[what]});
    },
    nudge(event, h) {
      const step = event.shiftKey ? 10 : 1, by = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step]}[event.key];
      if (!by) return;
      event.preventDefault();
      this.shift(h.id, [h.x + by[0], h.y + by[1]]);
      this.send(h.id);
    },
    strike(p) { if (this.tool === 'strike') this.$emit('moved', {what: 'strike', value: p[0]}); },
    key(event) {
      const [x, y, w, h] = this.view, middle = [x + w / 2, y + h / 2];
      if (event.key === '+' || event.key === '=') this.zoom(1 / 1.3, middle);
      else if (event.key === '-') this.zoom(1.3, middle);
      else if (event.key === '0') this.whole();
    },
  },
};
