// The lobe viewer: `lobes` has the rows of tress-lab fit --json and the far fields of tress-lab far-field --json, unchanged.
'use strict';
const at = (id) => document.getElementById(id);
const fields = lobes.far_fields, names = fields.length ? Object.keys(fields[0].lobes) : [];
const truth = fields.find((field) => field.model === 'fiber3d');
const degrees = Math.PI / 180;
/** What is looked at: lobe, channel, bins of theta_i and phi_i, models that are drawn. */
const chosen = {lobe: 'whole', channel: 0, theta: 0, phi: 0, models: new Set(fields.map((field) => field.model))};

/** One color for each model, black for the traced truth. */
const colors = {};
const rivals = palette.filter((color) => color !== '#000000');
fields.filter((field) => field !== truth).forEach((field, i) => { colors[field.model] = rivals[i % rivals.length]; });
if (truth) colors[truth.model] = '#000000';

const bins = () => ({thetas: fields[0].bins[0], phis: fields[0].bins[1]});
const middle = (index, count, from, range) => from + (index + 0.5) * range / count;
const thetaOf = (i) => middle(i, bins().thetas, -90, 180);
const phiOf = (j) => middle(j, bins().phis, -180, 360);
/** A bin in radians squared: fluxes over it are densities. */
const binSize = () => (Math.PI / bins().thetas) * (2 * Math.PI / bins().phis);
const part = (field, lobe) => field.lobes[lobe];
const flux = (field, lobe) => part(field, lobe).flux[chosen.channel];
const density = (field, lobe, i, j) => flux(field, lobe)[i][j] / binSize();
const largest = (field, lobe) => Math.max(...flux(field, lobe).map((row) => Math.max(...row))) / binSize();

/** Of two far fields, relative L2 over the bins less what the noise of both makes of it, and that noise. */
function distance(field, lobe) {
  let difference = 0, noise = 0, square = 0;
  const of = part(field, lobe), as = part(truth, lobe), c = chosen.channel;
  of.flux[c].forEach((row, i) => row.forEach((value, j) => {
    difference += (value - as.flux[c][i][j]) ** 2;
    noise += of.standard_error[c][i][j] ** 2 + as.standard_error[c][i][j] ** 2;
    square += as.flux[c][i][j] ** 2;
  }));
  return square > 0 ? {value: Math.sqrt(Math.max(0, difference - noise) / square), noise: Math.sqrt(noise / square)} : null;
}

const stops = [[8, 8, 28], [70, 20, 110], [150, 45, 125], [222, 80, 90], [252, 150, 80], [253, 250, 200]];
function shade(t) {
  const x = Math.min(1, Math.max(0, t)) * (stops.length - 1), i = Math.min(stops.length - 2, Math.floor(x));
  return stops[i].map((from, c) => from + (stops[i + 1][c] - from) * (x - i));
}
const decades = 4;
const level = (value, most) => at('scale').value === 'linear' ? value / most : value > 0 ? 1 + Math.log10(value / most) / decades : 0;

/** The brightest of the truth, or of the first model, colors all maps of a lobe alike. */
const scaleOf = (lobe) => Math.max(1e-30, largest(truth || fields[0], lobe));

function paintMap(canvas, field, lobe) {
  const {thetas, phis} = bins(), most = scaleOf(lobe);
  canvas.width = phis;
  canvas.height = thetas;
  const context = canvas.getContext('2d'), image = context.createImageData(phis, thetas);
  for (let i = 0; i < thetas; ++i) {
    for (let j = 0; j < phis; ++j) image.data.set([...shade(level(density(field, lobe, i, j), most)), 255], 4 * ((thetas - 1 - i) * phis + j));
  }
  context.putImageData(image, 0, 0);
}

function words(field, lobe) {
  const energy = part(field, lobe).energy[chosen.channel], error = part(field, lobe).energy_error[chosen.channel];
  const away = truth && field !== truth ? distance(field, lobe) : null;
  return `energy ${short(energy, 4)} ± ${short(error, 1)}${away ? `; L2 ${short(away.value)}${away.noise > 0.2 * away.value ? ` (noise ${short(away.noise, 2)})` : ''}` : ''}`;
}

