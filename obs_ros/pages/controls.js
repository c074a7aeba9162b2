/* Questions to the server, and what mouse and keyboard do. */

/* Those chosen that are heard; where none of them is, those that are shown in their place. */
function chosen() {
  const heard = (state.chosen || []).filter(name => state.known.includes(name));
  return heard.length || !state.answer ? heard : state.answer.shown.map(each => each.name);
}

function question() {
  const asked = new URLSearchParams();
  for (const name of chosen()) asked.append('of', name);
  const wide = Math.max(200, ...[...figures.values()].map(each => each.canvas.clientWidth));
  asked.set('points', String(Math.min(1000, Math.round(wide / 1.5))));
  if (state.fixed) {
    asked.set('from', String(state.fixed.from));
    asked.set('to', String(state.fixed.to));
  } else if (state.span) {
    asked.set('span', String(state.span));
  }
  return asked.toString();
}

/* One question at a time; what is wanted meanwhile is asked next. */
async function ask() {
  if (!live) return draw();
  if (state.asking) {
    state.again = true;
    return;
  }
  state.asking = true;
  try {
    const response = await fetch(`data?${question()}`, { signal: AbortSignal.timeout(10000) });
    if (!response.ok) throw new Error(await response.text());
    take(await response.json());
    state.answered = performance.now();
  } catch (error) {
    const since = ((performance.now() - state.answered) / 1000).toFixed(0);
    tell(`No answer for ${since} s: what is shown is old. Does ros2 run obs_ros view still run? ` +
      `(${error.message})`);
  } finally {
    state.asking = false;
  }
  if (state.again) {
    state.again = false;
    await ask();
  }
}

function look(from, to) {
  const span = Math.max(to - from, 1e-6);
  state.fixed = state.view = { from, to: from + span };
  showTools();
  draw();
  ask();
}

function follow() {
  state.fixed = null;
  state.paused = false;
  if (!live) state.view = { from: inside.from, to: inside.to };
  showTools();
  ask();
}

function pause() {
  if (state.paused) return follow();
  state.paused = true;
  state.fixed = { ...state.view };
  showTools();
}

function zoom(factor, about = (state.view.from + state.view.to) / 2) {
  const { from, to } = state.view;
  look(about - (about - from) * factor, about + (to - about) * factor);
}

function pan(share) {
  const shift = share * (state.view.to - state.view.from);
  look(state.view.from + shift, state.view.to + shift);
}

function timeAt(canvas, event) {
  const box = canvas.getBoundingClientRect();
  const frame = frameOf(box.width, box.height, state.view, [0, 1]);
  const x = Math.min(Math.max(event.clientX - box.left, frame.left), frame.right);
  return frame.t(x);
}

function listen(canvas) {
  canvas.addEventListener('pointermove', event => {
    cursor.t = timeAt(canvas, event);
    draw();
  });
  canvas.addEventListener('pointerleave', () => {
    cursor.t = cursor.begin = null;
    draw();
  });
  canvas.addEventListener('pointerdown', event => {
    if (event.button === 0) cursor.begin = timeAt(canvas, event);
  });
  canvas.addEventListener('pointerup', event => {
    const begin = cursor.begin, end = timeAt(canvas, event);
    cursor.begin = null;
    const enough = 0.01 * (state.view.to - state.view.from);
    if (begin !== null && Math.abs(end - begin) > enough) {
      look(Math.min(begin, end), Math.max(begin, end));
    }
  });
  canvas.addEventListener('dblclick', follow);
  canvas.addEventListener('wheel', event => {
    if (!event.ctrlKey && !event.shiftKey) return;
    event.preventDefault();
    const turn = event.deltaY || event.deltaX;
    zoom(Math.pow(1.0015, turn), timeAt(canvas, event));
  }, { passive: false });
}

function fileName(ending) {
  const who = state.answer.shown.map(each => each.name.replace(/[^A-Za-z0-9]+/g, '_')).join('');
  return `obs_ros${who}_${state.view.from.toFixed(0)}_${state.view.to.toFixed(0)}s.${ending}`;
}

function exportTable() {
  const text = csvOf(state.panels, state.answer, state.view);
  save(fileName('csv'), new Blob([text], { type: 'text/csv' }));
}

