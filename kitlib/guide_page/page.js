// What programs print is put in as text, never as HTML.
const one = (selector, within = document) => within.querySelector(selector);
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const make = (kind, more = {}, ...inside) => {
  const made = Object.assign(document.createElement(kind), more);
  made.append(...inside);
  return made;
};
const base = one("nav").dataset.base;
async function ask(what, wish, signal) {
  const gone = () => { throw new Error("the guide has ended: start it again, and open the address that it prints"); };
  const answer = await fetch(base + what, { method: "POST", body: JSON.stringify(wish), signal }).catch(gone);
  if (!answer.ok) throw new Error(await answer.text());
  return answer;
}

// ---- Programs: each has its lines as they come, until it ends, or its Stop or the page ends it ----

addEventListener("unhandledrejection", event => alert(event.reason.message));
const programs = new Map();
// Only one block's programs run; but a client that is alone may be for a server that is there already.
function begin(place, kinds) {
  for (const each of programs.values()) if (kinds !== "client" || each.kind !== "server") each.stop.abort();
  one(".output", place)?.remove();
  const output = make("div", { className: "output" });
  (one(".mistake", place) ?? one(".tools", place)).after(output);
  return () => output.appendChild(make("section"));
}

// `goes` is called when a server listens, and when any other program has ended.
async function program(box, kind, what, wish, goes = () => 0) {
  const stop = new AbortController(), lines = {}, seen = {};
  box.replaceChildren(one("#program").content.cloneNode(true));
  const [button, waits, verdict, columns] = ["button", "small", ".verdict", ".columns"].map(each => one(each, box));
  button.onclick = () => stop.abort();
  programs.set(box, { kind, stop });
  let seconds = 0;
  const clock = setInterval(() => { waits.textContent = `${++seconds} s`; }, 1000);
  const hear = ({ who, text, good, ...news }) => {
    const frame = who === "kit" && text.match(/^open (http:\S+) in/);
    if (frame) columns.before(make("iframe", { src: frame[1], title: "The messages, as arrows" }));
    if (frame) box.scrollIntoView({ block: "nearest" });
    if (news.command) one("code", box).textContent = news.command;
    if (who === "kit" && !frame || news.verdict) verdict.textContent = news.verdict ?? text;
    else if (who && who !== "tap" && !frame) (lines[who] ??= []).push(text);
    if (good != null) verdict.classList.add(good ? "good" : "bad");
    if (good && what === "own") {
      all(`[data-tick="${wish.lesson}"]`).forEach(tick => { tick.checked = true; });
      one(`nav a[href$="/${wish.lesson}.md"]:not(:has(b))`)?.append(make("b", {}, "✓"));
    }
    if (kind === "server" && text?.startsWith("listening on ")) goes();
  };
  // However much has come, there is one layout of it.
  const show = () => {
    for (const [who, each] of Object.entries(lines)) {
      const side = who === "server" ? "prepend" : "append";
      if (!seen[who]) columns[side](make("div", {}, make("b", {}, who), seen[who] = make("pre")));
      if (each.length > 500) each.splice(0, each.length - 499, "... earlier lines left out");
      seen[who].textContent = each.join("\n");
      seen[who].scrollTop = seen[who].scrollHeight;
    }
  };
  try {
    const reader = (await ask(what, wish, stop.signal)).body.pipeThrough(new TextDecoderStream()).getReader();
    for (let rest = "", part = await reader.read(); !part.done; part = await reader.read()) {
      const told = (rest + part.value).split("\n");
      rest = told.pop();
      told.map(JSON.parse).forEach(hear);
      show();
      // Stop and the page's own work come in between.
      await new Promise(go => setTimeout(go, 20));
    }
    if (kind !== "server") goes();
  } catch (error) {
    if (!stop.signal.aborted || !verdict.matches(".good, .bad")) {
      verdict.textContent = stop.signal.aborted ? "stopped" : error.message;
      verdict.className = "verdict";
    }
  }
  one("iframe", box)?.remove();
  clearInterval(clock);
  programs.delete(box);
  button.textContent = "Start";
  button.onclick = () => program(box, kind, what, wish, goes);
}

for (const block of all(".run"))
  block.onsubmit = async event => {
    event.preventDefault();
    const watch = event.submitter.value === "watch", values = Object.fromEntries(new FormData(event.target));
    const wish = { page: location.pathname.slice(base.length), block: block.dataset.block, values, watch };
    const kinds = block.dataset.steps, room = begin(block, kinds);
    for (const [step, kind] of kinds.split(" ").entries())
      await new Promise(goes => program(room(), kind, "run", { ...wish, step }, goes));
  };

// ---- The reader's own server ----

