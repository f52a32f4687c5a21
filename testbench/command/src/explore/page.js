"use strict";

const archs = [...new Set(DATA.designs.map((design) => design.arch))];
const colour = (design) => DATA.colours[archs.indexOf(design.arch)];
const pinned = new Set();
const brushes = new Map();
const by = (id) => document.getElementById(id);

// An element of HTML or, within a drawing, of SVG.
function make(name, attributes = {}, parent = null, text = null) {
  const space = parent instanceof SVGElement || name === "svg" ? "http://www.w3.org/2000/svg" : "http://www.w3.org/1999/xhtml";
  const element = document.createElementNS(space, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== null) element.textContent = text;
  if (parent) parent.appendChild(element);
  return element;
}

function written(value) {
  if (value === null || value === undefined) return "-";
  if (typeof value !== "number") return String(value);
  return value.toLocaleString("en", { maximumFractionDigits: Math.abs(value) < 100 ? 4 : 1 });
}

// What can stand along an axis: the objectives, then every figure as its mean over the scenes.
const quantities = [
  ...DATA.objectives.map((objective, k) => ({
    name: objective.name, most: objective.most, of: (design) => (design.objectives ? design.objectives[k] : null),
  })),
  ...DATA.figures.map((figure) => ({
    name: `${figure.name}${figure.unit ? ` (${figure.unit})` : ""}, mean over scenes`, most: false, of: (design) => mean(design, figure.name),
  })),
];

function mean(design, name) {
  const k = DATA.figures.findIndex((figure) => figure.name === name);
  const values = design.figures.map((scene) => (scene ? scene[k] : null));
  if (values.length === 0 || values.some((value) => value === null)) return null;
  return values.reduce((sum, value) => sum + value, 0) / values.length;
}

// From values to pixels, with some round values between.
function axis(values, from, to, logarithmic) {
  let low = Math.min(...values), high = Math.max(...values);
  const log = logarithmic && low > 0;
  const go = log ? Math.log10 : (x) => x;
  if (low === high) { low = log ? low / 2 : low - 1; high = log ? high * 2 : high + 1; }
  const gap = (go(high) - go(low)) * 0.05;
  const first = go(low) - gap, last = go(high) + gap;
  const at = (value) => from + ((go(value) - first) / (last - first)) * (to - from);
  const ticks = [];
  if (log) {
    for (let power = Math.floor(first); power <= last; power += 1)
      for (const factor of last - first > 3 ? [1] : [1, 2, 5]) ticks.push(factor * 10 ** power);
  } else {
    const rough = (last - first) / 6, unit = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((factor) => factor * unit).find((size) => size >= rough);
    for (let value = Math.ceil(first / step) * step; value <= last; value += step) ticks.push(Number(value.toPrecision(12)));
  }
  return { at, ticks: ticks.filter((tick) => go(tick) >= first && go(tick) <= last) };
}

// Those of some designs that nothing else is as good as in both quantities.
function front(designs, across, up) {
  const small = (quantity, design) => (quantity.most ? -quantity.of(design) : quantity.of(design));
  const place = new Map(designs.map((design) => [design, [small(across, design), small(up, design)]]));
  const beats = ([a, b], [c, d]) => a <= c && b <= d && (a < c || b < d);
  return designs
    .filter((design) => !designs.some((other) => beats(place.get(other), place.get(design))))
    .sort((a, b) => across.of(a) - across.of(b));
}

const passes = (design) => [...brushes].every(([column, [low, high]]) => {
  const share = column.share(design);
  return share !== null && share >= low && share <= high;
});

const chosen = () => [quantities[by("across").value], quantities[by("up").value]];

function shown() {
  const [across, up] = chosen();
  return DATA.designs.filter((design) =>
    (design.out === null || by("out").checked) && across.of(design) !== null && up.of(design) !== null);
}

