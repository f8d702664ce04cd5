/* The page: two sides, their pictures, the verdict, five numbers, and the nearest settings of one's own mill. */

const SIDES = ["paper", "own"];
// Units with prefixes of the numbers of this page.
const FITS = {
  J: { "nJ": 1e9, "µJ": 1e6, mJ: 1e3, J: 1 },
  "W/g": { "µW/g": 1e6, "mW/g": 1e3, "W/g": 1 },
  "W/cm²": { "µW/cm²": 1e6, "mW/cm²": 1e3, "W/cm²": 1 },
  W: { "µW": 1e6, mW: 1e3, W: 1, kW: 1e-3 },
  "1/s": { "1/h": 3600, "1/min": 60, "1/s": 1 },
};

/** A number with its unit and three digits, and the ends of its interval in the same unit. */
function shown(own, unit) {
  const fits = FITS[unit];
  const name = fits ? fitting(fits, Object.keys(fits), own.value) : unit;
  const factor = fits ? fits[name] : unit === "%" ? 100 : 1;
  const [value, lower, upper] = [own.value, own.lower, own.upper].map((end) => digits(end * factor));
  return { value, unit: name, interval: `${lower} to ${upper}` };
}

/** What follows from an estimate for a powder. */
function answerOf(kind, condition) {
  const { known, unsure, hits } = kind.estimate(condition);
  const shear = ratioWith(known.tangential_power_W, known.normal_power_W);
  const ball_g = 1e3 * condition.density_kg_m3 * (Math.PI / 6) * (condition.ball_diameter_mm / 1e3) ** 3;
  const powder_g = (condition.number * ball_g) / condition.bpr;
  // The inner wall, the rounding of edges left out.
  const [radius, height] = [condition.radius_mm / 10, condition.height_mm / 10];
  const wall_cm2 = 2 * Math.PI * radius * (radius + height);
  return {
    known,
    unsure,
    hits,
    powder_g,
    balls_g: condition.number * ball_g,
    power: through(known.wall_power_W, (end) => end / powder_g),
    energy: known.weighted_normal_energy_J,
    often: through(known.weighted_normal_frequency_hz, (end) => (end * condition.number) / powder_g),
    shear,
    share: through(shear, (end) => end / (1 + end)),
    point: { kind: kind.name, ...kind.groups(condition) },
    heat: through(known.wall_power_W, (end) => end / wall_cm2),
  };
}

// The five numbers: title, what it is, and its unit.
const FIVE = {
  power: ["Power", "per gram of powder; time makes up for it", "W/g"],
  energy: ["A strong hit", "E*ₙ: energy of the hits that carry the power", "J"],
  often: ["How many", "how often such hits come, per gram of powder; time makes up for it", "1/s"],
  share: ["Share of shear", "of what hits and shear dissipate", "%"],
  heat: ["Heat to carry away", "per cm² of the jar's inner wall", "W/cm²"],
};
// What decides whether a powder feels the same: title, what is shown in which unit, what is compared (of a share its odds,
// as by a match), and the numbers whose intervals it rests on.
const [NORMAL, TANGENTIAL] = ["normal", "tangential"].map((part) => ["energy_J", "frequency_hz"].map((name) => `weighted_${part}_${name}`));
const sheared = (own) => own.known.weighted_tangential_energy_J;
const SAME = {
  energy: ["The energy of a strong hit", (own) => own.energy, "J", (own) => own.energy, NORMAL.slice(0, 1)],
  shear: ["The energy of a strong shear", sheared, "J", sheared, TANGENTIAL.slice(0, 1)],
  share: ["The share of shear", (own) => own.share, "%", (own) => own.shear, [...NORMAL, ...TANGENTIAL]],
};

// The numbers that have a mark, in words.
const UNSURE = {
  wall_power_W: "power",
  weighted_normal_energy_J: "the energy of a strong hit",
  weighted_normal_frequency_hz: "how often it comes",
  weighted_tangential_energy_J: "the energy of a strong shear",
  weighted_tangential_frequency_hz: "how often that comes",
};

/** A number of one answer over that of another, with its interval: none at the same point of the atlas, whose error both
    have. */
function ratioAt(own, paper, of) {
  const [one, other] = [of(own), of(paper)];
  const value = one.value / other.value;
  const same = Object.entries(own.point).every(([name, each]) => each === paper.point[name] || Math.abs(each / paper.point[name] - 1) < 1e-9);
  return same ? { value, lower: value, upper: value } : ratioWith(one, other);
}

