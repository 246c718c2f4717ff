// Fig. 3: the errors were worked out when the page was made; here they are chosen and drawn.
const fig3 = read("fig3");
chart("fig3-chart", ["fig3-case", "fig3-theory", "fig3-reference", "fig3-mode", "fig3-scale"], () => {
  const [name, theory, reference, mode, scale] =
    ["case", "theory", "reference", "mode", "scale"].map((one) => $(`fig3-${one}`).value);
  const {theories, references, printed} = fig3.cases[name];
  const known = references[reference];
  const log = scale === "log";
  const shown = mode === "all" ? range(1, 6) : [Number(mode)];
  const named = $("fig3-theory").selectedOptions[0].text;
  if (!known) return {data: [], layout: {}, numbers: () => ({head: [], rows: []}),
    caption: `${reference} has no frequencies at ${name} that could be paired.`};
  const errors = theories[theory].errors[reference];
  const point = (i, k) => cell(signed(errors[k][i - 1], 4), `${signed(errors[k][i - 1], 7)} %`,
    `e${i}: ${theory}@${fig3.elements[k]} against ${reference}, ${name}`,
    {fields: {"Made as": "100 (theory / reference − 1), each mode paired by its shape",
      Command: `rps-bench convergence --cases ${name} --model ${theory} --references ${reference} --elements ${fig3.elements[k]}`},
    parts: [theories[theory].records[k], known.record]});
  const data = shown.map((i) => ({
    name: `f<sub>${i}</sub>`, x: fig3.elements, mode: "lines+markers",
    y: errors.map((row) => log ? Math.abs(row[i - 1]) : row[i - 1]),
    customdata: errors.map((_, k) => point(i, k)),
    line: {color: colour(i), width: 1.5},
    marker: {symbol: symbol(i), size: i % 2 ? 9 : 6, color: colour(i)},
    hovertemplate: `f<sub>${i}</sub>, s = %{x}: %{y:.4f} %<extra></extra>`,
  }));
  const own = known.uncertainty;
  for (const i of shown) {
    const quoted = printed.filter((one) => one[1] === i);
    if (quoted.length) data.push({
      x: quoted.map((one) => one[0]), y: quoted.map((one) => one[2]), mode: "markers",
      showlegend: false, marker: {symbol: `${symbol(i)}-open`, size: 13, color: colour(i)},
      hovertemplate: `printed: f<sub>${i}</sub>, s = %{x}: %{y} %<extra></extra>`,
    });
    if (own && own[i - 1] !== null) data.push({
      x: [0.7, 8.3], y: [own[i - 1], own[i - 1]], mode: "lines", showlegend: false,
      line: {color: colour(i), width: 1, dash: "dot"},
      hovertemplate: `the reference’s own uncertainty of f<sub>${i}</sub>: %{y:.4f} %<extra></extra>`,
    });
  }
  const layout = {
    xaxis: {title: {text: "elements a limb, s"}, tickvals: fig3.elements, range: [0.7, 8.3]},
    yaxis: {title: {text: log ? "|error| [%]" : "error [%]"}, type: scale,
      exponentformat: "power"},
  };
  const dotted = own ? " Dotted: the reference’s own numerical uncertainty." : "";
  const caption = `Error of ${named} with s elements a limb against ${reference} ` +
    `(${known.theory}), ${name}, in percent of the reference.${dotted}`;
  const numbers = () => ({
    head: ["s", ...shown.map((i) => `e${i} [%]`)],
    rows: fig3.elements.map((s, k) => [s, ...shown.map((i) => point(i, k))]),
  });
  return {data, layout, caption, numbers};
});
