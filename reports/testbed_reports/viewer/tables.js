// Tables that sort at a click on a heading and show the rows that hold what is typed; numbers that say how to get them.

const LONG = 6; // rows from which a table can be filtered

/** What a row is sorted by in a column: a number, a text, or null for nothing. */
function sortKey(row, column) {
  const cell = row.cells[column];
  if (!cell || cell.colSpan > 1) return null;
  const text = cell.textContent.trim();
  if (text === "" || text === "–") return null;
  const exact = cell.querySelector("[title]");
  const shown = cell.querySelector(":scope > span:not(.mark)");
  for (const one of [exact && exact.title, shown && shown.textContent, text]) {
    const found = one ? one.trim().replace("−", "-").replace("∞", "Infinity") : "";
    if (one && one.trim() === "–") return null;
    const number = Number.parseFloat(found);
    if (!Number.isNaN(number) && /^[-+]?(\d|\.\d|Infinity)/.test(found)) return number;
  }
  return text.toLowerCase();
}

/** Order of keys: numbers before texts; whatever the direction, nothing comes last. */
function compareKeys(a, b, direction) {
  if (a === null || b === null) return (a === null) - (b === null);
  if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
  return direction * (typeof a === "number" ? a - b : a < b ? -1 : a > b ? 1 : 0);
}

function sortable(table) {
  const body = table.tBodies[0];
  const before = [...body.rows];
  const headings = [...table.tHead.rows].at(-1).cells;
  [...headings].forEach((heading, column) => {
    const name = heading.textContent.trim();
    const button = make("button", { type: "button", class: "sort", "aria-label": `Sort by ${name || "this column"}` });
    heading.append(button);
    heading.classList.add("sortable");
    heading.addEventListener("click", (event) => {
      if (event.target.closest("a")) return;
      const next = { none: "ascending", ascending: "descending", descending: "none" }[heading.getAttribute("aria-sort") || "none"];
      for (const other of headings) other.removeAttribute("aria-sort");
      if (next !== "none") heading.setAttribute("aria-sort", next);
      const direction = next === "descending" ? -1 : 1;
      const keys = new Map(before.map((row) => [row, sortKey(row, column)]));
      const order = next === "none" ? before : [...before].sort((a, b) => compareKeys(keys.get(a), keys.get(b), direction));
      body.append(...order);
    });
  });
}

function filterable(table) {
  const rows = [...table.tBodies[0].rows];
  let texts = null;
  const hint = "A heading sorts; a number shows its command.";
  const count = make("span", { class: "count", role: "status" }, hint);
  const input = make("input", { type: "search", placeholder: "filter rows", "aria-label": `Filter the rows of: ${table.caption ? table.caption.textContent.slice(0, 80) : "table"}`,
    input: () => {
      texts ||= rows.map((row) => row.textContent.toLowerCase());
      const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      rows.forEach((row, k) => { row.hidden = !words.every((word) => texts[k].includes(word)); });
      count.textContent = words.length ? `${rows.filter((row) => !row.hidden).length} of ${rows.length} rows` : hint;
    } });
  table.closest(".scroll").before(make("div", { class: "filter" }, input, count));
}

/** A word of a command, quoted for a shell where that is needed. */
function quoted(word) {
  return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`;
}

/** The command that computes what stands in an element: of its scheme, dataset and levels as far as it has them. */
function commandFor(element, run) {
  const table = element.closest("table");
  const heading = table && element.cellIndex !== undefined ? [...table.tHead.rows].at(-1).cells[element.cellIndex] : null;
  const known = (name) => [element, element.closest("tr"), heading, element.closest(`[data-${name}]`)]
    .map((one) => one && one.dataset[name]).find((value) => value !== undefined && value !== null);
  const [scheme, dataset, level] = ["scheme", "dataset", "level"].map(known);
  if (dataset === undefined) return run.command;
  const { spec, levels, schemes } = run.datasets[Number(dataset)];
  const chosen = scheme === undefined ? schemes : [Number(scheme)];
  const range = level === undefined || level === "all" ? `${Math.min(...levels)}:${Math.max(...levels)}` : `${level}:${level}`;
  return ["testbed", "run", ...chosen.flatMap((one) => ["-s", quoted(run.schemes[one])]), "-d", quoted(spec), "--levels", range].join(" ");
}

/** A bar at the bottom of the window that shows the command behind a number. */
class CommandBar {
  constructor(run) {
    this.run = run;
    this.what = make("span", { class: "what" });
    this.code = make("code");
    this.copy = make("button", { type: "button", click: () => this.take() }, "Copy");
    this.element = make("div", { class: "command", role: "region", "aria-label": "How to get this number", "aria-live": "polite", hidden: true },
      this.what, this.code, this.copy, make("button", { type: "button", "aria-label": "Close", click: () => this.close() }, "×"));
    document.body.append(this.element);
    document.addEventListener("click", (event) => {
      const cell = event.target.closest("td, .extremes");
      if (cell && !event.target.closest("a, button, input, summary") && !String(getSelection())) this.show(cell);
    });
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.close();
    });
  }

  show(cell) {
    if (/^\s*–?\s*$/.test(cell.textContent)) return;
    const row = cell.closest("tr");
    const headings = cell.cellIndex === undefined || cell.colSpan > 1 ? null : [...cell.closest("table").tHead.rows].at(-1).cells;
    const exact = cell.querySelector("[title]");
    const heading = headings && headings[cell.cellIndex];
    this.what.textContent = [row && row.cells[0].textContent.trim(), heading && (heading.title || heading.textContent.trim()), exact && exact.title]
      .filter(Boolean).join(" · ");
    this.code.textContent = commandFor(cell, this.run);
    this.copy.textContent = "Copy";
    this.element.hidden = false;
    for (const one of document.querySelectorAll(".asked")) one.classList.remove("asked");
    cell.classList.add("asked");
  }

  close() {
    this.element.hidden = true;
    for (const one of document.querySelectorAll(".asked")) one.classList.remove("asked");
  }

  async take() {
    try {
      await navigator.clipboard.writeText(this.code.textContent);
      this.copy.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(this.code); // where a page may not write: ready to be copied by hand
      this.copy.textContent = "Selected";
    }
  }
}

/** With the arrow keys from number to number in a table, Enter for its command. */
function walkable(table, bar) {
  const cells = () => [...table.tBodies[0].rows].filter((row) => !row.hidden).map((row) => [...row.cells]);
  const first = table.tBodies[0].querySelector("td");
  if (!first) return;
  first.tabIndex = 0;
  table.addEventListener("keydown", (event) => {
    const cell = event.target.closest("td, th");
    if (!cell || event.target !== cell) return;
    const rows = cells();
    const y = rows.findIndex((row) => row.includes(cell));
    if (y < 0) return;
    const x = rows[y].indexOf(cell);
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (event.key === "Enter") bar.show(cell);
    if (!step) return;
    const row = rows[Math.max(0, Math.min(rows.length - 1, y + step[1]))];
    const next = row[Math.max(0, Math.min(row.length - 1, x + step[0]))];
    event.preventDefault();
    cell.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });
}

function startTables() {
  document.documentElement.setAttribute("data-scripts", "");
  const run = JSON.parse(document.getElementById("run-data").textContent);
  const bar = new CommandBar(run);
  for (const table of document.querySelectorAll("main table")) {
    if (!table.tHead || !table.tBodies.length) continue;
    if (table.tBodies[0].rows.length > 1) sortable(table);
    if (table.tBodies[0].rows.length >= LONG) filterable(table);
    walkable(table, bar);
  }
}
