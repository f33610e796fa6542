// Plots.

import {
  BarController, BarElement, CategoryScale, Chart, Legend, LinearScale, LineElement,
  LogarithmicScale, PointElement, ScatterController, Tooltip,
} from 'chart.js';
import {colorOf, element} from './dom.js';
import {number, power} from './format.js';

Chart.register(BarController, BarElement, CategoryScale, Legend, LinearScale, LineElement,
               LogarithmicScale, PointElement, ScatterController, Tooltip);
Chart.defaults.animation = false;
Chart.defaults.font.family = 'system-ui, sans-serif';

const COLORS = ['--series-1', '--series-2', '--series-3', '--series-4', '--series-5', '--series-6',
                '--series-7', '--series-8'];
const MARKS = ['circle', 'rect', 'triangle', 'rectRot', 'star', 'crossRot', 'rectRounded', 'dash'];
const all = [];

function scale(label, isLog, isWhole) {
  return {
    type: isLog ? 'logarithmic' : 'linear',
    title: {display: true, text: label, color: colorOf('--muted')},
    grid: {color: colorOf('--line')},
    border: {color: colorOf('--line')},
    ticks: {
      color: colorOf('--muted'), maxTicksLimit: isLog ? undefined : 7, maxRotation: 0,
      precision: isWhole ? 0 : undefined,
      callback(value, index, ticks) {
        if (!isLog) {
          // As many digits as tell one tick from the next.
          const step = ticks.length > 1 ? Math.abs(ticks[1].value - ticks[0].value) : 0;
          const digits = step > 0 && value !== 0 ? Math.ceil(Math.log10(Math.abs(value) / step) - 1e-9) + 1 : 3;
          return Math.abs(value) < 1e-9 * step ? '0' : number(value, Math.min(12, Math.max(2, digits)));
        }
        const exponent = Math.log10(value);
        const whole = Math.abs(exponent - Math.round(exponent)) < 1e-6;
        const span = Math.log10(this.max / this.min);
        if (whole && (span < 8 || Math.round(exponent) % 2 === 0)) {
          return Math.abs(exponent) > 3.5 ? power(Math.round(exponent)) : number(value, 2);
        }
        const mantissa = Math.round(value / 10 ** Math.floor(exponent + 1e-9));
        return span < 1.6 && [2, 5].includes(mantissa) ? number(value, 2) : '';
      },
    },
  };
}

// A bar from `low` to `high` through each point that has them.
const intervals = {
  id: 'intervals',
  afterDatasetsDraw(chart) {
    const {ctx} = chart;
    chart.data.datasets.forEach((set, k) => {
      if (!set.data.some((p) => p && p.low !== undefined) || !chart.isDatasetVisible(k)) return;
      ctx.save();
      ctx.strokeStyle = set.borderColor;
      ctx.lineWidth = 1.5;
      for (const point of set.data) {
        if (point.low === undefined || point.low === null) continue;
        const x = chart.scales.x.getPixelForValue(point.x);
        const low = chart.scales.y.getPixelForValue(point.low);
        const high = chart.scales.y.getPixelForValue(point.high);
        ctx.beginPath();
        ctx.moveTo(x, low);
        ctx.lineTo(x, high);
        ctx.moveTo(x - 5, low);
        ctx.lineTo(x + 5, low);
        ctx.moveTo(x - 5, high);
        ctx.lineTo(x + 5, high);
        ctx.stroke();
      }
      ctx.restore();
    });
  },
};

