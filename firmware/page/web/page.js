// Shows the printer's state, which comes as server-sent events, and sends commands. No library, nothing from elsewhere.
"use strict";

const language = Object.keys(texts).find((code) => (localStorage.getItem("language") || navigator.language).startsWith(code)) || "en";
const words = texts[language], said = printerTexts[language];  // the state has the English sentences of messages itself
const $ = (id) => document.getElementById(id);
let state = null;
let access = {page: "local", paired: false};

// --- Small tools

function element(name, text, attributes = {}) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}
function show(id, shown, text) {
  const node = $(id);
  node.hidden = !shown;
  if (text !== undefined && node.textContent !== text) node.textContent = text;
}
// Fills a list or a group only if it has changed, so that the keyboard's focus and a screen reader stay where they are.
function fill(node, key, make) {
  const text = JSON.stringify(key);
  if (node.dataset.key === text) return;
  node.dataset.key = text;
  node.replaceChildren(...make());
}
const number = (value, digits) => value.toLocaleString(words.locale, {minimumFractionDigits: digits, maximumFractionDigits: digits});
function duration(seconds) {
  if (seconds < 60) return `${Math.round(seconds)} ${words.s}`;
  const minutes = Math.ceil(seconds / 60);
  return minutes < 60 ? `${minutes} ${words.min}` : `${Math.floor(minutes / 60)} ${words.h} ${minutes % 60} ${words.min}`;
}

// --- What the printer tells: a code with its values, and beside it an English sentence

// As firmware/messages/catalogue.hpp has it: {area_mm2} is a value, {count?Insel|Inseln} chooses, [ ] is left out if a value of it is not told.
function fact(name, value) {
  const digits = factDigits[name] || 0;
  if (digits >= 0) return number(value, digits);
  return Math.abs(value) >= 10 ** (-digits - 1) ? number(value, 0) : value.toLocaleString(words.locale, {maximumSignificantDigits: -digits});
}
function filledIn(pattern, told) {
  const isTold = (part) => [...part.matchAll(/\{(\w+)/g)].every(([, name]) => name === "name" ? told.name : name in told.values);
  return pattern.replace(/\[([^\]]*)\]/g, (all, part) => isTold(part) ? part : "").replace(/\{(\w+)(?:\?([^|}]*)\|([^}]*))?\}/g, (all, name, one, many) => {
    if (name === "name") return told.name || "";
    if (!(name in told.values)) return "";
    return one === undefined ? fact(name, told.values[name]) : told.values[name] === 1 ? one : many;
  });
}
// The sentence and the remedy; null: there are none but the English sentence.
function inWords(told) {
  const texts = told && said.told[told.code];
  return texts ? texts.map((text) => filledIn(text, told)) : null;
}
function worded(told, english) {
  const texts = inWords(told);
  return texts ? `${texts[0]}${texts[1] ? `. ${texts[1]}` : ""}` : english;
}
const refusal = (reply) => worded(reply.told, `${reply.error}${reply.advice ? `. ${reply.advice}` : ""}`);

// --- To the printer

async function post(path, body) {
  const headers = {"Content-Type": "application/json", "Plumbline-Token": localStorage.getItem("token") || ""};
  const reply = await fetch(path, {method: "POST", headers, body: JSON.stringify(body)});
  return {status: reply.status, ...await reply.json()};
}
async function lookAtAccess() {
  const reply = await fetch("/access", {headers: {"Plumbline-Token": localStorage.getItem("token") || ""}});
  access = await reply.json();
  if (access.page === "local" && !access.paired) {
    const paired = await post("/pair", {});
    if (paired.token) localStorage.setItem("token", paired.token);
    access.paired = Boolean(paired.token);
  }
  showBrowsers();
}
// Commands go one after the other, so that each is meant for what the one before has made of the printer.
let sendings = 0, lastSent = Promise.resolve(), stateCame = () => {};
function command(body) {
  sendings += 1;
  markButtons();
  show("notice", false);
  lastSent = lastSent.then(() => send(body)).finally(() => {
    sendings -= 1;
    markButtons();
  });
  return lastSent;
}
async function send(body) {
  try {
    if (!access.paired) await lookAtAccess();
    if (!access.paired && !await pair()) return;
    const reply = await post("/command", body);
    if (reply.status === 401) {
      access.paired = false;
      return await send(body);
    }
    if (!reply.ok) return show("notice", true, refusal(reply));
    // What it has changed is in the next state. If nothing has, none comes.
    await new Promise((done) => { stateCame = done; setTimeout(done, 500); });
  } catch {
    show("notice", true, words.lost);
  }
}

// The printer shows one code at a time, and takes it from the browser that asked alone: from whoever knows the name that this one gave itself.
function ownName() {
  const name = localStorage.getItem("ask") || Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  localStorage.setItem("ask", name);
  return name;
}
// What it is called in the list of paired browsers.
function shownName() {
  const first = (names) => (names.find(([, pattern]) => pattern.test(navigator.userAgent)) || [""])[0];
  return [first([["Firefox", /Firefox|FxiOS/], ["Edge", /Edg/], ["Opera", /OPR/], ["Chrome", /Chrome|CriOS/], ["Safari", /Safari/]]),
          first([["Android", /Android/], ["iPhone", /iPhone/], ["iPad", /iPad/], ["Windows", /Windows/], ["Mac", /Macintosh/], ["Linux", /Linux/]])]
    .filter(Boolean).join(", ");
}
// Asks for the code on the printer's screen. Gives back whether this browser is paired now.
function pair() {
  const dialog = $("pair"), form = dialog.querySelector("form"), ask = ownName();
  return new Promise((done) => {
    const wrong = (reply) => show("pair-error", !reply.ok, reply.ok ? "" : refusal(reply));
    // Whoever has to wait for another browser's code asks again, which keeps the place.
    const askForCode = async () => {
      const reply = await post("/pair", {ask});
      if (!dialog.open) return;
      wrong(reply);
      const wait = reply.told && reply.told.values.wait_s;
      if (wait) setTimeout(() => { if (dialog.open) askForCode(); }, 1000 * Math.min(wait, 5));
    };
    form.onsubmit = async (event) => {
      event.preventDefault();
      const reply = await post("/pair", {code: $("code").value, ask, name: shownName()});
      wrong(reply);
      if (!reply.token) return;
      localStorage.setItem("token", reply.token);
      access.paired = true;
      dialog.close();
    };
    form.querySelector("button[type=button]").onclick = () => dialog.close();
    dialog.onclose = () => {
      if (!access.paired) post("/pair", {ask, stop: true}).catch(() => {});
      showBrowsers();
      done(access.paired);
    };
    $("code").value = "";
    dialog.showModal();
    askForCode().catch(() => {});
  });
}

