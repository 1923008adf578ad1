// The page of `flexura watch`. Everything that comes from a campaign is put in as text, never as HTML.
"use strict";

const cards = new Map(); // by number: its elements, and what was drawn of it
const SVG = "http://www.w3.org/2000/svg";
const MARGIN = { left: 46, right: 12, top: 8, bottom: 24 };
const SILENT = 25000; // ms without a sign of the watcher; it sends one every 5 s
let heard = 0;

function make(tag, text, properties) {
  const element = document.createElement(tag);
  if (text !== undefined) element.textContent = text;
  return Object.assign(element, properties || {});
}

function drawn(tag, attributes, text) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text !== undefined) element.textContent = text;
  return element;
}

const two = (number) => String(Math.floor(number)).padStart(2, "0");

function offset(date) {
  const minutes = -date.getTimezoneOffset();
  return (minutes < 0 ? "−" : "+") + two(Math.abs(minutes) / 60) + ":" + two(Math.abs(minutes) % 60);
}

function clock(date, withDay) {
  const day = date.getFullYear() + "-" + two(date.getMonth() + 1) + "-" + two(date.getDate()) + " ";
  return (withDay ? day : "") + two(date.getHours()) + ":" + two(date.getMinutes()) + ":" + two(date.getSeconds());
}

// Times are those of whoever reads the page, with their offset; of a simulated rig those of its own clock, in UTC.
function when(iso, simulated) {
  const date = new Date(iso);
  if (Number.isNaN(date.getTime())) return "";
  return simulated ? date.toISOString().slice(11, 19) + " simulated" : clock(date, true) + " " + offset(date);
}

function duration(seconds) {
  if (seconds < 120) return Math.round(seconds) + " s";
  const minutes = Math.round(seconds / 60);
  return minutes < 60 ? minutes + " min" : Math.floor(minutes / 60) + " h " + two(minutes % 60) + " min";
}

const degrees = (value) => (value === null ? "–" : value.toFixed(2) + " °C");

function facts(one) {
  const found = [
    ["plate", degrees(one.plate)],
    ["air", degrees(one.air)],
    ["set-point", one.set_point === null ? "none" : degrees(one.set_point)],
    ["limits", one.coldest === null ? "–" : one.coldest + " to " + one.hottest + " °C"],
    ["rig", one.abandoned && one.rest === "follows the programme" ? "not known" : one.rest],
  ].filter(([, value]) => one.kind === "sweeps" || (value !== "–" && value !== "none")); // of hits in a room: no oven
  if (one.seconds_left !== null) {
    found.push(["left" + (one.simulated ? ", simulated time" : ""), duration(one.seconds_left)]);
    found.push(["expected end", when(one.ends, one.simulated)]);
  }
  if (one.read !== null) found.push(["last reading", when(one.read, one.simulated)]);
  return found;
}

function card(number, open) {
  const parts = { version: -1, sensor: 0, data: null, loading: false };
  parts.root = make("article", undefined, { className: "card" });
  const head = make("div", undefined, { className: "head" });
  parts.badge = make("span", "", { className: "badge" });
  parts.name = make("h2");
  head.append(parts.badge, parts.name);
  parts.stage = make("p");
  parts.warnings = make("div", undefined, { className: "warning" });
  parts.bar = make("progress");
  parts.count = make("p", undefined, { className: "small" });
  parts.next = make("p");
  parts.facts = make("dl", undefined, { className: "facts" });
  parts.more = make("details", undefined, { open });
  parts.more.append(make("summary", "temperatures, last FRF, levels, log"));
  parts.charts = make("div", undefined, { className: "charts" });
  parts.more.append(parts.charts);
  parts.more.addEventListener("toggle", () => load(number));
  parts.root.append(head, parts.warnings, parts.stage, parts.bar, parts.count, parts.next, parts.facts, parts.more);
  document.getElementById("campaigns").append(parts.root);
  new ResizeObserver(() => redraw(parts)).observe(parts.charts);
  cards.set(number, parts);
  return parts;
}

