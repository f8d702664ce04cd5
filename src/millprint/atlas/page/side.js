/* One side of the page: a mill, its dimensions, and its settings, each a field followed by its unit. */

const OWN = "own:";
// Fields of every side, in this order; the number of balls and the speed follow from the mill.
const SETTINGS = ["ball_diameter_mm", "number", "speed_hz", "density_kg_m3"];
const LABELS = {
  ball_diameter_mm: "Ball diameter",
  number: "Balls",
  speed_hz: "Speed",
  density_kg_m3: "Density of balls",
  fastest_hz: "Fastest speed of the machine",
};
// Balls to powder by mass, and hours of milling: of no mill.
const FURTHER = {
  bpr: { label: "Balls to powder, by mass", unit: ": 1", least: 0.1, most: 1000, start: 10 },
  time_h: { label: "Milling time", unit: "h", least: 0.001, most: 10000, start: 2 },
};
const DENSITY = 7700;
// Where in their ranges speed and fill ratio are at first, as shares of a logarithm.
const FAST = 0.6;
const FULL = [0.75, 0.85, 0.95, 0.6, 0.4];

/** The number that a field has. Throws a line for one that has none, another unit, or more or less than can be meant. */
function readField(text, { label, unit, least, most }) {
  const [, number, written] = text.trim().match(/^([-+]?[\d.]*(?:e[-+]?\d+)?)\s*(.*)$/i);
  const inUnit = unit && unit !== ": 1" ? ` in ${unit}` : "";
  if (number === "" || Number.isNaN(Number(number))) throw new Error(`${label}: “${text}” is no number; write it${inUnit}, such as ${short(middle(least, most))}.`);
  if (written !== "" && written.toLowerCase() !== unit.toLowerCase()) {
    throw new Error(`${label}: “${text}”: write it${inUnit || " without a unit"}${written.startsWith(",") ? ", with a point for decimals" : ""}.`);
  }
  const value = Number(number);
  if (value < least || value > most) {
    throw new Error(`${label}: ${short(value)}${unit && ` ${unit}`} cannot be meant; it is ${short(least)} to ${short(most)}${unit && ` ${unit}`}. Look at the unit.`);
  }
  return value;
}

/** A round number in a range, as an example. */
const middle = (least, most) => Number(Math.sqrt(Math.max(least, most * 1e-4) * most).toPrecision(1));

class Side {
  /** place: "paper" or "own"; changed: called after each change. */
  constructor(place, content, kinds, changed) {
    Object.assign(this, { place, content, kinds, changed, fields: {} });
    this.choice = byId(`${place}-mill`);
    const makers = Object.values(kinds).map((kind) => ({
      label: kind.title,
      options: [
        ...content.mills.map((mill, i) => [String(i), mill.title, mill.kind]).filter((own) => own[2] === kind.name),
        [OWN + kind.name, `Own dimensions: ${small(kind.title)}`],
      ],
    }));
    fillOptions(this.choice, makers);
    const notYet = content.not_yet.map((title) => element("option", { disabled: "" }, title));
    if (notYet.length) this.choice.append(element("optgroup", { label: "Not in the atlas yet" }, ...notYet));
    this.choice.addEventListener("change", () => {
      this.choose(this.choice.value);
      this.changed();
    });
    byId(`${place}-settings`).addEventListener("change", () => this.changed());
    byId(`${place}-dimensions`).addEventListener("change", () => {
      // Other dimensions than the maker's are one's own.
      this.choice.value = OWN + this.kind.name;
      this.mill = null;
      this.tellMill(null);
      this.changed();
    });
  }

  /** Take a mill, a number in the list of mills, or own dimensions of a kind, with settings in the middle of its atlas. */
  choose(value) {
    const own = value.startsWith(OWN);
    const mill = own ? this.content.mills.find((each) => each.kind === value.slice(OWN.length)) : this.content.mills[Number(value)];
    this.choice.value = value;
    this.kind = this.kinds[mill.kind];
    this.mill = own ? null : mill;
    this.build();
    this.tellMill(own ? null : mill);
    byId(`${this.place}-more`).open = own;
    this.put(this.typical(mill));
  }

  /** What is printed by the maker, and what is not. */
  tellMill(mill) {
    const place = byId(`${this.place}-known`);
    const known = Object.entries(mill?.known ?? {}).map(([name, how]) => `${this.label(name)}: ${how}.`);
    const others = known.length === this.kind.dimensions.length ? "" : `${known.length ? "The others are" : "All are"} assumed: put in yours.`;
    place.textContent = mill && !mill.known ? "" : mill ? `${known.join(" ")} ${others}`.trim() : "Put in the dimensions of your jar and machine.";
  }

  label(name) {
    return LABELS[name] ?? capital(this.kind.settings[name].means.replace(/ \[.*?\]$/, "").split(/[:;] /)[0]);
  }

