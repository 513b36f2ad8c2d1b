// The live page: asks the render what it has, shows it, and passes on what is clicked.
'use strict';
const at = (id) => document.getElementById(id);
const passes = [];
let next = 0, shown = {}, tableVersion = -1, slices = [], isBusy = false, isOver = false;

async function ask(path) {
  const response = await fetch(path);
  if (response.status === 204) return null;
  if (!response.ok) throw new Error(`${path}: ${response.status}`);
  return response;
}

async function control(words) {
  const response = await fetch('control', {method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify(words)});
  return response.ok ? response.json() : {};
}

async function fetchLayer(which, version) {
  const layer = at('layer').value || 'beauty', kept = shown[which || 'latest'];
  if (kept && kept.layer === layer && kept.version === version) return;
  const response = await ask(`picture?which=${which}&layer=${encodeURIComponent(layer)}`);
  if (!response) return;
  const [width, height] = response.headers.get('X-Size').split('x').map(Number);
  shown[which || 'latest'] = {layer, version, width, height, planes: new Float32Array(await response.arrayBuffer())};
}

function paint() {
  const picture = shown.latest, beside = shown[at('beside').value];
  if (!picture) return;
  const canvas = at('picture'), {width, height} = picture, count = width * height;
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  const context = canvas.getContext('2d'), image = context.createImageData(width, height), bytes = image.data;
  const scale = Math.pow(2, Number(at('exposure').value)), view = viewTransforms[at('view').value], color = [0, 0, 0];
  const fits = at('beside').value && beside && beside.width === width && beside.height === height;
  const cut = fits ? Math.round(Number(at('split').value) * width) : width;
  for (let i = 0; i < count; ++i) {
    const planes = i % width < cut ? picture.planes : beside.planes;
    view(planes[i] * scale, planes[count + i] * scale, planes[2 * count + i] * scale, color);
    for (let c = 0; c < 3; ++c) bytes[4 * i + c] = Math.round(255 * color[c]);
    bytes[4 * i + 3] = 255;
  }
  context.putImageData(image, 0, 0);
  if (fits && cut > 0 && cut < width) { context.fillStyle = '#fff'; context.fillRect(cut, 0, 1, height); }
  canvas.dataset.version = picture.version;
}

/** To fit is to be seen whole, whatever the shape. */
function sizeCanvas() {
  const canvas = at('picture'), room = canvas.parentElement.clientWidth;
  const zoom = Number(at('zoom').value) || Math.min(room / canvas.width, 0.7 * window.innerHeight / canvas.height);
  canvas.style.width = `${zoom * canvas.width}px`;
}

/** Seconds, in words that are read at once. */
function duration(seconds) {
  if (seconds < 100) return `${short(seconds, 2)} s`;
  return seconds < 6000 ? `${Math.round(seconds / 60)} min` : `${short(seconds / 3600, 2)} h`;
}

const charts = {};
function drawCharts() {
  const line = (name, title, series, options) => {
    charts[name] = charts[name] || chartPanel(at('charts'), title);
    lineChart(charts[name], {series: series.map(([label, field, dashed]) => ({
      name: label, dashed, points: passes.map((pass) => ({x: options.byPaths ? pass.samples : pass.pass + 1, y: typeof field === 'function' ? field(pass) : pass[field]}))})), ...options});
  };
  line('share', 'Queries answered by rows', [['answered', 'answered_query_share'], ['by rows that have converged', 'converged_query_share']], {x: 'pass', y: 'share', max: 1});
  line('noise', 'Noise of the picture', [['noise', 'noise']], {x: 'paths', y: 'relative', byPaths: true, logX: true, logY: true});
  line('error', 'Error of the fits', [['median', 'p50'], ['99 %', 'p99'], ['epsilon', () => shown.epsilon, true]], {x: 'pass', y: 'objective', logY: true});
  line('rows', 'Rows by state', [['converged', 'converged'], ['open', 'open'], ['nodes answered by coarser rows', 'coarse'], ['refused', 'refused']], {x: 'pass', y: 'rows'});
  line('rates', 'Rates', [['paths a second', (pass) => pass.pixels / pass.seconds], ['g evaluations a second', (pass) => pass.g_evaluations / pass.seconds]], {x: 'pass', y: '1/s', logY: true});
  line('memory', 'Memory', [['of the table, MB', (pass) => pass.bytes / 1e6], ['of the process, MB', (pass) => pass.process_bytes / 1e6]], {x: 'pass', y: 'MB'});
}

