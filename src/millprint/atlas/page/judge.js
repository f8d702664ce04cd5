/* The verdict on two numbers by their intervals, as millprint.estimate.judge; its words are those of a match. */

const holds = ({ lower, upper }, value) => lower <= value && value <= upper;

/** One of the three words and why: whether your number is the paper's, by the intervals of both; widest: the largest
    factor between the ends of one that says anything. */
function judge(own, paper, widest) {
  if ([own, paper].some(({ lower, upper }) => !(lower > 0 && upper <= widest * lower))) {
    return { word: OPEN, reason: `an interval spans more than a factor of ${widest}` };
  }
  const inside = [holds(own, paper.value), holds(paper, own.value)];
  if (inside[0] && inside[1]) return { word: AGREES, reason: "each value lies within the other's interval" };
  if (inside[1]) return { word: AGREES, reason: "your value lies within the paper's interval" };
  if (own.lower <= paper.upper && paper.lower <= own.upper) {
    return { word: OPEN, reason: "the intervals overlap, but do not hold both values" };
  }
  return { word: DIFFERS, reason: "the intervals are apart" };
}

/** What rests on several verdicts: the first word that differs, or else is open, or else agrees. */
function judgeAll(verdicts) {
  return [DIFFERS, OPEN, AGREES].find((word) => verdicts.some((own) => own.word === word)) ?? OPEN;
}

/** One over the other, with its interval, as a number. */
function ratioWith(one, other) {
  const { value, interval } = ratioOf(one, other);
  return { value, ...interval };
}

/** What a rising function makes of a number and of the ends of its interval. */
function through(own, rising) {
  return { value: rising(own.value), lower: rising(own.lower), upper: rising(own.upper) };
}
