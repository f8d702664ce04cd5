/* The inverse search: conditions of the shown mill that do what a wanted condition does, or have wanted descriptors. */

/* A condition is at the end of a range if it is as near as this, as a fraction of it. */
const AT_LIMIT = 2e-3;
// Balls up to this factor outside of the simulated sizes may be proposed, if they come nearer by the other.
const OTHER_SIZES = 2;
const NEARER = 0.5;
const VERDICTS = { [AGREES]: "Met", [OPEN]: "Not known", [DIFFERS]: "Not met" };

class Finder {
  constructor(explorer) {
    this.explorer = explorer;
    // What is asked for, in SI, which stays when another mill is chosen, unless it is still the initial one.
    this.target = new Target({});
    this.given = false;
    // The unit of each field.
    this.units = {};
  }

  start() {
    for (const [name, { label }] of Object.entries(DESCRIPTORS)) {
      const field = element("input", { type: "number", id: `target-${name}`, min: 0, step: "any" });
      field.addEventListener("change", () => this.read(name, field.value));
      const unit = element("span", { id: `target-${name}-unit` });
      byId("targets").append(element("p", {}, element("label", { for: field.id }, label), element("span", {}, field, " ", unit)));
    }
    byId("take").addEventListener("click", () => {
      this.take();
      this.renderFields();
    });
    byId("find-other").addEventListener("click", () => this.findOn(byId("other").value));
    byId("search").addEventListener("submit", (event) => {
      event.preventDefault();
      this.show();
    });
  }

  /** The descriptors that a search for a condition asks for: energies, and frequencies if these are to be equal too. */
  get asked() {
    return this.explorer.content.descriptors.filter((name) => DESCRIPTORS[name].unit === "J" || byId("equal").checked);
  }

  /** Take what the shown condition does for the target. */
  take() {
    const { explorer } = this;
    const { state, mill } = explorer;
    const found = explorer.answer(state);
    this.target = new Target(Object.fromEntries(this.asked.map((name) => [name, found[name]])), {
      power_W_kg: powerOfMass(found, state),
      outside: found.outside,
      time_h: state.time_h,
      bpr: state.bpr,
      words: `${mill.content.title}, ${explorer.conditionText(state)}`,
    });
    this.given = true;
  }

  /** Search for the shown condition on another mill, and show that mill in the condition that was found. */
  async findOn(name) {
    const { explorer } = this;
    this.take();
    explorer.change(() => explorer.useMill(explorer.mills.find((mill) => mill.name === name)));
    const rows = await this.show();
    if (rows.length) this.use(rows[0]);
    byId("answer").scrollIntoView({ block: "start" });
  }

  read(name, text) {
    const value = this.units[name].from(Number(text));
    const { [name]: _, ...others } = this.target.wanted;
    // A number of the user's is of no condition, which would have a power.
    this.target = new Target(value > 0 ? { ...others, [name]: value } : others);
    this.given = true;
  }

  /** The fields for another mill; the last search is not valid any more. */
  build() {
    const { mill, mills, content } = this.explorer;
    const { search } = mill.content;
    const others = mills.filter((each) => each !== mill);
    fillOptions(byId("other"), others.map((each) => [each.name, each.content.title]));
    byId("elsewhere").hidden = others.length === 0;
    const first = byId("first").value;
    fillOptions(byId("first"), [["", "all alike"], ...content.descriptors.map((name) => [name, DESCRIPTORS[name].sign])]);
    byId("first").value = first;
    if (!this.given) this.target = new Target({ ...Object.values(search.targets)[0] });
    byId("answer").hidden = true;
    this.matched = null;
    byId("searching").textContent = "";
    this.renderFields();
  }

  renderFields() {
    const { values } = this.target;
    for (const [name, own] of Object.entries(DESCRIPTORS)) {
      this.units[name] = unitOf(own, this.explorer.units, values[name]);
      const { unit, to } = this.units[name];
      byId(`target-${name}`).value = name in values ? short(Number(to(values[name]).toPrecision(4))) : "";
      byId(`target-${name}-unit`).textContent = unit;
    }
  }

