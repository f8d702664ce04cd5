/* The numbers of the chosen condition, and how they change with one setting. */

const NORMAL = "#0072b2";
const TANGENTIAL = "#c2500a";
const INK = "#333";
const POINTS = 41;

const NAMES = {
  charge: "Charge",
  amplitude_m: "Amplitude",
  normal_energy_uJ: "normal energy [µJ]",
  tangential_energy_uJ: "tangential energy [µJ]",
  specific_frequency_hz: "specific collision frequency [1/s]",
  tangential_share: "tangential share [-]",
  bpr: "ball-to-powder ratio",
  molar_ratio: "MgH₂ to borate",
  time_h: "milling time [h]",
};
/* The observables with the kind of their unit, or with unit and factor from SI. */
const KINDS = { J: { kind: "energy" }, "1/s": { kind: "frequency" }, "-": { unit: "%", factor: 100 } };
const RESULTS = Object.fromEntries(
  OBSERVABLES.map((own) => {
    const label = own.title[0].toUpperCase() + own.title.slice(1);
    return [own.name, { ...own, label, sign: own.symbol || own.title, ...(KINDS[own.unit] ?? { unit: own.unit, factor: 1 }) }];
  }),
);
/* Those by which conditions are matched. */
const DESCRIPTORS = Object.fromEntries(Object.entries(RESULTS).filter(([, { matched }]) => matched));
const LINES = { normal: NORMAL, tangential: TANGENTIAL, rolling: "#009e73" };

/** The unit of a result that fits a value in SI, and how to get to it. */
function unitOf({ kind, unit, factor }, units, value) {
  if (kind) return units.of(kind, value);
  if (!PREFIXED[unit]) return fixedUnit(unit, factor);
  const name = fitting(PREFIXED[unit], Object.keys(PREFIXED[unit]), value ?? 1);
  return fixedUnit(name, PREFIXED[unit][name]);
}
/** A power with its unit. */
function powerText(value, units) {
  const { unit, to } = unitOf(RESULTS.wall_power_W, units, value);
  return `${digits(to(value))} ${unit}`;
}
/** A band in a unit that is proportional to SI. */
const inUnit = (band, scale) => times(band, scale.to(1));
const between = ({ lower, upper }) => (Number.isNaN(lower + upper) ? "not known" : `${digits(lower)} to ${digits(upper)}`);
/** What stands with numbers of a mill where conditions were recorded for few turns; nothing for none. */
const fewTurnsWords = ({ about: { few_turns: few } }) =>
  few ? [`Few turns: ${few} of the simulated conditions were recorded for fewer than ${CONTENT.fewest_turns} independent turns, so that their scatter is hardly known.`] : [];
/** The name of a setting within a sentence. */
const nameOf = (name) => (SETTINGS[name]?.label ?? NAMES[name]).toLowerCase();

/** The settings that were not simulated, in words. */
const beyondOf = ({ outside }) => outside.filter((name) => name !== NO_IMPACTS).map(nameOf);
/** What stands with numbers where nothing hits. */
const noImpactsWords = ({ outside }) =>
  outside.includes(NO_IMPACTS) ? ["Nothing hits here, or in a simulated condition next to this one, so that hits are not known."] : [];

class Results {
  constructor(explorer) {
    this.explorer = explorer;
  }

  render(found) {
    byId("results").replaceChildren(...this.rows(found));
    byId("outside").textContent = this.warnings(found).join(" ");
    byId("compared").textContent = this.explorer.finder.compared(found);
    byId("brief").textContent = this.brief(found);
  }

  rows(found) {
    const { units, mill, fingerprint, state } = this.explorer;
    const item = (label, text, below, warn) => {
      const lines = [below].flat().map((line) => element("dd", { class: "interval" }, line));
      return element("div", warn ? { class: "warn" } : {}, element("dt", {}, label), element("dd", {}, text), ...lines);
    };
    const warn = found.outside.length > 0;
    const rows = Object.entries(RESULTS).map(([name, about]) => {
      const scale = unitOf(about, units, found[name].value);
      const band = inUnit(found[name], scale);
      const others = mill.further.map((origin) => {
        const interval = band.further[origin];
        const words = interval ? between(interval) : fingerprint.missing(origin, state.fill_ratio) || "not known";
        return `${mill.content.origins[origin].title}: ${words}`;
      });
      const below = [`${mill.content.origins.scatter.title}: ${between(band)}`, ...others];
      return item(about.label, `${digits(band.value)} ${scale.unit}`, below, warn);
    });
    const parts = ["normal", "tangential", "rolling"].map((name) => `${name} ${units.text("dose", found[`${name}_dose_J_kg`].value)}`);
    rows.push(
      item("Specific energy of the powder", units.text("dose", found.dose_J_kg.value), [
        parts.join(", "),
        `if all that is dissipated reached the powder, in ${timeText(state.time_h)}`,
      ], warn),
      item("Hits of the powder", `${digits(found.hits_per_g.value)} 1/g`, `in ${timeText(state.time_h)}`, warn),
      item("Acceleration of the wall", this.acceleration(), "largest of any point", false),
    );
    const { value, lower, upper, outside = [] } = found.yield_percent ?? {};
    if (found.yield_percent) {
      const about = `${digits(lower)} to ${digits(upper)}${outside.length ? ", extrapolated" : ""}`;
      rows.push(item("Yield to expect", `${digits(value)} %`, about, outside.length + found.outside.length > 0));
    }
    rows.push(item("To weigh in", `${digits(found.powder_g)} g of powder`, `with ${found.balls} balls of ${digits(found.balls_g)} g in all`, false));
    return rows;
  }

