// The travelling-wave motor from above: tabs in the colour of their voltage, the wave over them,
// the rotor at its angle.
import { byId, colour, sheet } from "./dom.js";
import { digits, quantity } from "./format.js";

/** Phase frequency of the animation, Hz; the drive has 40 kHz. */
const BEAT_HZ = 0.6;
const TURN = 2 * Math.PI;

export class MotorView {
  constructor(canvas) {
    this.canvas = canvas;
    this.data = null;
    this.moment = 0;
    this.phase = 0.1;
    const still = matchMedia("(prefers-reduced-motion: reduce)");
    let before = null;
    const tick = (now) => {
      if (this.data && !still.matches && this.visible) {
        this.phase = (this.phase + (BEAT_HZ * (before === null ? 0 : now - before)) / 1e3) % 1;
        this.draw();
      }
      before = now;
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    new IntersectionObserver(([entry]) => { this.visible = entry.isIntersecting; }).observe(canvas);
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  show(data) {
    this.data = data;
    byId("motor").hidden = !data;
    if (data) this.most = Math.max(...data.forward_um, ...data.backward_um, 1e-9);
  }

  goto(moment) {
    if (!this.data) return;
    this.moment = moment;
    this.draw();
    const at = this.#index();
    const { forward_um, backward_um, rotor_rad_per_s, rotor_rad } = this.data;
    byId("motor-now").textContent =
      `forward wave ${digits(forward_um[at], 3)} µm, backward wave ${digits(backward_um[at], 2)} µm; rotor ${quantity(rotor_rad_per_s[at], "rad/s", 3)}, turned by ${digits((rotor_rad[at] * 360) / TURN, 4)}°`;
  }

  #index() {
    const time = this.data.time_s;
    let low = 0, high = time.length;
    while (low < high) { const mid = (low + high) >> 1; if (time[mid] <= this.moment) low = mid + 1; else high = mid; }
    return Math.max(0, low - 1);
  }

  draw() {
    if (!this.data || this.canvas.clientWidth === 0) return;
    const { waves, tabs, lanes, drive_v, forward_um, backward_um, rotor_rad } = this.data;
    const at = this.#index(), size = Math.min(420, this.canvas.clientWidth);
    const { context, width, height } = sheet(this.canvas, size);
    const centre = [width / 2, height / 2], outer = 0.40 * size, inner = 0.27 * size;
    const on = drive_v[at] > 0, phase = this.phase * TURN;
    context.translate(...centre);
    // Tab j belongs to lane j mod 4, a quarter of a period after the previous lane.
    for (let tab = 0; tab < tabs; tab += 1) {
      const volts = on ? Math.cos(phase - ((tab % 4) * TURN) / 4) : 0;
      const from = ((tab - 0.45) / tabs) * TURN, to = ((tab + 0.45) / tabs) * TURN;
      context.beginPath(); context.arc(0, 0, outer, from, to); context.arc(0, 0, inner, to, from, true); context.closePath();
      context.fillStyle = colour("tab");
      context.fill();
      context.globalAlpha = Math.abs(volts) * (tab % 4 < lanes ? 0.85 : 0);
      context.fillStyle = volts > 0 ? colour("estimate") : colour("command");
      context.fill();
      context.globalAlpha = 1;
    }
    // The surface, as a line around the ring.
    const tall = 0.055 * size, part = (um) => um[at] / this.most;
    context.beginPath();
    for (let n = 0; n <= 360; n += 1) {
      const angle = (n / 360) * TURN;
      const high = tall * (part(forward_um) * Math.cos(waves * angle - phase) + part(backward_um) * Math.cos(waves * angle + phase));
      const radius = outer + 0.045 * size + high;
      context.lineTo(radius * Math.cos(angle), radius * Math.sin(angle));
    }
    context.closePath();
    context.strokeStyle = colour("ink");
    context.lineWidth = 2.4;
    context.stroke();
    // The rotor.
    context.rotate(rotor_rad[at]);
    context.beginPath(); context.arc(0, 0, inner - 0.03 * size, 0, TURN); context.fillStyle = colour("tab"); context.fill();
    context.strokeStyle = colour("muted"); context.lineWidth = 2; context.stroke();
    for (let n = 0; n < 6; n += 1) {
      context.rotate(TURN / 6);
      context.beginPath(); context.moveTo(0.06 * size, 0); context.lineTo(inner - 0.05 * size, 0);
      context.strokeStyle = n === 5 ? colour("truth") : colour("muted"); context.lineWidth = n === 5 ? 5 : 2; context.stroke();
    }
  }
}
