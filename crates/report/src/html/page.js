"use strict";
// Everything that the project says goes into the page as text, never as markup.
const { version, answer, text, report, ladder } = JSON.parse(document.getElementById("data").textContent);
const page = document.getElementById("page");
const SVG = "http://www.w3.org/2000/svg";

function el(tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) made.setAttribute(name, value);
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}
function svg(tag, attributes, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes || {})) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// Times as people say them: of bounds no less than they are, of scans that were found no more.
const above = (ps) => time(ps, Math.ceil), below = (ps) => time(ps, Math.floor);
function time(ps, round = Math.round) {
  if (ps === null || ps === undefined) return "";
  const units = [["days", 86400e12, 172800e12], ["h", 3600e12, 7200e12], ["min", 60e12, 120e12], ["s", 1e12, 1e12], ["ms", 1e9, 1e9], ["us", 1e6, 1e6], ["ns", 1e3, 1e3], ["ps", 1, 0]];
  if (ps === 0) return "0 us";
  const [unit, size] = units.find(([, , least]) => ps >= least);
  const value = ps / size;
  const digits = Math.max(0, 3 - Math.floor(Math.log10(Math.max(1, value))));
  const parts = 10 ** (size === 1 ? 0 : digits);
  // What a quotient falls short or is over by its last bit is not rounded for.
  const shown = round(Number((value * parts).toPrecision(13))) / parts;
  return shown.toFixed(size === 1 ? 0 : digits) + " " + unit;
}
const share = (ps) => (100 * ps / Math.max(1, report.scan.upper_ps)).toFixed(1) + " %";
const shortName = (file) => {
  const last = (name) => name.split(/[\\/]/).pop();
  const own = last(file);
  return report.program.files.filter((other) => last(other) === own).length === 1 ? own : file;
};
const files = report.program.files.map(shortName);
const place = (at) => files[at.file] + ":" + at.line;

const rungs = ladder.map(([number, file, line, elements, paths], index) => {
  const sum = (n) => elements.reduce((all, one) => all + one[n], 0);
  return { number, file, line, elements, paths, index, part: sum(8), most: sum(9) };
});
// A rung whose instructions do not stand together is drawn in several pieces.
const byNumber = new Map();
for (const piece of rungs) {
  const known = byNumber.get(piece.number);
  if (known) { known.part += piece.part; known.most += piece.most; } else byNumber.set(piece.number, { ...piece });
}
const distinct = (pieces) => new Set(pieces.map((piece) => piece.number)).size;
const why = new Map();
for (const group of report.groups) for (const one of group.excluded) why.set(one.block, one);

function toRung(number, ...children) {
  return byNumber.has(number) ? el("a", { href: "#r" + number }, ...children) : el("span", {}, ...children);
}
function table(heads, rows) {
  const isNumber = heads.map((head) => head.startsWith(">"));
  const cell = (tag) => (value, n) => el(tag, isNumber[n] ? { class: "n" } : {}, value);
  return el("div", { class: "scroll" }, el("table", {},
    el("thead", {}, el("tr", {}, ...heads.map((head) => head.replace(">", "")).map(cell("th")))),
    el("tbody", {}, ...rows.map((row) => el("tr", {}, ...row.map(cell("td")))))));
}
function section(id, title, ...children) {
  page.append(el("h2", { id }, title), ...children);
}
// The first of many, and a button for the others.
function first(count, heads, rows) {
  const box = el("div", {}, table(heads, rows.slice(0, count).map((row) => row())));
  if (rows.length > count) {
    const button = el("button", { type: "button" }, "all " + rows.length);
    button.addEventListener("click", () => box.replaceChildren(table(heads, rows.map((row) => row()))));
    box.append(button);
  }
  return box;
}
const code = (told) => el("code", {}, told);

