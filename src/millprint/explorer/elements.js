/* Elements of the page, and numbers as text. */

const SVG = "http://www.w3.org/2000/svg";

/** An element with attributes and children; text where a child is a string. */
function element(name, attributes = {}, ...children) {
  const made = name.startsWith("svg:")
    ? document.createElementNS(SVG, name.slice(4))
    : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const byId = (id) => document.getElementById(id);

/** Fill a list of options, each a value and its text, or a group of them: {label, options}. */
function fillOptions(choice, options) {
  const option = ([value, text]) => element("option", { value }, text);
  choice.replaceChildren(
    ...options.map((each) =>
      each.options ? element("optgroup", { label: each.label }, ...each.options.map(option)) : option(each),
    ),
  );
}

/** A number with three digits, rounded before its form is chosen: 999.6 is 1000. */
function digits(value, count = 3) {
  if (!Number.isFinite(value)) return "–";
  const rounded = Number(value.toPrecision(count));
  const size = Math.abs(rounded);
  if (size >= LARGE || (size && size < SMALL)) return inPowers(rounded, count);
  return size >= 10 ** count ? String(rounded) : rounded.toPrecision(count);
}

// Smaller and larger numbers are written in powers of ten, which no row of zeros makes longer than their place.
const SMALL = 1e-3;
const LARGE = 1e4;

const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/** A whole power of ten: 10⁻³. */
function powerOfTen(exponent) {
  return `10${[...String(exponent)].map((sign) => SUPERSCRIPTS[sign]).join("")}`;
}

function inPowers(value, count) {
  const [front, exponent] = value.toExponential(count - 1).split("e");
  return `${front}·${powerOfTen(Number(exponent))}`;
}

/** A setting of a machine: a whole number, or up to four digits of a small one. */
const setting = (value) => (value >= 100 ? String(Math.round(value)) : short(Number(value.toPrecision(4))));

/** A number with up to six digits, as a field takes it. */
function short(value) {
  const rounded = Number(value.toPrecision(6));
  return rounded && Math.abs(rounded) < SMALL ? rounded.toExponential() : String(rounded);
}

/** "low to high" of settings, or the one number if both are the same. */
const fromTo = (low, high) => [...new Set([low, high].map(setting))].join(" to ");

/** Bring a part of the page into view, and the keyboard with it. */
function goTo(id) {
  const part = byId(id);
  part.tabIndex = -1;
  part.focus({ preventScroll: true });
  part.scrollIntoView({ block: "start" });
}

/** A quantity with its unit; "-" for one that has none. */
function withUnit(label, unit) {
  return `${label} [${unit || "-"}]`;
}

/** "a, b and c" */
function listed(words) {
  return words.length < 2 ? words.join("") : `${words.slice(0, -1).join(", ")} and ${words.at(-1)}`;
}

/** A time as people say it: 12 s, 11 min, 2.5 h. */
function durationWords(hours) {
  if (hours >= 1) return `${digits(hours)} h`;
  return hours >= 1 / 60 ? `${digits(60 * hours, 2)} min` : `${digits(3600 * hours, 2)} s`;
}
