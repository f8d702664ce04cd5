/* Conditions whose descriptors come nearest to a target, as millprint.fingerprint.condition_search finds them. */

/** Weighted residuals log(found / target), whose root sum of squares is the distance. */
function residualsOf(found, target, weights) {
  const names = Object.keys(target);
  const total = names.reduce((sum, name) => sum + weights[name], 0);
  return names.map((name) => Math.sqrt(weights[name] / total) * Math.log(found[name] / target[name]));
}

const norm = (values) => Math.sqrt(dot(values, values));
const clamp = (value, [low, high]) => Math.min(Math.max(value, low), high);

/** Fill ratio and speed [Hz] of every local minimum of the distance for one kind of ball. */
function localMinima(residualsAt, fills, speeds, grid) {
  const axes = [fills, speeds].map(([low, high], k) => geomspace(low, high, high > low ? grid[k] : 1));
  const values = axes[0].map((fill) => axes[1].map((speed) => norm(residualsAt([Math.log(fill), Math.log(speed)]))));
  const bounds = [fills.map(Math.log), speeds.map(Math.log)];
  const found = [];
  values.forEach((row, i) =>
    row.forEach((value, j) => {
      // Nothing is known of hits there.
      if (Number.isNaN(value)) return;
      for (let a = Math.max(0, i - 1); a <= Math.min(values.length - 1, i + 1); a += 1) {
        for (let b = Math.max(0, j - 1); b <= Math.min(row.length - 1, j + 1); b += 1) {
          if (values[a][b] < value) return;
        }
      }
      found.push(refine(residualsAt, [Math.log(axes[0][i]), Math.log(axes[1][j])], bounds));
    }),
  );
  return found;
}

/** Levenberg and Marquardt's descent of the squared residuals within bounds, from a place in logarithms. */
function refine(residualsAt, start, bounds) {
  const step = 1e-6;
  let place = start;
  let residuals = residualsAt(place);
  let damping = 1e-3;
  for (let count = 0; count < 100 && damping < 1e12; count += 1) {
    const slopes = place.map((_, k) => {
      const [ahead, behind] = [step, -step].map((by) => residualsAt(place.map((x, m) => (m === k ? x + by : x))));
      return ahead.map((value, r) => (value - behind[r]) / (2 * step));
    });
    const gradient = slopes.map((slope) => dot(slope, residuals));
    // A place at a bound that the descent would leave stays there.
    const free = place.map((x, k) => !((x <= bounds[k][0] && gradient[k] > 0) || (x >= bounds[k][1] && gradient[k] < 0)));
    const move = solvePair(slopes, gradient, free, damping);
    const next = place.map((x, k) => clamp(x + move[k], bounds[k]));
    const there = residualsAt(next);
    if (norm(there) < norm(residuals)) {
      const gain = norm(residuals) ** 2 - norm(there) ** 2;
      [place, residuals, damping] = [next, there, damping / 10];
      if (gain < 1e-18) break;
    } else {
      damping *= 10;
    }
  }
  return place.map(Math.exp);
}

/** The damped Gauss-Newton step of two variables, some of which are held. */
function solvePair(slopes, gradient, free, damping) {
  const [a, d] = slopes.map((slope) => dot(slope, slope) * (1 + damping) + 1e-12);
  const b = free[0] && free[1] ? dot(slopes[0], slopes[1]) : 0;
  const [g, h] = gradient.map((value, k) => (free[k] ? value : 0));
  const determinant = a * d - b * b;
  return [(b * h - d * g) / determinant, (b * g - a * h) / determinant];
}

/**
 * The nearest conditions, nearest first; of those that come equally near, the one first that changes the milling time
 * least. target: a Target; allowed: speeds_hz and fill_ratios from-to, balls (diameters [mm], names of charges) and
 * densities_kg_m3 as lists (an empty one: each fingerprint's own).
 */
async function rankConditions(target, fingerprints, allowed, { weights, ranked, grid, nearPercent }, breathe = async () => {}) {
  const { values } = target;
  const rows = [];
  for (const fingerprint of fingerprints) {
    const [low, high] = fingerprint.about.ranges.fill_ratio;
    const fills = [Math.max(low, allowed.fill_ratios[0]), Math.min(high, allowed.fill_ratios[1])];
    const densities = allowed.densities_kg_m3.length ? allowed.densities_kg_m3 : [fingerprint.about.density_kg_m3];
    if (fills[0] > fills[1]) continue;
    for (const media of allowed.balls.map((choice) => fingerprint.chosen(choice)).filter(Boolean)) {
      for (const density_kg_m3 of densities) {
        const at = ([fill, speed]) =>
          fingerprint.whole({ fill_ratio: fill, speed_hz: speed, density_kg_m3, ...media });
        const residualsAt = (place) =>
          residualsOf(fingerprint.descriptors(at(place.map(Math.exp))), values, weights);
        await breathe();
        for (const place of localMinima(residualsAt, fills, allowed.speeds_hz, grid)) {
          const condition = at(place);
          const prediction = fingerprint.predict(condition);
          const found = Object.fromEntries(Object.keys(values).map((name) => [name, prediction[name].value]));
          const distance = norm(residualsOf(found, values, weights));
          rows.push({ fingerprint, condition, distance, prediction, ...target.judge(condition, prediction, nearPercent) });
        }
      }
    }
  }
  const near = ({ distance }) => Number(distance.toFixed(EQUALLY_NEAR));
  const change = ({ time }) => (time ? Math.abs(Math.log(time.value)) : 0);
  rows.sort((one, other) => one.distance - other.distance);
  if (target.power_W_kg) rows.sort((one, other) => near(one) - near(other) || change(one) - change(other));
  return distinct(rows).slice(0, ranked);
}

/** The rows without duplicates from different starts of the search. */
function distinct(rows) {
  const seen = new Set();
  return rows.filter(({ fingerprint, condition }) => {
    const { contact } = fingerprint.about;
    const { ball_diameter_m, charge, density_kg_m3, fill_ratio, speed_hz } = condition;
    const key = [contact, charge, ball_diameter_m, density_kg_m3, fill_ratio.toFixed(3), (60 * speed_hz).toFixed(0)].join();
    return !seen.has(key) && seen.add(key);
  });
}
