"use strict";
// What all sections share: choices, charts, tables of numbers, and where a number comes from.
const $ = (id) => document.getElementById(id);
// What is large is in the page packed: the data of all sections, and the plotting library.
async function unpack(id) {
  const packed = Uint8Array.from(atob($(id).textContent), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
}
const kept = JSON.parse(await unpack("data"));
const read = (key) => kept[key] ?? null;
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const ledger = read("ledger");
const SYMBOLS = ["circle", "square", "triangle-up", "diamond", "triangle-down", "hexagon"];
const colour = (mode) => css(`--m${(mode - 1) % 6 + 1}`);
const symbol = (mode) => SYMBOLS[(mode - 1) % 6];
const CONFIG = {displayModeBar: false, responsive: true, displaylogo: false};
const webgl = !!document.createElement("canvas").getContext("webgl");
const range = (from, to) => Array.from({length: Math.max(0, to - from + 1)}, (_, k) => from + k);
const signed = (value, digits) => (value > 0 ? "+" : "") + value.toFixed(digits);

function element(tag, text = "", attributes = {}) {
  const made = document.createElement(tag);
  made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

// A number with all its digits, what it is, and its record in the ledger.
const cell = (text, full, what, record) => ({text, full, what, record});

function ask({full, what, record}) {
  $("record-title").textContent = what;
  $("record-value").textContent = full;
  const body = $("record-body");
  body.replaceChildren();
  const describe = ({title, fields, parts}, heading) => {
    if (heading) body.append(element("h3", title));
    const list = element("dl", "", {class: "fields"});
    for (const [name, text] of Object.entries(fields)) {
      const value = element("dd");
      value.append(name === "Command" ? element("code", text) : text);
      list.append(element("dt", name), value);
    }
    body.append(list);
    for (const part of parts) if (part !== null) describe(ledger[part], true);
  };
  // A record of its own where the page made the number; else one of the ledger's.
  if (typeof record === "object") describe(record, false);
  else describe(ledger[record], ledger[record].title !== what);
  $("record").showModal();
}

document.addEventListener("click", (event) => {
  const button = event.target.closest("button.n");
  if (button) ask(button.cell ?? {...button.dataset, record: Number(button.dataset.record)});
});

function select(id, options, chosen) {
  const list = $(id);
  const kept = chosen ?? list.value;
  list.replaceChildren(...options.map(([value, text]) => element("option", text, {value})));
  if (options.some(([value]) => String(value) === String(kept))) list.value = kept;
}

// Charts: drawn when they come near the screen, again when a choice or the theme changes.
const charts = new Map();
let before = null; // how the page was before it went to paper

function chart(id, controls, make) {
  charts.set(id, {make, near: false, listening: false});
  for (const control of controls) $(control).addEventListener("input", () => update(id));
  const numbers = $(`${id}-numbers`);
  if (numbers) numbers.addEventListener("toggle", () => update(id));
  update(id);
}

function update(id) {
  const own = charts.get(id);
  const {data, layout, caption, numbers, three} = own.make();
  legend(id, data);
  const caption_of = $(`${id}-caption`);
  if (caption_of && caption) caption_of.textContent = caption;
  if ($(`${id}-numbers`)?.open) tabulate($(`${id}-numbers`).querySelector(".numbers"), caption, numbers());
  if (!own.near) return;
  const place = $(id);
  if (three && !webgl) {
    place.classList.add("empty");
    place.textContent = "This browser has no WebGL, which pictures in three dimensions need.";
    return;
  }
  // Paper has its own width, which the screen cannot know: A4 or Letter less the margins of page.css.
  const size = before ? {autosize: false, width: place.closest(".two") ? 330 : 680, height: 310} : {autosize: true};
  Plotly.react(place, data, themed({...layout, ...size}), CONFIG);
  if (!own.listening) {
    own.listening = true;
    place.on("plotly_click", (event) => {
      const known = event.points[0].customdata;
      if (known?.what) ask(known);
    });
  }
}

// The legend is part of the page, not of the picture: it takes the lines it needs, and a click on a
// name hides its curve or shows it again.
const FORMS = {
  circle: "M8 4a4 4 0 1 0 .01 0z", square: "M4.5 4.5h7v7h-7z", "triangle-up": "M8 3.5l4.5 8h-9z",
  diamond: "M8 3l5 5-5 5-5-5z", "triangle-down": "M8 12.5l4.5-8h-9z", hexagon: "M3.5 8l2.2-4h4.6l2.2 4-2.2 4H5.7z",
};
function legend(id, data) {
  const list = $(`${id}-legend`), own = charts.get(id);
  const named = data.filter((one) => one.name && !one.quiet);
  list.hidden = named.length < 2;
  own.off = new Set(named.map((one) => one.name).filter((name) => own.off?.has(name)));
  for (const one of named) one.visible = own.off.has(one.name) ? "legendonly" : true;
  const looks = named.map((one) => [one.name, String(one.marker?.symbol ?? "square"),
    one.type === "bar" || !one.line ? one.marker?.color : one.line.color]);
  // Buttons that are right stay: one of them may have the focus.
  if (list.dataset.looks === JSON.stringify(looks)) {
    list.querySelectorAll("button").forEach((button, k) => button.setAttribute("aria-pressed", String(named[k].visible === true)));
    return;
  }
  list.dataset.looks = JSON.stringify(looks);
  list.replaceChildren(...named.map((one, k) => {
    const [form, tint] = [looks[k][1].replace("-open", ""), looks[k][2]];
    const drawing = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    drawing.setAttribute("viewBox", "0 0 16 16");
    drawing.setAttribute("aria-hidden", "true");
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    path.setAttribute("d", FORMS[form] ?? FORMS.square);
    path.setAttribute("stroke", tint);
    path.setAttribute("fill", looks[k][1].endsWith("-open") ? "none" : tint);
    drawing.append(path);
    const text = element("span");
    text.append(...one.name.split(/<sub>(.*?)<\/sub>/).map((part, k) => k % 2 ? element("sub", part) : part));
    const button = element("button", "", {type: "button", "aria-pressed": String(one.visible === true)});
    button.append(drawing, text);
    button.addEventListener("click", () => {
      if (!own.off.delete(one.name)) own.off.add(one.name);
      update(id);
    });
    const item = element("li");
    item.append(button);
    return item;
  }));
}

function themed(layout) {
  const [ink, muted, rule] = [css("--ink"), css("--muted"), css("--rule")];
  const axis = {gridcolor: rule, linecolor: rule, zerolinecolor: css("--faint"), tickcolor: rule,
    automargin: true, tickfont: {color: muted, size: 12}};
  const result = {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: {family: "system-ui, sans-serif", size: 13, color: ink},
    margin: {l: 56, r: 12, t: 12, b: 48},
    hoverlabel: {bgcolor: css("--panel"), bordercolor: rule, font: {color: ink}},
    hovermode: "closest", dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
    showlegend: false,
    ...layout,
  };
  for (const name of ["xaxis", "yaxis"]) result[name] = {...axis, ...layout[name]};
  if (layout.scene) {
    const box = {gridcolor: rule, color: muted, backgroundcolor: "rgba(0,0,0,0)", zerolinecolor: rule};
    const scene = {...layout.scene};
    for (const name of ["xaxis", "yaxis", "zaxis"]) scene[name] = {...box, ...scene[name]};
    result.scene = scene;
  }
  if (layout.polar) {
    const ring = {gridcolor: rule, linecolor: rule, tickcolor: rule, tickfont: {color: muted, size: 11}};
    result.polar = {bgcolor: "rgba(0,0,0,0)", ...layout.polar,
      radialaxis: {...ring, ...layout.polar.radialaxis},
      angularaxis: {...ring, ...layout.polar.angularaxis}};
  }
  return result;
}

function tabulate(place, caption, {head, rows}) {
  const table = element("table", "", {role: "table"});
  table.append(element("caption", caption));
  const top = element("tr", "", {role: "row"});
  head.forEach((name, k) => top.append(element("th", name, {scope: "col", role: "columnheader", class: k ? "r" : ""})));
  const thead = element("thead", "", {role: "rowgroup"});
  thead.append(top);
  const body = element("tbody", "", {role: "rowgroup"});
  for (const row of rows) {
    const line = element("tr", "", {role: "row"});
    row.forEach((one, k) => {
      const box = element("td", "", {class: k ? "r" : "", role: "cell", "data-name": head[k]});
      if (one?.what) {
        const button = element("button", one.text, {type: "button", class: "n"});
        button.cell = one;
        box.append(button);
      } else box.textContent = one ?? "";
      line.append(box);
    });
    body.append(line);
  }
  table.append(thead, body);
  place.replaceChildren(table);
}

function draw(id) {
  const own = charts.get(id);
  if (own.near) return;
  own.near = true;
  update(id);
}

function redraw() {
  for (const id of charts.keys()) update(id);
}

// The plotting library is in the page packed; unpacked it takes longest, so what can be read shows first.
async function library() {
  // The second frame comes when the first is on the screen.
  await new Promise((shown) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(shown))));
  document.head.append(element("script", await unpack("plotly")));
  root.dataset.charts = "ready";
}

