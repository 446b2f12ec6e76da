"use strict";
// Without this script everything is there; with it cases can be filtered, and links open what they lead to.
const filter = document.getElementById("filter");
const cases = [...document.querySelectorAll("details.case")];

function select() {
  const wanted = Object.fromEntries(new FormData(filter));
  const text = wanted.text.toLowerCase();
  delete wanted.text;
  let found = 0;
  for (const each of cases) {
    const fits = Object.entries(wanted).every(([name, value]) => !value || each.dataset[name] === value)
      && (!text || each.textContent.toLowerCase().includes(text));
    each.hidden = !fits;
    found += fits;
  }
  document.getElementById("found").textContent = `${found} of ${cases.length} cases`;
}

function reveal() {
  const target = document.getElementById(location.hash.slice(1));
  if (target instanceof HTMLDetailsElement) {
    target.hidden = false;
    target.open = true;
    target.scrollIntoView();
    target.querySelector("summary").focus();
  }
}

// A mark says which case it is; written out for each it would double the page.
function name(event) {
  const mark = event.target.closest("a.mark");
  if (mark && !mark.title) {
    const found = document.getElementById(mark.hash.slice(1));
    mark.title = `${found.querySelector("summary").textContent.trim().slice(2)}: ${found.dataset.verdict}`;
    mark.setAttribute("aria-label", mark.title);
  }
}

// The map is one stop of the Tab key, not thousands: the arrow keys move in it.
const map = document.querySelector("table.map");
const STEPS = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] };

function enter(mark) {
  map.querySelector("a[tabindex='0']")?.setAttribute("tabindex", "-1");
  mark.setAttribute("tabindex", "0");
}

function move(event) {
  const step = STEPS[event.key];
  let cell = event.target.closest("td");
  if (!step || !cell || event.altKey || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  let row = cell.parentElement.sectionRowIndex, column = cell.cellIndex, mark = null;
  const rows = map.tBodies[0].rows;
  do {
    row += step[0];
    column += step[1];
    cell = rows[row]?.cells[column];
    mark = cell?.querySelector("a");
  } while (cell?.tagName === "TD" && !mark);
  mark?.focus();
}

if (map) {
  map.querySelectorAll("a").forEach((mark) => mark.setAttribute("tabindex", "-1"));
  map.querySelector("a")?.setAttribute("tabindex", "0");
  map.addEventListener("focusin", (event) => event.target.closest("a") && enter(event.target));
  map.addEventListener("keydown", move);
}

addEventListener("mouseover", name);
addEventListener("focusin", name);
filter.hidden = false;
filter.addEventListener("input", select);
filter.addEventListener("submit", (event) => event.preventDefault());
addEventListener("hashchange", reveal);
select();
reveal();