for (const own of all(".own")) {
  const lesson = own.dataset.lesson, text = one("textarea", own), mistake = one(".mistake", own);
  let was, options;
  // The line and the buttons are both seen, and each line has its number.
  const show = line => {
    const lines = text.value.split("\n");
    const start = lines.slice(0, line - 1).join("\n").length + 1;
    text.setSelectionRange(start, start);
    text.focus({ preventScroll: true });
    text.scrollTop = text.scrollHeight * (line - 4) / lines.length;
    own.scrollIntoView();
  };
  text.onscroll = () => { text.previousSibling.scrollTop = text.scrollTop; };
  const number = text.oninput = () => {
    text.previousSibling.textContent = text.value.split("\n").map((_, at) => at + 1).join("\n");
  };
  const edit = async wish => {
    const told = await (await ask("edit", { lesson, ...wish })).json();
    const elsewhere = "not saved: this file was changed elsewhere since you opened it here";
    mistake.textContent = told.newer ? elsewhere : told.error;
    if (told.newer && !confirm(`${elsewhere}. Load what it is now?`)) return false;
    own.classList.add("open");
    one("[value=save]", own).textContent = "Save and run";
    one("small", own).textContent = told.path;
    const other = text.value !== told.text;
    if (other) text.value = told.text;
    number();
    if (other || told.error) show(told.at);
    was = text.defaultValue = told.text;
    return !told.newer && !told.error;
  };
  own.onsubmit = async event => {
    event.preventDefault();
    const does = event.submitter.value, opened = was !== undefined;
    if (!programs.has(one("section", own))) one(".output", own)?.remove();
    if (does === "again" && !confirm("Lose what you have written, and start again from the kit's server.py?")) return;
    const wish = does === "again" ? { again: true } : opened ? { text: text.value, was } : {};
    const check = does === "check", saved = check && !opened || await edit(wish), now = one("input", own).value;
    // While it runs with these options, its server is started anew by what is saved.
    const goes = programs.has(one("section", own)) && options === now;
    if (!saved || does === "again" || does === "save" && (!opened || goes)) return;
    options = check ? null : now;
    program(begin(own)(), "run", "own", { lesson, options: now, check });
  };
  text.onkeydown = event => {
    if ((event.ctrlKey || event.metaKey) && event.key === "s") {
      event.preventDefault();
      own.requestSubmit(one("[value=save]", own));
    }
    const line = text.value.slice(0, text.selectionStart).split("\n").pop(), more = line.endsWith(":") ? "    " : "";
    const put = { Tab: "    ", Enter: `\n${line.match(/^ */)[0]}${more}` }[event.key];
    if (!put || event.shiftKey || event.isComposing) return;
    text.setRangeText(put, text.selectionStart, text.selectionEnd, "end");
    event.preventDefault();
    number();
  };
}
addEventListener("beforeunload", event => {
  if (all(".own textarea").some(text => text.value !== text.defaultValue)) event.preventDefault();
});
for (const link of all("main a[href^=http]")) link.target = "_blank";
for (const box of all("[data-tick]"))
  box.onchange = () => ask("tick", { lesson: box.dataset.tick, done: box.checked });

// ---- Search, source files, large type ----

let index;
const field = one("#search"), found = one("#found"), shown = one("dialog");
const parts = text => text.toLowerCase().split(/[\s'"`:()]+/).filter(word => word);
const load = field.onfocus = () => index ??= fetch(`${base}search.json`).then(answer => answer.json());
field.oninput = async () => {
  const words = parts(field.value), has = (text, word) => parts(text).some(each => each.startsWith(word));
  const hits = ([text, , title]) => words.reduce((sum, word) => sum + 2 * has(text, word) + has(title, word), 0);
  const ranked = (await load()).map(entry => [hits(entry), entry]).filter(each => each[0] && each[0] >= words.length);
  ranked.sort((a, b) => b[0] - a[0] || a[1][0].length - b[1][0].length);
  found.replaceChildren(...ranked.slice(0, 12).map(([, [text, where, title]]) =>
    make("li", {}, make("a", { href: base + where }, text, make("small", {}, title)))));
  found.hidden = !ranked.length;
};
found.onclick = () => { found.hidden = true; };
field.onkeydown = event => { if (event.key === "Enter") one("a", found)?.click(); };

document.addEventListener("click", async event => {
  const link = event.target.closest?.("main a, dialog a"), file = link?.pathname.slice(base.length);
  if (!link || link.target || event.ctrlKey || event.metaKey || /\.md$|^class$/.test(file)) return;
  event.preventDefault();
  const part = all("[data-file]").map(each => each.dataset.file).find(each => each.startsWith(`${file}?`));
  const read = new DOMParser().parseFromString(await (await fetch(base + (part ?? file))).text(), "text/html");
  one("div", shown).replaceChildren(...one("main", read).childNodes);
  if (!shown.open) shown.showModal();
  shown.scrollTop = 0;
  one(".hll", shown)?.scrollIntoView({ block: "center" });
});

const page = document.documentElement;
const fit = () => page.classList.toggle("narrow", innerWidth < 50 * parseFloat(getComputedStyle(page).fontSize));
const large = yes => {
  localStorage.setItem("big", page.classList.toggle("big", yes) ? "yes" : "");
  fit();
};
addEventListener("resize", fit);
large(localStorage.getItem("big") === "yes");
// The reader stays at the same place.
const resize = () => {
  const here = document.elementFromPoint(one("main").getBoundingClientRect().x + 50, innerHeight / 3);
  large();
  here.scrollIntoView();
};
one("#big").onclick = resize;
one("#menu").onclick = () => one("nav").classList.toggle("open");
document.addEventListener("keydown", event => {
  if (event.isComposing || event.target.matches("input, textarea")) return;
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "b") resize();
  if (event.key === "/") { event.preventDefault(); field.focus(); }
});
one(`nav a[href="${location.pathname}"]`)?.setAttribute("aria-current", "page");
