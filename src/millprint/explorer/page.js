/* The page: which mill, contact set and condition it shows, and when its parts are drawn again. */

class Explorer {
  constructor(content) {
    this.content = content;
    this.mills = content.mills.map((each) => new Mill(each, content.variables));
    this.chosenUnits = {};
    this.shaded = "scatter";
    this.controls = new Controls(this);
    this.results = new Results(this);
    this.finder = new Finder(this);
    this.intro = new Intro(this);
    this.spectra = new Spectra(this);
    this.heat = new Heat(this);
    this.keeper = new Keeper(this);
    this.setMill(this.mills[0]);
  }

  get fingerprints() {
    return this.mill.fingerprints;
  }

  get fingerprint() {
    return this.fingerprints[this.contact];
  }

  get units() {
    return this.unitsOf(this.mill);
  }

  /** The chosen units on a mill: its speed unit, and the acceleration of its wall. */
  unitsOf({ content: { acceleration, speed_unit: unit } }) {
    return new Units({ speed: unit === "hz" ? "Hz" : "rpm", ...this.chosenUnits }, acceleration);
  }

  answer(state, fingerprint = this.fingerprint) {
    return this.mill.answer(state, fingerprint);
  }

  /** A condition in words: its mill, speed, balls and fill ratio. */
  conditionText(condition) {
    const { unit, to } = this.units.of("speed");
    const balls = condition.charge || `${short(Number((condition.ball_diameter_m * 1e3).toFixed(3)))} mm`;
    return `${setting(to(condition.speed_hz))} ${unit}, balls of ${balls}, fill ${condition.fill_ratio.toFixed(3)}`;
  }

  /** Show a mill in its first state. */
  setMill(mill) {
    this.mill = mill;
    this.contact = 0;
    this.diameter = undefined;
    this.state = mill.firstState(this.fingerprint);
    this.axis = "fill_ratio";
    if (!(this.shaded in mill.content.origins)) this.shaded = "scatter";
  }

  /** Another mill, with its controls. */
  useMill(mill) {
    this.setMill(mill);
    this.finder.forget();
    this.build();
  }

  /** The settings that the charts can be drawn over: those with a slider that change something; there is nothing between
      two charges. */
  axes() {
    const names = Object.keys(this.controls.sliders).filter((name) => name in SETTINGS || this.mill.yieldModel);
    return this.state.charge === ONE_SIZE ? names : names.filter((name) => name !== "ball_diameter_m");
  }

  start() {
    // On a phone the settings come first.
    byId("tools").open = innerWidth > 760;
    fillOptions(byId("mill"), this.mills.map((mill) => [mill.name, mill.content.title]));
    byId("mills").hidden = this.mills.length === 1;
    byId("mill").addEventListener("change", () => {
      this.change(() => this.useMill(this.mills.find((mill) => mill.name === byId("mill").value)));
    });
    for (const [kind, { label, factors, fits }] of Object.entries(UNITS)) {
      const choice = element("select", { id: `unit-${kind}` });
      fillOptions(choice, [...(fits ? [FITTING] : []), ...Object.keys(factors)].map((unit) => [unit, unit]));
      choice.addEventListener("change", () => this.change(() => {
        this.chosenUnits[kind] = choice.value;
        this.build();
      }));
      byId("units").append(element("span", {}, element("label", { for: choice.id }, label), choice));
    }
    byId("axis").addEventListener("change", () => this.change(() => (this.axis = byId("axis").value)));
    byId("shaded").addEventListener("change", () => this.change(() => (this.shaded = byId("shaded").value)));
    byId("copy").addEventListener("click", () => copyText(byId("methods"), byId("copied")));
    for (const part of [this.finder, this.spectra, this.heat, this.keeper]) part.start();
    this.build();
    this.draw();
    this.keeper.readAddress();
  }

  /** Draw what depends on the mill and the units, but not on the settings. */
  build() {
    this.controls.build();
    this.finder.build();
    this.intro.build();
  }

  /** Something that the user has changed. */
  change(act) {
    act();
    this.render();
  }

  /** Another contact set, with its density unless the user has set a density. */
  choose(index) {
    this.useContact(index);
    this.render();
  }

  useContact(index) {
    const own = this.state.density_kg_m3 === this.fingerprint.about.density_kg_m3;
    this.contact = index;
    if (own) this.state.density_kg_m3 = this.fingerprint.about.density_kg_m3;
    const { media } = this.fingerprint;
    this.take(media.includes(this.state.charge) ? this.state.charge : media[0]);
  }

  /** Other balls: of one size with the diameter that was set last, or a charge with its mean-volume diameter. */
  take(charge) {
    if (this.state.charge === ONE_SIZE) this.diameter = this.state.ball_diameter_m;
    const one = this.diameter ?? this.fingerprint.range("ball_diameter_m")[1];
    this.state.charge = charge;
    this.state.ball_diameter_m = charge === ONE_SIZE ? one : this.fingerprint.chosen(charge).ball_diameter_m;
    // Nothing is known between two charges, so the diameter of a charge cannot be changed.
    if (charge !== ONE_SIZE && this.axis === "ball_diameter_m") this.axis = "fill_ratio";
  }

  /** A condition that the search has found. */
  use(fingerprint, condition) {
    this.contact = this.fingerprints.indexOf(fingerprint);
    for (const name of ["charge", ...Object.keys(SETTINGS)]) this.state[name] = condition[name];
    if (condition.charge !== ONE_SIZE && this.axis === "ball_diameter_m") this.axis = "fill_ratio";
    this.render();
  }

  /** Draw the state, and keep it in the address. */
  render() {
    this.draw();
    this.keeper.later();
  }

  draw() {
    const found = this.answer(this.state);
    byId("mill").value = this.mill.name;
    this.renderChoices();
    this.controls.render(found);
    this.results.render(found);
    byId("methods").textContent = methodsText(this, found);
    byId("copied").textContent = "";
    renderAdvice(this, found);
    // A slider sends more events than the browser draws pictures: the charts, which cost most, follow the pictures.
    this.frame ??= requestAnimationFrame(() => {
      this.frame = null;
      this.results.renderCharts(this.answer(this.state));
      this.spectra.render();
      this.heat.render();
    });
  }

  /** The choices of units, of the axis of the charts and of their interval. */
  renderChoices() {
    const { units } = this;
    for (const kind of Object.keys(UNITS)) {
      const names = units.names(kind);
      for (const option of byId(`unit-${kind}`).options) option.hidden = option.disabled = !names.includes(option.value);
      byId(`unit-${kind}`).value = units.choice(kind);
    }
    const every = { ...SETTINGS, ...POWDER };
    fillOptions(byId("axis"), this.axes().map((name) => [name, every[name].label]));
    byId("axis").value = this.axis;
    fillOptions(byId("shaded"), Object.entries(this.mill.content.origins).map(([origin, { title }]) => [origin, title]));
    byId("shaded").value = this.shaded;
  }
}
