// What a solved scene has to tell: summary.json, and the history of its load steps.

import {element} from './dom.js';
import {number, percent, seconds, words} from './format.js';
import {plot} from './charts.js';
import {badge, card, pairs, table, wideCard, xyz} from './tables.js';

export function sceneBadges(summary) {
  const list = [badge(summary.converged ? 'good' : 'bad',
                      summary.converged ? 'converged' : 'not converged')];
  const expect = summary.expect ?? [];
  if (expect.length > 0) {
    const failed = expect.filter((e) => !e.holds).length;
    list.push(badge(failed === 0 ? 'good' : 'bad', failed === 0 ?
      expect.length === 1 ? '1 expectation holds' : `${expect.length} expectations hold` :
      `${failed} of ${expect.length} expectations fail`));
  }
  const modes = summary.stability?.negative_modes;
  if (modes !== null && modes !== undefined && modes > 0) list.push(badge('bad', 'unstable'));
  list.push(badge('', `${summary.theory} theory`), badge('', `${number(summary.dof)} dof`),
            badge('', seconds(summary.time_s?.total)));
  return list;
}

function expectations(summary) {
  const list = summary.expect ?? [];
  if (list.length === 0) return null;
  return card('Expectations of the scene', table(
    ['quantity', 'value', 'expected', 'error', 'tolerance', 'holds'],
    list.map((e) => [e.quantity, e.value ?? e.message, e.expected, e.error,
                     `${number(e.tolerance)} ${e.relative ? 'relative' : 'absolute'}`,
                     badge(e.holds ? 'good' : 'bad', e.holds ? 'holds' : 'fails')]),
    'Expectations'));
}

export function sceneNumbers(summary) {
  const energies = Object.entries(summary.energy ?? {}).map(([k, v]) => [words(k), v]);
  const probes = Object.entries(summary.probes ?? {});
  const fingers = Object.entries(summary.fingers ?? {});
  const gas = summary.gas ?? {};
  const gasIsOn = summary.effects?.gas?.on;
  const grasp = summary.grasp ?? {};
  const graspRows = Object.entries(grasp)
    .filter(([k, v]) => v !== null && !k.startsWith('force_closure')).map(([k, v]) => [
      words(k), v && typeof v === 'object' && !Array.isArray(v) && 'x' in v ? xyz(v) :
        Array.isArray(v) && Array.isArray(v[0]) ? v.map((r) => r.map((x) => number(x)).join(', ')).join(' | ') :
        v !== null && typeof v === 'object' && !Array.isArray(v) ? JSON.stringify(v) : v]);
  const closures = Object.entries(grasp).filter(([k, v]) => k.startsWith('force_closure') && v)
    .map(([k, c]) => [words(k).replace('force closure ', ''), badge(c.closed ? 'good' : '', c.closed ? 'yes' : 'no'),
      c.margin, c.least_friction, c.lacks ?? '']);
  const accuracy = summary.accuracy;
  const levels = accuracy?.levels ?? [];
  return [
    card('Result', pairs([
      ['largest displacement', summary.max_displacement],
      ['largest membrane strain', summary.max_membrane_strain],
      ['largest rotation of the normal, rad', summary.max_rotation],
      ['energy', summary.energy?.total],
      ['theory', `${summary.theory}: ${summary.theory_reason}`],
      ['strains', summary.strains],
      ['unknowns', summary.unknowns],
      ['elements', summary.elements],
      ['quadrature points', summary.quadrature_points],
      ['message', summary.message],
    ], 'Result')),
    card('Equilibrium', pairs([
      ['gradient over forces', summary.equilibrium?.gradient_norm],
      ['force balance, relative', summary.equilibrium?.force_balance],
      ['reaction of the supports', xyz(summary.supports?.reaction)],
      ['iterations', summary.iterations],
      ['load steps', summary.load_steps?.length],
      ['negative modes', summary.stability?.negative_modes],
      ['softness', summary.stability?.softness],
      ['free motions', (summary.free_motions ?? []).join(', ') || 'none'],
      ['backend', summary.backend],
      ['set-up', seconds(summary.time_s?.setup)],
      ['solution', seconds(summary.time_s?.solve)],
    ], 'Equilibrium')),
    energies.length > 0 ? card('Energies', pairs(energies, 'Energies')) : null,
    gasIsOn ? card('Gas', pairs(Object.entries(gas).map(([k, v]) => [words(k), v]), 'Gas')) : null,
    probes.length > 0 ? card('Probes', table(
      ['probe', 'position', 'displacement', 'size'],
      probes.map(([name, p]) => {
        const u = xyz(p.displacement);
        const size = u && u.every((x) => x !== null) ? Math.hypot(...u) : null;
        return [name, p.position, u, size];
      }), 'Probes')) : null,
    fingers.length > 0 ? card('Fingers', table(
      ['finger', 'normal force', 'force', 'travel', 'indentation', 'contact area',
       'largest pressure', 'penetration', 'stiffness', 'points', 'stick / slip', 'driven by'],
      fingers.map(([name, f]) => [name, f.normal_force, xyz(f.force), f.travel, f.indentation,
        f.contact_area, f.largest_pressure, f.penetration, f.stiffness, f.contact_points,
        `${f.sticking} / ${f.slipping}`, f.driven_by]), 'Fingers')) : null,
    graspRows.length > 0 ? card('Grasp', pairs(graspRows, 'Grasp')) : null,
    closures.length > 0 ? card('Force closure', table(
      ['grasp', 'closed', 'margin', 'least friction', 'lacks'], closures, 'Force closure')) : null,
    expectations(summary),
    accuracy ? card('Accuracy', element('p', {},
      badge(accuracy.reached ? 'good' : 'bad', accuracy.reached ? 'reached' : 'not reached'), ' ',
      `asked for ${percent(accuracy.target)}, estimated ${percent(accuracy.estimate)}. `,
      accuracy.message ?? ''), table(
      ['level', 'cells', 'dof', 'theory', 'solutions', 'estimated error', 'seconds'],
      levels.map((l, i) => [String(i + 1), l.divisions?.[0] > 0 ? `${l.divisions[0]} × ${l.divisions[1]}` : '–',
        l.dof, l.theory, l.solutions, l.estimate, l.seconds]), 'Levels')) : null,
  ];
}