const stateColors = {'.': [236, 238, 240], o: [230, 159, 0], c: [0, 114, 178], r: [190, 30, 45]};
const ramp = (t) => [[255, 255, 229], [254, 196, 79], [217, 95, 14], [102, 37, 6]].reduce((all, color, i, list) => {
  const x = Math.min(1, Math.max(0, t)) * 3;
  return x >= i ? list[i].map((from, c) => i < 3 ? from + (list[i + 1][c] - from) * Math.min(1, x - i) : from) : all;
}, [255, 255, 229]);

function shadeOf(slice, node, most) {
  const state = slice.states[node];
  if (at('shade').value === 'state') return stateColors[state];
  if (at('shade').value === 'light') return slice.light[node] > 0 ? ramp(1 + Math.log10(slice.light[node] / most) / 4) : stateColors['.'];
  return state === '.' ? stateColors['.'] : ramp(1 + Math.log10(Math.max(slice.error[node], 1e-6)) / 4);
}

function drawMaps() {
  const shade = at('shade').value;
  at('key').replaceChildren();
  if (shade === 'state') {
    for (const [name, letter] of [['not a row', '.'], ['open', 'o'], ['converged', 'c'], ['refused', 'r']]) {
      const box = element('span', '', 'key');
      box.style.background = `rgb(${stateColors[letter]})`;
      at('key').append(box, name);
    }
  } else {
    at('key').textContent = shade === 'error' ? 'light to dark: objective 0.0001 to 1' : 'light to dark: 0.0001 of the most to the most, of each map';
  }
  slices.forEach((slice, i) => {
    let panel = at('maps').children[i];
    if (!panel) {
      panel = element('section', '', 'panel');
      const canvas = element('canvas', '', 'map');
      panel.append(element('h2'), canvas, element('p', '', 'soft'));
      canvas.addEventListener('click', (event) => clickMap(i, canvas, event));
      at('maps').append(panel);
    }
    const [title, canvas, words] = panel.children, wide = slice.a.length, high = slice.b.length;
    const count = (letter) => slice.states.split(letter).length - 1;
    title.textContent = slice.name;
    words.textContent = `right: ${slice.name_a} ${short(slice.a[0])} to ${short(slice.a[wide - 1])}, up: ${slice.name_b} ${short(slice.b[0])} to ${short(slice.b[high - 1])} degrees; ${count('c')} converged, ${count('o')} open, ${count('r')} refused of ${wide * high}`;
    canvas.width = wide;
    canvas.height = high;
    const context = canvas.getContext('2d'), image = context.createImageData(wide, high), most = Math.max(...slice.light, 1e-30);
    for (let x = 0; x < wide; ++x) {
      for (let y = 0; y < high; ++y) image.data.set([...shadeOf(slice, x * high + y, most), 255], 4 * ((high - 1 - y) * wide + x));
    }
    context.putImageData(image, 0, 0);
  });
}

function clickMap(index, canvas, event) {
  const slice = slices[index], box = canvas.getBoundingClientRect();
  const x = Math.min(slice.a.length - 1, Math.floor((event.clientX - box.left) / box.width * slice.a.length));
  const y = Math.min(slice.b.length - 1, Math.floor((event.clientY - box.top) / box.height * slice.b.length));
  showRow(index, x * slice.b.length + slice.b.length - 1 - y);
}

