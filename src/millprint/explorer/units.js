/* Units that the user can choose. Internally, everything is in SI. Where none was chosen, the unit is the largest of
   `fits` with one to three digits before the point. */

/* For each kind of quantity: its units with their factors from SI. The acceleration of a wall, in units of gravity, grows
   with the square of the speed, so it is not a factor. */
const UNITS = {
  energy: { label: "energy of a collision", factors: { "µJ": 1e6, mJ: 1e3, J: 1 }, fits: ["µJ", "mJ", "J"] },
  frequency: { label: "collisions", factors: { "1/s": 1, "1/min": 60 } },
  dose: { label: "specific energy", factors: { "J/g": 1e-3, "kJ/g": 1e-6, "MJ/g": 1e-9, "kWh/t": 1 / 3.6e3 }, fits: ["J/g", "kJ/g", "MJ/g"] },
  speed: { label: "speed", factors: { rpm: 60, Hz: 1, g: null } },
};
// The choice of the unit that fits a number.
const FITTING = "by size";
// Units with prefixes of results that have no choice: a power.
const PREFIXED = { W: { mW: 1e3, W: 1, kW: 1e-3 } };
const TIMES = { s: 3600, min: 60, h: 1 };
// Steps of the slider of the speed.
const SPEED_STEPS = { rpm: 5, Hz: 0.05, g: 0.05 };

class Units {
  /** acceleration: of the fastest wall at one turn per second, in units of gravity; null if not known. */
  constructor(chosen, acceleration) {
    this.chosen = chosen;
    this.acceleration = acceleration;
  }

  /** What can be chosen for a kind on this mill. */
  names(kind) {
    const units = Object.keys(UNITS[kind].factors).filter((unit) => unit !== "g" || this.acceleration > 0);
    return UNITS[kind].fits ? [FITTING, ...units] : units;
  }

  /** The choice for a kind; one that this mill lacks counts as the first. */
  choice(kind) {
    const names = this.names(kind);
    return names.includes(this.chosen[kind]) ? this.chosen[kind] : names[0];
  }

  /** The unit of a kind, and its conversion from SI and back; value: in SI, which the unit is to fit. */
  of(kind, value) {
    const { factors, fits } = UNITS[kind];
    const choice = this.choice(kind);
    const unit = choice === FITTING ? fitting(factors, fits, value) : choice;
    if (unit === "g") {
      const { acceleration } = this;
      return { unit, to: (speed) => acceleration * speed ** 2, from: (shown) => Math.sqrt(shown / acceleration) };
    }
    const factor = UNITS[kind].factors[unit];
    return { unit, to: (value) => value * factor, from: (shown) => shown / factor };
  }

  /** A number of a kind, with its unit. */
  text(kind, value, count = 3) {
    const { unit, to } = this.of(kind, value);
    return `${digits(to(value), count)} ${unit}`;
  }
}

/** The largest of some units in which a value in SI is 1 or more; the smallest for smaller ones, the first without one. */
function fitting(factors, names, value) {
  if (value === undefined) return names[0];
  return [...names].reverse().find((name) => Math.abs(value) * factors[name] >= 0.9995) ?? names[0];
}

/** The unit of a time that fits hours, in the form of `Units.of`, from hours. */
const timeUnit = (hours) => {
  const unit = fitting(TIMES, Object.keys(TIMES), hours);
  return fixedUnit(unit, TIMES[unit]);
};
/** A time that was set: 5 h, 34.6 min. */
function timeText(hours) {
  const { unit, to } = timeUnit(hours);
  return `${short(Number(to(hours).toPrecision(3)))} ${unit}`;
}

/** A unit with a fixed factor, in the form of `Units.of`. */
const fixedUnit = (unit, factor) => ({ unit, to: (value) => value * factor, from: (shown) => shown / factor });