function drawMaps() {
  const made = at('maps');
  made.replaceChildren();
  const order = ['whole', ...names.filter((name) => name !== 'whole')];
  const head = element('tr');
  head.append(element('th', 'model'), ...order.map((lobe) => element('th', lobe)));
  made.append(head);
  for (const field of fields) {
    const row = element('tr'), name = element('th'), swatch = element('span', '', 'swatch');
    swatch.style.background = colors[field.model];
    name.append(swatch, field.model);
    if (field.rows) name.append(element('br'), element('small', `${field.rows.converged} row${field.rows.converged === 1 ? '' : 's'}${field.rows.open + field.rows.refused ? `, ${field.rows.open + field.rows.refused} not converged` : ''}`));
    row.append(name);
    for (const lobe of order) {
      const cell = element('td', '', lobe === chosen.lobe ? 'chosen' : ''), canvas = element('canvas');
      cell.dataset.model = field.model;
      cell.dataset.lobe = lobe;
      canvas.setAttribute('role', 'img');
      canvas.setAttribute('aria-label', `${lobe} of ${field.model}, theta_i upwards by phi_i`);
      paintMap(canvas, field, lobe);
      canvas.addEventListener('click', (event) => {
        const box = canvas.getBoundingClientRect(), {thetas, phis} = bins();
        choose({lobe, theta: thetas - 1 - Math.floor((event.clientY - box.top) / box.height * thetas), phi: Math.floor((event.clientX - box.left) / box.width * phis)});
      });
      cell.append(canvas, element('small', words(field, lobe)));
      row.append(cell);
    }
    made.append(row);
  }
  const ramp = element('canvas', '', 'ramp');
  ramp.width = 64;
  ramp.height = 1;
  for (let i = 0; i < 64; ++i) { const context = ramp.getContext('2d'); context.fillStyle = `rgb(${shade(i / 63)})`; context.fillRect(i, 0, 1, 1); }
  at('key').replaceChildren(at('scale').value === 'log' ? `${decades} decades below` : '0 to', ramp, `the brightest bin of ${(truth || fields[0]).model}, of each lobe`);
}

function drawSlices() {
  const {thetas, phis} = bins(), drawn = fields.filter((field) => chosen.models.has(field.model));
  const phi = Array.from({length: phis}, (_, j) => phiOf(j)), theta = Array.from({length: thetas}, (_, i) => thetaOf(i));
  const round = (field) => phi.map((_, j) => density(field, chosen.lobe, chosen.theta, j));
  const along = (field) => theta.map((_, i) => density(field, chosen.lobe, i, chosen.phi));
  const series = (angles, values) => drawn.map((field) => ({
    name: field.model, color: colors[field.model], width: field === truth ? 2.6 : 1.6, points: values(field).map((y, i) => ({x: angles[i], y}))}));
  at('slice-title').textContent = `${chosen.lobe}: through theta_i ${short(thetaOf(chosen.theta), 4)} and phi_i ${short(phiOf(chosen.phi), 4)} degrees`;
  const panels = drawSlices.panels = drawSlices.panels || {
    polar: polarPanel(at('slices'), 'Around the fiber'), round: chartPanel(at('slices'), 'Over phi_i'), along: chartPanel(at('slices'), 'Over theta_i')};
  polarChart(panels.polar, phi, drawn.map((field) => ({values: round(field), color: colors[field.model]})), '1/rad²');
  lineChart(panels.round, {series: series(phi, round), x: 'phi_i, degrees', y: '1/rad²', range: circle, legend: false});
  lineChart(panels.along, {series: series(theta, along), x: 'theta_i, degrees', y: '1/rad²', range: [-90, 90], legend: false});
}

function choose(what) {
  Object.assign(chosen, what);
  at('lobe').value = chosen.lobe;
  at('theta').value = chosen.theta;
  at('phi').value = chosen.phi;
  for (const cell of document.querySelectorAll('.maps td')) cell.classList.toggle('chosen', cell.dataset.lobe === chosen.lobe);
  drawSlices();
}

