/* The settings of one's own mill that do most nearly what the paper's do: balls as sold, their number, the speed. */

// Numbers and speeds of the first look, for each size of balls; how often the search of number and speed halves.
const LOOK = 7;
const HALVED = 8;

/** Squared distance of the logarithms of what is to be alike; infinite where the atlas knows nothing or balls hardly hit. */
function distance(kind, condition, wanted) {
  if (kind.fault(condition)) return Infinity;
  const inputs = kind.inputs(kind.known(condition));
  if (kind.hits(inputs) < kind.limits.hits) return Infinity;
  const scale = Math.log(kind.scales(condition).energy);
  const fitted = kind.fittedAt(inputs);
  const own = alike((name) => COMBINED[name](fitted), scale);
  return own.reduce((sum, value, i) => sum + (value - wanted[i]) ** 2, 0);
}

/** Logarithms of what is to be alike: energies of hits and of shear, and normal over tangential power. How often they
    come is made up by time. */
function alike(log, scale = 0) {
  return [
    log("weighted_normal_energy_J") + scale,
    log("weighted_tangential_energy_J") + scale,
    log("normal_power_W") - log("tangential_power_W"),
  ];
}

/** The same of an estimate. */
const wantedOf = ({ known }) => alike((name) => Math.log(known[name].value));

/** The range of a setting that a group allows, the others kept. */
function rangeOf(kind, condition, name, groups) {
  const own = kind.ranges.find((group) => groups.includes(group.name));
  const value = kind.groups(condition)[own.name];
  return [own.low, own.high].map((end) => condition[name] * (end / value) ** DECIDING[own.name][1]);
}

/**
 * The nearest conditions of a kind, one for each size of balls that is sold, nearest first; speedsHz: the slowest and
 * the fastest of the mill.
 * Number and speed go up and down by ever smaller factors from the best of a first look.
 */
async function nearest(kind, condition, wanted, soldMm, speedsHz) {
  const found = [];
  for (const ball_diameter_mm of soldMm) {
    await new Promise((done) => setTimeout(done));
    const start = { ...condition, ball_diameter_mm, number: 1 };
    const [fewest, most] = rangeOf(kind, start, "number", ["fill"]);
    const [slowest, fastest] = rangeOf(kind, start, "speed_hz", ["froude", "critical"]);
    const counts = spaced(Math.max(1, fewest), Math.min(kind.limits.most_balls, most));
    const speeds = spaced(Math.max(slowest, speedsHz[0]), Math.min(fastest, speedsHz[1]));
    let best = { distance: Infinity };
    const look = (number, speed_hz) => {
      const own = { ...start, number: Math.round(number), speed_hz: within(speed_hz, speedsHz) };
      const far = distance(kind, own, wanted);
      if (far < best.distance) best = { condition: own, distance: far };
    };
    look(condition.number, condition.speed_hz);
    for (const number of counts) for (const speed of speeds) look(number, speed);
    if (best.distance === Infinity) continue;
    for (let i = 0, factor = 1.4; i < HALVED; i += 1, factor = Math.sqrt(factor)) {
      for (let moved = true; moved; ) {
        const { number, speed_hz } = best.condition;
        const before = best.distance;
        for (const [n, s] of [[factor, 1], [1 / factor, 1], [1, factor], [1, 1 / factor]]) look(number * n, speed_hz * s);
        moved = best.distance < before - 1e-9;
      }
    }
    const speed_hz = asSet(kind, best.condition.speed_hz, speedsHz);
    const condition_ = { ...best.condition, speed_hz };
    found.push({ condition: condition_, distance: distance(kind, condition_, wanted) });
  }
  return found.filter((own) => own.distance < Infinity).sort((one, other) => one.distance - other.distance);
}

/** A speed as a mill is set, and within its bounds: whole turns per minute, tenths of hertz. */
function asSet(kind, speedHz, speedsHz) {
  const steps = kind.perHertz * (kind.speedUnit === "Hz" ? 10 : 1);
  return within(Math.min(Math.round(speedHz * steps), Math.floor(speedsHz[1] * steps * (1 + 1e-9))) / steps, speedsHz);
}

const within = (value, [low, high]) => Math.min(Math.max(value, low), high);

/** Numbers at equal ratios. */
function spaced(low, high) {
  if (!(high >= low)) return [];
  return Array.from({ length: LOOK }, (_, i) => low * (high / low) ** (i / (LOOK - 1)));
}
