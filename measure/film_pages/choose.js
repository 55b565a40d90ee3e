"use strict";
const data = JSON.parse(document.getElementById("data").textContent), film = data.film, at = (id) => document.getElementById(id);
const known = structuredClone(data.project), count = film.steps.length;
const state = {
  marks: (known.marks?.place_px ?? []).map((place) => [...place]), subset: known.marks?.subset_px ?? null,
  stick: lineOf(known.scale?.from_px_mm ?? known.scale?.rule_px_mm), kind: known.scale?.rule_px_mm ? "rule_px_mm" : "from_px_mm",
  length: (known.scale?.from_px_mm ?? known.scale?.rule_px_mm)?.[4] ?? null, mmPerPx: known.scale?.mm_per_px ?? null,
  plumb: lineOf(known.scale?.plumb_px), origin: known.platform?.origin_px ?? null, principal: known.camera?.principal_px ?? null,
  values: {}, first: 0, last: count - 1, tool: "mark", selected: -1,
};
const HELP = {
  mark: "Click to set a mark; drag a mark to move it. Drag beside the marks to move the picture, turn the wheel or pinch to zoom.",
  stick: "Drag from one end of a known length to the other, and type how long it is. It must be as far from the camera as the platform.",
  plumb: "Drag along a plumb line, or another edge that is vertical.",
  origin: "Click where the platform's origin is in the first frame. Without it, the origin is the mean of the marks.",
  pan: "Drag to move the picture.",
};
let texture = null;

function lineOf(five) { return five ? five.slice(0, 4) : null; }
function round(value, digits = 2) { return Number(value.toFixed(digits)); }
function subset() { return state.subset ?? 31; }
function numberIn(id) { const text = at(id).value.trim(); return text === "" || !Number.isFinite(Number(text)) ? null : Number(text); }

const view = new View(at("picture"), film.width, film.height, paint);

function grip(points, where) {
  const near = points.map((p, k) => [Math.hypot(...view.screen(p).map((v, i) => v - where[i])), k]).filter(([d]) => d < 12).sort((a, b) => a[0] - b[0]);
  return near.length ? near[0][1] : -1;
}
function rounded(place) { return place.map((v) => round(v)); }
function pairs(line) { return line ? [line.slice(0, 2), line.slice(2)] : []; }

function lineTool(name) {
  const hold = (k) => (p) => { state[name].splice(2 * k, 2, ...rounded(p)); update(); };
  return {
    down(place, where) {
      const k = grip(pairs(state[name]), where);
      if (k >= 0) return hold(k);
      const from = rounded(place);
      return (p) => { state[name] ??= [...from, ...from]; if (state[name].begun !== from) { state[name] = [...from, ...rounded(p)]; state[name].begun = from; } hold(1)(p); };
    },
    click() {},
  };
}
const TOOLS = {
  mark: {
    down(place, where) {
      const k = grip(state.marks, where);
      state.selected = k;
      if (k < 0) return null;
      view.draw();
      return (p) => { state.marks[k] = rounded(p); update(); };
    },
    click(place) { addMark(place); },
  },
  stick: lineTool("stick"), plumb: lineTool("plumb"),
  origin: { down() { return null; }, click(place) { state.origin = rounded(place); update(); } },
  pan: { down() { return null; }, click() {} },
};
function addMark(place) { state.marks.push(rounded(place)); state.selected = state.marks.length - 1; update(); }
function take(name) {
  state.tool = name; view.tool = TOOLS[name];
  for (const button of at("tools").children) button.setAttribute("aria-pressed", button.dataset.tool === name);
  at("help").textContent = HELP[name];
}

