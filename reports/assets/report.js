(function () {
  'use strict';

  const font = 'system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
  const axis = {
    labelFont: font, titleFont: font, labelFontSize: 12, titleFontSize: 13, titleFontWeight: 'normal',
    labelColor: '#161b20', titleColor: '#161b20', domainColor: '#5b6670', tickColor: '#5b6670',
    gridColor: '#e4e8eb'
  };
  const legend = {
    labelFont: font, titleFont: font, labelFontSize: 12, titleFontSize: 13, titleFontWeight: 'normal',
    labelColor: '#161b20', titleColor: '#161b20'
  };
  const options = {
    mode: 'vega-lite',
    renderer: 'svg',
    actions: {export: true, source: false, compiled: false, editor: false},
    config: {
      font: font, axis: axis, legend: legend, text: {font: font, fontSize: 12, color: '#161b20'},
      view: {stroke: '#5b6670'}, background: '#ffffff'
    }
  };

  const specs = JSON.parse(document.getElementById('figures').textContent);

  // A hidden figure has no width to be drawn in: it is drawn when it is first shown.
  function draw(figure) {
    const spec = specs[figure.dataset.figure];
    if (!spec || figure.hidden || figure.dataset.drawn) return;
    figure.dataset.drawn = 'yes';
    const plot = figure.querySelector('.plot');
    vegaEmbed(plot, spec, options).catch(function (error) {
      plot.textContent = 'This figure could not be drawn: ' + error.message;
      console.error(error);
    });
  }
  const figures = Array.from(document.querySelectorAll('figure[data-figure]'));

  const choice = document.getElementById('pair');
  if (choice) {
    choice.addEventListener('change', function () {
      figures.forEach(function (figure) {
        if (!('pair' in figure.dataset)) return;
        figure.hidden = figure.dataset.pair !== choice.value;
        draw(figure);
      });
    });
  }
  figures.forEach(draw);

  // Rows without a value (failures) stay at the end, whatever the direction.
  function sortBy(table, header, column) {
    const descending = header.getAttribute('aria-sort') === 'ascending';
    const numeric = header.classList.contains('number');
    const body = table.tBodies[0];
    const rows = Array.from(body.rows).map(function (row) {
      const cell = row.cells[column];
      const text = 'sort' in cell.dataset ? cell.dataset.sort : cell.textContent.trim();
      return {row: row, key: numeric && text !== '' ? Number(text) : text};
    });
    rows.sort(function (a, b) {
      if (a.key === '' || b.key === '') return (a.key === '') - (b.key === '');
      const order = numeric ? a.key - b.key : a.key.localeCompare(b.key);
      return descending ? -order : order;
    });
    rows.forEach(function (item) { body.appendChild(item.row); });
    Array.from(header.parentNode.cells).forEach(function (other) {
      other.removeAttribute('aria-sort');
    });
    header.setAttribute('aria-sort', descending ? 'descending' : 'ascending');
  }
  document.querySelectorAll('table.sortable').forEach(function (table) {
    Array.from(table.tHead.rows[0].cells).forEach(function (header, column) {
      header.tabIndex = 0;
      header.title = 'Sort';
      header.addEventListener('click', function () { sortBy(table, header, column); });
      header.addEventListener('keydown', function (event) {
        if (event.key === 'Enter' || event.key === ' ') {
          event.preventDefault();
          sortBy(table, header, column);
        }
      });
    });
  });
}());
