/* Energy spectra of two simulated conditions over each other. */

const CHANNELS = { normal: "normal", tangential: "tangential" };
const PAIRS = { ball_ball: "ball on ball", ball_wall: "ball on wall", both: "both" };
const FIRST = "#0072b2";
const SECOND = "#c2500a";
/* The quantities over the energy: per bin, or the share above an energy. */
const SHOWN = {
  bins: { label: "collisions per second and power of each bin", titles: { collisions_hz: "Collisions per bin [1/s]", power_W: "Power per bin [W]" } },
  above: { label: "share above an energy", titles: { collisions_hz: "Collisions above [-]", power_W: "Power above [-]" } },
};
// The value of a choice that follows the sliders.
const NEAREST = "";

/** The steps of a spectrum: its bins except the open ones, with their content, or the share in the bin and above. */
function spectrumSteps(bins, quantity, edges, isShare) {
  const values = bins[quantity];
  const total = values.reduce((sum, value) => sum + value, 0);
  let above = 0;
  const shares = [...values].reverse().map((value) => (above += value) / total).reverse();
  return (isShare && total ? shares : values)
    .map((value, i) => ({ low: edges[bins.first + i - 1], high: edges[bins.first + i], value }))
    .filter(({ low, high }) => low !== undefined && high !== undefined);
}

class Spectra {
  constructor(explorer) {
    this.explorer = explorer;
    this.shown = "bins";
    this.chosen = [NEAREST, NEAREST];
    this.all = explorer.mills.flatMap((mill) =>
      (mill.content.spectra?.conditions ?? []).map((each) => ({ ...each, mill, key: `${mill.name}/${each.id}` })),
    );
  }

  start() {
    fillOptions(byId("spectra-shown"), Object.entries(SHOWN).map(([name, { label }]) => [name, label]));
    byId("spectra-shown").addEventListener("change", (event) => this.explorer.change(() => (this.shown = event.target.value)));
    [0, 1].forEach((k) => {
      byId(`spectra-${k}`).addEventListener("change", (event) => this.explorer.change(() => (this.chosen[k] = event.target.value)));
    });
  }

  /** The two conditions: chosen ones, or conditions that follow the sliders. */
  pair() {
    const { mill, state, fingerprint } = this.explorer;
    const own = this.all.filter((each) => each.mill === mill);
    const nearest = own.length ? nearestTwo(own, fingerprint.whole(state), fingerprint.about.contact) : [];
    return this.chosen.map((key, k) => this.all.find((each) => each.key === key) ?? nearest[k]);
  }

  /** Whether a key names a condition, or none. */
  knows(key) {
    return key === NEAREST || this.all.some((each) => each.key === key);
  }

  buildChoices() {
    const { explorer } = this;
    const groups = explorer.mills.map((mill) => ({
      label: mill.content.title,
      options: this.all.filter((each) => each.mill === mill).map((each) => [each.key, conditionWords(each, explorer.unitsOf(mill))]),
    }));
    const options = groups.filter((group) => group.options.length);
    [0, 1].forEach((k) => {
      // The key below names the conditions.
      fillOptions(byId(`spectra-${k}`), [[NEAREST, k ? "one to compare" : "nearest to the settings"], ...options]);
      byId(`spectra-${k}`).value = this.chosen[k];
    });
    byId("spectra-shown").value = this.shown;
  }

  render() {
    const has = this.explorer.mill.content.spectra?.conditions.length > 0;
    byId("spectra").hidden = !has && this.chosen.every((key) => key === NEAREST);
    if (byId("spectra").hidden) return;
    this.buildChoices();
    const pair = this.pair();
    const named = pair.map((each, k) => each && { each, colour: [FIRST, SECOND][k], words: this.words(each) }).filter(Boolean);
    byId("spectra-key").replaceChildren(
      ...named.map(({ colour, words }) => element("li", {}, element("span", { style: `background: ${colour}` }), words)),
      element("li", {}, "solid: ball on ball; dashed: ball on wall; vertical: half of the power is above this energy"),
    );
    byId("spectra-charts").replaceChildren(...this.charts(named));
    this.renderTable(named);
  }

  words(condition) {
    const { explorer } = this;
    const of = condition.mill === explorer.mill ? "" : `${condition.mill.content.title}: `;
    return `${of}${conditionWords(condition, explorer.unitsOf(condition.mill))}`;
  }

  charts(named) {
    const { unit, to } = this.explorer.units.of("energy");
    const isShare = this.shown === "above";
    return Object.entries(SHOWN[this.shown].titles).flatMap(([quantity, title]) =>
      Object.keys(CHANNELS).map((channel) =>
        drawLogChart({
          title,
          label: `${CHANNELS[channel]} energy [${unit}]`,
          share: isShare,
          marks: named
            .map(({ each, colour, words }) => ({ at: to(each.read_off[channel].both?.half_power_J ?? NaN), colour, name: `half of the power above, ${words}` }))
            .filter(({ at }) => at > 0),
          lines: named.flatMap(({ each, colour, words }) =>
            ["ball_ball", "ball_wall"].map((pair) => ({
              name: `${words}, ${PAIRS[pair]}`,
              colour,
              dashed: pair === "ball_wall",
              steps: spectrumSteps(each.bins[channel][pair], quantity, each.mill.content.spectra.edges.map(to), isShare),
            })),
          ),
        }),
      ),
    );
  }

  renderTable(named) {
    const { units } = this.explorer;
    const head = ["energy, between", "collisions [1/s]", "power", "mean", "median", "half of the power above"];
    byId("spectra-table").tHead.replaceChildren(element("tr", {}, ...head.map((text) => element("th", { scope: "col" }, text))));
    const row = (read, name) => {
      const energies = [read.mean_J, read.median_J, read.half_power_J].map((value) => units.text("energy", value ?? NaN));
      const cells = [digits(read.collisions_hz ?? NaN), powerText(read.power_W ?? NaN, units), ...energies];
      return element("tr", {}, element("th", { scope: "row" }, name), ...cells.map((text) => element("td", {}, text)));
    };
    const rows = named.flatMap(({ each, words }) => [
      element("tr", {}, element("th", { scope: "rowgroup", colspan: head.length }, words)),
      ...Object.keys(CHANNELS).flatMap((channel) =>
        Object.entries(PAIRS).map(([pair, between]) => row(each.read_off[channel][pair], `${channel}, ${between}`)),
      ),
    ]);
    byId("spectra-table").tBodies[0].replaceChildren(...rows);
  }
}
