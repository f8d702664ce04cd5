/* The fingerprint of one mill and contact set, as millprint.fingerprint.model computes it. */

// The scaled quantities from which `complete` calculates all others: of collisions only, and with those of the power.
const { of_collisions: OF_COLLISIONS, known: BASIC, own_curves: OWN_CURVES } = CONTENT.curves;
// Records of millprint.observables.definitions, in the order of the page, and their scales.
const OBSERVABLES = CONTENT.observables;
const BY_COLLISION = OBSERVABLES.filter(({ adds_up, curve }) => !adds_up && curve !== "share");
// The charge of balls of one size.
const ONE_SIZE = "";
// An interval whose ends are farther apart than this factor says nothing: they count as not known; as in Python.
const WIDEST = 10;
// Where nothing hits, as a reason; as in Python.
const NO_IMPACTS = "no_impacts";
// Conditions are the same within this difference of logarithms.
const SAME = 1e-5;
// Parts of a power: the whole, and their share in it by a ratio; rising with the ratio or not.
const part = (ratio) => ratio / (1 + ratio);
const PARTS = {
  Pn: { whole: "P", of: "ratio", share: (ratio) => 1 / (1 + ratio), rises: false },
  Pt: { whole: "P", of: "ratio", share: part, rises: true },
  Pr: { whole: "Pw", of: "rolling_ratio", share: part, rises: true },
};

/** A Gaussian process of the logarithm of one scaled quantity (millprint.fingerprint.processes). */
class LogProcess {
  /**
   * content: from Process.to_dict, with `reduced` where the curve is that of a few conditions
   * (millprint.fingerprint.processes); inputs: logarithms of the variables, a row for each condition; layers: of those
   * without impacts, which the curve leaves out.
   */
  constructor(content, inputs, layers) {
    const parameters = content.log_parameters.map(Math.exp);
    const width = inputs[0].length + 1;
    this.parts = [];
    for (let first = 0; first < parameters.length; first += width) {
      this.parts.push({ variance: parameters[first], lengths: parameters.slice(first + 1, first + width) });
    }
    this.noise = content.noise_variance;
    this.sampling = content.sampling;
    this.stretch = content.stretch;
    this.variance = this.parts.reduce((sum, part) => sum + part.variance, 0);
    this.simulated = [{ ...content, inputs }, ...(content.apart ? [{ ...content.apart, inputs: layers }] : [])];
    if (content.reduced) this.knowFew(content.reduced);
    else this.knowAll(content, inputs);
  }

  /** A process of every condition. */
  knowAll(content, inputs) {
    this.inputs = inputs;
    const logs = content.values.map(Math.log);
    this.centre = logs.reduce((sum, value) => sum + value, 0) / logs.length;
    const matrix = inputs.map((row) => this.covariance(row));
    matrix.forEach((row, i) => {
      row[i] += content.relative_errors[i] ** 2 + this.noise + 1e-10;
    });
    this.factor = cholesky(matrix);
    this.weights = solveFactored(this.factor, logs.map((value) => value - this.centre));
    this.left = () => 0;
  }

  /** A process that is reduced to some of its conditions. */
  knowFew({ taken, corner, lower, weights, centre }) {
    this.inputs = taken;
    this.centre = centre;
    this.factor = corner;
    this.weights = solveUpper(corner, solveUpper(lower, weights));
    this.left = (known) => {
      const told = solveLower(lower, known);
      return dot(told, told);
    };
  }

  /** Covariance of one point with every known condition: a sum of Matern 5/2 kernels. */
  covariance(point) {
    const found = new Float64Array(this.inputs.length);
    for (const { variance, lengths } of this.parts) {
      for (let i = 0; i < found.length; i += 1) {
        let square = 0;
        for (let k = 0; k < lengths.length; k += 1) square += ((point[k] - this.inputs[i][k]) / lengths[k]) ** 2;
        const distance = Math.sqrt(5 * square);
        found[i] += variance * (1 + distance + (distance * distance) / 3) * Math.exp(-distance);
      }
    }
    return found;
  }

  mean(point) {
    return this.centre + dot(this.covariance(point), this.weights);
  }

