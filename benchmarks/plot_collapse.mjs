// node benchmarks/plot_collapse.mjs collapse.json PLOT.svg EXPERIMENT.RESPONSE GROUP…: draws what
// `powdercal scale STUDY --collapse --out FOLDER` left there; a column for each group, every seed a point.
import {readFileSync, writeFileSync} from 'node:fs';
import * as vega from 'vega';
import * as lite from 'vega-lite';

const [source, target, wanted, ...groups] = process.argv.slice(2);
if (!groups.length) {
  console.error('usage: node benchmarks/plot_collapse.mjs collapse.json PLOT.svg EXPERIMENT.RESPONSE GROUP…');
  process.exit(2);
}
const report = JSON.parse(readFileSync(source, 'utf8'));
const [experiment, response] = wanted.split('.');

const column = (group, first) => ({
  width: 220, height: 200,
  data: {
    values: report.points
        .filter((point) => point.experiment === experiment && point.groups[group])
        .flatMap(({mode, groups: own, responses}) =>
          (responses[response] ?? []).map((value) => ({mode, x: own[group], y: value}))),
  },
  mark: {type: 'point', filled: true, size: 50, opacity: 0.7},
  encoding: {
    x: {field: 'x', type: 'quantitative', title: group, scale: {type: 'log'}},
    y: {
      field: 'y', type: 'quantitative', scale: {zero: false},
      title: first ? response.replaceAll('_', ' ') : null,
    },
    color: {
      field: 'mode', type: 'nominal', legend: {title: null, orient: 'top', labelLimit: 0},
      scale: {range: ['#0b5cad', '#c2410c', '#2f7d32']},
    },
  },
});

const spec = lite.compile({
  background: 'white',
  hconcat: groups.map((group, i) => column(group, i === 0)),
}).spec;
const view = new vega.View(vega.parse(spec), {renderer: 'none'});
writeFileSync(target, await view.toSVG());
