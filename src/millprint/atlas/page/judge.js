/* What a verdict rests on: ratios with intervals; the verdict on one is that of a match (`verdictOn`). */

/** Why a ratio has its word. */
function why(word, nearPercent) {
  if (word === AGREES) return `surely within ${nearPercent} %`;
  return word === DIFFERS ? `surely more than ${nearPercent} % apart` : `within ${nearPercent} % or not: the interval does not tell`;
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