export function effects(summary) {
  const list = Object.entries(summary.effects ?? {});
  if (list.length === 0) return null;
  const energy = summary.energy ?? {};
  return card('Physical effects', table(
    ['effect', 'state', 'why', 'blocks', 'residuals', 'energy'],
    list.map(([name, e]) => [words(name), badge(e.on ? 'on' : 'off', e.on ? 'on' : 'off'), e.why,
      e.residual_blocks, e.residuals, e.on && typeof energy[name] === 'number' ? energy[name] : null]),
    'Physical effects'));
}

export function decisions(summary) {
  const list = summary.decisions ?? [];
  if (list.length === 0) return null;
  return wideCard('What the solver decided, and why',
              element('ul', {}, ...list.map((text) => element('li', {}, text))));
}

export function stepTable(history) {
  if (!history || history.length < 2) return null;
  const fingers = Object.keys(history[0].fingers ?? {});
  const probes = Object.keys(history[0].probes ?? {});
  const hasGas = history.some((h) => h.gas);
  return card('Load steps', element('div', {class: 'tall'}, table(
    ['step', 'load factor', 'iterations', 'energy', 'gradient', 'largest displacement',
     ...fingers.flatMap((f) => [`${f}: travel`, `${f}: force`]),
     ...probes.map((p) => `${p}: displacement`), ...(hasGas ? ['gauge pressure'] : []), 'note'],
    history.map((h) => [h.step, h.factor, h.iterations, h.energy, h.relative_gradient,
      h.max_displacement,
      ...fingers.flatMap((f) => [h.fingers[f]?.travel, h.fingers[f]?.normal_force]),
      ...probes.map((p) => h.probes[p]), ...(hasGas ? [h.gas?.gauge_pressure] : []),
      [h.converged ? '' : 'not converged', h.limit_point ? 'limit point' : ''].filter(Boolean)
        .join(', ')]), 'Load steps')));
}

// The component of a probe that moves most in the end.
function mainComponent(history, probe) {
  const last = history[history.length - 1].probes[probe] ?? [];
  let best = 0;
  last.forEach((x, k) => {
    if (Math.abs(x ?? 0) > Math.abs(last[best] ?? 0)) best = k;
  });
  return best;
}

