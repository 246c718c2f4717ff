// Work and precision: both axes logarithmic, a line a model.
const work = read("work-precision");
if (work) chart("work-chart", ["work-case", "work-theory", "work-modes", "work-error"], () => {
  const [name, theory, modes] = ["case", "theory", "modes"].map((one) => $(`work-${one}`).value);
  const error = $("work-error").selectedOptions[0].text;
  const here = work.filter((row) => row[0] === name && row[4] === modes && (!theory || row[2] === theory))
    .map(([, model, , elements, , record, ms, ...errors]) => ({elements, record, ms,
      model: model + (elements.includes("+") ? ", extrapolated" : ""), e: Math.abs(errors[$("work-error").value])}))
    .filter((one) => one.ms > 0 && one.e > 0);
  const models = [...new Set(here.map((one) => one.model))];
  const data = models.map((model, k) => {
    // No line leads from the last mesh to what needs none.
    const rows = here.filter((one) => one.model === model)
      .flatMap((one, n) => n && !parseInt(one.elements) ? [{}, one] : [one]);
    return {
      name: theory ? model.replace(`, ${theory}`, "") : model, x: rows.map((one) => one.ms), y: rows.map((one) => one.e),
      mode: "lines+markers", line: {color: colour(k + 1), width: 1.3, dash: ["solid", "dot", "dash"][Math.floor(k / 6) % 3]},
      marker: {symbol: SYMBOLS[k % 6] + (k < 6 ? "" : "-open"), size: 8, color: colour(k + 1)},
      customdata: rows.map((one) => one.ms && cell("", `${one.e} % in ${one.ms} ms a pose`,
        `${model}, ${one.elements || "no"} elements, ${modes}, ${name}`, one.record)),
      text: rows.map((one) => one.elements),
      hovertemplate: `${model}, elements %{text}: %{y:.3g} % in %{x:.3g} ms<extra></extra>`,
    };
  });
  const log = {type: "log", exponentformat: "power"};
  const layout = {showlegend: true, xaxis: {...log, title: {text: "time a pose [ms]"}}, yaxis: {...log, title: {text: error}}};
  const caption = `${error.replace(" [%]", "")}: the largest of ${modes} in percent, against the time a pose ` +
    `takes, ${name}; ${theory ? `models of ${theory}` : "every model"}, each with more and more elements.`;
  return {data, layout, caption};
});
