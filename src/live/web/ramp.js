// The editor of a color as a scene file has it: three numbers, linear RGB, or {"ramp": [[place, color], ...]} along the strand.
'use strict';

const linearOfHex = (hex) => [1, 3, 5].map((i) => {
  const x = parseInt(hex.slice(i, i + 2), 16) / 255;
  return Math.min(0.999, Math.max(0.001, Number((x <= 0.04045 ? x / 12.92 : Math.pow((x + 0.055) / 1.055, 2.4)).toFixed(4))));
});
const hexOfLinear = (color) => '#' + color.map((x) => Math.round(255 * encodeSrgb(x)).toString(16).padStart(2, '0')).join('');

/** The color of a ramp at a place, as the render interpolates it but for "smooth". */
function rampAt(stops, place) {
  const after = stops.findIndex(([x]) => x >= place);
  if (after <= 0) return stops[after < 0 ? stops.length - 1 : 0][1];
  const [[a, from], [b, to]] = [stops[after - 1], stops[after]], share = (place - a) / (b - a);
  return from.map((x, c) => x + (to[c] - x) * share);
}

/** Fills `box` with the editor; changed(color) is called after every edit. */
function colorEditor(box, color, changed) {
  const swap = element('button', ''), strip = element('div', '', 'strip'), canvas = element('canvas'), row = element('div', '', 'bar');
  const most = 16, gap = 0.001;
  canvas.width = 256;
  canvas.height = 1;
  strip.append(canvas);
  box.replaceChildren(element('span', 'Color'), swap, strip, row);

  const stops = () => Array.isArray(color) ? null : color.ramp;
  const edit = () => { draw(); changed(color); };
  const input = (value, label, set) => {
    const picker = element('input');
    Object.assign(picker, {type: 'color', value: hexOfLinear(value)});
    picker.setAttribute('aria-label', label);
    picker.addEventListener('input', () => { set(linearOfHex(picker.value)); paintStrip(); changed(color); });
    return picker;
  };

  function paintStrip() {
    const context = canvas.getContext('2d'), image = context.createImageData(256, 1);
    for (let x = 0; x < 256; ++x) image.data.set([...rampAt(stops() || [[0, color]], x / 255).map((v) => Math.round(255 * encodeSrgb(v))), 255], 4 * x);
    context.putImageData(image, 0, 0);
  }

  /** Moves a stop, but not past its neighbours. */
  function move(i, place) {
    const list = stops(), least = i > 0 ? list[i - 1][0] + gap : 0, highest = i + 1 < list.length ? list[i + 1][0] - gap : 1;
    list[i][0] = Number(Math.min(highest, Math.max(least, place)).toFixed(3));
    const handle = strip.querySelectorAll('.stop')[i];
    handle.style.left = `${100 * list[i][0]}%`;
    handle.setAttribute('aria-valuenow', list[i][0]);
    paintStrip();
    changed(color);
  }

  function handleOf(i) {
    const handle = element('button', '', 'stop');
    handle.setAttribute('role', 'slider');
    for (const [name, value] of [['label', `stop ${i + 1}, from root to tip`], ['valuemin', 0], ['valuemax', 1], ['valuenow', stops()[i][0]]]) handle.setAttribute(`aria-${name}`, value);
    handle.style.left = `${100 * stops()[i][0]}%`;
    handle.addEventListener('click', (event) => event.stopPropagation());
    handle.addEventListener('pointerdown', (event) => handle.setPointerCapture(event.pointerId));
    handle.addEventListener('pointermove', (event) => { if (handle.hasPointerCapture(event.pointerId)) move(i, placeOf(event)); });
    handle.addEventListener('keydown', (event) => {
      const step = {ArrowLeft: -0.01, ArrowDown: -0.01, ArrowRight: 0.01, ArrowUp: 0.01, PageUp: 0.1, PageDown: -0.1, Home: -1, End: 1}[event.key];
      if (step) move(i, stops()[i][0] + step);
      if (event.key === 'Delete' && stops().length > 1) {
        stops().splice(i, 1);
        edit();
        strip.querySelectorAll('.stop')[Math.max(0, i - 1)].focus();
      }
      if (step || event.key === 'Delete') event.preventDefault();
    });
    return handle;
  }

  const placeOf = (event) => {
    const {left, width} = strip.getBoundingClientRect();
    return Number(Math.min(1, Math.max(0, (event.clientX - left) / width)).toFixed(3));
  };

  function draw() {
    const list = stops();
    swap.textContent = list ? 'One color' : 'Along the strand';
    strip.hidden = !list;
    strip.querySelectorAll('.stop').forEach((handle) => handle.remove());
    row.replaceChildren();
    if (!list) row.append(input(color, 'color', (value) => { color = value; }));
    for (let i = 0; list && i < list.length; ++i) {
      strip.append(handleOf(i));
      row.append(input(list[i][1], `color of stop ${i + 1}`, (value) => { list[i][1] = value; }));
    }
    paintStrip();
  }

  swap.addEventListener('click', () => {
    const list = stops();
    color = list ? list[0][1] : {ramp: [[0, color], [1, color]], interpolation: 'linear'};
    edit();
  });
  strip.addEventListener('click', (event) => {
    const list = stops(), place = placeOf(event);
    if (list.length >= most || list.some(([x]) => Math.abs(x - place) < gap)) return;
    list.push([place, rampAt(list, place).map((x) => Number(x.toFixed(4)))]);
    list.sort(([a], [b]) => a - b);
    edit();
    strip.querySelectorAll('.stop')[list.findIndex(([x]) => x === place)].focus();
  });
  draw();
}
