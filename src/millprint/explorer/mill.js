/* One mill of the page: its fingerprints and yields, and their results for a state. */

/* The settings of a mill: a kind of unit that can be chosen, or unit, factor from SI and step of the slider. */
const SETTINGS = {
  speed_hz: { label: "Speed", kind: "speed" },
  fill_ratio: { label: "Fill ratio", unit: "", factor: 1, step: 0.005 },
  ball_diameter_m: { label: "Ball diameter", unit: "mm", factor: 1e3, step: 0.1 },
  density_kg_m3: { label: "Ball density", unit: "kg/m³", factor: 1, step: 50 },
};
/* The settings of powder and time. Only a yield model uses the molar ratio. */
const POWDER = {
  bpr: { label: "Ball-to-powder mass ratio", unit: "", factor: 1, step: 1 },
  molar_ratio: { label: "MgH₂ to borate", unit: "mol/mol", factor: 1, step: 0.1 },
  time_h: { label: "Milling time", unit: "h", factor: 1, step: 0.5 },
};
/* Without measured yields: range of the slider and first value; a field takes any number over 0. */
const WITHOUT_YIELD = { bpr: [1, 10, 100], time_h: [0.5, 5, 50] };
const SECONDS_PER_HOUR = 3600;

class Mill {
  constructor(content, variables) {
    this.content = content;
    this.variables = variables;
    // A mill without measured yields has no yield model.
    this.yieldModel = content.yield && new YieldModel(content.yield);
    this.powder = content.yield ? content.chemistry : WITHOUT_YIELD;
  }

  /** Its fingerprints, one for each contact set; they are factored when the mill is first shown. */
  get fingerprints() {
    this.models ??= this.content.fingerprints.map(
      (stored, i) => new Fingerprint(stored, this.variables, this.content.widths[i], this.further),
    );
    return this.models;
  }

  get name() {
    return this.content.name;
  }

  /** Origins of intervals that the run has, in addition to a new simulation: the mean is the first. */
  get further() {
    return Object.keys(this.content.origins).filter((origin) => origin !== "scatter");
  }

  /** The range of a slider in SI: a margin around what was simulated or trained. */
  reach(name) {
    if (name in SETTINGS) return this.content.sliders[name];
    const [low, , high] = this.powder[name];
    const beyond = this.yieldModel ? 0.25 * (high - low) : 0;
    return [Math.max(low - beyond, POWDER[name].step), high + beyond];
  }

  /** What a setting may be: what its slider reaches; anything over 0 where nothing was trained on it. */
  limits(name) {
    return name in POWDER && !this.yieldModel ? [0, Infinity] : this.reach(name);
  }

  /** A condition in the middle of the simulated and trained ranges. */
  firstState(fingerprint) {
    const { about } = fingerprint;
    const middle = (name, { factor, step }) => {
      const [low, high] = about.ranges[name];
      return low === high ? low : (Math.round((factor * (low + high)) / 2 / step) * step) / factor;
    };
    const [charge] = fingerprint.media;
    return {
      charge,
      speed_hz: middle("speed_hz", { factor: 60, step: SPEED_STEPS.rpm }),
      fill_ratio: clamp(0.1, about.ranges.fill_ratio),
      ball_diameter_m: fingerprint.range("ball_diameter_m", charge)[1],
      density_kg_m3: about.density_kg_m3,
      ...Object.fromEntries(Object.entries(this.powder).map(([name, [, first]]) => [name, first])),
    };
  }

  /** All results of the page for a condition. */
  answer(state, fingerprint) {
    const condition = Object.fromEntries(["charge", ...Object.keys(SETTINGS)].map((name) => [name, state[name]]));
    const prediction = fingerprint.predict(condition);
    const balls_g = prediction.balls * state.density_kg_m3 * (Math.PI / 6) * state.ball_diameter_m ** 3 * 1e3;
    const found = { ...prediction, balls_g, ...doses(prediction, state, balls_g / state.bpr) };
    if (!this.yieldModel) return found;
    const conditions = {
      ...Object.fromEntries(Object.keys(POWDER).map((name) => [name, state[name]])),
      normal_energy_uJ: 1e6 * prediction.normal_energy_J.value,
      tangential_energy_uJ: 1e6 * prediction.tangential_energy_J.value,
      specific_frequency_hz: prediction.specific_frequency_hz.value,
    };
    return { ...found, yield_percent: this.yieldModel.predict(conditions) };
  }

  /** The range in SI in which a setting was simulated or trained; null if there is none. */
  known(name, fingerprint, charge) {
    if (name in SETTINGS) return fingerprint.range(name, charge);
    if (!this.yieldModel) return null;
    const [low, , high] = this.content.chemistry[name];
    return [low, high];
  }

  /**
   * The search of the page for a Target, or for descriptors in their SI units, over all contact sets.
   * first: the descriptor that counts most; balls: in place of those of the search.
   */
  search(target, { breathe, first, balls } = {}) {
    const { search } = this.content;
    const allowed = {
      speeds_hz: search.speeds_rpm.map((speed) => speed / 60),
      fill_ratios: search.fill_ratios,
      balls: balls ?? search.ball_diameters_mm,
      densities_kg_m3: search.densities_kg_m3,
    };
    const weights = first ? { ...search.weights, [first]: HELD_DEAR * search.weights[first] } : search.weights;
    const asked = target instanceof Target ? target : new Target(target);
    const { ranked, grid, near_percent: nearPercent } = search;
    return rankConditions(asked, this.fingerprints, allowed, { weights, ranked, grid, nearPercent }, breathe);
  }
}

/** Specific energies [J/kg] and collisions per gram [1/g] of the powder [g] after milling for state.time_h. */
function doses(prediction, state, powder_g) {
  const time_s = state.time_h * SECONDS_PER_HOUR;
  const perMass = (1e3 * time_s) / powder_g;
  return {
    powder_g,
    dose_J_kg: times(prediction.wall_power_W, perMass),
    normal_dose_J_kg: times(prediction.normal_power_W, perMass),
    tangential_dose_J_kg: times(prediction.tangential_power_W, perMass),
    rolling_dose_J_kg: times(prediction.rolling_power_W, perMass),
    hits_per_g: times(prediction.specific_frequency_hz, (prediction.balls * time_s) / powder_g),
  };
}
