// SPDX-License-Identifier: Apache-2.0
// The tracks at the time of the playback, as rows beside it; a click selects one.

const ROWS = 40; // at most: the largest tracks

function ageText(us) {
  return us >= 1e6 ? `${(us / 1e6).toFixed(1)} s` : `${Math.round(us / 1e3)} ms`;
}

export class Present {
  constructor(body, count, sides, choose) {
    Object.assign(this, { body, count, sides });
    this.arrows = sides.some((side) => side.moving);
    this.shown = [];
    body.addEventListener("click", (event) => {
      const row = this.shown[event.target.closest("tr")?.sectionRowIndex];
      if (row) choose(row.side, row.life);
    });
  }

  draw(now, seen, selected) {
    const all = this.sides.filter((side) => seen.has(side.name)).flatMap((side) => {
      return side.livesAt(now).map((life) => ({ side, life, point: side.pointAt(life, now) }));
    });
    const largest = all.toSorted((a, b) => b.side.meanSide[b.point] - a.side.meanSide[a.point]).slice(0, ROWS);
    this.shown = all.filter((row) => largest.includes(row)); // in the order of sides and births, so that rows do not dance
    this.count.textContent = all.length > ROWS ? `the ${ROWS} largest of ${all.length}` : String(all.length);
    while (this.body.rows.length > this.shown.length) this.body.deleteRow(-1);
    for (const [i, row] of this.shown.entries()) this.#write(this.body.rows[i] ?? this.body.insertRow(), row, now, selected);
  }

  #write(line, { side, life, point }, now, selected) {
    const speed = side.moving ? Math.hypot(side.vx[point], side.vy[point]) : 0;
    const cells = [
      `${side.name} ${side.ids[life]}`,
      `${Math.round(2 * side.halfWidth[point])} × ${Math.round(2 * side.halfHeight[point])}`,
      ...(this.arrows ? [speed ? String(Math.round(speed)) : "–"] : []),
      ageText(now - side.birth[life]),
    ];
    while (line.cells.length < cells.length) line.insertCell();
    for (const [i, text] of cells.entries()) if (line.cells[i].textContent !== text) line.cells[i].textContent = text;
    line.cells[0].className = `${side.look}-name`;
    line.setAttribute("aria-selected", String(selected?.side === side && selected.life === life));
  }
}