function paint(c, v) {
  const half = subset() / 2;
  state.marks.forEach((place, k) => {
    const [x, y] = v.screen(place), centre = v.screen(place.map(Math.round)), r = half * v.scale, rating = texture?.rated(place, subset());
    stroke(c, rating && !rating.use ? "#ff5a5a" : rating?.word === "good" ? "#39d98a" : "#ffc44d", k === state.selected ? 3 : 1.5, () => c.rect(centre[0] - r, centre[1] - r, 2 * r, 2 * r));
    stroke(c, "#fff", 1, () => { c.moveTo(x - 5, y); c.lineTo(x + 5, y); c.moveTo(x, y - 5); c.lineTo(x, y + 5); });
    label(c, `m${k + 1}`, centre[0] - r, centre[1] - r - 4);
  });
  for (const [name, colour] of [["stick", "#4db8ff"], ["plumb", "#e58aff"]]) {
    const ends = pairs(state[name]).map((p) => v.screen(p));
    if (!ends.length) continue;
    stroke(c, colour, 2, () => { c.moveTo(...ends[0]); c.lineTo(...ends[1]); for (const [x, y] of ends) { c.moveTo(x + 5, y); c.arc(x, y, 5, 0, 7); } });
    label(c, name === "stick" ? `${state.length ?? "?"} mm` : "plumb line", ends[1][0] + 8, ends[1][1]);
  }
  if (state.origin) {
    const [x, y] = v.screen(state.origin);
    stroke(c, "#ff9f40", 2, () => { c.arc(x, y, 7, 0, 7); c.moveTo(x - 12, y); c.lineTo(x + 12, y); c.moveTo(x, y - 12); c.lineTo(x, y + 12); });
    label(c, "origin", x + 10, y - 10);
  }
}
function stroke(c, colour, width, path) {
  for (const [style, w] of [["#0009", width + 2], [colour, width]]) { c.beginPath(); path(); c.strokeStyle = style; c.lineWidth = w; c.stroke(); }
}
function label(c, text, x, y) {
  c.font = "12px system-ui, sans-serif"; c.lineWidth = 3; c.strokeStyle = "#000b"; c.strokeText(text, x, y); c.fillStyle = "#fff"; c.fillText(text, x, y);
}

function rate() { return state.values["film.fps"] ?? null; }
function seconds(k) { return rate() ? round(film.steps[k] / rate(), 6) : null; }
function project() {
  const made = { schema: 1 };
  for (const section of ["film", "marks", "scale", "platform", "camera"]) made[section] = { ...known[section] };
  for (const [key, value] of Object.entries(state.values)) put(made, ...key.split("."), value);
  if (film.camera_fps && made.film.fps === film.camera_fps && known.film?.fps === undefined) delete made.film.fps;
  if (state.first > 0) put(made, "film", "from_s", seconds(state.first));
  if (state.last < count - 1) put(made, "film", "to_s", seconds(state.last));
  put(made, "marks", "place_px", state.marks.length ? state.marks.map((p) => [...p]) : null);
  put(made, "marks", "subset_px", state.subset);
  const five = state.stick && state.length > 0 ? [...state.stick.slice(0, 4), state.length] : null;
  for (const kind of ["from_px_mm", "rule_px_mm"]) put(made, "scale", kind, kind === state.kind && state.mmPerPx === null ? five : null);
  put(made, "scale", "mm_per_px", state.mmPerPx);
  put(made, "scale", "plumb_px", state.plumb && state.plumb.slice(0, 4));
  put(made, "platform", "origin_px", state.origin);
  put(made, "camera", "principal_px", state.principal);
  return made;
}
function put(made, section, key, value) { if (value === null || value === undefined) delete made[section][key]; else made[section][key] = value; }

