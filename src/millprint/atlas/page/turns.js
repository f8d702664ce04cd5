/* Balls that move: recorded turns of simulated conditions, drawn on a canvas and coloured by speed. */

// A turn of the slower mill takes this long on the page [s].
const TURN_S = 2.5;
// From slow to fast, seen alike by people who do not see all colours.
const COLOURS = [[38, 70, 140], [0, 130, 160], [60, 170, 110], [225, 190, 50], [205, 65, 40]];
const [INK, GLASS] = ["#1f2328", "#fafbfc"];

function colourAt(share) {
  const place = Math.min(Math.max(share, 0), 1) * (COLOURS.length - 1);
  const [low, part] = [Math.min(Math.floor(place), COLOURS.length - 2), place % 1 || (place === COLOURS.length - 1 ? 1 : 0)];
  const mixed = COLOURS[low].map((from, i) => Math.round(from + part * (COLOURS[low + 1][i] - from)));
  return `rgb(${mixed.join(",")})`;
}
const SHADES = Array.from({ length: 33 }, (_, i) => colourAt(i / 32));

/** The recorded run that is nearest in the groups of a kind; those of the contact do not show. */
function nearestRun(kind, recorded, condition) {
  const shown = kind.ranges.filter(({ name }) => !(name in kind.settings) && name !== kind.limits.stiffness);
  const groups = kind.groups(condition);
  const far = (run) => {
    const own = kind.groups(run.condition);
    return shown.reduce((sum, group) => sum + (shareOf(group, groups[group.name]) - shareOf(group, own[group.name])) ** 2, 0);
  };
  return recorded.runs.reduce((best, run) => (far(run) < far(best) ? run : best));
}

/** The bytes of a run as numbers: to the right and up [radii], nearness and share of the fastest speed, by frame. */
async function unpacked(run, perRadius) {
  if (run.balls) return run.balls;
  const packed = Uint8Array.from(atob(run.bytes), (sign) => sign.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = await new Response(stream).arrayBuffer();
  const { number } = run.condition;
  const size = number * run.frames;
  const view = new DataView(bytes);
  const along = (start) => {
    const found = new Float32Array(size);
    for (let ball = 0; ball < number; ball += 1) {
      let sum = 0;
      for (let frame = 0; frame < run.frames; frame += 1) {
        const place = ball * run.frames + frame;
        sum += view.getInt16(start + 2 * place, true);
        found[place] = sum / perRadius;
      }
    }
    return found;
  };
  run.balls = { right: along(0), up: along(2 * size), near: new Uint8Array(bytes, 4 * size, size), speed: new Uint8Array(bytes, 5 * size, size) };
  return run.balls;
}

/** The picture of one side. */
class Picture {
  constructor(canvas, content) {
    this.canvas = canvas;
    this.content = content;
    this.run = null;
  }

  /** Show the run nearest to a condition; nothing without one. */
  async show(kind, condition) {
    this.run = null;
    if (!condition) return this.clear();
    const recorded = this.content.kinds[kind.name];
    const run = nearestRun(kind, recorded, condition);
    this.asked = run;
    const balls = await unpacked(run, this.content.per_radius);
    if (this.asked !== run) return null;
    const reach = [0, 1].map((axis) => Math.max(...run.poses.map((pose) => Math.abs(pose[axis]))));
    const half = recorded.outline === "round" ? [1, 1] : [run.condition.height_mm / run.condition.radius_mm / 2, 1];
    // A lying jar that turns reaches a little higher.
    const tilt = recorded.outline === "round" ? 0 : Math.max(...run.poses.map((pose) => Math.abs(Math.sin(pose[2])))) * half[0];
    Object.assign(this, { run, balls, recorded, half, reach: [reach[0] + half[0] + 0.08, reach[1] + half[1] + tilt + 0.08] });
    this.wall_m_s = 2 * Math.PI * condition.speed_hz * kind.stroke_m(condition);
    this.speed_hz = condition.speed_hz;
    return run;
  }

  /** The fastest ball that is drawn, if it were in the mill that is asked for [m/s]. */
  get fastest() {
    return this.run ? this.run.fastest * this.wall_m_s : 0;
  }

  clear() {
    this.asked = null;
    const { width, height } = this.canvas;
    this.canvas.getContext("2d").clearRect(0, 0, width, height);
    return null;
  }

  /** Draw the moment `turn` [turns]; top: the speed of the last colour [m/s]. */
  draw(turn, top) {
    if (!this.run) return;
    const { canvas, run, balls, half, reach, recorded } = this;
    const sharp = window.devicePixelRatio || 1;
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(wide * sharp)) [canvas.width, canvas.height] = [Math.round(wide * sharp), Math.round(high * sharp)];
    const pen = canvas.getContext("2d");
    const scale = Math.min(wide / (2 * reach[0]), high / (2 * reach[1]));
    const to = (right, up) => [wide / 2 + scale * right, high / 2 - scale * up];
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    pen.clearRect(0, 0, wide, high);
    const place = ((turn / recorded.turns) * run.frames) % run.frames;
    const frame = Math.floor(place);
    // Between the last frame and the first nothing is known.
    const [next, part] = frame + 1 < run.frames ? [frame + 1, place - frame] : [frame, 0];
    const between = (values, ball) => {
      const [one, other] = [values[ball * run.frames + frame], values[ball * run.frames + next]];
      return one + part * (other - one);
    };
    const pose = run.poses[frame].map((value, i) => value + part * (run.poses[next][i] - value));
    this.drawJar(pen, to, scale, pose, half);
    const radius = (scale * run.condition.ball_diameter_mm) / run.condition.radius_mm / 2;
    const order = Array.from({ length: run.condition.number }, (_, ball) => ball);
    order.sort((one, other) => balls.near[one * run.frames + frame] - balls.near[other * run.frames + frame]);
    pen.lineWidth = Math.min(1, radius / 6);
    pen.strokeStyle = "rgba(31,35,40,.55)";
    for (const ball of order) {
      const [x, y] = to(between(balls.right, ball), between(balls.up, ball));
      const speed = (between(balls.speed, ball) / 255) * this.fastest;
      pen.fillStyle = SHADES[Math.round(32 * Math.min(1, speed / top))];
      pen.beginPath();
      pen.arc(x, y, Math.max(0.5, radius - pen.lineWidth / 2), 0, 2 * Math.PI);
      pen.fill();
      pen.stroke();
    }
  }

  drawJar(pen, to, scale, [x, y, angle], half) {
    pen.save();
    pen.translate(...to(x, y));
    pen.rotate(-angle);
    pen.fillStyle = GLASS;
    pen.strokeStyle = INK;
    pen.lineWidth = 2;
    pen.beginPath();
    if (this.recorded.outline === "round") {
      pen.arc(0, 0, scale, 0, 2 * Math.PI);
      // A mark on the jar shows how it turns.
      pen.moveTo(scale, 0);
      pen.lineTo(scale * 1.07, 0);
    } else {
      const [wide, high] = half.map((own) => own * scale);
      const rounding = ((this.run.condition.fillet_radius_mm ?? 0) / this.run.condition.radius_mm) * scale;
      pen.roundRect(-wide, -high, 2 * wide, 2 * high, rounding);
    }
    pen.fill();
    pen.stroke();
    pen.restore();
  }
}