function scatter() {
  const [across, up] = chosen();
  const designs = shown();
  by("scatter").replaceChildren();
  if (designs.length === 0) { make("p", {}, by("scatter"), "No design has both figures."); return; }
  const width = 900, height = 460, left = 110, foot = 410;
  const svg = make("svg", { width, height, viewBox: `0 0 ${width} ${height}` }, by("scatter"));
  const logarithmic = by("logarithmic").checked;
  const x = axis(designs.map(across.of), left, width - 20, logarithmic);
  const y = axis(designs.map(up.of), foot, 15, logarithmic);
  for (const tick of x.ticks) {
    make("line", { x1: x.at(tick), x2: x.at(tick), y1: 15, y2: foot, stroke: "#ddd" }, svg);
    make("text", { x: x.at(tick), y: foot + 16, "text-anchor": "middle" }, svg, written(tick));
  }
  for (const tick of y.ticks) {
    make("line", { x1: left, x2: width - 20, y1: y.at(tick), y2: y.at(tick), stroke: "#ddd" }, svg);
    make("text", { x: left - 6, y: y.at(tick) + 4, "text-anchor": "end" }, svg, written(tick));
  }
  make("text", { x: (left + width) / 2, y: height - 8, "text-anchor": "middle" }, svg, across.name);
  make("text", { transform: `translate(14 ${foot / 2}) rotate(-90)`, "text-anchor": "middle" }, svg, up.name);
  const best = front(designs.filter((design) => design.out === null && passes(design)), across, up);
  const places = best.map((design) => `${x.at(across.of(design))},${y.at(up.of(design))}`);
  make("polyline", { points: places.join(" "), fill: "none", stroke: "#888", "stroke-dasharray": "4 3" }, svg);
  for (const design of designs) {
    const dot = make("circle", {
      cx: x.at(across.of(design)), cy: y.at(up.of(design)), r: pinned.has(design) ? 8 : 5, fill: design.out === null ? colour(design) : "white",
      stroke: best.includes(design) || pinned.has(design) ? "black" : colour(design), "stroke-width": best.includes(design) ? 2 : 1,
      opacity: passes(design) ? 1 : 0.1, class: best.includes(design) ? "front" : "",
    }, svg);
    dot.addEventListener("mousemove", (event) => tip(event, design));
    dot.addEventListener("mouseleave", () => { by("tip").style.display = "none"; });
    dot.addEventListener("click", () => pin(design));
  }
}

function tip(event, design) {
  const box = by("tip");
  box.replaceChildren();
  make("strong", {}, box, design.arch);
  for (const [name, value] of varied(design)) make("div", {}, box, `${name} ${written(value)}`);
  chosen().forEach((quantity) => make("div", {}, box, `${quantity.name}: ${written(quantity.of(design))}`));
  if (design.out !== null) make("div", {}, box, `out: ${design.out}`);
  box.style.left = `${event.pageX + 14}px`;
  box.style.top = `${event.pageY + 14}px`;
  box.style.display = "block";
}

// The parameters of a design of which some design of its architecture has another value.
function varied(design) {
  const family = DATA.designs.filter((other) => other.arch === design.arch);
  return Object.entries(design.parameters).filter(([name, value]) => family.some((other) => other.parameters[name] !== value));
}

function pin(design) {
  if (!pinned.delete(design)) pinned.add(design);
  const box = by("pinned");
  box.replaceChildren();
  if (pinned.size === 0) make("p", {}, box, "None yet.");
  for (const one of pinned) {
    const section = make("section", { style: `border-color: ${colour(one)}` }, box);
    make("h3", {}, section, one.name);
    if (one.out !== null) make("p", {}, section, `Out: ${one.out}`);
    make("p", {}, section, DATA.objectives.map((objective, k) => `${objective.name}: ${written(quantities[k].of(one))}`).join("; "));
    one.commands.forEach((command, k) => {
      make("pre", {}, section, command);
      const data = DATA.images[one.images[k]];
      if (data) make("img", { src: data, alt: `${one.name} on ${DATA.scenes[k]}` }, section);
    });
    const last = [...pinned].at(-2);
    if (last && one === [...pinned].at(-1) && last.files[0] && one.files[0]) {
      make("p", {}, section, "Why they differ:");
      make("pre", {}, section, `pellucid explain ${last.files[0]} ${one.files[0]}`);
    }
    make("button", {}, section, "Unpin").addEventListener("click", () => pin(one));
  }
  scatter();
}