  /** Search, and show what was found; returns the rows, the best first. */
  async show() {
    const [button, said, table] = ["find", "searching", "found"].map(byId);
    const { mill, content } = this.explorer;
    const { target } = this;
    const chosen = byId("first").value;
    const first = chosen in target.wanted ? chosen : null;
    byId("answer").hidden = false;
    byId("wanted").textContent = target.words ? `Wanted: what ${target.words} does.` : "";
    byId("choices").replaceChildren();
    table.hidden = true;
    if (!target.asked.some((name) => mill.content.search.weights[name] > 0)) {
      said.textContent = "Give at least one descriptor.";
      return [];
    }
    button.disabled = true;
    said.textContent = "Searching …";
    // The browser draws and answers between two kinds of balls.
    const breathe = () => new Promise((resolve) => setTimeout(resolve));
    const rows = await mill.search(target, { first, breathe });
    if (!rows.length) {
      said.textContent = "None of the possible fill ratios was simulated.";
    } else {
      const best = rows.findIndex(({ verdict }) => verdict === AGREES);
      if (best > 0) rows.unshift(...rows.splice(best, 1));
      said.textContent = this.verdict(rows[0], target);
      const choices = rows[0].verdict === DIFFERS ? await this.choices(rows[0], target, breathe) : [];
      if (mill !== this.explorer.mill) return [];
      byId("choices").replaceChildren(...choices.map((text) => element("li", {}, text)));
    }
    button.disabled = false;
    if (mill !== this.explorer.mill) return [];
    const [head] = table.tHead.rows;
    head.querySelectorAll(".target").forEach((cell) => cell.remove());
    const titles = this.shown(target).map((name) => element("th", { scope: "col", class: "target" }, DESCRIPTORS[name].sign));
    if (target.power_W_kg) titles.push(element("th", { scope: "col", class: "target" }, "time"));
    byId("found-speed").after(...titles);
    byId("found-contact").hidden = this.explorer.fingerprints.length === 1;
    byId("found-outside").hidden = rows.every(({ prediction }) => prediction.outside.length === 0);
    byId("found-speed").textContent = withUnit("speed", this.explorer.units.of("speed").unit);
    table.tBodies[0].replaceChildren(...rows.map((row) => this.row(row, target)));
    table.hidden = rows.length === 0;
    return rows;
  }

  /** The descriptors that a target names, in their order. */
  shown(target) {
    return Object.keys(DESCRIPTORS).filter((name) => name in target.wanted);
  }

  /** "E*n 1.02 times (0.91 to 1.14)" for each of some descriptors. */
  ratioWords(row, names) {
    return names
      .map((name) => {
        const { value, interval } = row.ratios[name];
        const met = row.verdicts[name] === AGREES ? " met," : "";
        return `${DESCRIPTORS[name].sign}${met} ${value.toFixed(2)} times (${rangeText(interval)})`;
      })
      .join(", ");
  }

  /** A sentence on the nearest condition: the verdict, what was found over what was wanted, limits, and the time. */
  verdict(row, target) {
    const { mill } = this.explorer;
    const { condition, ratios, verdict, time } = row;
    const near = verdict === AGREES ? "" : `; the nearest, ${farthest(ratios)}`;
    const said = [`${VERDICTS[verdict]}${near}: ${this.explorer.conditionText(condition)}: ${this.ratioWords(row, this.shown(target))}.`];
    const { speeds_rpm: speeds, fill_ratios: fills } = mill.content.search;
    const ends = [
      [speeds.map((speed) => speed / 60), condition.speed_hz, "speed"],
      [fills, condition.fill_ratio, "fill ratio"],
    ].flatMap(([[low, high], value, name]) => [[low, "lowest"], [high, "highest"]]
      .filter(([end]) => low < high && Math.abs(value / end - 1) < AT_LIMIT)
      .map(([, word]) => `the ${word} ${name}`));
    if (verdict === DIFFERS && ends.length) said.push(`It is at ${listed(ends)} that was searched.`);
    if (row.prediction.outside.length) said.push(`Not simulated: ${row.prediction.outside.map(nameOf).join(", ")}.`);
    if (target.outside.length) said.push(`The wanted condition itself was not simulated: ${target.outside.map(nameOf).join(", ")}.`);
    if (time) {
      const [here, ...range] = [time.value, ...(time.interval ? [time.interval.lower, time.interval.upper] : [])].map((ratio) => digits(target.time_h * ratio));
      said.push(`${short(target.time_h)} h there is ${here} h here (${range.length ? range.join(" to ") : "not known"}) for the same energy per gram of powder.`);
    }
    return said.join(" ");
  }