function head() {
  const verdict = report.check ? report.check.verdict : "";
  page.append(
    el("h1", {}, document.title.replace(/ - scanbound$/, "")),
    el("p", { class: "faint" }, [report.program.dialect, report.program.cpu, "table " + report.table.name, report.program.instructions + " instructions", report.program.blocks + " rungs"].filter(Boolean).join(" · ")),
    el("div", { class: "answer " + verdict, id: "answer" }, answer.trim()));
  const all = report.scan.proved_ps > report.scan.cycle_ps ? [["with all points that the CPU can have, at most", report.scan.proved_ps, above]] : [];
  const most = report.scan.proved_ps === null ? "the bound, which may be too low" : all.length ? "with the points that the program names, at most" : "longest scan, at most";
  const rows = [...all, [most, report.scan.upper_ps, above], ["longest scan found", report.scan.lower_ps, below], ["sum of all instructions, each at its larger time", report.scan.naive_ps, above]];
  page.append(table(["", ">time", ">of the bound"], rows.map(([name, ps, told]) => [name, told(ps), share(ps)])));
}

// What is not stated and may make the bound too low.
function open() {
  const loops = (report.unbounded || []).map((one) => "a scan can go round the loop back to " + files[one.file] + ":" + one.to_line + " for ever: the bound holds for scans that end");
  const all = [...loops, ...report.doubts];
  if (all.length) section("open", "Why the bound may be too low", el("ul", {}, ...all.map((told) => el("li", {}, told))));
}

// The time limit ended that audit: a longer one may find less.
function orLess(one) {
  return one.cut ? " or less" : "";
}

function unknowns() {
  const found = report.unknowns || [];
  if (found.length) {
    section("unknowns", "What is not known, and what to state",
      first(12, ["what", "where", "taken", ">part", "line for the facts file"], found.map((one) => () => [
        one.name, place(one.places[0]) + (one.places.length > 1 ? " and " + (one.places.length - 1) + " more" : ""),
        one.taken ? "up to " + one.taken[1] : "anything", one.ps ? time(one.ps) : "", code("[" + (one.table || "counts") + "] " + one.fact)])));
  }
  const solved = report.what_if;
  if (solved && solved.steps.length) {
    const most = solved.steps[0].solved.map((one) => one.most);
    section("what-if", "The bound where these are stated, each with those above it",
      table(["stated", ...most.map((n) => ">at most " + n)], solved.steps.map((step) => [
        step.name, ...step.solved.map((one) => (one.upper_ps === null ? "cannot be" : above(one.upper_ps) + orLess(one)))])));
  }
  const trusted = report.assumptions || [];
  if (trusted.length) {
    section("assumptions", "What is trusted: only the program writes these",
      first(12, ["what", "range", "written by", ">bound without"], trusted.map((one) => () => [
        one.name, one.range ? one.range.join(" to ") : one.most_on > 1 ? "never all on" : one.most_on === 0 ? "off in the first scan" : "never two on",
        one.written.slice(0, 3).map((at) => place(at)).join(", ") + (one.written.length > 3 ? ", ..." : ""),
        above(one.upper_without_ps) + orLess(one)])));
  }
}

function parts() {
  const rows = (list, name) => list.map((one) => () => [name(one), time(one.ps), share(one.ps), one.most_ps ? time(one.most_ps) : ""]);
  const name = (one) => {
    if (one.block !== undefined) return toRung(one.block, "rung " + one.block + "  " + place(one) + "  " + one.name);
    if (one.kind === "open") return "left open by the search: the bound above the longest scan found";
    if (one.kind === "factor") return "factor " + one.name;
    return one.name || (one.file === undefined ? one.kind : files[one.file]);
  };
  const heads = ["", ">part", ">of the bound", ">at most, nothing excluded"];
  section("where", "Where the time goes", treemap(),
    el("h3", {}, "Programs"), first(10, heads, rows(report.breakdown.program, name)),
    el("h3", {}, "Rungs"), first(10, heads, rows(report.breakdown.rung, name)),
    el("h3", {}, "Kinds of instructions"), first(10, heads, rows(report.breakdown.instruction, name)));
}

