/* The controls of the settings: contact set, balls, and a slider with a field for each number. */

class Controls {
  constructor(explorer) {
    this.explorer = explorer;
  }

  /** All controls of the mill that is shown. */
  build() {
    const { mill } = this.explorer;
    for (const id of ["contacts", "mill-sliders", "powder-sliders"]) {
      byId(id).replaceChildren(...[...byId(id).children].filter((child) => child.tagName === "LEGEND"));
    }
    this.sliders = {};
    this.buildContacts(mill);
    for (const [name, setting] of Object.entries(SETTINGS)) {
      // There is no diameter to set without balls of one size.
      if (mill.reach(name)) this.buildSlider("mill-sliders", name, setting);
    }
    for (const [name, setting] of Object.entries(POWDER)) {
      if (mill.powder[name]) this.buildSlider("powder-sliders", name, setting);
    }
    this.buildPowder();
  }

  buildContacts(mill) {
    const { explorer } = this;
    mill.fingerprints.forEach((fingerprint, i) => {
      const radio = element("input", { type: "radio", name: "contact", id: `contact-${i}`, value: i });
      radio.addEventListener("change", () => explorer.choose(i));
      const { contact, restitution, static_friction: friction } = fingerprint.about;
      const damping = restitution === undefined ? "" : `e = ${short(restitution)}, `;
      const text = `${contact} (${damping}µ = ${short(friction)})`;
      byId("contacts").append(element("span", {}, radio, element("label", { for: radio.id }, text)));
    });
  }

  /** The unit of a setting, how to get to it and back, the ends and the step of its slider, and what its field takes. */
  scaleOf(name) {
    const { explorer } = this;
    const { kind, unit, factor, step } = { ...SETTINGS, ...POWDER }[name];
    const scale = kind ? explorer.units.of(kind) : fixedUnit(unit, factor);
    const stride = kind ? SPEED_STEPS[scale.unit] : step;
    const [first, last] = explorer.mill.reach(name).map((value) => scale.to(value) / stride);
    const ends = { low: Math.ceil(first - 1e-9) * stride, high: Math.floor(last + 1e-9) * stride };
    const [least, most] = explorer.mill.limits(name);
    return { ...scale, ...ends, step: stride, limits: least > 0 ? [ends.low, ends.high] : [least, most] };
  }

  buildSlider(place, name, { label }) {
    const slider = element("input", { type: "range", id: name });
    const field = element("input", { type: "number", step: "any", id: `${name}-field` });
    const unit = element("span", { class: "unit" });
    const known = element("span", { class: "simulated" });
    const hint = element("p", { class: "hint", id: `${name}-hint`, role: "status" });
    slider.setAttribute("aria-describedby", hint.id);
    const set = (value) => this.set(name, value);
    slider.addEventListener("input", () => this.take(name, slider.value, set));
    field.addEventListener("change", () => this.take(name, field.value, set));
    const head = element("div", { class: "head" }, element("label", { for: name }, label), element("span", {}, field, " ", unit));
    const whole = element("div", { class: "slider" }, head, element("div", { class: "track" }, known, slider), hint);
    byId(place).append(whole);
    this.sliders[name] = { whole, slider, field, known, hint, unit };
  }

  /** Set a number in the shown unit, within its limits; returns what was changed of it, in words. */
  set(name, value) {
    const { limits, from, unit } = this.scaleOf(name);
    const taken = clamp(value, limits);
    this.explorer.state[name] = from(taken);
    return taken === value ? "" : `${short(value)} ${unit} cannot be set here: ${short(taken)} ${unit} is shown`;
  }

  /** Set a number that was put in; what was not taken of it, or changed, is told at its place. */
  take(name, text, set) {
    const value = Number(text);
    this.tell(name, value > 0 ? set(value) : `${text || "nothing"} is no number over 0`);
  }

  /** Draw the page with a line at a setting on what became of a number. */
  tell(name, text) {
    this.changed = { name, text };
    this.explorer.render();
    this.changed = null;
  }

  /** The mass of the powder, which sets the ball-to-powder ratio. */
  buildPowder() {
    const { explorer } = this;
    const hint = element("p", { class: "hint warn", id: "powder-hint", role: "status" });
    const field = element("input", { type: "number", step: "any", min: 0, id: "powder-field", "aria-describedby": hint.id });
    const set = (mass) => {
      const { balls_g } = explorer.answer(explorer.state);
      const asked = balls_g / mass;
      explorer.state.bpr = clamp(asked, this.scaleOf("bpr").limits);
      const { bpr } = explorer.state;
      return bpr === asked ? "" : `${short(mass)} g cannot be set here: ${digits(balls_g / bpr)} g is shown`;
    };
    field.addEventListener("change", () => this.take("powder", field.value, set));
    const label = element("label", { for: field.id }, "Powder");
    byId("powder-sliders").append(element("div", { class: "head" }, label, element("span", {}, field, " g")), hint);
    this.powder = { field, hint };
  }

