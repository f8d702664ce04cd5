/* The averaged yield model, as millprint.thesis.yields.averaging computes it. */

const LINKS = {
  identity: { forward: (y) => y, inverse: (z) => z },
  logit: { forward: (y) => Math.log(y / (1 - y)), inverse: (z) => 1 / (1 + Math.exp(-z)) },
  avrami: {
    forward: (y) => Math.log(-Math.log1p(-y)),
    inverse: (z) => -Math.expm1(-Math.exp(Math.min(z, 30))),
  },
};

/** One Gaussian process of the yield through its link (millprint.thesis.yields.averaging). */
class Member {
  constructor(stored, shared) {
    Object.assign(this, stored);
    this.shared = shared;
    this.squaredLengths = this.input_spread.map((_, k) => Math.exp(2 * this.log_parameters[k]));
    const count = this.input_spread.length;
    this.variances = this.terms.map((_, t) => Math.exp(this.log_parameters[count + t]));
    this.noise = Math.exp(this.log_parameters.at(-1));
    const matrix = this.known.map((row) => this.covariance(row));
    matrix.forEach((row, i) => {
      row[i] += this.noise + shared.jitter;
    });
    this.factor = cholesky(matrix);
    this.weights = solveFactored(this.factor, this.target);
  }

  between(left, right) {
    let sum = this.shared.mean_variance;
    this.terms.forEach(({ factors, linear }, t) => {
      if (linear) {
        sum += this.variances[t] * factors.reduce((all, f, k) => all + f * left[k] * right[k], 0);
        return;
      }
      let square = 0;
      for (let k = 0; k < factors.length; k += 1) {
        if (factors[k]) square += (left[k] - right[k]) ** 2 / this.squaredLengths[k];
      }
      sum += this.variances[t] * Math.exp(-0.5 * square);
    });
    return sum;
  }

  covariance(point) {
    return Float64Array.from(this.known, (row) => this.between(point, row));
  }

  /** Mean and deviation of link(y) of a measurement. */
  latent(inputs) {
    const point = inputs.map(
      (value, k) => ((this.scales[k] === "log" ? Math.log(value) : value) - this.input_mean[k]) / this.input_spread[k],
    );
    const covariance = this.covariance(point);
    const solved = solveLower(this.factor, covariance);
    const own = Math.max(0, this.between(point, point) - dot(solved, solved));
    return {
      mean: this.target_mean + this.target_spread * dot(covariance, this.weights),
      deviation: this.target_spread * Math.sqrt(own + this.noise),
    };
  }

  expected({ mean, deviation }) {
    const { nodes, node_weights: weights } = this.shared;
    return nodes.reduce((sum, node, i) => sum + weights[i] * LINKS[this.link].inverse(mean + deviation * node), 0);
  }

  /** P(y <= conversion). */
  below(conversion, { mean, deviation }) {
    if (this.link === "identity") return normalCdf((conversion - mean) / deviation);
    if (conversion <= 0) return 0;
    if (conversion >= 1) return 1;
    const inside = Math.min(Math.max(conversion, 1e-12), 1 - 1e-12);
    return normalCdf((LINKS[this.link].forward(inside) - mean) / deviation);
  }
}

class YieldModel {
  constructor(content) {
    this.content = content;
    this.members = content.members.map((stored) => new Member(stored, content));
  }

  /** The inputs of the model for a run: conditions, power of one ball [mW] and tangential share. */
  inputs(conditions) {
    const both = conditions.normal_energy_uJ + conditions.tangential_energy_uJ;
    const derived = {
      power_per_ball_mW: both * conditions.specific_frequency_hz * 1e-3,
      tangential_share: conditions.tangential_energy_uJ / both,
    };
    const all = { ...conditions, ...derived };
    return this.content.inputs.map((name) => all[name]);
  }

  quantile(latent, level) {
    let [low, high] = this.content.search;
    for (let step = 0; step < this.content.bisections; step += 1) {
      const middle = (low + high) / 2;
      const below = this.members.reduce((sum, member, i) => sum + member.weight * member.below(middle, latent[i]), 0);
      if (below < level) low = middle;
      else high = middle;
    }
    return 100 * Math.min(Math.max((low + high) / 2, 0), 1);
  }

  /** Mean yield and the central interval of a measurement [%], and what is outside the trained range; NaN without energies. */
  predict(conditions) {
    const inputs = this.inputs(conditions);
    if (inputs.some(Number.isNaN)) return { value: NaN, lower: NaN, upper: NaN, outside: this.outside(conditions) };
    const latent = this.members.map((member) => member.latent(inputs));
    const { level } = this.content;
    return {
      value: 100 * this.members.reduce((sum, member, i) => sum + member.weight * member.expected(latent[i]), 0),
      lower: this.quantile(latent, (1 - level) / 2),
      upper: this.quantile(latent, (1 + level) / 2),
      outside: this.outside(conditions),
    };
  }

  outside(conditions) {
    const both = conditions.normal_energy_uJ + conditions.tangential_energy_uJ;
    const all = { ...conditions, tangential_share: conditions.tangential_energy_uJ / both };
    return Object.entries(this.content.ranges)
      .filter(([name, [low, high]]) => !(low <= all[name] && all[name] <= high))
      .map(([name, [low, high]]) => ({ name, value: all[name], low, high }));
  }
}
