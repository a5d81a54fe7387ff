"use strict";
// What programs print is put in as text, never as HTML.
const one = (selector, within = document) => within.querySelector(selector);
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const base = one("nav").dataset.base, here = location.pathname.slice(base.length);
function make(kind, text = "", more = {}) {
  return Object.assign(document.createElement(kind), { textContent: text, ...more });
}
async function ask(what, wish, signal) {
  const headers = { "Content-Type": "application/json" };
  const answer = await fetch(base + what, { method: "POST", headers, body: JSON.stringify(wish), signal });
  if (!answer.ok) throw new Error(await answer.text());
  return answer;
}

// ---- One run at a time: its lines as they come, until it ends, or the page or its Stop ends it ----

let running = null;
async function run(place, what, wish) {
  running?.abort();
  const stop = running = new AbortController();
  one(".output", place)?.remove();
  const output = make("div", "", { className: "output" }), columns = make("div", "", { className: "columns" });
  const verdict = make("p", "", { className: "verdict" }), button = make("button", "Stop");
  verdict.setAttribute("role", "status");
  button.onclick = () => stop.abort();
  output.append(button, columns, verdict);
  place.append(output);
  const column = name => {
    let found = all("pre", columns).find(each => each.dataset.who === name);
    if (!found) {
      found = make("pre");
      found.dataset.who = name;
      const whole = make("div");
      whole.append(make("b", name), found);
      if (name === "server") columns.prepend(whole); else columns.append(whole);
    }
    return found;
  };
  const hear = news => {
    if (news.begins === "client") column("client").textContent = "";
    if (news.who) {
      const shown = column(news.who), below = shown.scrollTop + shown.clientHeight > shown.scrollHeight - 30;
      shown.append(`${news.text}\n`);
      if (below) shown.scrollTop = shown.scrollHeight;
    }
    if (news.page) output.append(make("iframe", "", { src: news.page, title: "The messages, as arrows" }));
    if (news.verdict) verdict.textContent = news.verdict;
    verdict.classList.toggle("good", ["as on the page", "done"].includes(verdict.textContent));
    if (news.passed) for (const box of all(`[data-tick="${wish.lesson}"]`)) box.checked = true;
  };
  try {
    const reader = (await ask(what, wish, stop.signal)).body.pipeThrough(new TextDecoderStream()).getReader();
    for (let rest = "", part = await reader.read(); !part.done; part = await reader.read()) {
      const lines = (rest + part.value).split("\n");
      rest = lines.pop();
      for (const line of lines) hear(JSON.parse(line));
    }
  } catch (error) {
    verdict.textContent = stop.signal.aborted ? "stopped" : `the guide does not answer: ${error.message}`;
  }
  button.remove();
  one("iframe", output)?.remove();
  if (running === stop) running = null;
}

for (const block of all(".run")) {
  const number = +block.dataset.block, inputs = all("[data-field]", block);
  const start = watch => {
    const values = Object.fromEntries(inputs.map(input => [input.dataset.field, input.value]));
    run(block, "run", { page: here, block: number, values, watch });
  };
  for (const button of all("[data-do]", block)) button.onclick = () => start(button.dataset.do === "watch");
  for (const input of inputs) {
    input.onkeydown = event => { if (event.key === "Enter") start(false); };
    input.onfocus = async () => {
      if (input.title) return;
      const told = await (await ask("hints", { page: here, block: number })).json();
      for (const each of inputs) each.title = told[each.dataset.name] ?? each.dataset.name;
    };
  }
}

// ---- The reader's own server ----

