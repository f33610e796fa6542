// The report: sections made of what the tool has written into the page.

import {header} from './data.js';
import {element} from './dom.js';
import {drawAllPlots, drawPlots, forgetPlots, redrawPlots} from './charts.js';
import {
  accuracyBadges, accuracyNumbers, accuracyPlots, calibrationBadges, calibrationNumbers,
  calibrationPlots, fitBadges, fitNumbers, fitPlots, truthNumbers,
} from './documents.js';
import {decisions, effects, sceneBadges, sceneNumbers, scenePlots, stepTable} from './scene.js';
import {ShapeSection} from './shape.js';
import {badge, document_} from './tables.js';

const {documents, views} = header;
const main = document.getElementById('main');

document.getElementById('name').textContent = header.name;
document.getElementById('tool').textContent = header.tool;
document.getElementById('made').textContent =
  `Made by ${header.tool} ${header.version}. Numbers are in the scene’s own ` +
  'units. This page is one file; it loads nothing from anywhere.';
document.title = header.name ? `${header.name} – ${header.tool}` : header.tool;

function badges() {
  if (documents.calibration) return calibrationBadges(documents.calibration);
  if (documents.accuracy) return accuracyBadges(documents.accuracy);
  if (documents.fit) return fitBadges(documents.fit);
  if (documents.summary) return sceneBadges(documents.summary);
  if (documents.truth) return [badge('', `${documents.truth.points} points`)];
  return [];
}
document.getElementById('badges').append(...badges());

function section(id, title, className) {
  const body = element('div', {class: className});
  const node = element('section', {id, 'aria-labelledby': `${id}-title`},
                       element('h2', {id: `${id}-title`}, title), body);
  return {node, body};
}

const numbers = section('numbers', 'Numbers', 'cards');
const state = section('state', 'Equilibrium', 'cards');
const plots = section('plots', 'Plots', 'plots');
const physics = section('effects', 'Effects and decisions', 'cards');
const perView = section('steps', 'Load steps', 'cards');
const raw = section('all', 'All numbers', 'stack');

const fill = (body, nodes) => {
  forgetPlots(body);
  body.replaceChildren(...nodes.filter(Boolean));
};

// What belongs to one view; a calibration has one for each grasp.
function showView(index) {
  const view = views[index];
  const summary = view?.summary ?? documents.summary;
  const which = views.length > 1 ? ` of ${view.title}` : '';
  const own = [
    ...(documents.calibration ? calibrationNumbers(documents.calibration) : []),
    ...(documents.accuracy ? accuracyNumbers(documents.accuracy) : []),
    ...(documents.fit ? fitNumbers(documents.fit) : []),
    ...(documents.truth ? truthNumbers(documents.truth) : []),
  ];
  const solved = summary ? sceneNumbers(summary) : [];
  fill(numbers.body, own.length > 0 ? own : solved);
  // Beside what a tool is about, the equilibrium that it was about.
  fill(state.body, own.length > 0 ? solved : []);
  state.node.firstChild.textContent = documents.accuracy ? `The run that is shown: ${view?.title}` :
    documents.calibration ? `Equilibrium${which}` : 'Computed equilibrium';
  fill(plots.body, [
    ...(documents.calibration ? calibrationPlots(documents.calibration) : []),
    ...(documents.accuracy ? accuracyPlots(documents.accuracy) : []),
    ...(documents.fit ? fitPlots(documents.fit) : []),
    ...(view ? scenePlots(view, summary) : []),
  ]);
  fill(physics.body, summary ? [effects(summary), decisions(summary)] : []);
  fill(perView.body, view ? [stepTable(view.history)] : []);
  const contents = [...Object.entries(documents)];
  if (view?.summary) contents.push([`summary${which}`, view.summary]);
  fill(raw.body, contents.map(([name, content]) => document_(`${name}.json`, content)));
  for (const {node, body} of [numbers, state, plots, physics, perView, raw]) {
    node.hidden = body.childElementCount === 0;
  }
  refreshNav();
  drawPlots();
}

function refreshNav() {
  const list = [['shape', 'Shape', views.length > 0],
                ...[['plots', 'Plots', plots], ['numbers', 'Numbers', numbers], ['state', 'Equilibrium', state],
                    ['effects', 'Effects', physics], ['steps', 'Load steps', perView],
                    ['all', 'All numbers', raw]].map(([id, name, s]) => [id, name, !s.node.hidden])];
  document.getElementById('nav').replaceChildren(...list.filter(([, , on]) => on).map(
    ([id, name]) => element('a', {href: `#${id}`}, name)));
}

let shape = null;
if (views.length > 0) {
  shape = new ShapeSection(views, showView);
  main.append(shape.node);
}
main.append(plots.node, numbers.node, state.node, physics.node, perView.node, raw.node);
if (shape?.viewer) shape.show(0);
else showView(0);

matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redrawPlots);
addEventListener('beforeprint', drawAllPlots);

// For scripts that look at the page, such as tools/report/screenshot.mjs.
window.darboux = {
  header, shape, viewer: shape?.viewer ?? null, drawAllPlots,
  ready: null,
};
requestAnimationFrame(() => {
  shape?.viewer?.drawNow();
  window.darboux.ready = performance.now();
});
