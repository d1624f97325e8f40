// Shows the states that the monitor sends. Text is set as text, never as markup; figures are SVG that the monitor draws.
"use strict";

const byId = (id) => document.getElementById(id);
// Time without a state after which the page reports a lost connection, ms.
const LOST_AFTER = 5000;
// Shortest interval between two requests for figures, ms.
const FIGURES_INTERVAL = 2000;
const HISTORY_INTERVAL = 20000;
// Longest time for the answer to a request, ms.
const ANSWER_WITHIN = 15000;

let latest = null;
let heardAt = null;
let figuresAt = 0;
let historyAt = 0;
let lostSince = null;
const others = new Map();

function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function element(name, className, text) {
  const created = document.createElement(name);
  if (className) created.className = className;
  if (text !== undefined) created.textContent = text;
  return created;
}

function clock(at) {
  const time = new Date(at);
  if (isNaN(time)) return "";
  // UTC, as in the terminal, the event log and the files.
  const [day, hours] = time.toISOString().split("T");
  const isToday = day === new Date().toISOString().slice(0, 10);
  return `${isToday ? "" : `${day} `}${hours.slice(0, 8)} UTC`;
}

function duration(at) {
  const seconds = Math.max(0, Math.round((Date.now() - new Date(at)) / 1000));
  if (seconds < 60) return `${seconds} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min`;
  const hours = Math.floor(seconds / 3600);
  return hours < 48 ? `${hours} h ${Math.floor((seconds % 3600) / 60)} min` : `${Math.floor(hours / 24)} days`;
}

function since(at) {
  return at ? `since ${clock(at)} (${duration(at)})` : "";
}

function number(value, digits = 2) {
  return typeof value === "number" ? value.toFixed(digits) : "\u2013";
}

function showBanner(level, word, title, sinceText, sentence, action) {
  const banner = byId("banner");
  if (banner.className !== level) banner.className = level;
  setText(byId("word"), word);
  setText(byId("title"), title);
  setText(byId("since"), sinceText);
  setText(byId("sentence"), sentence);
  setText(byId("action"), action);
  document.title = `${word}: ${latest ? latest.machine : "ballrace"}`;
}

function showState() {
  if (lostSince !== null) {
    const last = latest ? ` The last state was ${latest.status.word}.` : "";
    showBanner("lost", "NO CONNECTION", "", since(lostSince), `The monitor does not answer.${last}`,
      "Check that the monitor runs and that this computer reaches it.");
    return;
  }
  if (!latest) return;
  const status = latest.status;
  setText(byId("machine"), `${latest.machine} \u2013 ${latest.source}`);
  showBanner(status.level, status.word, status.title, since(status.since), status.sentence, status.action);
}

function showAlarms() {
  const alarms = latest.alarms;
  byId("no-alarm").hidden = alarms.length > 0;
  byId("token-form").hidden = !latest.can_acknowledge || alarms.every((alarm) => alarm.acknowledged_at);
  byId("read-only").hidden = latest.can_acknowledge || alarms.length === 0;
  const list = byId("alarm-list");
  const key = JSON.stringify([alarms, latest.can_acknowledge]);
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...alarms.map((alarm) => {
    const item = element("li", alarm.acknowledged_at ? "acknowledged" : alarm.ended_at ? "ended" : "active");
    const text = element("div", "text");
    text.append(element("b", "", alarm.title), element("span", "", alarm.sentence), element("br"),
      element("span", "", `Action: ${alarm.action}`), element("br"));
    const times = [`raised ${clock(alarm.raised_at)}`];
    if (alarm.ended_at) times.push(`ended ${clock(alarm.ended_at)}`);
    if (alarm.acknowledged_at) times.push(`acknowledged ${clock(alarm.acknowledged_at)}`);
    text.append(element("span", "soft", times.join(", ")));
    item.append(text);
    if (latest.can_acknowledge && !alarm.acknowledged_at) {
      const button = element("button", "", "Acknowledge");
      button.type = "button";
      button.addEventListener("click", () => acknowledge(alarm.id, button));
      item.append(button);
    }
    return item;
  }));
}