for (const own of all(".own")) {
  const lesson = own.dataset.lesson, tools = one(".tools", own);
  let text = null;
  const save = async () => {
    const told = await (await ask("edit", { lesson, ...(text ? { text: text.value } : {}) })).json();
    if (!text) {
      text = make("textarea", "", { value: told.text, spellcheck: false });
      text.setAttribute("aria-label", told.path);
      const go = make("button", "Save and run");
      go.dataset.do = "try";
      go.onclick = attempt;
      tools.append(go, make("small", told.path));
      tools.after(text, make("p", "", { className: "verdict" }));
      text.onkeydown = type;
      text.focus();
      text.setSelectionRange(told.at, told.at);
      text.scrollTop = text.scrollHeight * told.text.slice(0, told.at).split("\n").length / told.text.split("\n").length - 40;
      one("[data-do=edit]", own).hidden = true;
    }
    one(".verdict", own).textContent = told.error;
    return !told.error;
  };
  const type = event => {
    if ((event.ctrlKey || event.metaKey) && event.key === "s") { event.preventDefault(); attempt(); }
    if (event.key !== "Enter" && event.key !== "Tab" || event.shiftKey) return;
    event.preventDefault();
    const line = text.value.slice(0, text.selectionStart).split("\n").pop();
    const put = event.key === "Tab" ? "    " : "\n" + line.match(/^ */)[0] + (line.endsWith(":") ? "    " : "");
    text.setRangeText(put, text.selectionStart, text.selectionEnd, "end");
  };
  // A server that runs already is started anew by what is saved, and its client as well.
  const attempt = async () => {
    if (await save() && running?.of !== own) { run(own, "try", { lesson, check: false }); running.of = own; }
  };
  one("[data-do=edit]", own).onclick = save;
  const check = one("[data-do=check]", own);
  if (check) check.onclick = async () => { if (!text || await save()) run(own, "try", { lesson, check: true }); };
}
for (const box of all("[data-tick]"))
  box.onchange = () => ask("tick", { lesson: box.dataset.tick, done: box.checked });

// ---- Search, source files, large type ----

let index = null;
const field = one("#search"), found = one("#found");
field.oninput = async () => {
  index ??= await (await fetch(`${base}search.json`)).json();
  const words = field.value.toLowerCase().split(/[\s'"`:()]+/).filter(word => word);
  const rank = ([text, , title]) => words.filter(word => `${text} ${title}`.toLowerCase().includes(word)).length;
  const best = index.map(entry => [rank(entry), entry]).filter(([hits]) => hits && hits >= words.length / 2);
  best.sort((a, b) => b[0] - a[0] || a[1][0].length - b[1][0].length);
  found.replaceChildren(...best.slice(0, 12).map(([, [text, where, title]]) => {
    const link = make("a", text, { href: base + where });
    link.append(make("small", title));
    const item = make("li");
    item.append(link);
    return item;
  }));
  if (words.length && !best.length) found.append(make("li", "nothing of that; try fewer words"));
  found.hidden = !words.length;
};
found.onclick = () => { found.hidden = true; };

const shown = one("dialog");
document.addEventListener("click", async event => {
  const link = event.target.closest?.("main a, dialog a");
  if (!link || link.target || event.ctrlKey || event.metaKey || link.origin !== location.origin) return;
  if (/\.md$/.test(link.pathname) || link.pathname === location.pathname || link.pathname === `${base}class`) return;
  event.preventDefault();
  const file = link.pathname.slice(base.length);
  const function_ = all("[data-file]").map(each => each.dataset.file).find(each => each.startsWith(`${file}?`));
  const page = new DOMParser().parseFromString(await (await fetch(base + (function_ ?? file))).text(), "text/html");
  one("div", shown).replaceChildren(...one("main", page).childNodes);
  if (!shown.open) shown.showModal();
  shown.scrollTop = 0;
  one(".hll", shown)?.scrollIntoView({ block: "center" });
});

const big = yes => {
  document.documentElement.classList.toggle("big", yes);
  localStorage.setItem("big", yes ? "yes" : "");
};
big(localStorage.getItem("big") === "yes");
one("#big").onclick = () => big(!document.documentElement.classList.contains("big"));
one("#menu").onclick = () => one("#menu").setAttribute("aria-expanded", one("nav").classList.toggle("open"));
document.addEventListener("keydown", event => {
  if (event.key === "Escape") found.hidden = true;
  if (event.target.matches("input, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "b") one("#big").click();
  if (event.key === "/") { event.preventDefault(); field.focus(); }
});
one(`nav a[href="${location.pathname}"]`)?.setAttribute("aria-current", "page");