/** A ratio in words: 2.30 times more (1.80 to 3.00). */
function timesWords({ value, lower, upper }) {
  const [middle, low, high] = value >= 1 ? [value, lower, upper] : [1 / value, 1 / upper, 1 / lower];
  const words = digits(middle) === "1.00" ? "as much" : `${digits(middle)} times ${value >= 1 ? "more" : "less"}`;
  return `${words} (${digits(low)} to ${digits(high)})`;
}

class AtlasPage {
  constructor(content) {
    this.content = content;
    this.kinds = Object.fromEntries(Object.keys(content.kinds).map((name) => [name, new Kind(name, content)]));
    this.sides = SIDES.map((place) => new Side(place, content, this.kinds, () => this.render()));
    this.buildContact();
    this.pictures = SIDES.map((place) => new Picture(byId(`${place}-balls`), content.turns));
    this.film = new Film(this.pictures, byId("play"), byId("legend"));
    byId("take").addEventListener("click", () => this.take(this.found[0]));
  }

  start() {
    const mill = (kind) => Math.max(0, this.content.mills.findIndex((own) => own.kind === kind));
    const [first, second = first] = Object.keys(this.kinds);
    this.sides[0].choose(String(mill(first)));
    this.sides[1].choose(String(mill(second)));
    this.tellNotes();
    this.render();
  }

  /** The contact of both sides, since the powder is the same. */
  buildContact() {
    const choice = byId("contact-set");
    fillOptions(choice, this.content.contacts.map(({ name }) => [name, name]));
    const [kind] = Object.values(this.kinds);
    const names = ["restitution", "static_friction", "wall_static_friction", "rolling_friction"];
    this.contactFields = names.map((name) => {
      const input = element("input", { id: `contact-${name}`, type: "text", inputmode: "decimal", "aria-describedby": "contact-fault" });
      const { least, most } = kind.settings[name];
      const label = element("label", { for: input.id }, capital(PLAIN[name]));
      byId("contact-fields").append(element("p", { class: "field" }, label, element("span", { class: "entry" }, input, element("span", { class: "unit" }))));
      return { name, input, label: capital(PLAIN[name]), unit: "", least, most };
    });
    const fill = () => {
      this.contact = this.content.contacts.find((own) => own.name === choice.value);
      for (const { name, input } of this.contactFields) input.value = short(this.contact[name]);
      byId("contact-source").textContent = this.contact.source;
      byId("contact-name").textContent = this.contact.name;
    };
    choice.addEventListener("change", fill);
    fill();
    byId("contact-fields").addEventListener("change", () => (byId("contact-name").textContent = "your own"));
    byId("contact").addEventListener("change", () => this.render());
    for (const side of this.sides) side.contact = () => this.readContact() ?? {};
  }

  readContact() {
    const found = { young_modulus_gpa: this.contact.young_modulus_gpa };
    byId("contact-fault").textContent = "";
    for (const { input } of this.contactFields) input.removeAttribute("aria-invalid");
    for (const own of this.contactFields) {
      try {
        found[own.name] = readField(own.input.value, own);
      } catch (error) {
        byId("contact-fault").textContent = error.message;
        byId("contact").open = true;
        own.input.setAttribute("aria-invalid", "true");
        return null;
      }
    }
    return found;
  }

  render() {
    const contact = this.readContact();
    this.conditions = this.sides.map((side) => contact && side.read(contact));
    this.answers = this.sides.map((side, i) => this.conditions[i] && answerOf(side.kind, this.conditions[i]));
    this.renderNumbers();
    this.renderVerdict();
    this.renderDetails();
    this.searched = this.renderNearest();
    this.drawn = Promise.all(this.sides.map((side, i) => this.renderPicture(side, i))).then(() => this.film.tell());
  }

  async renderPicture(side, i) {
    const condition = this.conditions[i];
    const run = await this.pictures[i].show(side.kind, condition);
    const canvas = byId(`${side.place}-balls`);
    const said = byId(`${side.place}-said`);
    if (!run) {
      said.textContent = condition ? said.textContent : "No picture: the settings have a fault.";
      return;
    }
    const recorded = this.content.turns.kinds[side.kind.name];
    const percent = (own) => `${digits(100 * side.kind.groups(own).fill, 2)} % full`;
    const size = (own) => digits(own.ball_diameter_mm / own.radius_mm, 2);
    said.textContent =
      `Simulated: ${run.condition.number} balls, ${percent(run.condition)}, d/R ${size(run.condition)}; ` +
      `set here: ${condition.number}, ${percent(condition)}, ${size(condition)}. The nearest of ` +
      `${recorded.runs.length} recorded conditions, seen ${recorded.seen}.`;
    canvas.setAttribute("aria-label", `Moving balls in ${this.choiceText(side)}, coloured by speed. ${said.textContent}`);
  }

