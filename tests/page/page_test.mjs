// The page of torquectl report and view, in a browser: what it draws is what was computed, it can be used, and by
// everybody. Runs on a bus of its own.
//
// TORQUECTL, TORQUED, CHROMIUM: the programs. TRAJECTORIES: the folder of the measured walk. PICTURES: where screenshots
// go.

import assert from 'node:assert/strict';
import {execFileSync, spawn} from 'node:child_process';
import {once} from 'node:events';
import {mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {get} from 'node:http';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {chromium} from 'playwright-core';

const {TORQUECTL, TORQUED, CHROMIUM, TRAJECTORIES, PICTURES} = process.env;
const walk = join(TRAJECTORIES, 'subject01-walk/walk.csv');
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const folder = mkdtempSync(join(tmpdir(), 'torqued-page-'));
const file = name => join(folder, name);
const torquectl = (...words) => execFileSync(TORQUECTL, words, {stdio: ['ignore', 'ignore', 'pipe']});
const methods = ['human-transition', 'constrained'];

// a walk whose links accelerate otherwise in its second half
const disturbed = path => {
  const [header, ...rows] = readFileSync(path, 'utf8').split('\n');
  const names = header.split(',');
  const wave = (time, k) => time > 1.4 ? 20 * Math.sin(30 * time + k) : 0;
  return [header, ...rows.map(row => {
    const cells = row.split(',');
    if (cells.length < names.length) return row;
    return cells.map((cell, k) => names[k].startsWith('ddq') ? Number(cell) + wave(Number(cells[0]) / 1e6, k) : cell).join(',');
  })].join('\n');
};

let browser;
before(async () => {
  mkdirSync(PICTURES, {recursive: true});
  // the page of tools/demo: a log as it was answered by the first method, beside the other one and the plates
  torquectl('eval', walk, '--robot', 'human-subject01', '--method', methods[0], '-o', file('walk.lcm'));
  torquectl('report', file('walk.lcm'), '--measured', walk, '--method', methods[1], '-o', file('walk.html'));
  for (const name of methods)
    torquectl('eval', walk, '--robot', 'human-subject01', '--method', name, '-o', file(name + '.csv'));
  torquectl('gait', '--robot', 'rk', '-o', file('rk.csv'));
  torquectl('report', file('rk.csv'), '--robot', 'rk', '-o', file('rk.html'));
  torquectl('eval', file('rk.csv'), '--robot', 'rk', '-o', file('rk-answers.csv'));
  // asked for more than feet and motors can do, in the second half
  writeFileSync(file('wild.csv'), disturbed(file('rk.csv')));
  writeFileSync(file('nearest.toml'), 'infeasible = "nearest"\nevery_sample = true\n');
  torquectl('report', file('wild.csv'), '--config', file('nearest.toml'), '-o', file('wild.html'));
  torquectl('eval', file('wild.csv'), '--config', file('nearest.toml'), '-o', file('wild-answers.csv'));
  torquectl('report', join(TRAJECTORIES, 'compass/case-a.csv'), '--robot', 'compass', '-o', file('compass.html'));
  // as root Chromium has no sandbox; what it loads here is our own
  browser = await chromium.launch({executablePath: CHROMIUM, args: ['--no-sandbox']});
});
after(async () => {
  await browser?.close();
  rmSync(folder, {recursive: true, force: true});
});

// columns of a CSV by name
const read = path => {
  const lines = readFileSync(path, 'utf8').split('\n').filter(line => line && !line.startsWith('#')).map(line => line.split(','));
  return Object.fromEntries(lines[0].map((name, k) => [name, lines.slice(1).map(line => line[k] === '' ? NaN : Number(line[k]))]));
};

const complaints = [];
const open = async (name, {width = 1400, theme = 'light', url = 'file://' + file(name)} = {}) => {
  const page = await browser.newPage({viewport: {width, height: 900}, colorScheme: theme});
  page.on('console', message => complaints.push(`${name}: ${message.type()}: ${message.text()}`));
  page.on('pageerror', error => complaints.push(`${name}: ${error.stack}`));
  page.on('request', request => { if (!request.url().startsWith(url) && !request.url().startsWith('data:')) complaints.push(`${name} asked for ${request.url()}`); });
  await page.goto(url);
  await page.waitForSelector('.plot canvas');
  return page;
};
const goTo = (page, sample) => page.evaluate(value => {
  const slider = document.getElementById('time');
  slider.value = value;
  slider.dispatchEvent(new Event('input'));
}, sample);
const clock = async page => Number((await page.textContent('#clock')).split(' ')[0]);
// what the page says under the cursor: a panel's values by their curves
const values = (page, title) => page.evaluate(wanted => {
  const figure = [...document.querySelectorAll('figure')].find(f => f.querySelector('.title').textContent === wanted);
  return Object.fromEntries([...figure.querySelectorAll('.values span')].map(span => [span.dataset.of, Number(span.dataset.value)]));
}, title);
const picture = page => page.evaluate(() => document.getElementById('stage').toDataURL());

test('numbers at the cursor are those of eval and of the force plates', async () => {
  const page = await open('walk.html');
  const measured = read(walk);
  const answers = methods.map(name => read(file(name + '.csv')));
  for (const sample of [0, 60, 97, 110, 233, 446]) {
    await goTo(page, sample);
    for (const [title, column, plate] of [
      ['left hip, N m', 'tau_left_hip'], ['right knee, N m', 'tau_right_knee'], ['left ankle, N m', 'tau_left_ankle'],
      ['left foot: upward force, N', 'fzL', 'FzL'], ['right foot: forward force, N', 'fxR', 'FxR'],
      ['acceleration of resting contacts, m/s² or rad/s²', 'contact_residual'],
    ]) {
      const found = await values(page, title);
      const near = (value, expected) => assert.ok(Math.abs(value - expected) <= 1e-6 * Math.abs(expected), `sample ${sample}, ${title}: ${value}, expected ${expected}`);
      answers.forEach((answer, k) => near(found['run ' + k], answer[column][sample]));
      if (plate) near(found.plates, measured[plate][sample]);
    }
  }
  await page.close();
});

test('accelerations are shown as they were answered and as they were asked for, where they differ', async () => {
  const page = await open('wild.html');
  const asked = read(file('wild.csv')), answers = read(file('wild-answers.csv'));
  const near = (value, expected) => assert.ok(Math.abs(value - expected) <= 1e-5 * Math.max(1, Math.abs(expected)), `${value}, expected ${expected}`);
  let apart = 0;
  for (const sample of [20, 333, 400, 471, 540]) {
    await goTo(page, sample);
    for (const [title, name] of [['left shin (q1), rad/s²', 'q1'], ['right foot (q5), rad/s²', 'q5'], ['trunk (q6), rad/s²', 'q6']]) {
      const found = await values(page, title);
      near(found.asked, asked['dd' + name][sample]);
      near(found['run 0'], answers['a_' + name][sample]);
      apart += Math.abs(found.asked - found['run 0']) > 1 ? 1 : 0;
    }
  }
  assert.ok(apart >= 5, `they are apart in ${apart} places`);
  const adjusted = answers.flags.filter(flags => flags & 1024).length;
  assert.ok(adjusted > 100);
  assert.equal(await page.textContent('#figures tr:has(th:text-is("adjusted")) td'), String(adjusted));
  await page.close();

  const usual = await open('rk.html');
  assert.equal(await usual.getByRole('heading', {name: /^Accelerations/}).count(), 0);
  await usual.close();
});

test('curves pass through the samples', async () => {
  const page = await open('walk.html');
  const {fzL} = read(file('human-transition.csv'));
  // the tallest pixels of the curve in the panel's canvas lie where the largest force is
  const highest = fzL.indexOf(Math.max(...fzL));
  await goTo(page, highest);
  const off = await page.evaluate(() => {
    const figure = [...document.querySelectorAll('figure')].find(f => f.querySelector('.title').textContent === 'left foot: upward force, N');
    const canvas = figure.querySelector('canvas'), ratio = window.devicePixelRatio;
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const cursor = new DOMMatrix(getComputedStyle(figure.querySelector('.cursor')).transform).m41 * ratio;
    const ink = document.createElement('canvas').getContext('2d');
    ink.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--run-0');
    ink.fillRect(0, 0, 1, 1);
    const [r, g, b] = ink.getImageData(0, 0, 1, 1).data;
    for (let y = 0; y < canvas.height; ++y)
      for (let x = 0; x < canvas.width; ++x) {
        const at = 4 * (y * canvas.width + x);
        if (Math.hypot(pixels.data[at] - r, pixels.data[at + 1] - g, pixels.data[at + 2] - b) < 40 && pixels.data[at + 3] > 200)
          return Math.abs(x - cursor);
      }
    return Infinity;
  });
  assert.ok(off <= 4, `the curve's top is ${off} px from the cursor at the largest force`);
  await page.close();
});

test('it plays, pauses, steps, and moves by keys, by dragging and by the slider', async () => {
  const page = await open('walk.html');
  const start = await picture(page);
  await page.click('#play');
  await page.waitForFunction(() => Number(document.getElementById('clock').textContent.split(' ')[0]) > 0.2);
  await page.click('#play');
  assert.equal(await page.textContent('#play'), 'Play');
  const paused = await clock(page);
  assert.ok(paused > 0.2);
  assert.notEqual(await picture(page), start);
  await page.waitForTimeout(100);
  assert.equal(await clock(page), paused);

  await goTo(page, 100);
  assert.equal(await clock(page), 0.5);
  await page.click('#forth');
  assert.equal(await clock(page), 0.505);
  await page.click('#back');
  await page.click('#back');
  assert.equal(await clock(page), 0.495);
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press('ArrowRight');
  assert.equal(await clock(page), 0.5);
  await page.focus('#time');
  await page.keyboard.press('ArrowRight');
  assert.equal(await clock(page), 0.505);
  assert.equal(await page.getAttribute('#time', 'aria-valuetext'), '0.505 s');

  const first = page.locator('.plot').first();
  await first.scrollIntoViewIfNeeded();
  const plot = await first.boundingBox();
  await page.mouse.move(plot.x + 0.3 * plot.width, plot.y + 40);
  await page.mouse.down();
  const before = await clock(page);
  await page.mouse.move(plot.x + 0.6 * plot.width, plot.y + 40);
  await page.mouse.up();
  assert.ok(await clock(page) > before + 0.5);
  const cursors = await page.$$eval('.cursor', all => new Set(all.map(cursor => Math.round(new DOMMatrix(getComputedStyle(cursor).transform).m41))).size);
  assert.ok(cursors <= 2, 'all panels show the cursor at the same place');
  await page.close();
});

test('at the end it begins again', async () => {
  const page = await open('walk.html');
  await page.selectOption('#speed', '4');
  await goTo(page, 430);
  await page.click('#play');
  await page.waitForFunction(() => Number(document.getElementById('clock').textContent.split(' ')[0]) < 1);
  await page.close();
});

test('it looks closer where the cursor is, and shows all again', async () => {
  const page = await open('walk.html');
  await goTo(page, 200);
  await page.click('#closer');
  await page.click('#closer');
  const [from, to] = (await page.textContent('#window')).match(/[\d.]+/g).map(Number);
  assert.ok(Math.abs(to - from - 2.23 / 4) < 2e-3);
  assert.ok(from < 1 && 1 < to);
  await goTo(page, 400); // out of view: the view follows
  const [later] = (await page.textContent('#window')).match(/[\d.]+/g).map(Number);
  assert.ok(later > to - 0.6);
  await page.click('#all');
  assert.equal(await page.textContent('#window'), '');
  await page.close();
});

test('the robot shows the answers that are chosen, and curves can be hidden', async () => {
  const page = await open('walk.html');
  await goTo(page, 97);
  const first = await picture(page);
  await page.selectOption('#shown', '1');
  assert.notEqual(await picture(page), first);
  assert.match(await page.textContent('#key'), /ground reaction, constrained/);
  await page.getByLabel('as recorded, human-transition').last().uncheck();
  assert.deepEqual(Object.keys(await values(page, 'left hip, N m')), ['plates', 'published', 'run 1']);
  for (const layer of ['ground reactions', 'measured ones', 'friction cones', 'torques', 'other instants']) {
    const with_it = await picture(page);
    await page.getByLabel(layer, {exact: true}).uncheck();
    assert.notEqual(await picture(page), with_it, layer);
  }
  await page.close();
});

for (const [name, title] of [['walk.html', 'measured walk'], ['rk.html', 'rolling knees'], ['wild.html', 'what cannot be had'], ['compass.html', 'compass']])
  for (const [width, theme] of [[400, 'light'], [1600, 'dark'], [1600, 'light']])
    test(`${title}: at ${width} px, ${theme}, nothing is cut off and axe finds nothing`, async () => {
      const page = await open(name, {width, theme});
      await goTo(page, 60);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `the page is ${wide} px wide`);
      await page.screenshot({path: join(PICTURES, `${name.replace('.html', '')}-${width}-${theme}.png`), fullPage: true});
      await page.evaluate(axe);
      const {violations} = await page.evaluate(() => axe.run());
      assert.deepEqual(violations.map(({id, nodes}) => [id, ...nodes.slice(0, 3).map(node => node.html + ' ' + node.failureSummary)]), []);
      await page.close();
    });