  build() {
    const { place, kind } = this;
    const ask = (name) => {
      const { least, most } = kind.settings[name === "fastest_hz" ? "speed_hz" : name];
      const { unit, shown } = kind.shownSetting(name);
      return { name, label: this.label(name), unit, least: shown(least), most: shown(most) };
    };
    const further = ["bpr", ...(place === "paper" ? ["time_h"] : [])].map((name) => ({ name, ...FURTHER[name] }));
    const kept = Object.fromEntries(further.map(({ name, start }) => [name, this.fields[name]?.input.value ?? String(start)]));
    this.fields = {};
    byId(`${place}-settings`).replaceChildren(...[...SETTINGS.map(ask), ...further, ...(place === "own" ? [ask("fastest_hz")] : [])].map((own) => this.field(own)));
    byId(`${place}-dimensions`).replaceChildren(...kind.dimensions.map(({ name }) => this.field(ask(name))));
    for (const [name, text] of Object.entries(kept)) this.fields[name].input.value = text;
  }

  field(own) {
    const id = `${this.place}-${own.name}`;
    const input = element("input", { id, type: "text", inputmode: "decimal", autocomplete: "off", "aria-describedby": `${this.place}-fault` });
    const unit = own.unit ? ` [${own.unit === ": 1" ? "-" : own.unit}]` : "";
    const label = element("label", { for: id }, own.label, element("span", { class: "hidden" }, unit));
    this.fields[own.name] = { ...own, input };
    return element("p", { class: "field" }, label, element("span", { class: "entry" }, input, element("span", { class: "unit", "aria-hidden": "true" }, own.unit)));
  }

  /** Dimensions with balls, number and speed within what the atlas knows, and the fastest speed: of the mill, or of
      the fastest maker's of the kind. */
  typical({ dimensions, slowest_hz, fastest_hz }) {
    const { kind } = this;
    const start = { ...this.contact?.(), ...dimensions, density_kg_m3: DENSITY, ball_diameter_mm: 10, number: 1, speed_hz: 5 };
    const of = (name, groups, share = 0.5) => {
      const [low, high] = rangeOf(kind, start, name, groups);
      return low * (high / low) ** share;
    };
    const wanted = of("ball_diameter_mm", ["ball"]);
    start.ball_diameter_mm = this.content.sold_mm.reduce((best, own) => (Math.abs(Math.log(own / wanted)) < Math.abs(Math.log(best / wanted)) ? own : best));
    start.fastest_hz = fastest_hz ?? this.content.fastest_hz[kind.name] ?? of("speed_hz", ["froude", "critical"], 1);
    const speed = of("speed_hz", ["froude", "critical"], FAST) * kind.perHertz;
    start.speed_hz = Math.min(Math.max(Number(speed.toPrecision(2)) / kind.perHertz, slowest_hz), start.fastest_hz);
    // As many balls as hit something, if any number does.
    const numbers = FULL.map((share) => Math.max(1, Math.min(kind.limits.most_balls, Math.round(of("number", ["fill"], share)))));
    const hit = (number) => kind.hits(kind.inputs(kind.known({ ...start, number }))) >= kind.limits.hits;
    start.number = numbers.find(hit) ?? numbers[0];
    return start;
  }

  /** The slowest and the fastest speed of the machine: one where the mill has only one, unless another is put in. */
  speedsHz({ fastest_hz }) {
    const only = this.mill?.slowest_hz ?? 0;
    return [Math.abs(only - fastest_hz) < 1e-3 * only ? fastest_hz : 0, fastest_hz];
  }

  /** Fill in the fields. */
  put(condition) {
    for (const [name, { input }] of Object.entries(this.fields)) {
      if (name in condition) input.value = short(Number(this.kind.shownSetting(name).shown(condition[name]).toPrecision(4)));
    }
  }

  /** The condition that the fields have with a contact; null, with the fault told, where they have none. */
  read(contact) {
    const place = byId(`${this.place}-fault`);
    for (const { input } of Object.values(this.fields)) input.removeAttribute("aria-invalid");
    const wrong = (name, text) => {
      this.fields[name]?.input.setAttribute("aria-invalid", "true");
      place.textContent = text;
      return null;
    };
    const condition = { ...contact };
    for (const [name, own] of Object.entries(this.fields)) {
      try {
        const set = name in FURTHER ? (value) => value : this.kind.shownSetting(name).set;
        condition[name] = set(readField(own.input.value, own));
      } catch (error) {
        return wrong(name, error.message);
      }
    }
    if (condition.number !== Math.round(condition.number)) return wrong("number", `Balls: ${short(condition.number)} is not a whole number.`);
    if (condition.speed_hz > condition.fastest_hz * (1 + 1e-9)) {
      return wrong("speed_hz", `Speed: ${this.fields.speed_hz.input.value} ${this.kind.speedUnit} is more than the fastest of the machine.`);
    }
    const fault = this.kind.fault(condition);
    if (fault) return wrong(fault.name, fault.text);
    place.textContent = "";
    return condition;
  }
}