  choiceText(side) {
    return side.choice.selectedOptions[0].textContent;
  }

  /** The verdicts on SAME of an answer and the paper's. */
  verdicts(own, paper) {
    const near = this.content.near_percent;
    return Object.values(SAME).map(([title, of, unit, compared, numbers]) => {
      const ratio = ratioAt(own, paper, compared);
      const word = verdictOn({ interval: ratio }, near);
      return { title, unit, own: of(own), paper: of(paper), ratio, ...(this.unproven(numbers) ?? { word, reason: why(word, near) }) };
    });
  }

  /** That it is open, where the intervals of a kind have not held on mills that were kept apart; null where they have. */
  unproven(numbers) {
    for (const { kind } of this.sides) {
      const { held, mills } = this.content.errors[kind.name];
      const share = Math.min(...numbers.map((name) => held[name]));
      if (share < this.content.least_held) {
        const reason = `intervals of the kind ${small(kind.title)} held only ${Math.round(100 * share)} % of ${mills} mills kept apart`;
        return { word: OPEN, reason };
      }
    }
    return null;
  }

  /** Hours for the energy per gram that the paper's hours give. */
  hours(own) {
    return through(ratioWith(this.answers[0].power, own.power), (end) => end * this.conditions[0].time_h);
  }

  /** Whether both sides have hits that can be compared; told where they have none. */
  get compared() {
    return this.answers.every((own) => own && own.hits >= this.content.limits.hits);
  }

  renderVerdict() {
    const [paper, own] = this.answers;
    const [say, list] = [byId("verdict"), byId("reasons")];
    list.replaceChildren();
    byId("time").textContent = "";
    say.className = "";
    if (!paper || !own) {
      const faulty = byId("contact-fault").textContent ? "the numbers of the contact" : paper ? "your settings" : "the paper's settings";
      say.textContent = `Nothing to compare: ${faulty} have a fault.`;
      return;
    }
    if (!this.compared) {
      const rolling = SIDES.flatMap((side, i) => (this.answers[i].hits < this.content.limits.hits
        ? [`${side === "own" ? "your" : "the paper's"} mill (probability of hits ${Math.round(100 * this.answers[i].hits)} %)`] : []));
      say.textContent = `In ${listed(rolling)} the balls roll, slide or go round with the wall, so only powers are told.`;
      return;
    }
    const verdicts = this.verdicts(own, paper);
    const word = judgeAll(verdicts);
    const named = (wanted) => listed(verdicts.filter((each) => each.word === wanted).map(({ title }) => small(title)));
    say.className = word;
    say.textContent = {
      [AGREES]: `By the atlas both do the same to a powder, within ${this.content.near_percent} %.`,
      [DIFFERS]: `They do not do the same to a powder: they differ in ${named(DIFFERS)}.`,
      [OPEN]: `It is open whether they do the same to a powder: nothing is decided on ${named(OPEN)}.`,
    }[word];
    list.replaceChildren(...verdicts.map((each) => this.reason(each)));
    const hours = this.hours(own);
    byId("time").textContent =
      `For the same energy per gram of powder, ${durationWords(this.conditions[0].time_h)} in the paper's mill are ` +
      `${durationWords(hours.value)} in yours (${durationWords(hours.lower)} to ${durationWords(hours.upper)}).`;
  }

  reason({ title, unit, word, reason, own, paper, ratio }) {
    const [yours, its] = [own, paper].map((each) => shown(each, unit));
    const values = `yours ${yours.value} ${yours.unit}, the paper’s ${its.value} ${its.unit}`;
    const times = unit === "%" ? `, shear over hits ${timesWords(ratio)}` : `, ${timesWords(ratio)}`;
    const mark = element("strong", { class: `word ${word}` }, word);
    return element("li", {}, mark, element("span", {}, element("b", {}, title), `: ${values}${times}; ${reason}.`));
  }