test('view shows the last seconds of what is sent, live, until it is frozen', async () => {
  const started = [];
  const start = (program, words) => {
    const child = spawn(program, words, {stdio: ['ignore', 'pipe', 'ignore']});
    started.push(child);
    return child;
  };
  const stop = async child => {
    if (child.exitCode !== null) return child.exitCode;
    child.kill('SIGINT');
    return (await once(child, 'exit'))[0];
  };
  try {
    start(TORQUED, ['--robot', 'rk']);
    const view = start(TORQUECTL, ['view', '--port', '0', '--seconds', '3']);
    const [line] = await once(view.stdout, 'data');
    const url = String(line).match(/http:[^ ]+/)[0];
    const waiting = await browser.newPage();
    await waiting.goto(url);
    assert.match(await waiting.textContent('#summary'), /nothing heard yet/);
    await waiting.close();

    start(TORQUECTL, ['send', '--loop', file('rk.csv')]);
    const page = await open('view', {url});
    await page.waitForFunction(() => Number(document.getElementById('clock').textContent.split(' ')[0]) > 4, null, {timeout: 20_000});
    assert.match(await page.textContent('#summary'), /samples in [23]\.\d+ s/); // 3 s at the most
    const before = await picture(page);
    await page.waitForFunction(last => document.getElementById('stage').toDataURL() !== last, before);

    await page.click('#play');
    assert.equal(await page.textContent('#play'), 'Live');
    await page.waitForTimeout(600);
    const frozen = await clock(page);
    await page.waitForTimeout(600);
    assert.equal(await clock(page), frozen);
    // torques that are shown are those of eval at the same instant of the walk, which is mirrored every second step
    const answers = read(file('rk-answers.csv'));
    const found = (await values(page, 'left knee, N m'))['run 0'];
    assert.ok(answers.tau_left_knee.some(torque => Math.abs(torque - found) < 1e-5 * Math.max(1, Math.abs(torque))), `no answer of the walk has ${found} N m`);
    await page.screenshot({path: join(PICTURES, 'view.png'), fullPage: true});
    await page.evaluate(axe);
    assert.deepEqual((await page.evaluate(() => axe.run())).violations.map(({id}) => id), []);

    // a page of another site, under whatever name, is not answered; a second view says that the port is taken
    const {port} = new URL(url);
    const status = await new Promise((resolve, reject) => get({host: '127.0.0.1', port, path: '/document', headers: {host: 'elsewhere.example'}}, answer => resolve(answer.statusCode)).on('error', reject));
    assert.equal(status, 403);
    const second = spawn(TORQUECTL, ['view', '--port', port], {stdio: ['ignore', 'ignore', 'pipe']});
    let said = '';
    second.stderr.on('data', text => { said += text; });
    assert.equal((await once(second, 'exit'))[0], 1);
    assert.match(said, /--port: \d+ of 127\.0\.0\.1 cannot be had/);

    await page.click('#play');
    page.removeAllListeners('console'); // what the browser says of the lost connection is no complaint of ours
    assert.equal(await stop(view), 0);
    await page.waitForFunction(() => /^torquectl view has not answered for \d+(\.\d)? s; this page goes on/.test(document.getElementById('warning').textContent));
    await page.close();
  } finally {
    for (const child of started) await stop(child);
  }
});