function show(state) {
  const all = state.campaigns;
  document.querySelector("#campaigns > noscript")?.remove();
  all.forEach((one, number) => {
    const parts = cards.get(number) || card(number, all.length === 1 || (one.under_way && all.length < 4));
    parts.state = one;
    const bad = one.unsafe.length || ["silent", "stopped", "gone"].includes(one.state);
    parts.badge.textContent = one.unsafe.length ? "not at rest" : one.state;
    parts.badge.className = "badge" + (bad ? " bad" : one.state === "running" || one.state === "complete" ? "" : " calm");
    parts.name.textContent = one.name;
    parts.stage.textContent = one.under_way ? one.stage : one.ending;
    const warnings = one.unsafe.map((what) => "NOT AT REST: " + what);
    if (one.state === "silent") {
      const what = one.abandoned ? "its process is gone without a word" : "nothing was written";
      warnings.push("silent: " + what + " for " + duration(one.silent_for));
    }
    if (one.trouble) warnings.push("trouble: " + one.trouble);
    if (one.clipping.length) warnings.push("clipping: " + one.clipping.join(", "));
    if (one.problem) warnings.push((one.state === "gone" ? "the folder cannot be read: " : "") + one.problem);
    parts.warnings.replaceChildren(...warnings.map((text) => make("p", text)));
    parts.bar.max = Math.max(one.total, 1);
    parts.bar.value = one.finished + one.missing;
    parts.bar.hidden = one.total === 0;
    parts.count.textContent = one.total === 0 ? "" : one.finished + " of " + one.total + " " + one.kind +
      (one.missing ? ", " + one.missing + " given up" : "") +
      (one.rejected ? ", " + one.rejected + " rejected" : "") + (one.doubted ? ", " + one.doubted + " in doubt" : "");
    parts.next.textContent = !one.under_way && one.next_step ? "next: " + one.next_step : "";
    parts.more.hidden = one.kind === "hits"; // flexura view draws them
    parts.facts.replaceChildren(...facts(one).map(([what, value]) => {
      const row = make("div");
      row.append(make("dt", what), make("dd", value));
      return row;
    }));
    load(number);
  });
  document.title = all.length === 1 ? all[0].name + ": " + all[0].state + " – Flexura" : "Flexura";
  const failed = state.messages && state.messages.failed;
  const told = document.getElementById("messages");
  told.hidden = !failed;
  told.textContent = failed ? failed + " messages could not be told; last: " + state.messages.last_failure : "";
}

async function load(number) {
  const parts = cards.get(number);
  if (!parts.more.open || parts.more.hidden || parts.loading || parts.version === parts.state.version) return;
  parts.loading = true;
  const version = parts.state.version;
  try {
    const answer = await fetch("/campaigns/" + number);
    if (answer.ok) {
      parts.data = await answer.json();
      parts.version = version;
      rebuild(parts);
    }
  } catch {
    // the next state asks again
  } finally {
    setTimeout(() => { parts.loading = false; }, 1500);
  }
}

function section(title, wide) {
  const found = make("section", undefined, { className: wide ? "wide" : "" });
  found.append(make("h3", title));
  return found;
}

function key(entries) {
  const found = make("div", undefined, { className: "key" });
  for (const [name, text] of entries) {
    const entry = make("span");
    entry.append(make("i", undefined, { className: name }), document.createTextNode(text));
    found.append(entry);
  }
  return found;
}