// Parameters that change, of all architectures, and the objectives.
function columns() {
  const names = [...new Set(DATA.designs.flatMap((design) => Object.keys(design.parameters)))];
  const all = [{ name: "arch", of: (design) => design.arch }];
  for (const name of names) all.push({ name, of: (design) => design.parameters[name] ?? null });
  DATA.objectives.forEach((objective, k) => all.push({ name: objective.figure, of: quantities[k].of }));
  const inside = DATA.designs.filter((design) => design.out === null);
  const designs = inside.length > 0 ? inside : DATA.designs;
  const distinct = (column, those) => [...new Set(those.map(column.of).filter((value) => value !== null))];
  // What differs between architectures alone says no more than the architecture does.
  const changes = (column) => column.name === "arch" ? archs.length > 1 : archs.some((arch) =>
    distinct(column, DATA.designs.filter((design) => design.arch === arch)).length > 1);
  return all.filter(changes).filter((column) => distinct(column, designs).length > 0).map((column) => {
    const values = distinct(column, designs);
    const numbers = values.every((value) => typeof value === "number");
    const low = numbers ? Math.min(...values) : 0, high = numbers ? Math.max(...values) : values.length - 1;
    const place = (value) => ((numbers ? value : values.indexOf(value)) - low) / (high - low || 1);
    // Of those that are out, what lies beyond is shown at the end.
    const share = (design) => { const value = column.of(design); return value === null ? null : Math.min(1, Math.max(0, place(value))); };
    return { ...column, share, ends: numbers ? [low, high] : [values[0], values[values.length - 1]], values, numbers };
  });
}

const COLUMNS = columns();

function parallel() {
  by("parallel").replaceChildren();
  if (COLUMNS.length === 0) return;
  const step = 130, width = step * COLUMNS.length, top = 50, foot = 330;
  const svg = make("svg", { width, height: 360 }, by("parallel"));
  const x = (k) => step / 2 + k * step;
  const y = (share) => foot - share * (foot - top);
  for (const design of DATA.designs) {
    const places = COLUMNS.map((column, k) => [x(k), column.share(design)]).filter(([, share]) => share !== null);
    const faint = design.out !== null || !passes(design);
    make("polyline", {
      points: places.map(([at, share]) => `${at},${y(share)}`).join(" "), fill: "none", stroke: colour(design), opacity: faint ? 0.06 : 0.7,
      "stroke-width": design.front ? 2.5 : 1,
    }, svg);
  }
  COLUMNS.forEach((column, k) => {
    make("line", { x1: x(k), x2: x(k), y1: top, y2: foot, stroke: "black" }, svg);
    make("text", { x: x(k), y: 16, "text-anchor": "middle" }, svg, column.name);
    make("text", { x: x(k), y: top - 8, "text-anchor": "middle" }, svg, written(column.ends[1]));
    make("text", { x: x(k), y: foot + 18, "text-anchor": "middle" }, svg, written(column.ends[0]));
    const brush = brushes.get(column);
    if (brush) make("rect", { class: "brush", x: x(k) - 10, width: 20, y: y(brush[1]), height: Math.max(y(brush[0]) - y(brush[1]), 2) }, svg);
    const handle = make("rect", { x: x(k) - 12, width: 24, y: top, height: foot - top, fill: "transparent", cursor: "crosshair" }, svg);
    // A hand that comes near an end means the end.
    const share = (event) => {
      const exact = (foot - (event.clientY - svg.getBoundingClientRect().top)) / (foot - top);
      return exact < 0.03 ? 0 : exact > 0.97 ? 1 : exact;
    };
    handle.addEventListener("mousedown", (event) => {
      const start = share(event);
      const end = (up) => {
        window.removeEventListener("mouseup", end);
        const stop = share(up);
        if (Math.abs(stop - start) < 0.02) brushes.delete(column);
        else brushes.set(column, [Math.min(start, stop), Math.max(start, stop)]);
        parallel(); scatter(); table();
      };
      window.addEventListener("mouseup", end);
      event.preventDefault();
    });
  });
}

