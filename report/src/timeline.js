"use strict";
// The timelines of the page: numbers from a script element, drawn on a canvas. What is narrower than a pixel is drawn once a
// pixel, so that a frame costs what the canvas is wide, not what the run is long.
(() => {
  document.documentElement.classList.add("js");
  const S = 9, J = 7, LANE = 34, JOB = 12, HEAD = 46, GAP = 18;

  const units = [[1e9, "s"], [1e6, "ms"], [1e3, "µs"], [1, "ns"]];
  const time = (ns) => {
    const [unit, name] = units.find(([unit]) => Math.abs(ns) >= unit) || units[3];
    const value = ns / unit;
    return (Math.abs(value) >= 100 ? value.toFixed(1) : value.toFixed(3).replace(/\.?0+$/, "")) + " " + name;
  };
  const step = (span, count) => {
    const least = Math.max(1, span / count), power = 10 ** Math.floor(Math.log10(least));
    return [1, 2, 5, 10].map((times) => times * power).find((each) => each >= least);
  };

  document.querySelectorAll(".timeline").forEach((figure) => {
    const data = JSON.parse(figure.querySelector("script").textContent);
    const canvas = figure.querySelector("canvas"), pen = canvas.getContext("2d");
    const tip = figure.querySelector(".tip"), said = figure.querySelector("output");
    const overview = figure.querySelector(".overview");
    const frame = overview.appendChild(document.createElement("div"));
    frame.className = "frame";
    const slices = data.s, jobs = data.j, end = Math.max(1, data.end);
    let before = 0;
    for (let i = 0; i < slices.length; i += S) before = slices[i + 1] += before;
    const byLane = data.lanes.map(() => []);
    for (let i = 0; i < slices.length; i += S) if (slices[i + 7] > 0) byLane[slices[i]].push(i);
    const rowsOf = data.tasks.map(() => 0), firstRow = [];
    for (let i = 0; i < jobs.length; i += J) rowsOf[jobs[i]] = Math.max(rowsOf[jobs[i]], jobs[i + 6] + 1);
    rowsOf.reduce((sum, rows, task) => (firstRow[task] = sum, sum + rows), 0);
    const rows = rowsOf.reduce((sum, count) => sum + count, 0);
    const byRow = Array.from({ length: rows }, () => []), jobAt = new Map();
    for (let i = 0; i < jobs.length; i += J) {
      byRow[firstRow[jobs[i]] + jobs[i + 6]].push(i);
      jobAt.set(jobs[i] + "/" + jobs[i + 1], i);
    }
    const jobsTop = HEAD + byLane.length * (LANE + GAP);
    const height = jobsTop + rows * JOB + data.tasks.length * 6 + 8;
    let [from, until] = data.window, width = 0, hold = null, drawing = 0, colours = {};
    let miss = data.misses.length ? nearest() : -1;

    function nearest() {
      const middle = (from + until) / 2;
      const at = ([task, job]) => Math.abs(jobs[jobAt.get(task + "/" + job) + 3] - middle);
      return data.misses.reduce((best, each, i) => at(each) < at(data.misses[best]) ? i : best, 0);
    }
    function theme() {
      const style = getComputedStyle(figure), get = (name) => style.getPropertyValue("--" + name).trim();
      ["card", "ink", "quiet", "line", "slot", "late", "edit", "good"].forEach((name) => colours[name] = get(name));
      colours.tasks = Array.from({ length: data.colours }, (_, i) => get("c" + i));
      colours.font = style.fontFamily;
    }
    function size() {
      const ratio = window.devicePixelRatio || 1;
      width = canvas.clientWidth;
      canvas.style.height = height + "px";
      canvas.width = width * ratio;
      canvas.height = height * ratio;
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      redraw();
    }
    const x = (ns) => (ns - from) / (until - from) * width;
    const redraw = () => drawing = drawing || requestAnimationFrame(draw);

    function look(a, b) {
      const span = Math.min(Math.max(b - a, 200), end), middle = (a + b) / 2;
      from = Math.min(Math.max(0, middle - span / 2), end - span);
      until = from + span;
      redraw();
    }
    const zoom = (factor, at) => {
      const ns = from + (until - from) * at, span = Math.min(Math.max((until - from) * factor, 200), end);
      look(ns - span * at, ns - span * at + span);
    };
    // The first of a list, sorted by start, that may reach into what is seen; `back` of them may start before.
    function first(list, starts, offset) {
      let low = 0, high = list.length;
      while (low < high) {
        const middle = low + high >> 1;
        if (starts[list[middle] + offset] < from) low = middle + 1; else high = middle;
      }
      return Math.max(0, low - 1);
    }
    function fill(colour, left, top, right, bottom) {
      pen.fillStyle = colour;
      pen.fillRect(left, top, right - left, bottom - top);
    }
    function text(words, left, baseline, room, colour) {
      if (room < 14) return;
      pen.fillStyle = colour;
      let cut = words;
      while (cut.length > 1 && pen.measureText(cut).width > room) cut = cut.slice(0, -1);
      if (cut.length < words.length && cut.length < 4) return;
      pen.fillText(cut.length < words.length ? cut.slice(0, -1) + "…" : cut, left, baseline);
    }
    const name = (task, node) => data.tasks[task].nodes[node] || "node-" + node;

    function draw() {
      drawing = 0;
      pen.clearRect(0, 0, width, height);
      pen.font = "12px " + colours.font;
      const each = step(until - from, Math.max(2, width / 110));
      for (let at = Math.ceil(from / each) * each; at <= until; at += each) {
        fill(colours.line, x(at), 17, x(at) + 1, height);
        const label = time(at);
        text(label, Math.min(x(at) + 4, width - 60), 12, 100, colours.quiet);
      }
      drawReleases();
      byLane.forEach((list, lane) => drawLane(list, lane));
      byRow.forEach((list, row) => drawJobs(list, row));
      for (const [at, task, job] of data.hits) {
        const i = jobAt.get(task + "/" + job);
        if (at < from || at > until || i === undefined || width / (until - from) * (jobs[i + 3] - jobs[i + 2]) < 12) continue;
        pen.save();
        pen.translate(x(at), top(i) + JOB / 2 - 1);
        pen.rotate(Math.PI / 4);
        fill(colours.good, -3, -3, 3, 3);
        pen.restore();
      }
      let free = -1e9;
      for (const [at, words] of data.edits) {
        if (at < from || at > until) continue;
        pen.strokeStyle = colours.edit;
        pen.setLineDash([5, 4]);
        pen.beginPath();
        pen.moveTo(x(at), 16);
        pen.lineTo(x(at), height);
        pen.stroke();
        pen.setLineDash([]);
        const room = pen.measureText(words).width, left = Math.min(x(at) + 4, width - room - 4);
        if (left > free) {
          fill(colours.card, left - 2, 16, left + room + 2, 30);
          text(words, left, 27, 1e4, colours.edit);
          free = left + room + 10;
        }
      }
      data.lanes.forEach((words, lane) => label(words, HEAD + lane * (LANE + GAP) - 2));
      said.textContent = time(from) + " to " + time(until);
      frame.style.left = from / end * 100 + "%";
      frame.style.width = (until - from) / end * 100 + "%";
      frame.style.height = overview.querySelector("svg").clientHeight + 6 + "px";
    }
    function label(words, baseline) {
      fill(colours.card, 3, baseline - 10, pen.measureText(words).width + 9, baseline + 2);
      text(words, 6, baseline, 300, colours.quiet);
    }
    function drawReleases() {
      // Only where there is room between them.
      let last = -1e9;
      for (const list of byRow) for (let i = first(list, jobs, 2); i < list.length && jobs[list[i] + 2] <= until; i++) {
        const at = x(jobs[list[i] + 2]);
        if (width / (until - from) * (jobs[list[i] + 3] - jobs[list[i] + 2]) < 30) return;
        fill(colours.line, at, jobsTop - 8, at + 1, height);
        last = at;
      }
    }
    function drawLane(list, lane) {
      const above = HEAD + lane * (LANE + GAP) + 2, below = above + LANE;
      fill(colours.slot, 0, above, width, below);
      let drawn = -1;
      for (let k = first(list, slices, 1); k < list.length; k++) {
        const i = list[k], start = slices[i + 1], finish = start + slices[i + 2];
        if (start > until) break;
        if (finish < from) continue;
        const left = Math.max(x(start), -2), right = Math.min(Math.max(x(finish), left + 1), width + 2);
        if (right - left < 1.5 && Math.floor(left) === drawn) continue;
        drawn = Math.floor(left);
        const task = slices[i + 3], late = slices[i + 6] >= 0 && slices[i + 8] && finish > slices[i + 6];
        pen.globalAlpha = slices[i + 8] ? 1 - slices[i + 5] % 3 * 0.13 : 0.35;
        fill(colours.tasks[task % data.colours], left, above, right, below);
        pen.globalAlpha = 1;
        if (slices[i + 7] > 1 && right - left > 3) stripes(left, above, right, below);
        if (late) fill(colours.late, Math.max(left, x(slices[i + 6])), below - 5, right, below);
        if (right - left < 4) continue;
        fill(colours.card, right - 1, above, right, below);
        const due = x(slices[i + 6]);
        if (slices[i + 6] >= 0 && right - left > 12 && due > -1 && due < width + 1) {
          fill(colours.ink, due - 1, below - 3, due + 1, below + 5);
        }
        const words = name(task, slices[i + 5]) + (slices[i + 7] > 1 ? " +" + (slices[i + 7] - 1) : "");
        text(words, Math.max(left, 0) + 5, above + 16, right - Math.max(left, 0) - 8, "#10131a");
        text("#" + slices[i + 4], Math.max(left, 0) + 5, above + 29, right - Math.max(left, 0) - 8, "#10131acc");
      }
    }
    function stripes(left, above, right, below) {
      pen.save();
      pen.beginPath();
      pen.rect(left, above, right - left, below - above);
      pen.clip();
      pen.strokeStyle = colours.card;
      pen.globalAlpha = 0.55;
      pen.beginPath();
      for (let at = left - LANE; at < right; at += 7) {
        pen.moveTo(at, below);
        pen.lineTo(at + LANE, above);
      }
      pen.stroke();
      pen.restore();
    }
    const top = (i) => jobsTop + (firstRow[jobs[i]] + jobs[i + 6]) * JOB + jobs[i] * 6;
    function drawJobs(list, row) {
      let drawn = -1;
      for (let k = Math.max(0, first(list, jobs, 2)); k < list.length; k++) {
        const i = list[k], release = jobs[i + 2], due = jobs[i + 3], finish = jobs[i + 4] < 0 ? end : jobs[i + 4];
        if (release > until) break;
        if (Math.max(finish, due) < from) continue;
        const above = top(i), left = x(release), right = Math.max(x(finish), left + 1), outcome = jobs[i + 5];
        if (right - left < 1.5 && Math.floor(left) === drawn && outcome === 0) continue;
        drawn = Math.floor(left);
        fill(colours.tasks[jobs[i] % data.colours], left, above, Math.min(right, Math.max(left, x(due))), above + JOB - 4);
        for (let at = Math.max(x(due), left, -5); at < Math.min(right, width); at += 4) fill(colours.late, at, above, Math.min(at + 2.5, right), above + JOB - 4);
        if (outcome === 2) {
          pen.strokeStyle = colours.late;
          pen.lineWidth = 2;
          pen.beginPath();
          pen.moveTo(right - 4, above);
          pen.lineTo(right + 4, above + JOB - 4);
          pen.moveTo(right + 4, above);
          pen.lineTo(right - 4, above + JOB - 4);
          pen.stroke();
          pen.lineWidth = 1;
        }
        if (x(due) - left > 8) fill(colours.ink, x(due) - 1, above - 1, x(due) + 1, above + JOB - 3);
      }
    }
    function found(px, py) {
      const ns = from + px / width * (until - from), slack = 4 * (until - from) / width;
      const lane = Math.floor((py - HEAD) / (LANE + GAP));
      if (lane >= 0 && lane < byLane.length) {
        const list = byLane[lane];
        for (let k = first(list, slices, 1); k < list.length && slices[list[k] + 1] <= ns + slack; k++) {
          if (slices[list[k] + 1] + slices[list[k] + 2] >= ns - slack && slices[list[k] + 1] + slices[list[k] + 2] >= ns) return tellSlice(list[k]);
        }
      }
      for (const list of byRow) for (const i of list) {
        const finish = jobs[i + 4] < 0 ? end : jobs[i + 4];
        if (py >= top(i) - 1 && py < top(i) + JOB - 1 && ns >= jobs[i + 2] - slack && ns <= finish + slack) return tellJob(i);
      }
      return null;
    }
    const pair = (title, value) => [title, value];
    function tellSlice(i) {
      const [lane, start, length, task, job, node, due, , done] = slices.slice(i, i + S), lines = [];
      let members = [name(task, node)];
      for (let k = 1; k < slices[i + 7]; k++) members.push(name(slices[i + k * S + 3], slices[i + k * S + 5]) + " #" + slices[i + k * S + 4]);
      lines.push(pair("", data.tasks[task].name + " #" + job + ", " + data.lanes[lane]));
      lines.push(pair("start", time(start)), pair("finish", time(start + length) + (done ? "" : ", nobody wanted it")), pair("took", time(length)));
      if (due >= 0) lines.push(pair("sub-deadline", time(due)), pair(start + length > due ? "late" : "early", time(Math.abs(start + length - due))));
      return [members.join(" + "), lines];
    }
    function tellJob(i) {
      const [task, job, release, due, finish, outcome] = jobs.slice(i, i + 6);
      const lines = [pair("", ["on time", "late", "given up", "not ended"][outcome]), pair("released", time(release)), pair("deadline", time(due))];
      if (finish >= 0) lines.push(pair("ended", time(finish)), pair("response", time(finish - release)), pair(finish > due ? "late" : "early", time(Math.abs(finish - due))));
      return [data.tasks[task].name + " #" + job, lines];
    }
    function tell(event) {
      const box = canvas.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
      const words = found(px, py);
      tip.style.display = words ? "block" : "none";
      if (!words) return;
      tip.replaceChildren();
      tip.appendChild(document.createElement("b")).textContent = words[0];
      for (const [title, value] of words[1]) tip.appendChild(document.createElement("div")).textContent = (title ? title + " " : "") + value;
      tip.style.left = Math.max(0, Math.min(px + 14, width - tip.offsetWidth)) + "px";
      tip.style.top = canvas.offsetTop + py + 18 + "px";
    }
    const pointers = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, event.offsetX);
      canvas.setPointerCapture(event.pointerId);
      hold = { from, until, at: [...pointers.values()] };
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!pointers.has(event.pointerId)) return tell(event);
      pointers.set(event.pointerId, event.offsetX);
      const now = [...pointers.values()], span = hold.until - hold.from;
      if (now.length === 1) {
        const moved = (now[0] - hold.at[0]) / width * span;
        if (Math.abs(now[0] - hold.at[0]) > 3) tip.style.display = "none";
        return look(hold.from - moved, hold.until - moved);
      }
      const [a, b] = hold.at, wide = Math.max(20, Math.abs(now[0] - now[1])), scale = Math.max(20, Math.abs(a - b)) / wide;
      const ns = hold.from + (a + b) / 2 / width * span, at = (now[0] + now[1]) / 2 / width;
      look(ns - span * scale * at, ns + span * scale * (1 - at));
    });
    const up = (event) => {
      if (pointers.size === 1 && hold && Math.abs(event.offsetX - hold.at[0]) < 4) tell(event);
      pointers.delete(event.pointerId);
      hold = { from, until, at: [...pointers.values()] };
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("pointerleave", () => tip.style.display = "none");
    canvas.addEventListener("wheel", (event) => {
      const sideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
      // Without a modifier the page scrolls, as everywhere.
      if (!sideways && !event.ctrlKey && !event.metaKey && document.activeElement !== canvas) return;
      event.preventDefault();
      if (sideways) look(from + event.deltaX / width * (until - from), until + event.deltaX / width * (until - from));
      else zoom(Math.exp(Math.sign(event.deltaY) * 0.2), event.offsetX / width);
    }, { passive: false });
    function visit(by) {
      if (!data.misses.length) return;
      miss = (miss + by + data.misses.length) % data.misses.length;
      const i = jobAt.get(data.misses[miss].join("/"));
      if (i === undefined) return;
      const last = Math.max(jobs[i + 3], jobs[i + 4] < 0 ? end : jobs[i + 4]), room = (last - jobs[i + 2]) * 0.6;
      look(jobs[i + 2] - room, last + room);
    }
    const actions = {
      in: () => zoom(0.5, 0.5), out: () => zoom(2, 0.5), all: () => look(0, end),
      next: () => visit(1), previous: () => visit(-1),
      left: () => look(from - (until - from) * 0.2, until - (until - from) * 0.2),
      right: () => look(from + (until - from) * 0.2, until + (until - from) * 0.2),
    };
    const keys = { "+": "in", "=": "in", "-": "out", "0": "all", Home: "all", n: "next", p: "previous", ArrowLeft: "left", ArrowRight: "right" };
    canvas.addEventListener("keydown", (event) => {
      if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      actions[keys[event.key]]();
    });
    figure.querySelectorAll("button").forEach((button) => {
      button.addEventListener("click", () => actions[button.dataset.do]());
      if (!data.misses.length && /next|previous/.test(button.dataset.do)) button.hidden = true;
    });
    const point = (event) => {
      if (event.type === "pointermove" && !event.buttons) return;
      const box = overview.getBoundingClientRect(), ns = (event.clientX - box.left) / box.width * end;
      look(ns - (until - from) / 2, ns + (until - from) / 2);
    };
    overview.addEventListener("pointerdown", point);
    overview.addEventListener("pointermove", point);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (theme(), redraw()));
    window.addEventListener("resize", size);
    theme();
    size();
  });
})();