function rebuild(parts) {
  const scrolled = parts.log ? parts.log.scrollTop : 0;
  const data = parts.data, whole = [];
  parts.pictures = [];
  const time = parts.state.simulated ? "simulated time" : "time of day " + offset(new Date());
  const oven = section("temperatures, °C; " + time, true);
  parts.pictures.push([picture(oven), () => temperatures(parts)]);
  oven.append(key([["plate", "plate"], ["air", "air"], ["set", "set-point"], ["programme", "programme"],
    ["limit", "limits"], ["mark", "● sweep finished  × rejected or given up"]]));
  whole.push(oven);
  if (data.frfs && data.frfs.sensors.length) {
    parts.sensor = Math.min(parts.sensor, data.frfs.sensors.length - 1);
    const frf = section("last FRF, dB: " + data.frfs.sensors[parts.sensor].label);
    if (data.frfs.sensors.length > 1) {
      const chosen = make("select");
      chosen.setAttribute("aria-label", "sensor");
      data.frfs.sensors.forEach((one, place) => chosen.append(make("option", one.name, { value: place })));
      chosen.value = parts.sensor;
      chosen.addEventListener("change", () => { parts.sensor = Number(chosen.value); rebuild(parts); });
      frf.append(chosen);
    }
    parts.pictures.push([picture(frf), () => frfs(parts, "level")]);
    frf.append(key([["last", data.frfs.last], ...(data.frfs.before ? [["before", data.frfs.before]] : [])]));
    const coherence = section("its coherence");
    parts.pictures.push([picture(coherence), () => frfs(parts, "coherence")]);
    whole.push(frf, coherence);
  }
  if (data.levels) whole.push(levels(data.levels));
  const log = section("log" + (parts.state.simulated ? ", simulated time" : ""));
  parts.log = make("ol", undefined, { className: "log", tabIndex: 0 });
  parts.log.append(...data.log.map((line) => {
    const item = make("li");
    item.append(make("time", when(line.date, parts.state.simulated)), make("span", line.words));
    return item;
  }));
  log.append(parts.log);
  whole.push(log);
  parts.charts.replaceChildren(...whole);
  parts.log.scrollTop = scrolled;
  redraw(parts);
}

function picture(parent) {
  const svg = drawn("svg", { role: "img" });
  parent.append(svg);
  return svg;
}

function redraw(parts) {
  for (const [svg, lines] of parts.pictures || []) plot(svg, lines());
}

function levels(found) {
  const whole = section("levels of the last repeat, dB re full scale: " + found.place);
  const grid = make("div", undefined, { className: "levels" });
  for (const one of found.channels) {
    const numbers = make("span", one.peak.toFixed(1) + " peak, " + one.rms.toFixed(1) + " rms");
    if (one.clipped) numbers.append(make("b", "CLIP", { className: "clip" }));
    grid.append(make("span", one.name), make("meter", undefined, { min: -100, max: 0, value: one.peak }), numbers);
  }
  whole.append(grid);
  return whole;
}

function temperatures(parts) {
  const found = parts.data.temperatures, state = parts.state, at = found.time;
  const pairs = (values) => at.map((time, place) => [time, values[place]]);
  const lines = [["programme", found.programme], ["air", pairs(found.air)], ["set", found.set_point], ["plate", pairs(found.plate)]];
  const ends = at.length ? [at[0], at[at.length - 1]] : [0, 1];
  if (found.programme.length) ends[1] = Math.max(ends[1], found.programme[found.programme.length - 1][0]);
  const known = lines.flatMap(([, points]) => points.map(([, value]) => value)).filter((value) => value !== null);
  const low = Math.min(...known), high = Math.max(...known), near = 0.3 * (high - low) + 2;
  for (const limit of [state.coldest, state.hottest]) { // one that is far away would leave the curves no room
    if (limit !== null && limit > low - near && limit < high + near) lines.push(["limit", [[ends[0], limit], [ends[1], limit]]]);
  }
  return { lines, marks: parts.data.marks, x: ends, time: true, simulated: state.simulated };
}

function frfs(parts, what) {
  const one = parts.data.frfs.sensors[parts.sensor];
  const pairs = (curve) => curve.frequency.map((frequency, place) => [frequency, curve[what][place]]);
  const lines = [];
  if (one.before) lines.push(["before", pairs(one.before)]);
  lines.push(["last", pairs(one.last)]);
  const x = [one.last.frequency[0], one.last.frequency[one.last.frequency.length - 1]];
  return { lines, marks: [], x, y: what === "coherence" ? [0, 1] : null, unit: " Hz" };
}

function steps(low, high, most) {
  const raw = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw) || raw;
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high + 1e-9 * step; value += step) found.push(value);
  return found;
}

