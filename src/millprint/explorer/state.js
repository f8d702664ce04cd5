/* The state of the page in its address and as a file, so that a link or a file shows the same again. */

const VERSION = 1;
const FORMAT = "millprint explorer state";
// The browser is asked to write the address once the user pauses, at most this often [ms].
const PAUSE_MS = 300;
const UNIT_KEYS = Object.keys(UNITS).map((kind) => [`unit_${kind}`, kind]);

/** The state as flat values, numbers in SI. */
function stateOf(explorer) {
  const { mill, state, axis, shaded, units, spectra, heat } = explorer;
  return {
    mill: mill.name,
    contact: explorer.fingerprint.about.contact,
    ...state,
    axis,
    shaded,
    ...Object.fromEntries(UNIT_KEYS.map(([key, kind]) => [key, units.choice(kind)])),
    spectra_shown: spectra.shown,
    spectra_first: spectra.chosen[0],
    spectra_second: spectra.chosen[1],
    heat: heat.chosen,
  };
}

/**
 * Apply a state, as far as the page knows its names. Returns what could not be applied, in words; nothing is applied for
 * a mill that the page does not have.
 */
function takeState(explorer, given) {
  const told = [];
  const mill = explorer.mills.find((each) => each.name === given.mill);
  if (!mill) return [`mill = ${given.mill ?? "none"}: this page has ${listed(explorer.mills.map((each) => each.name))}`];
  explorer.useMill(mill);
  // An address has no empty values.
  explorer.spectra.chosen = [NEAREST, NEAREST];
  explorer.heat.chosen = NEAREST;
  /** Call `take` with a named value; a value that `isKnown` refuses is reported. */
  const each = (key, isKnown, take) => {
    if (!(key in given)) return;
    if (isKnown(given[key])) take(given[key]);
    else told.push(`${key} = ${given[key]} is not known here`);
  };
  const contacts = mill.fingerprints.map(({ about }) => about.contact);
  each("contact", (name) => contacts.includes(name), (name) => explorer.useContact(contacts.indexOf(name)));
  each("charge", (name) => explorer.fingerprint.media.includes(name), (name) => explorer.take(name));
  for (const name of Object.keys({ ...SETTINGS, ...POWDER })) {
    // The diameter of a charge follows from it.
    if (!(name in given) || !(name in explorer.state) || (name === "ball_diameter_m" && explorer.state.charge !== ONE_SIZE)) continue;
    const value = Number(given[name]);
    if (given[name] === "" || !(value > 0) || !Number.isFinite(value)) {
      told.push(`${name} = ${given[name]} is not a number above 0`);
      continue;
    }
    const [low, high] = mill.limits(name);
    explorer.state[name] = clamp(value, [low * (1 - 1e-9), high * (1 + 1e-9)]);
    if (explorer.state[name] !== value) told.push(`${name} = ${value} is beyond the slider's end, ${short(explorer.state[name])}`);
  }
  for (const [key, kind] of UNIT_KEYS) {
    each(key, (unit) => explorer.units.names(kind).includes(unit), (unit) => (explorer.chosenUnits[kind] = unit));
  }
  const axes = explorer.axes();
  each("axis", (name) => axes.includes(name), (name) => (explorer.axis = name));
  each("shaded", (name) => name in mill.content.origins, (name) => (explorer.shaded = name));
  each("spectra_shown", (name) => name in SHOWN, (name) => (explorer.spectra.shown = name));
  ["spectra_first", "spectra_second"].forEach((key, k) => {
    each(key, (name) => explorer.spectra.knows(name), (name) => (explorer.spectra.chosen[k] = name));
  });
  each("heat", (name) => explorer.heat.knows(name), (name) => (explorer.heat.chosen = name));
  return told;
}

class Keeper {
  constructor(explorer) {
    this.explorer = explorer;
  }

  start() {
    byId("save").addEventListener("click", () => this.save());
    byId("open").addEventListener("change", async (event) => {
      const [file] = event.target.files;
      if (file) this.read(await file.text());
      event.target.value = "";
    });
    byId("link").addEventListener("click", () => {
      this.write();
      copyText(byId("address"), byId("told"));
    });
    // In a frame of another page the address is not the user's.
    byId("link").hidden = !["file:", "http:", "https:"].includes(location.protocol);
    addEventListener("hashchange", () => this.readAddress());
  }

  /** The state in the form that follows the # of the address. */
  get fragment() {
    const filled = Object.entries(stateOf(this.explorer)).filter(([, value]) => value !== "");
    return new URLSearchParams([["v", VERSION], ...filled]).toString();
  }

  /** The state has changed: write it into the address once the user pauses. */
  later() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.write(), PAUSE_MS);
  }

  /** Replace the address without a new entry in the history of the browser. */
  write() {
    clearTimeout(this.timer);
    const { fragment } = this;
    byId("address").textContent = new URL(`#${fragment}`, location.href).href;
    try {
      history.replaceState(null, "", `#${fragment}`);
    } catch {
      // A page in a frame may not have its own address; the file still keeps the state.
    }
  }

  /** Show the state of the address, if there is one. */
  readAddress() {
    const fragment = location.hash.slice(1);
    if (!fragment || fragment === this.fragment) return;
    const { v, ...given } = Object.fromEntries(new URLSearchParams(fragment));
    if (v === undefined && given.mill === undefined) return;
    this.show(v, given, "the address");
  }

  /** The file that keeps the state. */
  get file() {
    const { content } = this.explorer;
    const about = { format: FORMAT, version: VERSION, run: content.name, millprint: content.version };
    return `${JSON.stringify({ ...about, state: stateOf(this.explorer) }, null, 2)}\n`;
  }

  save() {
    const address = URL.createObjectURL(new Blob([this.file], { type: "application/json" }));
    element("a", { href: address, download: `${this.explorer.mill.name}_explorer.json` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
    byId("told").textContent = "Saved.";
  }

  /** Show the state of a file's text. */
  read(text) {
    let content = null;
    try {
      content = JSON.parse(text);
    } catch {
      // Reported below.
    }
    if (content?.format !== FORMAT || typeof content.state !== "object" || !content.state) {
      byId("told").textContent = `The file is not a state of this page: its format must be "${FORMAT}".`;
      return;
    }
    this.show(content.version, content.state, "the file");
    this.write();
  }

  /** Apply a state and say in one line what could not be applied. */
  show(version, given, source) {
    const { explorer } = this;
    const told = String(version) === String(VERSION)
      ? takeState(explorer, given)
      : [`version = ${version ?? "none"}: this page reads version ${VERSION}`];
    explorer.draw();
    byId("told").textContent = told.length ? `Not taken from ${source}: ${told.join("; ")}.` : "";
  }
}