function exportPicture() {
  const who = state.answer.shown.map(each =>
    `${each.name}: ${each.outcome ? each.outcome.outcome.replaceAll('_', ' ') : 'no estimate'}`);
  pictureOf($('panels'), who.join('   ')).toBlob(blob => save(fileName('png'), blob));
}

function switchTheme() {
  theme_ = theme_ === 'dark' ? 'light' : 'dark';
  document.documentElement.dataset.theme = theme_;
  showEstimators.told = '';
  if (state.answer) take(state.answer);
}

const ACTIONS = {
  ' ': pause, '0': follow, '+': () => zoom(0.5), '-': () => zoom(2), ArrowLeft: () => pan(-0.25),
  ArrowRight: () => pan(0.25), c: exportTable, p: exportPicture, d: switchTheme,
};

function showEstimators(all) {
  const told = JSON.stringify([all.map(each => [each.name, each.well]), chosen(), theme_]);
  if (showEstimators.told === told) return;
  showEstimators.told = told;
  const held = document.activeElement?.dataset?.name;
  $('estimators').replaceChildren(...all.map(each => {
    const place = chosen().indexOf(each.name);
    const button = element('button', { ariaPressed: String(place >= 0), title: each.words });
    button.dataset.name = each.name;
    if (place >= 0) button.append(swatch(place));
    button.append(each.name);
    if (!each.well) button.append(element('span', { className: 'unwell', textContent: ' !' }));
    button.addEventListener('click', () => choose(each.name));
    return button;
  }));
  if (held) [...$('estimators').children].find(each => each.dataset.name === held)?.focus();
}

/* Show one more estimator, or one less, but never none. */
function choose(name) {
  const before = chosen(), others = before.filter(each => each !== name);
  state.chosen = !before.includes(name) ? [...others, name].slice(-6)
    : others.length ? others : before;
  layOut.keys = '';
  ask();
}

function showTools() {
  const say = state.paused ? 'Go on' : state.fixed ? 'Follow' : 'Pause';
  const button = (id, text, title, action) => {
    const made = element('button', { id, textContent: text, title });
    made.addEventListener('click', () => {
      action();
      $(id)?.focus();
    });
    return made;
  };
  const parts = [];
  if (live) {
    parts.push(button('pause', say, 'space', state.fixed ? follow : pause));
    const spans = element('select', { id: 'span', title: 'how far back', ariaLabel: 'how far back' });
    for (const [span, text] of SPANS) {
      spans.append(element('option', { value: String(span), textContent: `last ${text}`.replace('last all', 'all') }));
    }
    spans.value = String(state.span);
    spans.addEventListener('change', () => {
      state.span = Number(spans.value);
      follow();
    });
    parts.push(spans);
  }
  parts.push(button('whole', 'Whole', 'the whole view: 0, or a double click', follow),
    button('csv', 'CSV', 'what is seen as a table: c', exportTable),
    button('png', 'PNG', 'what is seen as a picture: p', exportPicture),
    button('dark', 'Light / dark', 'd', switchTheme));
  $('tools').replaceChildren(...parts);
}

function begin() {
  showTools();
  const keys = [['drag', 'zoom'], ['ctrl + wheel', 'zoom'], ['+', ''], ['-', 'zoom'],
    ['\u2190', ''], ['\u2192', 'move'], ['0', 'whole'], ...(live ? [['space', 'pause']] : []),
    ['c', 'CSV'], ['p', 'PNG'], ['d', 'light or dark']];
  $('help').append(...keys.flatMap(([key, text]) => [element('kbd', { textContent: key }),
    ` ${text}${text ? ' \u00a0 ' : ''}`]),
  'Bands: \u00b1 2 standard deviations. Dots: measured; dashed: truth, where it is published. ' +
    'Dashed lines of the autocorrelation hold 95 % of white noise.');
  addEventListener('keydown', event => {
    const typing = ['SELECT', 'BUTTON'].includes(event.target.tagName) && event.key === ' ';
    const action = ACTIONS[event.key];
    if (!action || typing || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.tagName === 'SELECT') return;
    event.preventDefault();
    action();
  });
  addEventListener('resize', draw);
  if (!live) return take(inside);
  ask();
  setInterval(() => {
    if (!state.paused && !document.hidden) ask();
  }, POLL);
}

begin();
