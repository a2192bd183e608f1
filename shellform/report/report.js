// SPDX-License-Identifier: LGPL-3.0-or-later
// Draws a report from its data: curves, the walk, the skin. Nothing is loaded from anywhere.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const el = (id) => document.getElementById(id);
  const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];
  const DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
  const SKIN = "#cdbfb4", CLOTH = "#7f9cbb", BARE = "#e4e7ea", NONE = 255, STEPS = 254;
  // light to dark, so also right in grey: ColorBrewer's YlOrRd and YlGnBu
  const HEAT = ["#ffffb2", "#fed976", "#feb24c", "#fd8d3c", "#fc4e2a", "#e31a1c", "#800026"];
  const SEA = ["#ffffd9", "#c7e9b4", "#7fcdbb", "#41b6c4", "#1d91c0", "#225ea8", "#081d58"];
  const WIDE = 0.8; // of the floor that is shown, to each side [m]
  const ARRAYS = { int16: Int16Array, int32: Int32Array, uint8: Uint8Array, float32: Float32Array };
  // named buttons alone: the library's own choice has one that sends the figure to its makers
  const QUIET = { displaylogo: false, responsive: true, displayModeBar: innerWidth > 700 ? "hover" : false, showSendToCloud: false, plotlyServerURL: "" };
  const CONFIG = { ...QUIET, scrollZoom: true,
    modeBarButtons: [["toImage", "zoom3d", "pan3d", "tableRotation", "resetCameraDefault3d"]] };
  const FLAT = { ...QUIET, scrollZoom: false,
    modeBarButtons: [["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]] };
  const names = { pressure: "pressure [Pa]", stretch: "stretch [%]", wrinkles: "strain of wrinkles [%]" };

  function unpacked(entry) {
    const text = atob(entry.base64), bytes = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
    const values = new ARRAYS[entry.type](bytes.buffer);
    values.row = entry.shape.slice(1).reduce((a, b) => a * b, 1);
    return values;
  }
  const whole = (values) => { values.row = values.length; return values; };
  const row = (values, k) => values.subarray(k * values.row, (k + 1) * values.row);

  // ---- which runs and which joint -------------------------------------------------------------
  const state = { joint: data.joints[0][0], frame: 0, playing: false, shown: data.runs.map(() => true) };
  const shownRuns = () => data.runs.map((_, k) => k).filter((k) => state.shown[k]);

  function makeControls() {
    data.joints.forEach(([name, words]) => el("joint").add(new Option(words, name)));
    const knee = data.joints.find(([name]) => name === "right_knee");
    if (knee) state.joint = el("joint").value = knee[0];
    el("joint").addEventListener("change", () => { state.joint = el("joint").value; drawCurves(); });
    data.runs.forEach((run, k) => {
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: true });
      box.id = `run_${k}`;
      const swatch = document.createElement("span");
      swatch.className = "swatch";
      swatch.style.borderTopColor = COLOURS[k % 6];
      swatch.style.borderTopStyle = ["solid", "dashed", "dotted"][k % 3];
      const label = document.createElement("label");
      label.append(box, swatch, run.label);
      box.addEventListener("change", () => { state.shown[k] = box.checked; drawAll(); });
      el("shown").append(label);
    });
  }

  // ---- torque ---------------------------------------------------------------------------------
  function tinted(colour, alpha) {
    const part = (at) => parseInt(colour.slice(at, at + 2), 16);
    return `rgba(${part(1)},${part(3)},${part(5)},${alpha})`;
  }

  function ribbon(x, y, reach, colour, alpha, group) {
    const up = y.map((v, k) => v + reach[k]), down = y.map((v, k) => v - reach[k]).reverse();
    return { x: x.concat([...x].reverse()), y: up.concat(down), fill: "toself", mode: "lines",
      line: { width: 0 }, fillcolor: tinted(colour, alpha), hoverinfo: "skip", showlegend: false,
      legendgroup: group };
  }

  function withBand(traces, x, y, error, spread, k, name) {
    const colour = COLOURS[k % 6], group = `run${k}`;
    if (spread && spread[0] !== null) traces.push(ribbon(x, y, spread, colour, 0.15, group));
    if (error && error[0] !== null) traces.push(ribbon(x, y, error, colour, 0.35, group));
    const several = error && error[0] !== null;
    traces.push({ x, y, mode: "lines", name, legendgroup: group, line: { color: colour, width: 1.8,
      dash: DASHES[k % 6] }, customdata: several ? error : undefined,
      hovertemplate: several ? "%{y:.3f} ± %{customdata:.3f} N m" : "%{y:.3f} N m" });
  }

  const layoutOf = (title, x) => ({ margin: { l: 58, r: 12, t: 64, b: 44 }, hovermode: "x unified",
    title: { text: title, font: { size: 14 }, x: 0, xref: "paper", y: 1, yref: "container", yanchor: "top",
      pad: { t: 8 } }, uirevision: title,
    xaxis: { title: { text: x }, zeroline: false, gridcolor: "#eceff2" },
    yaxis: { title: { text: "torque [N m], flexion positive" }, zerolinecolor: "#8a949e", gridcolor: "#eceff2" },
    legend: { orientation: "h", x: 0, xanchor: "left", y: 1.01, yanchor: "bottom" },
    font: { family: "system-ui, Liberation Sans, Arial, sans-serif", size: 12, color: "#1d2329" } });

  function timeMark() {
    const t = present();
    return t === null ? [] : [{ type: "line", x0: t, x1: t, yref: "paper", y0: 0, y1: 1,
      line: { color: "#55606b", width: 1, dash: "dot" } }];
  }

  function drawCurves() {
    const words = data.joints.find(([name]) => name === state.joint)[1];
    const time = [], phase = [];
    for (const k of shownRuns()) {
      const run = data.runs[k], own = run.joints[state.joint];
      if (!own) continue;
      withBand(time, own.time, own.torque, own.error, own.spread, k, run.label);
      own.strides.forEach((stride, n) => phase.push({ x: own.percent, y: stride, mode: "lines",
        name: `${run.label}, ${own.names[n]}`, legendgroup: `run${k}`, showlegend: false,
        line: { color: tinted(COLOURS[k % 6], own.mean ? 0.45 : 0.9), width: 1 + 0.5 * (n % 3), dash: DASHES[k % 6] },
        ...(own.mean ? { hoverinfo: "skip" } : { hovertemplate: "%{y:.3f} N m" }) }));
      if (!own.mean && own.strides.length) {
        phase.push({ x: [null], y: [null], mode: "lines", name: `${run.label}, single strides`,
          legendgroup: `run${k}`, line: { color: COLOURS[k % 6], dash: DASHES[k % 6] } });
      }
      if (own.mean) {
        withBand(phase, own.percent, own.mean, own.mean_error, own.mean_spread, k, run.label);
      }
    }
    const over = layoutOf(`${words}, against time`, "time [s]");
    over.shapes = timeMark();
    Plotly.react("over_time", time, over, FLAT);
    const gait = layoutOf(`${words}, against the phase of gait`, "part of the stride [%]");
    if (!phase.length) {
      gait.annotations = [{ text: "no stride in this motion", showarrow: false, xref: "paper", yref: "paper",
        x: 0.5, y: 0.5 }];
    }
    Plotly.react("over_phase", phase, gait, FLAT);
  }

  // ---- surfaces in space ----------------------------------------------------------------------
  function sphere(parts) {
    const rows = parts / 2 + 1, points = [], corners = [];
    for (let i = 0; i < rows; i++) for (let j = 0; j < parts; j++) {
      const a = Math.PI * i / (rows - 1), b = 2 * Math.PI * j / parts;
      points.push([Math.cos(a), Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b)]);
    }
    for (let i = 0; i < rows - 1; i++) for (let j = 0; j < parts; j++) {
      const a = i * parts + j, b = i * parts + (j + 1) % parts;
      corners.push([a, a + parts, b + parts], [a, b + parts, b]);
    }
    return { points, corners };
  }

  function cornersOf(ball, count) {
    const all = [];
    for (let b = 0; b < count; b++) ball.corners.forEach((c) => all.push(...c.map((v) => v + b * ball.points.length)));
    return columns(all);
  }

  const BALL = sphere(20);
  const LIGHT = { ambient: 0.78, diffuse: 0.42, specular: 0.04, roughness: 0.9, fresnel: 0.05 };

  function scaleOf(colours, low, high, bare) {
    // below the low end: what has no value
    const from = bare ? 0.02 : 0, span = (high - low) / (1 - from);
    const stops = colours.map((c, k) => [from + (1 - from) * k / (colours.length - 1), c]);
    if (bare) stops.unshift([0, BARE], [from - 1e-6, BARE]);
    return { colorscale: stops, cmin: high - span, cmax: high };
  }

  function decades(low, high) {
    const tickvals = [], ticktext = [];
    for (let k = Math.ceil(low - 1e-9); k <= high; k++) {
      tickvals.push(k);
      ticktext.push(k < 0 ? (10 ** k).toFixed(-k) : String(10 ** k));
    }
    return { tickvals, ticktext };
  }

  const barOf = (text, more) => ({ orientation: "h", thickness: 12, len: 0.8, x: 0.5, y: -0.02, yanchor: "top",
    title: { text, side: "top", font: { size: 12 } }, tickfont: { size: 11 }, outlinewidth: 0, ...more });

  function valuesOf(steps, low, high, each) {
    const out = new Float32Array(steps.length * each);
    for (let k = 0; k < steps.length; k++) {
      const v = steps[k] === NONE ? low - 0.02 * (high - low) : low + (high - low) * steps[k] / STEPS;
      for (let m = 0; m < each; m++) out[k * each + m] = v;
    }
    return out;
  }

  function columns(triangles) {
    const n = triangles.length / 3, i = new Int32Array(n), j = new Int32Array(n), k = new Int32Array(n);
    for (let m = 0; m < n; m++) { i[m] = triangles[3 * m]; j[m] = triangles[3 * m + 1]; k[m] = triangles[3 * m + 2]; }
    return { i, j, k };
  }

  // one scene a run, side by side, three in a row; their cameras are kept alike
  const sceneName = (place) => place ? `scene${place + 1}` : "scene";

  function domainOf(place, count) {
    const wide = Math.min(count, 3), rows = Math.ceil(count / wide), at = Math.floor(place / wide);
    return { x: [(place % wide) / wide, (place % wide + 1) / wide], y: [1 - (at + 1) / rows, 1 - at / rows] };
  }

  function cameraOf(heading, turn, up, far) {
    const a = Math.atan2(heading[1], heading[0]) + turn * Math.PI / 180, e = up * Math.PI / 180;
    return { eye: { x: far * Math.cos(a) * Math.cos(e), y: far * Math.sin(a) * Math.cos(e), z: far * Math.sin(e) },
      center: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 0, z: 1 }, projection: { type: "orthographic" } };
  }

  function spaceOf(own, heading, wide, top, turn) {
    const axis = (low, high) => ({ visible: false, range: [low, high], autorange: false });
    const high = top + 0.1, scale = 1.85 / high;
    const layout = { margin: { l: 0, r: 0, t: 0, b: 54 }, showlegend: false, uirevision: "view", annotations: [],
      paper_bgcolor: "#f6f7f9", font: { family: "system-ui, Liberation Sans, Arial, sans-serif" } };
    own.forEach((k, place) => {
      const domain = domainOf(place, own.length);
      layout[sceneName(place)] = { xaxis: axis(-wide, wide), yaxis: axis(-wide, wide),
        zaxis: axis(-0.05, top + 0.05), aspectmode: "manual", domain,
        aspectratio: { x: 2 * wide * scale, y: 2 * wide * scale, z: 1.85 },
        camera: cameraOf(heading, turn, 8, 2), dragmode: "turntable", uirevision: "view" };
      layout.annotations.push({ text: data.runs[k].label, showarrow: false, xref: "paper", yref: "paper",
        x: domain.x[0], xanchor: "left", xshift: 10, y: domain.y[1], yanchor: "top", yshift: -6,
        font: { size: 14, color: COLOURS[k % 6] } });
    });
    return layout;
  }

  const turning = {};
  function turnAll(view, camera) {
    const scenes = Object.keys(el(view).layout).filter((name) => /^scene\d*$/.test(name));
    return Plotly.relayout(view, Object.fromEntries(scenes.map((name) => [`${name}.camera`, camera])));
  }
  function keepAlike(view) {
    for (const event of ["plotly_relayouting", "plotly_relayout"]) {
      el(view).on(event, (change) => {
        const turned = Object.keys(change).filter((name) => /^scene\d*\.camera$/.test(name));
        if (turned.length !== 1 || turning[view] || !el(view).layout.scene2) return;
        turning[view] = true;
        turnAll(view, change[turned[0]]).finally(() => { turning[view] = false; });
      });
    }
  }

  function addViews(heading) {
    const sides = [["front", 0, 5], ["right", -90, 5], ["back", 180, 5], ["left", 90, 5], ["above", -62, 60]];
    document.querySelectorAll(".views").forEach((group) => sides.forEach(([name, turn, up]) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      const view = group.dataset.of;
      button.addEventListener("click", () => turnAll(view, cameraOf(heading, turn, up, 2)));
      group.append(button);
    }));
  }

  // ---- the walk -------------------------------------------------------------------------------
  const walks = data.runs.map((run) => run.walk && prepared(run.walk));
  const leader = walks.findIndex((walk) => walk);
  const clockOf = () => leader < 0 ? null : walks[leader].times;
  const present = () => leader < 0 ? null : clockOf()[state.frame];
  const walkers = () => shownRuns().filter((k) => walks[k]);

  function prepared(walk) {
    const out = { ...walk, colours: {} };
    for (const name of ["places", "origins", "triangles", "centres", "axes"]) out[name] = unpacked(walk[name]);
    for (const name in walk.colours) out.colours[name] = unpacked(walk.colours[name]);
    out.corners = columns(out.triangles);
    if (walk.skin) out.skin = unpacked(walk.skin);
    out.bodyCorners = walk.skin ? columns(unpacked(walk.skin_triangles)) : cornersOf(BALL, walk.radii.length);
    return out;
  }

  function nearest(times, t) {
    let best = 0;
    times.forEach((time, k) => { if (Math.abs(time - t) < Math.abs(times[best] - t)) best = k; });
    return best;
  }

  function placesAt(places, step, f) {
    const at = row(places, f), n = at.length / 3;
    const x = new Float32Array(n), y = new Float32Array(n), z = new Float32Array(n);
    for (let k = 0; k < n; k++) {
      x[k] = at[3 * k] * step;
      y[k] = at[3 * k + 1] * step;
      z[k] = at[3 * k + 2] * step;
    }
    return { x, y, z };
  }

  function bodyAt(walk, f) {
    if (walk.skin) return placesAt(walk.skin, walk.step, f);
    const centres = row(walk.centres, f), axes = row(walk.axes, f), x = [], y = [], z = [];
    walk.radii.forEach((radii, b) => BALL.points.forEach((p) => {
      const place = [0, 1, 2].map((c) => centres[3 * b + c] + [0, 1, 2].reduce(
        (sum, a) => sum + p[a] * radii[a] * axes[9 * b + 3 * a + c], 0));
      x.push(place[0]); y.push(place[1]); z.push(place[2]);
    }));
    return { x, y, z };
  }

  function tintOf(walk, f, name) {
    const [low, high] = data.scales[name], percent = name === "pressure" ? 1 : 100;
    const steps = row(walk.colours[name], f), cells = name !== "pressure";
    return valuesOf(steps, low * percent, high * percent, cells ? walk.triangles_per_cell : 1);
  }

  function clothTrace(walk, name, first) {
    const trace = { type: "mesh3d", ...walk.corners, lighting: LIGHT, flatshading: false, hoverinfo: "skip" };
    if (!name || !walk.colours[name]) return { ...trace, color: CLOTH };
    const [low, high] = data.scales[name], pressure = name === "pressure", percent = pressure ? 1 : 100;
    const ends = scaleOf(pressure ? HEAT : SEA, low * percent, high * percent, pressure);
    const bar = barOf(names[name], pressure ? decades(low, high) : {});
    return { ...trace, ...ends, intensitymode: pressure ? "vertex" : "cell", showscale: first, colorbar: bar };
  }

  function floorAt(walk, f) {
    // lines half a metre apart that stay where they are while the view moves along
    const [ox, oy] = row(walk.origins, f), x = [], y = [], z = [];
    const lines = (o) => {
      const out = [];
      for (let v = Math.ceil((o - WIDE) / 0.5) * 0.5; v <= o + WIDE; v += 0.5) out.push(v - o);
      return out;
    };
    lines(ox).forEach((v) => { x.push(v, v, null); y.push(-WIDE, WIDE, null); z.push(0, 0, null); });
    lines(oy).forEach((v) => { x.push(-WIDE, WIDE, null); y.push(v, v, null); z.push(0, 0, null); });
    return { x, y, z };
  }

  function boxAt(walk, f) {
    // what the view does not reach is cut off, all of it shrinks to nothing
    const [ox, oy] = row(walk.origins, f), { corner, size } = walk.obstacle;
    const cut = (v) => Math.max(-WIDE, Math.min(WIDE, v));
    const [a, b] = [corner[0] - ox, corner[0] + size[0] - ox].map(cut);
    const [c, d] = [corner[1] - oy, corner[1] + size[1] - oy].map(cut);
    const high = b - a > 1e-6 ? size[2] : 0;
    return { x: [a, b, b, a, a, b, b, a], y: [c, c, d, d, c, c, d, d], z: [0, 0, 0, 0, high, high, high, high] };
  }
  const BOX = { i: [0, 0, 4, 4, 0, 0, 1, 1, 2, 2, 3, 3], j: [1, 2, 5, 6, 1, 5, 2, 6, 3, 7, 0, 4],
    k: [2, 3, 6, 7, 5, 4, 6, 5, 7, 6, 4, 7] };

  function walkParts() {
    // of each run's cloth, body, floor and obstacle what changes from frame to frame
    const name = el("colour").value, t = present();
    return walkers().flatMap((k) => {
      const walk = walks[k], f = k === leader ? state.frame : nearest(walk.times, t);
      const cloth = placesAt(walk.places, walk.step, f);
      if (walk.colours[name]) cloth.intensity = tintOf(walk, f, name);
      return [cloth, bodyAt(walk, f), floorAt(walk, f), ...(walk.obstacle ? [boxAt(walk, f)] : [])];
    });
  }

  function drawWalk() {
    if (leader < 0 || !webgl) return;
    const own = walkers(), name = el("colour").value, parts = walkParts(), traces = [];
    const quiet = { lighting: LIGHT, hoverinfo: "skip" };
    own.forEach((k, place) => {
      const walk = walks[k], scene = sceneName(place), add = (trace) => traces.push({ ...trace, scene, ...parts[traces.length] });
      add(clothTrace(walk, name, place === 0));
      add({ type: "mesh3d", ...walk.bodyCorners, color: SKIN, ...quiet });
      add({ type: "scatter3d", mode: "lines", line: { color: "#b9c1c9", width: 1.5 }, hoverinfo: "skip" });
      if (walk.obstacle) add({ type: "mesh3d", ...BOX, color: "#9aa5b0", flatshading: true, ...quiet });
    });
    Plotly.react("walk_view", traces, spaceOf(own, walks[leader].heading, WIDE, 1.5, -62), CONFIG);
  }

  let busy = false, again = false;
  function showFrame(f) {
    const times = clockOf();
    state.frame = Math.max(0, Math.min(times.length - 1, f));
    el("frame").value = state.frame;
    el("frame").setAttribute("aria-valuetext", `${present().toFixed(2)} seconds`);
    el("clock").textContent = `${present().toFixed(2)} s (${state.frame + 1} of ${times.length})`;
    if (busy) { again = true; return; }
    busy = true;
    const parts = walkParts(), change = {};
    for (const key of ["x", "y", "z", "intensity"]) change[key] = parts.map((p) => p[key]);
    if (!parts.some((p) => p.intensity)) delete change.intensity;
    const drawn = webgl && parts.length ? Plotly.restyle("walk_view", change, parts.map((_, k) => k)) : Promise.resolve();
    drawn.then(() => Plotly.relayout("over_time", { shapes: timeMark() })).finally(() => {
      busy = false;
      if (again) { again = false; showFrame(state.frame); }
    });
  }

  function play(on) {
    state.playing = on;
    el("play").textContent = on ? "Pause" : "Play";
    el("play").setAttribute("aria-pressed", on);
    if (!on) return;
    const times = clockOf(), end = times[times.length - 1];
    let t = present() >= end ? times[0] : present(), before = performance.now();
    const tick = (now) => {
      if (!state.playing) return;
      t += (now - before) / 1000 * Number(el("speed").value);
      before = now;
      if (t > end) t = times[0];
      const f = nearest(times, t);
      if (f !== state.frame && !busy) showFrame(f);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  function makeWalk() {
    if (leader < 0) return;
    const kinds = Object.keys(data.scales).filter((name) => walks.some((walk) => walk && walk.colours[name]));
    kinds.forEach((name) => el("colour").add(new Option(name, name)));
    el("colour").add(new Option("none", ""));
    el("colour").addEventListener("change", drawWalk);
    el("frame").max = clockOf().length - 1;
    el("frame").addEventListener("input", () => { play(false); showFrame(Number(el("frame").value)); });
    el("play").addEventListener("click", () => play(!state.playing));
    el("walk_view").addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (event.key === " ") play(!state.playing);
      else if (by) { play(false); showFrame(state.frame + by); }
      else return;
      event.preventDefault();
    });
    el("over_time").on("plotly_click", (event) => { play(false); showFrame(nearest(clockOf(), event.points[0].x)); });
  }

  // ---- the skin -------------------------------------------------------------------------------
  const skins = data.runs.map((run) => run.skin && { ...run.skin, places: whole(unpacked(run.skin.places)),
    corners: run.skin.triangles ? columns(unpacked(run.skin.triangles))
      : cornersOf(sphere(run.skin.parts), run.skin.ellipsoids),
    colours: Object.fromEntries(Object.entries(run.skin.colours).map(([kind, own]) => [kind, unpacked(own)])) });

  function drawSkin() {
    const own = shownRuns().filter((k) => skins[k]);
    if (!webgl || !skins.some((skin) => skin)) return;
    const [low, high] = data.skin_scale, kind = el("kind").value;
    const traces = own.map((k, place) => {
      const skin = skins[k], values = valuesOf(skin.colours[kind], low, high, 1);
      return { type: "mesh3d", scene: sceneName(place), ...placesAt(skin.places, skin.step, 0), ...skin.corners, intensity: values,
        ...scaleOf(HEAT, low, high, true), lighting: LIGHT, showscale: place === 0,
        colorbar: barOf(`${kind} pressure [Pa]`, decades(low, high)),
        customdata: Array.from(values, (v) => v < low ? "not touched" : `${Number((10 ** v).toPrecision(2))} Pa`),
        hovertemplate: `${data.runs[k].label}: %{customdata}<extra></extra>` };
    });
    Plotly.react("skin_view", traces, spaceOf(own, skins.find((skin) => skin).heading, 0.5, 1.5, -30), CONFIG);
  }

  // ---- all of it ------------------------------------------------------------------------------
  function drawAll() { drawCurves(); drawWalk(); drawSkin(); }
  function hasWebgl() {
    try { return Boolean(document.createElement("canvas").getContext("webgl")); } catch { return false; }
  }
  const webgl = hasWebgl();
  if (!webgl) document.body.classList.add("no-webgl");
  makeControls();
  drawCurves();
  makeWalk();
  addViews((walks.find((walk) => walk) || skins.find((skin) => skin) || { heading: [1, 0] }).heading);
  drawWalk();
  if (leader >= 0) showFrame(0);
  drawSkin();
  if (webgl) ["walk_view", "skin_view"].filter((view) => el(view).on).forEach(keepAlike);
  document.body.style.setProperty("--runs", data.runs.length);
  el("kind").addEventListener("change", drawSkin);
  document.body.dataset.ready = "yes";
})();
