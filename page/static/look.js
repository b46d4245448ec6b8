// A picture, or a film, with what was found over it: zoom (wheel, + −), pan (drag), handles to drag (or Tab and arrow keys).
// All dragging and playing happens here; a result is sent once, on release.
const SPEEDS = [.01, .02, .05, .1, .25, .5, 1, 2];
const NAMES = {'base-left': tr('Base line, left end'), 'base-right': tr('Base line, right end'), 'roi-0': tr('Region, top left'), 'roi-1': tr('Region, top right'), 'roi-2': tr('Region, bottom left'), 'roi-3': tr('Region, bottom right'),
               'window-0': tr('Lower height'), 'window-1': tr('Upper height'), 'end-0': tr('First end'), 'end-1': tr('Second end'), spot: tr('Place: arrow keys move it, Enter sets it')};
export default {
  template: `
  <div>
  <div class="look" ref="box" tabindex="0" @keydown="key" :aria-label="label + '. ' + keys" role="application">
    <svg ref="svg" :viewBox="view.join(' ')" preserveAspectRatio="xMidYMid meet" :class="{aim: tool === 'place' || tool === 'follow'}"
         @wheel.prevent="wheel" @pointerdown="down" @pointermove="move" @pointerup="up" @pointercancel="up">
      <image v-if="source" :href="source" x="0" y="0" :width="width" :height="height" preserveAspectRatio="none"/>
      <polyline v-if="layers.surface" class="surface" :points="flat(layers.surface)"/>
      <line v-for="(l, i) in layers.lines || []" :key="'l' + i" class="fitted" :x1="l[0]" :y1="l[1]" :x2="l[2]" :y2="l[3]"/>
      <line v-for="(y, i) in windowLines" :key="'w' + i" class="window" :class="{on: tool === 'window'}" x1="0" :y1="y" :x2="width" :y2="y"/>
      <line v-if="base" class="base" :x1="base[0]" :y1="base[1]" :x2="base[2]" :y2="base[3]"/>
      <rect v-if="roi" class="roi" :x="roi[0]" :y="roi[1]" :width="roi[2]" :height="roi[3]"/>
      <line v-if="two && (tool === 'ruler' || tool === 'plumb')" class="ruler" :x1="two[0]" :y1="two[1]" :x2="two[2]" :y2="two[3]"/>
      <polyline v-if="path" class="track" :points="path"/>
      <g v-for="(p, i) in dots" :key="'t' + i"><circle :class="{stray: p[3], now: p[0] === frame}" class="dot" :cx="p[1]" :cy="p[2]" :r="(p[0] === frame ? 9 : 4) * unit"
         @pointerdown="tool === 'strike' && strike($event, p[0])"><title>{{ p[3] ? tr('frame {}, left out', p[0]) : tr('frame {}', p[0]) }}</title></circle></g>
      <path v-for="p in places" :key="'p' + p[0]" class="placed" :class="{now: p[0] === frame}" :d="cross(p[1], p[2], (p[0] === frame ? 11 : 5) * unit)"><title>{{ tr('frame {}, set by hand', p[0]) }}</title></path>
      <circle v-for="h in handles" :key="h.id" class="handle" :cx="h.x" :cy="h.y" :r="8 * unit" tabindex="0" :data-handle="h.id" role="button"
         :aria-label="name(h)" @pointerdown="grab($event, h)" @keydown.stop="nudge($event, h)"/>
    </svg>
  </div>
  <div v-if="film" class="player">
    <button type="button" @click="toggle" :aria-label="playing ? tr('Pause') : tr('Play')" class="play">{{ playing ? '❚❚' : '▶' }}</button>
    <button type="button" @click="step(-1)" :aria-label="tr('One frame back')">‹</button>
    <button type="button" @click="step(1)" :aria-label="tr('One frame on')">›</button>
    <input type="range" min="0" :max="last" step="1" :value="at" @input="show(+$event.target.value)" :aria-label="tr('Frame')" :aria-valuetext="moment">
    <label>{{ tr('speed') }} <select v-model.number="speed" @change="restart" :aria-label="tr('Playing speed')">
      <option v-for="s in speeds" :key="s" :value="s">{{ s }} ×</option></select></label>
    <span class="moment" role="status">{{ moment }}</span>
  </div>
  </div>`,
  props: {src: String, width: Number, height: Number, layers: Object, tool: String, label: String, film: Object},
  data() {
    return {view: [0, 0, this.width || 1, this.height || 1], held: null, start: null, unit: 1, mine: {}, two: null, at: 0, playing: false, speed: this.film && this.film.rate > 250 ? .01 : 1, speeds: SPEEDS, clock: null};
  },
  computed: {
    frame() { return this.film ? this.film.numbers[this.at] : 0; },
    last() { return this.film ? this.film.numbers.length - 1 : 0; },
    source() { return this.film ? this.picture(this.at) : this.src; },
    moment() {
      const n = this.film.numbers, t = (this.frame - n[0]) / this.film.rate;
      return tr('frame {} of {} to {}', this.frame, n[0], n[this.last]) + (this.film.timed ? ` · ${t.toFixed(this.film.rate > 500 ? 4 : 3)} s` : '');
    },
    keys() { return this.film ? tr('Left and right arrow: one frame, with Shift ten. Space: play or pause. Plus, minus, 0: zoom.') : tr('Plus, minus, 0: zoom. Arrow keys: move the picture.'); },
    base() { return this.mine.base || this.layers.base; },
    roi() { return this.mine.roi || this.layers.roi; },
    windowLines() {
      const {crest} = this.layers, w = this.mine.window || this.layers.window;
      if (!crest || !this.base || !w) return [];
      const foot = this.at_base(crest[0]);
      return w.map(p => foot - p / 100 * (foot - crest[1]));
    },
    dots() { return this.layers.track || []; },
    places() { return this.layers.places || []; },
    path() { return this.dots.length ? this.dots.filter(p => !p[3]).map(p => p[1] + ',' + p[2]).join(' ') : ''; },
    spot() {  // where the cross stands that the arrow keys move
      if (this.mine.spot) return this.mine.spot;
      const [, x, y] = this.places.find(p => p[0] === this.frame) || this.dots.find(p => p[0] === this.frame) || this.places.findLast(p => p[0] < this.frame) || [0, this.width / 2, this.height / 2];
      return [x, y];
    },
    handles() {
      const b = this.base, r = this.roi;
      if (this.tool === 'base' && b) return [{id: 'base-left', x: b[0] + .04 * (b[2] - b[0]), y: this.at_base(b[0] + .04 * (b[2] - b[0]))},
                                             {id: 'base-right', x: b[2] - .04 * (b[2] - b[0]), y: this.at_base(b[2] - .04 * (b[2] - b[0]))}];
      if (this.tool === 'roi' && r) return [{id: 'roi-0', x: r[0], y: r[1]}, {id: 'roi-1', x: r[0] + r[2], y: r[1]},
                                            {id: 'roi-2', x: r[0], y: r[1] + r[3]}, {id: 'roi-3', x: r[0] + r[2], y: r[1] + r[3]}];
      if (this.tool === 'window') return this.windowLines.map((y, i) => ({id: 'window-' + i, x: this.width * (.5 + .1 * i), y}));
      if ((this.tool === 'ruler' || this.tool === 'plumb') && this.two) return [{id: 'end-0', x: this.two[0], y: this.two[1]}, {id: 'end-1', x: this.two[2], y: this.two[3]}];
      if (this.tool === 'place' || this.tool === 'follow') return [{id: 'spot', x: this.spot[0], y: this.spot[1]}];
      return [];
    },
  },
  watch: {
    layers() { if (!this.held) delete this.mine.base, delete this.mine.roi, delete this.mine.window; },
    width() { this.whole(); }, height() { this.whole(); },
    at() { delete this.mine.spot; },
    tool(now) {
      const w = this.width, h = this.height;
      this.mine = {};
      if (now === 'ruler') this.two = [.35 * w, .5 * h, .65 * w, .5 * h];
      if (now === 'plumb') this.two = [.5 * w, .2 * h, .5 * w, .8 * h];
      if (now === 'roi' && !this.roi) this.mine = {roi: [.1 * w, .1 * h, .8 * w, .8 * h].map(Math.round)};
      if (now === 'base' && !this.base) this.mine = {base: [0, .9 * h, w, .9 * h]};
    },
  },
  mounted() {
    this.whole(); this.sizes = new ResizeObserver(() => this.measure()); this.sizes.observe(this.$refs.svg);
    const kept = this.film && this.film.numbers.indexOf(+new URL(location).searchParams.get('frame'));
    if (kept > 0) this.at = kept;
  },
  unmounted() { this.sizes.disconnect(); this.playing = false; },
  methods: {
    tr: window.tr,
    flat(points) { return points.map(p => p[0] + ',' + p[1]).join(' '); },
    cross(x, y, r) { return `M${x - r} ${y}H${x + r}M${x} ${y - r}V${y + r}`; },
    name(h) { return tr('{}, {} px from the left, {} px from the top', NAMES[h.id], Math.round(h.x), Math.round(h.y)); },
    at_base(x) { const b = this.base; return b[1] + (b[3] - b[1]) * (x - b[0]) / (b[2] - b[0]); },
    whole() { this.view = [0, 0, this.width || 1, this.height || 1]; this.measure(); },
    measure() {
      const matrix = this.$refs.svg && this.$refs.svg.getScreenCTM();
      if (matrix && matrix.a) this.unit = 1 / matrix.a;
    },
    point(event) {
      const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.$refs.svg.getScreenCTM().inverse());
      return [point.x, point.y];
    },
    zoom(by, at) {
      const [x, y, w, h] = this.view, size = Math.min(this.width, Math.max(40, w * by)), f = size / w;
      if (size >= this.width) return this.whole();
      this.view = [at[0] - (at[0] - x) * f, at[1] - (at[1] - y) * f, size, h * f];
      this.$nextTick(this.measure);
    },
    wheel(event) { this.zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, this.point(event)); },
    down(event) {
      this.start = {at: this.point(event), x: event.clientX, y: event.clientY, view: [...this.view], far: false};
      this.$refs.svg.setPointerCapture(event.pointerId);
    },
    grab(event, h) { if (h.id === 'spot') return; event.stopPropagation(); this.held = h.id; this.$refs.svg.setPointerCapture(event.pointerId); },
    move(event) {
      const p = this.point(event);
      if (this.held) { this.shift(this.held, p); return; }
      if (!this.start) return;
      if (Math.hypot(event.clientX - this.start.x, event.clientY - this.start.y) > 3) this.start.far = true;
      if (!this.start.far) return;
      const [dx, dy] = [p[0] - this.start.at[0], p[1] - this.start.at[1]];
      this.view = [this.view[0] - dx, this.view[1] - dy, this.view[2], this.view[3]];
    },
    up(event) {
      if (this.held) this.send(this.held);
      else if (this.start && !this.start.far && event.type === 'pointerup' && (this.tool === 'follow' || this.tool === 'place')) this.set(this.start.at);
      this.held = null; this.start = null;
    },
    set([x, y]) {  // the seed is there in this frame
      this.$emit('moved', {what: this.tool, value: [this.frame, x, y]});
      if (this.tool === 'place') this.step(1);
    },
    shift(id, [x, y]) {
      const [what, which] = id.split('-');
      if (what === 'base') {
        const b = [...this.base], left = which === 'left', anchor = left ? b[2] : b[0], other = this.at_base(anchor);
        const slope = (y - other) / ((x - anchor) || 1e-9);
        this.mine = {base: left ? [b[0], other + slope * (b[0] - anchor), b[2], b[3]] : [b[0], b[1], b[2], other + slope * (b[2] - anchor)]};
      } else if (what === 'roi') {
        const r = this.roi, right = r[0] + r[2], foot = r[1] + r[3], clamp = (v, top) => Math.round(Math.min(top, Math.max(0, v)));
        x = clamp(x, this.width); y = clamp(y, this.height);
        const x0 = which % 2 ? r[0] : Math.min(x, right - 24), x1 = which % 2 ? Math.max(x, r[0] + 24) : right;
        const y0 = which > 1 ? r[1] : Math.min(y, foot - 24), y1 = which > 1 ? Math.max(y, r[1] + 24) : foot;
        this.mine = {roi: [x0, y0, x1 - x0, y1 - y0]};
      } else if (what === 'window') {
        const {crest} = this.layers, foot = this.at_base(crest[0]), w = [...(this.mine.window || this.layers.window)];
        w[+which] = Math.round(Math.min(100, Math.max(0, 100 * (foot - y) / (foot - crest[1]))));
        if (w[1] - w[0] >= 10) this.mine = {window: w};
      } else if (what === 'end') {
        const t = [...this.two]; t[2 * which] = x; t[2 * which + 1] = y; this.two = t;
      } else if (what === 'spot') this.mine = {spot: [Math.min(this.width, Math.max(0, x)), Math.min(this.height, Math.max(0, y))]};
    },
    send(id) {
      const what = id.split('-')[0];
      if (what === 'end') this.$emit('moved', {what: this.tool, value: this.two});
      else if (this.mine[what]) this.$emit('moved', {what, value: this.mine[what]});
    },
    nudge(event, h) {
      const step = event.shiftKey ? 10 : 1, by = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step]}[event.key];
      if (by) {
        event.preventDefault();
        this.shift(h.id, [h.x + by[0], h.y + by[1]]);
        if (h.id !== 'spot') this.send(h.id);
      } else if (h.id === 'spot' && event.key === 'Enter') this.set([h.x, h.y]);
      else this.key(event);
    },
    strike(event, frame) { event.stopPropagation(); this.$emit('moved', {what: 'strike', value: frame}); },
    picture(at) { return `${this.film.source}&i=${this.film.numbers[at]}`; },
    show(at) {
      this.playing = false;
      this.at = Math.min(this.last, Math.max(0, at));
      this.keep();
    },
    step(by) { this.show(this.at + by); },
    keep() {  // the address says which frame: a reload shows it again
      const here = new URL(location); here.searchParams.set('frame', this.frame);
      clearTimeout(this.keeping); this.keeping = setTimeout(() => history.replaceState(history.state, '', here), 300);
    },
    toggle() {
      this.playing = !this.playing;
      if (!this.playing) return this.keep();
      if (this.at === this.last) this.at = 0;
      this.restart(); this.play();
    },
    restart() { this.clock = {begun: performance.now(), frame: this.frame}; },
    play() {  // the frame whose time has come; those between are skipped where the pictures do not come fast enough
      if (!this.playing) return;
      const due = this.clock.frame + (performance.now() - this.clock.begun) / 1000 * this.speed * this.film.rate, n = this.film.numbers;
      let next = this.at;
      while (next < this.last && n[next + 1] <= due) next++;
      if (next === this.at) return void requestAnimationFrame(this.play);
      const coming = new Image();
      coming.onload = () => {
        if (!this.playing) return;
        this.at = next;
        if (next === this.last) { this.playing = false; this.keep(); } else requestAnimationFrame(this.play);
      };
      coming.onerror = () => { this.playing = false; };
      coming.src = this.picture(next);
    },
    key(event) {
      const [x, y, w, h] = this.view, middle = [x + w / 2, y + h / 2];
      const way = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === '+' || event.key === '=') this.zoom(1 / 1.3, middle);
      else if (event.key === '-') this.zoom(1.3, middle);
      else if (event.key === '0') this.whole();
      else if (this.film && way && way[0]) this.step(way[0] * (event.shiftKey ? 10 : 1));
      else if (this.film && event.key === ' ') this.toggle();
      else if (this.film && event.key === 'Home') this.show(0);
      else if (this.film && event.key === 'End') this.show(this.last);
      else if (this.tool === 'strike' && event.key === 'Enter') this.$emit('moved', {what: 'strike', value: this.frame});
      else if (this.tool === 'place' && (event.key === 'Delete' || event.key === 'Backspace')) this.$emit('moved', {what: 'unplace', value: this.frame});
      else if (way && w < this.width) this.view = [x + way[0] * w / 8, y + way[1] * h / 8, w, h];
      else return;
      event.preventDefault();
    },
  },
};
