/* The page: panels out of an answer, the view that all of them share, and its controls. */

const POLL = 500;  // ms from one answer to the next question
const SPANS = [[0, 'all'], [10, '10 s'], [60, '1 min'], [600, '10 min'], [3600, '1 h'],
  [36000, '10 h']];
const $ = id => document.getElementById(id);
const inside = JSON.parse($('data').textContent);
const live = inside === null;
const state = {
  answer: null, view: { from: 0, to: 1 }, panels: [], chosen: null, known: [],
  fixed: null, paused: false, span: 0, asking: false, again: false, answered: performance.now(),
};
const cursor = { t: null, begin: null };
const figures = new Map();
let theme_ = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
document.documentElement.dataset.theme = theme_;

/* Panels of all estimators shown, those of one variable as one; the curves of one plant once.
   Of several plants each curve is of its estimator, by name and colour. */
function merged(shown) {
  const found = new Map(), several = new Set(shown.map(each => each.plant)).size > 1;
  shown.forEach((each, k) => {
    for (const panel of each.panels) {
      const key = `${panel.kind}/${panel.name}`;
      if (!found.has(key)) {
        found.set(key, { ...panel, key, curves: [], correlations: [], jumps: [] });
      }
      const whole = found.get(key);
      for (const curve of panel.curves) {
        const own = !['truth', 'measured', 'applied'].includes(curve.role), plant = each.plant;
        if (!own && whole.curves.some(other => other.role === curve.role && other.plant === plant)) {
          continue;
        }
        const short = each.name.replace(/^.*\/(?=[^/]+\/[^/]+$)/, '');
        whole.curves.push({ ...curve, of: k, own: own || several, plant, by: each.name, short });
      }
      if (panel.correlation) whole.correlations.push({ ...panel.correlation, of: k });
      if (panel.kind === 'parameter') {
        whole.jumps.push(...each.jumps.filter(jump => jump.names.includes(panel.name))
          .map(jump => ({ ...jump, by: each.name })));
      }
    }
  });
  const order = Object.keys(KINDS);
  return [...found.values()].sort((a, b) => order.indexOf(a.kind) - order.indexOf(b.kind));
}

function figureOf(key, high, wide) {
  const canvas = element('canvas', { role: 'img' });
  canvas.style.height = `${high}px`;
  const title = element('b'), told = element('span', { className: 'readout' });
  const made = element('figure', { className: wide ? 'wide' : '' },
    element('figcaption', {}, title, told), canvas);
  const entry = { made, canvas, title, told, words: null };
  figures.set(key, entry);
  return entry;
}

/* Figures are made anew only where other panels are shown than before. */
function layOut() {
  const keys = state.panels.map(panel => panel.key).join('\n');
  if (layOut.keys === keys) return;
  layOut.keys = keys;
  figures.clear();
  const main = $('panels');
  main.replaceChildren();
  const strip = figureOf('outcomes', 28 + 22 * state.answer.shown.length, true);
  strip.title.textContent = 'Outcomes';
  main.append(element('section', {}, strip.made));
  listen(strip.canvas);
  let section = null, kind = '';
  for (const panel of state.panels) {
    if (panel.kind !== kind) {
      section = element('section', { className: panel.kind === 'residual' ? 'pairs' : '' },
        element('h2', { textContent: KINDS[panel.kind] }));
      main.append(section);
    }
    kind = panel.kind;
    const entry = figureOf(panel.key, panel.kind === 'figure' ? 110 : 150, false);
    entry.title.textContent = panel.name + unitOf(panel);
    listen(entry.canvas);
    if (panel.kind !== 'residual') section.append(entry.made); else {
      const other = figureOf(`${panel.key}/correlation`, 130, false);
      other.title.textContent = `autocorrelation, ${panel.name}`;
      other.words = element('p', { className: 'words' });
      other.made.append(other.words);
      section.append(element('div', { className: 'pair' }, entry.made, other.made));
    }
  }
}

function draw() {
  if (!state.answer) return;
  const shown = state.answer.shown, several = shown.length > 1;
  layOut();
  const t = cursor.t === null ? state.view.to : cursor.t;
  drawOutcomes(figures.get('outcomes').canvas, shown, state.view, cursor);
  figures.get('outcomes').told.textContent =
    cursor.t === null ? `${label(state.view.from, 0.1)} to ${label(state.view.to, 0.1)} s`
      : `t = ${cursor.t.toPrecision(7)} s`;
  for (const panel of state.panels) {
    const entry = figures.get(panel.key);
    drawPanel(entry.canvas, panel, state.view, cursor);
    entry.told.textContent = readout(panel, t, several);
    entry.canvas.setAttribute('aria-label', `${panel.name}: ${entry.told.textContent}`);
    const other = figures.get(`${panel.key}/correlation`);
    if (other) {
      drawCorrelation(other.canvas, panel.correlations);
      other.words.title = other.words.textContent = panel.correlations.map(each => each.words).join('; ');
      other.canvas.setAttribute('aria-label', other.words.textContent);
    }
  }
}

/* Take an answer: the server's, or the one inside. */
function take(answer) {
  state.answer = answer;
  state.panels = merged(answer.shown);
  if (!state.fixed) state.view = { from: answer.from, to: Math.max(answer.to, answer.from + 1e-6) };
  const names = answer.estimators.map(each => each.name);
  if (state.chosen === null && names.length) state.chosen = [names[0]];
  state.known = names;
  showEstimators(answer.estimators);
  $('cards').replaceChildren(...answer.shown.map(card));
  $('lists').replaceChildren(jumpTable(answer.shown), outcomeTable(answer.shown));
  const words = names.length ? answer.notes : ['No estimator is heard. Start one with ros2 run ' +
    'obs_ros estimator; is it on this machine, or in this network, and in the same ROS_DOMAIN_ID?',
  ...answer.notes];
  tell(words.join(' '));
  draw();
}

function tell(words) {
  $('trouble').hidden = !words;
  if ($('trouble').textContent !== words) $('trouble').textContent = words;
}