function missing(made) {
  const found = [];
  if (!rate()) found.push("the capture rate that the camera was set to");
  if (state.stick && !(state.length > 0) && state.mmPerPx === null) found.push("the length of the scale stick");
  else if (!made.scale.mm_per_px && !made.scale.from_px_mm && !made.scale.rule_px_mm && !(made.camera.focal_px && made.camera.distance_m)) found.push("the scale: millimetres per pixel, or a stick of known length");
  if (subset() % 2 === 0 || subset() < 9 || subset() > 301) found.push("an odd side of the subset from 9 to 301 px");
  state.marks.forEach((place, k) => { const r = texture?.rated(place, subset()); if (r && !r.use) found.push(`another place for m${k + 1}, which ${r.word.startsWith("too") ? "has " : ""}${r.word}`); });
  return found;
}
function update() {
  const made = project(), [words, left] = optionWords(made);
  at("toml").value = tomlText(made);
  const end = /^[\w.-]+$/.test(film.stem) ? film.stem : "film";
  at("command").textContent = `track-video ${film.word} --project ${end}.toml -o ${end}.csv`;
  at("options").textContent = `track-video ${film.word} ${words} -o ${end}.csv`;
  at("only-file").hidden = !left.length; at("only-file").textContent = `In the project file alone: ${left.join(", ")}.`;
  at("missing").replaceChildren(...missing(made).map((text) => element("li", {}, `Still needed: ${text}`)));
  fillTable(); fillLines(); fillClip();
  view.draw();
}
function fillTable() {
  const rows = state.marks.map((place, k) => {
    const rating = texture?.rated(place, subset()), cells = place.map((value, axis) => {
      const input = element("input", { type: "number", step: "0.1", "aria-label": `m${k + 1} ${"xy"[axis]}` });
      input.value = value;
      input.addEventListener("change", () => { if (input.value !== "") { state.marks[k][axis] = Number(input.value); update(); } });
      return element("td", {}, input);
    });
    const drop = element("button", { type: "button", "aria-label": `Remove m${k + 1}` }, "\u00d7");
    drop.addEventListener("click", () => { state.marks.splice(k, 1); state.selected = -1; update(); });
    const said = rating ? `${rating.word}${rating.use ? `, ${rating.sigma.toPrecision(2)} px` : ""}` : "";
    return element("tr", {}, element("td", {}, `m${k + 1}`), ...cells, element("td", rating && !rating.use ? { class: "bad" } : {}, said), element("td", {}, drop));
  });
  if (!at("marks").contains(document.activeElement) || at("marks").children.length !== rows.length) at("marks").replaceChildren(...rows);
  else rows.forEach((row, k) => at("marks").children[k].children[3].replaceWith(row.children[3]));
  at("no-marks").hidden = rows.length > 0;
}
function fillLines() {
  for (const name of ["stick", "plumb", "origin", "principal"])
    for (let k = 0; at(`${name}-${k}`); k++) if (document.activeElement !== at(`${name}-${k}`)) at(`${name}-${k}`).value = state[name]?.[k] ?? "";
  at("length-said").textContent = state.kind === "rule_px_mm" ? "Pitch of the graduation, mm" : "Length, mm";
  const apart = state.stick && Math.hypot(state.stick[2] - state.stick[0], state.stick[3] - state.stick[1]);
  at("scale-said").textContent = state.mmPerPx !== null ? (state.stick ? "The number counts; empty it to use the stick." : "") : !apart ? "Type a number, or drag a stick over a known length." : state.kind === "rule_px_mm" ? "The pitch is measured along the line, over eight divisions at least."
    : `${apart.toFixed(1)} px${state.length > 0 ? `: ${(state.length / apart).toPrecision(5)} mm/px, +- ${(100 * Math.SQRT2 * 0.5 / apart).toPrecision(2)} % from half a pixel in each coordinate` : ""}`;
  const lean = state.plumb && Math.atan2(...(state.plumb[3] < state.plumb[1] ? [state.plumb[2] - state.plumb[0], state.plumb[1] - state.plumb[3]] : [state.plumb[0] - state.plumb[2], state.plumb[3] - state.plumb[1]]));
  at("plumb-said").textContent = state.plumb ? `About ${(lean * 180 / Math.PI).toFixed(2)} deg clockwise; the command finds the line between the two points itself.` : "";
}
function fillClip() {
  const said = (k) => `frame ${film.first + k}${rate() ? `, ${seconds(k)} s` : ""}`;
  at("first-said").textContent = said(state.first); at("last-said").textContent = said(state.last);
  const nearest = (k) => data.strip.reduce((best, one) => Math.abs(one.frame - k) < Math.abs(best.frame - k) ? one : best).src;
  for (const [id, k] of [["first-seen", state.first], ["last-seen", state.last]]) if (at(id).src !== nearest(k)) at(id).src = nearest(k);
  at("other-first").hidden = state.first === 0;
  at("other-first").firstElementChild.textContent = `track-video ${film.word}${rate() ? ` --fps ${rate()} --from ${seconds(state.first)}` : ""} --choose ${film.page}`;
  const x = (k) => 600 * k / Math.max(count - 1, 1), most = Math.max(...data.change, 1e-9);
  const curve = data.change.map((v, k) => v === null ? "" : `${k && data.change[k - 1] !== null ? "L" : "M"}${x(k).toFixed(1)} ${(66 - 60 * v / most).toFixed(1)}`).join("");
  at("change").replaceChildren(element("rect", { class: "band", x: x(state.first), width: Math.max(x(state.last) - x(state.first), 1), y: 0, height: 70 }), element("path", { class: "curve", d: curve }));
}

