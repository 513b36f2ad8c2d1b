// The report of runs: `runs` is what report_data.cpp made of their telemetry.
'use strict';
const main = document.getElementById('main');
document.getElementById('about').textContent =
    `${runs.length} run${runs.length === 1 ? '' : 's'}: ${runs.map((run) => run.name).join(', ')}`;

const percent = (share) => share === null || share === undefined ? '–' : `${short(100 * share)} %`;
const last = (list) => list.length ? list[list.length - 1] : null;
const of = (run, field) => run.passes.map((pass) => ({x: pass.pass + 1, y: pass[field]}));

function heading(text) { main.append(element('h2', text)); }

heading('Has it converged?');
for (const run of runs) {
  const line = element('p');
  line.append(element('strong', `${run.name}: `), element('span', run.verdict.text, run.verdict.good ? 'good' : 'bad'));
  main.append(line);
}

heading('The runs side by side');
const rowsOf = (run, state) => last(run.passes) ? last(run.passes)[state] : null;
const facts = [
  ['scene', (run) => run.header.scene],
  ['model, estimator', (run) => `${run.header.model}, ${run.header.estimator}`],
  ['epsilon', (run) => run.header.epsilon],
  ['status', (run) => run.summary ? `${run.summary.status}, by ${run.summary.stopped_by || '–'}` : 'ended without a summary: killed?'],
  ['passes', (run) => run.passes.length],
  ['samples a pixel', (run) => run.summary && run.summary.samples_per_pixel],
  ['seconds (wall)', (run) => run.summary && run.summary.seconds],
  ['CPU seconds of the passes', (run) => run.cost.cpu_seconds],
  ['noise of the picture', (run) => last(run.passes) && last(run.passes).noise],
  ['queries answered by rows, last pass', (run) => percent(last(run.passes) && last(run.passes).answered_query_share)],
  ['by rows that have converged', (run) => percent(last(run.passes) && last(run.passes).converged_query_share)],
  ['rows converged', (run) => rowsOf(run, 'converged')],
  ['rows open', (run) => rowsOf(run, 'open')],
  ['rows refused', (run) => rowsOf(run, 'refused')],
  ['error of fits, median and 99 %', (run) => last(run.passes) ? `${short(last(run.passes).p50)}, ${short(last(run.passes).p99)}` : null],
  ['brightness off by fits at most', (run) => percent(last(run.passes) && last(run.passes).bias_bound)],
  ['g evaluations', (run) => run.cost.g_evaluations],
  ['CPU seconds of learning between passes', (run) => run.cost.learning_cpu_seconds],
  ['its share of the CPU time', (run) => percent(run.cost.learning_share)],
  ['table, bytes', (run) => last(run.passes) && last(run.passes).bytes],
  ['warm cache', (run) => run.cache.loaded],
  ['rows that it brought', (run) => run.cache.rows_known],
  ['samples that they had been learned from', (run) => run.cache.samples_known],
  ['CPU seconds that this spared, estimated', (run) => run.cache.cpu_seconds_spared],
];
table(main, ['', ...runs.map((run) => run.name)],
      facts.map(([name, value]) => [name, ...runs.map(value)]), runs.map((_, i) => i + 1));

heading('How it went');
const grid = element('div', '', 'grid');
main.append(grid);
const compare = (title, field, options, note) => lineChart(
    chartPanel(grid, title, note), {series: runs.map((run) => ({name: run.name, points: of(run, field)})), x: 'pass', ...options});
compare('Queries answered by rows', 'answered_query_share', {y: 'share', max: 1});
compare('Queries answered by rows that have converged', 'converged_query_share', {y: 'share', max: 1});
compare('Nodes answered by coarser rows', 'coarse', {y: 'nodes'});
lineChart(chartPanel(grid, 'Error of the fits', 'Relative squared L2 of clear rows; of rough, chi-square, and rows that carry little light may have more than epsilon, the dashed line.'), {
  series: [...runs.flatMap((run) => [
             {name: `${run.name} median`, points: of(run, 'p50')}, {name: `${run.name} 99 %`, points: of(run, 'p99')}]),
           {name: 'epsilon', dashed: true, color: '#888', points: of(runs[0], 'pass').map(({x}) => ({x, y: runs[0].header.epsilon}))}],
  x: 'pass', y: 'objective', logY: true});
lineChart(chartPanel(grid, 'Noise of the picture'), {
  series: runs.map((run) => ({name: run.name, points: run.passes.map((pass) => ({x: pass.samples, y: pass.noise}))})),
  x: 'paths', y: 'relative', logX: true, logY: true});
lineChart(chartPanel(grid, 'What learning cost', 'CPU time between passes, summed; g evaluations within passes are in the CPU time of the passes.'), {
  series: runs.flatMap((run) => {
    let learning = 0, all = 0;
    const sums = run.passes.map((pass) => ({x: pass.pass + 1, learning: learning += pass.learning_cpu_seconds, all: all += pass.cpu_seconds || 0}));
    return [{name: `${run.name} learning`, points: sums.map((s) => ({x: s.x, y: s.learning}))},
            {name: `${run.name} all`, dashed: true, points: sums.map((s) => ({x: s.x, y: s.all}))}];
  }), x: 'pass', y: 'CPU seconds', logY: true});
for (const run of runs) {
  lineChart(chartPanel(grid, `Rows of ${run.name}`), {
    series: ['converged', 'open', 'refused'].map((state) => ({name: state, points: of(run, state)})), x: 'pass', y: 'rows'});
}
compare('Memory of the table', 'bytes', {y: 'bytes'});

heading('Rows that have not converged');
for (const run of runs) {
  main.append(element('p', `${run.name}: ${run.left.text}`));
  if (!run.left.rows.length) continue;
  table(main, ['row', 'angles', 'state', 'error', 'failed tests', 'light', 'of all', 'see it'],
        run.left.rows.map((row) => [
          row.fiber, row.angles, row.state, row.objective, row.failed_tests, row.light, percent(row.share), row.command]),
        [0, 1, 2, 7]);
}