  /** Logarithm at a point, and its standard deviations: of the mean, and of a new simulation, one run. */
  predict(point) {
    return this.asSimulated(point) ?? this.onCurve(point);
  }

  onCurve(point) {
    const covariance = this.covariance(point);
    const solved = solveLower(this.factor, covariance);
    const own = Math.max(0, this.variance - dot(solved, solved) + this.left(solved));
    const oneRun = this.noise + Math.exp(this.sampling[0] + this.sampling[1] * point[0]);
    return {
      log: this.centre + dot(covariance, this.weights),
      ofMean: this.stretch * Math.sqrt(own),
      ofNew: this.stretch * Math.sqrt(own + oneRun),
    };
  }

  /** What was simulated at a point; null where nothing was. */
  asSimulated(point) {
    const isHere = (row) => row.every((value, k) => Math.abs(value - point[k]) < SAME);
    const known = this.simulated.find(({ inputs }) => inputs.some(isHere));
    if (!known) return null;
    const { inputs, values, relative_errors, seeds } = known;
    const place = inputs.findIndex(isHere);
    const runs = seeds?.[place] ?? 1;
    const square = relative_errors[place] ** 2;
    const [lasting, factor] = runs === 1 ? [this.noise, this.stretch] : [0, 1];
    return {
      log: Math.log(values[place]),
      ofMean: factor * Math.sqrt(square + lasting),
      ofNew: factor * Math.sqrt((1 + runs) * square + 2 * lasting),
    };
  }
}

/** Factors on the scaled quantities by one origin of intervals (millprint.fingerprint.bands.Factors). */
class Factors {
  constructor(content) {
    this.fills = content.fill_ratios;
    this.logs = this.fills.map(Math.log);
    this.factors = content.factors;
  }

  knows(fill) {
    return this.fills[0] * (1 - 1e-9) <= fill && fill <= this.fills.at(-1) * (1 + 1e-9);
  }

  /** The interval of a quantity's value at a fill ratio that is known; null for a quantity without factors. */
  interval(name, value, fill) {
    if (!(name in this.factors)) return null;
    const place = Math.min(Math.max(Math.log(fill), this.logs[0]), this.logs.at(-1));
    const above = Math.max(1, this.logs.findIndex((log) => log >= place));
    const between = (factors) => {
      if (factors.length === 1) return factors[0];
      const share = (place - this.logs[above - 1]) / (this.logs[above] - this.logs[above - 1]);
      return Math.exp((1 - share) * Math.log(factors[above - 1]) + share * Math.log(factors[above]));
    };
    const { lower, upper } = this.factors[name];
    return { lower: value * between(lower), upper: value * between(upper) };
  }
}

/** Every quantity from those of BASIC that have a curve, and Pn where the ratio has none; NaN for what is missing. */
function complete(read) {
  const { P, ratio = NaN, f = NaN, En_star = NaN, Et_star = NaN, f90 = NaN, Pn: own = NaN, rolling_ratio: rolls } = read;
  const Pn = Number.isNaN(ratio) ? own : P / (1 + ratio);
  const Pt = P - P / (1 + ratio);
  const Pr = rolls === undefined ? Math.max((read.Pw ?? NaN) - P, 0) : rolls * P;
  const weighted = { En_star, Et_star, fn_star: Pn / En_star, ft_star: Pt / Et_star, f90 };
  const powers = { Pn, Pt, P, Pr, Pw: P + Pr, rolling_ratio: Pr / P };
  const others = Object.fromEntries(OWN_CURVES.map((name) => [name, read[name] ?? NaN]));
  return { ...powers, f, ratio, En: Pn / f, Et: Pt / f, ...weighted, ...others };
}

/** What the scaled quantity of an observable is multiplied by in a condition, for one ball or one collision. */
function scaleOf({ scale }, { density_kg_m3, speed_hz, amplitude_m, ball_diameter_m }) {
  const { rho, omega, A, d } = CONTENT.scales[scale];
  return density_kg_m3 ** rho * speed_hz ** omega * amplitude_m ** A * ball_diameter_m ** d;
}

/** The neighbours of a value among others, below and above; at an end, that end twice. */
function around(values, asked) {
  const below = values.filter((value) => value <= asked + SAME);
  const above = values.filter((value) => value >= asked - SAME);
  return [below.length ? Math.max(...below) : Math.min(...values), above.length ? Math.min(...above) : Math.max(...values)];
}