function chooseBrightest() {
  const field = truth || fields[0], most = largest(field, chosen.lobe) * binSize();
  flux(field, chosen.lobe).forEach((row, i) => row.forEach((value, j) => { if (value === most) choose({theta: i, phi: j}); }));
}

function drawFarFields() {
  const p = fields[0].parameters, {thetas, phis} = bins();
  at('far').hidden = false;
  at('about').textContent = `one fiber: eccentricity ${p.e}, roughness ${p.alpha}, tilt ${p.tilt_deg} degrees, eta ${p.eta}, sigma_a ${p.sigma_a.join(', ')}; light from theta_r ${p.theta_r_deg}, phi_r ${p.phi_r_deg} degrees`;
  at('far-words').textContent = `Light that leaves the fiber, by bin: theta_i up from -90 to 90 degrees, phi_i right from -180 to 180 (${thetas} x ${phis} bins). ${truth ? 'L2: distance from fiber3d, the fiber traced in three dimensions, relative to it, less what noise makes of it. ' : ''}A click on a map chooses its lobe and bin for the slices.`;
  at('channel').append(...fields[0].channels.map((name, i) => new Option(name, i)));
  at('channel-label').hidden = fields[0].channels.length === 1;
  at('lobe').append(...names.map((name) => new Option(name, name)));
  at('theta').max = thetas - 1;
  at('phi').max = phis - 1;
  for (const field of fields) {
    const label = element('label'), box = element('input'), swatch = element('span', '', 'swatch');
    box.type = 'checkbox';
    box.checked = true;
    swatch.style.background = colors[field.model];
    box.addEventListener('change', () => { chosen.models[box.checked ? 'add' : 'delete'](field.model); drawSlices(); });
    label.append(box, ' ', swatch, field.model);
    at('models').append(label);
  }
  at('channel').addEventListener('change', () => { chosen.channel = Number(at('channel').value); drawMaps(); drawSlices(); });
  at('scale').addEventListener('change', drawMaps);
  at('lobe').addEventListener('change', () => choose({lobe: at('lobe').value}));
  at('theta').addEventListener('input', () => choose({theta: Number(at('theta').value)}));
  at('phi').addEventListener('input', () => choose({phi: Number(at('phi').value)}));
  at('peak').addEventListener('click', chooseBrightest);
  drawMaps();
  chooseBrightest();
}

function drawRows() {
  if (!lobes.rows.length) return;
  at('rows').append(element('h2', 'Rows of elliptical, beside their targets'));
  if (!fields.length) at('about').textContent = 'one row of the table';
  else at('rows').append(element('p', 'What the table learns for this fiber and this light where it leaves on the specular cone (theta_d is theta_r). The azimuth is absolute, from the major axis.', 'soft'));
  for (const row of lobes.rows) {
    const p = row.parameters, grid = element('div', '', 'grid narrow');
    at('rows').append(element('h2', `${row.lobe}${row.channel && row.channel !== 'grey' ? `, ${row.channel}` : ''}`));
    const line = element('p');
    line.append(row.lobe === 'R' ? 'closed form' : element('span', row.converged ? 'converged' : 'not converged', row.converged ? 'good' : 'bad'),
                `: energy ${short(row.energy, 4)}, relative squared error ${short(row.relative_l2)}${row.lobe === 'R' ? '' : ` (epsilon ${p.epsilon}), ${row.components} component${row.components === 1 ? '' : 's'}, ${row.evaluations} evaluations of g`}. `,
                element('span', `e ${p.e}, eta ${p.eta}, phi_r ${p.phi_deg}, theta_d ${p.theta_d_deg}, blur ${short(p.sigma_deg, 4)} degrees, sigma_a ${p.sigma_a}`, 'soft'));
    at('rows').append(line, grid);
    rowCharts(grid, row);
  }
}

if (fields.length) drawFarFields();
drawRows();