async function acknowledge(alarm, button) {
  button.disabled = true;
  const answer = byId("answer");
  try {
    const response = await fetch("acknowledge", {
      method: "POST",
      signal: AbortSignal.timeout(ANSWER_WITHIN),
      headers: { "Authorization": `Bearer ${byId("token").value}`, "Content-Type": "application/json" },
      body: JSON.stringify({ alarm }),
    });
    setText(answer, response.ok ? "" : await response.text());
  } catch {
    setText(answer, "The monitor does not answer.");
  }
  button.disabled = false;
}

function row(cells, className) {
  const created = element("tr", className);
  created.append(...cells.map((cell) => element("td", "", cell)));
  return created;
}

function showValues() {
  const facts = [`${number(latest.time_s, 1)} s of the recording`];
  if (latest.second) facts.push(`${number(latest.second.speed_rpm, 1)} rpm`);
  if (latest.monitor === "starting") facts.push(`the twin has been starting for ${number(latest.starting_s, 0)} s`);
  if (latest.monitor === "running") facts.push(`the twin started in ${number(latest.starting_s, 1)} s`);
  setText(byId("facts"), facts.join("; ") + ".");
  const head = element("tr");
  const limited = latest.limits.length > 0;
  const names = limited ? ["Probe", "Indicator", "Value", "Limit", "Share"]
    : ["Probe", "Peak to peak, um", "1X, um", "Residual, um rms", "Crest factor", "Kurtosis"];
  head.append(...names.map((name) => element("th", "", name)));
  byId("value-head").replaceChildren(head);
  const rows = limited ? latest.limits.map((limit) => {
    const share = limit.value === null ? null : limit.value / limit.limit;
    const name = limit.bearing ? `${limit.indicator} of ${limit.bearing}` : limit.indicator;
    const unit = limit.unit ? ` ${limit.unit}` : "";
    const level = typeof limit.exceeded_since_s === "number" || share > 1 ? "exceeded" : share > 0.8 ? "near" : "";
    const percent = share === null ? "\u2013" : `${number(100 * share, 0)} %`;
    return row([limit.probe, name, number(limit.value) + unit, number(limit.limit) + unit, percent], level);
  }) : (latest.second ? latest.second.probes : []).map((probe) => row([probe.name, number(probe.peak_to_peak_um),
    number(probe.one_x_um), number(probe.residual_rms_um, 3), number(probe.crest_factor), number(probe.kurtosis)]));
  byId("value-rows").replaceChildren(...rows);
  byId("diagnoses").replaceChildren(...latest.diagnoses.map((diagnosis) => {
    const item = element("li");
    item.append(element("b", "", diagnosis.title), element("span", "", diagnosis.details));
    return item;
  }));
}

function showEvents() {
  byId("events").replaceChildren(...latest.events.map((event) => {
    const item = element("li");
    item.append(element("time", "", clock(event.at)), document.createTextNode(event.sentence));
    return item;
  }));
  const counts = latest.counts;
  setText(byId("footer"), `ballrace ${latest.version}. ${counts.rows} samples read, ${counts.lost_frames} lost, ` +
    `${counts.repeated_frames} repeated, ${counts.malformed_frames} malformed, ${counts.dropped_rows} dropped; ` +
    `${latest.deadline_misses} deadlines missed.`);
}