/** Whether a condition without impacts is among those simulated around a point: as in millprint.fingerprint.layers. */
function isNearLayer(point, inputs, layers) {
  const isBetween = (value, [low, high]) => low - SAME <= value && value <= high + SAME;
  let near = [...inputs.map((row) => ({ row })), ...layers.map((row) => ({ row, isLayer: true }))];
  const boxes = Array.from(point, (value, k) => around(near.map(({ row }) => row[k]), value));
  near = near.filter(({ row }) => row.every((value, k) => k === 0 || isBetween(value, boxes[k])));
  return near.some(({ row, isLayer }) => {
    if (!isLayer) return false;
    const own = near.filter((other) => other.row.every((value, k) => k === 0 || Math.abs(value - row[k]) < SAME));
    return around(own.map((other) => other.row[0]), point[0]).some((fill) => Math.abs(fill - row[0]) < SAME);
  });
}

class Fingerprint {
  /**
   * content: a fingerprint's JSON; variables: their names in order; width: of its interval, in deviations; origins: of
   * intervals in addition to a new simulation's, each null in a band where it is not known.
   */
  constructor(content, variables, width, origins) {
    this.further = Object.fromEntries(origins.map((name) => [name, content[name] ? new Factors(content[name]) : null]));
    this.about = content.about;
    this.variables = variables;
    this.width = width;
    const conditions = content.inputs.fill_ratio.map((_, i) =>
      Object.fromEntries(Object.entries(content.inputs).map(([name, column]) => [name, column[i]])),
    );
    this.conditions = conditions.length;
    const inputs = conditions.map((condition) => this.point(condition));
    const { no_impacts: still = {} } = content;
    this.layers = (still.fill_ratio ?? []).map((_, i) =>
      this.point(Object.fromEntries(Object.entries(still).map(([name, column]) => [name, column[i]]))),
    );
    this.isUnknown = (point) => this.layers.length > 0 && isNearLayer(point, inputs, this.layers);
    this.processes = Object.fromEntries(
      Object.entries(content.processes).map(([name, process]) => [name, new LogProcess(process, inputs, this.layers)]),
    );
  }

  /**
   * A condition, with the mill's density and amplitude if it has none. `charge` names a charge of several ball sizes;
   * ball_diameter_m is then the diameter of its ball of mean volume.
   */
  whole(condition) {
    const { density_kg_m3, amplitude_m } = this.about;
    return { density_kg_m3, amplitude_m, ...condition };
  }

  /** Whether nothing is known of hits in a condition: one without impacts is at it or next to it. */
  isNearLayers(condition) {
    return this.isUnknown(this.point(condition));
  }

  /** The fill ratios of the conditions without impacts. */
  get layerFills() {
    return this.layers.map((row) => Math.exp(row[0]));
  }

  /** The inputs of the processes for a condition: logarithms and, with several kinds of balls, the place of its kind. */
  point(condition) {
    const { kinds } = this.about;
    const place = kinds ? [kinds.indexOf(condition.charge ?? ONE_SIZE)] : [];
    return Float64Array.from([...this.variables.map((name) => Math.log(condition[name])), ...place]);
  }

  /** Diameters [m] of the simulated balls of one charge; an empty list if it was not simulated. */
  diameters(charge) {
    const { ball_diameter_m, charge: charges } = this.about.settings;
    return ball_diameter_m.filter((_, i) => (charges?.[i] ?? ONE_SIZE) === charge);
  }

  /** The kinds of balls to choose from: balls of one size, if there are any, and each charge. */
  get media() {
    const charges = Object.keys(this.about.charges ?? {});
    return this.diameters(ONE_SIZE).length ? [ONE_SIZE, ...charges] : charges;
  }

  /** Charge and diameter [m] of balls, given by a diameter [mm] or by a charge's name; null if nothing is known of them. */
  chosen(choice) {
    if (typeof choice === "number") {
      return this.media.includes(ONE_SIZE) ? { charge: ONE_SIZE, ball_diameter_m: choice * 1e-3 } : null;
    }
    const found = this.about.charges?.[choice];
    return found ? { charge: choice, ball_diameter_m: found.ball_diameter_m } : null;
  }

