// Line charts by Chart.js, and small helpers of all pages.
'use strict';
const circle = [-180, 180];
const palette = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#000000', '#8c6d31', '#8a8f98'];

/** What stands there, in as many digits as say something. */
function short(x, digits = 3) {
  if (x === null || x === undefined || Number.isNaN(x)) return '–';
  if (typeof x !== 'number') return String(x);
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size >= 1e12 || size < 1e-4) return x.toExponential(digits - 1);
  for (const [unit, name] of [[1e9, 'billion'], [1e6, 'million']]) if (size >= unit) return `${Number((x / unit).toPrecision(digits))} ${name}`;
  if (size >= 1e4) return Number(size < 1e5 && Number.isInteger(x) ? x : x.toPrecision(digits)).toLocaleString('en');
  if (Number.isInteger(x)) return String(x);
  return String(Number(x.toPrecision(digits)));
}

/** An element with text; text is never taken as markup. */
function element(tag, text = '', className = '') {
  const made = document.createElement(tag);
  if (text !== '') made.textContent = text;
  if (className) made.className = className;
  return made;
}

function logTick(value) {
  const decade = Math.log10(value);
  return Math.abs(decade - Math.round(decade)) < 1e-9 ? short(value) : '';
}

/**
 * Lines over x. series: [{name, points: [{x, y}], dashed}]; what is not positive is left out of a logarithmic axis.
 * The chart is kept on its canvas: drawn again with new points when it is called again. min: null: where the points begin; range: of x; legend: whether there is one.
 */
function lineChart(canvas, {series, x, y, logX = false, logY = false, min = 0, max, range, legend = true}) {
  const shown = (point) => point.y !== null && Number.isFinite(point.y) && (!logY || point.y > 0) && (!logX || point.x > 0);
  const datasets = series.map((one, i) => ({
    label: one.name,
    data: one.points.filter(shown),
    borderColor: one.color || palette[i % palette.length],
    backgroundColor: one.color || palette[i % palette.length],
    borderDash: one.dashed ? [6, 4] : [],
    borderWidth: one.width || 1.8,
    pointRadius: one.points.length < 24 ? 2 : 0,
  }));
  if (canvas.chart) {
    canvas.chart.data.datasets = datasets;
    canvas.chart.update('none');
    return canvas.chart;
  }
  const axis = (title, isLog) => ({
    type: isLog ? 'logarithmic' : 'linear',
    title: {display: true, text: title},
    ticks: isLog ? {callback: logTick, autoSkip: false} : {callback: (value) => short(value), ...(title.endsWith('degrees') ? {stepSize: 45} : {})},
  });
  canvas.chart = new Chart(canvas, {
    type: 'line',
    data: {datasets},
    options: {
      animation: false, responsive: true, maintainAspectRatio: false, parsing: false, normalized: true,
      interaction: {mode: 'nearest', intersect: false},
      scales: {x: {...axis(x, logX), ...(range ? {min: range[0], max: range[1]} : {})}, y: {...axis(y, logY), ...(logY || min === null ? {} : {min}), ...(max === undefined ? {} : {max})}},
      plugins: {legend: {display: legend, labels: {boxWidth: 18, boxHeight: 2}},
                tooltip: {callbacks: {label: (item) => `${item.dataset.label}: ${short(item.parsed.y)}`}}},
    },
  });
  return canvas.chart;
}

/** A panel with a heading and a canvas; returns the canvas. */
function chartPanel(parent, title, note = '') {
  const panel = element('section', '', 'panel');
  panel.append(element('h2', title));
  const box = element('div', '', 'chart'), canvas = element('canvas');
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', title);
  box.append(canvas);
  panel.append(box);
  if (note) panel.append(element('p', note, 'soft'));
  parent.append(panel);
  return canvas;
}

