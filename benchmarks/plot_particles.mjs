// node benchmarks/plot_particles.mjs PICTURE.svg [--top] [--half] [--columns=N] LABEL=SNAPSHOTS[@DISPLACEMENT]…: draws
// particles of `powdercal simulate … --snapshots`, one picture for each argument, row by row. SNAPSHOTS is the folder that `simulate` names, the
// state drawn the last one, or the one whose blade has moved nearest to DISPLACEMENT [mm]. From the side (x to the
// right, z up) with --half only the particles of the nearer half, or from above (--top). The darker, the higher.
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';

const options = process.argv.slice(2);
const top = options.includes('--top');
const half = options.includes('--half');
const columns = Number(options.find((option) => option.startsWith('--columns='))?.slice(10) ?? 1);
const [target, ...wanted] = options.filter((option) => !option.startsWith('--'));
if (!wanted.length) {
  console.error('usage: node benchmarks/plot_particles.mjs PICTURE.svg [--top] [--half] [--columns=N] LABEL=SNAPSHOTS[@DISPLACEMENT]…');
  process.exit(2);
}

const kTypes = {Float64: Float64Array, Float32: Float32Array, Int64: BigInt64Array, Int32: Int32Array};

// The arrays of one VTK file by name; lengths in µm.
const readArrays = (file) => {
  const arrays = {};
  const pattern = /<(?:Data)?Array type="(\w+)" Name="(\w+)"[^>]*>\s*([A-Za-z0-9+/=]*)\s*</g;
  for (const [, type, name, text] of readFileSync(file, 'utf8').matchAll(pattern)) {
    const bytes = new Uint8Array(Buffer.from(text, 'base64').subarray(8)); // after their number
    arrays[name] ??= type === 'String' ? Buffer.from(bytes).toString().split('\0') : new kTypes[type](bytes.buffer);
  }
  return arrays;
};

const files = (folder, series) =>
  [...readFileSync(join(folder, `${series}.pvd`), 'utf8').matchAll(/file="([^"]+)"/g)].map(([, file]) => join(folder, file));

// The blade's corners [µm]; null where there is no blade.
const readBlade = (file) => {
  const {body, body_names: names, connectivity, position} = readArrays(file);
  const blade = names.indexOf('blade');
  if (blade < 0) return null;
  const corners = [];
  body.forEach((one, triangle) => {
    if (one !== blade) return;
    for (const point of connectivity.subarray(3 * triangle, 3 * triangle + 3)) {
      corners.push([...position.subarray(3 * point, 3 * point + 3)].map((x) => 1e6 * x));
    }
  });
  const along = (axis) => corners.map((corner) => corner[axis]);
  return {x: Math.max(...along(0)), back: Math.min(...along(0)), gap: Math.min(...along(2))};
};

const readParticles = (file) => {
  const {radius, position} = readArrays(file);
  return [...radius].map((r, i) => {
    const [x, y, z] = position.subarray(3 * i, 3 * i + 3);
    return {x: 1e6 * x, y: 1e6 * y, z: 1e6 * z, r: 1e6 * r};
  });
};

const readRow = (argument) => {
  const [, label, folder, displacement] = argument.match(/^(.*)=(.*?)(?:@([\d.]+))?$/) ?? [];
  if (!folder) throw new Error(`expected LABEL=SNAPSHOTS[@DISPLACEMENT], got ${argument}`);
  const walls = files(folder, 'walls');
  let frame = walls.length - 1;
  if (displacement !== undefined) {
    const start = readBlade(walls[0]).x;
    const off = walls.map((file) => Math.abs(readBlade(file).x - start - 1e3 * displacement));
    frame = off.lastIndexOf(Math.min(...off)); // of those before the sweep the last, at rest
  }
  return {label, blade: readBlade(walls[frame]), particles: readParticles(files(folder, 'particles')[frame])};
};

const rows = wanted.map(readRow);
const all = rows.flatMap((row) => row.particles);
const span = (axis) => [Math.min(...all.map((p) => p[axis] - p.r)), Math.max(...all.map((p) => p[axis] + p.r))];
const [x0, x1] = span('x');
const [low, high] = span(top ? 'y' : 'z');
const highest = span('z')[1];
const kColours = ['#f3d9a4', '#e8b96a', '#d98f3f', '#bf6427', '#96411c', '#6b2a18', '#451a12'];
const colour = (z) => kColours[Math.max(0, Math.min(kColours.length - 1, Math.floor((kColours.length * z) / Math.min(highest, 240))))];

// Discs in the order in which one hides the other; runs of one colour share a group.
const discs = ({particles}) => {
  const middle = all.reduce((sum, p) => sum + p.y, 0) / all.length;
  const seen = half && !top ? particles.filter((p) => p.y < middle) : [...particles];
  seen.sort(top ? (a, b) => a.z - b.z : (a, b) => b.y - a.y);
  let text = '';
  let last = '';
  for (const {x, y, z, r} of seen) {
    const fill = z < 0 ? '#c9ced6' : colour(z); // the fixed ones have their tops at 0
    if (fill !== last) text += `${last && '</g>'}<g fill="${fill}">`;
    last = fill;
    text += `<circle cx="${Math.round(x - x0)}" cy="${Math.round(top ? y - low : high - z)}" r="${Math.round(r)}"/>`;
  }
  return text + '</g>';
};

const unit = Math.max(1, (columns * (x1 - x0)) / 2800); // of text, in wide pictures
const kLabel = Math.round(60 * unit); // µm, above each picture
const kMargin = 40;
const height = high - low + kLabel + 30;
const width = x1 - x0 + 2 * kMargin;
const rectangle = (left, right, upper, lower, fill) => `<rect x="${Math.round(left)}" y="${Math.round(upper)}" ` +
  `width="${Math.round(right - left)}" height="${Math.round(lower - upper)}" fill="${fill}"/>`;
const drawBlade = (blade) => (top ? rectangle(blade.back - x0, blade.x - x0, 0, high - low, '#33415580')
  : rectangle(blade.back - x0, blade.x - x0, 0, high - blade.gap, '#334155'));
const drawRow = (row, i) => {
  const at = [kMargin + (i % columns) * width, kLabel + Math.floor(i / columns) * height].map(Math.round);
  return `<g transform="translate(${at.join(' ')})"><text y="${Math.round(-16 * unit)}" font-size="${Math.round(36 * unit)}" fill="#111">${row.label}</text>` +
    `<g stroke="#2228" stroke-width="1.2">${discs(row)}</g>${row.blade ? drawBlade(row.blade) : ''}</g>`;
};
const size = [Math.round(columns * width), Math.round(Math.ceil(rows.length / columns) * height + 80 * unit)];
const bar = unit > 1 ? 1000 : 200; // µm
const scale = `<g transform="translate(${kMargin} ${Math.round(size[1] - 30 * unit)})"><path d="M0 0h${bar}" stroke="#111" stroke-width="6"/>` +
  `<text x="${bar + 15}" y="${Math.round(12 * unit)}" font-size="${Math.round(34 * unit)}" fill="#111">${bar} µm</text></g>`;
writeFileSync(target, `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${size.join(' ')}" width="1000" font-family="sans-serif">` +
  `<rect width="100%" height="100%" fill="white"/>${rows.map(drawRow).join('\n')}${scale}</svg>\n`);