function figure(data) {
  const created = element("figure", "figure");
  created.append(element("figcaption", "", data.title));
  const parsed = new DOMParser().parseFromString(
    data.svg.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" '), "image/svg+xml");
  const svg = parsed.documentElement;
  if (svg.nodeName === "svg") {
    svg.setAttribute("role", "img");
    svg.setAttribute("aria-label", data.title);
    svg.removeAttribute("aria-hidden");
    created.append(svg);
  }
  if (data.note) created.append(element("p", "soft", data.note));
  return created;
}

async function load(path) {
  const response = await fetch(path, { signal: AbortSignal.timeout(ANSWER_WITHIN) });
  if (!response.ok) throw new Error(await response.text());
  return response.json();
}

async function loadFigures() {
  if (document.hidden || Date.now() - figuresAt < FIGURES_INTERVAL) return;
  figuresAt = Infinity;
  try {
    const figures = await load("figures");
    const sections = new Map();
    for (const data of figures) {
      if (!sections.has(data.heading)) sections.set(data.heading, []);
      sections.get(data.heading).push(figure(data));
    }
    byId("figures").replaceChildren(...[...sections].map(([heading, drawn]) => {
      const section = element("section");
      const grid = element("div", "figures");
      grid.append(...drawn);
      section.append(element("h2", "", heading), grid);
      return section;
    }));
  } catch {
    // The next event tries again; the banner reports a lost connection.
  }
  // The monitor collects samples for figures after the first request for them.
  figuresAt = byId("figures").firstChild ? Date.now() : 0;
}

async function loadHistory() {
  if (document.hidden || Date.now() - historyAt < HISTORY_INTERVAL) return;
  historyAt = Infinity;
  try {
    const drawn = await load(`history?hours=${byId("hours").value}`);
    setText(byId("history-note"), drawn.length > 0 ? drawn[0].note : "");
    byId("history").replaceChildren(...drawn.map((data) => figure({ ...data, note: "" })));
    historyAt = Date.now();
  } catch (error) {
    setText(byId("history-note"), error.message);
    historyAt = Date.now() - HISTORY_INTERVAL + 5000;
  }
}

function follow(origin, show) {
  let source = null;
  let at = 0;
  const open = () => {
    if (source) source.close();
    source = new EventSource(`${origin}/events`);
    at = performance.now();
    source.addEventListener("state", (event) => {
      at = performance.now();
      show(JSON.parse(event.data));
    });
  };
  open();
  // A state comes every second. A connection whose network path was lost stays open in silence, and after a refused request the
  // browser does not connect again.
  setInterval(() => { if (performance.now() - at > LOST_AFTER) open(); }, 1000);
}

function showOthers() {
  const nav = byId("others");
  nav.hidden = others.size === 0;
  for (const [origin, other] of others) {
    const isLost = Date.now() - other.heardAt > LOST_AFTER;
    const status = other.state && !isLost ? other.state.status : null;
    other.link.className = `machine ${status ? status.level : "lost"}`;
    setText(other.word, status ? status.word : "NO CONNECTION");
    setText(other.name, other.state ? other.state.machine : origin);
    setText(other.since, status ? since(status.since) : since(other.heardAt));
  }
}

function followOthers() {
  for (const origin of latest.also) {
    if (others.has(origin)) continue;
    const link = element("a", "machine lost");
    link.href = origin;
    const other = { link, name: element("span"), word: element("b"), since: element("span"), heardAt: Date.now() };
    link.append(other.name, other.word, other.since);
    byId("others").append(link);
    others.set(origin, other);
    follow(origin, (state) => { other.state = state; other.heardAt = Date.now(); showOthers(); });
  }
}

byId("token-form").addEventListener("submit", (event) => event.preventDefault());
byId("hours").addEventListener("change", () => { historyAt = 0; loadHistory(); });
follow(".", (state) => {
  latest = state;
  heardAt = Date.now();
  lostSince = null;
  showState();
  showAlarms();
  showValues();
  showEvents();
  followOthers();
  loadFigures();
  loadHistory();
});
const openedAt = Date.now();
setInterval(() => {
  if (Date.now() - (heardAt ?? openedAt) > LOST_AFTER) lostSince = lostSince ?? heardAt ?? openedAt;
  showState();
  showOthers();
}, 1000);