/** rows: arrays of texts or numbers; text columns by index. */
function table(parent, head, rows, textColumns = []) {
  const made = element('table'), box = element('div', '', 'scroll');
  const line = (cells, tag) => {
    const row = element('tr');
    cells.forEach((cell, i) => row.append(
        cell instanceof Node ? cell : element(tag, short(cell), textColumns.includes(i) ? 'text' : '')));
    return row;
  };
  const top = element('thead'), body = element('tbody');
  top.append(line(head, 'th'));
  for (const cells of rows) body.append(line(cells, 'td'));
  made.append(top, body);
  box.append(made);
  parent.append(box);
  return made;
}

/** A panel with a square canvas for polarChart. */
function polarPanel(parent, title) {
  const panel = element('section', '', 'panel'), canvas = element('canvas');
  canvas.width = canvas.height = 560;
  canvas.style.cssText = 'width: 100%; max-width: 300px; display: block; margin: auto';
  panel.append(element('h2', title), canvas);
  parent.append(panel);
  return canvas;
}

/** Densities over the circle, which Chart.js has not: distance from the middle is the value; 0 degrees right, 90 up. */
function polarChart(canvas, degrees, curves, unit = '1/rad') {
  const context = canvas.getContext('2d'), half = canvas.width / 2, most = Math.max(1e-30, ...curves.flatMap((curve) => curve.values));
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.font = '20px sans-serif';
  context.lineWidth = 1;
  context.setLineDash([]);
  context.strokeStyle = context.fillStyle = '#b8c0c8';
  for (const ring of [0.25, 0.5, 0.75, 1]) { context.beginPath(); context.arc(half, half, 0.85 * half * ring, 0, 2 * Math.PI); context.stroke(); }
  context.fillStyle = '#5b6570';
  context.fillText(`${short(most)} ${unit}`, half + 22, half - 0.89 * half);
  for (const [name, x, y] of [['0', 0.88, -0.02], ['90', -0.04, 0.89], ['180', -0.99, -0.02], ['-90', -0.05, -0.95]]) context.fillText(name, half + x * half, half - y * half);
  for (const {values, color, dashed} of curves) {
    context.strokeStyle = color;
    context.lineWidth = 3;
    context.setLineDash(dashed ? [10, 7] : []);
    context.beginPath();
    values.forEach((value, i) => {
      const angle = degrees[i] * Math.PI / 180, radius = 0.85 * half * Math.max(0, value) / most;
      context.lineTo(half + radius * Math.cos(angle), half - radius * Math.sin(angle));
    });
    context.closePath();
    context.stroke();
  }
}

/** A row: target and fit over the azimuth and around the circle, the parts of the fit, and how far it is off. */
function rowCharts(parent, row) {
  const curve = (values) => row.phi_deg.map((x, i) => ({x, y: values[i]}));
  const target = {name: 'target', points: curve(row.target), color: '#222', width: 2.4};
  const fit = row.fit && {name: 'fit', points: curve(row.fit), color: '#d55e00', dashed: true};
  const shown = fit ? [target, fit] : [target];
  lineChart(chartPanel(parent, 'Fit and target'), {series: shown, x: 'azimuth, degrees', y: '1/rad', range: circle});
  polarChart(polarPanel(parent, 'Polar'), row.phi_deg,
             [{values: row.target, color: '#222'}, ...(fit ? [{values: row.fit, color: '#d55e00', dashed: true}] : [])]);
  if (!fit) return;
  lineChart(chartPanel(parent, 'Error, fit less target'), {
    series: [{name: 'error', points: row.phi_deg.map((x, i) => ({x, y: row.fit[i] - row.target[i]}))}], x: 'azimuth, degrees', y: '1/rad', range: circle, min: null});
  if (!row.parts || !row.parts.length) return;
  const name = (i) => i + 1 < row.parts.length ? `component ${i + 1}` : 'uniform';
  lineChart(chartPanel(parent, 'Components of the fit'), {
    series: row.parts.map((values, i) => ({name: name(i), points: curve(values)})), x: 'azimuth, degrees', y: '1/rad', range: circle});
}