// A squarified treemap: Bruls, Huizing, van Wijk, "Squarified Treemaps", 2000.
function squarify(items, x, y, wide, high, put) {
  const all = items.filter((item) => item.ps > 0).sort((a, b) => b.ps - a.ps);
  let left = all.reduce((sum, item) => sum + item.ps, 0), at = 0;
  while (at < all.length && wide > 0 && high > 0) {
    const short = Math.min(wide, high), area = (wide * high) / left;
    let row = [], sum = 0, worst = Infinity;
    for (; at < all.length; at++) {
      const next = sum + all[at].ps;
      const ratio = Math.max(...[all[at].ps, (row[0] || all[at]).ps].map((ps) => {
        const a = (next * area) / short, b = (ps * area) / a;
        return Math.max(a / b, b / a);
      }));
      if (ratio > worst) break;
      worst = ratio; sum = next; row.push(all[at]);
    }
    const depth = (sum * area) / short;
    let along = 0;
    for (const item of row) {
      const length = (item.ps / sum) * short;
      if (wide >= high) put(item, x, y + along, depth, length); else put(item, x + along, y, length, depth);
      along += length;
    }
    if (wide >= high) { x += depth; wide -= depth; } else { y += depth; high -= depth; }
    left -= sum;
  }
}
function treemap() {
  const [wide, high] = [Math.max(280, page.clientWidth - 32), 340];
  const box = svg("svg", { class: "map", viewBox: `0 0 ${wide} ${high}`, preserveAspectRatio: "none", role: "img", "aria-label": "The parts of the bound" });
  const programs = report.breakdown.program.map((one) => ({ ps: one.ps, file: one.file, name: one.kind === "factor" ? "factor " + one.name : one.name || files[one.file] || "left open" }));
  const inner = new Map();
  for (const one of report.breakdown.rung) if (one.block !== undefined) {
    if (!inner.has(one.file)) inner.set(one.file, []);
    inner.get(one.file).push({ ps: one.ps, number: one.block, name: "rung " + one.block + " " + place(one) + " " + one.name });
  }
  let colour = 0;
  squarify(programs, 0, 0, wide, high, (program, x, y, w, h) => {
    const hue = (colour++ * 47) % 360;
    const own = program.file === undefined ? [] : inner.get(program.file) || [];
    const shown = own.slice(0, 150), rest = own.slice(150).reduce((sum, one) => sum + one.ps, 0);
    if (rest > 0) shown.push({ ps: rest, name: own.length - 150 + " further rungs of " + program.name });
    const items = shown.length ? shown : [{ ps: program.ps, name: program.name }];
    squarify(items, x, y, w, h, (item, ix, iy, iw, ih) => {
      const rect = svg("rect", { x: ix, y: iy, width: Math.max(0, iw - 0.5), height: Math.max(0, ih - 0.5), fill: `hsl(${hue} 45% 68%)` });
      const told = svg("title", {});
      told.textContent = item.name + ": " + time(item.ps) + ", " + share(item.ps);
      rect.append(told);
      if (item.number === undefined) { box.append(rect); return; }
      box.append(svg("a", { href: "#r" + item.number }, rect));
    });
    if (w > 70 && h > 18) {
      const label = svg("text", { x: x + 4, y: y + 14 });
      label.textContent = (program.name + " " + share(program.ps)).slice(0, Math.floor(w / 7));
      box.append(label);
    }
  });
  return box;
}

function excluded() {
  const rows = [...byNumber.values()].filter((rung) => why.has(rung.number) && rung.most > rung.part)
    .sort((a, b) => (b.most - b.part) - (a.most - a.part));
  if (!rows.length) return;
  section("excluded", "What cannot run in the same scan, and so is not in the bound",
    first(12, ["rung", ">not in the bound", "excluded by", "through"], rows.map((rung) => () => {
      const one = why.get(rung.number);
      const by = one.by_blocks.slice(0, 6).flatMap((number, n) => [n ? ", " : "", toRung(number, String(number))]);
      return [toRung(rung.number, rung.number + "  " + files[rung.file] + ":" + rung.line), time(rung.most - rung.part),
        el("span", {}, ...(by.length ? ["rung ", ...by] : ["itself"])), one.through.slice(0, 4).join(", ")];
    })));
}

