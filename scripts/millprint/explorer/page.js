/* The page: sliders, answers, charts and the search. */

const NORMAL = "#0072b2";
const TANGENTIAL = "#c2500a";
const INK = "#333";
const POINTS = 41;

/* Sliders: factor from SI to what is shown, its unit, and the step of the slider. */
const SETTINGS = {
  speed_hz: { label: "Speed", unit: "rpm", factor: 60, step: 5 },
  fill_ratio: { label: "Fill ratio", unit: "", factor: 1, step: 0.005 },
  ball_diameter_m: { label: "Ball diameter", unit: "mm", factor: 1e3, step: 0.1 },
  density_kg_m3: { label: "Ball density", unit: "kg/m³", factor: 1, step: 50 },
};
const CHEMISTRY = {
  bpr: { label: "Ball-to-powder mass ratio", unit: "", factor: 1, step: 1 },
  molar_ratio: { label: "MgH₂ to borate", unit: "mol/mol", factor: 1, step: 0.1 },
  time_h: { label: "Milling time", unit: "h", factor: 1, step: 0.5 },
};
const NAMES = {
  charge: "Charge",
  amplitude_m: "Amplitude",
  normal_energy_uJ: "normal energy [µJ]",
  tangential_energy_uJ: "tangential energy [µJ]",
  specific_frequency_hz: "collisions of a ball [1/s]",
  tangential_share: "tangential share [-]",
  bpr: "ball-to-powder ratio",
  molar_ratio: "MgH₂ to borate",
  time_h: "milling time [h]",
};
const DESCRIPTORS = {
  normal_energy_J: { label: "Normal energy of a collision", unit: "µJ", factor: 1e6 },
  tangential_energy_J: { label: "Tangential energy of a collision", unit: "µJ", factor: 1e6 },
  frequency_per_ball_hz: { label: "Collisions of one ball", unit: "1/s", factor: 1 },
};
const RESULTS = {
  ...DESCRIPTORS,
  normal_power_W: { label: "Normal power, all balls", unit: "W", factor: 1 },
  tangential_power_W: { label: "Tangential power, all balls", unit: "W", factor: 1 },
  power_W: { label: "Dissipated power, all balls", unit: "W", factor: 1 },
  tangential_share: { label: "Tangential share", unit: "%", factor: 100 },
};

/** A quantity with its unit; "-" for one that has none. */
function withUnit(label, unit) {
  return `${label} [${unit || "-"}]`;
}

class Explorer {
  constructor(content) {
    this.content = content;
    this.fingerprints = content.fingerprints.map(
      (stored, i) => new Fingerprint(stored, content.variables, content.widths[i], this.further),
    );
    // A mill without measured yields has no yield model.
    this.yieldModel = content.yield && new YieldModel(content.yield);
    this.chemistry = content.yield ? CHEMISTRY : {};
    this.contact = 0;
    this.state = this.firstState();
    this.axis = "fill_ratio";
    this.shaded = "scatter";
  }

  /** Origins of intervals besides the scatter, of which the run knows something. */
  get further() {
    return Object.keys(this.content.origins).filter((origin) => origin !== "scatter");
  }

  get fingerprint() {
    return this.fingerprints[this.contact];
  }

  /** A condition in the midst of what was simulated and trained. */
  firstState() {
    const { about } = this.fingerprint;
    const middle = (name) => {
      const [low, high] = about.ranges[name];
      const { factor, step } = SETTINGS[name];
      return low === high ? low : (Math.round((factor * (low + high)) / 2 / step) * step) / factor;
    };
    const fills = about.ranges.fill_ratio;
    const [charge] = this.fingerprint.media;
    return {
      charge,
      speed_hz: middle("speed_hz"),
      fill_ratio: clamp(0.1, fills),
      ball_diameter_m: this.fingerprint.range("ball_diameter_m", charge)[1],
      density_kg_m3: about.density_kg_m3,
      ...Object.fromEntries(Object.entries(this.content.chemistry).map(([name, ends]) => [name, ends[1]])),
    };
  }

