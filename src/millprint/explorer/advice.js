/* What the numbers can be used for and what not, as far as it follows from the mill and the state. */

// Origins of intervals that are analysed afterwards, if at all.
const AFTERWARDS = { contact: ["friction", "restitution"], shape: ["shape of the jar"] };

/** Two lists of sentences, {use, avoid}, for a condition and its answer. */
function adviceFor(explorer, found) {
  const { mill, mills, fingerprint, state } = explorer;
  const { about } = fingerprint;
  const fills = fromTo(...about.ranges.fill_ratio);
  const use = [];
  const avoid = [];
  const beyond = beyondOf(found);
  if (beyond.length) {
    avoid.push(`A decision on these settings: ${listed(beyond)} ${beyond.length > 1 ? "were" : "was"} not simulated here, and the scaling laws were not tested so far from the simulations.`);
  }
  const unknown = Object.keys(RESULTS).filter((name) => Number.isNaN(found[name].lower + found[name].upper));
  if (found.outside.includes(NO_IMPACTS)) {
    avoid.push("Any decision by hits: here or in a simulated condition next to this one, all balls move as one layer and nothing hits. Take a higher fill ratio.");
  } else if (unknown.length) {
    const names = listed(unknown.map((name) => RESULTS[name].label.replace(/^[A-Z](?=[a-z])/, (letter) => letter.toLowerCase())));
    avoid.push(`A decision by the ${names}: not known here. More simulations tell: millprint fingerprint ${mill.name} --config 'mills={precision: fine}'.`);
  } else if (!found.outside.length) {
    use.push("These settings: all of them are within the simulated ranges.");
  }
  use.push(`To compare settings of this mill with each other, at fill ratios from ${fills}: ratios are more certain than values.`);
  use.push(
    mills.length > 1
      ? "To find settings of another mill with nearly the same collisions, by the search below."
      : "To find other settings with nearly the same collisions, by the search below.",
  );
  const isKnown = (origin) => mill.further.includes(origin) && !fingerprint.missing(origin, state.fill_ratio);
  const [known, given] = [true, false].map((wanted) => Object.keys(AFTERWARDS).filter((origin) => isKnown(origin) === wanted).flatMap((origin) => AFTERWARDS[origin]));
  if (known.length) use.push(`To judge the effect of unknown ${listed(known)}: it has a separate interval.`);
  if (given.length) avoid.push(`The interval as the whole error: ${listed(given)} ${given.length > 1 ? "are" : "is"} taken as given.`);
  avoid.push("The load on single grains of powder: the simulation has balls without powder. Specific energy and hits are upper bounds.");
  const warmest = mill.content.heat && explorer.heat.shown();
  if (warmest && warmest.over_limit_share > 0) {
    avoid.push(`A long run without checking the temperatures: ${digits(100 * warmest.over_limit_share, 2)} % of the samples exceed ${short(warmest.limit_degC)} °C.`);
  }
  if (mill.yieldModel) {
    const outside = found.yield_percent.outside;
    if (outside.length) avoid.push(`The yield at these settings: ${listed(outside.map(({ name }) => NAMES[name]))} ${outside.length > 1 ? "are" : "is"} outside the range that the yield model was trained on.`);
    else use.push("To rank recipes of the powder that the yield model was trained on, in this jar.");
    avoid.push("Yields of another powder, jar or contact set: the yield model was trained on one chemistry in one jar.");
  }
  return { use, avoid };
}

function renderAdvice(explorer, found) {
  const { use, avoid } = adviceFor(explorer, found);
  const items = (list) => list.map((text) => element("li", {}, text));
  byId("use-for").replaceChildren(...items(use));
  byId("avoid-for").replaceChildren(...items(avoid));
}
