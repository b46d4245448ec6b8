// Recording | twin | difference, and both curves below, all at the place where the slider stands.
const W = 300, H = 300, CW = 1000, CH = 260, SPLIT = 170;
export default {
  template: `
  <div class="beside">
    <div class="beside-row">
      <figure v-for="(side, k) in sides" :key="k">
        <figcaption>{{ side.title }}</figcaption>
        <img v-if="picture(k)" :src="picture(k)" :alt="tr('{} at {}', side.title, at)">
        <svg v-else :viewBox="'0 0 ' + ${W} + ' ' + ${H}" role="img" :aria-label="tr('{} at {}', side.title, at)">
          <line v-if="s.rig !== 'pile'" class="ground" x1="0" :x2="${W}" :y1="ground" :y2="ground"/>
          <template v-if="s.rig === 'pile'">
            <path v-if="k !== 1" class="recorded" :d="outline(s.bench)"/><path v-if="k !== 0" class="twin" :d="outline(s.twin)"/>
            <line class="cursor" :x1="px(s.x[i])" :x2="px(s.x[i])" y1="0" :y2="${H}"/>
          </template>
          <template v-else>
            <ellipse v-if="k !== 1" class="recorded" :cx="centre(s.bench)[0]" :cy="centre(s.bench)[1]" :rx="radii[0]" :ry="radii[1]"/>
            <ellipse v-if="k !== 0" class="twin" :cx="centre(s.twin)[0]" :cy="centre(s.twin)[1]" :rx="radii[0]" :ry="radii[1]"/>
          </template>
        </svg>
      </figure>
    </div>
    <input type="range" min="0" :max="s.x.length - 1" step="1" v-model.number="i" :aria-label="tr('Through {}', s.xname)" :aria-valuetext="words">
    <div class="beside-words" role="status">{{ words }}</div>
    <svg class="curves" viewBox="0 0 ${CW} ${CH}" preserveAspectRatio="none" @pointerdown="grab" @pointermove="event => event.buttons && grab(event)" role="img" :aria-label="tr('Both over each other, and the difference below')">
      <path class="recorded" :d="curve(s.bench, span, 8, ${SPLIT} - 8)"/><path class="twin" :d="curve(s.twin, span, 8, ${SPLIT} - 8)"/>
      <line class="ground" x1="0" x2="${CW}" :y1="zero" :y2="zero"/><path class="off" :d="curve(off, offSpan, ${SPLIT} + 8, ${CH} - 4)"/>
      <line class="cursor" :x1="cx" :x2="cx" y1="0" y2="${CH}"/>
    </svg>
    <div class="soft text-xs">{{ tr('Above: {} over {}, recorded (line) and twin (dashed). Below: their difference, to ± {}. Another seed, another packing: they agree as two repeats do.', s.yname, s.xname, short(offSpan[1])) }} {{ filmed ? '' : tr('Without films, both are drawn from their tracks, at true scale.') }}</div>
  </div>`,
  props: {shown: Object},
  data() { return {i: Math.floor((this.shown.x.length - 1) / 3)}; },
  watch: { shown() { this.i = Math.floor((this.s.x.length - 1) / 3); } },
  computed: {
    s() { return this.shown; },
    unit() { return (this.s.yname.match(/\(([^)]*)\)/) || ['', ''])[1]; },
    xunit() { return (this.s.xname.match(/\(([^)]*)\)/) || ['', ''])[1]; },
    sides() { return [{title: tr('recording')}, {title: tr('twin')}, {title: tr('difference')}]; },
    off() { return this.s.twin.map((v, k) => v - this.s.bench[k]); },
    span() { const all = [...this.s.bench, ...this.s.twin]; return [Math.min(...all), Math.max(...all)]; },
    offSpan() { const most = Math.max(...this.off.map(Math.abs), 1e-9); return [-most, most]; },
    filmed() { return this.s.rig === 'pile' || this.s.frames.some(f => f); },
    zero() { return (SPLIT + 8 + CH - 4) / 2; },
    cx() { return CW * (this.s.x[this.i] - this.s.x[0]) / (this.s.x[this.s.x.length - 1] - this.s.x[0]); },
    at() { return `${this.s.xname.replace(/ \(.*/, '')} ${this.short(this.s.x[this.i])} ${this.xunit}`.trim(); },
    words() {
      const u = this.unit ? ' ' + this.unit : '';
      return tr('{}: recording {}, twin {}, difference {}', this.at, ...[this.s.bench, this.s.twin, this.off].map(of => this.short(of[this.i]) + u));
    },
    seed() { return this.s.seed || [Math.max(this.span[1] - this.span[0], 1) / 20, Math.max(this.span[1] - this.span[0], 1) / 20]; },
    scale() { // px a mm: drops stand upright, the rest runs from left to right
      const reach = Math.max(this.span[1] - this.span[0], 1e-9), room = this.s.rig === 'drop' ? this.seed[1] : this.seed[0];
      return (H - 24) / (reach + room);
    },
    radii() { return [Math.max(3, this.seed[0] / 2 * this.scale), Math.max(3, this.seed[1] / 2 * this.scale)]; },
    ground() { return this.s.rig === 'drop' ? H - 10 : H / 2 + this.radii[1]; },
    pileSpan() { return Math.max(this.s.x[this.s.x.length - 1] - this.s.x[0], this.span[1]) || 1; },
  },
  methods: {
    tr: window.tr,
    short(v) { return Number(v.toPrecision(4)).toString().replace('-', '−'); },
    centre(of) {
      const y = of[this.i] - this.span[0];
      if (this.s.rig === 'drop') return [W / 2, this.ground - this.radii[1] - y * this.scale];
      return [12 + this.radii[0] + y * this.scale, this.ground - this.radii[1]];
    },
    px(x) { return 10 + (W - 20) * (x - this.s.x[0]) / this.pileSpan; },
    outline(of) { return 'M' + this.s.x.map((x, k) => `${this.px(x).toFixed(1)} ${(H - 40 - (W - 20) * of[k] / this.pileSpan).toFixed(1)}`).join('L'); },
    curve(of, [low, high], top, foot) {
      const x0 = this.s.x[0], wide = this.s.x[this.s.x.length - 1] - x0 || 1;
      return 'M' + this.s.x.map((x, k) => `${(CW * (x - x0) / wide).toFixed(1)} ${(foot - (foot - top) * (of[k] - low) / (high - low || 1)).toFixed(1)}`).join('L');
    },
    picture(k) {
      if (k === 2) return '';
      const name = encodeURIComponent(this.s.names[k]), frames = this.s.frames[k];
      if (frames) return `/frame?r=${name}&i=${frames[this.i]}`;
      return this.s.photos[k] ? `/overlay?r=${name}&name=pile` : '';
    },
    grab(event) {
      const box = event.currentTarget.getBoundingClientRect(), x0 = this.s.x[0], end = this.s.x[this.s.x.length - 1];
      const to = x0 + (event.clientX - box.left) / box.width * (end - x0);
      this.i = this.s.x.reduce((best, x, k) => Math.abs(x - to) < Math.abs(this.s.x[best] - to) ? k : best, 0);
    },
  },
};