test('view shows accelerations as soon as one is adjusted', async () => {
  const started = [];
  const start = (program, words) => {
    const child = spawn(program, words, {stdio: ['ignore', 'pipe', 'ignore']});
    started.push(child);
    return child;
  };
  try {
    start(TORQUED, ['--robot', 'rk', '--config', file('nearest.toml')]);
    const view = start(TORQUECTL, ['view', '--port', '0', '--seconds', '3']);
    const url = String((await once(view.stdout, 'data'))[0]).match(/http:[^ ]+/)[0];
    const usual = start(TORQUECTL, ['send', '--loop', file('rk.csv')]);
    const page = await open('view', {url});
    const heading = page.getByRole('heading', {name: 'Accelerations, answered and asked for'});
    assert.equal(await heading.count(), 0);
    usual.kill('SIGINT');
    await once(usual, 'exit');
    start(TORQUECTL, ['send', file('wild.csv')]);
    await heading.waitFor();
    await page.waitForFunction(() => Number(document.querySelector('#clock').textContent.split(' ')[0]) > 2.4);
    await page.click('#play');
    const found = await values(page, 'right foot (q5), rad/s²');
    const answers = read(file('wild-answers.csv'));
    const sample = answers.ddq5.findIndex(asked => Math.abs(asked - found.asked) < 1e-5 * Math.max(1, Math.abs(asked)));
    assert.ok(sample > 0 && Math.abs(answers.a_q5[sample] - found['run 0']) < 1e-4, `asked ${found.asked}, answered ${found['run 0']}`);
    assert.ok(Number(await page.textContent('#figures tr:has(th:text-is("adjusted")) td')) > 50);
    await page.screenshot({path: join(PICTURES, 'view-adjusted.png'), fullPage: true});
    page.removeAllListeners('console'); // what the browser says of the lost connection is no complaint of ours
    await page.close();
  } finally {
    for (const child of started) {
      if (child.exitCode !== null || child.signalCode !== null) continue;
      child.kill('SIGKILL');
      await once(child, 'exit');
    }
  }
});

