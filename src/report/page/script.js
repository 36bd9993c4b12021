'use strict';
(function () {
const all = (root, what) => Array.from(root.querySelectorAll(what));

/// An element with attributes; its text or its children follow.
function made(name, attributes, ...inside) {
  const item = document.createElement(name);
  for (const [key, text] of Object.entries(attributes || {})) item.setAttribute(key, text);
  item.append(...inside);
  return item;
}
function drawn(svg, name, attributes) {
  const item = document.createElementNS(svg.namespaceURI, name);
  for (const [key, text] of Object.entries(attributes)) item.setAttribute(key, text);
  return item;
}

/// A quantity for people: four digits, and an SI prefix where its unit takes one.
function quantity(text, unit) {
  const v = Number(text);
  if (unit === '' || v === 0 || /^(%|deg|1)/.test(unit)) return Number(v.toPrecision(4)) + (unit ? ' ' + unit : '');
  const p = Math.min(3, Math.max(-4, Math.floor(Math.log10(Math.abs(v) * 1.0000001) / 3)));
  return Number((v / Math.pow(1000, p)).toPrecision(4)) + ' ' + ['p', 'n', 'u', 'm', '', 'k', 'M', 'G'][p + 4] + unit;
}

/// One of several figures at a time, chosen from a list.
all(document, '.choice').forEach(box => {
  const list = box.querySelector(':scope > label > select'), parts = all(box, ':scope > .option');
  if (!list) return;
  list.parentNode.hidden = false;
  const show = () => parts.forEach((p, i) => { p.hidden = i !== list.selectedIndex; });
  list.addEventListener('change', show);
  show();
});

/// What scrolls sideways scrolls by keys, too.
const scrolled = () => all(document, '.wide').forEach(w => {
  if (w.scrollWidth > w.clientWidth) for (const [k, v] of [['tabindex', '0'], ['role', 'region'], ['aria-label', 'Table']]) w.setAttribute(k, v);
});
scrolled();
addEventListener('resize', scrolled);

/// Round numbers between two values: 1, 2 or 5 times a power of ten apart.
function roundTicks(from, to, most) {
  const raw = (to - from) / most, power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = power * [1, 2, 5, 10].find(d => d * power >= raw * (1 - 1e-9)), ticks = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + 1e-9 * step; ++k) ticks.push(k * step);
  return ticks;
}
function logTicks(from, to) {
  const low = Math.floor(Math.log10(from) + 1e-9), high = Math.ceil(Math.log10(to) - 1e-9), ticks = [];
  if (to / from < 5) return roundTicks(from, to, 5);
  const every = Math.max(1, Math.ceil((high - low) / 5)), digits = high - low > 2 ? [1] : [1, 2, 5];
  for (let k = low; k <= high; k += every)
    for (const d of digits)
      if (d * Math.pow(10, k) >= from * (1 - 1e-9) && d * Math.pow(10, k) <= to * (1 + 1e-9)) ticks.push(d * Math.pow(10, k));
  return ticks;
}
function tickLabel(v) {
  const exponent = Math.round(Math.log10(Math.abs(v)));
  if (Math.abs(exponent) < 4 || Math.abs(v / Math.pow(10, exponent) - 1) > 1e-9) return String(Number(v.toPrecision(6)));
  return '10' + (exponent < 0 ? '\u207b' : '') + String(Math.abs(exponent)).replace(/./g, d => '\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079'[d]);
}

/// Zoom, values and switches of a picture with axes.
function enhanced(figure) {
  const svg = figure.querySelector('svg[data-units]'), axes = svg.querySelector('.axes');
  const units = svg.getAttribute('data-units').split('|');
  const [left, right, top, bottom] = axes.getAttribute('data-frame').split(' ').map(Number);
  const axis = ['data-abscissa', 'data-ordinate'].map(name => {
    const [from, to, log, unit] = axes.getAttribute(name).split(' ').map(Number);
    return {from, to, log, unit, value: part => log ? from * Math.pow(to / from, part) : from + part * (to - from)};
  });
  const whole = [0, 1, 0, 1], image = svg.querySelector('image[data-span]'), says = made('output');
  let view = whole.slice(), points = null, at = null, clip = null, pixels = null;

  // Original pixels to those of the view, and back.
  const part = (x, y) => [(x - left) / (right - left), (bottom - y) / (bottom - top)];
  const mapX = x => left + (part(x, 0)[0] - view[0]) / (view[1] - view[0]) * (right - left);
  const mapY = y => bottom - (part(0, y)[1] - view[2]) / (view[3] - view[2]) * (bottom - top);

  /// Each drawn item with the function that places it.
  function placers() {
    const out = [];
    all(svg, '[data-series] path, [data-series] circle, path.limit').forEach(item => {
      const d = item.getAttribute('d');
      if (item.matches('.mark')) {
        const a = d ? d.match(/^M(\S+) ([-\d.]+)/).slice(1).map(Number) : ['cx', 'cy'].map(n => Number(item.getAttribute(n)));
        out.push(() => item.setAttribute('transform', 'translate(' + (mapX(a[0]) - a[0]) + ' ' + (mapY(a[1]) - a[1]) + ')'));
      } else if (item.matches('.error')) {
        const [x, y, to] = d.match(/^M(\S+) (\S+?)h6m-3 0V(\S+?)m/).slice(1).map(Number);
        out.push(() => item.setAttribute('d', 'M' + (mapX(x + 3) - 3) + ' ' + mapY(y) + 'h6m-3 0V' + mapY(to) + 'm-3 0h6'));
      } else {
        out.push(() => item.setAttribute('d', d.replace(/([-\d.]+) ([-\d.]+)/g, (_, x, y) => mapX(x).toFixed(2) + ' ' + mapY(y).toFixed(2))));
      }
    });
    if (image) {
      const [x, y, w, h] = ['x', 'y', 'width', 'height'].map(n => Number(image.getAttribute(n)));
      out.push(() => {
        image.setAttribute('x', mapX(x)); image.setAttribute('width', mapX(x + w) - mapX(x));
        image.setAttribute('y', mapY(y)); image.setAttribute('height', mapY(y + h) - mapY(y));
      });
    }
    return out;
  }
  let place = null;

  function drawAxes() {
    let grid = '';
    all(axes, 'text').forEach(t => t.remove());
    axis.forEach((a, k) => {
      const from = a.value(view[2 * k]), to = a.value(view[2 * k + 1]);
      let free = -Infinity;
      (a.log ? logTicks(from, to) : roundTicks(from / a.unit, to / a.unit, 5).map(v => v * a.unit)).forEach(v => {
        const p = a.log ? Math.log(v / from) / Math.log(to / from) : (v - from) / (to - from);
        const label = tickLabel(v / a.unit), half = 3.3 * label.length;
        const x = left + p * (right - left), y = bottom - p * (bottom - top);
        grid += k ? 'M' + left + ' ' + y + 'H' + right : 'M' + x + ' ' + top + 'V' + bottom;
        if (!k && x - half < free) return;
        if (!k) free = x + half + 6;
        const text = drawn(svg, 'text', k ? {x: left - 4, y: y + 3.5, class: 'tick end'} : {x, y: bottom + 13, class: 'tick mid'});
        text.textContent = label;
        axes.appendChild(text);
      });
    });
    axes.querySelector('.grid').setAttribute('d', grid);
  }

  /// What the view shows is cut at the frame.
  function clipped() {
    clip = drawn(svg, 'svg', {x: left, y: top, width: right - left, height: bottom - top,
                              viewBox: [left, top, right - left, bottom - top].join(' ')});
    clip.style.width = 'auto';
    axes.after(clip);
    all(svg, '[data-series], path.limit, image[data-span]').forEach(item => { if (item.parentNode === svg) clip.appendChild(item); });
  }
  function draw() {
    if (!place) { known(); place = placers(); clipped(); }
    place.forEach(f => f());
    drawAxes();
    mark();
    reset.disabled = view.every((v, i) => v === whole[i]);
  }
  function show(x0, x1, y0, y1) {
    const least = 1e-4;  // of an axis: beyond, the six digits of the data are steps
    if (x1 - x0 < least || y1 - y0 < least) return;
    const within = (a, b) => b - a >= 1 ? [0, 1] : a < 0 ? [0, b - a] : b > 1 ? [1 - (b - a), 1] : [a, b];
    view = [...within(x0, x1), ...within(y0, y1)];
    draw();
  }
  function zoom(factor) {
    const middle = at && inside(at) ? part(at.px, at.py) : [(view[0] + view[1]) / 2, (view[2] + view[3]) / 2];
    show(middle[0] + (view[0] - middle[0]) * factor, middle[0] + (view[1] - middle[0]) * factor,
         middle[1] + (view[2] - middle[1]) * factor, middle[1] + (view[3] - middle[1]) * factor);
  }
  const inside = p => { const [u, v] = part(p.px, p.py); return u >= view[0] - 1e-6 && u <= view[1] + 1e-6 && v >= view[2] - 1e-6 && v <= view[3] + 1e-6; };

  /// All points with values, in original pixels; read once, when someone asks.
  function known() {
    if (points) return points;
    points = [];
    all(svg, '[data-series]').forEach(group => {
      const own = [], series = group.getAttribute('data-series');
      all(group, '[data-points]').forEach(l => {
        const pen = l.getAttribute('d').slice(1).split(/[ML]/);
        l.getAttribute('data-points').split(' ').forEach((t, i) => {
          const [x, y] = t.split(','), [px, py] = pen[i].split(' ').map(parseFloat);
          own.push({group, series, x, y, px, py});
        });
      });
      all(group, '[data-x]').forEach(m => {
        const d = m.getAttribute('d');
        const [px, py] = (d ? d.match(/^M(\S+) ([-\d.]+)/).slice(1) : [m.getAttribute('cx'), m.getAttribute('cy')]).map(Number);
        own.push({group, series, x: m.getAttribute('data-x'), y: m.getAttribute('data-y'), px, py});
      });
      if (own.length) points.push(own);
    });
    return points;
  }
  const visible = () => known().filter(own => own[0].group.style.display !== 'none');

  let ring = null;
  function mark() {
    if (ring) ring.remove();
    ring = null;
    if (!at || !inside(at)) return;
    ring = image ? drawn(svg, 'rect', {class: 'cursor', x: mapX(at.px - at.w / 2), y: mapY(at.py - at.h / 2), width: mapX(at.w) - mapX(0), height: mapY(at.h) - mapY(0)})
                 : drawn(svg, 'circle', {class: 'cursor', cx: mapX(at.px), cy: mapY(at.py), r: 6});
    svg.appendChild(ring);
  }
  function tell(point) {
    at = point;
    says.textContent = !at ? '' : image ? at.text : '\u2068' + at.series + '\u2069: ' + quantity(at.x, units[0]) + ', ' + quantity(at.y, units[1]);
    mark();
  }

  // A heat map is read back from its picture: a colour is a step of the scale.
  function readPixels(item, use) {
    const p = new Image();
    p.onload = () => {
      const c = made('canvas'), t = c.getContext('2d', {willReadFrequently: true});
      c.width = p.width; c.height = p.height;
      t.drawImage(p, 0, 0);
      use(t.getImageData(0, 0, c.width, c.height));
    };
    p.setAttribute('src', item.getAttribute('href'));
  }
  const box = image && ['x', 'y', 'width', 'height'].map(n => Number(image.getAttribute(n)));
  if (image) {
    const colour = (d, i) => d[4 * i] + ',' + d[4 * i + 1] + ',' + d[4 * i + 2];
    readPixels(svg.querySelector('image.scale'), b => {
      const steps = {};
      for (let i = 0; i < b.height; ++i) steps[colour(b.data, i)] = 1 - i / (b.height - 1);
      readPixels(image, g => { pixels = {g, step: i => g.data[4 * i + 3] === 0 ? null : steps[colour(g.data, i)]}; });
    });
  }
  function cell(column, row, u, v) {
    if (!pixels || column < 0 || row < 0 || column >= pixels.g.width || row >= pixels.g.height) return null;
    const step = pixels.step(row * pixels.g.width + column), span = image.getAttribute('data-span').split(' ').map(Number);
    const from = Number(image.getAttribute('data-from')), to = Number(image.getAttribute('data-to'));
    const w = box[2] / pixels.g.width, h = box[3] / pixels.g.height;
    return {column, row, w, h, px: box[0] + (column + .5) * w, py: box[1] + (row + .5) * h,
            text: quantity(span[0] + u * (span[1] - span[0]), units[0]) + ', ' + quantity(span[3] - v * (span[3] - span[2]), units[1]) + ': ' +
                  (step === null ? 'no configuration' : quantity(from + step * (to - from), image.getAttribute('data-unit')))};
  }

  const position = e => { const m = svg.getScreenCTM(); return [(e.clientX - m.e) / m.a, (e.clientY - m.f) / m.d]; };
  function nearest(x, y, reach) {
    if (image) {
      if (!pixels) return null;
      const [fx, fy] = [left + (view[0] + (x - left) / (right - left) * (view[1] - view[0])) * (right - left),
                        bottom - (view[2] + (bottom - y) / (bottom - top) * (view[3] - view[2])) * (bottom - top)];
      const u = (fx - box[0]) / box[2], v = (fy - box[1]) / box[3];
      return cell(Math.floor(u * pixels.g.width), Math.floor(v * pixels.g.height), u, v);
    }
    let best = null, near = reach * reach;
    visible().forEach(own => own.forEach(p => {
      const dx = mapX(p.px) - x, dy = mapY(p.py) - y, d = dx * dx + dy * dy;
      if (d < near && inside(p)) { near = d; best = p; }
    }));
    return best;
  }

  // Pointer: values, and a frame to zoom into. Fingers scroll the page; they have the buttons.
  let start = null, frame = null;
  svg.addEventListener('pointermove', e => {
    const [x, y] = position(e);
    if (!start) { tell(nearest(x, y, 18)); return; }
    if (!frame) svg.appendChild(frame = drawn(svg, 'rect', {class: 'window'}));
    const inX = Math.min(right, Math.max(left, x)), inY = Math.min(bottom, Math.max(top, y));
    for (const [n, v] of [['x', Math.min(start[0], inX)], ['y', Math.min(start[1], inY)], ['width', Math.abs(inX - start[0])], ['height', Math.abs(inY - start[1])]])
      frame.setAttribute(n, v);
  });
  svg.addEventListener('pointerdown', e => {
    const [x, y] = position(e);
    if (e.pointerType !== 'mouse' || e.button !== 0 || x < left || x > right || y < top || y > bottom) return;
    start = [x, y];
    svg.setPointerCapture(e.pointerId);
  });
  svg.addEventListener('pointerup', () => {
    if (frame) {
      const [x, y, w, h] = ['x', 'y', 'width', 'height'].map(n => Number(frame.getAttribute(n)));
      frame.remove();
      const u = p => view[0] + (p - left) / (right - left) * (view[1] - view[0]), v = p => view[2] + (bottom - p) / (bottom - top) * (view[3] - view[2]);
      if (w > 6 && h > 6) show(u(x), u(x + w), v(y + h), v(y));
    }
    start = frame = null;
  });
  svg.addEventListener('pointercancel', () => { if (frame) frame.remove(); start = frame = null; });
  svg.addEventListener('dblclick', () => show(...whole));

  // Keys: along a series, to the next one, zoom, all.
  function step(dx, dy) {
    if (image) {
      if (!pixels) return;
      const column = at ? at.column + dx : pixels.g.width >> 1, row = at ? at.row + dy : pixels.g.height >> 1;
      const next = cell(column, row, (column + .5) / pixels.g.width, (row + .5) / pixels.g.height);
      if (next) tell(next);
      return;
    }
    const lines = visible();
    if (!lines.length) return;
    let s = at ? lines.findIndex(own => own.includes(at)) : -1, i = s < 0 ? 0 : lines[s].indexOf(at);
    if (s < 0) s = 0;
    else if (dy) { s = (s + dy + lines.length) % lines.length; const x = at.px; i = lines[s].reduce((b, p, k) => Math.abs(p.px - x) < Math.abs(lines[s][b].px - x) ? k : b, 0); }
    else i = Math.min(lines[s].length - 1, Math.max(0, i + dx));
    tell(lines[s][i]);
    if (!inside(at)) { const [u, v] = part(at.px, at.py), w = (view[1] - view[0]) / 2, h = (view[3] - view[2]) / 2; show(u - w, u + w, v - h, v + h); }
  }
  svg.addEventListener('keydown', e => {
    const does = {ArrowRight: () => step(1, 0), ArrowLeft: () => step(-1, 0), ArrowDown: () => step(0, 1), ArrowUp: () => step(0, -1),
                  '+': () => zoom(.5), '=': () => zoom(.5), '-': () => zoom(2), '0': () => show(...whole), Escape: () => tell(null)}[e.key];
    if (!does || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    does();
  });

  const button = (text, label, does) => { const b = made('button', {type: 'button', 'aria-label': label, title: label}, text); b.addEventListener('click', does); return b; };
  const title = figure.querySelector('figcaption').textContent;
  const reset = button('Reset', 'Reset: ' + title, () => show(...whole));
  reset.disabled = true;
  const tools = made('div', {class: 'tools'}, says, button('+', 'Zoom into: ' + title, () => zoom(.5)), button('\u2212', 'Zoom out of: ' + title, () => zoom(2)), reset);
  svg.setAttribute('tabindex', '0');
  svg.setAttribute('role', 'application');
  svg.setAttribute('aria-roledescription', 'plot');
  svg.setAttribute('aria-label', title + '. Arrows read values, plus and minus zoom, 0 shows all.');
  svg.after(tools);

  const groups = all(svg, '[data-series]');
  if (groups.length > 1) all(figure, '.legend > li').slice(0, groups.length).forEach((li, i) => {
    const b = made('button', {type: 'button', 'aria-pressed': 'true'}, ...li.childNodes);
    b.addEventListener('click', () => {
      const on = b.getAttribute('aria-pressed') !== 'true';
      b.setAttribute('aria-pressed', on);
      groups[i].style.display = on ? '' : 'none';
      if (!on && at && at.group === groups[i]) tell(null);
    });
    li.append(b);
  });
}
all(document, 'figure').forEach(f => { if (f.querySelector('svg[data-units] .axes')) enhanced(f); });

/// The robot in three dimensions, its errors at the tip enlarged: orthographic, so that the outline of an ellipsoid of covariance C
/// is the ellipse of the projected P C P^T.
function scene(box) {
  const data = JSON.parse(box.querySelector('script').textContent), n = data.encoders.length;
  const times = (a, b) => {  // transforms as rows of [R p]
    const out = [];
    for (let r = 0; r < 3; ++r) for (let c = 0; c < 4; ++c)
      out.push(a[4 * r] * b[c] + a[4 * r + 1] * b[4 + c] + a[4 * r + 2] * b[8 + c] + (c === 3 ? a[4 * r + 3] : 0));
    return out;
  };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2], plus = (a, b, f) => [a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = a => { const l = Math.sqrt(dot(a, a)) || 1; return a.map(v => v / l); };
  const origin = t => [t[3], t[7], t[11]], turned = (t, a) => [0, 1, 2].map(r => t[4 * r] * a[0] + t[4 * r + 1] * a[1] + t[4 * r + 2] * a[2]);
  function rotation(a, angle) {  // Rodrigues
    const s = Math.sin(angle), c = Math.cos(angle), k = 1 - c, [x, y, z] = a;
    return [c + x * x * k, x * y * k - z * s, x * z * k + y * s, 0, y * x * k + z * s, c + y * y * k, y * z * k - x * s, 0, z * x * k - y * s, z * y * k + x * s, c + z * z * k, 0];
  }
  /// Joints with place and axis, and the tip, in the base frame [m].
  function posed(q) {
    let t = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
    const joints = data.joints.map(j => {
      t = times(t, j.origin);
      const at = origin(t), axis = turned(t, j.axis), value = j.multiplier * q[j.coordinate] + j.added;
      t = times(t, j.prismatic ? [1, 0, 0, value * j.axis[0], 0, 1, 0, value * j.axis[1], 0, 0, 1, value * j.axis[2]] : rotation(j.axis, value));
      return {joint: j, at, axis, after: origin(t)};
    });
    return {joints, tip: origin(times(t, data.tip))};
  }
  const poses = data.poses.map(p => {
    const q = p.slice(0, n), covariance = p.slice(-6), half = p.slice(n, -6);
    const [xx, xy, xz, yy, yz, zz] = covariance, b = half.length === 3 ? [half[0], 0, 0, 0, half[1], 0, 0, 0, half[2]] : half;
    const edges = [b.slice(0, 3), b.slice(3, 6), b.slice(6, 9)];
    return {q, covariance: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], edges, tip: posed(q).tip,
            worst: [0, 1, 2].map(k => edges.reduce((sum, e) => sum + Math.abs(e[k]), 0))};
  });
  const measures = [['sigma of xyz', p => Math.sqrt(p.covariance[0][0] + p.covariance[1][1] + p.covariance[2][2])],
                    ['worst case of x', p => p.worst[0]], ['worst case of y', p => p.worst[1]], ['worst case of z', p => p.worst[2]]];
  let measure = 0, chosen = 0, order = [], cut = {axis: -1, at: 0}, yaw = -.9, pitch = .42, scale = 1;
  const shows = {cloud: true, ellipsoid: true, box: true, axes: true, names: true};

  // The sphere that holds base, cloud and robot.
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  const include = p => p.forEach((v, k) => { low[k] = Math.min(low[k], v); high[k] = Math.max(high[k], v); });
  include([0, 0, 0]);
  poses.forEach(p => include(p.tip));
  posed(poses[0].q).joints.forEach(j => { include(j.at); include(j.after); });
  const centre = low.map((v, k) => (v + high[k]) / 2), radius = Math.sqrt(dot(plus(high, low, -1), plus(high, low, -1))) / 2 || 1;

  const canvas = made('canvas', {tabindex: '0', role: 'application', 'aria-roledescription': 'robot in three dimensions',
    'aria-label': 'The robot with its error at the tip. Arrows turn it, plus and minus zoom, 0 resets the view, n and p go to the next and previous configuration by error.'});
  const g = canvas.getContext('2d');
  let right, up, depth, w = 1, h = 1, perMetre = 1;
  function camera() {
    const s = Math.sin(yaw), c = Math.cos(yaw);
    depth = [c * Math.cos(pitch), s * Math.cos(pitch), Math.sin(pitch)];  // to the eye
    right = [-s, c, 0];
    up = cross(depth, right);
    perMetre = scale * Math.min(w, h) / (1.75 * radius);
  }
  const project = p => { const d = plus(p, centre, -1); return [w / 2 + perMetre * dot(d, right), h / 2 - perMetre * dot(d, up), dot(d, depth)]; };
  const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  function colour(part) {
    const x = Math.min(1, Math.max(0, part)) * (data.colours.length - 1), k = Math.min(data.colours.length - 2, Math.floor(x));
    return 'rgb(' + data.colours[k].map((v, i) => Math.round(v + (x - k) * (data.colours[k + 1][i] - v))).join() + ')';
  }
  function path(points, close) {
    g.beginPath();
    points.forEach((p, i) => { const [x, y] = project(p); if (i) g.lineTo(x, y); else g.moveTo(x, y); });
    if (close) g.closePath();
  }
  const stroke = (style, width, dash) => { g.strokeStyle = style; g.lineWidth = width; g.setLineDash(dash || []); g.stroke(); g.setLineDash([]); };
  function text(what, x, y, style, align) {
    g.textAlign = align || 'left';
    g.lineWidth = 3; g.lineJoin = 'round'; g.strokeStyle = css('--card'); g.strokeText(what, x, y);
    g.fillStyle = style; g.fillText(what, x, y);
  }
  /// The disc around a joint's axis, or the square of a prismatic one.
  function outline(at, axis, size, sides) {
    const first = unit(cross(axis, Math.abs(axis[2]) < .9 ? [0, 0, 1] : [1, 0, 0])), second = cross(axis, first), points = [];
    for (let i = 0; i < sides; ++i) { const t = 2 * Math.PI * (i + .5) / sides; points.push(plus(plus(at, first, size * Math.cos(t)), second, size * Math.sin(t))); }
    return points;
  }
  function drawJoint(j) {
    // A cylinder is all between its two ends, seen: the far end, the side, the near end.
    const size = radius * .04, ends = [plus(j.at, j.axis, -1.2 * size), plus(j.at, j.axis, 1.2 * size)], sides = j.joint.prismatic ? 4 : 28;
    if (dot(j.axis, depth) < 0) ends.reverse();
    const [far, near] = ends.map(e => outline(e, j.axis, size, sides)), style = css(j.joint.prismatic ? '--c2' : '--c0'), edge = css('--paper');
    const light = unit(plus(plus(up, depth, .8), right, -.6)), centreNear = plus(j.at, j.axis, dot(j.axis, depth) < 0 ? -1.2 * size : 1.2 * size);
    for (let i = 0; i < sides; ++i) {
      const k = (i + 1) % sides, normal = unit(plus(plus(near[i], near[k], 1), centreNear, -2)), bright = dot(normal, light);
      if (dot(normal, depth) < 0) continue;
      path([far[i], far[k], near[k], near[i]], true);
      g.fillStyle = style; g.fill(); stroke(style, 1);
      g.fillStyle = bright > 0 ? 'rgba(255,255,255,' + .35 * bright + ')' : 'rgba(0,0,0,' + -.35 * bright + ')'; g.fill();
    }
    path(near, true); g.fillStyle = style; g.fill(); stroke(edge, 1.2);
  }
  function drawLink(a, b) {
    const width = Math.max(6, perMetre * radius * .055);
    path([a, b]); stroke(css('--soft'), width + 2);
    g.lineCap = 'round';  // over the edges of the piece before
    path([a, b]); stroke(css('--grid'), width);
    g.lineCap = 'butt';
  }
  function drawError(p, tip) {
    const bounds = p.edges.flat().every(Number.isFinite);
    if (shows.box && bounds) {
      const corner = i => p.edges.reduce((at, e, k) => plus(at, e, (i >> k & 1 ? 1 : -1) * data.factor), tip);
      for (let i = 0; i < 8; ++i) for (const bit of [1, 2, 4]) if (!(i & bit)) { path([corner(i), corner(i | bit)]); stroke(css('--c2'), 1.6, [6, 3]); }
    }
    if (shows.ellipsoid) {
      const C = v => p.covariance.map(row => dot(row, v)), a = dot(right, C(right)), b = dot(right, C(up)), c = dot(up, C(up));
      const mean = (a + c) / 2, spread = Math.hypot((a - c) / 2, b), [x, y] = project(tip), k = data.factor * perMetre;
      g.beginPath();
      g.ellipse(x, y, Math.max(.5, k * Math.sqrt(mean + spread)), Math.max(.5, k * Math.sqrt(Math.max(0, mean - spread))), -Math.atan2(2 * b, a - c) / 2, 0, 2 * Math.PI);
      g.globalAlpha = .35; g.fillStyle = css('--c1'); g.fill(); g.globalAlpha = 1;
      stroke(css('--c1'), 2);
    }
  }
  const kept = p => cut.axis < 0 || p.tip[cut.axis] >= cut.at;
  function range() {
    const values = poses.map(measures[measure][1]).filter(Number.isFinite);
    return values.length ? [Math.min(...values), Math.max(...values)] : [0, 1];
  }
  function drawFloor() {
    const raw = radius / 3, power = Math.pow(10, Math.floor(Math.log10(raw))), step = power * [1, 2, 5].reduce((b, d) => d * power <= raw ? d : b, 1), z = Math.min(0, low[2]);
    const x0 = Math.floor(low[0] / step), x1 = Math.ceil(high[0] / step), y0 = Math.floor(low[1] / step), y1 = Math.ceil(high[1] / step);
    for (let i = x0; i <= x1; ++i) { path([[i * step, y0 * step, z], [i * step, y1 * step, z]]); stroke(css('--grid'), 1); }
    for (let i = y0; i <= y1; ++i) { path([[x0 * step, i * step, z], [x1 * step, i * step, z]]); stroke(css('--grid'), 1); }
    const end = project([0, 0, 0]);
    ['x', 'y', 'z'].forEach((name, k) => {
      const to = [0, 0, 0]; to[k] = radius * .22;
      path([[0, 0, 0], to]); stroke(css(['--c1', '--c2', '--c0'][k]), 2);
      const [x, y] = project(to);
      text(name, x + 5 * Math.sign(x - end[0]), y, css('--ink'), 'center');
    });
    return step;
  }
  function drawScales(step) {
    const [from, to] = range(), x = w - 22, tall = Math.min(170, h * .35);
    for (let i = 0; i < tall; ++i) { g.fillStyle = colour(1 - i / tall); g.fillRect(x, 34 + i, 10, 1.5); }
    text(measures[measure][0], w - 10, 14, css('--ink'), 'right');
    text(quantity(to, 'm'), w - 10, 28, css('--soft'), 'right');
    text(quantity(from, 'm'), w - 10, 34 + tall + 13, css('--soft'), 'right');
    text('squares of ' + quantity(step, 'm') + '; errors drawn ' + Number(data.factor.toPrecision(3)) + ' times larger', 10, h - 10, css('--soft'));
  }
  let waits = false;
  function draw() {
    waits = false;
    const ratio = window.devicePixelRatio || 1;
    w = canvas.clientWidth || 600; h = canvas.clientHeight || 400;
    if (canvas.width !== Math.round(w * ratio)) canvas.width = Math.round(w * ratio);
    if (canvas.height !== Math.round(h * ratio)) canvas.height = Math.round(h * ratio);
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, w, h);
    g.font = '12px system-ui, sans-serif';
    camera();
    const step = drawFloor(), pose = poses[chosen], body = posed(pose.q), [from, to] = range(), items = [];
    if (shows.cloud) poses.forEach((p, i) => { if (kept(p)) items.push([project(p.tip)[2], () => {
      const [x, y] = project(p.tip);
      g.beginPath(); g.arc(x, y, i === chosen ? 6 : 3.2, 0, 2 * Math.PI);
      g.fillStyle = colour((measures[measure][1](p) - from) / (to - from || 1)); g.globalAlpha = .6; g.fill(); g.globalAlpha = 1;
    }]); });
    // Long links in pieces, so that the cloud hides what is behind it.
    const places = [[0, 0, 0], ...body.joints.flatMap(j => [j.at, j.after]), body.tip];
    for (let i = 1; i < places.length; ++i) {
      const a = places[i - 1], b = places[i], d = plus(b, a, -1), pieces = Math.ceil(Math.sqrt(dot(d, d)) / radius * 6);
      for (let k = 0; k < pieces; ++k) {
        const from = plus(a, d, k / pieces), to = plus(a, d, (k + 1) / pieces);
        items.push([project(plus(a, d, (k + .5) / pieces))[2], () => drawLink(from, to)]);
      }
    }
    body.joints.forEach(j => items.push([project(j.at)[2] + radius * .03, () => drawJoint(j)]));
    items.sort((a, b) => a[0] - b[0]).forEach(i => i[1]());
    if (shows.axes) body.joints.forEach(j => { path([plus(j.at, j.axis, -radius * .14), plus(j.at, j.axis, radius * .14)]); stroke(css('--ink'), 1.2, [7, 3, 2, 3]); });
    drawError(pose, body.tip);
    if (shows.names) {
      const taken = [];
      body.joints.forEach(j => {
        let [x, y] = project(j.at);
        x += 14;
        const wide = g.measureText(j.joint.name).width;
        while (taken.some(t => x < t[0] + t[2] + 4 && t[0] < x + wide + 4 && Math.abs(t[1] - y) < 13)) y -= 13;
        taken.push([x, y, wide]);
        text(j.joint.name, x, y + 4, css('--ink'));
      });
      const [x, y] = project(body.tip);
      text('tip', x + 10, y + 18, css('--ink'));
    }
    drawScales(step);
  }
  const later = () => { if (!waits) { waits = true; requestAnimationFrame(draw); } };

  // The panel.
  const list = (label, names, does) => {
    const s = made('select', {}, ...names.map(name => made('option', {}, name)));
    s.addEventListener('change', () => does(s.selectedIndex));
    return [made('label', {}, label, ' ', s), s];
  };
  const [poseLabel, poseList] = list('Configuration', ['largest variance', 'median variance', 'chosen by error'], i => { choose(i < 2 ? i : order[Number(slider.value)]); poseList.selectedIndex = i; });
  const slider = made('input', {type: 'range', min: 0, max: poses.length - 1, step: 1, value: 0});
  slider.addEventListener('input', () => choose(order[Number(slider.value)]));
  const [measureLabel] = list('Colour and order', measures.map(m => m[0]), i => { measure = i; sort(); choose(chosen); });
  const at = made('input', {type: 'range', min: 0, max: 100, value: 50, disabled: 'disabled'});
  const [cutLabel, cutList] = list('Cut the cloud', ['nowhere', 'across x', 'across y', 'across z'], () => { move(); });
  function move() {
    cut.axis = cutList.selectedIndex - 1;
    at.disabled = cut.axis < 0;
    if (cut.axis >= 0) cut.at = low[cut.axis] + Number(at.value) / 100 * (high[cut.axis] - low[cut.axis]);
    atText.textContent = cut.axis < 0 ? 'Cut at' : 'Cut at ' + 'xyz'[cut.axis] + ' = ' + quantity(cut.at, 'm') + ', shown above it';
    later();
  }
  at.addEventListener('input', move);
  const atText = made('span', {}, 'Cut at');
  const boxes = made('div', {class: 'boxes'}, ...Object.keys(shows).map(name => {
    const b = made('input', {type: 'checkbox', checked: 'checked'});
    b.addEventListener('change', () => { shows[name] = b.checked; later(); });
    return made('label', {}, b, ' ' + name);
  }));
  const turns = made('div', {class: 'boxes'}, ...[['front', -Math.PI / 2, 0], ['side', 0, 0], ['top', -Math.PI / 2, Math.PI / 2 - 1e-3], ['free', -.9, .42]].map(([name, a, b]) => {
    const item = made('button', {type: 'button', 'aria-label': 'View from: ' + name}, name);
    item.addEventListener('click', () => { yaw = a; pitch = b; scale = 1; later(); });
    return item;
  }));
  const says = made('output');
  function sort() {
    const value = measures[measure][1];
    order = poses.map((_, i) => i).sort((a, b) => value(poses[a]) - value(poses[b]) || a - b);
  }
  function choose(i) {
    chosen = i;
    slider.value = order.indexOf(i);
    poseList.selectedIndex = i < 2 ? i : 2;
    const p = poses[i], row = (...cells) => made('tr', {}, ...cells.map((c, k) => made(k ? 'td' : 'th', k ? {} : {scope: 'row'}, c)));
    const head = made('tr', {}, ...['', 'x', 'y', 'z'].map(c => made(c ? 'th' : 'td', c ? {scope: 'col'} : {}, c)));
    says.replaceChildren(
      made('div', {}, data.encoders.map((e, k) => e.name + ' ' + (e.prismatic ? quantity(p.q[k], 'm') : (p.q[k] * 180 / Math.PI).toFixed(1) + ' deg')).join(', ') + (data.rows[i] ? '; row ' + data.rows[i] + ' of --per-configuration' : '')),
      made('table', {}, head, row('tip', ...p.tip.map(v => quantity(v, 'm'))),
           row('sigma', ...[0, 1, 2].map(k => quantity(Math.sqrt(p.covariance[k][k]), 'm'))),
           row('worst', ...p.worst.map(v => Number.isFinite(v) ? quantity(v, 'm') : 'unbounded'))));
    later();
  }
  const sliderLabel = made('label', {}, 'From the least to the largest', slider);
  box.append(canvas, made('div', {class: 'panel'}, turns, poseLabel, sliderLabel, says, measureLabel, cutLabel, made('label', {}, atText, at), boxes));

  // Pointer and keys.
  let from = null, moved = false;
  const turn = (a, b) => { yaw += a; pitch = Math.min(Math.PI / 2 - 1e-3, Math.max(-Math.PI / 2 + 1e-3, pitch + b)); later(); };
  const zoom = f => { scale = Math.min(20, Math.max(.3, scale * f)); later(); };
  canvas.addEventListener('pointerdown', e => { from = [e.clientX, e.clientY]; moved = false; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener('pointermove', e => {
    if (!from) return;
    const dx = e.clientX - from[0], dy = e.clientY - from[1];
    if (Math.abs(dx) + Math.abs(dy) < 3 && !moved) return;
    moved = true;
    turn(-.008 * dx, .008 * dy);
    from = [e.clientX, e.clientY];
  });
  canvas.addEventListener('pointerup', e => {
    if (from && !moved) {
      const r = canvas.getBoundingClientRect();
      let best = -1, near = 150;
      poses.forEach((p, i) => { if (!kept(p)) return; const [x, y] = project(p.tip), d = (x - e.clientX + r.left) ** 2 + (y - e.clientY + r.top) ** 2; if (d < near) { near = d; best = i; } });
      if (best >= 0) choose(best);
    }
    from = null;
  });
  canvas.addEventListener('pointercancel', () => { from = null; });
  const next = by => choose(order[Math.min(order.length - 1, Math.max(0, order.indexOf(chosen) + by))]);
  canvas.addEventListener('keydown', e => {
    const does = {ArrowLeft: () => turn(.1, 0), ArrowRight: () => turn(-.1, 0), ArrowUp: () => turn(0, -.1), ArrowDown: () => turn(0, .1), '+': () => zoom(1.25), '=': () => zoom(1.25), '-': () => zoom(.8),
                  '0': () => { yaw = -.9; pitch = .42; scale = 1; later(); }, n: () => next(1), p: () => next(-1)}[e.key];
    if (!does || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    does();
    canvas.setAttribute('data-view', [yaw, pitch, scale].map(v => v.toFixed(3)).join(' '));
  });
  addEventListener('resize', later);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', later);
  box.hidden = false;
  box.parentNode.querySelector('.views').classList.add('flat');
  sort();
  choose(0);
}
all(document, '.scene').forEach(scene);
})();
