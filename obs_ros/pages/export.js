/* What is seen, as a table (CSV) or a picture (PNG), saved by the browser. */

function save(name, blob) {
  const address = URL.createObjectURL(blob);
  const link = element('a', { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

function stampOf(origin, t) {
  const ns = BigInt(origin) + BigInt(Math.round(t * 1e6)) * 1000n;
  const digits = (ns < 0n ? -ns : ns).toString().padStart(10, '0');
  return `${ns < 0n ? '-' : ''}${digits.slice(0, -9)}.${digits.slice(-9)}`;
}

/* Spreadsheets take a field that begins so for a formula. */
function field(text) {
  const plain = String(text ?? '');
  const safe = /^[=+\-@\t\r]/.test(plain) && isNaN(Number(plain)) ? `'${plain}` : plain;
  return /[",\n\r]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}

/* One row for each point that is seen: stamp (s), who, what, value, and the ends of +-2 sd. */
function csvOf(panels, answer, view) {
  const lines = ['stamp_s,t_s,estimator,kind,role,name,unit,value,lower_2sd,upper_2sd'];
  for (const panel of panels) {
    for (const curve of panel.curves) {
      for (let k = 0; k < curve.t.length; k++) {
        const t = curve.t[k];
        if (t < view.from || t > view.to || curve.v[k] === null) continue;
        const edge = curve.band ? placeAt(curve.band.t, t) : -1;
        const ends = edge < 0 ? ['', ''] : [curve.band.lower[edge], curve.band.upper[edge]];
        lines.push([stampOf(answer.origin, t), t, curve.own ? curve.by : '', panel.kind,
          curve.role, panel.name, panel.unit, curve.v[k], ...ends].map(field).join(','));
      }
    }
    for (const jump of panel.jumps) {
      if (jump.t < view.from || jump.t > view.to) continue;
      lines.push([stampOf(answer.origin, jump.t), jump.t, jump.by, 'jump',
        jump.retracted ? 'taken back' : 'jump', panel.name, '1', jump.probability, '', '']
        .map(field).join(','));
    }
  }
  return lines.join('\n') + '\n';
}

/* All panels as they stand, with their captions. */
function pictureOf(main, title) {
  const ratio = window.devicePixelRatio || 1, colours = theme();
  const box = main.getBoundingClientRect(), head = 34;
  const canvas = element('canvas', { width: Math.ceil(box.width * ratio),
    height: Math.ceil((box.height + head) * ratio) });
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  context.fillStyle = colours.colour('paper');
  context.fillRect(0, 0, box.width, box.height + head);
  context.fillStyle = colours.ink;
  context.font = "600 14px system-ui, 'DejaVu Sans', sans-serif";
  context.fillText(title, 14, 22);
  const text = (node, font, colour, align) => {
    const place = node.getBoundingClientRect();
    context.font = font;
    context.fillStyle = colour;
    context.textAlign = align;
    const x = (align === 'right' ? place.right : place.left) - box.left;
    context.fillText(node.textContent, x, place.bottom - box.top + head - 5, place.width);
  };
  for (const node of main.querySelectorAll('figure')) {
    const place = node.getBoundingClientRect();
    context.fillStyle = colours.card;
    context.fillRect(place.left - box.left, place.top - box.top + head, place.width, place.height);
  }
  for (const node of main.querySelectorAll('canvas')) {
    const place = node.getBoundingClientRect();
    context.drawImage(node, place.left - box.left, place.top - box.top + head, place.width,
      place.height);
  }
  const small = "12px system-ui, 'DejaVu Sans', sans-serif";
  for (const node of main.querySelectorAll('h2')) text(node, `600 ${small}`, colours.soft, 'left');
  for (const node of main.querySelectorAll('figcaption b')) {
    text(node, `600 ${small}`, colours.ink, 'left');
  }
  for (const node of main.querySelectorAll('.readout')) text(node, small, colours.soft, 'right');
  for (const node of main.querySelectorAll('.words')) text(node, small, colours.soft, 'left');
  return canvas;
}