// The drawing of a rung: cells of one size, contacts from the left, what is driven at the right.
const CELL = 104, ROW = 62, WIRE = 30, LEFT = 10;
function isText(element) { return element[0] === "box" || element[0] === "if"; }
function cells(element) { return isText(element) ? Math.ceil((element[2].length * 7.3 + 30) / CELL) : 1; }
function size(rung, drawing) {
  if (typeof drawing === "number") return [cells(rung.elements[drawing]), 1];
  const [kind, ...all] = drawing, sizes = all.map((one) => size(rung, one));
  const sum = (n) => sizes.reduce((total, one) => total + one[n], 0), most = (n, least) => sizes.reduce((top, one) => Math.max(top, one[n]), least);
  return kind === 0 ? [sum(0), most(1, 1)] : [most(0, 0), sum(1)];
}
function children(rung, path) { return rung.paths.map((_, n) => n).filter((n) => rung.paths[n][0] === path); }
function rows(rung, path) {
  const behind = children(rung, path).reduce((sum, child) => sum + rows(rung, child), rung.paths[path][2].length);
  return Math.max(size(rung, rung.paths[path][1])[1], behind);
}
function reach(rung, path, from) {
  const end = from + size(rung, rung.paths[path][1])[0];
  return children(rung, path).reduce((far, child) => Math.max(far, reach(rung, child, end)), end);
}
function height(rung) { return children(rung, null).reduce((sum, path) => sum + rows(rung, path), 0) * ROW + 8; }

