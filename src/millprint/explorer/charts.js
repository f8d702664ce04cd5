/* Line charts with bands, as SVG. */

const CHART = { width: 300, height: 225, left: 46, right: 16, top: 40, bottom: 36 };
// Number of charts drawn so far: each has a separate clipping path.
let charts = 0;

/** About five round numbers within a range. */
function ticks(low, high) {
  const rough = (high - low) / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= rough) * power;
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high * (1 + 1e-9); value += step) found.push(value);
  return found;
}

/** The upper end of an axis: a band may be cut where it reaches far beyond the values. */
function topOf(lines) {
  const values = lines.flatMap((line) => line.bands);
  const largestOf = (end) => Math.max(...values.map((band) => band[end]).filter(Number.isFinite));
  const largest = largestOf("value");
  return Math.min(Math.max(largest, largestOf("upper")), 1.5 * largest);
}

/** The power of ten of an axis whose numbers would have zeros or more than three digits otherwise; 0 if none is needed. */
const thousands = (top) => (top > 0 && (top < 0.1 || top >= 1e3) ? 3 * Math.floor(Math.log10(top) / 3) : 0);

/**
 * chart: title, x (values), label, lines ({name, colour, bands, dashed, now}), known (from-to in x of what was simulated;
 * all of it if left out), at (x of the marked condition, if there is one), top (fixed upper end, optional), level ({value,
 * name} of a horizontal line, optional). Each band is {value, lower, upper} for an x, its ends NaN where they are not known.
 */
function drawChart(chart) {
  const { width, height, left, right, top, bottom } = CHART;
  const [low, high] = [chart.x[0], chart.x.at(-1)];
  const upper = chart.top ?? topOf(chart.lines);
  const x = (value) => left + ((value - low) / (high - low)) * (width - left - right);
  const y = (value) => height - bottom - (value / upper) * (height - top - bottom);
  const id = `clip-${(charts += 1)}`;
  const svg = element("svg:svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": describeChart(chart) });
  const area = { x: left, y: top, width: width - left - right, height: height - top - bottom };
  svg.append(element("svg:clipPath", { id }, element("svg:rect", area)), element("svg:rect", { ...area, class: "ground" }));
  const [from, to] = (chart.known ?? [low, high]).map((value) => Math.min(Math.max(x(value), left), width - right));
  svg.append(element("svg:rect", { ...area, x: from, width: Math.max(to - from, 2), class: "known" }));
  svg.append(element("svg:text", { x: 2, y: 14, class: "chart-title" }, chart.title));
  for (const value of ticks(0, upper)) {
    svg.append(
      element("svg:line", { x1: left, x2: width - right, y1: y(value), y2: y(value), class: "grid" }),
      element("svg:text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, short(value)),
    );
  }
  for (const value of ticks(low, high)) {
    svg.append(element("svg:text", { x: x(value), y: height - bottom + 18, "text-anchor": "middle" }, short(value)));
  }
  svg.append(element("svg:text", { x: width - right, y: height - 4, "text-anchor": "end", class: "axis" }, chart.label));
  const inside = element("svg:g", { "clip-path": `url(#${id})` });
  for (const line of chart.lines) inside.append(...drawLine(line, chart.x, x, y));
  svg.append(inside);
  if (chart.level && chart.level.value <= upper) {
    const place = y(chart.level.value);
    svg.append(
      element("svg:line", { x1: left, x2: width - right, y1: place, y2: place, class: "level" }),
      element("svg:text", { x: width - right - 3, y: place - 4, "text-anchor": "end" }, chart.level.name),
    );
  }
  if (chart.lines.length > 1) svg.append(drawNames(chart.lines));
  for (const line of chart.lines) {
    if (line.now && line.now.value <= upper) {
      svg.append(element("svg:circle", { cx: x(chart.at), cy: y(line.now.value), r: 4, fill: line.colour, class: "now" }));
    }
  }
  return svg;
}

/** The band and the line of a quantity; parts of the line that are not trusted are dashed. */
function drawLine(line, places, x, y) {
  const path = (points) => points.map(([a, b], i) => `${i ? "L" : "M"}${a.toFixed(1)} ${b.toFixed(1)}`).join("");
  const along = (key) =>
    line.bands.map((band, i) => [x(places[i]), y(band[key])]).filter(([, height]) => Number.isFinite(height));
  const ends = [...along("upper"), ...along("lower").reverse()];
  const points = along("value");
  const isDashed = (i) => Boolean(line.dashed?.[i] || line.dashed?.[i + 1]);
  const drawn = ends.length ? [element("svg:path", { d: `${path(ends)}Z`, fill: line.colour, class: "band" })] : [];
  let start = 0;
  for (let i = 1; i < points.length; i += 1) {
    if (i + 1 < points.length && isDashed(i) === isDashed(start)) continue;
    const dash = isDashed(start) ? { "stroke-dasharray": "4 4" } : {};
    drawn.push(element("svg:path", { d: path(points.slice(start, i + 1)), stroke: line.colour, class: "line", ...dash }));
    start = i;
  }
  return drawn;
}

/** Names of the lines in their colours, under the title. */
function drawNames(lines) {
  const names = lines.map((line) => element("svg:tspan", { fill: line.colour, dx: 8 }, line.name));
  return element("svg:text", { x: CHART.left - 8, y: 31, class: "name" }, ...names);
}

/** The description of a chart for screen readers. */
function describeChart(chart) {
  const said = chart.lines.map((line) => {
    const ends = [line.bands[0], line.bands.at(-1)].map((band) => digits(band.value));
    return `${line.name}: ${ends[0]} to ${ends[1]}${line.now ? `, ${digits(line.now.value)} now` : ""}`;
  });
  return `${chart.title} against ${chart.label} from ${short(chart.x[0])} to ${short(chart.x.at(-1))}. ${said.join("; ")}`;
}