// Browsers that may command the printer; a paired one may forget them.
async function showBrowsers() {
  const reply = access.page === "network" && access.paired ? await fetch("/browsers", {headers: {"Plumbline-Token": localStorage.getItem("token") || ""}}).catch(() => null) : null;
  $("browsers").hidden = !reply || !reply.ok;
  if ($("browsers").hidden) return;
  const {browsers} = await reply.json();
  const time = (value) => value ? new Date(value).toLocaleString(words.locale, {dateStyle: "short", timeStyle: "short"}) : words.timeUnknown;
  fill($("browsers").querySelector("ul"), browsers, () => browsers.map((one) => {
    const line = element("li"), text = element("span"), button = element("button", words.forget, {type: "button", class: "danger"});
    const name = `${one.name || words.browser} ${one.number}`;
    text.append(element("strong", one.this ? `${name} (${words.thisBrowser})` : name),
                element("div", `${words.pairedAt} ${time(one.paired_at)}, ${words.seenAt} ${time(one.seen_at)}`, {class: "pale"}));
    button.setAttribute("aria-label", `${words.forget}: ${name}`);
    button.onclick = () => {
      ask(words.forgetTitle, `${name} ${words.forgetText}`, words.keepPaired, words.forget, null);
      $("ask").onclose = () => { if ($("ask").returnValue === "yes") forget(one); };
    };
    line.append(text, button);
    return line;
  }));
}
async function forget(browser) {
  const reply = await post("/forget", {browser: browser.number}).catch(() => ({error: words.lost}));
  if (reply.error) show("notice", true, refusal(reply));
  else if (browser.this) access.paired = false;
  showBrowsers();
}

// Asks before it sends a command that can't be taken back.
let isOpenStill = () => true;  // whether what the open question is about is still there
function ask(title, text, no, yes, body, isThere) {
  isOpenStill = isThere;
  const dialog = $("ask"), [stay, go] = dialog.querySelectorAll("button");
  $("ask-title").textContent = title;
  $("ask-text").textContent = text;
  stay.textContent = no;
  go.textContent = yes;
  dialog.returnValue = "";
  dialog.onclose = () => { if (dialog.returnValue === "yes") command(body); };
  dialog.showModal();
}
const askAboutTank = () => ask(words.tankTitle, words.tankText, words.tankNo, words.tankYes, {do: "filled"}, () => true);
function askToCancel(about) {
  const isThere = () => (about === jobId() || about === state.asks) && state.commands.includes("cancel");
  ask(words.askTitle, words.askText, words.keep, words.end, {do: "cancel", ...about && {for: about}}, isThere);
}
function closeOldQuestion() {
  if (!$("ask").open || isOpenStill()) return;
  $("ask").returnValue = "";
  $("ask").close();
  show("notice", true, words.over);
}

// --- The parts of the page

const isRunning = () => ["checks", "homing", "printing", "pausing", "paused", "cover open", "cooling down", "feed me"].includes(state.state);