function draw(rung) {
  const roots = children(rung, null);
  const right = roots.reduce((far, path) => Math.max(far, reach(rung, path, 0)), 0);
  const driven = rung.paths.flatMap((path) => path[2]).map((n) => rung.elements[n]);
  const last = driven.reduce((wide, one) => Math.max(wide, one[0] === "box" ? one[2].length * 7.3 + 40 : 60 + Math.max(one[2].length * 7.3, comment(one).length * 6.2)), 60);
  const wide = LEFT + right * CELL + last + 20, high = height(rung);
  const box = svg("svg", { width: wide, height: high, viewBox: `0 0 ${wide} ${high}`, role: "img", "aria-label": rung.elements.map((one) => one[1]).join("; ") });
  box.append(svg("path", { d: `M${LEFT} 0V${high}` }));
  const x = (column) => LEFT + column * CELL, y = (row) => row * ROW + WIRE;
  const line = (d, live) => box.append(svg("path", live ? { d, class: "live" } : { d }));
  const label = (at, down, told, kind, anchor) => {
    const made = svg("text", { x: at, y: down, class: kind, "text-anchor": anchor || "middle" });
    made.textContent = told;
    return made;
  };
  const cut = (told, most) => (told.length > most ? told.slice(0, most - 1) + "…" : told);
  // What conducts in the longest scan; what is not timed says nothing of itself.
  const conducts = (drawing) => {
    if (typeof drawing === "number") return rung.elements[drawing][7] > 0;
    const [kind, ...all] = drawing;
    return kind === 0 ? all.every(conducts) : all.some(conducts);
  };
  function symbol(element, column, row) {
    const live = element[7] > 0, from = x(column), to = x(column + cells(element)), middle = (from + to) / 2, at = y(row);
    const group = svg("g", { class: live ? "on" : "off" });
    const style = live ? { class: "live" } : {};
    const title = svg("title", {});
    title.textContent = element[1] + (element[4].length ? "\n" + element[4].join("\n") : "") + "\nline " + element[3]
      + (element[5] ? "\n" + time(element[8]) + " of " + time(element[9]) + " in the bound; in the longest scan " + element[7] + " of " + element[5] + (element[5] === 1 ? " execution runs" : " executions run") : "");
    group.append(title);
    if (element[0] === "if") {
      const half = (element[2].length * 7.3 + 12) / 2;
      group.append(svg("path", { d: `M${from} ${at}H${middle - half}M${middle + half} ${at}H${to}`, ...style }),
        svg("rect", { x: middle - half, y: at - 12, width: 2 * half, height: 24, ...style }), label(middle, at + 4, element[2], "l"));
    } else {
      group.append(svg("path", { d: `M${from} ${at}H${middle - 7}M${middle + 7} ${at}H${to}M${middle - 7} ${at - 9}V${at + 9}M${middle + 7} ${at - 9}V${at + 9}` + (element[0] === "nc" ? `M${middle - 9} ${at + 9}L${middle + 9} ${at - 9}` : ""), ...style }),
        label(middle, at - 13, cut(element[2], 13), "l"));
    }
    if (element[0] !== "if") group.append(label(middle, at + 22, cut(comment(element), 15), "c"));
    box.append(group);
  }
  function put(drawing, column, row) {
    if (typeof drawing === "number") return symbol(rung.elements[drawing], column, row);
    const [kind, ...all] = drawing;
    if (kind === 0) {
      for (const one of all) { put(one, column, row); column += size(rung, one)[0]; }
      return;
    }
    const across = size(rung, drawing)[0];
    let at = row, end = row;
    for (const one of all) {
      const [own, down] = size(rung, one);
      put(one, column, at);
      if (own < across) line(`M${x(column + own)} ${y(at)}H${x(column + across)}`, conducts(one));
      end = at; at += down;
    }
    line(`M${x(column)} ${y(row)}V${y(end)}M${x(column + across)} ${y(row)}V${y(end)}`, false);
  }
  function drive(element, row) {
    const live = element[7] > 0, from = x(right), at = y(row), style = live ? { class: "live" } : {};
    const group = svg("g", { class: live ? "on" : "off" });
    const title = svg("title", {});
    title.textContent = element[1] + (element[4].length ? "\n" + element[4].join("\n") : "") + "\nline " + element[3];
    group.append(title);
    let end;
    if (element[0] === "box") {
      const width = element[2].length * 7.3 + 12;
      group.append(svg("path", { d: `M${from} ${at}H${from + 12}`, ...style }), svg("rect", { x: from + 12, y: at - 13, width, height: 26, ...style }), label(from + 18, at + 4, element[2], "l", "start"));
      end = from + 12;
    } else {
      const sign = { set: "S", rst: "R" }[element[0]] || "";
      group.append(svg("path", { d: `M${from} ${at}H${from + 14}`, ...style }), svg("path", { d: `M${from + 20} ${at - 10}Q${from + 8} ${at} ${from + 20} ${at + 10}M${from + 34} ${at - 10}Q${from + 46} ${at} ${from + 34} ${at + 10}`, ...style }),
        label(from + 27, at + 4, sign, "l"), label(from + 52, at + 4, element[2], "l", "start"));
      end = from + 52;
    }
    const told = [comment(element), element[8] > 0 ? time(element[8]) : ""].filter(Boolean).join(" · ");
    group.append(label(end, at + 26, told, "c", "start"));
    box.append(group);
  }
  function layout(path, column, row, before) {
    const [, conditions, own] = rung.paths[path];
    const live = before && conducts(conditions);
    put(conditions, column, row);
    const end = column + size(rung, conditions)[0];
    let used = 0, lowest = row;
    for (const n of own) {
      lowest = row + used;
      line(`M${x(end)} ${y(lowest)}H${x(right)}`, live && rung.elements[n][7] > 0);
      drive(rung.elements[n], lowest);
      used++;
    }
    for (const child of children(rung, path)) {
      lowest = row + used;
      used += layout(child, end, lowest, live);
    }
    if (lowest > row) line(`M${x(end)} ${y(row)}V${y(lowest)}`, false);
    return Math.max(used, size(rung, conditions)[1]);
  }
  let row = 0;
  for (const path of roots) row += layout(path, 0, row, true);
  return box;
}
function comment(element) { return element[4].length ? element[4][0].slice(element[4][0].indexOf(" ") + 1) : ""; }