test('view says when torqued is silent, when the last answer is old, and when view itself does not answer', async () => {
  const started = [];
  const start = (program, words) => {
    const child = spawn(program, words, {stdio: ['ignore', 'pipe', 'ignore']});
    started.push(child);
    return child;
  };
  try {
    const torqued = start(TORQUED, ['--robot', 'rk']);
    const view = start(TORQUECTL, ['view', '--port', '0', '--seconds', '3']);
    const url = String((await once(view.stdout, 'data'))[0]).match(/http:[^ ]+/)[0];
    const send = start(TORQUECTL, ['send', '--loop', file('rk.csv')]);
    const page = await open('view', {url});
    const says = wanted => page.waitForFunction(pattern => {
      const warning = document.getElementById('warning');
      return pattern === null ? warning.hidden : !warning.hidden && new RegExp(pattern).test(warning.textContent);
    }, wanted);
    await says(null);
    torqued.kill('SIGSTOP');
    await says('^torqued has been silent for [1-9]\\d*\\.\\d s: stopped, killed, or cut off from this bus · last answer [1-9]\\d*\\.\\d s ago$');
    await page.screenshot({path: join(PICTURES, 'view-silent.png')});
    await page.evaluate(axe);
    assert.deepEqual((await page.evaluate(() => axe.run())).violations.map(({id}) => id), []);
    torqued.kill('SIGCONT');
    await says(null);
    send.kill('SIGINT');
    await says('^last answer [1-9]\\d*\\.\\d s ago$');
    await page.click('#play'); // what is frozen says so, too
    torqued.kill('SIGTERM');
    await says('^torqued ended \\d+\\.\\d s ago · last answer');
    view.kill('SIGSTOP'); // then it accepts connections, and says nothing
    await says('^torquectl view has not answered for [1-9]\\d*\\.\\d s; this page goes on when it is back$');
    view.kill('SIGCONT');
    await says('^torqued ended');
    await page.close();
  } finally {
    for (const child of started) {
      if (child.exitCode !== null || child.signalCode !== null) continue;
      child.kill('SIGKILL');
      await once(child, 'exit');
    }
  }
});

test('light and dark can be changed', async () => {
  const page = await open('walk.html', {theme: 'dark'});
  const dark = await picture(page);
  await page.click('#theme');
  assert.equal(await page.getAttribute('html', 'data-theme'), 'light');
  assert.notEqual(await picture(page), dark);
  await page.close();
});

test('nothing was complained about, and nothing asked for from elsewhere', () => assert.deepEqual(complaints, []));
