/* The atlas as millprint.atlas.model and millprint.atlas.estimate_mill: groups, refusals, numbers with intervals. */

/** A kind of mills, its words from CONTENT and its formulas from FORMULAS. */
class Kind {
  constructor(name, { settings, limits, models, kinds, fitted, predicted, marks }) {
    Object.assign(this, { name, limits, fitted, predicted, marks }, kinds[name], FORMULAS[name]);
    this.model = models[name];
    this.about = this.model.about;
    this.settings = Object.fromEntries([...this.dimensions, ...settings].map((own) => [own.name, own]));
    // Per hertz: one turn a minute is a sixtieth.
    this.perHertz = this.speed_unit === "hz" ? 1 : 60;
    this.speedUnit = this.speed_unit === "hz" ? "Hz" : "rpm";
    this.surfaces = Object.fromEntries(
      Object.entries({ ...this.model.surfaces, hits: this.model.hits }).map(([key, own]) => [key, new Surface(own, this.model.centres)]),
    );
  }

  /** What is wrong with a condition, in a line, and which setting it is about; null where the atlas knows it. */
  fault(condition) {
    const { number, ball_diameter_mm: ball, radius_mm: radius, height_mm: height, fillet_radius_mm: fillet = 0 } = condition;
    const refuse = (name, text) => ({ name, text });
    if (!(number >= 1)) return refuse("number", `${short(number)} balls are less than one ball.`);
    const opening = Math.min(2 * radius, height);
    if (ball >= opening) {
      return refuse("ball_diameter_mm", `A ball of ${digits3(ball)} mm does not go into a jar of ${digits3(opening)} mm.`);
    }
    if (fillet > radius || this.ends * fillet > height) {
      return refuse("fillet_radius_mm", `A rounding of ${digits3(fillet)} mm does not fit the jar's radius of ${digits3(radius)} mm.`);
    }
    const groups = this.groups(condition);
    const { packed, beyond, stiffness, most_balls: mostBalls } = this.limits;
    if (groups.fill > packed) {
      const most = Math.floor((number * packed) / groups.fill);
      return refuse("number", `The jar cannot hold ${short(number)} balls of ${digits3(ball)} mm: it is full with about ${most}.`);
    }
    if (groups.critical >= 1) {
      const fastest = digits3((this.perHertz * condition.speed_hz) / groups.critical);
      return refuse("speed_hz", `A ball that does not slide goes round with the wall: the drum is beyond its critical speed of ${fastest} ${this.speedUnit}.`);
    }
    if (groups.turns <= 0) {
      return refuse("ratio", "Jars of the atlas turn against the wheel: write -2 for what makers print as 1:-2 or 1:2.");
    }
    // Last of all the fill ratio, which other faults decide.
    const last = (group) => group.name === "fill";
    for (const group of [...this.ranges].sort((one, other) => last(one) - last(other))) {
      const value = groups[group.name];
      const share = value > 0 || !group.logarithmic ? shareOf(group, value) : -Infinity;
      if (group.name !== stiffness && !(share >= -beyond && share <= 1 + beyond)) return this.outside(condition, group, value);
    }
    const beyondBound = this.bounded(groups).findIndex((value, i) => value > this.bounds[i].most);
    if (beyondBound >= 0) {
      const { formula, reason, most } = this.bounds[beyondBound];
      const value = digits3(this.bounded(groups)[beyondBound]);
      return refuse("ratio", `${formula} is ${value}: ${reason}; the atlas knows up to ${short(most)}. For others, simulate: millprint card.`);
    }
    if (number > mostBalls) return refuse("number", `The atlas knows up to ${mostBalls} balls, not ${short(number)}.`);
    return null;
  }

  /** The line for a group out of its range: what a setting may be, where one setting decides. */
  outside(condition, group, value) {
    const ask = "For others, simulate: millprint card.";
    const [name, power] = DECIDING[group.name] ?? [null, 1];
    if (name === null) {
      const range = `${digits3(group.low)} to ${digits3(group.high)}`;
      return { name: this.dimensionOf(group), text: `${group.symbol} is ${digits3(value)}; the atlas knows ${range}. ${ask}` };
    }
    const [low, high] = [group.low, group.high].map((end) => condition[name] * (end / value) ** power);
    const { shown, unit } = this.shownSetting(name);
    const whole = [Math.max(1, Math.ceil(low)), Math.min(this.limits.most_balls, Math.floor(high))];
    const bounds = name === "number" ? whole : [shown(low), shown(high)].map((own) => digits3(own));
    const here = `${capital(PLAIN[name])}: ${digits3(shown(condition[name]))}${unit && ` ${unit}`}`;
    return { name, text: `${here}; here the atlas knows ${bounds.join(" to ")}${unit && ` ${unit}`}. ${ask}` };
  }

  /** A dimension that a group is made of. */
  dimensionOf(group) {
    const text = group.name;
    const names = { height: "height_mm", length: "height_mm", rounding: "fillet_radius_mm", jar: "sun_radius_mm", turns: "ratio" };
    const more = { stroke: "stroke_mm", arc: this.settings.arm_mm ? "arm_mm" : "arc_radius_mm", sideways: "sideways_mm" };
    return { ...names, ...more }[text] ?? text;
  }

