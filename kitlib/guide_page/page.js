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

// ---- One run at a time: its lines as they come, until it ends, or the page or its Stop ends it ----

addEventListener("unhandledrejection", event => alert(event.reason.message));
let running = null, index = null;
async function run(place, what, wish) {
  running?.stop.abort();
  const mine = running = { place, check: wish.check, stop: new AbortController() };
  const columns = make("div", { className: "columns" }), verdict = make("p", { className: "verdict", role: "status" });
  const button = make("button", { textContent: "Stop", onclick: () => mine.stop.abort() });
  const output = make("div", { className: "output" }, button, verdict, columns), seen = {}, lines = {};
  one(".output", place)?.remove();
  one(".tools", place).after(output);
  const column = who => {
    const put = who === "server" ? "prepend" : "append";
    if (!seen[who]) columns[put](make("div", {}, make("b", {}, who), seen[who] = make("pre")));
    return lines[who] ??= [];
  };
  const hear = news => {
    if (news.begins === "client") column("client").length = 0;
    if (news.who === "kit") verdict.textContent = news.text;
    else if (news.who) column(news.who).push(news.text);
    if (news.page) output.append(make("iframe", { src: news.page, title: "The messages, as arrows" }));
    if (news.verdict) verdict.textContent = news.verdict;
    if (news.verdict) verdict.classList.add(["as on the page", "done"].includes(news.verdict) ? "good" : "bad");
    if (news.passed) all(`[data-tick="${wish.lesson}"]`).forEach(box => { box.checked = true; });
  };
  // However much has come, there is one layout of it.
  const show = () => {
    for (const [who, each] of Object.entries(lines)) {
      if (each.length > 500) each.splice(0, each.length - 499, "... earlier lines left out");
      seen[who].textContent = each.join("\n");
      seen[who].scrollTop = seen[who].scrollHeight;
    }
  };
  try {
    const reader = (await ask(what, wish, mine.stop.signal)).body.pipeThrough(new TextDecoderStream()).getReader();
    for (let rest = "", part = await reader.read(); !part.done; part = await reader.read()) {
      const told = (rest + part.value).split("\n");
      rest = told.pop();
      told.map(JSON.parse).forEach(hear);
      show();
      // Stop and the page's own work come in between.
      await new Promise(go => setTimeout(go, 20));
    }
  } catch (error) {
    verdict.textContent = mine.stop.signal.aborted ? "stopped" : error.message;
  }
  button.remove();
  one("iframe", output)?.remove();
  if (running === mine) running = null;
}

for (const block of all(".run"))
  block.onsubmit = event => {
    event.preventDefault();
    const watch = event.submitter.value === "watch", values = Object.fromEntries(new FormData(event.target));
    run(block, "run", { page: location.pathname.slice(base.length), block: block.dataset.block, values, watch });
  };

// ---- The reader's own server ----

for (const own of all(".own")) {
  const lesson = own.dataset.lesson, edit = one("[data-do=edit]", own), check = one("[data-do=check]", own);
  let text = null;
  // The first time there is nothing to save yet.
  const saved = async () => {
    all(".verdict", own).forEach(each => { each.textContent = ""; });
    const told = await (await ask("edit", { lesson, text: text?.value })).json();
    if (!text) {
      text = make("textarea", { defaultValue: told.text, spellcheck: false, ariaLabel: told.path, onkeydown: type });
      edit.replaceWith(make("button", { textContent: "Save and run", onclick: attempt }));
      one(".tools", own).after(make("p", { className: "mistake verdict bad" }), make("small", {}, told.path), text);
      text.setSelectionRange(told.at, told.at);
      text.focus();
    }
    text.defaultValue = told.text;
    one(".mistake", own).textContent = told.error;
    return !told.error;
  };
  const type = event => {
    const line = text.value.slice(0, text.selectionStart).split("\n").pop(), more = line.endsWith(":") ? "    " : "";
    const put = { Tab: "    ", Enter: `\n${line.match(/^ */)[0]}${more}` }[event.key];
    if (!put || event.shiftKey) return;
    text.setRangeText(put, text.selectionStart, text.selectionEnd, "end");
    event.preventDefault();
  };
  // A server that runs already is started anew by what is saved, and its client as well.
  const attempt = async () => await saved() && (running?.place !== own || running.check) && run(own, "try", { lesson, check: false });
  edit.onclick = saved;
  if (check) check.onclick = async () => { if (!text || await saved()) run(own, "try", { lesson, check: true }); };
}
addEventListener("beforeunload", event => {
  if (all(".own textarea").some(text => text.value !== text.defaultValue)) event.preventDefault();
});
for (const link of all("main a[href^=http]")) link.target = "_blank";
for (const box of all("[data-tick]"))
  box.onchange = () => ask("tick", { lesson: box.dataset.tick, done: box.checked });

// ---- Search, source files, large type ----

const field = one("#search"), found = one("#found"), shown = one("dialog");
field.oninput = async () => {
  index ??= await (await fetch(`${base}search.json`)).json();
  const words = field.value.toLowerCase().split(/[\s'"`:()]+/).filter(word => word);
  const hits = ([text, , title]) => words.filter(word => `${text} ${title}`.toLowerCase().includes(word)).length;
  const ranked = index.map(entry => [hits(entry), entry]).filter(each => each[0] && each[0] >= words.length / 2);
  ranked.sort((a, b) => b[0] - a[0] || a[1][0].length - b[1][0].length);
  found.replaceChildren(...ranked.slice(0, 12).map(([, [text, where, title]]) =>
    make("li", {}, make("a", { href: base + where }, text, make("small", {}, title)))));
  found.hidden = !ranked.length;
};
found.onclick = () => { found.hidden = true; };

document.addEventListener("click", async event => {
  const link = event.target.closest?.("main a, dialog a"), file = link?.pathname.slice(base.length);
  if (!link || link.target || event.ctrlKey || event.metaKey || /\.md$|^class$/.test(file)) return;
  event.preventDefault();
  const part = all("[data-file]").map(each => each.dataset.file).find(each => each.startsWith(`${file}?`));
  const page = new DOMParser().parseFromString(await (await fetch(base + (part ?? file))).text(), "text/html");
  one("div", shown).replaceChildren(...one("main", page).childNodes);
  if (!shown.open) shown.showModal();
  shown.scrollTop = 0;
  one(".hll", shown)?.scrollIntoView({ block: "center" });
});

const large = yes => localStorage.setItem("big", document.documentElement.classList.toggle("big", yes) ? "yes" : "");
large(localStorage.getItem("big") === "yes");
one("#big").onclick = () => large();
one("#menu").onclick = () => one("nav").classList.toggle("open");
document.addEventListener("keydown", event => {
  if (event.target.matches("input, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "b") large();
  if (event.key === "/") { event.preventDefault(); field.focus(); }
});
one(`nav a[href="${location.pathname}"]`)?.setAttribute("aria-current", "page");