function timeSteps(low, high, most, simulated) {
  const sizes = [10, 20, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, 86400, 172800, 604800];
  const step = sizes.find((one) => (high - low) / one <= most) || (high - low) / most;
  const shift = simulated ? low : new Date(low * 1000).getTimezoneOffset() * 60;
  const found = [];
  for (let value = Math.ceil((low - shift) / step) * step + shift; value <= high; value += step) found.push(value);
  return found;
}

function plot(svg, { lines, marks, x, y, time, simulated, unit }) {
  const width = svg.clientWidth, height = svg.clientHeight;
  if (!width || !height) return;
  svg.setAttribute("viewBox", "0 0 " + width + " " + height);
  let [low, high] = x;
  if (!(high > low)) high = low + 1;
  let [bottom, top] = y || [Infinity, -Infinity];
  if (!y) {
    for (const [, points] of lines) {
      for (const [, value] of points) {
        if (value !== null) { bottom = Math.min(bottom, value); top = Math.max(top, value); }
      }
    }
    if (!(top >= bottom)) [bottom, top] = [0, 1];
    const room = 0.05 * (top - bottom) || 1;
    bottom -= room;
    top += room;
  }
  const right = width - MARGIN.right, base = height - MARGIN.bottom;
  const across = (value) => MARGIN.left + ((value - low) / (high - low)) * (right - MARGIN.left);
  const up = (value) => base - ((value - bottom) / (top - bottom)) * (base - MARGIN.top);
  const parts = [];
  for (const value of steps(bottom, top, 5)) {
    parts.push(drawn("line", { class: "grid", x1: MARGIN.left, x2: right, y1: up(value), y2: up(value) }));
    const text = String(Number(value.toPrecision(6)));
    parts.push(drawn("text", { x: MARGIN.left - 6, y: up(value) + 4, "text-anchor": "end" }, text));
  }
  const most = Math.max(2, Math.floor((right - MARGIN.left) / 80));
  for (const value of time ? timeSteps(low, high, most, simulated) : steps(low, high, most)) {
    const text = !time ? String(Number(value.toPrecision(6))) + unit
      : simulated ? duration(value - low) : clock(new Date(value * 1000), false).slice(0, 5);
    const at = across(value);
    if (at > right - 14) continue;
    parts.push(drawn("line", { class: "grid", x1: at, x2: at, y1: MARGIN.top, y2: base }));
    parts.push(drawn("text", { x: at, y: height - 6, "text-anchor": "middle" }, text));
  }
  for (const [name, points] of lines) {
    let path = "", pen = "M";
    for (const [one, value] of points) {
      if (one === null || value === null) { pen = "M"; continue; }
      path += pen + across(one).toFixed(1) + " " + up(value).toFixed(1);
      pen = "L";
    }
    if (path) parts.push(drawn("path", { class: name, d: path }));
  }
  for (const mark of marks) {
    if (mark.temperature === null || mark.temperature === undefined) continue;
    const at = across(mark.time), here = up(mark.temperature);
    parts.push(mark.kind === "finished" ? drawn("circle", { class: mark.kind, cx: at, cy: here, r: 3.5 })
      : drawn("path", { class: mark.kind, d: `M${at - 4} ${here - 4}l8 8m0 -8l-8 8` }));
  }
  svg.replaceChildren(...parts);
}

function lost() {
  const shown = document.getElementById("link");
  shown.className = "lost";
  shown.textContent = "no connection to the watcher; this is how it stood" +
    (heard ? " at " + clock(new Date(heard), true) + " " + offset(new Date(heard)) : "");
}

function link() {
  const shown = document.getElementById("link");
  const events = new EventSource("/events");
  events.onmessage = (event) => {
    heard = Date.now();
    const state = JSON.parse(event.data);
    shown.className = "";
    const now = new Date(state.now * 1000);
    shown.textContent = "live, " + clock(now, true) + " " + offset(now);
    show(state);
  };
  events.onerror = () => {
    lost();
    if (events.readyState === EventSource.CLOSED) setTimeout(link, 5000);
  };
}

link();
setInterval(() => { if (heard && Date.now() - heard > SILENT) lost(); }, 5000);
