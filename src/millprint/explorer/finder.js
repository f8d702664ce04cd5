/* The inverse search: conditions of the shown mill whose descriptors come nearest to given ones. */

/* A condition is at the end of a range if it is as near as this, as a fraction of it. */
const AT_LIMIT = 2e-3;

class Finder {
  constructor(explorer) {
    this.explorer = explorer;
    // Targets in SI, which stay when another mill is chosen, unless they are still the initial ones.
    this.target = {};
    this.given = false;
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

  /** Take the descriptors of the shown condition for the target. */
  take() {
    const found = this.explorer.answer(this.explorer.state);
    this.target = Object.fromEntries(this.explorer.content.descriptors.map((name) => [name, found[name].value]));
    this.given = true;
  }

  /** Search for the shown condition on another mill, and show that mill. */
  findOn(name) {
    const { explorer } = this;
    this.take();
    explorer.change(() => explorer.useMill(explorer.mills.find((mill) => mill.name === name)));
    byId("search-title").scrollIntoView({ block: "start" });
    return this.show();
  }

  read(name, text) {
    const value = unitOf(DESCRIPTORS[name], this.explorer.units).from(Number(text));
    if (value > 0) this.target[name] = value;
    else delete this.target[name];
    this.given = true;
  }

  /** The fields for another mill; the last search is not valid any more. */
  build() {
    const { mill, mills } = this.explorer;
    const { search } = mill.content;
    const others = mills.filter((each) => each !== mill);
    fillOptions(byId("other"), others.map((each) => [each.name, each.content.title]));
    byId("elsewhere").hidden = others.length === 0;
    if (!this.given) this.target = { ...Object.values(search.targets)[0] };
    byId("found").hidden = true;
    byId("searching").textContent = "";
    this.renderFields();
  }

  renderFields() {
    for (const [name, own] of Object.entries(DESCRIPTORS)) {
      const { unit, to } = unitOf(own, this.explorer.units);
      byId(`target-${name}`).value = name in this.target ? short(to(this.target[name])) : "";
      byId(`target-${name}-unit`).textContent = unit;
    }
  }

  async show() {
    const [button, said, table] = ["find", "searching", "found"].map(byId);
    const { mill } = this.explorer;
    const target = { ...this.target };
    const weighed = Object.keys(target).some((name) => mill.content.search.weights[name] > 0);
    table.hidden = true;
    if (!weighed) {
      said.textContent = "Give at least one descriptor.";
      return;
    }
    button.disabled = true;
    said.textContent = "Searching …";
    // The browser draws and answers between two kinds of balls.
    const rows = await mill.search(target, () => new Promise((resolve) => setTimeout(resolve)));
    button.disabled = false;
    if (mill !== this.explorer.mill) return;
    said.textContent = rows.length ? this.verdict(rows[0], target) : "None of the possible fill ratios was simulated.";
    const [row] = table.tHead.rows;
    row.querySelectorAll(".target").forEach((cell) => cell.remove());
    const titles = this.shown(target).map((name) => element("th", { scope: "col", class: "target" }, DESCRIPTORS[name].sign));
    byId("found-speed").after(...titles);
    byId("found-speed").textContent = withUnit("speed", this.explorer.units.of("speed").unit);
    table.tBodies[0].replaceChildren(...rows.map((row) => this.row(row, target)));
    table.hidden = rows.length === 0;
  }

  /** The descriptors that a target names, in their order. */
  shown(target) {
    return Object.keys(DESCRIPTORS).filter((name) => name in target);
  }

  /** Whether a descriptor lies within the band of a new simulation, and by how much it is missed [%]. */
  missed({ value, lower, upper }, wanted) {
    const percent = 100 * (value / wanted - 1);
    return { met: lower <= wanted && wanted <= upper, text: `${percent < 0 ? "−" : "+"}${Math.abs(percent).toFixed(1)} %` };
  }

  /** A sentence on the nearest condition: met, or by how much each descriptor is missed and which limit it is at. */
  verdict({ condition, prediction }, target) {
    const { mill, units } = this.explorer;
    const { unit, to } = units.of("speed");
    const balls = condition.charge || `${short(Number((condition.ball_diameter_m * 1e3).toFixed(3)))} mm`;
    const setting = `${digits(to(condition.speed_hz))} ${unit}, fill ${condition.fill_ratio.toFixed(3)}, balls of ${balls}`;
    const lost = this.shown(target)
      .map((name) => [DESCRIPTORS[name].sign, this.missed(prediction[name], target[name])])
      .filter(([, { met }]) => !met)
      .map(([sign, { text }]) => `${sign} ${text}`);
    if (!lost.length) return `Met within the scatter of a simulation: ${setting}.`;
    const { speeds_rpm: speeds, fill_ratios: fills } = mill.content.search;
    const ends = [
      [speeds.map((speed) => speed / 60), condition.speed_hz, "speed"],
      [fills, condition.fill_ratio, "fill ratio"],
    ].flatMap(([[low, high], value, name]) => [[low, "lowest"], [high, "highest"]]
      .filter(([end]) => low < high && Math.abs(value / end - 1) < AT_LIMIT)
      .map(([, word]) => `the ${word} ${name}`));
    const limit = ends.length ? ` It is at ${listed(ends)} that was searched.` : "";
    return `No setting is within the scatter of a simulation. Nearest: ${setting}; missed: ${lost.join(", ")}.${limit}`;
  }

  row({ fingerprint, condition, prediction }, target) {
    const missed = this.shown(target).map((name) => {
      const { met, text } = this.missed(prediction[name], target[name]);
      return element("td", met ? { class: "met" } : {}, text);
    });
    const cells = [
      fingerprint.about.contact,
      condition.charge || short(Number((condition.ball_diameter_m * 1e3).toFixed(3))),
      condition.fill_ratio.toFixed(3),
      digits(this.explorer.units.of("speed").to(condition.speed_hz)),
    ].map((text) => element("td", {}, text));
    const use = element("button", { type: "button", "aria-label": `use ${cells.map((cell) => cell.textContent).join(", ")}` }, "use");
    use.addEventListener("click", () => this.explorer.use(fingerprint, condition));
    const beyond = prediction.outside.map(nameOf).join(", ");
    return element("tr", {}, ...cells, ...missed, element("td", {}, digits(prediction.wall_power_W.value)), element("td", {}, beyond || "–"), element("td", {}, use));
  }
}
