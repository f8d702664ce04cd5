/* Units that the user can choose. Internally, everything is in SI. */

/* For each kind of quantity: its units with their factors from SI. The acceleration of a wall, in units of gravity, grows
   with the square of the speed, so it is not a factor. */
const UNITS = {
  energy: { label: "energy of a collision", factors: { "µJ": 1e6, mJ: 1e3, J: 1 } },
  frequency: { label: "collisions", factors: { "1/s": 1, "1/min": 60 } },
  dose: { label: "specific energy", factors: { "kJ/g": 1e-6, "J/g": 1e-3, "kWh/t": 1 / 3.6e3 } },
  speed: { label: "speed", factors: { rpm: 60, Hz: 1, g: null } },
};
// Steps of the slider of the speed.
const SPEED_STEPS = { rpm: 5, Hz: 0.05, g: 0.05 };

class Units {
  /** acceleration: of the fastest wall at one turn per second, in units of gravity; null if not known. */
  constructor(chosen, acceleration) {
    this.chosen = chosen;
    this.acceleration = acceleration;
  }

  /** The names of the units of a kind that can be shown for this mill. */
  names(kind) {
    return Object.keys(UNITS[kind].factors).filter((unit) => unit !== "g" || this.acceleration > 0);
  }

  /** The unit of a kind, and its conversion from SI and back. A unit that this mill lacks gives the first unit. */
  of(kind) {
    const names = this.names(kind);
    const unit = names.includes(this.chosen[kind]) ? this.chosen[kind] : names[0];
    if (unit === "g") {
      const { acceleration } = this;
      return { unit, to: (speed) => acceleration * speed ** 2, from: (shown) => Math.sqrt(shown / acceleration) };
    }
    const factor = UNITS[kind].factors[unit];
    return { unit, to: (value) => value * factor, from: (shown) => shown / factor };
  }

  /** A number of a kind, with its unit. */
  text(kind, value, count = 3) {
    const { unit, to } = this.of(kind);
    return `${digits(to(value), count)} ${unit}`;
  }
}

/** A unit with a fixed factor, in the form of `Units.of`. */
const fixedUnit = (unit, factor) => ({ unit, to: (value) => value * factor, from: (shown) => shown / factor });