  /** Everything that the page says of a condition. */
  answer(state, fingerprint = this.fingerprint) {
    const condition = Object.fromEntries(["charge", ...Object.keys(SETTINGS)].map((name) => [name, state[name]]));
    const prediction = fingerprint.predict(condition);
    if (!this.yieldModel) return prediction;
    const conditions = {
      ...Object.fromEntries(Object.keys(CHEMISTRY).map((name) => [name, state[name]])),
      normal_energy_uJ: 1e6 * prediction.normal_energy_J.value,
      tangential_energy_uJ: 1e6 * prediction.tangential_energy_J.value,
      specific_frequency_hz: prediction.frequency_per_ball_hz.value,
    };
    const balls_g = prediction.balls * state.density_kg_m3 * (Math.PI / 6) * state.ball_diameter_m ** 3 * 1e3;
    return { ...prediction, yield_percent: this.yieldModel.predict(conditions), powder_g: balls_g / state.bpr };
  }

  /** The search of the page: a target, in the descriptors' SI units, over all contact sets. */
  search(target, breathe) {
    const { search } = this.content;
    const allowed = {
      speeds_hz: search.speeds_rpm.map((speed) => speed / 60),
      fill_ratios: search.fill_ratios,
      balls: search.ball_diameters_mm,
      densities_kg_m3: search.densities_kg_m3,
    };
    return rankConditions(target, this.fingerprints, allowed, search.weights, search.ranked, search.grid, breathe);
  }

  start() {
    this.controls = {};
    this.buildContacts();
    for (const [name, setting] of Object.entries(SETTINGS)) {
      // Without balls of one size there is no diameter to set.
      if (this.content.sliders[name]) this.buildSlider("mill-sliders", name, setting, this.content.sliders[name]);
    }
    for (const [name, setting] of Object.entries(this.chemistry)) {
      const [low, , high] = this.content.chemistry[name];
      const beyond = 0.25 * (high - low);
      this.buildSlider("chemistry-sliders", name, setting, [Math.max(low - beyond, setting.step), high + beyond]);
    }
    this.buildAxis();
    this.buildShade();
    this.buildSearch();
    this.render();
    this.renderCharts(this.answer(this.state));
  }

  buildContacts() {
    const box = document.getElementById("contacts");
    this.fingerprints.forEach((fingerprint, i) => {
      const radio = element("input", { type: "radio", name: "contact", id: `contact-${i}`, value: i });
      radio.checked = i === this.contact;
      radio.addEventListener("change", () => this.choose(i));
      const { contact, restitution, static_friction: friction } = fingerprint.about;
      const text = `${contact} (e = ${short(restitution)}, µ = ${short(friction)})`;
      box.append(element("span", {}, radio, element("label", { for: `contact-${i}` }, text)));
    });
  }

  /** Another contact set, with its own density unless the user has set one. */
  choose(index) {
    const own = this.state.density_kg_m3 === this.fingerprint.about.density_kg_m3;
    this.contact = index;
    if (own) this.state.density_kg_m3 = this.fingerprint.about.density_kg_m3;
    const { media } = this.fingerprint;
    this.take(media.includes(this.state.charge) ? this.state.charge : media[0]);
    this.render();
  }

  /** Other balls: of one size with the diameter that was set last, or a charge with that of its ball of mean volume. */
  take(charge) {
    if (this.state.charge === ONE_SIZE) this.diameter = this.state.ball_diameter_m;
    const one = this.diameter ?? this.fingerprint.range("ball_diameter_m")[1];
    this.state.charge = charge;
    this.state.ball_diameter_m = charge === ONE_SIZE ? one : this.fingerprint.chosen(charge).ball_diameter_m;
    // There is nothing between two charges, so that nothing changes with the diameter of one.
    if (charge !== ONE_SIZE && this.axis === "ball_diameter_m") this.axis = "fill_ratio";
  }

  /** The choice of balls; hidden if all are of one size. */
  renderMedia(found) {
    const { about, media } = this.fingerprint;
    const box = document.getElementById("media");
    const options = media.map((charge, i) => {
      const radio = element("input", { type: "radio", name: "charge", id: `charge-${i}`, value: charge });
      radio.checked = charge === this.state.charge;
      radio.addEventListener("change", () => {
        this.take(charge);
        this.render();
        document.getElementById(radio.id).focus();
      });
      const mean = charge === ONE_SIZE ? null : digits(1e3 * about.charges[charge].ball_diameter_m);
      const words = mean ? `${charge} (d30 = ${mean} mm)` : "balls of one size";
      return element("span", {}, radio, element("label", { for: radio.id }, words));
    });
    box.replaceChildren(element("legend", {}, "Balls"), ...options);
    const { charge } = this.state;
    const said = [];
    if (charge !== ONE_SIZE) {
      const counts = this.fingerprint.counts(charge, found.balls);
      const sizes = about.charges[charge].sizes_m.map((size, k) => `${counts[k]} of ${short(1e3 * size)} mm`);
      said.push(`${charge}: ${sizes.join(", ")}. Only charges that were simulated: between two of them nothing is calculated.`);
    }
    box.append(element("p", { class: "hint", id: "charge-said" }, ...said));
    box.hidden = media.length === 1 && media[0] === ONE_SIZE;
    for (const part of [this.controls.ball_diameter_m?.whole, document.querySelector("#axis [value=ball_diameter_m]")]) {
      if (part) part.hidden = charge !== ONE_SIZE;
    }
    document.getElementById("axis").value = this.axis;
  }

