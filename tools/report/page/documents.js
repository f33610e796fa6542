// What a study of accuracy, a fit, a calibration and a simulated scan have to tell.

import {element} from './dom.js';
import {number, percent, seconds, words} from './format.js';
import {plot} from './charts.js';
import {badge, card, pairs, table} from './tables.js';

// ---- Scans ------------------------------------------------------------------------------------

export function histogram(title, statistics) {
  const bins = statistics?.histogram;
  if (!bins || !bins.counts || bins.counts.length === 0) return null;
  return plot({
    title, x: 'distance from the face, length', y: 'points',
    bars: bins.counts.map((_, k) => number((k + 0.5) * bins.bin_width, 2)),
    series: [{name: 'points', points: bins.counts}],
  });
}

function distances(name, s) {
  const part = s?.percent_of_max_displacement ?? {};
  return s ? [name, s.count, s.mean, s.mean_absolute, s.rms, s.median_absolute, s.max,
              part?.mean_absolute ?? null, part?.rms ?? null] : null;
}

export function fitBadges(fit) {
  return [badge(fit.converged ? 'good' : 'bad', fit.converged ? 'fits' : 'does not fit'),
          badge('', `${number(fit.points)} points`), badge('', seconds(fit.time_s))];
}

export function fitNumbers(fit) {
  const registration = fit.registration ?? {};
  const pose = fit.pose ?? registration.pose;
  const rows = [distances('inliers', fit.inliers), distances('all points', fit.all)].filter(Boolean);
  return [
    card('Fit', pairs([
      ['verdict', fit.verdict],
      ['scan', fit.scan],
      ['mode', fit.mode],
      ['noise', fit.noise ?? registration.noise],
      ['misfit', fit.misfit],
      ['weight of the energy', fit.weight],
      ['energy', fit.energy],
      ['iterations', fit.iterations ?? registration.iterations],
      ['largest displacement', fit.max_displacement],
      ['outliers', fit.outliers],
      ['beyond the boundary', fit.beyond_boundary],
    ].filter(([, v]) => v !== undefined), 'Fit')),
    card('Registration', pairs([
      ['matched', registration.matched],
      ['verdict', registration.verdict],
      ['robust deviation', registration.sigma],
      ['inliers', percent(registration.inlier_fraction)],
      ['not determined', (registration.undetermined ?? []).join(', ') || 'nothing'],
      ['equivalent poses', registration.equivalent_poses],
      ['rotation w, x, y, z', pose?.rotation_wxyz],
      ['translation', pose?.translation],
    ], 'Registration')),
    rows.length > 0 ? card('Distances of the scan', table(
      ['', 'count', 'mean', 'mean absolute', 'rms', 'median absolute', 'largest',
       'mean absolute, % of displacement', 'rms, % of displacement'], rows, 'Distances')) : null,
  ];
}

export function fitPlots(fit) {
  return [
    histogram('Distances of the inliers', fit.inliers),
    histogram('Distances of all points', fit.all),
    plot({
      title: 'Choice of the weight', x: 'weight of the energy', y: 'misfit', logX: true, logY: true,
      note: 'The largest weight at which the misfit is the noise is taken (discrepancy principle).',
      series: [
        {name: 'tried', line: false, points: (fit.weights ?? []).map((t) => ({
          x: t.weight, y: t.misfit, title: `${t.iterations} iterations`}))},
        {name: 'noise', dash: true, mark: false, points: (fit.weights ?? []).length === 0 ? [] : [
          {x: Math.min(...fit.weights.map((t) => t.weight)), y: fit.noise},
          {x: Math.max(...fit.weights.map((t) => t.weight)), y: fit.noise}]},
      ],
    }),
  ];
}

export function truthNumbers(truth) {
  const options = truth.options ?? {};
  return [
    card('Scan', pairs([
      ['surface', truth.surface],
      ['points', truth.points],
      ['spikes', truth.spikes],
      ['strays', truth.strays],
      ['viewpoints', truth.viewpoints?.length],
      ['tried, for these points', truth.tried],
      ['extent', truth.extent],
      ['thickness', truth.thickness],
    ], 'Scan')),
    card('Scanner', pairs(['seed', 'unit', 'noise', 'bias', 'bias_length', 'bias_along', 'outliers',
      'grazing', 'sampling', 'motion', 'max_angle', 'max_translation'].map((k) => [words(k), options[k]]),
      'Scanner')),
    card('Frame of the scanner', pairs([
      ['rotation w, x, y, z', truth.scan_from_model?.quaternion_wxyz],
      ['translation', truth.scan_from_model?.translation],
    ], 'Frame of the scanner')),
  ];
}

// ---- Calibration --------------------------------------------------------------------------------

const shortName = (file) => String(file).split('/').pop();

export function calibrationBadges(calibration) {
  const done = calibration.termination === 'converged';
  const list = [badge(done ? 'good' : 'bad', words(calibration.termination))];
  for (const [name, p] of Object.entries(calibration.parameters ?? {})) {
    list.push(badge(p.identifiable ? 'good' : 'bad',
                    `${words(name)} ${p.value === null ? 'unknown' : number(p.value, 4)}`));
  }
  return list;
}

