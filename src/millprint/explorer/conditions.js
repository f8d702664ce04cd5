/* The simulated conditions of all mills, to choose from, and which are nearest to the sliders. */

// Another contact set or another charge is farther away than any ratio of two settings.
const OTHER = 10;
const COMPARED = ["fill_ratio", "speed_hz", "ball_diameter_m", "density_kg_m3", "amplitude_m"];

/** How far a simulated condition is from a state: root of the sum of squared logarithms of ratios. */
function distanceTo(simulated, state, contact) {
  const logs = COMPARED.map((name) => Math.log(simulated[name] / state[name]));
  const others = (simulated.contact !== contact) + (simulated.charge !== state.charge);
  return norm(logs) + OTHER * others;
}

/** The conditions, nearest first. */
function byDistance(conditions, state, contact) {
  const far = conditions.map((each) => [distanceTo(each, state, contact), each]);
  return far.sort(([one], [other]) => one - other).map(([, each]) => each);
}

/**
 * The nearest condition, and one to compare it with: the nearest with the same balls at another speed; if there is none,
 * at another fill ratio; if there is none either, the next nearest of all.
 */
function nearestTwo(conditions, state, contact) {
  const [first, ...others] = byDistance(conditions, state, contact);
  const differs = (each) => COMPARED.filter((name) => each[name] !== first[name]).join();
  const alike = others.filter((each) => each.contact === first.contact && each.charge === first.charge);
  const second = ["speed_hz", "fill_ratio"].map((name) => alike.find((each) => differs(each) === name)).find(Boolean);
  return [first, second ?? others[0] ?? first];
}

/** A condition in words, with its speed in the chosen unit. */
function conditionWords(condition, units) {
  const { unit, to } = units.of("speed");
  return `${condition.words}, ${setting(to(condition.speed_hz))} ${unit}`;
}
