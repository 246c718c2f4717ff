// History: what is kept is only where something changed; here it is spread out again.
const past = read("history");
if (past) {
  const CONTROLS = ["case", "model", "variant", "what", "mode", "along"].map((one) => `history-${one}`);
  const DASHES = ["solid", "dash", "dot", "dashdot", "longdash"];
  const ALL = "all";
  const TIMES = ["solve", "build", "relative"];
  const value = (one) => $(`history-${one}`).value;
  const spread = ([length, ...pairs]) => {
    const result = new Array(length);
    for (let k = 0; k < pairs.length; k += 2) result.fill(pairs[k + 1], pairs[k]);
    return result;
  };
  const ABOUT = ["command", "commit", "release", "machine", "python", "numpy", "scipy", "blas"];
  const runs = Object.fromEntries(Object.entries(past.runs).map(([name, list]) =>
    [name, name === "run" || name === "time" ? list : spread(list)]));
  const label = () => value("model");
  const ofCase = () => past.series.filter((one) => one.case === value("case"));
  const ofModel = () => ofCase().filter((one) => one.model === label());
  const inOrder = (list) => [...new Set(list)].sort((a, b) => a.localeCompare(b, "en", {numeric: true}));
  const chosen = () => ofModel().filter((one) => value("variant") === ALL || one.variant === value("variant"));
  const short = (text) => text.length > 70 ? `${text.slice(0, 69)}…` : text;
  const words = (variant) => variant || "as usual";
  const placed = (one) => spread(one.at).map((gap, k) => gap + k);

  // A case may lack a model; a model has its own variants and number of modes.
  const refill = () => {
    select("history-model", inOrder(ofCase().map((one) => one.model)).map((one) => [one, one]));
    const variants = ofModel().sort((a, b) => Boolean(a.variant) - Boolean(b.variant)
      || placed(b).at(-1) - placed(a).at(-1) || a.variant.localeCompare(b.variant, "en", {numeric: true}));
    const all = variants.length > 1 ? [[ALL, `all ${variants.length}, to compare`]] : [];
    select("history-variant", [...variants.map(({variant}) => [variant, words(variant)]), ...all]);
    $("history-variant").disabled = variants.length === 1;
    const modes = [...new Set(chosen().flatMap((one) => Object.keys(one.f)))].sort((a, b) => a - b);
    const every = value("variant") === ALL ? [] : [[ALL, "all"]];
    select("history-mode", [...every, ...modes.map((one) => [one, `f${one}`])]);
    $("history-mode").disabled = TIMES.includes(value("what"));
  };
  for (const id of CONTROLS) $(id).addEventListener("input", refill);
  // First what most runs have: there is most to see.
  const most = past.series.reduce((a, b) => b.at[0] > a.at[0] ? b : a);
  for (const [one, first] of [["case", most.case], ["model", most.model]]) {
    refill();
    $(`history-${one}`).value = first;
  }
  refill();

  const record = (one, place, run, settings) => ({parts: [], fields: {
    Case: one.case, Pose: `z = ${+(1000 * one.pose[0]).toFixed(6)} mm, azimuth ${+(one.pose[1] * 180 / Math.PI).toFixed(6)}°, tilt ${+(one.pose[2] * 180 / Math.PI).toFixed(6)}°`,
    Mechanism: one.mechanism, Model: one.model, Theory: one.theories[place], Version: one.versions[place],
    ...(settings ? {Settings: settings} : {}),
    "Given by": `${runs.time[run]} UTC, run ${runs.run[run]}`,
    ...Object.fromEntries(ABOUT.slice(1).map((name) => [name[0].toUpperCase() + name.slice(1), runs[name][run]])),
    Command: runs.command[run]}});

  chart("history-chart", CONTROLS, () => {
    const what = value("what"), time = TIMES.includes(what);
    const even = value("along") === "run";
    const found = chosen().map((one) => ({...one, runs: placed(one),
      versions: spread(one.version), theories: spread(one.theory), options: spread(one.settings)}));
    const along = (run) => even ? run + 1 : runs.time[run];
    const shown = $("history-what").selectedOptions[0].text;
    const unit = {change: "ppm", frequency: "Hz", relative: "yardsticks"}[what] ?? "ms";
    const data = [], rows = [];
    let largest = 0;
    found.forEach((one, way) => {
      const modes = time ? [0] : value("mode") === ALL ? Object.keys(one.f).map(Number) : [Number(value("mode"))];
      for (const mode of modes) {
        if (!time && !one.f[mode]) continue;
        const kind = found.length > 1 ? way + 1 : mode || 1;
        const yard = (ms, k) => past.yardstick[one.runs[k]] && ms !== null ? +(ms / past.yardstick[one.runs[k]]).toPrecision(3) : null;
        const raw = what === "relative" ? one.solve.map(yard) : time ? one[what] : spread(one.f[mode]);
        const last = raw.findLast((v) => v !== null);
        const y = what === "change" ? raw.map((v) => v === null ? null : 1e6 * (v / last - 1)) : raw;
        if (what === "change") largest = Math.max(largest, ...y.map(Math.abs));
        const title = `${time ? shown : `f${mode}`} of ${one.model}, ${one.case}${one.variant && `, ${one.variant}`}`;
        const cells = y.map((v, k) => v === null ? "" : cell(
          what === "change" ? signed(v, 4) : String(v),
          time ? `${v} ${unit}` : `${raw[k]} Hz`, title, record(one, k, one.runs[k], one.options[k])));
        data.push({
          name: found.length > 1 ? short(words(one.variant)) : time ? shown : `f<sub>${mode}</sub>`, x: one.runs.map(along), y,
          mode: y.length > 60 ? "lines" : "lines+markers", line: {color: colour(kind), width: 1.4, shape: "hv", dash: DASHES[Math.floor((kind - 1) / 6) % DASHES.length]},
          marker: {symbol: symbol(kind), size: kind % 2 ? 8 : 6, color: colour(kind)},
          customdata: cells, hovertemplate: "%{x}: %{y}<extra></extra>",
        });
        cells.forEach((c, k) => rows.push([one.runs[k], title, c]));
      }
    });
    const marks = [];
    for (const one of found) one.runs.forEach((run, k) => {
      if (!k) return;
      const news = [];
      if (one.versions[k] !== one.versions[k - 1]) news.push(one.versions[k]);
      if (runs.release[run] !== runs.release[one.runs[k - 1]]) news.push(`rps-bench ${runs.release[run]}`);
      if (news.length) marks.push([along(run), news.join(", ")]);
    });
    const layout = {
      xaxis: {title: {text: even ? "run" : "time (UTC)"}, type: even ? "linear" : "date"},
      yaxis: {title: {text: `${shown} [${unit}]`}, rangemode: time ? "tozero" : "normal",
        ...(what === "change" && largest < 1e-6 ? {range: [-1, 1]} : {})},
      shapes: marks.map(([x]) => ({type: "line", x0: x, x1: x, yref: "paper", y0: 0, y1: 1,
        line: {color: css("--muted"), width: 1, dash: "dot"}})),
      annotations: marks.map(([x, text]) => ({x, y: 1, yref: "paper", yanchor: "top", xanchor: "left",
        text, showarrow: false, textangle: 90, font: {size: 11, color: css("--muted")}})),
    };
    const count = new Set(found.flatMap((one) => one.runs)).size;
    if (count === 1) layout.xaxis.type = "category";
    const same = what === "change" && count > 1 && largest === 0 ? " No run differs from the newest." : "";
    const since = what === "change" ? " from its newest value" : "";
    const way = value("variant") && `, ${$("history-variant").selectedOptions[0].text}`;
    const which = !time && value("mode") !== ALL ? ` of f${value("mode")}` : "";
    return {data, layout,
      caption: `${shown[0].toUpperCase()}${shown.slice(1)}${which}${since}: ${label()}, ${value("case")}${way}, ` +
        `${count} ${count === 1 ? "run" : "runs"}.${same}`,
      numbers: () => ({head: ["Run (UTC)", "What", `[${unit}]`],
        rows: rows.sort((a, b) => b[0] - a[0]).slice(0, 300).map(([run, ...rest]) => [`${runs.time[run]}`, ...rest])}),
    };
  });

  // A series that moved is a click away.
  for (const card of document.querySelectorAll("#history-cards button")) card.addEventListener("click", () => {
    const one = past.series[card.dataset.series];
    for (const [control, chosen] of [["case", one.case], ["model", one.model],
      ["variant", one.variant], ["what", "change"], ["mode", ALL]]) {
      refill();
      $(`history-${control}`).value = chosen;
    }
    $("history-case").dispatchEvent(new Event("input"));
    $("history-chart").scrollIntoView({block: "center"});
  });
}