export function calibrationNumbers(calibration) {
  const parameters = Object.entries(calibration.parameters ?? {});
  const grasps = calibration.grasps ?? [];
  const interval = (i) => (i && i.length === 2 && i[0] !== null ? `[${number(i[0])}, ${number(i[1])}]` : '–');
  const forces = grasps.flatMap((g, k) => (g.forces ?? []).map((f) => [
    `${k + 1}: ${f.finger}`, f.reading, f.error, f.computed, f.computed - f.reading]));
  const scans = grasps.flatMap((g, k) => (g.scans ?? []).map((s) => [
    `${k + 1}: ${shortName(s.file)}`, s.points, percent(s.inliers), s.deviation,
    ...['mean_abs', 'rms', 'max'].map((n) => s.distances?.[n])]));
  const fields = grasps.flatMap((g, k) => (g.fields ?? []).map((f) => [
    `${k + 1}: ${shortName(f.file)}`, f.points, percent(f.inliers), f.rms, f.deviation, f.deformation,
    f.independent_points]));
  const matrix = calibration.correlation?.matrix ?? [];
  const sensitivities = Object.entries(calibration.sensitivities ?? {}).flatMap(([of, list]) =>
    Object.entries(list).map(([to, value]) => [`${words(of)}, ${words(to)}`, value]));
  return [
    card('Parameters', table(['parameter', 'value', '95 % interval', 'bootstrap', 'identified', 'verdict'],
      parameters.map(([name, p]) => [words(name), p.value, interval(p.interval_95),
        interval(p.bootstrap_95), badge(p.identifiable ? 'good' : 'bad', p.identifiable ? 'yes' : 'no'),
        p.verdict]), 'Parameters')),
    matrix.length > 1 ? card('Correlation', table(['', ...calibration.correlation.of.map(words)],
      matrix.map((row, i) => [words(calibration.correlation.of[i]), ...row]), 'Correlation')) : null,
    forces.length > 0 ? card('Forces', table(['grasp: finger', 'reading', 'its error', 'computed',
      'difference'], forces, 'Forces')) : null,
    scans.length > 0 ? card('Scans', table(['grasp: scan', 'points', 'inliers', 'deviation',
      'mean absolute distance', 'rms', 'largest'], scans, 'Scans')) : null,
    fields.length > 0 ? card('Fields of displacements', table(['grasp: field', 'points', 'inliers', 'rms',
      'deviation', 'deformation', 'as good as independent points'], fields, 'Fields')) : null,
    card('Grasps', table(['grasp', 'scene', 'theory', 'largest displacement', 'change of travel',
      'its deviation'], grasps.map((g, k) => [k + 1, shortName(g.scene), g.theory, g.max_displacement,
      g.travel_change, g.travel_deviation]), 'Grasps')),
    sensitivities.length > 0 ? card('Sensitivities', pairs(sensitivities, 'Sensitivities')) : null,
    card('Errors that are shared', pairs(
      Object.entries(calibration.errors ?? {}).map(([k, v]) => [words(k), v]), 'Errors')),
    (calibration.notes ?? []).length > 0 ? card('Notes', element('ul', {},
      ...calibration.notes.map((text) => element('li', {}, text)))) : null,
  ];
}

export function calibrationPlots(calibration) {
  const plots = [];
  const parameters = Object.entries(calibration.parameters ?? {});
  for (const [name, p] of parameters) {
    const bars = [['95 %', p.interval_95], ['bootstrap', p.bootstrap_95]]
      .filter(([, i]) => i && i[0] !== null);
    if (p.value === null || bars.length === 0) continue;
    const linear = name === 'young_modulus' ? calibration.linear_theory?.young_modulus : null;
    const ticks = bars.map(([label]) => label);
    const series = [{
      name: words(name), line: false, points: bars.map(([label, [low, high]], k) => ({
        x: k, y: p.value, low, high, title: `${words(name)}, ${label}`})),
    }];
    if (typeof linear === 'number') {
      ticks.push('linear theory');
      series.push({name: 'in the linear theory', line: false, points: [{x: ticks.length - 1, y: linear}]});
    }
    plots.push(plot({
      title: `${words(name)} and its intervals`, x: '', y: words(name), xTicks: ticks, series,
    }));
  }
  const forces = (calibration.grasps ?? []).flatMap((g, k) =>
    (g.forces ?? []).map((f) => ({...f, label: `${k + 1}: ${f.finger}`})));
  plots.push(plot({
    title: 'Forces, read and computed', x: 'grasp: finger', y: 'force', xTicks: forces.map((f) => f.label),
    series: [
      {name: 'read, ± 2 errors', line: false, points: forces.map((f, k) => ({
        x: k - 0.08, y: f.reading, low: f.reading - 2 * f.error, high: f.reading + 2 * f.error,
        title: `${f.label}, read`}))},
      {name: 'computed', line: false, points: forces.map((f, k) => ({
        x: k + 0.08, y: f.computed, title: `${f.label}, computed`}))},
    ],
  }));
  const scans = (calibration.grasps ?? []).flatMap((g, k) =>
    (g.scans ?? []).map((s, i) => ({
      ...s, label: g.scans.length > 1 ? `${k + 1}.${i + 1}` : `${k + 1}`, file: shortName(s.file)})));
  plots.push(plot({
    title: 'Distances of the scans', x: 'grasp', y: 'distance, length',
    xTicks: scans.map((s) => s.label),
    series: [['mean absolute', 'mean_abs'], ['rms', 'rms'], ['given deviation', null]].map(([name, key]) => ({
      name, line: false, points: scans.map((s, k) => ({
        x: k, y: key ? s.distances?.[key] : s.deviation, title: `${s.file}, ${name}`}))})),
  }));
  return plots;
}

