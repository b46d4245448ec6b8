// Loudness over time with the impacts heard: zoom (wheel, + −), pan (drag), click to add or strike out.
// Keyboard: arrows go from sound to sound (Shift: a millisecond), Enter does what a click does.
const WIDE = 1000, HIGH = 240, REACH_PX = 7;
export default {
  template: `
  <div class="wave" ref="box" tabindex="0" @keydown="key" role="application" :aria-label="tr('Sound: arrows go from sound to sound, Enter adds or strikes out an impact')">
    <svg ref="svg" viewBox="0 0 1000 240" preserveAspectRatio="none"
         @wheel.prevent="wheel" @pointerdown="down" @pointermove="move" @pointerup="up" @pointercancel="start = null">
      <path class="loud" :d="outline"/>
      <line v-for="t in inside(marks.others)" :key="'o' + t" class="other" :x1="x(t)" :x2="x(t)" y1="214" y2="240"><title>{{ tr('{} s, no impact', t.toFixed(4)) }}</title></line>
      <line v-for="t in inside(marks.impacts)" :key="'i' + t" class="impact" :class="{added: isAdded(t)}" :x1="x(t)" :x2="x(t)" y1="0" y2="240" :data-impact="t"><title>{{ isAdded(t) ? tr('{} s, impact set by hand', t.toFixed(4)) : tr('{} s, impact', t.toFixed(4)) }}</title></line>
      <line v-for="t in inside(marks.struck)" :key="'s' + t" class="struck" :x1="x(t)" :x2="x(t)" y1="0" y2="240" :data-struck="t"><title>{{ tr('{} s, struck out by hand', t.toFixed(4)) }}</title></line>
      <line v-if="cursor !== null" class="cursor" :x1="x(cursor)" :x2="x(cursor)" y1="0" y2="240"/>
    </svg>
    <div class="wave-axis"><span v-for="t in ticks" :key="t" :style="{left: x(t) / 10 + '%'}">{{ label(t) }}</span></div>
    <div class="soft text-xs" role="status">{{ words }}</div>
  </div>`,
  props: {src: String, begin: Number, end: Number, marks: Object},
  data() { return {view: [this.begin, this.end], peaks: [], of: null, cursor: null, start: null, timer: null}; },
  computed: {
    outline() {
      if (!this.of || !this.peaks.length) return '';
      const n = this.peaks.length, at = i => this.x(this.of[0] + (i + .5) / n * (this.of[1] - this.of[0])).toFixed(2);
      const top = this.peaks.map((p, i) => at(i) + ' ' + (HIGH / 2 * (1 - p)).toFixed(1));
      const foot = this.peaks.map((p, i) => at(i) + ' ' + (HIGH / 2 * (1 + p)).toFixed(1)).reverse();
      return 'M' + top.join('L') + 'L' + foot.join('L') + 'Z';
    },
    step() {
      const raw = (this.view[1] - this.view[0]) / 8, tens = 10 ** Math.floor(Math.log10(raw));
      return [1, 2, 5, 10].map(f => f * tens).find(s => s >= raw);
    },
    ticks() {
      const out = [];
      for (let t = Math.ceil(this.view[0] / this.step) * this.step; t <= this.view[1]; t += this.step) if (t > this.view[0] + .02 * (this.view[1] - this.view[0])) out.push(t);
      return out;
    },
    sounds() { return [...(this.marks.others || []), ...(this.marks.impacts || [])].sort((a, b) => a - b); },
    words() {
      if (this.cursor === null) return tr('Click an impact to strike it out, another sound to add it. Wheel or + − 0 zoom, dragging pans; arrows and Enter do the same by key.');
      const near = (list, reach) => (list || []).some(t => Math.abs(t - this.cursor) < reach);
      const at = this.cursor.toFixed(4);
      if (near(this.marks.struck, .004)) return tr('{} s: struck out. Enter brings it back.', at);
      if (near(this.marks.impacts, .0005)) return tr('{} s: an impact. Enter strikes it out.', at);
      if (near(this.marks.others, .0005)) return tr('{} s: a sound, no impact. Enter adds an impact.', at);
      return tr('{} s: nothing sudden. Enter adds an impact.', at);
    },
  },
  mounted() { this.fetch(); this.sizes = new ResizeObserver(() => this.later()); this.sizes.observe(this.$refs.svg); },
  unmounted() { this.sizes.disconnect(); clearTimeout(this.timer); },
  methods: {
    tr: window.tr,
    x(t) { return WIDE * (t - this.view[0]) / (this.view[1] - this.view[0]); },
    label(t) { return t.toFixed(Math.max(0, -Math.floor(Math.log10(this.step) + 1e-9))) + ' s'; },
    inside(list) { return (list || []).filter(t => t >= this.view[0] && t <= this.view[1]); },
    isAdded(t) { return (this.marks.added || []).some(a => Math.abs(a - t) < 1e-6); },
    later() { clearTimeout(this.timer); this.timer = setTimeout(this.fetch, 120); },
    async fetch() {
      const [a, b] = this.view, n = Math.max(200, Math.round(this.$refs.svg?.clientWidth || 800));
      const answer = await fetch(`${this.src}&a=${a}&b=${b}&n=${n}`);
      if (answer.ok) { this.peaks = await answer.json(); this.of = [a, b]; }
    },
    time(event) { const r = this.$refs.svg.getBoundingClientRect(); return this.view[0] + (event.clientX - r.left) / r.width * (this.view[1] - this.view[0]); },
    reach() { return REACH_PX / this.$refs.svg.clientWidth * (this.view[1] - this.view[0]); },
    look(a, wide) {
      wide = Math.min(this.end - this.begin, Math.max(.01, wide));
      a = Math.min(this.end - wide, Math.max(this.begin, a));
      this.view = [a, a + wide]; this.later();
    },
    zoom(by, t) { const [a, b] = this.view; this.look(t - (t - a) * by, (b - a) * by); },
    wheel(event) { this.zoom(event.deltaY > 0 ? 1.25 : .8, this.time(event)); },
    down(event) { this.start = {x: event.clientX, view: [...this.view], moved: false}; this.$refs.svg.setPointerCapture(event.pointerId); },
    move(event) {
      if (!this.start) return;
      const dx = event.clientX - this.start.x;
      if (Math.abs(dx) > 3) this.start.moved = true;
      const [a, b] = this.start.view;
      if (this.start.moved) this.look(a - dx / this.$refs.svg.clientWidth * (b - a), b - a);
    },
    up(event) {
      if (this.start && !this.start.moved) { this.cursor = null; this.$emit('clicked', {at: this.time(event), reach: this.reach()}); }
      this.start = null;
    },
    go(to) {
      this.cursor = to;
      const [a, b] = this.view;
      if (to < a || to > b) this.look(to - (b - a) / 2, b - a);
    },
    key(event) {
      const from = this.cursor ?? this.view[0], right = event.key === 'ArrowRight', [a, b] = this.view;
      if (right || event.key === 'ArrowLeft') {
        const next = right ? this.sounds.find(t => t > from + 1e-4) : this.sounds.findLast(t => t < from - 1e-4);
        if (event.shiftKey) this.go(from + (right ? .001 : -.001)); else if (next !== undefined) this.go(next);
      } else if (event.key === 'Enter' && this.cursor !== null) this.$emit('clicked', {at: this.cursor, reach: .0005});
      else if (event.key === '+' || event.key === '=') this.zoom(.7, this.cursor ?? (a + b) / 2);
      else if (event.key === '-') this.zoom(1 / .7, this.cursor ?? (a + b) / 2);
      else if (event.key === '0') this.look(this.begin, this.end - this.begin);
      else return;
      event.preventDefault();
    },
  },
};