  acceleration() {
    const { acceleration } = this.explorer.units;
    return acceleration > 0 ? `${digits(acceleration * this.explorer.state.speed_hz ** 2)} g` : "–";
  }

  /** The line at the foot of a phone. */
  brief(found) {
    const { units } = this.explorer;
    const { value, outside = [] } = found.yield_percent ?? {};
    return [
      ...this.explorer.content.descriptors.map((name) => `${DESCRIPTORS[name].sign} ${units.text(DESCRIPTORS[name].kind, found[name].value)}`),
      powerText(found.wall_power_W.value, units),
      ...(found.yield_percent ? [`yield ${digits(value, 2)} %${outside.length ? " ?" : ""}`] : []),
    ].join(" · ");
  }

  warnings(found) {
    const said = [];
    const beyond = beyondOf(found);
    if (beyond.length) said.push(`Not simulated: ${beyond.join(", ")}. The scaling laws extrapolate, with a wider interval.`);
    said.push(...noImpactsWords(found));
    said.push(...fewTurnsWords(this.explorer.fingerprint));
    const outside = found.yield_percent?.outside ?? [];
    if (outside.length) {
      const names = outside.map((each) => `${NAMES[each.name]} ${digits(each.value)}, trained ${digits(each.low)} to ${digits(each.high)}`);
      said.push(`The yield model was not trained there: ${names.join("; ")}.`);
    }
    return said;
  }

  /** A band with the ends of the interval that the charts show; NaN where it is not known. */
  shade(band) {
    const { shaded } = this.explorer;
    if (shaded === "scatter") return band;
    const { lower = NaN, upper = NaN } = band.further[shaded] ?? {};
    return { ...band, lower, upper };
  }

  renderCharts(found) {
    const { explorer } = this;
    const { axis: name, units, mill } = explorer;
    const { low, high, to, from, unit } = explorer.controls.scaleOf(name);
    const { label } = { ...SETTINGS, ...POWDER }[name];
    // With both sides of the condition among the points: a yield is trained in a narrow range. At the condition itself
    // there may be a simulation, which need not lie on the curve.
    const here = to(explorer.state[name]);
    const near = [-1e-3, 1e-3].map((by) => clamp(here + by * (high - low), [low, high]));
    const x = [...new Set([...linspace(low, high, POINTS), ...near])].sort((one, other) => one - other);
    const answers = x.map((value) => explorer.answer({ ...explorer.state, [name]: from(value) }));
    const line = (key, named, colour, scale) => ({
      name: named,
      colour,
      bands: answers.map((answer) => (key === "yield_percent" ? answer[key] : this.shade(times(answer[key], scale)))),
      now: times(found[key], scale),
      dashed: key === "yield_percent" ? answers.map((answer) => answer[key].outside.length > 0) : null,
    });
    const panels = Map.groupBy(Object.entries(RESULTS).filter(([, { panel }]) => panel), ([, { panel }]) => panel);
    const charts = [...panels].map(([panel, shown]) => {
      const drawn = (scale) => shown.map(([key, { line: named }]) => line(key, named, LINES[named] ?? INK, scale));
      const top = topOf(drawn(1));
      const { unit: inside, to: into } = unitOf(shown[0][1], units, top);
      if (inside === "%") return { title: `${panel} [%]`, lines: drawn(into(1)), top: 100 };
      const power = thousands(into(top));
      const title = `${panel} [${power ? `${powerOfTen(power)} ` : ""}${inside}]`;
      return { title, lines: drawn(into(10 ** -power)) };
    });
    if (found.yield_percent) charts.push({ title: "Yield [%]", lines: [line("yield_percent", "yield", INK, 1)], top: 100 });
    const known = mill.known(name, explorer.fingerprint, explorer.state.charge)?.map(to);
    const shared = { x, label: withUnit(label, unit), known, at: here };
    byId("charts").replaceChildren(...charts.map((chart) => drawChart({ ...chart, ...shared })));
  }
}