function buttonText(name) {
  if (name === "cancel") {
    return {offered: words.decline, slicing: words.stop, interrupted: words.giveUp}[state.state] || words.cancel;
  }
  if (name === "offer" && !state.stick.present) return words.offerUpload;
  return name === "start" && state.sliced ? words.again : name === "settings" ? words.back : words[name];
}
// A button is made anew with each question and keeps what it is for, so a click counts only for the question that was there when the pointer
// went down. And one of a person's two quick clicks on a button must not hit the next question's, which stands in the same place.
const settle = 1000;  // ms, as the printer's own buttons
let asked = "", askedAt = 0;
const jobId = () => state.job && state.job.id || null;
const answers = (name) => state.asks && name !== "pause";
const isTooSoon = (name) => sendings > 0 || Boolean(answers(name) || state.state === "slicing") && performance.now() < askedAt + settle;
function markButtons() {
  for (const button of $("buttons").children) button.setAttribute("aria-disabled", isTooSoon(button.dataset.do));
}
function showButtons() {
  const names = state.commands.filter((name) => !["choose", "set", "remove", "propose", "open"].includes(name));
  // No state lists it: the tank can be filled whenever nothing is printed.
  if (state.machine && ["idle", "offered", "interrupted", "plate in use", "paused", "feed me"].includes(state.state)) names.push("filled");
  const look = JSON.stringify([state.state, names.map(buttonText)]);
  if (look !== asked) {
    if (asked) askedAt = performance.now();
    asked = look;
    setTimeout(markButtons, settle + 10);
  }
  fill($("buttons"), [names, names.map(buttonText), state.asks, jobId()], () => names.map((name) => {
    const kind = name === "cancel" ? "danger" : ["pause", "filled", "settings"].includes(name) ? "" : "main";
    const button = element("button", buttonText(name), {class: kind, "data-do": name});
    const asks = name === "cancel" && (isRunning() || state.state === "interrupted");
    const about = name === "offer" ? null : answers(name) && !(name === "cancel" && isRunning()) ? state.asks : jobId();
    button.onclick = () => {
      if (isTooSoon(name)) return show("notice", true, words.tooSoon);
      return asks ? askToCancel(about) : name === "filled" ? askAboutTank() : command({do: name, ...about && {for: about}});
    };
    return button;
  }));
  markButtons();
}
function showFacts() {
  const rows = [];
  const {progress, sliced, job, resin, slicing} = state;
  if (slicing) rows.push([words.step, words.steps[slicing.stage] || slicing.stage]);
  if (job) rows.push([words.scan, job.files.length > 1 ? job.files.join(", ") : job.scan], [words.profile, job.profile]);
  if (sliced) {
    const sides = [sliced.width_mm, sliced.depth_mm, sliced.height_mm].map((side) => number(side, 1)).join(" × ");
    const steps = sliced.layer_runs.map(([, step]) => number(step * sliced.layer_height_mm, 3)).sort();
    const high = steps.length ? `, ${steps[0]}–${steps.at(-1)} mm` : ` × ${number(sliced.layer_height_mm, 3)} mm`;
    rows.push([words.size, `${sides} mm`], [words.layers, `${sliced.layers}${high}`]);
    if (sliced.points_off_percent >= 0.1) rows.push([words.pointsOff, `${number(sliced.points_off_percent, 1)} %`]);
    const vanish = sliced.shows_grey ? "" : `, ${number(sliced.grey_lost_percent, 1)} % ${words.vanish}`;
    if (sliced.grey_percent) rows.push([words.grey, `${number(sliced.grey_percent, 1)} %${vanish}`]);
    if (!progress) rows.push([words.time, duration(sliced.time_s)], [words.resin, `${number(sliced.resin_ml, 1)} ml`]);
  }
  if (progress) {
    rows.push([words.layer, `${Math.min(progress.layers_done + 1, progress.layers)} ${words.of} ${progress.layers}`],
              [words.height, `${number(progress.height_mm, 2)} mm`], [words.elapsed, duration(progress.elapsed_s)]);
    if (["checks", "homing", "printing"].includes(state.state)) {
      // By this browser's clock: the printer's may never have been set.
      rows.push([words.ends, new Date(Date.now() + 1000 * progress.left_s).toLocaleString(words.locale, {dateStyle: "short", timeStyle: "short"})]);
    }
    if (resin) {
      rows.push([words.resin, `${number(resin.used_ml, 1)} ml ${words.used}, ${number(resin.needed_ml, 1)} ml ${words.needed}, ` +
                              `${number(resin.tank_ml, 0)} ml ${words.tank}`]);
    }
    if (progress.slack_s !== null) rows.push([words.slack, `${number(progress.slack_s, 1)} s ${words.before}`]);
  }
  if (state.machine) {
    const left = state.machine.resin_ml;
    rows.push([words.resinLeft, left === null ? words.resinUnknown : `${number(left, 1)} ml`]);
  }
  const warm = Object.entries(state.temperatures_c || {}).filter(([, degrees]) => degrees !== null);
  if (warm.length && !slicing) rows.push([words.temperatures, warm.map(([what, degrees]) => `${words.warm[what]} ${number(degrees, 0)} °C`).join(", ")]);
  if (state.address && !isRunning()) rows.push([words.address, state.address]);
  fill($("facts"), rows, () => rows.flatMap(([name, value]) => [element("dt", name), element("dd", value)]));
}
function showNow() {
  const offersSliced = state.state === "offered" && state.sliced;
  const offersUpload = state.state === "offered" && state.stick.uploaded;
  const proposes = Boolean(state.slicing && state.slicing.proposes);
  const pauses = Boolean(state.message_told && state.message_told.code === "pause_taken");
  show("title", true, pauses ? words.pausing : proposes ? words.proposing : offersSliced ? words.sliced : offersUpload ? words.offeredUpload : words[state.state] || state.state);
  let hint = words.hints[state.state] || "";
  if (state.state === "idle" && state.stick.present) hint = words.hints.stick;
  else if (state.state === "idle" && state.commands.includes("offer")) hint = words.hints.kept;
  else if (state.state === "idle" && state.upload_limit) hint = words.hints.idleUpload;
  if (state.state === "slicing" && state.stick.uploaded) hint = words.hints.wait;
  if (state.state === "offered") hint = offersSliced ? words.hints.sliced : state.stick.job_file ? words.hints.job : words.hints.offered;
  show("hint", hint !== "", hint);
  show("question", Boolean(state.question), worded(state.question_told, state.question || ""));
  show("answers", Boolean(state.question) && state.commands.includes("resume"), words.answers);  // the printer speaks of its own buttons
  // A message without a code says what title, hint and facts say, too.
  const message = state.message_told && (language === "en" || inWords(state.message_told)) ? worded(state.message_told, state.message || "") : "";
  show("message", message !== "" && !state.fault, message);
  const fault = state.fault;
  $("fault").hidden = !fault;
  if (fault) {
    const known = language !== "en" && said.faults[fault.code], texts = inWords(fault.told);
    show("fault-title", true, `${fault.code}: ${known ? known.title : fault.title}`);
    const told = texts ? texts[0] : known ? "" : fault.message || "";
    show("fault-told", told !== "", told);
    show("fault-meaning", true, known ? known.meaning : fault.meaning);
    show("fault-remedy", true, texts && texts[1] || (known ? known.remedy : fault.remedy));
    $("fault-mend").hidden = !(fault.told && ["too_wide", "too_deep", "too_high"].includes(fault.told.code) && (state.stick.present || state.stored));
    // It has the file's own words and places, which no table has.
    show("fault-wording", Boolean(known && fault.message), `${words.wording}: ${fault.message}`);
  }
  const progress = state.progress;
  const done = state.slicing ? state.slicing.whole : progress && progress.layers ? progress.layers_done / progress.layers : null;
  $("progress").hidden = done === null;
  if (done !== null) {
    $("progress").value = done;
    $("progress").textContent = `${Math.round(100 * done)} %`;
  }
  const waits = progress && (isRunning() || state.state === "interrupted");
  // Between two states the time goes on. That of a simulated printer may run faster.
  const left = progress && Math.max(0, progress.left_s - (progress.ends_at && !state.simulated ? (performance.now() - tookAt) / 1000 : 0));
  show("left", Boolean(waits), waits ? `${Math.floor(100 * done)} % · ${words.locale === "de-DE" ? `${words.left} ${duration(left)}` : `${duration(left)} ${words.left}`}` : "");
}
// What does not fit is offered again, fitted to the plate, and sliced.
async function until(holds) {
  for (let waited = 0; waited < 100 && !holds(); ++waited) await new Promise((go) => setTimeout(go, 100));
}
$("fault-mend").firstElementChild.onclick = async () => {
  await command({do: "seen", ...state.asks && {for: state.asks}});
  await until(() => state.state !== "fault");
  if (state.commands.includes("offer")) await command({do: "offer"});
  await until(() => state.state === "offered");
  await command({do: "set", key: "fit", value: "true", ...jobId() && {for: jobId()}});
  if (state.job && state.job.fit) await command({do: "start", ...state.asks && {for: state.asks}});
};
// Numbers begin again when the printer's software does. With the job's id no picture is taken for that of another one.
const ofJob = () => jobId() ? `job=${jobId()}&` : "";
function showPictures() {
  const there = Object.entries(state.pictures || {}).filter(([name, value]) => value !== null && name !== "part" && name !== "proposal" && (name !== "layer" || isRunning()) && !(view && state.pictures.part && ["preview", "issues"].includes(name)));
  $("pictures").hidden = there.length === 0;
  const names = there.map(([name]) => name);
  fill($("pictures"), names, () => [$("pictures").firstElementChild, ...names.map((name) => {
    const figure = element("figure"), caption = name === "layer" ? words.layerPicture : words[name] || name;
    figure.append(element("img", undefined, {alt: caption, id: `picture-${name}`}), element("figcaption", caption));
    return figure;
  })]);
  for (const [name, value] of there) {
    const address = `/picture/${name}?${ofJob()}n=${value}`, img = $(`picture-${name}`);
    if (img.getAttribute("src") !== address) img.src = address;
  }
}

