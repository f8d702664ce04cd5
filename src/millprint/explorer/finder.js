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
      this.find();
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
    const known = this.asked.filter((name) => !Number.isNaN(found[name].value));
    this.target = new Target(Object.fromEntries(known.map((name) => [name, found[name]])), {
      power_W_kg: powerOfMass(found, state),
      outside: found.outside,
      time_h: state.time_h,
      bpr: state.bpr,
      words: `${mill.content.title}, ${explorer.conditionText(state)}`,
      said: fewTurnsWords(explorer.fingerprint).map((text) => `There: ${text}`),
    });
    this.given = true;
  }

  /** Search for the shown condition on another mill. */
  async findOn(name) {
    const { explorer } = this;
    this.take();
    explorer.change(() => explorer.useMill(explorer.mills.find((mill) => mill.name === name)));
    await this.find();
  }

  /** Search, and show the best condition and, in view, what was found. */
  async find() {
    const rows = await this.show();
    if (rows.length) this.use(rows[0]);
    goTo("answer");
  }

  read(name, text) {
    const value = this.units[name].from(Number(text));
    const { [name]: _, ...others } = this.target.wanted;
    // A number of the user's is of no condition, which would have a power.
    this.target = new Target(value > 0 ? { ...others, [name]: value } : others);
    this.given = true;
    byId("left-open").textContent = text === "" || value > 0 ? "" : `${text} is no number over 0: ${DESCRIPTORS[name].sign} is left open.`;
    this.renderFields();
  }

  /** The last search is not valid any more, of another mill. */
  forget() {
    this.answer = null;
    this.matched = null;
    byId("answer").hidden = true;
  }

  /** The fields and the answer of the last search, in the units that are chosen. */
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
    this.renderFields();
    if (this.answer) this.renderAnswer();
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
    const [button, said] = ["find", "searching"].map(byId);
    const { mill } = this.explorer;
    const { target } = this;
    const chosen = byId("first").value;
    const first = chosen in target.wanted ? chosen : null;
    this.answer = null;
    byId("answer").hidden = false;
    byId("wanted").textContent = target.words ? `Wanted: what ${target.words} does.` : "";
    byId("choices").replaceChildren();
    byId("found").hidden = true;
    if (!target.asked.some((name) => mill.content.search.weights[name] > 0)) {
      said.textContent = target.words ? "Nothing is known of its hits." : "Give at least one descriptor.";
      return [];
    }
    button.disabled = true;
    said.textContent = "Searching …";
    // The browser draws and answers between two kinds of balls.
    const breathe = () => new Promise((resolve) => setTimeout(resolve));
    const rows = await mill.search(target, { first, breathe });
    const best = rows.findIndex(({ verdict }) => verdict === AGREES);
    if (best > 0) rows.unshift(...rows.splice(best, 1));
    const choices = rows[0]?.verdict === DIFFERS ? await this.choices(rows[0], target, breathe) : [];
    button.disabled = false;
    if (mill !== this.explorer.mill) return [];
    this.answer = { rows, choices, target };
    this.renderAnswer();
    return rows;
  }

  /** What the last search has found. */
  renderAnswer() {
    const { rows, choices, target } = this.answer;
    const table = byId("found");
    byId("searching").textContent = rows.length ? this.verdict(rows[0], target) : "None of the possible fill ratios was simulated.";
    byId("choices").replaceChildren(...choices.map(({ row, name }) => element("li", {}, this.choiceWords(row, name))));
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
        return `${DESCRIPTORS[name].sign}${met} ${digits(value)} times (${rangeText(interval)})`;
      })
      .join(", ");
  }

  /** A sentence on the nearest condition: the verdict, what was found over what was wanted, limits, and the time. */
  verdict(row, target) {
    const { mill } = this.explorer;
    const { condition, ratios, verdict } = row;
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
    return [...said, ...this.timeWords(row, target), ...target.said].join(" ");
  }

  /** A sentence on the milling time for the dose of the wanted condition; none where none is wanted. */
  timeWords({ time }, { time_h, bpr }, own = bpr) {
    if (!time) return [];
    const { unit, to } = timeUnit(time_h * time.value);
    const [here, lower, upper] = [time.value, time.interval?.lower, time.interval?.upper].map((ratio) => digits(to(time_h * ratio)));
    const range = time.interval ? `${lower} to ${upper}` : "not known";
    return [`${timeText(time_h)} there is ${here} ${unit} here (${range}) for the same energy per gram of powder, ${ratiosOfPowder(bpr, own)}.`];
  }

  /** What else to choose where not all can be met: one of the energies, with what it costs the others, or other balls
      (without a name). */
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
      found.push({ row, name });
    }
    const [low, high] = best.fingerprint.range("ball_diameter_m").map((size) => 1e3 * size);
    const sizes = explorer.content.sold_mm.filter((size) => size >= low / OTHER_SIZES && size <= OTHER_SIZES * high);
    const balls = sizes.filter((size) => size < low || size > high);
    const [row] = balls.length ? await mill.search(target, { balls, breathe }) : [];
    if (row && row.distance < NEARER * best.distance) found.push({ row });
    return found;
  }

  choiceWords(row, name) {
    const place = this.explorer.conditionText(row.condition);
    if (!name) return `or other balls, ${farthest(row.ratios)} by the scaling of the curves: ${place}; simulate them first`;
    const others = this.shown(this.answer.target).filter((other) => other !== name);
    return `or ${this.ratioWords(row, [name, ...others])}: ${place}`;
  }

  /** Show a condition that was found, with the time for the same dose, and keep what it was matched to for the methods text. */
  use({ fingerprint, condition, ...row }) {
    const { explorer } = this;
    const { target } = this.answer;
    this.matched = { target, condition, row };
    const dose = row.time ? { bpr: target.bpr, time_h: Number((target.time_h * row.time.value).toPrecision(3)) } : {};
    const changed = Object.entries(dose).map(([name, value]) => [name, explorer.controls.set(name, value)]);
    explorer.use(fingerprint, condition);
    for (const [name, text] of changed) if (text) explorer.controls.tell(name, text);
  }

  /** What the shown condition is to that of another mill that a search was for; null without one. */
  toWanted(found) {
    const { matched, explorer } = this;
    if (!matched?.target.words) return null;
    const { state, mill } = explorer;
    return matched.target.judge(state, found, mill.content.search.near_percent);
  }

  /** The wanted condition and how the shown one compares; empty without one. */
  compared(found) {
    const row = this.toWanted(found);
    if (!row) return "";
    const { target } = this.matched;
    const said = `Wanted: what ${target.words} does. ${VERDICTS[row.verdict]}: ${this.ratioWords(row, this.shown(target))}.`;
    return [said, ...this.timeWords(row, target, this.explorer.state.bpr), ...target.said].join(" ");
  }

  /** Sentences for the methods text, where a search was for a condition of another mill. */
  matchedWords(found) {
    const row = this.toWanted(found);
    if (!row) return [];
    const { target, condition } = this.matched;
    const { near_percent: near } = this.explorer.mill.content.search;
    const isFound = Object.keys(SETTINGS).every((name) => this.explorer.state[name] === condition[name]);
    const head = isFound ? `These settings were chosen to do what ${target.words} does` : `Compared with ${target.words}`;
    return [
      `${head} (${VERDICTS[row.verdict].toLowerCase()} within ${near} %): ${this.ratioWords(row, this.shown(target))}, with the interval of the mean of very many simulations of both.`,
      ...(row.time
        ? [`The same energy per gram of powder as in ${timeText(target.time_h)} there takes ${timeText(target.time_h * row.time.value)}, ${ratiosOfPowder(target.bpr, this.explorer.state.bpr)}.`]
        : []),
      ...target.said,
    ];
  }

  row(found, target) {
    const { fingerprint, condition, prediction, ratios, verdicts, time } = found;
    const cellsOf = this.shown(target).map((name) => {
      const { value, interval } = ratios[name];
      return element("td", verdicts[name] === AGREES ? { class: "met" } : {}, `${digits(value)} (${rangeText(interval)})`);
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
      goTo("results-title");
    });
    const beyond = prediction.outside.map(nameOf).join(", ");
    return element("tr", {}, ...cells, ...cellsOf, element("td", {}, powerText(prediction.wall_power_W.value, this.explorer.units)), ...(byId("found-outside").hidden ? [] : [element("td", {}, beyond || "–")]), element("td", {}, use));
  }
}

/** The ball-to-powder ratios at which two milling times are compared. */
const ratiosOfPowder = (there, here) =>
  here === there ? "at the same ball-to-powder ratio" : `at ball-to-powder ratios of ${short(there)} there and ${short(here)} here`;

/** "0.91 to 1.14", or that an interval is not known. */
const rangeText = (interval) => (interval ? `${digits(interval.lower)} to ${digits(interval.upper)}` : "not known");