  buildSlider(place, name, { label, unit, factor, step }, ends) {
    const [low, high] = [Math.ceil((ends[0] * factor) / step), Math.floor((ends[1] * factor) / step)].map((n) => n * step);
    const slider = element("input", { type: "range", id: name, min: short(low), max: short(high), step });
    const field = element("input", { type: "number", min: short(low), max: short(high), step: "any", "aria-label": withUnit(label, unit) });
    const known = element("span", { class: "simulated" });
    const hint = element("p", { class: "hint", id: `${name}-hint` });
    slider.setAttribute("aria-describedby", hint.id);
    const set = (text) => {
      const value = Number(text);
      if (text === "" || !(value > 0)) return;
      this.state[name] = clamp(value, [low, high]) / factor;
      this.render();
    };
    slider.addEventListener("input", () => set(slider.value));
    field.addEventListener("change", () => set(field.value));
    const head = element("div", { class: "head" }, element("label", { for: name }, label), element("span", {}, field, ` ${unit}`));
    const whole = element("div", { class: "slider" }, head, element("div", { class: "track" }, known, slider), hint);
    document.getElementById(place).append(whole);
    this.controls[name] = { whole, slider, field, known, hint, low, high, factor, unit };
  }

  buildAxis() {
    const choice = document.getElementById("axis");
    for (const [name, { label }] of Object.entries({ ...SETTINGS, ...this.chemistry })) {
      if (!this.controls[name]) continue;
      choice.append(element("option", { value: name }, label.toLowerCase()));
    }
    choice.value = this.axis;
    choice.addEventListener("change", () => {
      this.axis = choice.value;
      this.render();
    });
  }

  /** The choice of the interval that charts show; hidden if there is but one. */
  buildShade() {
    const choice = document.getElementById("shaded");
    for (const [origin, { title }] of Object.entries(this.content.origins)) {
      choice.append(element("option", { value: origin }, title));
    }
    choice.value = this.shaded;
    document.getElementById("shade").hidden = this.further.length === 0;
    choice.addEventListener("change", () => {
      this.shaded = choice.value;
      this.render();
    });
  }

  /** A band whose ends are those of the interval that charts show; NaN where it is not known. */
  shade(band) {
    if (this.shaded === "scatter") return band;
    const { lower = NaN, upper = NaN } = band.further[this.shaded] ?? {};
    return { ...band, lower, upper };
  }

  buildSearch() {
    const first = Object.values(this.content.search.targets)[0] ?? {};
    for (const [name, { label, unit, factor }] of Object.entries(DESCRIPTORS)) {
      const field = element("input", { type: "number", id: `target-${name}`, min: 0, step: "any" });
      if (first[name] !== undefined) field.value = short(first[name] * factor);
      document.getElementById("targets").append(
        element("p", {}, element("label", { for: field.id }, label), element("span", {}, field, ` ${unit}`)),
      );
    }
    document.getElementById("take").addEventListener("click", () => {
      const found = this.answer(this.state);
      for (const [name, { factor }] of Object.entries(DESCRIPTORS)) {
        document.getElementById(`target-${name}`).value = digits(found[name].value * factor, 5);
      }
    });
    document.getElementById("search").addEventListener("submit", (event) => {
      event.preventDefault();
      this.showSearch();
    });
  }

  /** Ranges that a control's condition was simulated or trained in, in SI. */
  known(name) {
    if (name in SETTINGS) return this.fingerprint.range(name, this.state.charge);
    const [low, , high] = this.content.chemistry[name];
    return [low, high];
  }