// The part in 3D (part.js). Where a browser has no WebGL 2 the preview stays.
const view = makePartView($("view"), (text) => {
  show("loading", text !== "", text === null ? words.noModel : `${words.modelComes} ${text}`);
  if (text !== "") return;
  showPart();
  if (!$("layers").hidden) layerView.fit(view.box.map((ends, axis) => ends.map((mm) => mm / state.sliced.mask_pixel_mm[axis])));
});
for (const [id, yaw, pitch] of [["from-front", 0, 0], ["from-left", -Math.PI / 2, 0], ["from-above", 0, Math.PI / 2]]) $(id).onclick = () => view.look(yaw, pitch);
const boxIn = (id) => $(id).querySelector("input");
boxIn("with-supports").onchange = () => view.supports(boxIn("with-supports").checked);
boxIn("with-colours").onchange = () => {
  view.colours(boxIn("with-colours").checked);
  $("legend").hidden = !boxIn("with-colours").checked;
};
function showPart() {
  const of = view && state.pictures && state.pictures.part ? `/part?${ofJob()}of=${state.pictures.part}` : null;
  $("part").hidden = of === null;
  if (!view) return;
  view.show(of);
  $("with-supports").hidden = !view.hasSupports;
  $("with-colours").hidden = !view.hasEvidence;
}

// mm of so many layers. Runs of an adaptive print are [end, height].
function topOf(layers) {
  let sum = 0, from = 0;
  for (const [end, step] of state.sliced.layer_runs) {
    sum += Math.max(0, Math.min(layers, end) - from) * step;
    from = end;
  }
  return (sum + Math.max(0, layers - from)) * state.sliced.layer_height_mm;
}
// The layer, from 1, at a height above the plate.
function layerAt(mm) {
  let [low, high] = [1, state.sliced.layers];
  while (low < high) {
    const between = Math.floor((low + high) / 2);
    if (topOf(between) > mm + 1e-6) high = between;
    else low = between + 1;
  }
  return low;
}
const layerView = makeLayerView($("mask"), (n, x, y, step) => `/mask?${ofJob()}n=${n}&x=${x}&y=${y}&step=${step}`,
                                (shown) => show("mask-error", !shown, words.noMask), (place) => tapOn(place));
