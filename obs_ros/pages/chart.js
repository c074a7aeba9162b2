/* One panel: curves with bands over time, jumps, and the time under the cursor. */

const MARGIN = { left: 58, right: 10, top: 6, bottom: 20 };

function theme() {
  const style = getComputedStyle(document.documentElement);
  const colour = name => style.getPropertyValue(`--${name}`).trim();
  return {
    colour, ink: colour('ink'), soft: colour('soft'), grid: colour('grid'), line: colour('line'),
    card: colour('card'), measured: colour('measured'), truth: colour('truth'),
    jump: colour('jump'), shade: colour('shade'), of: k => colour(`c${k % 6}`),
  };
}

/* The canvas's context in CSS pixels, cleared, at the screen's resolution. */
function prepared(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth || 400, height = canvas.clientHeight || 130;
  const wide = Math.round(width * ratio), high = Math.round(height * ratio);
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "11px system-ui, 'DejaVu Sans', sans-serif";
  return { context, width, height };
}

function frameOf(width, height, view, range) {
  const w = Math.max(width - MARGIN.left - MARGIN.right, 1);
  const h = Math.max(height - MARGIN.top - MARGIN.bottom, 1);
  const span = view.to - view.from || 1, [low, high] = range;
  return {
    x: t => MARGIN.left + (t - view.from) / span * w,
    y: v => MARGIN.top + (high - v) / (high - low) * h,
    t: x => view.from + (x - MARGIN.left) / w * span,
    left: MARGIN.left, right: MARGIN.left + w, top: MARGIN.top, bottom: MARGIN.top + h,
  };
}

function drawAxes(context, frame, view, range, colours) {
  context.lineWidth = 1;
  context.strokeStyle = colours.grid;
  context.fillStyle = colours.soft;
  const across = ticks(view.from, view.to, (frame.right - frame.left) / 90);
  context.textAlign = 'center';
  context.textBaseline = 'top';
  context.beginPath();
  for (const t of across.found) {
    context.moveTo(Math.round(frame.x(t)) + 0.5, frame.top);
    context.lineTo(Math.round(frame.x(t)) + 0.5, frame.bottom);
    const room = frame.x(t) < frame.right - 14;
    if (room) context.fillText(label(t, across.step), frame.x(t), frame.bottom + 5);
  }
  context.textAlign = 'right';
  context.fillText('s', frame.right, frame.bottom + 5);
  const up = ticks(range[0], range[1], (frame.bottom - frame.top) / 24);
  context.textBaseline = 'middle';
  for (const v of up.found) {
    context.moveTo(frame.left, Math.round(frame.y(v)) + 0.5);
    context.lineTo(frame.right, Math.round(frame.y(v)) + 0.5);
    context.fillText(label(v, up.step), frame.left - 6, frame.y(v));
  }
  context.stroke();
  context.strokeStyle = colours.line;
  context.strokeRect(frame.left + 0.5, frame.top + 0.5, frame.right - frame.left - 1,
    frame.bottom - frame.top - 1);
}

/* A line through the points: interrupted at what is not known, and where an angle wraps. */
function trace(context, frame, curve, period, hold) {
  let previous = null;
  context.beginPath();
  for (let k = 0; k < curve.t.length; k++) {
    const v = curve.v[k];
    if (v === null) {
      previous = null;
      continue;
    }
    const x = frame.x(curve.t[k]), y = frame.y(v);
    if (previous === null || (period && Math.abs(v - previous) > period / 2)) {
      context.moveTo(x, y);
    } else {
      if (hold) context.lineTo(x, frame.y(previous));
      context.lineTo(x, y);
    }
    previous = v;
  }
  context.stroke();
}

/* The area between the edges, a part for each stretch in which both are known. */
function drawBand(context, frame, band, colour) {
  const known = k => k < band.t.length && band.lower[k] !== null && band.upper[k] !== null;
  context.fillStyle = colour;
  context.globalAlpha = 0.2;
  for (let begin = 0; begin < band.t.length; begin++) {
    if (!known(begin)) continue;
    let end = begin;
    while (known(end + 1)) end++;
    const x = k => frame.x(band.t[k]);
    if (begin === end) {
      const top = frame.y(band.upper[begin]);
      context.fillRect(x(begin) - 2, top, 4, frame.y(band.lower[begin]) - top);
    } else {
      context.beginPath();
      for (let k = begin; k <= end; k++) context.lineTo(x(k), frame.y(band.upper[k]));
      for (let k = end; k >= begin; k--) context.lineTo(x(k), frame.y(band.lower[k]));
      context.fill();
    }
    begin = end;
  }
  context.globalAlpha = 1;
}