function build(canvas, {series, x, y, logX, logY, bars, xTicks, wholeX, wholeY}) {
  const datasets = series.map((s, k) => {
    const color = colorOf(s.color ?? COLORS[k % COLORS.length]);
    return {
      label: s.name, data: s.points, borderColor: color,
      backgroundColor: bars ? color : s.hollow ? 'transparent' : color,
      showLine: s.line ?? true, borderWidth: s.line === false ? 1.5 : 2, tension: 0,
      borderDash: s.dash ? [6, 4] : [],
      pointStyle: s.mark === false ? 'line' : MARKS[(k + 3 * Math.floor(k / COLORS.length)) % MARKS.length],
      pointRadius: s.mark === false || s.points.length > 80 ? 0 : 3.5, pointHoverRadius: 6, hoverBorderWidth: 2,
      barPercentage: 1, categoryPercentage: 0.96,
    };
  });
  const scales = {x: scale(x, logX, wholeX), y: scale(y, logY, wholeY)};
  const ends = bars ? [] : series.flatMap((s) => s.points.flatMap((p) => [p.low, p.high]))
    .filter((v) => Number.isFinite(v));
  if (ends.length > 0) {
    scales.y.suggestedMin = Math.min(...ends);
    scales.y.suggestedMax = Math.max(...ends);
    scales.y.grace = '5%';
  }
  if (bars) scales.x = {...scale(x, false), type: 'category', grid: {display: false}};
  if (bars) scales.x.ticks = {color: colorOf('--muted'), maxTicksLimit: 8};
  if (xTicks) {
    scales.x.min = -0.6;
    scales.x.max = xTicks.length - 0.4;
    scales.x.ticks = {
      color: colorOf('--muted'), stepSize: 1, autoSkip: false,
      callback: (value) => xTicks[value] ?? '',
    };
    scales.x.afterBuildTicks = (axis) => {
      axis.ticks = xTicks.map((_, value) => ({value}));
    };
    scales.x.grid = {display: false};
  }
  return new Chart(canvas, {
    type: bars ? 'bar' : 'scatter',
    data: bars ? {labels: bars, datasets} : {datasets},
    plugins: [intervals],
    options: {
      responsive: true, maintainAspectRatio: false,
      interaction: {mode: 'nearest', intersect: false},
      scales,
      plugins: {
        legend: {
          display: series.length > 1, position: 'bottom',
          labels: {color: colorOf('--text'), usePointStyle: !bars, boxHeight: 7},
        },
        tooltip: {
          callbacks: {
            title: (items) => (bars ? items[0].label : items[0].raw.title ?? items[0].dataset.label),
            label: (item) => (bars ? `${item.raw}` :
              `${xTicks ? '' : `${number(item.raw.x)}, `}${number(item.raw.y)}` +
              (item.raw.low !== undefined && item.raw.low !== null ?
                ` [${number(item.raw.low)}, ${number(item.raw.high)}]` : '')),
          },
        },
      },
    },
  });
}

// A card with a plot:
//
//   {title, note, x, y, logX, logY, series: [{name, points: [{x, y, title, low, high}], line, dash,
//    mark, hollow, color}], bars: labels of the bars, xTicks: names of x = 0, 1, ...}
//
// Null where there is nothing to be seen. Points that cannot be drawn on a logarithmic axis or are
// no numbers are left out.
export function plot(spec) {
  const drawable = (p) => Number.isFinite(p.x) && Number.isFinite(p.y) &&
    (!spec.logX || p.x > 0) && (!spec.logY || p.y > 0);
  const series = spec.bars ? spec.series :
    spec.series.filter((s) => s.points.some(drawable)).map((s) => ({
      ...s, points: s.gaps ? s.points.map((p) => (drawable(p) ? p : {x: p.x, y: NaN})) :
        s.points.filter(drawable)}));
  if (series.length === 0) return null;
  const canvas = element('canvas', {
    role: 'img', 'aria-label': `${spec.title}: ${spec.y} against ${spec.x}`,
  });
  const node = element('article', {class: spec.tall ? 'card plot tall' : 'card plot'}, element('h3', {}, spec.title),
    element('div', {class: 'canvas'}, canvas),
    spec.note ? element('p', {class: 'hint'}, spec.note) : null);
  all.push({canvas, spec: {...spec, series}, chart: null});
  return node;
}

// Once cards are on the page; plots are built when they come into view.
export function drawPlots() {
  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      observer.unobserve(entry.target);
      const found = all.find((p) => p.canvas === entry.target);
      if (found && !found.chart) found.chart = build(found.canvas, found.spec);
    }
  }, {rootMargin: '400px'});
  for (const {canvas} of all) observer.observe(canvas);
}

// Colours of the page have changed.
export function redrawPlots() {
  for (const item of all) {
    if (!item.chart) continue;
    item.chart.destroy();
    item.chart = build(item.canvas, item.spec);
  }
}

export function forgetPlots(container) {
  for (let i = all.length - 1; i >= 0; --i) {
    if (!container.contains(all[i].canvas)) continue;
    all[i].chart?.destroy();
    all.splice(i, 1);
  }
}

// For whoever prints or looks at all of them.
export function drawAllPlots() {
  for (const item of all) item.chart ??= build(item.canvas, item.spec);
}