function showLayer(cuts) {
  const layer = Number($("layer").value);
  $("which").textContent = `${words.layer} ${layer} ${words.of} ${$("layer").max}, ${number(topOf(layer), 2)} mm`;
  layerView.show(layer - 1);
  if (view) view.plane(cuts && layer < state.sliced.layers ? topOf(layer) : null);
}
let layersOf = null;
$("layer").oninput = () => showLayer(true);
boxIn("with-ghost").onchange = () => layerView.ghost(boxIn("with-ghost").checked);
// Supports by hand: a tap on the mask is a place of the print, which becomes one of the job's lists. The printer then slices anew.
const lists = {support_at: words.supportsAdded, no_support_at: words.supportsBlocked};
const listOf = (key) => state.job && state.job.support_values[key] || [];
const inMm = ([x, y, z, radius]) => `x ${number(x, 1)}, y ${number(y, 1)}, z ${number(z, 2)} mm${radius ? ` (r ${number(radius, 1)} mm)` : ""}`;
let tapped = null;
function setPlaces(key, places) {
  tapped = null;
  command({do: "set", key, value: places.map((place) => place.map((mm) => Math.round(mm * 100) / 100).join(",")).join(";"), ...jobId() && {for: jobId()}});
}
function tapOn([column, row]) {
  if ($("by-hand").hidden) return;
  // The middle of a pixel, at the underside of the layer.
  const [width, depth] = state.sliced.mask_pixel_mm;
  tapped = [(Math.floor(column) + 0.5) * width, (Math.floor(row) + 0.5) * depth, topOf(Number($("layer").value) - 1)];
  showByHand();
}
$("support-here").onclick = () => setPlaces("support_at", [...listOf("support_at"), tapped]);
$("no-support-here").onclick = () => setPlaces("no_support_at", [...listOf("no_support_at"), tapped]);
function showByHand() {
  const may = state.state === "offered" && state.commands.includes("set") && Boolean(state.job) && state.sliced && !state.sliced.values.some(({source}) => source === "archive");
  $("by-hand").hidden = !may;
  if (!may) return;
  show("tapped", Boolean(tapped), tapped ? inMm(tapped) : "");
  $("support-here").hidden = $("no-support-here").hidden = !tapped;
  const kept = Object.entries(lists).filter(([key]) => listOf(key).length);
  fill($("kept-places"), [kept.map(([key]) => listOf(key)), jobId()], () => kept.map(([key, name]) => {
    const line = element("p", `${name}: ${listOf(key).map(inMm).join("; ")} `), clear = element("button", words.clearPlaces, {type: "button"});
    clear.onclick = () => setPlaces(key, []);
    line.append(clear);
    return line;
  }));
}
function showMasks() {
  const shown = Boolean(state.masks && state.sliced);
  const of = shown ? jobId() || "" : null;
  $("layers").hidden = !shown;
  if (of === layersOf) return;
  // Nothing of another job stays, nor may what is on its way come in its place.
  layersOf = of;
  tapped = null;
  show("mask-error", false);
  if (!shown) return;
  layerView.begin(state.sliced.mask_pixels);
  $("layer").max = state.sliced.layers;
  $("layer").value = Math.ceil(state.sliced.layers / 2);
  showLayer(false);
}
function showStick() {
  const {scans, folder, folders, not_listed: notListed} = state.stick;
  $("stick").hidden = scans.length === 0 || isRunning() || Boolean(state.sliced && state.state === "offered");
  $("stick").querySelector("h2").textContent = state.stick.uploaded ? words.uploadedTitle : folder ? `${words.stickTitle}: ${folder}` : words.stickTitle;
  const mayChoose = state.commands.includes("choose") && !state.sliced;
  const chosen = state.job ? state.job.number : null;
  const unpictured = scans.map(({picture, ...scan}) => scan);
  fill($("scans"), [unpictured, mayChoose, chosen, Boolean(said)], () => scans.map((scan) => {
    const line = element("li");
    const button = element("button", undefined, {"aria-pressed": scan.number === chosen});
    button.disabled = !mayChoose;
    const name = scan.files > 1 ? `${scan.files} ${words.asOne}: ${scan.name}, …` : scan.name;
    button.append(element("img", undefined, {alt: words.scanPicture}), element("span", name), element("span", size(scan.bytes), {class: "pale"}));
    button.onclick = () => command({do: "choose", scan: scan.number, ...state.asks && {for: state.asks}});
    line.append(button);
    if (scan.problem) line.append(element("p", worded(scan.told, scan.problem), {class: "problem"}));
    return line;
  }));
  // Pictures come one by one: a line that somebody is on stays.
  scans.forEach((scan, i) => {
    const image = $("scans").children[i].querySelector("img");
    image.hidden = !scan.picture;
    const address = `/scan.png?n=${scan.number}&of=${scan.picture}`;
    if (scan.picture && image.getAttribute("src") !== address) image.src = address;
  });
  const mayOpen = state.commands.includes("open");
  fill($("folders"), [folders, folder, mayOpen, Boolean(said)], () => [...folder ? [{number: 0, name: words.folderUp}] : [], ...folders].map((one) => {
    const line = element("li");
    const button = element("button");
    button.disabled = !mayOpen;
    button.append(element("span", one.number ? `${one.name}/` : one.name), element("span", one.number ? `${one.entries} ${words.inside}` : "", {class: "pale"}));
    button.onclick = () => command({do: "open", folder: one.number, ...state.asks && {for: state.asks}});
    line.append(button);
    return line;
  }));
  show("left-out", Boolean(notListed), notListed && worded(state.stick.not_listed_told, notListed));
}

// A scan from this device into the printer's store. The printer is asked first, since a browser that is refused while it sends a long file may
// not see why.
let sending = null;  // {abort, number, refused} while this browser sends one
let sent = 0;        // number of the last one
let others = "";     // what is said of one that another browser sends
const fileName = (name) => {
  const plain = name.normalize("NFKD").replace(/[\u0300-\u036f]/g, "").replaceAll("ß", "ss").replace(/[^A-Za-z0-9 ._()+-]/g, "_").replace(/^[ .-]+/, "");
  const dot = plain.lastIndexOf(".");
  return dot < 0 || plain.length < 80 ? plain.slice(0, 79) : plain.slice(0, 79 - plain.length + dot) + plain.slice(dot);
};
const sayUpload = (status, error = "") => {
  show("upload-status", true, status);
  show("upload-error", error !== "", error);
};
async function askForUpload(file) {
  if (!access.paired) await lookAtAccess();
  if (!access.paired && !await pair()) return null;
  const reply = await post("/upload", {do: "upload", name: fileName(file.name), bytes: file.size});
  if (reply.status !== 401) return reply;
  access.paired = false;
  return askForUpload(file);
}
async function upload(file) {
  if (file.size === 0) return sayUpload("", words.emptyFile);
  if (state.upload_limit && file.size > state.upload_limit) return sayUpload("", `${words.tooLarge} ${size(state.upload_limit)}.`);
  sending = {abort: new AbortController(), number: 0, refused: false};
  sayUpload(`${words.uploading}: ${file.name}`);
  showUpload();
  let problem = null;
  try {
    const asked = await askForUpload(file);
    if (asked && asked.ok) {
      sent = sending.number = asked.upload;
      const headers = {"Content-Type": "application/octet-stream", "Plumbline-Token": localStorage.getItem("token") || ""};
      const reply = await fetch(`/upload/body?n=${asked.upload}`, {method: "POST", headers, body: file, signal: sending.abort.signal});
      const answer = await reply.json();
      problem = answer.ok ? "" : answer.error ? refusal(answer) : words.uploadFailed;
    } else {
      problem = asked ? refusal(asked) : words.uploadStopped;
    }
  } catch {
    const told = state && state.upload && state.upload.number === sending.number ? worded(state.upload.told, state.upload.problem) : null;
    problem = sending.abort.signal.aborted && !sending.refused ? words.uploadStopped : told || words.uploadFailed;
  }
  sending = null;
  sayUpload(problem === "" ? `${words.uploaded}: ${file.name}` : "", problem);
  if (problem === "") $("send").reset();
  showUpload();
}
function showUpload() {
  const coming = state.upload && state.upload.stage === "coming" ? state.upload : null;
  const stored = state.stored;
  $("upload").hidden = !(state.upload_limit || coming || sending || state.commands.includes("remove"));
  $("send").hidden = !(state.upload_limit || coming || sending);
  if ($("upload").hidden) sayUpload("");  // what is said of the last one is old when the section comes back
  $("stored").hidden = !stored;
  if (stored) {
    const text = `${words.stored}: ${stored.name}, ${size(stored.bytes)}`;
    if ($("stored").firstElementChild.textContent !== text) $("stored").firstElementChild.textContent = text;
    $("stored").lastElementChild.disabled = !state.commands.includes("remove");
  }
  $("file").disabled = $("send").querySelector("button").disabled = Boolean(sending || coming);
  $("stop-upload").hidden = !sending;
  $("sent").hidden = !(coming || sending);
  $("sent").value = coming && coming.bytes ? coming.received / coming.bytes : 0;
  $("sent").textContent = `${Math.round(100 * $("sent").value)} %`;
  const other = coming && !sending && coming.number !== sent ? `${words.uploading}: ${coming.name}` : "";
  if (other !== others) sayUpload(other);
  others = other;
  // The printer has ended it, so the rest of the file need not be sent.
  if (sending && state.upload && state.upload.number === sending.number && state.upload.stage === "failed") {
    sending.refused = true;
    sending.abort.abort();
  }
}
$("send").onsubmit = (event) => {
  event.preventDefault();
  if ($("file").files.length && !sending) upload($("file").files[0]);
};
$("stored").lastElementChild.onclick = () => {
  const {name} = state.stored;
  ask(words.removeTitle, `${name} ${words.removeText}`, words.keepStored, words.remove, {do: "remove", name},
      () => state.stored && state.stored.name === name);
};
$("stop-upload").onclick = () => { if (sending) sending.abort.abort(); };

