// The error budget: stacked bars, a bar a mode, a colour a part; the total is a mark with its value.
const budget = read("budget");
if (budget) chart("budget-chart", ["budget-case", "budget-reference", "budget-elements"], () => {
  const [name, reference, s] = ["case", "reference", "elements"].map((one) => $(`budget-${one}`).value);
  const one = budget.find((each) => each.reference === reference);
  const here = one.cases[name], k = one.elements.indexOf(Number(s));
  if (!here || k < 0) return {data: [], layout: {}, numbers: () => ({head: [], rows: []}),
    caption: `There is no budget against ${reference} at ${name} with s = ${s}.`};
  const modes = one.modes.map((i) => `f${i}`);
  const told = (part, value, i, record) => value === null ? "" : cell(signed(value, 3), `${signed(value, 5)} points`,
    `${modes[i]}: ${part}, s = ${s}, ${name}`, record);
  const records = here.records[k];
  const data = one.parts.map((part, p) => ({
    type: "bar", name: part, x: modes, y: here.shares[k][p], width: 0.62,
    marker: {color: css(`--m${p % 6 + 1}`)},
    customdata: here.shares[k][p].map((value, i) => told(part, value, i, records[p])),
    hovertemplate: `${part}: %{y:+.3f} points<extra></extra>`,
  }));
  const total = here.total[k];
  data.push({
    name: "total error", x: modes, y: total, mode: "markers",
    marker: {symbol: "diamond", size: 11, color: css("--ink"), line: {width: 1.5, color: css("--paper")}},
    error_y: here.band.some((value) => value !== null)
      ? {array: here.band, color: css("--ink"), thickness: 1.2, width: 4} : undefined,
    customdata: total.map((value, i) => told("total error", value, i, records.at(-1))),
    hovertemplate: "total: %{y:+.3f} %<extra></extra>",
  });
  // The value stands over the bar, where nothing lies under it.
  const top = modes.map((_, i) => here.shares[k].reduce((sum, part) => sum + Math.max(0, part[i] ?? 0), 0));
  const annotations = modes.map((x, i) => ({x, y: Math.max(top[i], (total[i] ?? 0) + (here.band[i] ?? 0)), yshift: 15,
    text: total[i] === null ? "" : `<b>${signed(total[i], 2)}</b>`, showarrow: false, font: {color: css("--ink"), size: 12}}));
  const layout = {annotations, barmode: "relative", xaxis: {}, yaxis: {title: {text: "share of the error [points]"}}};
  const bars = here.band.some((value) => value !== null) ? " Whiskers: the reference’s own numerical uncertainty." : "";
  const caption = `Error of ${one.theory} with ${s} ${s === "1" ? "element" : "elements"} a limb ` +
    `against ${reference}, ${name}, by cause, in percentage points of the reference.${bars}`;
  const numbers = () => ({head: ["part", ...modes], rows: [...one.parts.map((part, p) =>
    [part, ...here.shares[k][p].map((value, i) => told(part, value, i, records[p]))]),
    ["total error", ...total.map((value, i) => told("total error", value, i, records.at(-1)))]]});
  return {data, layout, caption, numbers};
});
