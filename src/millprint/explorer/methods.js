/* A paragraph for the methods section of a paper, from the state and its numbers. */

function methodsText(explorer, found) {
  const { mill, fingerprint, state, units, content } = explorer;
  const { about } = fingerprint;
  const { unit, to } = units.of("speed");
  const rpm = unit === "rpm" ? "" : ` (${setting(60 * state.speed_hz)} rpm)`;
  const gravity = units.acceleration > 0 && unit !== "g" ? `, with up to ${digits(units.acceleration * state.speed_hz ** 2)} g at a wall` : "";
  const balls = state.charge === ONE_SIZE || !about.charges?.[state.charge]
    ? `${found.balls} balls of ${short(Number((1e3 * state.ball_diameter_m).toPrecision(4)))} mm`
    : `${found.balls} balls (${state.charge}: ${chargeInWords(fingerprint, state.charge, found.balls)})`;
  const [low, high] = about.ranges.speed_hz.map(to);
  const interval = short(100 * about.probability);
  const band = (name) => {
    const scale = unitOf(RESULTS[name], units, found[name].value);
    const own = inUnit(found[name], scale);
    return `${digits(own.value)} ${scale.unit} (${between(own)})`;
  };
  const said = [
    `The milling was characterised by the discrete element method with millprint ${content.version}, with balls and without powder.`,
    `Mill: ${mill.content.title} (nominal volume ${short(1e6 * about.volume_m3)} mL)${mill.content.words ? `; ${mill.content.words}` : ""}.`,
    `Settings: ${setting(to(state.speed_hz))} ${unit}${rpm}${gravity}; ${balls} with a density of ${short(state.density_kg_m3)} kg/m³, ${digits(found.balls_g)} g in all, ` +
      `which fill ${short(Number((100 * state.fill_ratio).toPrecision(3)))} % of the jar's volume.`,
    `Contact set ${about.contact}, an assumption on balls and powder: ${coefficientWords(about)}${wallWords(about)}.`,
    `The numbers are predictions of a model that was fitted to ${fingerprint.conditions} simulated conditions (fill ratios from ${fromTo(...about.ranges.fill_ratio)}, ` +
      `speeds of ${fromTo(low, high)} ${unit}, balls of ${fromTo(...about.ranges.ball_diameter_m.map((size) => 1e3 * size))} mm); in brackets is the band in which ${interval} % of new simulations are expected.`,
    `The energy-weighted mean energy of a collision (sum of squares over sum) is ${band("weighted_normal_energy_J")} along the line of centres and ` +
      `${band("weighted_tangential_energy_J")} along the surface; the power of a ball over it is ${band("weighted_normal_frequency_hz")} and ${band("weighted_tangential_frequency_hz")}.`,
    `Contacts of a pair (two balls, or a ball and a ${about.collisions_by} of the wall) that follow each other within ${short(about.collision_gap_turns)} turns count as one collision.`,
    `A collision dissipates on average ${band("normal_energy_J")} along the line of centres and ${band("tangential_energy_J")} along the surface; ` +
      `all collisions over the balls: ${band("specific_frequency_hz")}.`,
    `The walls supply a power of ${band("wall_power_W")}, which all balls dissipate: ${band("normal_power_W")} by compression, ` +
      `${band("tangential_power_W")} by shear and ${band("rolling_power_W")} by rolling.`,
    ...mill.further.map((origin) => furtherWords(explorer, found, origin)),
    `With ${digits(found.powder_g)} g of powder (ball-to-powder mass ratio ${short(Number(state.bpr.toPrecision(3)))}) for ${timeText(state.time_h)}, the specific energy is at most ${units.text("dose", found.dose_J_kg.value)}.`,
    ...explorer.finder.matchedWords(found),
    ...fewTurnsWords(fingerprint),
    ...(beyondOf(found).length ? [`Outside the simulated range: ${listed(beyondOf(found))}.`] : []),
    ...noImpactsWords(found),
    `(Fingerprint file with SHA-256 ${mill.content.fingerprints[explorer.contact].digest}….)`,
  ];
  return said.join(" ");
}

/** Coefficients between balls, those that the contact law has. */
function coefficientWords({ restitution, static_friction: friction }) {
  return restitution === undefined
    ? `coefficient of static friction ${short(friction)}`
    : `coefficient of restitution ${short(restitution)}, of static friction ${short(friction)}`;
}

/** Coefficients at the wall, if they differ. */
function wallWords(about) {
  const own = { wall_restitution: "restitution", wall_static_friction: "static friction" };
  const words = Object.entries(own).filter(([key]) => key in about).map(([key, name]) => `${name} ${short(about[key])}`);
  return words.length ? ` (at the wall: ${words.join(", ")})` : "";
}

/** The interval of the power by an origin other than a new simulation. */
function furtherWords({ mill, fingerprint, state, units }, found, origin) {
  const { title } = mill.content.origins[origin];
  const interval = found.wall_power_W.further[origin];
  const ends = ({ lower, upper }) => `${powerText(lower, units)} and ${powerText(upper, units)}`;
  if (origin === "mean") {
    return Number.isNaN(interval.lower)
      ? "The mean power of very many simulations is not known."
      : `The mean power of very many simulations is between ${ends(interval)}.`;
  }
  return interval
    ? `By ${title} only, the power is between ${ends(interval)}.`
    : `The interval by ${title} is not known (${fingerprint.missing(origin, state.fill_ratio)}).`;
}

/** Copy the text of an element; without access to the clipboard it stays selected. */
async function copyText(source, said) {
  try {
    await navigator.clipboard.writeText(source.textContent);
    said.textContent = "Copied.";
    return;
  } catch {
    // A page in a frame, or opened without permission.
  }
  getSelection().selectAllChildren(source);
  said.textContent = document.execCommand("copy") ? "Copied." : "Selected: copy it with the keyboard.";
}