function size(bytes) {
  if (bytes < 1000) return `${bytes} ${words.bytes}`;
  return bytes < 1e6 ? `${number(bytes / 1e3, 1)} kB` : `${number(bytes / 1e6, 1)} MB`;
}

// Settings: name, label, kind, the printer's value, and what to send for what was entered.
const heights = () => [["", words.ofProfile], ...[0.025, 0.03, 0.05, 0.1].map((mm) => [String(mm), `${number(mm, 3)} mm`]), ["adaptive", words.adaptive]];
const settings = [
  ["profile", words.profile, () => state.profiles.map((name) => [name, name]), (job) => job.profile, (value) => ["profile", value]],
  ["height", words.heightMm, "number", (job) => job.size && job.size.side === "height" ? job.size.mm : "",
   (value) => value ? ["height", `${value}mm`] : ["scale", "1"]],
  ["units", words.units, () => ["mm", "cm", "m", "in", "auto"].map((unit) => [unit, unit === "auto" ? words.unitAuto : unit]), (job) => job.units, (value) => ["units", value]],
  ["scale", words.scale, "number", (job) => job.size || job.fit ? "" : job.scale, (value) => ["scale", value || "1"]],
  ["fit", words.fit, () => [["false", words.no], ["true", words.yes]], (job) => job.fit, (value) => ["fit", value]],
  ...["z", "x", "y"].map((axis) => [`rotate_${axis}_deg`, `${axis === "z" ? words.turn : words.tilt} (${axis})`, "number", (job) => job[`rotate_${axis}_deg`],
                                    (value) => [`rotate_${axis}_deg`, value || "0"]]),
  ["supports", words.supports, () => [["", words.ofProfile], ["auto", words.auto], ["none", words.none]], (job) => job.supports || "",
   (value) => ["supports", value]],
  ["layer_height", words.layerHeight, heights, (job) => job.layer_height || "", (value) => ["layer_height", value]],
];
function makeSettings() {
  const parts = [];
  for (const [name, label, kind, , toSend] of settings) {
    const id = `set-${name}`, isList = typeof kind === "function";
    const input = element(isList ? "select" : "input", undefined, {id});
    if (!isList) input.type = kind;
    if (kind === "number") Object.assign(input, name.startsWith("rotate") ? {min: -360, max: 360, step: 15} : {min: 0, step: "any"});
    input.onchange = () => {
      const [key, value] = toSend(input.value);
      command({do: "set", key, value, ...jobId() && {for: jobId()}});
    };
    const line = element("div");
    line.append(element("label", label, {for: id}), input);
    parts.push(line);
  }
  return parts;
}
$("reset").onclick = () => command({do: "set", key: "reset", value: "", ...jobId() && {for: jobId()}});
function showSettings() {
  const shown = state.commands.includes("set") && Boolean(state.job) && !state.sliced;
  $("settings").hidden = !shown;
  if (!shown) return;
  fill($("form"), 1, makeSettings);
  for (const [name, , kind, ofJob] of settings) {
    const input = $(`set-${name}`), value = ofJob(state.job);
    if (typeof kind === "function") {
      const choices = kind(value);
      if (!choices.some(([choice]) => choice === String(value))) choices.push([String(value), String(value)]);
      fill(input, choices, () => choices.map(([choice, text]) => element("option", text, {value: choice})));
    }
    input.parentElement.hidden = name !== "profile" && !state.commands.includes("propose");  // an archive stands as it was sliced
    if (document.activeElement === input && kind === "number") continue;  // somebody is typing
    if (input.value !== String(value)) input.value = value;
  }
}
// What will be done, each value with who has said it. While the printer asks, those that need no new layers may be changed.
function showContract() {
  $("contract").hidden = !state.sliced;
  if (!state.sliced) return;
  const {values} = state.sliced, mayChange = state.state === "offered" && state.commands.includes("set");
  show("contract-hint", mayChange, words.contractHint);
  fill($("values"), [values.map(({key, source}) => [key, source]), mayChange, Boolean(said)], () => values.map(({key, unit, source, can_change: canChange}) => {
    const row = element("tr", undefined, {class: source}), cell = element("td"), id = `value-${key}`;
    if (canChange && mayChange) {
      const input = element("input", undefined, {id, type: "number", step: "any", min: 0});
      input.onchange = () => command({do: "set", key, value: input.value, ...jobId() && {for: jobId()}});
      cell.append(input);
    } else {
      cell.append(element("span", undefined, {id}));
    }
    cell.append(` ${unit}`);
    const name = said.fields[key];
    const head = element("th", undefined, {scope: "row"});
    head.append(canChange && mayChange ? element("label", name, {for: id}) : name);
    row.append(head, cell, element("td", said.sources[source]));
    return row;
  }));
  for (const {key, value} of values) {
    const node = $(`value-${key}`);
    if (node.tagName === "SPAN") node.textContent = value.toLocaleString(words.locale, {maximumFractionDigits: 3});
    else if (document.activeElement !== node && node.value !== String(value)) node.value = value;
  }
}
// The best ways up, each with a picture and what it costs, beside the scan as it lies. The printer looks for them when somebody asks.
function showWays() {
  const proposals = state.proposals || [], of = state.pictures && state.pictures.proposal, chosen = state.job ? state.job.proposal : null;
  $("ways").hidden = !state.commands.includes("propose");
  $("propose").hidden = proposals.length > 0;
  show("ways-hint", true, proposals.length ? words.waysLegend : words.waysHint);
  fill($("proposals"), [proposals, of, jobId()], () => proposals.map((way) => {
    const line = element("li"), button = element("button", undefined, {type: "button", "data-proposal": way.number});
    const name = way.number ? `${words.way} ${way.number}` : words.unturned;
    if (of) button.append(element("img", undefined, {src: `/proposal?${ofJob()}n=${way.number}&of=${of}`, alt: words.front}));
    button.append(element("strong", name));
    for (const text of [`${words.overhang} ${number(way.support_ml, 1)} ml, ${number(way.support_mm2 / 100, 1)} cm²`,
                        `${words.height} ${number(way.height_mm, 1)} mm`, `${words.largestLayer} ${number(way.peel_mm2 / 100, 1)} cm²`]) {
      button.append(element("span", text));
    }
    button.onclick = () => command({do: "set", key: "proposal", value: way.number, ...state.asks && {for: state.asks}});
    line.append(button);
    return line;
  }));
  for (const button of $("proposals").querySelectorAll("button")) {
    button.setAttribute("aria-pressed", Number(button.dataset.proposal) === chosen);
  }
}
$("propose").onclick = () => command({do: "propose", ...jobId() && {for: jobId()}});
// What was found: what it is, where, and what mends it, as buttons.
let placeAt = -1;
const placesFound = () => state.masks && state.sliced ? state.findings.flatMap((one) => one.places_mm.map((mm) => ({mm, one}))) : [];
function showPlace(which) {
  const places = placesFound();
  if (!places.length) return;
  placeAt = (which + places.length) % places.length;
  const [x, y, z] = places[placeAt].mm, [width, depth] = state.sliced.mask_pixel_mm;
  $("layer").value = layerAt(z);
  showLayer(true);
  layerView.lookAt(x / width, y / depth);
  $(view ? "part" : "layers").scrollIntoView({block: "nearest"});
}
$("place-before").onclick = () => showPlace(placeAt - 1);
$("place-next").onclick = () => showPlace(placeAt + 1);
// "Add supports", "It is in cm", "Make the height 40.15 mm".
function mendText(key, value) {
  const said = words[`mend_${key}`];
  if (key === "units") return `${said} ${value === "in" ? words.inches : value}`;
  return value.endsWith("mm") ? `${said} ${number(parseFloat(value), 2)} mm` : said;
}
function showFindings() {
  const places = placesFound(), mends = state.state === "offered" && Boolean(state.sliced) && state.commands.includes("set");
  $("findings").hidden = state.findings.length === 0;
  fill($("findings").querySelector("ul"), [state.findings, mends, places.length > 0, jobId()], () => {
    placeAt = -1;
    return state.findings.map((one) => {
      const line = element("li", worded(one.told, one.text), {class: one.severity}), buttons = element("div");
      const first = places.findIndex((place) => place.one === one);
      if (first >= 0) {
        const where = element("button", one.places_mm.length > 1 ? `${words.showPlace} (${one.places_mm.length})` : words.showPlace, {type: "button"});
        where.onclick = () => showPlace(first);
        buttons.append(where);
      }
      for (const {key, value} of mends ? one.remedies : []) {
        const mend = element("button", mendText(key, value), {type: "button", class: "main", "data-key": key});
        mend.onclick = () => command({do: "set", key, value, ...jobId() && {for: jobId()}});
        buttons.append(mend);
      }
      if (buttons.children.length) line.append(buttons);
      return line;
    });
  });
  $("places").hidden = places.length < 2;
  fill($("marks"), [places.map(({mm}) => mm), jobId()], () => {
    const [width, depth] = state.sliced ? state.sliced.mask_pixel_mm : [1, 1];
    layerView.marks(places.map(({mm: [x, y, z]}) => ({x: x / width, y: y / depth, layer: layerAt(z) - 1})));
    const marks = places.map(({mm, one}, i) => {
      const node = element("button", undefined, {type: "button", class: "mark", "aria-label": `${i + 1}: ${worded(one.told, one.text)}`});
      node.append(element("span", String(i + 1)));
      node.onclick = () => showPlace(i);
      return {at: mm, node};
    });
    if (view) view.marks(marks);
    return marks.map(({node}) => node);
  });
}
function showLists() {
  const checks = state.checks.map((one) => [one.outcome, `${words.checkNames[one.check] || one.check}: ${worded(one.told, one.detail)}`]);
  $("checks").hidden = checks.length === 0;
  fill($("checks").querySelector("ul"), checks, () => checks.map(([kind, text]) => element("li", text, {class: kind})));
  $("report").hidden = !state.report;
}
// The last prints, which the printer gives out only while it is at rest: as it does with the last one's report.
let wantsAgain = null;  // the scan that somebody wants once more, until what is on the stick is offered
function printAgain(scan) {
  wantsAgain = scan;
  if (state.commands.includes("offer")) return command({do: "offer"});
  return chooseAgain();
}
function chooseAgain() {
  if (!wantsAgain || state.state !== "offered" || state.sliced) return;
  const scan = state.stick.scans.find(({name}) => name === wantsAgain);
  show("notice", !scan, `${wantsAgain}: ${words.notThere}`);
  wantsAgain = null;
  if (scan && state.commands.includes("choose")) command({do: "choose", scan: scan.number, ...state.asks && {for: state.asks}});
  if (scan) $("now").scrollIntoView();
}
function showPrints() {
  chooseAgain();
  $("prints").hidden = !state.report || state.prints.length === 0;
  if ($("prints").hidden) return;
  fill($("prints").querySelector("ul"), state.prints, () => state.prints.map((print) => {
    const line = element("li"), ended = print.ended_at ? new Date(print.ended_at).toLocaleString(words.locale) : "";
    if (print.preview) line.append(element("img", undefined, {src: `/print.png?n=${print.number}&of=${print.ended_at}`, alt: words.preview, loading: "lazy"}));
    const name = element("strong", print.scan);
    const facts = `${words[print.result] || print.result} · ${words.layers} ${print.layers_done} ${words.of} ${print.layers} · ` +
      `${number(print.resin_ml, 1)} ml${ended && ` · ${ended}`}`;
    const link = element("a", words.downloadOf, {href: `/report.json?n=${print.number}`, download: `print-${print.number}.json`});
    link.setAttribute("aria-label", `${words.downloadOf}: ${print.scan}, ${ended}`);
    const again = element("button", words.printAgain, {type: "button", "data-scan": print.scan});
    again.setAttribute("aria-label", `${words.printAgain}: ${print.scan}`);
    again.onclick = () => printAgain(print.scan);
    line.append(name, element("div", facts), link, again);
    return line;
  }));
  const may = state.commands.includes("offer") || (state.state === "offered" && !state.sliced);
  for (const button of $("prints").querySelectorAll("button")) button.hidden = !may;
}

