// Scales and grids of a chart: logarithmic for times and errors, linear for decibels and similarities.

/** A scale from values to pixels, with ticks of which some are labelled. */
function scaleOf(values, [from, to], logarithmic) {
  const low = Math.min(...values), high = Math.max(...values);
  if (logarithmic) {
    // A little room, and never less than a factor of two.
    const middle = Math.sqrt(low * high), half = Math.max(Math.sqrt(high / low) * 1.15, Math.SQRT2);
    const [a, b] = [Math.log10(middle / half), Math.log10(middle * half)];
    const at = (value) => from + ((Math.log10(value) - a) / (b - a)) * (to - from);
    return { at, ticks: logTicks(10 ** a, 10 ** b, b - a) };
  }
  const room = Math.max((high - low) * 0.08, Math.abs(high) * 0.01, 1e-6);
  const [a, b] = [low - room, high + room];
  return { at: (value) => from + ((value - a) / (b - a)) * (to - from), ticks: linearTicks(a, b) };
}

/** 1 to 9 of each decade; labels at 1, and at 2 and 5 where there are few decades. */
function logTicks(low, high, decades) {
  const ticks = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++) {
    for (let digit = 1; digit < 10; digit++) {
      const value = digit * 10 ** power;
      if (value < low || value > high) continue;
      const labelled = digit === 1 || (decades < 2.5 && (digit === 2 || digit === 5)) || (decades < 0.7 && digit % 2 === 1);
      ticks.push({ value, strong: digit === 1, label: labelled ? short(value) : null });
    }
  }
  return ticks;
}

function linearTicks(low, high) {
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((candidate) => candidate >= rough);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high; i++) {
    ticks.push({ value: i * step, strong: false, label: short(i * step) });
  }
  return ticks;
}

/** A tick's label: no digits that are rounding. */
function short(value) {
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) return value.toExponential(0).replace("e+", "e");
  return String(Number(value.toPrecision(4)));
}

/** Grid lines, labels and titles. */
function axes(x, y, box, titles) {
  const group = drawn("g", { class: "axes", "aria-hidden": "true" });
  for (const tick of x.ticks) {
    const at = x.at(tick.value).toFixed(1);
    group.append(drawn("line", { x1: at, x2: at, y1: box.top, y2: box.bottom, class: tick.strong ? "strong" : "" }));
    if (tick.label) group.append(drawn("text", { x: at, y: box.bottom + 17, "text-anchor": "middle" }, tick.label));
  }
  for (const tick of y.ticks) {
    const at = y.at(tick.value).toFixed(1);
    group.append(drawn("line", { x1: box.left, x2: box.right, y1: at, y2: at, class: tick.strong ? "strong" : "" }));
    if (tick.label) group.append(drawn("text", { x: box.left - 7, y: at, dy: "0.32em", "text-anchor": "end" }, tick.label));
  }
  group.append(
    drawn("text", { x: box.right, y: box.bottom + 36, "text-anchor": "end", class: "title" }, titles.x),
    drawn("text", { x: box.left, y: box.top - 10, class: "title" }, titles.y),
  );
  return group;
}
