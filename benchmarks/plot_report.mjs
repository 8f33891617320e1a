// node benchmarks/plot_report.mjs REPORT.html [FIGURE PICTURE.svg [WIDTH]]: one figure of a report as an SVG file;
// without FIGURE, the names of its figures.
import {readFileSync, writeFileSync} from 'node:fs';
import * as vega from 'vega';
import * as lite from 'vega-lite';

const [report, figure, target, width = 460] = process.argv.slice(2);
if (!report || (figure && !target)) {
  console.error('usage: node benchmarks/plot_report.mjs REPORT.html [FIGURE PICTURE.svg [WIDTH]]');
  process.exit(2);
}
const text = readFileSync(report, 'utf8').match(/<script type="application\/json" id="figures">(.*?)<\/script>/s)?.[1];
const specs = JSON.parse(text ?? '{}');
if (!specs[figure]) {
  console.error(`${figure ? `no figure '${figure}'; ` : ''}figures: ${Object.keys(specs).join(', ')}`);
  process.exit(figure ? 2 : 0);
}
// A page gives its figures the width that it has.
const fixWidth = (spec) => {
  if (spec.width === 'container') spec.width = Number(width);
  for (const key of ['layer', 'hconcat', 'vconcat', 'concat']) spec[key]?.forEach(fixWidth);
};
fixWidth(specs[figure]);
const spec = {background: 'white', ...specs[figure], config: {font: 'sans-serif', view: {stroke: '#5b6670'}}};
const view = new vega.View(vega.parse(lite.compile(spec).spec), {renderer: 'none'});
// A map has thousands of cells: what only screen readers need of each, and digits beyond a tenth of a pixel, go,
// and neighbours of one colour become one.
const short = (svg) => svg.replace(/ (?:aria-label|aria-roledescription|role)="[^"]*"/g, '')
  .replace(/ stroke-width="0"/g, '')
  .replace(/\d+\.\d{2,}/g, (number) => String(Math.round(10 * number) / 10))
  .replace(/<path d="[^"]*" fill="([^"]*)"\/>(?:<path d="[^"]*" fill="\1"\/>)+/g, (cells, fill) =>
    `<path d="${[...cells.matchAll(/ d="([^"]*)"/g)].map(([, path]) => path).join('')}" fill="${fill}"/>`);
writeFileSync(target, short(await view.toSVG()));