  /** How many of `balls` have each size of a charge, by the largest remainders. */
  counts(charge, balls) {
    const exact = this.about.charges[charge].fractions.map((fraction) => balls * fraction);
    const found = exact.map(Math.trunc);
    const byRemainder = exact.map((_, k) => k).sort((one, other) => found[one] - exact[one] - (found[other] - exact[other]));
    const missing = balls - found.reduce((sum, count) => sum + count, 0);
    for (const k of byRemainder.slice(0, missing)) found[k] += 1;
    return found;
  }

  /** The simulated range of a variable; for the ball diameter, of balls of the same kind. */
  range(name, charge = ONE_SIZE) {
    const own = name === "ball_diameter_m" && this.about.charges ? this.diameters(charge) : [];
    return own.length ? [Math.min(...own), Math.max(...own)] : this.about.ranges[name];
  }

  /** The quantities that `complete` needs, each by `of` its process. */
  read(of, names = BASIC) {
    const needed = [...names, "Pn"].filter((name) => name in this.processes);
    return complete(Object.fromEntries(needed.map((name) => [name, Math.exp(of(name, this.processes[name]))])));
  }

  /** Scaled quantities of collisions without bands, on the curves; NaN around conditions without impacts. */
  means(condition) {
    const point = this.point(condition);
    const isUnknown = this.isUnknown(point);
    return this.read((name, process) => (isUnknown ? NaN : process.mean(point)), OF_COLLISIONS);
  }

  /** Scaled quantities with the band of a new simulation; the mean's band is the first of the further intervals. */
  scaled(condition) {
    const point = this.point(condition);
    const isUnknown = this.isUnknown(point);
    const logs = Object.fromEntries(
      Object.entries(this.processes).map(([name, process]) => {
        const own = process.predict(point);
        // In a condition without impacts, powers are known.
        return [name, isUnknown && !process.asSimulated(point) ? { ...own, log: NaN } : own];
      }),
    );
    const values = this.read((name) => logs[name].log);
    const found = Object.fromEntries(
      Object.entries(values).map(([name, value]) => {
        const ends = (kind) => this.ends(name, value, (of) => this.width * logs[of][kind], logs);
        const further = { ...this.intervals(name, value, condition.fill_ratio), mean: ends("ofMean") };
        return [name, { value, ...ends("ofNew"), further }];
      }),
    );
    if (Number.isNaN(found.Pt.value)) return found;
    const { Pn, Pt, Pr } = found;
    return { ...found, ...(Number.isNaN(found.Pw.value) ? partsOf(found.P, { Pn, Pt }) : partsOf(found.Pw, { Pn, Pt, Pr })) };
  }

  /** The ends of a band, NaN where it says nothing; half: half the width of a quantity's band in logarithms. */
  ends(name, value, half, logs) {
    let [below, above] = name in logs ? [half(name), half(name)] : [NaN, NaN];
    const { whole, of, share, rises } = PARTS[name] ?? {};
    if (whole in logs && of in logs) {
      // As in millprint.fingerprint.predicted_values: no end of a part is beyond the whole.
      const ratio = Math.exp(logs[of].log);
      const away = (sign) => Math.hypot(half(whole), Math.log(share(ratio * Math.exp(sign * half(of))) / share(ratio)));
      [below, above] = rises ? [away(-1), away(1)] : [away(1), away(-1)];
    }
    const isKnown = below + above <= Math.log(WIDEST);
    return { lower: isKnown ? value * Math.exp(-below) : NaN, upper: isKnown ? value * Math.exp(above) : NaN };
  }

  /** The interval of a scaled quantity by each further origin. */
  intervals(name, value, fill) {
    return Object.fromEntries(
      Object.entries(this.further).map(([origin, factors]) => [
        origin,
        factors?.knows(fill) ? factors.interval(name, value, fill) : null,
      ]),
    );
  }

  /** Why the interval of an origin is not known at a fill ratio. */
  missing(origin, fill) {
    const factors = this.further[origin];
    if (!factors) return "not analysed for this contact set";
    return factors.knows(fill) ? "" : `analysed at fill ratios from ${factors.fills[0]} to ${factors.fills.at(-1)}`;
  }