  /** What else to choose where not all can be met: one of the energies, with what it costs the others, or other balls. */
  async choices(best, target, breathe) {
    const { explorer } = this;
    const { mill } = explorer;
    const found = [];
    const told = new Set([explorer.conditionText(best.condition)]);
    for (const name of this.shown(target).filter((each) => DESCRIPTORS[each].unit === "J" && target.asked.length > 1)) {
      const [row] = await mill.search(target, { first: name, breathe });
      const place = explorer.conditionText(row.condition);
      if (row.verdicts[name] !== AGREES || told.has(place)) continue;
      told.add(place);
      const others = this.shown(target).filter((other) => other !== name);
      found.push(`or ${this.ratioWords(row, [name, ...others])}: ${place}`);
    }
    const [low, high] = best.fingerprint.range("ball_diameter_m").map((size) => 1e3 * size);
    const sizes = explorer.content.sold_mm.filter((size) => size >= low / OTHER_SIZES && size <= OTHER_SIZES * high);
    const balls = sizes.filter((size) => size < low || size > high);
    const [row] = balls.length ? await mill.search(target, { balls, breathe }) : [];
    if (row && row.distance < NEARER * best.distance) {
      found.push(`or other balls, ${farthest(row.ratios)} by the scaling of the curves: ${explorer.conditionText(row.condition)}; simulate them first`);
    }
    return found;
  }

  /** Show a condition that was found, with the time for the same dose, and keep what it was matched to for the methods text. */
  use({ fingerprint, condition, ...row }) {
    const { explorer, target } = this;
    this.matched = { target, condition, row };
    if (row.time) {
      const [shortest, longest] = explorer.mill.reach("time_h");
      const time = Number((target.time_h * row.time.value).toPrecision(3));
      Object.assign(explorer.state, { time_h: clamp(time, [shortest, longest]), bpr: clamp(target.bpr, explorer.mill.reach("bpr")) });
    }
    explorer.use(fingerprint, condition);
  }

  /** Sentences for the methods text, if a search has found the shown condition for one of another mill. */
  matchedWords() {
    const { matched, explorer } = this;
    if (!matched?.target.words || Object.keys(SETTINGS).some((name) => explorer.state[name] !== matched.condition[name])) return [];
    const { row, target } = matched;
    return [
      `These settings were chosen to do what ${target.words} does: ${this.ratioWords(row, this.shown(target))}, with the interval of the mean of very many simulations of both.`,
      ...(row.time ? [`The same energy per gram of powder takes ${digits(row.time.value)} times as long, at the same ball-to-powder ratio.`] : []),
    ];
  }

  row(found, target) {
    const { fingerprint, condition, prediction, ratios, verdicts, time } = found;
    const cellsOf = this.shown(target).map((name) => {
      const { value, interval } = ratios[name];
      return element("td", verdicts[name] === AGREES ? { class: "met" } : {}, `${value.toFixed(2)} (${rangeText(interval)})`);
    });
    if (target.power_W_kg) cellsOf.push(element("td", {}, digits(time.value)));
    const { fingerprints } = this.explorer;
    const cells = [
      ...(fingerprints.length > 1 ? [fingerprint.about.contact] : []),
      condition.charge || short(Number((condition.ball_diameter_m * 1e3).toFixed(3))),
      condition.fill_ratio.toFixed(3),
      setting(this.explorer.units.of("speed").to(condition.speed_hz)),
    ].map((text) => element("td", {}, text));
    const use = element("button", { type: "button", "aria-label": `use ${cells.map((cell) => cell.textContent).join(", ")}` }, "use");
    use.addEventListener("click", () => {
      this.use(found);
      byId("results-title").scrollIntoView({ block: "start" });
    });
    const beyond = prediction.outside.map(nameOf).join(", ");
    return element("tr", {}, ...cells, ...cellsOf, element("td", {}, digits(prediction.wall_power_W.value)), ...(byId("found-outside").hidden ? [] : [element("td", {}, beyond || "–")]), element("td", {}, use));
  }
}

/** "0.91 to 1.14", or that an interval is not known. */
const rangeText = (interval) => (interval ? `${interval.lower.toFixed(2)} to ${interval.upper.toFixed(2)}` : "not known");
