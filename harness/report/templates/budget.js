// The error budget: stacked bars, a bar a mode, a colour a part.
const budget = read("budget");
if (budget) chart("budget-chart", ["budget-case", "budget-elements"], () => {
  const [name, s] = [$("budget-case").value, $("budget-elements").value];
  const here = budget.rows.filter((row) => row.case === name);
  const own = here.find((row) => row.part.startsWith("reference's own"));
  const parts = here.filter((row) => row.s === s && row.part !== "total error");
  const total = here.find((row) => row.s === s && row.part === "total error");
  const tint = [1, 2, 3, 4, 5];
  const told = (row, k) => cell("", `${signed(row.values[k], 5)} points`,
    `f${k + 1}: ${row.part}, s = ${s}, ${name}`, row.records[k]);
  const data = parts.map((row, p) => ({
    type: "bar", name: row.part, x: budget.modes, y: row.values, width: 0.62,
    marker: {color: css(`--m${tint[p]}`)},
    customdata: row.values.map((_, k) => told(row, k)),
    hovertemplate: `${row.part}: %{y:+.3f} points<extra></extra>`,
  }));
  if (total) data.push({
    name: "total error", x: budget.modes, y: total.values, mode: "markers",
    marker: {symbol: "line-ew-open", size: 26, color: css("--ink"), line: {width: 2}},
    error_y: own ? {array: own.values, color: css("--ink"), thickness: 1.2, width: 4} : undefined,
    customdata: total.values.map((_, k) => told(total, k)),
    hovertemplate: "total: %{y:+.3f} %<extra></extra>",
  });
  const layout = {barmode: "relative", xaxis: {}, yaxis: {title: {text: "share of the error [points]"}}};
  const bars = own ? " Whiskers: the reference’s own numerical uncertainty." : "";
  const caption = `Error of ${budget.theory} with ${s} ${s === "1" ? "element" : "elements"} a limb ` +
    `against ${budget.reference}, ${name}, by cause, in percentage points of the reference.${bars}`;
  return {data, layout, caption};
});
