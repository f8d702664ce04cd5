/* Temperatures of balls, powder and jar over a milling programme: of a simulated condition, or at the power of the
   settings. The balance is linear, so that temperatures above the surroundings grow with the power. */

const BODIES = { balls: "#0072b2", powder: "#c2500a", jar: "#333" };
const BANDS = ["time_to_limit_h", "pause_needed_min"];

/** A time [h] with its band, each null where it is infinite: "30 min (24 min to never)". */
function timeWords([lower, median, upper], zero, infinite) {
  const words = (value) => (value === null ? infinite : value === 0 ? zero : durationWords(value));
  const [low, middle, high] = [lower, median, upper].map(words);
  return low === high ? middle : `${middle} (${low} to ${high})`;
}

/** A number between two, at a share of the way; where one of them is infinite, the second, which has more power. */
const along = (one, other, share) => (one === null || other === null ? other : one + share * (other - one));

class Heat {
  constructor(explorer) {
    this.explorer = explorer;
    this.chosen = NEAREST;
  }

  start() {
    byId("heat-condition").addEventListener("change", (event) => this.explorer.change(() => (this.chosen = event.target.value)));
  }

  get conditions() {
    return this.explorer.mill.content.heat?.conditions ?? [];
  }

  /** The power of the walls in a condition, as predicted. */
  powerOf(condition) {
    return this.explorer.fingerprint.predict(condition).wall_power_W.value;
  }

  /** The simulated conditions of this contact set with their powers, lowest first; calculated once for each. */
  byPower() {
    const { fingerprint } = this.explorer;
    if (this.known?.fingerprint !== fingerprint) {
      const own = this.conditions.filter((each) => each.contact === fingerprint.about.contact);
      const powers = (own.length ? own : this.conditions).map((each) => ({ condition: each, power: this.powerOf(each) }));
      this.known = { fingerprint, powers: powers.sort((one, other) => one.power - other.power) };
    }
    return this.known.powers;
  }

  /**
   * What is shown: a chosen condition as simulated; or the settings: the temperatures of the nearest condition, scaled to
   * the power of the settings, and limits between those of the conditions of less and of more power.
   */
  shown() {
    const chosen = this.conditions.find((each) => each.id === this.chosen);
    if (chosen) return { ...chosen, near: chosen, factor: 1 };
    const { fingerprint, state } = this.explorer;
    const power = this.powerOf(state);
    const powers = this.byPower();
    const [near] = byDistance(this.conditions, fingerprint.whole(state), fingerprint.about.contact);
    const above = powers.find((each) => each.power >= power) ?? powers.at(-1);
    const below = powers.findLast((each) => each.power <= power) ?? above;
    const share = above === below ? 1 : Math.log(power / below.power) / Math.log(above.power / below.power);
    const [one, other] = [below.condition, above.condition];
    const factor = power / this.powerOf(near);
    const scaled = (values) => values.map((value) => values[0] + factor * (value - values[0]));
    const courses = Object.entries(near.courses).map(([body, bands]) => [
      body,
      Object.fromEntries(Object.entries(bands).map(([end, values]) => [end, scaled(values)])),
    ]);
    return {
      ...near,
      near,
      factor,
      total_W: factor * near.total_W,
      courses: Object.fromEntries(courses),
      over_limit_share: along(one.over_limit_share, other.over_limit_share, share),
      ...Object.fromEntries(BANDS.map((name) => [name, one[name].map((value, i) => along(value, other[name][i], share))])),
    };
  }

  knows(id) {
    return id === NEAREST || this.conditions.some((each) => each.id === id);
  }

  render() {
    byId("heat").hidden = !this.conditions.length;
    if (byId("heat").hidden) return;
    if (!this.knows(this.chosen)) this.chosen = NEAREST;
    const { units, mill } = this.explorer;
    const found = this.shown();
    const { times_h: times_, probability, programme, limit_body: body } = mill.content.heat;
    fillOptions(byId("heat-condition"), [
      [NEAREST, "the settings, by their power"],
      ...this.conditions.map((each) => [each.id, conditionWords(each, units)]),
    ]);
    byId("heat-condition").value = this.chosen;
    const lines = Object.entries(BODIES).map(([name, colour]) => {
      const { lower, median, upper } = found.courses[name];
      return { name, colour, bands: median.map((value, i) => ({ value, lower: lower[i], upper: upper[i] })) };
    });
    const level = { value: found.limit_degC, name: `limit of the ${body}` };
    byId("heat-chart").replaceChildren(drawChart({ title: "Temperature [°C]", x: times_, label: "Time [h]", lines, level }));
    const pauses = programme.pause_min > 0 ? `pauses of ${short(programme.pause_min)} min every ${short(programme.cycle_min)} min` : "no pauses";
    const scaled =
      this.chosen === NEAREST
        ? `; from the simulation of ${conditionWords(found.near, units)}, ${powerText(found.near.total_W, units)}, times ${digits(found.factor)}`
        : "";
    const pause = found.pause_needed_min.map((minutes) => (minutes === null ? null : minutes / 60));
    const [surely] = found.time_to_limit_h;
    byId("heat-said").textContent =
      `${powerText(found.total_W, units)}, rolling included, with ${pauses}${scaled}. Shaded is the band of ${short(100 * probability)} %, due to unknown heat transfer and shares. ` +
      `Until the ${body} reaches ${short(found.limit_degC)} °C without a pause: ${timeWords(found.time_to_limit_h, "at once", "never")}. ` +
      `Pause after every ${short(found.milling_min)} min of milling that keeps this limit: ${timeWords(pause, "no pause needed", "no pause is long enough")}.` +
      (surely > 0 ? ` Mill for ${durationWords(surely)} at most between two pauses to be sure.` : "");
  }
}