function render() {
  document.title = `${words[state.state] || state.state} · ${state.printer}`;
  show("printer", true, state.printer);
  show("simulated", state.simulated, words.simulated);
  document.body.dataset.state = state.state;
  closeOldQuestion();
  for (const part of [showNow, showButtons, showFacts, showPictures, showPart, showMasks, showByHand, showContract, showStick, showUpload, showSettings, showWays, showFindings, showLists, showPrints]) part();
}

// --- From the printer

function listen() {
  const events = new EventSource("/events");
  events.onmessage = (event) => {
    show("crowded", false);
    take(JSON.parse(event.data));
  };
  events.addEventListener("lost", () => lose(words.noDaemon));
  events.addEventListener("hangs", () => lose(words.hangs));
  events.onerror = () => {
    if (events.readyState === EventSource.CLOSED) return lookNowAndThen(10);
    lose(words.lost);
  };
}
let tookAt = 0;
function take(next) {
  state = next;
  tookAt = performance.now();
  show("lost", false);
  $("now").inert = false;
  render();
  stateCame();
}
function lose(text) {
  show("lost", true, text);
  $("now").inert = true;
}
// The printer tells a few pages at a time what it does. One more asks every two seconds, and now and then whether there is room for it.
async function lookNowAndThen(times) {
  try {
    const reply = await fetch("/state");
    if (!reply.ok) throw new Error("no state");
    take(await reply.json());
    show("crowded", true, words.crowded);
  } catch {
    lose(words.lost);
  }
  setTimeout(() => times > 1 ? lookNowAndThen(times - 1) : listen(), 2000);
}

