// Ranges and ticks. The rules are those of the drawn charts: round steps, room for marks, a tick of its own for infinity.

/** The smallest of 1, 2, 2.5, 5, 10 times a power of ten that is not below `raw`. */
function niceStep(raw) {
  const magnitude = 10 ** Math.floor(Math.log10(raw));
  return magnitude * [1, 2, 2.5, 5, 10].find((m) => m * magnitude >= raw * (1 - 1e-9));
}

/** A number in few letters: 0.25, 1200, 3.5 M. */
function tickText(v, step) {
  const size = Math.abs(v);
  if (size < step * 1e-6) return "0";
  if (size >= 1e5 || step >= 1e4) {
    const power = Math.min(4, Math.max(1, Math.floor(Math.log10(size) / 3 + 1e-9)));
    const scaled = v / 1000 ** power;
    if (Math.abs(scaled) >= 1e4) return v.toExponential(0).replace("+", "");
    return `${Number(scaled.toPrecision(4))} ${["k", "M", "G", "T"][power - 1]}`;
  }
  if (size < 1e-4) return String(Number(v.toPrecision(3))).replace("-", "−");
  const decimals = Math.max(0, -Math.floor(Math.log10(step)));
  const exact = Math.abs((step * 10 ** decimals) % 1) < 1e-6;
  return v.toFixed(Math.min(12, exact ? decimals : decimals + 1)).replace("-", "−");
}

/** Whether a value has a place on an axis. */
const hasPlace = (v, log) =>
  v !== null && !Number.isNaN(v) && (log ? v > 0 && v < Infinity : v > -Infinity);

/** Where values stand, as shares of the axis, and its ticks. `values` all have a place. */
function range(values, log, infinity) {
  const finite = values.filter(Number.isFinite);
  const low = finite.length ? Math.min(...finite) : 1;
  const high = finite.length ? Math.max(...finite) : 1;
  return log ? logRange(low, high) : linearRange(low, high, values.includes(Infinity) ? infinity : null);
}

function logRange(low, high) {
  const widen = Math.sqrt(Math.max(1, 5 / (high / low))) * 1.12;
  const [from, to] = [Math.log10(low / widen), Math.log10(high * widen)];
  const decades = to - from;
  const digits = decades < 2.2 ? [1, 2, 5] : [1];
  const every = Math.max(1, Math.ceil(decades / 7));
  const ticks = [];
  for (let power = Math.floor(from); power <= to; power += 1) {
    if (digits.length === 1 && power % every !== 0) continue;
    for (const digit of digits) {
      const v = digit * 10 ** power;
      const at = (Math.log10(v) - from) / decades;
      if (at >= 0 && at <= 1) ticks.push({ at, text: tickText(v, 10 ** power) });
    }
  }
  return { ticks, place: (v) => (Math.log10(v) - from) / decades };
}

function linearRange(low, high, infinity) {
  const span = high > low ? high - low : Math.max(Math.abs(high) * 0.1, 1e-6);
  const step = niceStep(span / 5);
  let [from, to] = [Math.floor(low / step) * step, Math.ceil(high / step) * step];
  if (low - from < 0.15 * step && from !== 0) from -= step;
  if (to - high < 0.15 * step) to += step;
  const top = infinity ? to + step : to;
  const place = (v) => ((v === Infinity ? top : v) - from) / (top - from);
  const ticks = [];
  for (let i = 0; i <= Math.round((to - from) / step); i += 1) {
    const v = from + i * step;
    ticks.push({ at: place(v), text: tickText(v, step) });
  }
  if (infinity) ticks.push({ at: 1, text: infinity });
  return { ticks, place };
}

