// Work and precision: both axes logarithmic, a line a model.
const work = read("work-precision");
if (work) chart("work-chart", ["work-theory", "work-modes", "work-error"], () => {
  const [theory, modes, kind] = ["theory", "modes", "error"].map((one) => $(`work-${one}`).value);
  const group = work.groups[modes], against = work.kinds[kind];
  const here = work.rows.filter((row) => !theory || row.theory === theory)
    .map((row) => ({...row, e: row.errors[kind][modes], method: row.method + (row.size.includes("+") ? ", extrapolated" : "")}))
    .filter((row) => row.ms > 0 && row.e > 0);
  const told = (row) => cell(`${row.e}`, `${row.e} % in ${row.ms} ms a pose`, `${row.method}, elements ${row.size}, ${group}`, row.record);
  const data = [...new Set(here.map((row) => row.method))].map((method, k) => {
    // No line leads from the last mesh to what needs none.
    const rows = here.filter((row) => row.method === method)
      .flatMap((row, n) => n && !parseInt(row.size) ? [{}, row] : [row]);
    return {
      name: method, x: rows.map((row) => row.ms ?? null), y: rows.map((row) => row.e ?? null),
      mode: "lines+markers", line: {color: colour(k + 1), width: 1.3, dash: ["solid", "dot", "dash"][Math.floor(k / 6) % 3]},
      marker: {symbol: SYMBOLS[k % 6] + (k < 6 ? "" : "-open"), size: 8, color: colour(k + 1)},
      customdata: rows.map((row) => row.ms ? told(row) : ""), text: rows.map((row) => row.size ?? ""),
      hovertemplate: `${method}, elements %{text}: %{y:.3g} % in %{x:.3g} ms<extra></extra>`,
    };
  });
  const log = {type: "log", exponentformat: "power"};
  const layout = {xaxis: {...log, title: {text: "time a pose [ms]"}}, yaxis: {...log, title: {text: "largest error [%]"}}};
  const caption = `The largest error of ${group} against ${against} in percent, over the time a pose takes; ` +
    `${theory ? `models of ${theory}` : "every model"}, each with more and more elements.`;
  const numbers = () => ({head: ["way", "elements", "ms a pose", "error [%]"],
    rows: here.map((row) => [row.method, row.size, String(row.ms), told(row)])});
  return {data, layout, caption, numbers};
});
