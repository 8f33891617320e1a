// node benchmarks/plot.mjs REPORT.json PLOT.svg [RESPONSE…]: draws what benchmarks/protocol printed with
// --json; a row for each response, a column for each sweep, mean and standard deviation over seeds.
import {readFileSync, writeFileSync} from 'node:fs';
import * as vega from 'vega';
import * as lite from 'vega-lite';

const [source, target, ...wanted] = process.argv.slice(2);
if (!target) {
  console.error('usage: node benchmarks/plot.mjs REPORT.json PLOT.svg [RESPONSE…]');
  process.exit(2);
}
const report = JSON.parse(readFileSync(source, 'utf8'));

const degrees = (response) => report.units?.[response] === 'rad';
const title = (response) => response.replaceAll('_', ' ') + (degrees(response) ? ' [°]' : '');

const rows = [];
for (const {sweep, cases} of report.sweeps) {
  if (report.sweeps.length > 1 && cases.length === 1) continue; // nothing to compare
  for (const {setting, point, responses} of cases) {
    for (const [response, value] of Object.entries(responses)) {
      if (!value || (wanted.length && !wanted.includes(response))) continue;
      // Without a setting it is the points that are compared.
      const own = !setting;
      const factor = degrees(response) ? 180 / Math.PI : 1;
      rows.push({
        sweep: own ? 'k [J/m³]' : sweep, setting: own ? `${point.k}` : setting, response,
        mean: factor * value.mean, low: factor * (value.mean - value.sd), high: factor * (value.mean + value.sd),
        point: own ? `μr = ${point.mu_r}` : `k = ${point.k} J/m³, μr = ${point.mu_r}`,
      });
    }
  }
}

const unique = (field) => [...new Set(rows.map((row) => row[field]))];
const responses = wanted.length ? wanted : unique('response').sort();
const cell = (response, sweep, first, last) => {
  const values = rows.filter((row) => row.response === response && row.sweep === sweep);
  const x = {
    field: 'setting', type: 'nominal', sort: null,
    axis: {title: last ? sweep : null, labels: last, labelAngle: 0, labelLimit: 80},
  };
  const colour = {
    field: 'point', type: 'nominal', legend: {title: null, orient: 'top', labelLimit: 0},
    scale: {range: ['#0b5cad', '#c2410c', '#2f7d32']},
  };
  const y = (field) => ({
    field, type: 'quantitative', scale: {zero: false},
    axis: {title: first ? title(response) : null, tickCount: 4, format: '~r', minExtent: 42},
  });
  return {
    width: 190, height: 135, data: {values},
    layer: [
      {mark: {type: 'rule', strokeWidth: 2}, encoding: {x, xOffset: {field: 'point'}, y: y('low'), y2: {field: 'high'}, color: colour}},
      {mark: {type: 'point', filled: true, size: 45}, encoding: {x, xOffset: {field: 'point'}, y: y('mean'), color: colour}},
    ],
  };
};
const sweeps = unique('sweep');
const spec = {
  background: 'white',
  title: {text: `${report.experiment}: mean ± sd over ${report.seeds} particle seeds`, anchor: 'start'},
  vconcat: responses.map((response, r) => ({
    hconcat: sweeps.map((sweep, s) => cell(response, sweep, s === 0, r === responses.length - 1)),
    resolve: {scale: {y: 'shared'}},
  })),
  config: {font: 'sans-serif', axis: {labelFontSize: 10, titleFontSize: 11}},
};
const view = new vega.View(vega.parse(lite.compile(spec).spec), {renderer: 'none'});
writeFileSync(target, await view.toSVG());