function drawDots(context, frame, curve, colour, size) {
  context.fillStyle = colour;
  for (let k = 0; k < curve.t.length; k++) {
    if (curve.v[k] === null) continue;
    context.beginPath();
    context.arc(frame.x(curve.t[k]), frame.y(curve.v[k]), size, 0, 2 * Math.PI);
    context.fill();
  }
}

function isSparse(frame, curve, pixels) {
  const inside = curve.t.filter(t => frame.x(t) >= frame.left && frame.x(t) <= frame.right);
  return inside.length * pixels < frame.right - frame.left;
}

function drawCurve(context, frame, panel, curve, colours) {
  const own = colours.of(curve.of);
  context.setLineDash(DASHES[curve.of % DASHES.length]);
  context.lineWidth = 1.3;
  context.lineJoin = 'round';
  if (curve.role === 'measured') {
    drawDots(context, frame, curve, curve.own ? own : colours.measured, isSparse(frame, curve, 4) ? 1.8 : 1.1);
  } else if (curve.role === 'truth') {
    context.setLineDash([5, 4]);
    context.strokeStyle = curve.own ? own : colours.truth;
    trace(context, frame, curve, panel.period, panel.kind === 'parameter');
  } else if (curve.role === 'residual') {
    drawDots(context, frame, curve, own, isSparse(frame, curve, 4) ? 1.8 : 1.1);
  } else {
    context.strokeStyle = own;
    trace(context, frame, curve, panel.period, curve.role === 'applied');
    context.setLineDash([]);
    if (curve.role === 'estimate' && isSparse(frame, curve, 7)) {
      drawDots(context, frame, curve, own, 2.8);
    }
  }
  context.setLineDash([]);
}

/* A line at each jump of this panel's variable, with its probability where there is room. */
function drawJumps(context, frame, panel, view, colours) {
  let free = -Infinity;
  context.textAlign = 'left';
  context.textBaseline = 'top';
  for (const jump of panel.jumps) {
    if (jump.t < view.from || jump.t > view.to) continue;
    const x = frame.x(jump.t);
    context.strokeStyle = context.fillStyle = jump.retracted ? colours.soft : colours.jump;
    context.setLineDash(jump.retracted ? [1, 4] : [4, 3]);
    context.beginPath();
    context.moveTo(x, frame.top);
    context.lineTo(x, frame.bottom);
    context.stroke();
    context.setLineDash([]);
    context.beginPath();
    context.moveTo(x - 4, frame.top);
    context.lineTo(x + 4, frame.top);
    context.lineTo(x, frame.top + 7);
    context.fill();
    const words = jump.retracted ? 'taken back'
      : jump.probability === null ? 'jump' : `P ${jump.probability > 0.99 ? '> 0.99' : jump.probability.toFixed(2)}`;
    if (x > free && x < frame.right - 50) {
      context.fillText(words, x + 6, frame.top + 2);
      free = x + 60;
    }
  }
}

function drawPanel(canvas, panel, view, cursor) {
  const { context, width, height } = prepared(canvas);
  const colours = theme(), range = valueRange(panel, view.from, view.to);
  const frame = frameOf(width, height, view, range);
  drawAxes(context, frame, view, range, colours);
  context.save();
  context.beginPath();
  context.rect(frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top);
  context.clip();
  for (const curve of panel.curves) {
    if (curve.band) drawBand(context, frame, curve.band, colours.of(curve.of));
  }
  for (const curve of panel.curves) drawCurve(context, frame, panel, curve, colours);
  drawJumps(context, frame, panel, view, colours);
  drawCursor(context, frame, view, cursor, colours);
  context.restore();
}

function drawCursor(context, frame, view, cursor, colours) {
  if (cursor.begin !== null && cursor.t !== null) {
    context.fillStyle = colours.shade;
    const x = frame.x(cursor.begin);
    context.fillRect(x, frame.top, frame.x(cursor.t) - x, frame.bottom - frame.top);
  }
  if (cursor.t === null || cursor.t < view.from || cursor.t > view.to) return;
  context.strokeStyle = colours.soft;
  context.beginPath();
  context.moveTo(frame.x(cursor.t), frame.top);
  context.lineTo(frame.x(cursor.t), frame.bottom);
  context.stroke();
}
