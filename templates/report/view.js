"use strict";
// Spheres at true size on a 2-D canvas: each is drawn pixel by pixel into a depth buffer, so that no graphics
// card is needed and spheres interpenetrate, hide and are cut exactly.
(() => {
  const data = JSON.parse(document.getElementById("view-data").textContent);
  const canvas = document.getElementById("view");
  const context = canvas.getContext("2d", {willReadFrequently: true});  // kept in main memory, where it is drawn
  const say = document.getElementById("view-legend");
  const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
  const count = data.shown;
  const place = new Uint16Array(bytes(data.place)), size = new Uint8Array(bytes(data.size));
  const body = new Uint8Array(data.body ? bytes(data.body) : 0);
  const sphere = new Float32Array(4 * count), label = new Int32Array(3 * count);
  const middle = new Uint16Array(data.depth ? bytes(data.depth) : 0);  // the cut shows or hides a body as a whole
  const depthOf = i => data.span[1] * (middle[i] / 32767.5 - 1);
  const ratio = data.radius_min > 0 ? data.radius_max / data.radius_min : 1;
  for (let i = 0; i < count; i++) {
    for (let axis = 0; axis < 3; axis++)
      sphere[4 * i + axis] = data.span[axis] * (place[3 * i + axis] / 32767.5 - 1);
    sphere[4 * i + 3] = data.radius_min * ratio ** (size[i] / 255);
  }
  let overhang = 0;  // how far spheres are from the middles of their bodies
  for (let i = 0; i < middle.length; i++) overhang = Math.max(overhang, Math.abs(depthOf(i) - sphere[4 * i + 1]));
  let filled = 0;
  for (const [run, ...names] of data.labels) for (const end = filled + run; filled < end; filled++) label.set(names, 3 * filled);
  const start = {azimuth: -0.5, elevation: 0.3, zoom: 1, x: 0, y: 0};
  const camera = {...start};
  const choice = {}, absent = {value: "set", setAttribute() {}, addEventListener() {}};  // a plan has no such choice
  for (const name of ["colour", "cut", "cut-at", "cut-says"]) choice[name] = document.getElementById(name) || absent;
  const frame = data.frame || {half: data.half, middle: [0, 0, 0]};  // what is to be seen, bed and outlines
  const outlines = (data.outlines || []).map(each => ({...each, ends: new Float32Array(bytes(each.ends))}));
  const kinds = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#777777"];
  const ramp = ["#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725"];
  const channels = hex => [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16));
  const red = new Float32Array(count), green = new Float32Array(count), blue = new Float32Array(count);
  let depth = new Float32Array(0), image = null, pixels = null, waiting = 0, finer = 0, slow = false;

  function along(share) {
    const at = Math.min(Math.max(share, 0), 1) * (ramp.length - 1), low = Math.min(Math.floor(at), ramp.length - 2);
    const from = channels(ramp[low]), to = channels(ramp[low + 1]);
    return from.map((value, place) => value + (at - low) * (to[place] - value));
  }

  function paint() {
    const by = choice.colour.value, column = {set: 0, zone: 1, body: 1, batch: 2}[by];
    let low = Infinity, high = -Infinity;
    const value = new Float32Array(count), seen = new Set();
    for (let i = 0; i < count; i++) {
      value[i] = by === "radius" ? sphere[4 * i + 3] : by === "body" ? body[i] : label[3 * i + column];
      low = Math.min(low, value[i]); high = Math.max(high, value[i]);
      if (column < 2) seen.add(value[i]);
    }
    const scale = high > low ? 1 / (high - low) : 0;
    for (let i = 0; i < count; i++) {
      const mix = column < 2 ? channels(kinds[value[i] % kinds.length]) : along((value[i] - low) * scale);
      red[i] = mix[0]; green[i] = mix[1]; blue[i] = mix[2];
    }
    say.replaceChildren();
    const entry = (colour, text) => {
      const item = document.createElement("span"), patch = document.createElement("i");
      patch.style.background = colour;
      item.append(patch, text);
      say.append(item);
    };
    if (by === "body") entry(`linear-gradient(90deg, ${kinds.join(",")})`, "a body has one colour");
    else if (column < 2) {
      for (const each of [...seen].sort((a, b) => a - b))
        entry(kinds[each % kinds.length], by === "set" ? data.sets[each] || `set ${each}` : `zone ${each}`);
    } else {
      const unit = by === "radius" ? " m" : "", name = by === "radius" ? "radius " : "batch ";
      if (by === "radius") { low = data.radius_min; high = data.radius_max; }
      entry(`linear-gradient(90deg, ${ramp.join(",")})`,
            `${name}${Number(low.toPrecision(4))} to ${Number(high.toPrecision(4))}${unit}`);
      say.firstChild.firstChild.style.width = "6em";
    }
    for (const each of outlines) entry(each.colour, each.name);
    draw(1);
  }

  function resize(fineness) {
    const box = canvas.getBoundingClientRect();
    const scale = fineness * Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(Math.round(box.width * scale), 1), height = Math.max(Math.round(box.height * scale), 1);
    if (image && canvas.width === width && canvas.height === height) return;
    canvas.width = width; canvas.height = height;
    image = context.createImageData(width, height);
    pixels = new Uint32Array(image.data.buffer);
    depth = new Float32Array(width * height);
  }

  function render(fineness) {
    resize(fineness);
    const width = canvas.width, height = canvas.height;
    pixels.fill(0); depth.fill(-1e30);
    const sa = Math.sin(camera.azimuth), ca = Math.cos(camera.azimuth);
    const se = Math.sin(camera.elevation), ce = Math.cos(camera.elevation);
    // Rows of the turned frame: right, up, towards the viewer; the bed's y points away, its z up.
    const rx = ca, ry = sa, vx = sa * ce, vy = -ca * ce, vz = se, ux = -sa * se, uy = ca * se, uz = ce;
    const half = data.half, whole = frame.half, flat = Math.hypot(whole[0], whole[1]), [mx, my, mz] = frame.middle;
    const scale = camera.zoom * 0.94 / Math.max(flat / (width / 2), (whole[2] * ce + flat * Math.abs(se)) / (height / 2), 1e-30);
    const across = width / 2 + camera.x * width - (rx * mx + ry * my) * scale;
    const down = height / 2 + camera.y * height + (ux * mx + uy * my + uz * mz) * scale;
    const cut = choice.cut.checked, plane = half[1] * (choice["cut-at"].value / 50 - 1) * scale;
    // The part with y below the plane is taken away: its outward direction in the turned frame.
    const a = -ry, b = -uy, c = -vy;
    const lx = -0.4, ly = 0.55, lz = 0.73, reach = Math.hypot(...half) * scale;
    // Spheres inside the bed are seen in the cut only, and through its gaps.
    const behind = cut ? plane + (8 * data.radius_max + overhang) * scale : -Infinity;
    for (let i = 0; i < count; i++) {
      const y = sphere[4 * i + 1] * scale;
      if (i >= data.outer && y > behind) continue;
      const x = sphere[4 * i] * scale, z = sphere[4 * i + 2] * scale;
      const r = Math.max(sphere[4 * i + 3] * scale, 0.6);
      if (cut && (middle.length ? depthOf(i) * scale < plane : y < plane - r)) continue;
      const px = across + rx * x + ry * y, py = down - (ux * x + uy * y + uz * z), pz = vx * x + vy * y + vz * z;
      if (px + r < 0 || px - r > width || py + r < 0 || py - r > height) continue;
      const split = cut && !middle.length && y < plane + r;
      const top = Math.max(Math.ceil(py - r), 0), bottom = Math.min(Math.floor(py + r), height - 1);
      for (let row = top; row <= bottom; row++) {
        const dy = py - row, wide = Math.sqrt(Math.max(r * r - dy * dy, 0));
        const first = Math.max(Math.ceil(px - wide), 0), last = Math.min(Math.floor(px + wide), width - 1);
        for (let column = first; column <= last; column++) {
          const dx = column - px;
          let dz = Math.sqrt(Math.max(r * r - dx * dx - dy * dy, 0)), face = false;
          if (split) {
            const outside = plane - y + a * dx + b * dy + c * dz;
            if (outside > 0) {
              if (c <= 1e-9) continue;
              const back = outside / c;
              if (back > 2 * dz) continue;
              dz -= back; face = true;
            }
          }
          const at = row * width + column, near = pz + dz;
          if (near <= depth[at]) continue;
          depth[at] = near;
          let light;
          if (face) {
            const edge = (dx * dx + dy * dy + dz * dz) / (r * r);
            light = edge > 0.85 && r > 3 ? 0.62 : 1.02;
          } else {
            light = 0.38 + 0.62 * Math.max((lx * dx + ly * dy + lz * dz) / r, 0);
            if (dz < 0.3 * r) light *= 0.72;
          }
          light *= 0.86 + 0.14 * near / reach;
          pixels[at] = 0xff000000 | Math.min(blue[i] * light, 255) << 16 |
            Math.min(green[i] * light, 255) << 8 | Math.min(red[i] * light, 255);
        }
      }
    }
    for (const each of outlines) {
      const [lr, lg, lb] = channels(each.colour), colour = 0xff000000 | lb << 16 | lg << 8 | lr, ends = each.ends;
      const turned = at => {
        const x = ends[at] * scale, y = ends[at + 1] * scale, z = ends[at + 2] * scale;
        return [across + rx * x + ry * y, down - (ux * x + uy * y + uz * z), vx * x + vy * y + vz * z];
      };
      for (let at = 0; at < ends.length; at += 6) line(turned(at), turned(at + 3), width, height, colour);
    }
    context.putImageData(image, 0, 0);
    canvas.dataset.azimuth = camera.azimuth.toFixed(3);
    canvas.dataset.drawn = String(Number(canvas.dataset.drawn || 0) + 1);
  }

  // A line where no sphere is nearer; what lies outside the picture is left out first.
  function line([ax, ay, az], [bx, by, bz], width, height, colour) {
    let from = 0, to = 1;
    for (const [start, step, most] of [[ax, bx - ax, width - 1], [ay, by - ay, height - 1]]) {
      if (step === 0) { if (start < 0 || start > most) return; continue; }
      const first = -start / step, last = (most - start) / step;
      from = Math.max(from, Math.min(first, last)); to = Math.min(to, Math.max(first, last));
    }
    if (from > to) return;
    const steps = Math.max(Math.ceil((to - from) * Math.max(Math.abs(bx - ax), Math.abs(by - ay))), 1);
    for (let step = 0; step <= steps; step++) {
      const t = from + (to - from) * step / steps;
      const column = Math.min(Math.max(Math.round(ax + t * (bx - ax)), 0), width - 1);
      const at = Math.min(Math.max(Math.round(ay + t * (by - ay)), 0), height - 1) * width + column;
      if (az + t * (bz - az) + 1 >= depth[at]) pixels[at] = colour;
    }
  }

  // Coarse while it moves on a slow machine, fine again soon after.
  function draw(fineness) {
    clearTimeout(finer);
    if (fineness < 1) finer = setTimeout(() => draw(1), 160);
    if (!waiting) requestAnimationFrame(() => {
      const now = waiting, from = performance.now();
      waiting = 0;
      render(now);
      slow = performance.now() - from > 40 || (now < 1 && slow);
    });
    waiting = Math.max(waiting, fineness);
  }
  const moved = () => draw(slow ? 0.5 : 1);

  function turn(azimuth, elevation) {
    camera.azimuth += azimuth;
    camera.elevation = Math.min(Math.max(camera.elevation + elevation, -Math.PI / 2), Math.PI / 2);
    moved();
  }
  function zoom(factor) { camera.zoom = Math.min(Math.max(camera.zoom * factor, 0.2), 60); moved(); }

  const held = new Map();
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, event => held.delete(event.pointerId));
  canvas.addEventListener("pointermove", event => {
    const former = held.get(event.pointerId);
    if (!former) return;
    const dx = event.clientX - former[0], dy = event.clientY - former[1];
    const box = canvas.getBoundingClientRect();
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const was = Math.hypot(former[0] - other[0], former[1] - other[1]);
      zoom(Math.hypot(event.clientX - other[0], event.clientY - other[1]) / Math.max(was, 1));
    } else if (event.shiftKey) {
      camera.x += dx / box.width; camera.y += dy / box.height; moved();
    } else turn(-dx * 0.008, dy * 0.008);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("wheel", event => { event.preventDefault(); zoom(Math.exp(-event.deltaY * 0.0012)); }, {passive: false});
  const reset = () => { Object.assign(camera, start); draw(1); };
  canvas.addEventListener("dblclick", reset);
  const keys = {
    ArrowLeft: () => turn(0.12, 0), ArrowRight: () => turn(-0.12, 0), ArrowUp: () => turn(0, 0.12),
    ArrowDown: () => turn(0, -0.12), "+": () => zoom(1.2), "=": () => zoom(1.2), "-": () => zoom(1 / 1.2), Home: reset,
  };
  canvas.addEventListener("keydown", event => {
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  });
  const looks = {front: [0, 0], side: [-Math.PI / 2, 0], top: [0, Math.PI / 2], reset: null};
  for (const [name, angles] of Object.entries(looks)) {
    document.getElementById(`look-${name}`).addEventListener("click", () => {
      Object.assign(camera, start);
      if (angles) [camera.azimuth, camera.elevation] = angles;
      draw(1);
    });
  }
  choice.colour.addEventListener("change", paint);
  function cutMoved() {
    const share = Number(choice["cut-at"].value);
    const text = !choice.cut.checked ? "whole" : share === 50 ? "in half" : `${share} % taken away`;
    choice["cut-at"].disabled = !choice.cut.checked;
    choice["cut-at"].setAttribute("aria-valuetext", text);
    choice["cut-says"].textContent = text;
  }
  choice.cut.addEventListener("change", () => { cutMoved(); draw(1); });
  choice["cut-at"].addEventListener("input", () => { cutMoved(); moved(); });
  window.addEventListener("resize", () => draw(1));
  document.getElementById("view-section").hidden = false;
  cutMoved();
  paint();
})();