  balls(condition) {
    return roundHalfEven(
      (condition.fill_ratio * this.about.volume_m3) / ((Math.PI / 6) * condition.ball_diameter_m ** 3),
    );
  }

  /** A condition with a simulated fill ratio that has as many whole balls, beyond the ends and without impacts. */
  ofBalls(condition) {
    const { fill_ratio: fill } = condition;
    const [low, high] = this.about.ranges.fill_ratio;
    const apart = (other) => Math.abs(Math.log(other / fill));
    const nearest = { ...condition, fill_ratio: this.isNearLayers(condition)
      ? this.layerFills.reduce((one, other) => (apart(other) < apart(one) ? other : one))
      : Math.min(Math.max(fill, low), high) };
    return this.balls(nearest) === this.balls(condition) ? nearest : condition;
  }

  outside(condition) {
    const { charge = ONE_SIZE } = condition;
    const near = this.isNearLayers(condition);
    const beyond = this.variables.filter((name) => {
      const known = this.range(name, charge);
      // Fill ratios without impacts were simulated too.
      const ends = near && name === "fill_ratio" ? [...known, ...this.layerFills] : known;
      return !(Math.min(...ends) * (1 - 1e-9) <= condition[name] && condition[name] <= Math.max(...ends) * (1 + 1e-9));
    });
    return [...beyond, ...(this.media.includes(charge) ? [] : ["charge"]), ...(near ? [NO_IMPACTS] : [])];
  }

  /** The observables of a condition by Eqs 3.28, 3.29 and 4.5, each with its interval. */
  predict(given) {
    const condition = this.ofBalls(this.whole(given));
    const scaled = this.scaled(condition);
    const balls = this.balls(condition);
    const bands = { ...scaled, share: share(scaled.ratio) };
    const found = OBSERVABLES.map((own) => [own.name, times(bands[own.curve], (own.adds_up ? balls : 1) * scaleOf(own, condition))]);
    return { balls, ...Object.fromEntries(found), outside: this.outside(condition) };
  }

  /** The descriptors of collisions without bands. */
  descriptors(condition) {
    const scaled = this.means(condition);
    return Object.fromEntries(BY_COLLISION.map((own) => [own.name, scaled[own.curve] * scaleOf(own, condition)]));
  }
}

/** A band through a rising function: value, band of a new simulation, and each further interval, null if not known. */
function through({ value, lower, upper, further = {} }, rising) {
  const others = Object.entries(further).map(([origin, interval]) => [
    origin,
    interval && { lower: rising(interval.lower), upper: rising(interval.upper) },
  ]);
  return { value: rising(value), lower: rising(lower), upper: rising(upper), further: Object.fromEntries(others) };
}

/** Parts with intervals that say no more than the whole allows, as millprint.estimate.estimates.parts_of. */
function partsOf(whole, parts) {
  const isKnown = (ends) => ends && !Number.isNaN(ends.lower + ends.upper);
  const limited = (part, endsOf) => {
    const [own, all] = [part, whole].map(endsOf);
    if (!isKnown(own) || !isKnown(all)) return own;
    const others = Object.values(parts).filter((each) => each !== part).map(endsOf);
    const rest = (end, unknown) => others.reduce((sum, each) => sum + (isKnown(each) ? each[end] : unknown), 0);
    return {
      lower: Math.min(Math.max(own.lower, all.lower - rest("upper", Infinity)), part.value),
      upper: Math.max(Math.min(own.upper, all.upper - rest("lower", 0)), part.value),
    };
  };
  return Object.fromEntries(
    Object.entries(parts).map(([name, part]) => {
      const further = Object.keys(part.further).map((origin) => [origin, limited(part, (each) => each.further[origin])]);
      const { lower, upper } = limited(part, (each) => each);
      return [name, { ...part, lower, upper, further: Object.fromEntries(further) }];
    }),
  );
}

function times(band, factor) {
  return through(band, (end) => end * factor);
}

/** Et / (En + Et) from Et / En; it rises with it. */
function share(ratio) {
  return through(ratio, (end) => end / (1 + end));
}
