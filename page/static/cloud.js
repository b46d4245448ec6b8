// Draws of a posterior over two or three chosen parameters. Dragging or the arrow keys turn it, wheel or + − zoom.
export default {
  template: `
  <div class="cloud">
    <div class="cloud-choice">
      <label v-for="(_, k) in axes" :key="k">{{ 'xyz'[k] }} <select v-model.number="axes[k]" @change="draw"><option v-for="(n, i) in names" :key="n" :value="i">{{ n }}</option><option v-if="k === 2" :value="-1">none: two parameters</option></select></label>
    </div>
    <canvas ref="canvas" tabindex="0" role="img" :aria-label="words" @pointerdown="down" @pointermove="move" @pointerup="start = null" @pointercancel="start = null" @wheel.prevent="wheel" @keydown="key"></canvas>
    <div class="soft text-xs" role="status">{{ words }}</div>
  </div>`,
  props: {names: Array, draws: Array},
  data() {
    const k = this.names.length, first = Math.max(0, k - 3);  // seed on seed come last: what a pile leaves open
    return {axes: [first, Math.min(first + 1, k - 1), k > 2 ? first + 2 : -1], turn: .6, tilt: .45, size: 1, start: null};
  },
  computed: {
    words() {
      const quantile = (i, p) => { const v = this.draws.map(d => d[i]).sort((a, b) => a - b); return Number(v[Math.round(p * (v.length - 1))].toPrecision(3)); };
      const of = this.axes.filter(i => i >= 0).map(i => `${this.names[i]} ${quantile(i, .025)} to ${quantile(i, .975)}`);
      return of.join('; ') + ` (95 %). ${this.axes[2] < 0 ? '' : 'Drag or arrow keys turn it.'}`;
    },
  },
  mounted() { this.sizes = new ResizeObserver(() => this.draw()); this.sizes.observe(this.$refs.canvas); this.draw(); },
  unmounted() { this.sizes.disconnect(); },
  methods: {
    down(e) { this.start = {x: e.clientX, y: e.clientY, turn: this.turn, tilt: this.tilt}; this.$refs.canvas.setPointerCapture(e.pointerId); },
    move(e) {
      if (!this.start || this.axes[2] < 0) return;
      this.turn = this.start.turn + (e.clientX - this.start.x) / 150;
      this.tilt = Math.max(-1.57, Math.min(1.57, this.start.tilt + (e.clientY - this.start.y) / 150));
      this.draw();
    },
    wheel(e) { this.size = Math.min(6, Math.max(.4, this.size * (e.deltaY > 0 ? 1 / 1.1 : 1.1))); this.draw(); },
    key(e) {
      const step = {ArrowLeft: [-.1, 0], ArrowRight: [.1, 0], ArrowUp: [0, -.1], ArrowDown: [0, .1]}[e.key];
      if (step) { this.turn += step[0]; this.tilt = Math.max(-1.57, Math.min(1.57, this.tilt + step[1])); }
      else if (e.key === '+' || e.key === '=') this.size = Math.min(6, this.size * 1.2);
      else if (e.key === '-') this.size = Math.max(.4, this.size / 1.2);
      else return;
      e.preventDefault(); this.draw();
    },
    ends(i) { const v = this.draws.map(d => d[i]); return [Math.min(...v), Math.max(...v)]; },
    draw() {
      const c = this.$refs.canvas, dpr = devicePixelRatio || 1, w = c.clientWidth, h = c.clientHeight;
      if (!w) return;
      c.width = w * dpr; c.height = h * dpr;
      const g = c.getContext('2d'); g.scale(dpr, dpr); g.fillStyle = '#15181c'; g.fillRect(0, 0, w, h);
      const used = this.axes.filter(i => i >= 0), ends = used.map(i => this.ends(i)), flat = used.length < 3, unit = .3 * Math.min(w, h) * this.size * (flat ? 1.3 : 1);
      const [ct, st, cp, sp] = flat ? [1, 0, 1, 0] : [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.tilt), Math.sin(this.tilt)];
      const see = ([x, y, z]) => {  // x and y lie on the ground, z stands
        if (flat) return [w / 2 + x * unit, h / 2 - y * unit, 0];
        const [a, b] = [ct * x - st * y, st * x + ct * y];
        return [w / 2 + a * unit, h / 2 - (cp * z + sp * b) * unit, -cp * b + sp * z];
      };
      const place = d => used.map((i, k) => (d[i] - ends[k][0]) / (ends[k][1] - ends[k][0] || 1) * 2 - 1);
      const line = (a, b, colour) => { const [p, q] = [see(a), see(b)]; g.strokeStyle = colour; g.beginPath(); g.moveTo(p[0], p[1]); g.lineTo(q[0], q[1]); g.stroke(); };
      const all = flat ? [[-1, -1], [1, -1], [1, 1], [-1, 1]] : [-1, 1].flatMap(x => [-1, 1].flatMap(y => [-1, 1].map(z => [x, y, z])));
      for (const [i, a] of all.entries()) for (const b of all.slice(i + 1)) if (a.reduce((n, v, k) => n + (v !== b[k]), 0) === 1) line(a, b, '#4a5563');
      g.fillStyle = 'rgba(54,197,216,.42)';
      for (const d of this.draws) { const [x, y] = see([...place(d), 0]); g.beginPath(); g.arc(x, y, 2, 0, 7); g.fill(); }
      g.font = '13px system-ui'; g.fillStyle = '#fff'; g.textAlign = 'center';
      used.forEach((i, k) => {
        const edge = k === 2 ? [-1, 1, 0] : used.map(() => -1), short = v => Number(v.toPrecision(3)).toString();
        const on = (along, off) => see(edge.map((v, j) => j === k ? along : v * off));  // beside the edge that this parameter runs along
        const [x, y] = on(0, 1.2), [a, b] = [on(-.86, 1.1), on(.86, 1.1)];
        const put = (text, px, py) => g.fillText(text, Math.min(w - g.measureText(text).width / 2 - 4, Math.max(g.measureText(text).width / 2 + 4, px)), py);
        put(this.names[i], x, y + 14); g.fillStyle = '#aeb8c4'; put(short(ends[k][0]), a[0], a[1] + 4); put(short(ends[k][1]), b[0], b[1] + 4); g.fillStyle = '#fff';
      });
    },
  },
};