  renderNumbers() {
    const rows = Object.entries(FIVE).map(([name, [title, means, unit]]) => {
      const head = element("th", { scope: "row" }, title, element("small", {}, means));
      const cells = this.answers.map((own) => {
        const needsHits = !["power", "heat"].includes(name);
        if (!own || (needsHits && own.hits < this.content.limits.hits)) return element("td", {}, "–");
        const { value, unit: shownUnit, interval } = shown(own[name], unit);
        const number = element("span", { class: "number" }, value, element("span", { class: "unit" }, ` ${shownUnit}`));
        return element("td", {}, number, element("small", {}, interval));
      });
      return element("tr", {}, head, ...cells);
    });
    document.querySelector("#five tbody").replaceChildren(...rows);
    byId("unsure").replaceChildren(...this.sides.flatMap((side, i) => this.unsureWords(side, this.answers[i])));
    const beyond = this.sides.filter(({ kind }, i) => this.conditions[i] && kind.isBeyondStiffness(this.conditions[i]));
    const where = beyond.map(({ place }) => (place === "own" ? "your mill" : "the paper’s mill"));
    byId("stiff").textContent = where.length
      ? `In ${listed(where)} the balls are stiffer or softer than the atlas knows: shear is told as at the end of its range.` : "";
  }

  /** What is to be simulated on a side, in words. */
  unsureWords({ place }, own) {
    const found = own ? own.unsure.filter((name) => name === "wall_power_W" || own.hits >= this.content.limits.hits) : [];
    if (!found.length) return [];
    const mill = place === "own" ? "Your mill" : "The paper’s mill";
    const words = `${mill} is told worse than the atlas is meant to in ${listed(found.map((name) => UNSURE[name]))}: simulate it, with `;
    return [element("span", {}, words, element("code", {}, "millprint card"), ". ")];
  }

  async renderNearest() {
    const [paper] = this.answers;
    const [side, condition] = [this.sides[1], this.conditions[1]];
    const possible = paper && condition && paper.hits >= this.content.limits.hits;
    byId("nearest").hidden = !possible;
    if (!possible) return;
    byId("best").textContent = "Searching …";
    byId("take").hidden = true;
    // Nothing of another mill stays.
    const rowsOf = document.querySelector("#others tbody");
    for (const part of [byId("best-reasons"), rowsOf]) part.replaceChildren();
    const token = (this.token = {});
    const found = await nearest(side.kind, condition, wantedOf(paper), this.content.sold_mm, side.speedsHz(condition));
    // Another search has begun since.
    if (token !== this.token) return;
    this.found = found.map((own) => ({ ...own, answer: answerOf(side.kind, own.condition) }));
    byId("take").hidden = !this.found.length;
    if (!this.found.length) {
      byId("best").textContent = "Your mill has no settings within the atlas at which balls hit strongly.";
      return;
    }
    const [best] = this.found;
    const word = judgeAll(this.verdicts(best.answer, paper));
    byId("best").replaceChildren(element("span", { class: "number" }, this.settingWords(best)), element("strong", { class: `word ${word}` }, word));
    byId("best-reasons").replaceChildren(...this.verdicts(best.answer, paper).map((each) => this.reason(each)));
    const rows = this.found.map((own) => {
      const { condition: each, answer } = own;
      const verdict = judgeAll(this.verdicts(answer, paper));
      const button = element("button", { type: "button" }, "Take", element("span", { class: "hidden" }, ` balls of ${each.ball_diameter_mm} mm`));
      button.addEventListener("click", () => this.take(own));
      const { unit, shown: speed } = side.kind.shownSetting("speed_hz");
      const cells = [each.number, `${short(Number(speed(each.speed_hz).toPrecision(4)))} ${unit}`, durationWords(this.hours(answer).value), shown(answer.energy, "J"), shown(answer.share, "%"), verdict];
      const texts = cells.map((cell) => (cell.unit ? `${cell.value} ${cell.unit}` : String(cell)));
      return element("tr", {}, element("th", { scope: "row" }, `${each.ball_diameter_mm} mm`), ...texts.map((text) => element("td", {}, text)), element("td", {}, button));
    });
    rowsOf.replaceChildren(...rows);
  }

  settingWords({ condition, answer }) {
    const { unit, shown: speed } = this.sides[1].kind.shownSetting("speed_hz");
    const balls = condition.number === 1 ? "1 ball" : `${condition.number} balls`;
    return `${balls} of ${condition.ball_diameter_mm} mm, ${short(Number(speed(condition.speed_hz).toPrecision(4)))} ${unit}, ${durationWords(this.hours(answer).value)}`;
  }

  /** Take settings that were found as one's own. */
  take({ condition }) {
    const { fields, kind } = this.sides[1];
    for (const name of ["ball_diameter_mm", "number", "speed_hz"]) {
      fields[name].input.value = short(Number(kind.shownSetting(name).shown(condition[name]).toPrecision(6)));
    }
    this.render();
    // The button that was pressed is hidden or gone.
    goTo("verdict-title");
  }

