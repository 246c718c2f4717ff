// Fig. 3: the errors were worked out when the run was made; here they are chosen and drawn.
const fig3 = read("fig3");
if (fig3) chart("fig3-chart", ["fig3-case", "fig3-theory", "fig3-reference", "fig3-mode", "fig3-scale"], () => {
  const [name, theory, reference, mode, scale] =
    ["case", "theory", "reference", "mode", "scale"].map((one) => $(`fig3-${one}`).value);
  const {families, references, printed} = fig3.cases[name];
  const family = families[theory], known = references[reference];
  const log = scale === "log";
  const shown = mode === "all" ? fig3.modes : [Number(mode)];
  if (!known || !family) return {data: [], layout: {}, numbers: () => ({head: [], rows: []}),
    caption: `There is no answer of ${known ? theory : reference} at ${name}.`};
  const errors = family.errors[reference], floors = family.floors[reference];
  const at = (k, i) => errors[k]?.[fig3.modes.indexOf(i)] ?? null;
  const fit = (value) => log && value !== null ? Math.abs(value) : value;
  const point = (i, k) => at(k, i) === null ? "" : cell(signed(at(k, i), 4), `${signed(at(k, i), 7)} %`,
    `e${i}: ${family.labels[k]} against ${reference}, ${name}`,
    {fields: {"Made as": "100 (model / reference − 1), each mode paired by its shape", Command: fig3.command},
    parts: [family.records[k], known.record]});
  // Modes whose curves lie on each other share a name in the legend.
  const same = (i, j) => fig3.elements.every((_, k) => at(k, i) !== null && at(k, j) !== null
    && Math.abs(at(k, i) - at(k, j)) <= 1e-3 * Math.abs(at(k, i)));
  const ends = [fig3.elements[0] - 0.3, fig3.elements.at(-1) + 0.3];
  const data = shown.map((i) => ({
    name: `e<sub>${i}</sub>`, x: fig3.elements, mode: "lines+markers", connectgaps: true,
    y: fig3.elements.map((_, k) => fit(at(k, i))),
    customdata: fig3.elements.map((_, k) => point(i, k)),
    line: {color: colour(i), width: i % 2 ? 3 : 1.3},
    marker: {symbol: symbol(i), size: i % 2 ? 10 : 6, color: colour(i)},
    hovertemplate: `e<sub>${i}</sub>, s = %{x}: %{y:.4f} %<extra></extra>`,
  }));
  const own = known.uncertainty;
  for (const i of shown) {
    const quoted = printed.filter((one) => one[1] === i);
    if (quoted.length) data.push({
      x: quoted.map((one) => one[0]), y: quoted.map((one) => one[2]), mode: "markers",
      quiet: true, marker: {symbol: `${symbol(i)}-open`, size: 13, color: colour(i)},
      hovertemplate: `printed: e<sub>${i}</sub>, s = %{x}: %{y} %<extra></extra>`,
    });
    const floor = floors?.[fig3.modes.indexOf(i)] ?? null;
    if (floor !== null) data.push({
      x: ends, y: [fit(floor), fit(floor)], mode: "lines", quiet: true,
      line: {color: colour(i), width: 1.2, dash: "dash"},
      hovertemplate: `floor of e<sub>${i}</sub>: ${family.limit}: %{y:.4f} %<extra></extra>`,
    });
    const unsure = own?.[fig3.modes.indexOf(i)] ?? null;
    if (unsure !== null) data.push({
      x: ends, y: [unsure, unsure], mode: "lines", quiet: true,
      line: {color: colour(i), width: 1, dash: "dot"},
      hovertemplate: `the reference’s own uncertainty of f<sub>${i}</sub>: %{y:.4f} %<extra></extra>`,
    });
  }
  const layout = {
    xaxis: {title: {text: "elements a limb, s"}, tickvals: fig3.elements, range: ends},
    yaxis: {title: {text: log ? "|error| [%]" : "error [%]"}, type: scale, exponentformat: "power"},
  };
  const pairs = shown.flatMap((i) => shown.filter((j) => j > i && same(i, j)).map((j) => `e${i} and e${j}`));
  const caption = `Error of ${theory} with s elements a limb against ${reference} ` +
    `(${known.theory}), ${fig3.cases[name].heading}, in percent of the reference.` +
    `${pairs.length ? ` ${pairs.join("; ")} lie on each other.` : ""}` +
    `${floors ? ` Dashed: ${family.limit}.` : ""}` +
    `${own ? " Dotted: the reference’s own numerical uncertainty." : ""}` +
    `${printed.length ? " Hollow: quoted by the paper." : ""}`;
  const numbers = () => ({
    head: ["s", ...shown.map((i) => `e${i} [%]`)],
    rows: [...fig3.elements.map((s, k) => [s, ...shown.map((i) => point(i, k))]),
      ...(floors ? [["floor", ...shown.map((i) => signed(floors[fig3.modes.indexOf(i)] ?? NaN, 4))]] : [])],
  });
  return {data, layout, caption, numbers};
});