// Called once the plotting library is there.
function watch() {
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) {
      seen.unobserve(entry.target);
      draw(entry.target.id);
    }
  }, {rootMargin: "300px"});
  for (const id of charts.keys()) seen.observe($(id));
  const links = new Map([...document.querySelectorAll("nav li a")].map((a) => [a.hash.slice(1), a]));
  const current = new IntersectionObserver((entries) => {
    for (const {target, isIntersecting} of entries) {
      if (isIntersecting) {
        links.get(target.id).setAttribute("aria-current", "true");
        $("menu").textContent = links.get(target.id).textContent;
      }
      else links.get(target.id).removeAttribute("aria-current");
    }
  }, {rootMargin: "-10% 0px -85% 0px"});
  document.querySelectorAll("main > section").forEach((one) => current.observe(one));
}

// On a phone the sections are behind a button that says where one is.
const menu = (open) => { $("menu").setAttribute("aria-expanded", String(open)); };
$("menu").addEventListener("click", () => menu($("menu").getAttribute("aria-expanded") !== "true"));
$("sections").addEventListener("click", () => menu(false));
document.addEventListener("keydown", (event) => { if (event.key === "Escape") menu(false); });

// A link to what is folded away opens it.
const unfold = () => {
  let one = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  for (; one; one = one.parentElement) if (one.tagName === "DETAILS") one.open = true;
};
addEventListener("hashchange", unfold);
unfold();

