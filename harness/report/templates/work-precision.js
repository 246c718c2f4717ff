// Work and precision: both axes logarithmic, a line a model.
const work = read("work-precision");
if (work) chart("work-chart", ["work-case", "work-modes"], () => {
  const [name, modes] = [$("work-case").value, $("work-modes").value];
  const here = work.filter((row) => row[0] === name && row[3] === modes && row[5] > 0);
  const models = [...new Set(here.map((row) => row[1]))];
  const data = models.map((model, k) => {
    const rows = here.filter((row) => row[1] === model).sort((a, b) => a[4] - b[4]);
    return {
      name: model, x: rows.map((row) => row[4]), y: rows.map((row) => row[5]),
      mode: "lines+markers", line: {color: colour(k + 1), width: 1.5, dash: k < 6 ? "solid" : "dash"},
      marker: {symbol: SYMBOLS[k % 6] + (k < 6 ? "" : "-open"), size: 8, color: colour(k + 1)},
      customdata: rows.map((row) => cell("", `${row[5]} % in ${row[4]} ms a pose`,
        `${model}, elements ${row[2]}, ${modes}, ${name}`, row[6])),
      text: rows.map((row) => row[2]),
      hovertemplate: `${model}, elements %{text}: %{y:.3g} % in %{x:.3g} ms<extra></extra>`,
    };
  });
  const log = {type: "log", exponentformat: "power", dtick: 1};
  const layout = {xaxis: {...log, title: {text: "time a pose [ms]"}},
    yaxis: {...log, title: {text: "largest |error| [%]"}}};
  const caption = `Largest error of ${modes} against the time a pose takes, ${name}, for each model ` +
    "and mesh.";
  return {data, layout, caption};
});