  render() {
    const found = this.answer(this.state);
    const outside = new Set([...found.outside, ...(found.yield_percent?.outside ?? []).map((item) => item.name)]);
    this.renderMedia(found);
    for (const [name, control] of Object.entries(this.controls)) this.renderControl(name, control, outside.has(name));
    this.renderResults(found);
    // A slider sends more events than the browser draws pictures: the charts, which cost most, follow the pictures.
    this.frame ??= requestAnimationFrame(() => {
      this.frame = null;
      this.renderCharts(this.answer(this.state));
    });
  }

  renderControl(name, { slider, field, known, hint, low, high, factor, unit }, outside) {
    const shown = this.state[name] * factor;
    slider.value = shown;
    if (document.activeElement !== field || Number(field.value) !== shown) field.value = short(shown);
    slider.setAttribute("aria-valuetext", `${short(shown)} ${unit}`);
    const ends = this.known(name).map((value) => value * factor);
    const [from, to] = ends.map((value) => (clamp(value, [low, high]) - low) / (high - low));
    // A slider's thumb, 16 px wide, does not reach over the ends of its track.
    known.style.left = `calc(${from} * (100% - 16px) + 8px - 2px)`;
    known.style.width = `calc(${to - from} * (100% - 16px) + 4px)`;
    const word = name in SETTINGS ? "simulated" : "trained";
    const range = ends[0] === ends[1] ? short(ends[0]) : `${short(ends[0])} to ${short(ends[1])}`;
    hint.textContent = `${outside ? "outside: " : ""}${word} ${range} ${unit}`;
    hint.classList.toggle("warn", outside);
  }

  renderResults(found) {
    const list = document.getElementById("results");
    const item = (label, text, below, warn) => {
      const lines = [below].flat().map((line) => element("dd", { class: "interval" }, line));
      return element("div", warn ? { class: "warn" } : {}, element("dt", {}, label), element("dd", {}, text), ...lines);
    };
    const between = ({ lower, upper }) => `${digits(lower)} to ${digits(upper)}`;
    const rows = Object.entries(RESULTS).map(([name, { label, unit, factor }]) => {
      const band = times(found[name], factor);
      const others = this.further.map((origin) => {
        const interval = band.further[origin];
        const words = interval ? between(interval) : this.fingerprint.missing(origin, this.state.fill_ratio);
        return `${this.content.origins[origin].title}: ${words}`;
      });
      // The scatter is named only where there is something to tell it from.
      const below = others.length ? [`scatter: ${between(band)}`, ...others] : between(band);
      return item(label, `${digits(band.value)} ${unit}`, below, found.outside.length > 0);
    });
    const { value, lower, upper, outside = [] } = found.yield_percent ?? {};
    if (found.yield_percent) {
      const about = `${digits(lower)} to ${digits(upper)}${outside.length ? ", extrapolated" : ""}`;
      rows.push(item("Yield to expect", `${digits(value)} %`, about, outside.length + found.outside.length > 0));
      rows.push(item("To weigh in", `${digits(found.powder_g)} g of powder`, `with ${found.balls} balls`, false));
    } else {
      rows.push(item("Balls", String(found.balls), [], false));
    }
    list.replaceChildren(...rows);
    const words = [
      ...["normal_energy_J", "tangential_energy_J", "frequency_per_ball_hz"].map((name) => {
        const { unit, factor } = DESCRIPTORS[name];
        return `${digits(found[name].value * factor)} ${unit}`;
      }),
      `${digits(found.power_W.value)} W`,
      ...(found.yield_percent ? [`yield ${digits(value, 2)} %${outside.length ? " ?" : ""}`] : []),
    ];
    document.getElementById("brief").textContent = words.join(" · ");
    const said = [];
    if (found.outside.length) {
      const names = found.outside.map((name) => (SETTINGS[name]?.label ?? NAMES[name]).toLowerCase()).join(", ");
      said.push(`Not simulated: ${names}. The scaling laws carry the numbers on, with a wider interval.`);
    }
    if (outside.length) {
      const names = outside.map((each) => `${NAMES[each.name]} ${digits(each.value)}, trained ${digits(each.low)} to ${digits(each.high)}`);
      said.push(`The yield model was not trained there: ${names.join("; ")}.`);
    }
    document.getElementById("outside").textContent = said.join(" ");
  }