// Light or dark; on paper always light, with every chart drawn and every table open.
const root = document.documentElement;
function theme(name) {
  root.dataset.theme = name;
  $("theme").textContent = name === "dark" ? "Light" : "Dark";
  $("theme").setAttribute("aria-label", name === "dark" ? "Light theme" : "Dark theme");
}
theme(root.dataset.theme);
$("theme").addEventListener("click", () => {
  theme(root.dataset.theme === "dark" ? "light" : "dark");
  try { localStorage.setItem("theme", root.dataset.theme); } catch { /* not remembered */ }
  redraw();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => {
  theme(event.matches ? "dark" : "light");
  redraw();
});
const print = matchMedia("print");
function paper(printing) {
  if (printing === (before !== null)) return;
  if (printing) {
    before = {theme: root.dataset.theme, closed: [...document.querySelectorAll("details.print:not([open])")]};
    before.closed.forEach((one) => { one.open = true; });
    theme("light");
    for (const own of charts.values()) own.near = true;
  } else {
    before.closed.forEach((one) => { one.open = false; });
    theme(before.theme);
    before = null;
  }
  redraw();
}
addEventListener("beforeprint", () => paper(true));
addEventListener("afterprint", () => paper(print.matches));
print.addEventListener("change", () => paper(print.matches));
