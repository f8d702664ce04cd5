/* What a search asks for, and the one verdict on it, as millprint.fingerprint.condition_search. */

const AGREES = "agrees";
const OPEN = "open";
const DIFFERS = "differs";
// How much more the descriptor counts that a user holds dear, as millprint.config.fingerprint.FIRST.
const HELD_DEAR = 100;
// Conditions whose distances differ less than this come equally near.
const EQUALLY_NEAR = 2;

/** The interval of the mean of very many simulations, which is what hours of milling are; null if it is not known. */
function meanOf({ further, lower, upper }) {
  const own = further?.mean ?? { lower, upper };
  return Number.isNaN(own.lower + own.upper) ? null : own;
}

/** one / other, with the interval of both; other may be a plain number. */
function ratioOf(one, other) {
  if (typeof other === "number") {
    const own = meanOf(one);
    return { value: one.value / other, interval: own && { lower: own.lower / other, upper: own.upper / other } };
  }
  const value = one.value / other.value;
  const [own, its] = [one, other].map(meanOf);
  if (!own || !its) return { value, interval: null };
  const below = Math.hypot(Math.log(one.value / own.lower), Math.log(its.upper / other.value));
  const above = Math.hypot(Math.log(own.upper / one.value), Math.log(other.value / its.lower));
  return { value, interval: { lower: value * Math.exp(-below), upper: value * Math.exp(above) } };
}

/** Whether a ratio is 1 to within `nearPercent`. */
function verdictOn({ interval }, nearPercent) {
  const factor = 1 + nearPercent / 100;
  if (!interval) return OPEN;
  if (interval.lower >= 1 / factor && interval.upper <= factor) return AGREES;
  return interval.lower > factor || interval.upper < 1 / factor ? DIFFERS : OPEN;
}

/** Power of the walls over the mass of the balls [W/kg], a band. */
function powerOfMass(prediction, { density_kg_m3, ball_diameter_m }) {
  return times(prediction.wall_power_W, 1 / (prediction.balls * density_kg_m3 * (Math.PI / 6) * ball_diameter_m ** 3));
}

class Target {
  /**
   * wanted: for each descriptor that is asked for, a band, or a number; power_W_kg: of the condition that it is to be
   * like; outside: variables of it that were not simulated; words: that condition in words; said: what stands with its
   * numbers; time_h, bpr: of it.
   */
  constructor(wanted, { power_W_kg = null, outside = [], words = "", said = [], time_h = null, bpr = null } = {}) {
    Object.assign(this, { wanted, power_W_kg, outside, words, said, time_h, bpr });
  }

  get asked() {
    return Object.keys(this.wanted);
  }

  /** The values that are asked for. */
  get values() {
    return Object.fromEntries(Object.entries(this.wanted).map(([name, own]) => [name, typeof own === "number" ? own : own.value]));
  }

  /** What a condition is to this target: ratios, time, verdicts of each and of the whole. */
  judge(condition, prediction, nearPercent) {
    const ratios = Object.fromEntries(this.asked.map((name) => [name, ratioOf(prediction[name], this.wanted[name])]));
    const isSimulated = !prediction.outside.length && !this.outside.length;
    const verdictOf = (name) => (isSimulated ? verdictOn(ratios[name], nearPercent) : OPEN);
    const verdicts = Object.fromEntries(this.asked.map((name) => [name, verdictOf(name)]));
    // Powder for a mass of balls: as in the wanted condition, where the condition has none.
    const more = (condition.bpr ?? this.bpr) / this.bpr;
    const time = this.power_W_kg && ratioOf(this.power_W_kg, times(powerOfMass(prediction, condition), more));
    const words = Object.values(verdicts);
    const verdict = [DIFFERS, OPEN].find((word) => words.includes(word)) ?? AGREES;
    return { ratios, verdicts, time, verdict };
  }
}

/** How near ratios come to 1: "within 30 %", or "within a factor of 2.1". */
function farthest(ratios) {
  const factor = Math.exp(Math.max(...Object.values(ratios).map(({ value }) => Math.abs(Math.log(value)))));
  return factor < 2 ? `within ${Math.ceil(100 * (factor - 1))} %` : `within a factor of ${Number(factor.toPrecision(2))}`;
}