  render(found) {
    const { explorer } = this;
    explorer.mill.fingerprints.forEach((_, i) => {
      byId(`contact-${i}`).checked = i === explorer.contact;
    });
    this.renderMedia(found);
    const outside = new Set([...found.outside, ...(found.yield_percent?.outside ?? []).map((item) => item.name)]);
    for (const name of Object.keys(this.sliders)) this.renderSlider(name, outside.has(name));
    const { field, hint } = this.powder;
    const isOwn = this.changed?.name === "powder";
    hint.textContent = isOwn ? this.changed.text : "";
    if (document.activeElement !== field || (isOwn && this.changed.text)) field.value = short(Number(found.powder_g.toPrecision(3)));
  }

  renderSlider(name, outside) {
    const { explorer } = this;
    const { whole, slider, field, known, hint, unit: named } = this.sliders[name];
    const { unit, to, low, high, step, limits } = this.scaleOf(name);
    const { label } = { ...SETTINGS, ...POWDER }[name];
    const shown = to(explorer.state[name]);
    for (const [key, value] of Object.entries({ min: short(low), max: short(high), step })) slider.setAttribute(key, value);
    field.setAttribute("min", short(limits[0]));
    field.setAttribute("max", short(limits[1]));
    field.setAttribute("aria-label", withUnit(label, unit));
    named.textContent = unit;
    slider.value = shown;
    if (document.activeElement !== field || Number(field.value) !== shown) field.value = short(Number(shown.toPrecision(4)));
    slider.setAttribute("aria-valuetext", `${short(shown)} ${unit}`);
    whole.hidden = name === "ball_diameter_m" && explorer.state.charge !== ONE_SIZE;
    const range = explorer.mill.known(name, explorer.fingerprint, explorer.state.charge);
    const told = this.changed?.name === name ? this.changed.text : "";
    hint.textContent = told;
    hint.classList.toggle("warn", outside || told !== "");
    known.hidden = !range;
    hint.hidden = !range && !told;
    if (!range) return;
    const ends = range.map(to);
    const [from, till] = ends.map((value) => (clamp(value, [low, high]) - low) / (high - low));
    // A slider's thumb, 16 px wide, does not reach over the ends of its track.
    known.style.left = `calc(${from} * (100% - 16px) + 8px - 2px)`;
    known.style.width = `calc(${till - from} * (100% - 16px) + 4px)`;
    const where = `${outside ? "outside: " : ""}${name in SETTINGS ? "simulated" : "trained"} ${fromTo(...ends)} ${unit}`;
    hint.textContent = told ? `${told}; ${where}` : where;
  }

  /** The choice of balls; hidden if all are of one size. */
  renderMedia(found) {
    const { explorer } = this;
    const { about, media } = explorer.fingerprint;
    const box = byId("media");
    const options = media.map((charge, i) => {
      const radio = element("input", { type: "radio", name: "charge", id: `charge-${i}`, value: charge });
      radio.checked = charge === explorer.state.charge;
      radio.addEventListener("change", () => {
        explorer.take(charge);
        explorer.render();
        byId(radio.id).focus();
      });
      const mean = charge === ONE_SIZE ? null : digits(1e3 * about.charges[charge].ball_diameter_m);
      const words = mean ? `${charge} (d30 = ${mean} mm)` : "balls of one size";
      return element("span", {}, radio, element("label", { for: radio.id }, words));
    });
    box.replaceChildren(element("legend", {}, "Balls"), ...options);
    const { charge } = explorer.state;
    const said = [];
    if (charge !== ONE_SIZE && about.charges?.[charge]) {
      const text = chargeInWords(explorer.fingerprint, charge, found.balls);
      said.push(`${charge}: ${text}. Only simulated charges: between two of them nothing is calculated.`);
    }
    box.append(element("p", { class: "hint", id: "charge-said" }, ...said));
    box.hidden = media.length === 1 && media[0] === ONE_SIZE;
  }
}

/** "12 of 10 mm, 3 of 14 mm" */
function chargeInWords(fingerprint, charge, balls) {
  const counts = fingerprint.counts(charge, balls);
  return fingerprint.about.charges[charge].sizes_m.map((size, k) => `${counts[k]} of ${short(1e3 * size)} mm`).join(", ");
}