function wire() {
  for (const button of at("tools").children) button.addEventListener("click", () => take(button.dataset.tool));
  data.pictures.forEach((one, k) => at("shown").append(element("option", { value: k }, one.label)));
  at("shown").addEventListener("change", async () => view.show(await pictureOf(data.pictures[at("shown").value].src)));
  at("closer").addEventListener("click", () => view.zoom(1.5)); at("farther").addEventListener("click", () => view.zoom(1 / 1.5)); at("whole").addEventListener("click", () => view.fit());
  at("subset").value = subset();
  at("subset").addEventListener("input", () => { state.subset = numberIn("subset"); update(); });
  for (const input of document.querySelectorAll("input[data-key]")) {
    if (input.id === "subset") continue;
    const [section, key] = input.dataset.key.split("."), value = known[section]?.[key] ?? (input.id === "fps" ? film.fps : null);
    if (value !== null && value !== undefined) { input.value = value; state.values[input.dataset.key] = value; }
    input.addEventListener("input", () => { state.values[input.dataset.key] = input.value === "" ? null : Number(input.value); update(); });
  }
  for (const [id, key] of [["mm-per-px", "mmPerPx"], ["length", "length"]]) {
    at(id).value = state[key] ?? "";
    at(id).addEventListener("input", () => { state[key] = numberIn(id); update(); });
  }
  at("stick-kind").value = state.kind;
  at("stick-kind").addEventListener("change", () => { state.kind = at("stick-kind").value; update(); });
  for (const [name, size] of [["stick", 4], ["plumb", 4], ["origin", 2], ["principal", 2]])
    for (let k = 0; k < size; k++) at(`${name}-${k}`).addEventListener("input", () => {
      const all = [...Array(size).keys()].map((i) => numberIn(`${name}-${i}`));
      state[name] = all.includes(null) ? null : all;
      update();
    });
  for (const end of ["first", "last"]) {
    at(end).max = count - 1; at(end).value = state[end];
    at(end).addEventListener("input", () => {
      state[end] = Number(at(end).value);
      if (state.last <= state.first) { state.first = end === "first" ? Math.min(state.first, count - 2) : state.last - 1; state.first = Math.max(state.first, 0); state.last = state.first + 1; }
      at("first").value = state.first; at("last").value = state.last;
      update();
    });
  }
  at("suggest").disabled = !data.suggested.length;
  at("suggest").addEventListener("click", () => { state.marks = data.suggested.map((p) => [...p]); if (data.suggested_subset !== subset()) { state.subset = data.suggested_subset; at("subset").value = subset(); } update(); });
  at("clear").addEventListener("click", () => { state.marks = []; state.selected = -1; update(); });
  at("save").addEventListener("click", () => {
    const link = element("a", { download: `${film.stem}.toml`, href: URL.createObjectURL(new Blob([at("toml").value], { type: "application/toml" })) });
    link.click(); URL.revokeObjectURL(link.href);
  });
  for (const button of document.querySelectorAll("[data-copy]")) button.addEventListener("click", () => copy(at(button.dataset.copy)));
  at("picture").addEventListener("pointermove", (e) => { const [x, y] = view.film(e.offsetX, e.offsetY); at("place").textContent = `x ${x.toFixed(1)}, y ${y.toFixed(1)}`; });
  at("picture").addEventListener("keydown", pressed);
}
async function copy(from) {
  const text = from.value ?? from.textContent;
  try { await navigator.clipboard.writeText(text); at("copied").textContent = "Copied."; }
  catch { getSelection().selectAllChildren(from); from.select?.(); at("copied").textContent = "Selected; press Ctrl+C to copy."; }
}
function pressed(e) {
  const step = e.shiftKey ? 1 : 0.1, way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key], mark = state.marks[state.selected];
  if (way && mark) { state.marks[state.selected] = mark.map((v, k) => round(v + step * way[k])); update(); }
  else if (way) view.pan(-40 * way[0], -40 * way[1]);
  else if (e.key === "Enter" && state.tool === "mark") addMark(view.middle());
  else if (e.key === "Enter" && state.tool === "origin") { state.origin = rounded(view.middle()); update(); }
  else if (e.key === "Delete" && mark) { state.marks.splice(state.selected, 1); state.selected = -1; update(); }
  else if (e.key === "+" || e.key === "=") view.zoom(1.25);
  else if (e.key === "-") view.zoom(0.8);
  else return;
  e.preventDefault();
}

wire();
take("mark");
update();
pictureOf(data.pictures[0].src).then((image) => { texture = new Texture(image, data); view.show(image); update(); document.documentElement.dataset.ready = "yes"; });