async function showRow(slice, node) {
  const {request} = await control({do: 'row', slice, node});
  if (!request) return;
  at('row').hidden = false;
  at('row-words').textContent = 'asked: the render answers between two passes';
  for (let tries = 0; tries < 600 && !isOver; ++tries) {
    const response = await ask(`row?request=${request}`).catch(() => null);
    if (response) { drawRow(await response.json()); return; }
    await new Promise((done) => setTimeout(done, 250));
  }
}

function drawRow(row) {
  at('row-words').textContent = row.words;
  at('row-command').textContent = row.command || '';
  at('row-charts').replaceChildren();
  if (row.phi_deg) rowCharts(at('row-charts'), row);
}

/** Values of the sliders that were moved, and the color if it was edited; the change that was sent and not shown yet, when, and whether another waits. */
const look = {moved: {}, sent: 0, sentAt: 0, waits: false, seconds: null};
function makeSliders(sliders, color) {
  at('look').hidden = false;
  colorEditor(at('color'), color, (edited) => { look.color = edited; delete look.moved.melanin; sendLook(); });
  for (const {name, label, least, most, step, value} of sliders) {
    const box = element('label'), input = element('input'), output = element('output', short(value));
    Object.assign(input, {type: 'range', id: `slider-${name}`, min: least, max: most, step, value});
    input.addEventListener('input', () => {
      output.textContent = input.value;
      look.moved[name] = Number(input.value);
      if (name === 'melanin') delete look.color;
      sendLook();
    });
    box.append(element('span', label), output, input);
    at('sliders').append(box);
  }
}

/** One change at a time: the next one when the first picture of this one is there. */
async function sendLook() {
  look.waits = true;
  if (look.sent) return;
  look.waits = false;
  look.sent = -1;
  look.sentAt = performance.now();
  const response = await fetch('control', {method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify({do: 'look', values: look.moved, color: look.color})});
  const answer = await response.json().catch(() => ({}));
  look.sent = answer.look || 0;
  if (answer.error) at('look-words').textContent = answer.error;
  else watchLook();
}

async function watchLook() {
  while (look.sent && !isOver) {
    await turn();
    if (look.sent) await new Promise((done) => setTimeout(done, 100));
  }
  if (look.waits) sendLook();
}

function seeLook(status) {
  if (look.shown !== status.look) {
    if (look.shown !== undefined) { passes.length = 0; next = status.first; }
    look.shown = status.look;
  }
  at('has-look').hidden = !(status.look_before > 0);
  if (look.sent > 0 && status.look >= look.sent && status.picture >= status.first_of_look && shown.latest && shown.latest.version >= status.first_of_look) {
    look.sent = 0;
    look.seconds = (performance.now() - look.sentAt) / 1000;
    at('look-words').textContent = `The first picture of this look came after ${short(look.seconds)} s. As options:`;
    at('look-options').textContent = Object.entries(look.moved).map(([name, x]) => `${lookOptions[name]} ${x}`)
      .concat(look.color ? [`--color '${Array.isArray(look.color) ? look.color : JSON.stringify(look.color)}'`] : []).join(' ');
  }
}
const lookOptions = {melanin: '--melanin', roughness: '--roughness', eccentricity: '--eccentricity', tilt: '--cuticle-tilt', lights: '--light-scale'};