  /** How a setting is shown: its unit and the conversion from SI or mm. */
  shownSetting(name) {
    if (name === "speed_hz" || name === "fastest_hz") {
      return { unit: this.speedUnit, shown: (value) => value * this.perHertz, set: (value) => value / this.perHertz };
    }
    if (name === "density_kg_m3") return { unit: "g/cm³", shown: (value) => value / 1e3, set: (value) => value * 1e3 };
    const unit = name.endsWith("_mm") ? "mm" : name.endsWith("_gpa") ? "GPa" : "";
    return { unit, shown: (value) => value, set: (value) => value };
  }

  /** The inputs of the model at some groups. */
  inputs(groups) {
    return [...this.ranges.map((group) => shareOf(group, groups[group.name])), ...this.derived(groups)];
  }

  /** Groups with the stiffness in its range. */
  known(condition) {
    const groups = this.groups(condition);
    const { low, high, name } = this.stiffness;
    groups[name] = Math.min(Math.max(groups[name], low), high);
    return groups;
  }

  get stiffness() {
    return this.ranges.find((group) => group.name === this.limits.stiffness);
  }

  /** Whether the stiffness of the balls is out of its range, so that its end is taken. */
  isBeyondStiffness(condition) {
    const { low, high, name } = this.stiffness;
    const value = this.groups(condition)[name];
    return value < low || value > high;
  }

  /** Logarithms of what is fitted over its scales, each calculated once it is asked for. */
  fittedAt(inputs) {
    const completed = [...inputs, this.hits(inputs) > this.limits.hits ? 1 : 0];
    const found = {};
    for (const name of this.fitted) {
      let value;
      Object.defineProperty(found, name, { get: () => (value ??= this.surfaces[name].at(completed)) });
    }
    return found;
  }

  /** The answer of the atlas for a condition: numbers with the ends of their intervals, the probability of hits, and the
      numbers that are to be simulated, since a larger error than the mark is to be expected. */
  estimate(condition) {
    const inputs = this.inputs(this.known(condition));
    const scales = this.scales(condition);
    const fitted = this.fittedAt(inputs);
    const known = {};
    const unsure = [];
    for (const [name, scale] of Object.entries(this.predicted)) {
      const { linear, factor, median } = this.model.widths[name];
      const half = factor * Math.exp(linearAt(linear, inputs));
      const log = COMBINED[name](fitted);
      const [lower, value, upper] = [-1, 0, 1].map((side) => scales[scale] * Math.exp(log + side * half));
      known[name] = { value, lower, upper };
      if ((median / factor) * half > this.marks[name]) unsure.push(name);
    }
    return { known, unsure, hits: this.hits(inputs) };
  }

  /** The probability that balls hit something. */
  hits(inputs) {
    return 1 / (1 + Math.exp(-this.surfaces.hits.at(inputs)));
  }
}

// The setting that decides a group, and the power of the group that it grows with.
const DECIDING = {
  fill: ["number", 1],
  ball: ["ball_diameter_mm", 1],
  froude: ["speed_hz", 0.5],
  critical: ["speed_hz", 1],
  restitution: ["restitution", 1],
  static_friction: ["static_friction", 1],
  wall_static_friction: ["wall_static_friction", 1],
  rolling_friction: ["rolling_friction", 1],
};
const PLAIN = {
  number: "number of balls",
  ball_diameter_mm: "diameter of the balls",
  speed_hz: "speed",
  density_kg_m3: "density of the balls",
  restitution: "restitution",
  static_friction: "friction between balls",
  wall_static_friction: "friction at the wall",
  rolling_friction: "rolling friction",
  young_modulus_gpa: "Young's modulus in the simulation",
};
// A title within a sentence; letters that stand for words stay.
const small = (text) => (/^[A-Z]{2}/.test(text) ? text : text[0].toLowerCase() + text.slice(1));
const capital = (text) => text[0].toUpperCase() + text.slice(1);
const digits3 = (value) => short(Number(value.toPrecision(3)));

/** The share of its range at which the value of a group lies. */
function shareOf({ low, high, logarithmic }, value) {
  return logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
}

/** A constant, and a slope for each of the first inputs. */
function linearAt(linear, inputs) {
  let sum = linear[0];
  for (let i = 1; i < linear.length; i += 1) sum += linear[i] * inputs[i - 1];
  return sum;
}

/** A fitted number over the inputs: linear, and Matern's covariance of smoothness 5/2 with each simulation. */
class Surface {
  constructor({ linear, lengths, weights, rows }, centres) {
    Object.assign(this, { linear, lengths, weights });
    this.width = lengths.length;
    // Only the first inputs count, as many as there are lengths.
    this.places = Float64Array.from(rows.flatMap((row) => lengths.map((length, j) => centres[row][j] / length)));
  }

  at(inputs) {
    const { places, weights, width } = this;
    const own = this.lengths.map((length, j) => inputs[j] / length);
    let sum = linearAt(this.linear, inputs);
    for (let i = 0, k = 0; i < weights.length; i += 1) {
      let squared = 0;
      for (let j = 0; j < width; j += 1, k += 1) squared += (own[j] - places[k]) ** 2;
      const z = Math.sqrt(5 * squared);
      sum += weights[i] * (1 + z + (z * z) / 3) * Math.exp(-z);
    }
    return sum;
  }
}