  renderDetails() {
    const [first, second] = this.answers;
    const titles = {
      wall_power_W: ["Power of the walls", "W"],
      normal_power_W: ["Normal power, of hits", "W"],
      tangential_power_W: ["Tangential power, of shear", "W"],
      rolling_power_W: ["Power of rolling friction", "W"],
      weighted_normal_energy_J: ["E*ₙ, a strong hit", "J"],
      weighted_normal_frequency_hz: ["f*ₙ, such hits of a ball", "1/s"],
      weighted_tangential_energy_J: ["E*ₜ, a strong shear", "J"],
      weighted_tangential_frequency_hz: ["f*ₜ, such shears of a ball", "1/s"],
      strong_frequency_hz: ["Hits of a ball with half the energy of the walls or more", "1/s"],
    };
    const cell = (own, name, unit) => {
      if (!own || (own.hits < this.content.limits.hits && name !== "wall_power_W")) return element("td", {}, "–");
      const { value, unit: shownUnit, interval } = shown(own.known[name], unit);
      return element("td", {}, `${value} ${shownUnit}`, element("small", {}, interval));
    };
    const masses = [["Mass of the balls", "balls_g"], ["Mass of the powder", "powder_g"]].map(([title, name]) =>
      element("tr", {}, element("th", { scope: "row" }, title), ...[first, second].map((own) => element("td", {}, own ? `${digits(own[name])} g` : "–"))));
    const rows = Object.keys(this.content.predicted).map((name) => {
      const [title, unit] = titles[name];
      return element("tr", {}, element("th", { scope: "row" }, title), cell(first, name, unit), cell(second, name, unit));
    });
    const likely = element("tr", {}, element("th", { scope: "row" }, "Probability that balls hit strongly"), ...[first, second].map((own) => element("td", {}, own ? `${Math.round(100 * own.hits)} %` : "–")));
    document.querySelector("#every tbody").replaceChildren(...rows, likely, ...masses);
    byId("groups").replaceChildren(...this.sides.map((side, i) => this.groupTable(side, this.conditions[i])));
  }

  /** The groups of a side, with the range of the atlas. */
  groupTable(side, condition) {
    const groups = condition && side.kind.groups(condition);
    const row = ({ name, symbol, formula, low, high, reason }) =>
      element("tr", {}, element("th", { scope: "row" }, symbol === formula ? symbol : `${symbol} = ${formula}`, element("small", {}, reason)),
        element("td", {}, groups ? digits(groups[name]) : "–"), element("td", {}, `${short(low)} to ${short(high)}`));
    const head = element("tr", {}, ...["Group", "here", "atlas"].map((text) => element("th", { scope: "col" }, text)));
    return element("table", {}, element("caption", {}, `${side.place === "own" ? "Your mill" : "The paper's mill"}: ${small(side.kind.title)}`), element("thead", {}, head), element("tbody", {}, ...side.kind.ranges.map(row)));
  }

  /** What the atlas was made from. */
  tellNotes() {
    const [known, missing] = [Object.values(this.kinds).map(({ title }) => title), this.content.not_yet].map((titles) =>
      listed(titles.map((title) => `${small(title)}s`)));
    byId("covers").textContent = missing ? `A first edition, of ${known}. Not yet: ${missing}.` : "";
    const made = Object.values(this.kinds).map(({ title, about }) => `${about.simulations} of the kind ${small(title)}`);
    byId("made").textContent = `The numbers come from simulations of mills: ${listed(made)}.`;
    const numbers = { wall_power_W: "power", weighted_normal_energy_J: "the energy of a strong hit", weighted_normal_frequency_hz: "how often it comes" };
    byId("wrong").replaceChildren(
      ...Object.values(this.kinds).map(({ name, title }) => {
        const { mills, median, held } = this.content.errors[name];
        const percent = (share) => `${Math.round(100 * share)} %`;
        const parts = Object.entries(numbers).map(([key, words]) => `${words} ${percent(median[key])} (the interval held ${percent(held[key])})`);
        return element("li", {}, `${title}: on ${mills} mills that it had not seen, the median error was, of ${listed(parts)}.`);
      }),
    );
    const versions = [...new Set(Object.values(this.kinds).map(({ about }) => about.version))];
    byId("version").textContent = `Physics and settings of the simulations: ${listed(versions)}.`;
  }
}
