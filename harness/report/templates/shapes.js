// Mode shapes: limbs as tubes and the platform as a disc, moved by a cosine.
const shapes = read("shapes");
if (shapes) {
  const RING = range(0, 23).map((k) => k * Math.PI / 12);
  const add = (a, b, scale = 1) => a.map((v, k) => v + scale * b[k]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const n = Math.hypot(...a); return a.map((v) => v / n); };
  const view = {turn: -60, height: 16, far: innerWidth < 640 ? 1.8 : 1.25};
  const now = () => {
    const here = shapes[$("shape-case").value];
    return {here, model: here.models[$("shape-model").value], mode: Number($("shape-mode").value) - 1};
  };

  // A tube round the points of a line, as triangles.
  const tube = (line, radius) => {
    const along = unit(add(line.at(-1), line[0], -1));
    const side = unit(cross(along, Math.abs(along[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
    const up = cross(along, side);
    const points = line.flatMap((p) => RING.map((t) => add(add(p, side, radius * Math.cos(t)), up, radius * Math.sin(t))));
    const n = RING.length, faces = [];
    for (let row = 0; row + 1 < line.length; row++) for (let k = 0; k < n; k++) {
      const [a, b] = [row * n + k, row * n + (k + 1) % n];
      faces.push([a, b, a + n], [b, b + n, a + n]);
    }
    return {points, faces};
  };
  const disc = (centre, arms) => ({points: [centre, ...arms.map((arm) => add(centre, arm))],
    faces: arms.map((_, k) => [0, 1 + k, 1 + (k + 1) % arms.length])});
  // The limbs' lines as moved; a point of one at a fraction of its length.
  const moved = (amount) => {
    const {here, model, mode} = now();
    return here.starts.map((start, i) => model.limbs[mode][i].map((shift, k, all) =>
      add(add(start, add(here.tips[i], start, -1), k / (all.length - 1)), shift, amount)));
  };
  const along = (line, t) => {
    const at = Math.min(Math.floor(t * (line.length - 1)), line.length - 2);
    return add(line[at], add(line[at + 1], line[at], -1), t * (line.length - 1) - at);
  };
  const SYMBOLS = {R: "circle-open", U: "cross", S: "circle", P: "square", fixed: "diamond", body: "diamond-open"};
  const marks = (amount) => {
    const {here} = now(), lines = moved(amount);
    return here.marks.map((one) => add(along(lines[one.limb], one.place), one.beside));
  };
  const bodies = (amount, thick = 1) => {
    const {here, model, mode} = now();
    const [move, spin] = [model.platform[mode].slice(0, 3), model.platform[mode].slice(3)];
    const arms = range(0, 47).map((k) => k * Math.PI / 24).map((t) =>
      here.axes[0].map((v, c) => here.radius * (v * Math.cos(t) + here.axes[1][c] * Math.sin(t))));
    const lines = moved(amount);
    const limbs = here.spans.map(([i, begin, end, radius]) => tube([begin, ...range(0, 10).map((k) => k / 10)
      .filter((t) => begin < t && t < end), end].map((t) => along(lines[i], t)), thick * radius));
    return [...limbs, disc(add(here.centre, move, amount), arms.map((arm) => add(arm, cross(spin, arm), amount)))];
  };
  const points = (found) => ({x: found.map((p) => p[0]), y: found.map((p) => p[1]), z: found.map((p) => p[2])});
  const mesh = ({points, faces}, color, opacity) => ({
    type: "mesh3d", x: points.map((p) => p[0]), y: points.map((p) => p[1]), z: points.map((p) => p[2]),
    i: faces.map((f) => f[0]), j: faces.map((f) => f[1]), k: faces.map((f) => f[2]),
    color, opacity, hoverinfo: "skip", flatshading: false,
    lighting: {ambient: 0.65, diffuse: 0.55, specular: 0.1, roughness: 0.9, vertexnormalsepsilon: 0, facenormalsepsilon: 0},
    lightposition: {x: 2e4, y: -6e4, z: 5e4},
  });
  const camera = () => {
    const [a, h] = [view.turn * Math.PI / 180, view.height * Math.PI / 180];
    return {eye: {x: view.far * Math.cos(h) * Math.cos(a), y: view.far * Math.cos(h) * Math.sin(a), z: view.far * Math.sin(h)},
      center: {x: 0, y: 0, z: -0.08}, up: {x: 0, y: 0, z: 1}};
  };

  // A case may lack a model.
  const refill = () => select("shape-model", Object.keys(shapes[$("shape-case").value].models).map((one) => [one, one]));
  $("shape-case").addEventListener("input", refill);
  refill();
  chart("shape-chart", ["shape-case", "shape-model", "shape-mode"], () => {
    const {here, model, mode} = now();
    const name = $("shape-case").value, label = $("shape-model").value;
    const {ground} = here, all = [...ground, ...here.starts, ...here.tips];
    const reach = 1.25 * Math.max(...all.flatMap((p) => [Math.abs(p[0]), Math.abs(p[1])]));
    const low = Math.min(0, ...all.map((p) => p[2])), high = Math.max(0, ...all.map((p) => p[2]), here.centre[2]);
    const [bottom, top] = [low - 0.05 - 0.35 * Math.max(0, -here.centre[2]), 1.02 * (high + 0.35 * Math.max(0, here.centre[2]))];
    const hidden = {visible: false, showbackground: false};
    const data = [
      ...bodies(0, 0.97).map((body) => mesh(body, css("--faint"), 0.16)),
      ...bodies(1).map((body, k) => mesh(body, css(k < here.spans.length ? "--m1" : "--m2"), k < here.spans.length ? 1 : 0.85)),
      {type: "scatter3d", mode: "lines", x: ground.map((p) => p[0]), y: ground.map((p) => p[1]),
        z: ground.map((p) => p[2]), line: {color: css("--muted"), width: 3}, hoverinfo: "skip"},
      ...(here.marks.length ? [{type: "scatter3d", mode: "markers", ...points(marks(1)), hoverinfo: "text",
        text: here.marks.map((one) => one.kind), marker: {size: 4, color: css("--muted"),
          symbol: here.marks.map((one) => SYMBOLS[one.kind] || "diamond")}}] : []),
    ];
    const number = (m) => cell(model.f[m].toFixed(3), `${model.f[m]} Hz`, `f${m + 1} of ${label}, ${name}`, model.record);
    return {
      three: true, data,
      layout: {margin: {l: 0, r: 0, t: 0, b: 0}, showlegend: false, scene: {
        camera: camera(), dragmode: "turntable", aspectmode: "manual",
        aspectratio: {x: 1, y: 1, z: (top - bottom) / (2 * reach)},
        xaxis: {...hidden, range: [-reach, reach]}, yaxis: {...hidden, range: [-reach, reach]},
        zaxis: {...hidden, range: [bottom, top]}}},
      caption: `Mode ${mode + 1} of ${label} at ${name}: ${model.f[mode].toFixed(3)} Hz.`,
      numbers: () => ({head: ["Mode", "f [Hz]"], rows: model.f.map((_, m) => [m + 1, number(m)])}),
    };
  });

  const place = $("shape-chart");
  const pose = (amount) => {
    const shown = bodies(amount).map((body) => body.points), n = shown.length, where = shown.map((_, k) => k + n);
    if (now().here.marks.length) { shown.push(marks(amount)); where.push(2 * n + 1); }
    const axis = (c) => shown.map((points) => points.map((p) => p[c]));
    return Plotly.restyle(place, {x: axis(0), y: axis(1), z: axis(2)}, where);
  };
  let playing = false, busy = false;
  const frame = (time) => {
    if (!playing) return;
    if (!busy && charts.get("shape-chart").listening) {
      busy = true;
      // A slow machine must find time for a click between two pictures.
      pose(Math.cos(2 * Math.PI * time / 1600)).then(() => setTimeout(() => { busy = false; }, 15));
    }
    requestAnimationFrame(frame);
  };
  $("shape-play").addEventListener("click", () => {
    if (!webgl) return;
    draw("shape-chart");
    playing = !playing;
    $("shape-play").textContent = playing ? "❚❚ Pause" : "▶ Play";
    $("shape-play").setAttribute("aria-pressed", playing);
    if (playing) requestAnimationFrame(frame);
    else pose(1);
  });
  for (const button of document.querySelectorAll("[data-turn], [data-zoom]")) button.addEventListener("click", () => {
    if (!webgl) return;
    draw("shape-chart");
    const eye = place._fullLayout.scene.camera.eye; // wherever the mouse has turned it
    view.far = Math.hypot(eye.x, eye.y, eye.z);
    view.turn = Math.atan2(eye.y, eye.x) * 180 / Math.PI;
    view.height = Math.asin(eye.z / view.far) * 180 / Math.PI;
    const [left, up] = (button.dataset.turn ?? "0,0").split(",").map(Number);
    view.turn += left;
    view.height = Math.max(-80, Math.min(85, view.height + up));
    view.far *= Number(button.dataset.zoom ?? 1);
    Plotly.relayout(place, {"scene.camera": camera()});
  });
}