// ---- Studies of accuracy ------------------------------------------------------------------------

export function accuracyBadges(study) {
  return [badge(study.established ? 'good' : 'bad', study.established ? 'reference known' : 'no reference'),
          badge('', `${study.runs.filter((r) => r.status === 'converged').length} runs`),
          badge('', study.reference.kind)];
}

const clockOf = (study) => (study.clock === 'cpu' ? 'cpu' : 'total');

export function accuracyNumbers(study) {
  const clock = clockOf(study);
  const front = new Set(study.pareto_front?.seconds ?? []);
  return [
    card('Cheapest settings', table(['error at most', 'settings'],
      study.cheapest.map((c) => [percent(c.target), c.text]), 'Cheapest settings')),
    card('Reference', element('p', {}, study.reference.method), table(
      ['quantity', 'value', 'known to', 'source'],
      study.reference.quantities.map((q) => [q.quantity, q.value, percent(q.uncertainty), q.source]),
      'Reference')),
    study.notes.length > 0 ? card('Notes', element('ul', {},
      ...study.notes.map((text) => element('li', {}, text)))) : null,
    card('Runs', element('p', {class: 'hint'}, clock === 'cpu' ?
      'Seconds of all processors count.' : 'Seconds of the clock count, set-up and solution.'),
      element('div', {class: 'tall'}, table(
      ['settings', 'dof', 'elements', 'points', 'iterations', 'error', 'set-up, s', 'solution, s',
       'all, s', 'cpu, s', 'MB', 'note'],
      study.runs.map((r, i) => [r.label, r.dof, r.elements, r.quadrature_points, r.iterations,
        r.below_uncertainty ? `< ${percent(study.reference.uncertainty)}` :
          r.error === null ? r.status : percent(r.error),
        r.time_s.setup, r.time_s.solve, r.time_s.total, r.time_s.cpu, r.memory_mb,
        [front.has(i) ? 'Pareto front' : '', r.other_model ? 'other model' : '', r.reason].filter(Boolean)
          .join(', ')]), 'Runs'))),
  ];
}

export function accuracyPlots(study) {
  const clock = clockOf(study);
  const secondsOf = (r) => r.time_s?.[clock];
  const families = study.families.map((name, family) => ({
    name: name || 'own settings',
    runs: study.runs.filter((r) => r.family === family && r.error !== null)
      .sort((a, b) => a.refinement - b.refinement),
  })).filter((f) => f.runs.length > 0);
  const error = (r) => 100 * Math.max(r.error, r.below_uncertainty ? study.reference.uncertainty : 0);
  const series = (x) => families.map(({name, runs}) => ({
    name, points: runs.map((r) => ({x: x(r), y: error(r), title: r.label})),
  }));
  const frontOf = (indices, x) => ({
    name: 'Pareto front', dash: true, mark: false, color: '--muted',
    points: (indices ?? []).map((i) => ({x: x(study.runs[i]), y: error(study.runs[i])}))
      .sort((a, b) => a.x - b.x),
  });
  const dof = (r) => r.dof;
  return [
    plot({title: 'Error against unknowns', x: 'degrees of freedom', y: 'relative error, %', logX: true,
          logY: true, tall: true, series: [...series(dof), frontOf(study.pareto_front?.dof, dof)]}),
    plot({title: 'Error against time', x: clock === 'cpu' ? 'seconds of all processors' : 'seconds',
          y: 'relative error, %', logX: true, logY: true,
          tall: true, series: [...series(secondsOf), frontOf(study.pareto_front?.seconds, secondsOf)]}),
    plot({title: 'Time against unknowns', x: 'degrees of freedom', y: 'seconds', logX: true, logY: true, tall: true,
          series: families.map(({name, runs}) => ({
            name, points: runs.map((r) => ({x: r.dof, y: secondsOf(r), title: r.label}))}))}),
    plot({title: 'Memory', x: 'degrees of freedom', y: 'megabytes', logX: true, tall: true,
          series: families.map(({name, runs}) => ({
            name, points: runs.map((r) => ({x: r.dof, y: r.memory_mb ?? NaN, title: r.label}))}))}),
  ];
}