function drawn() {
  if (!rungs.length) return;
  const find = el("input", { type: "search", placeholder: "device, comment, instruction, rung number", "aria-label": "search the rungs", id: "find" });
  const count = el("span", { class: "faint", id: "count" }, byNumber.size + " rungs");
  const nav = el("nav", {}, el("a", { href: "#answer" }, "answer"), el("a", { href: "#where" }, "time"), el("a", { href: "#rungs" }, "ladder"), find, count);
  page.prepend(nav);
  section("rungs", "The ladder, lit as in the longest scan");
  const boxes = new Map();
  const watch = new IntersectionObserver((seen) => {
    for (const one of seen) if (one.isIntersecting) {
      watch.unobserve(one.target);
      one.target.replaceChildren(draw(boxes.get(one.target)));
    }
  }, { rootMargin: "600px" });
  let file = -1;
  const all = [];
  for (const rung of rungs) {
    if (rung.file !== file) {
      file = rung.file;
      page.append(el("h3", { class: "file" }, files[file]));
    }
    const tall = height(rung);
    const drawing = el("div", { class: "drawing", style: `min-height:${tall}px` });
    const bar = rung.part > 0 ? el("div", { class: "bar", style: `width:${Math.min(100, 100 * rung.part / report.scan.upper_ps)}%` }) : null;
    const reason = why.get(rung.number);
    const head = el("header", {}, el("b", {}, "rung " + rung.number), el("span", { class: "faint" }, files[rung.file] + ":" + rung.line),
      rung.most > 0 ? el("span", {}, time(rung.part) + (rung.most > rung.part ? " of " + time(rung.most) : "") + ", " + share(rung.part)) : null,
      reason && rung.most > rung.part ? el("span", { class: "why" }, reason.by_blocks.length ? "excluded by rung " + reason.by_blocks.slice(0, 4).join(", ") : "never costs more") : null);
    const id = all.some(([, other]) => other.number === rung.number) ? {} : { id: "r" + rung.number };
    const box = el("section", { class: "rung", ...id, style: `contain-intrinsic-size:auto ${tall + 40}px` }, head, bar, drawing);
    boxes.set(drawing, rung);
    watch.observe(drawing);
    page.append(box);
    all.push([box, rung]);
  }
  let texts = null, waiting = 0;
  find.addEventListener("input", () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      texts = texts || rungs.map((rung) => ("rung " + rung.number + " " + rung.elements.map((one) => one[1] + " " + one[4].join(" ")).join(" ")).toLowerCase());
      const asked = find.value.trim().toLowerCase();
      const shown = [];
      all.forEach(([box, rung], n) => { box.hidden = asked !== "" && !texts[n].includes(asked); if (!box.hidden) shown.push(rung); });
      count.textContent = asked ? distinct(shown) + " of " + byNumber.size + " rungs" : byNumber.size + " rungs";
    }, 150);
  });
}

function rest() {
  const kinds = new Map();
  for (const one of report.approximations) {
    if (!kinds.has(one.what)) kinds.set(one.what, []);
    kinds.get(one.what).push(one);
  }
  if (kinds.size) section("approximations", "What is over-approximated",
    first(8, ["what", ">instructions", "first"], [...kinds].sort((a, b) => b[1].length - a[1].length).map(([what, all]) => () => [what, String(all.length), place(all[0]) + "  " + all[0].instruction])));
  if (report.exactness) {
    const all = report.exactness;
    const part = (exact, of) => of ? (100 * exact / of).toFixed(1) + " %" : "";
    const languages = all.languages.map((one) => () => [one.language, String(one.bodies), String(one.uncalled), String(one.statements), String(one.exact), part(one.exact, one.statements)]);
    const at = (one) => place(one) + "  " + one.body + ": " + one.statement;
    const boxes = [first(8, ["language", ">bodies", ">not called", ">statements", ">exactly", ">share"], languages)];
    if (all.constructs.length) boxes.push(first(8, ["taken as any value", ">statements", "first"], all.constructs.map((one) => () => [one.what, String(one.statements), at(one.places[0])])));
    section("exactness", "Followed exactly: " + all.exact + " of " + all.statements + " statements", ...boxes);
  }
  const details = el("details", {}, el("summary", {}, "The report as text"), el("pre", {}, text));
  const from = report.inputs.map((one) => () => [one.what, one.name + (one.date ? " (" + one.date + ")" : ""), one.sha256]);
  const sums = el("details", {}, el("summary", {}, "What it was made from, with checksums"),
    first(50, ["what", "name", "SHA-256"], from));
  section("text", "Report", details, sums, el("p", { class: "faint" }, "scanbound " + version));
}

head();
open();
unknowns();
parts();
excluded();
rest();
drawn();
document.documentElement.dataset.ready = "yes";
if (location.hash) document.getElementById(location.hash.slice(1))?.scrollIntoView();