export function scenePlots(view, summary) {
  const history = view.history ?? [];
  const plots = [];
  if (history.length > 0) {
    const zero = {x: 0, y: 0};
    const fingers = Object.keys(history[0].fingers ?? {});
    plots.push(plot({
      title: 'Force against travel',
      x: 'travel from first touch, length', y: 'normal force',
      note: history.length === 1 ? 'One load step only: `steps: N` in the scene gives the curve.' : null,
      series: fingers.map((f) => ({
        name: f, points: [{...zero, title: `${f}, at rest`}, ...history.map((h) => ({
          x: h.fingers[f].travel, y: h.fingers[f].normal_force, title: `${f}, step ${h.step}`,
        }))],
      })),
    }));
    plots.push(plot({
      title: 'Contact area against travel', x: 'travel from first touch, length', y: 'area',
      series: history.length < 2 ? [] : fingers.map((f) => ({
        name: f, points: [zero, ...history.map((h) => ({
          x: h.fingers[f].travel, y: h.fingers[f].contact_area, title: `${f}, step ${h.step}`}))],
      })),
    }));
    const probes = Object.keys(history[0].probes ?? {});
    if (history.length > 1) {
      plots.push(plot({
        title: 'Load against displacement', x: 'displacement of the probe, length', y: 'load factor',
        series: probes.map((p) => {
          const k = mainComponent(history, p);
          return {
            name: `${p}, ${'xyz'[k]}`, points: [zero, ...history.map((h) => ({
              x: h.probes[p]?.[k], y: h.factor,
              title: `step ${h.step}${h.limit_point ? ', limit point' : ''}`}))],
          };
        }),
      }));
      const names = Object.keys(history[0].energies ?? {})
        .filter((e) => history.some((h) => Math.abs(h.energies[e] ?? 0) > 0));
      plots.push(plot({
        title: 'Energies', x: 'load step', y: 'energy', wholeX: true,
        series: names.map((e) => ({
          name: words(e), points: history.map((h) => ({x: h.step, y: h.energies[e]})),
        })),
      }));
      plots.push(plot({
        title: 'Gas', x: 'load step', y: 'gauge pressure', wholeX: true,
        series: [{name: 'gauge pressure', points: history.filter((h) => h.gas).map((h) => ({
          x: h.step, y: h.gas.gauge_pressure, title: `volume ratio ${number(h.gas.volume_ratio)}`}))}],
      }));
      plots.push(plot({
        title: 'Iterations', x: 'load step', y: 'iterations', wholeX: true, wholeY: true,
        series: [{name: 'iterations', points: history.map((h) => ({x: h.step, y: h.iterations}))}],
      }));
    }
  }
  const columns = view.iterations ?? {step: []};
  if (columns.step.length > 2) {
    const numbered = columns.step.map((step, k) => ({
      step, count: k + 1, iteration: columns.iteration[k], factor: columns.factor[k],
      method: columns.method[k], energy: columns.energy[k],
      relative_gradient: columns.relative_gradient[k], seconds: columns.seconds[k],
    }));
    // A line for each way to a load factor, in the colours of the load steps as long as these can
    // be told apart.
    const steps = [...new Set(columns.step)];
    const runs = [];
    for (const it of numbered) {
      const last = runs[runs.length - 1];
      if (last && last[0].step === it.step && it.iteration > last[last.length - 1].iteration) last.push(it);
      else runs.push([it]);
    }
    const gap = {x: NaN, y: NaN};
    const lines = steps.length <= 8 ? steps.map((s) => ({
      name: `step ${s}`, of: runs.filter((r) => r[0].step === s)})) : [{name: 'all steps', of: runs}];
    const series = (key) => lines.map(({name, of}) => ({
      name, gaps: true, points: of.flatMap((run) => [...run.map((it) => ({
        x: it.count, y: it[key], title: `step ${it.step}, to load ${number(it.factor)}, ${it.method} ` +
          `iteration ${it.iteration}, ${seconds(it.seconds)}`})), gap]),
    }));
    plots.push(plot({
      title: 'Convergence', x: 'iteration', y: 'gradient over forces', logY: true, wholeX: true,
      series: series('relative_gradient'),
      note: 'A line begins where the solver sets out for the next load factor.',
    }));
    plots.push(plot({title: 'Energy by iteration', x: 'iteration', y: 'energy', wholeX: true, series: series('energy')}));
  }
  const levels = summary?.accuracy?.levels ?? [];
  if (levels.length > 0) {
    plots.push(plot({
      title: 'Accuracy', x: 'degrees of freedom', y: 'estimated relative error', logX: true, logY: true,
      series: [{name: 'estimate', points: levels.map((l, i) => ({
        x: l.dof, y: l.estimate, title: `level ${i + 1}, ${seconds(l.seconds)}`}))},
      {name: 'asked for', dash: true, mark: false, points: [
        {x: levels[0].dof, y: summary.accuracy.target},
        {x: levels[levels.length - 1].dof, y: summary.accuracy.target}]}],
    }));
  }
  return plots;
}