function effects() {
  const [, up] = chosen();
  by("effects").replaceChildren();
  const designs = DATA.designs.filter((design) => design.out === null && up.of(design) !== null);
  for (const column of COLUMNS.filter((column) => !DATA.objectives.some((objective) => objective.figure === column.name))) {
    const values = [...column.values].sort((a, b) => (column.numbers ? a - b : 0));
    const means = values.map((value) => {
      const those = designs.filter((design) => column.of(design) === value).map(up.of);
      return those.length === 0 ? null : those.reduce((sum, one) => sum + one, 0) / those.length;
    });
    const there = means.filter((one) => one !== null);
    if (there.length < 2) continue;
    const svg = make("svg", { width: 300, height: 180 }, by("effects"));
    make("text", { x: 150, y: 14, "text-anchor": "middle" }, svg, column.name);
    const y = axis(there, 140, 30, false);
    const x = (k) => 80 + (k * 200) / Math.max(values.length - 1, 1);
    y.ticks.forEach((tick) => make("text", { x: 60, y: y.at(tick) + 4, "text-anchor": "end" }, svg, written(tick)));
    const places = means.map((one, k) => (one === null ? null : `${x(k)},${y.at(one)}`)).filter((place) => place !== null);
    make("polyline", { points: places.join(" "), fill: "none", stroke: "#0072b2", "stroke-width": 2 }, svg);
    values.forEach((value, k) => {
      if (means[k] !== null) make("circle", { cx: x(k), cy: y.at(means[k]), r: 3 }, svg);
      if (values.length < 7 || k % Math.ceil(values.length / 6) === 0)
        make("text", { x: x(k), y: 160, "text-anchor": "middle" }, svg, written(value));
    });
  }
}

let sorted = { key: DATA.objectives[0].figure, down: DATA.objectives[0].most };

function table() {
  const keys = [
    { name: "machine", of: (design) => design.name },
    { name: "front", of: (design) => (design.front ? "yes" : "") },
    ...DATA.objectives.map((objective, k) => ({ name: objective.figure, of: quantities[k].of })),
    { name: "out", of: (design) => design.out ?? "" },
  ];
  const key = keys.find((one) => one.name === sorted.key) ?? keys[0];
  const word = by("filter").value;
  const rows = DATA.designs.filter((design) => passes(design) && design.name.includes(word));
  const order = (a, b) => {
    const [x, y] = [key.of(a), key.of(b)];
    if (x === null || y === null) return (x === null) - (y === null);
    return (x < y ? -1 : x > y ? 1 : 0) * (sorted.down ? -1 : 1);
  };
  rows.sort(order);
  const box = by("designs");
  box.replaceChildren();
  const head = make("tr", {}, box);
  for (const one of keys) {
    const mark = one === key ? (sorted.down ? " \u25bc" : " \u25b2") : "";
    make("th", {}, head, one.name + mark).addEventListener("click", () => {
      sorted = { key: one.name, down: one === key && !sorted.down };
      table();
    });
  }
  for (const design of rows) {
    const row = make("tr", { class: design.front ? "front" : "" }, box);
    for (const one of keys) {
      const value = one.of(design);
      make("td", { class: typeof value === "number" ? "number" : "" }, row, written(value));
    }
    row.firstChild.style.cursor = "pointer";
    row.firstChild.addEventListener("click", () => pin(design));
  }
  by("count").textContent = `${rows.length} of ${DATA.designs.length}`;
}

quantities.forEach((quantity, k) => {
  for (const id of ["across", "up"]) make("option", { value: k }, by(id), quantity.name);
});
by("across").value = DATA.objectives.length > 1 ? 1 : 0;
by("up").value = 0;
for (const id of ["across", "up", "logarithmic", "out"]) by(id).addEventListener("change", () => { scatter(); effects(); });
by("filter").addEventListener("input", table);
archs.forEach((arch) => {
  const sample = make("span", { class: "sample" }, by("legend"));
  make("span", { class: "colour", style: `background: ${DATA.colours[archs.indexOf(arch)]}` }, sample);
  make("span", {}, sample, ` ${arch}`);
});
scatter();
parallel();
effects();
table();