/** The clock of both pictures: one factor of slow motion, so that the faster mill is seen to be faster. */
class Film {
  constructor(pictures, button, legend) {
    Object.assign(this, { pictures, button, legend, turns: pictures.map(() => 0), plays: false });
    button.addEventListener("click", () => this.play(!this.plays));
    this.play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    addEventListener("resize", () => this.draw());
  }

  play(plays) {
    this.plays = plays;
    this.button.textContent = plays ? "Pause the balls" : "Let the balls move";
    this.last = null;
    if (plays) requestAnimationFrame((now) => this.step(now));
  }

  /** Times that a second on the page is shorter in the mills. */
  get slower() {
    const speeds = this.pictures.filter((own) => own.run).map((own) => own.speed_hz);
    return speeds.length ? TURN_S * Math.min(...speeds) : 1;
  }

  get top() {
    return Math.max(...this.pictures.map((own) => own.fastest)) * 0.8 || 1;
  }

  step(now) {
    if (!this.plays) return;
    const passed = this.last === null ? 0 : Math.min(0.1, (now - this.last) / 1e3);
    this.last = now;
    this.turns = this.turns.map((turn, i) => turn + (passed / this.slower) * (this.pictures[i].speed_hz ?? 0));
    this.draw();
    requestAnimationFrame((then) => this.step(then));
  }

  draw() {
    this.pictures.forEach((picture, i) => picture.draw(this.turns[i], this.top));
  }

  /** After another condition: what colours and pace mean. */
  tell() {
    const factor = digits3(Math.max(this.slower, 1 / this.slower));
    const pace = factor === "1" ? "as fast as" : `${factor} times ${this.slower > 1 ? "slower" : "faster"} than`;
    this.legend.textContent = this.pictures.some((own) => own.run) ? `0 to ${digits(this.top)} m/s; shown ${pace} the mills.` : "";
    this.draw();
  }
}
