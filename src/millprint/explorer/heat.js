/* Temperatures of balls, powder and jar over a milling programme, for the simulated condition nearest to the sliders. */

const BODIES = { balls: "#c2500a", powder: "#333", jar: "#0072b2" };

/** A time with its band, each null where it is infinite: "0.5 h (0.4 to never)". */
function timeWords([lower, median, upper], unit, zero, infinite) {
  const words = (value) => (value === null ? infinite : value === 0 ? zero : `${digits(value)} ${unit}`);
  const [low, middle, high] = [lower, median, upper].map(words);
  return low === high ? middle : `${middle} (${low} to ${high})`;
}

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

  /** The condition that is shown. */
  condition() {
    const { state, mill, contact } = this.explorer;
    const chosen = this.conditions.find((each) => each.id === this.chosen);
    return chosen ?? byDistance(this.conditions, state, mill.fingerprints[contact].about.contact)[0];
  }

  knows(id) {
    return id === NEAREST || this.conditions.some((each) => each.id === id);
  }

  render() {
    byId("heat").hidden = !this.conditions.length;
    if (byId("heat").hidden) return;
    if (!this.knows(this.chosen)) this.chosen = NEAREST;
    const { units, mill } = this.explorer;
    const found = this.condition();
    const { times_h: times_, probability, programme, limit_body: body } = mill.content.heat;
    const near = this.chosen === NEAREST ? `: ${conditionWords(found, units)}` : "";
    fillOptions(byId("heat-condition"), [
      [NEAREST, `nearest to the settings${near}`],
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
    byId("heat-said").textContent =
      `${digits(found.total_W)} W, with ${pauses}; shaded is the band of ${short(100 * probability)} %, due to unknown heat transfer and shares. ` +
      `Until the ${body} reaches ${short(found.limit_degC)} °C without a pause: ${timeWords(found.time_to_limit_h, "h", "at once", "never")}. ` +
      `Pause after every ${short(found.milling_min)} min of milling that keeps this limit: ${timeWords(found.pause_needed_min, "min", "none", "none is long enough")}.`;
  }
}
