// Elements and numbers, as all parts of the page make them.

/** An element with attributes and children; texts become text, never markup. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

/** A number as the tables show it, to some digits. */
function short(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  const text = size >= 1e-3 && size < 1e5 ? String(Number(value.toPrecision(digits))) : value.toExponential(digits - 1);
  return text.replace("-", "−").replace("e+", "e");
}

/** A coordinate to a ten-thousandth of a size. */
function fixed(value, size) {
  const decimals = 4 - Math.floor(Math.log10(size)) - 1;
  return decimals > 9 || decimals < -6 ? short(value, 6) : value.toFixed(Math.max(0, decimals)).replace("-", "−");
}
