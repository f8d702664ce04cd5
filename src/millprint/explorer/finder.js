/* The inverse search: conditions of the shown mill whose descriptors come nearest to given ones. */

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
      const found = this.explorer.answer(this.explorer.state);
      this.target = Object.fromEntries(this.explorer.content.descriptors.map((name) => [name, found[name].value]));
      this.given = true;
      this.renderFields();
    });
    byId("search").addEventListener("submit", (event) => {
      event.preventDefault();
      this.show();
    });
  }

  read(name, text) {
    const value = this.explorer.units.of(DESCRIPTORS[name].kind).from(Number(text));
    if (value > 0) this.target[name] = value;
    else delete this.target[name];
    this.given = true;
  }

  /** The fields for another mill; the last search is not valid any more. */
  build() {
    const { search } = this.explorer.mill.content;
    if (!this.given) this.target = { ...Object.values(search.targets)[0] };
    byId("found").hidden = true;
    byId("searching").textContent = "";
    this.renderFields();
  }

  renderFields() {
    for (const [name, { kind }] of Object.entries(DESCRIPTORS)) {
      const { unit, to } = this.explorer.units.of(kind);
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
    said.textContent = rows.length ? `${rows.length} conditions, the nearest first.` : "None of the possible fill ratios was simulated.";
    const [row] = table.tHead.rows;
    row.querySelectorAll(".target").forEach((cell) => cell.remove());
    const titles = this.shown(target).map((name) => element("th", { scope: "col", class: "target" }, DESCRIPTORS[name].label));
    byId("found-speed").after(...titles);
    byId("found-speed").textContent = withUnit("speed", this.explorer.units.of("speed").unit);
    table.tBodies[0].replaceChildren(...rows.map((row) => this.row(row, target)));
    table.hidden = rows.length === 0;
  }

  /** The descriptors that a target names, in their order. */
  shown(target) {
    return Object.keys(DESCRIPTORS).filter((name) => name in target);
  }

  row({ fingerprint, condition, prediction }, target) {
    const missed = this.shown(target).map((name) => {
      const { value, lower, upper } = prediction[name];
      const percent = 100 * (value / target[name] - 1);
      const text = `${percent < 0 ? "−" : "+"}${Math.abs(percent).toFixed(1)} %`;
      return element("td", lower <= target[name] && target[name] <= upper ? { class: "met" } : {}, text);
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
    return element("tr", {}, ...cells, ...missed, element("td", {}, digits(prediction.power_W.value)), element("td", {}, beyond || "–"), element("td", {}, use));
  }
}
