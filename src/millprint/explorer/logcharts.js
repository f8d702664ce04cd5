/* Charts of steps on two logarithmic axes, as SVG. */

// Number of decades below the highest value that are drawn: single contacts would stretch the axis.
const DECADES = 7;

/**
 * chart: title, label, lines ({name, colour, dashed, steps}) with steps {low, high, value}; marks ({at, colour, name});
 * share: true for values from 0 to 1 on a linear axis. Values of 0 or below are not drawn.
 */
function drawLogChart(chart) {
  const { width, height, left, right, top, bottom } = CHART;
  const steps = chart.lines.flatMap((line) => line.steps).filter((step) => step.value > 0);
  const svg = element("svg:svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": describeLogChart(chart) });
  const area = { x: left, y: top, width: width - left - right, height: height - top - bottom };
  svg.append(element("svg:rect", { ...area, class: "known" }));
  svg.append(element("svg:text", { x: 2, y: 14, class: "chart-title" }, chart.title));
  if (!steps.length) return svg;
  const highest = Math.max(...steps.map((step) => step.value));
  const floor = chart.share ? 0 : Math.max(highest * 10 ** -DECADES, Math.min(...steps.map((step) => step.value)));
  const drawn = steps.filter((step) => step.value >= floor);
  const ends = [Math.min(...drawn.map((step) => step.low)), Math.max(...drawn.map((step) => step.high))].map(Math.log10);
  const heights = chart.share ? [0, 1] : [Math.floor(Math.log10(floor)), Math.ceil(Math.log10(highest))];
  const x = (value) => left + ((Math.log10(value) - ends[0]) / (ends[1] - ends[0])) * area.width;
  const y = (value) =>
    height - bottom - (((chart.share ? value : Math.log10(value)) - heights[0]) / (heights[1] - heights[0])) * area.height;
  for (const [value, text] of chart.share ? ticks(0, 1).map((each) => [each, short(each)]) : decades(heights)) {
    svg.append(
      element("svg:line", { x1: left, x2: width - right, y1: y(value), y2: y(value), class: "grid" }),
      element("svg:text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, text),
    );
  }
  for (const [value, text] of decades(ends)) {
    svg.append(
      element("svg:line", { x1: x(value), x2: x(value), y1: top, y2: height - bottom, class: "grid" }),
      element("svg:text", { x: x(value), y: height - bottom + 18, "text-anchor": "middle" }, text),
    );
  }
  svg.append(element("svg:text", { x: width - right, y: height - 4, "text-anchor": "end", class: "axis" }, chart.label));
  for (const { at, colour } of chart.marks) {
    if (Math.log10(at) < ends[0] || Math.log10(at) > ends[1]) continue;
    svg.append(element("svg:line", { x1: x(at), x2: x(at), y1: top, y2: height - bottom, stroke: colour, class: "mark" }));
  }
  for (const line of chart.lines) {
    const shown = line.steps.filter((step) => step.value > 0 && step.value >= floor);
    const dash = line.dashed ? { "stroke-dasharray": "4 3" } : {};
    svg.append(element("svg:path", { d: stepPath(shown, x, y), stroke: line.colour, class: "line", ...dash }));
  }
  return svg;
}

/** About six whole powers of ten within a range of logarithms, with their text. */
function decades([low, high]) {
  const every = Math.max(1, Math.ceil((high - low) / 6));
  const found = [];
  for (let power = Math.ceil(low / every) * every; power <= high + 1e-9; power += every) {
    found.push([10 ** power, powerOfTen(power)]);
  }
  return found;
}

/** A path along the tops of neighbouring steps; it starts again after a gap. */
function stepPath(steps, x, y) {
  return steps
    .map((step, i) => {
      const joined = i > 0 && Math.abs(step.low / steps[i - 1].high - 1) < 1e-6;
      return `${joined ? "L" : "M"}${x(step.low).toFixed(1)} ${y(step.value).toFixed(1)}H${x(step.high).toFixed(1)}`;
    })
    .join("");
}

/** The description of a chart for screen readers. */
function describeLogChart(chart) {
  const said = chart.lines.map((line) => {
    const top = line.steps.reduce((best, step) => (step.value > (best?.value ?? 0) ? step : best), null);
    return top ? `${line.name}: at most ${digits(top.value)}, at ${digits(top.low)} to ${digits(top.high)}` : `${line.name}: nothing`;
  });
  const marked = chart.marks.map(({ name, at }) => `${name}: ${digits(at)}`);
  return `${chart.title} against ${chart.label}. ${[...said, ...marked].join("; ")}`;
}
