// The workspace: one layer at a time, flat and as a surface.
const workspace = read("workspace");
if (workspace) {
  const CONTROLS = ["set", "run", "model", "mode", "layer", "show", "other", "since"].map((one) => `ws-${one}`);
  const value = (one) => $(`ws-${one}`).value;
  const chosen = () => workspace.find((one) => one.name === value("set"));
  // Another model's map at the same poses may be of another run: the newest that has it.
  const modelOf = (set, run, model) =>
    run.models[model] ?? set.runs.find((one) => one.models[model]).models[model];
  const numbered = (list) => list.map((one, k) => [k, one.name]);

  // What can be chosen depends on the poses, the run and the model.
  const refill = () => {
    const set = chosen();
    select("ws-run", numbered(set.runs));
    const run = set.runs[value("run")];
    const models = Object.keys(run.models);
    const everyModel = [...new Set(set.runs.flatMap((one) => Object.keys(one.models)))];
    select("ws-model", models.map((one) => [one, one]));
    const grids = set.values[run.models[value("model")].values];
    select("ws-mode", grids.map((_, k) => [k, `f${k + 1}`]));
    const heights = [...new Set(set.poses.map((pose) => pose[0]))].sort((a, b) => a - b);
    select("ws-layer", heights.map((z) => [z, `${+z.toFixed(3)} mm`]));
    const others = everyModel.filter((one) => one !== value("model"));
    select("ws-other", others.map((one) => [one, one]));
    // This run's map is held against every recorded one.
    const own = Number(value("run"));
    const earlier = numbered(set.runs).filter(([k, name]) => set.runs[k].models[value("model")]
      && (k > own || (k < own && name === "this run")));
    select("ws-since", earlier);
    const can = {against: others.length > 0, since: earlier.length > 0};
    for (const option of $("ws-show").options) option.disabled = can[option.value] === false;
    if (can[value("show")] === false) $("ws-show").value = "frequency";
    $("ws-other").disabled = value("show") !== "against";
    $("ws-since").disabled = value("show") !== "since";
    $("ws-note").textContent = set.note;
  };

  const layer = () => {
    const set = chosen();
    const run = set.runs[value("run")];
    const model = run.models[value("model")];
    const show = value("show");
    const than = show === "against" ? modelOf(set, run, value("other"))
      : show === "since" ? set.runs[value("since")].models[value("model")] : null;
    const grid = (one) => one && set.values[one.values][value("mode")];
    const [ours, theirs] = [grid(model), grid(than)];
    const here = range(0, set.poses.length - 1).filter((k) => set.poses[k][0] === Number(value("layer")));
    let points = here.map((k) => ({pose: set.poses[k], f: ours[k],
      v: show === "frequency" ? ours[k] : theirs?.[k] ? 100 * (ours[k] / theirs[k] - 1) : null}))
      .filter((one) => one.v !== null && one.f !== null);
    const largest = Math.max(0, ...points.map((one) => Math.abs(one.v)));
    const small = show !== "frequency" && largest < 0.01;
    if (small) points = points.map((one) => ({...one, v: 1e4 * one.v}));
    const unit = show === "frequency" ? "Hz" : small ? "ppm" : "%";
    const what = `f${Number(value("mode")) + 1} of ${value("model")}`;
    const compared = show === "against" ? `, error against ${value("other")} [${unit}]`
      : show === "since" ? `, change since ${$("ws-since").selectedOptions[0].text} [${unit}]` : " [Hz]";
    const told = show !== "frequency" && !theirs ? ` The other has no f${Number(value("mode")) + 1}.` :
      show === "since" ? (largest ? ` ${points.filter((one) => one.v).length} of ${points.length} poses differ.` : " No pose differs.") : "";
    const cells = points.map(({pose, f, v}) => cell(
      show === "frequency" ? v.toFixed(3) : signed(v, 4),
      show === "frequency" ? `${f} Hz` : `${signed(v, 6)} ${unit} (${f} Hz)`,
      `${what} at azimuth ${+pose[1].toFixed(2)}°, tilt ${+pose[2].toFixed(2)}°`,
      than ? {fields: {"Made as": "100 (f / f of the other − 1), mode by mode in order"},
        parts: [model.record, than.record]} : model.record));
    const extent = Math.max(1e-9, ...points.map((one) => Math.abs(one.v)));
    const scale = show === "frequency" ? {colorscale: "Viridis"}
      : {colorscale: DIVERGING(), cmin: -extent, cmax: extent};
    const hover = points.map(({pose, v}) =>
      `azimuth ${+pose[1].toFixed(2)}°, tilt ${+pose[2].toFixed(2)}°<br>${v.toPrecision(6)} ${unit}`);
    const caption = `${what}${compared} at z = ${+Number(value("layer")).toFixed(3)} mm, ` +
      `${$("ws-run").selectedOptions[0].text}.`;
    return {points, unit, cells, scale, hover, caption, told, compared};
  };
  const DIVERGING = () => [[0, "#2166ac"], [0.5, css("--rule")], [1, "#d6604d"]];
  const small = (text) => ({title: {text, font: {size: 11}}, tickfont: {size: 10}, nticks: 5});
  const bar = (unit) => ({title: {text: unit, side: "top"}, thickness: 12, len: 0.85, outlinewidth: 0,
    tickfont: {color: css("--muted")}});

  // Before the charts: their own listeners come after these.
  for (const id of CONTROLS) $(id).addEventListener("input", refill);
  refill();
  // Values of a layer on a grid of x and y, linear between its rings and rays; null where it has none.
  const CELLS = 160;
  const ringed = (points) => {
    const turns = [...new Set(points.filter((one) => one.pose[2] > 0).map((one) => one.pose[1]))].sort((a, b) => a - b);
    const tilts = [...new Set(points.map((one) => one.pose[2]))].sort((a, b) => a - b);
    const known = new Map(points.map((one) => [`${one.pose[1]} ${one.pose[2]}`, one.v]));
    const rings = tilts.map((t) => turns.map((a) => known.get(`${t ? a : 0} ${t}`)));
    return turns.length > 2 && rings.every((ring) => ring.every((v) => v !== undefined)) ? {turns, tilts, rings} : null;
  };
  const flat = ({turns, tilts, rings}) => {
    const rim = tilts.at(-1), axis = range(0, CELLS).map((k) => rim * (2 * k / CELLS - 1) * 1.02);
    const between = (ring, turn) => {
      let k = turns.findLastIndex((a) => a <= turn);
      if (k < 0) k = turns.length - 1;
      const from = turns[k], next = (k + 1) % turns.length;
      const gap = (turns[next] - from + 360) % 360 || 360;
      const part = ((turn - from + 360) % 360) / gap;
      return ring[k] * (1 - part) + ring[next] * part;
    };
    const z = axis.map((y) => axis.map((x) => {
      const tilt = Math.min(Math.hypot(x, y), rim), turn = (Math.atan2(y, x) * 180 / Math.PI + 360) % 360;
      if (Math.hypot(x, y) > 1.03 * rim || tilt < tilts[0]) return null;
      const k = Math.min(tilts.findLastIndex((t) => t <= tilt), tilts.length - 2);
      if (k < 0) return between(rings[0], turn);
      const part = (tilt - tilts[k]) / (tilts[k + 1] - tilts[k]);
      return between(rings[k], turn) * (1 - part) + between(rings[k + 1], turn) * part;
    }));
    return {x: axis, y: axis, z};
  };
  const circle = (radius) => range(0, 120).map((k) => [radius * Math.cos(k * Math.PI / 60), radius * Math.sin(k * Math.PI / 60)]);
  const path = (corners) => `M${corners.map(([x, y]) => `${x},${y}`).join("L")}Z`;
  chart("ws-map", CONTROLS, () => {
    const {points, unit, cells, scale, hover, caption, told} = layer();
    const turn = (one) => one.pose[1] * Math.PI / 180;
    const x = points.map((one) => one.pose[2] * Math.cos(turn(one)));
    const y = points.map((one) => one.pose[2] * Math.sin(turn(one)));
    const rim = Math.max(1e-9, ...points.map((one) => one.pose[2]));
    const grid = ringed(points);
    const {cmin, cmax, colorscale} = scale;
    const poses = {type: "scatter", mode: "markers", x, y, customdata: cells, text: hover,
      hovertemplate: "%{text}<extra></extra>",
      marker: grid ? {size: 9, opacity: 0, color: points.map((one) => one.v)}
        : {size: 9, color: points.map((one) => one.v), ...scale, showscale: true, colorbar: bar(unit)}};
    const contours = grid && {type: "contour", ...flat(grid), colorscale, zmin: cmin, zmax: cmax, zauto: cmin === undefined,
      ncontours: 12, hoverinfo: "skip", colorbar: bar(unit), connectgaps: false,
      contours: {coloring: "fill", showlabels: false}, line: {width: 0.8, color: "rgba(255,255,255,.75)"}};
    const far = 1.12 * rim, box = [[-far, -far], [far, -far], [far, far], [-far, far]];
    const axis = {range: [-far, far], zeroline: false, showgrid: !grid, nticks: 5};
    return {
      data: [...(grid ? [contours] : []), poses],
      layout: {showlegend: false, margin: {l: 52, r: 8, t: 8, b: 48},
        xaxis: {...axis, title: {text: "tilt · cos azimuth [°]"}},
        yaxis: {...axis, title: {text: "tilt · sin azimuth [°]"}, scaleanchor: "x", constrain: "domain"},
        // What lies between the rim and the corners of the grid is no part of the map.
        shapes: grid ? [{type: "path", path: path(box) + path(circle(rim)), fillrule: "evenodd", layer: "above",
          fillcolor: css("--paper"), line: {width: 0}},
        {type: "path", path: path(circle(rim)), line: {width: 1, color: css("--muted")}}] : []},
      caption: `${caption} Tilt to ${+rim.toFixed(1)}°.${told}`,
      numbers: () => ({head: ["azimuth, tilt", unit],
        rows: points.map((one, k) => [`${+one.pose[1].toFixed(2)}°, ${+one.pose[2].toFixed(2)}°`, cells[k]])}),
    };
  });
  chart("ws-surface", CONTROLS, () => {
    const {points, unit, cells, scale, hover, caption} = layer();
    const turn = (one) => one.pose[1] * Math.PI / 180;
    const x = points.map((one) => one.pose[2] * Math.cos(turn(one)));
    const y = points.map((one) => one.pose[2] * Math.sin(turn(one)));
    const z = points.map((one) => one.v);
    const {cmin, cmax, colorscale} = scale;
    return {
      three: true,
      data: [
        {type: "mesh3d", x, y, z, intensity: z, delaunayaxis: "z", colorscale, cmin, cmax, showscale: false,
          hoverinfo: "skip", flatshading: false, lighting: {ambient: 0.75, diffuse: 0.5, specular: 0.05}},
        {type: "scatter3d", mode: "markers", x, y, z, text: hover, customdata: cells,
          hovertemplate: "%{text}<extra></extra>", marker: {size: points.length > 200 ? 1.5 : 3, color: css("--ink"), opacity: 0.35}},
      ],
      layout: {margin: {l: 0, r: 0, t: 0, b: 0}, showlegend: false, uirevision: "stay",
        scene: {aspectmode: "manual", aspectratio: {x: 1, y: 1, z: 0.7}, dragmode: "turntable",
          camera: {eye: {x: 1.4, y: -1.4, z: 0.8}},
          xaxis: small("tilt · cos azimuth [°]"), yaxis: small("tilt · sin azimuth [°]"), zaxis: small(unit)}},
      caption: `The same as a surface: ${caption}`,
    };
  });
}