function showStatus(status) {
  if (status.facts) {
    at('title').textContent = `tress: ${status.facts.output.split('/').pop()}`;
    at('title').title = status.facts.output;
    at('about').textContent = `${status.facts.scene}, ${status.facts.model}, ${status.facts.estimator}, epsilon ${status.facts.epsilon}`;
    shown.epsilon = status.facts.epsilon;
    if (shown.view === undefined) {  // as the scene has it, until somebody chooses
      shown.view = status.facts.view;
      at('view').value = shown.view;
      at('exposure').value = status.facts.exposure;
      at('stops').textContent = at('exposure').value;
    }
  }
  if (status.said) at('said').textContent = status.said;
  at('has-reference').hidden = !status.reference;
  const last = passes[passes.length - 1];
  at('pause').textContent = status.paused ? 'Go on' : 'Pause';
  if (!last) return;
  const left = status.progress && status.progress.seconds_left !== null ? `, about ${duration(status.progress.seconds_left)} left` : '';
  at('done').value = status.progress ? status.progress.share : 0;
  at('state').textContent = `${status.stopped ? 'stopping: ' : status.paused ? 'paused: ' : ''}${short(last.samples / last.image_pixels)} samples a pixel, noise ${short(last.noise)}${left}`;
  at('learned').textContent = `${short(100 * last.answered_query_share)} % of the last pass's queries were answered by rows, ${short(100 * last.converged_query_share)} % by rows that have converged; ${last.converged} rows converged, ${last.open} open, ${last.refused} refused; ${short(last.g_evaluations)} evaluations of g in the last pass, learning took ${short(100 * last.learning_cpu_seconds / last.cpu_seconds)} % of its CPU time; the table has ${short(last.bytes / 1e6)} MB.`;
}

async function turn() {
  if (isBusy || isOver) return;
  isBusy = true;
  try {
    const status = await (await ask(`status?since=${next}`)).json();
    if (status.sliders && status.sliders.length && at('look').hidden) makeSliders(status.sliders, status.color);
    seeLook(status);
    passes.push(...status.passes);
    next = status.first + status.passes.length;
    if (status.layers && at('layer').options.length !== status.layers.length) {
      const chosen = at('layer').value;
      at('layer').replaceChildren(...status.layers.map((layer) => new Option(layer, layer)));
      if (status.layers.includes(chosen)) at('layer').value = chosen;
    }
    showStatus(status);
    if (status.passes.length) drawCharts();
    if (status.picture > 0) {
      await fetchLayer('', status.picture);
      const beside = at('beside').value;
      if (beside) await fetchLayer(beside, beside === 'before' ? status.before : beside === 'look' ? status.look_before : 1).catch(() => null);
      paint();
      sizeCanvas();
      seeLook(status);
    }
    if (status.table !== tableVersion) {
      slices = (await (await ask('table')).json()).slices;
      tableVersion = status.table;
      drawMaps();
    }
    turn.failures = 0;
  } catch (error) {
    turn.failures = (turn.failures || 0) + 1;
    if (turn.failures > 3) {
      at('state').textContent = 'the render has ended, or cannot be reached; this is what it showed last';
      document.body.dataset.over = 'true';
    }
  }
  isBusy = false;
}

for (const id of ['exposure', 'split']) at(id).addEventListener('input', () => { at('stops').textContent = at('exposure').value; paint(); });
at('view').addEventListener('change', paint);
at('zoom').addEventListener('change', sizeCanvas);
window.addEventListener('resize', sizeCanvas);
at('shade').addEventListener('change', drawMaps);
for (const id of ['layer', 'beside']) at(id).addEventListener('change', turn);
at('pause').addEventListener('click', () => control({do: at('pause').textContent === 'Pause' ? 'pause' : 'resume'}).then(turn));
for (const id of ['save', 'stop']) at(id).addEventListener('click', () => { at('said').textContent = id === 'save' ? 'saves after this pass' : ''; control({do: id}).then(turn); });
at('picture').addEventListener('mousemove', (event) => {
  const picture = shown.latest, box = at('picture').getBoundingClientRect();
  if (!picture) return;
  const x = Math.floor((event.clientX - box.left) / box.width * picture.width), y = Math.floor((event.clientY - box.top) / box.height * picture.height);
  const value = [0, 1, 2].map((c) => short(picture.planes[c * picture.width * picture.height + y * picture.width + x]));
  at('pixel').textContent = `(${x}, ${y}): ${value.join(', ')}`;
});
turn();
setInterval(turn, 1000);