function sayWords() {
  document.documentElement.lang = words.locale.slice(0, 2);
  const put = (selector, text) => { document.querySelector(selector).textContent = text; };
  for (const [id, text] of Object.entries({pictures: words.pictures, part: words.partTitle, layers: words.masks, contract: words.contract, stick: words.stickTitle, settings: words.settings, ways: words.waysTitle,
                                           findings: words.findings, checks: words.checksTitle, upload: words.uploadTitle, report: words.report,
                                           prints: words.printsTitle, browsers: words.browsersTitle})) put(`#${id} h2`, text);
  put("#report a", words.download);
  put("#fault-do", words.doThis);
  put("#pair-title", words.pairTitle);
  put("#pair label", words.pairLabel);
  put("#pair button.main", words.pair);
  put("#pair button[type=button]", words.close);
  put("#layers label", words.layer);
  put("#by-hand-hint", words.byHandHint);
  put("#support-here", words.supportHere);
  put("#no-support-here", words.noSupportHere);
  for (const [id, text] of [["from-front", words.fromFront], ["from-left", words.fromLeft], ["from-above", words.fromAbove], ["with-supports span", words.supports],
                            ["with-colours span", words.withColours], ["view-hint", words.viewHint]]) put(`#${id}`, text);
  $("view").setAttribute("aria-label", `${words.partTitle}. ${words.viewKeys}`);
  $("legend").append(...["scanned", "closed", "underside"].map((name) => element("li", words[name], {class: name})));
  put("#propose", words.propose);
  put("#send label", words.uploadLabel);
  put("#send button.main", words.uploadDo);
  put("#stop-upload", words.uploadStop);
  put("#stored button", words.remove);
  $("sent").setAttribute("aria-label", words.uploading);
  for (const [id, text] of [["with-ghost span", words.withGhost], ["fault-mend button", words.mend_fit], ["reset", words.reset], ["mask-hint", words.maskHint], ["place-before", words.placeBefore], ["place-next", words.placeNext]]) put(`#${id}`, text);
  $("mask").setAttribute("aria-label", words.masksAlt);
  $("language").setAttribute("aria-label", words.language);
  $("language").append(...Object.keys(texts).map((code) => element("option", texts[code].ownName, {value: code})));
  $("language").value = language;
  $("language").onchange = () => {
    localStorage.setItem("language", $("language").value);
    location.reload();
  };
  $("progress").setAttribute("aria-label", words.printing);
}

setInterval(() => { if (state && state.progress && state.progress.ends_at && !state.simulated) showNow(); }, 1000);
sayWords();
lookAtAccess().catch(() => {});
listen();
