/* Two more kinds of panel: the autocorrelation of residuals, and the outcomes over time. */

function drawCorrelation(canvas, correlations) {
  const { context, width, height } = prepared(canvas);
  const colours = theme();
  const lags = Math.max(1, ...correlations.map(each => each.values.length));
  const most = Math.min(1, 1.15 * Math.max(0.1, ...correlations.flatMap(each =>
    [each.bound || 0, ...each.values.map(v => Math.abs(v || 0))])));
  const view = { from: 0, to: lags + 1 }, range = [-most, most];
  const frame = frameOf(width, height, view, range);
  drawAxes(context, frame, view, range, colours);
  context.fillStyle = colours.card;
  context.fillRect(frame.right - 30, frame.bottom + 2, 32, 16);
  context.fillStyle = colours.soft;
  context.textAlign = 'right';
  context.textBaseline = 'top';
  context.fillText('lag', frame.right, frame.bottom + 5);
  correlations.forEach((each, k) => {
    const own = colours.of(each.of), shift = 3 * (k - (correlations.length - 1) / 2);
    context.strokeStyle = own;
    context.lineWidth = 2;
    context.beginPath();
    each.values.forEach((value, place) => {
      const x = frame.x(place + 1) + shift;
      context.moveTo(x, frame.y(0));
      context.lineTo(x, frame.y(value || 0));
    });
    context.stroke();
    context.lineWidth = 1;
    context.setLineDash([4, 3]);
    context.beginPath();
    for (const bound of [-each.bound, each.bound]) {
      context.moveTo(frame.left, frame.y(bound));
      context.lineTo(frame.right, frame.y(bound));
    }
    context.stroke();
    context.setLineDash([]);
  });
  context.strokeStyle = colours.soft;
  context.beginPath();
  context.moveTo(frame.left, frame.y(0));
  context.lineTo(frame.right, frame.y(0));
  context.stroke();
}

/* Outcomes as a strip for each estimator: the better, the taller and by colour. */
function drawOutcomes(canvas, shown, view, cursor) {
  const { context, width, height } = prepared(canvas);
  const colours = theme(), frame = frameOf(width, height, view, [0, 1]);
  const share = { yes: 1, roughly: 0.78, no: 0.56 };
  const room = (frame.bottom - frame.top) / Math.max(shown.length, 1);
  const across = ticks(view.from, view.to, (frame.right - frame.left) / 90);
  context.fillStyle = colours.soft;
  context.textAlign = 'center';
  context.textBaseline = 'top';
  for (const t of across.found) {
    if (frame.x(t) < frame.right - 14) {
      context.fillText(label(t, across.step), frame.x(t), frame.bottom + 5);
    }
  }
  context.save();
  context.beginPath();
  context.rect(frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top);
  context.clip();
  shown.forEach((each, row) => {
    const base = frame.top + (row + 1) * room - 1;
    each.spells.forEach((spell, k) => {
      const next = each.spells[k + 1];
      const begin = frame.x(spell.from), end = Math.max(begin + 3, next ? frame.x(next.from) - 1
        : frame.x(spell.to) + 3);
      const tall = (room - 3) * share[spell.good];
      context.fillStyle = colours.colour(spell.good);
      context.globalAlpha = 0.75;
      context.fillRect(begin, base - tall, end - begin, tall);
      context.globalAlpha = 1;
      if (end - begin > 8 * spell.outcome.length) {
        context.fillStyle = colours.card;
        context.textAlign = 'left';
        context.textBaseline = 'bottom';
        context.fillText(spell.outcome.replaceAll('_', ' '), begin + 5, base - 1);
      }
    });
  });
  drawCursor(context, frame, view, cursor, colours);
  context.restore();
}
