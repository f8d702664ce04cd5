/* Texts on the shown mill: title, introduction, what is searched, and where numbers come from. */

class Intro {
  constructor(explorer) {
    this.explorer = explorer;
  }

  build() {
    const { mill } = this.explorer;
    const { about } = mill.fingerprints[0];
    byId("title").textContent = mill.content.title;
    document.title = `${mill.content.title}: explorer`;
    const probability = short(100 * about.probability);
    const level = mill.yieldModel && short(100 * mill.content.yield.level);
    byId("intro").textContent = [
      `The mechanical fingerprint of a mill: set it and see what a collision does to the powder,`,
      level ? "what the balls dissipate, and the yield to expect." : "and what the balls dissipate.",
      `Shaded is the band in which ${probability} % of new simulations are expected${level ? `, or ${level} % of measured yields` : ""}.`,
      "The mean of very many simulations and other unknowns have separate intervals, which are not added up.",
    ].join(" ");
    byId("searched").textContent = this.searched();
    byId("found-balls").textContent = about.charges ? "balls [mm]" : "ball [mm]";
    byId("notes").replaceChildren(...this.notes());
  }

  searched() {
    const { mill, units, mills } = this.explorer;
    const { search } = mill.content;
    const { unit, to } = units.of("speed");
    const speeds = search.speeds_rpm.map((speed) => to(speed / 60));
    const contacts = mill.fingerprints.map(({ about }) => about.contact);
    const other = mills.length > 1 ? " The fields stay when another mill is chosen: take the values of one mill, and search for them on another." : "";
    return (
      `Which conditions of this mill give these descriptors? Searched are speeds from ${fromTo(...speeds)} ${unit}, ` +
      `fill ratios from ${fromTo(...search.fill_ratios)}, ${search.balls_in_words} and the contact ` +
      `set${contacts.length > 1 ? "s" : ""} ${contacts.join(", ")}; leave a field empty to leave its descriptor open.${other}`
    );
  }

  notes() {
    const { mill, content } = this.explorer;
    const { about } = mill.fingerprints[0];
    const count = mill.fingerprints.reduce((sum, each) => sum + each.conditions, 0);
    const contacts = mill.fingerprints.map((each) => each.about.contact);
    const runs = mill.yieldModel ? `, and a yield model from ${mill.content.yield.members[0].target.length} measured runs` : "";
    const said = [
      `The page carries the fitted models of the run and computes in the browser what the library (millprint ${content.version}) computes: ` +
        `${contacts.length} fingerprint${contacts.length > 1 ? "s" : ""} of mill ${about.mill} (${contacts.join(", ")}) from ${count} ` +
        `simulated conditions${runs}. It loads nothing else and works from a folder.`,
      "Weighted energies and frequencies need no counting rule: E* is the sum of squares of the energies of all contacts over their sum, " +
        "and f* the power of a ball over E*.",
      `Energies of a collision and the specific collision frequency use the counting rule ${about.counting_rule}: re-contacts of a ball with the ` +
        `same ball or ${about.collisions_by} of the wall within ${short(about.collision_gap_turns)} turns are one collision. The jar holds ${short(1e6 * about.volume_m3)} mL, its amplitude is ` +
        `${short(1e3 * about.amplitude_m)} mm.`,
      ...(about.charges ? ["A charge of several ball sizes has one diameter in the scaling, d30, the diameter of its ball of mean volume."] : []),
      ...(mill.yieldModel
        ? ["The yield's interval is from the yield model at the descriptors' expected values; it does not include their uncertainty."]
        : []),
      "The powder to weigh in is the mass of the balls over the ball-to-powder ratio. The acceleration is the largest that a point of a " +
        "wall or stirrer has, over 9.81 m/s²; makers of planetary mills often give only the sun wheel's, which is smaller.",
    ];
    const origins = Object.values(mill.content.origins).flatMap(({ title, meaning }) => [element("dt", {}, title), element("dd", {}, meaning)]);
    const list = mill.further.length ? [element("dl", { id: "origins" }, ...origins)] : [];
    return [...said.map((text) => element("p", {}, text)), ...list];
  }
}