  renderCharts(found) {
    const name = this.axis;
    const { low, high, factor, unit } = this.controls[name];
    const { label } = { ...SETTINGS, ...CHEMISTRY }[name];
    // With the condition itself, and both sides of it, among the points: a yield is trained in a narrow range.
    const here = this.state[name] * factor;
    const near = [-1e-3, 0, 1e-3].map((by) => clamp(here + by * (high - low), [low, high]));
    const x = [...new Set([...linspace(low, high, POINTS), ...near])].sort((one, other) => one - other);
    const answers = x.map((value) => this.answer({ ...this.state, [name]: value / factor }));
    const line = (key, named, colour, scale) => ({
      name: named,
      colour,
      bands: answers.map((answer) => (key === "yield_percent" ? answer[key] : this.shade(times(answer[key], scale)))),
      now: times(found[key], scale),
      dashed: key === "yield_percent" ? answers.map((answer) => answer[key].outside.length > 0) : null,
    });
    const charts = [
      { title: "Energy of a collision [µJ]", lines: [line("normal_energy_J", "normal", NORMAL, 1e6), line("tangential_energy_J", "tangential", TANGENTIAL, 1e6)] },
      { title: "Collisions of one ball [1/s]", lines: [line("frequency_per_ball_hz", "collisions", INK, 1)] },
      { title: "Dissipated power [W]", lines: [line("normal_power_W", "normal", NORMAL, 1), line("tangential_power_W", "tangential", TANGENTIAL, 1)] },
      { title: "Tangential share [%]", lines: [line("tangential_share", "share", INK, 100)], top: 100 },
      ...(found.yield_percent ? [{ title: "Yield [%]", lines: [line("yield_percent", "yield", INK, 1)], top: 100 }] : []),
    ];
    const shared = { x, label: withUnit(label, unit).toLowerCase(), known: this.known(name).map((value) => value * factor), at: here };
    document.getElementById("charts").replaceChildren(...charts.map((chart) => drawChart({ ...chart, ...shared })));
  }

  /** The target of the form in SI; descriptors left empty are left open. */
  target() {
    const given = Object.entries(DESCRIPTORS).map(([name, { factor }]) => [name, Number(document.getElementById(`target-${name}`).value) / factor]);
    return Object.fromEntries(given.filter(([, value]) => value > 0));
  }

  async showSearch() {
    const [button, said, table] = ["find", "searching", "found"].map((id) => document.getElementById(id));
    const target = this.target();
    const weighed = Object.keys(target).some((name) => this.content.search.weights[name] > 0);
    table.hidden = true;
    if (!weighed) {
      said.textContent = "Give at least one descriptor.";
      return;
    }
    button.disabled = true;
    said.textContent = "Searching …";
    // The browser draws and answers between two kinds of balls.
    const rows = await this.search(target, () => new Promise((resolve) => setTimeout(resolve)));
    button.disabled = false;
    said.textContent = rows.length ? `${rows.length} conditions, the nearest first.` : "No fill ratio that can be set was simulated.";
    table.tBodies[0].replaceChildren(...rows.map((row) => this.foundRow(row, target)));
    table.hidden = rows.length === 0;
  }

  foundRow({ fingerprint, condition, prediction }, target) {
    const missed = Object.keys(DESCRIPTORS).map((name) => {
      if (!(name in target)) return element("td", {}, "open");
      const { value, lower, upper } = prediction[name];
      const percent = 100 * (value / target[name] - 1);
      const text = `${percent < 0 ? "−" : "+"}${Math.abs(percent).toFixed(1)} %`;
      return element("td", lower <= target[name] && target[name] <= upper ? { class: "met" } : {}, text);
    });
    const use = element("button", { type: "button" }, "use");
    use.addEventListener("click", () => {
      this.contact = this.fingerprints.indexOf(fingerprint);
      document.getElementById(`contact-${this.contact}`).checked = true;
      for (const name of ["charge", ...Object.keys(SETTINGS)]) this.state[name] = condition[name];
      if (condition.charge !== ONE_SIZE && this.axis === "ball_diameter_m") this.axis = "fill_ratio";
      this.render();
      document.getElementById("results-title").scrollIntoView({ block: "start" });
    });
    const cells = [
      fingerprint.about.contact,
      condition.charge || short(Number((condition.ball_diameter_m * 1e3).toFixed(3))),
      condition.fill_ratio.toFixed(3),
      (condition.speed_hz * 60).toFixed(0),
    ].map((text) => element("td", {}, text));
    const beyond = prediction.outside.map((name) => (SETTINGS[name]?.label ?? NAMES[name]).toLowerCase()).join(", ");
    return element("tr", {}, ...cells, ...missed, element("td", {}, digits(prediction.power_W.value)), element("td", {}, beyond || "–"), element("td", {}, use));
  }
}
