/* What is said in words: cards, readouts, tables. Texts from topics are data: textContent only. */

const KINDS = {
  parameter: 'Parameters', state: 'States', output: 'Outputs', input: 'Inputs',
  residual: 'Residuals: measured less predicted one step ahead', figure: 'Quality and speed',
};
const ROLES = {
  estimate: 'estimate', prediction: 'prediction', truth: 'truth', measured: 'measured',
  applied: 'applied', residual: 'residual', figure: '',
};
const SIGNS = { yes: '\u25cf', roughly: '\u25d0', no: '\u25cb' };

function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in made) made[name] = value; else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

function swatch(k) {
  const canvas = element('canvas', { className: 'swatch', width: 44, height: 16, ariaHidden: true });
  const context = canvas.getContext('2d');
  context.strokeStyle = theme().of(k);
  context.lineWidth = 5;
  context.setLineDash(DASHES[k % DASHES.length].map(dash => 2 * dash));
  context.beginPath();
  context.moveTo(0, 8);
  context.lineTo(44, 8);
  context.stroke();
  return canvas;
}

/* A card for each estimator shown: how it is, and what its newest estimate says. */
function card(shown, k) {
  const made = element('div', { className: 'card' });
  made.style.borderTopColor = theme().of(k);
  made.append(element('p', {},
    element('b', { textContent: shown.name }),
    element('span', { className: 'soft',
      textContent: `  model ${shown.model}, observer ${shown.observer}` })));
  if (shown.outcome) {
    const good = shown.outcome.good;
    made.append(element('p', {},
      element('span', { className: `outcome ${good}`,
        textContent: `${SIGNS[good]} ${shown.outcome.outcome.replaceAll('_', ' ')}` }),
      `: ${shown.outcome.message}`));
  }
  const twice = shown.well && shown.outcome && shown.words.endsWith(shown.outcome.message);
  if (shown.words && !twice) {
    made.append(element('p', { className: shown.well ? 'soft' : 'unwell',
      textContent: shown.words }));
  }
  if (shown.lost) {
    made.append(element('p', { className: 'unwell',
      textContent: `messages lost on their way to this page: ${shown.lost}` }));
  }
  if (shown.left_out) {
    made.append(element('p', { className: 'soft',
      textContent: `${shown.left_out} more variables are not shown` }));
  }
  return made;
}

/* The values of a panel at time t: of each curve the last one that was known then. */
function readout(panel, t, several) {
  const parts = [];
  for (const curve of panel.curves) {
    const value = valueAt(curve, t);
    if (value === null) continue;
    const name = [ROLES[curve.role], several && curve.own ? curve.short : ''].filter(Boolean).join(' ');
    parts.push(`${name} ${figure(value)}${spread(curve, t)}`.trim());
  }
  return parts.reverse().join('  \u00b7  ');
}

function spread(curve, t) {
  if (!curve.band) return '';
  const k = placeAt(curve.band.t, t);
  if (k < 0 || curve.band.upper[k] === null || curve.band.lower[k] === null) return '';
  const half = (curve.band.upper[k] - curve.band.lower[k]) / 2;
  return curve.role === 'residual' ? ` (2 sd: ${figure(half, 2)})` : ` \u00b1 ${figure(half, 2)}`;
}

function jumpTable(shown) {
  const rows = shown.flatMap((each, k) => each.jumps.map(jump => ({ ...jump, by: each.name, k })));
  rows.sort((a, b) => b.t - a.t);
  const several = shown.length > 1;
  const head = ['time (s)', 'jump of, \u00b1 2 sd', 'probability', ...(several ? ['found by'] : [])];
  const body = rows.slice(0, 50).map(jump => [
    jump.t.toFixed(2), jump.words,
    jump.retracted ? 'taken back' : jump.probable.replace('probability ', ''),
    ...(several ? [jump.by] : []),
  ]);
  return listCard('Jumps', head, body, rows.map(jump => jump.retracted),
    'No parameter has jumped in what is seen.');
}

function outcomeTable(shown) {
  const rows = shown.flatMap(each => each.spells.map(spell => ({ ...spell, by: each.name })));
  rows.sort((a, b) => b.from - a.from);
  const several = shown.length > 1;
  const head = ['time (s)', 'outcome', 'estimates', 'what it says', ...(several ? ['of'] : [])];
  const body = rows.slice(0, 30).map(spell => [
    stretch(spell.from, spell.to),
    `${SIGNS[spell.good]} ${spell.outcome.replaceAll('_', ' ')}`, String(spell.count),
    spell.message, ...(several ? [spell.by] : []),
  ]);
  return listCard('Outcomes', head, body, [], 'No estimate yet in what is seen.');
}

function listCard(title, head, body, gone, nothing) {
  const made = element('div', { className: 'card' }, element('b', { textContent: title }));
  if (!body.length) {
    made.append(element('p', { className: 'soft', textContent: nothing }));
    return made;
  }
  const table = element('table', { className: title.toLowerCase() });
  table.append(element('tr', {}, ...head.map(text => element('th', { textContent: text }))));
  body.forEach((cells, k) => {
    table.append(element('tr', { className: gone[k] ? 'gone' : '' },
      ...cells.map(text => element('td', { textContent: text }))));
  });
  made.append(table);
  return made;
}
